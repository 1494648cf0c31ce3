"""Where an edge is, from single points: of a side that the camera sees, of a rim behind which it sees nothing."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ggo_factors.seeing.pieces import Piece
from ggo_factors.seeing.profile import CELL
from ggo_factors.seeing.strip import WIDTH, Strip
from ggo_factors.support.inputs import Array

NEAR = 0.04
"""How far in [m] from where the profile breaks the points of an edge are looked for."""
RIM = 0.12
"""Over how much ground in [m] before a rim its points are counted, to tell how many there are by metre."""
FEW = 12
"""Fewer points tell nothing of an edge."""
LOST = 0.2
"""Share of a row of pixels that is lost at a rim: pixels that see both sides of it tell of neither."""
CLEAR = 6.0
"""A side lower than so many standard deviations of a point is told by where the height changes alone."""
FLOOR = 0.0015
"""No edge is known better than this in [m]: pixels beside it mix what is before and behind."""


class Place(NamedTuple):
    """A place along the way and its standard deviation, both in [m]."""

    x: float
    std: float


class Points:
    """The points of a strip in order of their x, which gives those of a window at once."""

    def __init__(self, strip: Strip) -> None:
        order = np.argsort(strip.x)
        self.x, self.y, self.eye = strip.x[order], strip.y[order], strip.eye

    def between(self, low: float, high: float) -> tuple[Array, Array]:
        """X and y of the points from `low` to `high` in [m]."""
        first, last = np.searchsorted(self.x, (low, high))
        return self.x[first:last], self.y[first:last]

    def row_spacing(self, x: float, y: float) -> float:
        """How far apart in [m] rows of pixels lie on level ground at x and y in [m].

        From the points by metre in the strip, for pixels that are as wide as they are high, seen from the eye.
        """
        number = len(self.between(x - NEAR, x + NEAR)[0]) / (2.0 * NEAR)
        distance, above = math.hypot(x - self.eye[0], y - self.eye[1]), max(self.eye[1] - y, 0.1)
        angle = math.sqrt(WIDTH * above / (max(number, 1.0) * distance**3))
        return min(max(distance**2 * angle / above, 0.002), 0.03)


def side(points: Points, low: float, high: float, bottom: float, top: float) -> Place | None:
    """Where a vertical side is: the points of one that the camera sees.

    Args:
        points: the points.
        low: the side is not before this in [m].
        high: nor beyond this.
        bottom: points below this in [m] are of the ground before it.
        top: points above this are of what it bears.
    """
    x, y = points.between(low, high)
    x = x[(y > bottom) & (y < top)]
    for _ in range(2):
        if len(x) < FEW:
            return None
        middle = float(np.median(x))
        spread = max(1.48 * float(np.median(np.abs(x - middle))), FLOOR)
        x = x[np.abs(x - middle) < 3.0 * spread]
    return Place(middle, math.hypot(1.25 * spread / math.sqrt(len(x)), FLOOR))


def combined(places: Iterable[Place | None]) -> Place | None:
    """One place from those that several frames tell, each weighted by its information; None where none does."""
    told = [place for place in places if place is not None]
    if not told:
        return None
    weights = [1.0 / place.std**2 for place in told]
    mean = sum(weight * place.x for weight, place in zip(weights, told, strict=True)) / sum(weights)
    return Place(mean, max(1.0 / math.sqrt(sum(weights)), FLOOR))


def rim(points: Points, piece: Piece, end: float, way: float, others: Array) -> Place | None:
    """Where a piece ends: its points are counted, as there are so many by metre.

    Args:
        points: the points.
        piece: the piece.
        end: where its cells end in [m].
        way: 1 for its far end, -1 for its near one.
        others: heights in [m] of the ground beyond, whose points are not to be counted.
    """
    length = min(RIM, 0.8 * piece.length)
    spacing = points.row_spacing(end - way * length / 2.0, piece.at(end))
    start = end - way * length
    x, y = points.between(min(start, end + way * NEAR), max(start, end + way * NEAR))
    band = max(3.0 * piece.noise, 0.006)
    if len(others):
        band = min(band, float(np.abs(others - piece.at(end)).min()) / 2.0)
    x = x[np.abs(y - piece.at(0.0) - piece.slope * x) < band]
    whole = end - way * min(0.02, length / 4.0)
    sure = (x - whole) * way < 0.0
    if sure.sum() < FEW:
        return None
    if length < NEAR:
        return Place(end + way * spacing / 2.0, math.hypot(0.6 * spacing, FLOOR))
    # On level ground points lie the denser the nearer they are: by the third power of the distance.
    weight = np.hypot(x - points.eye[0], piece.at(end) - points.eye[1]) ** 3
    by_metre = float(weight[sure].sum()) / abs(whole - start)
    further = float(weight.sum()) / by_metre + LOST * spacing - length
    further = min(max(further, -CELL), CELL / 2.0 + 2.2 * spacing)
    return Place(end + way * further, math.hypot(0.4 * spacing, FLOOR))


def change(points: Points, before: Piece, after: Piece, low: float, high: float) -> Place | None:
    """Where the height changes from one piece to the next: the most likely place, for low risers.

    Args:
        points: the points.
        before: the nearer piece.
        after: the farther one.
        low: the change is not before this in [m].
        high: nor beyond this.
    """
    x, y = points.between(low, high)
    spacing = points.row_spacing((low + high) / 2.0, before.at(low))
    if len(x) < FEW:
        return None
    one, other = y - before.at(0.0) - before.slope * x, y - after.at(0.0) - after.slope * x
    noise = max(before.noise, after.noise)
    gain = np.cumsum(np.clip(other**2 - one**2, -9.0 * noise**2, 9.0 * noise**2))
    place = int(gain.argmax())
    return Place(float(x[place] + x[min(place + 1, len(x) - 1)]) / 2.0, math.hypot(0.5 * spacing, 2.0 * FLOOR))
