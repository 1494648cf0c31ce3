"""MCAP out: what other readers make of it, and that a file is whole or not there."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.interpolate import CubicSpline

from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.paper_gait import paper_base_gait
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.procedures.stairs import climb_stairs
from ggo_factors.procedures.steps import step_over
from ggo_factors.recording.export import ros2_log as ros2
from ggo_factors.recording.export.export_mcap import JOINTS, export_mcap, stick_figures
from ggo_factors.walking.step import Step
from ggo_factors.walking.walk import Walk

TOPICS = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/gait/trajectory": "trajectory_msgs/msg/JointTrajectory",
    "/gait/stick": "visualization_msgs/msg/MarkerArray",
    "/gait/scene": "visualization_msgs/msg/MarkerArray",
    "/robot_description": "std_msgs/msg/String",
    "/tf": "tf2_msgs/msg/TFMessage",
}


def two_steps() -> Walk:
    """The base gait twice, bent a little so that the second step starts where the first one ended."""
    base = paper_base_gait()
    jump = swap_roles(base.frames[-1]) - base.frames[0]
    fade = np.linspace(1.0, 0.0, len(base))[:, None]
    second = Gait(base.frames + fade * jump, base.dt, model=base.model)
    return Walk((base, second), (Step(foothold=(0.39, 0.0)),) * 2)


def read(path: Path) -> dict[str, list[tuple[SimpleNamespace, SimpleNamespace]]]:
    """Every topic's (message record, decoded message), by mcap-ros2-support."""
    found: dict[str, list[tuple[SimpleNamespace, SimpleNamespace]]] = {}
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message, decoded))
    return found


def nanoseconds(stamp: SimpleNamespace) -> int:
    return stamp.sec * 10**9 + stamp.nanosec


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("export") / "walk.mcap"
    export_mcap(two_steps(), path)
    return path


def test_positions_come_back_bit_equal_from_mcap_ros2_support(exported):
    want = two_steps().joint_trajectory("right")
    messages = read(exported)
    states = [decoded for _, decoded in messages["/joint_states"]]
    assert len(states) == len(want.time) == 101
    assert all(state.name == list(JOINTS) for state in states)
    positions = np.array([state.position for state in states])
    for column, joint in enumerate(JOINTS):
        assert positions[:, column].tobytes() == getattr(want, joint).tobytes()
    ((_, trajectory),) = messages["/gait/trajectory"]
    assert trajectory.joint_names == list(JOINTS)
    assert np.array([point.positions for point in trajectory.points]).tobytes() == positions.tobytes()
    assert [nanoseconds(p.time_from_start) for p in trajectory.points] == [10_000_000 * k for k in range(101)]


def test_positions_come_back_bit_equal_from_rosbags(exported):
    highlevel = pytest.importorskip("rosbags.highlevel")
    want = two_steps().joint_trajectory("right")
    with highlevel.AnyReader([exported]) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == TOPICS
        states, points, markers = [], [], []
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            if connection.topic == "/joint_states":
                states.append(message)
                assert nanoseconds(message.header.stamp) == time
            elif connection.topic == "/gait/trajectory":
                points = [point.positions for point in message.points]
            elif connection.topic == "/gait/stick":
                markers.append(message.markers)
    positions = np.array([state.position for state in states])
    assert positions.tobytes() == np.array(points).tobytes()
    assert positions.tobytes() == np.stack([getattr(want, joint) for joint in JOINTS], -1).tobytes()
    assert len(markers) == len(states)


def test_quality_of_service_is_read_by_rosbags(exported):
    highlevel = pytest.importorskip("rosbags.highlevel")
    from rosbags.interfaces import QosDurability, QosHistory, QosReliability

    with highlevel.AnyReader([exported]) as reader:
        for connection in reader.connections:
            (qos,) = connection.ext.offered_qos_profiles
            once = connection.topic in ("/gait/trajectory", "/gait/scene", "/robot_description")
            assert (qos.history, qos.reliability) == (QosHistory.KEEP_LAST, QosReliability.RELIABLE)
            assert qos.durability == (QosDurability.TRANSIENT_LOCAL if once else QosDurability.VOLATILE)
            assert qos.depth == (1 if once else 10)
            assert (qos.deadline.sec, qos.deadline.nsec) == (9223372036, 854775807)


def test_schemas_are_the_official_ones():
    typesys = pytest.importorskip("rosbags.typesys")
    for store in (typesys.Stores.ROS2_HUMBLE, typesys.Stores.ROS2_JAZZY, typesys.Stores.LATEST):
        official = typesys.get_typestore(store)
        for kind in TOPICS.values():
            ours = typesys.get_typestore(typesys.Stores.EMPTY)
            ours.register(typesys.get_types_from_msg(ros2.schema_text(kind.replace("/msg", "")), kind))
            assert ours.hash_rihs01(kind) == official.hash_rihs01(kind)


def test_summary_profile_and_times(exported):
    with exported.open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()} == TOPICS
        for channel in summary.channels.values():
            assert channel.message_encoding == "cdr"
            assert summary.schemas[channel.schema_id].encoding == "ros2msg"
            assert "reliability: 1\n" in channel.metadata["offered_qos_profiles"]
        assert summary.statistics.message_count == 3 * 101 + 3
        assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 10**9)
    for topic, messages in read(exported).items():
        for record, decoded in messages:
            if topic == "/robot_description":
                continue  # has no header
            inside = getattr(decoded, "markers", None) or getattr(decoded, "transforms", None) or [decoded]
            heads = [part.header for part in inside]
            assert {nanoseconds(head.stamp) for head in heads} == {record.log_time} == {record.publish_time}


def test_velocities_and_accelerations_are_those_of_a_spline_through_the_positions(exported):
    messages = read(exported)
    states = [decoded for _, decoded in messages["/joint_states"]]
    points = messages["/gait/trajectory"][0][1].points
    velocities = np.array([state.velocity for state in states])
    np.testing.assert_array_equal([point.velocities for point in points], velocities)
    times = 0.01 * np.arange(101)
    ends = (1, velocities[0]), (1, velocities[-1])
    spline = CubicSpline(times, [state.position for state in states], bc_type=ends)
    np.testing.assert_allclose(velocities, spline(times, 1), atol=1e-9)
    np.testing.assert_allclose([point.accelerations for point in points], spline(times, 2), atol=1e-6)


def test_stick_figure_stands_where_the_steps_end(exported):
    walk = two_steps()
    figures = [decoded.markers for _, decoded in read(exported)["/gait/stick"]]
    points = np.array([[[(p.x, p.y, p.z) for p in leg.points] for leg in markers] for markers in figures])
    assert [leg.text for leg in figures[0]] == ["left", "right"]
    assert {leg.type for leg in figures[0]} == {4}
    assert (points[..., 1] == 0.0).all()
    left, right = points[:, 0, :, ::2], points[:, 1, :, ::2]
    # The left ankle is the origin of the first step; the right one comes down at P and then stays.
    np.testing.assert_array_equal(left[:51, 0], 0.0)
    np.testing.assert_allclose(right[:51, 0], walk.gaits[0].endpoints())
    np.testing.assert_allclose(right[50:, 0], np.tile(right[50, 0], (51, 1)), atol=1e-9)
    np.testing.assert_allclose(left[-1, 0], right[50, 0] + walk.gaits[1].endpoints()[-1], atol=1e-12)
    # Both legs end in the hip, and no segment changes its length.
    np.testing.assert_allclose(left[:, 2], right[:, 2], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(np.diff(points, axis=2), axis=-1), 0.39, atol=1e-12)


def test_first_swing_says_which_leg(tmp_path):
    walk = two_steps()
    export_mcap(walk, tmp_path / "left.mcap", first_swing="left")
    first = read(tmp_path / "left.mcap")["/joint_states"][0][1]
    assert first.position == [*walk.gaits[0].frames[0, 2:], *walk.gaits[0].frames[0, :2]]
    figure = stick_figures(walk.gaits, walk.model, "left")[0]
    np.testing.assert_array_equal(figure["right"][0], 0.0)
    with pytest.raises(InputError, match="first_swing: 'both'"):
        export_mcap(walk, tmp_path / "both.mcap", first_swing="both")
    assert os.listdir(tmp_path) == ["left.mcap"]


def test_pelvis_tilt_is_taken_from_the_hips_only(tmp_path, exported):
    export_mcap(two_steps(), tmp_path / "tilted.mcap", pelvis_tilt=-0.25)
    tilted, plain = (
        np.array([decoded.position for _, decoded in read(path)["/joint_states"]])
        for path in (tmp_path / "tilted.mcap", exported)
    )
    assert (tilted[:, [1, 3]] == plain[:, [1, 3]]).all()
    assert (tilted[:, [0, 2]] == plain[:, [0, 2]] + 0.25).all()


@pytest.mark.parametrize("tilt", [float("nan"), -17.0, "level", None])
def test_pelvis_tilt_that_is_no_angle_is_refused(tmp_path, tilt):
    with pytest.raises(InputError, match="pelvis_tilt"):
        export_mcap(paper_base_gait(), tmp_path / "x.mcap", pelvis_tilt=tilt)
    assert os.listdir(tmp_path) == []


def test_metadata_says_what_was_exported(tmp_path):
    export_mcap(paper_base_gait(frames=26), tmp_path / "gait.mcap", pelvis_tilt=0.1, first_swing="left")
    with (tmp_path / "gait.mcap").open("rb") as stream:
        (record,) = make_reader(stream).iter_metadata()
    assert record.name == "gait"
    expected = {
        "format_version": "1",
        "name": "paper base gait",
        "steps": "1",
        "frames": "26",
        "dt_s": "0.02",
        "first_swing": "left",
        "pelvis_tilt_rad": "0.1",
        "thigh_m": "0.39",
        "shank_m": "0.39",
    }
    assert record.metadata.items() >= expected.items()


def test_a_solution_is_exported_only_when_it_passed_its_check(tmp_path):
    good = step_over(paper_base_gait(), [Obstacle(0.2, 0.25, 0.08)], foothold=(0.39, 0.0))
    bad = replace(good, converged=False, reason="stopped early")
    with pytest.raises(InfeasibleGaitError, match="stopped early"):
        export_mcap(bad, tmp_path / "bad.mcap")
    assert os.listdir(tmp_path) == []
    export_mcap(good, tmp_path / "good.mcap")
    export_mcap(good.gait, tmp_path / "gait.mcap")
    solved, alone = read(tmp_path / "good.mcap"), read(tmp_path / "gait.mcap")
    states = [[tuple(state.position) for _, state in messages["/joint_states"]] for messages in (solved, alone)]
    assert states[0] == states[1]
    # A gait alone does not know what it steps over.
    assert (len(solved["/gait/scene"][0][1].markers), len(alone["/gait/scene"][0][1].markers)) == (3, 0)


def test_a_generated_walk_comes_back_as_it_was(tmp_path):
    walk = climb_stairs(paper_base_gait(), riser=[0.10, 0.14])
    export_mcap(walk, tmp_path / "stairs.mcap")
    messages = read(tmp_path / "stairs.mcap")
    want = walk.joint_trajectory("right")
    positions = np.array([state.position for _, state in messages["/joint_states"]])
    assert positions.tobytes() == np.stack([getattr(want, joint) for joint in JOINTS], -1).tobytes()
    # The left leg swings last: its ankle ends on the second stair.
    left = messages["/gait/stick"][-1][1].markers[0].points[0]
    np.testing.assert_allclose((left.x, left.z), (0.78, 0.24), atol=2e-3)


def test_two_frames_are_enough(tmp_path):
    export_mcap(paper_base_gait(frames=2), tmp_path / "two.mcap")
    first, last = (decoded for _, decoded in read(tmp_path / "two.mcap")["/joint_states"])
    assert first.velocity == last.velocity


def test_what_cannot_be_exported_is_named(tmp_path):
    base = paper_base_gait()
    with pytest.raises(InputError, match="expected a Walk, a Solution or a Gait"):
        export_mcap("walk.csv", tmp_path / "x.mcap")
    with pytest.raises(InputError, match="model: gait"):
        export_mcap(Gait(base.frames, 0.01), tmp_path / "x.mcap")
    with pytest.raises(InputError, match="dt"):
        export_mcap(Gait(base.frames[:2], 1e-10, model=base.model), tmp_path / "x.mcap")
    assert os.listdir(tmp_path) == []
    export_mcap(Gait(base.frames, 0.01), tmp_path / "x.mcap", model=base.model)


def test_a_file_is_whole_or_not_there(tmp_path, monkeypatch):
    for bad in (tmp_path / "missing" / "x.mcap", tmp_path):
        with pytest.raises(InputError, match="cannot be written"):
            export_mcap(paper_base_gait(), bad)
    target = tmp_path / "x.mcap"
    target.write_bytes(b"as it was")

    def fail(kind: str, message: object) -> bytes:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(ros2, "encode", fail)
    with pytest.raises(InputError, match="No space left"):
        export_mcap(paper_base_gait(), target)
    assert target.read_bytes() == b"as it was"
    assert os.listdir(tmp_path) == ["x.mcap"]


def test_a_folder_that_may_not_be_written(tmp_path, monkeypatch):
    def refuse(**where: object) -> tuple[int, str]:  # root, who may run the tests, writes anywhere
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("ggo_factors.support.files.tempfile.mkstemp", refuse)
    with pytest.raises(InputError, match="cannot be written: Permission denied"):
        export_mcap(paper_base_gait(), tmp_path / "x.mcap")


def test_no_field_is_dropped():
    state = {"header": ros2.header(0), "name": ["a"], "position": [1.0], "velocity": [], "effort": []}
    assert ros2.encode("sensor_msgs/JointState", state)
    with pytest.raises(ValueError, match=r"\['position', 'positions'\]"):
        ros2.encode("sensor_msgs/JointState", {k.replace("position", "positions"): v for k, v in state.items()})
    with pytest.raises(ValueError, match=r"\['effort'\]"):
        ros2.encode("sensor_msgs/JointState", {k: v for k, v in state.items() if k != "effort"})


def test_encoding_equals_that_of_mcap_ros2_support():
    from mcap_ros2.writer import serialize_dynamic

    generator = np.random.default_rng(5)
    for _ in range(50):
        names = ["j" * int(n) for n in generator.integers(0, 9, generator.integers(0, 4))]
        values = generator.normal(size=len(names)).tolist()
        point = {
            "positions": values,
            "velocities": [],
            "accelerations": values[:1],
            "effort": [],
            "time_from_start": ros2.stamp(int(generator.integers(0, 10**12))),
        }
        message = {"header": ros2.header(123, names[0] if names else ""), "joint_names": names, "points": [point] * 2}
        kind = "trajectory_msgs/JointTrajectory"
        theirs = serialize_dynamic(kind, ros2.schema_text(kind))[kind](message)
        assert ros2.encode(kind, message) == theirs
