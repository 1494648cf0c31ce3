"""Terrains: composition, their shapes in words and numbers, and what a step sees of them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ggo_factors as ggo

T, BOX = ggo.Terrain, ggo.Obstacle
FOOT = ggo.Foot(0.06, 0.05, 0.12)
COURSE = (
    (T.level(1.0) + T.stairs(2, riser=[0.1, -0.05], tread=0.3) + T.ramp(1.0, 0.1) + T.level(1.0, rise=0.08))
    .with_boxes(BOX(0.4, 0.5, 0.12), BOX(2.0, 2.1, 0.05))
    .with_pits(ggo.Gap(2.7, 2.9), ggo.Gap(3.0, 3.1, 0.01, unknown=True))
)


@st.composite
def terrains(draw):
    """Two to four pieces of any kind, one behind the other, with boxes on some."""
    made, steps = None, st.floats(-0.3, 0.3)
    for _ in range(draw(st.integers(1, 4))):
        long = draw(st.floats(0.05, 2.0))
        part = draw(
            st.sampled_from(
                [
                    T.level(long, rise=draw(steps), edge_std=draw(st.sampled_from([0.0, 0.02]))),
                    T.ramp(long, draw(st.floats(-0.26, 0.26))),
                    T.stairs(draw(st.integers(1, 3)), riser=draw(steps), tread=long),
                    T.pit(long),
                    T.level(long).with_boxes(BOX(0.0, long / 2.0, abs(draw(steps)))),
                ]
            )
        )
        made = part if made is None else made + part
    return made


@given(terrains(), terrains(), terrains())
def test_terrains_are_put_one_behind_another(one, other, third):
    both = one + other
    assert both.length == pytest.approx(one.length + other.length)
    assert len(both.boxes) == len(one.boxes) + len(other.boxes)
    x = np.random.default_rng(0).uniform(0.01, 0.99, 9)
    here = one.x_start + x * one.length
    np.testing.assert_allclose(both.height_at(here), one.height_at(here), rtol=1e-6, atol=1e-12)
    ahead = other.height_at(other.x_start + x * other.length) + one.surfaces[-1].end_height
    np.testing.assert_allclose(both.height_at(one.x_end + x * other.length), ahead, rtol=1e-6, atol=1e-9)
    moved = [box.x_start - one.x_end for box in both.boxes[len(one.boxes) :]]
    assert moved == pytest.approx([box.x_start - other.x_start for box in other.boxes])
    again = one + (other + third)
    assert (both + third).length == pytest.approx(again.length)
    x = again.x_start + np.random.default_rng(1).uniform(0.01, 0.99, 9) * again.length
    edges = np.array([surface.x_start for surface in again.surfaces])
    x = x[np.abs(x[:, None] - edges).min(axis=1) > 1e-6]
    np.testing.assert_allclose((both + third).height_at(x), again.height_at(x), rtol=1e-6, atol=1e-9)


@given(terrains())
def test_a_terrain_comes_back_from_its_file(tmp_path_factory, terrain):
    path = tmp_path_factory.getbasetemp() / "terrain.toml"
    terrain.save(path)
    again = ggo.load_terrain(path)
    for mine, theirs in zip(again.surfaces, terrain.surfaces, strict=True):
        assert replace(mine, slope=0.0) == replace(theirs, slope=0.0)
        assert mine.slope == pytest.approx(theirs.slope, abs=1e-13)
    assert (again.boxes, again.pits, again.name) == (terrain.boxes, terrain.pits, terrain.name)


def test_level_pieces_that_go_on_are_one():
    whole = T.level(1.0) + T.level(2.0)
    assert whole.surfaces == (ggo.Surface(0.0, 3.0),)
    assert len((T.level(1.0) + T.level(2.0, rise=0.1)).surfaces) == 2
    assert len((T.level(1.0) + T.level(2.0, edge_std=0.01)).surfaces) == 2
    assert len((T.ramp(1.0, 0.1) + T.ramp(1.0, 0.1)).surfaces) == 1


def test_heights_slopes_and_tops_in_the_world():
    assert COURSE.length == pytest.approx(3.6)
    assert COURSE.rises == pytest.approx((0.1, -0.05, 0.0, 0.08))
    heights = COURSE.height_at([-5.0, 0.5, 1.0, 1.2, 1.3, 1.5, 2.6, 3.0])
    ramp = 0.05 + math.tan(0.1)
    assert heights == pytest.approx([0.0, 0.0, 0.1, 0.1, 0.1, 0.05, ramp + 0.08, ramp + 0.08])
    assert [COURSE.slope_at(x) for x in (0.0, 1.6, 2.0, 2.6)] == [0.0, 0.1, 0.1, 0.0]
    assert [COURSE.surface_at(x) for x in (-9.0, 0.5, 1.0, 1.29, 2.0, 99.0)] == [0, 0, 1, 1, 3, 4]
    assert COURSE.tops == pytest.approx((0.12, 0.05 + math.tan(0.1) * 0.5 + 0.05))
    assert COURSE.ankle_at(2.0, FOOT) == pytest.approx(0.05 + math.tan(0.1) * 0.4 + 0.06 / math.cos(0.1))
    assert repr(COURSE) == "Terrain('terrain', 3.6 m, 3 risers, 1 ramp, 2 boxes, 2 pits)"


@given(terrains(), st.floats(-1.0, 5.0), st.floats(-0.6, 0.0), st.floats(0.0, 1.0))
def test_a_step_sees_the_ground_as_it_is(terrain, x, behind, ahead):
    seen, y = terrain.seen_from(x, x + behind, x + ahead), float(terrain.height_at(x))
    edges = [surface.x_start for surface in terrain.surfaces[1:]]
    for place in np.linspace(behind, ahead, 13):
        if (
            min([abs(x + place - edge) for edge in edges], default=1.0) > 1e-6
            and min([abs(x - edge) for edge in edges], default=1.0) > 1e-6
        ):
            assert float(seen.height_at(place)) == pytest.approx(float(terrain.height_at(x + place)) - y, abs=1e-9)
            assert seen.slope_at(place) == pytest.approx(terrain.slope_at(x + place))


@pytest.mark.parametrize(
    ("made", "told"),
    [
        (lambda: T(()), "surfaces: 0 must be at least 1"),
        (lambda: T((ggo.Surface(0.0, 1.0), ggo.Surface(2.0, 3.0))), "surface 1 ends at 1 m, the next begins at 2 m"),
        (lambda: T([1.0]), "surfaces: expected Surfaces, got 1.0"),
        (lambda: T(tuple(ggo.Surface(n * 0.05, n * 0.05 + 0.05) for n in range(1001))), "1001 must be at most 1000"),
        (lambda: T.level(math.nan), "x_end: nan m is not finite"),
        (lambda: T.level(0.0), "x_end: 0 m must be above x_start 0 m"),
        (lambda: T.level(1e4), "x_end: 10000 m must be at most 1000 m"),
        (lambda: T.ramp(1.0, 0.3), "slope: 17.1887 degrees is beyond 15 degrees"),
        (lambda: T.ramp(1.0, 10.0), "slope: 572.958 degrees"),
        (lambda: T.stairs(0, riser=0.1, tread=0.3), "steps: 0 must be at least 1"),
        (lambda: T.stairs(2, riser=[0.1], tread=0.3), r"riser: expected shape \(2,\), got \(1,\)"),
        (lambda: T.stairs(2, riser=0.1, tread=-0.3), "tread: -0.3 m must be above 0 m"),
        (lambda: T.level(1.0, edge_std=0.2), "edge_std: 0.2 m must be at most 0.1 m"),
        (lambda: T.level(1.0, height_std=-0.1), "height_std: -0.1 m must be at least 0 m"),
        (lambda: T.level(1.0).with_boxes(BOX(1.5, 1.6, 0.1)), "boxes: box from 1.5 to 1.6 m.* beyond the end"),
        (lambda: T.level(1.0).with_boxes(BOX(0.5, 0.6, 0.1, base=-0.1)), "has a base; in a terrain a box stands on"),
        (lambda: T.level(1.0).with_pits(BOX(0.5, 0.6, 0.1)), "pits: expected Gaps, got a Obstacle"),
        (lambda: replace(T.level(1.0), name=3), "name: expected a str, got 3"),
        (lambda: sum([T.level(600.0)] * 2, start=T.level(1.0)), "must be at most 1000 m"),
    ],
)
def test_a_terrain_is_checked(made, told):
    with pytest.raises(ggo.InputError, match=told) as error:
        made()
    assert "\n" not in str(error.value)


def test_only_terrains_are_put_behind_terrains():
    with pytest.raises(TypeError):
        T.level(1.0) + 1.0


@pytest.mark.parametrize(
    ("name", "value"),
    [(name, value) for name in ("x_start", "x_end", "height", "slope", "edge_std", "height_std")
     for value in (math.nan, math.inf, "1", None, True, 10**400, 1e300)],
)  # fmt: skip
def test_a_surface_names_the_number_that_is_wrong(name, value):
    with pytest.raises(ggo.InputError, match=f"^{name}: "):
        ggo.Surface(**({"x_start": 0.0, "x_end": 1.0} | {name: value}))
