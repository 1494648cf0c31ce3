"""The walker of all procedures: from step to step, each bent from the base gait that fits its leg and its ground."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.motion.base_gaits import AFTER_FIRST, STAIR, BaseGaits, Kind, Leg, landing_height, other_leg
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.procedures.gains import BALANCED_HOLD, INSIDE
from ggo_factors.procedures.search import checked_step
from ggo_factors.procedures.task import MOST_MOTIONS, Settings, StepSolution, StepTask
from ggo_factors.support.inputs import Array, as_number
from ggo_factors.walking.pace import allowed_landing_speed
from ggo_factors.walking.step import Step, closes, stands_in
from ggo_factors.walking.walk import Walk


@dataclass(frozen=True, eq=False)
class Walker:
    """A walker between two steps: where, how fast, and how steps are made.

    Attributes:
        bases: the base gaits, of which each step bends the one for its swinging leg and its ground.
        model: the legs.
        frame: the frame that the walker is in, shape (4,) in [rad].
        velocity_offset: change of the offset from the base gait to the next frame, shape (4,) in [rad].
        settings: how steps are made.
        last_motion: motion into that frame, shape (4,) in [rad]; None where it is not known.
        moves: whether it is known how fast the walker moves now, which no pace can change.
        placed: whether the frame was given, or walked to, and is not merely the base gait's first.
        swing: the leg that swings next.
        kind: the kind of ground that the base gait of the next step is for.
    """

    bases: BaseGaits
    model: LegModel
    frame: Array
    velocity_offset: Array
    settings: Settings
    last_motion: Array | None = None
    moves: bool = False
    placed: bool = False
    swing: Leg = "right"
    kind: Kind = "level"

    @property
    def base(self) -> Gait:
        """The base gait that the next step bends."""
        return self.bases.gait(self.kind, self.swing)

    def walk(self, steps: Iterable[Step]) -> Walk:
        """A walk of these steps.

        Raises:
            InputError: where there is none.
            InfeasibleGaitError: where no gait passes the check for a step.
        """
        return self.whole(self.walked(steps))

    def whole(self, solutions: Sequence[StepSolution]) -> Walk:
        """The walk of steps that were made from here one after the other, as slow as it must be.

        Raises:
            InfeasibleGaitError: where a step does not follow from the one before, or cannot be slowed as it must.
        """
        gaits, plan = (solution.gait for solution in solutions), (solution.task.step for solution in solutions)
        made = Walk(tuple(gaits), tuple(plan), tuple(solutions), self.settings.limits, first_swing=self.swing)
        if self.settings.slows:
            made = self._slowed(made, max(allowed_landing_speed(s.task.base, self.model) for s in solutions))
        # Without smoothness nothing carries a joint's speed on at a change of legs: `Walk.verify` tells where it jumps.
        for number, faults in enumerate(made.trajectory_faults(self.settings.limits), start=1):
            if faults and self.settings.smoothness:
                message = f"step {number}: its motion does not follow from rest or from the steps beside it: "
                raise InfeasibleGaitError(message + "; ".join(map(str, faults)), faults, None, number)
        return made

    def _slowed(self, made: Walk, landing_speed: float) -> Walk:
        """A walk as slow as it must be; as it is where its walker moves too fast to slow down, but within limits."""
        try:
            return made.slowed(landing_speed, held=self.moves)
        except InfeasibleGaitError:
            if not self.moves or any(made.trajectory_faults(made.limits)):
                raise
            return made

    def walked(self, steps: Iterable[Step], first: int = 1) -> list[StepSolution]:
        """The steps, numbered from `first`, each from where the one before ended; see `walk`."""
        way, steps = Way(self), list(steps)
        for number, step in enumerate(steps, start=first):
            way = way.then(step, number, first + len(steps) - number)
        if not way.solutions:
            raise InputError("steps: a walk needs at least one step")
        return list(way.solutions)

    def task(self, step: Step, number: int, left: int) -> StepTask:
        """The next step as a task, `number` of its walk, one of `left` that are to be made."""
        settings = self.settings
        if stands_in(self.frame) and abs(landing_height(self.base, self.model)) > STAIR:
            # Far from how a stair gait begins, with a foot to be lifted from beside the other: it takes more attempts.
            settings = replace(settings, work=math.inf)
        return StepTask(
            base=self.base,
            step=step,
            model=self.model,
            walked=self.frame[None],
            velocity_offset=self.velocity_offset,
            last_motion=self.last_motion,
            settings=settings,
            name=f"step {number}",
            number=number,
            moves=self.moves,
            left=left,
            bases=self.bases,
            swing=self.swing,
            kind=self.kind,
        )

    def toward(self, step: Step) -> Walker:
        """The walker with the base gait that fits a step, moving on as it moves now.

        Raises:
            InputError: where it was not said where the walker is, and the base gait begins on other ground.
        """
        faced = self.bending(self.bases.kind_for(step.landing(self.model)[1], self.model, self.frame, closes(step)))
        if not self.placed and abs(landing_height(self.base, self.model)) > STAIR:
            x, y = self.model.endpoint(self.frame).tolist()
            stands = float(step.ground.height_at(x))
            if abs(y - stands) > STAIR:
                raise InputError(
                    f"base: {self.base.name!r} walks stairs, its feet {abs(y):.3f} m apart in height at the start; on "
                    f"this ground say where the walker is (start=STANDING, --from-standing), or take a level gait"
                )
        return replace(faced, placed=True)

    def after(self, gait: Gait, step: Step) -> Walker:
        """The walker after a step: the legs' roles swapped, moving on as the step ended."""
        frames, leg, kind = gait.frames, other_leg(self.swing), AFTER_FIRST.get(self.kind, self.kind)
        following = self.bases.gait(kind, leg)
        motion, pace = swap_roles(frames[-1] - frames[-2]), gait.pace(len(gait) - 2)
        if step.end_frame is not None:
            offset = following.frames[0] - following.frames[1]  # at rest
        elif kind != self.kind:
            offset = motion - (following.frames[1] - following.frames[0])  # its base gait does not go on as it ends
        else:
            offset = swap_roles(np.diff(frames[-2:] - self.base.frames[-2:], axis=0)[0])
        settings = scaled(self.settings, len(self.base) - 1, len(following) - 1)
        return replace(
            self,
            frame=swap_roles(frames[-1]),
            velocity_offset=offset + (pace - 1.0) * motion,
            last_motion=pace * motion,
            moves=False,
            settings=settings,
            swing=leg,
            kind=kind,
        )

    def bending(self, kind: Kind) -> Walker:
        """The walker in the same motion with the base gait for another kind of ground."""
        now, then = self.base, self.bases.gait(kind, self.swing)
        if then is now:
            return replace(self, kind=kind)
        moving = (now.frames[1] - now.frames[0]) + self.velocity_offset
        return replace(
            self,
            velocity_offset=moving - (then.frames[1] - then.frames[0]),
            settings=scaled(self.settings, len(now) - 1, len(then) - 1),
            kind=kind,
        )


@dataclass(frozen=True, eq=False)
class Way:
    """The steps that a walker has made so far.

    Attributes:
        walker: the walker before its next step, or before the first.
        solutions: how each step was found.
        off: where the supporting foot stands beyond where it was to stand, shape (2,) in [m].
        before: the last step, as it was asked for; None before the first.
    """

    walker: Walker
    solutions: tuple[StepSolution, ...] = ()
    off: tuple[float, float] = (0.0, 0.0)
    before: Step | None = None

    def then(self, step: Step, number: int, left: int) -> Way:
        """The way with one more step, `number` of its walk, one of `left` that are to be made.

        Raises:
            InfeasibleGaitError: where no gait passes the check for it.
        """
        walker = self.walker
        if self.before is not None:
            walker = walker.after(self.solutions[-1].gait, self.before)
        seen = step.shifted(*self.off) if any(self.off) else step
        walker = walker.toward(seen)
        solution = checked_step(walker.task(seen, number, left))
        x, y = (walker.model.endpoint(solution.gait.frames[-1]) - seen.landing(walker.model)).tolist()
        return Way(walker, (*self.solutions, solution), (x, y), step)


def scaled(settings: Settings, motions: int, others: int) -> Settings:
    """Settings of steps of `motions` frame-to-frame motions for steps of another number, alike in what they weigh."""
    if motions == others:
        return settings
    gains, before, now = settings.gains, min(motions, MOST_MOTIONS), min(others, MOST_MOTIONS)
    if settings.gain_given:
        end = gains.end * max(1.0, others / MOST_MOTIONS) / max(1.0, motions / MOST_MOTIONS)
    else:
        end = gains.end * (now + 1) / (before + 1)
    hold = balanced_hold(others) if settings.balance else gains.hold
    gains = replace(gains, end=end, hold=hold, inside=INSIDE if others > MOST_MOTIONS else 0.0)
    smoothness = settings.smoothness if settings.smoothness_given else settings.smoothness * (others / motions) ** 2
    return replace(settings, gains=gains, smoothness=smoothness)


def balanced_hold(motions: int) -> float:
    """Hold of the first attempt at a balanced step of so many frame-to-frame motions."""
    return BALANCED_HOLD * min(1.0, 50.0 / min(motions, MOST_MOTIONS))


def by(settings: Settings, deadline: float, work: float = math.inf) -> Settings:
    """Settings with a search that ends in so many seconds from now, or when so much is spent on a step."""
    return replace(
        settings, work=work, until=time.perf_counter() + as_number(deadline, "deadline", above=0.0, unit="s")
    )
