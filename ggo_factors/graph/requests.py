"""What a user asks of a gait graph, request by request: plain data, made into edges in `assembly`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.check.balance import support_of
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.style import Style
from ggo_factors.motion.terrain import Ground, Obstacle
from ggo_factors.support.inputs import Array, as_number

HARD_GAIN = 1e4
"""Gain of the edge that stands for a constraint; its target is moved until the constraint is met (augmented
Lagrangian)."""
HARD_TOLERANCE = 1e-6
"""Largest miss of a constraint that counts as met, in its own unit."""
LIMIT_GAIN = 10.0
"""Gain of an edge on a joint limit, whose error is the excess as a share of the limit."""
LEG_GAIN = 100.0
"""Gain of a leg edge, in [1/m^2]."""
POSTURE_GAIN = 50.0
"""Gain of the touchdown posture times solved motions: 1 for 50 of them, as stiff as a residual edge. The residual chain
of a step is as stiff as one edge of gain 1 / n, so the law lands alike at any sampling rate."""
MOTION_GAIN = 0.5
"""Gain of the motion at touchdown for each solved motion: 25 for 50 of them. Less lets more flights of stairs limp with
period two (7 of 36 at 0.4, 2 at 0.5), more makes joints accelerate more (over the paper's obstacles 3.8 times the base
gait's own peak at 0.5, 4.0 at 0.8)."""
BALANCE_GAIN = 2.0
"""Gain of a balance edge in [1/m^2] in a step of 50 motions, see `balance_gain`. Mean distance of the ZMP from the base
gait's in steps of 1 s over 205 boxes: 1.7 mm, the largest mean of a step 7 (without 86, 652); 5 and 22 at 0.5, 3 and
12 at 1. All change the joints less than steps that are not balanced, by a sixth."""


def balance_gain(gain: float, motions: float) -> float:
    """Gain of each balance edge in a step of so many motions that acts as `gain` does in one of 50.

    The residual chain of a step is as stiff as one edge of gain 1 / n, and there are n balance edges.
    """
    return gain * (50.0 / motions) ** 2


@dataclass(frozen=True)
class ObstacleRequest:
    """A box to clear; `frames` None leaves it to the rounds which frames get an edge."""

    obstacle: Obstacle
    frames: tuple[int, ...] | None
    hold: float
    gamma: float
    margin: float


@dataclass(frozen=True)
class GroundRequest:
    """The ground to stay above; the rounds choose the frames."""

    ground: Ground
    hold: float
    gamma: float
    margin: float


@dataclass(frozen=True)
class LegRequest:
    """Thighs and shanks that have a radius stay clear of obstacles and stairs by a margin in [m]."""

    obstacles: tuple[Obstacle, ...]
    ground: Ground | None
    margin: float
    gain: float


@dataclass(frozen=True)
class JointLimitRequest:
    """Joint limits, and the gain of their edges, whose error is a share of the limit."""

    limits: JointLimits
    gain: float


@dataclass(frozen=True, eq=False)
class StartRequest:
    """The motion to begin with.

    Attributes:
        velocity_offset: change of the offset from the base gait from frame to frame, shape (4,) in [rad].
        given: the share of the first motion that is given by that speed and cannot change.
        varies: whether the walker's speed is not known: that of the base gait, as it varies by the style.
    """

    velocity_offset: Array
    given: float
    varies: bool = False


@dataclass(frozen=True, eq=False)
class EndRequest:
    """Targets of one frame: foothold, angle of the shank, whole pose; None where there is none."""

    frame: int
    foothold: tuple[float, float] | None
    shank_angle: float | None
    pose: Array | None
    gain: float  # infinite for a constraint


@dataclass(frozen=True, eq=False)
class LandingRequest:
    """Land as the base gait lands, as far as the foothold allows; both edges are soft.

    Attributes:
        posture: touchdown posture, shape (4,) in [rad].
        posture_gain: gain of the edge on the last frame.
        motion_gain: gain of the edge on the last motion.
    """

    posture: Array
    posture_gain: float
    motion_gain: float


@dataclass(frozen=True)
class BalanceRequest:
    """The ground's push acts where it does in the base gait, or within a support.

    Attributes:
        gain: gain of the edge of each inner frame in [1/m^2].
        support: x of the back and front end of the support in [m], from the supporting ankle, or None.
        shift: how much further forward the push acts where the walker starts, see `zero_moment.start_shift`, in [m]; if
            None what the anchor of the first frame says.
        since: time since that start in [s].
    """

    gain: float
    support: tuple[float, float] | None = None
    shift: float | None = None
    since: float = 0.0


LIKELY_START = 18.47
"""Squared distance in standard deviations within which 999 of 1000 frames of four angles are. A start farther off, over
a box or from standing, says nothing of how the person varies steps."""


@dataclass(frozen=True, eq=False)
class StyleRequest:
    """The base gait varies as a person varies a step, see `factors.style`.

    Attributes:
        directions: W at the frames of the graph, shape (m, 4, k), in [rad] for each unit of the style variable, whose
            prior has gain 1, as the residual edges have.
        unit: standard deviation of each of its numbers between steps, in that unit.
        lands: whether landing edges hold the step to the base gait as it varies.
        start_gain: gain of the edge that holds the first frame, where it is anchored, to the base gait as it varies.
    """

    directions: Array
    unit: float
    lands: bool = False
    start_gain: float = 0.0

    @property
    def farthest(self) -> float:
        """How far the style variable goes from 0 in 99 of 100 of a person's steps, in its own unit."""
        return self.unit * (math.sqrt(self.directions.shape[2]) + 1.65)  # of a chi distribution, to 1 %


@lru_cache(maxsize=16)
def style_request(style: Style, frames: int, motions: float | None = None, first: float = 0.0) -> StyleRequest:
    """The style at the frames of a graph.

    The residual chain of a step is as stiff as one edge of gain 1 / n, so in a step of more motions each of them varies
    less, and the style variable counts as much as before beside them.

    Args:
        style: the style.
        frames: how many frames the graph has.
        motions: how many motions from frame to frame the whole step would have; as many as the graph if None.
        first: phase of the first frame, 0 at the start of the step, 1 at the landing.
    """
    unit = math.sqrt(style.variance * 50.0 / (frames - 1 if motions is None else motions))
    gain = 0.0 if first else unit**2 / style.start_variance
    return StyleRequest(style.at(frames, first) / unit, unit, style.lands, gain)


def starts_likely(asked: StyleRequest, offset: Array) -> bool:
    """Whether a person who varies steps so starts one this far from the base gait, in 999 of 1000 steps.

    Args:
        asked: the style, with an edge of the start.
        offset: of the first frame from the base gait's, shape (4,) in [rad].
    """
    directions = asked.directions[0] * asked.unit
    covariance = directions @ directions.T + asked.unit**2 / asked.start_gain * np.eye(len(offset))
    return float(offset @ np.linalg.solve(covariance, offset)) <= LIKELY_START


def balance_request(motions: int, gain: float | None, support: ArrayLike | None) -> BalanceRequest:
    """What a user asks of the balance, in a step of so many motions; see `GaitGraph.balance`.

    Raises:
        InputError: where an argument is unusable.
    """
    each = balance_gain(BALANCE_GAIN, motions) if gain is None else as_number(gain, "gain", above=0.0)
    return BalanceRequest(each, None if support is None else support_of(support, "support"))


@dataclass(frozen=True)
class Lift:
    """One obstacle edge: the swing ankle over `height` at an instant, or frame, held at `hold_x`, both in [m]."""

    frame: int
    height: float
    gamma: float
    hold: float
    hold_x: float
    weight: float = 1.0  # how many frames it stands for
