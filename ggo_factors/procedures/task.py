"""One step of a walk to be made: what is asked for, where the walker is, and how it is made. Plain data."""

from __future__ import annotations

from dataclasses import dataclass

from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.procedures.gains import Gains
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import Step

MOST_MOTIONS = 100
"""A step of more frame-to-frame motions is solved as one of so many, with obstacle edges at the full rate between them,
and its offset from the base gait upsampled: the gait of the full graph for nearly the same time at any sampling rate.
The check looks at every frame."""
LEAST_FRAMES_FOR_A_RATE = 4
"""So many frames a step needs to go on as the walker moves: the second one is given, and one more must be free."""


@dataclass(frozen=True)
class Settings:
    """How steps are made.

    Attributes:
        gains: gains of the first attempt.
        gain_given: whether the end edge keeps its gain in the attempts that follow.
        smoothness: gain of the second-order edges.
        hard: whether foothold, knees, clearance and joint limits are constraints.
        limits: of the joints, or None.
        landing: whether steps land as the base gait lands, as far as their footholds let them.
        landing_forced: whether a step that cannot be made so is refused, and not made without.
    """

    gains: Gains
    gain_given: bool
    smoothness: float
    hard: bool
    limits: JointLimits | None
    landing: bool
    landing_forced: bool = False


@dataclass(frozen=True, eq=False)
class Beginning:
    """How what is left of a step begins.

    Attributes:
        done: the frame where the walker is now.
        fine: the base gait from there on, at its own rate.
        rest: the same at the rate that the step is solved at.
        every: frames of the one from a frame of the other to the next, 1 or more.
        extrapolated: the motion to the next frame of one who goes on as the walker moves, shape (4,) in [rad].
        velocity_offset: what the offset from the base gait changes by to the next frame, shape (4,) in [rad]; where the
            walker would go on faster than its joints may, as fast as they may.
        carried: where that brings the joints by the second frame of `rest`, shape (4,) in [rad]; None where nothing in
            the graph goes on with it.
    """

    done: int
    fine: Gait
    rest: Gait
    every: float
    extrapolated: Array
    velocity_offset: Array
    carried: Array | None


@dataclass(frozen=True, eq=False)
class StepTask:
    """One step to be made.

    Attributes:
        base: what it bends.
        step: what it must do.
        model: the legs.
        walked: the frames that are walked already, shape (k + 1, 4) in [rad]: the last one is where the walker is now.
        velocity_offset: what the offset from the base gait changes by from one frame to the next there, shape (4,) in
            [rad].
        last_motion: by which the walker came into the frame that the step starts in, shape (4,) in [rad]; None where
            that is not known.
        settings: how.
        name: what to call it in an error.
        number: number of the step in its walk, from 1.
    """

    base: Gait
    step: Step
    model: LegModel
    walked: Array
    velocity_offset: Array
    last_motion: Array | None
    settings: Settings
    name: str
    number: int


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class StepSolution(Solution):
    """The solution of one step of a walk.

    Attributes:
        task: what was asked for.
    """

    task: StepTask
