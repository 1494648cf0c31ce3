"""A block of schema, channel and message records: where each message of each channel lies in it.

Runs of records of equal length are found with numpy; alternating topics fall back to one record at a time.
"""

from __future__ import annotations

import re
import struct
from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

SCHEMA, CHANNEL, MESSAGE = 3, 4, 5
"""Opcodes of the records that a chunk may hold."""
HEAD = 9
"""Bytes of a record's opcode and length."""
PAYLOAD = 31
"""Bytes of a message record before its data: head, channel id, sequence, log time, publish time."""
_head = struct.Struct("<BQH").unpack_from
_FIRST = 16
"""Records that are compared before a longer run of equal ones is tried: topics that alternate end a run at once."""
_DAY = 86_400 * 10**9
"""How far in [ns] a message found in a damaged chunk may lie outside the chunk's own times and be believed."""

Offsets = NDArray[np.int64]
Bytes = NDArray[np.uint8]


@dataclass
class Index:
    """What lies in a block.

    Attributes:
        messages: for each channel id, offset and length (with its head) of each message, in file order.
        definitions: opcode and body of each schema and channel record.
        end: offset behind the last record that was understood.
        gaps: stretches [a, b) that hold no records, and were skipped.
    """

    messages: dict[int, tuple[Offsets, Offsets]]
    definitions: list[tuple[int, bytes]]
    end: int
    gaps: list[tuple[int, int]] = field(default_factory=list)


def index_block(data: bytes) -> Index:
    """Find the records of a block, up to the first thing that is no schema, channel or message record."""
    view = np.frombuffer(data, np.uint8)
    found: defaultdict[int, list[tuple[int, int, int]]] = defaultdict(list)
    definitions: list[tuple[int, bytes]] = []
    position, size = 0, len(data)
    wait, patience = 0, 1
    while position + HEAD + 2 <= size:
        opcode, length, channel = _head(data, position)
        total = HEAD + length
        if position + total > size:
            break
        if opcode == MESSAGE:
            if total < PAYLOAD:
                break
            if wait:
                wait -= 1
                found[channel].append((position, total, 1))
                position += total
                continue
            count = _run(view, position, total, (size - position) // total)
            patience = 1 if count >= 4 else min(2 * patience, 256)
            wait = 0 if count >= 4 else patience
            found[channel].append((position, total, count))
            position += total * count
        elif opcode in (SCHEMA, CHANNEL):
            definitions.append((opcode, data[position + HEAD : position + total]))
            position += total
        else:
            break
    return Index({channel: _spread(runs) for channel, runs in found.items()}, definitions, position)


def index_salvaging(data: bytes, channels: Collection[int], start_ns: int, end_ns: int) -> Index:
    """As `index_block`, looking for the next message wherever the chain of records breaks.

    A message found so is believed only where its channel is known and its log time lies near [start_ns, end_ns]; the
    last one before a break is not, for the damage may begin in it.
    """
    index = index_block(data)
    while index.end < len(data):
        broken = index.end
        drop_last(index)
        at = next_message(data, broken + 1, channels, start_ns - _DAY, end_ns + _DAY)
        index.gaps.append((broken, len(data) if at is None else at))
        if at is None:
            break
        more = index_block(data[at:])
        for channel, (offsets, sizes) in more.messages.items():
            known = index.messages.get(channel, (np.empty(0, np.int64), np.empty(0, np.int64)))
            index.messages[channel] = (np.append(known[0], offsets + at), np.append(known[1], sizes))
        index.definitions += more.definitions
        index.end = at + more.end
    return index


def drop_last(index: Index) -> None:
    """Take the last message out of an index."""
    last = max(index.messages, key=lambda c: int(index.messages[c][0][-1]), default=None)
    if last is None:
        return
    offsets, sizes = index.messages[last]
    index.messages[last] = offsets[:-1], sizes[:-1]
    if len(offsets) == 1:
        del index.messages[last]


def next_message(data: bytes, start: int, channels: Collection[int], low: int, high: int) -> int | None:
    """Offset of the next plausible message record at or after `start`, or None."""
    for match in re.compile(rb"\x05(?=[\s\S]{4}\x00{4})").finditer(data, start):
        at = match.start()
        if at + PAYLOAD > len(data):
            return None
        length, channel, _, log_time = struct.unpack_from("<QHIQ", data, at + 1)
        end = at + HEAD + length
        good = length >= PAYLOAD - HEAD and end <= len(data) and channel in channels and low <= log_time <= high
        if good and (end == len(data) or data[end] in (SCHEMA, CHANNEL, MESSAGE)):
            return at
    return None


def rows_of(data: bytes, offsets: Offsets, total: int) -> Bytes:
    """The records of `total` bytes at `offsets` as rows, shape (len(offsets), total); a view where they adjoin."""
    view = np.frombuffer(data, np.uint8)
    first = int(offsets[0])
    if int(offsets[-1]) - first == (len(offsets) - 1) * total:
        return view[first : first + len(offsets) * total].reshape(-1, total)
    windows = as_strided(view, (len(view) - total + 1, total), (1, 1), writeable=False)
    rows: Bytes = windows[offsets]
    return rows


def _run(view: Bytes, position: int, total: int, most: int) -> int:
    # how many records from here have the same opcode, length and channel
    count = 1
    for limit in (_FIRST, most):
        limit = min(limit, most)
        heads = view[position : position + limit * total].reshape(limit, total)[:, : HEAD + 2]
        same = (heads == heads[0]).all(axis=1)
        count = limit if same.all() else int(same.argmin())
        if count < limit or limit == most:
            break
    return count


def _spread(runs: list[tuple[int, int, int]]) -> tuple[Offsets, Offsets]:
    first, total, count = np.array(runs, np.int64).T
    if len(runs) == 1:
        return first[0] + total[0] * np.arange(count[0]), np.full(count[0], total[0])
    within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    return np.repeat(first, count) + np.repeat(total, count) * within, np.repeat(total, count)
