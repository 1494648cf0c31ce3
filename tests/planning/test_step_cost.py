"""Costs of steps whose graphs are not solved, against dense linear algebra and solved graphs."""

import math

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.motion.gait import swap_roles
from ggo_factors.planning.postures import postures
from ggo_factors.planning.step_cost import (
    CROUCH,
    CROUCH_GAIN,
    FREE,
    HOME,
    Room,
    StepCosts,
    blocks_on,
    bridge,
    roof_of,
)

BASE = ggo.paper_base_gait()
MODEL = ggo.LegModel(0.39, 0.39)
FOOT = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.05, 0.12))
LEVEL = ggo.Terrain.level(3.0)
SMOOTHNESS = 100.0
START = BASE.frames[:1]
ORIGIN = np.zeros(1)


def costs_on(terrain, model=MODEL):
    return StepCosts(BASE, model, SMOOTHNESS, roof_of(terrain, model), blocks_on(terrain))


def landing_at(x, y=0.0):
    return postures(MODEL, BASE.frames[-1], np.array([[x, y]]))


def precision_of(motions, smoothness):
    """The information of all first- and second-order residual edges, shape (m, m)."""
    first = np.diff(np.eye(motions + 1), axis=0)
    second = np.diff(np.eye(motions + 1), 2, axis=0)
    return first.T @ first + smoothness * second.T @ second


@pytest.mark.parametrize("motions", [4, 5, 20, 50])
@pytest.mark.parametrize("smoothness", [1e-3, 1.0, 100.0, 1e4])
def test_a_bridge_is_what_dense_algebra_makes_of_its_edges(motions, smoothness):
    stiffness, weights, variances, root = bridge(motions, smoothness)
    whole, ends = precision_of(motions, smoothness), [0, 1, motions - 1, motions]
    inner = list(range(2, motions - 1))
    solve = np.linalg.solve(whole[np.ix_(inner, inner)], whole[np.ix_(inner, ends)])
    given = whole[np.ix_(ends, ends)] - whole[np.ix_(ends, inner)] @ solve
    moved = np.array([0.0, 0.0, 1.0, 1.0])
    assert stiffness == pytest.approx(moved @ given @ moved, rel=1e-8)
    np.testing.assert_allclose(weights[inner], -solve @ moved, atol=1e-8)
    np.testing.assert_array_equal(weights[ends], moved)
    np.testing.assert_allclose(variances[inner], np.diag(np.linalg.inv(whole[np.ix_(inner, inner)])), rtol=1e-6)
    assert not variances[ends].any()
    outer = np.array([[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.0]])
    np.testing.assert_allclose(root.T @ root + outer.T @ outer, given, rtol=1e-7, atol=1e-8 * np.abs(given).max())


@pytest.mark.parametrize("motions", [1, 2, 3, 17])
def test_without_smoothness_a_bridge_is_a_straight_line(motions):
    stiffness, weights, variances, root = bridge(motions, 0.0)
    whole, inner = precision_of(motions, 0.0), list(range(1, motions))
    assert stiffness == pytest.approx(1.0 / motions)
    np.testing.assert_allclose(weights, np.linspace(0.0, 1.0, motions + 1))
    np.testing.assert_allclose(variances[inner], np.diag(np.linalg.inv(whole[np.ix_(inner, inner)])))
    assert float(((root @ [0.0, 0.0, 1.0, 1.0]) ** 2).sum()) == pytest.approx(stiffness)


@pytest.mark.parametrize("length", [0.35, 0.4, 0.45, 0.5, 0.6, 0.7])
def test_level_steps_cost_what_their_graphs_do(length):
    made = ggo.step_over(BASE, [], foothold=(length, 0.0)).error_history[-1]
    costs, ends = costs_on(LEVEL), landing_at(length)
    # HOME comes on top of what its graph costs; the 1.5e-5 is what the graph of the base gait's own step costs.
    assert costs.of(START, ends)[0] / (1.0 + HOME) == pytest.approx(made, rel=0.10, abs=1.5e-5)


def test_the_base_gait_s_own_step_costs_nothing_and_what_cannot_be_is_infinite():
    costs = costs_on(LEVEL)
    ends = np.concatenate([BASE.frames[-1:], np.full((1, 4), np.nan), landing_at(1.3), landing_at(0.4)])
    found = costs.of(np.repeat(START, 4, axis=0), ends)
    assert found[0] == 0.0
    assert np.isinf(found[1:3]).all()
    assert 0.0 < found[3] < 1e-3


def test_a_first_motion_that_moves_otherwise_costs_more():
    costs, ends = costs_on(LEVEL), landing_at(0.5)
    assert costs.of(START, ends, leaves=np.zeros(4))[0] == pytest.approx(costs.of(START, ends)[0])
    assert costs.of(START, ends, leaves=np.full(4, 0.02))[0] > costs.of(START, ends)[0]


@pytest.mark.parametrize("height", [0.05, 0.10, 0.20])
@pytest.mark.parametrize("near", [0.10, 0.15, 0.25])
def test_lifts_cost_about_what_solved_graphs_do(height, near):
    box = ggo.Obstacle(near, near + 0.05, height)
    made = ggo.step_over(BASE, [box], foothold=(0.45, 0.0)).error_history[-1]
    costs, ends = costs_on(LEVEL.with_boxes(box)), landing_at(0.45)
    found = costs.of(START, ends) + costs.lifts(START, ends, ORIGIN, ORIGIN)
    # Too dear, by more the higher the box.
    assert 1.0 < found[0] / made < 3.0


def test_nothing_is_lifted_over_nothing_nor_over_a_wall():
    ends = landing_at(0.45)
    assert costs_on(LEVEL).lifts(START, ends, ORIGIN, ORIGIN)[0] < 1e-3
    for height in (0.9, 1e3, 1e300):
        wall = costs_on(LEVEL.with_boxes(ggo.Obstacle(0.1, 0.2, height)))
        assert np.isinf(wall.lifts(START, ends, ORIGIN, ORIGIN)[0])


@pytest.mark.parametrize("model", [MODEL, FOOT], ids=["point", "sole"])
def test_the_roof_is_nowhere_lower_than_what_it_covers(model):
    terrain = ggo.Terrain.level(0.8) + ggo.Terrain.stairs(2, riser=[0.1, -0.15], tread=0.4)
    terrain = (terrain + ggo.Terrain.ramp(0.6, 0.2)).with_boxes(
        ggo.Obstacle(0.3, 0.4, 0.12), ggo.Obstacle(1.0, 1.1, 0.05)
    )
    roof, foot = roof_of(terrain, model), model.foot
    for x in np.random.default_rng(0).uniform(-0.5, terrain.x_end, 300):
        low, high = x - 0.02, x + 0.03
        top, bare = (float(each[0]) for each in roof.over(np.array([low]), np.array([high])))
        dense = np.linspace(low - foot.heel, high + foot.toe, 101)
        ground = terrain.height_at(np.linspace(low, high, 101)).max()
        assert bare >= ground - 2e-3
        for box, over in zip(terrain.boxes, terrain.tops, strict=True):
            if ((dense > box.x_start) & (dense < box.x_end)).any():
                assert top >= over - 1e-9
        assert top >= bare


def test_an_uncertain_box_and_riser_count_for_more():
    sure = LEVEL.with_boxes(ggo.Obstacle(0.5, 0.6, 0.1))
    unsure = LEVEL.with_boxes(ggo.Obstacle(0.5, 0.6, 0.1, 0.01, 0.01))
    x = np.array([0.47])
    assert roof_of(sure, MODEL).over(x, x)[0] == 0.0
    assert roof_of(unsure, MODEL).over(x, x)[0] > 0.12
    ((low, high, top),) = blocks_on(unsure).tolist()
    assert low < 0.48
    assert high > 0.62
    assert top > 0.12
    kerb = [ggo.Terrain.level(1.0) + ggo.Terrain.level(1.0, rise=0.1, edge_std=std) for std in (0.0, 0.01)]
    lefts = [blocks_on(each)[0, 0] for each in kerb]
    assert lefts[0] == 1.0
    assert 0.95 < lefts[1] < 0.97


def test_a_shank_beside_a_box_may_lean_as_far_as_its_edge():
    terrain = LEVEL.with_boxes(ggo.Obstacle(0.6, 0.7, 0.2))
    room = Room(blocks_on(terrain), roof_of(terrain, MODEL), MODEL)
    back, forward = room.at(np.array([0.5, 0.8, 9.0]), 1.0)
    assert forward[0] == pytest.approx(math.atan(0.09 / 0.2))
    assert back[1] == pytest.approx(-math.atan(0.09 / 0.2))
    assert forward[1:] == pytest.approx(math.atan(FREE))
    assert back[[0, 2]] == pytest.approx([-math.atan(FREE), -math.atan(FREE)])


def test_to_climb_until_the_hip_is_low_over_the_own_foot_costs_more():
    costs = costs_on(LEVEL)
    ends = landing_at(0.5, 0.35)
    low = float(MODEL.hip_height(ends)[0] - MODEL.endpoint(ends)[0, 1])
    assert 0.45 * MODEL.reach < low < CROUCH * MODEL.reach
    assert costs.postures(START, ends)[0] >= 0.5 * CROUCH_GAIN * (CROUCH * MODEL.reach - low) ** 2 - 1e-12
    assert costs.postures(START, landing_at(0.5, 0.10))[0] == 0.0


def test_a_step_as_low_as_the_check_allows_is_one():
    """Down a riser of 0.4275 m, hip at 0.45 of the leg: the exhaustive search walks it."""
    starts = swap_roles(landing_at(0.375))
    ends = landing_at(0.625, -0.4275)
    assert 0.45 * MODEL.reach < MODEL.hip_height(ends)[0] < 0.455 * MODEL.reach
    assert np.isfinite(costs_on(LEVEL).postures(starts, ends)).all()
