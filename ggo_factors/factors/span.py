"""Spans: the motion between keyframes as one edge, exactly, and the frames between them.

Without second-order edges a span is a residual edge of gain 1 / length, its offsets on a straight line (`residual`).

With second-order edges, of error d(k+1) - 2 d(k) + d(k-1) for the offset d = g - z from the base gait, the chain of
frames is Markov in pairs of neighbours. A span of `length` frame-to-frame motions from frame p to q is then an edge on
p - 1, p, q, q + 1: all first-order edges from p to q and all second-order edges centred on p to q, their inner frames
eliminated. All joints share one scalar chain, which is eliminated once for each length by orthogonal steps: a longer
span is two shorter ones with the pair between them eliminated, which keeps full precision at any sampling rate.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, LinearFunction
from ggo_factors.factors.residual import MOTION, residual_edge
from ggo_factors.support.inputs import Array


def with_neighbours(keyframes: Iterable[int], count: int) -> list[int]:
    """Keyframes of a gait of `count` frames, completed so that each stands in a pair of neighbours."""
    keys = set(keyframes) | ({0, 1, count - 2, count - 1} if count > 2 else {0, 1})
    for n in sorted(keys):
        if n - 1 not in keys and n + 1 not in keys:
            keys.add(n + 1)
    return sorted(keys)


def motion_edges(base: Array, keyframes: Sequence[int], smoothness: float) -> list[Edge]:
    """The residual edges between neighbouring keyframes, of first and, with a smoothness, of second order.

    Args:
        base: base frames in [rad], shape (m, 4).
        keyframes: frame numbers, ascending, from 0 to m - 1; with a smoothness as `with_neighbours` gives them.
        smoothness: gain of the second-order edge on three neighbouring frames; that of the first-order edge is 1.
    """
    if not smoothness:
        return [residual_edge(base, first, last) for first, last in pairwise(keyframes)]
    edges = []
    for first, last in pairwise(keyframes):
        if last - first == 1:
            motion = LinearFunction(MOTION, base[last] - base[first])
            edges.append(Edge("residual", (first, last), FRAME_SIZE, 1.0, motion))
    for before, first, last in zip(keyframes, keyframes[1:], keyframes[2:], strict=False):
        if last - before == 2:
            edges.append(_span_edge(base, (before, first, last), 0, smoothness))
        elif last - first > 1:
            ends = (before, first, last, last + 1)
            edges.append(_span_edge(base, ends, last - first, smoothness))
    return edges


def fill_frames(base: Array, keyframes: Sequence[int], values: Array, smoothness: float) -> Array:
    """All frames of a gait from its keyframes, those between where the motion edges cost least.

    Args:
        base: base frames in [rad], shape (m, 4).
        keyframes: as for `motion_edges`.
        values: the keyframes in [rad], shape (k, 4).
        smoothness: as for `motion_edges`.

    Returns:
        Frames in [rad], shape (m, 4).
    """
    if not smoothness:
        return fill_spans(base, keyframes, values)
    offsets = values - base[list(keyframes)]
    filled = base.copy()
    for k, (first, last) in enumerate(pairwise(keyframes)):
        if last - first > 1:
            filled[first + 1 : last] += inner_weights(last - first, smoothness) @ offsets[k - 1 : k + 3]
    filled[list(keyframes)] = values
    return filled


def fill_spans(base: Array, keyframes: Sequence[int], values: Array) -> Array:
    """All frames of a gait from its keyframes, those between by a straight line of the offset.

    Args:
        base: base frames in [rad], shape (m, 4).
        keyframes: frame numbers, ascending, from 0 to m - 1.
        values: the keyframes in [rad], shape (k, 4).

    Returns:
        Frames in [rad], shape (m, 4).
    """
    keys = list(keyframes)
    offsets = values - base[keys]
    span, share = _places(tuple(keys))
    filled: Array = base + offsets[span] + share * (offsets[1:] - offsets[:-1])[span]
    filled[keys] = values  # exactly, not to the last bit of a sum
    return filled


@lru_cache(maxsize=64)
def _places(keyframes: tuple[int, ...]) -> tuple[NDArray[np.int_], Array]:
    """The span that each frame is in, shape (m,), and how far on in it, shape (m, 1)."""
    keys = np.array(keyframes)
    every = np.arange(keys[-1] + 1)
    span = np.minimum(np.searchsorted(keys, every, "right") - 1, len(keys) - 2)
    share = (every - keys[span]) / (keys[span + 1] - keys[span])
    return span, share[:, None]


def _span_edge(base: Array, frames: tuple[int, ...], length: int, smoothness: float) -> Edge:
    """The edge of error `span_root @ d` for each joint."""
    root, blocks = span_root(length, smoothness), _blocks(length, smoothness)
    target = (root @ base[list(frames)]).ravel()
    return Edge("residual", frames, len(target), 1.0, LinearFunction(blocks, target))


@cache
def _blocks(length: int, smoothness: float) -> tuple[Array, ...]:
    """The Jacobians of a span's edge, which all spans of a length share."""
    columns = span_root(length, smoothness).T
    return tuple(np.asfortranarray(np.kron(column[:, None], np.eye(FRAME_SIZE))) for column in columns)


@cache
def span_root(length: int, smoothness: float) -> Array:
    """Square root of a span's information, shape (3, 4): its cost is |root @ d|^2 / 2 for each joint.

    d are the offsets of the frames p - 1, p, q, q + 1, with q - p = `length`. Of length 0 it is the second-order edge
    on three frames, shape (1, 3).
    """
    root = np.sqrt(smoothness)
    if length == 0:
        return np.array([[root, -2.0 * root, root]])
    if length == 1:
        return np.array([[0.0, -1.0, 1.0, 0.0], [root, -2.0 * root, root, 0.0], [0.0, root, -2.0 * root, root]])
    middle, triangle = _eliminated(length, smoothness)
    return np.asarray(triangle[middle:, middle:])


@cache
def inner_weights(length: int, smoothness: float) -> Array:
    """Offsets of a span's inner frames by those of its ends p - 1, p, q, q + 1, shape (length - 1, 4)."""
    if length == 1:
        return np.zeros((0, 4))
    count, triangle = _eliminated(length, smoothness)
    middle = np.asarray(-np.linalg.solve(triangle[:count, :count], triangle[:count, count:]), dtype=np.float64)
    if length == 2:
        return middle
    ends = np.eye(4)
    before = inner_weights(_left(length), smoothness) @ np.concatenate([ends[:2], middle])
    after = inner_weights(length - 1 - _left(length), smoothness) @ np.concatenate([middle, ends[2:]])
    return np.concatenate([before, middle, after])


def _left(length: int) -> int:
    """Length of the left one of the two spans that a span of 3 or more consists of, with a pair between them."""
    return (length - 1) // 2


@cache
def _eliminated(length: int, smoothness: float) -> tuple[int, Array]:
    """How many frames in the middle were eliminated, and the triangle of rows: those frames', then the ends'."""
    root = np.sqrt(smoothness)
    if length == 2:
        middle = 1
        rows = np.array(
            [
                [1.0, 0.0, -1.0, 0.0, 0.0],
                [-1.0, 0.0, 0.0, 1.0, 0.0],
                [root, root, -2.0 * root, 0.0, 0.0],
                [-2.0 * root, 0.0, root, root, 0.0],
                [root, 0.0, 0.0, -2.0 * root, root],
            ]
        )
    else:
        middle = 2
        rows = np.zeros((7, 6))
        rows[:3, [2, 3, 0, 1]] = span_root(_left(length), smoothness)
        rows[3:6, [0, 1, 4, 5]] = span_root(length - 1 - _left(length), smoothness)
        rows[6, :2] = -1.0, 1.0
    # An offset common to all frames costs nothing: the last row is 0.
    return middle, np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)[: middle + 3]
