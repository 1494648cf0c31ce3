"""Judges what an optimizer returns: whether it is a minimum that keeps all hard edges, which GTSAM does not say."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import gtsam
import numpy as np

from ggo_factors.factors import frame_of_key
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.graph.optimizer import Outcome, descend, is_singular, named, require_solver
from ggo_factors.graph.requests import HARD_TOLERANCE

STATIONARY_SHARE = 1e-6
"""A solution is stationary where a Gauss-Newton step promises to save less than this share of the error."""
STATIONARY_FLOOR = 1e-10
"""It is stationary too where such a step promises to save less error than this."""


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
    require_solver(optimizer, max_iterations)
    return judged(graph, descend(graph, initial, optimizer, max_iterations), max_iterations)


def judged(graph: gtsam.NonlinearFactorGraph, outcome: Outcome, limit: int) -> Outcome:
    """The outcome with the judgement whether it is a stationary point that keeps all hard edges.

    Raises:
        GraphError: where the graph is singular or an edge is not finite.
    """
    try:
        converged, reason = _judge(graph, outcome.values, outcome.iterations, limit)
    except RuntimeError as error:
        raise named(error) from error
    return replace(outcome, converged=converged, reason=reason)


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
        if not is_singular(error):
            raise
        return linear.eliminateSequential(gtsam.Ordering.ColamdGaussianFactorGraph(linear)).optimize()
