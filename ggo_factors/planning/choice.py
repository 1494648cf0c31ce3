"""Which foothold each step takes: a discrete variable for each, costs of steps as ternary factors.

What data association is in SLAM: a choice among a few candidates that the continuous graph cannot make, scored by that
graph's own cost. Elimination of the factor graph gives the footholds that are cheapest together.
"""

from __future__ import annotations

from collections.abc import Sequence

import gtsam
import numpy as np

from ggo_factors.support.inputs import Array

LEAST_WEIGHT = 1e-6
"""Smallest weight of a step that may be part of the cheapest way. A `DecisionTreeFactor` takes weights that differ by
less than 1e-9 for equal, and much smaller ones for 0."""


def foothold_graph(tables: Sequence[Array], counts: Sequence[int], most: float) -> gtsam.DiscreteFactorGraph:
    """The factor graph of a plan: variable ``symbol("f", n)`` is the foothold of step n, from 0.

    A step with one candidate has no variable: GTSAM reads weights of such a variable from beyond its tables.

    A way that costs c has the weight exp(-k c). Steps that no way of cost `most` or less can contain, whatever the
    others cost, have the weight 0, so that k can be large enough to tell the others apart.

    Args:
        tables: cost of each step by the footholds of the step two before, the one before, and its own, those that are
            given already left out: shape (k0,), (k0, k1), (k0, k1, k2), (k1, k2, k3) and so on; infinite where there is
            no step.
        counts: how many candidates each step has.
        most: cost of some way.
    """
    graph = gtsam.DiscreteFactorGraph()
    least = [float(table.min()) for table in tables]
    spare = max(most - sum(least), 1e-12)
    for step, (table, low) in enumerate(zip(tables, least, strict=True)):
        beyond = (table - low) / spare
        weights = np.where(beyond <= 1.0 + 1e-9, LEAST_WEIGHT**beyond, 0.0)
        first = step - table.ndim + 1
        keys = [(key(n), counts[n]) for n in range(first, step + 1) if counts[n] > 1]
        if keys:
            graph.push_back(gtsam.DecisionTreeFactor(keys, weights.ravel().tolist()))
    return graph


def chosen(tables: Sequence[Array], counts: Sequence[int], known: Sequence[int]) -> list[int]:
    """The candidate of each step that is cheapest together, see `foothold_graph`, given a choice that is `known`."""
    if not np.isfinite(cost_of(tables, known)):
        return list(known)
    # What all ways cost would hide what they differ by.
    tables = [table - table.min() for table in tables]
    most = cost_of(tables, known)
    free, choice = [step for step, count in enumerate(counts) if count > 1], [0] * len(counts)
    if not free:
        return choice
    ordering = gtsam.Ordering()
    for step in free:
        ordering.push_back(key(step))
    best = foothold_graph(tables, counts, most).maxProduct(ordering).argmax()
    for step in free:
        choice[step] = int(best[key(step)])
    return choice if cost_of(tables, choice) <= most else list(known)


def cost_of(tables: Sequence[Array], choice: Sequence[int]) -> float:
    """What a choice of candidates costs."""
    return sum(float(table[tuple(choice[n - table.ndim + 1 : n + 1])]) for n, table in enumerate(tables))


def key(step: int) -> int:
    """Key of the foothold of a step, from 0."""
    return int(gtsam.symbol("f", step))
