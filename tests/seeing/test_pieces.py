"""The division of a profile against a search over all divisions, and the places of edges against plain geometry."""

from itertools import combinations, pairwise

import numpy as np
import pytest

from ggo_factors.seeing.edges import Place, combined
from ggo_factors.seeing.pieces import PIECE_PRICE, SLOPE_PRICE, STRAY_PRICE, pieces_of
from ggo_factors.seeing.profile import Profile

STD = 0.003


def profile(x, y):
    n = len(x)
    return Profile(np.asarray(x), np.asarray(y), np.full(n, STD), np.full(n, STD), np.full(n, 50))


def cost_of(x, y, kind):
    if kind == "stray":
        return STRAY_PRICE * len(x)
    degree = 0 if kind == "level" else 1
    if len(x) <= degree:
        return np.inf
    off = y - np.polyval(np.polyfit(x, y, degree), x)
    return float(off @ off) / STD**2 + PIECE_PRICE + SLOPE_PRICE * degree


def cheapest(x, y):
    """The least cost over all divisions into level, sloped and stray stretches."""
    n = len(x)
    least = np.inf
    for count in range(4):
        for cuts in combinations(range(1, n), count):
            ends = [0, *cuts, n]
            parts = [
                min(cost_of(x[a:b], y[a:b], kind) for kind in ("level", "sloped", "stray")) for a, b in pairwise(ends)
            ]
            least = min(least, sum(parts))
    return least


@pytest.mark.parametrize("seed", range(6))
def test_no_division_is_cheaper(seed):
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, 0.3, 14))
    y = np.where(x < 0.1, 0.0, np.where(x < 0.2, 0.02, 0.02 + rng.uniform(-0.2, 0.2) * (x - 0.2)))
    y = y + rng.normal(0.0, STD, 14)
    y[rng.integers(14)] += 0.1
    found = pieces_of(profile(x, y))
    cost = sum(cost_of(x[p.cells], y[p.cells], "sloped" if p.slope else "level") for p in found) + STRAY_PRICE * (
        14 - sum(len(p.cells) for p in found)
    )
    # The search stops at four stretches: what needs more may be cheaper still.
    assert cost <= cheapest(x, y) + 1e-6


def test_a_step_of_fifteen_millimetres_is_found_and_one_of_three_is_not():
    x = np.arange(0.0, 1.0, 0.01)
    noise = np.random.default_rng(0).normal(0.0, STD, len(x))
    assert len(pieces_of(profile(x, np.where(x < 0.5, 0.0, 0.015) + noise))) == 2
    assert len(pieces_of(profile(x, np.where(x < 0.5, 0.0, 0.003) + noise))) == 1


def test_a_height_is_known_the_better_the_more_cells_it_has():
    x = np.arange(0.0, 1.0, 0.01)
    rng = np.random.default_rng(1)
    (piece,) = pieces_of(profile(x, rng.normal(0.0, STD, len(x))))
    assert piece.height_var**0.5 == pytest.approx(STD / 10.0, rel=0.3)
    off = [pieces_of(profile(x, rng.normal(0.0, STD, len(x))))[0].height for _ in range(200)]
    assert np.std(off) == pytest.approx(STD / 10.0, rel=0.2)


def test_places_are_weighted_by_their_information():
    one = combined([Place(1.0, 0.003), None, Place(1.1, 0.004)])
    assert one is not None
    assert one.x == pytest.approx((1.0 / 9 + 1.1 / 16) / (1 / 9 + 1 / 16))
    assert one.std == pytest.approx(0.0024)
    assert combined([None, None]) is None
