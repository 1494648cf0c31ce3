"""One step of a walk to be made: what is asked for, where the walker is, and how the step is sampled."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ggo_factors.graph.optimizer import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array
from ggo_factors.walking.walk import Step

MOST_MOTIONS = 100
"""A step of more frame-to-frame motions is solved as one of so many, with obstacle edges at the full rate between them,
and its offset from the base gait upsampled: the gait of the full graph for nearly the same time at any sampling rate.
The check looks at every frame."""
LEAST_FRAMES_FOR_A_RATE = 4


@dataclass(frozen=True)
class Manner:
    """How steps are made.

    Attributes:
        gain: omega of the end edge, or None for 5 m, 10 m with a smoothness.
        smoothness: gain of the second-order edges.
        hard: whether foothold, knees, clearance and joint limits are constraints.
        limits: of the joints, or None.
    """

    gain: float | None
    smoothness: float
    hard: bool
    limits: JointLimits | None


@dataclass(frozen=True, eq=False)
class StepTask:
    """One step to be made.

    Attributes:
        base: what it bends.
        step: what it must do.
        model: the legs.
        walked: the frames that are walked already, shape (k + 1, 4) in [rad]: the last one is where the walker is now.
        drift: what the offset from the base gait changes by from one frame to the next there, shape (4,) in [rad].
        pose: to land in, as far as the foothold lets it, shape (4,) in [rad]; or None.
        manner: how.
        name: what to call it in an error.
        number: number of the step in its walk, from 1.
    """

    base: Gait
    step: Step
    model: LegModel
    walked: Array
    drift: Array
    pose: Array | None
    manner: Manner
    name: str
    number: int

    @property
    def done(self) -> int:
        """The frame where the walker is now."""
        return len(self.walked) - 1

    @property
    def ahead(self) -> tuple[Gait, Gait, float]:
        """The base gait from there on, at its own rate and at that which it is solved at, and the ratio of the two."""
        return _ahead(self.base, self.done)

    @property
    def onward(self) -> Array:
        """The motion to the next frame of one who goes on as the walker moves, shape (4,) in [rad]."""
        base = self.ahead[0].frames
        return np.asarray(base[1] - base[0] + self.drift)

    @property
    def slowed(self) -> Array:
        """`drift`, but where the walker would go on faster than its joints may, as fast as they may."""
        if self.manner.limits is None:
            return self.drift
        base, most = self.ahead[0].frames, self.manner.limits.speed * self.base.dt
        allowed = np.clip(self.onward, -most, most) - (base[1] - base[0])
        return np.where(np.abs(self.onward) <= most, self.drift, allowed)

    @property
    def carried(self) -> Array | None:
        """Where the walker's motion carries the joints to by the second frame of the graph, shape (4,) in [rad].

        None where nothing in the graph goes on with it.
        """
        _, rest, every = self.ahead
        if not self.manner.smoothness or len(rest) < LEAST_FRAMES_FOR_A_RATE:
            return None
        return np.asarray(self.walked[-1] + (rest.frames[1] - rest.frames[0]) + every * self.slowed)

    def held(self, hard: bool) -> StepTask:
        """The same with its limits as constraints, or as edges that give way."""
        return replace(self, manner=replace(self.manner, hard=hard))


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class StepSolution(Solution):
    """The solution of one step of a walk.

    Attributes:
        task: what was asked for.
        solved: the frames that the graph was solved for, shape (k, 4) in [rad].
    """

    task: StepTask
    solved: Array


@lru_cache(maxsize=16)
def _ahead(base: Gait, done: int) -> tuple[Gait, Gait, float]:
    """`StepTask.ahead`, kept for the attempts at a step."""
    every = max(1.0, (len(base) - 1) / MOST_MOTIONS)
    fine = replace(base, frames=base.frames[done:])
    if every == 1.0:
        return fine, fine, every
    rest = fine.resampled(max(LEAST_FRAMES_FOR_A_RATE, round((len(fine) - 1) / every) + 1))
    return fine, rest, (len(fine) - 1) / (len(rest) - 1)
