"""Read an MCAP file in file order: everything in it that is not damaged.

mcap's own StreamReader gives no file positions, does not recover after damage, and reads as many bytes as a damaged
length says. So this module goes from record to record itself, and mcap parses single records only.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

from ggo_factors.errors import LogError
from ggo_factors.recording.log.bag import MAGIC, check_magic
from ggo_factors.recording.log.chunk_records import (
    CHANNEL,
    HEAD,
    MESSAGE,
    SCHEMA,
    Index,
    drop_last,
    index_block,
    index_salvaging,
)
from ggo_factors.recording.log.decompress import CHUNK_LIMIT, UnpackError, over, unpack
from ggo_factors.recording.log.records import (
    ATTACHMENT,
    CHUNK,
    DATA_END,
    FOOTER,
    HEADER,
    IN_DATA,
    KNOWN,
    MESSAGE_INDEX,
    METADATA,
    STATISTICS,
    Block,
    Channel,
    Damage,
    SchemaText,
    parse_record,
)

_DATA_END = bytes([DATA_END]) + struct.pack("<Q", 4)
_FOOTER = bytes([FOOTER]) + struct.pack("<Q", 20)
_WINDOW = 4 * 2**20
"""Bytes read at a time outside chunks, and searched for the footer at the end of the file."""
_CHUNK_HEAD = struct.Struct("<QQQII")
"""Start time, end time, unpacked size, checksum, and length of the compression's name."""
_RECORD = re.compile(rb"(?=[\x05\x06\x07\x0f][\s\S]{5}\x00\x00\x00)")


class Container:
    """One pass over an MCAP file.

    Attributes:
        path: the file; `size` is its length in [byte].
        schemas: schemas by id; `channels` are the channels by id.
        counts: messages for each channel id by the file's statistics, or None where it has none to be trusted.
        damages: what was found damaged, complete once `blocks` has ended.
        checksums: whether any chunk carries one.
        library: the program that wrote the file, by its own word.
    """

    def __init__(self, path: Path, largest_chunk: int = CHUNK_LIMIT) -> None:
        """Open `path` and read its summary.

        Args:
            path: the file.
            largest_chunk: the most that is read and unpacked as one, in [byte].

        Raises:
            LogError: where it cannot be read, or is no MCAP file.
        """
        self.path = path
        self._largest = largest_chunk
        try:
            if path.exists() and not path.is_file():
                raise LogError(f"{path}: is no file; save what comes from a pipe to a file first")
            self._file = path.open("rb")
            self.size = self._file.seek(0, 2)
        except (OSError, ValueError) as error:
            raise LogError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
        self.schemas: dict[int, SchemaText] = {}
        self.channels: dict[int, Channel] = {}
        self.counts: dict[int, int] | None = None
        self.damages: list[Damage] = []
        self.checksums = False
        self.library = ""
        self._open_damage: Damage | None = None
        self._tail: Damage | None = None
        self._bare = False
        self._times = (0, 2**63)
        self._defined: set[tuple[int, bytes]] = set()
        self._end: int | None = None
        try:
            check_magic(path, self._read(0, 64), self.size)
            self._summary()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def blocks(self, progress: Callable[[float], None] | None = None) -> Iterator[Block]:
        """All records that are not damaged, in file order.

        Args:
            progress: called with the part of the file that was walked, 0 to 1.

        Raises:
            LogError: where the messages lie outside chunks and do not match the checksum of the whole data.
        """
        position = len(MAGIC)
        limit = self.size if self._end is None else self._end
        good_chunk = False
        while position < limit:
            if progress is not None:
                progress(position / self.size)
            opcode, length = self._head(position)
            end = position + HEAD + length
            if opcode in (SCHEMA, CHANNEL, MESSAGE) and end <= limit:
                block = self._stretch(position, limit)
                if block is not None:
                    self._bare = self._bare or bool(block.records.messages)
                    position += len(block.data)
                    good_chunk = False
                    self._open_damage = None
                    yield block
                    continue
            elif opcode == CHUNK and end <= limit:
                parts = self._chunk_parts(position, length)
                if parts is not None:
                    chunk = self._chunk(position, *parts)
                    good_chunk = chunk is not None
                    position = end
                    if chunk is not None:
                        self._open_damage = None
                        yield chunk
                    continue
            elif end <= limit and self._other(position, opcode, length, good_chunk):
                if opcode == DATA_END and self._end is None:
                    self._end = position
                good_chunk = good_chunk and opcode == MESSAGE_INDEX
                position = end
                continue
            good_chunk = False
            position = self._resync(position, limit, opcode, length)
        if self._end is None:
            what = f"the file ends at byte {self.size} without its end of data (recorder killed, or file cut)"
            if self._tail is None:
                self.damages.append(Damage(what, self.size, {}))
            else:
                self._tail.what += f", and {what}"
        elif self._bare:
            self._check_data()

    def _read(self, position: int, size: int) -> bytes:
        try:
            self._file.seek(position)
            return self._file.read(max(0, min(size, self.size - position)))
        except OSError as error:
            raise LogError(f"{self.path}: cannot be read at byte {position}: {error.strerror or error}") from error

    def _head(self, position: int) -> tuple[int, int]:
        head = self._read(position, HEAD)
        if len(head) < HEAD:
            return 0, 0
        return head[0], int.from_bytes(head[1:], "little")

    def _stretch(self, position: int, limit: int) -> Block | None:
        # schema, channel and message records that lie outside chunks
        data = self._read(position, min(_WINDOW, limit - position))
        index = index_block(data)
        if index.end == 0:
            _, length = self._head(position)
            if length > self._largest:
                return None
            data = self._read(position, HEAD + length)
            index = index_block(data)
            if index.end == 0:
                return None
        if not self._define(index):
            return None
        if position + index.end < self.size and self._head(position + index.end)[0] not in KNOWN:
            drop_last(index)  # damage follows, and may begin in it
        return Block(data[: index.end], index, position)

    def _chunk_parts(self, position: int, length: int) -> tuple[int, int, int, int, str, int, int] | None:
        # start, end, size, crc, compression, where the data lie and their length; None if the lengths disagree
        head = self._read(position + HEAD, _CHUNK_HEAD.size + 40)
        if len(head) < _CHUNK_HEAD.size + 8:
            return None
        start, end, size, crc, letters = _CHUNK_HEAD.unpack_from(head)
        if letters > 24 or len(head) < _CHUNK_HEAD.size + letters + 8:
            return None
        name = head[_CHUNK_HEAD.size : _CHUNK_HEAD.size + letters]
        packed = int.from_bytes(head[_CHUNK_HEAD.size + letters : _CHUNK_HEAD.size + letters + 8], "little")
        if _CHUNK_HEAD.size + letters + 8 + packed != length or not name.isascii():
            return None
        if not name and packed != size and size <= self._largest:
            return None
        return start, end, size, crc, name.decode(), position + HEAD + length - packed, packed

    def _chunk(
        self, position: int, start: int, end: int, size: int, crc: int, compression: str, at: int, packed: int
    ) -> Block | None:
        self._open_damage = None
        try:
            if packed > self._largest + 2**20:
                raise UnpackError(f"holds {over(max(packed, size), self._largest)}")
            data = unpack(self._read(at, packed), compression, size, self._largest)
            if crc and zlib.crc32(data) != crc:
                raise UnpackError("does not match its checksum (CRC)")
        except UnpackError as error:
            self._damage(f"chunk at byte {position} {error}", position, sure=True)
            return None
        self.checksums = self.checksums or crc != 0
        index = index_block(data)
        if not self._define(index):
            self._damage(f"chunk at byte {position} holds a schema or channel that cannot be read", position)
        if index.end < len(data):
            index = index_salvaging(data, self.channels, start, end)
            self._damage(f"chunk at byte {position}: its records do not follow each other", position)
        return Block(data, index, position)

    def _other(self, position: int, opcode: int, length: int, good_chunk: bool) -> bool:
        # whether any other kind of record is one that can be believed
        if opcode == MESSAGE_INDEX:
            if length < 6:
                return False
            head = self._read(position + HEAD, 6)
            channel, size = struct.unpack("<HI", head)
            if size != length - 6 or size % 16:
                return False
            if not good_chunk:
                damage = self._open_damage or self._damage(f"no chunk before the index at byte {position}", position)
                damage.counts[channel] = damage.counts.get(channel, 0) + size // 16
            return True
        if opcode >= 0x80:  # a private record; followed by another record, or it is damage
            following = self._head(position + HEAD + length)
            return following[0] in KNOWN and position + 2 * HEAD + length + following[1] <= self.size
        if self._end is None or position < self._end:
            if opcode not in IN_DATA:
                return False
        elif opcode not in KNOWN:
            return False
        if length > self._largest:
            return opcode in (ATTACHMENT, METADATA)
        if opcode == DATA_END:
            return length == 4
        if self._end is not None and opcode in (HEADER, ATTACHMENT, METADATA):
            if opcode == HEADER:
                self._library(self._read(position + HEAD, length))
            following = self._head(position + HEAD + length)
            return following[0] in KNOWN
        if opcode == STATISTICS and self.counts is None:
            record = parse_record("Statistics", self._read(position + HEAD, length))
            self.counts = None if record is None else dict(record.channel_message_counts)
        if opcode == HEADER:
            self._library(self._read(position + HEAD, length))
        return True

    def _library(self, body: bytes) -> None:
        record = parse_record("Header", body)
        self.library = "" if record is None else str(record.library)

    def _define(self, index: Index) -> bool:
        done = [self._definition(opcode, body) for opcode, body in index.definitions]
        return all(done)

    def _definition(self, opcode: int, body: bytes, sure: bool = False) -> bool:
        if not sure and (opcode, body) in self._defined:  # every chunk repeats them, thousands in a large log
            return True
        record = parse_record("Schema" if opcode == SCHEMA else "Channel", body)
        if record is None:
            return False
        self._defined.add((opcode, body))
        if opcode == SCHEMA:
            schema = SchemaText(record.name, record.encoding, record.data)
            self.schemas[record.id] = schema if sure else self.schemas.get(record.id, schema)
        else:
            channel = Channel(record.topic, record.message_encoding, record.schema_id)
            self.channels[record.id] = channel if sure else self.channels.get(record.id, channel)
        return True

    def _damage(self, what: str, where: int, sure: bool = False) -> Damage:
        self._open_damage = Damage(what, where, {}, sure)
        self.damages.append(self._open_damage)
        return self._open_damage

    def _resync(self, position: int, limit: int, opcode: int, length: int) -> int:
        # the next record that can be believed
        at = position + 1
        found = None
        while found is None and at < limit:
            window = self._read(at, min(_WINDOW, limit - at))
            for match in _RECORD.finditer(window):
                if self._believable(at + match.start(), limit):
                    found = at + match.start()
                    break
            at += max(1, len(window) - HEAD)
        if opcode == CHUNK and position + HEAD + length > limit:
            what = f"chunk at byte {position} is cut off: it needs {HEAD + length} bytes, {limit - position} are there"
        else:
            what = f"no record can be read at byte {position}"
        if self._open_damage is None:
            self._damage(what, position)
        else:  # still the same damage: nothing whole lies between
            self._open_damage.sure = False
        if found is None:
            self._tail = self._open_damage
        return limit if found is None else found

    def _believable(self, position: int, limit: int) -> bool:
        opcode, length = self._head(position)
        end = position + HEAD + length
        if end > limit:
            return False
        if opcode == CHUNK:
            return self._chunk_parts(position, length) is not None
        if opcode == MESSAGE_INDEX:
            channel, size = struct.unpack("<HI", self._read(position + HEAD, 6).ljust(6, b"\xff"))
            return length >= 6 and size == length - 6 and size % 16 == 0 and channel in self.channels
        if opcode == DATA_END:
            return length == 4 and self._head(end)[0] in KNOWN
        if length < 22 or self._head(end)[0] not in KNOWN:
            return False
        channel, _, log_time = struct.unpack("<HIQ", self._read(position + HEAD, 14))
        return self._bare and channel in self.channels and self._times[0] <= log_time <= self._times[1]

    def _summary(self) -> None:
        # definitions and statistics ahead of the walk: the first chunk, which holds them too, may be lost
        tail_start = max(len(MAGIC), self.size - _WINDOW)
        tail = self._read(tail_start, _WINDOW)
        footer = tail.rfind(_FOOTER)
        if footer < 0 or len(tail) < footer + 29:
            return
        start, _, crc = struct.unpack_from("<QQI", tail, footer + HEAD)
        at = (start if start else tail_start + footer) - len(_DATA_END) - 4
        if self._read(at, HEAD) != _DATA_END:
            at = tail_start + tail.rfind(_DATA_END, 0, footer)
            if at < tail_start:
                return
        summary = self._read(at + HEAD + 4, tail_start + footer + 25 - at - HEAD - 4)
        sure = crc == 0 or zlib.crc32(summary) == crc
        if not sure:
            self.damages.append(Damage("the summary at the file's end does not match its checksum", at, {}, True, True))
        if not sure and start and at != start - HEAD - 4:
            return
        self._end = at
        if not tail.endswith(MAGIC, footer + 29):
            what = f"the file does not end with the MCAP magic (byte {self.size})"
            self.damages.append(Damage(what, tail_start + footer + 29, {}, True, True))
        position = 0
        while position + HEAD < len(summary):
            opcode, length = summary[position], int.from_bytes(summary[position + 1 : position + HEAD], "little")
            body = summary[position + HEAD : position + HEAD + length]
            if opcode in (SCHEMA, CHANNEL):
                self._definition(opcode, body, sure)
            elif opcode == STATISTICS and sure and (record := parse_record("Statistics", body)) is not None:
                self.counts = dict(record.channel_message_counts)
                if record.message_count:
                    day = 86_400 * 10**9
                    self._times = (record.message_start_time - day, record.message_end_time + day)
            position += HEAD + length

    def _check_data(self) -> None:
        # messages outside chunks have no checksum of their own, but the data as a whole may have one
        assert self._end is not None
        crc = int.from_bytes(self._read(self._end + HEAD, 4), "little")
        if crc == 0 or self._read(self._end, HEAD) != _DATA_END:
            return
        self.checksums = True
        actual, position = 0, 0
        while position < self._end:
            data = self._read(position, min(_WINDOW, self._end - position))
            actual, position = zlib.crc32(data, actual), position + len(data)
        if actual != crc:
            raise LogError(
                f"{self.path}: the data do not match the file's checksum (CRC), and as the messages are outside chunks "
                "it is not known which are damaged"
            )
