"""A gait that comes home: after a box, on stairs, at rest, and handed over from one call to the next."""

import math
from pathlib import Path

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.procedures.gains import Gains, stiffer

BASE = ggo.paper_base_gait()
SAMPLE_LOG = Path(__file__).parents[2] / "datasets" / "children_walk.mcap"


@pytest.fixture(scope="module")
def bases():
    """The paper's base gait and the sample log's."""
    sample = ggo.import_base_gait(SAMPLE_LOG, joints=SAMPLE_LOG.with_suffix(".toml")).gait
    return {"paper": BASE, "sample log": sample}


def mean_off_deg(first, second):
    """Each joint's mean difference between two steps in degrees."""
    return np.degrees(np.abs(first.frames - second.frames).mean(axis=0))


def angles(walk):
    """Both legs over time as an exoskeleton plays them, in [rad], shape (m, 4)."""
    joints = walk.joint_trajectory()
    return np.stack([joints.left_hip, joints.left_knee, joints.right_hip, joints.right_knee], -1)


# -- home -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [0.08, 0.15])
@pytest.mark.parametrize("name", ["paper", "sample log"])
def test_home_from_the_third_step_after_a_box(bases, name, height):
    level = [ggo.Step((float(bases[name].endpoints()[-1, 0]), 0.0))] * 8
    boxed = [ggo.Step(level[0].foothold, (ggo.Obstacle(0.20, 0.25, height),)), *level[1:]]
    walks = [ggo.walk(bases[name], plan).gaits for plan in (level, boxed)]
    off = np.array([mean_off_deg(*pair) for pair in zip(*walks, strict=True)])
    assert off[0].max() > 3.0  # a bend there was
    assert off[2:].max() < 1.0


def test_without_landing_edges_it_stays_bent():
    level = [ggo.Step((0.39, 0.0))] * 4
    boxed = [ggo.Step((0.39, 0.0), (ggo.Obstacle(0.20, 0.25, 0.15),)), *level[1:]]
    walks = [ggo.walk(BASE, plan, landing=False).gaits for plan in (level, boxed)]
    assert min(mean_off_deg(*pair).max() for pair in zip(*walks, strict=True)) > 5.0


def test_home_at_any_sampling_rate():
    ends = []
    for frames in (26, 51, 101, 201):
        base = ggo.paper_base_gait(frames)
        walk = ggo.walk(base, [ggo.Step((0.39, 0.0), (ggo.Obstacle(0.20, 0.25, 0.15),)), ggo.Step((0.39, 0.0))])
        ends.append([gait.frames[-1] for gait in walk.gaits])
    assert np.degrees(np.ptp(ends, axis=0)).max(axis=-1) == pytest.approx([1.0, 0.0], abs=0.5)


@pytest.mark.parametrize("riser", [0.10, 0.15, 0.18])
@pytest.mark.parametrize("flight", [ggo.climb_stairs, ggo.descend_stairs])
def test_every_stair_is_climbed_like_the_one_before(flight, riser):
    walk = flight(BASE, riser, tread=0.29, first_edge=0.20, steps=5)
    assert all(report.ok for report in walk.verify())
    for before, after in zip(walk.gaits[2:], walk.gaits[3:], strict=False):
        assert np.degrees(np.abs(after.frames - before.frames)).max() < 2.0
    if flight is ggo.climb_stairs:
        landing = [math.degrees(gait.frames[-1, 1]) for gait in walk.gaits]
        assert max(landing) <= 15.0
    else:
        bend = [math.degrees(gait.frames[:, 3].max()) for gait in walk.gaits]
        assert max(bend) < {0.10: 113.0, 0.15: 128.0, 0.18: 136.0}[riser]


# -- rest -----------------------------------------------------------------------------------------------------------


def standing_plans(seed, count=12):
    """Walks to standing over a box, up and down a kerb of two risers."""
    rng = np.random.default_rng(seed)
    stand = ggo.STANDING
    for number in range(count):
        x, box, height = rng.uniform(0.30, 0.42), rng.uniform(0.12, 0.25), rng.uniform(0.03, 0.10)
        rise = rng.uniform(0.05, 0.12) * (-1.0) ** number
        if number % 3 < 2:
            over = ggo.Step((x, 0.0), (ggo.Obstacle(box, box + 0.04, height),))
            yield [ggo.Step((x / 2.0 + 0.05, 0.0)), over, ggo.Step((x, 0.0)), ggo.Step(end_frame=stand)]
        else:
            ground = ggo.Ground((0.15, 0.44), (0.0, rise, 2.0 * rise))
            yield [
                ggo.Step((0.29, rise), ground=ground),
                ggo.Step((0.29, rise), ground=ground.shifted(0.29, rise)),
                ggo.Step(end_frame=stand, ground=ground.shifted(0.58, 2.0 * rise)),
            ]


TIGHT = ggo.JointLimits(hip_acceleration=math.radians(2500.0), knee_acceleration=math.radians(6500.0))


@pytest.mark.parametrize(
    ("frames", "limits", "hard"),
    [(51, None, False), (51, ggo.JointLimits(), False), (51, TIGHT, False), (51, TIGHT, True), (151, TIGHT, False)],
)
def test_a_walk_from_and_to_standing_starts_and_ends_at_rest(frames, limits, hard):
    base, made = ggo.paper_base_gait(frames), 0
    for plan in standing_plans(seed=7):
        try:
            walk = ggo.walk(base, plan, start=ggo.STANDING, limits=limits, hard=hard)
        except ggo.InfeasibleGaitError:
            continue
        made += 1
        assert all(report.ok for report in walk.verify())
        played, times = angles(walk), walk.times
        first = np.abs(played[1] - played[0]).max() / (times[1] - times[0])
        last = np.abs(played[-1] - played[-2]).max() / (times[-1] - times[-2])
        assert last <= 1e-9 if frames == 51 else last <= 0.1
        assert first <= 1e-9 if frames == 51 else first <= 0.1
        if limits is not None:
            most = np.abs(walk.joint_trajectory(rate=1000).accelerations).max(axis=0)
            assert (most <= 1.0011 * np.tile([limits.hip_acceleration, limits.knee_acceleration], 2)).all()
    assert made >= 10


def test_a_step_that_stands_between_others_rests_there():
    walk = ggo.walk(BASE, [ggo.Step((0.3, 0.0)), ggo.Step(end_frame=ggo.STANDING), ggo.Step((0.3, 0.0))])
    np.testing.assert_array_equal(walk.gaits[1].frames[-1], walk.gaits[1].frames[-2])
    np.testing.assert_allclose(walk.gaits[2].frames[1], walk.gaits[2].frames[0], atol=1e-9)
    assert all(report.ok for report in walk.verify())


# -- hand-over ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper", "sample log"])
def test_a_step_from_the_frame_that_another_ended_in_moves_on(bases, name):
    base = bases[name]
    first = ggo.step_over(base, [ggo.Obstacle(0.20, 0.25, 0.08)])
    start = first.gait.swapped().frames[-1]
    second = ggo.step_over(base, [], start=start)
    onward = second.gait.frames[1] - second.gait.frames[0]
    np.testing.assert_allclose(onward, base.frames[1] - base.frames[0], atol=1e-12)
    joined = ggo.Walk((first.gait, second.gait), (first.task.step, second.task.step))
    assert all(report.ok for report in joined.verify())
    jump = onward - np.diff(first.gait.swapped().frames[-2:], axis=0)[0]
    assert np.abs(jump).max() < 2.0 * base.dt
    by_walk = ggo.walk(base, [second.task.step], start=start).gaits[0]
    np.testing.assert_array_equal(by_walk.frames, second.gait.frames)


def test_one_who_stands_starts_at_rest_and_cannot_be_in_motion():
    for smoothness in (None, 0):
        still = ggo.step_over(BASE, [], foothold=(0.3, 0.0), start=ggo.STANDING, smoothness=smoothness).gait.frames
        np.testing.assert_allclose(still[1], still[0], atol=1e-12)
    with pytest.raises(ggo.InputError, match="start_rate: a walker whose legs are alike stands"):
        ggo.step_over(BASE, [], foothold=(0.3, 0.0), start=ggo.STANDING, start_rate=[0.1, 0.2, 0.3, 0.4])


# -- landing= -------------------------------------------------------------------------------------------------------


def lands(solution):
    """Whether the solved graph of a step has landing edges."""
    return "landing motion" in [edge.name for _, edge in solution.graph.edges]


@pytest.mark.parametrize(
    ("landing", "smoothness", "expected"),
    [(None, None, True), (True, None, True), (False, None, False), (None, 0, False), (True, 0, True)],
)
def test_when_a_step_has_landing_edges(landing, smoothness, expected):
    solution = ggo.step_over(BASE, [], foothold=(0.45, 0.0), landing=landing, smoothness=smoothness)
    assert lands(solution) is expected
    for walk in (
        ggo.walk(BASE, [ggo.Step((0.45, 0.0))], landing=landing, smoothness=smoothness),
        ggo.adjust_stride(BASE, 0.9, steps=1, landing=landing, smoothness=smoothness),
    ):
        np.testing.assert_array_equal(walk.gaits[0].frames, solution.gait.frames)
    stairs = ggo.climb_stairs(BASE, landing=landing, smoothness=smoothness).steps[1]
    assert lands(stairs) is expected


def test_an_end_frame_has_no_landing_edges():
    walk = ggo.walk(BASE, [ggo.Step((0.39, 0.0)), ggo.Step(end_frame=ggo.STANDING)], landing=True)
    assert [lands(step) for step in walk.steps] == [True, False]


def test_landing_is_yes_or_no_or_left_out():
    with pytest.raises(ggo.InputError, match="landing"):
        ggo.step_over(BASE, [], landing="yes")


def test_a_step_found_only_without_landing_edges_says_so():
    box, asked = ggo.Obstacle(0.20, 0.25, 0.15), {"hard": True, "limits": ggo.JointLimits(), "pace": 1, "deadline": 20}
    solution = ggo.step_over(BASE, [box], foothold=(0.39, 0.0), **asked)
    assert solution.ok
    (note,) = solution.report.notes
    assert note.startswith("found only without landing edges")
    assert note.endswith("the step after it brings the walker home")
    assert not lands(solution)
    assert solution.task.settings.landing  # a replan lands again
    assert ggo.step_over(BASE, [], foothold=(0.39, 0.0), **asked).report.notes == ()


def test_landing_edges_give_way_to_joint_limits_before_they_are_left_out():
    gains = Gains(20.0)
    assert stiffer(gains, {"hip speed"}, False, 0.0).landing == pytest.approx(0.1 * gains.landing)
    assert stiffer(gains, {"obstacle"}, False, 0.0).landing == gains.landing


def test_a_walk_whose_motion_its_own_check_refuses_is_not_returned(monkeypatch):
    plan = [ggo.Step((0.39, 0.0))] * 2
    assert ggo.walk(BASE, plan).verify()[1].ok
    monkeypatch.setattr("ggo_factors.check.trajectory.LEAST_JUMP", 0.1)
    monkeypatch.setattr("ggo_factors.check.trajectory.JUMPS_BY", 0.1)
    with pytest.raises(ggo.InfeasibleGaitError, match=r"step 2: its motion does not follow .* speed jumps"):
        ggo.walk(BASE, plan)
    assert ggo.walk(BASE, plan, smoothness=0.0).gaits  # the paper's graph has no edge that would carry the speed
