"""Joint values from objects in memory: a mapping of arrays, or a data frame (pandas, polars)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.recording.log.joint_log import JointLog, as_column
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.sources.columns import Columns, find_time, log_of_columns
from ggo_factors.support.inputs import Array


def is_frame(log: Any) -> bool:
    """Whether an object is a data frame, by what it can do: no package is needed to tell."""
    return hasattr(log, "columns") and hasattr(log, "shape") and hasattr(log, "__getitem__")


def log_of_mapping(log: Mapping[Any, Any]) -> JointLog:
    """The log of a mapping of names to arrays of one length, one of them the time.

    Raises:
        InputError: where a column is no row of numbers, or has another length than the others.
        LogError: where the log is of no use: no time, times that do not rise.
    """
    columns = {_name(name, "mapping"): as_column(_seconds(values), f"mapping: {name}") for name, values in log.items()}
    lengths = {name: len(column) for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise InputError(f"mapping: columns of different lengths: {str(lengths)[1:-1]:.80}")
    return log_of_columns(Columns("mapping", "arrays", columns))


def log_of_frame(log: Any) -> JointLog:
    """The log of a data frame: a column for the time, or an index of times.

    Raises:
        InputError: where a name is no text, or stands twice.
        LogError: where the log is of no use: no time, times that do not rise.
    """
    kind = type(log).__name__
    names = [_name(name, kind) for name in log.columns]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{kind}: two columns are named {twice!r:.60}")
    values: dict[str, Array] = {}
    words = []
    for name in names:
        try:
            values[name] = as_column(_numbers(log[name]), name)
        except InputError:
            words.append(name)
    notes = (f"{listed(words)}: no numbers, left out",) if words else ()
    times, time_source, values = _with_index(log, kind, values)
    return log_of_columns(Columns(kind, kind, values, {}, _row, times, time_source, notes))


def _with_index(log: Any, kind: str, values: dict[str, Array]) -> tuple[Array | None, str, dict[str, Array]]:
    """Times in [s] where the index of a frame holds them, and its columns, the index among them where it has a name."""
    index = getattr(log, "index", None)
    if index is None or find_time(tuple(values)) is not None:
        return None, "", values
    if _kind(index).startswith(("datetime64", "timedelta64")):
        return as_column(_numbers(index), f"{kind}: index"), "index", values
    if not _kind(index).startswith(("float", "int")):
        return None, "", values
    column = as_column(_numbers(index), f"{kind}: index")
    if index.name is not None:
        return None, "", {_name(index.name, kind): column, **values}
    # unnamed: whole numbers count the rows
    return (column, "index", values) if _kind(index).startswith("float") else (None, "", values)


def _row(number: int) -> str:
    return f"row {number}"


def _name(name: Any, kind: str) -> str:
    if not isinstance(name, str):
        raise InputError(f"{kind}: expected columns named by texts, got {name!r:.60}")
    return name


def _kind(column: Any) -> str:
    """The type of a column by its name: a date with a time zone has no numpy type."""
    return str(getattr(column, "dtype", "")).lower()


def _numbers(column: Any) -> Any:
    """A column of a frame as numbers; pandas has a value of its own for what is missing."""
    if _kind(column).startswith("datetime64"):
        return _seconds(column.to_numpy(dtype="datetime64[ns]"))
    if _kind(column).startswith("timedelta64"):
        return _seconds(column.to_numpy())
    try:
        return column.to_numpy(dtype=np.float64, na_value=np.nan)
    except (TypeError, ValueError):
        return _seconds(column)


def _seconds(values: Any) -> Any:
    """Dates and durations as seconds from the first of them; anything else as it is."""
    array = np.asarray(values)
    if array.dtype.kind not in "mM" or not array.size:
        return values
    ns = array.astype(f"{array.dtype.kind}8[ns]")
    known = ~np.isnat(ns)
    seconds = np.full(len(ns), np.nan)
    seconds[known] = (ns[known] - ns[known][:1]).astype(np.int64) * 1e-9
    return seconds
