"""The messages of one channel as names and values: ROS 2 and JSON here, ROS 1 and protobuf by their packages."""

from __future__ import annotations

import contextlib
import importlib
import io
import json
from collections import ChainMap, Counter
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ggo_factors.recording.log.chunk_records import PAYLOAD, Bytes, Offsets, rows_of
from ggo_factors.recording.log.decode_many import MISSING, Template, Times, nanoseconds
from ggo_factors.recording.log.message_shapes import Reading, read_shape
from ggo_factors.recording.log.records import Channel, SchemaText
from ggo_factors.recording.log.ros2_definitions import DefinitionError, parse_messages, short_name
from ggo_factors.recording.log.walk_cdr import CdrError, PackedError, check_packed, walk
from ggo_factors.support.inputs import Array

_TEMPLATES = 256
"""Most message layouts kept for one channel; messages of any further layout are decoded one by one."""
_NAMES = 10_000
"""Most names kept for one channel: damaged messages may hold a new one each."""
_HOPELESS = 1000
"""Stop decoding a channel when so many messages were refused and none was read."""
_EXTRAS = {"ros1": "mcap_ros1.decoder", "protobuf": "mcap_protobuf.decoder"}


class UndecodableError(Exception):
    """No message of a channel can be decoded; the text says why."""


@dataclass
class Part:
    """Messages with the same names.

    Attributes:
        names: names of the columns.
        order: number of each row's message among those of its topic, shape (n,).
        values: shape (n, len(names)).
        stamps: the messages' own times in [ns], or plain numbers of unknown unit, or None; shape (n,).
        log: log times in [ns], shape (n,); `publish` are the publish times.
        points: position of each row in its trajectory, or None where a message is one row; shape (n,).
        source: who sent them, as far as the log tells: file, channel and frame.
    """

    names: tuple[str, ...]
    order: Offsets
    values: Array
    stamps: Times | Array | None
    log: Times
    publish: Times
    points: Offsets | None = None
    source: tuple[int, int, str] = (0, 0, "")


class Decoder:
    """Decodes the messages of one channel.

    Attributes:
        place: number of the file and of the channel in it.
        reading: what the first message said that could be read, or None.
        dropped: how many messages were dropped, for each reason.
        example: for each reason, what the first such message suffered from.
        read: messages that were read.
        names: all names that occurred in them.
        unnamed: messages whose names stood in an earlier one only.
        left: for a number of bytes behind what the schema says, how many messages have so many.
    """

    def __init__(
        self,
        channel: Channel,
        schema: SchemaText | None,
        wanted: Collection[str] | None,
        lists: dict[int, tuple[str, ...] | None] | None = None,
        place: tuple[int, int] = (0, 0),
    ) -> None:
        """Prepare to decode.

        Args:
            channel: the channel.
            schema: its schema, or None where it has none.
            wanted: names of the values to take; None: all.
            lists: lists of names by their length, shared by the channels of a topic: for messages without any.
            place: number of the file and of the channel in it.

        Raises:
            UndecodableError: where its encoding or its schema cannot be read.
        """
        self.reading: Reading | None = None
        self.place = place
        self.dropped: Counter[str] = Counter()
        self.example: dict[str, str] = {}
        self.read = 0
        self.names: dict[str, None] = {}
        self.left: Counter[int] = Counter()
        self.unnamed = 0
        self._bare: dict[int, bool] = {}
        self._own: dict[int, tuple[str, ...] | None] = {}
        self._shared = {} if lists is None else lists
        self._lists = ChainMap(self._own, self._shared)
        self._wanted = None if wanted is None else frozenset(wanted)
        self._templates: dict[int, list[Template]] = {}
        self._known = 0
        self._kind = "" if schema is None else short_name(schema.name)
        self._bulk = False
        self._tree: Callable[[bytes], Any] = json.loads
        if channel.encoding == "cdr":
            if schema is None:
                raise UndecodableError("its channel has no schema")
            try:
                self._messages = parse_messages(schema.name, schema.encoding, schema.data)
                self._bulk = True
            except DefinitionError as error:
                self._tree = _by_package("mcap_ros2.decoder", "cdr", schema, str(error))
        elif channel.encoding in _EXTRAS:
            self._tree = _by_package(_EXTRAS[channel.encoding], channel.encoding, schema, "")
        elif channel.encoding != "json":
            raise UndecodableError(f"encoding {channel.encoding!r} is not supported (cdr, json, ros1, protobuf)")

    def decode(self, data: bytes, offsets: Offsets, sizes: Offsets, order: Offsets) -> list[Part]:
        """Decode messages of a block.

        Args:
            data: the block; its message records lie at `offsets`, and are `sizes` long.
            offsets: shape (n,).
            sizes: in [byte], shape (n,).
            order: number of each message among those of its topic, shape (n,).
        """
        if self.read == 0 and sum(self.dropped.values()) > _HOPELESS:
            self.dropped[next(iter(self.dropped))] += len(offsets)
            return []
        if self._bulk:
            kinds, first = np.unique(sizes, return_index=True)
            # Messages without names last: the others have the names that they lack.
            bare = [len(kinds) > 1 and self._nameless(data, offsets[i], sizes[i]) for i in first]
            in_order = kinds[np.argsort(bare, kind="stable")].tolist()
            parts = [part for size in in_order for part in self._same_size(data, offsets, sizes, size)]
        else:
            parts = self._singly(data, offsets, sizes)
        for part in parts:
            part.order = order[part.order]
        return parts

    def _nameless(self, data: bytes, offset: int, size: int) -> bool:
        if size not in self._bare:
            try:
                tree = walk(data[offset + PAYLOAD : offset + size], self._kind, self._messages).tree
                self._bare[size] = read_shape(tree).shape == "values"
            except CdrError:
                self._bare[size] = False
        return self._bare[size]

    def _same_size(self, data: bytes, offsets: Offsets, sizes: Offsets, size: int) -> Iterator[Part]:
        order = np.flatnonzero(sizes == size)
        rows = rows_of(data, offsets[order], size)
        templates = self._templates.setdefault(size, [])
        left = np.arange(len(rows))
        for i, template in enumerate(templates):
            whole = len(left) == len(rows)
            same = template.matches(rows[:, PAYLOAD:] if whole else rows[left, PAYLOAD:])
            if same.any():
                yield from self._take(template, rows, order, left[same], whole and bool(same.all()))
                left = left[~same]
                if i:  # the layout seen last is tried first
                    templates.insert(0, templates.pop(i))
            if not len(left):
                return
        while len(left):
            try:
                template = Template(
                    rows[left[0], PAYLOAD:].tobytes(), self._kind, self._messages, self._wanted, self._lists
                )
            except PackedError as error:
                self._drop(str(error), 1, "")
                left = left[1:]
                continue
            except CdrError as error:
                self._drop("cannot be decoded", 1, str(error))
                left = left[1:]
                if self.read == 0 and sum(self.dropped.values()) > _HOPELESS:
                    self._drop("cannot be decoded", len(left), "")
                    return
                continue
            if self._known < _TEMPLATES:
                self._known += 1
                templates.insert(0, template)
                same = template.matches(rows[left, PAYLOAD:])
            else:
                same = np.arange(len(left)) == 0  # too many layouts: each message by itself
            yield from self._take(template, rows, order, left[same], False)
            left = left[~same]

    def _take(self, template: Template, rows: Bytes, order: Offsets, which: Offsets, whole: bool) -> Iterator[Part]:
        if template.reading.problem:
            self._drop(template.reading.problem, len(which), "")
            return
        self._note(template.reading, len(which))
        if template.left:
            self.left[template.left] += len(which)
        chosen = rows if whole else rows[which]
        payload = chosen[:, PAYLOAD:]
        log, publish = np.ascontiguousarray(chosen[:, 15:PAYLOAD]).view("<u8").astype(np.int64).T
        stamps, offsets = template.stamps(payload), template.offsets(payload)
        points = None
        order = order if whole else order[which]
        if offsets is not None:
            n = template.points()
            points = np.tile(np.arange(n), len(which))
            order, log, publish = np.repeat(order, n), np.repeat(log, n), np.repeat(publish, n)
            stamps = _after(None if stamps is None else np.repeat(stamps, n), log, offsets.ravel())
        yield Part(
            template.names,
            order,
            template.values(payload),
            stamps,
            log,
            publish,
            points,
            (*self.place, template.reading.frame),
        )

    def _singly(self, data: bytes, offsets: Offsets, sizes: Offsets) -> list[Part]:
        rows: dict[tuple[tuple[str, ...], str], list[tuple[int, list[float], Any, int]]] = {}
        for i, (offset, size) in enumerate(zip(offsets.tolist(), sizes.tolist(), strict=True)):
            message = data[offset + PAYLOAD : offset + size]
            try:
                check_packed(message)
                reading = read_shape(self._tree(message), self._lists)
            except PackedError as error:
                self._drop(str(error), 1, "")
                continue
            except Exception as error:  # each package raises what it likes, a dozen kinds of exception
                self._drop("cannot be decoded", 1, f"{type(error).__name__}: {error}")
                continue
            if reading.problem:
                self._drop(reading.problem, 1, "")
                continue
            self._note(reading, 1)
            stamp = None if reading.stamp is None else reading.stamp.parts
            for point, row in enumerate(reading.rows):
                moment: Any = (stamp, reading.offsets[point]) if reading.offsets else stamp
                table = rows.setdefault((reading.names, reading.frame), [])
                table.append((i, [_float(value) for value in row], moment, point))
        times = _record_times(data, offsets)
        return [self._part(names, frame, table, times) for (names, frame), table in rows.items()]

    def _part(
        self, names: tuple[str, ...], frame: str, table: list[tuple[int, list[float], Any, int]], times: Times
    ) -> Part:
        order = np.array([row[0] for row in table], np.int64)
        values = np.array([row[1] for row in table], float).reshape(len(table), len(names))
        keep = [i for i, name in enumerate(names) if self._wanted is None or name in self._wanted]
        moments = [row[2] for row in table]
        trajectory = self.reading is not None and self.reading.shape == "trajectory"
        points = np.array([row[3] for row in table], np.int64) if trajectory else None
        log, publish = times[order].T
        if trajectory:
            stamps = _after(_moments([m[0] for m in moments]), log, _moments([m[1] for m in moments]))
        else:
            stamps = _moments(moments)
        source = (*self.place, frame)
        return Part(tuple(names[i] for i in keep), order, values[:, keep], stamps, log, publish, points, source)

    def _note(self, reading: Reading, count: int) -> None:
        self.reading = self.reading or reading
        self.read += count
        self.unnamed += count if reading.inherited else 0
        if reading.shape in ("state", "controller") and not reading.inherited:
            self._remember(reading.names)
        if len(self.names) < _NAMES:
            self.names.update(dict.fromkeys(reading.names))

    def _remember(self, names: tuple[str, ...]) -> None:
        size = len(names)
        if self._own.get(size, ()) == names:
            return
        twice = size in self._own
        self._own[size] = None if twice else names
        self._shared[size] = names if self._shared.get(size, names) == names else None
        if twice:  # messages without names cannot be told any more
            for size, templates in self._templates.items():
                self._templates[size] = [template for template in templates if not template.reading.inherited]

    def _drop(self, reason: str, count: int, example: str) -> None:
        self.dropped[reason] += count
        if example:
            self.example.setdefault(reason, example.splitlines()[0][:120])


def _record_times(data: bytes, offsets: Offsets) -> Times:
    # log time and publish time of message records, shape (n, 2)
    windows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(data, np.uint8), PAYLOAD)
    return np.ascontiguousarray(windows[offsets][:, 15:]).view("<u8").astype(np.int64)


def _moments(moments: list[Any]) -> Any:
    # times of messages: whole [ns], or plain numbers of unknown unit, or None where there are none
    kinds = {len(m) for m in moments if m is not None}
    if kinds == {2}:
        pairs = np.array([(np.nan, np.nan) if m is None else (_float(m[0]), _float(m[1])) for m in moments])
        return nanoseconds(pairs[:, 0], pairs[:, 1])
    if kinds == {1}:
        return np.array([np.nan if m is None else _float(m[0]) for m in moments])
    return None


def _after(stamps: Any, log: Times, offsets: Any) -> Times:
    # times of the points of trajectories; a stamp of zero means now
    base = log if stamps is None or stamps.dtype != np.int64 else np.where(stamps > 0, stamps, log)
    if offsets is None or offsets.dtype != np.int64:
        return np.full(len(base), MISSING)
    return np.where(offsets == MISSING, MISSING, base + np.where(offsets == MISSING, 0, offsets))


def _float(value: Any) -> float:
    try:
        return float("nan") if value is None else float(value)
    except OverflowError:  # a whole number of JSON may be longer than any float
        return float("nan")


def _by_package(module: str, encoding: str, schema: SchemaText | None, why: str) -> Callable[[bytes], Any]:
    try:
        factory: Any = importlib.import_module(module).DecoderFactory()  # a new one: it caches by schema id
    except ImportError as error:
        package = module.split(".")[0].replace("_", "-") + "-support"
        raise UndecodableError(
            f"encoding {encoding!r} needs the package {package}: pip install 'ggo-factors[{encoding}]'"
        ) from error
    from mcap.records import Schema

    if schema is None:
        raise UndecodableError("its channel has no schema")
    try:
        with contextlib.redirect_stderr(io.StringIO()):  # it prints its errors
            decoder = factory.decoder_for(encoding, Schema(1, schema.data, schema.encoding, schema.name))
    except Exception as error:  # each package raises what it likes
        raise UndecodableError(why or f"its schema cannot be read ({type(error).__name__}: {error})") from error
    if decoder is None:
        raise UndecodableError(why or f"its schema encoding {schema.encoding!r} does not go with {encoding!r}")
    return lambda data: plain(decoder(data))


def plain(value: Any) -> Any:
    """A message of any package as dict, list, str and numbers."""
    if value is None or isinstance(value, (str, int, float)):
        return value
    if isinstance(value, (bytes, bytearray)):
        return None
    descriptor = getattr(value, "DESCRIPTOR", None)
    if descriptor is not None:  # protobuf: a field left out counts as zero, unless it knows that it was left out
        return {
            f.name: plain(getattr(value, f.name)) if not f.has_presence or value.HasField(f.name) else None
            for f in descriptor.fields
        }
    if hasattr(value, "items"):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "__len__"):
        items = list(value)
        if len(items) > 4096:
            return None
        return items if items and all(type(item) is float for item in items) else [plain(item) for item in items]
    return {name: plain(getattr(value, name)) for name in getattr(type(value), "__slots__", ())}
