"""Bone edge: keeps the bare axis of a thigh or shank out of a block on the ground (ours; the paper's legs are points).

A leg edge tells how deep the deepest point lies under the nearest face: in a thin box that is half its thickness, in
the wrong direction. A bone edge tells how far the whole axis must move to be out.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, ManyFunction, PointFunction
from ggo_factors.factors.leg import ROWS, SUPPORT_SHANK, SWING_SHANK, Block, distances, trimmed
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array


@dataclass(frozen=True)
class BoneFunction(PointFunction):
    """Error in [m], one row: `ReLU(far - d)`, with d the `separation` of a segment's axis from a block.

    Attributes:
        model: the legs.
        segment: which, in the order of `check.leg_collision.SEGMENTS`.
        block: the block.
        far: how far the axis must stay out in [m].
        bare: share of a shank, from the ankle, that does not count: see `check.leg_collision.leg_clearance`.
        shift: by how much the row aims past its target, as that of a constraint does, in [m].
    """

    model: LegModel
    segment: int
    block: Block
    far: float
    bare: float = 0.0
    shift: tuple[float, ...] = (0.0,) * ROWS

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobian."""
        error, block = self.together([self])(frame[None], want_jacobian)
        return error[0], (np.asfortranarray(block[0]),)

    def curvature(self, frame: Array) -> Array:
        """Left out, as Gauss-Newton does: the distance has kinks wherever another direction becomes the shortest."""
        return np.zeros((FRAME_SIZE, FRAME_SIZE))

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        return BoneFunction, self.model

    @staticmethod
    def together(functions: Sequence[BoneFunction]) -> ManyFunction:
        """The same for as many frames as functions."""
        model, blocks = functions[0].model, np.array([function.block for function in functions])
        far = np.array([function.far for function in functions])[:, None] + [function.shift for function in functions]
        segment = np.array([function.segment for function in functions])
        bare = np.array([function.bare for function in functions])
        each = np.arange(len(functions))
        first = np.where(segment == SUPPORT_SHANK, bare, 0.0)[:, None]
        last = np.where(segment == SWING_SHANK, bare, 0.0)[:, None]

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            points, moves = model.joints_and_jacobian(frames)
            start, end = trimmed(points[each, segment], points[each, segment + 1], first, last)
            from_move, to_move = trimmed(
                moves[each, segment], moves[each, segment + 1], first[..., None], last[..., None]
            )
            distance, slope = distances(start, end, from_move, to_move, blocks)
            gap, by_start, by_end = separation(start, end, blocks)
            inside = gap < 0.0
            distance[:, 3] = gap
            slope[:, 3] = np.einsum("ki,kij->kj", by_start, from_move) + np.einsum("ki,kij->kj", by_end, to_move)
            distance[inside, :3], distance[~inside, 3] = np.inf, np.inf
            close = distance < far
            return np.where(close, far - distance, 0.0), -slope * close[..., None]

        return evaluate


def separation(start: Array, end: Array, blocks: Array) -> tuple[Array, Array, Array]:
    """How far pieces are apart from blocks: the largest gap along a face's normal or the piece's own.

    Below 0 it is the shortest way out. Above 0 it is at most the distance, and less only past a corner.

    Args:
        start: first ends in [m], shape (k, 2).
        end: last ends in [m], shape (k, 2).
        blocks: near side, far side, top of a block for each, shape (k, 3) in [m].

    Returns:
        The gap in [m], shape (k,), and its derivatives by the two ends, shape (k, 2) each.
    """
    left, right, top = blocks.T
    each, ends, run = np.arange(len(start)), np.stack([start, end]), end - start
    lowest = ends[:, :, 1].argmin(axis=0)
    nearest, furthest = ends[:, :, 0].argmin(axis=0), ends[:, :, 0].argmax(axis=0)
    # The normal of the piece that points up; of the two corners the one that is further along it.
    length = np.maximum(np.hypot(run[:, 0], run[:, 1]), np.finfo(np.float64).tiny)
    sign = np.where(run[:, 0] < 0.0, -1.0, 1.0) / length
    normal = np.stack([-run[:, 1], run[:, 0]], -1) * sign[:, None]
    corner = np.stack([np.where(normal[:, 0] > 0.0, right, left), top], -1)
    away = start - corner
    gaps = np.stack(
        [
            ends[lowest, each, 1] - top,
            left - ends[furthest, each, 0],
            ends[nearest, each, 0] - right,
            (normal * away).sum(axis=1),
        ]
    )
    which = gaps.argmax(axis=0)
    found = np.zeros((2, len(start), 2))
    for axis, (at, slope) in enumerate(((lowest, (0.0, 1.0)), (furthest, (-1.0, 0.0)), (nearest, (1.0, 0.0)))):
        chosen = np.flatnonzero(which == axis)
        found[at[chosen], chosen] = slope
    across = np.flatnonzero(which == 3)
    # The piece keeps its length, so the normal turns with its ends: the derivative of the cross product alone.
    turned = np.stack([away[across, 1], -away[across, 0]], -1) * sign[across, None]
    found[1, across] = turned
    found[0, across] = normal[across] - turned
    return gaps[which, each], found[0], found[1]


def bone_edge(frame: int, function: BoneFunction, gain: float) -> Edge:
    """The bone edge of `frame`."""
    return Edge("bone", (frame,), ROWS, gain, function)
