"""Every edge: Jacobians against central differences, and the gate that all factors pass."""

import math

import gtsam
import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.factors import (
    anchor_factor,
    balance_edges,
    checked_factor,
    clear_edge,
    edge_between,
    fill_spans,
    foothold_edge,
    foothold_factor,
    frame_key,
    frame_of_key,
    hip_edge,
    knee_edge,
    knee_factor,
    landing_factors,
    limit_edge,
    motion_edges,
    obstacle_edge,
    obstacle_factor,
    pose_factor,
    precision,
    rate_edge,
    residual_edge,
    residual_factor,
    shank_edge,
    shank_factor,
    stacked_factor,
    without_constants,
)

MODEL = ggo.LegModel(0.45, 0.40)
BASE = ggo.paper_base_gait()
STATES = np.random.default_rng(7).uniform(-1.2, 1.2, (20, 3, 4))

OFFSET = np.array([0.02, -0.01, 0.03, 0.01])


def low_between(height=0.9, **weights):
    """An obstacle edge at an instant a third of the way from frame 0 to frame 1."""
    return edge_between(obstacle_edge(7, MODEL, height, **weights), (0, 1), 0.3, OFFSET)


EDGES = {
    "obstacle between frames, below": low_between(hold=0.3, hold_x=0.2).factor(),
    "obstacle between frames, above": low_between(-2.0).factor(),
    "hip between frames": edge_between(hip_edge(7, MODEL, 0.84, 50.0), (0, 2), 0.6, OFFSET).factor(),
    "rate": rate_edge(BASE.frames, np.full(4, 0.01), 100.0).factor(),
    "anchor": anchor_factor(0, np.full(4, 0.1)),
    "residual": residual_factor(BASE.frames, 0, 1),
    "residual over a span": residual_factor(BASE.frames, 0, 2),
    "knee": knee_factor(0, 5.0),
    "obstacle, below": obstacle_factor(0, MODEL, 0.9, gamma=4.0),
    "obstacle, above": obstacle_factor(0, MODEL, -2.0, gamma=4.0),
    "obstacle with hold": obstacle_factor(1, MODEL, 0.9, gamma=4.0, hold=0.3, hold_x=0.2),
    "foothold": foothold_factor(2, MODEL, (0.39, 0.1), 255.0),
    "foothold, hard": foothold_factor(2, MODEL, (0.39, 0.1), math.inf),
    "obstacle for several frames": obstacle_factor(1, MODEL, 0.9, hold=1.0, hold_x=0.2, gain=16.0),
    "shank": shank_factor(2, math.pi / 2, 255.0),
    "landing, posture": landing_factors(BASE.frames[:3], np.full(4, 0.2), 1.0, 20.0)[0],
    "landing, motion": landing_factors(BASE.frames[:3], np.full(4, 0.2), 1.0, 20.0)[1],
    "pose": pose_factor(2, np.full(4, 0.2), 5.0),
    "clear, below": clear_edge(1, MODEL, 0.9, 3.0).factor(),
    "clear, above": clear_edge(1, MODEL, -2.0, 3.0).factor(),
    "hip, below": hip_edge(1, MODEL, 0.84, 50.0).factor(),
    "hip, above": hip_edge(1, MODEL, 0.1, 50.0).factor(),
    "angle limit": limit_edge("joint angle", (1,), np.full(4, -0.5), np.full(4, 0.4), np.full(4, 0.9), 5.0).factor(),
    "speed limit": limit_edge("joint speed", (0, 1), np.full(4, -0.1), np.full(4, 0.1), np.full(4, 0.1), 5.0).factor(),
    "acceleration limit": limit_edge(
        "joint acceleration", (0, 1, 2), np.full(4, -0.2), np.arange(1.0, 5.0), np.arange(1.0, 5.0), 5.0
    ).factor(),
}
# The ZMP held to a place, and within supports that it is behind, in, and before.
for support in ((0.1, 0.1), (3.0, 4.0), (-40.0, 40.0), (-4.0, -3.0)):
    EDGES[f"balance, {support}"] = balance_edges(MODEL, 0.2, 0.3, np.array([support]))[0].factor()


def values_of(frames):
    values = gtsam.Values()
    for number, frame in enumerate(frames):
        values.insert(frame_key(number), np.asarray(frame, dtype=float))
    return values


@pytest.mark.parametrize("name", EDGES)
@pytest.mark.parametrize("state", range(20))
def test_jacobian_at_random_states(name, state):
    assert ggo.check_jacobian(EDGES[name], values_of(STATES[state])) < 1e-6


@pytest.mark.parametrize("side", [-1e-4, 1e-4])
@pytest.mark.parametrize("column", [1, 3])
def test_knee_on_both_sides_of_its_kink(side, column):
    frame = np.full(4, 0.5)
    frame[column] = side
    assert ggo.check_jacobian(EDGES["knee"], values_of([frame])) < 1e-6
    error = EDGES["knee"].unwhitenedError(values_of([frame]))
    assert error.max() == pytest.approx(max(-side, 0.0))


@pytest.mark.parametrize("side", [-1e-4, 1e-4])
@pytest.mark.parametrize("hold", [0.0, 0.3])
def test_obstacle_on_both_sides_of_its_kink(side, hold):
    for frame in STATES[:, 0]:
        height = float(MODEL.endpoint(frame)[1]) + side
        factor = obstacle_factor(0, MODEL, height, hold=hold, hold_x=0.1)
        assert ggo.check_jacobian(factor, values_of([frame])) < 1e-6
        error = factor.unwhitenedError(values_of([frame]))
        assert error[0] == pytest.approx(math.expm1(4.0 * max(side, 0.0)), abs=1e-12)


def test_errors_by_hand():
    standing, values = np.zeros(4), values_of(np.zeros((3, 4)))
    assert EDGES["foothold"].unwhitenedError(values) == pytest.approx([-0.39, -0.1])
    assert EDGES["shank"].unwhitenedError(values) == pytest.approx([0.0])
    assert EDGES["obstacle with hold"].unwhitenedError(values) == pytest.approx([math.expm1(3.6), -0.06])
    assert EDGES["anchor"].unwhitenedError(values) == pytest.approx([-0.1] * 4)
    assert EDGES["residual"].unwhitenedError(values) == pytest.approx(BASE.frames[0] - BASE.frames[1])
    assert EDGES["landing, posture"].unwhitenedError(values) == pytest.approx([-0.2] * 4)
    assert EDGES["landing, motion"].unwhitenedError(values) == pytest.approx(BASE.frames[1] - BASE.frames[2])
    assert ggo.factors.shank_angle(standing) == pytest.approx(math.pi / 2)


def test_gains_weigh_the_square():
    values = values_of(np.zeros((3, 4)))
    assert EDGES["foothold"].error(values) == pytest.approx(0.5 * 255.0 * (0.39**2 + 0.1**2))
    span = residual_factor(BASE.frames, 0, 2)
    moving = BASE.frames[2] - BASE.frames[1]
    assert EDGES["landing, posture"].error(values) == pytest.approx(0.5 * 4 * 0.2**2)
    assert EDGES["landing, motion"].error(values) == pytest.approx(0.5 * 20.0 * (moving @ moving))
    motion = BASE.frames[2] - BASE.frames[0]
    assert span.error(values) == pytest.approx(0.5 * (motion @ motion) / 2)


def test_a_span_costs_what_its_best_inner_frames_cost():
    rng = np.random.default_rng(8)
    base, ends = BASE.frames[:6], rng.uniform(-1, 1, (2, 4))
    frames = fill_spans(base, [0, 5], ends)
    chain = [residual_factor(base, k, k + 1) for k in range(5)]
    cost = sum(factor.error(values_of(frames)) for factor in chain)
    assert cost == pytest.approx(residual_factor(base, 0, 5).error(values_of(frames)))
    for _ in range(20):  # any other inner frames cost more
        moved = frames.copy()
        moved[1:5] += rng.normal(0, 1e-2, (4, 4))
        assert sum(factor.error(values_of(moved)) for factor in chain) > cost


def test_a_wrong_jacobian_is_seen():
    def wrong(frame, want_jacobian):
        return frame[:2] * 2.0, (np.eye(2, 4),)

    factor = checked_factor("mine", (0,), 2, wrong, precision(2, 9.0))
    assert ggo.check_jacobian(factor, values_of([np.zeros(4)])) == pytest.approx(1.0)


def test_check_jacobian_takes_native_factors_and_refuses_what_it_cannot_judge():
    key, noise = frame_key(0), gtsam.noiseModel.Isotropic.Precision(4, 3.0)
    prior = gtsam.PriorFactorVector(key, np.ones(4), noise)
    assert ggo.check_jacobian(prior, values_of([np.zeros(4)])) < 1e-6
    with pytest.raises(ggo.InputError, match="no value for g0"):
        ggo.check_jacobian(prior, gtsam.Values())
    huber = gtsam.noiseModel.Robust.Create(gtsam.noiseModel.mEstimator.Huber.Create(1.0), noise)
    with pytest.raises(ggo.InputError, match="robust"):
        ggo.check_jacobian(gtsam.PriorFactorVector(key, np.ones(4), huber), values_of([np.zeros(4)]))


GOOD_BLOCK = np.zeros((2, 4), order="F")


@pytest.mark.parametrize(
    ("result", "message"),
    [
        ((np.zeros(3), (GOOD_BLOCK,)), r"error has shape \(3,\) of float64, expected shape \(2,\)"),
        (([0.0, 0.0], (GOOD_BLOCK,)), r"error is \[0.0, 0.0\]"),
        ((np.array([0.0, np.nan]), (GOOD_BLOCK,)), "is not finite"),
        ((np.ones(2), ()), "0 Jacobians, expected 1"),
        ((np.ones(2), (np.zeros(4),)), r"Jacobian 0 has shape \(4,\)"),
        ((np.ones(2), (np.zeros((3, 4)),)), r"Jacobian 0 has shape \(3, 4\)"),
        ((np.ones(2), (np.zeros((2, 5)),)), r"Jacobian 0 has shape \(2, 5\)"),
        ((np.ones(2), (np.full((2, 4), np.inf),)), "Jacobian 0 is not finite"),
        ((np.ones(2), (None,)), "Jacobian 0 is None"),
    ],
)
@pytest.mark.parametrize("optimizer", [gtsam.DoglegOptimizer, gtsam.LevenbergMarquardtOptimizer])
def test_what_would_kill_the_interpreter_is_an_error_that_names_the_edge(result, message, optimizer):
    graph = gtsam.NonlinearFactorGraph()
    graph.add(checked_factor("mine", (3,), 2, lambda frame, want: result, precision(2, 1.0)))
    values = gtsam.Values()
    values.insert(frame_key(3), np.zeros(4))
    with pytest.raises(ggo.GraphError, match=f"mine edge at frame 3: .*{message}"):
        optimizer(graph, values).optimize()


def test_the_gate_checks_its_own_arguments():
    with pytest.raises(ggo.InputError, match="noise of dimension 3, error of 2"):
        checked_factor("mine", (0,), 2, lambda frame, want: (np.zeros(2), (GOOD_BLOCK,)), precision(3, 1.0))
    with pytest.raises(ggo.InputError, match="each once"):
        checked_factor("mine", (0, 0), 2, lambda a, b, want: (np.zeros(2), ()), precision(2, 1.0))
    factor = checked_factor("mine", (0,), 2, lambda frame, want: (np.zeros(2), (GOOD_BLOCK,)), precision(2, 1.0))
    values = gtsam.Values()
    values.insert(frame_key(0), np.zeros(3))
    with pytest.raises(ggo.GraphError, match=r"value of frame 0 has shape \(3,\)"):
        factor.unwhitenedError(values)


def test_keys_of_frames():
    assert frame_key(12) == gtsam.symbol("g", 12)
    assert frame_of_key(frame_key(12)) == 12
    assert frame_of_key(gtsam.symbol("x", 12)) is None


CURVED = {
    "obstacle, below": obstacle_edge(0, MODEL, 0.9, gamma=4.0),
    "obstacle with hold, below": obstacle_edge(0, MODEL, 0.9, hold=1.0, hold_x=0.2),
    "obstacle with hold, above": obstacle_edge(0, MODEL, -2.0, hold=1.0, hold_x=0.2),
    "foothold": foothold_edge(0, MODEL, (0.39, 0.1), 1.0),
    "clear, below": clear_edge(0, MODEL, 0.9, 1.0),
    "hip, below": hip_edge(0, MODEL, 0.84, 1.0),
}


@pytest.mark.parametrize("name", CURVED)
def test_curvature_is_what_gauss_newton_leaves_out(name):
    edge = CURVED[name]

    def gradient(frame):
        error, (block,) = edge.function(frame, True)
        return block.T @ error

    for frame in STATES[:, 0]:
        _, (block,) = edge.function(frame, True)
        steps = 1e-6 * np.eye(4)
        hessian = np.stack([(gradient(frame + step) - gradient(frame - step)) / 2e-6 for step in steps], -1)
        np.testing.assert_allclose(block.T @ block + edge.function.curvature(frame), hessian, rtol=1e-6, atol=1e-5)


def test_curvature_between_frames():
    edge = low_between(hold=1.0, hold_x=0.2)
    for frames in STATES[:, :2]:

        def gradient(change, frames=frames):
            error, blocks = edge.function(*(frames + change.reshape(2, 4)), True)
            return np.hstack(blocks).T @ error

        jacobian = np.hstack(edge.function(*frames, True)[1])
        hessian = np.stack([(gradient(step) - gradient(-step)) / 2e-6 for step in 1e-6 * np.eye(8)], -1)
        found = jacobian.T @ jacobian + edge.function.curvature(*frames)
        np.testing.assert_allclose(found, hessian, rtol=1e-6, atol=1e-5)


@pytest.mark.parametrize("fixed", [(), (0,), (1,)])
def test_an_edge_between_frames_is_the_edge_at_their_mean(fixed):
    edge = low_between(hold=0.3, hold_x=0.2, gain=2.0)
    for frames in STATES:
        at = 0.7 * frames[0] + 0.3 * frames[1] + OFFSET
        error = obstacle_edge(0, MODEL, 0.9, hold=0.3, hold_x=0.2).function(at, False)[0]
        np.testing.assert_allclose(edge.errors(frames), error, atol=1e-12)
        left = without_constants(edge, {n: frames[n] for n in fixed})
        assert left.frames == tuple(n for n in (0, 1) if n not in fixed)
        np.testing.assert_allclose(left.errors(frames), error, atol=1e-12)


@pytest.mark.parametrize("side", [-1e-4, 1e-4])
def test_hip_and_limits_on_both_sides_of_their_kinks(side):
    for frames in STATES:
        hip = float(MODEL.joints(frames[0])[2, 1])
        factor = hip_edge(0, MODEL, hip + side, 1.0).factor()
        assert ggo.check_jacobian(factor, values_of(frames)) < 1e-6
        assert factor.unwhitenedError(values_of(frames)) == pytest.approx([max(side, 0.0)])
        foot = float(MODEL.endpoint(frames[0])[1])
        clear = clear_edge(0, MODEL, foot + side, 1.0).factor()
        assert ggo.check_jacobian(clear, values_of(frames)) < 1e-6
        assert clear.unwhitenedError(values_of(frames)) == pytest.approx([max(side, 0.0)])
        for order in range(3):
            rates, wide = np.diff(frames, n=order, axis=0)[0], np.full(4, 100.0)
            for lower, upper in ((rates + side, wide), (-wide, rates - side)):
                limit = limit_edge("limit", range(order + 1), lower, upper, np.full(4, 2.0), 1.0).factor()
                assert ggo.check_jacobian(limit, values_of(frames)) < 1e-6
                beyond = limit.unwhitenedError(values_of(frames))
                assert np.sort(beyond)[-4:] == pytest.approx(np.full(4, max(side, 0.0) / 2.0))


def edges_of_every_kind():
    return [
        *motion_edges(BASE.frames[:3], [0, 1, 2], 100.0),
        hip_edge(0, MODEL, 0.84, 50.0),
        hip_edge(1, MODEL, 0.84, 50.0),
        hip_edge(2, MODEL, 0.84, 50.0),
        clear_edge(0, MODEL, 0.9, 3.0),
        clear_edge(1, MODEL, 0.9, 3.0),
        clear_edge(2, MODEL, 0.3, 3.0),
        limit_edge("joint acceleration", (0, 1, 2), np.full(4, -0.2), np.full(4, 0.1), np.ones(4), 5.0),
        knee_edge(0, 5.0),
        knee_edge(2, 5.0),
        obstacle_edge(0, MODEL, 0.2, hold=0.3, hold_x=0.2),
        obstacle_edge(2, MODEL, 0.5, hold=0.3, hold_x=0.2, gain=4.0),
        foothold_edge(0, MODEL, (0.1, 0.1), 2.0),
        foothold_edge(1, MODEL, (0.1, 0.2), 2.0),
        residual_edge(BASE.frames, 0, 1),
        residual_edge(BASE.frames, 1, 2),
        low_between(hold=0.3, hold_x=0.2, gain=3.0),
        edge_between(obstacle_edge(8, MODEL, 0.4, hold=0.3), (1, 2), 0.75, OFFSET),
        edge_between(clear_edge(8, MODEL, 0.9, 3.0), (0, 2), 0.5, OFFSET),
        rate_edge(BASE.frames, OFFSET, 40.0),
        rate_edge(BASE.frames, OFFSET, 40.0, given=0.75),
        knee_edge(1, 5.0),
        obstacle_edge(1, MODEL, 0.9, hold=0.3, hold_x=0.2, gain=2.0),
        foothold_edge(2, MODEL, (0.39, 0.1), 255.0),
        shank_edge(2, math.pi / 2, 7.0),
    ]


@pytest.mark.parametrize("state", range(5))
@pytest.mark.parametrize("fixed", [(), (0,), (0, 2)])
def test_a_stack_is_the_sum_of_its_edges(state, fixed):
    edges, values = edges_of_every_kind(), values_of(STATES[state])
    known = {n: STATES[state][n] for n in fixed}
    stack = stacked_factor(edges, known)
    assert sorted(map(frame_of_key, stack.keys())) == [n for n in range(3) if n not in fixed]
    assert stack.error(values) == pytest.approx(sum(edge.factor().error(values) for edge in edges))
    assert ggo.check_jacobian(stack, values) < 1e-6


def test_a_stack_names_the_edge_that_is_not_finite():
    stack = stacked_factor(edges_of_every_kind(), {})
    frames = STATES[0].copy()
    frames[1, 3] = np.nan
    with pytest.raises(ggo.GraphError, match=r"residual edge at frame 0: error .* not finite"):
        stack.unwhitenedError(values_of(frames))
    steep = stacked_factor([obstacle_edge(1, MODEL, 0.9, gamma=1e4)], {})
    with pytest.raises(ggo.GraphError, match="obstacle edge at frame 1: OverflowError"):
        steep.unwhitenedError(values_of(STATES[0]))
