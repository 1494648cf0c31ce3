"""The leg edge: its distance by shapely, its Jacobian by central differences, many at once as one by one."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.collision import SEGMENTS
from ggo_factors.factors.leg import LegFunction, nearest

MODEL = ggo.LegModel(0.39, 0.42, foot=ggo.Foot(0.08, 0.05, 0.15), thigh_radius=0.06, shank_radius=0.05)
STEP = 1e-6
numbers = st.floats(-0.6, 0.6)


@settings(max_examples=300)
@given(start=st.tuples(numbers, numbers), run=st.tuples(numbers, numbers), left=numbers, width=st.floats(1e-3, 0.5))
def test_distance_and_place_against_shapely(start, run, left, width):
    first, last = np.array(start), np.array(start) + run
    block = shapely.box(left, -9.0, left + width, 0.0)
    (distance,), (share,), (direction,) = nearest(first[None], last[None], np.array([[left, left + width, 0.0]]))
    place = shapely.Point(first + share * (last - first))
    outside = shapely.LineString([first, last]).distance(block)
    if outside > 0.0:
        assert distance == pytest.approx(outside, abs=1e-12)
        assert place.distance(block) == pytest.approx(outside, abs=1e-9)
        assert np.hypot(*direction) == pytest.approx(1.0)
        return
    along = shapely.points(first + np.linspace(0.0, 1.0, 500)[:, None] * (last - first))
    depth = np.where(shapely.contains(block, along), shapely.distance(block.exterior, along), 0.0).max()
    assert -distance == pytest.approx(depth, abs=2e-3)
    assert place.distance(block) == pytest.approx(0.0, abs=1e-9)
    assert place.distance(block.exterior) == pytest.approx(-distance, abs=1e-9)


def random_cases(segment, count=400):
    """Poses with a block near a point of the segment or beside it, its corner or a face, and how far it must be off."""
    rng = np.random.default_rng(segment)
    for _ in range(count):
        frame = rng.uniform(-1.5, 1.5, 4)
        ends = MODEL.joints(frame)[segment : segment + 2]
        x, y = ends[0] + rng.uniform(-0.2, 1.2) * (ends[1] - ends[0]) + rng.normal(0.0, 0.05, 2)
        width = rng.uniform(0.005, 0.3)
        left = x - rng.choice([0.0, rng.uniform(0.0, width), width])
        block = (left, left + width, y + rng.choice([0.0, rng.uniform(0.0, 0.3)]))
        yield frame, LegFunction(MODEL, segment, block, rng.choice([0.01, 0.06, 0.5]), rng.choice([0.0, 0.1, 0.3]))


@pytest.mark.parametrize("segment", range(4), ids=SEGMENTS[:4])
def test_jacobian_against_central_differences(segment):
    seen = {"off": 0, "outside": 0, "inside": 0}
    for frame, function in random_cases(segment):
        (error,), (block,) = function(frame, True)
        seen["off" if error == 0.0 else "outside" if error < function.far else "inside"] += 1
        ahead, behind = (
            np.array([function(frame + sign * STEP * axis, False)[0][0] for axis in np.eye(4)]) for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(block[0], (ahead - behind) / (2.0 * STEP), atol=1e-6)
    assert min(seen.values()) > 30, seen


@pytest.mark.parametrize("segment", range(4), ids=SEGMENTS[:4])
def test_the_hinge_begins_at_the_distance(segment):
    for frame, near in random_cases(segment, 50):
        reach = LegFunction(MODEL, segment, near.block, 5.0, near.bare)
        distance = 5.0 - float(reach(frame, False)[0][0])
        above, below = (
            LegFunction(MODEL, segment, near.block, distance + by, near.bare)(frame, True) for by in (1e-9, -1e-9)
        )
        assert 0.0 < above[0][0] < 2e-9
        np.testing.assert_array_equal(above[1][0], reach(frame, True)[1][0])
        assert below[0][0] == 0.0
        assert not below[1][0].any()


def test_many_at_once_are_as_one_by_one():
    cases = [case for segment in range(4) for case in random_cases(segment, 50)]
    frames, functions = np.array([frame for frame, _ in cases]), [function for _, function in cases]
    errors, blocks = LegFunction.together(functions)(frames, True)
    assert errors.shape == (200, 1)
    assert blocks.shape == (200, 1, 4)
    for (frame, function), error, block in zip(cases, errors, blocks, strict=True):
        alone, (jacobian,) = function(frame, True)
        np.testing.assert_allclose(error, alone, atol=1e-15)
        np.testing.assert_allclose(block, jacobian, atol=1e-15)
