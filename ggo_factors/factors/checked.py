"""The gate through which the custom factor of an edge is built.

GTSAM trusts what a Python callback writes into its Jacobians: an unset block, a wrong number of rows or a
1-D row is a segmentation fault, a wrong number of columns silently stops the solver at its start. So every
factor of one edge is built here, and a user can build factors of their own in the same way; `stacked` builds the only
other kind, one factor for many edges of the library.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import TypeGuard

import gtsam
import numpy as np

from ggo_factors.errors import GgoError, GraphError, InputError
from ggo_factors.support.inputs import Array, as_count, as_instance, as_tuple_of

FRAME_SIZE = 4
"""Angles of a frame: alpha1, beta1, alpha2, beta2."""
STYLE_KEY = int(gtsam.symbol("c", 0))
"""The GTSAM key of a step's style variable."""

# (frames..., want_jacobian) -> (error, jacobians); `jacobians` is not read where it was not asked for.
EdgeFunction = Callable[..., tuple[Array, Sequence[Array]]]


class CheckedFactor(gtsam.CustomFactor):
    """A custom factor every callback of which is checked.

    Attributes:
        edge: what its edge is called.
    """

    edge = ""


@cache
def frame_key(frame: int) -> int:
    """The GTSAM key of a frame, `g<frame>`."""
    return int(gtsam.symbol("g", frame))


def frame_of_key(key: int) -> int | None:
    """The frame of a GTSAM key, or None where the key is not `g<frame>`."""
    symbol = gtsam.Symbol(key)
    return int(symbol.index()) if chr(symbol.chr()) == "g" else None


def checked_factor(
    edge: str,
    frames: Sequence[int],
    rows: int,
    function: EdgeFunction,
    noise: gtsam.noiseModel.Base,
    *,
    style_size: int = 0,
) -> gtsam.CustomFactor:
    """A `gtsam.CustomFactor` on frames of a gait, every callback of which is checked.

    Args:
        edge: what to call the edge in an error.
        frames: numbers of the frames that it connects.
        rows: length of its error.
        function: `(frames..., want_jacobian) -> (error, jacobians)`: frames of shape (4,) in [rad], the error of
            shape (rows,), one Jacobian of shape (rows, 4) for each frame. Fortran order is the faster one.
        noise: noise model of dimension `rows`.
        style_size: length of the style variable, where the factor is on that too: the function then gets it after the
            frames and gives one more Jacobian, of shape (rows, style_size). 0 where it is not.

    Raises:
        InputError: where the noise model's dimension is not `rows`, or no frame is given.
        GraphError: from inside a solve, naming the edge and the frames: a wrong shape, or a value not finite.
    """
    numbers = tuple(as_count(n, f"{edge} edge: frames", 0) for n in as_tuple_of(frames, f"{edge} edge: frames", object))
    if not (numbers or style_size) or len(set(numbers)) != len(numbers):
        raise InputError(f"{edge} edge: frames {list(numbers)} must be one or more, each once")
    as_instance(noise, f"{edge} edge: noise", gtsam.noiseModel.Base)
    if noise.dim() != rows:
        raise InputError(f"{edge} edge on frames {list(numbers)}: noise of dimension {noise.dim()}, error of {rows}")
    keys = [frame_key(n) for n in numbers]
    name = f"{edge} edge at frame {numbers[0]}" if len(keys) == 1 else f"{edge} edge on frames {list(numbers)}"
    error_shape, block_shapes = (rows,), [(rows, FRAME_SIZE)] * len(keys)
    if style_size:
        keys.append(STYLE_KEY)
        block_shapes.append((rows, style_size))
        name += " and style"

    def evaluate(_: gtsam.CustomFactor, values: gtsam.Values, blocks: list[Array] | None) -> Array:
        at = [values.atVector(key) for key in keys]
        for number, frame in zip(numbers, at, strict=False):  # the style variable follows the frames
            if frame.shape != (FRAME_SIZE,):
                raise GraphError(f"{name}: the value of frame {number} has shape {frame.shape}, expected (4,)")
        try:
            error, jacobians = function(*at, blocks is not None)
        except GgoError:
            raise
        except Exception as fault:  # whatever a user's own function does, it must not reach the C++ underneath
            raise GraphError(f"{name}: {type(fault).__name__}: {fault}") from fault
        if not _is_float(error) or error.shape != error_shape:
            raise GraphError(f"{name}: error {_shape_of(error)}, expected shape {error_shape}")
        if not _all_finite(error):
            raise GraphError(f"{name}: error {error.tolist()} is not finite, frames {[f.tolist() for f in at]}")
        if blocks is not None:
            if not isinstance(jacobians, (tuple, list)) or len(jacobians) != len(keys):
                count = f"{len(jacobians)}" if isinstance(jacobians, (tuple, list)) else f"{jacobians!r:.40} for"
                raise GraphError(f"{name}: {count} Jacobians, expected {len(keys)}")
            for i, (block, block_shape) in enumerate(zip(jacobians, block_shapes, strict=True)):
                if not _is_float(block) or block.shape != block_shape:
                    raise GraphError(f"{name}: Jacobian {i} {_shape_of(block)}, expected shape {block_shape}")
                if not _all_finite(block):
                    raise GraphError(f"{name}: Jacobian {i} is not finite, frames {[f.tolist() for f in at]}")
                blocks[i] = block
        return error

    factor = CheckedFactor(noise, keys, evaluate)
    factor.edge = edge
    return factor


def precision(rows: int, gain: float) -> gtsam.noiseModel.Base:
    """The noise model of a gain: `gain * |error|^2` in the objective; an infinite gain is a hard constraint."""
    if np.isinf(gain):
        return gtsam.noiseModel.Constrained.All(rows)
    return gtsam.noiseModel.Isotropic.Precision(rows, gain)


def _all_finite(values: Array) -> bool:
    # A sum costs a fraction of isfinite().all(); where it is not finite, one value is not, or it overflowed.
    return math.isfinite(values.sum()) or bool(np.isfinite(values).all())


def _is_float(value: object) -> TypeGuard[Array]:
    return isinstance(value, np.ndarray) and value.dtype == np.float64


def _shape_of(value: object) -> str:
    return f"has shape {value.shape} of {value.dtype}" if isinstance(value, np.ndarray) else f"is {value!r:.60}"
