"""What the page's animation shows: where the joints are at each instant, over which ground, how far over obstacles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ggo_factors.check.uncertainty import HIT_PROBABILITY, all_cautious
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Ground, Obstacle
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import Step

INSTANTS = 100
"""A step is shown at so many instants at least: 5 ms apart in a step of 0.5 s, so that a thin box is seen passed."""
MARGIN = 1.0
"""The ground is drawn so far behind the first foot and past the last one, in [m]."""
PIT = 0.06
"""Gaps are drawn so deep, in [m]: how deep they are is not known."""


@dataclass(frozen=True, eq=False)
class ShownStep:
    """One step of what is shown.

    Attributes:
        gait: its motion.
        step: what it had to do; None where nobody said: level ground, or as low as it lands.
        origin: its supporting ankle, as seen from that of the first step, in [m].
        begins: time at which it begins in [s].
        swings: the leg that swings, ``"right"`` or ``"left"``.
    """

    gait: Gait
    step: Step | None
    origin: tuple[float, float]
    begins: float
    swings: str

    @property
    def ground(self) -> Ground:
        """The ground under it, in its own body frame."""
        return Ground() if self.step is None else self.step.ground

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """What it steps over, in its own body frame."""
        return () if self.step is None else self.step.obstacles

    def sole(self, model: LegModel) -> float:
        """How far the ground lies under an ankle that stands, in [m]: soles lie along a ramp."""
        return self.ground.ankle_over(model.foot)

    @property
    def by_leg(self) -> Array:
        """Left hip, left knee, right hip and right knee of each frame in [rad], shape (m, 4)."""
        return self.gait.frames if self.swings == "right" else swap_roles(self.gait.frames)


def motion_numbers(steps: Sequence[ShownStep], model: LegModel) -> dict[str, Any]:
    """Every instant of the animation, in the body frame of the first step: a column for each thing.

    Joints are linear between frames, as the check plays them. Lengths in [m], clearance in [mm] and None where the
    swinging foot is not over an obstacle, tilt of the left and the right sole in [rad], which turn on ramps.
    """
    times, numbers, joints, clearances = list[float](), list[int](), list[list[float]](), list[float | None]()
    tilts = list[list[float]]()
    for number, shown in enumerate(steps, start=1):
        frames, at = _instants(shown.gait)
        places = model.joints(frames)
        above, tilt = _clearance(places[:, 4], shown.obstacles, model), _tilts(shown, places[:, 4, 0])
        first = 0 if number == 1 else 1  # the frame in which the legs change roles is shown once
        for k in range(first, len(at)):
            times.append(round(shown.begins + float(at[k]), 6))
            numbers.append(number)
            joints.append(np.round(_legs(places[k] + shown.origin, shown.swings), 5).tolist())
            tilts.append(np.round(tilt[k], 4).tolist())
            clearances.append(None if math.isinf(above[k]) else round(float(above[k]) * 1e3, 1))
    return {"time_s": times, "step": numbers, "joints_m": joints, "tilt_rad": tilts, "clearance_mm": clearances}


def _instants(gait: Gait) -> tuple[Array, Array]:
    """Frames at the instants that are shown, shape (k, 4) in [rad], and the time of each in [s], shape (k,)."""
    between = math.ceil(INSTANTS / (len(gait) - 1))
    at = np.arange((len(gait) - 1) * between + 1) / between
    known = np.arange(len(gait))
    frames = np.stack([np.interp(at, known, column) for column in gait.frames.T], -1)
    return frames, np.interp(at, known, gait.times)


def _legs(joints: Array, swings: str) -> Array:
    """Left ankle, left knee, hip, right knee and right ankle, of joints from the supporting to the swinging ankle."""
    places = joints if swings == "right" else joints[::-1]
    return np.asarray(places.ravel())


def _tilts(shown: ShownStep, x: Array) -> Array:
    """Tilt of the left and the right sole in [rad], shape (k, 2), of the swing ankle at x in [m], shape (k,).

    The swinging one turns evenly from the slope that it leaves to the one it lands on, as the check has it.
    """
    ground = shown.ground
    swinging = ground.sole_tilt(x, float(x[0]), float(x[-1]))
    standing = np.full(len(x), ground.slope_at(0.0))
    return np.stack([standing, swinging] if shown.swings == "right" else [swinging, standing], -1)


def _clearance(path: Array, obstacles: Sequence[Obstacle], model: LegModel) -> Array:
    """Height of the swing ankle over what it must clear there in [m], shape (k,); infinite beside all obstacles."""
    above = np.full(len(path), math.inf)
    for obstacle in obstacles:
        box = obstacle.for_ankle(model.foot)
        over = (path[:, 0] >= box.x_start) & (path[:, 0] <= box.x_end)
        above[over] = np.minimum(above[over], path[over, 1] - box.height)
    return above


def scene_numbers(steps: Sequence[ShownStep], model: LegModel) -> dict[str, Any]:
    """What the legs walk on and over, in [m] in the body frame of the first step; heights are of what soles touch."""
    boxes, pits, footholds = list[dict[str, Any]](), list[dict[str, Any]](), list[list[float]]()
    known = set[tuple[float, float]]()
    for number, shown in enumerate(steps, start=1):
        (x, y), sole = shown.origin, shown.sole(model)
        larger = all_cautious(shown.obstacles, HIT_PROBABILITY)
        for box, wide in zip(shown.obstacles, larger, strict=True):
            # A box that several steps see is drawn once, as the first one saw it.
            if _is_new(known, x + box.x_start, x + box.x_end) and not shown.ground.is_edge(box):
                low = y - sole + min(box.base, float(shown.ground.height_at([box.x_start, box.x_end]).min()))
                made = _block(x + box.x_start, x + box.x_end, low, y + box.height - sole, number)
                if box.is_uncertain:
                    made["cautious"] = _block(x + wide.x_start, x + wide.x_end, low, y + wide.height - sole, number)
                boxes.append(made)
        for pit in () if shown.step is None else shown.step.gaps:
            if _is_new(known, x + pit.x_start, x + pit.x_end):
                level = y + float(shown.ground.height_at((pit.x_start + pit.x_end) / 2.0)) - sole
                block = _block(x + pit.x_start, x + pit.x_end, level - PIT, level, number)
                pits.append({**block, "unknown": pit.unknown})
        if shown.step is not None:
            lands, _ = shown.step.landing(model)
            footholds.append(_rounded([x + lands, y - sole + float(shown.ground.height_at(lands))]))
    return {"ground": _ground_line(steps, model), "boxes": boxes, "pits": pits, "footholds": footholds}


def _is_new(known: set[tuple[float, float]], start: float, end: float) -> bool:
    span = (round(start, 4), round(end, 4))
    if span in known:
        return False
    known.add(span)
    return True


def _block(x_start: float, x_end: float, low: float, top: float, step: int) -> dict[str, Any]:
    numbers = dict(zip(("x_start", "x_end", "low", "top"), _rounded([x_start, x_end, low, top]), strict=True))
    return {"step": step, **numbers}


def _rounded(values: Sequence[float] | Array) -> list[float]:
    return [round(float(value), 5) for value in values]


def _ground_line(steps: Sequence[ShownStep], model: LegModel) -> list[list[float]]:
    """The top of the ground from behind the first foot to past the last one, points (n, 2) in [m]."""
    ends = [shown.gait.endpoints(model)[[0, -1], 0] + shown.origin[0] for shown in steps]
    first, last = min(0.0, float(np.min(ends))) - MARGIN, float(np.max(ends)) + MARGIN
    borders = [first, *(shown.origin[0] for shown in steps[1:]), last]
    line = list[list[float]]()
    for shown, (low, high) in zip(steps, pairwise(borders), strict=True):
        x, y = shown.origin
        if low < high:
            points = shown.ground.line(low - x, high - x) + np.array([x, y - shown.sole(model)])
            line += [_rounded(point) for point in points]
    return line
