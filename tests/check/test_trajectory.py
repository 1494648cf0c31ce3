"""The check of the joint trajectory over time: jumps, rest, limits across steps, speeds, dragging feet, soles."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bare_bones import pointed
from independent import leg_clearance, path_of
from scipy.interpolate import CubicSpline

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
LEGS = BASE.legs()
DT = BASE.dt
SAMPLE_LOG = Path(__file__).parents[2] / "datasets" / "children_walk.mcap"
STRIDE = ggo.step_over(BASE, [], foothold=(0.39, 0.0)).gait
BENT = np.radians([5.0, 20.0, -15.0, 25.0])


def found(reports, *words):
    """Violations of all steps, by step from 0, whose kind has one of the words."""
    return [
        (number, fault)
        for number, report in enumerate(reports)
        for fault in report.violations
        if any(word in fault.kind for word in words)
    ]


def steadily(start, speed, frames=21):
    """A gait whose joints turn at constant speeds: it accelerates nowhere but before and after it."""
    return ggo.Gait(np.asarray(start) + np.arange(frames)[:, None] * DT * np.asarray(speed), DT, model=LEGS)


def joined(first_speed, second_speed, start=BENT):
    """A walk of two steps, each steady; both speeds of the legs by their roles in the first step."""
    first = steadily(start, first_speed)
    second = steadily(first.swapped().frames[-1], np.roll(second_speed, 2))
    return ggo.Walk((first, second), (ggo.Step((0.1, 0.0)), ggo.Step((0.1, 0.0))))


# -- the change of legs -------------------------------------------------------------------------------------------


def test_a_step_that_was_joined_at_rest_jumps():
    first = ggo.step_over(BASE, [])
    still = ggo.step_over(BASE, [], start=first.gait.swapped().frames[-1], start_rate=np.zeros(4))
    walk = ggo.Walk((first.gait, still.gait), (first.task.step, still.task.step))
    ((number, fault),) = found(walk.verify(), "")
    assert (number, fault.kind, fault.frame) == (1, "knee speed jumps", 0.0)
    assert "swing leg, at the change of legs" in str(fault)
    # The knee that swings now: what it did as the supporting one, and what it does.
    was, now = np.diff(first.gait.frames[-2:, 1])[0], np.diff(still.gait.frames[:2, 3])[0]
    assert fault.value == pytest.approx(math.degrees(now - was) / DT)


@pytest.mark.parametrize(("change", "told"), [(1.9, False), (2.1, True), (-2.1, True)])
def test_how_large_a_jump_is_told(change, told):
    for joint, kind in enumerate(("hip", "knee", "hip", "knee")):
        other = np.zeros(4)
        other[joint] = change
        jumps = found(joined(np.zeros(4), other, BENT + 0.5).verify(), "jumps")
        assert [fault.kind for _, fault in jumps] == [f"{kind} speed jumps"] * told


def test_a_step_with_kinks_of_its_own_may_have_one_at_the_change_of_legs():
    walk = ggo.walk(
        BASE,
        [ggo.Step((0.39, 0.0), (ggo.Obstacle(0.2, 0.25, 0.15),)), ggo.Step((0.3, 0.0)), ggo.Step((0.45, 0.0))],
        smoothness=0,
    )
    legs = walk.joint_trajectory()
    joints = np.stack([legs.left_hip, legs.left_knee, legs.right_hip, legs.right_knee], -1)
    assert np.abs(np.diff(joints, 2, axis=0)[49] / DT).max() > 2.0
    assert not found(walk.verify(), "")


def sample_base(frames=51):
    """The base gait of the sample log."""
    return ggo.import_base_gait(SAMPLE_LOG, joints=SAMPLE_LOG.with_suffix(".toml")).gait.resampled(frames)


def unclosed_base(seed):
    """A base gait whose speeds at both ends differ, as those of recorded ones do."""
    rng = np.random.default_rng(seed)
    share = np.linspace(0.0, np.pi, len(BASE))[:, None]
    waves = [np.radians(rng.uniform(-1.5, 1.5, 4)) * np.sin(k * share + rng.uniform(0, 6, 4)) for k in (1, 2)]
    frames = BASE.frames + sum(waves)
    frames[:, [1, 3]] = np.maximum(frames[:, [1, 3]], np.radians(1.0))
    return ggo.Gait(frames, DT, f"seed {seed}", model=LEGS)


BASES = {
    "paper": lambda: BASE,
    "sample log": sample_base,
    "sample log, 120 frames": lambda: sample_base(120),
    "seed 0": lambda: unclosed_base(0),
    "seed 1": lambda: unclosed_base(1),
    "seed 2": lambda: unclosed_base(2),
}


@pytest.mark.parametrize("name", BASES)
@pytest.mark.parametrize("smoothness", [None, 0])
def test_walks_of_ours_do_not_jump(name, smoothness):
    base = BASES[name]()
    x = float(base.endpoints()[-1, 0])
    box = ggo.Obstacle(0.5 * x, 0.5 * x + 0.04, 0.08)
    plan = [ggo.Step((x, 0.0)), ggo.Step((x + 0.04, 0.0), (box,)), ggo.Step((x - 0.05, 0.0)), ggo.Step((x, 0.0))]
    assert not found(ggo.walk(base, plan, smoothness=smoothness).verify(), "")


def test_limits_are_held_across_the_change_of_legs():
    walk = joined([0.1, 0.0, 0.5, 0.0], [0.1, 0.0, -1.0, 0.0])
    limits = ggo.JointLimits(hip_acceleration=100.0)
    assert not found(walk.verify(), "jumps", "acceleration")
    ((number, fault),) = found(walk.verify(limits=limits), "acceleration")
    assert (number, fault.kind, fault.frame) == (1, "hip acceleration", 0.0)
    assert "support leg" in str(fault)  # the leg that swung
    assert fault.value == pytest.approx(math.degrees(-1.5 / DT))
    kept = ggo.Walk(walk.gaits, walk.plan, limits=limits)
    assert len(found(kept.verify(), "acceleration")) == 1
    assert not found(kept.verify(limits=ggo.JointLimits(hip_acceleration=151.0)), "acceleration")


# -- rest ---------------------------------------------------------------------------------------------------------


def test_a_start_that_is_not_at_rest_is_told():
    for speed, told in ((0.09, 0), (0.2, 1)):
        walk = ggo.Walk((steadily(ggo.STANDING, [0, 0, speed, 0]),), (ggo.Step((0.1, 0.0)),))
        rest = found(walk.verify(), "not at rest")
        assert len(rest) == told
    fault = rest[0][1]
    assert (fault.kind, fault.frame, fault.value) == ("hip not at rest", 0.5, pytest.approx(math.degrees(0.2)))
    moving = ggo.Walk((steadily(ggo.STANDING + BENT, [0, 0, 0.2, 0]),), (ggo.Step((0.1, 0.0)),))
    assert not found(moving.verify(), "not at rest")


def test_an_end_that_is_not_at_rest_is_told():
    for speed, told in ((-0.09, 0), (-0.2, 1)):
        gait = steadily(BENT, [0, 0, 0, speed])
        rest = found(ggo.Walk((gait,), (ggo.Step(end_frame=gait.frames[-1]),)).verify(), "not at rest")
        assert len(rest) == told
    fault = rest[0][1]
    assert (fault.kind, fault.frame, fault.value) == ("knee not at rest", 19.5, pytest.approx(math.degrees(-0.2)))
    assert not found(ggo.Walk((gait,), (ggo.Step((0.1, 0.0)),)).verify(), "not at rest")


def test_a_step_after_a_stand_starts_at_rest():
    first = steadily(BENT, np.zeros(4))
    second = steadily(first.swapped().frames[-1], [0, 0.3, 0, 0])
    plan = (ggo.Step(end_frame=first.frames[-1]), ggo.Step((0.1, 0.0)))
    ((number, fault),) = found(ggo.Walk((first, second), plan).verify(), "not at rest")
    assert (number, fault.kind, fault.frame) == (1, "knee not at rest", 0.5)


@pytest.mark.parametrize("end", [False, True])
def test_limits_are_held_where_the_walker_stands(end):
    """Steady joints accelerate only out of and into rest."""
    slack, limits = ggo.Tolerances(rest=2.0), ggo.JointLimits(hip_acceleration=100.0)
    gait = steadily(BENT if end else ggo.STANDING, [0, 0, 1.5, 0])
    step = ggo.Step(end_frame=gait.frames[-1]) if end else ggo.Step((0.1, 0.0))
    ((_, fault),) = found(ggo.Walk((gait,), (step,)).verify(slack, limits=limits), "acceleration")
    assert fault.frame == (20.0 if end else 0.0)
    assert fault.value == pytest.approx(math.degrees((-1.5 if end else 1.5) / DT))
    free = ggo.Walk((steadily(BENT, [0, 0, 1.5, 0]),), (ggo.Step((0.1, 0.0)),))
    assert not found(free.verify(slack, limits=limits), "acceleration")


# -- one step -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("joint", "kind"), [(0, "hip turns"), (1, "knee turns"), (2, "hip turns"), (3, "knee turns")])
def test_no_joint_turns_as_fast(joint, kind):
    frames = np.tile(BENT, (21, 1))
    for speed, told in ((19.9, []), (-20.1, [(kind, 9.5)])):
        frames[10:, joint] = BENT[joint] + speed * DT
        report = ggo.verify(ggo.Gait(frames, DT), LEGS)
        assert [(fault.kind, fault.frame) for fault in report.violations if "turns" in fault.kind] == told
    assert f"{math.degrees(20.1):.4g} deg/s" in str(next(f for f in report.violations if f.kind == kind))


def low_swing(heights, way=0.4):
    """The ankle from behind to before the other at so many heights in [m], evenly; the support leg stays."""
    support = np.radians([30.0, 60.0])
    x = np.linspace(-way / 2.0, way / 2.0, len(heights))
    swing = [LEGS.inverse_kinematics((float(a), float(h)), support) for a, h in zip(x, heights, strict=True)]
    return ggo.Gait([[*support, *each] for each in swing], 0.02, model=LEGS)


def test_a_foot_that_drags_over_level_ground_is_told():
    heights = np.full(41, 0.03)
    heights[[0, -1]] = 0.0
    for at, low, told in (
        (20, 0.006, False),
        (20, 0.004, True),
        (12, 0.004, True),
        (28, 0.004, True),
        (8, 0.004, False),
    ):
        dipped = heights.copy()
        dipped[at] = low
        drags = [f for f in ggo.verify(low_swing(dipped)).violations if "drags" in f.kind]
        assert [f.frame for f in drags] == pytest.approx([at] * told)
        assert [f.value for f in drags] == pytest.approx([low] * told, abs=1e-9)
    assert ggo.verify(low_swing(np.zeros(41), way=0.04)).ok  # too short a way to have a mid-swing
    level = ggo.verify(low_swing(np.zeros(41)), ground=ggo.Ground())
    assert "foot drags in mid-swing" in [f.kind for f in level.violations]


@pytest.mark.parametrize(("height", "told"), [(-0.047, True), (-0.043, False)])
def test_lower_ground_counts_from_where_the_foot_lands(height, told):
    heights = np.full(41, height)
    heights[0], heights[-1] = 0.0, -0.05
    assert ("foot drags in mid-swing" in [f.kind for f in ggo.verify(low_swing(heights)).violations]) is told


@pytest.mark.parametrize("foothold", [(-0.2, 0.0), (-0.25, 0.0), (0.1, 0.0), (0.2, 0.0)])
def test_the_library_lifts_the_foot_of_one_who_stood(foothold):
    path = path_of(ggo.step_over(BASE, [], foothold=foothold, start=ggo.STANDING).gait.frames)
    share = path[:, 0] / foothold[0]
    assert path[(share > 0.26) & (share < 0.74), 1].min() > 0.005


@pytest.mark.parametrize("dt", [0.01, 0.02])
def test_landing_speed(dt):
    gait = ggo.step_over(BASE, [ggo.Obstacle(0.2, 0.3, 0.12)]).gait
    heights = path_of(gait.frames)[:, 1]
    seen = ggo.verify(ggo.Gait(gait.frames, dt, model=LEGS)).landing_speed
    assert seen == pytest.approx((heights[-2] - heights[-1]) / dt)
    assert seen > 0.5 * 0.01 / dt


@pytest.mark.parametrize("box", [(0.30, 0.36, 0.02), (0.20, 0.25, 0.08), (0.10, 0.16, 0.10), (-0.12, -0.08, 0.12)])
def test_the_distance_of_the_axes_from_a_box(box):
    # An ankle well over its sole: of a lower one the last centimetre of the shank belongs to the foot.
    legs = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08))
    axes, _ = leg_clearance(STRIDE.frames, [box], foot=(0.08, 0.0, 0.0))
    seen = ggo.verify(STRIDE, legs, obstacles=[ggo.Obstacle(*box)]).axis_clearance
    assert axes - 1e-4 <= seen < axes + 0.003  # fewer instants see no less


def test_a_bare_bone_in_a_box_is_below_zero():
    box = ggo.Obstacle(0.02, 0.10, 0.30)  # before the supporting shin, which leans forward into it
    assert leg_clearance(STRIDE.frames, [(0.02, 0.10, 0.30)])[0] == 0.0
    assert ggo.verify(STRIDE, obstacles=[box]).axis_clearance < -0.005
    assert ggo.verify(STRIDE).axis_clearance == math.inf


def test_the_distance_of_the_axes_from_stairs():
    solution = ggo.climb_stairs(BASE, 0.12, model=ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08, 0.05, 0.10))).steps[1]
    ground = solution.task.step.ground
    axes, _ = leg_clearance(solution.gait.frames, (), ground.edges, ground.heights, foot=(0.08, 0.05, 0.10))
    assert solution.report.axis_clearance == pytest.approx(axes, abs=0.003)
    assert ggo.verify(solution.gait, ground=ground).axis_clearance == pytest.approx(axes, abs=0.003)


# -- soles --------------------------------------------------------------------------------------------------------

SHOD = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08, 0.05, 0.15))
START_X = float(path_of(STRIDE.frames)[0, 0])


@pytest.mark.parametrize(
    ("foot", "edges", "heights"),
    [
        ("foothold", (0.391,), (0.0, -0.15)),
        ("swinging foot's start", (START_X + 0.001, -0.1), (0.0, -0.15, 0.0)),
        ("supporting foot", (0.001, 0.2), (0.0, -0.15, 0.0)),
    ],
)
def test_a_sole_over_a_void_is_told(foot, edges, heights):
    report = ggo.verify(STRIDE, SHOD, foothold=(0.39, 0.0), ground=ggo.Ground(edges, heights))
    (fault,) = [f for f in report.violations if "void" in f.kind]
    assert fault.kind == f"{foot} over a void"
    assert fault.value == pytest.approx(0.149, abs=1e-9)
    assert fault.limit == pytest.approx(0.1)
    bare = ggo.verify(STRIDE, LEGS, foothold=(0.39, 0.0), ground=ggo.Ground(edges, heights))
    assert not [f for f in bare.violations if "void" in f.kind]


@pytest.mark.parametrize(("toe_over", "drop", "told"), [(0.095, 0.15, 0), (0.105, 0.15, 1), (0.149, 0.009, 0)])
def test_half_a_sole_may_hang_over(toe_over, drop, told):
    ground = ggo.Ground((0.39 + 0.15 - toe_over,), (0.0, -drop))
    report = ggo.verify(STRIDE, SHOD, foothold=(0.39, 0.0), ground=ground)
    assert len([f for f in report.violations if "void" in f.kind]) == told


@pytest.mark.parametrize(
    ("foot", "gap"),
    [
        ("foothold", (0.45, 0.8)),
        ("supporting foot", (0.10, 0.2)),
        ("supporting foot", (-0.20, -0.04)),
        ("swinging foot's start", (START_X + 0.14, -0.1)),
        ("swinging foot's start", (START_X - 0.3, START_X - 0.04)),
    ],
)
def test_a_gap_under_any_part_of_any_sole_is_told(foot, gap):
    shod = ggo.verify(STRIDE, SHOD, gaps=[ggo.Gap(*gap)])
    assert [f.kind for f in shod.violations] == [f"{foot} in a gap"]
    assert ggo.verify(STRIDE, LEGS, gaps=[ggo.Gap(*gap)]).ok


@pytest.mark.parametrize("frames", [21, 51, 201])
@pytest.mark.parametrize("joint", range(4))
def test_a_single_frame_that_stands_out_is_told(frames, joint):
    base = ggo.paper_base_gait(frames)
    bent = base.frames.copy()
    bent[frames // 2, joint] += np.radians(9.0)
    found = ggo.verify(replace(base, frames=bent)).violations
    assert [fault.frame for fault in found if fault.kind == f"{('hip', 'knee')[joint % 2]} spike"] == [frames // 2]
    assert not [fault for fault in ggo.verify(base).violations if "spike" in fault.kind]


def test_the_kinks_of_the_papers_graph_are_no_spikes():
    for box in [(0.20, 0.25, 0.15), (0.12, 0.16, 0.15), (-0.33, -0.29, 0.175)]:
        for frames in (21, 51):
            base = pointed(ggo.paper_base_gait(frames))
            assert ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0), smoothness=0.0).ok


@pytest.mark.parametrize("frames", [51, 101, 201, 401])
@pytest.mark.parametrize("end", ["out of", "into"])
def test_limits_hold_as_it_is_played_out_of_rest_and_into_it(frames, end):
    first = ggo.walk(ggo.paper_base_gait(frames), [ggo.Step((0.3, 0.0))], start=ggo.STANDING).gaits[0]
    frames = first.frames if end == "out of" else first.frames[::-1]
    step = ggo.Step((0.3, 0.0)) if end == "out of" else ggo.Step(end_frame=frames[-1])
    walk = ggo.Walk((replace(first, frames=frames),), (step,))
    few = slice(0, len(frames) // 20) if end == "out of" else slice(-(len(frames) // 20), None)
    times, rests = walk.times, (end == "out of", end == "into")
    # Clamped where it rests; the other end is far away.
    ends = tuple((1, np.zeros(4)) if rest else "not-a-knot" for rest in rests)
    knee = np.degrees(np.abs(CubicSpline(times, frames, bc_type=ends)(times, 2)[few, 3]).max())
    differences = np.degrees(np.abs(np.diff(frames[:, 3], 2)).max()) / DT**2 * ((len(frames) - 1) / 50) ** 2
    assert knee > 1.1 * differences
    for share, told in ((0.99, 1), (1.01, 0)):
        limits = ggo.JointLimits(knee_acceleration=math.radians(share * knee), knee_speed=15.0)
        faults = [fault for _, fault in found(walk.verify(limits=limits), "acceleration") if end in fault.note]
        assert len(faults) == told
        assert all(abs(fault.value) == pytest.approx(knee, rel=1e-3) for fault in faults)


def test_a_start_that_is_played_beyond_its_limits_is_made_slower_or_refused():
    plan, base = [ggo.Step((0.3, 0.0))], ggo.paper_base_gait(201)
    with pytest.raises(
        ggo.InfeasibleGaitError, match=r"from rest .* knee acceleration \(swing leg, played out of rest"
    ):
        ggo.walk(base, plan, start=ggo.STANDING, limits=ggo.JointLimits(), pace=1)
    walk = ggo.walk(base, plan, start=ggo.STANDING, limits=ggo.JointLimits())
    most = np.abs(walk.joint_trajectory(rate=2000.0).accelerations).max(axis=0)
    assert (most <= 1.01 * np.radians([3000.0, 10000.0, 3000.0, 10000.0])).all()


@pytest.mark.parametrize("frames", [21, 51, 101, 102, 151, 401])
@pytest.mark.parametrize("options", [{}, {"limits": ggo.JointLimits()}, {"smoothness": 0.0}])
def test_who_stands_is_at_rest_to_the_digit_at_any_sampling_rate(frames, options):
    plan = [ggo.Step((0.39, 0.0)), ggo.Step(end_frame=tuple(ggo.STANDING.tolist()))]
    walk = ggo.walk(ggo.paper_base_gait(frames), plan, start=ggo.STANDING, **options)
    first, last = walk.gaits[0].frames, walk.gaits[-1].frames
    np.testing.assert_array_equal(first[1], first[0])
    np.testing.assert_array_equal(last[-2], last[-1])
    assert all(report.ok for report in walk.verify())
