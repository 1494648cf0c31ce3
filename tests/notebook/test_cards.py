"""What a notebook shows of each result: right, small, without matplotlib, safe with any text."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from pictures import of_colour, read

import ggo_factors as ggo
from ggo_factors.evaluate.likeness import METHODS, ComparedStep, Comparison
from ggo_factors.notebook import svg as colours
from ggo_factors.planning.whynot import Ban

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.2, 0.25, 0.08)
FEET = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(ankle_height=0.07, heel=0.05, toe=0.12))


@pytest.fixture(scope="module")
def over():
    return ggo.step_over(BASE, [BOX], foothold=(0.45, 0.0))


@pytest.fixture(scope="module")
def stairs():
    return ggo.climb_stairs(BASE, 0.12, tread=0.35, steps=3)


@pytest.fixture(scope="module")
def found():
    return ggo.import_base_gait(ggo.datasets.children_walk(), joints=ggo.datasets.children_walk_joints(), leg="each")


@pytest.fixture(scope="module")
def graph():
    made = ggo.GaitGraph(BASE)
    made.anchor(BASE.frames[0])
    made.add_obstacle(BOX)
    made.end((0.45, 0.0))
    return made


@pytest.fixture(scope="module")
def plan():
    ground = ggo.Terrain.level(1.2) + ggo.Terrain.stairs(1, riser=0.1, tread=0.6) + ggo.Terrain.pit(0.2)
    return ggo.plan_walk(BASE, ground.with_boxes(ggo.Obstacle(0.6, 0.65, 0.08, edge_std=0.004)), goal=1.7)


@pytest.fixture
def results(over, stairs, found, graph, plan):
    solved = graph.solve()
    bare = ggo.Walk((replace(BASE, model=None),) * 2, (ggo.Step((0.39, 0.0)),) * 2)
    gaits = (BASE, replace(BASE, model=None), ggo.BaseGaits(BASE, BASE), found.base_gaits)
    walks = (stairs, bare, stairs.joint_trajectory(), stairs.joint_trajectory(rate=1000.0), plan, plan.terrain)
    return (*gaits, over, over.report, *walks, found, graph, solved, solved.report)


def scale_of(html):
    """Pixels a metre: by the thigh and the shank of the first leg drawn, 0.39 m each."""
    leg = of_colour(html, colours.SUPPORT)[0]
    lengths = np.linalg.norm(np.diff(leg[:3], axis=0), axis=1)
    assert lengths[0] == pytest.approx(lengths[1], abs=0.3)
    return lengths.mean() / 0.39


def test_each_result_has_a_small_card_of_its_own_and_one_line(results):
    for thing in results:
        html = thing._repr_html_()
        tags, words = read(html)
        assert {"svg", "table"} <= tags
        assert not tags & {"script", "img", "link"}
        assert len(words) > 40
        assert len(html.encode()) < 20_000, type(thing)
        assert "\n" not in repr(thing) or isinstance(thing, ggo.Report | ggo.ImportReport)


def test_the_path_in_the_picture_passes_the_box_by_the_clearance_of_the_report(over):
    html = over._repr_html_()
    scale, path = scale_of(html), of_colour(html, colours.PATH)[0]
    (box,) = of_colour(html, colours.OBSTACLE, "polygon")
    assert np.ptp(box, axis=0) / scale == pytest.approx([0.05, 0.08], abs=0.002)
    near = np.interp(box[[0, 1], 0], path[:, 0], path[:, 1])
    inside = path[(path[:, 0] > box[:, 0].min()) & (path[:, 0] < box[:, 0].max()), 1]
    least = (min(*near, *inside) - box[:, 1].max()) / scale
    assert least == pytest.approx(over.report.clearance, abs=0.002)


def test_the_card_of_a_step_tells_what_the_check_saw(over):
    words = read(over._repr_html_())[1]
    assert "no limit broken" in words
    assert f"{over.report.clearance * 1e3:.1f} mm" in words
    assert f"converged in {over.iterations} iterations" in words


def test_a_broken_limit_is_told_in_words(graph):
    solved = graph.solve()
    assert len(solved.violations) == 1
    for thing in (solved, solved.report):
        words = read(thing._repr_html_())[1]
        assert "1 limit broken" in words
        assert str(solved.violations[0]) in words


def test_the_bars_of_a_report_are_as_long_as_its_lengths(over):
    html = over.report._repr_html_()
    bars = of_colour(html, colours.SUPPORT, "polygon")
    known = [value for value in over.report.lengths.values() if math.isfinite(value)]
    widths = np.array([np.ptp(bar[:, 0]) for bar in bars])
    assert len(known) >= 3
    assert widths / widths.max() == pytest.approx(np.array(known) / max(known), abs=0.01)


def test_a_length_below_zero_goes_the_other_way(over):
    html = replace(over.report, clearance=-0.02)._repr_html_()
    ((low, high),) = [np.sort(bar[[0, 1], 0]) for bar in of_colour(html, colours.SWING, "polygon")]
    others = of_colour(html, colours.SUPPORT, "polygon")
    assert low < high
    assert high == pytest.approx(min(bar[:, 0].min() for bar in others), abs=0.2)


def test_a_leg_keeps_its_colour_and_stands_on_the_stairs(stairs):
    html = stairs._repr_html_()
    scale = scale_of(html)
    right, left = of_colour(html, colours.RIGHT), of_colour(html, colours.LEFT)
    # The right leg swings first: where it lands it stands in the second step, while the left one lands in front.
    assert right[6][2] == pytest.approx(right[7][2], abs=0.3)
    assert left[13][2, 0] > right[7][2, 0] + 0.3 * scale
    ground = next(line for line in of_colour(html, colours.INK) if len(line) > 5)
    heights = (ground[:, 1] - ground[0, 1]) / scale
    assert np.unique(np.round(heights, 2)) == pytest.approx([0.0, 0.12, 0.24, 0.36], abs=0.01)
    assert (left[13][2, 1] - ground[0, 1]) / scale == pytest.approx(0.24, abs=0.005)


def test_soles_are_drawn_where_there_are_feet():
    html = replace(BASE, model=FEET)._repr_html_()
    scale = scale_of(html)
    leg = of_colour(html, colours.SUPPORT)[0]
    ankle, heel, toe = leg[2], leg[3], leg[4]
    assert (heel - ankle) / scale == pytest.approx([-0.05, -0.07], abs=0.002)
    assert (toe - ankle) / scale == pytest.approx([0.12, -0.07], abs=0.002)
    ground = max(of_colour(html, colours.INK), key=lambda line: np.ptp(line[:, 0]))
    assert ground[0, 1] == pytest.approx(heel[1], abs=0.3)


def test_a_gait_without_leg_lengths_shows_its_angles():
    html = replace(BASE, model=None)._repr_html_()
    knee = of_colour(html, colours.SWING, number=1)[0]
    turned = np.degrees(BASE.frames[:, 3])
    heights = (knee[:, 1] - knee[:, 1].min()) / np.ptp(knee[:, 1])
    assert heights == pytest.approx((turned - turned.min()) / np.ptp(turned), abs=0.02)
    assert f"{turned.max():.0f}°" in read(html)[1]


def test_an_import_shows_the_spread_of_its_strides(found):
    html = found._repr_html_()
    (band,) = of_colour(html, colours.RIGHT, "polygon", number=1)
    knee = np.degrees(found.mean_cycle["right"][:, 1])
    half = len(band) // 2
    wide = (band[half:, 1][::-1] - band[:half, 1]) / 2.0
    mean = (band[half:, 1][::-1] + band[:half, 1]) / 2.0
    scale = np.ptp(mean) / np.ptp(knee)
    assert wide.max() / scale == pytest.approx(np.degrees(found.spread["right"][:, 1].max()), rel=0.1)
    assert "24" in read(html)[1]


def test_a_graph_shows_which_frames_are_variables(graph):
    solved = graph.solve()
    strip = of_colour(graph._repr_html_(), colours.PATH, number=1)
    places = [points[0, 0] for points in strip]
    wanted = np.array(solved.keyframes)
    assert len(places) == len(wanted)
    assert np.array(places) / max(places) == pytest.approx(wanted / wanted.max(), abs=0.01)


def test_any_text_is_only_text():
    bad = "<script>alert('x')</script> & \"quoted\""
    gait = replace(BASE, name=bad, origin=bad * 20, notes=(bad,) * 20)
    walk = ggo.Walk((gait,), (ggo.Step((0.39, 0.0)),), notes=(bad,))
    terrain = replace(ggo.Terrain.level(1.0), name=bad)
    for thing in (gait, replace(gait, model=None), ggo.BaseGaits(gait, gait), walk, ggo.GaitGraph(gait), terrain):
        html = thing._repr_html_()
        assert "script" not in read(html)[0]
        assert "<script>alert" in read(html)[1]
    assert "and 12 more" in read(gait._repr_html_())[1]


def test_a_walk_of_two_hundred_steps_stays_small():
    step = ggo.Step((0.39, 0.0), tuple(ggo.Obstacle(0.2, 0.25, 0.03 + k / 100.0) for k in range(3)))
    html = ggo.Walk((BASE,) * 200, (step,) * 200)._repr_html_()
    assert len(html.encode()) < 60_000
    assert "the first 40 steps" in read(html)[1]


def test_a_terrain_is_drawn_to_scale_and_told(plan):
    html = plan.terrain._repr_html_()
    (line,), (box,) = of_colour(html, colours.INK), of_colour(html, colours.OBSTACLE, "polygon")
    scale = np.ptp(line[:, 0]) / plan.terrain.length
    assert (line[0, 0], np.ptp(line[:, 1]) / scale) == pytest.approx((0.0, 0.1), abs=0.002)
    assert (box[:, 0] / scale).round(3).tolist() == pytest.approx([0.6, 0.65, 0.65, 0.6], abs=0.002)
    assert np.ptp(box[:, 1]) / scale == pytest.approx(0.08, abs=0.002)
    (pit,) = of_colour(html, "#FFFFFF", "polygon")
    assert (pit[[0, 2], 0] / scale) == pytest.approx([1.8, 2.0], abs=0.002)
    assert pit[:, 1].max() == pytest.approx(line[-1, 1], abs=0.1)
    words = read(html)[1]
    for told in ("x = 0 to 2 m", "0 to 0.1 m", *map(str, plan.terrain.boxes), "gap from 1.8 to 2 m", "at most 4 mm"):
        assert told in words


@pytest.mark.parametrize("height", [100.0, 1e300, 1.7e308])
def test_the_ground_beside_a_wall_is_to_be_seen(height):
    html = ggo.Terrain.level(4.0).with_boxes(ggo.Obstacle(0.5, 0.6, height))._repr_html_()
    (line,), (box,) = of_colour(html, colours.INK), of_colour(html, colours.OBSTACLE, "polygon")
    assert np.ptp(box[:, 1]) / np.ptp(line[:, 0]) == pytest.approx(0.5, abs=0.01)
    assert f"box from 0.5 to 0.6 m, {height:g} m high" in read(html)[1]


def test_a_terrain_of_a_thousand_pieces_stays_small():
    stairs = ggo.Terrain.stairs(999, riser=[0.1, -0.1] * 499 + [0.1], tread=0.15)
    boxes = [ggo.Obstacle(0.15 * k + 0.05, 0.15 * k + 0.08, 0.05) for k in range(600)]
    for terrain, drawn in ((stairs, "x = 15.150 m"), (stairs.with_boxes(*boxes), "x = 15.050 m")):
        html = terrain._repr_html_()
        assert len(html.encode()) < 20_000
        assert f"as far as {drawn}" in read(html)[1]
        assert "and 991 more" in read(html)[1]


def test_a_plan_tells_its_footholds_and_what_they_cost(plan):
    html = plan._repr_html_()
    words = read(html)[1]
    assert ", ".join(f"{x:.3f}" for x in plan.footholds) in words
    assert f"{plan.cost:.4g} rad²" in words
    assert len(of_colour(html, colours.OBSTACLE, "polygon")) == 1
    refused = replace(plan, banned=(Ban(0.0, 0.1, 0.2, "too <high>"),) * 1000)._repr_html_()
    assert "to 0.200 m: too <high>" in read(refused)[1]
    assert "and 992 more" in read(refused)[1]


def test_a_trajectory_tells_its_largest_rates(stairs):
    joints = stairs.joint_trajectory()
    speeds, bends = np.degrees(np.abs(joints.velocities)), np.degrees(np.abs(joints.accelerations))
    html = joints._repr_html_()
    words = read(html)[1]
    assert f"hip {speeds[:, [0, 2]].max():.0f}, knee {speeds[:, [1, 3]].max():.0f} deg/s" in words
    assert f"hip {bends[:, [0, 2]].max():.0f}, knee {bends[:, [1, 3]].max():.0f} deg/s²" in words
    turned = np.degrees(joints.right_knee)
    (knee,) = of_colour(html, colours.RIGHT, number=1)
    heights = (knee[:, 1] - knee[0, 1]) / np.ptp(knee[:, 1])
    assert heights[-1] == pytest.approx((turned[-1] - turned[0]) / np.ptp(turned), abs=0.03)


def test_results_without_a_picture_show_their_numbers():
    times = np.arange(20) * 0.01
    log = ggo.JointLog(times, {f"joint <{k}>": times for k in range(500)}, unit="rad", notes=("a <note>",) * 20)
    summary = ggo.inspect_log(ggo.datasets.children_walk())
    style = ggo.Style(np.full((51, 4, 2), 0.01), 3e-6, 56, 3, 0.9, (5.9, 4.4), (0.68, 0.77), ground="up")
    step = ComparedStep("right", 0.0, 0.5, (0.39, 0.0), BASE.frames, {}, {METHODS[0]: "no foothold: 3 mm"})
    made = Comparison("paper", "someone", "level", (step,) * 300, 0, 0, 0.0, BASE.legs())
    for thing, told in (
        (log, ("joint <3>", "20 rows, 0.19 s", "a <note>", "and 12 more")),
        (summary, (summary.topics[0].topic, summary.joints[0].name, summary.unit_why)),
        (style, ("56 steps of 3 people", "up", "0.68 degrees with it, 0.77 without", "90% of the variance")),
        (made, ("someone", "0 of 300", "300 steps refused")),
    ):
        html = thing._repr_html_()
        words = read(html)[1]
        assert all(word in words for word in told), (told, words)
        assert len(html.encode()) < 20_000
        assert len(repr(thing)) < 200
        assert "\n" not in repr(thing)


def test_one_box_is_drawn_once_though_two_steps_meet_it():
    near = ggo.Step((0.4, 0.0), (BOX,))
    far = ggo.Step((0.4, 0.0), (BOX.shifted(*BASE.endpoints()[-1].tolist()),))
    html = ggo.Walk((BASE, BASE), (near, far))._repr_html_()
    assert len(of_colour(html, colours.OBSTACLE, "polygon")) == 1


def test_no_card_loads_matplotlib():
    code = (
        "import sys, ggo_factors as ggo; base = ggo.paper_base_gait(); base._repr_html_(); "
        "ggo.Walk((base,), (ggo.Step((0.39, 0.0)),))._repr_html_(); ggo.verify(base)._repr_html_(); "
        "ggo.joint_trajectory([base])._repr_html_(); ggo.Terrain.level(1.0)._repr_html_(); "
        "print([m for m in ('matplotlib', 'mcap', 'pandas') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_colours_are_those_of_the_figures():
    for name in ("SUPPORT", "SWING", "PATH", "BASE", "GROUND", "OBSTACLE"):
        assert getattr(colours, name) == getattr(ggo.plot, f"{name}_COLOUR")
    assert {"right": colours.RIGHT, "left": colours.LEFT} == ggo.plot.LEG_COLOURS
