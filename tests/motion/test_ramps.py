"""Ground with ramps, against its geometry looked at point by point."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.motion.terrain import CELL, STEEPEST
from ggo_factors.walking.on_terrain import steps_on

FOOT = ggo.Foot(ankle_height=0.06, heel=0.05, toe=0.12)
SLOPES = st.floats(-STEEPEST, STEEPEST)


@st.composite
def grounds(draw):
    """Pieces of random slopes and heights, 0 at x = 0 and level ground around it half the time."""
    edges = sorted(draw(st.lists(st.integers(-20, 20), min_size=0, max_size=4, unique=True)))
    count = len(edges) + 1
    heights = draw(st.lists(st.floats(-0.2, 0.2), min_size=count, max_size=count))
    slopes = draw(st.lists(SLOPES, min_size=count, max_size=count))
    return ggo.Ground(tuple(edge / 20.0 + 0.013 for edge in edges), tuple(heights), tuple(slopes))


def sides(ground, x):
    """Heights of the pieces that meet at x, by their definition."""
    edges, slopes = ground.edges, ground.slopes or (0.0,) * len(ground.heights)
    found = []
    for n, (height, slope) in enumerate(zip(ground.heights, slopes, strict=True)):
        low = edges[n - 1] if n else -math.inf
        high = edges[n] if n < len(edges) else math.inf
        begins = edges[n - 1] if n else (edges[0] if edges else 0.0)
        if low <= x <= high:
            found.append(height + math.tan(slope) * (x - begins))
    return found


@given(grounds(), st.floats(-2.0, 2.0))
def test_height_is_that_of_the_higher_piece(ground, x):
    assert float(ground.height_at(x)) == pytest.approx(max(sides(ground, x)), abs=1e-12)
    for edge in ground.edges:
        assert float(ground.height_at(edge)) == pytest.approx(max(sides(ground, edge)), abs=1e-12)


@given(grounds(), st.floats(-2.0, 2.0), st.floats(-1.0, 1.0), st.floats(-2.0, 2.0))
def test_shifted_ground_is_the_same_ground(ground, x, y, place):
    assume(min([abs(place + x - edge) for edge in ground.edges], default=1.0) > 1e-9)
    moved = ground.shifted(x, y)
    assert float(moved.height_at(place)) == pytest.approx(float(ground.height_at(place + x)) - y, abs=1e-9)
    assert moved.slope_at(place) == ground.slope_at(place + x)


@given(grounds(), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_the_highest_between_two_places(ground, x, other):
    low, high = min(x, other), max(x, other)
    dense = [*np.linspace(low, high, 200), *(edge for edge in ground.edges if low <= edge <= high)]
    wanted = max(float(ground.height_at(place)) for place in dense)
    assert float(ground.highest_between(np.float64(x), np.float64(other))) == pytest.approx(wanted, abs=1e-12)


def sole(x, y, tilt, foot=FOOT):
    """Points of a sole in [m], shape (n, 2), whose ankle is at x, y, and which is tilted by `tilt` in [rad]."""
    along = np.array([math.cos(tilt), math.sin(tilt)])
    under = np.array([x, y]) - foot.ankle_height * np.array([-along[1], along[0]])
    return under + np.linspace(-foot.heel, foot.toe, 401)[:, None] * along


def least_ankle(ground, x, tilt, foot=FOOT):
    """Least height of an ankle in [m] over the ground under the supporting foot whose sole is not in the ground."""
    points = sole(x, 0.0, tilt, foot)
    return float((ground.height_at(points[:, 0]) - points[:, 1]).max())


@given(grounds(), st.floats(-1.0, 1.0))
def test_an_ankle_on_the_ground_is_as_high_as_its_sole_lets_it(ground, x):
    assume(bool(ground.slopes))
    stands = FOOT.ankle_height / math.cos(ground.slope_at(0.0))
    found = ground.ankle_on(FOOT, x) + stands
    least = least_ankle(ground, x, ground.slope_at(x))
    # Where a riser lies between two of the points looked at, the sole may be higher.
    assert found >= least - 1e-9
    assert found <= max(least, *(least_ankle(ground, x + off, ground.slope_at(x)) for off in (-5e-4, 5e-4))) + 1e-3


def test_a_sole_on_a_ramp_lies_on_it():
    slope = math.radians(12.0)
    ground = ggo.Ground((0.3,), (0.0, 0.0), (0.0, slope))
    ankle = ground.ankle_on(FOOT, 0.7) + FOOT.ankle_height
    points = sole(0.7, ankle, slope)
    np.testing.assert_allclose(points[:, 1], ground.height_at(points[:, 0]), atol=1e-12)


@given(grounds(), st.floats(-0.6, -0.1), st.floats(0.1, 0.8), st.floats(0.0, 1.0))
def test_an_ankle_above_the_ground_for_it_keeps_the_turning_sole_out(ground, start, landing, share):
    assume(bool(ground.slopes))
    lifted = ground.for_ankle(FOOT, (start, landing))
    x = start + share * (landing - start)
    tilt = (1.0 - share) * ground.slope_at(start) + share * ground.slope_at(landing)
    stands = FOOT.ankle_height / math.cos(ground.slope_at(0.0))
    points = sole(x, float(lifted.height_at(x)) + stands, tilt)
    # Between samples the sole turns by less than 0.01 rad, and risers are looked at from cell to cell.
    assert (points[:, 1] - ground.height_at(points[:, 0])).min() > -2e-3 or any(
        np.abs(points[[0, -1], 0] - edge).min() < CELL for edge in ground.edges
    )


def test_a_foot_without_size_sees_ramps_as_they_are():
    ground = ggo.Ground((0.3,), (0.0, 0.05), (0.0, 0.1))
    assert ground.for_ankle(ggo.Foot(), (0.0, 0.4)) is ground


def test_slopes_are_checked():
    with pytest.raises(ggo.InputError, match="2 heights need as many slopes, or none; got 1"):
        ggo.Ground((0.3,), (0.0, 0.0), (0.1,))
    with pytest.raises(ggo.InputError, match=r"slopes: 17\.1887 degrees is above 15 degrees"):
        ggo.Ground((0.3,), (0.0, 0.0), (0.0, -0.3))
    with pytest.raises(ggo.InputError, match="slopes: value nan at"):
        ggo.Ground((0.3,), (0.0, 0.0), (0.0, math.nan))
    assert ggo.Ground((0.3,), (0.0, 0.1), (0.0, 0.0)) == ggo.Ground((0.3,), (0.0, 0.1))


# What `verify` sees of ramps.
BASE = ggo.paper_base_gait()
MODEL = ggo.LegModel(0.39, 0.39, foot=FOOT)


def step_up(slope, foothold=0.45, seam=0.2, model=MODEL):
    terrain = ggo.Terrain.level(seam) + ggo.Terrain.ramp(3.0, slope)
    (step,) = steps_on(terrain, [foothold], model=model, start=BASE.frames[0])
    made = ggo.walk(BASE, [step], model=model)
    return made.gaits[0], step


def verified(gait, step, ground):
    return ggo.verify(gait, MODEL, obstacles=step.obstacles, ground=ground, foothold=step.foothold)


def kinds(report):
    return {fault.kind for fault in report.violations}


def kinked(step, slope, off, then):
    """The ground of a step on a ramp that goes on with another slope from `off` beyond where its foot lands."""
    place = step.foothold[0] + off
    rise = math.tan(slope) * (place - step.ground.edges[-1])
    return ggo.Ground((*step.ground.edges, place), (*step.ground.heights, rise), (*step.ground.slopes, then))


def test_verify_sees_a_foot_in_a_ramp():
    gait, step = step_up(math.radians(6.0))
    assert verified(gait, step, step.ground).ok
    steeper = ggo.Ground(step.ground.edges, step.ground.heights, (0.0, math.radians(14.0)))
    assert {"ground", "foothold off the ground"} <= kinds(verified(gait, step, steeper))
    flatter = ggo.Ground(step.ground.edges, step.ground.heights, (0.0, 0.0))
    assert "foothold off the ground" in kinds(verified(gait, step, flatter))


def test_verify_sees_a_sole_over_a_kink():
    slope = math.radians(8.0)
    gait, step = step_up(slope)
    assert verified(gait, step, kinked(step, slope, FOOT.toe + 0.02, STEEPEST)).ok
    for off in (-0.02, 0.0, 0.05, 0.10):
        assert "stair in the foothold" in kinds(verified(gait, step, kinked(step, slope, off, STEEPEST))), off
    # A toe may hang over a crest, most of a sole may not.
    assert verified(gait, step, kinked(step, slope, 0.05, -STEEPEST)).ok
    assert "foothold over a void" in kinds(verified(gait, step, kinked(step, slope, -0.04, -STEEPEST)))
