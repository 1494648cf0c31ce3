"""Stairs up and down, foot over foot; each step checked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.motion.terrain import Obstacle, stair_ground
from ggo_factors.procedures.steps import MOST_STEPS, walker_of
from ggo_factors.support.inputs import Array, as_array, as_count, as_number
from ggo_factors.walking.step import Step
from ggo_factors.walking.walk import Walk

UPRIGHT = math.pi / 2.0
"""Angle of an upright shank to the ground in [rad], which the paper's stairs ask for at landing."""
EDGE_HALF_WIDTH = 0.01
"""Half the width in [m] of the box that stands for the edge of a stair (paper, section V-C: [0.28, 0.30] for 0.29)."""


def climb_stairs(
    base: Gait,
    riser: float | Sequence[float] = 0.10,
    *,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    gain: float | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
) -> Walk:
    """Stairs up, foot over foot, the shank upright at landing (paper, section V-C).

    Args:
        base: the base gait.
        riser: height of the risers in [m], above 0; a number, or one for each step.
        tread: depth of the treads and distance of the footholds in [m].
        first_edge: x of the first riser in the body frame of the first step in [m], between 0 and `tread`.
        steps: number of steps; 2, or as many as there are risers, if None.
        model: as for `step_over`.
        start: as for `step_over`.
        start_rate: as for `step_over`.
        gain: as for `step_over`.
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.
        landing: as for `step_over`.
        pace: as for `step_over`.
        deadline: as for `step_over`.
        balance: as for `step_over`.
        style: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step.
    """
    walker = walker_of(
        base, model, start, start_rate, gain, smoothness, hard, limits, landing, pace, deadline, balance, style
    )
    return walker.walk(_flight(1.0, riser, tread, first_edge, steps))


def descend_stairs(
    base: Gait,
    riser: float | Sequence[float] = 0.10,
    *,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    gain: float | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
) -> Walk:
    """Stairs down, foot over foot; arguments and errors as for `climb_stairs`."""
    walker = walker_of(
        base, model, start, start_rate, gain, smoothness, hard, limits, landing, pace, deadline, balance, style
    )
    return walker.walk(_flight(-1.0, riser, tread, first_edge, steps))


def _flight(
    direction: float, riser: float | Sequence[float], tread: float, first_edge: float, steps: int | None
) -> Iterator[Step]:
    """The steps of a flight of stairs, direction 1 up, -1 down."""
    depth = as_number(tread, "tread", above=0.0, unit="m")
    edge = as_number(first_edge, "first_edge", above=0.0, unit="m")
    if not edge < depth:
        raise InputError(f"first_edge: {edge:g} m must be below the tread {depth:g} m, where the first foothold is")
    rises = direction * _risers(riser, steps)
    ground = stair_ground(edge, depth, rises.tolist())
    for k, rise in enumerate(rises):
        here = ground.shifted(depth * k, float(rises[:k].sum()))
        ahead = Obstacle(edge - EDGE_HALF_WIDTH, edge + EDGE_HALF_WIDTH, max(float(rise), 0.0))
        yield Step((depth, float(rise)), (ahead,), shank_angle=UPRIGHT, ground=here)


def _risers(riser: float | Sequence[float], steps: int | None) -> Array:
    if np.ndim(riser) == 0:
        count = as_count(2 if steps is None else steps, "steps", 1, MOST_STEPS)
        return np.full(count, as_number(riser, "riser", above=0.0, unit="m"))
    rises = as_array(riser, "riser", (None,))
    for rise in rises:
        as_number(rise, "riser", above=0.0, unit="m")
    if len(rises) == 0 or (steps is not None and as_count(steps, "steps", 1) != len(rises)):
        raise InputError(f"riser: {len(rises)} risers for {steps if steps is not None else 'at least 1'} steps")
    return rises
