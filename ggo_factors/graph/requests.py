"""What a user asks of a gait graph, edge by edge, and the edges of the graph made of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ggo_factors.factors import Edge, clear_edge, foothold_edge, obstacle_edge, pose_edge, shank_edge
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Ground, Obstacle
from ggo_factors.support.inputs import Array

HARD_GAIN = 1e4
"""Gain of the edge that a constraint is solved by, its target moved until it is met (augmented Lagrangian)."""
HARD_TOLERANCE = 1e-6
"""How far a constraint may be missed, in its own unit."""
NOWHERE = 1e6
"""A height in [m] that nothing reaches."""
NO_SHIFT = np.zeros(4)


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
    """One obstacle edge: P of `frame`, or at an instant between two, over `height`, held at `hold_x`, both in [m]."""

    frame: int
    height: float
    gamma: float
    hold: float
    hold_x: float
    weight: float = 1.0  # how many frames it stands for

    def edges(
        self, model: LegModel, source: int | str, hard: bool, shifts: Mapping[str, Array], share: float = 1.0
    ) -> list[Edge]:
        """The edges of the graph: one, or a constraint and a hold.

        Args:
            model: the legs.
            source: what asked for it: tells its constraint from that of another at the same frame.
            hard: whether the height is a constraint.
            shifts: by how much constraints aim past their targets, by name.
            share: how many frames of the graph an instant stands for.
        """
        if not hard:
            return [self._edge(model, self.height, share)]
        name = f"clearance over {source} at frame {self.frame}"
        height = self.height + float(shifts.get(name, NO_SHIFT)[0])
        clear = replace(clear_edge(self.frame, model, height, HARD_GAIN), constraint=name)
        return [clear, self._edge(model, -NOWHERE, share)] if self.hold else [clear]

    def _edge(self, model: LegModel, height: float, share: float) -> Edge:
        return obstacle_edge(
            self.frame,
            model,
            height,
            gamma=self.gamma,
            hold=self.hold,
            hold_x=self.hold_x,
            gain=self.weight * share,
        )


@dataclass(frozen=True, eq=False)
class StartEdge:
    """The motion to begin with: what the offset changes by from a frame to the next, and the share that is given."""

    drift: Array
    given: float


@dataclass(frozen=True, eq=False)
class EndEdge:
    """Targets of one frame: foothold, angle of the shank, whole pose; None where there is none."""

    frame: int
    foothold: tuple[float, float] | None
    shank_angle: float | None
    pose: Array | None
    gain: float

    def edges(self, model: LegModel, number: int, shifts: Mapping[str, Array]) -> list[Edge]:
        """An edge of the graph for each target; that of a constraint is shifted.

        Args:
            model: the legs.
            number: tells the constraints of this end edge from those of another.
            shifts: by how much constraints aim past their targets, by name.
        """
        made: list[Edge] = []
        for target in ("foothold", "shank angle", "pose"):
            name = f"{target} of end edge {number}" if math.isinf(self.gain) else None
            edge = self._edge(model, target, shifts.get(name, NO_SHIFT) if name else NO_SHIFT)
            if edge is not None:
                made.append(edge.counting(edge.gain, name))
        return made

    def _edge(self, model: LegModel, target: str, shift: Array) -> Edge | None:
        gain = HARD_GAIN if math.isinf(self.gain) else self.gain
        if target == "foothold" and self.foothold is not None:
            x, y = self.foothold[0] - shift[0], self.foothold[1] - shift[1]
            return foothold_edge(self.frame, model, (float(x), float(y)), gain)
        if target == "shank angle" and self.shank_angle is not None:
            return shank_edge(self.frame, self.shank_angle - float(shift[0]), gain)
        if target == "pose" and self.pose is not None:
            return pose_edge(self.frame, self.pose - shift, gain)
        return None
