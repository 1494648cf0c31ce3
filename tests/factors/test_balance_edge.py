"""Balance edges: their error against the ZMP worked out link by link, their Jacobians, and where they let go."""

from __future__ import annotations

import math

import gtsam
import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.factors import balance_edges as edges_at
from ggo_factors.factors import frame_key, stacked_factor
from ggo_factors.motion.zero_moment import LEAST_CARRIED, held_points, start_shift

LEGS = ggo.LegModel(0.45, 0.40, thigh_mass=9.0, shank_mass=4.0)
BASE = ggo.paper_base_gait(21)
WEIGHT = 26.0 * 9.81


def balance_edges(base, model, dt, gain, support=None):
    """Edges that hold the base gait's own ZMP, or keep it in a support."""
    held = held_points(model, base, dt, 0.0)
    places = np.stack([held, held], -1) if support is None else np.tile(support, (len(base) - 2, 1))
    return edges_at(model, dt, gain, places)


def values_of(frames):
    values = gtsam.Values()
    for number, frame in enumerate(frames):
        values.insert(frame_key(number), frame)
    return values


def pushed(frames, dt):
    """Moment about the supporting ankle and upward force of the ground on three frames, link by link."""
    moment = force = 0.0
    joints = LEGS.joints(frames)
    for link, mass in enumerate((4.0, 9.0, 9.0, 4.0)):
        (x0, y0), (x, y), (x2, y2) = (joints[:, link] + joints[:, link + 1]) / 2.0
        lift = mass * ((y0 - 2.0 * y + y2) / dt**2 + 9.81)
        moment += lift * x - mass * y * (x0 - 2.0 * x + x2) / dt**2
        force += lift
    return moment, force


def falling(share, dt):
    """Three frames in which the ground carries this share of the weight: both knees give way by so much."""

    def carried(bend):
        turned = np.array([0.2, 0.0, -0.2, 0.0]) + np.outer([1.0, 0.0, 1.0], [bend, 2.0 * bend, 0.0, 0.0])
        return turned, pushed(turned, dt)[1] / WEIGHT

    low, high = 0.0, 0.5
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if carried(middle)[1] > share else (low, middle)
    return carried(low)[0]


@pytest.mark.parametrize("dt", [0.01, 0.05])
def test_the_error_is_the_way_to_the_base_gaits_zmp_times_the_share_carried(dt):
    bent = BASE.frames + np.random.default_rng(1).normal(0.0, 0.002, BASE.frames.shape)
    edges = balance_edges(BASE.frames, LEGS, dt, 1.0)
    assert edges
    for edge in edges:
        (moment, force), (held, carried) = (pushed(each[list(edge.frames)], dt) for each in (bent, BASE.frames))
        by_hand = (moment / force - held / carried) * force / WEIGHT
        assert edge.errors(bent) == pytest.approx([by_hand], abs=1e-9)
        assert edge.errors(BASE.frames) == pytest.approx([0.0], abs=1e-12)


def test_every_inner_frame_has_an_edge_but_those_that_nearly_fall():
    slow = balance_edges(BASE.frames, LEGS, 0.05, 1.0)
    assert [edge.frames for edge in slow] == [(n, n + 1, n + 2) for n in range(19)]
    dt = 0.016
    carried = [pushed(BASE.frames[n : n + 3], dt)[1] / WEIGHT for n in range(19)]
    kept = [n for n in range(19) if carried[n] >= LEAST_CARRIED]
    assert 0 < len(kept) < 19
    assert [edge.frames[0] for edge in balance_edges(BASE.frames, LEGS, dt, 1.0)] == kept
    # A support is there, however little it carries.
    assert len(balance_edges(BASE.frames, LEGS, dt, 1.0, (-0.1, 0.2))) == 19


@pytest.mark.parametrize("share", [0.5, 1e-3, 0.0, -1e-3, -0.5])
@pytest.mark.parametrize("support", [None, (-0.05, 0.15)])
def test_jacobian_where_the_ground_carries_next_to_nothing(share, support):
    dt = 0.05
    frames = falling(share, dt)
    assert pushed(frames, dt)[1] / WEIGHT == pytest.approx(share, abs=1e-9)
    (edge,) = balance_edges(BASE.frames[:3], LEGS, dt, 1.0, support)
    assert ggo.check_jacobian(edge.factor(), values_of(frames)) < 1e-6
    assert abs(edge.errors(frames)[0]) < 2.0


def test_a_support_costs_nothing_inside_and_the_way_to_its_nearer_end_outside():
    dt, frames = 0.05, BASE.frames[:3]
    moment, force = pushed(frames, dt)
    point, share = moment / force, force / WEIGHT
    for support, way in (
        ((point - 0.1, point + 0.1), 0.0),
        ((point + 0.02, point + 0.1), -0.02),
        ((point - 0.3, point - 0.01), 0.01),
    ):
        (edge,) = balance_edges(frames, LEGS, dt, 1.0, support)
        assert edge.errors(frames) == pytest.approx([way * share], abs=1e-12)


def test_a_stack_is_the_sum_of_its_edges_also_beside_fixed_frames():
    rng, dt = np.random.default_rng(3), 0.03
    bent = BASE.frames + rng.normal(0.0, 0.05, BASE.frames.shape)
    edges = [
        *balance_edges(BASE.frames, LEGS, dt, 2.0)[:12],
        *balance_edges(BASE.frames, LEGS, dt, 5.0, (-0.1, 0.1))[:12],
    ]
    fixed = {0: bent[0], 1: bent[1]}
    stack, values = stacked_factor(edges, fixed), values_of(bent)
    assert stack.error(values) == pytest.approx(sum(edge.factor().error(values) for edge in edges))
    assert ggo.check_jacobian(stack, values) < 1e-6
    gradients = gtsam.GaussianFactorGraph(), gtsam.GaussianFactorGraph()
    gradients[0].add(stack.linearize(values))
    for edge in edges:
        gradients[1].add(edge.factor().linearize(values))
    ours, theirs = (each.gradientAtZero() for each in gradients)
    for n in range(2, 14):
        np.testing.assert_allclose(ours.at(frame_key(n)), theirs.at(frame_key(n)), atol=1e-9)


def test_another_start_moves_the_places_and_the_shift_fades_as_a_pendulum_falls():
    dt, base = 0.05, BASE.frames
    start = base[0] + np.array([0.1, 0.05, 0.02, -0.03])
    shift = start_shift(LEGS, base, dt, start)
    moment, force = pushed(base[:3] + start - base[0], dt)
    own = held_points(LEGS, base, dt, 0.0)
    assert shift == pytest.approx(moment / force - own[0])
    assert abs(shift) > 0.03
    moved = held_points(LEGS, base, dt, shift) - own
    np.testing.assert_allclose(moved, shift * np.exp(-dt * np.arange(19) / math.sqrt(0.85 / 9.81)))
    np.testing.assert_allclose(held_points(LEGS, base[5:], dt, shift, 5 * dt), (moved + own)[5:])
    assert start_shift(LEGS, base, dt, base[0]) == 0.0
    assert start_shift(LEGS, base[:2], dt, start) == 0.0
