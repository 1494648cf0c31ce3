"""How far each joint of a generated gait could as well be elsewhere: the marginals of its gait graph.

The gains of a graph are precisions, so the gait is the mean of a normal distribution, linearised there, and the inverse
of the graph's information is its covariance, but for one scale: what a residual edge of gain 1 stands for in radians.
A frame that is no variable follows from those at the ends of its span, and adds what the span leaves open.

Every edge counts as it is linearised: one that only pushes, as over an obstacle, counts as if it pulled too.
"""

from __future__ import annotations

import math
from itertools import pairwise

import gtsam
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from ggo_factors.factors import STYLE_KEY, frame_of_key
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.graph.solution import Solution
from ggo_factors.support.inputs import Array, as_instance, as_number

STEP_STD = math.radians(2.0)
"""Default of `step_std` in [rad]: strides of one healthy adult in walking logs vary by 0.8 to 2.7 degrees."""


def joint_spread(solution: Solution, step_std: float = STEP_STD) -> Array:
    """The standard deviation of each joint in each frame, 0 where a frame is anchored.

    Args:
        solution: the solved graph.
        step_std: how far healthy steps stray from the base gait, in [rad]: the standard deviation to which a joint's
            offset from it grows over a step that starts right and that nothing but first-order residual edges hold. The
            spread of the recorded strides tells it (`ImportReport.spread_deg`). The result is proportional to it.

    Returns:
        Shape (m, 4) in [rad].

    Raises:
        InputError: where an argument is unusable.
    """
    as_instance(solution, "solution", Solution)
    motions = (len(solution.gait) - 1) / solution.frames_apart
    scale = as_number(step_std, "step_std", above=0.0, unit="rad") / math.sqrt(motions)
    first_of_all, graph = solution.first_frame, solution.factor_graph
    keys = sorted(n for n in map(frame_of_key, solution.values.keys()) if n is not None)
    factors = [(graph.at(k), [frame_of_key(key) for key in graph.at(k).keys()]) for k in range(graph.size())]
    covariance = _covariance(factors, solution.values, keys)
    smoothness, size = solution.smoothness, FRAME_SIZE * len(keys)
    variance = np.zeros((keys[-1] + 1, FRAME_SIZE))
    variance[keys] = np.diagonal(covariance)[:size].reshape(-1, FRAME_SIZE)
    style = solution.graph.problem.style
    for k, (first, last) in enumerate(pairwise(keys)):
        if last - first > 1:
            weights, own = _span(last - first, smoothness)
            ends = range(k - 1, k + 3) if smoothness else range(k, k + 2)
            by_style = np.zeros((last - first - 1, FRAME_SIZE, 0))
            if style is not None:
                at_ends = style.directions[[keys[e] for e in ends]]
                by_style = style.directions[first + 1 : last] - np.einsum("ie,ejk->ijk", weights, at_ends)
            for joint in range(FRAME_SIZE):
                columns = [FRAME_SIZE * e + joint for e in ends] + list(range(size, len(covariance)))
                rows = np.concatenate([weights, by_style[:, joint]], axis=1)
                variance[first + 1 : last, joint] = own + ((rows @ covariance[np.ix_(columns, columns)]) * rows).sum(1)
    spread = scale * np.sqrt(np.maximum(variance, 0.0))
    at = np.arange(len(solution.gait) - first_of_all) / solution.frames_apart
    ahead = np.stack([np.interp(at, np.arange(len(spread)), column) for column in spread.T], -1)
    return np.concatenate([np.zeros((first_of_all, FRAME_SIZE)), ahead])


_Factors = list[tuple[gtsam.NonlinearFactor, list[int | None]]]


def _covariance(factors: _Factors, values: gtsam.Values, keys: list[int]) -> Array:
    """The covariance of the keyframes, then of the style variable, for a scale of 1, shape (4 k + style, 4 k + style).

    `gtsam.Marginals` (4.3) gives the same of single frames; but with constraints its joint blocks are wrong, and where
    one leaves a frame partly free it gives that no spread at all.
    """
    count = FRAME_SIZE * len(keys)
    size = count + (len(values.atVector(STYLE_KEY)) if values.exists(STYLE_KEY) else 0)
    columns = np.arange(count).reshape(-1, FRAME_SIZE)
    places: dict[int | None, NDArray[np.int_]] = {n: columns[k] for k, n in enumerate(keys)}
    places[None] = np.arange(count, size)
    information, constraints = np.zeros((size, size)), [np.zeros((0, size))]
    for factor, frames in factors:
        linear = factor.linearize(values)
        at = np.concatenate([places[n] for n in frames])
        hard = isinstance(factor, gtsam.NoiseModelFactor) and factor.noiseModel().isConstrained()
        if hard and isinstance(linear, gtsam.JacobianFactor):
            constraints.append(np.zeros((factor.dim(), size)))
            constraints[-1][:, at] = linear.getA()
        else:
            information[np.ix_(at, at)] += linear.information()
    free = null_space(np.concatenate(constraints)) if len(constraints) > 1 else np.eye(size)
    return np.asarray(free @ np.linalg.inv(free.T @ information @ free) @ free.T)


def _span(length: int, smoothness: float) -> tuple[Array, Array]:
    """How far the inner frames of a span follow its ends, and how far they are free besides.

    The ends are the frames p and q = p + `length`; with a smoothness p - 1, p, q, q + 1.

    Returns:
        The inner frames' offsets by those of the ends, shape (length - 1, ends); their variances beside that, shape
        (length - 1,).
    """
    beside = 1 if smoothness else 0
    chain = np.eye(length + 1 + 2 * beside)
    motions = np.diff(chain, axis=0)
    rows = motions[beside : beside + length]
    if smoothness:
        rows = np.concatenate([rows, math.sqrt(smoothness) * np.diff(motions, axis=0)])
    information = rows.T @ rows
    inner = np.arange(beside + 1, beside + length)
    ends = np.delete(np.arange(len(chain)), inner)
    open_ = np.linalg.inv(information[np.ix_(inner, inner)])
    across = information[np.ix_(inner, ends)]
    return -open_ @ across, np.diagonal(open_).copy()
