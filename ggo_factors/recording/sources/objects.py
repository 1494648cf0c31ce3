"""Joint values from objects in memory: a mapping of arrays, or a data frame (pandas, polars)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.recording.log.joint_log import JointLog, as_column
from ggo_factors.recording.sources.columns import Columns, log_of_columns
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
    notes = (f"{', '.join(words[:8])}: no numbers, left out",) if words else ()
    times, time_source = _index_times(getattr(log, "index", None))
    return log_of_columns(Columns(kind, kind, values, {}, _row, times, time_source, notes))


def _row(number: int) -> str:
    return f"row {number}"


def _name(name: Any, kind: str) -> str:
    if not isinstance(name, str):
        raise InputError(f"{kind}: expected columns named by texts, got {name!r:.60}")
    return name


def _numbers(column: Any) -> Any:
    """A column as numbers; pandas has a value of its own for what is missing."""
    try:
        return _seconds(column.to_numpy(dtype=np.float64, na_value=np.nan))
    except (TypeError, ValueError):
        return _seconds(column)


def _seconds(values: Any) -> Any:
    """Dates and durations as seconds from the first of them; anything else as it is."""
    array = np.asarray(values)
    if array.dtype.kind not in "mM" or not array.size:
        return values
    ns = array.astype(f"{array.dtype.kind}8[ns]")
    return np.where(np.isnat(ns), np.nan, (ns - ns[0]).astype(np.int64) * 1e-9)


def _index_times(index: Any) -> tuple[Array | None, str]:
    """The times in [s] of an index of dates or durations, or of one that is named like a time; shape (n,)."""
    kind = str(getattr(index, "dtype", ""))  # by name: a date with a zone has no numpy type
    if kind.startswith(("datetime64", "timedelta64")):
        times = index.to_numpy(dtype="datetime64[ns]") if kind.startswith("date") else index.to_numpy()
        return as_column(_seconds(times), "index"), "index"
    name = getattr(index, "name", None)
    if name in ("time", "t", "timestamp"):
        return as_column(index, f"index {name}"), f"index {name}"
    return None, ""
