"""Minimises a factor graph by GTSAM: Dogleg's steps, then Newton's; `judge` judges the result."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import gtsam
import numpy as np

from ggo_factors.errors import GraphError, InputError
from ggo_factors.factors import BetweenFunction, Edge, frame_key
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import PointFunction
from ggo_factors.support.inputs import Array, as_count

RELATIVE_TOLERANCE = 1e-9
"""A step that saves a smaller share of the error than this is the last."""
ABSOLUTE_TOLERANCE = 1e-12
"""A step that saves less error than this is the last."""
NOTHING = 1e-20
"""A smaller error is rounding, from which no step saves anything: where the base gait itself is the answer."""
NEAR = (1e-2, 1e-3, 1e-5)
"""Newton's method is tried where a step of Dogleg saves a smaller share of the error than the first of these, then the
next ones."""
MOST_NEWTON_STEPS = 8
"""Limit of Newton steps; two to four are usual."""

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


def require_solver(optimizer: object, max_iterations: object) -> None:
    """Refuse an optimizer that is not known, or a limit of iterations that is none.

    Raises:
        InputError: naming which.
    """
    as_count(max_iterations, "max_iterations", 1)
    if not isinstance(optimizer, str) or optimizer not in OPTIMIZERS:
        raise InputError(f"optimizer: {optimizer!r} is not known; {' or '.join(map(repr, OPTIMIZERS))}")


def descend(
    graph: gtsam.NonlinearFactorGraph,
    initial: gtsam.Values,
    optimizer: str,
    limit: int,
    edges: Sequence[Edge] | None = None,
) -> Outcome:
    """`optimize` without the judgement, which Newton's last step is where it was taken: converged, with a reason.

    Args:
        graph: factors on vector variables.
        initial: a value for each variable.
        optimizer: its name, see `OPTIMIZERS`.
        limit: limit of iterations, 1 or more.
        edges: the graph's edges, where Dogleg may leave the last steps to Newton's method: where no factor is a hard
            constraint.

    Raises:
        GraphError: where the graph is singular or an edge is not finite.
    """
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
            done = history[-1] < NOTHING
            if not done and near > RELATIVE_TOLERANCE and len(history) <= limit:
                values, more, done = _newton_steps(graph, values, history[-1], edges, RELATIVE_TOLERANCE)
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


def _newton_steps(
    graph: gtsam.NonlinearFactorGraph,
    values: gtsam.Values,
    error: float,
    edges: Sequence[Edge],
    tolerance: float,
) -> tuple[gtsam.Values, list[float], bool]:
    """The last steps to the minimum by Newton's method, on GTSAM's own linear graphs, while each saves something.

    Gauss-Newton, and so Dogleg, leaves out the curvature of the swing ankle's path. Where obstacle and end edges still
    pull at the minimum, the last digits then take two to four times as many iterations as the first.

    Args:
        graph: a graph without hard edges.
        values: a point near the minimum.
        error: of the graph there.
        edges: its edges on variables.
        tolerance: a step that saves a smaller share of the error is the last.

    Returns:
        Where it stopped, the error after each step, and whether the last step was that small.
    """
    history: list[float] = []
    for _ in range(MOST_NEWTON_STEPS):
        linear = graph.linearize(values)
        for factor in _curvature(edges, values):
            linear.add(factor)
        try:
            step = linear.optimize()
        except RuntimeError:  # not convex here: this is no place for Newton
            return values, history, False
        there = values.retract(step)
        after = graph.error(there)
        if not math.isfinite(after) or after > error * (1.0 + tolerance):
            return values, history, False
        done = error - after <= tolerance * error
        history.append(after)
        values, error = there, after
        if done:
            return values, history, True
    return values, history, False


def _curvature(edges: Sequence[Edge], values: gtsam.Values) -> Iterator[gtsam.HessianFactor]:
    """What Gauss-Newton leaves out of the edges on one frame, or between two: a factor for each frame and each pair."""
    at: dict[int, Array] = {}
    bent: dict[tuple[int, ...], Array] = {}
    for edge in edges:
        if isinstance(edge.function, (PointFunction, BetweenFunction)):
            for n in edge.frames:
                if n not in at:
                    at[n] = values.atVector(frame_key(n))
            own = edge.gain * edge.function.curvature(*map(at.__getitem__, edge.frames))
            bent[edge.frames] = bent[edge.frames] + own if edge.frames in bent else own
    zero, half = np.zeros(FRAME_SIZE), FRAME_SIZE
    for frames, each in bent.items():
        key, *other = map(frame_key, frames)
        if other:
            own, between, others = each[:half, :half], each[:half, half:], each[half:, half:]
            yield gtsam.HessianFactor(key, other[0], own, between, zero, others, zero, 0.0)
        else:
            yield gtsam.HessianFactor(key, each, zero, 0.0)


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
    """GTSAM's error about a singular graph, as an error of the library that names the frame."""
    found = re.search(r"near variable\s+(\d+) \(Symbol: g(\d+)\)", str(error))
    if is_singular(error):
        where = f" at frame {found[2]}" if found else ""
        return GraphError(
            f"the graph is singular{where}: an edge is missing, or its Jacobian is zero, or gains are too far apart"
        )
    return GraphError(f"GTSAM stopped: {str(error).strip().splitlines()[0]}")
