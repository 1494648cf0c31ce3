"""The best division of a height profile into level and sloped pieces, by dynamic programming over all break points.

I. E. Auger, C. E. Lawrence, "Algorithms for the optimal identification of segment neighborhoods", Bulletin of
Mathematical Biology 1989; with a price for each piece: B. Jackson and others, "An algorithm for optimal partitioning of
data on an interval", IEEE Signal Processing Letters 2005. Beside them a cell may belong to no piece, at a price of its
own: sides of boxes, flying pixels. A profile has some 300 cells, so that what R. Killick and others prune (PELT, 2012)
would not pay.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ggo_factors.motion.terrain import STEEPEST
from ggo_factors.seeing.profile import Profile

PIECE_PRICE, SLOPE_PRICE, STRAY_PRICE = 25.0, 15.0, 9.0
"""What a piece costs, what its slope costs beside, and what a cell in no piece costs, in squared standard deviations:
three cells make a piece, a stray one is 3 of them off."""
MIXED = 0.01
"""A cell that is off by more than this in [m] is in no piece: it sees both before and behind an edge."""
LONG_ENOUGH = 0.15
"""Pieces shorter than this in [m] say nothing of the slope that all have in common."""
TILT_STD = math.radians(0.1)
"""What is left of a wrong `up` in [rad] after it was found from level ground."""
SLACK = math.radians(1.5)
"""How much steeper than any ramp a piece may be in [rad], for a camera that is told a wrong `up`."""


@dataclass(frozen=True, eq=False)
class Piece:
    """Cells on one straight line.

    Attributes:
        cells: their numbers, ascending.
        x_start: x of the first in [m].
        x_end: x of the last in [m].
        middle: where its height is known best, in [m].
        height: its height there in [m].
        slope: its rise by metre.
        height_var: variance of `height` in [m^2].
        slope_var: variance of `slope`.
        noise: how far single points scatter around it in [m].
    """

    cells: NDArray[np.int64]
    x_start: float
    x_end: float
    middle: float
    height: float
    slope: float
    height_var: float
    slope_var: float
    noise: float

    @property
    def length(self) -> float:
        """From its first cell to its last in [m]."""
        return self.x_end - self.x_start

    def at(self, x: float) -> float:
        """Its height in [m] at `x` in [m]."""
        return self.height + self.slope * (x - self.middle)

    def var_at(self, x: float) -> float:
        """Variance of its height at `x`, in [m^2]."""
        return self.height_var + self.slope_var * (x - self.middle) ** 2


def pieces_of(profile: Profile, least_slope: float = 0.0) -> list[Piece]:
    """The pieces of a profile, from near to far.

    Args:
        profile: the profile.
        least_slope: pieces of a smaller rise by metre are level.
    """
    clear = np.flatnonzero(profile.std < MIXED)
    return [_fitted(profile, clear[i:j], sloped, least_slope) for i, j, sloped in _divided(profile, clear)]


def _divided(profile: Profile, clear: NDArray[np.int64]) -> list[tuple[int, int, bool]]:
    """First cell, cell behind the last, and whether it slopes, of each piece of the cheapest division.

    Cells are counted among those that are clear.
    """
    weight = 1.0 / profile.std[clear] ** 2
    x, y = profile.x[clear], profile.height[clear]
    sums = np.zeros((6, len(x) + 1))
    np.cumsum([weight, weight * x, weight * y, weight * x * x, weight * x * y, weight * y * y], axis=1, out=sums[:, 1:])
    steepest = math.tan(STEEPEST + SLACK)
    best, before, kind = np.zeros(len(x) + 1), np.zeros(len(x) + 1, np.int64), np.zeros(len(x) + 1, np.int64)
    for end in range(1, len(x) + 1):
        w, wx, wy, wxx, wxy, wyy = sums[:, end, None] - sums[:, :end]
        level = wyy - wy**2 / w
        across, along = wxy - wx * wy / w, np.maximum(wxx - wx**2 / w, 1e-12)
        slope = np.clip(across / along, -steepest, steepest)
        sloped = level - slope * (2.0 * across - slope * along) + SLOPE_PRICE
        cost = best[:end] + np.minimum(level, sloped) + PIECE_PRICE
        start = int(cost.argmin())
        stray = best[end - 1] + STRAY_PRICE
        if stray <= cost[start]:
            best[end], before[end], kind[end] = stray, end - 1, 0
        else:
            best[end], before[end], kind[end] = cost[start], start, 1 + (sloped[start] < level[start])
    found, end = [], len(x)
    while end:
        if kind[end]:
            found.append((int(before[end]), end, bool(kind[end] == 2)))
        end = int(before[end])
    return found[::-1]


def _fitted(profile: Profile, cells: NDArray[np.int64], sloped: bool, least_slope: float) -> Piece:
    x, y, w = profile.x[cells], profile.height[cells], 1.0 / profile.std[cells] ** 2
    total = float(w.sum())
    middle, height = float(w @ x) / total, float(w @ y) / total
    along = max(float(w @ (x - middle) ** 2), 1e-12)
    slope = float(w @ ((x - middle) * (y - height))) / along if sloped else 0.0
    if abs(slope) < least_slope:
        slope, sloped = 0.0, False
    off = y - height - slope * (x - middle)
    # What scatters more than it should says so of its mean.
    excess = max(1.0, float(w @ off**2) / max(len(cells) - 2, 1))
    return Piece(
        cells,
        float(x[0]),
        float(x[-1]),
        middle,
        height,
        slope,
        excess / total,
        excess / along if sloped else 0.0,
        float(np.median(profile.noise[cells])),
    )


def merged(profile: Profile, pieces: list[Piece], apart: float, least_slope: float) -> list[Piece]:
    """The pieces, neighbours on one line made one.

    Args:
        profile: the profile they are of.
        pieces: from near to far.
        apart: lines that differ by less in [m] where they meet, and hardly in slope, are one.
        least_slope: as in `pieces_of`.
    """
    found = list[Piece]()
    for piece in pieces:
        while found:
            last = found[-1]
            joined = _fitted(
                profile, np.concatenate([last.cells, piece.cells]), bool(last.slope or piece.slope), least_slope
            )
            ends = [(one, x) for one in (last, piece) for x in (one.x_start, one.x_end)]
            if max(abs(joined.at(x) - one.at(x)) for one, x in ends) > apart:
                break
            found.pop()
            piece = joined
        found.append(piece)
    return found


def tilt_of(profile: Profile, pieces: list[Piece], most: float) -> tuple[float, float]:
    """The slope in [rad] that all level ground has in common, by a wrong `up`, and its standard deviation.

    Args:
        profile: the profile.
        pieces: its pieces.
        most: pieces of a larger rise by metre are ramps.
    """
    fitted = [_fitted(profile, piece.cells, True, 0.0) for piece in pieces if piece.length > LONG_ENOUGH]
    level = [piece for piece in fitted if abs(piece.slope) < most]
    if not level:
        return 0.0, most / 3.0
    weight = np.array([piece.length**3 for piece in level])
    return math.atan(float(weight @ [piece.slope for piece in level]) / float(weight.sum())), TILT_STD
