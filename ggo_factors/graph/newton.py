"""The last steps to the minimum by Newton's method, on GTSAM's own linear graphs.

Gauss-Newton, and so Dogleg, leaves out the curvature of P. Where obstacle and end edges keep a pull at the minimum,
that makes the last digits take two to four times as many iterations as the first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import gtsam
import numpy as np

from ggo_factors.factors.between import BetweenFunction
from ggo_factors.factors.checked import FRAME_SIZE, frame_key
from ggo_factors.factors.edge import Edge, PointFunction
from ggo_factors.support.inputs import Array

MOST_STEPS = 8


def newton_steps(
    graph: gtsam.NonlinearFactorGraph,
    values: gtsam.Values,
    error: float,
    edges: Sequence[Edge],
    tolerance: float,
) -> tuple[gtsam.Values, list[float], bool]:
    """Full Newton steps for as long as each saves something.

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
    for _ in range(MOST_STEPS):
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
            own = edge.gain * edge.function.curvature(*(at[n] for n in edge.frames))
            bent[edge.frames] = bent[edge.frames] + own if edge.frames in bent else own
    zero, half = np.zeros(FRAME_SIZE), FRAME_SIZE
    for frames, each in bent.items():
        key, *other = (frame_key(n) for n in frames)
        if other:
            own, between, others = each[:half, :half], each[:half, half:], each[half:, half:]
            yield gtsam.HessianFactor(key, other[0], own, between, zero, others, zero, 0.0)
        else:
            yield gtsam.HessianFactor(key, each, zero, 0.0)
