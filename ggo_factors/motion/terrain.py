"""The ground as one step sees it: obstacles, gaps, treads, and what the swing ankle must clear so that the foot does.

`motion.world` has the ground along a whole way, of which this is a view from one supporting foot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.leg_model import Foot
from ggo_factors.support.inputs import Array, as_array, as_bool, as_number

LARGEST_STD = 0.1
"""Largest standard deviation of an obstacle's edges and height in [m]: five times that of a poor
depth camera; a larger one is surely a mistake."""

STEEPEST = math.radians(15.0)
"""Largest slope of a ramp in [rad]: beyond it people climb on their toes, and a flat sole slips."""

CELL = 0.01
"""How finely the ground is sampled in [m] where a sole turns from one slope to another."""

NOSE = 0.001
"""Depth in [m] of the box that stands for a riser whose place or height was measured with an error."""
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
        height: height of its top above the ground under the supporting foot in [m], `base` or more.
        edge_std: standard deviation of each of the two edges in [m], their errors independent; 0 where they are known,
            0.005 to 0.020 for depth cameras, at most `LARGEST_STD`. See `check.uncertainty`.
        height_std: the same of the height.
        base: height of the ground that it stands on above that under the supporting foot in [m], below 0 on the way
            down stairs.

    Raises:
        InputError: where a number is not finite or out of its range, or the far edge is not beyond the near one.
    """

    x_start: float
    x_end: float
    height: float
    edge_std: float = 0.0
    height_std: float = 0.0
    base: float = 0.0

    def __post_init__(self) -> None:
        _check_span(self)
        object.__setattr__(self, "base", as_number(self.base, "base", unit="m"))
        object.__setattr__(self, "height", as_number(self.height, "height", at_least=self.base, unit="m"))
        for name in ("edge_std", "height_std"):
            number = as_number(getattr(self, name), name, at_least=0.0, at_most=LARGEST_STD, unit="m")
            object.__setattr__(self, name, number)

    def __repr__(self) -> str:
        spread = f", edge_std={self.edge_std!r}, height_std={self.height_std!r}" if self.is_uncertain else ""
        base = f", base={self.base!r}" if self.base else ""
        return f"Obstacle({self.x_start!r}, {self.x_end!r}, {self.height!r}{spread}{base})"

    def __str__(self) -> str:
        spread = f" (edges \u00b1 {self.edge_std:g}, height \u00b1 {self.height_std:g} m)" if self.is_uncertain else ""
        return f"box from {self.x_start:g} to {self.x_end:g} m, {self.height:g} m high{spread}"

    @property
    def is_uncertain(self) -> bool:
        """Whether its edges or its height were measured with an error."""
        return self.edge_std > 0.0 or self.height_std > 0.0

    @property
    def is_edge(self) -> bool:
        """Whether it only stands for the edge of a riser, no deeper than `NOSE`."""
        return self.x_end - self.x_start <= 1.001 * NOSE

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
        # A box on the ground under the supporting foot stays so where it merely stands a little higher.
        height, base = self.height - y, self.base - y
        return replace(
            self,
            x_start=self.x_start - x,
            x_end=self.x_end - x,
            height=height,
            base=0.0 if self.base == 0.0 and height >= 0.0 else base,
        )


@dataclass(frozen=True)
class Gap:
    """A pit: no foothold in it.

    Attributes:
        x_start: near edge in [m], in the body frame of its step.
        x_end: far edge in [m].
        edge_std: standard deviation of each of the two edges in [m], as for `Obstacle`.
        unknown: whether it is ground that nobody saw, rather than a pit.

    Raises:
        InputError: where a number is not finite or out of its range, or the far edge is not beyond the near one.
    """

    x_start: float
    x_end: float
    edge_std: float = 0.0
    unknown: bool = False

    def __post_init__(self) -> None:
        _check_span(self)
        number = as_number(self.edge_std, "edge_std", at_least=0.0, at_most=LARGEST_STD, unit="m")
        object.__setattr__(self, "edge_std", number)
        object.__setattr__(self, "unknown", as_bool(self.unknown, "unknown"))

    def __repr__(self) -> str:
        spread = f", edge_std={self.edge_std!r}" if self.edge_std else ""
        unknown = ", unknown=True" if self.unknown else ""
        return f"Gap({self.x_start!r}, {self.x_end!r}{spread}{unknown})"

    def __str__(self) -> str:
        return f"{'unknown ground' if self.unknown else 'gap'} from {self.x_start:g} to {self.x_end:g} m"

    def for_ankle(self, foot: Foot) -> Gap:
        """Where the swing ankle must not land, so that no part of the sole stands over the gap."""
        return replace(self, x_start=self.x_start - foot.toe, x_end=self.x_end + foot.heel)

    def shifted(self, x: float) -> Gap:
        """The gap as seen from a body frame that stands `x` [m] further on."""
        return replace(self, x_start=self.x_start - x, x_end=self.x_end - x)


@dataclass(frozen=True)
class Ground:
    """Level ground, treads at different heights with risers between them, ramps.

    Attributes:
        edges: x in [m] where one piece ends and the next begins, ascending, shape (n,), in the body frame of its step;
            a riser where their heights differ.
        heights: height of each piece at its near edge in [m], shape (n + 1,), from behind to ahead; of the first at
            its far edge, or at 0 where there is no other. 0 under the supporting foot.
        slopes: slope of each piece in [rad], up positive, at most `STEEPEST`, shape (n + 1,); all level if empty.

    Raises:
        InputError: where the numbers do not fit together.
    """

    edges: tuple[float, ...] = ()
    heights: tuple[float, ...] = (0.0,)
    slopes: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        edges, heights = as_array(self.edges, "edges", (None,)), as_array(self.heights, "heights", (None,))
        if len(heights) != len(edges) + 1:
            raise InputError(f"heights: {len(edges)} edges need {len(edges) + 1} heights, got {len(heights)}")
        given = edges.tolist()
        if (np.diff(edges) <= 0.0).any():
            raise InputError(f"edges: {given} must ascend")
        slopes = as_array(self.slopes, "slopes", (None,))
        if len(slopes) not in (0, len(heights)):
            raise InputError(f"slopes: {len(heights)} heights need as many slopes, or none; got {len(slopes)}")
        if not self._sampled and np.abs(slopes).max(initial=0.0) > STEEPEST + 1e-9:
            steepest = math.degrees(float(np.abs(slopes).max()))
            raise InputError(f"slopes: {steepest:g} degrees is above {math.degrees(STEEPEST):g} degrees")
        object.__setattr__(self, "edges", tuple(given))
        object.__setattr__(self, "heights", tuple(heights.tolist()))
        object.__setattr__(self, "slopes", tuple(slopes.tolist()) if slopes.any() else ())

    if TYPE_CHECKING:
        # For type checkers: what is made a tuple of numbers when it is made may be any list or array.
        def __init__(self, edges: ArrayLike = (), heights: ArrayLike = (0.0,), slopes: ArrayLike = ()) -> None: ...

    @property
    def _sampled(self) -> bool:
        """Whether this is what an ankle must stay above, whose pieces may be steeper than any ground."""
        return False

    @cached_property
    def _lines(self) -> tuple[Array, Array, Array]:
        """Of each piece the place, the height there, and the rise by metre."""
        places = [self.edges[0], *self.edges] if self.edges else [0.0]
        return np.array(places), np.array(self.heights), np.tan(self.slopes or (0.0,) * len(self.heights))

    @property
    def steepest(self) -> float:
        """Largest rise by metre, of any sign."""
        return float(np.abs(self._lines[2]).max()) if self.slopes else 0.0

    def height_at(self, x: ArrayLike) -> Array:
        """Height of the ground in [m] at `x` in [m]; at a riser the higher of its two sides."""
        x = np.asarray(x, dtype=np.float64)
        if not self.edges and not self.slopes:
            level = np.empty(x.shape)
            level.fill(self.heights[0])  # np.full takes ten times as long for one place
            return level
        left, right = np.searchsorted(self.edges, x, "left"), np.searchsorted(self.edges, x, "right")
        if not self.slopes:
            heights = np.array(self.heights)
            return np.asarray(np.maximum(heights[left], heights[right]), dtype=np.float64)
        places, heights, rises = self._lines
        sides = [heights[piece] + rises[piece] * (x - places[piece]) for piece in (left, right)]
        return np.asarray(np.maximum(*sides), dtype=np.float64)

    def slope_at(self, x: float) -> float:
        """Slope of the ground in [rad] at `x` in [m]; at an edge of the piece ahead."""
        return self.slopes[int(np.searchsorted(self.edges, x, "right"))] if self.slopes else 0.0

    def line(self, low: float, high: float) -> Array:
        """The surface between two places in [m], a polyline of shape (k, 2) in [m], two points at a riser."""
        cuts = np.array([low, *(edge for edge in self.edges if low < edge < high), high])
        # A piece is straight, so that two points within it say where it begins and ends.
        first, second = cuts[:-1] + np.diff(cuts) / 3.0, cuts[:-1] + np.diff(cuts) * 2.0 / 3.0
        near, far = self.height_at(first), self.height_at(second)
        points = np.empty((2 * len(first), 2))
        points[::2, 0], points[1::2, 0] = cuts[:-1], cuts[1:]
        points[::2, 1], points[1::2, 1] = 2.0 * near - far, 2.0 * far - near
        return points

    def is_edge(self, box: Obstacle) -> bool:
        """Whether a box only stands for the edge of a stair of this ground."""
        return any(box.x_start <= x <= box.x_end and box.height <= self.height_at(x) + 1e-9 for x in self.edges)

    def ankle_over(self, foot: Foot, x: float = 0.0) -> float:
        """How far the ankle of a foot that stands at `x` in [m] is over the ground right under it, in [m]."""
        return foot.ankle_height / math.cos(self.slope_at(x))

    def sole_tilt(self, x: ArrayLike, start: float, landing: float) -> Array:
        """Tilt of a swinging sole in [rad], its ankle at `x` in [m]: it turns evenly by x between the ends of its way.

        Args:
            x: where the ankle is, of any shape.
            start: where it leaves the ground; the sole then lies along the slope there.
            landing: where it lands, as for `start`.
        """
        way = landing - start
        share = np.clip((np.asarray(x) - start) / way, 0.0, 1.0) if way else np.zeros(np.shape(x))
        return np.asarray((1.0 - share) * self.slope_at(start) + share * self.slope_at(landing))

    def highest_between(self, x: ArrayLike, other: ArrayLike) -> Array:
        """The highest ground in [m] between `x` and `other`, both in [m], ends included."""
        low, high = np.minimum(x, other), np.maximum(x, other)
        top = np.maximum(self.height_at(low), self.height_at(high))
        if self.edges:
            # A piece is a straight line: what lies between is highest at an edge.
            tops = self.height_at(self.edges)
            between = (low[..., None] <= self.edges) & (self.edges <= high[..., None])
            top = np.maximum(top, np.where(between, tops, -math.inf).max(axis=-1))
        return np.asarray(top, dtype=np.float64)

    def shifted(self, x: float, y: float) -> Ground:
        """The ground as seen from a body frame that stands `x` further on and `y` higher, both in [m]."""
        rise = 0.0 if self.edges or not self.slopes else math.tan(self.slopes[0]) * x
        return type(self)(tuple(e - x for e in self.edges), tuple(h + rise - y for h in self.heights), self.slopes)

    def for_ankle(self, foot: Foot, ends: tuple[float, float] = (0.0, 0.0)) -> Ground:
        """The ground that the swing ankle must stay above so that the whole sole does.

        Each tread is widened by toe and heel. Where there are ramps, the sole turns along its way from the slope that
        it leaves to the one it lands on, evenly by x; the ground is then sampled every `CELL`, nowhere too low.

        Args:
            foot: the foot.
            ends: x of the swing ankle at start and landing in [m]; of no account without ramps.
        """
        if self.slopes:
            return self if foot == Foot() else self._under_turning_sole(foot, ends)
        if foot.toe == 0.0 and foot.heel == 0.0:
            return self
        edges = sorted({e - foot.toe for e in self.edges} | {e + foot.heel for e in self.edges})
        bounds = [-math.inf, *edges, math.inf]
        heights = []
        for low, high in pairwise(bounds):
            inside = high - 1.0 if math.isinf(low) else low + 1.0 if math.isinf(high) else (low + high) / 2.0
            heights.append(float(self.highest_between(inside - foot.heel, inside + foot.toe)))
        return Ground(tuple(edges), tuple(heights))

    def ankle_on(self, foot: Foot, x: float) -> float:
        """Height of the ankle in [m] above the supporting one, of a foot whose sole lies on the ground at `x` in [m].

        Where the ground is not even under the sole, it lies on the highest of it, parallel to the piece at `x`.
        """
        if not self.slopes:
            return float(self.highest_between(np.float64(x - foot.heel), np.float64(x + foot.toe)))
        return float(self._above(foot, np.array([x]), np.array([self.slope_at(x)]))[0])

    def _above(self, foot: Foot, x: Array, tilt: Array) -> Array:
        """Least height of an ankle in [m] at `x` in [m] over which a sole tilted by `tilt` in [rad] clears the ground.

        Both shape (n,). The highest point of straight pieces under a straight sole is at one of its ends or an edge.
        """
        along, down = np.cos(tilt), np.sin(tilt)
        middle = x + foot.ankle_height * down
        behind, ahead = middle - foot.heel * along, middle + foot.toe * along
        least = np.maximum(self.height_at(behind) + foot.heel * down, self.height_at(ahead) - foot.toe * down)
        for edge, top in zip(self.edges, self.height_at(self.edges).tolist(), strict=True):
            under = (behind <= edge) & (edge <= ahead)
            least = np.where(under, np.maximum(least, top - (edge - middle) * down / along), least)
        return np.asarray(least + foot.ankle_height * along - self.ankle_over(foot))

    def _under_turning_sole(self, foot: Foot, ends: tuple[float, float]) -> Ground:
        """As `for_ankle`, sampled around the way from one end to the other."""
        start, landing = ends
        reach = foot.heel + foot.toe + 0.1
        low, high = min(start, landing) - reach, max(start, landing) + reach
        grid = np.unique([*np.arange(low, high, CELL), high, start, landing])
        least = self._above(foot, grid, self.sole_tilt(grid, start, landing))
        # Where it jumps between two samples, it counts as high as the higher one.
        jumps = np.abs(np.diff(least)) > CELL
        begins = np.where(jumps, np.maximum(least[:-1], least[1:]), least[:-1])
        slopes = np.where(jumps, 0.0, np.arctan2(np.diff(least), np.diff(grid)))
        heights = (least[0], *begins.tolist(), least[-1])
        return _AnkleGround(tuple(grid.tolist()), heights, (0.0, *slopes.tolist(), 0.0))


class _AnkleGround(Ground):
    """What an ankle must stay above, sampled."""

    @property
    def _sampled(self) -> bool:
        return True


LEVEL = Ground()
"""Level ground at the height of the supporting foot."""


def stair_ground(first_edge: float, tread: float, rises: ArrayLike) -> Ground:
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
