"""The procedures, judged by a dense check that shares no code with the library's own."""

import math

import numpy as np
import pytest
from bare_bones import deepest, joints, pointed, way_past
from independent import clearance, densely, least_knee_deg, path_of, stair_clearance
from rival_minimisers import textbook
from rivals import default_smoothness
from rivals import walk as full_graph

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


def random_obstacles(count, seed):
    """Boxes that do not come within 0.03 m of the supporting foot."""
    rng = np.random.default_rng(seed)
    made = []
    while len(made) < count:
        start, width, height = rng.uniform(-0.30, 0.25), rng.uniform(0.02, 0.08), rng.uniform(0.02, 0.20)
        if start > 0.03 or start + width < -0.03:
            made.append((start, start + width, height))
    return made


def test_fifty_random_obstacles():
    """A sample of what `tests/campaign` does with three hundred and more."""
    refused = []
    for numbers in random_obstacles(50, seed=2024):
        try:
            frames = ggo.step_over(BASE, [ggo.Obstacle(*numbers)], foothold=(0.39, 0.0)).gait.frames
        except ggo.InfeasibleGaitError:
            refused.append(numbers)
            continue
        assert clearance(frames, *numbers) > 0.0, numbers
        assert np.hypot(*(path_of(frames)[-1] - [0.39, 0.0])) < 1e-3, numbers
        assert least_knee_deg(frames) > -0.3, numbers
        assert path_of(densely(frames))[:, 1].min() > -1e-3, numbers
        np.testing.assert_array_equal(frames[0], BASE.frames[0])
    # Where no bone is in the box in the first two frames, which are given, it stands right before the supporting shin.
    standing = [box for box in refused if deepest(joints(BASE.frames[:2]), box) > 0.0]
    assert len(standing) <= 4, standing
    assert len(refused) - len(standing) <= 1, refused
    assert not any(way_past(BASE.frames[0], box, (0.39, 0.0)) for box in set(refused) - set(standing))


@pytest.mark.parametrize("frames", [21, 201])
def test_other_sampling_rates(frames):
    base = ggo.paper_base_gait(frames)
    for numbers in random_obstacles(12, seed=frames):
        if deepest(joints(base.frames[:1]), numbers) > 0.0:
            continue
        gait = ggo.step_over(base, [ggo.Obstacle(*numbers)], foothold=(0.39, 0.0)).gait
        assert clearance(gait.frames, *numbers) > 0.0
        assert np.hypot(*(path_of(gait.frames)[-1] - [0.39, 0.0])) < 1e-3


def test_two_obstacles_in_one_step():
    boxes = [(-0.25, -0.20, 0.10), (0.15, 0.20, 0.12)]
    solution = ggo.step_over(BASE, [ggo.Obstacle(*box) for box in boxes], foothold=(0.39, 0.0))
    for box in boxes:
        assert clearance(solution.gait.frames, *box) > 0.0


@pytest.mark.parametrize("span", [(-0.02, 0.03), (0.0, 0.05), (-0.05, 0.0), (-0.5, 0.5)])
def test_an_obstacle_in_the_support_foot_is_refused(span):
    with pytest.raises(ggo.InfeasibleGaitError, match="obstacle in the supporting foot"):
        ggo.step_over(BASE, [ggo.Obstacle(*span, 0.05)], foothold=(0.39, 0.0))


def test_impossible_steps_are_refused_with_a_foothold_that_works():
    with pytest.raises(
        ggo.InfeasibleGaitError,
        match=r"step 1: obstacle in the foothold \(box from 0\.36 to 0\.42 m, 0\.1 m high\): 0\.39 m",
    ) as caught:
        ggo.step_over(BASE, [ggo.Obstacle(0.36, 0.42, 0.10)], foothold=(0.39, 0.0))
    nearest = caught.value.nearest_foothold
    assert nearest is not None
    assert f"({nearest[0]:.3f}, 0.000) m" in str(caught.value)
    solution = ggo.step_over(BASE, [ggo.Obstacle(0.36, 0.42, 0.10)], foothold=nearest)
    assert clearance(solution.gait.frames, 0.36, 0.42, 0.10) > 0.0
    with pytest.raises(ggo.InfeasibleGaitError, match="obstacle in the swinging foot's start"):
        ggo.step_over(BASE, [ggo.Obstacle(-0.41, -0.35, 0.10)], foothold=(0.39, 0.0))
    with pytest.raises(ggo.InfeasibleGaitError, match="no gait found that passes the check: ") as caught:
        ggo.step_over(BASE, [ggo.Obstacle(0.15, 0.2, 0.9)], foothold=(0.39, 0.0))
    assert caught.value.step == 1
    assert caught.value.violations


def test_unreachable_foothold_carries_its_numbers():
    with pytest.raises(ggo.UnreachableFootholdError, match=r"step 1: .*1\.560 m") as caught:
        ggo.step_over(BASE, [], foothold=(1.8, 0.0))
    assert (caught.value.distance, caught.value.reach, caught.value.step) == pytest.approx((1.8, 1.56, 1))


def test_a_split_is_no_step():
    # Two legs reach 1.56 m, but nobody's thighs open that far.
    with pytest.raises(ggo.InfeasibleGaitError, match="thigh back"):
        ggo.step_over(BASE, [], foothold=(1.5, 0.0))


@pytest.mark.parametrize("stride", [0.975, 0.585])
def test_strides(stride):
    walk = ggo.adjust_stride(BASE, stride)
    first, second = (path_of(gait.frames) for gait in walk.gaits)
    np.testing.assert_allclose(first[-1], [stride / 2, 0.0], atol=1e-3)
    np.testing.assert_allclose(second[0], [-stride / 2, 0.0], atol=1e-3)
    np.testing.assert_allclose(second[-1], [stride / 2, 0.0], atol=1e-3)
    assert all(solution.ok for solution in walk.steps)


def test_a_pit_is_stepped_over_by_a_longer_stride():
    pit = ggo.Gap(0.30, 0.44)
    with pytest.raises(
        ggo.InfeasibleGaitError, match=r"foothold in a gap \(gap from 0\.3 to 0\.44 m\): 0\.39 m \(limit 0\.44 m\)"
    ):
        ggo.adjust_stride(BASE, 0.78, gaps=[pit])
    walk = ggo.adjust_stride(BASE, gaps=[pit])
    landings = np.cumsum([path_of(gait.frames)[-1, 0] for gait in walk.gaits])
    assert landings[0] > 0.44
    assert not ((landings > 0.30) & (landings < 0.44)).any()


def test_a_pit_met_by_the_second_foothold_is_seen():
    with pytest.raises(ggo.InfeasibleGaitError, match="step 2: foothold in a gap"):
        ggo.adjust_stride(BASE, 0.78, gaps=[ggo.Gap(0.7, 0.9)])


@pytest.mark.parametrize("down", [False, True])
@pytest.mark.parametrize("risers", [0.10, 0.15, (0.10, 0.14)])
def test_stairs(risers, down):
    walk = (ggo.descend_stairs if down else ggo.climb_stairs)(BASE, risers)
    rises = np.broadcast_to(risers, 2) * (-1.0 if down else 1.0)
    assert len(walk.gaits) == 2
    for number, gait in enumerate(walk.gaits):
        np.testing.assert_allclose(path_of(gait.frames)[-1], [0.39, rises[number]], atol=1e-3)
        assert np.degrees(gait.frames[-1, 2] - gait.frames[-1, 3]) == pytest.approx(0.0, abs=1.0)
        below = rises[:number].sum()
        edges = np.array([0.29, 0.68]) - 0.39 * number
        heights = np.array([0.0, rises[0], rises.sum()]) - below
        assert stair_clearance(gait.frames, edges, heights) > 0.005
        assert least_knee_deg(gait.frames) > -0.3


def test_longer_stairs_with_other_treads():
    walk = ggo.climb_stairs(BASE, riser=0.17, tread=0.29, first_edge=0.20, steps=4)
    np.testing.assert_allclose(np.sum([path_of(g.frames)[-1] for g in walk.gaits], axis=0), [1.16, 0.68], atol=4e-3)


@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
def test_a_flight_of_stairs_does_not_sink_into_a_crouch(procedure):
    walk = procedure(BASE, riser=0.17, tread=0.28, first_edge=0.20, steps=8)
    hips = [ggo.LegModel(0.39, 0.39).joints(gait.frames)[:, 2, 1].min() for gait in walk.gaits]
    assert hips[7] > hips[2] - 0.005
    np.testing.assert_allclose(walk.gaits[7].frames[-1], walk.gaits[2].frames[-1], atol=math.radians(1.0))


def test_a_real_foot_lifts_over_the_edge_earlier():
    foot = ggo.Foot(ankle_height=0.08, heel=0.05, toe=0.10)
    model = ggo.LegModel(0.39, 0.39, foot=foot)
    solution = ggo.step_over(BASE, [ggo.Obstacle(0.15, 0.20, 0.08)], foothold=(0.39, 0.0), model=model)
    assert clearance(solution.gait.frames, 0.05, 0.25, 0.08) > 0.0
    with pytest.raises(ggo.InfeasibleGaitError, match="obstacle in the supporting foot"):
        ggo.step_over(BASE, [ggo.Obstacle(0.09, 0.14, 0.08)], foothold=(0.39, 0.0), model=model)


@pytest.mark.parametrize(
    "last", [ggo.Step(end_frame=tuple(ggo.STANDING)), ggo.Step((0.0, 0.0), end_frame=(0, 0, 0, 0))]
)
def test_from_standing_to_standing(last):
    walk = ggo.walk(BASE, [ggo.Step((0.35, 0.0)), ggo.Step((0.39, 0.0)), last], start=ggo.STANDING)
    np.testing.assert_array_equal(walk.gaits[0].frames[0], 0.0)
    np.testing.assert_allclose(walk.gaits[-1].frames[-1], 0.0, atol=1e-9)
    np.testing.assert_allclose(path_of(walk.gaits[-1].frames)[0], [-0.39, 0.0], atol=1e-3)
    for gait in walk.gaits:
        assert path_of(densely(gait.frames))[:, 1].min() > -1e-3


def test_stairs_from_standing():
    walk = ggo.climb_stairs(BASE, riser=0.12, tread=0.25, first_edge=0.15, start=ggo.STANDING)
    np.testing.assert_allclose(path_of(walk.gaits[0].frames)[-1], [0.25, 0.12], atol=1e-3)


def test_up_one_stair_to_standing():
    stair = ggo.Ground(edges=(0.15,), heights=(0.0, 0.12))
    plan = [
        ggo.Step((0.25, 0.12), shank_angle=math.pi / 2, ground=stair),
        ggo.Step(end_frame=tuple(ggo.STANDING), ground=stair.shifted(0.25, 0.12)),
    ]
    walk = ggo.walk(BASE, plan, start=ggo.STANDING)
    np.testing.assert_allclose(walk.gaits[1].frames[-1], 0.0, atol=1e-6)


def test_a_kerb_by_its_ground():
    kerb = ggo.Ground(edges=(0.29,), heights=(0.0, 0.12))
    walk = ggo.walk(BASE, [ggo.Step((0.39, 0.12), ground=kerb)])
    assert stair_clearance(walk.gaits[0].frames, [0.29], [0.0, 0.12]) > 0.005
    with pytest.raises(ggo.InfeasibleGaitError, match=r"foothold off the ground: 0\.12 m \(limit 0 m\)"):
        ggo.walk(BASE, [ggo.Step((0.39, 0.12))])


def test_a_gain_that_is_given_is_kept():
    with pytest.raises(ggo.InfeasibleGaitError, match="foothold at frame 50"):
        ggo.step_over(BASE, [ggo.Obstacle(0.2, 0.25, 0.15)], foothold=(0.39, 0.0), gain=0.5)


def test_a_walk_of_many_steps_does_not_drift():
    walk = ggo.walk(BASE, [ggo.Step((0.39, 0.0))] * 12)
    changes = [np.abs(gait.frames - BASE.frames).max() for gait in walk.gaits]
    assert math.degrees(max(changes)) < 3.0
    np.testing.assert_allclose(walk.origins()[-1], [0.39 * 11, 0.0], atol=2e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ggo.walk(BASE, []), "at least one step"),
        (lambda: ggo.walk(BASE, [(0.39, 0.0)]), "expected Steps"),
        (lambda: ggo.walk(BASE, [ggo.Step((0.39, 0.0))], start=[0, 0, 0]), r"start: expected shape \(4,\)"),
        (ggo.Step, "needs a foothold"),
        (lambda: ggo.Step((0.39, 0.0), obstacles=[(0.1, 0.2, 0.3)]), "obstacles: expected Obstacles"),
        (lambda: ggo.adjust_stride(BASE, -0.5), r"stride: -0\.5 m must be above 0 m"),
        (lambda: ggo.adjust_stride(BASE, 0.8, steps=0), "steps: 0 must be at least 1"),
        (lambda: ggo.climb_stairs(BASE, riser=-0.1), r"riser: -0\.1 m must be above 0"),
        (lambda: ggo.climb_stairs(BASE, riser=(0.1, 0.1), steps=3), "2 risers for 3 steps"),
        (lambda: ggo.climb_stairs(BASE, first_edge=0.5), r"first_edge: 0\.5 m must be below the tread 0\.39 m"),
        (lambda: ggo.step_over(ggo.Gait(BASE.frames, 0.01), []), "states no leg lengths"),
    ],
)
def test_bad_requests_are_refused(call, message):
    with pytest.raises(ggo.InputError, match=message):
        call()


@pytest.mark.parametrize(
    ("box", "apart"),
    [
        ((0.20, 0.25, 0.08), 2e-3),
        # Few frames are over this narrow box: those of the full graph at 401 frames a step are 5 mm apart from these.
        ((0.12, 0.16, 0.15), 6e-3),
        ((-0.33, -0.29, 0.175), 2e-3),
    ],
)
@pytest.mark.parametrize("smoothness", [None, 0.0])
def test_the_same_gait_at_any_high_sampling_rate(box, apart, smoothness):
    """In time: the residual cost times the rate, the path of the foot, and where it lands."""
    found = {}
    for frames in (401, 501, 1601):
        base = pointed(ggo.paper_base_gait(frames))
        solution = ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0), smoothness=smoothness)
        bent = solution.gait.frames
        assert len(bent) == frames
        assert clearance(bent, *box) > 0.0
        assert np.hypot(*(path_of(bent)[-1] - [0.39, 0.0])) < 1e-3
        np.testing.assert_array_equal(bent[0], base.frames[0])
        cost = float((np.diff(bent - base.frames, axis=0) ** 2).sum()) * (frames - 1)
        places = np.linspace(0, 1, 11)
        path = [np.interp(places, np.linspace(0, 1, frames), column) for column in path_of(bent).T]
        found[frames] = cost, np.array(path)
        assert len(solution.keyframes) < 60
        assert solution.keyframes[-1] == frames - 1
    for frames in (401, 501):
        # The outermost frame over a box counts for less, the more there are.
        assert found[frames][0] == pytest.approx(found[1601][0], rel=0.05)
        np.testing.assert_allclose(found[frames][1], found[1601][1], atol=apart)


@pytest.mark.parametrize(
    ("box", "frames", "smoothness"),
    [
        (None, 201, None),
        ((0.20, 0.25, 0.08), 201, None),
        ((0.12, 0.16, 0.08), 401, None),
        ((0.12, 0.16, 0.15), 201, 0.0),
        ((-0.33, -0.29, 0.175), 201, None),
    ],
)
def test_above_a_hundred_motions_the_gait_costs_what_that_of_the_full_graph_does(box, frames, smoothness):
    base = pointed(ggo.paper_base_gait(frames))
    steps = [ggo.Step((0.39, 0.0), (ggo.Obstacle(*box),))] if box else [ggo.Step((0.4875, 0.0))] * 2
    ours = [gait.frames for gait in ggo.walk(base, steps, smoothness=smoothness).gaits]
    gain = default_smoothness(frames) if smoothness is None else smoothness
    full = full_graph(base, steps, gain, textbook)
    assert full.ok
    offsets = [np.array(gaits) - base.frames for gaits in (ours, full.gaits)]
    cost, least = (float((np.diff(each, axis=1) ** 2).sum()) for each in offsets)
    assert cost == pytest.approx(least, rel=0.01)
    np.testing.assert_allclose(*offsets, atol=0.003)
    if box:
        assert clearance(ours[0], *box) > 0.0


@pytest.mark.parametrize("frames", [51, 101, 102, 151, 401, 1601])
def test_a_start_rate_is_kept_or_refused_at_any_sampling_rate(frames):
    base = ggo.paper_base_gait(frames)
    with pytest.raises(ggo.InfeasibleGaitError, match=r"knee \(support leg, as it moves now\) at frame .*limit -0.3"):
        ggo.step_over(base, [], foothold=(0.4, 0.0), start_rate=(0.0, -0.8, 0.0, 0.0))
    asked = (base.frames[1] - base.frames[0]) / base.dt + [0.0, 0.2, 0.3, 0.0]
    made = ggo.step_over(base, [], foothold=(0.4, 0.0), start_rate=asked).gait.frames
    first = (made[1] - made[0]) / base.dt
    np.testing.assert_allclose(first, asked, atol=1e-9 if frames <= 101 else 0.03)


@pytest.mark.parametrize(("frames", "at"), [(200, 103), (401, 207)])
def test_a_replan_near_the_joints_limits_is_made_at_a_high_rate_too(frames, at):
    base = ggo.paper_base_gait(frames)
    step = ggo.step_over(base, [ggo.Obstacle(0.20, 0.25, 0.08)], foothold=(0.39, 0.0))
    again = ggo.replan(step, at, obstacles=[ggo.Obstacle(0.2374, 0.3009, 0.1336)], foothold=(0.4167, 0.0))
    rates = np.degrees(np.diff(again.gait.frames[at - 1 :], n=2, axis=0)) / base.dt**2
    assert (np.abs(rates) <= np.array([3000.0, 10000.0, 3000.0, 10000.0]) * 1.001).all()


def test_a_high_rate_joins_steps_without_a_jump_too():
    base = ggo.paper_base_gait(801)
    first, second = (gait.frames - base.frames for gait in ggo.adjust_stride(base, 0.9).gaits)
    before, after = np.diff(first, axis=0)[-1][[2, 3, 0, 1]], np.diff(second, axis=0)[0]
    assert np.abs(after - before).max() < 0.01 * np.abs(np.diff(base.frames, axis=0)).max()


def test_a_replan_at_a_high_rate():
    base = ggo.paper_base_gait(501)
    first = ggo.step_over(base, [ggo.Obstacle(0.20, 0.25, 0.08)], foothold=(0.39, 0.0))
    again = ggo.replan(first, 207, obstacles=[ggo.Obstacle(0.21, 0.26, 0.10)], foothold=(0.42, 0.0))
    np.testing.assert_array_equal(again.gait.frames[:208], first.gait.frames[:208])
    assert clearance(again.gait.frames, 0.21, 0.26, 0.10) > 0.0
    jump = np.diff(again.gait.frames - base.frames, n=2, axis=0)[206]
    assert np.abs(jump).max() < 0.01 * np.abs(np.diff(again.gait.frames, axis=0)).max()
    assert ggo.joint_spread(again).shape == (501, 4)
    assert (ggo.joint_spread(again)[:208] == 0.0).all()
