"""Named columns of numbers as a `JointLog`: which one is the time, in what unit each is."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_log import JointLog, fault_of, from_start
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.log.joint_table import lacking
from ggo_factors.support.inputs import ANGLE_LIMIT_RAD, Array

SECONDS: Mapping[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds in each unit that a time column may be in."""
SLOWEST_S = 0.5
"""A time column without a unit that rises by more in the median is not in [s]: nobody records a walk at 2 Hz."""
_TIME_NAMES = ("time", "t", "timestamp", "timestamps", "times", "elapsed", "elapsedtime", "seconds", "sec")
"""What a time column is called, without signs and its unit; the first of these that is there is taken."""
_WORDS = {
    "rad": ("rad", "rads", "radian", "radians"),
    "deg": ("deg", "degs", "degree", "degrees", "°"),
    "s": ("s", "sec", "secs", "second", "seconds"),
    "ms": ("ms", "msec", "millis", "millisecond", "milliseconds"),
    "us": ("us", "µs", "μs", "usec", "micros", "microsecond", "microseconds"),
    "ns": ("ns", "nsec", "nanos", "nanosecond", "nanoseconds"),
}
_UNITS = {word: unit for unit, words in _WORDS.items() for word in words}
_BRACKETS = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]+)[\])]\s*$")
_ENDING = re.compile(r"^(.*)[_.\s-](rad|deg|degrees|radians|s|sec|ms|us|ns)$", re.IGNORECASE)
_NO_ANGLES = {"deg/s", "rad/s", "deg/s^2", "rad/s^2", "m", "mm", "cm", "n", "nm", "n*m", "n.m", "nm/kg", "w", "v", "a"}


@dataclass(frozen=True, eq=False)
class Columns:
    """Named columns of a file or of an object.

    Attributes:
        source: where they are from, for messages.
        kind: what it is, for example ``"csv"``.
        values: a column of numbers for each name, all of shape (n,); NaN where a value is missing.
        units: what the source states of a column beside its name.
        row: what a row is called in a message, by its number from 0.
        times: in [s], where they are known and not to be found among the columns, shape (n,).
        time_source: where `times` are from.
        notes: what was decided, in words.
    """

    source: str
    kind: str
    values: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)
    row: Callable[[int], str] = lambda number: f"row {number + 1}"
    times: Array | None = None
    time_source: str = ""
    notes: tuple[str, ...] = ()


def log_of_columns(columns: Columns) -> JointLog:
    """The log of all columns but that of the time.

    Raises:
        LogError: where there is no time, it does not rise, or nothing is left beside it.
    """
    source, times, values = columns.source, columns.times, dict(columns.values)
    time_source = columns.time_source
    if times is None:
        name = time_column(tuple(values), source)
        times, time_source = _seconds(name, values.pop(name), columns), f"column {name}"
    if len(times) < 2:
        raise LogError(f"{source}: {len(times)} rows; a walk has hundreds")
    if fault := fault_of(times, columns.row):
        raise LogError(f"{source}, {fault}")
    if not values:
        raise LogError(f"{source}: no column but {time_source}")
    names = tuple(values)
    stated = {name: columns.units.get(name) or unit_in(name) for name in names}
    units = {name: unit for name, unit in stated.items() if unit and unit not in SECONDS}
    table = np.stack(list(values.values()), axis=1)
    table[np.isinf(table)] = np.nan
    return JointLog(
        from_start(times),
        table,
        names,
        source=source,
        units=units,
        encoding=columns.kind,
        time_source=time_source,
        notes=(*columns.notes, f"times from {time_source}", *lacking(table, names)),
    )


def time_column(names: tuple[str, ...], source: str) -> str:
    """The name of the column that holds the time.

    Raises:
        LogError: where none does, naming those that there are.
    """
    found = find_time(names)
    if found is None:
        raise LogError(f"{source}: no time column (time, t, timestamp; time_ms if not in s); there are {listed(names)}")
    return found


def find_time(names: tuple[str, ...]) -> str | None:
    """The name of the column that is called like the time, or None."""
    plain = {re.sub(r"[^a-z]", "", _without_unit(name).lower()): name for name in reversed(names)}
    return next((plain[word] for word in _TIME_NAMES if word in plain), None)


def unit_in(name: str) -> str | None:
    """The unit that a column's name ends in: ``hip_l_deg``, ``hip_l [rad]``, ``time (ms)``; None where in none."""
    if match := _BRACKETS.match(name):
        word = match[2].strip().lower()
        return _UNITS.get(word) or (word if word in _NO_ANGLES else None)
    match = _ENDING.match(name)
    return _UNITS[match[2].lower()] if match else None


def named_unit(word: str) -> str:
    """A unit as it stands in a file, by its short name where it has one."""
    return _UNITS.get(word.strip().lower(), word.strip())


def require_radians(log: JointLog, names: Sequence[str]) -> None:
    """Refuse values that are said to be radians and run beyond a whole turn; single wild ones are left to cleaning.

    Raises:
        LogError: naming the first row and value beyond it.
    """
    for name in names:
        column = log.values[:, log.names.index(name)]
        finite = column[np.isfinite(column)]
        if len(finite) and np.abs(np.percentile(finite, [1.0, 99.0])).max() > ANGLE_LIMIT_RAD:
            at = int(np.flatnonzero(np.abs(column) > ANGLE_LIMIT_RAD)[0])
            raise LogError(
                f"{log.source}, row {at + 1} ({log.times[at]:.2f} s): {name} is {column[at]:.4g} rad, over a turn "
                f"(limit 6.283 rad): looks like degrees; unit='deg' if so"
            )


def require_seconds(times: Array, name: str, source: str) -> None:
    """Refuse a time column without a unit that cannot be in [s].

    Raises:
        LogError: with its step, and what it should be called.
    """
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    if step > SLOWEST_S:
        raise LogError(
            f"{source}: {name} rises by {step:.6g} a row, in seconds {1.0 / step:.2g} Hz (a walk needs 12 Hz): "
            f"name the column time_ms, time_us or time_ns if it is in those"
        )


def _without_unit(name: str) -> str:
    match = _BRACKETS.match(name) or _ENDING.match(name)
    return match[1] if match and unit_in(name) else name


def _seconds(name: str, column: Array, columns: Columns) -> Array:
    """A time column in [s]."""
    missing = np.flatnonzero(~np.isfinite(column))
    if len(missing):
        raise LogError(f"{columns.source}, {columns.row(int(missing[0]))}: {name} is missing or no finite number")
    unit = columns.units.get(name) or unit_in(name)
    if unit is not None and unit not in SECONDS:
        raise LogError(f"{columns.source}: the time column {name} is in {unit!r:.20}, not in s, ms, us or ns")
    if unit is None:
        require_seconds(column, name, columns.source)
    return (column - column[0]) * SECONDS[unit or "s"] if len(column) else column
