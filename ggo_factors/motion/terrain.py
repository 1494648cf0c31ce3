"""The ground ahead of one step: obstacles, gaps, stairs, and what the swing ankle must clear so that the foot does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.leg_model import Foot
from ggo_factors.support.inputs import Array, as_array, as_number

LARGEST_STD = 0.1
"""Largest standard deviation of an obstacle's edges and height in [m]: five times that of a poor
depth camera; a larger one is surely a mistake."""

FARTHEST = 100.0
"""How far ahead an obstacle or a gap may begin in [m]: beyond it the numbers are surely millimetres."""


def _check_span(shape: Obstacle | Gap) -> None:
    for name in ("x_start", "x_end"):
        object.__setattr__(shape, name, as_number(getattr(shape, name), name, unit="m"))
    if shape.x_start > FARTHEST:
        raise InputError(f"x_start: {shape.x_start:g} m is more than {FARTHEST:g} m ahead; looks like millimetres")
    if not shape.x_start < shape.x_end:
        raise InputError(f"x_end: {shape.x_end:g} m must be above x_start {shape.x_start:g} m")


@dataclass(frozen=True)
class Obstacle:
    """A box on the ground that the swinging foot must step over.

    Attributes:
        x_start: near edge in [m], in the body frame of its step (origin: ankle of the supporting leg).
        x_end: far edge in [m].
        height: height above the ground under the supporting foot in [m], 0 or more.
        edge_std: standard deviation of each of the two edges in [m], their errors independent; 0 where they are known,
            0.005 to 0.020 for depth cameras, at most `LARGEST_STD`. See `check.uncertainty`.
        height_std: the same of the height.

    Raises:
        InputError: where a number is not finite or out of its range, or the far edge is not beyond the near one.
    """

    x_start: float
    x_end: float
    height: float
    edge_std: float = 0.0
    height_std: float = 0.0

    def __post_init__(self) -> None:
        _check_span(self)
        object.__setattr__(self, "height", as_number(self.height, "height", at_least=0.0, unit="m"))
        for name in ("edge_std", "height_std"):
            number = as_number(getattr(self, name), name, at_least=0.0, at_most=LARGEST_STD, unit="m")
            object.__setattr__(self, name, number)

    def __repr__(self) -> str:
        spread = f", edge_std={self.edge_std!r}, height_std={self.height_std!r}" if self.is_uncertain else ""
        return f"Obstacle({self.x_start!r}, {self.x_end!r}, {self.height!r}{spread})"

    def __str__(self) -> str:
        spread = f" (edges \u00b1 {self.edge_std:g}, height \u00b1 {self.height_std:g} m)" if self.is_uncertain else ""
        return f"box from {self.x_start:g} to {self.x_end:g} m, {self.height:g} m high{spread}"

    @property
    def is_uncertain(self) -> bool:
        """Whether its edges or its height were measured with an error."""
        return self.edge_std > 0.0 or self.height_std > 0.0

    def for_ankle(self, foot: Foot) -> Obstacle:
        """The obstacle that the swing ankle must clear so that the whole sole does.

        The ankle heights of both feet cancel; the toe meets the box before the ankle does, the heel leaves it
        after (the paper's equivalent stair, section V-C).
        """
        if foot.toe == 0.0 and foot.heel == 0.0:
            return self
        return replace(self, x_start=self.x_start - foot.toe, x_end=self.x_end + foot.heel)

    def shifted(self, x: float, y: float = 0.0) -> Obstacle:
        """The obstacle as seen from a body frame that stands `x` further on and `y` higher, both in [m]."""
        return replace(self, x_start=self.x_start - x, x_end=self.x_end - x, height=max(self.height - y, 0.0))


@dataclass(frozen=True)
class Gap:
    """A pit: no foothold in it.

    Attributes:
        x_start: near edge in [m], in the body frame of its step.
        x_end: far edge in [m].

    Raises:
        InputError: where a number is not finite or the far edge is not beyond the near one.
    """

    x_start: float
    x_end: float

    def __post_init__(self) -> None:
        _check_span(self)

    def __str__(self) -> str:
        return f"gap from {self.x_start:g} to {self.x_end:g} m"

    def for_ankle(self, foot: Foot) -> Gap:
        """Where the swing ankle must not land, so that no part of the sole stands over the gap."""
        return Gap(self.x_start - foot.toe, self.x_end + foot.heel)

    def shifted(self, x: float) -> Gap:
        """The gap as seen from a body frame that stands `x` [m] further on."""
        return Gap(self.x_start - x, self.x_end - x)


@dataclass(frozen=True)
class Ground:
    """Level ground, or treads at different heights with risers between them.

    Attributes:
        edges: x of each riser in [m], ascending, shape (n,), in the body frame of its step.
        heights: height of each tread in [m], shape (n + 1,), from behind to ahead; 0 under the supporting foot.

    Raises:
        InputError: where the numbers do not fit together.
    """

    edges: tuple[float, ...] = ()
    heights: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        edges, heights = as_array(self.edges, "edges", (None,)), as_array(self.heights, "heights", (None,))
        if len(heights) != len(edges) + 1:
            raise InputError(f"heights: {len(edges)} edges need {len(edges) + 1} heights, got {len(heights)}")
        given = edges.tolist()
        if (np.diff(edges) <= 0.0).any():
            raise InputError(f"edges: {given} must ascend")
        object.__setattr__(self, "edges", tuple(given))
        object.__setattr__(self, "heights", tuple(heights.tolist()))

    def height_at(self, x: ArrayLike) -> Array:
        """Height of the ground in [m] at `x` in [m]; at a riser the higher of its two sides."""
        x = np.asarray(x, dtype=np.float64)
        if not self.edges:
            level = np.empty(x.shape)
            level.fill(self.heights[0])  # np.full takes ten times as long for one place
            return level
        heights = np.array(self.heights)
        left, right = np.searchsorted(self.edges, x, "left"), np.searchsorted(self.edges, x, "right")
        return np.asarray(np.maximum(heights[left], heights[right]), dtype=np.float64)

    def highest_between(self, x: ArrayLike, other: ArrayLike) -> Array:
        """The highest ground in [m] between `x` and `other`, both in [m], ends included."""
        low, high = np.minimum(x, other), np.maximum(x, other)
        top = np.maximum(self.height_at(low), self.height_at(high))
        for edge in self.edges:
            top = np.where((low <= edge) & (edge <= high), np.maximum(top, self.height_at(edge)), top)
        return np.asarray(top, dtype=np.float64)

    def shifted(self, x: float, y: float) -> Ground:
        """The ground as seen from a body frame that stands `x` further on and `y` higher, both in [m]."""
        return Ground(tuple(e - x for e in self.edges), tuple(h - y for h in self.heights))

    def for_ankle(self, foot: Foot) -> Ground:
        """The ground that the swing ankle must stay above so that the whole sole does.

        Each tread is widened by toe and heel.
        """
        if foot.toe == 0.0 and foot.heel == 0.0:
            return self
        edges = sorted({e - foot.toe for e in self.edges} | {e + foot.heel for e in self.edges})
        bounds = [-math.inf, *edges, math.inf]
        heights = []
        for low, high in pairwise(bounds):
            inside = high - 1.0 if math.isinf(low) else low + 1.0 if math.isinf(high) else (low + high) / 2.0
            heights.append(float(self.highest_between(inside - foot.heel, inside + foot.toe)))
        return Ground(tuple(edges), tuple(heights))


LEVEL = Ground()
"""Level ground at the height of the supporting foot."""


def stair_ground(first_edge: float, tread: float, rises: Sequence[float]) -> Ground:
    """Stairs ahead of a walker on level ground: the first riser at `first_edge`, one more each `tread`.

    Args:
        first_edge: x of the first riser in [m].
        tread: depth of each tread in [m].
        rises: rise of each riser in [m], negative downwards.

    Raises:
        InputError: where a number is not finite or the tread is not above 0.
    """
    steps = as_array(rises, "rises", (None,))
    edge, depth = as_number(first_edge, "first_edge", unit="m"), as_number(tread, "tread", above=0.0, unit="m")
    return Ground(tuple(edge + depth * k for k in range(len(steps))), (0.0, *np.cumsum(steps).tolist()))
