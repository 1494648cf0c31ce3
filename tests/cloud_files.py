"""Point clouds as drivers of depth cameras write them, for tests: `sensor_msgs/PointCloud2` and /tf in MCAP."""

from __future__ import annotations

import numpy as np
from log_files import HEADER, START_NS, stamp, write_messages
from mcap_ros2._dynamic import serialize_dynamic
from scipy.spatial.transform import Rotation

CLOUD_TYPE, TF_TYPE = "sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage"
CLOUD_TEXT = (
    "std_msgs/Header header\nuint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\nuint32 point_step\n"
    "uint32 row_step\nuint8[] data\nbool is_dense" + HEADER + "=" * 80 + "\nMSG: sensor_msgs/PointField\n"
    "uint8 INT8=1\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n"
)
TF_TEXT = (
    "geometry_msgs/TransformStamped[] transforms\n" + "=" * 80 + "\nMSG: geometry_msgs/TransformStamped\n"
    "std_msgs/Header header\nstring child_frame_id\nTransform transform"
    + HEADER
    + "=" * 80
    + "\nMSG: geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n"
    + "=" * 80
    + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    + "=" * 80
    + "\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
)
_cloud = serialize_dynamic(CLOUD_TYPE, CLOUD_TEXT)[CLOUD_TYPE]
_tf = serialize_dynamic(TF_TYPE, TF_TEXT)[TF_TYPE]
TYPES = {"f4": 7, "f8": 8, "i2": 3}


def cloud_message(points, *, ns=START_NS, frame="camera", kind="f4", big=False, colour=True, pad=0, names="xyz"):
    """One cloud in CDR.

    Args:
        points: shape (n, 3) or (rows, columns, 3).
        ns: its stamp in [ns].
        frame: its frame.
        kind: numpy type of a coordinate.
        big: whether the points are big-endian.
        colour: whether there are a colour and a gap after the coordinates, as drivers pad them to 32 bytes.
        pad: bytes after each row.
        names: names of the three coordinates.
    """
    points = np.asarray(points)
    rows, columns = (1, len(points)) if points.ndim == 2 else points.shape[:2]
    size = int(kind[1])
    step = 32 if colour else 3 * size
    fields = [{"name": names[i], "offset": i * size, "datatype": TYPES[kind], "count": 1} for i in range(3)]
    if colour:
        fields.append({"name": "rgb", "offset": 3 * size, "datatype": 7, "count": 1})
    raw = np.zeros((rows, columns * step + pad), np.uint8)
    body = raw[:, : columns * step].reshape(rows, columns, step)
    values = points.reshape(rows, columns, 3).astype((">" if big else "<") + kind)
    body[..., : 3 * size] = np.ascontiguousarray(values).view(np.uint8).reshape(rows, columns, 3 * size)
    raw[:, : columns * step] = body.reshape(rows, -1)
    return _cloud(
        {
            "header": {"stamp": stamp(ns), "frame_id": frame},
            "height": rows,
            "width": columns,
            "fields": fields,
            "is_bigendian": big,
            "point_step": step,
            "row_step": columns * step + pad,
            "data": raw.tobytes(),
            "is_dense": False,
        }
    )


def tf_message(transforms, ns=START_NS):
    """One message of /tf: parent, child, place and quaternion of each."""
    return _tf(
        {
            "transforms": [
                {
                    "header": {"stamp": stamp(ns), "frame_id": parent},
                    "child_frame_id": child,
                    "transform": {
                        "translation": dict(zip("xyz", map(float, place), strict=True)),
                        "rotation": dict(zip("xyzw", map(float, turn), strict=True)),
                    },
                }
                for parent, child, place, turn in transforms
            ]
        }
    )


def quaternion(turn):
    """The quaternion x, y, z, w of a rotation matrix, shape (3, 3)."""
    return Rotation.from_matrix(turn).as_quat()


def camera_pose(camera):
    """Place and quaternion of a simulated camera in a frame with x forward, y left, z up under its walker's foot."""
    rep = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    turn = rep @ camera.axes.T
    return rep @ np.asarray(camera.at), quaternion(turn)


def write_clouds(path, clouds, transforms=(), topic="/camera/points", **options):
    """Write clouds, (ns, data) each, and /tf messages, (ns, data) each."""
    channels = {topic: (CLOUD_TYPE, CLOUD_TEXT, "ros2msg", "cdr")}
    if transforms:
        channels["/tf"] = TF_TYPE, TF_TEXT, "ros2msg", "cdr"
    messages = [(topic, ns, ns, data) for ns, data in clouds] + [("/tf", ns, ns, data) for ns, data in transforms]
    messages.sort(key=lambda message: (message[1], message[0] != "/tf"))
    return write_messages(path, channels, messages, **options)
