"""What the pieces of a profile are: ground, boxes, pits, and what nobody saw."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.surface import Surface
from ggo_factors.motion.terrain import LARGEST_STD, STEEPEST, Gap, Obstacle
from ggo_factors.motion.world import Terrain
from ggo_factors.seeing.edges import CLEAR, NEAR, Place, Points, change, combined, rim, side
from ggo_factors.seeing.pieces import Piece, merged, pieces_of
from ggo_factors.seeing.profile import CELL, Profile
from ggo_factors.seeing.strip import BEHIND

LEAST_SLOPE = math.tan(math.radians(1.5))
"""Ground of a smaller rise by metre is level: floors that drain, and cameras that are told a wrong `up`."""
ONE_LINE = 0.006
"""Pieces off one line by less than this in [m] are one; half of the least riser that is told."""
HOLE = 0.05
"""Ground is unknown where it was not seen over more than this in [m]: less is between two rows of pixels."""
NARROW = 0.45
"""What is higher or lower than both neighbours and shorter than this in [m] is a box or a pit: a foot does not fit
safely on it. Beyond it is ground that goes up and down."""
UNSEEN = 0.08
"""How much longer than its seen part in [m] a pit is taken for whose near edge the camera does not see."""
HIGHEST_RISER = 0.3
"""Ground that is more than this in [m] higher or lower than that before it carries no step."""
LEAST_STEP = 0.02
"""The first ground that is seen is the one that the foot stands on where it is no more than this in [m] off."""
LEAST_BOX, LEAST_PIT = 0.008, 0.03
"""A box is so much higher than its neighbours in [m], a pit so much lower."""
IN_THE_WAY = 0.03
"""Cells that reach so much above the ground in [m] hold something."""
FEWEST = 3
"""So many high cells without a level top are something; fewer fly at an edge."""
LEAST_PIECE = 0.012
"""Pieces shorter than this in [m] are of a side, where cells of several frames lie close together."""
LEAST_LENGTH = 0.002
"""Shorter stretches in [m] are no ground."""
SURE, LEAST_MARGIN = 2.5, 0.004
"""A point further off a piece than so many standard deviations, and so much in [m], is not of it."""
STANDING = 0.15
"""Ground up to this far in [m] ahead of the ankle is known: the foot stands on it."""


@dataclass(frozen=True)
class Block:
    """Something higher than the ground around it.

    Attributes:
        x_start: where its cells begin in [m].
        x_end: where they end.
        top: its height in [m].
        top_var: variance of that in [m^2].
        piece: its top where it has a level one.
    """

    x_start: float
    x_end: float
    top: float
    top_var: float
    piece: Piece | None


UNDERFOOT = Piece(np.empty(0, np.int64), BEHIND, STANDING, 0.0, 0.0, 0.0, 0.0, 0.0, 0.001)
"""The ground that the foot stands on, where that is known; no cell is of it."""


def _narrow(before: Piece, piece: Piece, after: Piece) -> str:
    """Whether a piece between two others is a "box" or a "pit"; "" where it carries a foot."""
    up = piece.at(piece.x_start) - before.at(piece.x_start)
    down = piece.at(piece.x_end) - after.at(piece.x_end)
    if up > LEAST_BOX and down > LEAST_BOX and piece.length < NARROW:
        return "box"
    length = piece.length + UNSEEN if before is UNDERFOOT else after.x_start - before.x_end
    return "pit" if up < -LEAST_PIT and down < -LEAST_PIT and length < NARROW else ""


class Scene:
    """What one profile shows, step by step; `terrain` puts it together."""

    def __init__(
        self, profile: Profile, frames: Sequence[Points], std: tuple[float, float], tilt_std: float, stands: bool
    ) -> None:
        """Divide a profile.

        Args:
            profile: the profile, level ground made level.
            frames: the points of each frame.
            std: standard deviations in [m] of what all edges, and all heights, have in common.
            tilt_std: standard deviation of the slope that all ground has in common, in [rad].
            stands: whether the foot stands at height 0.

        Raises:
            InputError: where no ground is seen.
        """
        self.profile, self.frames, self.tilt_std = profile, frames, tilt_std
        self.edge_std, self.height_std = std
        pieces = [piece for piece in pieces_of(profile, LEAST_SLOPE) if piece.length > LEAST_PIECE]
        pieces = merged(profile, pieces, ONE_LINE, LEAST_SLOPE)
        self.ground, self.raised = self._sorted_out(([UNDERFOOT] if stands else []) + pieces)
        if self.ground[:1] == [UNDERFOOT] and len(self.ground) > 1:
            first = self.ground[1]
            if abs(first.at(first.x_start)) < LEAST_STEP:
                self.ground = self.ground[1:]
        if self.ground in ([], [UNDERFOOT]):
            raise InputError("points: no ground is seen: nowhere do they lie on a line that a foot could stand on")
        self.blocks = self._blocks()

    def _sorted_out(self, pieces: list[Piece]) -> tuple[list[Piece], list[Piece]]:
        """Pieces that carry a foot, and those that stand in the way."""
        ground, raised = list[Piece](), list[Piece]()
        for piece in pieces:
            if abs(piece.slope) > math.tan(STEEPEST):
                continue
            rise = piece.at(piece.x_start) - (ground[-1].at(piece.x_start) if ground else 0.0)
            if abs(rise) <= HIGHEST_RISER:
                ground.append(piece)
            elif rise > 0.0:
                raised.append(piece)
        ground = merged(self.profile, ground, ONE_LINE, LEAST_SLOPE)
        while True:
            triples = zip(ground, ground[1:], ground[2:], strict=False)
            narrow = next(
                ((piece, kind) for one, piece, other in triples if (kind := _narrow(one, piece, other))), None
            )
            if narrow is None:
                return ground, raised
            raised += [narrow[0]] if narrow[1] == "box" else []
            ground.remove(narrow[0])
            ground = merged(self.profile, ground, ONE_LINE, LEAST_SLOPE)

    def _base(self, x: float) -> float:
        """The highest ground in [m] beside `x`."""
        before = [piece for piece in self.ground if piece.x_start + NEAR <= x]
        after = [piece for piece in self.ground if piece.x_end - NEAR >= x]
        under = [piece for piece in self.ground if piece.x_start <= x <= piece.x_end]
        return max(piece.at(x) for piece in (*before[-1:], *under, *after[:1]))

    def _blocks(self) -> list[Block]:
        profile, mine = self.profile, {int(cell) for piece in self.ground for cell in piece.cells}
        tops = {int(cell): piece for piece in self.raised for cell in piece.cells}
        groups = list[list[int]]()
        for cell, (x, height) in enumerate(zip(profile.x.tolist(), profile.height.tolist(), strict=True)):
            high = height - self._base(x) > max(IN_THE_WAY, 4.0 * float(profile.noise[cell]))
            if cell in tops or (high and cell not in mine):
                last = groups[-1][-1] if groups else -1
                same = cell in tops and tops.get(last) is tops[cell]
                if groups and (same or x - profile.x[last] < 3.5 * CELL):
                    groups[-1].append(cell)
                else:
                    groups.append([cell])
        found = []
        for group in groups:
            pieces = list({id(tops[cell]): tops[cell] for cell in group if cell in tops}.values())
            ends = float(profile.x[group[0]]), float(profile.x[group[-1]])
            if pieces:
                highest = max(pieces, key=lambda piece: piece.height)
                top = max(highest.at(highest.x_start), highest.at(highest.x_end))
                found.append(Block(*ends, top, highest.var_at(highest.x_start), pieces[-1]))
            elif len(group) >= FEWEST:
                cell = group[int(profile.height[group].argmax())]
                found.append(Block(*ends, float(profile.height[cell]), float(profile.noise[cell]) ** 2, None))
        return found

    def terrain(self, name: str) -> Terrain:
        """The terrain."""
        boxes = [self._box(block) for block in self.blocks]
        edges = [self._edge(before, after) for before, after in pairwise(self.ground)]
        first, last = self.ground[0], self.ground[-1]
        start = Place(min(first.x_start, 0.0), 0.0)
        surfaces = []
        for piece, stop in zip(self.ground, edges, strict=False):
            # Where an edge is told before the one before it, what lies between is too short to be ground.
            if stop.x - start.x > LEAST_LENGTH:
                surfaces.append(self._surface(piece, start, stop.x))
                start = stop
        end = max([last.x_end + CELL / 2.0, start.x + CELL, *(box.x_start + CELL for box in boxes)])
        surfaces.append(self._surface(last, start, end))
        pits = self._holes(boxes)
        return Terrain(tuple(surfaces), tuple(boxes), tuple(pits), name)

    def _surface(self, piece: Piece, start: Place, stop: float) -> Surface:
        slope = float(np.clip(math.atan(piece.slope), -STEEPEST, STEEPEST))
        return Surface(
            start.x, stop, piece.at(start.x), slope, self._off(start.std) if start.std else 0.0, self._height_std(piece)
        )

    def _height_std(self, piece: Piece) -> float:
        near = min(max(0.0, piece.x_start), piece.x_end)
        return min(math.sqrt(piece.var_at(near) + self.height_std**2 + (self.tilt_std * near) ** 2), LARGEST_STD)

    def _off(self, std: float) -> float:
        """Standard deviation of a place in [m], with what all have in common."""
        return min(math.hypot(std, self.edge_std), LARGEST_STD)

    def _edge(self, before: Piece, after: Piece) -> Place:
        """Where one piece of ground ends and the next begins."""
        for block in self.blocks:
            if before.x_end - CELL < block.x_start and block.x_end < after.x_start + CELL:
                return Place((block.x_start + block.x_end) / 2.0, 0.0)
        middle = (before.x_end + after.x_start) / 2.0
        rise = after.at(middle) - before.at(middle)
        bend = after.slope - before.slope
        if abs(bend) > LEAST_SLOPE / 2.0:
            meet = middle - rise / bend
            if before.x_end - HOLE < meet < after.x_start + HOLE:
                var = before.var_at(meet) + after.var_at(meet)
                return Place(meet, min(math.sqrt(var) / abs(bend), LARGEST_STD))
        noise = max(before.noise, after.noise)
        if not (rise > CLEAR * noise or rise < -CLEAR / 2.0 * noise):
            low, high = before.x_end - NEAR, after.x_start + NEAR
            found = combined(change(points, before, after, low, high) for points in self.frames)
            return found or Place((low + high) / 2.0, (high - low) / math.sqrt(12.0))
        if rise < 0.0:
            return self._rim(before, before.x_end, 1.0, after.at(before.x_end))
        return self._front(before, after)

    def _rim(self, piece: Piece, end: float, way: float, *others: float) -> Place:
        found = combined(rim(points, piece, end, way, np.array(others)) for points in self.frames)
        return found or Place(end + way * CELL / 2.0, CELL)

    def _margin(self, piece: Piece) -> float:
        """How far in [m] from a piece a point is not of it."""
        return max(SURE * piece.noise, LEAST_MARGIN)

    def _side(self, low: float, high: float, bottom: float, top: float) -> Place | None:
        return combined(side(points, low, high, bottom, top) for points in self.frames)

    def _front(self, before: Piece, after: Piece) -> Place:
        """Where a piece begins whose side the camera sees, or at least its near rim."""
        start = after.x_start
        top = after.at(start) - self._margin(after)
        low = max(before.x_end, start) - NEAR
        bottom = before.at(start) + self._margin(before)
        return self._side(low, start + NEAR / 2.0, bottom, top) or self._rim(after, start, -1.0)

    def _box(self, block: Block) -> Obstacle:
        base = self._base(block.x_start)
        margin = self._margin(block.piece or self.ground[0])
        near = self._side(block.x_start - NEAR, block.x_start + NEAR, base + margin, block.top - margin)
        near = near or Place(block.x_start - CELL / 2.0, CELL)
        far = Place(block.x_end + CELL / 2.0, CELL)
        if block.piece is not None:
            far = self._rim(block.piece, block.piece.x_end, 1.0, self._base(block.x_end))
        under = max(self._base(near.x), self._base(far.x))
        return Obstacle(
            near.x,
            max(far.x, near.x + CELL),
            max(block.top - under, 0.001),
            self._off(max(near.std, far.std)),
            min(math.hypot(math.sqrt(block.top_var), self.height_std), LARGEST_STD),
        )

    def _holes(self, boxes: list[Obstacle]) -> list[Gap]:
        """Pits, and what nobody saw."""
        found = list[Gap]()
        profile = self.profile
        seen = [(float(profile.x[cell]), piece) for piece in self.ground for cell in piece.cells]
        if seen[0][0] > STANDING + HOLE:
            front = min([seen[0][0] - CELL / 2.0, *(box.x_start for box in boxes if box.x_start > STANDING + HOLE)])
            found.append(Gap(STANDING, front, self.edge_std, unknown=True))
        for (x, before), (ahead, after) in pairwise(seen):
            if ahead - x > HOLE:
                found += self._hole(x, before, ahead, after, boxes)
        return found

    def _hole(self, x: float, before: Piece, ahead: float, after: Piece, boxes: list[Obstacle]) -> list[Gap]:
        between = [box for box in boxes if x - NEAR < box.x_start and box.x_end < ahead + NEAR]
        if between:
            back = max(box.x_end for box in between)
            return [Gap(back, ahead - CELL / 2.0, self.edge_std, unknown=True)] if ahead - back > HOLE / 2.0 else []
        low = min(before.at(x), after.at(ahead))
        inside = slice(*np.searchsorted(self.profile.x, (x, ahead + NEAR)))
        below = self.profile.height[inside] < low - max(LEAST_PIT, 4.0 * max(before.noise, after.noise))
        if not below.any():
            start = x + CELL / 2.0
            if before is not after and after.at(x) < before.at(x):
                start = min(self._rim(before, x, 1.0, after.at(x)).x, start)
            return [Gap(start, ahead - CELL / 2.0, self.edge_std, unknown=True)]
        near = self._rim(before, x, 1.0)
        top = after.at(ahead) - self._margin(after)
        far = self._side(ahead - NEAR, ahead + NEAR / 2.0, top - HIGHEST_RISER, top)
        far = far or self._rim(after, ahead, -1.0)
        return [Gap(near.x, max(far.x, near.x + CELL), self._off(max(near.std, far.std)))]
