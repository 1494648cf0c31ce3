"""What a recording holds: topics, joints, units and damage, at a glance."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ggo_factors.errors import LogError
from ggo_factors.recording.log.bag import mcap_files
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.losses import Loss, find_losses
from ggo_factors.recording.log.read_log import joint_log
from ggo_factors.recording.log.topic_streams import Scan, Stream, scan_files, survey
from ggo_factors.recording.log.topics import choose_topic, per_joint, rank, unread
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_count, short_text

_RADIANS = 6.8
"""Greater values are not radians: even angles wrapped at 2 pi stay below it."""
_STILL = 0.35
"""Where no value moves by more, whether in radians or in degrees, the unit cannot be told."""
_HIP = re.compile(r"hip|thigh|upper_?leg|femur", re.IGNORECASE)
_KNEE = re.compile(r"knee|shank|shin|lower_?leg|tibia", re.IGNORECASE)
_LEFT = re.compile(r"left|(?:^|[^a-z])l(?:[^a-z]|$)|^l(?=hip|knee|thigh|shank)|(?<=hip|nee)l$", re.IGNORECASE)
_RIGHT = re.compile(r"right|(?:^|[^a-z])r(?:[^a-z]|$)|^r(?=hip|knee|thigh|shank)|(?<=hip|nee)r$", re.IGNORECASE)
_OTHER_AXIS = re.compile(
    r"add|abd|rot|roll|yaw|vel|effort|torque|moment|current|(?:^|_)(?:aa|ie)(?:_|$)", re.IGNORECASE
)


@dataclass(frozen=True)
class TopicSummary:
    """A topic.

    Attributes:
        topic: its name.
        message_type: type of its messages, or "".
        encoding: their encoding.
        count: messages that are there.
        expected: messages by the file's statistics, or None.
        rate_hz: messages per second of log time.
        duration_s: from the first to the last in [s].
        problem: why it cannot be decoded, or "".
    """

    topic: str
    message_type: str
    encoding: str
    count: int
    expected: int | None
    rate_hz: float
    duration_s: float
    problem: str


@dataclass(frozen=True)
class JointSummary:
    """A logged value.

    Attributes:
        topic: its topic.
        name: what it is called in the log.
        low: its 1st percentile in the unit of the log, or None where no value is there.
        high: its 99th percentile.
        missing: how many samples lack it.
        looks_like: ``"left_hip"``, ``"left_knee"``, ``"right_hip"``, ``"right_knee"``, or "".
    """

    topic: str
    name: str
    low: float | None
    high: float | None
    missing: int
    looks_like: str


@dataclass(frozen=True)
class LogSummary:
    """What a recording holds.

    Attributes:
        source: the path as it was given.
        files: how many files it has; `size_bytes` is their length.
        library: the program that wrote it, by its own word.
        checksums: whether it carries any.
        duration_s: from the first to the last message in [s].
        topics: all topics.
        topic: the topic (or topics, separated by commas) that an import would take, or None where it has to be told.
        joints: the values of every topic that looks like joints.
        time_source: where the times of `topic` come from, or None.
        unit: ``"rad"`` where convention says so, else None.
        unit_guess: what the values look like: ``"rad"``, ``"deg"``, or None where that cannot be told.
        unit_why: why.
        losses: what was lost.
        notes: what else there is to say, in words.
    """

    source: str
    files: int
    size_bytes: int
    library: str
    checksums: bool
    duration_s: float
    topics: tuple[TopicSummary, ...]
    topic: str | None
    joints: tuple[JointSummary, ...]
    time_source: str | None
    unit: str | None
    unit_guess: str | None
    unit_why: str
    losses: tuple[Loss, ...] = ()
    notes: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        found = f"{len(self.topics)} topics, {len(self.joints)} joint values, {self.duration_s:.4g} s"
        return f"LogSummary({short_text(self.source)}, {found}{', damaged' if self.damaged else ''})"

    def _repr_html_(self) -> str:
        from ggo_factors.notebook.card import card  # only here: nothing but a notebook needs it

        facts = {
            "size": f"{self.size_bytes / 1e6:.2f} MB, {self.duration_s:.4g} s",
            "topics": [f"{topic.topic}: {topic.count} of {topic.message_type or '-'}" for topic in self.topics],
            "joint values": [f"{joint.topic} {joint.name} {joint.looks_like}" for joint in self.joints],
            "an import takes": self.topic or "no topic: it has to be told",
            "unit": f"{self.unit_guess or 'not known'}: {self.unit_why}",
            "lost": list(map(str, self.losses)),
            "notes": self.notes,
        }
        return card(f"Log: {self.source}", facts)

    @property
    def damaged(self) -> bool:
        """Whether anything was lost."""
        return bool(self.losses)

    def to_json(self) -> dict[str, Any]:
        """The summary as JSON values."""
        values = asdict(self)
        values["losses"] = [asdict(loss) | {"text": str(loss)} for loss in self.losses]
        return {"format_version": 1, **values, "damaged": self.damaged}


def inspect_log(
    path: PathLike, progress: Callable[[float], None] | None = None, *, largest_chunk: int = CHUNK_MIB
) -> LogSummary:
    """Say what a recording holds.

    Args:
        path: an MCAP file, or a rosbag2 folder.
        progress: called with the part that was read, 0 to 1.
        largest_chunk: the most of the file that is unpacked as one, in [MiB].

    Raises:
        LogError: where nothing in it can be read.
    """
    limit = as_count(largest_chunk, "largest_chunk", 1) * 2**20
    try:
        files, absent = mcap_files(path)
        first = survey(files, limit)
        looked_at = {s.topic for s in first.streams.values() if rank(s) > 0}
        scan = scan_files(files, lambda topic: None if topic in looked_at else False, progress, largest_chunk=limit)
        for key, stream in scan.streams.items():
            stream.problem = stream.problem or (_problem(first.streams[key]) if key in first.streams else "")
        return _summary(scan, files, absent, str(path))
    except MemoryError as error:
        raise LogError(f"{path}: does not fit into memory") from error


def _summary(scan: Scan, files: Sequence[Path], absent: Sequence[str], source: str) -> LogSummary:
    streams = list(scan.streams.values())
    if not any(s.count for s in streams) and scan.damages:
        raise LogError(f"{source}: nothing can be read: {scan.damages[0].damage.what}")
    chosen: list[Stream] = []
    notes: list[str] = []
    try:
        chosen = per_joint(scan) or [choose_topic(scan, source, None)]
    except LogError as error:
        notes.append(str(error).removeprefix(f"{source}: ").split("; topics:")[0])
    named = len(chosen) > 1
    logs: list[JointLog] = []
    if named:
        called = {s.topic: {s.names[0]: f"{s.topic}:{s.names[0]}"} for s in chosen}
        _read(logs, notes, scan, files, absent, source, called)
    for stream in streams:
        if stream.read and not named and (rank(stream) > 1 or stream in chosen):
            _read(logs, notes, scan, files, absent, source, {stream.topic: {}})
    main = next((log for log in logs if log.topic == ",".join(s.topic for s in chosen)), None)
    if main is None:
        losses, more = find_losses(scan, streams, lambda *_: (None, None))
        losses += [Loss(f"{name} is listed in metadata.yaml and is not there") for name in absent]
    else:
        losses, more = list(main.losses), list(main.notes)
    joints = tuple(joint for log in logs for joint in _joints(log))
    guess, why = _unit(main)
    seen = [s for s in streams if s.count]
    span = max((s.last_ns for s in seen), default=0) - min((s.first_ns for s in seen), default=0)
    return LogSummary(
        source=source,
        files=len(files),
        size_bytes=sum(file.stat().st_size for file in files),
        library=scan.library,
        checksums=scan.checksums,
        duration_s=span * 1e-9,
        topics=tuple(_topic(s) for s in streams),
        topic=None if main is None else main.topic,
        joints=joints,
        time_source=None if main is None else main.time_source,
        unit=None if main is None else main.unit,
        unit_guess=guess,
        unit_why=why,
        losses=tuple(losses),
        notes=(*notes, *more),
    )


def _read(
    logs: list[JointLog],
    notes: list[str],
    scan: Scan,
    files: Sequence[Path],
    absent: Sequence[str],
    source: str,
    wanted: dict[str, dict[str, str]],
) -> None:
    try:
        logs.append(joint_log(scan, files, absent, source, wanted, None))
    except LogError as error:
        notes.append(str(error).removeprefix(f"{source}: "))


def _problem(stream: Stream) -> str:
    why = unread(stream)  # a message without numbers is none of joints, and no problem
    return "" if why == "no numbers" else why


def _topic(stream: Stream) -> TopicSummary:
    span = (stream.last_ns - stream.first_ns) * 1e-9 if stream.count else 0.0
    return TopicSummary(
        stream.topic,
        stream.message_type,
        stream.encoding,
        stream.count,
        stream.expected,
        stream.rate_hz,
        span,
        _problem(stream),
    )


def _joints(log: JointLog) -> list[JointSummary]:
    ranges = [_range(column) for column in log.values.T]
    roles = _roles(log.names, ranges)
    return [
        JointSummary(
            topic=name.rpartition(":")[0] if "," in log.topic else log.topic,
            name=name,
            low=None if span is None else span[0],
            high=None if span is None else span[1],
            missing=int(np.isnan(column).sum()),
            looks_like=roles.get(name, ""),
        )
        for name, column, span in zip(log.names, log.values.T, ranges, strict=True)
    ]


def _range(column: np.ndarray[Any, np.dtype[np.float64]]) -> tuple[float, float] | None:
    finite = column[np.isfinite(column)]
    if not len(finite):
        return None
    low, high = np.percentile(finite, (1, 99))
    return float(low), float(high)


def _roles(names: Sequence[str], ranges: Sequence[tuple[float, float] | None]) -> dict[str, str]:
    # of several that are called alike (three axes of a hip), the one that moves most bends forward and back
    best: dict[str, tuple[bool, float, str]] = {}
    for name, span in zip(names, ranges, strict=True):
        joint = "knee" if _KNEE.search(name) else "hip" if _HIP.search(name) else ""
        left, right = bool(_LEFT.search(name)), bool(_RIGHT.search(name))
        if not joint or left == right:
            continue
        moves = 0.0 if span is None else span[1] - span[0]
        role = f"{'left' if left else 'right'}_{joint}"
        best[role] = max(best.get(role, (False, -1.0, "")), (not _OTHER_AXIS.search(name), moves, name))
    return {name: role for role, (_, _, name) in best.items()}


def _unit(log: JointLog | None) -> tuple[str | None, str]:
    if log is None:
        return None, "no topic holds joints for certain"
    ranges = [_range(column) for column in log.values.T]
    roles = _roles(log.names, ranges)
    spans = [r for name, r in zip(log.names, ranges, strict=True) if r and (not roles or name in roles)]
    if not spans:
        return log.unit, "convention" if log.unit else "no values"
    low, high = min(s[0] for s in spans), max(s[1] for s in spans)
    seen = f"values from {low:.3g} to {high:.3g}"
    if max(-low, high) > _RADIANS:
        return "deg", f"{seen}: too great for radians{', which convention asks for' if log.unit else ''}"
    if log.unit:
        return log.unit, f"by convention of {log.message_type}, and {seen}"
    if max(s[1] - s[0] for s in spans) < _STILL:
        return None, f"{seen}: the values move too little to tell"
    return "rad", f"{seen}: too small for degrees; no convention says so"


def summary_of(log: JointLog, size_bytes: int) -> LogSummary:
    """What a log that was read from a table holds.

    Args:
        log: the log.
        size_bytes: length of its file, 0 where there is none.
    """
    duration = float(log.times[-1] - log.times[0])
    count, rate = len(log.times), (len(log.times) - 1) / duration
    stated = set(log.units.values()) & {"rad", "deg"}
    if len(stated) == 1:
        guess, why = stated.pop(), "stated by the source"
    elif stated:
        guess, why = None, "the source states degrees and radians, each value its own"
    else:
        guess, why = _unit(log)
    return LogSummary(
        source=log.source,
        files=int(size_bytes > 0),
        size_bytes=size_bytes,
        library="",
        checksums=False,
        duration_s=duration,
        topics=(TopicSummary(log.topic, log.message_type, log.encoding, count, None, rate, duration, ""),),
        topic=log.topic,
        joints=tuple(_joints(log)),
        time_source=log.time_source,
        unit=log.unit,
        unit_guess=guess,
        unit_why=why,
        losses=log.losses,
        notes=log.notes,
    )
