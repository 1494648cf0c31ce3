"""Random courses of about ten steps, as plain numbers in one world frame: boxes, pits, risers, kerbs, ramps."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

import ggo_factors as ggo

LENGTH = 3.9
"""About ten steps of the paper's base gait, in [m]."""
BEFORE, BEHIND = 0.30, 0.60
"""Level ground before the first and behind the last feature, in [m]."""
KINDS = ("box", "pit", "up", "down", "kerb")

Piece = tuple[float, float, float, float]
Box = tuple[float, float, float]
Pit = tuple[float, float]


@dataclass(frozen=True)
class Course:
    """A way from x = 0 to a goal, all in [m] and [rad], in the world frame.

    Attributes:
        name: how to find it again.
        pieces: x_start, x_end, height at x_start, slope of each stretch of ground; ascending, without holes.
        boxes: x_start, x_end, height over the highest ground below.
        pits: x_start, x_end.
        goal: where to go.
    """

    name: str
    pieces: tuple[Piece, ...]
    boxes: tuple[Box, ...]
    pits: tuple[Pit, ...]
    goal: float

    def piece_at(self, x: float) -> Piece:
        """The stretch of ground under `x`; at an edge the one ahead."""
        return next((piece for piece in self.pieces if x < piece[1]), self.pieces[-1])

    def height_at(self, x: float) -> float:
        """Height of the ground under `x` in [m]."""
        start, _, height, slope = self.piece_at(x)
        return height + math.tan(slope) * (x - start)

    def top_of(self, box: Box) -> float:
        """Height of a box's top in the world frame in [m]; no box lies over a riser."""
        return max(self.height_at(box[0]), self.height_at(box[1])) + box[2]

    def terrain(self, std: float = 0.0) -> ggo.Terrain:
        """The same for the library, each edge and height with a standard deviation in [m]."""
        surfaces = [
            ggo.Surface(*piece, edge_std=std if n else 0.0, height_std=std if n else 0.0)
            for n, piece in enumerate(self.pieces)
        ]
        boxes = [ggo.Obstacle(*box, edge_std=std, height_std=std) for box in self.boxes]
        pits = [ggo.Gap(*pit, edge_std=std) for pit in self.pits]
        return ggo.Terrain(tuple(surfaces), tuple(boxes), tuple(pits), self.name)


def random_course(seed: int, length: float = LENGTH, ramp: bool | None = None) -> Course:
    """A course of features 0.2 to 0.5 m apart; one in three has a ramp, unless `ramp` says whether this one does."""
    rng = np.random.default_rng([16, seed])
    made = _Ground(x=float(rng.uniform(BEFORE, 2.0 * BEFORE)))
    sloped = seed % 3 == 0 if ramp is None else ramp
    ramp_at = float(rng.uniform(0.3, length - 1.9)) if sloped else math.inf
    while made.x < length - BEHIND:
        if made.x >= ramp_at:
            made.add_ramp(rng)
            ramp_at = math.inf
        else:
            made.add(str(rng.choice(KINDS)), rng)
        made.x += float(rng.uniform(0.2, 0.5))
    made.x += BEHIND - 0.2
    made.close(made.x)
    return Course(f"course {seed}", tuple(made.pieces), tuple(made.boxes), tuple(made.pits), made.x - 0.15)


class _Ground:
    """A course in the making: what lies behind `x`, and the ground that goes on there."""

    def __init__(self, x: float) -> None:
        self.x, self.height, self.begun = x, 0.0, 0.0
        self.pieces, self.boxes, self.pits = list[Piece](), list[Box](), list[Pit]()

    def close(self, x: float) -> None:
        """End the stretch of ground at `x`."""
        self.pieces.append((self.begun, x, self.height, 0.0))
        self.begun = x

    def add(self, kind: str, rng: np.random.Generator) -> None:
        """One feature at `x`, which then lies behind it."""
        if kind == "box":
            width, height = float(rng.uniform(0.02, 0.12)), float(rng.uniform(0.03, 0.25))
            self.boxes.append((self.x, self.x + width, height))
            self.x += width
        elif kind == "pit":
            width = float(rng.uniform(0.08, 0.38))
            self.pits.append((self.x, self.x + width))
            self.x += width
        elif kind == "kerb":
            rise, width = float(rng.uniform(0.05, 0.18)), float(rng.uniform(0.2, 0.5))
            self.rise(rise)
            self.x += width
            self.rise(-rise)
        else:
            self.rise(float(rng.uniform(0.05, 0.18)) * (1.0 if kind == "up" else -1.0))

    def rise(self, by: float) -> None:
        """A riser at `x`."""
        self.close(self.x)
        self.height += by

    def add_ramp(self, rng: np.random.Generator) -> None:
        """A ramp at `x`; a box stands on one in three."""
        slope, width = math.radians(float(rng.uniform(3.0, 15.0)) * rng.choice([-1, 1])), float(rng.uniform(0.6, 1.4))
        self.close(self.x)
        self.pieces.append((self.x, self.x + width, self.height, slope))
        if rng.random() < 1.0 / 3.0:
            at = self.x + float(rng.uniform(0.2, width - 0.3))
            self.boxes.append((at, at + float(rng.uniform(0.02, 0.10)), float(rng.uniform(0.03, 0.15))))
        self.x += width
        self.height += math.tan(slope) * width
        self.begun = self.x


def shaken(course: Course, std: float, seed: int) -> Course:
    """The course as it is measured once more: each edge and height with an error of `std` in [m]."""
    rng = np.random.default_rng([61, seed])
    edges = [course.pieces[0][0], *(piece[0] + std * rng.standard_normal() for piece in course.pieces[1:])]
    ends = [*edges[1:], course.pieces[-1][1]]
    pieces, before = list[Piece](), math.nan
    for (start, end, height, slope), x, x_end in zip(course.pieces, edges, ends, strict=True):
        y = height + std * float(rng.standard_normal()) if pieces else height
        if abs(before - height) < 1e-9:
            # What joins without a riser still does.
            y = pieces[-1][2] + math.tan(pieces[-1][3]) * (x - pieces[-1][0])
        before = height + math.tan(slope) * (end - start)
        pieces.append((x, x_end, y, slope))
    boxes, pits = list[Box](), list[Pit]()
    for begin, end, height in course.boxes:
        one, other = sorted((np.array([begin, end]) + std * rng.standard_normal(2)).tolist())
        boxes.append((one, max(other, one + 0.005), max(height + std * float(rng.standard_normal()), 0.01)))
    for pit in course.pits:
        one, other = sorted((np.array(pit) + std * rng.standard_normal(2)).tolist())
        pits.append((one, other))
    return replace(course, pieces=tuple(pieces), boxes=tuple(boxes), pits=tuple(pits))


def blocked_course(seed: int) -> Course:
    """A course that nobody walks: its last feature is too long, too high or too deep for any step."""
    rng, open_way = np.random.default_rng([17, seed]), random_course(seed, length=2.2, ramp=False)
    made = _Ground(open_way.goal - BEHIND / 2.0)
    last = open_way.pieces[-1]
    made.height, made.begun = last[2], last[0]
    kind = ("pit", "up", "down", "box")[seed % 4]
    if kind == "pit":
        width = float(rng.uniform(0.9, 1.3))
        made.pits.append((made.x, made.x + width))
        made.x += width
    elif kind == "box":
        made.boxes.append((made.x, made.x + 0.1, float(rng.uniform(0.8, 1.1))))
        made.x += 0.1
    else:
        made.rise(float(rng.uniform(0.9, 1.2)) * (1.0 if kind == "up" else -1.0))
    made.x += BEHIND
    made.close(made.x)
    pieces, boxes, pits = (*open_way.pieces[:-1], *made.pieces), (*open_way.boxes, *made.boxes), made.pits
    return Course(f"blocked {seed}", pieces, boxes, (*open_way.pits, *pits), made.x - 0.15)
