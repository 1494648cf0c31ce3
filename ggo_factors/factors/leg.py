"""Leg edge: keeps a thigh or shank that has a thickness clear of a block on the ground (ours; paper: future work)."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, ManyFunction, PointFunction
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

Block = tuple[float, float, float]
"""Near side, far side and top of what stands on the ground, in [m], in the body frame."""
SUPPORT_SHANK, SUPPORT_THIGH, SWING_THIGH, SWING_SHANK = range(4)
"""The segments, each between two neighbours of `LegModel.joints`."""

ROWS = 4
"""Rows of the error, one for each point of `nearest`."""

_FACES = np.array([[0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]])  # the outward directions of top, near side, far side


@dataclass(frozen=True)
class LegFunction(PointFunction):
    """Error in [m], 4 rows, of how near a segment's axis comes to a block; d are the distances of `nearest`.

    `ReLU(far - d)` of both ends and of where it is nearest to a corner, `ReLU(-d)` of where it lies deepest. One row
    for the least of them would measure the same, but has a kink where an upright shank stands beside a block: there the
    solver must see both the ankle's distance and that of the point beside the corner.

    Attributes:
        model: the legs.
        segment: which, in the order of `check.leg_collision.SEGMENTS`.
        block: the block.
        far: how far the axis must stay away in [m]: the segment's radius and a margin.
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
        error, block = self.together([self])(frame[None], want_jacobian)
        return error[0], (np.asfortranarray(block[0]),)

    def curvature(self, frame: Array) -> Array:
        """Left out, as Gauss-Newton does: the distance has kinks wherever another point becomes the nearest."""
        return np.zeros((FRAME_SIZE, FRAME_SIZE))

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        return LegFunction, self.model

    @staticmethod
    def together(functions: Sequence[LegFunction]) -> ManyFunction:
        """The same for as many frames as functions."""
        model, blocks = functions[0].model, np.array([function.block for function in functions])
        far = np.array([(f.far, f.far, f.far, 0.0) for f in functions]) + [f.shift for f in functions]
        segment = np.array([f.segment for f in functions])
        bare = np.array([f.bare for f in functions])
        each = np.arange(len(functions))
        # The shank's end at the ankle is left out: the first end of the supporting one, the last of the swinging one.
        first = np.where(segment == SUPPORT_SHANK, bare, 0.0)[:, None]
        last = np.where(segment == SWING_SHANK, bare, 0.0)[:, None]

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            points, moves = model.joints_and_jacobian(frames)
            start, end = trimmed(points[each, segment], points[each, segment + 1], first, last)
            from_move, to_move = trimmed(
                moves[each, segment], moves[each, segment + 1], first[..., None], last[..., None]
            )
            distance, share, normal, corner = nearest(start, end, blocks)
            close = distance < far
            along = share[..., None, None]
            motion = (1.0 - along) * from_move[:, None] + along * to_move[:, None]
            # Where it is nearest to the corner moves along the axis too.
            run, turn = end - start, to_move - from_move
            reach = corner - start - 2.0 * share[:, 2:3] * run
            slide = np.einsum("ki,kij->kj", reach, turn) - np.einsum("ki,kij->kj", run, from_move)
            slide /= np.maximum((run**2).sum(axis=1), np.finfo(np.float64).tiny)[:, None]
            inner = (share[:, 2] > 0.0) & (share[:, 2] < 1.0)
            motion[:, 2] += run[..., None] * (slide * inner[:, None])[:, None]
            slope = -np.einsum("kri,krij->krj", normal, motion) * close[..., None]
            return np.where(close, far - distance, 0.0), slope

        return evaluate


def trimmed(start: Array, end: Array, first: Array, last: Array) -> tuple[Array, Array]:
    """Both ends of pieces without a first and a last share of them."""
    return (1.0 - first) * start + first * end, last * start + (1.0 - last) * end


def nearest(start: Array, end: Array, blocks: Array) -> tuple[Array, Array, Array, Array]:
    """Signed distances of four points of pieces from blocks: outside how far, inside how deep under the nearest face.

    The points are both ends, the one that is nearest to a corner of the block, and the one that lies deepest in it.

    Args:
        start: first ends in [m], shape (k, 2).
        end: last ends in [m], shape (k, 2).
        blocks: near side, far side, top of a block for each, shape (k, 3) in [m].

    Returns:
        Distance in [m], shape (k, 4), below 0 inside; where along the piece, as a share of it, shape (k, 4); derivative
        of the distance by where that point is, shape (k, 4, 2); the nearest corner in [m], shape (k, 2).
    """
    left, right, top = blocks.T
    run = end - start
    shares = [np.zeros(len(run)), np.ones(len(run))]
    squared = np.maximum((run**2).sum(axis=1), np.finfo(np.float64).tiny)
    for side in (left, right):
        shares.append(((side - start[:, 0]) * run[:, 0] + (top - start[:, 1]) * run[:, 1]) / squared)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        # Inside, the deepest point is an end, or where two of the three faces are equally far.
        shares.append((left + right - 2.0 * start[:, 0]) / (2.0 * run[:, 0]))
        shares.append((top - start[:, 1] + left - start[:, 0]) / (run[:, 0] + run[:, 1]))
        shares.append((top - start[:, 1] - right + start[:, 0]) / (run[:, 1] - run[:, 0]))
    share = np.clip(np.nan_to_num(np.stack(shares), nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    at = start + share[..., None] * run
    faces = np.stack([at[..., 1] - top, left - at[..., 0], at[..., 0] - right])
    outside = np.stack([np.maximum(faces[2], 0.0) - np.maximum(faces[1], 0.0), np.maximum(faces[0], 0.0)], -1)
    away = np.hypot(outside[..., 0], outside[..., 1])
    inside = faces.max(axis=0)
    signed = np.where(inside > 0.0, away, inside)
    corner, deepest = 2 + signed[2:4].argmin(axis=0), signed.argmin(axis=0)
    chosen = np.stack([np.zeros_like(corner), np.ones_like(corner), corner, deepest])
    distance, place = np.take_along_axis(signed, chosen, 0).T, np.take_along_axis(share, chosen, 0).T
    around = np.take_along_axis(outside, chosen[..., None], 0).transpose(1, 0, 2)
    # Inside, the two foremost faces are equal at the deepest point unless that is an end: there the distance grows in
    # the mean of their directions that is upright on the piece.
    ranked = np.argsort(np.take_along_axis(faces, chosen[None], 1), axis=0)
    second, first = ranked[1].T, ranked[2].T
    one, other = _FACES[first], _FACES[second]
    ahead, behind = (one * run[:, None]).sum(axis=-1), (other * run[:, None]).sum(axis=-1)
    equal = (chosen.T >= 4) & (ahead * behind < 0.0) & (place > 0.0) & (place < 1.0)
    weight = np.where(equal, behind / np.where(equal, behind - ahead, 1.0), 1.0)[..., None]
    normals = weight * one + (1.0 - weight) * other
    straight = around / np.maximum(distance, np.finfo(np.float64).tiny)[..., None]
    beside = np.stack([np.where(corner == 2, left, right), top], -1)
    return distance, place, np.where(distance[..., None] > 0.0, straight, normals), beside


def leg_edge(frame: int, function: LegFunction, gain: float) -> Edge:
    """The leg edge of `frame`."""
    return Edge("leg", (frame,), ROWS, gain, function)
