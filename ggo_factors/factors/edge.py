"""What an edge of the gait graph is, before it becomes a GTSAM factor: a function of frames, and how much it counts."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any

import gtsam
import numpy as np

from ggo_factors.factors.checked import EdgeFunction, checked_factor, precision
from ggo_factors.support.inputs import Array

# (frames (k, 4), want_jacobian) -> (errors (k, rows), Jacobians (k, rows, 4)) of k edges on single frames; on n frames
# each (k, n, 4) and (k, rows, n, 4).
ManyFunction = Callable[[Array, bool], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class LinearFunction:
    """The function of a linear edge, of error `sum of blocks @ frames - target`, or of a hinge.

    Attributes:
        blocks: one for each frame, shape (rows, 4), Fortran order.
        target: shape (rows,).
        hinge: whether only what is above the target counts: ReLU of the error.
    """

    blocks: Sequence[Array]
    target: Array
    hinge: bool = False

    def __call__(self, *arguments: Array | bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobians."""
        error = -self.target
        for block, frame in zip(self.blocks, arguments, strict=False):  # the last argument is want_jacobian
            error = error + block @ frame
        if not self.hinge:
            return error, tuple(self.blocks)
        above = error > 0.0
        return np.where(above, error, 0.0), tuple(np.asfortranarray(above[:, None] * block) for block in self.blocks)


class PointFunction:
    """The function of an edge on one frame that can be evaluated for many such edges at once."""

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """As an `EdgeFunction`."""
        raise NotImplementedError

    def curvature(self, frame: Array) -> Array:
        """Sum over the rows of error times second derivative, shape (4, 4): what Gauss-Newton leaves out."""
        raise NotImplementedError

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        raise NotImplementedError

    @staticmethod
    def together(functions: Sequence[Any]) -> ManyFunction:
        """One function for as many frames as functions."""
        raise NotImplementedError


class NeighboursFunction:
    """The function of an edge on several neighbouring frames that is evaluated for many such edges at once."""

    def __call__(self, *arguments: Array | bool) -> tuple[Array, tuple[Array, ...]]:
        """As an `EdgeFunction`."""
        *frames, want_jacobian = arguments
        error, parts = self.together([self])(np.array([frames]), bool(want_jacobian))
        if not want_jacobian:
            return error[0], ()
        return error[0], tuple(np.asfortranarray(parts[0, :, k]) for k in range(len(frames)))

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        raise NotImplementedError

    @staticmethod
    def together(functions: Sequence[Any]) -> ManyFunction:
        """One function for as many rows of frames as functions."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge of the gait graph: an error as a function of some frames, and how much it counts.

    Attributes:
        name: what to call it in an error.
        frames: numbers of the frames that it connects.
        rows: length of its error.
        gain: it adds `gain * |error|^2 / 2` to the objective; infinite for a hard constraint.
        function: as for `checked_factor`.
        constraint: name of the constraint that the edge stands for, if it stands for one; see `rounds`.
        style: Jacobian by the step's style variable, shape (rows, k), whose product with that is added to the error;
            None where the edge is on frames only.
    """

    name: str
    frames: tuple[int, ...]
    rows: int
    gain: float
    function: EdgeFunction
    constraint: str | None = None
    style: Array | None = None

    def counting(self, gain: float, constraint: str | None = None) -> Edge:
        """The same edge with another gain."""
        return Edge(self.name, self.frames, self.rows, gain, self.function, constraint, self.style)

    def factor(self) -> gtsam.CustomFactor:
        """The edge as a GTSAM factor of its own."""
        noise = precision(self.rows, self.gain)
        if self.style is None:
            return checked_factor(self.name, self.frames, self.rows, self.function, noise)
        size = self.style.shape[1]
        return checked_factor(self.name, self.frames, self.rows, self._on_style_too, noise, style_size=size)

    def _on_style_too(self, *arguments: Array | bool) -> tuple[Array, tuple[Array, ...]]:
        *frames, style, want_jacobian = arguments
        assert self.style is not None
        error, blocks = self.function(*frames, want_jacobian)
        return error + self.style @ style, (*blocks, self.style)

    def errors(self, frames: Array, style: Array | None = None) -> Array:
        """Its error at all frames of a gait, shape (m, 4) in [rad], and the style variable, shape (k,)."""
        error = self.function(*frames[list(self.frames)], False)[0]
        return error if self.style is None or style is None else error + self.style @ style
