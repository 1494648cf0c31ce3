"""At which instants the rounds look at the path of P and lift it: at a graph's frames, or at a higher rate."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ggo_factors.arrays import Array
from ggo_factors.factors import Edge, edge_between

# An instant nearer to a frame than this share of a motion is that frame.
NEAR = 1e-6


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

    @cached_property
    def _places(self) -> tuple[NDArray[np.int_], Array]:
        """The frame of the graph at or before each instant, and how far the instant is on the way to the next."""
        last = len(self.base) - 1
        at = np.linspace(0.0, last, len(self.fine))
        nearest = np.rint(at)
        at = np.where(np.abs(at - nearest) < NEAR, nearest, at)
        lower = np.floor(at).astype(int)
        return lower, at - lower

    def frames(self, frames: Array) -> Array:
        """A gait's frames at the instants, shape (m, 4): its offset from the base gait runs straight between two."""
        if len(self.fine) == len(self.base):
            return frames
        lower, share = self._places
        offset, upper = frames - self.base, np.minimum(lower + 1, len(self.base) - 1)
        return np.asarray(self.fine + offset[lower] + share[:, None] * (offset[upper] - offset[lower]))

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

    def edge(self, edge: Edge) -> Edge:
        """An edge on one instant as an edge on frames of the graph."""
        (instant,) = edge.frames
        frames = self.neighbours(instant)
        if frames == edge.frames:
            return edge
        if len(frames) == 1:
            return replace(edge, frames=frames)
        first, second = frames
        share = float(self._places[1][instant])
        offset = self.fine[instant] - (1.0 - share) * self.base[first] - share * self.base[second]
        return edge_between(edge, (first, second), share, offset)
