"""Solves a factor graph by GTSAM and judges the result, which GTSAM itself never does."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import gtsam
import numpy as np

from ggo_factors.check.verify import Report
from ggo_factors.errors import GraphError, InfeasibleGaitError, InputError, Violation
from ggo_factors.factors import Edge, frame_of_key
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.graph.newton import newton_steps
from ggo_factors.graph.requests import HARD_TOLERANCE
from ggo_factors.motion.gait import Gait
from ggo_factors.support.inputs import Array, as_count, short_text

RELATIVE_TOLERANCE = 1e-9
# A step of Dogleg that saves a smaller share of the error may be near enough for Newton; where it is not, the next.
NEAR = (1e-2, 1e-3, 1e-5)
ABSOLUTE_TOLERANCE = 1e-12
# A solution is stationary where a Gauss-Newton step promises less than this share of the error.
STATIONARY_SHARE = 1e-6
STATIONARY_FLOOR = 1e-10

OPTIMIZERS: dict[str, tuple[Any, Any]] = {
    "dogleg": (gtsam.DoglegParams, gtsam.DoglegOptimizer),
    "lm": (gtsam.LevenbergMarquardtParams, gtsam.LevenbergMarquardtOptimizer),
}


@dataclass(frozen=True)
class Outcome:
    """What an optimizer did, judged.

    Attributes:
        values: the variables where it stopped.
        converged: whether they are a stationary point that keeps all hard edges.
        reason: why it counts as converged or not, in words; empty where it was not judged.
        iterations: iterations used.
        error_history: error before the first and after each iteration, shape (iterations + 1,).
    """

    values: gtsam.Values
    converged: bool
    reason: str
    iterations: int
    error_history: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Solution:
    """A solved gait graph: the gait, how it was found, and what the dense check says of it.

    Attributes:
        gait: the generated gait.
        converged: whether the optimizer reached a stationary point that keeps all hard edges.
        reason: why, in words.
        iterations: iterations over all rounds.
        error_history: error at the start and after each iteration, over all rounds.
        smoothness: gain of the second-order residual edges.
        rounds: how many times the graph was solved.
        keyframes: frames that were variables in the last round.
        insert: makes `values` when they are first asked for.
        build: makes `factor_graph` when it is first asked for.
        check: makes `report` when it is first asked for.
        count: makes `costs` when they are first asked for.
        first_frame: the frame of the gait that the graph calls g0: not 0 where a step was replanned.
        frames_apart: frames of the gait from one frame of the graph to the next: above 1 at a high sampling rate.
    """

    gait: Gait
    converged: bool
    reason: str
    iterations: int
    error_history: Array
    smoothness: float
    rounds: int
    keyframes: tuple[int, ...]
    insert: Callable[[], gtsam.Values] = field(repr=False)
    build: Callable[[], gtsam.NonlinearFactorGraph] = field(repr=False)
    check: Callable[[], Report] = field(repr=False)
    count: Callable[[], Mapping[str, float]] = field(repr=False)
    first_frame: int = 0
    frames_apart: float = 1.0

    def __repr__(self) -> str:
        found = "converged" if self.converged else self.reason.partition(":")[0]
        checked = "not checked yet"  # the check takes time, which a line at a prompt must not
        if "report" in vars(self):
            broken = len(self.violations)
            checked = f"{broken} limit{'s' if broken > 1 else ''} broken" if broken else "checked"
        return (
            f"{type(self).__name__}({short_text(self.gait.name)}, {len(self.gait)} frames, "
            f"{len(self.keyframes)} keyframes, {self.iterations} iterations, {found}, {checked})"
        )

    @cached_property
    def costs(self) -> Mapping[str, float]:
        """Half sums of squares by edge family.

        They are anchor, residual, smoothness, knee, limits, obstacle, hold and end, and `user` where there are factors
        of a user's own.
        """
        return self.count()

    @cached_property
    def report(self) -> Report:
        """What the dense check says of the gait."""
        return self.check()

    @cached_property
    def factor_graph(self) -> gtsam.NonlinearFactorGraph:
        """Graph of the last round, one factor for each edge."""
        return self.build()

    @cached_property
    def values(self) -> gtsam.Values:
        """Keyframes of the last round, for example for `gtsam.Marginals` with `factor_graph`."""
        return self.insert()

    @property
    def violations(self) -> tuple[Violation, ...]:
        """Every limit that the gait breaks; empty where it is good."""
        return self.report.violations

    @property
    def ok(self) -> bool:
        """Whether the solver converged and the dense check found nothing."""
        return self.converged and self.report.ok

    def require_ok(self) -> Solution:
        """Itself, where the gait is good.

        Raises:
            InfeasibleGaitError: with every violation, where it is not.
        """
        if self.ok:
            return self
        faults = [] if self.converged else [self.reason]
        faults += [str(violation) for violation in self.violations]
        raise InfeasibleGaitError("no safe gait: " + "; ".join(faults), self.violations)


def optimize(
    graph: gtsam.NonlinearFactorGraph,
    initial: gtsam.Values,
    optimizer: str = "dogleg",
    max_iterations: int = 100,
) -> Outcome:
    """Minimise the graph's error and judge the result.

    Args:
        graph: factors on vector variables.
        initial: a value for each variable.
        optimizer: ``"dogleg"``, or ``"lm"`` for a cross-check.
        max_iterations: limit of iterations.

    Raises:
        InputError: where the optimizer is unknown or the limit is not 1 or more.
        GraphError: where the graph is singular or an edge is not finite.
    """
    return judged(graph, descend(graph, initial, optimizer, max_iterations), max_iterations)


def descend(
    graph: gtsam.NonlinearFactorGraph,
    initial: gtsam.Values,
    optimizer: str = "dogleg",
    max_iterations: int = 100,
    edges: Sequence[Edge] | None = None,
) -> Outcome:
    """`optimize` without the judgement, which Newton's last step is where it was taken: converged, with a reason.

    Args:
        graph: as for `optimize`.
        initial: as for `optimize`.
        optimizer: as for `optimize`.
        max_iterations: as for `optimize`.
        edges: the graph's edges, where Dogleg may leave the last steps to Newton's method: where no factor is a hard
            constraint.

    Raises:
        InputError, GraphError: as `optimize`.
    """
    limit = as_count(max_iterations, "max_iterations", 1)
    if not isinstance(optimizer, str) or optimizer not in OPTIMIZERS:
        raise InputError(f"optimizer: {optimizer!r} is not known; {' or '.join(map(repr, OPTIMIZERS))}")
    try:
        if edges is None or optimizer != "dogleg":
            values, history = _run(graph, initial, optimizer, limit, RELATIVE_TOLERANCE)
            return Outcome(values, False, "", len(history) - 1, tuple(history))
        values, history, done = initial, list[float](), False
        for near in (*NEAR, RELATIVE_TOLERANCE):
            left = limit + 1 - max(len(history), 1)
            if done or left <= 0:
                break
            values, more = _run(graph, values, optimizer, left, near)
            history += more[bool(history) :]
            if near > RELATIVE_TOLERANCE and len(history) <= limit:
                values, more, done = newton_steps(graph, values, history[-1], edges, RELATIVE_TOLERANCE)
                history += more
    except RuntimeError as error:
        raise _named(error) from error
    iterations = len(history) - 1
    # A full Newton step that saves next to nothing is a judgement: here the error is least.
    reason = f"converged after {iterations} iterations" if done else ""
    return Outcome(values, done, reason, iterations, tuple(history))


def _run(
    graph: gtsam.NonlinearFactorGraph, initial: gtsam.Values, optimizer: str, limit: int, tolerance: float
) -> tuple[gtsam.Values, list[float]]:
    """GTSAM's optimizer: where it stopped, and the error before the first and after each iteration.

    By Cholesky's method, or where that calls stiff edges beside soft ones singular, by QR, which takes longer.
    """
    try:
        return _run_by("MULTIFRONTAL_CHOLESKY", graph, initial, optimizer, limit, tolerance)
    except RuntimeError as error:
        if not _is_singular(error):
            raise
        return _run_by("MULTIFRONTAL_QR", graph, initial, optimizer, limit, tolerance)


def _run_by(
    linear_solver: str,
    graph: gtsam.NonlinearFactorGraph,
    initial: gtsam.Values,
    optimizer: str,
    limit: int,
    tolerance: float,
) -> tuple[gtsam.Values, list[float]]:
    make_params, method = OPTIMIZERS[optimizer]
    params = make_params()
    params.setLinearSolverType(linear_solver)
    params.setMaxIterations(limit)
    params.setRelativeErrorTol(tolerance)
    params.setAbsoluteErrorTol(ABSOLUTE_TOLERANCE)
    history: list[float] = []

    def record(iteration: int, before: float, after: float) -> None:
        history.append(after)

    params.iterationHook = record
    solver = method(graph, initial, params)
    first = solver.error()
    if not math.isfinite(first):
        raise GraphError(f"the error of the graph at its start is {first}")
    values = solver.optimize()
    return values, [first, *history]


def judged(graph: gtsam.NonlinearFactorGraph, outcome: Outcome, limit: int) -> Outcome:
    """The outcome with the judgement whether it is a stationary point that keeps all hard edges.

    Raises:
        GraphError: where the graph is singular or an edge is not finite.
    """
    try:
        converged, reason = _judge(graph, outcome.values, outcome.iterations, limit)
    except RuntimeError as error:
        raise _named(error) from error
    return replace(outcome, converged=converged, reason=reason)


def graph_of(factors: Iterable[gtsam.NonlinearFactor]) -> gtsam.NonlinearFactorGraph:
    """A factor graph of these factors."""
    graph = gtsam.NonlinearFactorGraph()
    for factor in factors:
        graph.add(factor)
    return graph


def common_offset_is_free(factors: Iterable[gtsam.NonlinearFactor], values: gtsam.Values) -> bool:
    """Whether some offset common to all frames changes none of these factors.

    The residual edges fix every frame but for such an offset, so a gait graph is singular exactly where the other
    edges leave one free: the gauge freedom of a pose graph without a prior.
    """
    stiffness = np.zeros((FRAME_SIZE, FRAME_SIZE))
    for factor in factors:
        linear = factor.linearize(values)
        if isinstance(linear, gtsam.JacobianFactor):
            jacobian = np.array(linear.getA())
            common = jacobian.reshape(len(jacobian), -1, FRAME_SIZE).sum(axis=1)
            stiffness += common.T @ common
    return bool(np.linalg.eigvalsh(stiffness)[0] < 1e-9)


def _judge(graph: gtsam.NonlinearFactorGraph, values: gtsam.Values, iterations: int, limit: int) -> tuple[bool, str]:
    error = graph.error(values)
    if not math.isfinite(error):
        return False, f"not finite: the error ended at {error}"
    for index in range(graph.size()):
        factor = graph.at(index)
        if not isinstance(factor, gtsam.NoiseModelFactor) or not factor.noiseModel().isConstrained():
            continue
        miss = float(np.abs(factor.unwhitenedError(values)).max())
        if miss > HARD_TOLERANCE:
            frames = [frame_of_key(key) for key in factor.keys()]
            return False, f"contradicting: a hard edge at frame {frames[0]} is missed by {miss:.3g}"
    linear = graph.linearize(values)
    step = _step(linear)
    still = gtsam.VectorValues.Zero(step)
    promised = linear.error(still) - linear.error(step)
    if promised > STATIONARY_SHARE * error + STATIONARY_FLOOR:
        stopped = "stopped at the limit of" if iterations >= limit else "stopped after"
        left = f"a step could still save {promised:.3g} of {error:.3g}"
        return False, f"not converged: {stopped} {iterations} iterations, {left}"
    return True, f"converged after {iterations} iterations"


def _step(linear: gtsam.GaussianFactorGraph) -> gtsam.VectorValues:
    """The step to the minimum, also of a graph that Cholesky's method on large cliques calls singular and is not."""
    try:
        return linear.optimize()
    except RuntimeError as error:
        if not _is_singular(error):
            raise
        return linear.eliminateSequential(gtsam.Ordering.ColamdGaussianFactorGraph(linear)).optimize()


def _is_singular(error: RuntimeError) -> bool:
    return re.search("ndetermina(te|nt) linear system", str(error)) is not None


def _named(error: RuntimeError) -> GraphError:
    """GTSAM's own words for a singular graph, in ours."""
    found = re.search(r"near variable\s+(\d+) \(Symbol: g(\d+)\)", str(error))
    if _is_singular(error):
        where = f" at frame {found[2]}" if found else ""
        return GraphError(
            f"the graph is singular{where}: an edge is missing, or its Jacobian is zero, or gains are too far apart"
        )
    return GraphError(f"GTSAM stopped: {str(error).strip().splitlines()[0]}")
