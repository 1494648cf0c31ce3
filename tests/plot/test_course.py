"""Pictures of terrains and plans: what is drawn is where it is in the world."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

from made_plan import AT, SLOPE, WORDS, made_plan, made_terrain
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from test_plot import two_steps

from ggo_factors import plot
from ggo_factors.errors import InputError
from ggo_factors.motion.leg_model import Foot, LegModel
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.plan import Plan
from ggo_factors.planning.whynot import Ban
from ggo_factors.plot.course import TOLD
from ggo_factors.plot.terrain import BAND, PIT_DEPTH

RIGHT, LEFT = (plot.LEG_COLOURS[leg] for leg in ("right", "left"))


@pytest.fixture(autouse=True)
def close_figures() -> Iterator[None]:
    yield
    plt.close("all")


def lines(ax: Axes, gid: str) -> list[np.ndarray]:
    return [line.get_xydata() for line in ax.lines if line.get_gid() == gid]


def outlines(ax: Axes, gid: str) -> list[np.ndarray]:
    """Corners of the patches of a name in [m]."""
    found = [patch for patch in ax.patches if patch.get_gid() == gid]
    return [patch.get_patch_transform().transform_path(patch.get_path()).vertices for patch in found]


def costs_of(ax: Axes) -> Axes:
    (_, below) = ax.figure.axes
    return below


# -- terrain ----------------------------------------------------------------------------------------------------------


def test_the_ground_goes_on_before_a_terrain_and_nobody_saw_what_is_beyond_it():
    ax = plot.plot_terrain(made_terrain())
    (line,) = lines(ax, "ground")
    left, right = ax.get_xlim()
    assert left < 0.0
    assert right > 3.4
    np.testing.assert_allclose(line[[0, -1]], [[left, -0.05], [right, math.tan(SLOPE)]])
    assert [0.9, -0.05] in np.round(line, 9).tolist()
    assert [0.9, 0.0] in np.round(line, 9).tolist()
    (unseen,) = outlines(ax, "unseen")
    np.testing.assert_allclose([unseen[:, 0].min(), unseen[:, 0].max()], [3.4, right])
    assert ax.get_aspect() == 1.0
    assert ax.get_ylim()[1] > max(made_terrain().tops)


def test_a_pit_on_a_ramp_is_as_deep_everywhere_and_a_box_stands_on_its_lower_side():
    ax = plot.plot_terrain(made_terrain())
    level, sloped = outlines(ax, "gap")
    assert {tuple(point) for point in np.round(level, 9).tolist()} == {
        (1.5, 0.0),
        (1.7, 0.0),
        (1.5, -PIT_DEPTH),
        (1.7, -PIT_DEPTH),
    }
    for x in (2.2, 2.4):
        heights = np.unique(np.round(sloped[np.isclose(sloped[:, 0], x), 1], 9))
        np.testing.assert_allclose(heights, math.tan(SLOPE) * (x - 2.0) - np.array([PIT_DEPTH, 0.0]), atol=1e-9)
    low, high = (outlines(ax, "obstacle")[1][:, 1].min(), outlines(ax, "obstacle")[1][:, 1].max())
    assert low == pytest.approx(math.tan(SLOPE) * 0.5)
    assert high == pytest.approx(math.tan(SLOPE) * 0.6 + 0.05)


def test_bands_hold_95_of_100_edges_and_heights():
    ax = plot.plot_terrain(made_terrain())
    spans = [(*band.min(axis=0), *band.max(axis=0)) for band in outlines(ax, "band")]
    pit, kerb, over = BAND * 0.006, BAND * 0.004, BAND * 0.003
    np.testing.assert_allclose(
        spans,
        [
            (1.5 - pit, -PIT_DEPTH, 1.5 + pit, 0.0),
            (1.7 - pit, -PIT_DEPTH, 1.7 + pit, 0.0),
            (0.9 - kerb, -0.05, 0.9 + kerb, 0.0),
            (0.9, -over, 2.0, over),
        ],
    )
    assert len(outlines(ax, "obstacle band")) == 1
    assert not outlines(plot.plot_terrain(Terrain.level(2.0)), "band")


def test_a_seam_without_a_riser_has_a_band_that_can_be_seen():
    ax = plot.plot_terrain(Terrain.level(1.0) + Terrain.ramp(1.0, 0.1, edge_std=0.01))
    (band,) = outlines(ax, "band")
    assert np.ptp(band[:, 1]) > 0.01
    assert np.ptp(band[:, 0]) == pytest.approx(2.0 * BAND * 0.01)


# -- plans ------------------------------------------------------------------------------------------------------------


def test_ankles_walk_in_the_world_from_where_the_plan_starts_and_land_on_the_footholds():
    plan = made_plan()
    ax = plot.plot_plan(plan)
    first, second = lines(ax, "ankle")
    np.testing.assert_allclose(first, plan.walk.gaits[0].endpoints() + np.array([AT, 0.0]), atol=1e-12)
    stands = plan.walk.origins()[1] + [AT, 0.0]
    np.testing.assert_allclose(second, plan.walk.gaits[1].endpoints() + stands, atol=1e-12)
    np.testing.assert_allclose([first[-1, 0], second[-1, 0]], plan.footholds)
    marks = np.concatenate(lines(ax, "chosen"))
    np.testing.assert_allclose(marks, np.stack([plan.footholds, plan.terrain.height_at(plan.footholds)], -1))
    np.testing.assert_allclose(np.concatenate(lines(ax, "start"))[:, 0], [first[0, 0], AT])
    assert [text.get_text() for text in ax.texts if text.get_text().isdigit()] == ["1", "2"]


def test_each_foot_keeps_its_colour():
    for swing, first, second in (("right", RIGHT, LEFT), ("left", LEFT, RIGHT)):
        plan = made_plan(walk=replace(two_steps(), first_swing=swing))
        ax = plot.plot_plan(plan)
        for gid in ("ankle", "chosen", "start"):
            assert [line.get_color() for line in ax.lines if line.get_gid() == gid] == [first, second]
        assert [line.get_color() for line in costs_of(ax).lines if line.get_gid() == "cost"] == [first, second]
        assert [text.get_color() for text in ax.texts if text.get_text().isdigit()] == [first, second]


def test_legs_are_drawn_at_the_start_half_way_and_at_each_landing():
    plan = made_plan()
    legs = lines(plot.plot_plan(plan), "leg")
    joints = [gait.model.joints(gait.frames) for gait in plan.walk.gaits]
    wanted = [(0, 0), (0, 25), (0, 50), (1, 25), (1, 50)]
    assert len(legs) == 2 * len(wanted)
    for pair, (step, frame) in zip(zip(legs[::2], legs[1::2], strict=True), wanted, strict=True):
        stands = plan.walk.origins()[step] + [AT, 0.0]
        np.testing.assert_allclose(pair[0], joints[step][frame, :3] + stands)
        np.testing.assert_allclose(pair[1], joints[step][frame, 2:] + stands)


def test_footholds_considered_are_ticks_on_the_ground():
    plan = made_plan()
    (ticks,) = lines(plot.plot_plan(plan), "considered")
    np.testing.assert_allclose(ticks[:, 0], plan.considered)
    np.testing.assert_allclose(ticks[:, 1], plan.terrain.height_at(plan.considered))
    assert not lines(plot.plot_plan(made_plan(considered=())), "considered")


def test_a_refused_step_is_a_cross_where_it_was_to_land_and_is_told_in_words():
    ax = plot.plot_plan(made_plan())
    np.testing.assert_allclose(np.concatenate(lines(ax, "refused"))[:, 0], [1.25, 1.275, 1.9])
    letters = {text.get_text(): text.xy for text in ax.texts if not text.get_text().isdigit()}
    assert set(letters) == {"a, b", "c"}
    np.testing.assert_allclose([letters["a, b"], letters["c"]], [(1.2625, 0.0), (1.9, 0.0)])
    (words,) = (text.get_text() for text in costs_of(ax).texts)
    assert words.splitlines() == [
        f"a: from 0.600 over 1.000 to 1.250 m: {WORDS}",
        "b: from 0.600 over 1.000 to 1.275 m: too far",
        "c: from 1.000 over 1.390 to 1.900 m: no gait",
    ]
    assert not costs_of(plot.plot_plan(made_plan(banned=()))).texts


def test_of_many_refused_steps_some_are_told_and_the_others_counted():
    banned = tuple(Ban(1.0, 1.39, 1.4 + 0.15 * n, "no gait") for n in range(TOLD + 3))
    ax = plot.plot_plan(made_plan(banned=banned))
    assert len(lines(ax, "refused")) == TOLD + 3
    (words,) = (text.get_text() for text in costs_of(ax).texts)
    assert words.splitlines()[-1] == "and 3 more steps refused"
    assert len(words.splitlines()) == TOLD + 1


def test_costs_are_drawn_where_steps_land_beside_what_was_expected():
    plan = made_plan()
    below = costs_of(plot.plot_plan(plan))
    bars = lines(below, "cost")
    np.testing.assert_allclose([bar[:, 1] for bar in bars], [[0.0, 0.004], [0.0, 0.002]])
    np.testing.assert_allclose([bar[0, 0] for bar in bars], plan.footholds, atol=0.03)
    np.testing.assert_allclose([mark[0, 1] for mark in lines(below, "expected")], plan.expected)


def test_a_new_figure_has_terrain_and_costs_one_under_the_other():
    ax = plot.plot_plan(made_plan())
    ax.figure.draw_without_rendering()
    above, below = ax.get_position(), costs_of(ax).get_position()
    assert (above.x0, above.x1) == pytest.approx((below.x0, below.x1), abs=0.01)
    assert ax.get_xlim() == costs_of(ax).get_xlim()
    assert above.y0 > below.y1
    assert above.height > 0.35


def test_axes_that_are_given_get_the_terrain_alone():
    figure, (mine, other) = plt.subplots(1, 2, layout="constrained")
    assert plot.plot_plan(made_plan(), ax=mine) is mine
    assert not other.has_data()
    assert len(figure.axes) == 2
    assert not figure.get_suptitle()
    assert any(WORDS in text.get_text() for text in mine.texts)


def test_feet_stand_on_the_ground_where_they_land():
    foot = Foot(0.06, 0.04, 0.10)
    model = LegModel(0.39, 0.39, foot=foot)
    walk = two_steps()
    walk = replace(walk, gaits=tuple(replace(gait, model=model) for gait in walk.gaits))
    sloped = Terrain.level(1.1) + Terrain.ramp(3.0, SLOPE)
    ax = plot.plot_plan(made_plan(walk=walk, terrain=sloped, considered=(), banned=()))
    feet = lines(ax, "foot")
    assert len(feet) == 6  # each step's two at its start, one where it lands
    np.testing.assert_allclose(feet[1], [[AT, 0.06], [AT - 0.04, 0.0], [AT + 0.10, 0.0], [AT, 0.06]], atol=1e-12)
    rise = feet[2][2] - feet[2][1]
    assert math.atan2(rise[1], rise[0]) == pytest.approx(SLOPE)
    assert not lines(plot.plot_plan(made_plan()), "foot")


def test_what_is_no_terrain_or_plan_is_refused():
    with pytest.raises(InputError, match="terrain: expected"):
        plot.plot_terrain(made_plan())
    with pytest.raises(InputError, match="plan: expected"):
        plot.plot_plan(made_terrain())


def test_colours_of_paths_are_those_of_the_legend():
    plan: Plan = made_plan()
    ax = plot.plot_plan(plan)
    (legend,) = ax.figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    handles = dict(zip(words, legend.legend_handles, strict=True))
    assert to_hex(handles["right ankle"].get_color()) == to_hex(RIGHT)
    assert to_hex(handles["left ankle"].get_color()) == to_hex(LEFT)
