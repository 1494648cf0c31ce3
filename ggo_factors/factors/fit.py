"""Whether a user's factor fits frames of four angles, asked before it is taken into a graph."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from weakref import WeakSet

import gtsam
import numpy as np

from ggo_factors.errors import GgoError, InputError
from ggo_factors.factors.checked import FRAME_SIZE, CheckedFactor, frame_of_key
from ggo_factors.factors.child import answer_of_child
from ggo_factors.support.inputs import Array

BESIDE = 0.1
"""A raw factor is also evaluated so far from the base gait in [rad]: its function may have two branches."""
HINT = "; ggo.checked_factor says what is wrong with a Jacobian"
_FITS: WeakSet[gtsam.CustomFactor] = WeakSet()
"""Raw factors that a child process has evaluated: once is enough."""


def frames_of(factor: gtsam.NonlinearFactor, name: str = "factor") -> list[int]:
    """The numbers of the frames that a user's factor connects.

    Raises:
        InputError: where a key is not that of a frame.
    """
    numbers = []
    for key in factor.keys():
        number = frame_of_key(key)
        if number is None:
            raise InputError(f"{name}: key {gtsam.DefaultKeyFormatter(key)} is not gtsam.symbol('g', frame)")
        numbers.append(number)
    return numbers


def require_fit(factor: gtsam.NonlinearFactor, frames: Array, name: str = "factor") -> None:
    """Evaluate a user's factor once, where a misfit is still an error with a name.

    A raw `gtsam.CustomFactor`, which may kill the interpreter, is evaluated in a child process first.

    Args:
        factor: a factor on keys `g<frame>`.
        frames: frames in [rad], shape (m, 4), to evaluate it on.
        name: what to call it in an error.

    Raises:
        InputError: where it has no noise model, does not fit frames of four angles, is not finite, or kills the
            interpreter.
        GraphError: where it is one of `checked_factor` and wrong in itself.
    """
    if isinstance(factor, gtsam.NoiseModelFactor) and factor.noiseModel() is None:
        raise InputError(f"{name}: it has no noise model")
    here = _values_of(factor, frames)

    def with_beside() -> str:
        said = _misfit(factor, here)
        for offset in (BESIDE, -BESIDE):
            factor.linearize(_values_of(factor, frames + offset))
        return said

    require_survivable(factor, with_beside, name)
    try:
        said = _misfit(factor, here)
    except GgoError:
        raise
    except Exception as fault:
        raise InputError(f"{name}: does not fit frames of four angles: {type(fault).__name__}: {fault}") from fault
    if said:
        raise InputError(f"{name}: {said}")


def require_survivable(factor: gtsam.NonlinearFactor, work: Callable[[], str], name: str = "factor") -> None:
    """Evaluate a raw custom factor in a child process; one of `checked_factor`, or of GTSAM's own, kills nothing.

    Args:
        factor: the factor.
        work: evaluates it, and returns what is wrong, or nothing.
        name: what to call it in an error.

    Raises:
        InputError: where something is wrong, the work raises, or dies.
    """
    if not isinstance(factor, gtsam.CustomFactor) or isinstance(factor, CheckedFactor) or factor in _FITS:
        return
    said = answer_of_child(work)
    if said is None:
        warnings.warn(f"{name}: a raw custom factor that could not be tried in a child process", stacklevel=2)
    elif said:
        raise InputError(f"{name}: {said}{HINT}")
    _FITS.add(factor)


def _misfit(factor: gtsam.NonlinearFactor, values: gtsam.Values) -> str:
    """What is wrong with a factor there, or nothing."""
    wanted = FRAME_SIZE * len(factor.keys())
    linear = factor.linearize(values)
    jacobian = np.array(linear.getA()) if isinstance(linear, gtsam.JacobianFactor) else np.zeros((0, wanted))
    rows = len(factor.unwhitenedError(values)) if isinstance(factor, gtsam.NoiseModelFactor) else factor.dim()
    columns = jacobian.shape[1]
    # BetweenFactorVector takes a vector of any length and compares as many angles as it has.
    measured = len(factor.measured()) if isinstance(factor, gtsam.BetweenFactorVector) else FRAME_SIZE
    if columns != wanted or rows != factor.dim() or measured != FRAME_SIZE:
        return f"does not fit frames of four angles: {rows} rows, {columns} columns, {measured} measured"
    if not (math.isfinite(factor.error(values)) and np.isfinite(jacobian).all()):
        return "its error or Jacobian is not finite on the base gait"
    return ""


def _values_of(factor: gtsam.NonlinearFactor, frames: Array) -> gtsam.Values:
    """Values of a factor's variables, taken from frames in [rad], shape (m, 4)."""
    values = gtsam.Values()
    for key in sorted(set(factor.keys())):
        values.insert(key, frames[frame_of_key(key)])
    return values
