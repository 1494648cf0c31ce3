"""The rows of one or several topics as one table: equal times merged, values published separately put together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ggo_factors.recording.log.clock import Moments, TimeLine, spread_bursts, time_line
from ggo_factors.recording.log.decode import Part
from ggo_factors.recording.log.decode_many import MISSING, Times
from ggo_factors.recording.log.sources import SAME_SENDER, one_source
from ggo_factors.recording.log.topic_streams import Stream
from ggo_factors.support.inputs import Array

BRIDGE_S = 0.15
"""Longest gap in [s] that is bridged by interpolation: over the bend of a swinging knee still right to some degrees."""

_ABSURD = 1e12
"""No angle in any unit, and no count of an encoder, is this large: such a value is damage."""


Source = tuple[int, int, str, tuple[str, ...]]


@dataclass
class Rows:
    """The decoded rows of one stream in file order.

    Attributes:
        values: shape (n, columns of the whole table).
        order: number of each row's message, shape (n,).
        group: which of the stream's sets of names each row belongs to, shape (n,).
        groups: the columns of each set.
        source: who sent each row, as far as the log tells, shape (n,).
        sources: file, channel, frame and joints that each number stands for.
        line: times of the rows.
        moments: the clocks they were told from.
    """

    values: Array
    order: Times
    group: Times
    groups: list[list[int]]
    source: Times
    sources: list[Source]
    line: TimeLine
    moments: Moments


@dataclass
class Table:
    """One table over time.

    Attributes:
        ns: times in [ns], strictly increasing, shape (n,).
        values: shape (n, columns).
        segment: number of the stretch between clock steps, shape (n,).
        notes: what was decided, in words.
    """

    ns: Times
    values: Array
    segment: Times
    notes: list[str] = field(default_factory=list)


def stream_rows(stream: Stream, columns: dict[str, int], width: int, recorder_only: bool = False) -> Rows:
    """The rows of a stream; its parts are used up.

    Args:
        stream: a stream with decoded parts.
        columns: for each name of the stream that is taken, its column.
        width: columns of the whole table.
        recorder_only: leave the messages' own times aside.
    """
    parts: list[Part] = stream.parts
    stream.parts = []
    n = sum(len(part.order) for part in parts)
    groups = _groups([part.names for part in parts], columns)
    values = np.full((n, width), np.nan)
    order, group, log, publish, source = (np.empty(n, np.int64) for _ in range(5))
    sources: dict[Source, int] = {}
    whole = [p.stamps is not None and p.stamps.dtype == np.int64 for p in parts]
    plain = bool(parts) and not any(whole) and any(p.stamps is not None for p in parts)
    stamps: Any = np.full(n, np.nan) if plain else np.full(n, MISSING)
    points = np.zeros(n, np.int64)
    start = 0
    while parts:
        part = parts.pop(0)
        end = start + len(part.order)
        taken = [i for i, name in enumerate(part.names) if name in columns]
        values[start:end, [columns[part.names[i]] for i in taken]] = part.values[:, taken]
        first = columns[part.names[taken[0]]] if taken else -1
        group[start:end] = next((g for g, members in enumerate(groups) if first in members), -1)
        sent = (*part.source, tuple(sorted(name for name in part.names if name in columns)))
        source[start:end] = sources.setdefault(sent, len(sources))
        order[start:end], log[start:end], publish[start:end] = part.order, part.log, part.publish
        if part.stamps is not None and part.stamps.dtype == stamps.dtype:
            stamps[start:end] = part.stamps
        if part.points is not None:
            points[start:end] = part.points
        start = end
    if n and (np.diff(order) < 0).any():
        by = np.lexsort((points, order))
        values, order, group, log, publish, stamps, source = (
            a[by] for a in (values, order, group, log, publish, stamps, source)
        )
    relative = stream.shape == "trajectory"
    notes: list[str] = []
    keep = (group >= 0) & _first_of_copies(log, stamps, values, notes)
    if not keep.all():
        values, order, group, log, publish, stamps, source = (
            a[keep] for a in (values, order, group, log, publish, stamps, source)
        )
    if relative:
        walked = _walked(stamps, order, values, notes)
        values, order, group, log, publish, stamps, source = (
            a[walked] for a in (values, order, group, log, publish, stamps, source)
        )
    with np.errstate(invalid="ignore"):
        values[~(np.abs(values) < _ABSURD)] = np.nan
    stamp = next((d.reading.stamp for d in stream.decoders if d.reading and d.reading.stamp), None)
    moments = Moments(
        None if stamp is None and not relative else stamps,
        log,
        publish,
        "time_from_start" if relative else "" if stamp is None else stamp.path,
        None if stamp is None else stamp.scale,
        relative,
    )
    line = time_line(moments, recorder_only)
    line.notes += notes
    return Rows(values, order, group, groups, source, list(sources), line, moments)


def leave_other_sources(rows: Rows) -> None:
    """Take out the rows of sources that do not move, with a note.

    Raises:
        MixedError: where several sources move differently.
    """
    if rows.moments.relative:
        return  # trajectories overtake each other as they are meant to
    for number, columns in enumerate(rows.groups):
        mine = np.flatnonzero((rows.group == number) & (rows.line.ns != MISSING))
        present, source = np.unique(rows.source[mine], return_inverse=True)
        sources = [rows.sources[i] for i in present.tolist()]
        called = [_called(sent, sources) for sent in sources]
        keep = one_source(rows.values[mine][:, columns], rows.line.ns[mine], source, called, rows.line.notes)
        if keep is not None:
            rows.group[mine[~keep]] = -1


def _called(sent: Source, sources: list[Source]) -> str:
    # what tells a source from the others
    words = [
        f"{word} {sent[i]!r}" if i == 2 else f"{word} {sent[i]}"
        for i, word in ((0, "file"), (1, "channel"), (2, "frame"))
        if len({other[i] for other in sources}) > 1
    ]
    return " ".join(words) or f"{SAME_SENDER} {len(sent[3])} joints"


def build_table(streams: Sequence[Rows], names: Sequence[str]) -> Table:
    """Bring the rows of all streams to one time line, that of the set of names with the most rows.

    Args:
        streams: their rows.
        names: names of the columns.
    """
    notes: list[str] = []
    tables: list[tuple[list[int], Table]] = []
    for rows in streams:
        for number, columns in enumerate(rows.groups):
            mine = (rows.group == number) & (rows.line.ns != MISSING)
            if mine.any():
                whole = bool(mine.all())
                tables.append((columns, _one(rows, mine, whole, columns, notes)))
    if not tables:
        return Table(np.empty(0, np.int64), np.empty((0, len(names))), np.empty(0, np.int64), notes)
    best = max(range(len(tables)), key=lambda i: len(tables[i][1].ns))
    columns, base = tables[best]
    if len(tables) == 1 and len(columns) == len(names):
        return Table(base.ns, base.values[:, np.argsort(columns)], base.segment, notes)
    values = np.full((len(base.ns), len(names)), np.nan)
    values[:, columns] = base.values
    turn = _turn([table for _, table in tables])
    for i, (others, table) in enumerate(tables):
        if i != best:
            values[:, others] = _at(base.ns, table, turn)
            called = ", ".join(names[c] for c in others[:4]) + (", ..." if len(others) > 4 else "")
            notes.append(f"{called}: logged separately, interpolated to the times of {names[columns[0]]}")
    return Table(base.ns, values, base.segment, notes)


def lacking(values: Array, names: Sequence[str]) -> list[str]:
    """A line for each column of `values`, shape (n, len(names)), that lacks some."""
    counts = np.isnan(values).sum(axis=0)
    return [
        f"{name}: {count} of {len(values)} values are missing (NaN, infinite, null, no number, or not logged)"
        for name, count in zip(names, counts.tolist(), strict=True)
        if count
    ]


def _groups(sets: list[tuple[str, ...]], columns: dict[str, int]) -> list[list[int]]:
    # columns that occur together in any message form one group
    groups: list[set[int]] = []
    for names in dict.fromkeys(sets):
        mine = {columns[name] for name in names if name in columns}
        if mine:
            touched = [g for g in groups if g & mine]
            groups = [g for g in groups if not g & mine] + [mine.union(*touched)]
    return [sorted(g) for g in sorted(groups, key=min)]


def _first_of_copies(log: Times, stamps: Any, values: Array, notes: list[str]) -> NDArray[np.bool_]:
    """Mask of the rows without those that repeat an earlier one bit for bit: a file given twice."""
    first = np.ones(len(log), bool)
    if (np.diff(log) < 0).any():
        keys = np.column_stack([log, stamps.view(np.int64), values.view(np.int64)])
        first[:] = False
        first[np.unique(keys, axis=0, return_index=True)[1]] = True
        if not first.all():
            notes.append(f"{int((~first).sum())} samples are in the recording twice (a file given twice?): left out")
    return first


def _walked(starts: Times, order: Times, values: Array, notes: list[str]) -> NDArray[np.bool_]:
    """Mask of the points of trajectories without those behind the start of the next trajectory."""
    first = np.flatnonzero(np.append(True, np.diff(order) != 0)) if len(order) else np.empty(0, np.int64)
    walked = np.ones(len(order), bool)
    again = 0
    for a, b, c in zip(first, first[1:], [*first[2:], len(order)], strict=False):
        walked[a:b] = (starts[a:b] < starts[b]) | (starts[b] == MISSING)
        again += int(walked[a:b].all() and np.array_equal(values[a:b], values[b:c]))
    if not walked.all():
        notes.append(f"{int((~walked).sum())} points of trajectories were overtaken by the next one: left out")
    if again:
        notes.append(f"{again} times a trajectory repeats the one before it: its strides count each time")
    return walked


def _one(rows: Rows, mine: NDArray[np.bool_], whole: bool, columns: list[int], notes: list[str]) -> Table:
    ns, segment, values = rows.line.ns, rows.line.segment, rows.values
    if not whole:
        ns, segment, values = ns[mine], segment[mine], values[mine]
    if len(columns) < values.shape[1]:
        values = values[:, columns]
    if (np.diff(ns) < 0).any():
        by = np.lexsort((ns, segment))
        ns, segment, values = ns[by], segment[by], values[by]
    recorded = rows.line.source in ("log_time", "publish_time")
    if rows.line.source != "time_from_start":  # a stamp may be the time of receipt
        spread = spread_bursts(ns)
        if spread is not None and (recorded or not _repeats(values)):
            ns = spread
            notes.append("the messages were recorded in bursts: their times are spread evenly over each burst")
    ties = np.diff(ns) == 0
    if not ties.any():
        return Table(ns, values, segment)
    first = np.append(True, ~ties)
    head = np.maximum.accumulate(np.where(first, np.arange(len(ns)), 0))
    with np.errstate(invalid="ignore"):
        other = ~first & ((values != values[head]) & np.isfinite(values)).any(axis=1)
    values = values.copy()
    for i in np.flatnonzero(~first):  # a later row only fills what the first one lacks
        lacking = np.isnan(values[head[i]])
        values[head[i], lacking] = values[i, lacking]
    same = int((~first).sum() - other.sum())
    if other.any():
        notes.append(f"{int(other.sum())} messages have the time of an earlier one but other values: dropped")
    if same:
        notes.append(f"{same} messages repeat the time and the values of an earlier one: dropped")
    return Table(ns[first], values[first], segment[first])


def _turn(tables: Sequence[Table]) -> float:
    """A whole turn in the unit of a log, told by its largest values: 2 pi, 360, or none."""
    values = np.abs(np.concatenate([table.values.ravel() for table in tables]))
    largest = float(np.nanpercentile(values, 99.9)) if np.isfinite(values).any() else 0.0
    return 2.0 * np.pi if largest < 6.6 else 360.0 if 150.0 < largest < 366.0 else np.inf


def _repeats(values: Array) -> bool:
    # whether most rows are as the one before: copies, not a burst
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    return bool(same.all(axis=1).mean() > 0.5)


def _at(ns: Times, table: Table, turn: float) -> Array:
    # the values of a table at other times, between two samples that lie close enough
    right = np.searchsorted(table.ns, ns)
    inside = (right > 0) & (right < len(table.ns))
    right = np.clip(right, 1, max(1, len(table.ns) - 1))
    if len(table.ns) < 2:
        out = np.full((len(ns), table.values.shape[1]), np.nan)
        out[ns == table.ns[0]] = table.values[0]
        return out
    left = right - 1
    gap = (table.ns[right] - table.ns[left]).astype(float)
    part = np.clip((ns - table.ns[left]) / gap, 0, 1)[:, None]
    low, high = table.values[left], table.values[right]
    between = low + part * (high - low)
    # a wrapped angle has no value between a whole turn and 0
    with np.errstate(invalid="ignore"):
        wrapped = np.abs(high - low) > 0.5 * turn
        between = np.where(wrapped, np.where(part < 0.5, low, high), between)
    between = np.where(part == 0, low, np.where(part == 1, high, between))
    usable = inside & (gap <= BRIDGE_S * 1e9) & (table.segment[left] == table.segment[right])
    usable |= (ns == table.ns[left]) | (ns == table.ns[right])
    return np.where(usable[:, None], between, np.nan)
