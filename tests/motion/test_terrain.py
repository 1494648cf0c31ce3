"""Obstacles, gaps and stairs, and what a foot's size makes of them."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import ggo_factors as ggo

FOOT = ggo.Foot(ankle_height=0.08, heel=0.05, toe=0.15)


def test_obstacle_for_the_ankle_is_longer_by_the_foot():
    box = ggo.Obstacle(0.20, 0.25, 0.08).for_ankle(FOOT)
    assert (box.x_start, box.x_end, box.height) == pytest.approx((0.05, 0.30, 0.08))


@pytest.mark.parametrize("numbers", [(0.3, 0.2, 0.1), (0.2, 0.2, 0.1), (0.2, 0.3, -0.1), (np.nan, 0.3, 0.1)])
def test_obstacle_is_checked(numbers):
    with pytest.raises(ggo.InputError, match=r"x_end|height|x_start"):
        ggo.Obstacle(*numbers)


def test_stairs_seen_from_the_next_tread():
    ground = ggo.stair_ground(0.29, 0.39, [0.10, 0.14])
    np.testing.assert_allclose(ground.height_at([0.0, 0.28, 0.29, 0.5, 0.7]), [0, 0, 0.10, 0.10, 0.24])
    np.testing.assert_allclose(ground.shifted(0.39, 0.10).height_at([-0.2, 0.0, 0.30]), [-0.10, 0.0, 0.14])


def test_a_riser_counts_as_its_higher_side_both_ways():
    assert ggo.stair_ground(0.29, 0.39, [-0.10]).height_at(0.29) == 0.0
    assert ggo.stair_ground(0.29, 0.39, [0.10]).height_at(0.29) == 0.10


@given(
    edges=st.lists(st.floats(-1, 1), min_size=1, max_size=4, unique=True).map(sorted),
    seed=st.integers(0, 1000),
    x=st.floats(-1.5, 1.5),
)
def test_ground_for_the_ankle_is_the_highest_under_the_sole(edges, seed, x):
    heights = np.random.default_rng(seed).uniform(-0.3, 0.3, len(edges) + 1)
    ground = ggo.Ground(tuple(edges), tuple(heights))
    bounds = [-np.inf, *edges, np.inf]
    under = [
        height
        for height, low, high in zip(heights, bounds[:-1], bounds[1:], strict=True)
        if low <= x + FOOT.toe and high >= x - FOOT.heel
    ]
    widened = ground.for_ankle(FOOT)
    assume(min(abs(x - e) for e in widened.edges) > 1e-9)
    assert float(widened.height_at(x)) == max(under)


def test_ground_is_checked():
    with pytest.raises(ggo.InputError, match="1 edges need 2 heights, got 1"):
        ggo.Ground((0.3,), (0.0,))
    with pytest.raises(ggo.InputError, match="must ascend"):
        ggo.Ground((0.3, 0.2), (0.0, 0.1, 0.2))


def test_level_ground_may_lie_lower():
    np.testing.assert_array_equal(ggo.Ground(heights=(-0.2,)).height_at([[0.0, 3.0]]), [[-0.2, -0.2]])
