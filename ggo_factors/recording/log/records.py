"""The records of an MCAP file that the reader uses."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from typing import Any, NamedTuple

from ggo_factors.recording.log.chunk_records import Index

HEADER, FOOTER, CHUNK, MESSAGE_INDEX, ATTACHMENT, STATISTICS, METADATA, DATA_END = 1, 2, 6, 7, 9, 11, 12, 15
"""Opcodes of records outside chunks."""
KNOWN = range(1, 16)
"""All opcodes that the MCAP format defines."""
IN_DATA = (1, 3, 4, 5, 6, 7, 9, 12, 15)
"""Opcodes that may occur before the end of the data."""


class SchemaText(NamedTuple):
    """A schema record."""

    name: str
    encoding: str
    data: bytes


class Channel(NamedTuple):
    """A channel record."""

    topic: str
    encoding: str
    schema_id: int


class Block(NamedTuple):
    """Records that lie together: a chunk, or a stretch of records outside chunks."""

    data: bytes
    records: Index
    where: int


@dataclass
class Damage:
    """A damaged place of the file.

    Attributes:
        what: what is wrong, in words.
        where: first byte of it.
        counts: messages lost for each channel id, as far as the indexes behind a chunk still tell.
        sure: whether `counts` names every channel that lost a message.
        harmless: whether no message can have been lost here.
    """

    what: str
    where: int
    counts: dict[int, int]
    sure: bool = False
    harmless: bool = False


def parse_record(kind: str, body: bytes) -> Any:
    """A record by mcap's own parser; None where it does not fill its bytes, or cannot be read."""
    from mcap import records
    from mcap.data_stream import ReadDataStream

    stream = ReadDataStream(BytesIO(body))
    try:
        record = getattr(records, kind).read(stream)
    except Exception:  # whatever mcap raises on damaged bytes
        return None
    return record if stream.count == len(body) else None
