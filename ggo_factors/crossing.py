"""Which frames of a path P pass over a stretch of ground, which of them pass too low, and how high they are to go.

Frames are chosen by the pieces of the path beside them, so that nothing is missed between two frames.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.edges import GroundEdges, Lift, ObstacleEdges
from ggo_factors.model import Foot
from ggo_factors.terrain import Ground, Obstacle
from ggo_factors.verify import FOOTHOLD_ZONE, lift_off_zone

# A frame joins the ground's edges a little before the dense check would call it too low.
GROUND_LEAST = 0.006
# An edge that a later round wants higher by less than this stays as it is, or rounds would never end.
WORTH_RAISING = 0.001

Source = int | str
Lifts = dict[tuple[int, Source], Lift]


@dataclass(frozen=True)
class Wish:
    """A frame that an obstacle or the ground wants at a height, the margin included."""

    source: Source
    frame: int
    height: float
    edges: ObstacleEdges | GroundEdges


def wishes(
    path: Array, obstacles: Sequence[ObstacleEdges], ground: GroundEdges | None, foot: Foot, low_only: bool
) -> Iterator[Wish]:
    """The frames of a path (m, 2) in [m] that pass over an obstacle (only those too low), or under the ground."""
    for source, edges in enumerate(obstacles):
        if edges.frames is None:
            box = edges.obstacle.for_ankle(foot)
            for n in frames_too_low(path, box) if low_only else frames_over(path, box):
                yield Wish(source, n, box.height + edges.margin, edges)
    if ground is not None:
        yield from _under_ground(path, ground, foot)


def given_wishes(obstacles: Sequence[ObstacleEdges], foot: Foot) -> Iterator[Wish]:
    """The frames that the user chose."""
    for source, edges in enumerate(obstacles):
        for n in edges.frames or ():
            yield Wish(source, n, edges.obstacle.for_ankle(foot).height + edges.margin, edges)


def granted(lifts: Lifts, wanted: Iterable[Wish], hold_at: Array, fixed: Iterable[int]) -> Lifts:
    """The lifts with the wishes added; a frame never leaves, and none is lowered.

    Args:
        lifts: what is there.
        wanted: what is to be added.
        hold_at: path (m, 2) in [m] whose x each lifted frame is held at.
        fixed: frames that cannot move.
    """
    new, still = dict(lifts), set(fixed)
    for wish in wanted:
        known = new.get((wish.frame, wish.source))
        if wish.frame not in still and (known is None or known.height + WORTH_RAISING < wish.height):
            x = float(hold_at[wish.frame, 0])
            new[wish.frame, wish.source] = Lift(wish.frame, wish.height, wish.edges.gamma, wish.edges.hold, x)
    return new


def _under_ground(path: Array, edges: GroundEdges, foot: Foot) -> Iterator[Wish]:
    ground = edges.ground.for_ankle(foot)
    top = heights_under(path, ground)
    from_start, to_end = np.abs(path[:, 0] - path[0, 0]), np.abs(path[:, 0] - path[-1, 0])
    leaving = (from_start <= lift_off_zone(path)) & (top == ground.height_at(path[0, 0]))
    near = leaving | (from_start <= FOOTHOLD_ZONE) | (to_end <= FOOTHOLD_ZONE)
    # A frame near a foothold counts as away where the piece of the path beside it leads out of the zone.
    inside = near & np.append(near[1:], True) & np.insert(near[:-1], 0, True)
    least = np.where(inside | (not ground.edges), 0.0, GROUND_LEAST)
    spare = np.where(near, 0.0, edges.margin)
    for n in np.flatnonzero(path[:, 1] < top + least - 1e-6):
        yield Wish("ground", int(n), float(top[n] + least[n] + spare[n]), edges)


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
