"""Which frames of a path pass over an obstacle or the ground, which of them pass too low, and how high they must go.

Frames are chosen by the pieces of the path beside them, so that nothing is missed between two frames. At a high
sampling rate a few frames stand for a run of them, each with the weight of those it stands for, so that the cost of a
graph does not grow with the rate.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.ground import in_mid_swing, near_footholds
from ggo_factors.graph.requests import GroundRequest, Lift, ObstacleRequest
from ggo_factors.motion.leg_model import Foot
from ggo_factors.motion.terrain import Ground, Obstacle
from ggo_factors.support.inputs import Array

GROUND_LEAST = 0.006
"""A frame that passes lower over the ground than this in [m] gets an edge: 1 mm before the check calls it too low."""
WORTH_RAISING = 0.001
"""An edge that a later round wants higher by less than this in [m] stays as it is, or rounds would never end."""
GROWTH = 4
"""Factor by which the frames that one edge stands for grow from the ends of a run inwards: with 4 the residual cost
stays within 1.1 % of the full graph's (obstacles of the paper, 201, 401 and 801 frames)."""
Mask = NDArray[np.bool_]
Source = int | str


@dataclass(frozen=True, eq=False)
class Demand:
    """Frames that must go to a height over an obstacle or the ground, the margin included."""

    source: Source
    wanted: Mask  # (m,)
    heights: Array  # (m,) in [m]
    request: ObstacleRequest | GroundRequest


@dataclass(frozen=True, eq=False)
class Lifts:
    """The obstacle edges of a round, and for each source the frames that they stand for."""

    edges: dict[tuple[int, Source], Lift] = field(default_factory=dict)
    covered: dict[Source, Mask] = field(default_factory=dict)

    def with_given(
        self, obstacles: Sequence[ObstacleRequest], foot: Foot, hold_at: Array, fixed: Collection[int]
    ) -> Lifts:
        """The same with an edge on each frame that the user chose."""
        edges = dict(self.edges)
        for source, given in enumerate(obstacles):
            height = given.obstacle.for_ankle(foot).height + given.margin
            for n in given.frames or ():
                if n not in fixed:
                    edges[n, source] = Lift(n, height, given.gamma, given.hold, float(hold_at[n, 0]))
        return Lifts(edges, self.covered)

    def meeting(self, demand: Demand, hold_at: Array, fixed: Mask, spacing: int) -> Lifts:
        """The same with a demand met; an edge never leaves, and none is lowered.

        Args:
            demand: what is wanted.
            hold_at: path (m, 2) in [m] whose x each lifted frame is held at.
            fixed: whether each frame cannot move.
            spacing: how many frames one edge may stand for.
        """
        edges, source = dict(self.edges), demand.source
        wanted = demand.wanted & ~fixed
        covered = self.covered.get(source, np.zeros(len(wanted), dtype=bool))
        weights = thinned(wanted & ~covered, spacing)
        for first, last in runs(wanted):
            # An edge stands for these frames, and they pass too low all the same: the middle one gets its own edge.
            if covered[first : last + 1].all() and not any((n, source) in edges for n in range(first, last + 1)):
                weights[(first + last) // 2] = float(spacing)
        for n in np.flatnonzero(wanted).tolist():
            known = edges.get((n, source))
            if known is not None and known.height + WORTH_RAISING < demand.heights[n]:
                weights.setdefault(n, known.weight)
        for n, weight in weights.items():
            x, height = float(hold_at[n, 0]), float(demand.heights[n])
            edges[n, source] = Lift(n, height, demand.request.gamma, demand.request.hold, x, weight)
        return Lifts(edges, {**self.covered, source: covered | wanted})


def demands(
    path: Array,
    hold_at: Array,
    obstacles: Sequence[ObstacleRequest],
    ground: GroundRequest | None,
    foot: Foot,
    low_only: bool,
) -> Iterator[Demand]:
    """The frames of a path (m, 2) in [m] that pass over an obstacle, or only those too low, and those under the ground.

    Lifted frames are held at the x of the path `hold_at` (m, 2).
    """
    for source, request in enumerate(obstacles):
        if request.frames is None:
            box = request.obstacle.for_ankle(foot)
            wanted = frames_too_low(path, box) if low_only else frames_over(path, box)
            if wanted.any():
                yield Demand(source, wanted, np.full(len(path), box.height + request.margin), request)
    if ground is not None:
        yield from _under_ground(path, hold_at, ground, foot)


def runs(mask: Mask) -> list[tuple[int, int]]:
    """First and last index of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True))


def thinned(mask: Mask, spacing: int) -> dict[int, float]:
    """Frames that stand for the True ones, with how many each stands for: one at the ends of a run, more inside.

    At its ends a run is decided: there a foot that rises or comes down is lowest over a box, and there a knee leaves
    the frame that is anchored. From each end the frames that one stands for grow up to `spacing`. They are odd in
    number, so that it stands in their middle.
    """
    if spacing == 1:
        return dict.fromkeys(np.flatnonzero(mask).tolist(), 1.0)
    chosen: dict[int, float] = {}
    widest = spacing - (spacing + 1) % 2
    for first, last in runs(mask):
        cells, left = [], last - first + 1
        width = 1
        while left > 2 * width:
            cells.append(width)
            left -= 2 * width
            width = min(GROWTH * width + 1, widest)
        at = first
        for cell in [*cells, *_odd_parts(left, widest), *reversed(cells)]:
            chosen[at + cell // 2] = float(cell)
            at += cell
    return chosen


def _odd_parts(total: int, most: int) -> list[int]:
    """A number as a sum of odd numbers that differ little, none above the odd number `most`."""
    count = -(-total // most)
    count += (total - count) % 2
    pairs = np.diff(np.rint(np.linspace(0, (total - count) // 2, count + 1))).tolist() if count else []
    return [1 + 2 * int(pair) for pair in pairs]


def _under_ground(path: Array, hold_at: Array, request: GroundRequest, foot: Foot) -> Iterator[Demand]:
    ground = request.ground.for_ankle(foot, (float(path[0, 0]), float(path[-1, 0])))
    top = heights_under(path, ground)
    if not (path[:-1, 1] < top[:-1] + GROUND_LEAST - 1e-6).any():
        return
    near = near_footholds(path[:, 0], top, path[[0, -1]], ground)
    # A frame near a foothold counts as away where the piece of the path beside it leads out of the zone.
    inside = near & np.append(near[1:], True) & np.insert(near[:-1], 0, True)
    if not ground.edges:
        inside = ~in_mid_swing(path[:, 0])
    least = np.where(inside, 0.0, GROUND_LEAST)
    low = np.asarray(path[:, 1] < top + least - 1e-6)
    low[-1] = False  # the foothold says where the last frame goes
    if low.any():
        wanted = top
        if ground.edges:
            # A frame that lags behind its place is drawn on to it, and need not go higher than the ground there.
            lags = hold_at[:, 0] >= path[:, 0]
            wanted = np.where(lags, np.minimum(top, heights_under(hold_at, ground)), top)
        yield Demand("ground", low, wanted + least + np.where(near, 0.0, request.margin), request)


def frames_over(path: Array, box: Obstacle) -> Mask:
    """Frames with a piece of the path beside them that overlaps the box's span, of a path (m, 2) in [m]."""
    return _ends_of(_overlapping(path, box))


def frames_too_low(path: Array, box: Obstacle) -> Mask:
    """Frames with a piece beside them that overlaps the box's span and dips under its height there.

    The check finds the lowest point over a span by code of its own (`check.ground`), so that a fault in one is seen.
    """
    here, there = path[:-1], path[1:]
    run = there[:, 0] - here[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.stack([(box.x_start - here[:, 0]) / run, (box.x_end - here[:, 0]) / run])
    shares = np.clip(np.nan_to_num(shares, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    heights = here[:, 1] + shares * (there[:, 1] - here[:, 1])
    return _ends_of(_overlapping(path, box) & (heights.min(axis=0) < box.height))


def heights_under(path: Array, ground: Ground) -> Array:
    """The highest ground in [m] under the two pieces of the path beside each frame, shape (m,)."""
    if not ground.edges:
        return ground.height_at(path[:, 0])
    top = ground.highest_between(path[:-1, 0], path[1:, 0])
    return np.asarray(np.maximum(np.concatenate([top, top[-1:]]), np.concatenate([top[:1], top])), dtype=np.float64)


def _overlapping(path: Array, box: Obstacle) -> Mask:
    low, high = np.minimum(path[:-1, 0], path[1:, 0]), np.maximum(path[:-1, 0], path[1:, 0])
    return np.asarray((low <= box.x_end) & (high >= box.x_start))


def _ends_of(pieces: Mask) -> Mask:
    return np.asarray(np.append(pieces, False) | np.insert(pieces, 0, False))
