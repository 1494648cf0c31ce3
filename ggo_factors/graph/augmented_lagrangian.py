"""Constraints met exactly: their edges are shifted, solve after solve, until nothing is missed.

GTSAM's own constraints leave 1e-6 and know no inequalities. Here the edge of a constraint is an ordinary stiff one
whose target is shifted by what it misses, the constraint's multiplier over the gain: an augmented Lagrangian.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import gtsam
import numpy as np

from ggo_factors.factors import Edge
from ggo_factors.graph.assembly import Assembly
from ggo_factors.graph.optimizer import Outcome
from ggo_factors.graph.requests import HARD_TOLERANCE

STALLED = 5
"""So many shifts of the constraints that do not halve what is missed show that they contradict each other."""

Minimised = tuple[Assembly, Outcome, gtsam.NonlinearFactorGraph]


def meet_constraints(first: Minimised, minimise: Callable[[Assembly], Minimised]) -> Minimised:
    """A graph solved so that its constraints are met to a tenth of `HARD_TOLERANCE`, or known to contradict each other.

    Args:
        first: the graph, solved once; what that did; its factors.
        minimise: solves a graph once.

    Returns:
        The same of the last solve; its iterations and errors are those of all solves.
    """
    graph, outcome, factors = first
    least, stalled = np.inf, 0
    while True:
        if outcome.reason and not outcome.converged:
            return graph, outcome, factors  # out of time
        constraints = constraints_of(graph)
        state = graph.state
        shifts = {name: edge.errors(state.frames) for name, edge in constraints.items()}
        misses = {name: float(np.abs(shift - state.shifts.get(name, 0.0)).max()) for name, shift in shifts.items()}
        worst = max(misses, key=misses.__getitem__)
        missed = misses[worst]
        if missed <= HARD_TOLERANCE / 10.0:
            return graph, outcome, factors
        least, stalled = min(missed, least), 0 if missed < least / 2.0 else stalled + 1
        if stalled == STALLED:
            frame = constraints[worst].frames[0]
            reason = f"contradicting: a hard edge at frame {frame} is missed by {missed:.3g} ({worst})"
            refused = replace(outcome, converged=False, reason=reason)
            return graph, outcome if missed <= HARD_TOLERANCE else refused, factors
        graph, more, factors = minimise(replace(graph, state=replace(state, shifts=shifts)))
        history = outcome.error_history + more.error_history[1:]
        outcome = replace(more, error_history=history, iterations=len(history) - 1)


def constraints_of(graph: Assembly) -> Mapping[str, Edge]:
    """The edges that stand for constraints, by the constraint's name."""
    return {edge.constraint: edge for edge in graph.variable_edges if edge.constraint}
