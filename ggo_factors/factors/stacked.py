"""Many edges in one custom factor: the same sum of squares for a fraction of the callbacks.

GTSAM's optimizers hand each callback of a Python factor a copy of all variables, which costs more than most edges do.
A stack gets that copy once for all its edges, and evaluates the linear ones as one product.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from itertools import accumulate

import gtsam
import numpy as np

from ggo_factors.errors import GraphError
from ggo_factors.factors.between import BetweenFunction
from ggo_factors.factors.checked import FRAME_SIZE, frame_key
from ggo_factors.factors.edge import Edge, LinearFunction, PointFunction
from ggo_factors.support.inputs import Array

MOST_SINGLE = 2
"""Up to so many edges of a kind are evaluated one by one: setting up a batch costs more than it saves for them."""


def stacked_factor(edges: Sequence[Edge], fixed: Mapping[int, Array]) -> gtsam.CustomFactor:
    """One factor for several soft edges, on all their frames but those that are fixed.

    Args:
        edges: edges of finite gain; their functions are `LinearFunction`, `PointFunction` and `BetweenFunction`.
        fixed: frames that are no variables, each (4,) in [rad].

    Raises:
        GraphError: from inside a solve, naming the edge: a value not finite.
    """
    order, linear, hinges = _ordered(edges)
    # Fixed frames have columns behind the variables' where an edge that is not linear has them.
    bent = {n for edge in order[len(linear) :] for n in edge.frames if n in fixed}
    variables = sorted({n for edge in edges for n in edge.frames if n not in fixed})
    numbers, constants = [*variables, *bent], [fixed[n] for n in bent]
    column = {n: FRAME_SIZE * k for k, n in enumerate(numbers)}
    keys = [frame_key(n) for n in variables]
    ends = list(accumulate(edge.rows for edge in order))
    rows = [slice(end - edge.rows, end) for edge, end in zip(order, ends, strict=True)]
    template = np.zeros((ends[-1], FRAME_SIZE * len(numbers)), order="F")
    straight = sum(edge.rows for edge in order[: len(linear) - hinges])  # rows of edges that are no hinges
    constant = sum(edge.rows for edge in order[: len(linear)])
    target = np.zeros(constant)
    for edge, function, at in zip(order, linear, rows, strict=False):
        target[at] += function.target
        for n, block in zip(edge.frames, function.blocks, strict=True):
            if n in column:
                template[at, column[n] : column[n] + FRAME_SIZE] = block
            else:
                target[at] -= block @ fixed[n]
    product = np.ascontiguousarray(template[:constant])
    others = _together(order[len(linear) :], rows[len(linear) :], column)
    gains = np.array([edge.gain for edge in order for _ in range(edge.rows)])
    height = len(template)

    def evaluate(this: gtsam.CustomFactor, values: gtsam.Values, blocks: list[Array] | None) -> Array:
        frames = np.array([values.atVector(key) for key in keys] + constants)
        want = blocks is not None
        error = np.empty(height)
        error[:constant] = product @ frames.ravel() - target
        jacobian = template.copy(order="F") if want else template
        if straight < constant:
            slack = error[straight:constant] <= 0.0
            error[straight:constant][slack] = 0.0
            if want:
                jacobian[straight:constant][slack] = 0.0
        for other in others:
            other.evaluate(frames, error, jacobian if want else None)
        if not math.isfinite(error.sum()) or (want and not math.isfinite(jacobian.sum())):
            raise _not_finite(order, {**fixed, **dict(zip(numbers, frames, strict=True))}, error, jacobian, rows)
        if blocks is not None:
            for k in range(len(keys)):
                blocks[k] = jacobian[:, FRAME_SIZE * k : FRAME_SIZE * (k + 1)]
        return error

    return gtsam.CustomFactor(gtsam.noiseModel.Diagonal.Precisions(gains), keys, evaluate)


def _ordered(edges: Sequence[Edge]) -> tuple[list[Edge], list[LinearFunction], int]:
    """The edges, linear ones first, then hinges, then others; functions of the first two; how many are hinges."""
    linear = [(edge, edge.function) for edge in edges if isinstance(edge.function, LinearFunction)]
    linear.sort(key=lambda each: each[1].hinge)
    others = [edge for edge in edges if not isinstance(edge.function, LinearFunction)]
    functions = [function for _, function in linear]
    return [edge for edge, _ in linear] + others, functions, sum(function.hinge for function in functions)


def _together(edges: Sequence[Edge], rows: Sequence[slice], column: Mapping[int, int]) -> list[_Single | _Batch]:
    """Edges that can be evaluated together, together."""
    kinds: dict[Hashable, list[tuple[Edge, slice]]] = {}
    for edge, at in zip(edges, rows, strict=True):
        kinds.setdefault(_point(edge).alike(), []).append((edge, at))
    made: list[_Single | _Batch] = []
    for members in kinds.values():
        many = len(members) > MOST_SINGLE
        made += [_Batch(members, column)] if many else [_Single(edge, at, column) for edge, at in members]
    return made


def _point(edge: Edge) -> PointFunction:
    """The function on one frame that an edge asks, at a frame or between two."""
    function = edge.function.point if isinstance(edge.function, BetweenFunction) else edge.function
    assert isinstance(function, PointFunction), edge.name
    return function


class _Single:
    """An edge that is evaluated alone: where its frames are read, and its error and Jacobians written."""

    def __init__(self, edge: Edge, rows: slice, column: Mapping[int, int]) -> None:
        self._edge, self._rows = edge, rows
        first = [column[n] for n in edge.frames]
        self._at = [at // FRAME_SIZE for at in first]
        self._columns = [slice(at, at + FRAME_SIZE) for at in first]

    def evaluate(self, frames: Array, error: Array, jacobian: Array | None) -> None:
        """Write the error at the frames of the stack, shape (n, 4), and the Jacobian where one is wanted."""
        try:
            error[self._rows], blocks = self._edge.function(*[frames[k] for k in self._at], jacobian is not None)
        except ArithmeticError as fault:
            name, number = self._edge.name, self._edge.frames[0]
            raise GraphError(f"{name} edge at frame {number}: {type(fault).__name__}: {fault}") from fault
        if jacobian is not None:
            for columns, block in zip(self._columns, blocks, strict=True):
                jacobian[self._rows, columns] = block


class _Batch:
    """Edges that are evaluated together: where their frames are read, and their errors and Jacobians written."""

    def __init__(self, members: Sequence[tuple[Edge, slice]], column: Mapping[int, int]) -> None:
        edges = [edge for edge, _ in members]
        points = [_point(edge) for edge in edges]
        self._function = points[0].together(points)
        self._rows = np.stack([np.arange(at.start, at.stop) for _, at in members])
        across = np.array([column[edge.frames[0]] for edge in edges])
        self._first, self._where = across // FRAME_SIZE, self._blocks(self._rows, across)
        between = [edge.function for edge in edges if isinstance(edge.function, BetweenFunction)]
        self._mixed = bool(between)
        if not between:
            return
        mixes = [edge.function if isinstance(edge.function, BetweenFunction) else None for edge in edges]
        self._share = np.array([mix.shares[0] if mix else 1.0 for mix in mixes])[:, None]
        self._offset = np.stack([mix.offset if mix else np.zeros(FRAME_SIZE) for mix in mixes])
        self._pairs = np.array([k for k, edge in enumerate(edges) if len(edge.frames) == 2], dtype=int)
        across = np.array([column[edges[k].frames[1]] for k in self._pairs], dtype=int)
        self._second, self._where_second = across // FRAME_SIZE, self._blocks(self._rows[self._pairs], across)
        self._rest = np.array([mix.shares[1] for mix in between if len(mix.shares) == 2])[:, None]

    @staticmethod
    def _blocks(rows: Array, across: Array) -> tuple[Array, Array]:
        return rows[:, :, None], across[:, None, None] + np.arange(FRAME_SIZE)

    def evaluate(self, frames: Array, error: Array, jacobian: Array | None) -> None:
        """Write the errors at the frames of the stack, shape (n, 4), and the Jacobian where one is wanted."""
        at = frames[self._first]
        if self._mixed:
            at = self._share * at + self._offset
            at[self._pairs] += self._rest * frames[self._second]
        error[self._rows], parts = self._function(at, jacobian is not None)
        if jacobian is None:
            return
        if self._mixed:
            jacobian[self._where_second] = self._rest[:, :, None] * parts[self._pairs]
            parts = self._share[:, :, None] * parts
        jacobian[self._where] = parts


def _not_finite(
    edges: Sequence[Edge], frames: dict[int, Array], error: Array, jacobian: Array, rows: Sequence[slice]
) -> GraphError:
    """The error that names the edge."""
    for edge, at in zip(edges, rows, strict=True):
        if not (np.isfinite(error[at]).all() and np.isfinite(jacobian[at]).all()):
            listed = [frames[n].tolist() for n in edge.frames]
            return GraphError(
                f"{edge.name} edge at frame {edge.frames[0]}: error {error[at].tolist()} or its Jacobian is not "
                f"finite, frames {listed}"
            )
    return GraphError(f"the sum of the edges on frames {sorted(frames)} is not finite")
