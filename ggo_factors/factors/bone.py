"""Bone edge: keeps the bare axis of a thigh or shank out of a block on the ground (ours; the paper's legs are points).

A leg edge tells how deep the deepest point lies under the nearest face: in a thin box that is half its thickness, in
the wrong direction. A bone edge tells how far the whole axis must move to be out. It works in plain floats, several
times faster than arrays for the few edges that a graph has of it.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, ManyFunction, PointFunction
from ggo_factors.factors.leg import SUPPORT_SHANK, SWING_SHANK, Block
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

ROWS = 4
"""Rows of the error: both ends and both corners, or the first for the way out."""

Gap = tuple[float, float, float, float, float]
"""A distance in [m], and its derivative by where an axis begins (x, y) and ends (x, y)."""


@dataclass(frozen=True)
class BoneFunction(PointFunction):
    """Error in [m], 4 rows, of how near a segment's axis comes to a block.

    Outside, `ReLU(far - d)` of the distances d of both ends from the block and of both its corners from the axis: of an
    upright shank beside a block the solver must see the ankle's and that of the corner, or it stands on a kink. Inside,
    the first row is `far` and the shortest way out, see `way_out`.

    Attributes:
        model: the legs.
        segment: which, in the order of `check.leg_collision.SEGMENTS`.
        block: the block.
        far: how far the axis must stay out in [m].
        bare: share of a shank, from the ankle, that does not count: see `check.leg_collision.leg_clearance`.
        shift: by how much the rows aim past their targets, as those of a constraint do, in [m].
    """

    model: LegModel
    segment: int
    block: Block
    far: float
    bare: float = 0.0
    shift: tuple[float, ...] = (0.0,) * ROWS

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobian."""
        error, jacobian = np.zeros(ROWS), np.zeros((ROWS, FRAME_SIZE), order="F")
        moves, ends = self._axis(frame)
        out = way_out(ends, self.block)
        gaps = (out,) if out[0] < 0.0 else distances(ends, self.block)
        for row, (distance, *slopes) in enumerate(gaps):
            close = self.far + self.shift[row] - distance
            if close > 0.0:
                error[row] = close
                if want_jacobian:
                    jacobian[row] = self._by_frame(slopes, moves)
        return error, (jacobian,)

    def curvature(self, frame: Array) -> Array:
        """Left out, as Gauss-Newton does: the distance has kinks wherever another direction becomes the shortest."""
        return np.zeros((FRAME_SIZE, FRAME_SIZE))

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        return BoneFunction, self.model

    @staticmethod
    def together(functions: Sequence[BoneFunction]) -> ManyFunction:
        """The same for as many frames as functions."""

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            errors, jacobians = np.empty((len(frames), ROWS)), np.empty((len(frames), ROWS, FRAME_SIZE))
            for k, (function, frame) in enumerate(zip(functions, frames, strict=True)):
                errors[k], (jacobians[k],) = function(frame, want_jacobian)
            return errors, jacobians

        return evaluate

    def _axis(self, frame: Array) -> tuple[list[tuple[float, float]], tuple[float, float, float, float]]:
        """How the axis' end moves with each link up to its own, and its two ends (x, y, x, y) in [m]."""
        a1, b1, a2, b2 = frame.tolist()
        thigh, shank, last = self.model.thigh, self.model.shank, self.segment
        x = y = 0.0
        moves, ends = [], (0.0, 0.0, 0.0, 0.0)
        links = ((a1 - b1, -shank), (a1, -thigh), (a2, thigh), (a2 - b2, shank))
        for angle, length in links[: last + 1]:
            across, down = length * math.sin(angle), length * math.cos(angle)
            ends = (x, y, x + across, y - down)
            x, y = ends[2:]
            moves.append((down, across))
        if self.bare:
            x0, y0, x1, y1 = ends
            if last == SUPPORT_SHANK:
                ends = (x0 + self.bare * (x1 - x0), y0 + self.bare * (y1 - y0), x1, y1)
            elif last == SWING_SHANK:
                ends = (x0, y0, x1 - self.bare * (x1 - x0), y1 - self.bare * (y1 - y0))
        return moves, ends

    def _by_frame(self, slopes: list[float], moves: list[tuple[float, float]]) -> tuple[float, float, float, float]:
        """The derivative by the frame of what a distance lacks, given that of the distance by the axis' ends."""
        from_x, from_y, to_x, to_y = slopes
        own_x, own_y = to_x, to_y  # the axis' own link moves its far end alone
        if self.bare and self.segment == SUPPORT_SHANK:
            own_x, own_y = to_x + self.bare * from_x, to_y + self.bare * from_y
        elif self.bare and self.segment == SWING_SHANK:
            own_x, own_y = (1.0 - self.bare) * to_x, (1.0 - self.bare) * to_y
        turns = [0.0] * FRAME_SIZE
        for link, (by_x, by_y) in enumerate(moves):
            if link == self.segment:
                turns[link] = own_x * by_x + own_y * by_y
            else:
                turns[link] = (from_x + to_x) * by_x + (from_y + to_y) * by_y
        return (-turns[0] - turns[1], turns[0], -turns[2] - turns[3], turns[3])


def way_out(ends: tuple[float, float, float, float], block: Block) -> Gap:
    """The largest gap between an axis and a block along a face's normal or the axis' own; below 0 the way out."""
    x0, y0, x1, y1 = ends
    left, right, top = block
    first = x0 > x1
    found: Gap = (left - (x0 if first else x1), -1.0 * first, 0.0, -1.0 * (not first), 0.0)
    if (x1 if first else x0) - right > found[0]:
        found = ((x1 if first else x0) - right, 1.0 * (not first), 0.0, 1.0 * first, 0.0)
    if min(y0, y1) - top > found[0]:
        found = (min(y0, y1) - top, 0.0, 1.0 * (y0 < y1), 0.0, 1.0 * (y0 >= y1))
    run, rise = x1 - x0, y1 - y0
    length = math.hypot(run, rise)
    if length > 0.0:
        scale = -1.0 / length if run < 0.0 else 1.0 / length
        normal_x, normal_y = -rise * scale, run * scale  # of the two the one that points up
        away_x, away_y = x0 - (right if normal_x > 0.0 else left), y0 - top
        gap = normal_x * away_x + normal_y * away_y
        if gap > found[0]:
            # The axis keeps its length, so the normal turns with its ends.
            turn_x, turn_y = away_y * scale, -away_x * scale
            found = (gap, normal_x - turn_x, normal_y - turn_y, turn_x, turn_y)
    return found


def distances(ends: tuple[float, float, float, float], block: Block) -> list[Gap]:
    """Distances of both ends of an axis from a block, and of the block's corners from the axis, which is outside."""
    x0, y0, x1, y1 = ends
    left, right, top = block
    run, rise = x1 - x0, y1 - y0
    squared = run * run + rise * rise or 1.0
    found: list[Gap] = []
    for share, x, y in ((0.0, x0, y0), (1.0, x1, y1)):
        found.append(_between(min(max(x, left), right), min(y, top), x, y, share))
    for corner in (left, right):
        share = min(max(((corner - x0) * run + (top - y0) * rise) / squared, 0.0), 1.0)
        found.append(_between(corner, top, x0 + share * run, y0 + share * rise, share))
    return found


def _between(from_x: float, from_y: float, x: float, y: float, share: float) -> Gap:
    """The distance of a point at some share of an axis from another point, and its derivatives by the axis' ends."""
    ahead, up = x - from_x, y - from_y
    distance = math.hypot(ahead, up)
    scale = 1.0 / distance if distance > 0.0 else 0.0
    ahead, up = ahead * scale, up * scale
    return (distance, (1.0 - share) * ahead, (1.0 - share) * up, share * ahead, share * up)


def bone_edge(frame: int, function: BoneFunction, gain: float) -> Edge:
    """The bone edge of `frame`."""
    return Edge("bone", (frame,), ROWS, gain, function)
