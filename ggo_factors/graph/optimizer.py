"""Minimises a factor graph by GTSAM: Dogleg's steps, then Newton's; what came out is judged in `judge`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import gtsam

from ggo_factors.errors import GraphError, InputError
from ggo_factors.factors import Edge
from ggo_factors.graph.newton import newton_steps
from ggo_factors.support.inputs import as_count

RELATIVE_TOLERANCE = 1e-9
"""A step that saves a smaller share of the error is the last."""
ABSOLUTE_TOLERANCE = 1e-12
"""So is one that saves less than this."""
NEAR = (1e-2, 1e-3, 1e-5)
"""A step of Dogleg that saves a smaller share of the error may be near enough for Newton; where it is not, the next."""

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
        raise named(error) from error
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
        if not is_singular(error):
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


def graph_of(factors: Iterable[gtsam.NonlinearFactor]) -> gtsam.NonlinearFactorGraph:
    """A factor graph of these factors."""
    graph = gtsam.NonlinearFactorGraph()
    for factor in factors:
        graph.add(factor)
    return graph


def is_singular(error: RuntimeError) -> bool:
    """Whether GTSAM calls a graph singular."""
    return re.search("ndetermina(te|nt) linear system", str(error)) is not None


def named(error: RuntimeError) -> GraphError:
    """GTSAM's own words for a singular graph, in ours."""
    found = re.search(r"near variable\s+(\d+) \(Symbol: g(\d+)\)", str(error))
    if is_singular(error):
        where = f" at frame {found[2]}" if found else ""
        return GraphError(
            f"the graph is singular{where}: an edge is missing, or its Jacobian is zero, or gains are too far apart"
        )
    return GraphError(f"GTSAM stopped: {str(error).strip().splitlines()[0]}")
