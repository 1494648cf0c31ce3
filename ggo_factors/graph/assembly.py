"""The graph of one round: from a description to edges, and from edges to plain GTSAM objects."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import gtsam
import numpy as np

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
from ggo_factors.graph.inequalities import limit_edges
from ggo_factors.graph.optimizer import graph_of
from ggo_factors.graph.problem import Problem, Round
from ggo_factors.support.inputs import Array

COSTS = ("anchor", "residual", "smoothness", "knee", "limits", "obstacle", "hold", "end")
STACKED = 16
"""How many neighbouring keyframes share one factor where the graph is solved."""


@dataclass(frozen=True, eq=False)
class RoundGraph:
    """The graph of a problem in a round.

    Attributes:
        problem: the description.
        state: the round.
    """

    problem: Problem
    state: Round

    @cached_property
    def keyframes(self) -> list[int]:
        """The frames that are variables, ascending."""
        problem, state = self.problem, self.state
        keys = {0, len(problem.base) - 1} | problem.always | problem.own_frames | problem.anchors.keys()
        keys.update(end.frame for end in problem.ends)
        for instant, _ in state.lifts.edges:
            keys.update(problem.sampling.neighbours(instant))
        for limit in problem.limits:
            if limit.name in state.joined:
                keys.update(*(limit.edge(n, None).frames for n in state.joined[limit.name].weights))
        return with_neighbours(keys, len(problem.base)) if problem.smoothness else sorted(keys)

    @cached_property
    def edges(self) -> list[tuple[str, Edge]]:
        """Every edge with the family that its cost counts to."""
        problem, state = self.problem, self.state
        made = [("anchor", anchor_edge(n, frame)) for n, frame in problem.anchors.items()]
        made += [("residual", edge) for edge in motion_edges(problem.base, self.keyframes, problem.smoothness)]
        if problem.start is not None:
            start = problem.start
            made.append(("smoothness", rate_edge(problem.base, start.drift, problem.smoothness, start.given)))
        for limit in problem.limits:
            weights = state.joined[limit.name].weights if limit.name in state.joined else {}
            if limit.name == "knee" and not problem.hard:
                weights = {n: weights.get(n, 1.0) for n in self.keyframes if n not in problem.anchors}
            made += [(limit.family, edge) for edge in limit_edges(limit, weights, problem.hard, state.shifts)]
        for (_, source), lift in state.lifts.edges.items():
            name = source if isinstance(source, str) else f"obstacle {source}"
            edges = lift.edges(problem.model, name, problem.hard, state.shifts, problem.sampling.weight)
            made += [("obstacle", problem.sampling.edge(edge)) for edge in edges]
        for number, end in enumerate(problem.ends):
            made += [("end", edge) for edge in end.edges(problem.model, number, state.shifts)]
        return made

    @cached_property
    def variable_edges(self) -> list[Edge]:
        """The edges on what is variable where the graph is solved."""
        fixed = self.problem.fixed
        return [without_constants(edge, fixed) for _, edge in self.edges if not fixed.keys() >= set(edge.frames)]

    def plain(self) -> gtsam.NonlinearFactorGraph:
        """A factor for each edge."""
        return graph_of([*(edge.factor() for _, edge in self.edges), *self.problem.own])

    def solved(self) -> gtsam.NonlinearFactorGraph:
        """The same sum of squares in few factors, the anchored frames constant.

        The soft edges of neighbouring keyframes are one factor.
        """
        stacks: dict[int, list[Edge]] = {}
        place = {n: k // STACKED for k, n in enumerate(self.keyframes)}
        for edge in self.variable_edges:
            if not math.isinf(edge.gain):
                stacks.setdefault(place[edge.frames[-1]], []).append(edge)
        hard = [edge.factor() for edge in self.variable_edges if math.isinf(edge.gain)]
        soft = [stacked_factor(stack, self.problem.fixed) for stack in stacks.values()]
        return graph_of([*hard, *soft, *self.problem.own])

    def values(self, without: Collection[int] = ()) -> gtsam.Values:
        """The keyframes as GTSAM values."""
        values = gtsam.Values()
        for n in self.keyframes:
            if n not in without:
                values.insert(frame_key(n), self.state.frames[n])
        return values

    def filled(self, values: gtsam.Values) -> Array:
        """All frames, (m, 4) in [rad], of the keyframes in GTSAM values."""
        fixed = self.problem.fixed
        at = [fixed[n] if n in fixed else values.atVector(frame_key(n)) for n in self.keyframes]
        return fill_frames(self.problem.base, self.keyframes, np.array(at), self.problem.smoothness)

    def costs(self) -> dict[str, float]:
        """Half sums of squares by family, at the frames of the round.

        The second row of an obstacle edge counts as `hold`, what the second-order edges cost as `smoothness`; a
        constraint costs nothing, it is kept or the gait is not converged.
        """
        problem, frames = self.problem, self.state.frames
        offsets = frames - problem.base
        costs = dict.fromkeys(COSTS, 0.0)
        costs["residual"] = 0.5 * float((np.diff(offsets, axis=0) ** 2).sum())
        costs["smoothness"] = 0.5 * problem.smoothness * float((np.diff(offsets, n=2, axis=0) ** 2).sum())
        for family, edge in self.edges:
            if family == "residual" or math.isinf(edge.gain) or edge.constraint:
                continue
            halves = 0.5 * edge.gain * edge.errors(frames) ** 2
            if family == "obstacle":
                costs["obstacle"] += float(halves[0])
                costs["hold"] += float(halves[1:].sum())
            else:
                costs[family] += float(halves.sum())
        if problem.own:
            costs["user"] = float(graph_of(problem.own).error(self.values()))
        return costs
