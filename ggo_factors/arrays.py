"""The array type of the library, and the checks that every number passes on its way in."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors.errors import InputError

Array = NDArray[np.float64]

ANGLE_LIMIT_RAD = 2.0 * math.pi


def as_array(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """A read-only float copy of `value`, checked to be finite and of `shape` (None: any length).

    Raises:
        InputError: naming the field, the shape, and the first value that is not finite.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers of shape {_words(shape)}, got {value!r:.80}") from error
    if array.ndim != len(shape) or any(
        want is not None and want != got for want, got in zip(shape, array.shape, strict=True)
    ):
        raise InputError(f"{name}: expected shape {_words(shape)}, got {array.shape}")
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"{name}: value {array[where]} at {list(where)} is not finite")
    array.setflags(write=False)
    return array


def as_angles(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """As `as_array`, for angles in [rad]: below 2 pi in size, or they are surely degrees.

    Raises:
        InputError: also where an angle is 2 pi or more.
    """
    array = as_array(value, name, shape)
    over = np.argwhere(np.abs(array) >= ANGLE_LIMIT_RAD)
    if len(over):
        where = tuple(int(i) for i in over[0])
        raise InputError(f"{name}: angle {array[where]:.6g} rad at {list(where)} is not below 2 pi; looks like degrees")
    return array


def as_number(
    value: Any, name: str, *, above: float | None = None, at_least: float | None = None, unit: str = ""
) -> float:
    """`value` as a finite float within its limit.

    Raises:
        InputError: naming the field, the value and the limit.
    """
    unit = f" {unit}" if unit else ""
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected a number, got {value!r:.80}") from error
    if not math.isfinite(number):
        raise InputError(f"{name}: {number}{unit} is not finite")
    if above is not None and not number > above:
        raise InputError(f"{name}: {number:g}{unit} must be above {above:g}{unit}")
    if at_least is not None and not number >= at_least:
        raise InputError(f"{name}: {number:g}{unit} must be at least {at_least:g}{unit}")
    return number


def as_count(value: Any, name: str, at_least: int) -> int:
    """`value` as a whole number of at least `at_least`.

    Raises:
        InputError: naming the field, the value and the limit.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise InputError(f"{name}: expected a whole number, got {value!r:.80}")
    if value < at_least:
        raise InputError(f"{name}: {value} must be at least {at_least}")
    return int(value)


def _words(shape: tuple[int | None, ...]) -> str:
    letters = iter("mnk")
    inner = ", ".join(next(letters) if n is None else str(n) for n in shape)
    return f"({inner},)" if len(shape) == 1 else f"({inner})"
