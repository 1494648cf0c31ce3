"""Every figure as a whole: what is drawn by its hash, and what holds of all of them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise

import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

from drawn import colours, digest, drawn
from made_plan import made_plan
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.text import Text
from test_plot import BASE, compared, level_report, two_steps
from test_plot import varied as unnamed

from ggo_factors import plot
from ggo_factors.check.verify import verify
from ggo_factors.evaluate.comfort import Comfort
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import Foot, LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.plot.terrain import BAND
from ggo_factors.walking.step import Step
from ggo_factors.walking.walk import Walk

BOX = Obstacle(0.30, 0.35, 0.012)
SEEN = Obstacle(0.20, 0.26, 0.02, edge_std=0.006, height_std=0.004)
FEET = LegModel(0.39, 0.39, foot=Foot(0.08, 0.05, 0.12))


def varied() -> Gait:
    return replace(unnamed(), name="step to 0.423 m", origin="generated from paper base gait")


def with_feet() -> Walk:
    walk = two_steps(obstacles=(BOX,))
    return replace(walk, gaits=tuple(replace(gait, model=FEET) for gait in walk.gaits))


def solution() -> Solution:
    report = verify(varied(), obstacles=(SEEN,))
    return Solution(varied(), None, True, "made by hand", 0, np.zeros(1), 1, report)  # type: ignore[arg-type]


def spread(**given: object) -> tuple[Axes, ...]:
    with pytest.MonkeyPatch.context() as patch:
        wide = np.radians([1.0, 2.0, 3.0, 4.0]) * np.linspace(0.0, 1.0, len(BASE))[:, None]
        patch.setattr("ggo_factors.plot.spread.joint_spread", lambda *_: wide)
        return plot.plot_spread(solution(), BASE, **given)  # type: ignore[arg-type]


def comforts() -> list[Comfort]:
    peaks = np.arange(1.0, 13.0).reshape(3, 4)
    return [
        Comfort(name, JOINTS, share * peaks, share * peaks / 2.0, 0.1, math.nan, math.nan, 0.1, 0.1, 0.1)
        for name, share in (("over a box", 1.0), ("base gait", 0.6))
    ]


def one(ax: Axes) -> tuple[Axes, ...]:
    return (ax,)


FIGURES: dict[str, Callable[[], tuple[Axes, ...]]] = {
    "step": lambda: one(plot.plot_stick_figure(varied(), base=BASE, obstacles=[SEEN], foothold=(0.39, 0.0))),
    "pit": lambda: one(plot.plot_stick_figure(BASE, gaps=[Gap(0.05, 0.15)], frames=[0, 25, 50])),
    "walk": lambda: one(plot.plot_stick_figure(two_steps(obstacles=(BOX, SEEN)), base=BASE)),
    "left first": lambda: one(plot.plot_stick_figure(replace(two_steps(), first_swing="left"), frames=3)),
    "feet": lambda: one(plot.plot_stick_figure(with_feet(), frames=4)),
    "stairs": lambda: one(plot.plot_stick_figure(BASE, ground=Ground((0.29,), (0.0, 0.1)))),
    "ramp": lambda: one(plot.plot_stick_figure(BASE, model=FEET, ground=Ground((0.2,), (0.0, 0.0), (0.0, 0.1)))),
    "angles": lambda: plot.plot_joint_angles(varied(), BASE),
    "angles of a walk": lambda: plot.plot_joint_angles(two_steps(), BASE),
    "angles in one": lambda: plot.plot_joint_angles(varied(), BASE, axes=plt.subplots(layout="constrained")[1]),
    "residual": lambda: one(plot.plot_residual(varied(), BASE)),
    "residual of a walk": lambda: one(plot.plot_residual(two_steps(), BASE)),
    "joints": lambda: plot.plot_joint_trajectory(two_steps()),
    "joints in one": lambda: plot.plot_joint_trajectory(two_steps(), axes=plt.subplots(layout="constrained")[1]),
    "spread": spread,
    "import": lambda: plot.plot_import(level_report()),
    "comparison": lambda: plot.plot_comparison(compared()),
    "comfort": lambda: plot.plot_comfort(comforts()),
    "terrain": lambda: one(plot.plot_terrain(made_plan().terrain)),
    "terrain in one": lambda: one(plot.plot_terrain(made_plan().terrain, ax=plt.subplots(layout="constrained")[1])),
    "plan": lambda: tuple(plot.plot_plan(made_plan()).figure.axes),
    "plan in one": lambda: one(plot.plot_plan(made_plan(), ax=plt.subplots(layout="constrained")[1])),
}
HASHES = {
    "step": "7a88851ab3560493",
    "pit": "5e69db8fcd6bbd7b",
    "walk": "7e54b52a23f1d17d",
    "left first": "ed6c33fdaf41973b",
    "feet": "f2b911bac3426c6f",
    "stairs": "4907854a1782e548",
    "ramp": "c26f20a66c262882",
    "angles": "34223fe7350e8a40",
    "angles of a walk": "b216ace333ff5e03",
    "angles in one": "52eea2f9679db7bd",
    "residual": "8c97cd52da6d92fe",
    "residual of a walk": "89b2dafed9882e97",
    "joints": "57eb5be85aa5f596",
    "joints in one": "586c3367a45e8df8",
    "spread": "586aae04c580f44d",
    "import": "e1666315017e2d30",
    "comparison": "f003b4f223ec9bd5",
    "comfort": "4c51043d5f3056be",
    "terrain": "2f0ea8c5507f0aa0",
    "terrain in one": "33f1878e7d9307b7",
    "plan": "8c2700d9e15be7e6",
    "plan in one": "ad648cc215bcae73",
}


@pytest.fixture(autouse=True)
def close_figures() -> Iterator[None]:
    yield
    plt.close("all")


@cache
def panels_of(name: str) -> tuple[Axes, ...]:
    """The panels of a figure, made once: no test changes them, and a closed figure can be drawn all the same."""
    return FIGURES[name]()


@pytest.fixture(params=FIGURES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def figure_of(panels: tuple[Axes, ...]) -> Figure:
    figure = panels[0].get_figure()
    assert figure is not None
    return figure


def legends_of(panels: tuple[Axes, ...]) -> list[mpl.legend.Legend]:
    own = [ax.get_legend() for ax in panels if ax.get_legend() is not None]
    return [*figure_of(panels).legends, *own]


def insets_of(ax: Axes) -> list[Axes]:
    return list(ax.child_axes)


def test_what_is_drawn_is_what_was(name):
    figure = figure_of(panels_of(name))
    assert digest(figure) == HASHES.get(name), "if it is meant, look at the picture and change HASHES:\n" + "\n".join(
        line[:160] for line in drawn(figure)
    )


def test_a_legend_names_what_is_drawn_and_nothing_else(name):
    panels = panels_of(name)
    artists = [a for ax in panels for a in (*ax.lines, *ax.patches, *ax.collections)]
    labels = {a.get_label(): a for a in artists if not a.get_label().startswith("_")}
    bars = {container.get_label() for ax in panels for container in ax.containers}
    words = [text.get_text() for legend in legends_of(panels) for text in legend.get_texts()]
    assert sorted(words) == sorted({*labels, *bars} - {""})
    assert len(words) == len(set(words))


def test_a_legend_has_the_colours_of_what_it_names(name):
    panels = panels_of(name)
    lines = {(line.get_label(), to_hex(line.get_color())) for ax in panels for line in ax.lines}
    for legend in legends_of(panels):
        shown = {to_hex(line.get_color()) for line in legend.get_lines()}
        assert shown <= {colour for label, colour in lines if not label.startswith("_")} | {
            colours(artist).partition("/")[2][:7] for ax in panels for artist in ax.collections
        }


def test_new_figures_have_a_title_and_given_axes_do_not(name):
    title = figure_of(panels_of(name)).get_suptitle()
    assert (title == "") == name.endswith("in one")
    if not name.endswith("in one") and name not in ("import", "comparison", "comfort", "terrain"):
        assert "paper base gait" in title.lower()
        assert re.search(r"strides? 0\.\d{3}.* m", title)


def test_no_text_lies_on_another(name):
    panels = panels_of(name)
    figure = figure_of(panels)
    figure.draw_without_rendering()
    axes = [*panels, *(inset for ax in panels for inset in insets_of(ax))]
    texts: list[Text] = [t for legend in legends_of(panels) for t in legend.get_texts()]
    texts += [figure._suptitle] if figure._suptitle is not None else []
    for ax in axes:
        texts += [ax.title, *ax.texts]
        for axis in (ax.xaxis, ax.yaxis):
            low, high = sorted(axis.get_view_interval())
            texts += [axis.label, *(t.label1 for t in axis.get_major_ticks() if low <= t.get_loc() <= high)]
    boxes = [(t.get_text(), t.get_window_extent()) for t in texts if t.get_text() and t.get_visible()]
    for (text, box), (other, beside) in combinations(boxes, 2):
        over = min(box.x1, beside.x1) - max(box.x0, beside.x0), min(box.y1, beside.y1) - max(box.y0, beside.y0)
        assert min(over) <= 1.0, f"{text!r} on {other!r}"
    for text, box in boxes:
        assert figure.bbox.x0 - 1.0 <= box.x0 <= box.x1 <= figure.bbox.x1 + 1.0, text
        assert figure.bbox.y0 - 1.0 <= box.y0 <= box.y1 <= figure.bbox.y1 + 1.0, text


# -- legs ---------------------------------------------------------------------------------------------------------


def test_a_leg_has_one_colour_in_all_panels_of_all_figures():
    walk = two_steps()
    right, left = (to_hex(plot.LEG_COLOURS[leg]) for leg in ("right", "left"))
    for panels in (plot.plot_joint_trajectory(walk), plot.plot_joint_trajectory(walk, axes=plt.subplots()[1])):
        for ax in panels:
            for line in ax.lines:
                if line.get_gid() != "swap":
                    named = line.get_label() if len(panels) == 1 else ax.get_title()
                    assert to_hex(line.get_color()) == (right if named.startswith("right") else left)
    ax = plot.plot_stick_figure(walk)
    assert {(line.get_label(), to_hex(line.get_color())) for line in ax.lines if "leg" in line.get_label()} == {
        ("right leg", right),
        ("left leg", left),
        ("legs swap", to_hex("k")),
    }
    residual = plot.plot_residual(walk, BASE)
    swings = {line.get_label(): to_hex(line.get_color()) for line in residual.lines if line.get_gid() == "residual"}
    assert swings == {"right leg swings": right, "left leg swings": left}
    # The last step is in full colour: the right leg supports in it.
    for number, ax in enumerate(plot.plot_joint_angles(walk, BASE)):
        assert to_hex(ax.lines[-1].get_color()) == (right if number < 2 else left)
    for number, ax in enumerate((*plot.plot_joint_angles(varied()), *spread())):
        assert to_hex(ax.lines[-1].get_color()) == (left if number % 4 < 2 else right)
    for ax in plot.plot_import(level_report()):
        (mean,) = (line for line in ax.lines if line.get_gid() == "mean")
        assert to_hex(mean.get_color()) == (right if ax.get_title().startswith("right") else left)


def test_the_leg_that_lands_keeps_its_place_and_its_colour_in_the_next_step():
    ax = plot.plot_stick_figure(two_steps(), frames=[0, 25, 50])
    legs = [line for line in ax.lines if line.get_marker() == "o"]
    landed, supports = legs[5], legs[6]
    np.testing.assert_allclose(landed.get_xydata()[-1], supports.get_xydata()[0])
    for line, leg in ((landed, "right"), (legs[8], "right"), (legs[9], "left")):
        np.testing.assert_allclose(line.get_color(), mpl.colors.to_rgb(plot.LEG_COLOURS[leg]))


def test_swaps_are_marked_at_the_hip_and_in_time():
    walk = two_steps()
    (mark,) = (line for line in plot.plot_stick_figure(walk).lines if line.get_gid() == "swap")
    np.testing.assert_allclose(mark.get_xydata(), [walk.model.joints(walk.gaits[0].frames[-1])[2]])
    for ax in plot.plot_joint_trajectory(walk):
        (mark,) = (line for line in ax.lines if line.get_gid() == "swap")
        np.testing.assert_allclose(mark.get_xdata(), walk.gaits[0].duration)
    (mark,) = (line for line in plot.plot_residual(walk, BASE).lines if line.get_gid() == "swap")
    np.testing.assert_allclose(mark.get_xdata(), 50.0)
    assert not any(line.get_gid() == "swap" for line in plot.plot_stick_figure(BASE).lines)


def test_of_many_steps_the_legend_names_the_first_and_the_last():
    walk = two_steps()
    many = Walk(walk.gaits * 4, walk.plan * 4)
    (legend,) = plot.plot_joint_angles(many)[0].figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["step 1, right swings", "step 8, left swings"]
    one_axes = plot.plot_joint_angles(many, axes=plt.subplots()[1])[0]
    assert len(one_axes.get_legend().get_texts()) == 8  # four angles, twice


# -- feet -----------------------------------------------------------------------------------------------------------


def test_feet_stand_on_the_ground_and_hang_on_their_ankles():
    walk, foot = with_feet(), FEET.foot
    ax = plot.plot_stick_figure(walk, frames=[0, 25, 50])
    feet = [line.get_xydata() for line in ax.lines if line.get_gid() == "foot"]
    paths = [line.get_xydata() for line in ax.lines if line.get_gid() == "swing ankle"]
    np.testing.assert_allclose(paths[0], walk.gaits[0].endpoints() + np.array([0.0, foot.ankle_height]))
    # Of the first step three swinging feet and the supporting one, of the second two and one.
    assert len(feet) == 7
    np.testing.assert_allclose(feet[2], [[0.0, 0.08], [-0.05, 0.0], [0.12, 0.0], [0.0, 0.08]], atol=1e-12)
    np.testing.assert_allclose(feet[0][0], paths[0][0])
    np.testing.assert_allclose(feet[0][1:3] - paths[0][0], [[-0.05, -0.08], [0.12, -0.08]])
    assert not any(line.get_gid() == "foot" for line in plot.plot_stick_figure(BASE).lines)


def test_a_foot_on_a_ramp_is_tilted_as_the_ramp():
    slope = 0.1
    ground = Ground((-1.0,), (0.0, -math.tan(slope)), (0.0, slope))
    ax = plot.plot_stick_figure(BASE, model=FEET, ground=ground)
    for foot in (line.get_xydata() for line in ax.lines if line.get_gid() == "foot"):
        rise = foot[2] - foot[1]
        assert math.atan2(rise[1], rise[0]) == pytest.approx(slope)
        assert math.hypot(*rise) == pytest.approx(FEET.foot.heel + FEET.foot.toe)
    supporting = next(
        line.get_xydata() for line in ax.lines if line.get_gid() == "foot" and abs(line.get_xydata()[0, 0]) < 1e-12
    )
    np.testing.assert_allclose(supporting[1:3, 1], ground.height_at(supporting[1:3, 0]), atol=1e-12)


# -- boxes ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [BASE.model, FEET])
@pytest.mark.parametrize("box", [BOX, SEEN, Obstacle(0.1, 0.15, 0.09)])
def test_an_inset_says_the_clearance_of_the_report(box, model):
    ax = plot.plot_stick_figure(varied(), model=model, obstacles=[box])
    report = verify(varied(), model, obstacles=[box])
    (inset,) = insets_of(ax)
    assert inset.get_title() == f"{1e3 * report.clearance:.1f} mm".replace("-", "\u2212")
    (beam,) = (line.get_xydata() for line in inset.lines if line.get_gid() == "clearance")
    assert beam[1, 1] - beam[0, 1] == pytest.approx(report.clearance)
    assert beam[0, 1] == pytest.approx(box.height)
    assert box.x_start <= beam[0, 0] <= box.x_end
    (passing,) = (line.get_xydata() for line in inset.lines if line.get_gid() == "passing")
    assert np.interp(beam[0, 0], *passing[passing[:, 0].argsort()].T) == pytest.approx(beam[1, 1], abs=1e-4) or (
        len(passing) > 2  # the path comes back over the box
    )
    # It stands above the legs, and shows what it says.
    assert inset.get_xlim()[0] < beam[0, 0] < inset.get_xlim()[1]
    assert inset.get_ylim()[0] < min(beam[:, 1]) <= max(beam[:, 1]) < inset.get_ylim()[1]


def test_a_walk_has_an_inset_for_each_box_and_no_more():
    walk = two_steps(obstacles=(BOX, SEEN))
    reports = [verify(walk.gaits[1], obstacles=[box]) for box in (SEEN, BOX)]
    said = [inset.get_title() for inset in insets_of(plot.plot_stick_figure(walk))]
    assert said == [f"{1e3 * report.clearance:.1f} mm".replace("-", "\u2212") for report in reports]
    # The same box, seen by both steps from where each stands.
    (_, origin) = walk.origins()
    both = Walk(walk.gaits, (replace(walk.plan[0], obstacles=(BOX.shifted(-origin[0]),)), Step((0.39, 0.0), (BOX,))))
    assert len(insets_of(plot.plot_stick_figure(both))) == 1
    assert insets_of(plot.plot_stick_figure(BASE, obstacles=[Obstacle(2.0, 2.1, 0.1)])) == []


def test_insets_stand_side_by_side_within_the_axes():
    boxes = [Obstacle(0.05 * k, 0.05 * k + 0.02, 0.01) for k in range(8)]
    ax = plot.plot_stick_figure(BASE, obstacles=boxes)
    ax.figure.draw_without_rendering()
    frames = [inset.get_window_extent() for inset in insets_of(ax)]
    assert len(frames) > 1
    for left, right in pairwise(frames):
        assert left.x1 < right.x0
    assert all(ax.bbox.x0 <= frame.x0 and frame.x1 <= ax.bbox.x1 and frame.y1 <= ax.bbox.y1 for frame in frames)


def filled(patch: mpl.patches.Patch, point: tuple[float, float]) -> bool:
    """Whether a patch covers a point: an odd number of its closed lines go around it."""
    return sum(Path(line).contains_point(point) for line in patch.get_path().to_polygons()) % 2 == 1


def test_the_band_of_a_measured_box_holds_95_of_100():
    assert pytest.approx(math.erf(BAND / math.sqrt(2.0))) == 0.95
    ax = plot.plot_stick_figure(BASE, obstacles=[SEEN, BOX])
    (band,) = (patch for patch in ax.patches if patch.get_gid() == "obstacle band")
    corners = band.get_path().vertices
    aside, over = BAND * SEEN.edge_std, BAND * SEEN.height_std
    np.testing.assert_allclose(corners.min(axis=0), [SEEN.x_start - aside, 0.0])
    np.testing.assert_allclose(corners.max(axis=0), [SEEN.x_end + aside, SEEN.height + over])
    # Inside it is open, where the box is for sure; a box thinner than its error has no such place.
    middle = (SEEN.x_start + SEEN.x_end) / 2.0
    for point, inside in (((middle, 0.005), False), ((middle, SEEN.height), True), ((SEEN.x_end, 0.005), True)):
        assert filled(band, point) is inside
    thin = Obstacle(0.2, 0.21, 0.02, edge_std=0.01)
    ax = plot.plot_stick_figure(BASE, obstacles=[thin])
    (band,) = (patch for patch in ax.patches if patch.get_gid() == "obstacle band")
    assert filled(band, (0.205, 0.005))


# -- ground -----------------------------------------------------------------------------------------------------------


def test_the_line_of_the_ground_has_its_risers_and_ramps():
    assert Ground().line(-1.0, 2.0).tolist() == [[-1.0, 0.0], [2.0, 0.0]]
    stairs = Ground((0.3, 0.6), (0.0, 0.1, 0.2)).line(0.0, 0.5)
    np.testing.assert_allclose(stairs, [[0.0, 0.0], [0.3, 0.0], [0.3, 0.1], [0.5, 0.1]])
    rise = math.tan(0.1)
    ramp = Ground((0.2, 1.2), (0.0, 0.0, rise), (0.0, 0.1, 0.0)).line(0.0, 2.0)
    np.testing.assert_allclose(ramp, [[0, 0], [0.2, 0], [0.2, 0], [1.2, rise], [1.2, rise], [2.0, rise]], atol=1e-12)


# -- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["walk", "angles"])
def test_text_of_vector_files_stays_text(name, tmp_path):
    figure = figure_of(panels_of(name))
    with mpl.rc_context(plot.VECTOR_TEXT):
        figure.savefig(tmp_path / "picture.svg")
        figure.savefig(tmp_path / "picture.pdf")
    text = (tmp_path / "picture.svg").read_text(encoding="utf-8")
    for line in figure.get_suptitle().splitlines():
        assert f">{line}</text>" in text
    pdf = (tmp_path / "picture.pdf").read_bytes()
    assert b"/Type3" not in pdf
    assert b"/CIDFontType2" in pdf
    assert b"/Subtype /Image" not in pdf
