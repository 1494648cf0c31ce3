"""A walker who takes steps: what all procedures ask for, checked once, and step after step from there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.procedures.search import checked_step
from ggo_factors.procedures.task import Settings, StepSolution, StepTask
from ggo_factors.support.inputs import Array, as_angles, as_array, as_instance, as_number
from ggo_factors.walking.walk import Step, Walk

MOST_STEPS = 1000
"""A walk of more steps is surely a slip."""
FASTEST = 50.0
"""No joint of a walker moves faster, in [rad/s]."""
SMOOTHING = 0.2
"""Share of a step's duration over which its offset from the base gait bends: the smoothness is the square of so many
frames, 100 for 51 of them."""


@dataclass(frozen=True, eq=False)
class Walker:
    """Who walks, from where, and how.

    Attributes:
        base: the base gait, which every step bends.
        model: the legs.
        frame: the frame that the walker is in, shape (4,) in [rad].
        velocity_offset: what the offset from the base gait changes by to the next frame, shape (4,) in [rad].
        settings: how steps are made.
    """

    base: Gait
    model: LegModel
    frame: Array
    velocity_offset: Array
    settings: Settings

    def walk(self, steps: Iterable[Step]) -> Walk:
        """A walk of these steps.

        Raises:
            InputError: where there is none.
            InfeasibleGaitError: where no gait passes the check for a step.
        """
        solutions = self.walked(steps)
        gaits, plan = (solution.gait for solution in solutions), (solution.task.step for solution in solutions)
        return Walk(tuple(gaits), tuple(plan), tuple(solutions))

    def walked(self, steps: Iterable[Step]) -> list[StepSolution]:
        """The steps, each from where the one before ended; see `walk`."""
        frame, offset, pose = self.frame, self.velocity_offset, None
        off = np.zeros(2)  # where the supporting foot stands beyond where it was to stand
        solutions: list[StepSolution] = []
        for number, step in enumerate(steps, start=1):
            seen = step.shifted(*off.tolist()) if off.any() else step
            kept = pose if step.keep_pose else None
            task = StepTask(
                self.base, seen, self.model, frame[None], offset, kept, self.settings, f"step {number}", number
            )
            solution = checked_step(task)
            solutions.append(solution)
            frames = solution.gait.frames
            pose, frame = frames[-1], swap_roles(frames[-1])
            offset = swap_roles(np.diff((frames - self.base.frames)[-2:], axis=0)[0])
            off = self.model.endpoint(frames[-1]) - seen.landing(self.model)
        if not solutions:
            raise InputError("steps: a walk needs at least one step")
        return solutions


def walker_of(
    base: Gait,
    model: LegModel | None,
    start: ArrayLike | None,
    start_rate: ArrayLike | None,
    gain: float | None,
    smoothness: float | None,
    hard: bool,
    limits: JointLimits | None,
) -> Walker:
    """The walker that a procedure was asked for; arguments as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
    """
    legs = as_instance(base, "base", Gait).legs(model)
    bends = (SMOOTHING * (len(base) - 1)) ** 2  # alike at any sampling rate
    settings = Settings(
        gain=None if gain is None else as_number(gain, "gain", above=0.0),
        smoothness=bends if smoothness is None else as_number(smoothness, "smoothness", at_least=0.0),
        hard=as_instance(hard, "hard", bool),
        limits=None if limits is None else as_instance(limits, "limits", JointLimits),
    )
    frame = base.frames[0] if start is None else as_angles(start, "start", (4,))
    motion = base.frames[1] - base.frames[0]
    if start_rate is None:
        return Walker(base, legs, frame, np.zeros(4) if start is None else -motion, settings)
    rate = as_array(start_rate, "start_rate", (4,))
    if not np.abs(rate).max() <= FASTEST:
        raise InputError(f"start_rate: {np.abs(rate).max():g} rad/s is above {FASTEST:g} rad/s")
    if not settings.smoothness:
        raise InputError("start_rate: without smoothness nothing keeps the rate; leave one of the two out")
    return Walker(base, legs, frame, rate * base.dt - motion, settings)
