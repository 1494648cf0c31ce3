"""Obstacles that were measured with an error: how far to keep away, and the probability of a hit that remains.

The true near edge, far edge and height are taken as independent and normal around the measured ones, with the standard
deviations that `Obstacle` carries. Where the errors exchange the two edges the box still lies between them: a post
thinner than its error is there all the same. A foot that has a size counts by `Obstacle.for_ankle`, as everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.support.inputs import Array, as_array, as_instance, as_number, as_tuple_of

HIT_PROBABILITY = 1e-3
"""Largest probability of a hit in one step unless the user gives another."""
LEAST_PROBABILITY = 1e-12
"""Smallest probability that `cautious` takes: no measured error is known to be normal that far out."""
KNOWN = 1e-9
"""Distances and standard deviations below this, in [m], count as 0."""
DEVIATIONS = 8.5
"""Heights are integrated over this many standard deviations on both sides: beyond lie 2e-17."""
PANELS = 34
"""Panels of the integral, so that none is wider than half a standard deviation."""
NEAR_EDGE = np.linspace(-4.0, 4.0, 9)
"""Panels also end at the heights of the path at these standard deviations from the measured edges."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
# Not SciPy's, which would double the time that the library takes to be imported.
_erfc = np.vectorize(math.erfc, otypes=[np.float64])


def cautious(obstacle: Obstacle, probability: float = HIT_PROBABILITY) -> Obstacle:
    """The box that holds the true one, but for at most the given probability.

    Near edge, far edge and height get an equal share of the probability, those of them that are not known. The height
    is raised until the true one is higher with the probability of its share. The box is made longer at both ends by the
    same length, until either true edge lies beyond one end or the other with at most the probability of its share, half
    of it at each end. The true box then sticks out with at most the sum of the shares, however the errors are
    correlated. So an ankle, sole, shank or thigh that stays clear of this box hits the true one with at most
    that probability.

    Args:
        obstacle: the box as it was measured.
        probability: of a hit; from `LEAST_PROBABILITY` to 1.

    Returns:
        A box without standard deviations; the obstacle itself where it has none.

    Raises:
        InputError: where the probability is unusable.
    """
    allowed = as_number(probability, "probability", at_least=LEAST_PROBABILITY, at_most=1.0)
    if not as_instance(obstacle, "obstacle", Obstacle).is_uncertain:
        return obstacle
    share = allowed / (2 * (obstacle.edge_std > 0.0) + (obstacle.height_std > 0.0))
    beyond = -NormalDist().inv_cdf(share / 2.0) * obstacle.edge_std
    higher = -NormalDist().inv_cdf(min(share, 0.5)) * obstacle.height_std
    return Obstacle(obstacle.x_start - beyond, obstacle.x_end + beyond, obstacle.height + higher, base=obstacle.base)


def all_cautious(obstacles: Sequence[Obstacle], probability: float = HIT_PROBABILITY) -> tuple[Obstacle, ...]:
    """Each obstacle of a step as by `cautious`, those that are uncertain with an equal share of the probability.

    What stays clear of them all hits any of the true ones with at most the given probability.
    """
    boxes = as_tuple_of(obstacles, "obstacles", Obstacle)
    uncertain = sum(box.is_uncertain for box in boxes)
    return tuple(cautious(box, probability / uncertain) if box.is_uncertain else box for box in boxes)


def hit_probability(obstacle: Obstacle, path: ArrayLike) -> float:
    """The probability that a path hits the true box: that a point of it lies over the box and lower than its top.

    For a given height, the stretches of x where the path is not lower are free; there is no hit where both edges lie in
    the same one, which for normal edges is a closed form. Only the integral over the height is by quadrature: by Gauss
    and Legendre, in panels that end where a dip or a peak of the path lets a stretch begin or end, and near the edges.

    Args:
        obstacle: the box as it was measured, in the frame of the path.
        path: points of the swing ankle in [m], shape (n, 2), close enough that it is straight between them.

    Returns:
        The probability; without standard deviations 0 or 1.

    Raises:
        InputError: where the path is unusable.
    """
    as_instance(obstacle, "obstacle", Obstacle)
    points = as_array(path, "path", (None, 2))
    if len(points) < 2:
        raise InputError(f"path: {len(points)} points, a path has at least 2")
    x, lowest = _lower_side(*points.T)
    if obstacle.height_std < KNOWN:
        return float(_hit_at(np.array([obstacle.height]), obstacle, x, lowest)[0])
    turns = np.flatnonzero(np.diff(np.sign(np.diff(lowest)))) + 1
    edges = [edge + NEAR_EDGE * obstacle.edge_std for edge in (obstacle.x_start, obstacle.x_end)]
    bends = np.concatenate([lowest[[0, *turns, -1]], np.interp(np.ravel(edges), x, lowest)])
    # To 1e-7 m alike: a level path has a thousand dips of rounding.
    jumps = (np.round(bends, 7) - obstacle.height) / obstacle.height_std
    ends = np.unique(np.clip([*np.linspace(-DEVIATIONS, DEVIATIONS, PANELS + 1), *jumps], -DEVIATIONS, DEVIATIONS))
    half, middle = np.diff(ends)[:, None] / 2.0, (ends[1:] + ends[:-1])[:, None] / 2.0
    at = (middle + half * NODES).ravel()
    weights = (half * WEIGHTS).ravel() * np.exp(-0.5 * at**2) / np.sqrt(2.0 * np.pi)
    return float(np.clip(weights @ _hit_at(obstacle.height + at * obstacle.height_std, obstacle, x, lowest), 0.0, 1.0))


def _lower_side(x: Array, y: Array) -> tuple[Array, Array]:
    """The lowest y of a path over some x, ascending: all that it has a point at, and both sides of where it turns."""
    turns = np.flatnonzero(np.diff(np.sign(np.diff(x)))) + 1
    beside = np.clip([x[turns] - KNOWN, x[turns] + KNOWN], x.min(), x.max())
    places = np.unique([*x, *beside.ravel()])
    lowest = np.full(len(places), np.inf)
    np.minimum.at(lowest, np.searchsorted(places, x), y)
    for first, last in pairwise([0, *turns.tolist(), len(x) - 1]):
        if x[first] != x[last]:
            run = slice(first, last + 1)
            there = np.argsort(x[run])
            lowest = np.minimum(lowest, np.interp(places, x[run][there], y[run][there], np.inf, np.inf))
    return places, lowest


def _hit_at(heights: Array, obstacle: Obstacle, x: Array, lowest: Array) -> Array:
    """Probability of a hit for each of some heights of the box, shape (k,), over the errors of its edges."""
    # Beside the path all is free; what is marked as not free beyond lets the outer stretches begin and end like others.
    x = np.concatenate([x[[0, 0]] - 1.0, x, x[[-1, -1]] + 1.0])
    lowest = np.concatenate([[-np.inf, np.inf], lowest, [np.inf, -np.inf]])
    free = lowest >= heights[:, None]
    level, before = np.nonzero(free[:, 1:] != free[:, :-1])
    inner, outer = (np.where(free[level, before] == side, before, before + 1) for side in (True, False))
    with np.errstate(invalid="ignore"):
        share = (heights[level] - lowest[outer]) / (lowest[inner] - lowest[outer])
    ends = x[outer] + share * (x[inner] - x[outer])
    ends[before == 0], ends[before == len(x) - 2] = -np.inf, np.inf
    std = max(obstacle.edge_std, KNOWN)
    near, far = (_between((ends.reshape(-1, 2) - edge) / std) for edge in (obstacle.x_start, obstacle.x_end))
    return np.asarray(1.0 - np.bincount(level[::2], near * far, minlength=len(heights)))


def _between(deviations: Array) -> Array:
    """The probability that a standard normal error lies between two values, shape (n, 2)."""
    return np.asarray(np.diff(_erfc(-deviations / math.sqrt(2.0)))[:, 0] / 2.0)
