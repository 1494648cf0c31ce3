"""Many edges in one custom factor: the same sum of squares for a fraction of the callbacks.

GTSAM's optimizers hand each callback of a Python factor a copy of all variables, which costs more than most edges do.
A stack gets that copy once for all its edges, and evaluates the linear ones as one product.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence

import gtsam
import numpy as np

from ggo_factors.errors import GraphError
from ggo_factors.factors.between import BetweenFunction
from ggo_factors.factors.checked import FRAME_SIZE, STYLE_KEY, frame_key
from ggo_factors.factors.edge import Edge, LinearFunction, NeighboursFunction, PointFunction
from ggo_factors.support.inputs import Array

MOST_SINGLE = 2
"""Up to so many edges of a kind are evaluated one by one: setting up a batch costs more than it saves for them."""


def stacked_factor(edges: Sequence[Edge], fixed: Mapping[int, Array], style_size: int = 0) -> gtsam.CustomFactor:
    """One factor for several soft edges, on all their frames but those that are fixed, and on the style variable.

    Args:
        edges: edges of finite gain; their functions are `LinearFunction`, `PointFunction`, `BetweenFunction` and
            `NeighboursFunction`.
        fixed: frames that are no variables, each (4,) in [rad].
        style_size: length of the style variable where an edge is on it, else 0.

    Raises:
        GraphError: from inside a solve, naming the edge: a value not finite.
    """
    straight, hinges, others = _by_kind(edges)
    order = [*straight, *hinges, *others]
    # Fixed frames have columns behind the variables' where an edge that is not linear has them.
    variables: set[int] = set()
    bent: set[int] = set()
    for edge in order:
        variables.update(edge.frames)
    for edge in others:
        bent.update(edge.frames)
    numbers = sorted(variables.difference(fixed))
    keys = list(map(frame_key, numbers))
    held = list(bent.intersection(fixed))
    numbers += held
    constants = list(map(fixed.__getitem__, held))
    column = dict(zip(numbers, range(0, FRAME_SIZE * len(numbers), FRAME_SIZE), strict=True))
    rows, gains, height = [], [], 0
    for edge in order:
        rows.append(slice(height, height + edge.rows))
        gains += [edge.gain] * edge.rows
        height += edge.rows
    template = np.zeros((height, FRAME_SIZE * len(numbers)), order="F")
    target = _linear_part(order, rows, column, fixed, template)
    constant = len(target)
    first_hinge = rows[len(straight) - 1].stop if straight else 0
    evaluated = _together(others, rows[len(order) - len(others) :], column)
    by_style = np.zeros((height, style_size), order="F")
    for edge, at in zip(order, rows, strict=True) if style_size else ():
        if edge.style is not None:
            by_style[at] = edge.style
    product = np.hstack([template[:constant], by_style[:constant]])

    def evaluate(this: gtsam.CustomFactor, values: gtsam.Values, blocks: list[Array] | None) -> Array:
        frames = np.array([*map(values.atVector, keys), *constants])
        want = blocks is not None
        error = np.empty(height)
        known = np.append(frames, values.atVector(STYLE_KEY)) if style_size else frames.ravel()
        error[:constant] = product @ known - target
        jacobian = template.copy(order="F") if want else template
        if first_hinge < constant:
            slack = error[first_hinge:constant] <= 0.0
            error[first_hinge:constant][slack] = 0.0
            if want:
                jacobian[first_hinge:constant][slack] = 0.0
        for other in evaluated:
            other.evaluate(frames, error, jacobian if want else None)
        if not math.isfinite(error.sum()) or (want and not math.isfinite(jacobian.sum())):
            raise _not_finite(order, {**fixed, **dict(zip(numbers, frames, strict=True))}, error, jacobian, rows)
        if blocks is not None:
            for k in range(len(keys)):
                blocks[k] = jacobian[:, FRAME_SIZE * k : FRAME_SIZE * (k + 1)]
            if style_size:
                blocks[len(keys)] = by_style
        return error

    asked = [*keys, STYLE_KEY] if style_size else keys
    return gtsam.CustomFactor(gtsam.noiseModel.Diagonal.Precisions(np.array(gains)), asked, evaluate)


def _linear_part(
    edges: Sequence[Edge], rows: Sequence[slice], column: Mapping[int, int], fixed: Mapping[int, Array], template: Array
) -> Array:
    """Targets of the edges that are linear, or hinges, which come first; their Jacobians go into the template."""
    target, constant = np.zeros(len(template)), 0
    for edge, at in zip(edges, rows, strict=True):
        function = edge.function
        if not isinstance(function, LinearFunction):
            break
        constant = at.stop
        target[at] += function.target
        for n, block in zip(edge.frames, function.blocks, strict=True):
            if n in column:
                template[at, column[n] : column[n] + FRAME_SIZE] = block
            else:
                target[at] -= block @ fixed[n]
    return target[:constant]


def _by_kind(edges: Sequence[Edge]) -> tuple[list[Edge], list[Edge], list[Edge]]:
    """The linear edges, the hinges, and the others."""
    straight, hinges, others = [], [], []
    for edge in edges:
        if not isinstance(edge.function, LinearFunction):
            others.append(edge)
        elif edge.function.hinge:
            hinges.append(edge)
        else:
            straight.append(edge)
    return straight, hinges, others


def _together(
    edges: Sequence[Edge], rows: Sequence[slice], column: Mapping[int, int]
) -> list[_Single | _Batch | _Neighbours]:
    """Edges that can be evaluated together, together."""
    kinds: dict[Hashable, list[tuple[Edge, slice]]] = {}
    for edge, at in zip(edges, rows, strict=True):
        asked = edge.function if isinstance(edge.function, NeighboursFunction) else _point(edge)
        kinds.setdefault(asked.alike(), []).append((edge, at))
    made: list[_Single | _Batch | _Neighbours] = []
    for members in kinds.values():
        if isinstance(members[0][0].function, NeighboursFunction):
            made.append(_Neighbours(members, column))
        elif len(members) > MOST_SINGLE:
            made.append(_Batch(members, column))
        else:
            for edge, at in members:
                made.append(_Single(edge, at, column))
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
        self._at, self._columns = [], []
        for n in edge.frames:
            self._at.append(column[n] // FRAME_SIZE)
            self._columns.append(slice(column[n], column[n] + FRAME_SIZE))

    def evaluate(self, frames: Array, error: Array, jacobian: Array | None) -> None:
        """Write the error at the frames of the stack, shape (n, 4), and the Jacobian where one is wanted."""
        try:
            error[self._rows], blocks = self._edge.function(*frames[self._at], jacobian is not None)
        except ArithmeticError as fault:
            name, number = self._edge.name, self._edge.frames[0]
            raise GraphError(f"{name} edge at frame {number}: {type(fault).__name__}: {fault}") from fault
        if jacobian is not None:
            for columns, block in zip(self._columns, blocks, strict=True):
                jacobian[self._rows, columns] = block


class _Batch:
    """Edges that are evaluated together: where their frames are read, and their errors and Jacobians written."""

    def __init__(self, members: Sequence[tuple[Edge, slice]], column: Mapping[int, int]) -> None:
        points, rows, columns, mixes = [], [], [], []
        for edge, at in members:
            points.append(_point(edge))
            rows.append(np.arange(at.start, at.stop))
            columns.append(column[edge.frames[0]])
            if isinstance(edge.function, BetweenFunction):
                mixes.append(edge.function)
        self._function = points[0].together(points)
        self._rows, across = np.stack(rows), np.array(columns)
        self._first, self._where = (
            across // FRAME_SIZE,
            (self._rows[:, :, None], across[:, None, None] + np.arange(FRAME_SIZE)),
        )
        self._mixed = bool(mixes)
        if self._mixed:
            self._mix(members, column)

    def _mix(self, members: Sequence[tuple[Edge, slice]], column: Mapping[int, int]) -> None:
        """Where and how much the edges between two frames read each of them."""
        functions = [edge.function if isinstance(edge.function, BetweenFunction) else None for edge, _ in members]
        self._share = np.array([mix.shares[0] if mix else 1.0 for mix in functions])[:, None]
        self._offset = np.stack([mix.offset if mix else np.zeros(FRAME_SIZE) for mix in functions])
        self._pairs = np.array([k for k, (edge, _) in enumerate(members) if len(edge.frames) == 2], dtype=int)
        across = np.array([column[members[k][0].frames[1]] for k in self._pairs], dtype=int)
        self._second, self._where_second = (
            across // FRAME_SIZE,
            (
                self._rows[self._pairs][:, :, None],
                across[:, None, None] + np.arange(FRAME_SIZE),
            ),
        )
        self._rest = np.array([mix.shares[1] for mix in functions if mix and len(mix.shares) == 2])[:, None]

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


class _Neighbours:
    """Edges on as many neighbouring frames each that are evaluated together."""

    def __init__(self, members: Sequence[tuple[Edge, slice]], column: Mapping[int, int]) -> None:
        functions, rows, columns = [], [], []
        for edge, at in members:
            functions.append(edge.function)
            rows.append(np.arange(at.start, at.stop))
            columns.append([column[n] for n in edge.frames])
        assert isinstance(functions[0], NeighboursFunction)
        self._function = functions[0].together(functions)
        self._rows, across = np.stack(rows), np.array(columns)
        self._at = across // FRAME_SIZE
        self._where = self._rows[:, :, None, None], across[:, None, :, None] + np.arange(FRAME_SIZE)

    def evaluate(self, frames: Array, error: Array, jacobian: Array | None) -> None:
        """As `_Batch.evaluate`."""
        error[self._rows], parts = self._function(frames[self._at], jacobian is not None)
        if jacobian is not None:
            jacobian[self._where] = parts


def _not_finite(
    edges: Sequence[Edge], frames: dict[int, Array], error: Array, jacobian: Array, rows: Sequence[slice]
) -> GraphError:
    """The error that names the edge."""
    for edge, at in zip(edges, rows, strict=True):
        if edge.frames and not (np.isfinite(error[at]).all() and np.isfinite(jacobian[at]).all()):
            listed = [frames[n].tolist() for n in edge.frames]
            return GraphError(
                f"{edge.name} edge at frame {edge.frames[0]}: error {error[at].tolist()} or its Jacobian is not "
                f"finite, frames {listed}"
            )
    return GraphError(f"the sum of the edges on frames {sorted(frames)} is not finite")
