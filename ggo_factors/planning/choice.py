"""Which foothold each step takes: a discrete variable for each, costs of steps as ternary factors.

What data association is in SLAM: a choice among a few candidates that the continuous graph cannot make, scored by that
graph's own cost. Elimination of the factor graph gives the footholds that are cheapest together.
"""

from __future__ import annotations

from collections.abc import Sequence

import gtsam
import numpy as np

from ggo_factors.support.inputs import Array

SHARPNESS = 2000.0
"""A way that costs c has the weight exp(-2000 c): costs that differ by 0.001, a thousandth of a step over a box, differ
by a factor of 7."""
LARGEST_EXPONENT = 600.0
"""Weights multiply over all steps and must not vanish: exp(-700) does. Where costs spread further they count less
sharply, in the same order."""


def foothold_graph(tables: Sequence[Array], counts: Sequence[int]) -> gtsam.DiscreteFactorGraph:
    """The factor graph of a plan: variable ``symbol("f", n)`` is the foothold of step n, from 0.

    Args:
        tables: cost of each step by the footholds of the step two before, the one before, and its own, those that are
            given already left out: shape (k0,), (k0, k1), (k0, k1, k2), (k1, k2, k3) and so on; infinite where there is
            no step.
        counts: how many candidates each step has.
    """
    graph = gtsam.DiscreteFactorGraph()
    finite = [table[np.isfinite(table)] for table in tables]
    spread = sum(float(np.ptp(costs)) for costs in finite if len(costs))
    sharpness = min(SHARPNESS, LARGEST_EXPONENT / max(spread, 1e-12))
    for step, (table, costs) in enumerate(zip(tables, finite, strict=True)):
        least = float(costs.min()) if len(costs) else 0.0
        weights = np.exp(-sharpness * (table - least))
        first = step - table.ndim + 1
        keys = [(key(n), counts[n]) for n in range(first, step + 1)]
        graph.push_back(gtsam.DecisionTreeFactor(keys, weights.ravel().tolist()))
    return graph


def chosen(tables: Sequence[Array], counts: Sequence[int]) -> list[int]:
    """The candidate of each step that is cheapest together, see `foothold_graph`; empty where there is no way."""
    ordering = gtsam.Ordering()
    for step in range(len(counts)):
        ordering.push_back(key(step))
    best = foothold_graph(tables, counts).maxProduct(ordering).argmax()
    choice = [int(best[key(step)]) for step in range(len(counts))]
    return choice if np.isfinite(cost_of(tables, choice)) else []


def cost_of(tables: Sequence[Array], choice: Sequence[int]) -> float:
    """What a choice of candidates costs."""
    return sum(float(table[tuple(choice[n - table.ndim + 1 : n + 1])]) for n, table in enumerate(tables))


def key(step: int) -> int:
    """Key of the foothold of a step, from 0."""
    return int(gtsam.symbol("f", step))
