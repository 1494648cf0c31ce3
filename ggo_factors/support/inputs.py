"""The array type of the library, and the checks that every number passes on its way in."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from reprlib import Repr
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors.errors import InputError

Array = NDArray[np.float64]
T = TypeVar("T")

ANGLE_LIMIT_RAD = 2.0 * math.pi
"""An angle of this size or more, in [rad], is taken for degrees."""

_SHORT = Repr()
_SHORT.maxstring = 60


def as_array(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """A read-only float copy of `value`, checked to be finite and of `shape` (None: any length).

    Raises:
        InputError: naming the field, the shape, and the first value that is not finite.
    """
    array = _of_shape(value, name, shape)
    if not np.isfinite(array).all():
        raise _not_finite(array, name)
    return array


def _not_finite(array: Array, name: str) -> InputError:
    where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
    return InputError(f"{name}: value {array[where]} at {list(where)} is not finite")


def _of_shape(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    if isinstance(value, Iterator):
        value = list(value)  # read once, here
    try:
        raw = np.asarray(value)
        if np.ma.isMaskedArray(value) or (raw.size and raw.dtype.kind not in "fiu"):
            raise TypeError
        array = np.array(raw, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected numbers of shape {_words(shape)}, got {value!r:.80}") from error
    fits = array.ndim == len(shape)
    for want, got in zip(shape, array.shape, strict=False):
        fits = fits and want in (None, got)
    if not fits:
        raise InputError(f"{name}: expected shape {_words(shape)}, got {array.shape}")
    array.setflags(write=False)
    return array


def as_angles(value: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """As `as_array`, for angles in [rad]: below 2 pi in size, or they are surely degrees.

    Raises:
        InputError: also where an angle is 2 pi or more.
    """
    array = _of_shape(value, name, shape)
    if array.size and not np.abs(array).max() < ANGLE_LIMIT_RAD:  # nor where a value is not a number
        if not np.isfinite(array).all():
            raise _not_finite(array, name)
        where = tuple(int(i) for i in np.argwhere(np.abs(array) >= ANGLE_LIMIT_RAD)[0])
        raise InputError(f"{name}: angle {array[where]:.6g} rad at {list(where)} is not below 2 pi; looks like degrees")
    return array


def as_number(
    value: Any,
    name: str,
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    unit: str = "",
) -> float:
    """`value` as a finite float within its limit.

    Raises:
        InputError: naming the field, the value and the limit.
    """
    unit = f" {unit}" if unit else ""
    try:
        if isinstance(value, (str, bytes, bool)):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name}: expected a number, got {value!r:.80}") from error
    if not math.isfinite(number):
        raise InputError(f"{name}: {number}{unit} is not finite")
    if above is not None and not number > above:
        raise InputError(f"{name}: {number:g}{unit} must be above {above:g}{unit}")
    if at_least is not None and not number >= at_least:
        raise InputError(f"{name}: {number:g}{unit} must be at least {at_least:g}{unit}")
    if at_most is not None and not number <= at_most:
        raise InputError(f"{name}: {number:g}{unit} must be at most {at_most:g}{unit}")
    return number


def as_count(value: Any, name: str, at_least: int, at_most: int = 10**6) -> int:
    """`value` as a whole number from `at_least` to `at_most`.

    Raises:
        InputError: naming the field, the value and the limit.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise InputError(f"{name}: expected a whole number, got {value!r:.80}")
    if value < at_least:
        raise InputError(f"{name}: {value} must be at least {at_least}")
    if value > at_most:
        raise InputError(f"{name}: {value} must be at most {at_most}")
    return int(value)


def as_bool(value: Any, name: str) -> bool:
    """`value` as a truth value: only True and False, not what Python takes for one.

    Raises:
        InputError: naming the field and what stands there instead.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name}: expected True or False, got {_shown(value)}")
    return bool(value)


def as_progress(value: Any) -> Callable[[float], None] | None:
    """`value` as a function of the share that is done, 0 to 1; or None where nobody asks.

    Raises:
        InputError: where it cannot be called.
    """
    if value is not None and not callable(value):
        raise InputError(f"progress: expected a function of the share that is done, got {_shown(value)}")
    return value  # type: ignore[no-any-return]


def as_instance(value: Any, name: str, kind: type[T]) -> T:
    """`value`, where it is a `kind`.

    Raises:
        InputError: naming the field and what stands there instead.
    """
    if not isinstance(value, kind):
        raise InputError(f"{name}: expected a {kind.__name__}, got {_shown(value)}")
    return value


def as_tuple_of(values: Any, name: str, kind: type[T]) -> tuple[T, ...]:
    """`values`, read once, as a tuple of `kind`.

    Raises:
        InputError: naming the field and what stands there instead.
    """
    try:
        if isinstance(values, (str, bytes, Mapping)):  # they can be iterated, and are no lists of anything
            raise TypeError
        items = tuple(values)
    except TypeError as error:
        raise InputError(f"{name}: expected a list of {kind.__name__}s, got {_shown(values)}") from error
    for item in items:
        if not isinstance(item, kind):
            raise InputError(f"{name}: expected {kind.__name__}s, got {_shown(item)}")
    return items


def short_text(text: str) -> str:
    """A text in quotes for a line of a prompt, its middle left out where it is long."""
    return _SHORT.repr(text)


def _shown(value: object) -> str:
    """A short picture of a wrong value; of a plain one only, since the repr of some GTSAM objects is a crash."""
    plain = type(value).__module__.partition(".")[0] in ("builtins", "numpy")
    return f"{value!r:.80}" if plain else f"a {type(value).__name__}"


def _words(shape: tuple[int | None, ...]) -> str:
    letters = iter("mnkpq")
    inner = ", ".join(next(letters) if n is None else str(n) for n in shape)
    return f"({inner},)" if len(shape) == 1 else f"({inner})"
