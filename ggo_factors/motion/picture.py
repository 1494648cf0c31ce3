"""Steps on their ground as a small picture: legs, soles, path of the swing ankle, boxes, pits, footholds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ggo_factors.motion.leg_model import Foot
from ggo_factors.motion.terrain import LEVEL, Gap, Ground, Obstacle
from ggo_factors.notebook.svg import BASE, GROUND, INK, LEFT, OBSTACLE, PATH, RIGHT, SUPPORT, SWING, Shape, Text, svg
from ggo_factors.support.inputs import Array

MOST_FIGURES, EACH_FIGURES = 60, 7
"""Most figures of the legs in a picture, and of one step: what can be told apart, and keeps it below 20 kB."""
PATH_POINTS = 600
"""About how many points the paths of the swing ankle have in a picture."""
CURVE_POINTS = 60
"""Most points of a curve of angles: one each three pixels."""
AROUND, DEPTH = 0.08, 0.06
"""How far the ground goes on beyond the legs, and how deep it and its pits are drawn, in [m]."""
WALL = 2.0
"""A box of a terrain is drawn to so far above the highest ground in [m], higher than any leg: a wall 100 m high would
leave a picture of 10 pixels."""

STEP_LEGEND = {"support leg": SUPPORT, "swing leg": SWING, "swing ankle": PATH}
WALK_LEGEND = {"right leg": RIGHT, "left leg": LEFT, "swing ankle": PATH}


@dataclass(frozen=True, eq=False)
class Place:
    """A step, and where it is.

    Attributes:
        joints: what `LegModel.joints` gives of each frame in [m], shape (m, 5, 2).
        foot: the feet.
        origin: where its supporting ankle is in the picture in [m], shape (2,).
        obstacles: boxes in its body frame.
        gaps: pits in its body frame.
        ground: height of the ground.
        foothold: where the swing ankle was to land in [m], shape (2,); or None.
        swings: the leg that swings, ``"right"`` or ``"left"``; "" where it is not said.
    """

    joints: Array
    foot: Foot
    origin: Array
    obstacles: Sequence[Obstacle] = ()
    gaps: Sequence[Gap] = ()
    ground: Ground = LEVEL
    foothold: tuple[float, float] | None = None
    swings: str = ""

    @property
    def sole(self) -> Array:
        """Where the ground under the supporting foot is, in the picture, shape (2,)."""
        return np.asarray(self.origin - np.array([0.0, self.foot.ankle_height]))

    def legs(self, frame: int) -> tuple[Array, Array]:
        """Supporting and swinging leg in the picture in a frame, from the hip down, the sole last, (n, 2) each."""
        joints, foot = self.joints[frame] + self.origin, self.foot
        sole = np.array([[-foot.heel, -foot.ankle_height], [foot.toe, -foot.ankle_height], [0.0, 0.0]])
        rows = [joints[[2, 1, 0]], joints[[2, 3, 4]]]
        if foot.heel + foot.toe > 0.0:
            rows = [np.concatenate([row, row[-1] + sole]) for row in rows]
        return rows[0], rows[1]

    @property
    def colours(self) -> tuple[str, str]:
        """Colours of supporting and swinging leg; a leg keeps its own over a walk."""
        return (RIGHT, LEFT) if self.swings == "left" else (SUPPORT, SWING)


def steps_picture(places: Sequence[Place], label: str, base: Array | None = None) -> str:
    """An SVG element of steps on end.

    Args:
        places: the steps, at least one.
        label: what it shows, for those who do not see it.
        base: path of the base gait's swing ankle in the first step in [m], shape (m, 2), dashed.
    """
    shapes = ground_shapes(places)
    each = min(EACH_FIGURES, max(2, MOST_FIGURES // len(places)))
    drawn = set(np.linspace(0, len(places) - 1, min(len(places), MOST_FIGURES // 2)).astype(int).tolist())
    for number, place in enumerate(places):
        if number in drawn:
            shapes += _figures(place, each, first=number == 0)
    for number, place in enumerate(places):
        if base is not None and number == 0:
            shapes.append(Shape(base + place.origin, BASE, 1.2, dashed=True))
        some = np.linspace(0, len(place.joints) - 1, min(len(place.joints), max(5, PATH_POINTS // len(places))))
        shapes.append(Shape(place.joints[np.rint(some).astype(int), 4] + place.origin, PATH, 2.0))
    return svg(shapes, label)


def _figures(place: Place, count: int, first: bool) -> list[Shape]:
    shapes = []
    frames = np.unique(np.rint(np.linspace(0, len(place.joints) - 1, count)).astype(int)).tolist()
    for frame, opacity in zip(frames, np.linspace(0.3, 1.0, len(frames)).tolist(), strict=True):
        if frame or first:  # the step before has drawn the frame in which the legs change roles
            for points, colour in zip(place.legs(frame), place.colours, strict=True):
                shapes.append(Shape(points, colour, 1.6, opacity))
    return shapes


def ground_shapes(places: Sequence[Place]) -> list[Shape]:
    """Ground, boxes, pits and footholds of steps on end; each box once, whichever steps meet it."""
    reach = np.concatenate([place.joints[:, :, 0].ravel() + place.origin[0] for place in places])
    borders = [reach.min() - AROUND, *(place.origin[0] for place in places[1:]), reach.max() + AROUND]
    lines = [_profile(place, *ends) for place, ends in zip(places, pairwise(borders), strict=True)]
    line = np.concatenate(lines)
    low = line[:, 1].min() - DEPTH
    ends = [[line[-1, 0], low], [line[0, 0], low]]
    boxes: dict[tuple[float, ...], Shape] = {}
    pits, marks = dict[tuple[float, ...], Shape](), list[Shape]()
    for place in places:
        for box in place.obstacles:
            corners = place.sole + np.array([[box.x_start, box.base], [box.x_end, box.height]])
            boxes.setdefault(_key(corners), Shape(_rectangle(corners), OBSTACLE, 0.0))
        for gap in place.gaps:
            corners = place.sole + np.array([[gap.x_start, -DEPTH], [gap.x_end, 0.0]])
            pits.setdefault(_key(corners), Shape(_rectangle(corners), "#FFFFFF", 0.0))
        if place.foothold is not None:
            cross = place.sole + place.foothold + np.array([[-1.0, -1], [1, 1], [0, 0], [-1, 1], [1, -1]]) * 0.012
            marks.append(Shape(cross, INK, 1.4))
    # Boxes first: those that stand for the edge of a stair lie in the ground.
    return [*boxes.values(), Shape(np.vstack([line, ends]), GROUND, 0.0), Shape(line, INK, 1.0), *pits.values(), *marks]


def terrain_picture(
    ground: Ground, low: float, high: float, boxes: Sequence[tuple[Obstacle, float]], pits: Sequence[Gap]
) -> str:
    """An SVG element of ground between two places in [m], its boxes, each with the height of its top in [m], its pits.

    Args:
        ground: height of the ground, in the frame of the picture.
        low: where the picture begins.
        high: where it ends.
        boxes: what stands on it.
        pits: where there is no foothold.
    """
    line = ground.line(low, high)
    bottom, most = line[:, 1].min() - DEPTH, line[:, 1].max() + WALL
    shapes = [
        Shape(_rectangle(np.array([[box.x_start, top - box.height], [box.x_end, min(top, most)]])), OBSTACLE, 0.0)
        for box, top in boxes
    ]
    shapes += [Shape(np.vstack([line, [[high, bottom], [low, bottom]]]), GROUND, 0.0), Shape(line, INK, 1.0)]
    for pit in pits:
        edge = float(ground.height_at(pit.x_start))
        corners = np.array([[pit.x_start, edge - DEPTH], [min(pit.x_end, high), edge]])
        shapes.append(Shape(_rectangle(corners), "#FFFFFF", 0.0))
    # Room above level ground, which would be a line otherwise.
    return svg(shapes, "the ground from the side", frame=np.array([[low, bottom], [high, line[:, 1].max() + DEPTH]]))


def _profile(place: Place, low: float, high: float) -> Array:
    """The line of the ground under a step between two places in the picture, shape (n, 2)."""
    return np.asarray(place.ground.line(*(np.array([low, high]) - place.sole[0]).tolist()) + place.sole)


def _rectangle(corners: Array) -> Array:
    (left, bottom), (right, top) = corners.tolist()
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])


def _key(corners: Array) -> tuple[float, ...]:
    """The same for two whose sides and tops are at the same place to the millimetre."""
    return tuple((np.rint(corners.ravel()[[0, 2, 3]] * 1e3) + 0.0).tolist())


def angles_picture(
    along: Array, curves: Sequence[tuple[str, str, Array, Array | None]], label: str, unit: str = "%"
) -> str:
    """An SVG element of joint angles in degrees over a step, a cycle or a walk.

    Args:
        along: how far it has gone, shape (m,).
        curves: of each its name, its colour, its angles in [rad], shape (m,), and their standard deviation or None.
        label: the angle.
        unit: unit of `along`.
    """
    shapes, lows, highs = [], [0.0], [0.0]
    some = np.unique(np.rint(np.linspace(0, len(along) - 1, CURVE_POINTS)).astype(int))
    along = along[some]
    for _, colour, angles, spread in curves:
        mean = np.degrees(angles[some])
        off = np.zeros_like(mean) if spread is None else np.degrees(spread[some])
        if spread is not None:
            band = [np.column_stack([along, mean - off]), np.column_stack([along, mean + off])[::-1]]
            shapes.append(Shape(np.concatenate(band), colour, 0.0, 0.25))
        shapes.append(Shape(np.column_stack([along, mean]), colour, 2.0))
        lows.append(float((mean - off).min()))
        highs.append(float((mean + off).max()))
    ends, low, high = along[[0, -1]], min(lows), max(highs)
    shapes.insert(0, Shape(np.column_stack([ends, [0.0, 0.0]]), INK, 0.7, 0.6))
    # Room for the words above and below the curves.
    room = 0.14 * (high - low)
    frame = np.array([[ends[0], low - room], [ends[1], high + room]])
    said = [Text(ends[0], y, f"{round(angle)}°") for y, angle in ((high + 0.3 * room, high), (low - room, low))]
    said.append(Text(ends[1], low - room, f"{ends[1]:.3g} {unit}", "end"))
    said.append(Text(float(ends.mean()), high + 0.3 * room, label, "middle"))
    return svg(shapes, label, texts=said, size=(210, 140), frame=frame)
