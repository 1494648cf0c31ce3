"""Where a foot may stand, and which footholds are considered there."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.planning.footholds import DEVIATIONS, GRID, SPARE, blocked, candidates, free_stretches, may_stand
from ggo_factors.walking.on_terrain import step_on

PLACES = st.integers(-400, 400).map(lambda n: n / 100.0)
STRETCHES = st.lists(st.tuples(PLACES, PLACES).map(sorted), max_size=6).map(lambda s: np.array(s).reshape(-1, 2))
FOOT = ggo.Foot(0.06, 0.05, 0.12)
LEVEL = ggo.Terrain.level(4.0)


def strictly_inside(x, stretches):
    return any(begins + 1e-9 < x < ends - 1e-9 for begins, ends in stretches.tolist())


@given(STRETCHES, st.lists(PLACES, min_size=1, max_size=9))
def test_a_foot_may_stand_outside_every_stretch(stretches, places):
    free = may_stand(np.array(places), stretches)
    assert free.tolist() == [not strictly_inside(x, stretches) for x in places]


@given(STRETCHES, PLACES, st.floats(0.0, 3.0))
def test_free_stretches_are_all_that_is_not_blocked(stretches, low, long):
    high = low + long
    free = free_stretches(stretches, low, high)
    assert free == sorted(free)
    for begins, ends in free:
        assert low <= begins <= ends <= high
        assert not any(strictly_inside(x, stretches) for x in np.linspace(begins, ends, 9))
    for x in np.linspace(low, high, 97):
        assert strictly_inside(x, stretches) or any(a - 1e-9 <= x <= b + 1e-9 for a, b in free)


@given(STRETCHES, PLACES, st.floats(0.0, 3.0), st.sampled_from([GRID, GRID / 2.0]), st.data())
def test_candidates_lie_free_near_enough_and_keep_what_is_to_be_kept(stretches, low, long, apart, data):
    high = low + long
    keep = tuple(data.draw(st.lists(st.floats(low, high), max_size=3)))
    found = candidates(stretches, low, high, keep, apart)
    kept = np.array(keep)
    assume(len(np.unique(np.round(kept, 6))) == len(kept))  # no two of them in one place
    others, inner = found[~np.isin(found, kept)], stretches + np.array([1e-6, -1e-6])
    assert (np.diff(found) > 0.0).all()
    assert set(kept.tolist()) <= set(found.tolist())
    assert (others >= low - 1e-6).all()
    assert (others <= high + 1e-6).all()
    assert not any(strictly_inside(x, inner) for x in others.tolist())
    for x in np.linspace(low, high, 61):
        # Of what lies nearer than a fifth of the grid only one is kept.
        if not strictly_inside(x, stretches):
            assert np.abs(found - x).min() <= 1.2 * apart + 1e-6


def test_a_narrow_stretch_has_a_candidate_in_its_middle():
    stretches = np.array([[0.0, 1.02], [1.13, 3.0]])
    assert candidates(stretches, 0.5, 2.0, ()) == pytest.approx([1.02, 1.05, 1.075, 1.1, 1.13])


@pytest.mark.parametrize("foot", [ggo.Foot(), FOOT], ids=["point", "sole"])
@pytest.mark.parametrize("std", [0.0, 0.01])
def test_soles_keep_away_from_all_that_is_there(foot, std):
    away = SPARE + DEVIATIONS * std
    kerb = ggo.Terrain.level(1.0) + ggo.Terrain.level(3.0, rise=0.1, edge_std=std)
    shapes = [
        (kerb, (1.0, 1.0)),
        (LEVEL.with_boxes(ggo.Obstacle(1.0, 1.2, 0.1, std, 0.02)), (1.0, 1.2)),
        (LEVEL.with_boxes(ggo.Obstacle(1.0, 1.2, 0.0, std)), (1.0, 1.2)),
        (LEVEL.with_pits(ggo.Gap(1.0, 1.2, std)), (1.0, 1.2)),
        (LEVEL.with_pits(ggo.Gap(1.0, 1.2, std, unknown=True)), (1.0, 1.2)),
    ]
    for terrain, (begins, ends) in shapes:
        first = blocked(terrain, foot)[0]
        assert first == pytest.approx([begins - foot.toe - away, ends + foot.heel + away]), terrain


def test_no_foot_stands_beyond_the_end_nor_over_a_change_of_slope():
    assert blocked(LEVEL, FOOT)[0].tolist() == pytest.approx([4.0 - FOOT.toe - SPARE, 104.0 + FOOT.heel + SPARE])
    assert may_stand(np.array([-50.0]), blocked(LEVEL, FOOT))[0]
    ramp = ggo.Terrain.level(1.0) + ggo.Terrain.ramp(1.0, math.radians(10.0))
    aside = FOOT.ankle_height * math.sin(math.radians(10.0))  # a sole on the ramp is so much further on than its ankle
    assert blocked(ramp, FOOT)[0].tolist() == pytest.approx([1.0 - FOOT.toe - aside, 1.0 + FOOT.heel + aside])
    assert may_stand(np.array([1.0]), blocked(ramp, ggo.Foot()))[0]


def test_a_candidate_before_a_pit_is_a_foothold_for_a_step_that_began_on_a_ramp():
    terrain = ggo.Terrain(
        (ggo.Surface(0.0, 0.8, 0.0, 0.2), ggo.Surface(0.8, 3.0, 0.8 * math.tan(0.2))), (), (ggo.Gap(1.3, 1.5),)
    )
    model = ggo.LegModel(0.39, 0.39, foot=FOOT)
    ((first, _),) = [each for each in blocked(terrain, FOOT).tolist() if each[0] < 1.4 < each[1]]
    step = step_on(terrain, model, 0.6, 0.9, first)
    pits = [gap for gap in step.gaps if not gap.unknown]
    assert [pit.x_start for pit in pits] == pytest.approx([1.3 - 0.9])
    assert step.foothold[0] + FOOT.toe < pits[0].x_start
