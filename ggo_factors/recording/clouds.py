"""The point clouds of a depth camera in a log: `sensor_msgs/PointCloud2` in MCAP, as drivers write them."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.bag import mcap_files
from ggo_factors.recording.log.chunk_records import PAYLOAD
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.log.read_damaged import Container
from ggo_factors.recording.log.ros2_definitions import DefinitionError, Messages, parse_messages, short_name
from ggo_factors.recording.log.walk_cdr import CdrError, Slot, Walked, walk
from ggo_factors.recording.transforms import Transforms, add_message
from ggo_factors.seeing.strip import Sighting
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_count

CLOUD, TRANSFORM = "sensor_msgs/PointCloud2", "tf2_msgs/TFMessage"
"""Types of the messages that are read."""
KINDS = {7: "f4", 8: "f8"}
"""Of the types of `sensor_msgs/PointField`, those that coordinates are read of."""
MOST_POINTS = 10**7
"""A cloud that says it has more points is damaged."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """One cloud of a log.

    Attributes:
        points: in [m] in the frame of the message, shape (n, 3) or, of an organised cloud, (rows, columns, 3).
        time_ns: its stamp in [ns].
        frame: name of its frame.
    """

    points: NDArray[Any]
    time_ns: int
    frame: str


@dataclass(frozen=True)
class CloudLog:
    """The clouds of one topic and the transforms of a log."""

    clouds: tuple[Cloud, ...]
    transforms: Transforms


def read_sightings(
    path: PathLike,
    *,
    topic: str | None = None,
    frame: str | None = None,
    up: ArrayLike | None = None,
    heading: ArrayLike | None = None,
    at: ArrayLike | None = None,
    frames: int = 1,
    largest_chunk: int = CHUNK_MIB,
) -> list[Sighting]:
    """What a depth camera saw, from the point clouds of an MCAP log.

    Where the camera was is told by the log's transforms to a frame with x forward and z up (REP 103) whose origin is
    the ground under the supporting foot at the start, or by `up`, `heading` and `at`.

    Args:
        path: an MCAP file, or a rosbag2 folder.
        topic: topic of the clouds; may be left out where one alone has any.
        frame: name of that frame. Of a log with several clouds it must stand still: ``odom``, not ``base_link``.
        up: as in `Sighting`, where there is no such frame; for all clouds.
        heading: as in `Sighting`.
        at: as in `Sighting`, in [m].
        frames: how many clouds, evenly spaced over the log; of one alone the first.
        largest_chunk: the most of the file that is unpacked as one, in [MiB].

    Raises:
        InputError: where an argument is of no use.
        LogError: where the log cannot be read, holds no clouds, or needs a choice.
    """
    wanted = as_count(frames, "frames", 1, 1000)
    if frame is not None and any(value is not None for value in (up, heading, at)):
        raise InputError("frame: tells up, heading and at; give it, or them")
    log = read_clouds(path, topic=topic, largest_chunk=largest_chunk)
    if frame is None and (up is None or heading is None):
        names = f" (the log has {listed(log.transforms.names)})" if log.transforms.names else ""
        raise InputError(f"frame: give the frame of the foot{names}, or up= and heading= in that of the camera")
    chosen = np.unique(np.linspace(0, len(log.clouds) - 1, min(wanted, len(log.clouds))).round().astype(int))
    found = []
    for cloud in (log.clouds[number] for number in chosen):
        if frame is None:
            assert up is not None  # asked for above
            assert heading is not None
            found.append(Sighting(cloud.points, up, heading, at))
        else:
            pose = log.transforms.between(cloud.frame, frame, cloud.time_ns)
            turn, place = pose[:3, :3], pose[:3, 3]
            found.append(Sighting(cloud.points, turn[2], turn[0], -turn.T @ place))
    return found


def read_clouds(path: PathLike, *, topic: str | None = None, largest_chunk: int = CHUNK_MIB) -> CloudLog:
    """All clouds of one topic of an MCAP log, in order of time, and its transforms.

    Raises:
        InputError: where `largest_chunk` is no positive number.
        LogError: where the log cannot be read, holds no clouds, holds them on several topics, or none can be read.
    """
    limit = as_count(largest_chunk, "largest_chunk", 1) * 2**20
    files, _ = mcap_files(path)
    found, transforms, problem = dict[str, list[Cloud]](), Transforms(), ""
    for file in files:
        for name, kind, data, walked in _messages(file, limit):
            if isinstance(walked, str):
                problem = problem or f"{name}: {walked}"
            elif kind == TRANSFORM:
                add_message(transforms, data, walked.tree, lambda slot, data=data: _number(data, slot))
            elif topic is None or name == topic:
                try:
                    cloud = _cloud(data, walked)
                except CdrError as error:
                    problem = problem or f"{name}: a cloud {error}"
                else:
                    found.setdefault(name, []).append(cloud)
    if not found:
        asked = f" on topic {topic!r}" if topic else ""
        raise LogError(f"{path}: holds no {CLOUD}{asked} that can be read" + (f" ({problem})" if problem else ""))
    if len(found) > 1:
        raise LogError(f"{path}: clouds on several topics; choose one with topic= ({listed(tuple(found))})")
    (clouds,) = found.values()
    return CloudLog(tuple(sorted(clouds, key=lambda cloud: cloud.time_ns)), transforms)


def _messages(file: Path, limit: int) -> Iterator[tuple[str, str, bytes, Walked | str]]:
    """Topic, type and bytes of each message of clouds and transforms, and the message walked, or what is wrong."""
    container = Container(file, limit)
    definitions = dict[int, Messages | str]()
    try:
        for block in container.blocks():
            for number, (offsets, sizes) in block.records.messages.items():
                channel = container.channels.get(number)
                schema = container.schemas.get(channel.schema_id) if channel else None
                if channel is None or schema is None or short_name(schema.name) not in (CLOUD, TRANSFORM):
                    continue
                kind = short_name(schema.name)
                if number not in definitions:
                    definitions[number] = _definition(channel.encoding, schema)
                messages = definitions[number]
                for offset, size in zip(offsets.tolist(), sizes.tolist(), strict=True):
                    data = block.data[offset + PAYLOAD : offset + size]
                    if isinstance(messages, str):
                        yield channel.topic, kind, data, messages
                        continue
                    try:
                        yield channel.topic, kind, data, walk(data, kind, messages)
                    except CdrError as error:
                        yield channel.topic, kind, data, f"a message {error}"
    finally:
        container.close()


def _definition(encoding: str, schema: Any) -> Messages | str:
    if encoding != "cdr":
        return f"encoding {encoding!r}, and clouds are read from 'cdr' alone"
    try:
        return parse_messages(schema.name, schema.encoding, schema.data)
    except DefinitionError as error:
        return str(error)


def _number(data: bytes, slot: Slot) -> float:
    return float(np.frombuffer(data, slot.code, 1, slot.offset)[0])


def _cloud(data: bytes, walked: Walked) -> Cloud:
    """The cloud of one message.

    Raises:
        CdrError: saying what of it does not fit.
    """
    try:
        return _read_cloud(data, walked)
    except (KeyError, TypeError, AttributeError, struct.error) as error:
        raise CdrError(f"has a schema that is not that of {CLOUD} ({type(error).__name__}: {error})") from error


def _read_cloud(data: bytes, walked: Walked) -> Cloud:
    tree = walked.tree

    def whole(slot: Slot) -> int:
        return int(_number(data, slot))

    rows, columns = whole(tree["height"]), whole(tree["width"])
    step, row_step = whole(tree["point_step"]), whole(tree["row_step"])
    if rows * columns > MOST_POINTS:
        raise CdrError(f"says it has {rows} rows of {columns} points")
    start, length = _bytes_of(walked)
    fields = {one["name"]: one for one in tree["fields"]}
    lacking = [axis for axis in "xyz" if axis not in fields]
    if lacking:
        raise CdrError(f"has no field {', '.join(lacking)}; its fields are {listed(tuple(fields)) or 'none'}")
    order = ">" if whole(tree["is_bigendian"]) else "<"
    formats, offsets = [], []
    for axis in "xyz":
        kind, offset = whole(fields[axis]["datatype"]), whole(fields[axis]["offset"])
        if kind not in KINDS:
            raise CdrError(f"has field {axis} of type {kind}; FLOAT32 (7) and FLOAT64 (8) are read")
        if offset + int(KINDS[kind][1]) > step:
            raise CdrError(f"has field {axis} at byte {offset} of points that are {step} bytes long")
        formats.append(order + KINDS[kind])
        offsets.append(offset)
    row_step = row_step if row_step >= columns * step else columns * step
    if rows * columns and (rows - 1) * row_step + columns * step > length:
        raise CdrError(f"says it has {rows} rows of {columns} points of {step} bytes, and holds {length} bytes")
    layout = np.dtype({"names": ["x", "y", "z"], "formats": formats, "offsets": offsets, "itemsize": step})
    if rows * columns:
        raw = np.ndarray((rows, columns), layout, data, start, (row_step, step))
        points = np.stack([raw[axis] for axis in "xyz"], axis=-1).astype(np.result_type(*formats).newbyteorder("="))
    else:
        points = np.empty((0, 0, 3), np.float32)
    header = tree["header"]
    time = whole(header["stamp"]["sec"]) * 10**9 + whole(header["stamp"]["nanosec"])
    return Cloud(points if rows > 1 else points.reshape(-1, 3), time, header["frame_id"])


def _bytes_of(walked: Walked) -> tuple[int, int]:
    """Where the points of a message begin and how long they are, in [byte]."""
    if "data" in walked.arrays:
        start, length, _ = walked.arrays["data"]
        return start, length
    slots: Mapping[int, Slot] | list[Slot] = walked.tree["data"]
    return (slots[0].offset, len(slots)) if slots else (0, 0)
