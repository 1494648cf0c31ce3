"""One log of joint values, read from a recording."""

from __future__ import annotations

import bisect
import os
from collections.abc import Callable, Collection, Iterable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.bag import mcap_files
from ggo_factors.recording.log.clock import TimeLine, time_line
from ggo_factors.recording.log.decode_many import MISSING
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.log.joint_table import Rows, Table, build_table, lacking, leave_other_sources, stream_rows
from ggo_factors.recording.log.losses import Loss, find_losses
from ggo_factors.recording.log.recorder_clock import in_nanoseconds, too_fast
from ggo_factors.recording.log.sources import MixedError
from ggo_factors.recording.log.topic_streams import Scan, Stream, scan_files, survey
from ggo_factors.recording.log.topics import choose_topic, holders, of_topic, per_joint, topic_list, unread
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_count

__all__ = ["JointLog", "Loss", "joint_log", "read_log"]

_CLOCKS_APART_S = 0.05
"""Topics whose clocks differ by more in [s] are noted; a twentieth of a stride."""
_RARE = 0.01
"""A name in a smaller share of the messages than this is not taken for a joint of the topic."""


def read_log(
    path: PathLike,
    topic: str | None = None,
    names: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
    largest_chunk: int = CHUNK_MIB,
) -> JointLog:
    """Read joint values from a recording.

    Args:
        path: an MCAP file, or a rosbag2 folder.
        topic: the topic to read; None: the one that holds `names`, else the one that looks like joints.
        names: the logged values wanted, as they stand in the log; ``/topic:name`` takes one from another topic.
            None: all of the topic, or of all topics that hold one joint each.
        progress: called with the part that was read, 0 to 1.
        largest_chunk: the most of the file that is unpacked as one, in [MiB]; a damaged file may ask for any amount.

    Raises:
        InputError: where `path`, `topic` or `names` are none, or `largest_chunk` is no positive number.
        LogError: where the recording cannot be read, or does not hold what is wanted.
    """
    _check(path, topic, names)
    limit = as_count(largest_chunk, "largest_chunk", 1) * 2**20
    try:
        files, absent = mcap_files(path)
        wanted = _resolve(files, str(path), topic, names, limit)
        scan = scan_files(files, lambda t: (wanted[t] or None) if t in wanted else False, progress, largest_chunk=limit)
        return joint_log(scan, files, absent, str(path), wanted, names)
    except MemoryError as error:
        raise LogError(f"{path}: does not fit into memory") from error


def joint_log(
    scan: Scan,
    files: Sequence[Path],
    absent: Sequence[str],
    source: str,
    wanted: dict[str, dict[str, str]],
    names: Sequence[str] | None,
) -> JointLog:
    """The log of a pass in which the topics of `wanted` were decoded.

    Args:
        scan: the pass.
        files: its files; `absent` are the names of those that should be there.
        absent: names of missing files.
        source: the path as it was given.
        wanted: for each topic: names of its values, and what each is called in the log; empty: all.
        names: the columns wanted, or None.

    Raises:
        LogError: where nothing is left to read, or a name is not there.
    """
    _check_any(scan, source)
    streams = [of_topic(scan, source, topic) for topic in wanted]
    if names is None and wanted[streams[0].topic]:
        names = [alias for called in wanted.values() for alias in called.values()]
    columns = list(names) if names is not None else _columns(streams[0])
    for stream in streams:
        _check_read(stream, source, wanted[stream.topic])
    tables = [_rows(stream, wanted[stream.topic], columns, False) for stream in streams]
    if len(tables) > 1 and not _together(tables):
        for rows in tables:
            rows.line = _again(rows)
    for stream, rows in zip(streams, tables, strict=True):
        try:
            leave_other_sources(rows)
        except MixedError as error:
            raise LogError(f"{source}: {stream.topic}: {error}") from error
    apart = _clocks_apart(streams, tables)
    table = build_table(tables, columns)
    if not len(table.ns):
        raise LogError(f"{source}: {streams[0].topic}: no message has a time that can be used")
    start = int(table.ns[0])
    times = ((table.ns - start) * 1e-9).astype(np.float64)

    def around(stream: Stream, file: int, where: int) -> tuple[float | None, float | None]:
        return _around(stream, tables[streams.index(stream)], file, where, start)

    losses, notes = find_losses(scan, streams, around)
    losses += [Loss(f"{name} is listed in metadata.yaml and is not there") for name in absent]
    for stream, rows in zip(streams, tables, strict=True):
        notes += [f"{stream.topic}: {note}" if len(streams) > 1 else note for note in rows.line.notes]
        losses += [Loss(f"{stream.topic}: {why}", count) for count, why in rows.line.dropped]
        others = [s for s in scan.streams.values() if s.topic == stream.topic and s is not stream and s.count]
        notes += [f"{s.topic} has {s.count} messages of type {s.message_type} too: not read" for s in others]
    notes += apart + table.notes + lacking(table.values, columns)
    table.values.setflags(write=False)
    known = all(s.expected is not None for s in streams)
    return JointLog(
        source=source,
        topic=",".join(s.topic for s in streams),
        message_type=_once(s.message_type for s in streams),
        encoding=_once(s.encoding for s in streams),
        names=tuple(columns),
        times=times,
        values=table.values,
        time_source=_once(rows.line.source for rows in tables),
        unit="rad" if all(by_convention(s) for s in streams) else None,
        messages_read=sum(s.read for s in streams),
        messages_expected=sum(s.expected or 0 for s in streams) if known else None,
        losses=tuple(losses),
        notes=tuple(notes),
        segments=_segments(table),
    )


def by_convention(stream: Stream) -> bool:
    """Whether the convention for this type of message says radians."""
    if stream.encoding in ("cdr", "ros1"):
        return stream.shape in ("state", "list", "dynamic", "controller", "trajectory") or (
            "JointState" in stream.message_type
        )
    return "foxglove.JointState" in stream.message_type


def _check(path: PathLike, topic: str | None, names: Sequence[str] | None) -> None:
    if not isinstance(path, (str, os.PathLike)):
        raise InputError(f"path: expected a path, got {path!r:.80}")
    if topic is not None and not isinstance(topic, str):
        raise InputError(f"topic: expected a text, got {topic!r:.80}")
    if names is not None:
        if isinstance(names, str) or not all(isinstance(name, str) for name in names):
            raise InputError(f"names: expected a list of texts, got {names!r:.80}")
        if not names or len(set(names)) < len(names):
            raise InputError(f"names: expected at least one, and none twice, got {names!r:.80}")


def _resolve(
    files: Sequence[Path], source: str, topic: str | None, names: Sequence[str] | None, limit: int
) -> dict[str, dict[str, str]]:
    # for each topic to read: its own names, and what the caller calls them; empty: all of them
    if topic is not None and (names is None or not any(":" in name or name.startswith("/") for name in names)):
        return {topic: {name: name for name in names or ()}}
    scan = survey(files, limit)
    _check_any(scan, source)
    topics = {s.topic for s in scan.streams.values()}
    wanted: dict[str, dict[str, str]] = {}
    plain = []
    for name in names or ():
        head, _, tail = name.rpartition(":")
        if head in topics:
            wanted.setdefault(head, {})[tail] = name
        elif name in topics:
            single = of_topic(scan, source, name).names
            if len(single) != 1:
                raise LogError(f"{source}: {name} holds {len(single)} values, not one; name it as {name}:value")
            wanted.setdefault(name, {})[single[0]] = name
        else:
            plain.append(name)
    if names is None and topic is None and (each := per_joint(scan)):
        return {s.topic: {s.names[0]: f"{s.topic}:{s.names[0]}"} for s in each}
    if names is None or (plain and topic is not None):
        chosen = topic if topic is not None else choose_topic(scan, source, None).topic
        wanted.setdefault(chosen, {}).update({name: name for name in plain})
    elif plain:
        for name, stream in holders(scan, source, plain).items():
            wanted.setdefault(stream.topic, {})[name] = name
    return wanted


def _check_any(scan: Scan, source: str) -> None:
    if any(s.count for s in scan.streams.values()):
        return
    if scan.damages:
        found = scan.damages[0].damage.what
        raise LogError(f"{source}: nothing can be read: {found}")
    raise LogError(f"{source}: holds no message; {topic_list(scan)}")


def _check_read(stream: Stream, source: str, wanted: Collection[str]) -> None:
    if not stream.read:
        raise LogError(f"{source}: none of the {stream.count} messages of {stream.topic} can be used: {unread(stream)}")
    found = {name for d in stream.decoders for name in d.names}
    lacking = [name for name in wanted if name not in found]
    if lacking:
        raise LogError(f"{source}: {stream.topic} has no {listed(lacking)}; it has {listed(sorted(found))}")


def _columns(stream: Stream) -> list[str]:
    counts: dict[str, int] = {}
    for part in stream.parts:
        for name in part.names:
            counts[name] = counts.get(name, 0) + len(part.order)
    most = max(counts.values(), default=0)
    return [name for name, count in counts.items() if count > _RARE * most]


def _rows(stream: Stream, called: dict[str, str], columns: list[str], recorder_only: bool) -> Rows:
    mine = called or {name: name for name in columns}
    at = {name: i for i, name in enumerate(columns)}
    return stream_rows(stream, {name: at[alias] for name, alias in mine.items()}, len(columns), recorder_only)


def _together(tables: Sequence[Rows]) -> bool:
    # whether the topics run on one clock: the same source, and times that overlap
    spans = []
    for rows in tables:
        good = rows.line.ns[rows.line.ns != MISSING]
        if len(good):
            spans.append((int(good.min()), int(good.max())))
    overlap = min(b for _, b in spans) - max(a for a, _ in spans) if spans else 0
    longest = max((b - a for a, b in spans), default=0)
    return len({rows.line.source for rows in tables}) == 1 and overlap >= 0.5 * longest


def _again(rows: Rows) -> TimeLine:
    line = time_line(rows.moments, recorder_only=True)
    line.notes.append("the topics' own clocks do not agree: the recorder's is used")
    return line


def _clocks_apart(streams: Sequence[Stream], tables: Sequence[Rows]) -> list[str]:
    """Notes on topics whose own clocks differ, seen against the recorder's, at the first and last tenth of each."""
    offsets = []
    for rows in tables:
        log = in_nanoseconds(rows.moments.log)[0]
        if rows.line.source in ("log_time", "publish_time", "time_from_start") or too_fast(log):
            return []
        ahead = (rows.line.ns - log)[rows.line.ns != MISSING] * 1e-9
        tenth = max(1, len(ahead) // 10)
        offsets.append([float(np.median(ahead[:tenth])), float(np.median(ahead[-tenth:]))])
    if len(offsets) < 2:
        return []
    apart = np.array(offsets) - np.array(offsets[0])
    other = int(np.abs(apart).max(axis=1).argmax())
    first, last = apart[other].tolist()
    if max(abs(first), abs(last)) < _CLOCKS_APART_S:
        return []
    drift = f" at the start and {last:+.2f} s at the end" if abs(last - first) > _CLOCKS_APART_S else ""
    return [
        f"against the recorder's clock, {streams[other].topic} is {first:+.2f} s from {streams[0].topic}{drift}: "
        "two clocks? A leg on a clock of its own steps too early or too late"
    ]


def _around(stream: Stream, rows: Rows, file: int, where: int, start: int) -> tuple[float | None, float | None]:
    places = [(f, w) for f, w, _ in stream.places]
    at = bisect.bisect_left(places, (file, where))
    first = stream.places[at][2] if at < len(places) else stream.count
    row = int(np.searchsorted(rows.order, first))
    before = rows.line.ns[max(0, row - 50) : row]
    after = rows.line.ns[row : row + 50]
    before, after = before[before != MISSING], after[after != MISSING]
    return (
        (int(before.max()) - start) * 1e-9 if len(before) else None,
        (int(after.min()) - start) * 1e-9 if len(after) else None,
    )


def _segments(table: Table) -> tuple[tuple[int, int], ...]:
    cuts = [0, *(np.flatnonzero(np.diff(table.segment)) + 1).tolist(), len(table.ns)]
    return tuple(pairwise(cuts))


def _once(words: Iterable[str]) -> str:
    return ",".join(dict.fromkeys(words))
