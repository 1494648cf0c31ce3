"""Touchdown postures of many footholds at once, against the exact search for each."""

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.graph.touchdown import NEAR, touchdown_posture
from ggo_factors.planning.postures import MET, postures, upright

BASE = ggo.paper_base_gait()
LANDING = BASE.frames[-1]
GRID = np.array([(x, y) for x in np.arange(0.02, 1.5, 0.06) for y in np.arange(-0.3, 0.31, 0.06)])


@pytest.mark.parametrize("model", [ggo.LegModel(0.39, 0.39), ggo.LegModel(0.42, 0.36)], ids=["equal", "unequal"])
def test_they_are_the_exact_ones(model):
    found = postures(model, LANDING, GRID)
    exact = [touchdown_posture(model, LANDING, (x, y)) for x, y in GRID.tolist()]
    missed, worse, compared = 0, 0, 0
    for frame, other, foothold in zip(found, exact, GRID, strict=True):
        if not np.isfinite(frame).all():
            missed += other is not None and ((other - LANDING) ** 2).sum() < 4.0 * NEAR
            continue
        assert np.hypot(*(model.endpoint(frame) - foothold)) < MET
        if other is None:
            continue
        change, least = (((each - LANDING) ** 2).sum() for each in (frame, other))
        compared += 1
        worse += change > least + 1e-3
        if least <= NEAR:
            np.testing.assert_allclose(frame, other, atol=2e-3, err_msg=str(foothold))
    assert missed == 0
    assert compared > 100
    assert worse <= 0.05 * compared


def test_out_of_reach_there_is_none():
    found = postures(ggo.LegModel(0.39, 0.39), LANDING, np.array([[1.6, 0.0], [0.4, 0.0], [9.0, 9.0], [0.3, -1.7]]))
    assert np.isfinite(found).all(axis=1).tolist() == [False, True, False, False]


def test_no_foothold_spoils_another():
    model, few = ggo.LegModel(0.39, 0.39), np.array([[0.3, 0.1], [0.5, 0.0]])
    with_others = np.concatenate([few, [[np.nan, 0.0], [0.0, 0.0], [1e9, 0.0], [1.56, 0.0]]])
    alone = postures(model, LANDING, few)
    np.testing.assert_allclose(postures(model, LANDING, with_others)[:2], alone, atol=1e-12)


def test_an_upright_shank_is_that_of_the_exact_search():
    model = ggo.LegModel(0.39, 0.39)
    places = np.array([(x, y) for x in (0.45, 0.6, 0.75, 0.9) for y in (-0.1, 0.0, 0.1)])
    ends = postures(model, LANDING, places)
    most = np.full(len(places), np.radians(15.0))
    found = upright(model, ends, (-most, most))
    leaning = np.abs(ends[:, 3] - ends[:, 2]) > most
    assert leaning.sum() > 3
    np.testing.assert_array_equal(found[~leaning], ends[~leaning])
    for frame, end, place in zip(found[leaning], ends[leaning], places[leaning], strict=True):
        np.testing.assert_allclose(model.endpoint(frame), place, atol=1e-3)
        lean = np.clip(end[3] - end[2], -most[0], most[0])
        assert frame[3] - frame[2] == pytest.approx(lean, abs=1e-4)
        exact = touchdown_posture(model, LANDING, tuple(place.tolist()), np.pi / 2.0 - lean)
        np.testing.assert_allclose(frame, exact, atol=np.radians(3.0))
