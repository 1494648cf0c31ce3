"""Logged joint values over time, whatever they were read from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.recording.log.losses import Loss
from ggo_factors.support.inputs import Array, as_array, short_text

NANOSECONDS = 1e9
"""Nanoseconds in a second: times are kept to the nanosecond, as in MCAP, so that a log is the same from any source."""
COLUMNS = "columns"
"""What stands for the topic where values come from columns and not from messages."""


@dataclass(frozen=True, eq=False)
class JointLog:
    """Logged joint values over time.

    Attributes:
        times: times in [s], strictly increasing, shape (n,); an import counts them from the first one.
        values: values as they were logged (NaN where missing), in the unit of the log, shape (n, len(names)); or a
            mapping of names to arrays of shape (n,).
        names: what was logged, as it stands in the log: a name, a path ``left.hip``, ``data[3]``, ``/left_hip:data``;
            left out where `values` is a mapping.
        unit: ``"rad"`` or ``"deg"``, where convention or the maker of the log says so, else None (not known).
        source: where the values are from, for messages: a path, or a few words.
        units: units that the source itself states, by name (``"rad"``, ``"deg"``, others for what is no angle): they
            come before those of a joint map.
        topic: topic, or topics separated by commas.
        message_type: type of the messages, for example ``"sensor_msgs/msg/JointState"``.
        encoding: their encoding, for example ``"cdr"``.
        time_source: ``"publish_time"``, ``"log_time"``, ``"time_from_start"``, or the field or column that the times
            come from, for example ``"header.stamp"``.
        messages_read: messages of the topic that were read; rows where there are none.
        messages_expected: messages of the topic by the file's own statistics, or None where it has none.
        losses: what was lost, each with its place.
        notes: decisions that were taken, in words.
        segments: index ranges [a, b) between which time may not be bridged; one range when all is well.

    Raises:
        InputError: where times do not rise, shapes do not fit, or a name stands twice.
    """

    times: Array
    values: Array
    names: tuple[str, ...] = ()
    unit: str | None = None
    source: str = "JointLog"
    units: Mapping[str, str] = field(default_factory=dict)
    topic: str = COLUMNS
    message_type: str = ""
    encoding: str = "numbers"
    time_source: str = "times"
    messages_read: int = -1
    messages_expected: int | None = None
    losses: tuple[Loss, ...] = ()
    notes: tuple[str, ...] = ()
    segments: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        names, values = _columns(self.names, self.values, self.source)
        times = as_array(self.times, f"{self.source}: times", (None,))
        if fault := fault_of(times):
            raise InputError(f"{self.source}, {fault}")
        if values.ndim != 2 or values.shape != (len(times), len(names)):
            raise InputError(
                f"{self.source}: values: expected shape ({len(times)}, {len(names)}) for {len(times)} times and "
                f"{len(names)} names, got {values.shape}"
            )
        if self.unit not in (None, "rad", "deg"):
            raise InputError(f"{self.source}: unit: expected 'rad' or 'deg', got {self.unit!r:.40}")
        values.setflags(write=False)
        own = {
            "times": times,
            "values": values,
            "names": names,
            "units": MappingProxyType(dict(self.units)),
            "messages_read": len(times) if self.messages_read < 0 else self.messages_read,
            "segments": self.segments or ((0, len(times)),),
        }
        for name, value in own.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"JointLog({short_text(self.source)}, {len(self.names)} names, {self._extent()})"

    def _repr_html_(self) -> str:
        from ggo_factors.notebook.card import card  # only here: nothing but a notebook needs it

        facts = {
            "source": self.source,
            "topic": f"{self.topic} {self.message_type}",
            "values": self._extent(),
            "names": ", ".join(self.names),
            "unit": self.unit or "not known",
            "times": self.time_source,
            "lost": list(map(str, self.losses)),
            "notes": self.notes,
        }
        return card("Joint log", facts)

    def _extent(self) -> str:
        """How many values there are over which time, in words."""
        seconds = float(self.times[-1] - self.times[0]) if len(self.times) else 0.0
        return f"{len(self.times)} rows, {seconds:.4g} s"


def from_start(times: Array) -> Array:
    """Times in [s] from the first one on, to the nanosecond; shape (n,)."""
    start = times[0] if len(times) else 0.0
    return np.asarray(np.rint((times - start) * NANOSECONDS) * 1e-9, dtype=np.float64)


def fault_of(times: Array, row: Callable[[int], str] = lambda number: f"row {number + 1}") -> str:
    """What is wrong with times in [s], shape (n,), that do not rise, or nothing.

    Args:
        times: the times.
        row: what a row is called, by its number from 0.
    """
    stands = np.flatnonzero(~(np.diff(times) > 0.0))
    if not len(stands):
        return ""
    at = int(stands[0]) + 1
    return f"{row(at)}: time {times[at]:.10g} s is not after {times[at - 1]:.10g} s of {row(at - 1)}: times must rise"


def _columns(names: Any, values: ArrayLike | Mapping[str, ArrayLike], source: str) -> tuple[tuple[str, ...], Array]:
    """The names and their values side by side."""
    if isinstance(values, Mapping):
        if len(names):
            raise InputError(f"{source}: names: leave them out where the values are a mapping, which has its own")
        names = tuple(values)
        columns = [as_column(value, f"{source}: {name}") for name, value in values.items()]
        lengths = {name: len(column) for name, column in zip(names, columns, strict=True)}
        if len(set(lengths.values())) > 1:
            raise InputError(f"{source}: columns of different lengths: {str(lengths)[1:80]}")
        values = np.stack(columns, axis=1) if columns else np.empty((0, 0))
    names = tuple(names)
    if not names or not all(isinstance(name, str) for name in names):
        raise InputError(f"{source}: names: expected a text for each value, got {names!r:.80}")
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{source}: two columns are named {twice!r}")
    if isinstance(values, np.ndarray) and values.dtype == np.float64 and not values.flags.writeable:
        return names, values  # nobody changes it any more
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{source}: values: expected numbers, got {values!r:.60}") from error
    return names, array


def as_column(value: ArrayLike, name: str) -> Array:
    """One column of numbers, NaN where there is none, shape (n,).

    Raises:
        InputError: where it is not numbers, or has another shape.
    """
    try:
        column = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers, got {value!r:.60}") from error
    if column.ndim != 1:
        raise InputError(f"{name}: expected numbers of shape (n,), got shape {column.shape}")
    return column
