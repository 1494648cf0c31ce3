"""The height profile of a strip: the median and the spread of its points, direction by direction as the camera looks.

A camera errs along its rays. In cells along the way its points would be moved back and forth between neighbours, and
short treads tilted by that; in cells of directions they stay, and what flies at an edge is in one of them alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ggo_factors.errors import InputError
from ggo_factors.seeing.strip import AHEAD, BEHIND, Strip
from ggo_factors.support.inputs import Array

CELL = 0.01
"""Length of a cell on level ground in [m], near the camera: finer than a foothold must be."""
FINEST = 0.0025
"""Least angle of a cell in [rad]: about one row of pixels."""
LEAST_DEPRESSION = 0.05
"""Directions less than this in [rad] below the horizon are not looked at."""
LOWEST_EYE = 0.3
"""A camera lower than this above the foot in [m] is none that is worn."""
FEWEST = 5
"""A cell of fewer points is unknown."""
SHARE = 0.2
"""A cell with fewer than this share of the points of those around it is unknown."""
AROUND = 31
"""Cells over which points and noise are compared."""
FLOOR = 0.0015
"""What a cell's height is off in [m] beside the noise of its points."""


@dataclass(frozen=True, eq=False)
class Profile:
    """Cells in which something was seen, from near to far; all arrays have shape (n,).

    Attributes:
        x: place of each in [m].
        height: median height of its points in [m].
        std: standard deviation of that in [m].
        noise: how far single points scatter in height there, in [m].
        count: how many points it has.
    """

    x: Array
    height: Array
    std: Array
    noise: Array
    count: NDArray[np.int64]


def profile_of(strip: Strip) -> Profile:
    """The profile of the points of one frame.

    Raises:
        InputError: where the camera is not above the ground.
    """
    eye_x, eye_y = strip.eye
    if eye_y < LOWEST_EYE:
        raise InputError(
            f"points: must be in the camera's own frame, whose origin is {eye_y:.3g} m above the foot by up and at; "
            f"expected {LOWEST_EYE:g} m or more"
        )
    depression = np.arctan2(eye_y - strip.y, strip.x - eye_x)
    steep = np.arctan2(eye_y, np.arange(BEHIND, AHEAD, CELL))
    even = int(np.argmax(np.append(-np.diff(steep) < FINEST, True)))
    bounds = np.append(steep[: even + 1], np.arange(steep[even] - FINEST, LEAST_DEPRESSION, -FINEST))
    cell = len(bounds) - np.searchsorted(bounds[::-1], depression)
    inside = (cell > 0) & (cell < len(bounds))
    cell, y, depression = cell[inside], strip.y[inside], depression[inside]
    if not len(cell):
        raise InputError("points: none lies below the camera, where the ground is; check up")
    bottom = float(y.min())
    order = np.argsort(cell + (y - bottom) / (float(y.max()) - bottom + 1.0))
    cell, y = cell[order], y[order]
    starts = np.flatnonzero(np.diff(cell, prepend=-1))
    count = np.diff(starts, append=len(cell))
    direction = np.add.reduceat(depression[order], starts) / count

    def quantile(share: float) -> Array:
        place = share * (count - 1)
        whole = place.astype(np.int64)
        one, other = y[starts + whole], y[starts + np.minimum(whole + 1, count - 1)]
        return np.asarray(one + (place - whole) * (other - one))

    height, spread = quantile(0.5), (quantile(0.84) - quantile(0.16)) / 2.0
    noise = np.maximum(_around(spread), 5e-4)
    mixed = np.maximum(spread**2 - (2.0 * noise) ** 2, 0.0)
    std = np.sqrt(FLOOR**2 + 1.57 * noise**2 / count + mixed)
    good = count >= np.maximum(FEWEST, SHARE * _around(count.astype(np.float64)))
    x = eye_x + (eye_y - height) / np.tan(direction)
    return _ordered([value[good] for value in (x, height, std, noise, count)])


def together(profiles: Sequence[Profile]) -> Profile:
    """The cells of several frames in one profile."""
    return _ordered(
        [np.concatenate([getattr(one, field.name) for one in profiles]) for field in fields(Profile)],
    )


def _ordered(values: list[NDArray[Any]]) -> Profile:
    order = np.argsort(values[0], kind="stable")
    return Profile(*(value[order] for value in values))


def _around(values: Array) -> Array:
    """The median of each value and those around it."""
    half = AROUND // 2
    padded = np.pad(values, half, mode="reflect" if len(values) > half else "edge")
    return np.asarray(np.median(sliding_window_view(padded, AROUND), axis=1))
