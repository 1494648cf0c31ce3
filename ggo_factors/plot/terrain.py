"""The ground, boxes and pits of a picture, each step's where its supporting foot stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.plot.panels import GROUND_COLOUR, OBSTACLE_COLOUR

BAND = NormalDist().inv_cdf(0.975)
"""Standard deviations to either side of a measured edge or height between which the true one is in 95 of 100 boxes."""
PIT_DEPTH = 0.06
"""How deep a pit is drawn in [m]; how deep it is nobody says."""
BAND_COLOUR = "#E69F00"
"""Colour of what was measured with an error."""


@dataclass(frozen=True)
class Place:
    """What one step has around it, and where its supporting foot stands in the picture.

    Attributes:
        x: place of the supporting ankle in [m].
        y: height of the ground under it in [m].
        ground: the ground as the step sees it, 0 under the supporting foot.
        boxes: the step's obstacles.
        pits: the step's gaps.
    """

    x: float
    y: float
    ground: Ground
    boxes: tuple[Obstacle, ...]
    pits: tuple[Gap, ...]

    @property
    def own_boxes(self) -> tuple[Obstacle, ...]:
        """The boxes but those that only stand for the edge of a stair, and so are part of the ground's picture."""
        return tuple(box for box in self.boxes if not self.ground.is_edge(box))


def draw_boxes(ax: Axes, place: Place) -> None:
    """The boxes of a step on their ground, each with the band of its errors."""
    for box in place.own_boxes:
        middle = (box.x_start + box.x_end) / 2.0
        bottom = place.y + min(float(place.ground.height_at(middle)), box.height)
        draw_box(ax, box.shifted(-place.x), bottom, place.y + box.height)


def draw_box(ax: Axes, box: Obstacle, bottom: float, top: float) -> None:
    """A box from `bottom` to `top` in [m], and where its edges and its height are in 95 of 100 cases."""
    size = box.x_end - box.x_start, top - bottom
    style: dict[str, Any] = {"facecolor": OBSTACLE_COLOUR, "edgecolor": "k", "lw": 0.8, "zorder": 2.5}
    ax.add_patch(Rectangle((box.x_start, bottom), *size, gid="obstacle", label="obstacle", **style))
    if box.is_uncertain:
        aside, over = BAND * box.edge_std, BAND * box.height_std
        ring = _corners(box.x_start - aside, box.x_end + aside, bottom, top + over)
        inner = box.x_start + aside, box.x_end - aside, bottom, max(top - over, bottom)
        if inner[0] < inner[1] and inner[2] < inner[3]:
            ring = Path.make_compound_path(ring, _corners(*inner, around=-1))
        label = "95 % of edges and heights"
        style = {"facecolor": BAND_COLOUR, "edgecolor": BAND_COLOUR, "lw": 0.6, "ls": ":", "zorder": 2.6}
        ax.add_patch(PathPatch(ring, alpha=0.45, gid="obstacle band", label=label, **style))


def _corners(left: float, right: float, bottom: float, top: float, around: int = 1) -> Path:
    """A closed rectangle, the other way around, so that it is a hole, with `around` -1."""
    corners = [(left, bottom), (right, bottom), (right, top), (left, top), (left, bottom)]
    return Path(corners[::around], [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.LINETO])


def draw_pits(ax: Axes, place: Place) -> None:
    """The pits of a step, but for ground that nobody saw."""
    for gap in place.pits:
        if gap.unknown:
            continue
        bottom = place.y + float(place.ground.height_at((gap.x_start + gap.x_end) / 2.0)) - PIT_DEPTH
        corner, width = (place.x + gap.x_start, bottom), gap.x_end - gap.x_start
        style: dict[str, Any] = {"facecolor": "w", "edgecolor": "k", "hatch": "////", "lw": 0.8, "zorder": 1.5}
        ax.add_patch(Rectangle(corner, width, PIT_DEPTH, gid="gap", label="gap", **style))


def draw_unseen(ax: Axes, place: Place) -> None:
    """Ground that nobody saw, as far as the picture reaches: it may go on for a hundred metres."""
    left, right = ax.get_xlim()
    for gap in place.pits:
        start, end = max(place.x + gap.x_start, left), min(place.x + gap.x_end, right)
        if gap.unknown and start < end:
            bottom = place.y + float(place.ground.height_at(start - place.x)) - PIT_DEPTH
            style: dict[str, Any] = {"facecolor": "w", "edgecolor": "k", "ls": ":", "lw": 0.8, "zorder": 1.5}
            patch = Rectangle((start, bottom), end - start, PIT_DEPTH, gid="unseen", label="ground nobody saw", **style)
            ax.add_patch(patch)


def draw_grounds(ax: Axes, places: Sequence[Place]) -> None:
    """The ground of each step, from its supporting ankle to the next one's; beyond at both ends."""
    ax.margins(0.04)
    ax.autoscale_view()
    left, right = ax.get_xlim()
    lowest, top = ax.get_ylim()
    borders = [left, *(place.x for place in places[1:]), right]
    pieces = [
        place.ground.line(low - place.x, high - place.x) + np.array([place.x, place.y])
        for place, low, high in zip(places, borders[:-1], borders[1:], strict=True)
        if low < high
    ]
    line = np.concatenate(pieces)
    bottom = min(lowest, float(line[:, 1].min())) - 0.05
    ax.fill_between(line[:, 0], line[:, 1], bottom, color=GROUND_COLOUR, lw=0.0, zorder=0.5, gid="ground")
    ax.plot(*line.T, color="k", lw=1.0, zorder=1.0, gid="ground")
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
