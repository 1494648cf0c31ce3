"""The bone edge: its distances by shapely, its Jacobian by central differences, the way out of a thin box."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.check.leg_collision import SEGMENTS
from ggo_factors.factors.bone import ROWS, BoneFunction, distances, way_out
from ggo_factors.factors.leg import SWING_SHANK

MODEL = ggo.LegModel(0.39, 0.42)
STEP = 1e-6
numbers = st.floats(-0.6, 0.6)


@settings(max_examples=300)
@given(start=st.tuples(numbers, numbers), run=st.tuples(numbers, numbers), left=numbers, width=st.floats(1e-3, 0.5))
def test_distances_and_the_way_out_against_shapely(start, run, left, width):
    assume(np.hypot(*run) > 1e-3)
    end = np.array(start) + run
    line, block = shapely.LineString([start, end]), shapely.box(left, -9.0, left + width, 0.0)
    gap, from_x, from_y, to_x, to_y = way_out((*start, *end.tolist()), (left, left + width, 0.0))
    apart = line.distance(block)
    if gap > 0.0:
        assert gap <= apart + 1e-12
        found = distances((*start, *end.tolist()), (left, left + width, 0.0))
        assert min(each[0] for each in found) == pytest.approx(apart, abs=1e-12)
        return
    assert apart < 1e-12
    # Moved by the way out, and a little more, the axis is out; by a little less it is not.
    along = np.array([from_x + to_x, from_y + to_y])
    np.testing.assert_allclose(np.hypot(*along), 1.0)
    for share, inside in ((1.001, False), (0.999, True)):
        moved = shapely.affinity.translate(line, *(-gap * share + np.sign(share - 1.0) * 1e-9) * along)
        assert block.buffer(0.0).intersects(moved) == inside or abs(gap) < 1e-8


def random_cases(segment, count=200):
    """Poses with a block near a point of the segment, and how far it must be off."""
    rng = np.random.default_rng(segment)
    for _ in range(count):
        frame = rng.uniform(-1.5, 1.5, 4)
        ends = MODEL.joints(frame)[segment : segment + 2]
        x, y = ends[0] + rng.uniform(-0.2, 1.2) * (ends[1] - ends[0]) + rng.normal(0.0, 0.05, 2)
        width = rng.uniform(0.005, 0.3)
        left = x - rng.choice([0.0, rng.uniform(0.0, width), width])
        block = (left, left + width, y + rng.choice([0.0, rng.uniform(0.0, 0.3)]))
        bare = rng.choice([0.0, 0.1, 0.3]) if segment in (0, SWING_SHANK) else 0.0
        yield frame, BoneFunction(MODEL, segment, block, rng.choice([0.005, 0.06, 0.5]), bare)


@pytest.mark.parametrize("segment", range(4), ids=SEGMENTS[:4])
def test_jacobian_against_central_differences(segment):
    active = np.zeros(ROWS, dtype=int)
    for frame, function in random_cases(segment):
        error, (block,) = function(frame, True)
        active += error > 0.0
        ahead, behind = (
            np.stack([function(frame + sign * STEP * axis, False)[0] for axis in np.eye(4)], -1) for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(block, (ahead - behind) / (2.0 * STEP), atol=1e-5)
    assert (active > 10).all(), active


def test_many_at_once_are_as_one_by_one():
    cases = [case for segment in range(4) for case in random_cases(segment, 20)]
    frames, functions = np.array([frame for frame, _ in cases]), [function for _, function in cases]
    errors, blocks = BoneFunction.together(functions)(frames, True)
    for (frame, function), error, block in zip(cases, errors, blocks, strict=True):
        alone, (jacobian,) = function(frame, True)
        np.testing.assert_array_equal(error, alone)
        np.testing.assert_array_equal(block, jacobian)


def test_a_constraint_aims_past_its_target():
    frame, near = np.zeros(4), BoneFunction(MODEL, SWING_SHANK, (-0.24, -0.04, 0.1), 0.06)
    shifted, _ = replace(near, shift=(0.0, 0.2, 0.0, 0.4))(frame, False)
    error, _ = near(frame, False)
    np.testing.assert_allclose(error, [0.0, 0.02, 0.0, 0.02], atol=1e-12)  # the ankle, and the corner beside it
    np.testing.assert_allclose(shifted - error, [0.0, 0.2, 0.0, 0.4], atol=1e-12)


def test_out_of_a_thin_wall_is_over_it_and_not_through_it():
    # A swinging shank over a wall 2 mm thin, of which it cuts 30 mm: the way out is upright on the shank.
    frame = np.array([0.0, 0.0, 0.9, 0.4])
    start, end = MODEL.joints(frame)[SWING_SHANK : SWING_SHANK + 2]
    middle = (start + end) / 2.0
    wall = (middle[0] - 0.001, middle[0] + 0.001, middle[1] + 0.03)
    gap = way_out((*start.tolist(), *end.tolist()), wall)[0]
    lean = frame[2] - frame[3]
    assert gap == pytest.approx(-0.03 * np.sin(lean) - 0.001 * np.cos(lean), abs=1e-9)
