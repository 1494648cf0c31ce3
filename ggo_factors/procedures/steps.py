"""Checked steps: one over obstacles, any sequence of them, strides past pits; and the walker of all procedures."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.procedures.gains import BALANCED_HOLD, END_GAIN, INSIDE, LANDING_END_GAIN, SMOOTH_END_GAIN, Gains
from ggo_factors.procedures.search import checked_step
from ggo_factors.procedures.task import MOST_MOTIONS, Settings, StepSolution, StepTask
from ggo_factors.support.inputs import (
    Array,
    as_angles,
    as_array,
    as_bool,
    as_count,
    as_instance,
    as_number,
    as_tuple_of,
)
from ggo_factors.walking.pace import allowed_landing_speed
from ggo_factors.walking.step import Step, stands_in
from ggo_factors.walking.walk import Walk

MOST_STEPS = 1000
"""A walk of more steps is refused as a mistake."""
FASTEST = 50.0
"""No joint of a walker moves faster, in [rad/s]."""
SMOOTHING = 0.2
"""Share of a step's duration over which its offset from the base gait bends: the smoothness is the square of so many
frames, 100 for 51 of them."""
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
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
) -> StepSolution:
    """One step over obstacles (paper, section V-B), checked.

    Args:
        base: the base gait.
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

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check, with the numbers and the nearest foothold that works.
    """
    walker = walker_of(
        base, model, start, start_rate, gain, smoothness, hard, limits, landing, pace, deadline, balance, style
    )
    if foothold is None:
        foothold = (float(walker.base.endpoints(walker.model)[-1, 0]), 0.0)
    boxes, pits = as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap)
    step = Step(foothold, boxes, pits)
    if not walker.settings.slows:
        return walker.walked([step])[0]
    (made,) = walker.walk([step]).steps
    assert isinstance(made, StepSolution)  # a walk that was just made keeps how
    return made


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
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
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
        landing: as for `step_over`.
        pace: as for `step_over`.
        deadline: as for `step_over`.
        balance: as for `step_over`.
        style: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step, with its number, the numbers, and the nearest
            foothold that works.
    """
    walker = walker_of(
        base, model, start, start_rate, gain, smoothness, hard, limits, landing, pace, deadline, balance, style
    )
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
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
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
        landing: as for `step_over`.
        pace: as for `step_over`.
        deadline: as for `step_over`.
        balance: as for `step_over`.
        style: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where a foothold lies in a gap, or no gait passes the check.
    """
    walker = walker_of(
        base, model, start, start_rate, gain, smoothness, hard, limits, landing, pace, deadline, balance, style
    )
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


@dataclass(frozen=True, eq=False)
class Walker:
    """A walker between two steps: where, how fast, and how steps are made.

    Attributes:
        base: the base gait, which every step bends.
        model: the legs.
        frame: the frame that the walker is in, shape (4,) in [rad].
        velocity_offset: change of the offset from the base gait to the next frame, shape (4,) in [rad].
        settings: how steps are made.
        last_motion: motion into that frame, shape (4,) in [rad]; None where it is not known.
        moves: whether it is known how fast the walker moves now, which no pace can change.
    """

    base: Gait
    model: LegModel
    frame: Array
    velocity_offset: Array
    settings: Settings
    last_motion: Array | None = None
    moves: bool = False

    def walk(self, steps: Iterable[Step]) -> Walk:
        """A walk of these steps.

        Raises:
            InputError: where there is none.
            InfeasibleGaitError: where no gait passes the check for a step.
        """
        solutions = self.walked(steps)
        gaits, plan = (solution.gait for solution in solutions), (solution.task.step for solution in solutions)
        made = Walk(tuple(gaits), tuple(plan), tuple(solutions), self.settings.limits)
        if self.settings.slows:
            made = made.slowed(allowed_landing_speed(self.base, self.model), held=self.moves)
        # Without smoothness nothing carries a joint's speed on at a change of legs: `Walk.verify` tells where it jumps.
        for number, faults in enumerate(made.trajectory_faults(self.settings.limits), start=1):
            if faults and self.settings.smoothness:
                message = f"step {number}: its motion does not follow from the steps beside it: "
                raise InfeasibleGaitError(message + "; ".join(map(str, faults)), faults, None, number)
        return made

    def walked(self, steps: Iterable[Step], first: int = 1) -> list[StepSolution]:
        """The steps, numbered from `first`, each from where the one before ended; see `walk`."""
        walker, solutions, steps = self, list[StepSolution](), list(steps)
        off = np.zeros(2)  # where the supporting foot stands beyond where it was to stand
        before: Step | None = None
        for number, step in enumerate(steps, start=first):
            if before is not None:
                walker = walker.after(solutions[-1].gait, before)
            before = step
            seen = step.shifted(*off.tolist()) if off.any() else step
            task = StepTask(
                base=walker.base,
                step=seen,
                model=walker.model,
                walked=walker.frame[None],
                velocity_offset=walker.velocity_offset,
                last_motion=walker.last_motion,
                settings=walker.settings,
                name=f"step {number}",
                number=number,
                left=first + len(steps) - number,
            )
            solutions.append(checked_step(task))
            off = self.model.endpoint(solutions[-1].gait.frames[-1]) - seen.landing(self.model)
        if not solutions:
            raise InputError("steps: a walk needs at least one step")
        return solutions

    def after(self, gait: Gait, step: Step) -> Walker:
        """The walker after a step: the legs' roles swapped, moving on as the step ended."""
        frames = gait.frames
        offset = swap_roles(np.diff((frames - self.base.frames)[-2:], axis=0)[0])
        if step.end_frame is not None:
            offset = self.base.frames[0] - self.base.frames[1]  # at rest
        motion = swap_roles(frames[-1] - frames[-2])
        if gait.paced is not None:
            faster = gait.dt / float(gait.paced[-1] - gait.paced[-2])
            offset, motion = offset + (faster - 1.0) * motion, faster * motion
        return replace(self, frame=swap_roles(frames[-1]), velocity_offset=offset, last_motion=motion)


def walker_of(
    base: Gait,
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
    style: Style | None = None,
) -> Walker:
    """The walker of a procedure; arguments as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
    """
    legs = as_instance(base, "base", Gait).legs(model)
    base, slows = _at_pace(base, "auto" if pace is None and limits is not None else pace)
    motions = len(base) - 1
    bends = (SMOOTHING * motions) ** 2  # alike at any sampling rate
    smooth = bends if smoothness is None else as_number(smoothness, "smoothness", at_least=0.0)
    lands = smooth > 0.0 if landing is None else as_bool(landing, "landing")
    per_frame = LANDING_END_GAIN if lands else SMOOTH_END_GAIN if smooth else END_GAIN
    end = per_frame * (min(motions, MOST_MOTIONS) + 1)
    if gain is not None:
        end = as_number(gain, "gain", above=0.0) * max(1.0, motions / MOST_MOTIONS)
    balanced, hold = 0.0 if balance is None else as_number(balance, "balance", at_least=0.0), 1.0
    if balanced:
        hold = BALANCED_HOLD * min(1.0, 50.0 / min(motions, MOST_MOTIONS))
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
    frame = base.frames[0] if start is None else as_angles(start, "start", (4,))
    motion = base.frames[1] - base.frames[0]
    if start_rate is None:
        # A walker with both legs alike stands still; any other is in the middle of a walk.
        stands = start is not None and stands_in(frame)
        return Walker(base, legs, frame, -motion if stands else np.zeros(4), settings)
    rate = as_array(start_rate, "start_rate", (4,))
    if not np.abs(rate).max() <= FASTEST:
        raise InputError(f"start_rate: {np.abs(rate).max():g} rad/s is above {FASTEST:g} rad/s")
    if stands_in(frame) and rate.any():
        raise InputError("start_rate: a walker whose legs are alike stands, and does not move; leave it out")
    if not settings.smoothness:
        raise InputError("start_rate: without smoothness nothing keeps the rate; leave one of the two out")
    return Walker(base, legs, frame, rate * base.dt - motion, settings, moves=True)


def by(settings: Settings, deadline: float, work: float = math.inf) -> Settings:
    """Settings with a search that ends in so many seconds from now, or when so much is spent on a step."""
    return replace(
        settings, work=work, until=time.perf_counter() + as_number(deadline, "deadline", above=0.0, unit="s")
    )


def _at_pace(base: Gait, pace: float | str | None) -> tuple[Gait, bool]:
    """The base gait at a fixed pace, its frames evenly apart, and whether steps are slowed where they need it."""
    evenly = base if base.paced is None else base.resampled(len(base))
    if pace is None or pace == "auto":
        return evenly, pace == "auto"
    if isinstance(pace, str):
        raise InputError(f"pace: {pace!r} is neither a number nor 'auto'")
    share = as_number(pace, "pace", above=0.0, at_most=1.0)
    return (evenly if share == 1.0 else replace(evenly, dt=evenly.dt / share)), False
