"""One CDR message walked by its schema: which of its bytes are layout, and where its numbers lie.

Messages of equal length and equal layout bytes have all their numbers at the same places, so that one walk serves
thousands of messages (see `decode`). Layout bytes are the encapsulation head, counts, string lengths and strings;
padding is not compared, for some writers leave rubbish there.
"""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

from ggo_factors.recording.log.ros2_definitions import CODES, Field, Messages

_LONG = 4096
"""A longer array does not hold joints (an image, a point cloud) and is left out of the tree."""
_DEEP = 32
"""Deepest nesting of message types that is read: a schema may contain itself."""
IDS = ("id", "joint_id", "motor_id", "node_id", "can_id", "servo_id", "axis_id", "index", "joint_index", "motor_index")
"""Fields that tell the objects of a list apart: what they hold names the object."""
_SLACK = 7
"""Most bytes that may follow a message: writers pad to 4 or 8 bytes."""


_PACKED = {
    b"\x28\xb5\x2f\xfd": "zstd",
    b"\x04\x22\x4d\x18": "lz4",
    b"\x1f\x8b": "gzip",
    b"\xfd7zXZ": "xz",
    b"BZh": "bzip2",
}


class CdrError(Exception):
    """A message does not fit its schema; the text says where."""


class PackedError(CdrError):
    """A message is compressed by itself; the text says how."""


class Slot(NamedTuple):
    """A number's place in a message: offset in [byte], and its numpy type code."""

    offset: int
    code: str


class Walked(NamedTuple):
    """A message that was walked.

    Attributes:
        tree: its fields as dict, list, str and `Slot`; None for an array too long for joints.
        layout: stretches [a, b) of layout bytes.
        left: bytes behind the last field, beyond what writers pad.
        arrays: for the name of each array that is None in the tree: where it begins, its length, its numpy type code.
    """

    tree: dict[str, Any]
    layout: list[tuple[int, int]]
    left: int
    arrays: dict[str, tuple[int, int, str]]


def check_packed(data: bytes) -> None:
    """Refuse a message that is compressed by itself, as rosbag2 writes it with ``--compression-mode message``.

    Raises:
        PackedError: saying with what.
    """
    for start, what in _PACKED.items():
        if data.startswith(start):
            raise PackedError(
                f"each message is compressed by itself with {what} (rosbag2 does so with --compression-mode message): "
                "pip install 'ggo-factors[rosbags]', or write the bag again without compression (ros2 bag convert)"
            )


def walk(data: bytes, kind: str, messages: Messages) -> Walked:
    """Walk one message of type `kind`.

    Raises:
        CdrError: where it does not fit its schema.
    """
    if len(data) < 4:
        raise CdrError(f"is {len(data)} bytes long")
    check_packed(data)
    if data[0] != 0 or data[1] > 1:
        kind_of = "XCDR2" if 6 <= data[1] <= 11 else "parameter lists" if data[1] in (2, 3) else "no CDR"
        raise CdrError(f"has encapsulation 0x{data[:2].hex()} ({kind_of}), which cannot be read")
    reader = _Reader(data, "<" if data[1] else ">", messages)
    tree = reader.message(kind, 0)
    left = len(data) - reader.at
    return Walked(tree, reader.layout, left if left > _SLACK else 0, reader.arrays)


class _Reader:
    def __init__(self, data: bytes, order: str, messages: Messages) -> None:
        self.data = data
        self.at = 4
        self.order = order
        self.messages = messages
        self.layout = [(0, 2)]
        self.arrays: dict[str, tuple[int, int, str]] = {}
        self._count = struct.Struct(order + "I").unpack_from

    def message(self, kind: str, depth: int, listed: bool = False) -> dict[str, Any]:
        if depth > _DEEP:
            raise CdrError("is nested too deeply")
        fields = self.messages[kind]
        if not fields:
            self.take(1, 1)  # an empty structure holds one byte
        return {
            field.name: self.number(field.kind)
            if listed and field.name in IDS and field.size is None and CODES.get(field.kind, "f")[0] in "iu"
            else self.field(field, depth)
            for field in fields
        }

    def number(self, kind: str) -> int:
        """A whole number that names something, and so belongs to the layout."""
        code = CODES[kind]
        start = self.take(int(code[1]), int(code[1]))
        self.note(start, start + int(code[1]))
        return int.from_bytes(
            self.data[start : start + int(code[1])], "little" if self.order == "<" else "big", signed=code[0] == "i"
        )

    def field(self, field: Field, depth: int) -> Any:
        if field.size is None:
            return self.value(field.kind, depth)
        count = self.count() if field.size < 0 else field.size
        if count > len(self.data) - self.at:
            raise CdrError(f"claims {count} elements of {field.name} at byte {self.at} of {len(self.data)}")
        code = CODES.get(field.kind)
        if code is None:
            return [
                self.text() if field.kind == "string" else self.message(field.kind, depth + 1, True)
                for _ in range(count)
            ]
        if count == 0:
            return []  # no padding before elements that are not there
        width = int(code[1])
        start = self.take(width * count, width)
        if count > _LONG or (width == 1 and count > 64):
            self.arrays[field.name] = start, count, self.order + code
            return None
        return [Slot(start + width * i, self.order + code) for i in range(count)]

    def value(self, kind: str, depth: int) -> Any:
        if kind == "string":
            return self.text()
        code = CODES.get(kind)
        if code is None:
            return self.message(kind, depth + 1)
        width = int(code[1])
        return Slot(self.take(width, width), self.order + code)

    def text(self) -> str:
        length = self.count()
        start = self.take(length, 1)
        self.note(start, start + length)
        raw = self.data[start : start + length]
        try:
            return raw[:-1].decode("utf-8")
        except UnicodeDecodeError as error:
            raise CdrError(f"holds a text at byte {start} that is not UTF-8") from error

    def count(self) -> int:
        start = self.take(4, 4)
        self.note(start, start + 4)
        value: int = self._count(self.data, start)[0]
        return value

    def take(self, size: int, align: int) -> int:
        start = self.at + (4 - self.at) % align
        if start + size > len(self.data):
            raise CdrError(f"ends at byte {len(self.data)} inside a field")
        self.at = start + size
        return start

    def note(self, start: int, end: int) -> None:
        if self.layout[-1][1] == start:
            self.layout[-1] = (self.layout[-1][0], end)
        else:
            self.layout.append((start, end))
