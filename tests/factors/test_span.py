"""Second-order residual edges: spans against the full chain, at any length, smoothness and sampling rate."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.factors.span import fill_frames, inner_weights, motion_edges, span_root, with_neighbours

OBSTACLES = {
    0: None,
    1: (0.20, 0.25, 0.08),
    2: (0.20, 0.25, 0.15),
    3: (0.12, 0.16, 0.08),
    4: (0.12, 0.16, 0.15),
    5: (-0.33, -0.29, 0.175),
}


def chain_cost(offsets, smoothness):
    """Half the sum of squares of first and second differences, written out."""
    first = sum(float(((b - a) ** 2).sum()) for a, b in pairwise(offsets))
    triples = zip(offsets, offsets[1:], offsets[2:], strict=False)
    return 0.5 * (first + smoothness * sum(float(((a - 2 * b + c) ** 2).sum()) for a, b, c in triples))


def dense_elimination(length, smoothness):
    """Information of the ends, and the inner frames by them, from all rows of the chain at once."""
    count = length + 3
    rows = [np.eye(count)[k + 1] - np.eye(count)[k] for k in range(1, length + 1)]
    second = [np.eye(count)[k - 1] - 2 * np.eye(count)[k] + np.eye(count)[k + 1] for k in range(1, length + 2)]
    matrix = np.array(rows + [np.sqrt(smoothness) * row for row in second])
    ends, inner = [0, 1, length + 1, length + 2], list(range(2, length + 1))
    triangle = np.linalg.qr(matrix[:, inner + ends], mode="r")
    k = len(inner)
    return triangle[k:, k:].T @ triangle[k:, k:], -np.linalg.solve(triangle[:k, :k], triangle[:k, k:])


@pytest.mark.parametrize("smoothness", [1e-3, 1.0, 100.0, 1e5])
@pytest.mark.parametrize("length", [1, 2, 3, 4, 5, 8, 48, 399])
def test_a_span_is_the_chain_with_its_inner_frames_eliminated(length, smoothness):
    information, weights = dense_elimination(length, smoothness)
    root = span_root(length, smoothness)
    assert root.shape == (3, 4)
    np.testing.assert_allclose(root.T @ root, information, atol=1e-11 * np.abs(information).max())
    np.testing.assert_allclose(inner_weights(length, smoothness), weights, atol=1e-9)
    np.testing.assert_allclose(inner_weights(length, smoothness).sum(axis=1), 1.0)


@settings(deadline=None, max_examples=60)
@given(
    keys=st.sets(st.integers(0, 29), max_size=8),
    smoothness=st.sampled_from([0.5, 30.0, 1e4]),
    seed=st.integers(0, 1000),
)
def test_edges_and_filled_frames_cost_what_the_chain_costs(keys, smoothness, seed):
    rng = np.random.default_rng(seed)
    base = rng.uniform(-1, 1, (30, 4))
    keyframes = with_neighbours(keys, 30)
    assert keys <= set(keyframes)
    frames = fill_frames(base, keyframes, rng.uniform(-1, 1, (len(keyframes), 4)), smoothness)
    edges = motion_edges(base, keyframes, smoothness)
    cost = sum(0.5 * edge.gain * float((edge.errors(frames) ** 2).sum()) for edge in edges)
    assert cost == pytest.approx(chain_cost(frames - base, smoothness), rel=1e-9)
    free = [n for n in range(30) if n not in keyframes]
    moved = frames.copy()
    moved[free] += rng.normal(0, 1e-3, (len(free), 4))
    assert chain_cost(moved - base, smoothness) >= cost * (1.0 - 1e-12)


def graph_with(base, case, smoothness, keyframes):
    graph = ggo.GaitGraph(base, keyframes=keyframes, smoothness=smoothness)
    graph.anchor(base.frames[0])
    graph.anchor(base.frames[1] + 0.001, frame=1)
    if OBSTACLES[case] is not None:
        graph.add_obstacle(ggo.Obstacle(*OBSTACLES[case]), hold=1.0)
    graph.end(foothold=(0.4875 if case == 0 else 0.39, 0.0), gain=5.0 * len(base))
    return graph


@pytest.mark.parametrize("case", OBSTACLES)
@pytest.mark.parametrize("smoothness", [25.0, 100.0])
def test_few_keyframes_find_the_full_second_order_graphs_optimum(case, smoothness):
    base = ggo.paper_base_gait()
    few, full = (graph_with(base, case, smoothness, keyframes).solve() for keyframes in ("auto", "all"))
    assert few.converged, few.reason
    assert full.converged, full.reason
    assert sum(few.costs.values()) == pytest.approx(sum(full.costs.values()), rel=1e-9)
    np.testing.assert_allclose(few.gait.frames, full.gait.frames, atol=1e-6)
    assert len(few.keyframes) < 20
    np.testing.assert_array_equal(few.gait.frames[:2], np.stack([base.frames[0], base.frames[1] + 0.001]))


def test_the_cost_families_are_those_of_the_frames():
    base = ggo.paper_base_gait()
    solution = graph_with(base, 2, 100.0, "auto").solve()
    offsets = solution.gait.frames - base.frames
    assert solution.costs["residual"] == pytest.approx(chain_cost(offsets, 0.0))
    assert solution.costs["residual"] + solution.costs["smoothness"] == pytest.approx(chain_cost(offsets, 100.0))
    assert solution.factor_graph.error(solution.values) == pytest.approx(sum(solution.costs.values()))


@pytest.mark.parametrize("frames", [2, 3, 4, 5])
def test_short_gaits(frames):
    base = ggo.paper_base_gait(frames)
    graph = ggo.GaitGraph(base, smoothness=10.0)
    graph.anchor(base.frames[0])
    graph.end(foothold=(0.41, 0.0), gain=100.0)
    solution = graph.solve()
    assert solution.converged
    full = ggo.GaitGraph(base, smoothness=10.0, keyframes="all")
    full.anchor(base.frames[0])
    full.end(foothold=(0.41, 0.0), gain=100.0)
    np.testing.assert_allclose(solution.gait.frames, full.solve().gait.frames, atol=1e-8)


def test_smoothness_is_checked():
    with pytest.raises(ggo.InputError, match="smoothness: -1 must be at least 0"):
        ggo.GaitGraph(ggo.paper_base_gait(), smoothness=-1.0)
