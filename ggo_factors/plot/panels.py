"""What the pictures share: colours, names, panels, legends."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes

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


def legend_above(ax: Axes, handles: Sequence[Any], columns: int) -> None:
    """A legend over the axes, where no data can be."""
    ax.legend(
        handles=list(handles),
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=columns,
        frameon=False,
        fontsize="small",
    )


def legend_above_all(panels: Sequence[Axes]) -> None:
    """The legend of one axes over it, or of four over their figure."""
    handles, labels = panels[0].get_legend_handles_labels()
    if not handles:
        return
    if len(panels) == 1:
        legend_above(panels[0], handles, min(len(handles), 4))
        return
    unique = dict(zip(labels, handles, strict=True))
    legend_above_figure(panels, list(unique.values()))


def legend_above_figure(panels: Sequence[Axes], handles: Sequence[Any]) -> None:
    """A legend over the figure of the axes, in place of the one that was there."""
    figure = panels[0].get_figure()
    assert figure is not None  # axes that can be drawn on are in a figure
    for old in list(figure.legends):
        old.remove()
    figure.legend(handles=list(handles), loc="outside upper center", ncols=4, frameon=False, fontsize="small")
