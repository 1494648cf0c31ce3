"""The graph of one round: from a description to edges, and from edges to plain GTSAM objects."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import repeat

import gtsam
import numpy as np

from ggo_factors.errors import GraphError
from ggo_factors.factors import (
    STYLE_KEY,
    Edge,
    anchor_edge,
    balance_edges,
    clear_edge,
    fill_frames,
    fill_spans,
    foothold_edge,
    frame_key,
    motion_edges,
    obstacle_edge,
    pose_edge,
    shank_edge,
    stacked_factor,
    style_anchor,
    with_neighbours,
    without_constants,
)
from ggo_factors.graph.inequalities import Inequality, Joined, inequalities_of, inequality_edges
from ggo_factors.graph.judge import common_offset_is_free
from ggo_factors.graph.lifting import Lifts
from ggo_factors.graph.optimizer import graph_of
from ggo_factors.graph.problem import EdgeKey, Problem
from ggo_factors.graph.requests import HARD_GAIN, BalanceRequest, EndRequest, Lift
from ggo_factors.graph.sampling import Sampling
from ggo_factors.graph.varied import first_rate_edge, start_edges, varied_edges, varied_landing
from ggo_factors.motion.zero_moment import held_points, start_shift
from ggo_factors.support.inputs import Array

COSTS = ("anchor", "residual", "smoothness", "knee", "limits", "obstacle", "hold", "end", "landing", "balance")
"""Families of edges whose costs are told; `style` and `user` besides, where there are such edges."""
STACKED = 16
"""How many neighbouring keyframes share one factor where the graph is solved: a callback costs more than an edge."""
NOWHERE = 1e6
"""A height in [m] that nothing reaches."""
NO_SHIFT = np.zeros(4)


@dataclass(frozen=True, eq=False)
class Round:
    """What a round adds to the edges that were asked for, and its frames.

    Attributes:
        frames: the frames that it starts from, or that it ended with, shape (m, 4) in [rad].
        lifts: the obstacle edges.
        joined: the frames that got an edge because they broke an inequality, by its name.
        shifts: by how much each constraint aims past its target, by name.
        style: the style variable, shape (k,); None where the problem has no style.
        style_gain: gain of its prior.
        style_held: whether it is held where it is.
    """

    frames: Array
    lifts: Lifts = field(default_factory=Lifts)
    joined: dict[str, Joined] = field(default_factory=dict)
    shifts: dict[str, Array] = field(default_factory=dict)
    style: Array | None = None
    style_gain: float = 1.0
    style_held: bool = False


@dataclass(frozen=True, eq=False)
class Assembly:
    """The graph of a problem in a round.

    Attributes:
        problem: the description.
        inequalities: what gets an edge where a solve breaks it; the knees' are on every keyframe.
        sampling: the instants that the rounds look at and lift, or None where they are the frames.
        fixed: the anchored frames that are no variable where the graph is solved: those that no factor of a user's has.
        state: the round.
    """

    problem: Problem
    inequalities: tuple[Inequality, ...]
    sampling: Sampling | None
    fixed: Mapping[int, Array]
    state: Round

    @cached_property
    def keyframes(self) -> list[int]:
        """The frames that are variables, ascending."""
        problem, state = self.problem, self.state
        keys = {0, len(problem.base) - 1} | problem.always | problem.own_frames | problem.anchors.keys()
        for end in problem.ends:
            keys.add(end.frame)
        if problem.landing is not None:
            keys.update((len(problem.base) - 2, len(problem.base) - 1))
        if problem.balance is not None:
            return list(range(len(problem.base)))  # the ZMP does not interpolate
        for instant, _ in state.lifts.edges:
            keys.update((instant,) if self.sampling is None else self.sampling.neighbours(instant))
        for inequality in self.inequalities:
            if inequality.name in state.joined:
                for n in state.joined[inequality.name].weights:
                    keys.update(inequality.edge(n, None).frames)
        return with_neighbours(keys, len(problem.base)) if problem.smoothness else sorted(keys)

    @cached_property
    def free_edges(self) -> list[tuple[str, Edge]]:
        """Every edge that is no anchor, with the family that its cost counts to."""
        made = self._made_edges(self.state.style_held)
        if not self.problem.removed:
            return made
        return [(key.family, edge) for key, edge in _kept(made, self.problem.removed)]

    def _made_edges(self, style_held: bool) -> list[tuple[str, Edge]]:
        """Every edge that is no anchor, and those that the user took out."""
        problem, state, base = self.problem, self.state, self.problem.base.frames
        held = state.style if style_held else None
        if problem.style is not None:
            made = varied_edges(problem, problem.style, self.keyframes, state.style_gain, held)
        else:
            made = list(zip(repeat("residual"), motion_edges(base, self.keyframes, problem.smoothness)))
            if problem.start is not None:
                made.append(("smoothness", first_rate_edge(problem, problem.start)))
        for inequality in self.inequalities:
            weights = state.joined[inequality.name].weights if inequality.name in state.joined else {}
            if inequality.name == "knee" and not problem.hard:
                # Every keyframe has one.
                weights = dict.fromkeys(self.keyframes, 1.0) | weights
                for n in problem.anchors:
                    weights.pop(n, None)
            for edge in inequality_edges(inequality, weights, problem.hard, state.shifts):
                made.append((inequality.family, edge))
        for (_, source), lift in state.lifts.edges.items():
            for edge in self._lift_edges(lift, source):
                made.append(("obstacle", edge if self.sampling is None else self.sampling.edge(edge)))
        for number, end in enumerate(problem.ends):
            for edge in self._end_edges(end, number):
                made.append(("end", edge))
        if problem.landing is not None:
            made += zip(repeat("landing"), varied_landing(problem, problem.landing, held))
        if problem.balance is not None:
            made += zip(repeat("balance"), self._balance_edges(problem.balance))
        return made

    @property
    def edges(self) -> list[tuple[str, Edge]]:
        """Every edge with the family that its cost counts to."""
        return [(key.family, edge) for key, edge in self.keyed_edges]

    @property
    def keyed_edges(self) -> list[tuple[EdgeKey, Edge]]:
        """Every edge with what tells it from all others."""
        made = [("anchor", anchor_edge(n, frame)) for n, frame in self.problem.anchors.items()]
        if self.problem.style is not None and self.state.style is not None and self.state.style_held:
            made.append(("style", style_anchor(self.state.style)))
        return list(_kept([*made, *self._made_edges(style_held=False)], self.problem.removed))

    @cached_property
    def variable_edges(self) -> list[Edge]:
        """The edges on what is variable where the graph is solved."""
        fixed, made = self.fixed, []
        if len(fixed) < len(self.problem.anchors):
            made += [anchor_edge(n, frame) for n, frame in self.problem.anchors.items() if n not in fixed]
        for _, edge in self.free_edges:
            if edge.style is not None or not fixed.keys() >= set(edge.frames):
                made.append(edge if self.sampling is None else without_constants(edge, fixed))
        return made

    def plain(self) -> gtsam.NonlinearFactorGraph:
        """A factor for each edge."""
        return graph_of([*(edge.factor() for _, edge in self.edges), *self.problem.own])

    def solved(self) -> gtsam.NonlinearFactorGraph:
        """The same sum of squares in few factors, the anchored frames constant.

        The soft edges of neighbouring keyframes are one factor.
        """
        stacks: dict[int, list[Edge]] = {}
        place, hard = {}, []
        for k, n in enumerate(self.keyframes):
            place[n] = k // STACKED
        for edge in self.variable_edges:
            if math.isinf(edge.gain):
                hard.append(edge.factor())
            else:
                stacks.setdefault(place[edge.frames[-1] if edge.frames else 0], []).append(edge)
        for stack in stacks.values():
            size = 0 if self.problem.style is None else max(0 if e.style is None else e.style.shape[1] for e in stack)
            hard.append(stacked_factor(stack, self.fixed, size))
        graph = gtsam.NonlinearFactorGraph()
        for factor in (*hard, *self.problem.own):
            graph.add(factor)
        return graph

    def values(self, without: Collection[int] = ()) -> gtsam.Values:
        """The keyframes as GTSAM values."""
        values = gtsam.Values()
        for n in self.keyframes:
            if n not in without:
                values.insert(frame_key(n), self.state.frames[n])
        if self.state.style is not None:
            values.insert(STYLE_KEY, self.state.style)
        return values

    def filled(self, values: gtsam.Values) -> Round:
        """The round with all frames, (m, 4) in [rad], of the keyframes in GTSAM values, and their style variable."""
        at, base, style = [], self.problem.base.frames, self.state.style
        for n in self.keyframes:
            at.append(self.fixed[n] if n in self.fixed else values.atVector(frame_key(n)))
        if self.problem.style is not None:
            style = style if style is not None and self.state.style_held else values.atVector(STYLE_KEY)
            base = base + self.problem.style.directions @ style
        frames = fill_frames(base, self.keyframes, np.array(at), self.problem.smoothness)
        return replace(self.state, frames=frames, style=style)

    def costs(self) -> dict[str, float]:
        """Half sums of squares by family, at the frames of the round.

        The second row of an obstacle edge counts as `hold`, what the second-order edges cost as `smoothness`; a
        constraint costs nothing, it is kept or the gait is not converged.
        """
        problem, frames = self.problem, self.state.frames
        offsets = frames - problem.base.frames
        costs = dict.fromkeys(COSTS, 0.0)
        if problem.style is not None and self.state.style is not None:
            offsets -= problem.style.directions @ self.state.style
            costs["style"] = 0.5 * self.state.style_gain * float((np.square(self.state.style)).sum())
            for edge in start_edges(problem, problem.style):
                costs["style"] += 0.5 * edge.gain * float(np.square(edge.errors(frames, self.state.style)).sum())
        costs["residual"] = 0.5 * float((np.diff(offsets, axis=0) ** 2).sum())
        costs["smoothness"] = 0.5 * problem.smoothness * float((np.diff(offsets, n=2, axis=0) ** 2).sum())
        told = {"residual", "style"}
        if any(key.family == "residual" for key in problem.removed):
            # What is left of the chain counts edge by edge, and first and second order as one.
            costs["residual"], costs["smoothness"] = 0.0, 0.0
            told.remove("residual")
        for family, edge in self.free_edges:
            if family in told or math.isinf(edge.gain) or edge.constraint:
                continue
            halves = 0.5 * edge.gain * edge.errors(frames, self.state.style) ** 2
            if family == "obstacle":
                costs["obstacle"] += float(halves[0])
                costs["hold"] += float(halves[1:].sum())
            else:
                costs[family] += float(halves.sum())
        if problem.own:
            costs["user"] = float(graph_of(problem.own).error(self.values()))
        return costs

    def _lift_edges(self, lift: Lift, source: int | str) -> list[Edge]:
        """The edges of a lift, on its instant: one, or where obstacles are constraints that and a hold."""
        model, n = self.problem.model, lift.frame
        gain = lift.weight * (1.0 if self.sampling is None else self.sampling.weight)
        how = {"gamma": lift.gamma, "hold": lift.hold, "hold_x": lift.hold_x, "gain": gain}
        if not self.problem.hard:
            return [obstacle_edge(n, model, lift.height, **how)]
        over = source if isinstance(source, str) else f"obstacle {source}"
        name = f"clearance over {over} at frame {n}"
        height = lift.height + float(self.state.shifts.get(name, NO_SHIFT)[0])
        clear = clear_edge(n, model, height, HARD_GAIN).counting(HARD_GAIN, name)
        return [clear, obstacle_edge(n, model, -NOWHERE, **how)] if lift.hold else [clear]

    def _balance_edges(self, asked: BalanceRequest) -> list[Edge]:
        """The edges of all inner frames."""
        model, base, dt = self.problem.model, self.problem.base.frames, self.problem.base.dt
        if asked.support is not None or len(base) < 3:
            places = np.tile(asked.support or (0.0, 0.0), (len(base) - 2, 1))
        else:
            shift = asked.shift
            if shift is None:
                shift = start_shift(model, base, dt, self.problem.anchors.get(0, base[0]))
            places = np.repeat(held_points(model, base, dt, shift, asked.since)[:, None], 2, axis=1)
        return balance_edges(model, dt, asked.gain, places)

    def _end_edges(self, end: EndRequest, number: int) -> list[Edge]:
        """An edge for each target of an end edge; that of a constraint is shifted."""
        hard = math.isinf(end.gain)
        gain = HARD_GAIN if hard else end.gain
        made: list[Edge] = []
        for target, wanted in (("foothold", end.foothold), ("shank angle", end.shank_angle), ("pose", end.pose)):
            if wanted is None:
                continue
            name = f"{target} of end edge {number}" if hard else None
            aim = wanted if name is None else np.asarray(wanted) - _shift_of(self.state.shifts, name, np.size(wanted))
            if target == "foothold":
                x, y = np.asarray(aim).tolist()
                edge = foothold_edge(end.frame, self.problem.model, (x, y), gain)
            elif target == "shank angle":
                edge = shank_edge(end.frame, float(np.squeeze(aim)), gain)
            else:
                edge = pose_edge(end.frame, np.asarray(aim), gain)
            made.append(edge if name is None else edge.counting(gain, name))
        return made


def _kept(made: Sequence[tuple[str, Edge]], removed: Collection[EdgeKey]) -> Iterator[tuple[EdgeKey, Edge]]:
    """The edges that were not removed, with their keys."""
    seen = Counter[tuple[str, str, tuple[int, ...]]]()
    for family, edge in made:
        alike = family, edge.name, edge.frames
        key = EdgeKey(*alike, seen[alike])
        seen[alike] += 1
        if key not in removed and not any(_is_part(key, other) for other in removed):
            yield key, edge


def _is_part(key: EdgeKey, removed: EdgeKey) -> bool:
    """Whether a residual edge is a part of a removed span, into which a later round put a keyframe."""
    if not key.family == removed.family == "residual":
        return False
    span, frames = removed.frames, key.frames
    if len(span) == 4:  # p - 1, p, q, q + 1: edges of first order from p to q, of second order centred there
        return (
            span[1] <= frames[0] and frames[-1] <= span[2]
            if len(frames) == 2
            else (span[0] <= frames[0] and frames[-1] <= span[3])
        )
    return len(span) == len(frames) == 2 and span[0] <= frames[0] and frames[-1] <= span[1]


def _shift_of(shifts: Mapping[str, Array], name: str, count: int) -> Array:
    """By how much a constraint aims past its target, shape (count,)."""
    return shifts[name][:count] if name in shifts else NO_SHIFT[:count]


def first_assembly(problem: Problem, initial: Array | None = None) -> Assembly:
    """The graph of the first round.

    Args:
        problem: the description.
        initial: frames to start from, shape (m, 4) in [rad]; if None the base gait moved to the anchors, its offset
            fading out.
    """
    # The offset from the base gait fades out to the last frame.
    base, anchors, last = problem.base.frames, problem.anchors, len(problem.base) - 1
    first = min(anchors, default=last)
    known = {0: base[0] + anchors.get(first, base[first]) - base[first], last: base[last], **anchors}
    keys = sorted(known)
    unbent = fill_spans(base, keys, np.array(list(map(known.__getitem__, keys))))
    frames = unbent
    if initial is not None:
        frames = initial.copy()
        for n, frame in problem.anchors.items():
            frames[n] = frame
    sampling = None if problem.fine is problem.base else Sampling(problem.base.frames, problem.fine.frames)
    style = None if problem.style is None else np.zeros(problem.style.directions.shape[2])
    state = Round(frames, style=style)
    for request in problem.obstacles:
        if request.frames is not None:
            path = problem.model.endpoint(problem.base.frames)
            given = Lifts().with_given(problem.obstacles, problem.model.foot, path, problem.anchors)
            state = Round(frames, given, style=style)
            break
    fixed = dict(anchors)
    for n in problem.own_frames:
        fixed.pop(n, None)
    return Assembly(problem, inequalities_of(problem, unbent), sampling, fixed, state)


def require_anchored(graph: Assembly) -> None:
    """Refuse a graph in which a common offset of all frames is free.

    Raises:
        GraphError: where it is.
    """
    if graph.problem.anchors:
        return
    holding = [*(edge.factor() for family, edge in graph.edges if family == "end"), *graph.problem.own]
    if common_offset_is_free(holding, graph.values()):
        raise GraphError("frame 0 is not anchored")
