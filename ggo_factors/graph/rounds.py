"""Rounds: solve the graph, see which frames still break a limit, give them an edge, solve again.

Frames join and never leave, so the rounds end.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import gtsam
import numpy as np

from ggo_factors.errors import GgoError, GraphError
from ggo_factors.factors import STYLE_KEY, Edge, check_jacobian
from ggo_factors.factors.checked import CheckedFactor
from ggo_factors.graph.assembly import Assembly, Round, first_assembly
from ggo_factors.graph.augmented_lagrangian import Minimised, meet_constraints
from ggo_factors.graph.inequalities import Joined, broken
from ggo_factors.graph.judge import judged
from ggo_factors.graph.lifting import Lifts, demands
from ggo_factors.graph.optimizer import Outcome, descend
from ggo_factors.graph.problem import Problem
from ggo_factors.support.inputs import ANGLE_LIMIT_RAD, Array

FINEST = 100
"""Above this many frame-to-frame motions an edge that the rounds choose stands for several frames."""
MANY = 1_000_000
"""More iterations than any solve takes."""
MOST_ROUNDS = 15
"""More rounds than any gait seen here took; where frames still join after them, the gait counts as not converged."""
TOO_FAR = 1.5
"""By so many times too far the style variable may go: a round for less changes little that anyone could see."""
STRICTER = 2.5
"""The gain of the style variable's prior grows by this power of how many times too far it went: one more round is
enough, of walks from standing too, where it goes seven times too far."""

WRONG, JACOBIAN_ROUNDING = 0.01, 1e-4
"""A Jacobian that is off by more than this share of its entry, and this much more, is wrong: finite differences are
off by 1e-8 or so."""

SECONDS = 50e-6
"""Time of an iteration in [s] for each variable of a graph, and `BESIDES`, on a slow machine; 30 to 50 us were seen."""
BESIDES = 10
"""An iteration takes so many variables' time besides."""
OUT_OF_TIME = "not converged: the time for the search is over"


@dataclass(eq=False)
class Budget:
    """What may still be spent on solving.

    Attributes:
        work: iterations, each counted as often as the graph has variables and `BESIDES`.
        until: when to stop, by `time.perf_counter`, in [s].
        tried: what it was spent on.
    """

    work: float = math.inf
    until: float = math.inf
    tried: list[str] = field(default_factory=list)

    def iterations(self, variables: int) -> int:
        """How many iterations there is time for, 0 or more."""
        left = self.work
        if self.until < math.inf:
            left = min(left, (self.until - time.perf_counter()) / SECONDS)
        return MANY if left == math.inf else max(0, math.floor(left / (variables + BESIDES)))


@dataclass(frozen=True)
class Solver:
    """How the graph of each round is solved.

    Attributes:
        optimizer: its name, see `optimizer.OPTIMIZERS`.
        max_iterations: limit of its iterations in each round.
        budget: what all rounds may spend.
    """

    optimizer: str = "dogleg"
    max_iterations: int = 100
    budget: Budget = field(default_factory=Budget)


@dataclass(frozen=True, eq=False)
class Solved:
    """The graph of the last round, solved, and what the solves did.

    Attributes:
        graph: the graph of the last round.
        converged: whether the last solve reached a stationary point that keeps all hard edges.
        reason: why, in words.
        iterations: over all rounds.
        error_history: error at the start and after each iteration, over all rounds.
        rounds: how many times the graph was solved.
    """

    graph: Assembly
    converged: bool
    reason: str
    iterations: int
    error_history: Array
    rounds: int


def solve_in_rounds(problem: Problem, initial: Array | None = None, solver: Solver | None = None) -> Solved:
    """Solve a problem in rounds; the last solve is judged.

    Args:
        problem: what to solve.
        initial: frames to start from, shape (m, 4) in [rad]; see `first_assembly`.
        solver: how.

    Raises:
        GraphError: where an edge is singular or not finite, or a joint would turn by a whole turn.
    """
    graph, outcomes = _Rounds(problem, Solver() if solver is None else solver).solve(first_assembly(problem, initial))
    frames = graph.state.frames
    if not np.abs(frames).max() < ANGLE_LIMIT_RAD:
        turned = np.abs(frames)
        worst, _ = np.unravel_index(turned.argmax(), turned.shape)
        hint = wrong_jacobians(problem.own, graph.values())
        raise GraphError(f"a joint would turn by {math.degrees(turned.max()):.0f} degrees at frame {worst}{hint}")
    history: list[float] = []
    for outcome in outcomes:
        history += outcome.error_history
    errors, last = np.array(history), outcomes[-1]
    errors.setflags(write=False)
    reason = last.reason if last.converged else last.reason + wrong_jacobians(problem.own, graph.values())
    return Solved(graph, last.converged, reason, len(history) - len(outcomes), errors, len(outcomes))


def wrong_jacobians(factors: Iterable[gtsam.NonlinearFactor], values: gtsam.Values) -> str:
    """Which Jacobian of a user's factors is not the derivative of its error, in words; nothing where all are right.

    A wrong one is met late: the solver goes where no step helps, and says only that it did not converge.
    """
    for number, factor in enumerate(factors):
        try:
            found = check_jacobian(factor, values)  # type: ignore[arg-type]
        except GgoError:
            continue  # a factor that cannot be differentiated says nothing of the others
        if not float(found) <= WRONG * max(abs(found.analytic), abs(found.numeric)) + JACOBIAN_ROUNDING:
            name = f"{factor.edge} edge" if isinstance(factor, CheckedFactor) else type(factor).__name__
            return (
                f"; factor {number + 1} of your own ({name}) has a wrong Jacobian: off by {found!r}; see check_jacobian"
            )
    return ""


def stricter(state: Round, farthest: float) -> float:
    """The gain of the style variable's prior, larger where the variable goes further than in a person's own steps.

    A style is learned from everyday steps and says nothing of a high box, over which it would bend a step by 40
    standard deviations, four times as jerkily as residual edges do. Those bend it there.
    """
    away = 0.0 if state.style is None else float(np.linalg.norm(state.style)) / farthest
    return state.style_gain * (away**STRICTER if away > TOO_FAR else 1.0)


class _Rounds:
    """The rounds of one problem."""

    def __init__(self, problem: Problem, solver: Solver) -> None:
        self._problem, self._solver = problem, solver
        given = 0
        for request in problem.obstacles:
            given += request.frames is not None
        self._chooses = len(problem.obstacles) > given or problem.ground is not None
        coarse = self._chooses and not given and not problem.full and not problem.hard
        # How many frames, and instants, one edge that the rounds choose may stand for.
        self._spacing = -(-(len(problem.base) - 1) // FINEST) if coarse else 1
        self._lift_spacing = -(-(len(problem.fine) - 1) // FINEST) if coarse else 1

    def solve(self, graph: Assembly) -> tuple[Assembly, list[Outcome]]:
        """The graph of the last round, solved, and what each solve did; the last one judged."""
        if not self._chooses:
            return self._join(graph, self._path(graph, self._problem.base.frames))
        # Where the foot would pass without obstacles decides which frames pass over them, and where to hold.
        # A leg goes through what is not lifted over yet: soft edges may push it aside, constraints would contradict.
        # Those of bones wait: without flesh around them there are few ways to be pushed, and rounds would be lost.
        left = [each for each in graph.inequalities if not (each.is_bone or (self._problem.hard and each.of_ground))]
        level = replace(graph, inequalities=tuple(left))
        free, outcomes = self._join(level, None)
        if outcomes[-1].reason and not outcomes[-1].converged:
            return free, outcomes
        reference, problem = self._path(free, free.state.frames), self._problem
        lifts = self._lifted(free, reference, reference, low_only=False)
        # The style says how this person steps there; over what is in the way the residual edges bend that step.
        held = problem.style is not None and lifts.edges != free.state.lifts.edges
        whole = replace(graph, state=replace(free.state, lifts=lifts, style_held=held))
        complete = len(left) == len(graph.inequalities) or self._grown(whole, None) is None
        if lifts.edges == free.state.lifts.edges and complete:
            return free, outcomes
        last, more = self._join(whole, reference)
        return last, outcomes + more

    def _join(self, graph: Assembly, reference: Array | None) -> tuple[Assembly, list[Outcome]]:
        """Solve until no frame joins any more; judge the last solve."""
        outcomes: list[Outcome] = []
        graph = self._foreseen(graph)
        while True:
            edges = graph.variable_edges
            graph, outcome, factors = self._minimise(graph)
            for edge in edges:
                if edge.constraint:
                    graph, outcome, factors = meet_constraints((graph, outcome, factors), self._minimise)
                    break
            outcomes.append(outcome)
            if outcome.reason and not outcome.converged:
                return graph, outcomes  # contradicting constraints: more edges do not help
            grown = self._grown(graph, reference)
            if grown is None:
                if not outcome.converged:
                    outcomes[-1] = judged(factors, outcome, self._solver.max_iterations)
                return graph, outcomes
            if len(outcomes) == MOST_ROUNDS:
                reason = f"not converged: frames still join after {MOST_ROUNDS} rounds"
                outcomes[-1] = replace(outcome, converged=False, reason=reason)
                return graph, outcomes
            graph = grown

    def _foreseen(self, graph: Assembly) -> Assembly:
        """The graph with the prior of the style variable as strict as one linear step says that it must be.

        Else every step that is not the person's own would be solved twice.
        """
        style, state = self._problem.style, graph.state
        if style is None or state.style_held or state.style is None or state.style.any():
            return graph
        start = graph.values(graph.fixed)
        try:
            ahead = graph.solved().linearize(start).optimize().at(STYLE_KEY)
        except RuntimeError:
            return graph  # a singular graph, which the solver names
        gain = stricter(replace(state, style=ahead), style.farthest)
        return graph if gain <= state.style_gain else replace(graph, state=replace(state, style_gain=gain))

    def _grown(self, graph: Assembly, reference: Array | None) -> Assembly | None:
        """The graph of the next round, with the frames that join, or None where none does."""
        state, problem = graph.state, self._problem
        if problem.style is not None and not state.style_held:
            gain = stricter(state, problem.style.farthest)
            if gain > state.style_gain:
                return replace(graph, state=replace(state, style_gain=gain))
        joined = dict(state.joined)
        for inequality in graph.inequalities:
            now = broken(inequality, state.frames, problem.anchors, problem.hard)
            if now.any():
                before = joined.get(inequality.name, Joined({}, np.zeros(len(now), dtype=bool)))
                joined[inequality.name] = before.and_broken(now, self._spacing)
        lifts = state.lifts
        if reference is not None:
            lifts = self._lifted(graph, self._path(graph, state.frames), reference, low_only=True)
        if lifts.edges == state.lifts.edges and not self._reweighed(graph, joined):
            return None
        # The style says how this person steps; where that breaks limits the residual edges bend it, as over obstacles.
        held = problem.style is not None
        return replace(graph, state=replace(state, lifts=lifts, joined=joined, style_held=held))

    def _reweighed(self, graph: Assembly, joined: dict[str, Joined]) -> bool:
        """Whether an edge of an inequality is new or has another weight than before."""
        for name, now in joined.items():
            before = dict(graph.state.joined[name].weights) if name in graph.state.joined else {}
            if name == "knee" and not self._problem.hard:
                # Every keyframe has a knee edge of weight 1 anyway, unless knees are constraints.
                before = dict.fromkeys(graph.keyframes, 1.0) | before
            if now.weights.items() - before.items():
                return True
        return False

    def _lifted(self, graph: Assembly, path: Array, hold_at: Array, low_only: bool) -> Lifts:
        """The lifts, and those that a path calls for besides."""
        problem, lifts = self._problem, graph.state.lifts
        # An instant cannot be lifted where it cannot move, or a constraint says where it goes.
        given = set(problem.anchors)
        for end in problem.ends:
            if problem.hard and end.foothold is not None:
                given.add(end.frame)
        if graph.sampling is None:
            held = np.zeros(len(problem.base), dtype=bool)
            held[list(given)] = True
        else:
            held = graph.sampling.held(given)
        for demand in demands(path, hold_at, problem.obstacles, problem.ground, problem.model.foot, low_only):
            lifts = lifts.meeting(demand, hold_at, held, self._lift_spacing)
        return lifts

    def _path(self, graph: Assembly, frames: Array) -> Array:
        """The path of the swing ankle at the instants of the rounds in [m], shape (k, 2), of frames (m, 4) in [rad]."""
        return self._problem.model.endpoint(frames if graph.sampling is None else graph.sampling.frames(frames))

    def _minimise(self, graph: Assembly) -> Minimised:
        """The graph minimised, its constraints missed by what their edges give way."""
        factors, edges = graph.solved(), graph.variable_edges
        smooth: list[Edge] | None = edges  # Newton's last steps know no constraints of GTSAM's
        for edge in edges:
            if math.isinf(edge.gain):
                smooth = None
        for factor in self._problem.own:
            if isinstance(factor, gtsam.NoiseModelFactor) and factor.noiseModel().isConstrained():
                smooth = None
        start, solver = graph.values(graph.fixed), self._solver
        if graph.state.style_held:
            start.erase(STYLE_KEY)
        variables = start.size()
        left = solver.budget.iterations(variables)
        outcome = descend(factors, start, solver.optimizer, min(solver.max_iterations, max(left, 1)), smooth)
        solver.budget.work -= (variables + BESIDES) * outcome.iterations
        if left <= outcome.iterations:
            outcome = replace(outcome, converged=False, reason=OUT_OF_TIME)
        return replace(graph, state=graph.filled(outcome.values)), outcome, factors
