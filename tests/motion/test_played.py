"""The trajectory between frames, against SciPy's cubic splines and dense grids."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline, PPoly

import ggo_factors as ggo
from ggo_factors.motion.played import Played


def played(seed, count, rests=(False, False)):
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.004, 0.03, count - 1))])
    return Played(times, rng.standard_normal((count, 4)).cumsum(axis=0) * 0.02, *rests)


def spline_of(path):
    """SciPy's spline with the same ends: at rest, or with the acceleration of the frame beside it."""
    times, positions = path.times, path.positions
    if path.starts_at_rest and path.ends_at_rest:
        return CubicSpline(times, positions, bc_type="clamped")
    # An end whose acceleration is that of its neighbour: solved for by trying two values, since all is linear in it.
    made = []
    for first, last in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)):
        starts = (1, np.zeros(4)) if path.starts_at_rest else (2, np.full(4, first))
        ends = (1, np.zeros(4)) if path.ends_at_rest else (2, np.full(4, last))
        made.append(CubicSpline(times, positions, bc_type=(starts, ends)))
    bends = np.stack([spline(times, 2) for spline in made])  # (3, k, 4)
    coefficients = np.empty_like(made[0].c)
    for joint in range(4):
        own = bends[:, :, joint]
        free = [n for n, rests in enumerate((path.starts_at_rest, path.ends_at_rest)) if not rests]
        at = {0: (0, 1), 1: (-1, -2)}
        gaps = np.array([[own[k][at[n][0]] - own[k][at[n][1]] for k in range(3)] for n in free])
        share = np.linalg.solve(np.stack([gaps[:, n + 1] - gaps[:, 0] for n in free], -1), -gaps[:, 0])
        coefficients[:, :, joint] = made[0].c[:, :, joint]
        for n, x in zip(free, share, strict=True):
            coefficients[:, :, joint] += x * (made[n + 1].c - made[0].c)[:, :, joint]
    return PPoly(coefficients, times)


@pytest.mark.parametrize("rests", [(True, True), (True, False), (False, True), (False, False)])
@given(seed=st.integers(0, 10**6), count=st.integers(4, 40))
@settings(max_examples=25)
def test_the_spline_of_scipy(rests, seed, count):
    path = played(seed, count, rests)
    same, grid = spline_of(path), np.linspace(0.0, path.times[-1], 331)
    for order, own in enumerate(path.at(grid)):
        other = same(grid, order)
        np.testing.assert_allclose(own, other, rtol=0.0, atol=1e-8 * np.abs(other).max())
    np.testing.assert_allclose(path.velocities, same(path.times, 1), atol=1e-8 * np.abs(path.velocities).max())
    np.testing.assert_allclose(path.accelerations, same(path.times, 2), atol=1e-8 * np.abs(path.accelerations).max())


@given(seed=st.integers(0, 10**6), count=st.integers(3, 30), rests=st.tuples(st.booleans(), st.booleans()))
@settings(max_examples=40)
def test_peaks_are_exact(seed, count, rests):
    path = played(seed, count, rests)
    for n, (start, end) in enumerate(zip(path.times[:-1], path.times[1:], strict=True)):
        _, speeds, bends = path.at(np.linspace(start, end, 401)[:-1])
        fastest, bent = np.abs(speeds).max(axis=0), np.abs(bends).max(axis=0)
        # A grid of 400 misses a peak by up to an eighth of its width squared times the curvature.
        missed = np.abs(np.diff(path.accelerations[n : n + 2], axis=0)[0]) * (end - start) / 400.0
        assert (np.abs(path.fastest[n]) >= fastest - 1e-9).all()
        assert (np.abs(path.fastest[n]) <= fastest + missed + bent * (end - start) / 400.0 + 1e-9).all()
        assert (np.abs(path.accelerations[n : n + 2]).max(axis=0) >= bent - 1e-6).all()


@given(seed=st.integers(0, 10**6), count=st.integers(2, 20))
@settings(max_examples=25)
def test_it_rests_where_it_says(seed, count):
    path = played(seed, count, (True, True))
    if count > 2:
        assert not path.velocities[[0, -1]].any()
        assert not path.at(path.times[[0, -1]])[1].any()
    positions, _, _ = path.at(path.times)
    np.testing.assert_allclose(positions, path.positions, atol=1e-12)


def test_two_frames_are_joined_by_a_line():
    path = Played(np.array([0.0, 0.5]), np.array([[0.0, 1.0, 2.0, 3.0], [1.0, 1.0, 0.0, 4.0]]))
    positions, speeds, bends = path.at(np.array([0.0, 0.25, 0.5]))
    np.testing.assert_allclose(positions, [[0.0, 1.0, 2.0, 3.0], [0.5, 1.0, 1.0, 3.5], [1.0, 1.0, 0.0, 4.0]])
    np.testing.assert_allclose(speeds, [[2.0, 0.0, -4.0, 2.0]] * 3)
    assert not bends.any()


def test_a_cubic_is_played_as_it_is():
    # Its acceleration at the ends is not that of their neighbours: a parabola's is.
    times = np.cumsum([0.0, 0.1, 0.2, 0.05, 0.3])
    path = Played(times, np.stack([times**2, 3.0 - times, 0.5 * times**2 + times, 0.0 * times], -1))
    grid = np.linspace(0.0, times[-1], 50)
    positions, speeds, bends = path.at(grid)
    np.testing.assert_allclose(positions[:, 0], grid**2, atol=1e-13)
    np.testing.assert_allclose(speeds[:, 0], 2.0 * grid, atol=1e-12)
    np.testing.assert_allclose(bends, np.tile([2.0, 0.0, 1.0, 0.0], (50, 1)), atol=1e-11)


def test_joint_speeds_of_the_base_gait():
    base = ggo.paper_base_gait(201)
    path = base.played
    time = np.linspace(0.1, 0.4, 300)
    fine = ggo.paper_base_gait(20001)
    truth = CubicSpline(fine.times, fine.frames)
    np.testing.assert_allclose(path.at(time)[1], truth(time, 1), atol=1e-3)
    np.testing.assert_allclose(path.at(time)[2], truth(time, 2), atol=0.05)
