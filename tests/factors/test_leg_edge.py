"""The leg edge: its distance by shapely, its Jacobian by central differences, many at once as one by one."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.check.leg_collision import SEGMENTS
from ggo_factors.factors.leg import ROWS, SWING_SHANK, LegFunction, nearest

MODEL = ggo.LegModel(0.39, 0.42, foot=ggo.Foot(0.08, 0.05, 0.15), thigh_radius=0.06, shank_radius=0.05)
STEP = 1e-6
numbers = st.floats(-0.6, 0.6)


@example(start=(0.0, 0.0), run=(2.2e-309, 0.5), left=0.5, width=0.5)  # upright but for the last bit
@settings(max_examples=200)
@given(start=st.tuples(numbers, numbers), run=st.tuples(numbers, numbers), left=numbers, width=st.floats(1e-3, 0.5))
def test_distances_and_places_against_shapely(start, run, left, width):
    assume(np.hypot(*run) > 1e-6)  # shapely finds lines that are all but points infinitely far
    first, last = np.array(start), np.array(start) + run
    block = shapely.box(left, -9.0, left + width, 0.0)
    found = nearest(first[None], last[None], np.array([[left, left + width, 0.0]]))
    (distances,), (shares,), (directions,), (corner,) = found
    np.testing.assert_array_equal(shares[:2], [0.0, 1.0])
    for distance, share in zip(distances, shares, strict=True):
        place = shapely.Point(first + share * (last - first))
        assert place.distance(block) == pytest.approx(max(distance, 0.0), abs=1e-12)
        if distance < 0.0:
            assert place.distance(block.exterior) == pytest.approx(-distance, abs=1e-12)
    line = shapely.LineString([first, last])
    corners = [shapely.Point(x, 0.0) for x in (left, left + width)]
    at_corner = shapely.Point(first + shares[2] * (last - first))
    assert shapely.Point(corner) in corners
    assert at_corner.distance(shapely.Point(corner)) == pytest.approx(line.distance(shapely.Point(corner)), abs=1e-9)
    outside = line.distance(block)
    if outside > 0.0:
        assert distances[:3].min() == pytest.approx(outside, abs=1e-12)
        np.testing.assert_allclose(np.hypot(*directions.T), 1.0)
        return
    along = shapely.points(first + np.linspace(0.0, 1.0, 500)[:, None] * (last - first))
    depth = np.where(shapely.contains(block, along), shapely.distance(block.exterior, along), 0.0).max()
    assert -distances.min() == -distances[3] == pytest.approx(depth, abs=2e-3)


def random_cases(segment, count=200):
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
    active = np.zeros(ROWS, dtype=int)
    for frame, function in random_cases(segment):
        error, (block,) = function(frame, True)
        active += error > 0.0
        ahead, behind = (
            np.stack([function(frame + sign * STEP * axis, False)[0] for axis in np.eye(4)], -1) for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(block, (ahead - behind) / (2.0 * STEP), atol=1e-6)
    assert (active > 10).all(), active
    assert (active < 190).all(), active


@pytest.mark.parametrize("segment", range(4), ids=SEGMENTS[:4])
def test_the_hinge_begins_at_the_distance(segment):
    for frame, near in random_cases(segment, 50):
        errors, (slopes,) = replace(near, far=5.0)(frame, True)
        for row, error in enumerate(errors[:3]):
            inside, outside = (replace(near, far=5.0 - error + by)(frame, True) for by in (1e-9, -1e-9))
            assert inside[0][row] == pytest.approx(1e-9, abs=1e-12)
            np.testing.assert_array_equal(inside[1][0][row], slopes[row])
            assert outside[0][row] == 0.0
            assert not outside[1][0][row].any()
        shifted, _ = replace(near, far=5.0, shift=(0.1, 0.2, 0.3, 9.0))(frame, False)
        np.testing.assert_allclose((shifted - errors)[:3], [0.1, 0.2, 0.3])
        assert shifted[3] > 8.0


def test_an_upright_shank_beside_a_block_stands_on_no_kink():
    # The swinging shank upright, ankle at (0, 0), 0.04 m beside a block 0.1 m high: leaning either way, one of its ends
    # of what is beside the block comes nearer, and the rows tell of both.
    block = (-0.24, -0.04, 0.1)
    upright = np.zeros(4)
    function = LegFunction(MODEL, SWING_SHANK, block, 0.06)
    error, (slopes,) = function(upright, True)
    np.testing.assert_allclose(error, [0.0, 0.02, 0.02, 0.0], atol=1e-12)
    for turn in (1e-3, -1e-3):
        step = np.array([0.0, 0.0, turn, turn])  # about the hip
        moved, _ = function(upright + step, False)
        np.testing.assert_allclose(moved, np.maximum(error + slopes @ step, 0.0), atol=1e-6)


def test_many_at_once_are_as_one_by_one():
    cases = [case for segment in range(4) for case in random_cases(segment, 50)]
    frames, functions = np.array([frame for frame, _ in cases]), [function for _, function in cases]
    errors, blocks = LegFunction.together(functions)(frames, True)
    assert errors.shape == (200, ROWS)
    assert blocks.shape == (200, ROWS, 4)
    for (frame, function), error, block in zip(cases, errors, blocks, strict=True):
        alone, (jacobian,) = function(frame, True)
        np.testing.assert_allclose(error, alone, atol=1e-15)
        np.testing.assert_allclose(block, jacobian, atol=1e-15)
