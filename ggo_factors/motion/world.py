"""The ground along a whole way, in one world frame, of which each step sees its part."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.leg_model import Foot
from ggo_factors.motion.surface import Surface
from ggo_factors.motion.terrain import FARTHEST, NOSE, Gap, Ground, Obstacle
from ggo_factors.motion.terrain_file import parsed_terrain, terrain_text
from ggo_factors.support.files import PathLike, read_text, write_text
from ggo_factors.support.inputs import Array, as_array, as_count, as_instance, as_number, as_tuple_of, short_text

SAME_PLACE = 1e-6
"""Surfaces whose ends differ by no more than this in [m] meet there."""
MOST_SURFACES = 1000
"""A terrain of more surfaces is refused as a mistake."""
RAMP_BESIDE = 0.3
"""A ramp within this distance in [m] of a pit or box may have a sole on it that reaches it."""


@dataclass(frozen=True)
class Terrain:
    """The ground along a way: surfaces with risers between them, boxes and pits, in one world frame.

    The frame: x forward, y up, in [m]; a walker begins with the supporting ankle over x = 0 unless it is told where.
    Behind its first surface the ground goes on as it begins, since the walker came from there; beyond the last one it
    is unknown, and no foothold. Terrains are put one behind another by ``+``, the second where the first ends::

        Terrain.level(1.2) + Terrain.stairs(3, riser=0.12, tread=0.3) + Terrain.ramp(1.5, math.radians(-8))

    Attributes:
        surfaces: what carries a foot, each beginning where the one before ends; a jump in height there is a riser.
        boxes: what stands in the way: x in the world frame, height above the highest ground under the box.
        pits: where there is no foothold: x in the world frame.
        name: what it is called.

    Raises:
        InputError: where there is no surface, or one does not begin where the one before ends, naming both.
    """

    surfaces: tuple[Surface, ...]
    boxes: tuple[Obstacle, ...] = ()
    pits: tuple[Gap, ...] = ()
    name: str = "terrain"

    def __post_init__(self) -> None:
        surfaces = as_tuple_of(self.surfaces, "surfaces", Surface)
        as_count(len(surfaces), "surfaces", 1, MOST_SURFACES)
        for number, (one, other) in enumerate(pairwise(surfaces), start=1):
            if abs(one.x_end - other.x_start) > SAME_PLACE:
                raise InputError(
                    f"surfaces: surface {number} ends at {one.x_end:g} m, the next begins at {other.x_start:g} m; a "
                    f"stretch that carries no foot is a pit over a surface"
                )
        joined = [replace(one, x_end=other.x_start) for one, other in pairwise(surfaces)]
        object.__setattr__(self, "surfaces", (*joined, surfaces[-1]))
        object.__setattr__(self, "boxes", as_tuple_of(self.boxes, "boxes", Obstacle))
        object.__setattr__(self, "pits", as_tuple_of(self.pits, "pits", Gap))
        as_instance(self.name, "name", str)
        for kind, shapes in (("boxes", self.boxes), ("pits", self.pits)):
            for shape in shapes:
                if shape.x_end > self.x_end + FARTHEST or (kind == "boxes" and shape.x_start > self.x_end):
                    raise InputError(f"{kind}: {shape} lies beyond the end of the terrain at {self.x_end:g} m")
        for box in self.boxes:
            if box.base:
                raise InputError(f"boxes: {box} has a base; in a terrain a box stands on the ground")

    def __repr__(self) -> str:
        risers = sum(bool(rise) for *_, rise in self.seams)
        ramps = sum(bool(surface.slope) for surface in self.surfaces)
        count = [(risers, "riser"), (ramps, "ramp"), (len(self.boxes), "box"), (len(self.pits), "pit")]
        words = [f"{n} {word}{'' if n == 1 else 'es' if word == 'box' else 's'}" for n, word in count if n]
        return f"Terrain({short_text(self.name)}, {', '.join([f'{self.length:.4g} m', *words])})"

    def _repr_html_(self) -> str:
        from ggo_factors.motion.cards import terrain_card  # only here: nothing but a notebook needs it

        line = self.whole.line(self.x_start, self.x_end)
        rough = max(
            *(max(surface.edge_std, surface.height_std) for surface in self.surfaces),
            *(max(box.edge_std, box.height_std) for box in self.boxes),
            *(pit.edge_std for pit in self.pits),
            0.0,
        )
        facts = {
            "along": f"x = {self.x_start:.4g} to {self.x_end:.4g} m",
            "heights": f"{line[:, 1].min():.4g} to {line[:, 1].max():.4g} m",
            "surfaces": list(map(str, self.surfaces)),
            "boxes": list(map(str, self.boxes)),
            "pits": list(map(str, self.pits)),
            "measured": f"to a standard deviation of at most {rough * 1e3:.3g} mm" if rough else "",
        }
        ends, boxes = (self.x_start, self.x_end), list(zip(self.boxes, self.tops, strict=True))
        return terrain_card(f"Terrain: {self.name}", self.whole, ends, boxes, self.pits, facts)

    @classmethod
    def level(cls, length: float, *, rise: float = 0.0, edge_std: float = 0.0, height_std: float = 0.0) -> Terrain:
        """Level ground of a length in [m], `rise` above what lies before it in [m]; a kerb where that is not 0."""
        return cls((Surface(0.0, length, rise, 0.0, edge_std, height_std),))

    @classmethod
    def ramp(cls, length: float, slope: float, *, edge_std: float = 0.0, height_std: float = 0.0) -> Terrain:
        """A ramp of a length along x in [m] and a slope in [rad], up positive."""
        return cls((Surface(0.0, length, 0.0, slope, edge_std, height_std),))

    @classmethod
    def stairs(
        cls,
        steps: int,
        *,
        riser: float | Sequence[float],
        tread: float,
        edge_std: float = 0.0,
        height_std: float = 0.0,
    ) -> Terrain:
        """Stairs that begin with a riser.

        Args:
            steps: how many risers.
            riser: rise of each in [m], negative downwards; a number, or one for each.
            tread: depth of each tread in [m], the last included.
            edge_std: standard deviation of each riser's place in [m].
            height_std: standard deviation of each tread's height in [m].

        Raises:
            InputError: where a number is out of its range.
        """
        count, depth = as_count(steps, "steps", 1, MOST_SURFACES), as_number(tread, "tread", above=0.0, unit="m")
        rises = as_array([riser] * count if np.ndim(riser) == 0 else riser, "riser", (count,))
        heights = np.cumsum(rises).tolist()
        pieces = [
            Surface(n * depth, (n + 1) * depth, height, 0.0, edge_std, height_std) for n, height in enumerate(heights)
        ]
        return cls(tuple(pieces))

    @classmethod
    def pit(cls, length: float, *, edge_std: float = 0.0) -> Terrain:
        """A pit of a length in [m], the ground on both sides at one height."""
        flat = cls.level(length)
        return replace(flat, pits=(Gap(0.0, flat.x_end, edge_std),))

    def __add__(self, other: Terrain) -> Terrain:
        """This terrain and another one behind it: the origin of the other is where this one ends."""
        if not isinstance(other, Terrain):
            return NotImplemented
        x, y = self.x_end - other.x_start, self.surfaces[-1].end_height
        boxes = [replace(box, x_start=box.x_start + x, x_end=box.x_end + x) for box in other.boxes]
        pits = [replace(pit, x_start=pit.x_start + x, x_end=pit.x_end + x) for pit in other.pits]
        surfaces = [surface.shifted(x, y) for surface in other.surfaces]
        first, last = surfaces[0], self.surfaces[-1]
        alike = (first.slope, first.edge_std, first.height_std) == (last.slope, 0.0, last.height_std)
        before = self.surfaces
        if alike and abs(first.height - last.end_height) <= SAME_PLACE:
            before, surfaces[0] = before[:-1], replace(last, x_end=first.x_end)
        return replace(self, surfaces=(*before, *surfaces), boxes=(*self.boxes, *boxes), pits=(*self.pits, *pits))

    def with_boxes(self, *boxes: Obstacle) -> Terrain:
        """The terrain with more boxes, in the world frame."""
        return replace(self, boxes=(*self.boxes, *boxes))

    def with_pits(self, *pits: Gap) -> Terrain:
        """The terrain with more pits, in the world frame."""
        return replace(self, pits=(*self.pits, *pits))

    @property
    def x_start(self) -> float:
        """Where it begins in [m]."""
        return self.surfaces[0].x_start

    @property
    def x_end(self) -> float:
        """Where it ends in [m]."""
        return self.surfaces[-1].x_end

    @property
    def length(self) -> float:
        """How long it is in [m]."""
        return self.x_end - self.x_start

    @cached_property
    def rises(self) -> tuple[float, ...]:
        """How much higher each surface but the first begins than the one before ends, in [m]."""
        return tuple(b.height - a.end_height for a, b in pairwise(self.surfaces))

    @cached_property
    def seams(self) -> tuple[tuple[Surface, Surface, float], ...]:
        """Each two surfaces that meet, and the rise between them in [m]; exactly 0 where they join without a riser."""
        rises = (rise if abs(rise) > SAME_PLACE else 0.0 for rise in self.rises)
        return tuple((*both, rise) for both, rise in zip(pairwise(self.surfaces), rises, strict=True))

    @cached_property
    def whole(self) -> Ground:
        """All of the ground, in the world frame."""
        first, *others = self.surfaces
        height = first.end_height if others else first.height - math.tan(first.slope) * first.x_start
        return Ground(
            tuple(surface.x_start for surface in others),
            (height, *(surface.height for surface in others)),
            tuple(surface.slope for surface in self.surfaces),
        )

    @cached_property
    def tops(self) -> tuple[float, ...]:
        """Height of the top of each box in the world frame in [m]."""
        under = [float(self.whole.highest_between(np.float64(b.x_start), np.float64(b.x_end))) for b in self.boxes]
        return tuple(ground + box.height for ground, box in zip(under, self.boxes, strict=True))

    @cached_property
    def no_footholds(self) -> tuple[Gap, ...]:
        """The pits, and what lies beyond the end."""
        return (*self.pits, Gap(min(self.x_end, FARTHEST), self.x_end + FARTHEST, unknown=True))

    def height_at(self, x: ArrayLike) -> Array:
        """Height of the ground in [m] at `x` in [m]; at a riser the higher of its two sides."""
        return self.whole.height_at(x)

    def slope_at(self, x: float) -> float:
        """Slope of the ground in [rad] at `x` in [m]."""
        return self.whole.slope_at(x)

    def surface_at(self, x: float) -> int:
        """Number of the surface under `x` in [m], from 0; at an edge the one ahead."""
        return bisect_right(self.whole.edges, x)

    def ankle_at(self, x: float, foot: Foot) -> float:
        """Height in the world frame in [m] of the ankle of a foot that stands with its ankle over `x` in [m]."""
        return float(self.height_at(x)) + self.whole.ankle_over(foot, x)

    def seen_from(self, x: float, low: float, high: float) -> Ground:
        """The ground between `low` and `high` in [m], in the body frame of a foot that stands at `x` in [m]."""
        y, whole = float(self.height_at(x)), self.whole
        edges = [n for n, edge in enumerate(whole.edges) if low < edge < high]
        first, last = (edges[0], edges[-1] + 1) if edges else (self.surface_at(x),) * 2
        pieces = self.surfaces[first : last + 1]
        slopes = tuple(piece.slope for piece in pieces)
        if not edges:
            return Ground(slopes=slopes)
        heights = (pieces[0].end_height - y, *(piece.height - y for piece in pieces[1:]))
        return Ground(tuple(whole.edges[n] - x for n in edges), heights, slopes)

    def boxes_from(self, x: float, low: float, high: float, foot: Foot) -> tuple[Obstacle, ...]:
        """The boxes between `low` and `high` in [m], in the body frame of a foot that stands at `x` in [m].

        Where the ground beside a box is a ramp, the sole may hang down from the ankle by its length times the slope,
        and be further on or back by the ankle's height times it; the box counts so much higher and longer. A riser
        that was measured with an error is a box too, as deep as `NOSE`.
        """
        y, found = float(self.height_at(x)), list[Obstacle]()
        steepest = self.steepest_between(low, high)
        hangs, aside = max(foot.heel, foot.toe) * math.sin(steepest), foot.ankle_height * math.sin(steepest)
        for box, top in zip(self.boxes, self.tops, strict=True):
            if box.x_end > low and box.x_start < high:
                base = min(top - box.height - y, 0.0)
                ends = box.x_start - aside - x, box.x_end + aside - x
                found.append(Obstacle(*ends, top + hangs - y, box.edge_std, box.height_std, base))
        for before, surface, rise in self.seams:
            edge = surface.x_start
            if not rise or not low < edge < high or not (surface.edge_std or surface.height_std):
                continue
            upper = surface.height if rise > 0.0 else before.end_height
            std = surface.height_std if rise > 0.0 else before.height_std
            ends = (edge, edge + NOSE) if rise > 0.0 else (edge - NOSE, edge)
            top = upper - y
            found.append(Obstacle(ends[0] - x, ends[1] - x, top, surface.edge_std, std, min(top, 0.0)))
        return tuple(found)

    def pits_from(self, x: float, low: float, high: float, foot: Foot) -> tuple[Gap, ...]:
        """The pits and unknown ground between `low` and `high` in [m], in the body frame of a foot at `x` in [m].

        They are longer beside ramps: a sole on one is further on, or back, than its ankle.
        """
        found = list[Gap]()
        for pit in self.no_footholds:
            if pit.x_end > low and pit.x_start < high:
                steepest = self.steepest_between(pit.x_start - RAMP_BESIDE, pit.x_end + RAMP_BESIDE)
                aside = foot.ankle_height * math.sin(steepest)
                found.append(replace(pit, x_start=pit.x_start - aside - x, x_end=pit.x_end + aside - x))
        return tuple(found)

    def steepest_between(self, low: float, high: float) -> float:
        """Largest slope in [rad], of any sign, of what lies between `low` and `high` in [m]."""
        first, last = self.surface_at(low), self.surface_at(high)
        return max(abs(surface.slope) for surface in self.surfaces[first : last + 1])

    def save(self, path: PathLike) -> None:
        """Write the terrain as TOML, `# ggo-terrain 1`, whole or not at all.

        Raises:
            InputError: where the file cannot be written.
        """
        write_text(path, self.to_toml())

    def to_toml(self) -> str:
        """The terrain as the text of its file; `motion.terrain_file` describes the form."""
        return terrain_text(self.surfaces, self.boxes, self.pits, self.name)

    @classmethod
    def from_toml(cls, text: str) -> Terrain:
        """The terrain that `to_toml` gave.

        Raises:
            InputError: naming the table and the value that is wrong.
        """
        return cls(*parsed_terrain(text))


def load_terrain(path: PathLike) -> Terrain:
    """Read a terrain from TOML; `motion.terrain_file` describes the form.

    Raises:
        InputError: naming the file, the table and the value that is wrong.
    """
    text = read_text(path)
    try:
        return Terrain.from_toml(text)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
