"""The touchdown posture against SciPy's minimiser from several starts, on footholds on level ground and on stairs."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

import ggo_factors as ggo
from ggo_factors.graph.touchdown import touchdown_posture

BASE = ggo.paper_base_gait()
MODEL = BASE.model
LANDING = BASE.frames[-1]
UPRIGHT = math.pi / 2.0
LOWEST = np.radians([-50.0, 0.0, -50.0, 0.0])
HIGHEST = np.radians([130.0, 150.0, 130.0, 150.0])
STARTS = np.radians([[10.0, 20.0, 10.0, 30.0], [-20.0, 20.0, 20.0, 20.0], [20.0, 50.0, 40.0, 80.0]])


def floors(landing):
    """Least angles, the knees' as straight as in the landing or 5 degrees."""
    low = LOWEST.copy()
    low[1::2] = np.minimum(landing[1::2], math.radians(5.0))
    return low


def by_scipy(landing, foothold, shank):
    """The nearest posture of all that SLSQP finds, or None."""
    constraints = [{"type": "eq", "fun": lambda q: MODEL.endpoint(q) - foothold, "jac": MODEL.endpoint_jacobian}]
    if shank is not None:
        tilt = np.array([[0.0, 0.0, 1.0, -1.0]])
        constraints.append({"type": "eq", "fun": lambda q: tilt @ q + UPRIGHT - shank, "jac": lambda q: tilt})
    best = None
    for start in (landing, *STARTS):
        found = minimize(
            lambda q: ((q - landing) ** 2).sum(),
            start,
            jac=lambda q: 2.0 * (q - landing),
            bounds=list(zip(floors(landing), HIGHEST, strict=True)),
            constraints=constraints,
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 200},
        )
        met = all(np.abs(c["fun"](found.x)).max() < 1e-8 for c in constraints)
        if found.success and met and (best is None or found.fun < best.fun):
            best = found
    return None if best is None else best.x


def random_landings(count, seed):
    """Landings and footholds: level, stairs up and down, short steps and steps back; shanks free and upright."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        landing = LANDING + np.radians(rng.uniform(-4.0, 8.0, 4))
        yield landing, (rng.uniform(-0.1, 0.7), rng.uniform(-0.2, 0.2)), UPRIGHT if number % 2 else None


def test_it_is_the_nearest_that_scipy_finds():
    compared = 0
    for landing, foothold, shank in random_landings(80, seed=13):
        landing[3] = abs(landing[3])
        found, expected = touchdown_posture(MODEL, landing, foothold, shank), by_scipy(landing, foothold, shank)
        if expected is None:
            continue  # either there is none, or only one with a knee straighter than its floor
        assert found is not None, (landing, foothold, shank)
        np.testing.assert_allclose(MODEL.endpoint(found), foothold, atol=1e-9)
        if shank is not None:
            assert ggo.factors.shank_angle(found) == pytest.approx(shank, abs=1e-9)
        assert (found >= floors(landing) - 1e-5).all()
        assert ((found - landing) ** 2).sum() == pytest.approx(((expected - landing) ** 2).sum(), abs=1e-4)
        compared += 1
    assert compared >= 70


def test_on_its_own_foothold_the_base_gait_lands_as_it_does():
    own = tuple(MODEL.endpoint(LANDING).tolist())
    np.testing.assert_allclose(touchdown_posture(MODEL, LANDING, own), LANDING, atol=1e-12)
    shank = ggo.factors.shank_angle(LANDING)
    np.testing.assert_allclose(touchdown_posture(MODEL, LANDING, own, shank), LANDING, atol=1e-12)


def test_a_foothold_out_of_reach_has_none():
    for foothold in ((1.6, 0.0), (1.2, 1.2), (0.0, -1.57)):
        assert touchdown_posture(MODEL, LANDING, foothold) is None
    # Two metres of leg would reach it, but not with the shank upright and the thigh no further than a thigh goes.
    assert touchdown_posture(MODEL, LANDING, (1.3, 0.0), UPRIGHT) is None


def test_the_shank_comes_before_the_knees_floor():
    bent = LANDING + np.radians([0.0, 10.0, 0.0, 20.0])
    for foothold in ((-0.6, -0.3), (-0.5, -0.2), (-0.45, -0.15)):  # down, backwards
        assert by_scipy(bent, foothold, UPRIGHT) is None
        found = touchdown_posture(MODEL, bent, foothold, UPRIGHT)
        np.testing.assert_allclose(MODEL.endpoint(found), foothold, atol=1e-9)
        assert ggo.factors.shank_angle(found) == pytest.approx(UPRIGHT, abs=1e-9)
        assert -0.3 <= np.degrees(found[[1, 3]].min()) < 4.95


def test_knees_are_no_straighter_than_the_floor_asks():
    found = touchdown_posture(MODEL, LANDING, (0.29, 0.15), UPRIGHT)
    assert np.degrees(LANDING[1]) > 5.0
    assert np.degrees(found[1]) == pytest.approx(5.0, abs=1e-3)
    straight = LANDING * (1.0, 0.1, 1.0, 0.0)
    found = touchdown_posture(MODEL, straight, (0.29, 0.15), UPRIGHT)
    assert found[1] == pytest.approx(straight[1], abs=1e-5)
