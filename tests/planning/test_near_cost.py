"""Near costs of steps, against dense linear algebra and solved graphs."""

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.graph.requests import MOTION_GAIN, POSTURE_GAIN
from ggo_factors.planning.near_cost import NearCosts, chain_of
from ggo_factors.planning.postures import postures
from ggo_factors.planning.step_cost import StepCosts, blocks_on, roof_of
from ggo_factors.procedures.steps import walker_of

BASE = ggo.paper_base_gait()
MODEL = ggo.LegModel(0.39, 0.39)
LEVEL = ggo.Terrain.level(3.0)
SMOOTHNESS = 100.0
LEAVES = walker_of(BASE, *[None] * 5, False, *[None] * 2).velocity_offset
"""How the base gait's first motion differs from its last: the walker moves so at the start."""


def cost_of(terrain, foothold, met=True, leaves=LEAVES, start=BASE.frames[0], base=BASE):
    """The near cost of a step from the origin."""
    rough = StepCosts(base, MODEL, SMOOTHNESS, roof_of(terrain, MODEL), blocks_on(terrain))
    ends = postures(MODEL, base.frames[-1], np.array([foothold]))
    (cost,) = NearCosts(rough).of(start[None], ends, np.zeros(1), np.array(leaves, ndmin=2), np.array([met]))
    return float(cost)


@pytest.mark.parametrize("motions", [4, 20, 50])
@pytest.mark.parametrize("smoothness", [0.0, 7.0, 100.0])
def test_a_chain_is_what_dense_algebra_makes_of_its_edges(motions, smoothness):
    rng = np.random.default_rng(motions)
    start, rate, end = rng.normal(size=3)
    first, second = np.diff(np.eye(motions + 1), axis=0), np.diff(np.eye(motions + 1), 2, axis=0)
    rows = [
        first,
        np.sqrt(smoothness) * second,
        np.sqrt(2.0 * smoothness) * first[:1],
        np.sqrt(MOTION_GAIN * motions) * first[-1:],
        np.sqrt(POSTURE_GAIN / motions) * np.eye(motions + 1)[-1:],
    ]
    wanted = [np.zeros(motions), np.zeros(motions - 1), [np.sqrt(2.0 * smoothness) * rate], [0.0]]
    wanted = np.concatenate([*wanted, [np.sqrt(POSTURE_GAIN / motions) * end]])
    matrix = np.concatenate(rows)
    free, *_ = np.linalg.lstsq(matrix[:, 1:], wanted - matrix[:, 0] * start, rcond=None)
    frames = np.concatenate([[start], free])
    chain, given = chain_of(motions, smoothness), np.array([start, rate, end])
    assert chain.weights @ given == pytest.approx(frames, abs=1e-7)
    assert given @ chain.quadratic @ given == pytest.approx(((matrix @ frames - wanted) ** 2).sum(), abs=1e-7)
    inverse = np.linalg.inv(matrix[:, 1:].T @ matrix[:, 1:])
    assert chain.covariance[1:, 1:] == pytest.approx(inverse, rel=1e-6, abs=1e-9)
    assert not chain.covariance[0].any()


@pytest.mark.parametrize("terrain", [LEVEL, LEVEL.with_boxes(ggo.Obstacle(0.2, 0.25, 0.05))])
def test_a_base_gait_of_one_motion_has_no_frame_that_anything_meets(terrain):
    """Plans by such a gait ended in an error of NumPy."""
    base = BASE.resampled(2)
    free = cost_of(LEVEL, (0.45, 0.0), met=False, base=base)
    assert 0.0 < free == pytest.approx(cost_of(terrain, (0.45, 0.0), base=base), rel=1e-6)
    rough = StepCosts(base, MODEL, SMOOTHNESS, roof_of(terrain, MODEL), blocks_on(terrain))
    assert rough.lifts(base.frames[:1], base.frames[1:], np.zeros(1), np.zeros(1)).tolist() == [0.0]


def test_the_base_gait_s_own_step_costs_nothing():
    assert cost_of(LEVEL, MODEL.endpoint(BASE.frames[-1]), met=False, leaves=np.zeros(4)) < 1e-6


@pytest.mark.parametrize("length", [0.25, 0.30, 0.45, 0.50, 0.55, 0.60, 0.70])
def test_level_steps_cost_what_solved_graphs_do(length):
    (made,) = (step.error_history[-1] for step in ggo.walk(BASE, [ggo.Step(foothold=(length, 0.0))]).steps)
    assert cost_of(LEVEL, (length, 0.0)) == pytest.approx(made, rel=0.25)


@pytest.mark.parametrize("height", [0.05, 0.10, 0.20])
@pytest.mark.parametrize("near", [0.10, 0.15, 0.25])
def test_lifts_cost_nearly_what_solved_graphs_do(height, near):
    box = ggo.Obstacle(near, near + 0.05, height)
    made = ggo.step_over(BASE, [box], foothold=(0.45, 0.0)).error_history[-1]
    assert 0.6 < cost_of(LEVEL.with_boxes(box), (0.45, 0.0)) / made < 1.5


def test_a_higher_box_costs_more_and_a_wall_has_no_cost():
    costs = [cost_of(LEVEL.with_boxes(ggo.Obstacle(0.1, 0.2, height)), (0.45, 0.0)) for height in (0.01, 0.1, 0.2, 0.3)]
    assert costs == sorted(costs)
    assert costs[0] == pytest.approx(cost_of(LEVEL, (0.45, 0.0)), rel=0.1)
    for height in (0.9, 1e3, 1e300):
        assert np.isinf(cost_of(LEVEL.with_boxes(ggo.Obstacle(0.1, 0.2, height)), (0.45, 0.0)))


@pytest.mark.parametrize(("foothold", "more"), [((0.39, 0.0), 1.0), ((0.33, 0.07), 1.02), ((0.39, 0.07), 1.02)])
def test_a_knee_that_would_bend_backwards_costs(foothold, more, monkeypatch):
    held = cost_of(LEVEL, foothold, met=False)
    monkeypatch.setattr(NearCosts, "_hold_knees", lambda *_: False)
    free = cost_of(LEVEL, foothold, met=False)
    assert held == free if more == 1.0 else held > more * free


def test_who_moves_otherwise_at_the_start_pays_for_it():
    foothold = MODEL.endpoint(BASE.frames[-1])
    assert cost_of(LEVEL, foothold, met=False, leaves=LEAVES + 0.02) > cost_of(LEVEL, foothold, met=False) + 1e-4
