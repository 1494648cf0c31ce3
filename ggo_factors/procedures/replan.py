"""Replanning in mid-step: frames that are walked stay, the rest is made again for the ground as it is seen now."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, overload

import gtsam
import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InfeasibleGaitError, InputError, Violation
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.base_gaits import BaseGaits, Kind, Leg, as_leg, both, other_leg
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.procedures.gains import RATE_KINDS
from ggo_factors.procedures.search import checked_step
from ggo_factors.procedures.steps import walker_of
from ggo_factors.procedures.task import LEAST_FRAMES_FOR_A_RATE, WORK, Settings, StepSolution, StepTask
from ggo_factors.procedures.walker import Walker, by
from ggo_factors.support.inputs import as_array, as_count, as_instance, as_number, as_tuple_of
from ggo_factors.walking.pace import allowed_landing_speed
from ggo_factors.walking.step import Step, closes, verify_step
from ggo_factors.walking.walk import Walk

DEADLINE = 0.3
"""A replan takes no longer than this in [s]: a controller waits for it."""
MORE_TO_REST = 2
"""So many frames more a step needs that ends at rest: in the last motion but one the joints still slow down."""


@overload
def replan(
    solution: Solution,
    at_frame: int,
    *,
    obstacles: Sequence[Obstacle] | None = None,
    foothold: ArrayLike | None = None,
    gaps: Sequence[Gap] | None = None,
    ground: Ground | None = None,
    limits: JointLimits | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    factors: Sequence[gtsam.NoiseModelFactor] | None = None,
) -> StepSolution: ...


@overload
def replan(
    solution: Walk,
    at_frame: int | None = None,
    *,
    step: int | None = None,
    time: float | None = None,
    base: Gait | BaseGaits | None = None,
    obstacles: Sequence[Obstacle] | None = None,
    foothold: ArrayLike | None = None,
    gaps: Sequence[Gap] | None = None,
    ground: Ground | None = None,
    limits: JointLimits | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    factors: Sequence[gtsam.NoiseModelFactor] | None = None,
) -> Walk: ...


def replan(
    solution: Solution | Walk,
    at_frame: int | None = None,
    *,
    step: int | None = None,
    time: float | None = None,
    base: Gait | BaseGaits | None = None,
    obstacles: Sequence[Obstacle] | None = None,
    foothold: ArrayLike | None = None,
    gaps: Sequence[Gap] | None = None,
    ground: Ground | None = None,
    limits: JointLimits | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    factors: Sequence[gtsam.NoiseModelFactor] | None = None,
) -> StepSolution | Walk:
    """The rest of a step, or of a walk, made again for other ground, checked as a whole.

    Arguments that are left out stay as the step had them. Unless the step was made without smoothness the joints go on
    at the speed that they have at that frame. Joint limits decide what can be reached in the time that is left, held to
    `Tolerances.limits` by the check: without any a foot could land anywhere in one frame. The later steps of a walk are
    made again from where this one lands now, their footholds, boxes and ground where they were in the world.

    Args:
        solution: a step from `step_over` or `Walk.steps`, an earlier replan, or a walk.
        at_frame: the last frame of the step that is walked; it and those before it stay as they are, to the bit.
        step: of a walk: number of the step in which the walker is, from 1.
        time: of a walk, in place of `step` and `at_frame`: time since its start in [s]; where too little of a step is
            left to be changed, it stays and the next one is made again.
        base: of a walk that was read from a file: the base gait, or gaits, that its steps were bent from.
        obstacles: boxes to step over, in the body frame of the step.
        foothold: where the swing ankle must land in [m], shape (2,).
        gaps: pits with no foothold in them.
        ground: height of the ground.
        limits: of the joints; those that the step was made with, or else the default ones of `JointLimits`, if None.
        pace: of what is left of the step: 1, the base gait's, or ``"auto"``, slower where the joints or a landing foot
            would be too fast. If None it is 1, so that "too late" is true; later steps of a walk have that of the walk.
        deadline: seconds that the call may take, 0.3 if None; see `step_over`.
        factors: GTSAM factors of your own on frames of the whole step, see `Step`; frames that are walked stay.

    Returns:
        The solution of the whole step, whose graph is that of the rest and whose frame 0 is `at_frame`; of a walk the
        whole walk.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where it is too late, or no gait passes the check, with the numbers and the nearest
            foothold that works.
    """
    how = how_of(limits, pace, deadline)
    seen = {
        "obstacles": None if obstacles is None else as_tuple_of(obstacles, "obstacles", Obstacle),
        "gaps": None if gaps is None else as_tuple_of(gaps, "gaps", Gap),
        "ground": None if ground is None else as_instance(ground, "ground", Ground),
        "factors": None if factors is None else as_tuple_of(factors, "factors", gtsam.NoiseModelFactor),
    }
    if foothold is not None:
        x, y = as_array(foothold, "foothold", (2,)).tolist()
        seen["foothold"] = (x, y)
    ahead: dict[str, object] = {name: value for name, value in seen.items() if value is not None}
    if not isinstance(solution, Walk):
        if step is not None or time is not None or base is not None:
            raise InputError("step, time and base: are for a walk; a step knows its own")
        task = as_instance(solution, "solution", StepSolution).task
        if at_frame is None:
            raise InputError("at_frame: say which frame is the last one walked")
        made = rest_of_step(task, solution.gait, at_frame, ahead, how)
        if not how.slows:
            return made
        alone = Walk((made.gait,), (made.task.step,), (made,), made.task.settings.limits, first_swing=task.swing)
        (slowed,) = alone.slowed(allowed_landing_speed(task.base, task.model), frame=at_frame, held=True).steps
        assert isinstance(slowed, StepSolution)
        return slowed
    number, done = _where(solution, step, at_frame, time)
    return _rest_of_walk(solution, number, done, base, ahead, how)


@dataclass(frozen=True)
class How:
    """How the rest is made: the limits that were asked for, whether it is slowed, how long and how much it may take."""

    limits: JointLimits | None
    slows: bool
    deadline: float
    work: float

    def settings(self, settings: Settings) -> Settings:
        """Settings of a step with these in place."""
        limits = self.limits or settings.limits or JointLimits()
        # Of a walk whose pace was chosen the trajectory is held to its limits as it is played.
        played = settings.slows or settings.played or self.slows
        return by(replace(settings, limits=limits, slows=self.slows, played=played), self.deadline, self.work)


def how_of(limits: JointLimits | None, pace: object, deadline: float | None) -> How:
    """How the rest is made, of what was asked for; see `replan`.

    Raises:
        InputError: where an argument is unusable.
    """
    asked = limits if limits is None else as_instance(limits, "limits", JointLimits)
    if pace not in (None, 1, "auto"):
        raise InputError(f"pace: {pace!r} is neither 1 nor 'auto': the frames walked have the base gait's rate")
    # Without a deadline that was asked for, the same call has the same answer on any machine that is fast enough.
    seconds = DEADLINE if deadline is None else deadline
    return How(asked, pace == "auto", seconds, WORK if deadline is None else math.inf)


def rest_of_step(task: StepTask, gait: Gait, at_frame: int, ahead: dict[str, object], how: How) -> StepSolution:
    """The step with its rest made again."""
    if "foothold" in ahead:
        ahead = {**ahead, "end_frame": None}
    step: Step = replace(task.step, **ahead)  # type: ignore[arg-type]
    frames, needed = gait.frames, _least_frames(step)
    done = as_count(at_frame, "at_frame", 0, len(frames) - 1)
    if done > len(frames) - needed:
        raise InfeasibleGaitError(
            f"replan at frame {done}: too late, {len(frames) - 1 - done} frames are left and {needed - 1} are needed"
        )
    hit = [fault for fault in verify_step(gait, step, task.model).violations if _is_walked(fault, done)]
    if hit:
        raise InfeasibleGaitError(
            f"replan at frame {done}: too late, already walked: " + "; ".join(map(str, hit)),
            tuple(hit),
            None,
            task.number,
        )
    offset, paced = task.velocity_offset, gait.paced
    if done and paced is None:
        offset = np.diff((frames - task.base.frames)[done - 1 : done + 1], axis=0)[0]
    elif done:
        # The next frame is where what is played would be by then: as fast and as bent, no kink rings on.
        dt, motion = task.base.dt, task.base.frames[done + 1] - task.base.frames[done]
        (ahead_of,) = gait.played.at(gait.times[done : done + 1] + dt)[0]
        offset = ahead_of - frames[done] - motion
    return checked_step(
        replace(
            task,
            step=step,
            walked=frames[: done + 1],
            velocity_offset=offset,
            settings=how.settings(task.settings),
            name=f"replan at frame {done}",
            walked_times=None if paced is None else paced[: done + 1],
        )
    )


def _least_frames(step: Step) -> int:
    """How many frames a step must have left, the present one counted; who comes to rest needs time to slow down."""
    return LEAST_FRAMES_FOR_A_RATE + (MORE_TO_REST if step.end_frame is not None else 0)


def _where(walk: Walk, step: int | None, at_frame: int | None, time: float | None) -> tuple[int, int]:
    """The number of the step in which the walker is, from 0, and the last frame of it that is walked."""
    if time is None:
        if step is None or at_frame is None:
            raise InputError("replan: of a walk say the step and at_frame, or the time")
        return as_count(step, "step", 1, len(walk.gaits)) - 1, at_frame
    if step is not None or at_frame is not None:
        raise InputError("time: give it, or step and at_frame")
    seconds = as_number(time, "time", at_least=0.0, unit="s")
    began = 0.0
    for number, (gait, asked) in enumerate(zip(walk.gaits, walk.plan, strict=True)):
        # A frame counts as walked once it is reached; rounding must not cost one.
        frame = int(np.searchsorted(gait.times, seconds - began + 1e-6 * gait.dt, side="right")) - 1
        if frame <= len(gait) - _least_frames(asked):
            return number, max(frame, 0)
        began += gait.duration
    raise InfeasibleGaitError(f"replan at {seconds:g} s: too late, the walk is over or nearly so")


def _rest_of_walk(
    walk: Walk, number: int, done: int, base: Gait | BaseGaits | None, ahead: dict[str, object], how: How
) -> Walk:
    """The walk with the rest of a step and all later steps made again."""
    gait, walker = walk.gaits[number], walker_in(walk, number, base, how)
    task = walker.task(walk.plan[number], number + 1, len(walk.gaits) - number)
    now = rest_of_step(task, gait, done, ahead, how)
    model, made, later = walker.model, [now], list(walk.plan[number + 1 :])
    if later:
        moved = model.endpoint(now.gait.frames[-1]) - model.endpoint(gait.frames[-1])
        later[0] = later[0].shifted(*moved.tolist())
        # The others were seen from where the walker stood then; a walker sees them from where the step was to land.
        for k in range(1, len(later)):
            before = number + k
            off = model.endpoint(walk.gaits[before].frames[-1]) - walk.plan[before].landing(model)
            later[k] = later[k].shifted(*(-off).tolist())
        made += walker.after(now.gait, now.task.step).walked(later, first=number + 2)
    return joined(walk, number, made, walker, how, done)


def joined(walk: Walk, number: int, made: Sequence[StepSolution], walker: Walker, how: How, done: int) -> Walk:
    """A walk with other steps from a step on, counted from 0, of which `done` is the last frame that is walked.

    Raises:
        InfeasibleGaitError: where it cannot be slowed as it must, or comes to rest faster than its limits.
    """
    again = Walk(
        gaits=(*walk.gaits[:number], *(solution.gait for solution in made)),
        plan=(*walk.plan[:number], *(solution.task.step for solution in made)),
        steps=(*walk.steps[:number], *made) if walk.steps else (),
        limits=how.limits or walk.limits,
        notes=walk.notes,
        first_swing=walk.first_swing,
    )
    if walk.landing_speed is None and not how.slows:
        for step, faults in enumerate(again.trajectory_faults(again.limits)[number:], start=number):
            # Steps are checked one by one; as it is played a walk may be faster where it comes to rest.
            fast = [f for f in faults if f.kind in RATE_KINDS and (step > number or f.frame is None or f.frame > done)]
            if fast:
                message = f"replan: step {step + 1} is too fast: {'; '.join(map(str, fast))}; a slower pace may do"
                raise InfeasibleGaitError(message, fast, None, step + 1)
        return again
    most = walk.landing_speed or allowed_landing_speed(walker.base, walker.model)
    return again.slowed(most, step=number, frame=done, held=True)


def walker_in(walk: Walk, number: int, base: Gait | BaseGaits | None, how: How) -> Walker:
    """The walker in the first frame of a step of a walk."""
    walker = _walker_before(walk, number, base)
    slows = how.slows or walk.landing_speed is not None
    walker = replace(walker, settings=replace(how.settings(walker.settings), slows=slows))
    if not number:
        return walker
    before = replace(walker, swing=other_leg(walker.swing), kind=_kind(walk, number - 1, walker))
    after = before.after(walk.gaits[number - 1], walk.plan[number - 1])
    faced = after.toward(walk.plan[number])
    return replace(faced, frame=walker.frame, settings=walker.settings)


def _walker_before(walk: Walk, number: int, base: Gait | BaseGaits | None) -> Walker:
    """The walker at the start of a step, moving as its first two frames say."""
    gait, known = walk.gaits[number], walk.steps[number] if walk.steps else None
    swing = as_leg(walk.first_swing, "first_swing")
    if number % 2:
        swing = other_leg(swing)
    if isinstance(known, StepSolution):
        if base is not None:
            raise InputError("base: this walk knows which base gait it was bent from; leave it out")
        task, settings = known.task, known.task.settings
        bases, model, kind = task.bases or both(task.base), task.model, task.kind
    elif base is None:
        raise InputError("base: a walk from a file does not carry the base gait that it was bent from; give it")
    else:
        model, step = walk.model, walk.plan[number]
        kind = both(base).kind_for(step.landing(model)[1], model, gait.frames[0], closes(step))
        if isinstance(base, BaseGaits):
            bases = _at_its_pace(base, gait, kind, swing)
        else:
            one = as_instance(base, "base", Gait).resampled(len(gait))
            bases = both(replace(one, dt=gait.dt))
        bent = bases.gait(kind, swing)
        if len(bent) != len(gait):
            raise InputError(f"base: {bent.name!r} has {len(bent)} frames at this rate, step {number + 1} {len(gait)}")
        settings = walker_of(bent, model, None, None, None, None, False, walk.limits, None, 1.0).settings
    bent = bases.gait(kind, swing)
    # In this order of differences one who stands has an offset that takes the base gait's motion out to the last bit.
    first, motion = gait.frames[0], gait.pace(0) * (gait.frames[1] - gait.frames[0])
    offset = motion - (bent.frames[1] - bent.frames[0])
    return Walker(bases, model, first, offset, settings, placed=True, swing=swing, kind=kind)


def _at_its_pace(base: BaseGaits, gait: Gait, kind: Kind, swing: Leg) -> BaseGaits:
    """Base gaits at the rate of a step that was bent from them, and as slow as it is where that was asked for."""
    bases, own = base.at(gait.dt), base.gait(kind, swing)
    slower = (len(gait) - 1) * gait.dt / own.duration
    if len(bases.gait(kind, swing)) == len(gait) or slower < 1.0:
        return bases
    paced = base.changed(lambda one: replace(one, dt=slower * one.dt)).at(gait.dt)
    # Another walker's gait is not the same one slowed.
    return paced if gait.bent and gait.bent.fingerprint == paced.gait(kind, swing).fingerprint else bases


def _kind(walk: Walk, number: int, walker: Walker) -> Kind:
    """The kind of ground of the base gait that a step was bent from."""
    known = walk.steps[number] if walk.steps else None
    if isinstance(known, StepSolution):
        return known.task.kind
    step, begun = walk.plan[number], walk.gaits[number].frames[0]
    return walker.bases.kind_for(step.landing(walker.model)[1], walker.model, begun, closes(step))


def _is_walked(fault: Violation, done: int) -> bool:
    """Whether a violation is a hit in the frames that are walked, `done` the last of them."""
    return fault.frame is not None and fault.frame <= done and fault.kind.startswith(("obstacle", "ground"))
