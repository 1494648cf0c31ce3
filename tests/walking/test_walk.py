"""A walk on end: continuity, both legs over time, and its file."""

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.walking.step import across

BASE = ggo.paper_base_gait()
WALK = ggo.walk(
    BASE,
    [
        ggo.Step((0.42, 0.0), obstacles=[ggo.Obstacle(0.2, 0.25, 0.08)], gaps=[ggo.Gap(0.5, 0.6)]),
        ggo.Step((0.39, 0.0)),
        ggo.Step((0.35, 0.0), shank_angle=1.8),
    ],
)


@pytest.mark.parametrize("first", ["right", "left"])
def test_both_legs_over_time(first):
    joints = WALK.joint_trajectory(first_swing=first)
    count = 3 * 50 + 1  # each swap frame once
    assert joints.time.shape == joints.left_hip.shape == (count,)
    np.testing.assert_allclose(joints.time, np.arange(count) * 0.01)
    other = "left" if first == "right" else "right"
    swing, support = (getattr(joints, f"{side}_knee") for side in (first, other))
    np.testing.assert_array_equal(swing[:51], WALK.gaits[0].frames[:, 3])
    np.testing.assert_array_equal(support[:51], WALK.gaits[0].frames[:, 1])
    np.testing.assert_array_equal(support[51:101], WALK.gaits[1].frames[1:, 3])
    with pytest.raises(ValueError, match="read-only"):
        joints.time[0] = 1.0


def test_continuous_at_the_role_swap():
    for before, after in zip(WALK.gaits[:-1], WALK.gaits[1:], strict=True):
        assert np.abs(after.frames[0] - before.swapped().frames[-1]).max() < 1e-9


def test_steps_that_do_not_join_are_refused():
    with pytest.raises(ggo.InputError, match=r"step 2: starts .* rad away from the end of step 1"):
        ggo.joint_trajectory([BASE, BASE.swapped()])
    with pytest.raises(ggo.InputError, match=r"step 2: dt is 0\.02 s"):
        ggo.joint_trajectory([BASE, ggo.Gait(BASE.frames, 0.02)])
    with pytest.raises(ggo.InputError, match="'both' is neither"):
        WALK.joint_trajectory("both")


def test_file_round_trip_and_check(tmp_path):
    WALK.save(tmp_path / "walk.csv")
    read = ggo.load_walk(tmp_path / "walk.csv")
    assert read.steps == ()
    assert read.plan[0].obstacles == WALK.plan[0].obstacles
    assert read.plan[0].gaps == WALK.plan[0].gaps
    assert read.plan[2].shank_angle == pytest.approx(1.8)
    for mine, theirs in zip(WALK.gaits, read.gaits, strict=True):
        np.testing.assert_allclose(theirs.frames, mine.frames, atol=1e-13)
    assert all(report.ok for report in read.verify())
    read.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == (tmp_path / "walk.csv").read_text()


def test_stairs_and_standing_round_trip(tmp_path):
    walk = ggo.descend_stairs(BASE, (0.10, 0.14))
    walk.save(tmp_path / "stairs.csv")
    read = ggo.load_walk(tmp_path / "stairs.csv")
    assert [step.ground for step in read.plan] == [step.ground for step in walk.plan]
    assert all(report.ok for report in read.verify())
    closed = ggo.walk(BASE, [ggo.Step(end_frame=ggo.STANDING)])
    closed.save(tmp_path / "stand.csv")
    assert ggo.load_walk(tmp_path / "stand.csv").plan[0].end_frame == (0.0, 0.0, 0.0, 0.0)


def test_an_edited_file_is_found_unsafe(tmp_path):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    lines = path.read_text().splitlines()
    cells = lines[60].split(",")
    cells[4] = str(float(cells[4]) - 80.0)
    lines[60] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(ggo.InputError, match=r"walk\.csv: its rows, dt or limits were changed"):
        ggo.load_walk(path)
    reports = ggo.load_walk(path, edited=True).verify()
    assert {violation.kind for violation in reports[0].violations} >= {"knee"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda text: text.replace("# step 2: ", "# stop 2: "), "no line '# step 2: ...'"),
        (lambda text: text.replace('"gaps_m"', '"pits_m"'), "header 'step 1' lacks 'gaps_m'"),
        (lambda text: text.replace("[0.2, 0.25, 0.08]", "[0.25, 0.2, 0.08]"), "header 'step 1': x_end"),
        (lambda text: text.replace('{"foothold_m"', '"foothold_m"'), "header 'step 1' does not describe"),
        (lambda text: text.replace("\n3,", "\n4,"), "line .*: step 4 does not follow"),
        (
            lambda text: "\n".join(line for line in text.splitlines() if line[:2] != "3,"),
            "102 frames, its header says 153",
        ),
        (lambda text: text.replace("# ggo-walk 1", "# ggo-walk 9"), "line 1"),
    ],
)
def test_damaged_walk_file(tmp_path, change, message):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    path.write_text(change(path.read_text()))
    with pytest.raises(ggo.InputError, match=message):
        ggo.load_walk(path)


def test_the_header_is_plain_json(tmp_path):
    WALK.save(tmp_path / "walk.csv")
    line = next(line for line in (tmp_path / "walk.csv").read_text().splitlines() if line.startswith("# step 1: "))
    assert json.loads(line.removeprefix("# step 1: "))["foothold_m"] == [0.42, 0.0]


@given(x=st.floats(-0.3, 1.2))
def test_obstacles_along_the_way_are_seen_from_every_step(x):
    plan = [ggo.Step((0.4, 0.0)), ggo.Step((0.4, 0.0)), ggo.Step((0.4, 0.0))]
    placed = across(plan, ggo.LegModel(0.39, 0.39), [ggo.Obstacle(x, x + 0.01, 0.1)], [ggo.Gap(x, x + 0.1)])
    for number, step in enumerate(placed):
        assert step.obstacles[0].x_start == step.gaps[0].x_start == pytest.approx(x - 0.4 * number)


def test_an_obstacle_just_beyond_the_foothold_is_not_forgotten():
    # Without smoothness the foot swings beyond its foothold and back: it must clear what stands there.
    plan = [ggo.Step((0.30, 0.0)), ggo.Step(end_frame=ggo.STANDING)]
    swung = ggo.walk(BASE, plan, smoothness=0.0).gaits[1]
    beyond = float(swung.endpoints()[:, 0].max())
    assert beyond > 0.01
    boxed = across(plan, BASE.legs(), [ggo.Obstacle(0.30 + beyond / 2.0, 0.31 + beyond, 0.3)], [])
    assert "obstacle" in [fault.kind for fault in ggo.verify_step(swung, boxed[1]).violations]


def test_landing_errors_do_not_add_up():
    walk = ggo.descend_stairs(BASE, riser=0.15, tread=0.30, first_edge=0.2, steps=20)
    np.testing.assert_allclose(walk.origins()[-1], [0.30 * 19, -0.15 * 19], atol=6e-4)


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"ground": ggo.Ground(heights=(-5.0,))}, "off the ground"),
        ({"end_frame": (0.0, 0.0, 0.0, 0.0)}, "end frame"),
        ({"gaps": (ggo.Gap(0.4, 0.5),)}, "foothold in a gap"),
    ],
)
def test_a_plan_that_does_not_fit_its_gait_is_seen(change, kind):
    plan = (dataclasses.replace(WALK.plan[0], **change), *WALK.plan[1:])
    found = [str(violation) for violation in ggo.Walk(WALK.gaits, plan).verify()[0].violations]
    assert any(kind in violation for violation in found), found


def test_gaits_that_do_not_belong_together_are_refused():
    other = ggo.Gait(BASE.frames, 0.02, model=BASE.model)
    with pytest.raises(ggo.InputError, match="step 2 has another time step"):
        ggo.Walk((BASE, other), (ggo.Step((0.39, 0.0)), ggo.Step((0.39, 0.0))))


@pytest.mark.parametrize("keep", [-1, -30])
def test_a_cut_file_is_refused(tmp_path, keep):
    WALK.save(tmp_path / "walk.csv")
    (tmp_path / "cut.csv").write_text((tmp_path / "walk.csv").read_text()[:keep])
    with pytest.raises(ggo.InputError, match=r"cut\.csv"):
        ggo.load_walk(tmp_path / "cut.csv")
