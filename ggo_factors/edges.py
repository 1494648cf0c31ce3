"""What a user asks of a gait graph, edge by edge, and the factors made of it."""

from __future__ import annotations

from dataclasses import dataclass

import gtsam

from ggo_factors.arrays import Array
from ggo_factors.factors import foothold_factor, obstacle_factor, pose_factor, shank_factor
from ggo_factors.model import LegModel
from ggo_factors.terrain import Ground, Obstacle


@dataclass(frozen=True)
class ObstacleEdges:
    """A box to clear; `frames` None leaves it to the rounds which frames get an edge."""

    obstacle: Obstacle
    frames: tuple[int, ...] | None
    hold: float
    gamma: float
    margin: float


@dataclass(frozen=True)
class GroundEdges:
    """The ground to stay above; the rounds choose the frames."""

    ground: Ground
    hold: float
    gamma: float
    margin: float


@dataclass(frozen=True)
class Lift:
    """One obstacle edge: P of `frame` over `height`, held at `hold_x`, both in [m]."""

    frame: int
    height: float
    gamma: float
    hold: float
    hold_x: float
    weight: float = 1.0  # how many frames it stands for

    def factor(self, model: LegModel) -> gtsam.CustomFactor:
        """The edge as a factor."""
        return obstacle_factor(
            self.frame,
            model,
            self.height,
            gamma=self.gamma,
            hold=self.hold,
            hold_x=self.hold_x,
            gain=self.weight,
        )


@dataclass(frozen=True)
class EndEdge:
    """Targets of one frame: foothold, angle of the shank, whole pose; None where there is none."""

    frame: int
    foothold: tuple[float, float] | None
    shank_angle: float | None
    pose: Array | None
    gain: float

    def factors(self, model: LegModel) -> list[gtsam.CustomFactor]:
        """A factor for each target."""
        made = []
        if self.foothold is not None:
            made.append(foothold_factor(self.frame, model, self.foothold, self.gain))
        if self.shank_angle is not None:
            made.append(shank_factor(self.frame, self.shank_angle, self.gain))
        if self.pose is not None:
            made.append(pose_factor(self.frame, self.pose, self.gain))
        return made
