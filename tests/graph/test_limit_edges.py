"""Limits that get an edge where a solve breaks them, and limits, obstacles and ends as constraints."""

import math

import gtsam
import numpy as np
import pytest
from bare_bones import pointed
from independent import clearance, path_of
from scipy.optimize import minimize

import ggo_factors as ggo
from ggo_factors.graph.inequalities import end_inequality
from ggo_factors.graph.requests import JointLimitRequest

BASE = ggo.paper_base_gait()
MODEL = BASE.legs()
BOXES = [(0.20, 0.25, 0.08), (0.20, 0.25, 0.15), (0.12, 0.16, 0.08), (0.12, 0.16, 0.15), (-0.33, -0.29, 0.175)]


def graph_to(foothold, **options):
    graph = ggo.GaitGraph(BASE, **options)
    graph.anchor(BASE.frames[0])
    graph.end(foothold=foothold, gain=250.0)
    return graph


def hips(gait):
    a1, b1 = gait.frames[:, 0], gait.frames[:, 1]
    return 0.39 * np.cos(a1) + 0.39 * np.cos(a1 - b1)


def test_a_hip_edge_joins_only_where_the_hip_sinks():
    low = graph_to((0.39, 0.25)).solve()
    least = float(hips(low.gait).min()) + 0.02
    kept = graph_to((0.39, 0.25))
    kept.keep_hip_above(least)
    solution = kept.solve()
    assert hips(solution.gait).min() > hips(low.gait).min() + 0.008
    assert solution.costs["limits"] > 0.0
    assert set(solution.keyframes) > set(low.keyframes)
    spared = graph_to((0.39, 0.25))
    spared.keep_hip_above(least - 0.021)
    np.testing.assert_allclose(spared.solve().gait.frames, low.gait.frames, atol=1e-8)


@pytest.mark.parametrize("field", ["knee_speed", "hip_speed", "knee_acceleration", "hip_acceleration", "hip_forward"])
def test_edges_keep_joint_limits_softly_and_as_constraints(field):
    free = graph_to((0.52, 0.05), smoothness=30.0).solve().gait
    order = {"speed": 1, "acceleration": 2}.get(field.split("_")[1], 0)
    first = 1 if field.startswith("knee") else 0
    rates = np.diff(free.frames[:, first::2], n=order, axis=0) / free.dt**order
    worst = rates.max() if order == 0 else np.abs(rates).max()
    limits = ggo.JointLimits(**{field: float(0.97 * worst)})
    assert [v.kind for v in ggo.verify(free, limits=limits).violations if v.kind.startswith(field.split("_")[0])]
    excess = []
    for hard in (False, True):
        graph = graph_to((0.52, 0.05), smoothness=30.0, hard=hard)
        graph.limit_joints(limits)
        solution = graph.solve()
        assert solution.converged, solution.reason
        now = np.diff(solution.gait.frames[:, first::2], n=order, axis=0) / free.dt**order
        reached = now.max() if order == 0 else np.abs(now).max()
        excess.append(reached / getattr(limits, field) - 1.0)
    assert excess[0] < worst / getattr(limits, field) - 1.0
    assert excess[1] < 2e-6


@pytest.mark.parametrize("smoothness", [0.0, 100.0])
@pytest.mark.parametrize("box", BOXES)
def test_hard_meets_everything_on_the_papers_obstacles(box, smoothness):
    limits = ggo.JointLimits()
    base, boxes = pointed(BASE), [ggo.Obstacle(*box)]
    solution = ggo.step_over(base, boxes, foothold=(0.39, 0.0), smoothness=smoothness, hard=True, limits=limits)
    frames = solution.gait.frames
    assert np.hypot(*(path_of(frames)[-1] - [0.39, 0.0])) < 1e-6
    assert frames[2:, [1, 3]].min() > -1e-6  # the first two are where and how the walker moves now
    assert clearance(frames, *box) > 0.0
    assert ggo.verify(solution.gait, limits=limits, tolerances=ggo.Tolerances(limits=1e-6)).ok


@pytest.mark.parametrize("direction", [ggo.climb_stairs, ggo.descend_stairs])
def test_hard_meets_everything_on_stairs(direction):
    walk = direction(BASE, 0.10, hard=True)
    for step, solution in zip(walk.plan, walk.steps, strict=True):
        frames = solution.gait.frames
        assert np.hypot(*(path_of(frames)[-1] - step.foothold)) < 1e-6
        assert abs(math.pi / 2 + frames[-1, 2] - frames[-1, 3] - step.shank_angle) < 1e-6
        assert frames[2:, [1, 3]].min() > -1e-6


def test_scipy_finds_the_same_constrained_optimum():
    """Trust-region SQP of the full chain against the augmented Lagrangian on few keyframes."""
    base = ggo.paper_base_gait(11)
    graph = ggo.GaitGraph(base, hard=True)
    graph.anchor(base.frames[0])
    graph.end(foothold=(0.45, 0.02), shank_angle=1.7, hard=True)
    solution = graph.solve()

    def cost(flat):
        offsets = np.vstack([base.frames[0], flat.reshape(-1, 4)]) - base.frames
        return 0.5 * float((np.diff(offsets, axis=0) ** 2).sum())

    constraints = [
        {"type": "eq", "fun": lambda x: MODEL.endpoint(x[-4:]) - [0.45, 0.02]},
        {"type": "eq", "fun": lambda x: math.pi / 2 + x[-2] - x[-1] - 1.7},
        {"type": "ineq", "fun": lambda x: x.reshape(-1, 4)[:, [1, 3]].ravel()},
    ]
    start = base.frames[1:].ravel()
    found = minimize(cost, start, method="SLSQP", constraints=constraints, options={"ftol": 1e-14, "maxiter": 500})
    assert found.success
    np.testing.assert_allclose(solution.gait.frames[1:].ravel(), found.x, atol=1e-4)
    assert solution.costs["residual"] == pytest.approx(found.fun, rel=1e-5)


def test_a_contradiction_names_the_constraint_and_by_how_much():
    with pytest.raises(
        ggo.InfeasibleGaitError, match=r"contradicting: a hard edge at frame \d+ is missed by [\d.e-]+ \("
    ):
        ggo.step_over(BASE, [], foothold=(1.05, 0.0), hard=True)  # the hip would drop too far


@pytest.mark.parametrize("frames", [101, 151, 201, 801])
def test_hard_works_at_any_sampling_rate(frames):
    base = ggo.paper_base_gait(frames)
    limits = ggo.JointLimits(knee_bent=1.6)
    solution = ggo.step_over(base, [ggo.Obstacle(*BOXES[0])], foothold=(0.39, 0.0), hard=True, limits=limits)
    assert clearance(solution.gait.frames, *BOXES[0]) > 0.0
    assert np.hypot(*(path_of(solution.gait.frames)[-1] - [0.39, 0.0])) < 1e-6


def test_a_hard_landing_is_not_torn_up_by_the_clearance_before_it():
    assert all(step.ok for step in ggo.climb_stairs(ggo.paper_base_gait(6), hard=True).steps)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"start_rate": [1.0] * 4, "smoothness": 0.0}, ggo.InputError, "start_rate: without smoothness"),
        ({"start_rate": [1e6] * 4}, ggo.InputError, r"start_rate: 1e\+06 rad/s is above 50 rad/s"),
        (
            {"start_rate": [40.0] * 4, "landing": False},
            ggo.InfeasibleGaitError,
            r"hip turns \(support leg\) at frame 0.5: 2292 deg/s|a joint would turn by \d+ degrees",
        ),
        (
            {"limits": ggo.JointLimits(knee_speed=0.01), "start_rate": np.zeros(4), "pace": 1},
            ggo.InfeasibleGaitError,
            r"knee speed .*works at [\d.]+ times the time",
        ),
        (
            {"limits": ggo.JointLimits(knee_speed=3.0), "pace": 1},
            ggo.InfeasibleGaitError,
            r"^step 1: knee speed \(swing leg, as it moves now\) at frame 0.5: 282.3 deg/s \(limit 171.9 deg/s\)$",
        ),
        (
            {"limits": ggo.JointLimits(hip_forward=0.3), "start": np.array([0.4, 0.1, -0.2, 0.3])},
            ggo.InfeasibleGaitError,
            r"^step 1: hip angle \(support leg, as it stands now\) at frame 0: 22.92 deg \(limit 17.19 deg\)$",
        ),
    ],
)
def test_what_no_gait_can_do_is_told_by_its_name(arguments, error, message):
    with pytest.raises(error, match=message):
        ggo.step_over(BASE, [ggo.Obstacle(*BOXES[0])], foothold=(0.39, 0.0), **arguments)


@pytest.mark.parametrize("free", [1.0, 0.5, 0.2])
def test_the_start_acceleration_is_that_of_a_motion_that_goes_on_evenly_accelerated(free):
    """From slope r at half of what is given, to the mean slope in the middle of the first motion."""
    limits, dt = ggo.JointLimits(), 0.005
    motion, most = np.array([0.01, -0.02, 0.03, 0.0]), limits.acceleration
    limit = end_inequality("start", 0, JointLimitRequest(limits, 10.0), dt, motion, free)
    for share in (-1.5, -0.9, 0.0, 0.9, 1.5):
        frames = np.zeros((5, 4))
        frames[1] = motion + share * most * dt * (dt / 2.0 - (1.0 - free) * dt / 2.0)
        assert limit.excess(frames)[0] == pytest.approx(abs(share) - 1.0)
        assert np.isneginf(limit.excess(frames)[1:]).all()
        errors = limit.edge(0, None).errors(frames)
        assert errors.max() == pytest.approx(max(abs(share) - 1.0, 0.0))
        values = gtsam.Values()
        for n in (0, 1):
            values.insert(gtsam.symbol("g", n), frames[n])
        assert ggo.check_jacobian(limit.edge(0, None).factor(), values) < 1e-6


@pytest.mark.parametrize(("frames", "gain"), [(51, 1e4), (101, 10.0), (101, 1e4)])
def test_limits_much_stiffer_than_the_rest_are_not_called_singular(frames, gain):
    """GTSAM's Cholesky does call them that; by numpy's least squares nothing is left to gain."""
    base = ggo.paper_base_gait(frames)
    graph = ggo.GaitGraph(base, smoothness=0.04 * (frames - 1) ** 2)
    graph.anchor(base.frames[0])
    graph.end((0.42, 0.0), gain=500.0)
    graph.limit_joints(ggo.JointLimits().tightened(0.7), gain)
    solution = graph.solve()
    assert solution.converged, solution.reason
    jacobian, error = solution.factor_graph.linearize(solution.values).jacobian()
    free = jacobian[:, 4:]  # but the frame that is anchored
    left = error - free @ np.linalg.lstsq(free, error)[0]
    assert error @ error - left @ left < 1e-6 * (error @ error)


@pytest.mark.parametrize("frames", [11, 51, 101, 201])
def test_a_replan_that_changes_nothing_is_never_beyond_the_limits(frames):
    """Though the base gait's next motion is faster than the joints may be, which the step's own is not."""
    limits = ggo.JointLimits(hip_speed=math.radians(135), knee_speed=math.radians(315), hip_back=math.radians(-25))
    step = ggo.step_over(ggo.paper_base_gait(frames), [], foothold=(0.42, 0.0), limits=limits, pace=1)
    for at in range(0, frames - 4, max(1, frames // 20)):
        again = ggo.replan(step, at).gait
        np.testing.assert_array_equal(again.frames[: at + 1], step.gait.frames[: at + 1])
        assert ggo.verify(again, limits=limits).ok


@pytest.mark.parametrize("frames", [51, 101, 120, 1601])
def test_a_start_that_can_slow_to_the_limit_in_a_frame_does(frames):
    base = ggo.paper_base_gait(frames)
    rate = (base.frames[1] - base.frames[0]) / base.dt
    limits = ggo.JointLimits(hip_speed=math.radians(150), hip_back=math.radians(-25))
    rate[2] = math.radians(150.5)
    made = ggo.step_over(base, [], foothold=(0.39, 0.0), start_rate=rate, limits=limits).gait
    assert ggo.verify(made, limits=limits).ok
    rate[2] = math.radians(250.0)
    with pytest.raises(ggo.InfeasibleGaitError, match=r"^step 1: hip speed \(swing leg, as it moves now\)"):
        ggo.step_over(base, [], foothold=(0.39, 0.0), start_rate=rate, limits=limits)
