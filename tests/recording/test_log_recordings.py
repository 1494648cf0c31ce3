"""The recordings, each by its own .json: real walks, one walk in many formats, damaged logs, other programs' files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from ggo_factors.errors import LogError
from ggo_factors.recording.log.inspect import inspect_log
from ggo_factors.recording.log.read_log import read_log

UNREADABLE = {
    "h_bomb_zstd_512mib": "512 MiB",
    "h_claims_2gib_zstd": "2048 MiB",
    "h_cut_5pct": "byte 7897",
    "h_empty": "empty",
    "h_magic_start": "magic",
    "h_sqlite_bag": "SQLite",
    "h_unknown_compression": "brotli",
    "h_zero_messages": "no message",
}
ROLES = ("left_hip", "left_knee", "right_hip", "right_knee")


def described(folder):
    """Each log of a folder that has a description."""
    for path in sorted(folder.glob("*.json")):
        yield path.with_suffix(".mcap"), json.loads(path.read_text())


def wanted(truth):
    names = [truth["names"][role] for role in ROLES]
    if isinstance(truth["topic"], dict):
        return [f"{truth['topic'][role]}:data" for role in ROLES]
    field = "position" if "JointState" in (truth["schema"] or "") else "data"
    return [name if isinstance(name, str) else f"{field}[{name}]" for name in names]


def test_formats_and_hostile_logs_are_read_as_described(recordings):
    for folder in ("formats", "hostile"):
        for path, truth in described(recordings / folder):
            name = path.stem
            if name in UNREADABLE:
                with pytest.raises(LogError, match=UNREADABLE[name]):
                    read_log(path)
                continue
            names = wanted(truth)
            if name == "h_missing_joint":
                with pytest.raises(LogError, match="right_knee_joint"):
                    read_log(path, names=["left_hip_joint", "right_knee_joint"])
                continue
            if name == "h_no_names":
                names = [f"position[{i}]" for i in range(4)]
            log = read_log(path, names=names)
            written = truth["messages_written"]
            assert log.messages_read == truth.get("messages_recoverable", log.messages_read), name
            lost = sum(loss.count or 0 for loss in log.losses)
            if "messages_recoverable" not in truth or log.messages_expected:
                assert log.messages_read + lost == written, name
            else:
                assert log.losses, name
            source = "time_from_start" if name == "joint_trajectory" else truth["time_source"]
            assert log.time_source == source, name
            assert np.all(np.diff(log.times) > 0), name
            stretch = 1.5 if name == "h_stamp_drift" else 1.0
            assert abs(log.times[-1] / stretch - truth.get("duration_s", log.times[-1])) < 0.1 or log.losses, name
            assert len(log.segments) == (2 if name == "h_clock_jump" else 1), name
            if "range_deg" in truth and not set(name.split("_")) & {"wrapped", "spikes", "stuck", "nan"}:
                check_ranges(log, truth, name)


def check_ranges(log, truth, name):
    to_degrees = 1.0 if truth["unit"] == "deg" else 180 / np.pi
    for column, role in zip(log.values.T, ROLES, strict=True):
        low, high = np.nanpercentile(column * to_degrees * truth["sign"][role], (2, 98))
        assert truth["range_deg"][role][0] - 1 < low, (name, role)
        assert high < truth["range_deg"][role][1] + 1, (name, role)
        assert high - low > 0.8 * (truth["range_deg"][role][1] - truth["range_deg"][role][0]), (name, role)


def test_the_losses_of_the_hostile_logs_lie_where_they_were_made(recordings):
    for path, truth in described(recordings / "hostile"):
        spans = truth.get("recoverable_s")
        if not spans:
            continue
        log = read_log(path)
        start = spans[0][0]
        if len(spans) == 2:
            (loss,) = log.losses
            assert loss.count == truth["messages_written"] - truth["messages_recoverable"]
            assert (loss.from_s, loss.to_s) == pytest.approx((spans[0][1] - start, spans[1][0] - start), abs=0.02)
        assert log.times[-1] == pytest.approx(spans[-1][1] - start, abs=0.02)


def test_ros2_logs_are_equal_to_the_official_reader(recordings):
    paths = [*recordings.glob("*.mcap"), *(recordings / "formats").glob("*.mcap")]
    compared = 0
    for path in paths:
        rows, stamps = [], []
        with path.open("rb") as file:
            reader = make_reader(file, decoder_factories=[DecoderFactory()])
            summary = reader.get_summary()
            if summary is None:
                continue
            states = {s.id for s in summary.schemas.values() if s.name == "sensor_msgs/msg/JointState"}
            topics = [c.topic for c in summary.channels.values() if c.schema_id in states]
            for _, _, _, message in reader.iter_decoded_messages(topics) if topics else ():
                rows.append(list(message.position))
                stamps.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)
                names = message.name
        if not rows:
            continue
        log = read_log(path, topic=topics[0])
        assert log.names == tuple(names)
        assert np.array_equal(log.values, np.array(rows)), path
        assert np.allclose(log.times, (np.array(stamps) - stamps[0]) * 1e-9, rtol=0, atol=1e-9), path
        compared += 1
    assert compared >= 10


def test_a_split_bag_is_one_log(recordings):
    log = read_log(recordings / "formats" / "split_bag")
    assert log.messages_read == log.messages_expected == 2718
    assert np.diff(log.times).max() < 0.05
    assert inspect_log(recordings / "formats" / "split_bag").files == 2


def test_logs_of_other_programs(recordings):
    folder = recordings / "others"
    assert read_log(folder / "pr2_joint_states_ros1.mcap").values.shape == (1598, 42)
    assert read_log(folder / "rosbag2_one_joint_state.mcap").names == ("joint1", "joint2", "joint3")
    for path in folder.glob("*.mcap"):
        if path.stem == "git_lfs_pointer":
            with pytest.raises(LogError, match="git lfs pull"):
                inspect_log(path)
            continue
        summary = inspect_log(path)
        assert not summary.damaged
        joints = {"pr2_joint_states_ros1": "joint_states", "rosbag2_one_joint_state": "/one_shot/joint_state"}
        assert summary.topic == joints.get(path.stem), path


def test_inspect_names_topic_joints_unit_and_damage(recordings):
    for folder in ("formats", "hostile"):
        for path, truth in described(recordings / folder):
            name = path.stem
            if name == "h_zero_messages":
                summary = inspect_log(path)
                assert summary.topic is None
                assert any("no message" in note for note in summary.notes)
                continue
            if name in UNREADABLE:
                with pytest.raises(LogError, match=UNREADABLE[name]):
                    inspect_log(path)
                continue
            summary = inspect_log(path)
            topic = truth["topic"]
            assert summary.topic == (topic if isinstance(topic, str) else ",".join(topic.values())), name
            assert summary.unit_guess == truth["unit"], name
            lost = truth.get("messages_written", 0) > truth.get("messages_recoverable", 10**9)
            assert summary.damaged == (lost or name in ("h_no_footer", "h_cdr_short", "h_json_broken")), name
            found = {joint.looks_like: joint.name for joint in summary.joints if joint.looks_like}
            if truth["names"] and name not in ("names_unknown", "float64multiarray", "h_no_names", "h_missing_joint"):
                assert found == dict(zip(ROLES, wanted(truth), strict=True)), name
            values = summary.to_json()
            assert values["format_version"] == 1
            assert json.loads(json.dumps(values)) == values or isinstance(values["topics"], tuple)


def test_inspect_of_the_real_walks(recordings):
    for path, truth in described(recordings):
        summary = inspect_log(path)
        assert summary.topic == truth["topic"]
        assert summary.unit_guess == truth["units"], path
        assert not summary.damaged
        assert summary.topics[0].rate_hz == pytest.approx(truth["rate_hz"], rel=0.03)
        assert summary.duration_s == pytest.approx(truth["duration_s"], abs=0.05)
        names = {joint.name for joint in summary.joints}
        roles = {joint.looks_like: joint.name for joint in summary.joints if joint.looks_like}
        assert set(roles) == set(ROLES)
        for angle, terms in truth["joint_map"].items():
            assert names >= set(terms), path
            kind, side = angle.split("_")
            assert roles[f"{side}_{'hip' if kind == 'alpha' else 'knee'}"] in terms, path
