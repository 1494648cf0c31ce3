"""A ROS 2 log in MCAP, message by message: schemas, CDR, quality of service.

The message encoder of mcap-ros2-support writes an empty list for a field whose name is misspelt, and its writer
states no quality of service. This one takes a message only when it names every field of its type and no other.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from mcap.writer import Writer

from ggo_factors.support.files import PathLike, replacing

Message = Mapping[str, Any]

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""

# As the ROS distributions from Humble on define them, less the comments.
_DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/String": "string data",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
    "sensor_msgs/PointField": (
        "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n"
        "uint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count"
    ),
    "sensor_msgs/PointCloud2": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
        "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense"
    ),
    "trajectory_msgs/JointTrajectoryPoint": (
        "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
        "builtin_interfaces/Duration time_from_start"
    ),
    "trajectory_msgs/JointTrajectory": (
        "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points"
    ),
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data",
    "visualization_msgs/Marker": (
        "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\n"
        "int32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n"
        "int32 TRIANGLE_LIST=11\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n"
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
        "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
        "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n"
        "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n"
        "string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials"
    ),
    "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers",
}

_FIELDS = {
    kind: [(words[1], words[0]) for words in (line.split() for line in text.splitlines()) if "=" not in words[1]]
    for kind, text in _DEFINITIONS.items()
}

_NUMBERS = {"bool": "?", "uint8": "B", "int32": "i", "uint32": "I", "float32": "f", "float64": "d"}


def schema_text(kind: str) -> str:
    """The definition of a message type (`"sensor_msgs/JointState"`) and, below it, of all types in it."""
    order = [kind]
    for parent in order:
        for _, inner in _FIELDS[parent]:
            inner = inner.removesuffix("[]")
            if inner in _DEFINITIONS and inner not in order:
                order.append(inner)
    parts = [_DEFINITIONS[kind], *(f"MSG: {inner}\n{_DEFINITIONS[inner]}" for inner in order[1:])]
    return f"\n{'=' * 80}\n".join(parts) + "\n"


def encode(kind: str, message: Message) -> bytes:
    """A message in CDR, little endian, as ROS 2 sends it.

    Raises:
        ValueError: where the message lacks a field of its type, or has one that the type does not.
    """
    out = bytearray()
    _put(out, kind, message)
    return b"\x00\x01\x00\x00" + bytes(out)


def _put(out: bytearray, kind: str, value: Any) -> None:
    if kind in _NUMBERS:
        _put_numbers(out, kind, (value,))
    elif kind == "string":
        text = value.encode() + b"\0"
        _put_numbers(out, "uint32", (len(text),))
        out += text
    elif kind.endswith("[]"):
        _put_numbers(out, "uint32", (len(value),))
        if (item := kind[:-2]) in _NUMBERS:
            _put_numbers(out, item, value)
        else:
            for entry in value:
                _put(out, item, entry)
    else:
        fields = _FIELDS[kind]
        if odd := set(value) ^ {name for name, _ in fields}:
            raise ValueError(f"{kind}: fields {sorted(odd)} are missing or not of this type")
        for name, inner in fields:
            _put(out, inner, value[name])


def _put_numbers(out: bytearray, kind: str, values: Sequence[float] | bytes) -> None:
    """Numbers of one kind, aligned to their size; an empty sequence takes no padding."""
    if isinstance(values, bytes):
        out += values
    elif len(values):
        code = _NUMBERS[kind]
        out += bytes(-len(out) % struct.calcsize(code))
        out += struct.pack(f"<{len(values)}{code}", *values)


def stamp(time_ns: int) -> dict[str, int]:
    """A time or a duration in [ns] as the two fields of its message."""
    return {"sec": time_ns // NANOSECONDS, "nanosec": time_ns % NANOSECONDS}


def header(time_ns: int, frame_id: str = "") -> dict[str, Any]:
    """A std_msgs/Header at a time in [ns]."""
    return {"stamp": stamp(time_ns), "frame_id": frame_id}


def qos_profile(latched: bool) -> str:
    """What a recorder notes of a publisher, in YAML: reliable; kept for late subscribers if `latched`.

    Policies as integers (history keep last, reliability reliable, durability volatile or transient local,
    liveliness automatic): every ROS 2 distribution reads them, the words only the newer ones.
    """
    endless = f"sec: {0x7FFFFFFFFFFFFFFF // NANOSECONDS}\n    nsec: {0x7FFFFFFFFFFFFFFF % NANOSECONDS}"
    return (
        f"- history: 1\n  depth: {1 if latched else 10}\n  reliability: 1\n  durability: {1 if latched else 2}\n"
        f"  deadline:\n    {endless}\n  lifespan:\n    {endless}\n"
        f"  liveliness: 1\n  liveliness_lease_duration:\n    {endless}\n"
        "  avoid_ros_namespace_conventions: false\n"
    )


class Ros2Log:
    """An open log; made by `ros2_log`."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, tuple[str, int]] = {}

    def add_topic(self, topic: str, kind: str, *, latched: bool = False) -> None:
        """Declare a topic of messages of one type, for example `"sensor_msgs/JointState"`."""
        if kind not in self._schemas:
            package, name = kind.split("/")
            text = schema_text(kind).encode()
            self._schemas[kind] = self._writer.register_schema(f"{package}/msg/{name}", "ros2msg", text)
        metadata = {"offered_qos_profiles": qos_profile(latched)}
        self._channels[topic] = kind, self._writer.register_channel(topic, "cdr", self._schemas[kind], metadata)

    def write(self, topic: str, time_ns: int, message: Message) -> None:
        """Add a message, logged and published at `time_ns` in [ns].

        Raises:
            ValueError: where the message does not have just the fields of its type.
        """
        kind, channel = self._channels[topic]
        # PlotJuggler goes by the publish time, rosbag2 by the log time.
        self._writer.add_message(channel, log_time=time_ns, data=encode(kind, message), publish_time=time_ns)

    def add_metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Add a metadata record, which players ignore and keep."""
        self._writer.add_metadata(name, dict(entries))


@contextmanager
def ros2_log(path: PathLike) -> Iterator[Ros2Log]:
    """A log to write to, which appears at `path` whole when the block ends, or not at all.

    Raises:
        InputError: where the file cannot be written.
    """
    with replacing(path) as temporary, temporary.open("wb") as stream:
        writer = Writer(stream, use_summary_offsets=False)
        writer.start(profile="ros2", library="ggo_factors")
        yield Ros2Log(writer)
        writer.finish()  # type: ignore[no-untyped-call]
