"""ROS 2 message definitions: the text of a schema as fields, and the well-known ones for logs that carry no text."""

from __future__ import annotations

import re
from typing import NamedTuple

CODES = {
    "bool": "b1", "byte": "u1", "char": "i1", "uint8": "u1", "int8": "i1", "uint16": "u2", "int16": "i2",
    "uint32": "u4", "int32": "i4", "uint64": "u8", "int64": "i8", "float32": "f4", "float64": "f8",
}  # fmt: skip


class DefinitionError(Exception):
    """A schema cannot be understood; the text says why."""


class Field(NamedTuple):
    """A field of a message.

    Attributes:
        name: its name.
        kind: a key of `CODES`, "string", or the full name of another message.
        size: None for a single value, -1 for a sequence, else the length of a fixed array.
    """

    name: str
    kind: str
    size: int | None


Messages = dict[str, tuple[Field, ...]]

_FIELD = re.compile(r"^([A-Za-z]\w*(?:/\w+)*)(?:<=\d+)?(\[(<=)?(\d*)\])?\s+([A-Za-z]\w*)\s*(=)?")
_TIME = "int32 sec\nuint32 nanosec"
_HEADER = "builtin_interfaces/Time stamp\nstring frame_id"
_POINT = (
    "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
    "builtin_interfaces/Duration time_from_start"
)
_LAYOUT = "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset"
WELL_KNOWN = {
    "sensor_msgs/JointState": "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
    "float64[] effort",
    "std_msgs/Header": _HEADER,
    "builtin_interfaces/Time": _TIME,
    "builtin_interfaces/Duration": _TIME,
    "trajectory_msgs/JointTrajectory": "std_msgs/Header header\nstring[] joint_names\nJointTrajectoryPoint[] points",
    "trajectory_msgs/JointTrajectoryPoint": _POINT,
    "control_msgs/DynamicJointState": "std_msgs/Header header\nstring[] joint_names\nInterfaceValue[] interface_values",
    "control_msgs/InterfaceValue": "string[] interface_names\nfloat64[] values",
    "control_msgs/JointTrajectoryControllerState": "std_msgs/Header header\nstring[] joint_names\n"
    "trajectory_msgs/JointTrajectoryPoint desired\ntrajectory_msgs/JointTrajectoryPoint actual\n"
    "trajectory_msgs/JointTrajectoryPoint error",
    "sensor_msgs/PointCloud2": "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
    "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense",
    "sensor_msgs/PointField": "string name\nuint32 offset\nuint8 datatype\nuint32 count",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\nTransform transform",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "std_msgs/Float64": "float64 data",
    "std_msgs/Float32": "float32 data",
    "std_msgs/Float64MultiArray": "std_msgs/MultiArrayLayout layout\nfloat64[] data",
    "std_msgs/Float32MultiArray": "std_msgs/MultiArrayLayout layout\nfloat32[] data",
    "std_msgs/MultiArrayLayout": _LAYOUT,
    "std_msgs/MultiArrayDimension": "string label\nuint32 size\nuint32 stride",
}


def short_name(name: str) -> str:
    """A type name without its middle part: sensor_msgs/msg/JointState is sensor_msgs/JointState."""
    parts = name.split("/")
    return f"{parts[0]}/{parts[-1]}" if len(parts) > 1 else name


def parse_messages(name: str, encoding: str, data: bytes) -> Messages:
    """The messages of a schema by short name, that of `name` and all that it needs.

    Args:
        name: type of the message, for example ``"sensor_msgs/msg/JointState"``.
        encoding: of the schema; any but ``"ros2msg"`` is read by the type's name, where that is well known.
        data: the schema's text in UTF-8.

    Raises:
        DefinitionError: where the schema cannot be understood.
    """
    texts = dict(WELL_KNOWN)
    if encoding == "ros2msg" and data.strip():
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError as error:
            raise DefinitionError("its schema is not UTF-8 text") from error
        first, *others = re.split(r"^={3,}[ \t]*\r?$", text, flags=re.MULTILINE)
        texts[short_name(name)] = first
        for other in others:
            head = re.match(r"\s*MSG:\s+(\S+)[^\n]*", other)
            if head is None:
                raise DefinitionError("its schema has a part without a name")
            texts[short_name(head.group(1))] = other[head.end() :]
    elif short_name(name) not in WELL_KNOWN:
        raise DefinitionError(f"its schema has no text that can be read (encoding {encoding!r})")
    messages: Messages = {}
    waiting = [short_name(name)]
    while waiting:
        kind = waiting.pop()
        if kind in messages:
            continue
        if kind not in texts:
            raise DefinitionError(f"its schema does not define {kind}")
        messages[kind] = _fields(kind, texts[kind])
        waiting += [field.kind for field in messages[kind] if "/" in field.kind]
    return messages


def _fields(owner: str, text: str) -> tuple[Field, ...]:
    fields = []
    for line in text.splitlines():
        line = line.split("#")[0].strip()
        if not line:
            continue
        match = _FIELD.match(line)
        if match is None:
            raise DefinitionError(f"its schema has a line that is no field: {line!r:.60}")
        kind, array, bounded, length, name, constant = match.groups()
        if constant:
            continue
        if kind == "wstring":
            raise DefinitionError("it has a wstring field, which cannot be read")
        if kind not in CODES and kind != "string":
            package = "std_msgs" if kind == "Header" else owner.split("/")[0]
            kind = short_name(kind) if "/" in kind else f"{package}/{kind}"
        count = None if not array else -1 if bounded or not length else int(length)
        fields.append(Field(name, kind, count))
    return tuple(fields)
