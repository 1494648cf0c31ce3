"""Insets at the boxes of a picture: how far the swinging foot passes over each, in millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from ggo_factors.check.ground import lowest_in_span
from ggo_factors.check.verify import LEAST_INSTANTS, verify
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.plot.panels import GROUND_COLOUR, PATH_COLOUR
from ggo_factors.plot.terrain import BAND, Place, draw_box
from ggo_factors.support.inputs import Array

SIZE = (0.38, 0.30)
"""Width and height of an inset, by the length of a leg."""
BETWEEN = 1.2
"""Insets side by side stand so many of their widths apart."""
SAME = 0.01
"""Boxes of two steps whose edges and heights are no further apart than this, in [m], are one: a walk's later steps see
it from where the walker really stood."""
LEAST_VIEW, MOST_VIEW = 0.04, 0.12
"""Half the width of what an inset shows, in [m]: at least, and at most for the sake of the box alone."""


@dataclass(frozen=True, eq=False)
class Clearance:
    """How a swinging foot passes over a box, in the picture's frame.

    Attributes:
        box: the box.
        metres: the least height of the sole over it in [m], as the check's report has it; below 0 where it hits.
        x: where that is in [m], over the box.
        top: height of the box there in [m].
        path: what passes: the path of the swing ankle, or the sole where there are feet; shape (n, 2) in [m].
        bottom: height of what the box stands on in [m].
        colour: colour of the path.
    """

    box: Obstacle
    metres: float
    x: float
    top: float
    path: Array
    bottom: float
    colour: str


def clearances_of(gait: Gait, legs: LegModel, place: Place, colour: str) -> list[Clearance]:
    """The clearance over each box of a step that its swing ankle passes over, or its sole, drawn in `colour`."""
    found = []
    for box in place.own_boxes:
        # Each box by itself: the check then says its own clearance.
        metres = verify(gait, legs, obstacles=(box,)).clearance
        if math.isfinite(metres):
            ankle, path = _passing(gait, legs, box)
            middle = float(place.ground.height_at((box.x_start + box.x_end) / 2.0))
            found.append(
                Clearance(
                    box=box.shifted(-place.x),
                    metres=metres,
                    x=place.x + min(max(ankle, box.x_start), box.x_end),
                    top=place.y + box.height,
                    path=path + np.array([place.x, place.y]),
                    bottom=place.y + min(middle, box.height),
                    colour=colour if len(path) == 2 else PATH_COLOUR,
                )
            )
    return found


def _passing(gait: Gait, legs: LegModel, box: Obstacle) -> tuple[float, Array]:
    """Where the swing ankle is in [m] when it is lowest over the box, and its path, or its sole at that instant."""
    pieces = len(gait) - 1
    times = np.linspace(0.0, pieces, pieces * math.ceil(LEAST_INSTANTS / pieces) + 1)
    numbers = np.arange(len(gait))
    frames = np.stack([np.interp(times, numbers, angle) for angle in gait.frames.T], -1)
    path, foot = legs.endpoint(frames), legs.foot
    wide = box.for_ankle(foot)
    _, when = lowest_in_span(path, times, wide.x_start, wide.x_end)
    x, y = (float(np.interp(when, times, row)) for row in path.T)
    if foot.heel or foot.toe:
        return x, np.array([[x - foot.heel, y], [x + foot.toe, y]])
    return x, path


def draw_clearances(ax: Axes, found: Sequence[Clearance], reach: float) -> None:
    """An inset for each box above the legs, as many as fit side by side, those that pass closest first.

    Args:
        ax: axes with equal scales, whose limits are set; they are raised to make room.
        found: the clearances of all steps.
        reach: length of a leg in [m].
    """
    boxes = list[Clearance]()
    for clearance in sorted(found, key=lambda c: c.metres):
        if not any(_same(clearance.box, other.box) for other in boxes):
            boxes.append(clearance)
    width, height = SIZE[0] * reach, SIZE[1] * reach
    left, right = ax.get_xlim()
    shown = sorted(boxes[: max(int((right - left) / (BETWEEN * width)), 1)], key=lambda c: c.x)
    if not shown:
        return
    bottom, top = ax.get_ylim()
    apart = BETWEEN * width
    centres = [clearance.x for clearance in shown]
    # Beside each other from the left, then back inside from the right.
    for number in range(1, len(centres)):
        centres[number] = max(centres[number], centres[number - 1] + apart)
    limit = right - apart / 2.0
    for number in reversed(range(len(centres))):
        centres[number] = max(min(centres[number], limit), left + apart * (number + 0.5))
        limit = centres[number] - apart
    for clearance, centre in zip(shown, centres, strict=True):
        _draw_inset(ax, clearance, (centre - width / 2.0, top), (width, height))
    ax.set_ylim(bottom, top + height + 0.12 * reach)


def _same(box: Obstacle, other: Obstacle) -> bool:
    return max(abs(box.x_start - other.x_start), abs(box.x_end - other.x_end), abs(box.height - other.height)) <= SAME


def _draw_inset(ax: Axes, clearance: Clearance, corner: tuple[float, float], size: tuple[float, float]) -> None:
    """What is around the box, larger, in axes of their own, and a frame around it in the picture."""
    box, middle = clearance.box, clearance.top + clearance.metres / 2.0
    half = max(box.x_end - clearance.x, clearance.x - box.x_start) + BAND * box.edge_std + 0.01
    half = max(LEAST_VIEW, min(half, MOST_VIEW), 0.8 * abs(clearance.metres) * size[0] / size[1])
    tall = half * size[1] / size[0]
    inset = ax.inset_axes((*corner, *size), transform=ax.transData)
    inset.set(xlim=(clearance.x - half, clearance.x + half), ylim=(middle - tall, middle + tall), xticks=(), yticks=())
    if clearance.bottom > middle - tall:
        ends = [clearance.x - half, clearance.x + half]
        inset.fill_between(ends, middle - tall, clearance.bottom, color=GROUND_COLOUR, lw=0.0, zorder=0.5, gid="ground")
    draw_box(inset, box, clearance.bottom, clearance.top)
    inset.plot(*clearance.path.T, color=clearance.colour, lw=2.0, zorder=3.0, gid="passing")
    ends = [clearance.top, clearance.top + clearance.metres]
    beam: dict[str, Any] = {"color": "k", "marker": "_", "zorder": 4.0, "gid": "clearance"}
    inset.plot([clearance.x] * 2, ends, lw=1.0, ms=7, **beam)
    ax.plot([clearance.x] * 2, ends, lw=0.8, ms=4, label="clearance", **beam)
    inset.set_title(f"{1e3 * clearance.metres:.1f} mm".replace("-", "\u2212"), fontsize="x-small", pad=2.5)
    frame: dict[str, Any] = {"fill": False, "edgecolor": "#777777", "lw": 0.7, "zorder": 3.5, "gid": "zoom"}
    ax.add_patch(Rectangle((clearance.x - half, middle - tall), 2.0 * half, 2.0 * tall, **frame))
    ax.plot(
        [clearance.x, corner[0] + size[0] / 2.0], [middle + tall, corner[1]],
        color="#777777", lw=0.7, ls=":", zorder=0.9, gid="zoom",
    )  # fmt: skip
