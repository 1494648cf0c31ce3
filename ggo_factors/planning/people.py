"""Where people put their feet beside an obstacle, and how high they lift them over it.

Obstacle crossing of healthy adults (Scientific Reports 12, 2022, s41598-022-06631-8, table 1): of the step that brings
the leading foot over, 55 to 62 % lie before the obstacle; the leading toe passes 150 to 185 mm above it, the trailing
one 130 to 150 mm. The middle of each range stands here for its mean, half its width for the standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, cast, get_args

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.motion.world import Terrain
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import Step

Prefer = Literal["least_change", "people"]

SHARE_MEAN, SHARE_STD = 0.585, 0.035
"""Share of the step over an obstacle that lies before it."""
LEADING_MEAN, LEADING_STD = 0.1675, 0.0175
"""Height of the leading toe over an obstacle in [m]."""
TRAILING_MEAN, TRAILING_STD = 0.140, 0.010
"""Height of the trailing toe over it in [m]."""
LOW = 0.5
"""Feet are lifted so many standard deviations less than people lift them on average: each costs 5 to 8 % of a step."""
GIVES_WAY = 0.024
"""A foot passes about so much lower in [m] than soft edges draw it to: over 14 boxes, 0.05 to 0.17 m, alone on the way.
A step whose foot passes at another height than it should is made again, drawn to less or more."""
WEIGHT = 0.04
"""What one standard deviation of the share costs, times 1/2, in [rad^2]. Of 35 boxes on 30 courses with something every
0.2 to 0.5 m 32 are then met within 0.50 to 0.65 of the step, 18 with 0.006; plans cost 7 % more in the median."""
LOWEST = 0.02
"""People step over what is higher than this in [m] in this way."""


@dataclass(frozen=True, eq=False)
class PeoplePreference:
    """What people prefer, as costs of steps.

    Attributes:
        boxes: near and far edge of each box that people lift their feet over in [m], shape (k, 2), in the world frame.
    """

    boxes: Array

    @classmethod
    def if_preferred(cls, prefer: Prefer, terrain: Terrain) -> PeoplePreference | None:
        """The preference on a terrain, where it is preferred."""
        return cls.on(terrain) if prefer == "people" else None

    @classmethod
    def on(cls, terrain: Terrain) -> PeoplePreference:
        """The preference on a terrain."""
        boxes = [(box.x_start, box.x_end) for box in terrain.boxes if _is_stepped_over(box, box.height)]
        return cls(np.array(boxes).reshape(-1, 2))

    def __call__(self, behind: Array, stands: Array, lands: Array) -> Array:
        """Cost of each step, shape (n,) in [rad^2], of its three places in [m], shape (n,) each."""
        costs = np.zeros(len(stands))
        for begins, ends in self.boxes.tolist():
            leads = (behind <= begins) & (stands <= begins) & (lands >= ends)
            share = (begins - stands) / np.maximum(lands - stands, 1e-6)
            costs += np.where(leads, 0.5 * WEIGHT * ((share - SHARE_MEAN) / SHARE_STD) ** 2, 0.0)
        return costs


@dataclass(frozen=True)
class Height:
    """How high a foot is to pass over the boxes in its way.

    Attributes:
        wanted: least height over them in [m].
        lift: what soft edges draw the foot to so that it passes about there, in [m].
    """

    wanted: float
    lift: float


def _is_stepped_over(box: Obstacle, height: float) -> bool:
    return height > LOWEST and not box.is_edge


def boxes_in(step: Step) -> tuple[Obstacle, ...]:
    """The boxes about a step that people lift their feet over, in the body frame."""
    return tuple(box for box in step.obstacles if _is_stepped_over(box, box.height - box.base))


def height_over(step: Step, begins: float) -> Height | None:
    """How high people lift the foot of a step; None where it has no box in its way.

    A box ahead of the supporting foot is stepped over by the leading foot, one behind it by the trailing foot.

    Args:
        step: the step, in the body frame.
        begins: where the foot leaves the ground there, x in [m].
    """
    if step.foothold is None:
        return None
    ends = step.foothold[0]
    high = boxes_in(step)
    if not any(begins < box.x_end and box.x_start < ends for box in high):
        return None
    if any(box.x_start > 0.0 and box.x_end < ends for box in high):
        wanted = LEADING_MEAN - LOW * LEADING_STD
        return Height(wanted, wanted + GIVES_WAY)
    wanted = TRAILING_MEAN - LOW * TRAILING_STD
    return Height(wanted, wanted)


def preferred(prefer: Any) -> Prefer:
    """What is preferred.

    Raises:
        InputError: where there is no such preference.
    """
    if prefer not in get_args(Prefer):
        raise InputError(f"prefer: {prefer!r:.40} is neither 'least_change' nor 'people'")
    return cast(Prefer, prefer)
