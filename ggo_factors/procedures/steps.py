"""Checked steps: one over obstacles, any sequence of them, strides past pits; and where their walker begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import gtsam
import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.motion.base_gaits import BaseGaits, as_leg, both
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.motion.world import Terrain
from ggo_factors.procedures.gains import END_GAIN, INSIDE, LANDING_END_GAIN, SMOOTH_END_GAIN, Gains
from ggo_factors.procedures.next_step import SPARE, with_next_step
from ggo_factors.procedures.task import MOST_MOTIONS, Settings, StepSolution
from ggo_factors.procedures.walker import Walker, balanced_hold, by
from ggo_factors.support.inputs import (
    as_angles,
    as_array,
    as_bool,
    as_count,
    as_instance,
    as_number,
    as_tuple_of,
)
from ggo_factors.walking.on_terrain import steps_on
from ggo_factors.walking.step import Step, stands_in
from ggo_factors.walking.walk import Walk

MOST_STEPS = 1000
"""A walk of more steps is refused as a mistake."""
FASTEST = 50.0
"""No joint of a walker moves faster, in [rad/s]."""
SMOOTHING = 0.2
"""Share of a step's duration over which its offset from the base gait bends: the smoothness is the square of so many
frames, 100 for 51 of them."""
FINENESS = 0.005
"""How finely half strides are tried, in [m]."""


def step_over(
    base: Gait | BaseGaits,
    obstacles: Sequence[Obstacle],
    *,
    foothold: ArrayLike | None = None,
    gaps: Sequence[Gap] = (),
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
    first_swing: str = "right",
    factors: Sequence[gtsam.NoiseModelFactor] = (),
) -> StepSolution:
    """One step over obstacles (paper, section V-B), checked; and whether the other foot gets over them next.

    `StepSolution.next_step` is the step after; where there is none, `Report.notes` says why.

    Args:
        base: the base gait; or base gaits for each leg, and for stairs, of which each step bends the one that fits.
        obstacles: boxes to step over, in the body frame of this step.
        foothold: where the swing ankle must land in [m], shape (2,); where the base gait lands, on the ground, if None.
        gaps: pits with no foothold in them.
        model: the legs; the base gait's own if None.
        start: frame that the walker is in, shape (4,) in [rad], for example `STANDING`; the base gait's first if None.
        start_rate: speed of its joints there, shape (4,) in [rad/s]; if None, 0 where the walker stands, that is where
            both legs have the same angles, else that of the base gait in its first frame.
        gain: omega of the end edge; if None 20 m for m frames, 10 m without landing edges, 5 m without smoothness too,
            raised where the foothold is missed by more than the tolerance.
        smoothness: gain of the second-order edges, see `GaitGraph`; by default what keeps the joints' accelerations
            near the base gait's, 0 for the paper's graph.
        hard: whether foothold, knees, clearance and joint limits are met to 1e-6, as constraints.
        limits: angles, speeds and accelerations that the joints must keep to; none if None.
        landing: whether landing edges hold the end of the step to the base gait's own posture and motion, as far as
            the foothold lets it. If None they do, but not with `smoothness=0`, which is the paper's graph, nor where a
            gait is found only without them, which `Report.notes` then says.
        pace: how fast the path is walked, as a share of the base gait's pace, above 0 to 1, or ``"auto"``: no slower
            than the limits, and a landing speed of 1 m/s or 1.2 times the base gait's, want it. If None ``"auto"``
            within limits, else 1.
        deadline: seconds that the whole call may take: the best gait found by then that passes the check, or a refusal.
            If None there is none, and no step is searched for longer than about a quarter of a second.
        balance: gain in [1/m^2] of balance edges, which hold the ground's push (ZMP) to where it acts in the base gait,
            frame by frame; of a step of 50 motions, alike at any sampling rate. 2 is recommended; none if None or 0.
            `Report.zmp_off` then tells how far it is off. Where that would be more than `Tolerances.balance`, as on the
            later steps down stairs, the step is made without them, and `Report.notes` says so.
        style: how a person varies steps, see `learn_style` and `load_style`: steps are then bent as that person would
            rather than alike in all joints. Where it does not help (`Style.why_not`), or a gait is found only without
            it, steps are made without, and `Report.notes` says so.
        first_swing: the leg that swings, ``"right"`` or ``"left"``; in a walk that of its first step.
        factors: GTSAM factors of your own on frames of the step, see `Step`; in a walk on frames of every step.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check, with the numbers and the nearest foothold that works.
    """
    walker = walker_of(
        base,
        model,
        start,
        start_rate,
        gain,
        smoothness,
        hard,
        limits,
        landing,
        pace,
        deadline,
        balance,
        first_swing,
        style,
    )
    if foothold is None:
        foothold = (float(walker.base.endpoints(walker.model)[-1, 0]), 0.0)
    boxes, pits = as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap)
    step = Step(foothold, boxes, pits, factors=as_tuple_of(factors, "factors", gtsam.NoiseModelFactor))
    if not walker.settings.slows:
        return with_next_step(walker, walker.walked([step])[0])
    (made,) = walker.walk([step]).steps
    assert isinstance(made, StepSolution)  # a walk that was just made keeps how
    return with_next_step(walker, made)


def walk(
    base: Gait | BaseGaits,
    steps: Sequence[Step] | Sequence[float],
    *,
    terrain: Terrain | None = None,
    at: float = 0.0,
    to_standing: bool = False,
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
    first_swing: str = "right",
    factors: Sequence[gtsam.NoiseModelFactor] = (),
) -> Walk:
    """Any sequence of steps, the legs' roles swapped between them, each anchored where the last one ended.

    Args:
        base: as for `step_over`.
        steps: what each step must do; on a terrain x of each landing in the world frame in [m].
        terrain: the ground along the way, in the world frame: each step meets what of it lies on its way.
        at: x of the supporting ankle at the start in the world frame in [m].
        to_standing: on a terrain: close with one more step, the feet beside each other, at rest.
        model: as for `step_over`.
        start: as for `step_over`.
        start_rate: as for `step_over`. Each later step goes on as fast as the one before ended.
        gain: as for `step_over`.
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.
        landing: as for `step_over`.
        pace: as for `step_over`.
        deadline: as for `step_over`.
        balance: as for `step_over`.
        style: as for `step_over`.
        first_swing: as for `step_over`.
        factors: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step, with its number, the numbers, and the nearest
            foothold that works.
    """
    walker = walker_of(
        base,
        model,
        start,
        start_rate,
        gain,
        smoothness,
        hard,
        limits,
        landing,
        pace,
        deadline,
        balance,
        first_swing,
        style,
    )
    if terrain is None:
        if at != 0.0 or to_standing:
            raise InputError("at and to_standing: are for a walk on a terrain; a Step has its own frame and end_frame")
        return walker.walk(with_factors(as_tuple_of(steps, "steps", Step), factors))
    places = as_array(steps, "steps", (None,)).tolist()  # type: ignore[arg-type]
    closing = places[-1:] if as_bool(to_standing, "to_standing") else []
    legs, frame = walker.model, walker.frame
    planned = steps_on(terrain, [*places, *closing], model=legs, start=frame, at=at, to_standing=to_standing)
    return walker.walk(with_factors(planned, factors))


def adjust_stride(
    base: Gait | BaseGaits,
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
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
    first_swing: str = "right",
    factors: Sequence[gtsam.NoiseModelFactor] = (),
) -> Walk:
    """Steps of another stride (paper, section V-A); a pit is stepped over by a longer one.

    Args:
        base: as for `step_over`.
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
        landing: as for `step_over`.
        pace: as for `step_over`.
        deadline: as for `step_over`.
        balance: as for `step_over`.
        style: as for `step_over`.
        first_swing: as for `step_over`.
        factors: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where a foothold lies in a gap, or no gait passes the check.
    """
    walker = walker_of(
        base,
        model,
        start,
        start_rate,
        gain,
        smoothness,
        hard,
        limits,
        landing,
        pace,
        deadline,
        balance,
        first_swing,
        style,
    )
    legs, count = walker.model, as_count(steps, "steps", 1, MOST_STEPS)
    pits = as_tuple_of(gaps, "gaps", Gap)
    if stride is None:
        own = (walker.bases.left.stride(legs) + walker.bases.right.stride(legs)) / 2.0
        half = _half_stride_past(own / 2.0, [pit.for_ankle(legs.foot) for pit in pits], count, legs)
    else:
        half = as_number(stride, "stride", above=0.0, unit="m") / 2.0
    plan = [Step((half, 0.0), gaps=tuple(pit.shifted(half * k) for pit in pits)) for k in range(count)]
    return walker.walk(with_factors(plan, factors))


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


def with_factors(steps: Sequence[Step], factors: Sequence[gtsam.NoiseModelFactor]) -> list[Step]:
    """Steps with these factors besides their own.

    Raises:
        InputError: where one is no factor on frames.
    """
    own = as_tuple_of(factors, "factors", gtsam.NoiseModelFactor)
    return [replace(step, factors=(*step.factors, *own)) for step in steps] if own else list(steps)


def walker_of(
    base: Gait | BaseGaits,
    model: LegModel | None,
    start: ArrayLike | None,
    start_rate: ArrayLike | None,
    gain: float | None,
    smoothness: float | None,
    hard: bool,
    limits: JointLimits | None,
    landing: bool | None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    first_swing: str = "right",
    style: Style | None = None,
) -> Walker:
    """The walker of a procedure; arguments as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
    """
    leg = as_leg(first_swing, "first_swing")
    bases = both(base)
    legs = bases.legs(model)
    bases, slows = _at_pace(bases, "auto" if pace is None and limits is not None else pace)
    first = bases.gait("level", leg)
    motions = len(first) - 1
    bends = (SMOOTHING * motions) ** 2  # alike at any sampling rate
    smooth = bends if smoothness is None else as_number(smoothness, "smoothness", at_least=0.0)
    lands = smooth > 0.0 if landing is None else as_bool(landing, "landing")
    per_frame = LANDING_END_GAIN if lands else SMOOTH_END_GAIN if smooth else END_GAIN
    end = per_frame * (min(motions, MOST_MOTIONS) + 1)
    if gain is not None:
        end = as_number(gain, "gain", above=0.0) * max(1.0, motions / MOST_MOTIONS)
    balanced = 0.0 if balance is None else as_number(balance, "balance", at_least=0.0)
    hold = balanced_hold(motions) if balanced else Gains.hold
    settings = Settings(
        gains=Gains(end, hold=hold, inside=INSIDE if motions > MOST_MOTIONS else 0.0),
        gain_given=gain is not None,
        smoothness=smooth,
        hard=as_bool(hard, "hard"),
        limits=None if limits is None else as_instance(limits, "limits", JointLimits),
        landing=lands,
        landing_forced=landing is True,
        slows=slows,
        smoothness_given=smoothness is not None,
        balance=balanced,
        style=None if style is None else as_instance(style, "style", Style),
    )
    if deadline is not None:
        settings = by(settings, deadline)
    frame = first.frames[0] if start is None else as_angles(start, "start", (4,))
    motion = first.frames[1] - first.frames[0]
    if start_rate is None:
        # A walker with both legs alike stands still; any other is in the middle of a walk.
        stands = start is not None and stands_in(frame)
        offset = -motion if stands else np.zeros(4)
        return Walker(bases, legs, frame, offset, settings, placed=start is not None, swing=leg)
    rate = as_array(start_rate, "start_rate", (4,))
    if not np.abs(rate).max() <= FASTEST:
        raise InputError(f"start_rate: {np.abs(rate).max():g} rad/s is above {FASTEST:g} rad/s")
    if stands_in(frame) and rate.any():
        raise InputError("start_rate: a walker whose legs are alike stands, and does not move; leave it out")
    if not settings.smoothness:
        raise InputError("start_rate: without smoothness nothing keeps the rate; leave one of the two out")
    placed = start is not None
    return Walker(bases, legs, frame, rate * first.dt - motion, settings, moves=True, placed=placed, swing=leg)


def _at_pace(bases: BaseGaits, pace: float | str | None) -> tuple[BaseGaits, bool]:
    """Base gaits at a fixed pace, their frames evenly apart, and whether steps are slowed where they need it."""
    if pace is None or pace == "auto":
        return bases, pace == "auto"
    if isinstance(pace, str):
        raise InputError(f"pace: {pace!r} is neither a number nor 'auto'")
    share = as_number(pace, "pace", above=0.0, at_most=1.0)
    return (bases if share == 1.0 else bases.changed(lambda gait: replace(gait, dt=gait.dt / share))), False
