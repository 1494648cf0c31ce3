"""What a gait graph consists of in one round: from a description to edges, and from edges to plain GTSAM objects."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import gtsam
import numpy as np
from numpy.typing import NDArray

from ggo_factors.active import Joined, Limit, limit_edges
from ggo_factors.arrays import Array
from ggo_factors.crossing import Lifts
from ggo_factors.edges import EndEdge, GroundEdges, ObstacleEdges
from ggo_factors.factors import (
    Edge,
    anchor_edge,
    fill_frames,
    frame_key,
    motion_edges,
    rate_edge,
    stacked_factor,
    with_neighbours,
    without_constants,
)
from ggo_factors.model import LegModel
from ggo_factors.sampling import Sampling
from ggo_factors.solve import graph_of

COSTS = ("anchor", "residual", "smoothness", "knee", "limits", "obstacle", "hold", "end")
STACKED = 16
"""How many neighbouring keyframes share one factor where the graph is solved."""
FINEST = 100
"""Above this many frame-to-frame motions the edges that the rounds choose stand for several frames each."""


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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
        drift: what the offset from the base gait changes by from one frame to the next at the start, shape (4,) in
            [rad]; None leaves it free.
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
    drift: Array | None
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
            offsets = {n: frame - self.base[n] for n, frame in self.anchors.items()}
            offsets.setdefault(len(self.base) - 1, np.zeros(4))
            known = sorted(offsets)
            every = np.arange(len(self.base))
            shift = np.stack([np.interp(every, known, [offsets[n][c] for n in known]) for c in range(4)], -1)
            frames = self.base + shift
        else:
            frames = initial.copy()
        for n, frame in self.anchors.items():
            frames[n] = frame
        if all(edges.frames is None for edges in self.obstacles):
            return Round(frames)
        path = self.model.endpoint(self.base)
        return Round(frames, Lifts().with_given(self.obstacles, self.model.foot, path, self.anchors))

    def keyframes(self, state: Round) -> list[int]:
        """The frames that are variables, ascending."""
        keys = {0, len(self.base) - 1} | self.always | self.own_frames | self.anchors.keys()
        keys |= {end.frame for end in self.ends}
        for instant, _ in state.lifts.edges:
            keys.update(self.sampling.neighbours(instant))
        for limit in self.limits:
            if limit.name in state.joined:
                keys.update(*(limit.edge(n, None).frames for n in state.joined[limit.name].weights))
        return with_neighbours(keys, len(self.base)) if self.smoothness else sorted(keys)

    def edges(self, state: Round) -> list[tuple[str, Edge]]:
        """Every edge with the family that its cost counts to."""
        keys = self.keyframes(state)
        made = [("anchor", anchor_edge(n, frame)) for n, frame in self.anchors.items()]
        made += [("residual", edge) for edge in motion_edges(self.base, keys, self.smoothness)]
        if self.drift is not None:
            made.append(("smoothness", rate_edge(self.base, self.drift, self.smoothness)))
        for limit in self.limits:
            weights = state.joined[limit.name].weights if limit.name in state.joined else {}
            if limit.name == "knee" and not self.hard:
                weights = {n: weights.get(n, 1.0) for n in keys if n not in self.anchors}
            made += [(limit.family, edge) for edge in limit_edges(limit, weights, self.hard, state.shifts)]
        for (_, source), lift in state.lifts.edges.items():
            name = source if isinstance(source, str) else f"obstacle {source}"
            edges = lift.edges(self.model, name, self.hard, state.shifts, self.sampling.weight)
            made += [("obstacle", self.sampling.edge(edge)) for edge in edges]
        for number, end in enumerate(self.ends):
            made += [("end", edge) for edge in end.edges(self.model, number, state.shifts)]
        return made

    def plain_graph(self, state: Round) -> gtsam.NonlinearFactorGraph:
        """A factor for each edge."""
        return graph_of([*(edge.factor() for _, edge in self.edges(state)), *self.own])

    def solved_graph(self, state: Round) -> tuple[gtsam.NonlinearFactorGraph, list[Edge]]:
        """The same sum of squares in few factors, the anchored frames constant; and the edges on what is variable.

        The soft edges of neighbouring keyframes are one factor.
        """
        stacks: dict[int, list[Edge]] = {}
        place = {n: k // STACKED for k, n in enumerate(self.keyframes(state))}
        every = (edge for _, edge in self.edges(state) if not self.fixed.keys() >= set(edge.frames))
        edges = [without_constants(edge, self.fixed) for edge in every]
        for edge in edges:
            if not math.isinf(edge.gain):
                stacks.setdefault(place[edge.frames[-1]], []).append(edge)
        hard = [edge.factor() for edge in edges if math.isinf(edge.gain)]
        soft = [stacked_factor(stack, self.fixed) for stack in stacks.values()]
        return graph_of([*hard, *soft, *self.own]), edges

    def values(self, state: Round, without: Collection[int] = ()) -> gtsam.Values:
        """The keyframes of a round as GTSAM values."""
        values = gtsam.Values()
        for n in self.keyframes(state):
            if n not in without:
                values.insert(frame_key(n), state.frames[n])
        return values

    def filled(self, state: Round, values: gtsam.Values) -> Array:
        """All frames, of the keyframes in GTSAM values."""
        keys = self.keyframes(state)
        at = [self.fixed[n] if n in self.fixed else values.atVector(frame_key(n)) for n in keys]
        return fill_frames(self.base, keys, np.stack(at), self.smoothness)

    def costs(self, state: Round) -> dict[str, float]:
        """Half sums of squares by family, at the frames of a round.

        The second row of an obstacle edge counts as `hold`, what the second-order edges cost as `smoothness`; a
        constraint costs nothing, it is kept or the gait is not converged.
        """
        offsets = state.frames - self.base
        costs = dict.fromkeys(COSTS, 0.0)
        costs["residual"] = 0.5 * float((np.diff(offsets, axis=0) ** 2).sum())
        costs["smoothness"] = 0.5 * self.smoothness * float((np.diff(offsets, n=2, axis=0) ** 2).sum())
        for family, edge in self.edges(state):
            if family == "residual" or math.isinf(edge.gain) or edge.constraint:
                continue
            halves = 0.5 * edge.gain * edge.errors(state.frames) ** 2
            if family == "obstacle":
                costs["obstacle"] += float(halves[0])
                costs["hold"] += float(halves[1:].sum())
            else:
                costs[family] += float(halves.sum())
        if self.own:
            costs["user"] = float(graph_of(self.own).error(self.values(state)))
        return costs
