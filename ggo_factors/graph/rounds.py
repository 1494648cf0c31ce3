"""Rounds: solve the graph, see which frames still break a limit, give them an edge, solve again.

Frames join and never leave, so the rounds end.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import gtsam
import numpy as np

from ggo_factors.graph.assembly import RoundGraph
from ggo_factors.graph.inequalities import Joined, broken
from ggo_factors.graph.lifting import Lifts, wishes
from ggo_factors.graph.optimizer import Outcome, descend, judged
from ggo_factors.graph.problem import Problem, Round
from ggo_factors.graph.requests import HARD_TOLERANCE
from ggo_factors.support.inputs import Array

IN_VAIN = 5
"""So many shifts of the constraints that do not halve what is missed show that they contradict each other."""


@dataclass(frozen=True)
class Solver:
    """How the graph of each round is solved.

    Attributes:
        optimizer: its name, see `solve.OPTIMIZERS`.
        max_iterations: limit of its iterations in each round.
        most_rounds: limit of rounds.
    """

    optimizer: str
    max_iterations: int
    most_rounds: int


def solve_in_rounds(problem: Problem, solver: Solver, initial: Array | None) -> tuple[Round, list[Outcome]]:
    """The last round, solved, and what each solve did; the last one judged.

    Args:
        problem: what to solve.
        solver: how.
        initial: frames to start from, shape (m, 4) in [rad]; see `Problem.first_round`.
    """
    state = problem.first_round(initial)
    if not problem.chooses_frames:
        return _joined_in_rounds(problem, solver, state, problem.path(problem.base))
    # Where the foot would pass without obstacles decides which frames pass over them, and where to hold.
    # A leg goes through what is not lifted over yet: soft edges may push it aside, constraints would contradict.
    level = problem
    if problem.hard:
        level = replace(problem, limits=tuple(limit for limit in problem.limits if not limit.of_ground))
    free, outcomes = _joined_in_rounds(level, solver, state, None)
    if outcomes[-1].reason and not outcomes[-1].converged:
        return free, outcomes
    reference = problem.path(free.frames)
    lifts = _lifted(problem, free.lifts, reference, reference, low_only=False)
    if lifts.edges == free.lifts.edges and len(level.limits) == len(problem.limits):
        return free, outcomes
    state, more = _joined_in_rounds(problem, solver, replace(free, lifts=lifts), reference)
    return state, outcomes + more


def _joined_in_rounds(
    problem: Problem, solver: Solver, state: Round, reference: Array | None
) -> tuple[Round, list[Outcome]]:
    """Solve until no frame joins any more; judge the last solve."""
    outcomes: list[Outcome] = []
    while True:
        state, outcome, graph = _minimised(problem, solver, state)
        outcomes.append(outcome)
        if outcome.reason and not outcome.converged:
            return state, outcomes  # constraints that contradict each other: no frame that joins mends that
        grown = _grown(problem, state, reference)
        if grown is None:
            outcomes[-1] = outcome if outcome.converged else judged(graph, outcome, solver.max_iterations)
            return state, outcomes
        if len(outcomes) == solver.most_rounds:
            reason = f"not converged: frames still join after {solver.most_rounds} rounds"
            outcomes[-1] = replace(outcome, converged=False, reason=reason)
            return state, outcomes
        state = grown


def _grown(problem: Problem, state: Round, reference: Array | None) -> Round | None:
    """The next round with the frames that join, or None where none does."""
    joined = dict(state.joined)
    for limit in problem.limits:
        now = broken(limit, state.frames, problem.anchors, problem.hard)
        if now.any():
            before = joined.get(limit.name, Joined({}, np.zeros(len(now), dtype=bool)))
            joined[limit.name] = before.and_broken(now, problem.spacing)
    lifts = state.lifts
    if reference is not None:
        lifts = _lifted(problem, lifts, problem.path(state.frames), reference, low_only=True)
    grown = Round(state.frames, lifts, joined, state.shifts)
    return grown if lifts.edges != state.lifts.edges or any(_reweighed(problem, state, joined)) else None


def _reweighed(problem: Problem, state: Round, joined: dict[str, Joined]) -> Iterator[bool]:
    """Whether an edge of a limit weighs other than before, for each that joined."""
    for name, now in joined.items():
        before = state.joined[name].weights if name in state.joined else {}
        new = now.weights.items() - before.items()
        if new and name == "knee" and not problem.hard:
            # Every keyframe has a knee edge of weight 1 anyway, unless knees are constraints.
            keys = set(RoundGraph(problem, state).keyframes)
            yield any(n not in keys or weight != 1.0 for n, weight in new)
        else:
            yield bool(new)


def _lifted(problem: Problem, lifts: Lifts, path: Array, hold_at: Array, low_only: bool) -> Lifts:
    """The lifts with those that a path calls for."""
    for wish in wishes(path, problem.obstacles, problem.ground, problem.model.foot, low_only):
        lifts = lifts.granting(wish, hold_at, problem.held, problem.lift_spacing)
    return lifts


def _minimised(problem: Problem, solver: Solver, state: Round) -> tuple[Round, Outcome, gtsam.NonlinearFactorGraph]:
    """The graph minimised, its constraints met by an augmented Lagrangian.

    The edge of a constraint is shifted by what it misses its target by, which is the constraint's multiplier over the
    gain, until nothing is missed.
    """
    before: tuple[float, ...] = ()
    least, vain = math.inf, 0
    while True:
        this = RoundGraph(problem, state)
        graph, edges = this.solved(), this.variable_edges
        smooth = None if any(math.isinf(edge.gain) for edge in edges) else edges
        outcome = descend(graph, this.values(problem.fixed), solver.optimizer, solver.max_iterations, smooth)
        state = replace(state, frames=this.filled(outcome.values))
        if before:
            history = before + outcome.error_history[1:]
            outcome = replace(outcome, error_history=history, iterations=len(history) - 1)
        before = outcome.error_history
        hard = {edge.constraint: edge for edge in edges if edge.constraint}
        shifts = {name: edge.errors(state.frames) for name, edge in hard.items()}
        misses = {name: float(np.abs(shift - state.shifts.get(name, 0.0)).max()) for name, shift in shifts.items()}
        worst = max(misses, key=misses.__getitem__, default="")
        missed = misses.get(worst, 0.0)
        if missed <= HARD_TOLERANCE / 10.0:
            return state, outcome, graph
        least, vain = min(missed, least), 0 if missed < least / 2.0 else vain + 1
        if vain == IN_VAIN:
            frame = hard[worst].frames[0]
            reason = f"contradicting: a hard edge at frame {frame} is missed by {missed:.3g} ({worst})"
            refused = replace(outcome, converged=False, reason=reason)
            return state, outcome if missed <= HARD_TOLERANCE else refused, graph
        state = replace(state, shifts=shifts)
