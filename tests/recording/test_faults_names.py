"""Which value is which: ids instead of names, names that come once, names in other clothes, topics without joints."""

from __future__ import annotations

import json

import numpy as np
import pytest
from log_files import HEADER, JOINT_STATE, JOINT_TYPE, START_NS, joint_state, stamp, write_messages
from mcap_ros2._dynamic import serialize_dynamic
from test_import_refusals import NAMES, log_of, walk

import ggo_factors as ggo
from ggo_factors.recording.log.read_log import read_log

STATE = (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")
JSON = ("", "", "", "json")
ANGLES = walk(700)
TIMES = [START_NS + n * 10**7 for n in range(len(ANGLES))]
TERMS = dict(zip(("alpha_left", "beta_left", "alpha_right", "beta_right"), NAMES, strict=True))
MOTORS = """std_msgs/Header header
Motor[] motors
================================================================================
MSG: exo_msgs/Motor
uint8 id
float32 temperature
float64 pos
""" + HEADER.lstrip()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return ggo.import_base_gait(log_of(tmp_path_factory.mktemp("log") / "a.mcap", ANGLES), joints="direct")


def written(path, topics, messages):
    """A log of messages (topic, data), ten milliseconds apart for each topic."""
    counts = dict.fromkeys(topics, 0)
    rows = []
    for topic, data in messages:
        at = TIMES[counts[topic]]
        counts[topic] += 1
        rows.append((topic, at, at, data))
    return write_messages(path, topics, rows)


def by_name(names):
    return ggo.JointMap({angle: {name: 1.0} for angle, name in zip(TERMS, names, strict=True)}, "rad")


def shuffled(row, n):
    """(id, value) of a row in an order that changes."""
    items = list(zip((11, 12, 21, 22), row, strict=True))
    return items[n % 4 :] + items[: n % 4]


def json_ids(row, n, key):
    return json.dumps({"joints": [{key: i, "pos": value} for i, value in shuffled(row, n)]}).encode()


@pytest.mark.parametrize("key", ["id", "motor_id"])
def test_objects_in_any_order_are_named_by_their_id(tmp_path, key, whole):
    path = written(
        tmp_path / "a.mcap", {"/motors": JSON},
        [("/motors", json_ids(row, n, key)) for n, row in enumerate(ANGLES.tolist())],
    )  # fmt: skip
    joints = by_name([f"joints[{key}={i}].pos" for i in (11, 12, 21, 22)])
    np.testing.assert_array_equal(ggo.import_base_gait(path, joints=joints).gait.frames, whole.gait.frames)


def test_objects_in_cdr_are_named_by_their_id(tmp_path, whole):
    encode = serialize_dynamic("exo_msgs/msg/State", MOTORS)["exo_msgs/msg/State"]
    messages = []
    for n, (at, row) in enumerate(zip(TIMES, ANGLES.tolist(), strict=True)):
        motors = [{"id": i, "temperature": 30.0 + n % 3, "pos": value} for i, value in shuffled(row, n)]
        messages.append(("/motors", encode({"header": {"stamp": stamp(at), "frame_id": ""}, "motors": motors})))
    path = written(tmp_path / "a.mcap", {"/motors": ("exo_msgs/msg/State", MOTORS, "ros2msg", "cdr")}, messages)
    joints = by_name([f"motors[id={i}].pos" for i in (11, 12, 21, 22)])
    np.testing.assert_array_equal(ggo.import_base_gait(path, joints=joints).gait.frames, whole.gait.frames)


def test_an_id_that_is_a_name_is_the_name(tmp_path, whole):
    data = [
        ("/motors", json.dumps([{"id": name, "pos": x} for name, x in zip(NAMES, row, strict=True)]).encode())
        for row in ANGLES.tolist()
    ]
    path = written(tmp_path / "a.mcap", {"/motors": JSON}, data)
    report = ggo.import_base_gait(path, joints="direct", unit="rad")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)


def test_ids_that_are_there_twice_name_nothing(tmp_path):
    data = json.dumps({"joints": [{"id": 1, "pos": 0.1}, {"id": 1, "pos": 0.2}]}).encode()
    path = written(tmp_path / "a.mcap", {"/motors": JSON}, [("/motors", data)] * 3)
    assert read_log(path).names == ("joints[0].id", "joints[0].pos", "joints[1].id", "joints[1].pos")


@pytest.mark.parametrize("every", [10**9, 100])
@pytest.mark.parametrize("chunk_size", [2000, 10**6])
def test_names_that_come_in_the_first_message_serve_the_later_ones(tmp_path, every, chunk_size, whole):
    data = [
        ("/joint_states", at, at, joint_state(at, () if n % every else NAMES, row))
        for n, (at, row) in enumerate(zip(TIMES, ANGLES.tolist(), strict=True))
    ]
    path = write_messages(tmp_path / "a.mcap", {"/joint_states": STATE}, data, chunk_size=chunk_size)
    report = ggo.import_base_gait(path, joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)
    unnamed = sum(n % every > 0 for n in range(700))
    assert f"{unnamed} messages of /joint_states name no joints: they have the names of those that do" in report.notes


def test_names_in_the_first_file_of_a_bag_serve_the_second(tmp_path, whole):
    for n in range(2):
        part = slice(350 * n, 350 * (n + 1))
        data = [
            ("/joint_states", at, at, joint_state(at, () if n or at > START_NS else NAMES, row))
            for at, row in zip(TIMES[part], ANGLES[part].tolist(), strict=True)
        ]
        write_messages(tmp_path / f"a_{n}.mcap", {"/joint_states": STATE}, data)
    report = ggo.import_base_gait(tmp_path, joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)


def test_names_in_the_first_message_of_json(tmp_path, whole):
    data = [
        ("/joints", json.dumps({"position": row} | ({} if n else {"name": NAMES})).encode())
        for n, row in enumerate(ANGLES.tolist())
    ]
    path = written(tmp_path / "a.mcap", {"/joints": JSON}, data)
    report = ggo.import_base_gait(path, joints="direct", unit="rad")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)


def test_after_two_lists_of_names_a_message_without_is_dropped(tmp_path):
    lists = {0: NAMES, 300: NAMES[::-1]}
    data = [("/joint_states", joint_state(TIMES[n], lists.get(n, ()), row)) for n, row in enumerate(ANGLES.tolist())]
    log = read_log(written(tmp_path / "a.mcap", {"/joint_states": STATE}, data), names=NAMES)
    assert log.times[-1] <= 3.0
    assert any(
        (loss.count or 0) >= 399 and "4 positions without names, and two lists of names came before" in loss.what
        for loss in log.losses
    )


@pytest.mark.parametrize(
    "form",
    [
        "exo/{Side}{Joint}Joint", "/h3/{Side}{Joint}", "robot.legs.{S}{Joint}Angle", "exo::{side}_{joint}",
        "{side}Leg/{joint}/{side}_{joint}_joint", "{Joint}Joint{Side}", "Exo_{S}_{Joint}_Position",
    ],
)  # fmt: skip
def test_joint_names_in_other_clothes(tmp_path, form, whole):
    names = [
        form.format(side=side, Side=side.title(), S=side[0].upper(), joint=joint, Joint=joint.title())
        for side, joint in (name.split("_") for name in NAMES)
    ]
    report = ggo.import_base_gait(log_of(tmp_path / "a.mcap", ANGLES, names), joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)


def test_two_namespaces_of_a_joint_are_told(tmp_path):
    names = [f"{space}/{name}" for space in ("measured", "wanted") for name in NAMES]
    with pytest.raises(ggo.LogError, match=r"right_hip and wanted/right_hip fit"):
        ggo.import_base_gait(log_of(tmp_path / "a.mcap", np.hstack([ANGLES, ANGLES]), names), joints="direct")


LONG = [f"exoskeleton_left_leg_joint_number_{i}_position" for i in range(40)]
ANY_MAP = ggo.JointMap({angle: {angle: 1.0} for angle in TERMS})


@pytest.mark.parametrize("options", [{}, {"joints": None}, {"joints": ANY_MAP}, {"topic": "/x"}])
@pytest.mark.parametrize("kind", ["one topic", "many topics", "no joints", "garbage"])
def test_errors_are_short(tmp_path, kind, options):
    if kind in ("one topic", "many topics"):
        topics = {f"/robot/controller_{i}/joint_states": STATE for i in range(14 if kind == "many topics" else 1)}
        rows = np.tile(ANGLES[:30], (1, 10)).tolist()
        messages = [(t, joint_state(at, LONG, row)) for at, row in zip(TIMES, rows, strict=False) for t in topics]
    elif kind == "no joints":
        topics = {f"/sensors/thing_number_{i}": JSON for i in range(30)}
        messages = [(t, json.dumps({"temperature": 20.0, "voltage": 24.0}).encode()) for t in topics for _ in range(9)]
    else:
        topics = {f"/garbage/number_{i}": (f"pkg/msg/Type{i}", "pkg/Foo bar", "ros2msg", "cdr") for i in range(30)}
        messages = [(t, b"\x00\x01\x00\x00aaaa") for t in topics for _ in range(5)]
    path = written(tmp_path / "a.mcap", topics, messages)
    with pytest.raises(ggo.LogError) as error:
        ggo.import_base_gait(path, **{"joints": "direct"} | options)
    assert len(str(error.value)) - len(str(path)) < 400
    assert len(ggo.inspect_log(path).topics) == len(topics)


IMU = "float64 x\nfloat64 y\nfloat64 z"
THINGS = {
    "/imu/data": ("sensor_msgs/msg/Imu", IMU, "ros2msg", "cdr"),
    "/exo/battery": JSON,
    "/exo/chip_temp": JSON,
    "/exo/motor_currents": ("std_msgs/msg/Float64MultiArray", "float64[] data", "ros2msg", "cdr"),
    "/diagnostics": JSON,
}


def things():
    for _ in TIMES[:50]:
        yield "/imu/data", b"\0\1\0\0" + np.array([0.1, 0.2, 9.8]).tobytes()
        yield "/exo/battery", json.dumps({"voltage": 24.0, "current": 1.5}).encode()
        yield "/exo/chip_temp", json.dumps({"chip_temp": 41.0, "ship_temp": 20.0}).encode()
        yield "/exo/motor_currents", b"\0\1\0\0\4\0\0\0\0\0\0\0" + np.arange(4.0).tobytes()
        yield "/diagnostics", json.dumps([{"name": "cpu", "value": 0.3}, {"name": "fan", "value": 3}]).encode()


def test_topics_without_joints_are_not_offered(tmp_path):
    path = written(tmp_path / "a.mcap", THINGS, things())
    assert ggo.inspect_log(path).topic is None
    with pytest.raises(ggo.LogError, match="no topic holds joints") as error:
        ggo.import_base_gait(path, joints=None)
    assert "may each hold the joints" not in str(error.value)


@pytest.mark.parametrize("gripper", [("finger1", "finger2"), ("arm_shoulder", "arm_elbow", "arm_wrist")])
def test_legs_are_found_beside_other_joints_and_things(tmp_path, gripper, whole):
    messages = list(things())
    for at, row in zip(TIMES, ANGLES.tolist(), strict=True):
        messages += [("/arm", joint_state(at, gripper, row[: len(gripper)])), ("/legs", joint_state(at, NAMES, row))]
    path = written(tmp_path / "a.mcap", THINGS | {"/arm": STATE, "/legs": STATE}, messages)
    np.testing.assert_array_equal(ggo.import_base_gait(path, joints="direct").gait.frames, whole.gait.frames)
    assert ggo.inspect_log(path).topic == "/legs"
