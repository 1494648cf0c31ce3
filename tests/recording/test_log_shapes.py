"""Encodings and shapes: the same walk written in many ways is read as the same values."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest
from log_files import (
    HEADER,
    JOINT_STATE,
    JOINT_TYPE,
    NAMES,
    START_NS,
    float64,
    joint_state,
    stamp,
    walk_angles,
    write_joint_log,
    write_messages,
)
from mcap.writer import Writer
from mcap_ros2._dynamic import serialize_dynamic

from ggo_factors.errors import LogError
from ggo_factors.recording.log.message_shapes import read_shape
from ggo_factors.recording.log.read_log import read_log

COUNT = 120
VALUES = walk_angles(COUNT)
STEP = 10**7
POINT = """
================================================================================
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
================================================================================
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
"""


def cdr_log(path, topic, kind, text, trees):
    encode = serialize_dynamic(kind, text)[kind]
    messages = [(topic, START_NS + i * STEP, START_NS + i * STEP, encode(tree)) for i, tree in enumerate(trees)]
    return write_messages(path, {topic: (kind, text, "ros2msg", "cdr")}, messages)


def json_log(path, trees, topic="/a"):
    messages = [
        (
            topic,
            START_NS + i * STEP,
            START_NS + i * STEP,
            tree if isinstance(tree, bytes) else json.dumps(tree).encode(),
        )
        for i, tree in enumerate(trees)
    ]
    return write_messages(path, {topic: ("", "", "", "json")}, messages)


def header(i):
    return {"stamp": stamp(START_NS + i * STEP), "frame_id": ""}


def point(row, i=0):
    return {"positions": row, "time_from_start": stamp(i * STEP)}


def check(log, names=NAMES, values=VALUES):
    assert log.names == tuple(names)
    assert np.array_equal(log.values, values)
    assert np.allclose(log.times, 0.01 * np.arange(len(values)), rtol=0, atol=1e-8)
    assert not log.losses


@pytest.mark.parametrize("fields", [("desired", "actual", "error"), ("reference", "feedback", "output")])
def test_controller_state_takes_what_was_measured(tmp_path, fields):
    kind = "control_msgs/msg/JointTrajectoryControllerState"
    text = "std_msgs/Header header\nstring[] joint_names\n"
    text += "".join(f"trajectory_msgs/JointTrajectoryPoint {field}\n" for field in fields) + HEADER + POINT
    trees = [
        {"header": header(i), "joint_names": list(NAMES)}
        | {field: point([x + 9 * (k != 1) for x in row]) for k, field in enumerate(fields)}
        for i, row in enumerate(VALUES.tolist())
    ]
    log = read_log(cdr_log(tmp_path / "a.mcap", "/controller/state", kind, text, trees))
    check(log)
    assert log.unit == "rad"


def test_dynamic_joint_state_takes_positions(tmp_path):
    text = "std_msgs/Header header\nstring[] joint_names\nInterfaceValue[] interface_values\n" + HEADER
    text += f"{'=' * 80}\nMSG: control_msgs/InterfaceValue\nstring[] interface_names\nfloat64[] values\n"
    trees = [
        {
            "header": header(i),
            "joint_names": list(NAMES),
            "interface_values": [{"interface_names": ["effort", "position"], "values": [7.0, x]} for x in row],
        }
        for i, row in enumerate(VALUES.tolist())
    ]
    check(read_log(cdr_log(tmp_path / "a.mcap", "/d", "control_msgs/msg/DynamicJointState", text, trees)))


@pytest.mark.parametrize("at_once", [True, False])
def test_trajectories(tmp_path, at_once):
    text = "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points\n"
    text += HEADER + POINT
    rows = VALUES.tolist()
    if at_once:
        points = [point(row, i) for i, row in enumerate(rows)]
        trees = [{"header": header(0), "joint_names": list(NAMES), "points": points}]
    else:  # the controller is given the next five points with every message
        trees = [
            {
                "header": header(i),
                "joint_names": list(NAMES),
                "points": [point(row, k) for k, row in enumerate(rows[i : i + 5])],
            }
            for i in range(COUNT)
        ]
    log = read_log(cdr_log(tmp_path / "a.mcap", "/t", "trajectory_msgs/msg/JointTrajectory", text, trees))
    check(log)
    assert log.time_source == "time_from_start"
    assert log.messages_read == len(trees)


@pytest.mark.parametrize(
    ("start", "again", "count", "note"),
    [(0, 0, COUNT, "120 points of trajectories were overtaken"), (0, 50, COUNT + 50, "70 points of trajectories"),
     (0, 500, 2 * COUNT, "1 times a trajectory repeats the one before it")],
    ids=["the same time", "while it runs", "after it"],
)  # fmt: skip
def test_a_trajectory_sent_twice(tmp_path, start, again, count, note):
    text = "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points\n"
    points = [point(row, i) for i, row in enumerate(VALUES.tolist())]
    trees = [{"header": header(i), "joint_names": list(NAMES), "points": points} for i in (start, again)]
    log = read_log(
        cdr_log(tmp_path / "a.mcap", "/t", "trajectory_msgs/msg/JointTrajectory", text + HEADER + POINT, trees)
    )
    assert len(log.times) == count
    assert np.array_equal(log.values[-COUNT:], VALUES)
    assert log.segments == ((0, count),)
    assert any(note in line for line in log.notes)


@pytest.mark.parametrize("array", ["Float64MultiArray", "Float32MultiArray"])
def test_arrays_are_named_by_index(tmp_path, array):
    kind = f"std_msgs/msg/{array}"
    code = array.split("Multi")[0].lower()
    text = f"std_msgs/MultiArrayLayout layout\n{code}[] data\n{'=' * 80}\nMSG: std_msgs/MultiArrayLayout\n"
    text += "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n"
    text += f"{'=' * 80}\nMSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"
    path = cdr_log(tmp_path / "a.mcap", "/x", kind, text, [{"data": row} for row in VALUES.tolist()])
    values = VALUES if code == "float64" else VALUES.astype(np.float32).astype(float)
    log = read_log(path)
    check(log, [f"data[{i}]" for i in range(4)], values)
    assert log.unit is None
    check(read_log(path, names=["data[2]"]), ["data[2]"], values[:, 2:3])


def test_one_topic_a_joint(tmp_path):
    topics = [f"/{name}/angle" for name in NAMES]
    messages = [
        (topic, START_NS + i * STEP, START_NS + i * STEP, float64(value))
        for i, row in enumerate(VALUES.tolist())
        for topic, value in zip(topics, row, strict=True)
    ]
    kinds = dict.fromkeys(topics, ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr"))
    path = write_messages(tmp_path / "a.mcap", kinds, messages)
    names = [f"{topic}:data" for topic in topics]
    check(read_log(path, names=names), names)
    check(read_log(path, names=names[::-1]), names[::-1], VALUES[:, ::-1])
    check(read_log(path), names)
    check(read_log(path, names=topics), topics)
    check(read_log(path, topic=topics[1]), ["data"], VALUES[:, 1:2])
    with pytest.raises(LogError, match="has no angle; it has data"):
        read_log(path, names=[f"{topics[0]}:angle"])


def test_json_shapes(tmp_path):
    rows = list(enumerate(VALUES.tolist()))
    path = tmp_path / "a.mcap"
    check(read_log(json_log(path, [{"t": 0.01 * i} | dict(zip(NAMES, row, strict=True)) for i, row in rows])))
    check(read_log(json_log(path, [{"stamp": 0.01 * i, "name": list(NAMES), "position": row} for i, row in rows])))
    listed = [{"joints": [{"name": n, "position": x} for n, x in zip(NAMES, row, strict=True)]} for _, row in rows]
    log = read_log(json_log(path, listed))
    check(log)
    assert log.unit is None
    deep = [{"robot": {"left": {"hip": r[0], "knee": r[1]}, "right": {"hip": r[2], "knee": r[3]}}} for _, r in rows]
    check(read_log(json_log(path, deep)), [f"robot.{s}.{j}" for s in ("left", "right") for j in ("hip", "knee")])
    legs = [
        {"l": {"name": ["hip", "knee"], "angle": r[:2]}, "r": {"name": ["hip", "knee"], "angle": r[2:]}}
        for _, r in rows
    ]
    check(read_log(json_log(path, legs)), ["l.hip", "l.knee", "r.hip", "r.knee"])
    iso = [{"time": f"2026-01-01T00:00:{i * 0.01:012.9f}Z"} | dict(zip(NAMES, row, strict=True)) for i, row in rows]
    log = read_log(json_log(path, iso))
    check(log)
    assert log.time_source == "time"


def test_broken_json_is_counted(tmp_path):
    trees = [dict(zip(NAMES, row, strict=True)) for row in VALUES.tolist()]
    trees[3] = b'{"hip_l": 0.1, "kne'
    trees[4] = b"[" * 5000
    trees[5] = b'{"hip_l": ' + b"9" * 5000 + b"}"
    trees[6] = b"\xff\xfe"
    trees[7] = {"hip_l": None, "knee_l": "0.1", "hip_r": float("nan"), "knee_r": 1e400}
    trees[8] = trees[8] | {"hip_l": 10**400}
    log = read_log(json_log(tmp_path / "a.mcap", trees))
    values = np.delete(VALUES, [3, 4, 5, 6], axis=0)
    values[3], values[4, 0] = np.nan, np.nan
    assert np.array_equal(log.values, values, equal_nan=True)
    assert sum(loss.count for loss in log.losses) == 4
    assert any("hip_l: 2 of" in note for note in log.notes)


def test_well_known_types_need_no_schema_text(tmp_path):
    messages = [
        ("/j", START_NS + i * STEP, START_NS + i * STEP, joint_state(START_NS + i * STEP, NAMES, row))
        for i, row in enumerate(VALUES.tolist())
    ]
    for encoding, text in (("", ""), ("ros2idl", "module x {};"), ("ros2msg", "")):
        check(read_log(write_messages(tmp_path / "a.mcap", {"/j": (JOINT_TYPE, text, encoding, "cdr")}, messages)))


def test_a_schema_that_lies_is_said(tmp_path):
    lie = JOINT_STATE.replace("float64", "float32")
    messages = [("/j", START_NS + i, START_NS, joint_state(i, NAMES, row)) for i, row in enumerate(VALUES.tolist())]
    path = write_messages(tmp_path / "a.mcap", {"/j": (JOINT_TYPE, lie, "ros2msg", "cdr")}, messages)
    with pytest.raises(LogError, match="do not fit their schema"):
        read_log(path, topic="/j")


def test_names_decide_and_never_the_order(tmp_path):
    rng = np.random.default_rng(4)
    messages = []
    for i, row in enumerate(VALUES):
        order = rng.permutation(4)
        data = joint_state(START_NS + i * STEP, [NAMES[k] for k in order], row[order])
        messages.append(("/j", START_NS + i * STEP, START_NS + i * STEP, data))
    spoiled = [joint_state(START_NS + 50 * STEP + 5, NAMES, row) for row in ([1.0, 2.0], [])]
    spoiled.append(joint_state(START_NS + 50 * STEP + 6, ("hip_l", "hip_l"), (1.0, 2.0)))
    messages[50:50] = [("/j", START_NS + 50 * STEP, START_NS + 50 * STEP, data) for data in spoiled]
    path = write_messages(tmp_path / "a.mcap", {"/j": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages)
    log = read_log(path, names=NAMES)
    assert np.array_equal(log.values, VALUES)
    assert sorted(loss.count for loss in log.losses) == [1, 1, 1]
    assert any("'hip_l' twice" in str(loss) for loss in log.losses)


def test_a_topic_for_each_leg(tmp_path):
    kinds = dict.fromkeys(("/left", "/right"), (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr"))
    messages = []
    for i, row in enumerate(VALUES.tolist()):
        at = START_NS + i * STEP
        messages.append(("/left", at, at, joint_state(at, NAMES[:2], row[:2])))
        messages.append(("/right", at, at, joint_state(at, NAMES[2:], row[2:])))
    path = write_messages(tmp_path / "a.mcap", kinds, messages)
    log = read_log(path, names=NAMES)
    check(log)
    assert log.topic == "/left,/right"
    with pytest.raises(LogError, match="give the topic"):
        read_log(path)


def test_attachments_and_metadata_are_no_damage(tmp_path):
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=3000)
        writer.start()
        schema = writer.register_schema(JOINT_TYPE, "ros2msg", JOINT_STATE.encode())
        channel = writer.register_channel("/j", "cdr", schema)
        for i, row in enumerate(VALUES.tolist()):
            at = START_NS + i * STEP
            writer.add_message(channel, at, joint_state(at, NAMES, row), at, i)
            if i % 50 == 20:
                writer.add_attachment(at, at, "x.bin", "application/octet-stream", bytes(range(256)) * 100)
                writer.add_metadata("subject", {"height": "1.80"})
        writer.finish()
    log = read_log(path)
    check(log)
    assert log.notes == ("times from header.stamp",)


def test_the_right_topic_is_found_or_asked_for(tmp_path):
    kinds = dict.fromkeys(("/joint_states", "/desired", "/empty"), (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr"))
    kinds |= {
        "/temp": ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr"),
        "/odd": ("x/Y", "?", "ros2msg", "cdr"),
    }
    messages = []
    for i, row in enumerate(VALUES.tolist()):
        at = START_NS + i * STEP
        messages.append(("/joint_states", at, at, joint_state(at, NAMES, row)))
        messages.append(("/desired", at, at, joint_state(at, ("torso", "neck"), row[:2])))
        messages += [("/temp", at, at, float64(20.0)), ("/odd", at, at, b"\x00\x01\x00\x00")]
    path = write_messages(tmp_path / "a.mcap", kinds, messages)
    check(read_log(path, names=["knee_l"]), ["knee_l"], VALUES[:, 1:2])
    check(read_log(path, topic="/joint_states"))
    check(read_log(path))  # the one that names joints of legs
    legs = dict.fromkeys(("/joint_states", "/desired"), kinds["/empty"])
    both = [(topic, at, at, data) for _, at, _, data in messages[::4] for topic in legs]
    with pytest.raises(LogError, match=r"/joint_states, /desired may each.*give the topic"):
        read_log(write_messages(tmp_path / "b.mcap", legs, both))
    with pytest.raises(LogError, match=r"did you mean /joint_states"):
        read_log(path, topic="joint_state")
    with pytest.raises(LogError, match=r"/empty .*no message"):
        read_log(path, topic="/empty")
    with pytest.raises(LogError, match=r"/odd .*cannot be read"):
        read_log(path, topic="/odd")
    with pytest.raises(LogError, match="has no ankle; it has hip_l"):
        read_log(path, topic="/joint_states", names=["hip_l", "ankle"])
    with pytest.raises(LogError, match="no topic holds any of ankle"):
        read_log(path, names=["ankle"])


@pytest.mark.parametrize(
    ("encoding", "package"), [("ros1", "mcap-ros1-support"), ("protobuf", "mcap-protobuf-support")]
)
def test_a_missing_extra_is_named(tmp_path, monkeypatch, encoding, package):
    monkeypatch.setitem(sys.modules, f"{package.rpartition('-')[0].replace('-', '_')}.decoder", None)
    path = write_messages(tmp_path / "a.mcap", {"/j": ("a/B", "x", "", encoding)}, [("/j", 1, 1, b"abc")])
    for arguments in ({}, {"topic": "/j"}, {"names": ["hip"]}):
        with pytest.raises(LogError) as caught:
            read_log(path, **arguments)
        if "names" not in arguments:
            assert package in str(caught.value)
            assert f"pip install 'ggo-factors[{encoding}]'" in str(caught.value)


def test_compressions_and_no_chunks_read_the_same(tmp_path):
    from mcap.writer import CompressionType

    for kind in CompressionType:
        check(read_log(write_joint_log(tmp_path / "a.mcap", VALUES, compression=kind)))
    check(read_log(write_joint_log(tmp_path / "a.mcap", VALUES, use_chunking=False)))


def test_shapes_of_odd_trees():
    assert read_shape({"a": []}).problem
    assert read_shape([1.0, 2.0]).names == ("data[0]", "data[1]")
    assert read_shape(5).names == ("data",)
    assert read_shape({"name": ["a"], "position": []}).problem == "no positions"
    assert read_shape({"name": ["a"], "position": [True]}).shape != "state"
    deep = {}
    node = deep
    for _ in range(200):
        node["x"] = {}
        node = node["x"]
    assert read_shape(deep).problem == "no numbers"
