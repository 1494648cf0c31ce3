"""Steps on level ground: one over obstacles, any sequence of them, and strides past pits; each checked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InfeasibleGaitError
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.procedures.task import StepSolution
from ggo_factors.procedures.walker import MOST_STEPS, walker_of
from ggo_factors.support.inputs import as_count, as_number, as_tuple_of
from ggo_factors.walking.walk import Step, Walk

SPARE = 0.01
"""How far from a pit's edges a foothold is put, in [m]."""
FINENESS = 0.005
"""How finely half strides are tried, in [m]."""


def step_over(
    base: Gait,
    obstacles: Sequence[Obstacle],
    *,
    foothold: tuple[float, float] | None = None,
    gaps: Sequence[Gap] = (),
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    gain: float | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
) -> StepSolution:
    """One step over obstacles (paper, section V-B), checked.

    Args:
        base: the base gait.
        obstacles: boxes to step over, in the body frame of this step.
        foothold: where the swing ankle must land in [m], shape (2,); where the base gait lands, on the ground, if None.
        gaps: pits with no foothold in them.
        model: the legs; the base gait's own if None.
        start: frame that the walker is in, shape (4,) in [rad], for example `STANDING`; the base gait's first if None.
        start_rate: how fast its joints move there, shape (4,) in [rad/s]; if None, as the base gait does where no
            `start` is given, else not at all.
        gain: omega of the end edge; 10 m if None, 5 m without smoothness, raised where that leaves the foothold by more
            than the tolerance.
        smoothness: gain of the second-order edges, see `GaitGraph`; by default what keeps the joints' accelerations
            near the base gait's, 0 for the paper's graph.
        hard: whether foothold, knees, clearance and joint limits are met to 1e-6, as constraints.
        limits: angles, speeds and accelerations that the joints must keep to; not looked at if None.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check, with the numbers and the nearest foothold that works.
    """
    walker = walker_of(base, model, start, start_rate, gain, smoothness, hard, limits)
    if foothold is None:
        foothold = (float(walker.base.endpoints(walker.model)[-1, 0]), 0.0)
    boxes, pits = as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap)
    return walker.walked([Step(foothold, boxes, pits)])[0]


def walk(
    base: Gait,
    steps: Sequence[Step],
    *,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    gain: float | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
) -> Walk:
    """Any sequence of steps, the legs' roles swapped between them, each anchored where the last one ended.

    Args:
        base: the base gait, which every step bends.
        steps: what each step must do.
        model: as for `step_over`.
        start: as for `step_over`.
        start_rate: as for `step_over`. Each later step goes on as fast as the one before ended.
        gain: as for `step_over`.
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step, with its number, the numbers, and the nearest
            foothold that works.
    """
    walker = walker_of(base, model, start, start_rate, gain, smoothness, hard, limits)
    return walker.walk(as_tuple_of(steps, "steps", Step))


def adjust_stride(
    base: Gait,
    stride: float | None = None,
    *,
    gaps: Sequence[Gap] = (),
    steps: int = 2,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    gain: float | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
) -> Walk:
    """Steps of another stride (paper, section V-A); a pit is stepped over by a longer one.

    Args:
        base: the base gait.
        stride: distance that the swing ankle travels in a full step in [m]; if None, that of the base gait, or the
            nearest to it whose footholds keep out of the gaps.
        gaps: pits with no foothold in them, in the body frame of the first step.
        steps: number of steps.
        model: as for `step_over`.
        start: as for `step_over`.
        start_rate: as for `step_over`.
        gain: as for `step_over`.
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where a foothold lies in a gap, or no gait passes the check.
    """
    walker = walker_of(base, model, start, start_rate, gain, smoothness, hard, limits)
    legs, count = walker.model, as_count(steps, "steps", 1, MOST_STEPS)
    pits = as_tuple_of(gaps, "gaps", Gap)
    if stride is None:
        half = _half_stride_past(base.stride(legs) / 2.0, [pit.for_ankle(legs.foot) for pit in pits], count, legs)
    else:
        half = as_number(stride, "stride", above=0.0, unit="m") / 2.0
    return walker.walk(Step((half, 0.0), gaps=tuple(pit.shifted(half * k) for pit in pits)) for k in range(count))


def _half_stride_past(half: float, pits: Sequence[Gap], count: int, model: LegModel) -> float:
    """The half stride nearest to `half` whose footholds all keep clear of the pits, longer ones first on a tie."""
    every = np.arange(1, count + 1)
    shifts = np.arange(0.0, 2.0 * model.reach, FINENESS)
    for candidate in np.stack([half + shifts, half - shifts], -1).ravel():
        places = candidate * every
        if candidate > 0.0 and not any(
            ((pit.x_start - SPARE < places) & (places < pit.x_end + SPARE)).any() for pit in pits
        ):
            return float(candidate)
    raise InfeasibleGaitError(f"no stride within the legs' reach of {model.reach:g} m keeps out of the gaps")
