"""One step of a walk to be made: what is asked for, where the walker is, and how it is made. Plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import gtsam

from ggo_factors.graph.solution import Solution
from ggo_factors.motion.base_gaits import BaseGaits, Kind, Leg
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.recorded import BentFrom
from ggo_factors.motion.style import Style
from ggo_factors.procedures.gains import Gains
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array
from ggo_factors.walking.pace import allowed_landing_speed
from ggo_factors.walking.step import Step
from ggo_factors.walking.walk import Walk

if TYPE_CHECKING:
    from ggo_factors.motion.picture import Place

MOST_MOTIONS = 100
"""A step of more frame-to-frame motions is solved as one of this many, with obstacle edges at the full rate between
them, and its offset from the base gait is upsampled: nearly the gait of the full graph, in nearly the same time at any
sampling rate. The check looks at every frame."""
LEAST_FRAMES_FOR_A_RATE = 4
"""A step needs this many frames to go on at the walker's speed: the second one is given, and one more must be free."""
WORK = 5200.0
"""Where no deadline is given, so much may be spent on a step, see `Budget`: about a quarter of a second."""


@dataclass(frozen=True)
class Settings:
    """How steps are made.

    Attributes:
        gains: gains of the first attempt.
        gain_given: whether the end edge keeps its gain in the attempts that follow.
        smoothness: gain of the second-order edges.
        hard: whether foothold, knees, clearance and joint limits are constraints.
        limits: of the joints, or None.
        landing: whether steps have landing edges.
        landing_forced: whether a step that is not found with landing edges is refused, and not tried without.
        slows: whether a path on which joints are too fast is walked slower.
        smoothness_given: whether the smoothness stays in the ways that are tried.
        played: whether edges hold rates at every instant of what is played between frames too.
        work: how much may be spent on a step, see `Budget`.
        until: when the search must end, by `time.perf_counter` in [s].
        balance: gain of the balance edges in a step of 50 motions, see `requests.balance_gain`; 0 for none.
        style: how a person varies steps, or None.
        nearest: whether a refusal looks for the nearest foothold that works.
    """

    gains: Gains
    gain_given: bool
    smoothness: float
    hard: bool
    limits: JointLimits | None
    landing: bool
    landing_forced: bool = False
    slows: bool = False
    smoothness_given: bool = False
    played: bool = False
    work: float = WORK
    until: float = math.inf
    balance: float = 0.0
    style: Style | None = None
    nearest: bool = True


@dataclass(frozen=True, eq=False)
class Beginning:
    """How what is left of a step begins.

    Attributes:
        done: number of the frame that the walker is in now.
        fine: the base gait from there on, at its own rate.
        rest: the same at the rate that the step is solved at.
        every: frames of `fine` from one frame of `rest` to the next, 1 or more.
        extrapolated: the motion to the next frame at the walker's speed now, shape (4,) in [rad].
        velocity_offset: change of the offset from the base gait to the next frame, shape (4,) in [rad], cut to what
            the joint limits allow.
        stands: whether the walker stands still there.
        carried: the second frame of `rest` that follows from it, shape (4,) in [rad]; None where the graph does not
            keep the walker's speed.
        varies: whether the walker's speed is not known, and taken to vary with the style as the base gait does.
        own: the factors of the user's own, on frames of `rest`.
    """

    done: int
    fine: Gait
    rest: Gait
    every: float
    extrapolated: Array
    velocity_offset: Array
    stands: bool
    carried: Array | None
    varies: bool = False
    own: tuple[gtsam.NoiseModelFactor, ...] = ()


@dataclass(frozen=True, eq=False)
class StepTask:
    """One step to be made.

    Attributes:
        base: the base gait.
        step: what the step must do.
        model: the legs.
        walked: the frames that are walked already, shape (k + 1, 4) in [rad]; the walker is in the last one.
        velocity_offset: change of the offset from the base gait from that frame to the next, shape (4,) in [rad].
        last_motion: motion into the frame that the step starts in, shape (4,) in [rad]; None where it is not known.
        settings: how the step is made.
        name: what to call it in an error.
        number: number of the step in its walk, from 1.
        moves: whether it is known how fast the walker moves there, which no pace can change.
        left: how many steps are to be made, this one counted: so much of the time that is left is not all its own.
        walked_times: times of the frames walked from the first in [s], shape (k + 1,); None where they are `dt` apart.
        bases: all base gaits of the walker, `base` among them; None where `base` is the only one.
        swing: the leg that swings.
        kind: the kind of ground that `base` is for.
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
    moves: bool = False
    left: int = 1
    walked_times: Array | None = None
    bases: BaseGaits | None = None
    swing: Leg = "right"
    kind: Kind = "level"

    def motion_into(self) -> Array | None:
        """Motion into the present frame as if at the base gait's pace, shape (4,) in [rad]; None where unknown."""
        if len(self.walked) == 1:
            return self.last_motion
        motion: Array = self.walked[-1] - self.walked[-2]
        if self.walked_times is None:
            return motion
        return motion * (self.base.dt / float(self.walked_times[-1] - self.walked_times[-2]))


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class StepSolution(Solution):
    """The solution of one step of a walk.

    Attributes:
        task: what was asked for.
        next_step: of `step_over`: the step after, which brings the other foot over the same boxes; None where there is
            none, which `report.notes` then says, or none was looked for.
    """

    task: StepTask
    next_step: StepSolution | None = None

    def bent_from(self) -> BentFrom:
        """What the step was bent from, for its file."""
        task, numbers, style = self.task, self.style, self.task.settings.style
        said = BentFrom(task.base.name, task.base.fingerprint, task.kind, task.swing)
        if numbers is None or style is None:
            return said
        return replace(said, style=style.fingerprint, numbers=tuple(numbers.tolist()))

    def _on(self, place: Place) -> Place:
        step, legs = self.task.step, self.task.model
        return replace(
            place,
            joints=legs.joints(self.gait.frames),
            obstacles=step.obstacles,
            gaps=step.gaps,
            ground=step.ground,
            foothold=step.landing(legs),
        )

    def as_walk(self) -> Walk:
        """The walk of this one step, with what was asked of it and the joint limits."""
        task = self.task
        slowest = None if self.gait.paced is None else allowed_landing_speed(task.base, task.model)
        limits = task.settings.limits
        return Walk((self.gait,), (task.step,), (self,), limits=limits, landing_speed=slowest, first_swing=task.swing)

    def save(self, path: PathLike) -> None:
        """Write the step as a walk of one step, whole or not at all; `load_walk` reads and `Walk.verify` checks it.

        The file holds the gait, what was asked of it and the joint limits. The graph is not kept.

        Raises:
            InputError: where the file cannot be written.
        """
        self.as_walk().save(path)
