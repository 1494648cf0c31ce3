"""One pass over the files of a log: what each topic holds, the wanted ones decoded, and what is damaged."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ggo_factors.errors import LogError
from ggo_factors.recording.log.chunk_records import PAYLOAD
from ggo_factors.recording.log.decode import Decoder, Part, UndecodableError
from ggo_factors.recording.log.decompress import CHUNK_LIMIT
from ggo_factors.recording.log.read_damaged import Container
from ggo_factors.recording.log.records import Block, Damage

_SAMPLES = 24
"""Messages decoded of each topic to learn what it holds."""
_SURVEY = 16 * 2**20
"""Bytes read of a file without statistics to learn which topics it has."""


@dataclass
class Stream:
    """The messages of one topic and one type.

    Attributes:
        topic: its topic.
        message_type: its type, or "".
        encoding: encoding of its messages.
        expected: messages by the files' statistics, or None where one has none.
        count: messages seen; `first_ns` and `last_ns` are their least and greatest log time.
        decoders: one for each channel in each file.
        parts: what was decoded, in file order.
        problem: why it cannot be decoded, or "".
        lists: lists of names that its messages had, by their length, for messages without any.
        places: for each block with messages: file number, byte, number of the first message.
    """

    topic: str
    message_type: str
    encoding: str
    expected: int | None = None
    count: int = 0
    first_ns: int = 2**63 - 1
    last_ns: int = 0
    decoders: list[Decoder] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)
    problem: str = ""
    lists: dict[int, tuple[str, ...] | None] = field(default_factory=dict)
    places: list[tuple[int, int, int]] = field(default_factory=list)

    @property
    def shape(self) -> str:
        """The shape of its first message that was read, or ""."""
        return next((d.reading.shape for d in self.decoders if d.reading), "")

    @property
    def names(self) -> list[str]:
        """The names found, in the order of their first appearance."""
        return list(dict.fromkeys(name for decoder in self.decoders for name in decoder.names))

    @property
    def read(self) -> int:
        """Messages that were decoded."""
        return sum(d.read for d in self.decoders)

    @property
    def rate_hz(self) -> float:
        """Messages per second of log time; 0 where there are fewer than two."""
        span = (self.last_ns - self.first_ns) * 1e-9
        return (self.count - 1) / span if self.count > 1 and span > 0 else 0.0


@dataclass
class FileDamage:
    """A damage of one of the files, with the messages it took of each stream (None: not known)."""

    damage: Damage
    file: int
    path: Path
    lost: dict[tuple[str, str, str], int]


@dataclass
class Scan:
    """What one pass found.

    Attributes:
        streams: by topic, type and encoding.
        damages: in file order.
        checksums: whether any chunk carries one.
        library: the program that wrote the first file, by its own word.
        counted: whether every file carries statistics.
        undeclared: messages on channels that no file declares.
        unread: files that could not be read, and why.
    """

    streams: dict[tuple[str, str, str], Stream] = field(default_factory=dict)
    damages: list[FileDamage] = field(default_factory=list)
    checksums: bool = False
    library: str = ""
    counted: bool = True
    undeclared: int = 0
    unread: list[str] = field(default_factory=list)


Wanted = Callable[[str], Collection[str] | bool | None]


def survey(files: Sequence[Path], largest_chunk: int = CHUNK_LIMIT) -> Scan:
    """Learn what each topic is from its first messages, reading no more than needed."""

    def enough(scan: Scan, walked: int) -> bool:
        if all(s.expected is not None for s in scan.streams.values()):
            return all(s.count >= min(_SAMPLES, s.expected or 0) for s in scan.streams.values())
        return walked > _SURVEY

    return scan_files(files, lambda topic: None, None, enough, largest_chunk)


def scan_files(
    files: Sequence[Path],
    wanted: Wanted,
    progress: Callable[[float], None] | None = None,
    enough: Callable[[Scan, int], bool] | None = None,
    largest_chunk: int = CHUNK_LIMIT,
) -> Scan:
    """Walk the files of a log.

    Args:
        files: in the order of time.
        wanted: for a topic: names of the values to decode, None for all of them, False for none.
        progress: called with the part that was read, 0 to 1.
        enough: where given, only the first messages of each topic are decoded, and the pass ends once it holds.
        largest_chunk: the most that is read and unpacked as one, in [byte].

    Raises:
        LogError: where no file can be read.
    """
    scan = Scan()
    for number, path in enumerate(files):
        try:
            container = Container(path, largest_chunk)
        except LogError as error:
            if len(files) == 1:
                raise
            scan.unread.append(str(error))
            continue

        def step(part: float, number: int = number) -> None:
            if progress is not None:
                progress((number + part) / len(files))

        try:
            _scan_file(scan, container, number, wanted, step, enough)
        finally:
            container.close()
    if not scan.counted:
        for stream in scan.streams.values():
            stream.expected = None
    if len(scan.unread) == len(files):
        raise LogError(scan.unread[0])
    if progress is not None:
        progress(1.0)
    return scan


def _scan_file(
    scan: Scan,
    container: Container,
    number: int,
    wanted: Wanted,
    step: Callable[[float], None],
    enough: Callable[[Scan, int], bool] | None,
) -> None:
    decoders: dict[int, Decoder | None] = {}
    streams: dict[int, Stream] = {}
    counted = _count(scan, container)  # topics without a message, too
    for block in container.blocks(step):
        together: dict[int, list[int]] = {}
        for channel, (offsets, _) in block.records.messages.items():
            if channel not in container.channels:
                scan.undeclared += len(offsets)
                continue
            if channel not in decoders:
                streams[channel] = _stream(scan, container, channel)
                decoders[channel] = _decoder(streams[channel], container, number, channel, wanted)
            together.setdefault(id(streams[channel]), []).append(channel)
        for channels in together.values():
            sources = [(channel, decoders[channel]) for channel in channels]
            _take(block, number, streams[channels[0]], sources, enough is not None)
        if enough is not None and enough(scan, block.where):
            break
    scan.counted = scan.counted and (counted or _count(scan, container))
    scan.library = scan.library or container.library
    scan.checksums = scan.checksums or container.checksums
    for damage in sorted(container.damages, key=lambda d: d.where):
        lost: dict[tuple[str, str, str], int] = {}
        for channel, count in damage.counts.items():
            if channel in container.channels:
                key = _key(container, channel)
                lost[key] = lost.get(key, 0) + count
        scan.damages.append(FileDamage(damage, number, container.path, lost))


def _count(scan: Scan, container: Container) -> bool:
    # add what a file's statistics say
    for channel in container.channels:
        stream = _stream(scan, container, channel)
        if container.counts is not None:
            stream.expected = (stream.expected or 0) + container.counts.get(channel, 0)
    return container.counts is not None


def _key(container: Container, channel: int) -> tuple[str, str, str]:
    record = container.channels[channel]
    schema = container.schemas.get(record.schema_id)
    return record.topic, "" if schema is None else schema.name, record.encoding


def _stream(scan: Scan, container: Container, channel: int) -> Stream:
    key = _key(container, channel)
    return scan.streams.setdefault(key, Stream(*key))


def _decoder(stream: Stream, container: Container, number: int, channel: int, wanted: Wanted) -> Decoder | None:
    names = wanted(stream.topic)
    if isinstance(names, bool):
        return None
    record = container.channels[channel]
    try:
        decoder = Decoder(record, container.schemas.get(record.schema_id), names, stream.lists, (number, channel))
    except UndecodableError as error:
        stream.problem = str(error)
        return None
    stream.decoders.append(decoder)
    return decoder


def _take(
    block: Block, number: int, stream: Stream, sources: Sequence[tuple[int, Decoder | None]], sample: bool
) -> None:
    # two publishers have a channel each: their messages are numbered as they lie in the file
    found = [block.records.messages[channel] for channel, _ in sources]
    everything = np.sort(np.concatenate([offsets for offsets, _ in found]))
    windows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(block.data, np.uint8), PAYLOAD)
    ends = np.ascontiguousarray(windows[everything[[0, -1]], 15:23]).view("<u8").astype(np.int64)
    stream.first_ns = min(stream.first_ns, int(ends.min()))
    stream.last_ns = max(stream.last_ns, int(ends.max()))
    stream.places.append((number, block.where, stream.count))
    some = slice(max(0, _SAMPLES - stream.count) if sample else None)
    for (_, decoder), (offsets, sizes) in zip(sources, found, strict=True):
        if decoder is not None and len(offsets[some]):
            order = stream.count + np.searchsorted(everything, offsets[some])
            stream.parts += decoder.decode(block.data, offsets[some], sizes[some], order)
    stream.count += len(everything)
