"""The height profile of a strip: median and spread of the points in each cell along the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ggo_factors.seeing.strip import AHEAD, BEHIND
from ggo_factors.support.inputs import Array

CELL = 0.01
"""Length of a cell in [m]: finer than a foothold must be, and still of some 50 points."""
FEWEST = 5
"""A cell of fewer points is unknown."""
SHARE = 0.25
"""A cell with fewer than this share of the points of those around it is unknown: such points fly at an edge."""
LARGE_SHARE = 0.5
"""The same where points scatter three times as much as around: there all may be such points."""
AROUND = 31
"""Cells over which the noise of points is compared."""
WIDE = 61
"""Cells among which one with a quarter above it tells how many points ground has: not all of them are shadow."""
FLOOR = 0.002
"""What a cell's height is off in [m] beside the noise of its points: rows of pixels do not lie evenly in it."""


@dataclass(frozen=True)
class Profile:
    """Cells in which the ground was seen, from near to far; all arrays have shape (n,).

    Attributes:
        x: mean place of the points of each in [m].
        height: their median height in [m].
        std: standard deviation of that in [m].
        noise: how far single points scatter around the ground there in [m].
        low: height in [m] that a twentieth of its points are below; `high` is that of those above.
        high: see `low`.
        count: how many points it has.
    """

    x: Array
    height: Array
    std: Array
    noise: Array
    low: Array
    high: Array
    count: NDArray[np.int64]


def profile_of(x: Array, y: Array) -> Profile:
    """The profile of points at `x` and `y` in [m], shape (n,)."""
    cell = np.clip(((x - BEHIND) / CELL).astype(np.int64), 0, round((AHEAD - BEHIND) / CELL))
    bottom = float(y.min())
    order = np.argsort(cell + (y - bottom) / (float(y.max()) - bottom + 1.0))
    cell, y = cell[order], y[order]
    starts = np.flatnonzero(np.diff(cell, prepend=-1))
    count = np.diff(starts, append=len(cell))
    mean = np.add.reduceat(x[order], starts) / count

    def quantile(share: float) -> Array:
        place = share * (count - 1)
        whole = place.astype(np.int64)
        one, other = y[starts + whole], y[starts + np.minimum(whole + 1, count - 1)]
        return np.asarray(one + (place - whole) * (other - one))

    height, spread = quantile(0.5), (quantile(0.84) - quantile(0.16)) / 2.0
    usual = _around(count.astype(np.float64), WIDE, 0.75)
    noise = np.maximum(_around(spread, AROUND, 0.5), 5e-4)
    mixed = np.maximum(spread**2 - (2.0 * noise) ** 2, 0.0)
    std = np.sqrt(FLOOR**2 + 1.57 * noise**2 / count + mixed)
    good = count >= np.maximum(FEWEST, np.where(spread > 3.0 * noise, LARGE_SHARE, SHARE) * usual)
    values = (mean, height, std, noise, quantile(0.05), quantile(0.95))
    return Profile(*(value[good] for value in values), count[good])


def _around(values: Array, window: int, share: float) -> Array:
    """A quantile of each value and those around it, an odd number of them."""
    half = window // 2
    padded = np.pad(values, half, mode="reflect" if len(values) > half else "edge")
    return np.asarray(np.quantile(sliding_window_view(padded, window), share, axis=1))
