"""Logs made for tests: JointState and other messages written with mcap's own writer."""

from __future__ import annotations

import struct

import numpy as np
from mcap.writer import CompressionType, Writer
from mcap_ros2._dynamic import serialize_dynamic

START_NS = 1_790_000_000 * 10**9
NAMES = ("hip_l", "knee_l", "hip_r", "knee_r")
HEADER = """
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
JOINT_STATE = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort" + HEADER
JOINT_TYPE = "sensor_msgs/msg/JointState"
_encode = serialize_dynamic(JOINT_TYPE, JOINT_STATE)[JOINT_TYPE]


def stamp(ns):
    return {"sec": int(ns) // 10**9, "nanosec": int(ns) % 10**9}


def joint_state(ns, names, position, velocity=()):
    """One sensor_msgs/JointState in CDR."""
    header = {"stamp": stamp(ns), "frame_id": "exo"}
    return _encode({"header": header, "name": list(names), "position": list(position), "velocity": list(velocity)})


def walk_angles(count, step=0.01, seed=1):
    """Angles of four joints in [rad], all rows different: shape (count, 4)."""
    phase = 2 * np.pi * np.arange(count)[:, None] * step / 1.1 + np.arange(4)
    return 0.3 + 0.4 * np.sin(phase) + np.random.default_rng(seed).normal(0, 1e-3, (count, 4))


def write_messages(path, channels, messages, **options):
    """Write a log.

    Args:
        path: the file.
        channels: for each topic: type, schema text, schema encoding, message encoding.
        messages: (topic, log time, publish time, data) in file order.
        options: of mcap's Writer.
    """
    options = {"chunk_size": 20_000, "compression": CompressionType.ZSTD} | options
    with open(path, "wb") as file:
        writer = Writer(file, **options)
        writer.start("ros2", "tests")
        ids = {}
        for topic, (kind, text, schema_encoding, encoding) in channels.items():
            schema = writer.register_schema(kind, schema_encoding, text.encode()) if kind else 0
            ids[topic] = writer.register_channel(topic, encoding, schema)
        for topic, log, publish, data in messages:
            writer.add_message(ids[topic], int(log), data, int(publish))
        writer.finish()
    return path


def write_joint_log(path, values, names=NAMES, times_ns=None, log_ns=None, **options):
    """Write a JointState log, 100 Hz unless told otherwise: stamps `times_ns`, log times `log_ns`."""
    if times_ns is None:
        times_ns = START_NS + 10**7 * np.arange(len(values))
    if log_ns is None:
        log_ns = times_ns
    messages = [
        ("/joint_states", log + 500_000, log + 200_000, joint_state(ns, names, row))
        for ns, log, row in zip(times_ns, log_ns, values.tolist(), strict=True)
    ]
    return write_messages(path, {"/joint_states": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages, **options)


def float64(value):
    return b"\x00\x01\x00\x00" + struct.pack("<d", value)
