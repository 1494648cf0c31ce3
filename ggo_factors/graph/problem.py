"""The description of a gait graph, and what a round of solving it adds to that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import gtsam
import numpy as np
from numpy.typing import NDArray

from ggo_factors.factors import fill_spans
from ggo_factors.graph.inequalities import Joined, Limit
from ggo_factors.graph.lifting import Lifts
from ggo_factors.graph.requests import EndEdge, GroundEdges, ObstacleEdges, StartEdge
from ggo_factors.graph.sampling import Sampling
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

FINEST = 100
"""Above this many frame-to-frame motions the edges that the rounds choose stand for several frames each."""


@dataclass(frozen=True, eq=False)
class Round:
    """What one solve of the graph consists of beside the edges that the user gave.

    Attributes:
        frames: where it starts, or where it ended, (m, 4) in [rad].
        lifts: the obstacle edges.
        joined: the frames that got an edge since they broke a limit, by the limit's name.
        shifts: by how much each constraint aims past its target, by name.
    """

    frames: Array
    lifts: Lifts = field(default_factory=Lifts)
    joined: dict[str, Joined] = field(default_factory=dict)
    shifts: dict[str, Array] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Problem:
    """The description of a gait graph, as the user gave it.

    Attributes:
        base: frames of the base gait in [rad], shape (m, 4).
        fine: the same at the instants that the rounds look at and lift, shape (k, 4), k at least m.
        model: the legs.
        limits: what gets an edge where a solve breaks it; the knees' are on every keyframe.
        hard: whether those limits and the obstacles are constraints.
        smoothness: gain of the second-order residual edges.
        always: frames that are keyframes in any case.
        full: whether those are all.
        anchors: anchored frames in [rad], by number.
        start: the edge of the motion to begin with, or None.
        obstacles: the obstacles' edges.
        ground: the ground's edges.
        ends: the end edges.
        own: factors of the user's own.
        own_frames: the frames that those connect.
    """

    base: Array
    fine: Array
    model: LegModel
    limits: tuple[Limit, ...]
    hard: bool
    smoothness: float
    always: frozenset[int]
    full: bool
    anchors: Mapping[int, Array]
    start: StartEdge | None
    obstacles: tuple[ObstacleEdges, ...]
    ground: GroundEdges | None
    ends: tuple[EndEdge, ...]
    own: tuple[gtsam.NonlinearFactor, ...]
    own_frames: frozenset[int]

    @cached_property
    def fixed(self) -> dict[int, Array]:
        """The anchored frames that are no variable where the graph is solved: those that no factor of a user's has."""
        return {n: frame for n, frame in self.anchors.items() if n not in self.own_frames}

    @cached_property
    def chooses_frames(self) -> bool:
        """Whether the rounds choose frames over an obstacle or the ground."""
        return any(edges.frames is None for edges in self.obstacles) or self.ground is not None

    @cached_property
    def sampling(self) -> Sampling:
        """The instants that the rounds look at and lift."""
        return Sampling(self.base, self.fine)

    @cached_property
    def spacing(self) -> int:
        """How many frames one edge that the rounds choose may stand for; 1 where the user chose the frames."""
        return self._spacing(len(self.base))

    @cached_property
    def lift_spacing(self) -> int:
        """How many instants one obstacle edge that the rounds choose may stand for."""
        return self._spacing(len(self.fine))

    def _spacing(self, count: int) -> int:
        chosen = self.chooses_frames and all(edges.frames is None for edges in self.obstacles)
        return -(-(count - 1) // FINEST) if chosen and not self.full and not self.hard else 1

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Whether each instant cannot be lifted: where it cannot move, or a constraint says where it goes."""
        given = set(self.anchors) | {end.frame for end in self.ends if self.hard and end.foothold is not None}
        return self.sampling.held(given)

    def path(self, frames: Array) -> Array:
        """The path of P at the instants that the rounds look at in [m], shape (k, 2), of frames (m, 4) in [rad]."""
        return self.model.endpoint(self.sampling.frames(frames))

    def first_round(self, initial: Array | None = None) -> Round:
        """The start: frames that were given, or the base gait moved to the anchors, its offset fading out.

        Args:
            initial: frames to start from, shape (m, 4) in [rad].
        """
        if initial is None:
            frames = moved_to(self.anchors, self.base)
        else:
            frames = initial.copy()
            for n, frame in self.anchors.items():
                frames[n] = frame
        if all(edges.frames is None for edges in self.obstacles):
            return Round(frames)
        path = self.model.endpoint(self.base)
        return Round(frames, Lifts().with_given(self.obstacles, self.model.foot, path, self.anchors))


def moved_to(anchors: Mapping[int, Array], base: Array) -> Array:
    """A base gait, (m, 4) in [rad], moved to the frames that are anchored, its offset fading out to the last one."""
    first = min(anchors, default=len(base) - 1)
    known = {0: base[0] + anchors.get(first, base[first]) - base[first], len(base) - 1: base[-1], **anchors}
    keys = sorted(known)
    return fill_spans(base, keys, np.array([known[n] for n in keys]))
