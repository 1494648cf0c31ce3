"""Style: how this person varies a step, as one small variable of each step, estimated together with its frames.

With directions W the base gait z becomes z + W c, and the residual edges hold the residual r = g - z - W c instead of
the offset g - z: the variable c, of unit prior, is a calibration parameter of the odometry. A residual edge or span is
linear in the offsets of its frames, so it is as linear in c, and as exact, as it is in them. Not in the paper.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from ggo_factors.factors.edge import Edge, LinearFunction
from ggo_factors.support.inputs import Array


def styled_edges(edges: Iterable[Edge], directions: Array) -> Iterator[Edge]:
    """Residual edges and spans of the base gait as edges of the base gait varied by style.

    Args:
        edges: as `motion_edges` gives them.
        directions: W, shape (m, 4, k), in [rad] for each unit of c.
    """
    for edge in edges:
        function = edge.function
        assert isinstance(function, LinearFunction), edge.name
        block = np.zeros((edge.rows, directions.shape[2]), order="F")
        for n, by_frame in zip(edge.frames, function.blocks, strict=True):
            block -= by_frame @ directions[n]
        yield replace(edge, style=block)


def styled_rate_edge(edge: Edge, directions: Array, varies: bool = False) -> Edge:
    """The second-order edge of the start, see `rate_edge`, of the base gait varied by style.

    The walker's speed is given, the base gait's varies with c, so of W only what bends counts: half its second
    difference, by which a motion differs from the slope at its start. With `varies` the walker's speed is not known and
    taken to be that of the varied base gait.
    """
    if varies:
        return replace(edge, style=np.asfortranarray(directions[0] - directions[1]))
    bend = directions[:3].T @ np.array([1.0, -2.0, 1.0]) if len(directions) > 2 else np.zeros(directions.T.shape[:2])
    return replace(edge, style=np.asfortranarray(-0.5 * bend.T))


def style_start(first: Array, directions: Array, gain: float) -> Edge:
    """The edge of frame 0, shape (4,) in [rad], of error g(0) - z(0) - W(0) c: where a step starts tells of its style.

    Args:
        first: z(0), the first frame of the base gait.
        directions: W(0), shape (4, k).
        gain: of the edge.
    """
    function = LinearFunction((np.eye(len(first), order="F"),), first)
    return Edge("style start", (0,), len(first), gain, function, style=np.asfortranarray(-directions))


def styled_landing(edges: tuple[Edge, Edge], directions: Array, jacobian: Array) -> tuple[Edge, Edge]:
    """Landing edges as those of the base gait varied by style.

    The posture is that on the foothold nearest to the varied base gait's: it varies by what moves no swing ankle.

    Args:
        edges: as `landing_edges` gives them.
        directions: W at the last two frames, shape (2, 4, k).
        jacobian: of the swing ankle in the posture, shape (2, 4).
    """
    posture, motion = edges
    free = np.eye(jacobian.shape[1]) - np.linalg.pinv(jacobian) @ jacobian
    at, moving = -free @ directions[1], directions[0] - directions[1]
    return replace(posture, style=np.asfortranarray(at)), replace(motion, style=np.asfortranarray(moving))


def style_anchor(style: Array) -> Edge:
    """The hard edge that holds the style variable, shape (k,), where it is, as an anchor holds a frame."""
    size = len(style)
    return Edge("style anchor", (), size, math.inf, LinearFunction((), style), style=np.eye(size, order="F"))


def with_style_held(edge: Edge, style: Array) -> Edge:
    """An edge on frames and the style variable as one on frames only, the variable held."""
    if edge.style is None:
        return edge
    function = edge.function
    assert isinstance(function, LinearFunction), edge.name
    held = LinearFunction(function.blocks, function.target - edge.style @ style)
    return replace(edge, function=held, style=None)


def style_prior(size: int, gain: float = 1.0) -> Edge:
    """The prior of the style variable, of error c: the unit prior, or a stiffer one where c would go too far."""
    nowhere = LinearFunction((), np.zeros(size))
    return Edge("style prior", (), size, gain, nowhere, style=np.eye(size, order="F"))
