"""Which frames of a path P pass over a stretch of ground, and which of them pass too low.

Frames are chosen by the pieces of the path beside them, so that nothing is missed between two frames.
"""

from __future__ import annotations

import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.terrain import Ground, Obstacle


def frames_over(path: Array, box: Obstacle) -> list[int]:
    """Frames with a piece of the path beside them that overlaps the box's span, of a path (m, 2) in [m]."""
    return _ends_of(_overlapping(path, box))


def frames_too_low(path: Array, box: Obstacle) -> list[int]:
    """Frames with a piece beside them that overlaps the box's span and dips under its height there."""
    here, there = path[:-1], path[1:]
    run = there[:, 0] - here[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.stack([(box.x_start - here[:, 0]) / run, (box.x_end - here[:, 0]) / run])
    shares = np.clip(np.nan_to_num(shares, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    heights = here[:, 1] + shares * (there[:, 1] - here[:, 1])
    return _ends_of(_overlapping(path, box) & (heights.min(axis=0) < box.height))


def heights_under(path: Array, ground: Ground) -> Array:
    """The highest ground in [m] under the two pieces of the path beside each frame, shape (m,)."""
    top = ground.highest_between(path[:-1, 0], path[1:, 0])
    return np.asarray(np.maximum(np.append(top, top[-1]), np.insert(top, 0, top[0])), dtype=np.float64)


def _overlapping(path: Array, box: Obstacle) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    low, high = np.minimum(path[:-1, 0], path[1:, 0]), np.maximum(path[:-1, 0], path[1:, 0])
    return np.asarray((low <= box.x_end) & (high >= box.x_start))


def _ends_of(pieces: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> list[int]:
    index = np.flatnonzero(pieces)
    return sorted({int(i) for i in index} | {int(i) + 1 for i in index})
