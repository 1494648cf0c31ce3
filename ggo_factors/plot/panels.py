"""What the pictures share: colours, names, panels, legends, titles."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from ggo_factors.errors import InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.support.inputs import as_tuple_of
from ggo_factors.walking.walk import Walk

# The colours of Okabe and Ito, which colour-blind readers can tell apart.
SUPPORT_COLOUR, SWING_COLOUR, PATH_COLOUR = "#0072B2", "#D55E00", "#009E73"
LEG_COLOURS = {"right": SWING_COLOUR, "left": SUPPORT_COLOUR}
BASE_COLOUR, GROUND_COLOUR, OBSTACLE_COLOUR = "#555555", "#DDD8CF", "#8C6D31"

ANGLE_NAMES = (r"$\alpha_1$", r"$\beta_1$", r"$\alpha_2$", r"$\beta_2$")
ANGLE_COLOURS = (SUPPORT_COLOUR, "#56B4E9", SWING_COLOUR, "#E69F00")
ANGLE_TITLES = ("support thigh", "support knee", "swing thigh", "swing knee")
JOINT_STYLES = ("-", "--")
"""Line of a thigh and of a knee where both are in one panel: their colour is the leg's."""

VECTOR_TEXT: dict[Any, Any] = {"svg.fonttype": "none", "pdf.fonttype": 42, "ps.fonttype": 42}
"""Settings for `matplotlib.rc_context` around `savefig`: text in SVG and PDF stays text, to be searched and edited."""
LETTERS_PER_INCH = 13.0
"""Letters of a title to an inch of its figure, a few less than fit."""
WIDE = 6.2
"""Width of a figure in inches from which a legend has four entries in a row, else three."""


def gaits_of(walk: Walk | Solution | Gait) -> tuple[Gait, ...]:
    """The gait of each step.

    Raises:
        InputError: where it is something else.
    """
    if isinstance(walk, Walk):
        return walk.gaits
    if isinstance(walk, Solution):
        return (walk.gait,)
    if isinstance(walk, Gait):
        return (walk,)
    raise InputError(f"gait: expected a Gait, a Solution or a Walk, got {walk!r:.80}")


def legs_of_step(walk: Walk, number: int) -> tuple[str, str]:
    """The leg that supports and the one that swings, ``"right"`` or ``"left"``, in a step of a walk from 0."""
    first = walk.first_swing
    other = "left" if first == "right" else "right"
    return (first, other) if number % 2 else (other, first)


def lighter(colour: str, shade: float) -> tuple[float, float, float]:
    """A colour mixed with white, not made see-through: overlapping lines would show through one another."""
    rgb = np.array(matplotlib.colors.to_rgb(colour))
    red, green, blue = (1.0 - shade * (1.0 - rgb)).tolist()
    return (red, green, blue)


def new_axes(rows: int, columns: int, size: tuple[float, float]) -> tuple[Axes, ...]:
    """The axes of a new figure of a size in inches, row by row."""
    # Only pyplot gives a figure that a notebook or a window will show.
    from matplotlib import pyplot

    _, axes = pyplot.subplots(rows, columns, figsize=size, layout="constrained", sharex=True, squeeze=False)
    return tuple(axes.flat)


def four_panels(axes: Axes | Sequence[Axes] | None) -> tuple[Axes, ...]:
    """The four panels of a new figure, or the one or four that are given.

    Raises:
        InputError: where it is another number, or not axes.
    """
    if axes is None:
        return new_axes(2, 2, (7.2, 4.8))
    panels = given_axes(axes)
    if len(panels) not in (1, 4):
        raise InputError(f"axes: expected one or four, got {len(panels)}")
    return panels


def given_axes(axes: Axes | Iterable[Axes]) -> tuple[Axes, ...]:
    """The axes that a user gave, one or several, also as the array that `pyplot.subplots` makes.

    Raises:
        InputError: where something else is among them.
    """
    if isinstance(axes, Axes):
        return (axes,)
    return as_tuple_of(axes.ravel() if isinstance(axes, np.ndarray) else axes, "axes", Axes)


def finish_panels(panels: Sequence[Axes], x_label: str, y_label: str) -> None:
    """Grid and labels; in a grid of panels only where they are the outermost."""
    for ax in panels:
        ax.grid(True, color="#E4E4E4", lw=0.6)
        ax.set_axisbelow(True)
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        place = ax.get_subplotspec()
        if len(panels) > 1 and place is not None:
            ax.xaxis.label.set_visible(place.is_last_row())
            ax.yaxis.label.set_visible(place.is_first_col())


def show_legend(panels: Sequence[Axes]) -> None:
    """A legend over one axes, or below the figure of several, in place of the one that was there.

    It has an entry for each label of what is drawn, and no other. Where several colours share a label, as the two legs
    of one gait do, the entry shows two of them.
    """
    entries: dict[str, dict[str, Any]] = {}
    order: dict[str, tuple[bool, int]] = {}
    for ax in panels:
        for place, (handle, label) in enumerate(zip(*ax.get_legend_handles_labels(), strict=True)):
            entries.setdefault(label, {}).setdefault(_colour_of(handle), handle)
            # As they are drawn in their panels; but bars first, which name the gaits that the marks in them are of.
            order.setdefault(label, (not isinstance(handle, BarContainer), place))
    entries = {label: entries[label] for label in sorted(entries, key=lambda label: order[label])}
    handles: list[Any] = [
        tuple(list(drawn.values())[:2]) if len(drawn) > 1 else next(iter(drawn.values())) for drawn in entries.values()
    ]
    style: dict[str, Any] = {
        "frameon": False,
        "fontsize": "small",
        "handler_map": {tuple: HandlerTuple(ndivide=None, pad=0.4)},
    }
    figure = panels[0].get_figure()
    assert figure is not None  # axes that can be drawn on are in a figure
    width = figure.bbox.width / figure.dpi
    rows = math.ceil(len(handles) / (4 if width >= WIDE else 3))
    style["ncols"] = math.ceil(len(handles) / max(rows, 1))
    if len(panels) == 1:
        if handles:
            panels[0].legend(handles, list(entries), loc="lower center", bbox_to_anchor=(0.5, 1.0), **style)
        return
    for old in list(figure.legends):
        old.remove()
    if handles:
        figure.legend(handles, list(entries), loc="outside lower center", **style)


def _colour_of(handle: Any) -> str:
    """The colour that tells an artist of a legend from others."""
    if isinstance(handle, Line2D):
        return str(handle.get_color())
    if isinstance(handle, Collection):
        colours = np.concatenate([handle.get_facecolor(), handle.get_edgecolor()])
        return str(np.round(colours[0], 3).tolist())
    return type(handle).__name__


def name_figure(panels: Sequence[Axes], title: str) -> None:
    """A title over the figure of these axes, in as many lines as it needs."""
    figure = panels[0].figure
    assert isinstance(figure, Figure)  # it was made for these axes
    letters = int(LETTERS_PER_INCH * figure.get_figwidth())
    lines = [part for line in title.splitlines() for part in textwrap.wrap(line, letters)]
    # A name may hold dollar signs, and is no formula.
    figure.suptitle("\n".join(lines), fontsize="medium", parse_math=False)


def bases_of(base: Gait | Sequence[Gait] | None, count: int) -> tuple[Gait | None, ...]:
    """The base gait beside each of `count` steps: one for all of them, one each, or none.

    Raises:
        InputError: where there is another number of them.
    """
    if base is None or isinstance(base, Gait):
        return (base,) * count
    several = as_tuple_of(base, "base", Gait)
    if len(several) != count:
        raise InputError(f"base: {len(several)} base gaits for {count} steps; one, or one each")
    return several
