"""The instants at which the rounds look at the path of the swing ankle: a graph's frames, or at a higher rate."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ggo_factors.factors import Edge, edge_between
from ggo_factors.support.inputs import Array

NEAR = 1e-6
"""An instant nearer to a frame than this share of a motion is that frame."""


@dataclass(frozen=True, eq=False)
class Sampling:
    """The instants, evenly spaced from the first frame of the graph to the last.

    Attributes:
        base: the base gait at the frames of the graph in [rad], shape (k, 4).
        fine: the base gait at the instants in [rad], shape (m, 4), m at least k; where m is k they are the frames.
    """

    base: Array
    fine: Array

    @cached_property
    def weight(self) -> float:
        """How many frames of the graph an instant stands for."""
        return (len(self.base) - 1) / (len(self.fine) - 1)

    @property
    def _places(self) -> tuple[NDArray[np.int_], Array]:
        """The frame of the graph at or before each instant, and how far the instant is on the way to the next."""
        return _places(len(self.base), len(self.fine))

    def frames(self, frames: Array) -> Array:
        """A gait's frames at the instants, shape (m, 4): its offset from the base gait runs straight between two."""
        if len(self.fine) == len(self.base):
            return frames
        lower, share = self._places
        offset = frames - self.base
        sampled = self.fine + offset.take(lower, axis=0)
        sampled += share[:, None] * np.diff(offset, axis=0, append=offset[-1:]).take(lower, axis=0)
        return sampled

    def curved(self, curvature: Array) -> Array:
        """What an offset that runs as cubics between frames has beyond the straight one, shape (m, 4).

        Args:
            curvature: its second derivative at the frames of the graph, by the number of the frame, shape (k, 4).
        """
        lower, _ = self._places
        before, after = _cubic_shares(len(self.base), len(self.fine))
        added = before * curvature.take(lower, axis=0)
        added += after * np.append(curvature[1:], curvature[-1:], axis=0).take(lower, axis=0)
        return added

    def neighbours(self, instant: int) -> tuple[int, ...]:
        """The frame of the graph that an instant is, or the two it is between."""
        lower, share = self._places
        n = int(lower[instant])
        return (n, n + 1) if share[instant] else (n,)

    def held(self, frames: Collection[int]) -> NDArray[np.bool_]:
        """Whether each instant cannot move where these frames of the graph cannot, shape (m,)."""
        fixed = np.zeros(len(self.base) + 1, dtype=bool)
        fixed[list(frames)] = True
        lower, share = self._places
        return np.asarray(fixed[lower] & (fixed[lower + 1] | (share == 0.0)))

    def between(self, instant: int) -> tuple[dict[int, float], Array]:
        """The shares of frames of the graph in the frame at an instant, and what is added to them, (4,) in [rad]."""
        frames, share = self.neighbours(instant), float(self._places[1][instant])
        shares, offset = (
            dict(zip(frames, (1.0 - share, share) if len(frames) > 1 else (1.0,), strict=True)),
            self.fine[instant],
        )
        for n, part in shares.items():
            offset = offset - part * self.base[n]
        return shares, offset

    def edge(self, edge: Edge) -> Edge:
        """An edge on one instant as an edge on frames of the graph."""
        (instant,) = edge.frames
        frames = self.neighbours(instant)
        if frames == edge.frames:
            return edge
        if len(frames) == 1:
            return replace(edge, frames=frames)
        first, second = frames
        shares, offset = self.between(instant)
        return edge_between(edge, (first, second), shares[second], offset)


@lru_cache(maxsize=8)
def _places(count: int, fine: int) -> tuple[NDArray[np.int_], Array]:
    """`Sampling._places` of so many frames and instants."""
    at = np.linspace(0.0, count - 1, fine)
    nearest = np.rint(at)
    at = np.where(np.abs(at - nearest) < NEAR, nearest, at)
    lower = np.floor(at).astype(int)
    return lower, at - lower


@lru_cache(maxsize=8)
def _cubic_shares(count: int, fine: int) -> tuple[Array, Array]:
    """How much the second derivatives at the frames before and after count at each instant, shape (m, 1)."""
    share = _places(count, fine)[1][:, None]
    left = 1.0 - share
    return (left**3 - left) / 6.0, (share**3 - share) / 6.0
