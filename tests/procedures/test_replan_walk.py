"""Replanning a walk: what is walked stays to the bit, later steps are made again to the same places in the world."""

import dataclasses
import math

import numpy as np
import pytest
from independent import clearance, path_of

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
PLAN = [
    ggo.Step((0.39, 0.0), (ggo.Obstacle(0.20, 0.25, 0.08),)),
    ggo.Step((0.40, 0.0), (ggo.Obstacle(0.20, 0.25, 0.05),), gaps=(ggo.Gap(0.1, 0.2),)),
    ggo.Step((0.39, 0.0)),
    ggo.Step(end_frame=ggo.STANDING),
]
WALK = ggo.walk(BASE, PLAN)


def landings(walk):
    """Where the feet land in the world in [m], by independent kinematics, shape (n, 2)."""
    return np.cumsum([path_of(gait.frames)[-1] for gait in walk.gaits], axis=0)


def steps_without_a_jump(walk):
    """Whether no joint's speed changes at any change of legs by more than within the walk's own steps."""
    legs = walk.joint_trajectory()
    played = np.stack([legs.left_hip, legs.left_knee, legs.right_hip, legs.right_knee], -1)
    bends = np.abs(np.diff(played, 2, axis=0)).max(axis=1)
    swaps = np.cumsum([len(gait) - 1 for gait in walk.gaits[:-1]]) - 1
    return bends[swaps].max() <= np.delete(bends, swaps).max()


def same_up_to(again, walk, step, frame):
    """Whether the frames up to one of a step are the same to the bit, and those after it are not."""
    for mine, theirs in zip(again.gaits[: step - 1], walk.gaits, strict=False):
        np.testing.assert_array_equal(mine.frames, theirs.frames)
    mine, theirs = (each.gaits[step - 1].frames for each in (again, walk))
    np.testing.assert_array_equal(mine[: frame + 1], theirs[: frame + 1])
    return not (mine[frame + 1 :] == theirs[frame + 1 :]).all()


@pytest.mark.parametrize(("step", "frame"), [(1, 0), (1, 20), (2, 0), (2, 15), (3, 10)])
def test_a_moved_foothold_leaves_the_later_ones_where_they_were(step, frame):
    moved = PLAN[step - 1].foothold[0] + 0.04
    again = ggo.replan(WALK, step=step, at_frame=frame, foothold=(moved, 0.0))
    assert same_up_to(again, WALK, step, frame)
    assert all(report.ok for report in again.verify())
    wanted = landings(WALK)
    wanted[step - 1, 0] += 0.04
    np.testing.assert_allclose(landings(again)[:3], wanted[:3], atol=2e-3)
    np.testing.assert_array_equal(again.gaits[-1].frames[-1], ggo.STANDING)
    assert steps_without_a_jump(again)
    # The box of the second step stands where it stood, whatever the first step does now.
    box = again.plan[1].obstacles[0]
    origin = landings(again)[0]
    assert box.x_start + origin[0] == pytest.approx(0.59, abs=1e-9)
    assert box.height + origin[1] == pytest.approx(0.05, abs=1e-9)
    assert clearance(again.gaits[1].frames, box.x_start, box.x_end, box.height) > 0.0
    assert again.plan[1].gaps[0].x_start + origin[0] == pytest.approx(0.49, abs=1e-9)


def test_a_box_seen_late_is_cleared_and_the_rest_stays():
    box = ggo.Obstacle(0.22, 0.27, 0.09)
    again = ggo.replan(WALK, step=2, at_frame=15, obstacles=[box])
    assert clearance(WALK.gaits[1].frames, 0.22, 0.27, 0.09) < 0.0 < clearance(again.gaits[1].frames, 0.22, 0.27, 0.09)
    assert again.plan[1].obstacles == (box,)
    assert again.plan[1].gaps == WALK.plan[1].gaps  # what is left out stays as it was asked for
    assert again.plan[1].foothold == WALK.plan[1].foothold
    assert ggo.replan(WALK, step=2, at_frame=15, gaps=[]).plan[1].gaps == ()


def in_the_world(walk):
    """Edges and heights of the ground of each step, in the world in [m], shape (n, 2, k)."""
    grounds = [step.ground.shifted(*-origin) for origin, step in zip(walk.origins(), walk.plan, strict=True)]
    return [(ground.edges, ground.heights[1:]) for ground in grounds]


def test_the_ground_of_stairs_stays_where_it_was():
    stairs = ggo.climb_stairs(BASE, 0.12, steps=4)
    again = ggo.replan(stairs, step=2, at_frame=10, foothold=(0.37, 0.12))
    np.testing.assert_allclose(again.plan[2].ground.edges, np.array(stairs.plan[2].ground.edges) + 0.02, atol=1e-3)
    np.testing.assert_allclose(in_the_world(again), in_the_world(stairs), atol=1e-3)
    assert path_of(again.gaits[1].frames)[-1, 0] == pytest.approx(0.37, abs=1e-3)
    np.testing.assert_allclose(landings(again)[2:], landings(stairs)[2:], atol=2e-3)


def test_the_ground_of_stairs_stays_to_the_digit_however_often():
    stairs = ggo.descend_stairs(BASE, 0.15, tread=0.30, first_edge=0.20, steps=8)
    again = stairs
    for step in (1, 2, 3):
        again = ggo.replan(again, step=step, at_frame=20)
    np.testing.assert_allclose(in_the_world(stairs), np.broadcast_to(in_the_world(stairs)[0], (8, 2, 8)), atol=1e-9)
    np.testing.assert_allclose(in_the_world(again), in_the_world(stairs), atol=1e-9)


@pytest.mark.parametrize(
    ("time", "step", "frame"),
    [(0.0, 1, 0), (0.2, 1, 20), (0.209, 1, 20), (0.29, 1, 29), (0.47, 1, 47), (0.48, 2, 0), (0.5, 2, 0), (0.65, 2, 15)],
)
def test_a_time_says_step_and_frame(time, step, frame):
    timed = ggo.replan(WALK, time=time, obstacles=[])
    named = ggo.replan(WALK, step=step, at_frame=frame, obstacles=[])
    for mine, theirs in zip(timed.gaits, named.gaits, strict=True):
        np.testing.assert_array_equal(mine.frames, theirs.frames)
    assert timed.plan == named.plan
    assert timed.plan[step - 1].obstacles == ()


def test_a_walk_keeps_its_steps_and_can_be_replanned_again():
    again = ggo.replan(WALK, step=2, at_frame=15, foothold=(0.43, 0.0))
    assert len(again.steps) == 4
    assert again.steps[0] is WALK.steps[0]
    for number, (gait, step, asked) in enumerate(zip(again.gaits, again.steps, again.plan, strict=True), start=1):
        np.testing.assert_array_equal(step.gait.frames, gait.frames)
        assert (step.task.number, step.task.step) == (number, asked)
    assert again.steps[1].keyframes[0] == 15
    twice = ggo.replan(again, step=3, at_frame=5, foothold=(0.34, 0.0))
    assert same_up_to(twice, again, 3, 5)
    np.testing.assert_allclose(landings(twice)[1:3, 0], [0.82, 1.16], atol=2e-3)


# -- limits ---------------------------------------------------------------------------------------------------------

WIDE = ggo.JointLimits(hip_speed=math.radians(500.0), hip_acceleration=math.radians(5000.0))


def test_limits_of_the_walk_are_kept():
    walk = ggo.walk(BASE, PLAN, limits=WIDE)
    again = ggo.replan(walk, step=2, at_frame=10, foothold=(0.42, 0.0))
    assert again.limits == WIDE
    assert [step.task.settings.limits for step in again.steps] == [WIDE] * 4
    other = dataclasses.replace(WIDE, knee_acceleration=math.radians(9000.0))
    given = ggo.replan(walk, step=2, at_frame=10, foothold=(0.42, 0.0), limits=other)
    assert given.limits == other
    assert [step.task.settings.limits for step in given.steps] == [WIDE, other, other, other]
    assert all(report.ok for report in given.verify())


def test_later_steps_keep_the_default_limits_where_the_walk_had_none():
    # Its first step is beyond them, and walked: the walk as a whole has none.
    boxed = ggo.walk(BASE, [ggo.Step((0.39, 0.0), (ggo.Obstacle(0.20, 0.25, 0.15),)), *[ggo.Step((0.39, 0.0))] * 3])
    assert not boxed.verify(limits=ggo.JointLimits())[0].ok
    again = ggo.replan(boxed, step=3, at_frame=5, foothold=(0.44, 0.0))
    assert all(report.ok for report in again.verify())
    assert all(report.ok for report in again.verify(limits=ggo.JointLimits())[2:])
    assert [step.task.settings.limits for step in again.steps] == [None, None, ggo.JointLimits(), ggo.JointLimits()]


# -- from a file ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """The walk, and what is read from its file."""
    path = tmp_path_factory.mktemp("walks") / "walk.csv"
    WALK.save(path)
    return ggo.load_walk(path)


@pytest.mark.parametrize("base", [BASE, ggo.paper_base_gait(101), ggo.Gait(BASE.frames, 0.02, model=BASE.model)])
def test_a_walk_from_a_file_with_its_base_gait(read, base):
    again = ggo.replan(read, step=2, at_frame=15, base=base, foothold=(0.43, 0.0))
    assert same_up_to(again, read, 2, 15)
    assert again.steps == ()
    known = ggo.replan(WALK, step=2, at_frame=15, foothold=(0.43, 0.0))
    for mine, theirs in zip(again.gaits, known.gaits, strict=True):
        assert mine.dt == theirs.dt
        np.testing.assert_allclose(mine.frames, theirs.frames, atol=1e-9 if len(base) == 51 else 1e-2)
    assert all(report.ok for report in again.verify())


def test_limits_and_notes_of_a_file_are_kept(tmp_path):
    tight = ggo.JointLimits(hip_acceleration=math.radians(1800.0))
    ggo.walk(BASE, PLAN, limits=tight).save(tmp_path / "walk.csv")
    text = (tmp_path / "walk.csv").read_text().splitlines(keepends=True)
    (tmp_path / "bare.csv").write_text("".join(line for line in text if not line.startswith("# checksum")))
    walk = ggo.load_walk(tmp_path / "bare.csv")
    assert walk.notes
    again = ggo.replan(walk, step=2, at_frame=10, base=BASE, foothold=(0.44, 0.0))
    assert (again.limits, again.notes) == (walk.limits, walk.notes)
    assert all(report.ok for report in again.verify())
    loose = ggo.replan(walk, step=2, at_frame=10, base=BASE, foothold=(0.44, 0.0), limits=ggo.JointLimits())
    assert not all(report.ok for report in loose.verify(limits=tight))  # within them it takes some doing


def test_a_walk_from_a_file_without_its_base_gait_is_refused(read):
    with pytest.raises(ggo.InputError, match="base: a walk from a file does not carry the base gait"):
        ggo.replan(read, step=2, at_frame=15)
    with pytest.raises(ggo.InputError, match="base: expected a Gait"):
        ggo.replan(read, step=2, at_frame=15, base="paper")


def test_a_step_made_again_from_its_first_frame_goes_on_as_the_one_before_ended(tmp_path):
    # Without smoothness its speed jumped there; what is read from a file is made again with it.
    ggo.walk(BASE, PLAN, smoothness=0).save(tmp_path / "walk.csv")
    kinked = ggo.load_walk(tmp_path / "walk.csv")
    before, first = kinked.gaits[0].frames - BASE.frames, kinked.gaits[1].frames - BASE.frames
    onward = np.roll(before[-1] - before[-2], 2)
    assert np.abs(first[1] - first[0] - onward).max() > 0.5 * BASE.dt
    loose = ggo.JointLimits(hip_acceleration=1e3, knee_acceleration=1e3, hip_speed=20.0, knee_speed=20.0)
    again = ggo.replan(kinked, step=2, at_frame=0, base=BASE, limits=loose).gaits[1].frames - BASE.frames
    np.testing.assert_allclose(again[1] - again[0], onward, atol=1e-9)


# -- refusals -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({}, ggo.InputError, "of a walk say the step and at_frame, or the time"),
        ({"step": 1}, ggo.InputError, "of a walk say the step and at_frame, or the time"),
        ({"at_frame": 1}, ggo.InputError, "of a walk say the step and at_frame, or the time"),
        ({"step": 0, "at_frame": 1}, ggo.InputError, "step: 0 must be at least 1"),
        ({"step": 5, "at_frame": 1}, ggo.InputError, "step: 5 must be at most 4"),
        ({"step": True, "at_frame": 1}, ggo.InputError, "step: expected a whole number"),
        ({"step": 1, "at_frame": -1}, ggo.InputError, "at_frame: -1 must be at least 0"),
        ({"step": 1, "at_frame": 51}, ggo.InputError, "at_frame: 51 must be at most 50"),
        ({"step": 1, "at_frame": 48}, ggo.InfeasibleGaitError, "replan at frame 48: too late"),
        ({"time": 0.1, "step": 1}, ggo.InputError, "time: give it, or step and at_frame"),
        ({"time": 0.1, "at_frame": 1}, ggo.InputError, "time: give it, or step and at_frame"),
        ({"time": -0.1}, ggo.InputError, "time: -0.1 s must be at least 0"),
        ({"time": math.nan}, ggo.InputError, "time: nan"),
        ({"time": 1.98}, ggo.InfeasibleGaitError, "replan at 1.98 s: too late, the walk is over or nearly so"),
        ({"time": 9.0}, ggo.InfeasibleGaitError, "replan at 9 s: too late, the walk is over or nearly so"),
        ({"time": 0.1, "foothold": (5.0, 0.0)}, ggo.UnreachableFootholdError, "foothold"),
        ({"time": 0.1, "obstacles": ["box"]}, ggo.InputError, "obstacles"),
        ({"time": 0.1, "gaps": ["pit"]}, ggo.InputError, "gaps"),
        ({"time": 0.1, "ground": 3}, ggo.InputError, "ground: expected a Ground"),
        ({"time": 0.1, "limits": 3}, ggo.InputError, "limits: expected a JointLimits"),
        (
            {"step": 2, "at_frame": 40, "obstacles": [ggo.Obstacle(0.2, 0.25, 0.12)]},
            ggo.InfeasibleGaitError,
            "replan at frame 40: too late, already walked: obstacle",
        ),
    ],
)
def test_what_cannot_be_is_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        ggo.replan(WALK, **arguments)


def test_a_later_step_that_can_no_longer_be_made_is_named():
    with pytest.raises(ggo.InfeasibleGaitError, match=r"^step 2: ") as caught:
        ggo.replan(WALK, step=1, at_frame=0, foothold=(0.58, 0.0))  # in the box of the second step
    assert caught.value.step == 2


@pytest.mark.parametrize("arguments", [{"step": 1}, {"time": 0.1}, {"base": BASE}])
def test_a_step_knows_its_own(arguments):
    with pytest.raises(ggo.InputError, match="step, time and base: are for a walk"):
        ggo.replan(WALK.steps[0], 10, **arguments)
    with pytest.raises(ggo.InputError, match="at_frame: say which frame is the last one walked"):
        ggo.replan(WALK.steps[0])
