"""Edges at an instant between two frames: on both of them, through the interpolation of their offsets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ggo_factors.factors.edge import Edge, PointFunction
from ggo_factors.support.inputs import Array


@dataclass(frozen=True, eq=False)
class BetweenFunction:
    """A function of one frame, at the frame `offset + sum of shares * frames`.

    Attributes:
        point: the function.
        shares: how much each frame of the edge counts.
        offset: what is added to them, shape (4,) in [rad].
    """

    point: PointFunction
    shares: tuple[float, ...]
    offset: Array

    def frame(self, *frames: Array) -> Array:
        """The frame that the function is asked at, shape (4,) in [rad]."""
        mixed = self.offset
        for share, frame in zip(self.shares, frames, strict=True):
            mixed = mixed + share * frame
        return mixed

    def __call__(self, *arguments: Array | bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobians."""
        *frames, want_jacobian = arguments
        error, blocks = self.point(self.frame(*np.asarray(frames)), bool(want_jacobian))
        return error, tuple(np.asfortranarray(share * block) for block in blocks for share in self.shares)

    def curvature(self, *frames: Array) -> Array:
        """Sum over the rows of error times second derivative by all frames in a row, shape (4k, 4k)."""
        shares, bent = np.outer(self.shares, self.shares), self.point.curvature(self.frame(*frames))
        size = len(bent) * len(frames)
        return np.asarray(
            (shares[:, None, :, None] * bent[:, None, :]).reshape(size, size)
        )  # np.kron takes twice as long


def edge_between(edge: Edge, frames: tuple[int, int], share: float, offset: Array) -> Edge:
    """An edge on one frame as one at an instant between two others.

    Args:
        edge: the edge; its function is a `PointFunction`.
        frames: numbers of the two frames.
        share: where between them, above 0 and below 1.
        offset: what is added to the two, shape (4,) in [rad].
    """
    assert isinstance(edge.function, PointFunction), edge.name
    function = BetweenFunction(edge.function, (1.0 - share, share), offset)
    return replace(edge, frames=frames, function=function)


def without_constants(edge: Edge, fixed: Mapping[int, Array]) -> Edge:
    """The same edge on those of its frames that are variables, where it stands between two of which one is fixed."""
    function = edge.function
    if not isinstance(function, BetweenFunction) or fixed.keys().isdisjoint(edge.frames):
        return edge
    free = [k for k, n in enumerate(edge.frames) if n not in fixed]
    known = [fixed[n] if n in fixed else np.zeros(len(function.offset)) for n in edge.frames]
    shares = tuple(function.shares[k] for k in free)
    left = BetweenFunction(function.point, shares, function.frame(*known))
    return replace(edge, frames=tuple(edge.frames[k] for k in free), function=left)
