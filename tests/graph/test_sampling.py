"""Instants between the frames of a graph: where they are, and what an edge at one says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

import ggo_factors as ggo
from ggo_factors.factors import clear_edge
from ggo_factors.graph.sampling import Sampling

MODEL = ggo.LegModel(0.45, 0.40)


def sampling(count, fine):
    base = ggo.paper_base_gait(fine)
    return Sampling(base.resampled(count).frames, base.frames)


@given(st.integers(5, 30), st.integers(0, 60), st.integers(0, 2**32 - 1))
def test_an_edge_at_an_instant_is_asked_at_the_frame_there(count, more, seed):
    instants = sampling(count, count + more)
    frames = instants.base + np.random.default_rng(seed).uniform(-0.3, 0.3, (count, 4))
    at = instants.frames(frames)
    np.testing.assert_allclose(at[[0, -1]], frames[[0, -1]], atol=1e-15)
    for instant in range(len(at)):
        placed = clear_edge(instant, MODEL, 0.9, 2.0)
        edge = instants.edge(placed)
        assert (edge.name, edge.gain, edge.rows) == (placed.name, placed.gain, placed.rows)
        assert edge.frames == instants.neighbours(instant)
        place = instant * (count - 1) / (len(at) - 1)
        assert all(abs(n - place) < 1.0 for n in edge.frames)
        np.testing.assert_allclose(edge.errors(frames), placed.errors(at), atol=1e-12)
    assert instants.weight * (len(at) - 1) == pytest.approx(count - 1)


def test_the_offset_runs_straight_between_frames():
    instants = sampling(11, 41)
    frames = instants.base + np.linspace(0.0, 0.2, 11)[:, None] ** 2
    offset = instants.frames(frames) - instants.fine
    np.testing.assert_allclose(offset[:, 0], np.interp(np.arange(41) / 4, np.arange(11), np.linspace(0, 0.2, 11) ** 2))


def test_at_the_rate_of_the_graph_instants_are_its_frames():
    instants = sampling(11, 11)
    frames = np.random.default_rng(3).uniform(-0.3, 0.3, (11, 4))
    assert instants.frames(frames) is frames
    assert [instants.neighbours(n) for n in range(11)] == [(n,) for n in range(11)]
    assert np.flatnonzero(instants.held({0, 4, 10})).tolist() == [0, 4, 10]


def test_an_instant_is_held_where_both_its_neighbours_are():
    assert np.flatnonzero(sampling(11, 41).held({0, 1, 5, 10})).tolist() == [0, 1, 2, 3, 4, 20, 40]
    assert not sampling(11, 41).held(()).any()


@pytest.mark.parametrize("fine", [6, 7, 17, 160])
def test_cubics_between_frames_are_those_of_a_spline(fine):
    rng = np.random.default_rng(fine)
    base, high = rng.uniform(-1, 1, (5, 4)), rng.uniform(-1, 1, (fine, 4))
    offset = rng.uniform(-1, 1, (5, 4))
    spline = CubicSpline(np.arange(5), offset)
    instants = Sampling(base, high)
    made = instants.frames(base + offset) + instants.curved(spline(np.arange(5), 2))
    np.testing.assert_allclose(made, high + spline(np.linspace(0, 4, fine)), rtol=0, atol=1e-14)
