"""Many CDR messages of one layout decoded at once.

A template is made from one message, walked by its schema. Every other message of the same length whose layout bytes
are the same has its numbers at the same places: one comparison and one copy decode all of them. A changed order or
list of names changes layout bytes, so it never passes for the same.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ggo_factors.recording.log.chunk_records import Bytes
from ggo_factors.recording.log.message_shapes import Lists, Reading, read_shape
from ggo_factors.recording.log.ros2_definitions import Messages
from ggo_factors.recording.log.walk_cdr import CdrError, Slot, walk
from ggo_factors.support.inputs import Array

MISSING = np.iinfo(np.int64).min
"""Stands for a time that is not there, among times in [ns]."""
Times = NDArray[np.int64]


class Template:
    """The places of names, values and times in all messages of one layout.

    Attributes:
        reading: shape, names and problem of these messages.
        names: names of the values that are taken.
        left: bytes behind the last field of each, beyond what writers pad.
    """

    def __init__(
        self, data: bytes, kind: str, messages: Messages, wanted: Collection[str] | None, lists: Lists | None = None
    ) -> None:
        """Make a template from one message.

        Args:
            data: the message, of type `kind` in `messages`.
            kind: short name of its type.
            messages: what its schema defines.
            wanted: names of the values to take; None: all.
            lists: names of earlier messages, for one that lacks them.

        Raises:
            CdrError: where it does not fit its schema.
        """
        walked = walk(data, kind, messages)
        self.reading: Reading = read_shape(walked.tree, lists)
        self.left = walked.left
        raw = np.frombuffer(data, np.uint8)
        layout = walked.layout
        # Names beside as many numbers show that the schema fits; numbers alone do not, and then only zeros may follow.
        if walked.left and self.reading.shape in ("values", ""):
            layout = [*layout, (len(data) - walked.left, len(data))]
            if raw[-walked.left :].any():
                raise CdrError(f"has {walked.left} bytes too many for its schema")
        self._layout = [(a, b, raw[a:b]) for a, b in layout]
        keep = [i for i, name in enumerate(self.reading.names) if wanted is None or name in wanted]
        self.names = tuple(self.reading.names[i] for i in keep)
        if not self.reading.problem:
            self._points = len(self.reading.rows)
            self._values = _plan([row[i] for row in self.reading.rows for i in keep])
            self._stamp = _plan(list(self.reading.stamp.parts)) if self.reading.stamp else None
            self._offsets = _plan([part for pair in self.reading.offsets for part in pair])

    def matches(self, rows: Bytes) -> NDArray[np.bool_]:
        """Which of the messages in `rows`, shape (m, size), have this layout: shape (m,)."""
        same = np.ones(len(rows), bool)
        for a, b, bytes_ in self._layout:
            equal = rows[:, a:b] == bytes_
            if not equal.all():
                same &= equal.all(axis=1)
        return same

    def values(self, rows: Bytes) -> Array:
        """The values in `rows`: shape (m times the points of a message, len(names))."""
        return _take(rows, self._values).reshape(len(rows) * self._points, len(self.names))

    def points(self) -> int:
        """How many rows of values a message has."""
        return self._points

    def stamps(self, rows: Bytes) -> Times | Array | None:
        """The messages' own times: whole [ns], or plain numbers where their unit is not known; shape (m,)."""
        stamp = self.reading.stamp
        if stamp is None or self._stamp is None:
            return None
        parts = _take(rows, self._stamp)
        if len(stamp.parts) == 1:
            number: Array = parts[:, 0]
            return number
        return nanoseconds(parts[:, 0], parts[:, 1])

    def offsets(self, rows: Bytes) -> Times | None:
        """Times of the points of trajectories after their messages' own in [ns], shape (m, points), or None."""
        if not self.reading.offsets:
            return None
        pairs = _take(rows, self._offsets).reshape(len(rows), -1, 2)
        return nanoseconds(pairs[..., 0], pairs[..., 1])


def nanoseconds(seconds: Array, nanos: Array) -> Times:
    """Seconds and nanoseconds as one whole number; `MISSING` where they are no time."""
    good = (np.abs(seconds) < 2**33) & (nanos >= 0) & (nanos < 1e9)
    times = np.where(good, seconds, 0).astype(np.int64) * 10**9 + np.where(good, nanos, 0).astype(np.int64)
    return np.where(good, times, MISSING)


def _plan(slots: list[Any]) -> tuple[int, list[tuple[int, int, int, str]]]:
    # how many columns; and for each run of adjoining numbers: column, offset, count, type
    runs: list[tuple[int, int, int, str]] = []
    for column, slot in enumerate(slots):
        if not isinstance(slot, Slot):
            continue
        if runs:
            start, offset, count, code = runs[-1]
            if column == start + count and code == slot.code and slot.offset == offset + count * int(code[2]):
                runs[-1] = (start, offset, count + 1, code)
                continue
        runs.append((column, slot.offset, 1, slot.code))
    return len(slots), runs


def _take(rows: Bytes, plan: tuple[int, list[tuple[int, int, int, str]]]) -> Array:
    columns, runs = plan
    out = np.full((len(rows), columns), np.nan)
    for column, offset, count, code in runs:
        part = np.ascontiguousarray(rows[:, offset : offset + count * int(code[2])])
        out[:, column : column + count] = part.view(code)
    return out
