"""Bags that are no plain MCAP give the base gait of the MCAP with the same messages."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
import zstandard
from log_files import JOINT_TYPE, NAMES, START_NS, write_joint_log
from mcap.writer import CompressionType
from test_cut_strides import walk

import ggo_factors as ggo
from ggo_factors.cli import main

rosbags = pytest.importorskip("rosbags")
from rosbags.rosbag1 import Writer as Writer1  # noqa: E402
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin  # noqa: E402
from rosbags.rosbag2 import Writer as Writer2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

TIMES, RIGHT_FIRST, _ = walk(6)
VALUES = np.ascontiguousarray(RIGHT_FIRST[:, [2, 3, 0, 1]])
TIMES_NS = START_NS + np.rint(TIMES * 1e9).astype(np.int64)
JOINTS = "direct"


@pytest.fixture(scope="module")
def mcap(tmp_path_factory):
    return write_joint_log(tmp_path_factory.mktemp("logs") / "walk.mcap", VALUES, times_ns=TIMES_NS)


@pytest.fixture(scope="module")
def frames(mcap):
    return ggo.import_base_gait(mcap, joints=JOINTS).gait.frames


def states(store):
    """Names and values as messages of a store, each with its time."""
    kinds = store.types
    for number, (ns, row) in enumerate(zip(TIMES_NS.tolist(), VALUES, strict=True)):
        stamp = kinds["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
        more = {"seq": number} if store is ROS1 else {}
        header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="exo", **more)
        empty = np.zeros(0)
        yield ns, kinds[JOINT_TYPE](header=header, name=list(NAMES), position=row, velocity=empty, effort=empty)


ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.LATEST)


def write_bag(path, storage, mode=None):
    writer = Writer2(path, version=9, storage_plugin=storage)
    if mode is not None:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer as bag:
        channel = bag.add_connection("/joint_states", JOINT_TYPE, typestore=ROS2)
        for ns, state in states(ROS2):
            bag.write(channel, ns, ROS2.serialize_cdr(state, JOINT_TYPE))
    return path


def write_ros1(path):
    with Writer1(path) as bag:
        channel = bag.add_connection("/joint_states", JOINT_TYPE, typestore=ROS1)
        for ns, state in states(ROS1):
            bag.write(channel, ns, bytes(ROS1.serialize_ros1(state, JOINT_TYPE)))
    return path


def without_definitions(path):
    """An SQLite bag as ROS 2 Humble writes it."""
    import sqlite3

    (file,) = path.glob("*.db3")
    with sqlite3.connect(file) as data:
        data.execute("DELETE FROM message_definitions")
    return path


KINDS = {
    "SQLite": lambda folder: write_bag(folder / "bag", StoragePlugin.SQLITE3),
    "SQLite file": lambda folder: next(write_bag(folder / "bag", StoragePlugin.SQLITE3).glob("*.db3")),
    "SQLite without definitions": lambda folder: without_definitions(write_bag(folder / "bag", StoragePlugin.SQLITE3)),
    "SQLite, messages compressed": lambda folder: write_bag(
        folder / "bag", StoragePlugin.SQLITE3, CompressionMode.MESSAGE
    ),
    "MCAP, messages compressed": lambda folder: write_bag(folder / "bag", StoragePlugin.MCAP, CompressionMode.MESSAGE),
    "MCAP, files compressed": lambda folder: write_bag(folder / "bag", StoragePlugin.MCAP, CompressionMode.FILE),
    "MCAP folder": lambda folder: write_bag(folder / "bag", StoragePlugin.MCAP),
    "ROS 1": lambda folder: write_ros1(folder / "walk.bag"),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_gives_the_same_base_gait(tmp_path, frames, kind):
    path = KINDS[kind](tmp_path)
    parts = []
    report = ggo.import_base_gait(path, joints=JOINTS, progress=parts.append)
    assert np.array_equal(report.gait.frames, frames)
    assert report.source == str(path)
    assert report.topic == "/joint_states"
    assert report.time_source == "header.stamp"
    assert report.messages_read == report.messages_expected == len(TIMES)
    assert report.losses == ()
    assert parts == sorted(parts)
    assert parts[-1] == 1.0
    summary = ggo.inspect_log(path)
    assert (summary.source, summary.topic, summary.damaged) == (str(path), "/joint_states", False)
    assert {joint.looks_like for joint in summary.joints} == {"left_hip", "left_knee", "right_hip", "right_knee"}


def compressed(mcap, path):
    path.write_bytes(zstandard.ZstdCompressor().compress(mcap.read_bytes()))
    return path


def test_a_compressed_file_needs_no_metadata(tmp_path, mcap, frames):
    path = compressed(mcap, tmp_path / "walk.mcap.zstd")
    assert np.array_equal(ggo.import_base_gait(path, joints=JOINTS).gait.frames, frames)
    assert ggo.inspect_log(path).size_bytes == path.stat().st_size
    (tmp_path / "bag").mkdir()
    shutil.move(path, tmp_path / "bag")
    assert np.array_equal(ggo.import_base_gait(tmp_path / "bag", joints=JOINTS).gait.frames, frames)


def test_what_is_left_of_a_cut_compressed_file_is_read(tmp_path):
    plain = write_joint_log(tmp_path / "walk.mcap", VALUES, times_ns=TIMES_NS, compression=CompressionType.NONE)
    whole = compressed(plain, tmp_path / "walk.mcap.zstd").read_bytes()
    (tmp_path / "walk.mcap.zstd").write_bytes(whole[: len(whole) * 95 // 100])
    report = ggo.import_base_gait(tmp_path / "walk.mcap.zstd", joints=JOINTS, min_strides=1)
    assert report.losses
    assert report.messages_read < len(TIMES)
    (tmp_path / "walk.mcap.zstd").write_bytes(whole[:100])
    with pytest.raises(ggo.LogError, match="not a zstd file, or damaged at its start"):
        ggo.import_base_gait(tmp_path / "walk.mcap.zstd", joints=JOINTS)


def test_a_wheel_beside_the_joints_and_an_image_are_no_matter(tmp_path, frames):
    with Writer2(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        channel = bag.add_connection("/joint_states", JOINT_TYPE, typestore=ROS2)
        image = bag.add_connection("/image", "std_msgs/msg/UInt8MultiArray", typestore=ROS2)
        odd = bag.add_connection("/odd", "my_msgs/msg/Odd", msgdef="float64 x", rihs01="RIHS01_0")
        kinds = ROS2.types
        layout = kinds["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
        large = kinds["std_msgs/msg/UInt8MultiArray"](layout=layout, data=np.zeros(2**24, np.uint8))
        bag.write(image, TIMES_NS[0], ROS2.serialize_cdr(large, "std_msgs/msg/UInt8MultiArray"))
        for ns, state in states(ROS2):
            bag.write(channel, ns, ROS2.serialize_cdr(state, JOINT_TYPE))
            bag.write(odd, ns, b"\x00\x01\x00\x00" + bytes(8))
    assert np.array_equal(ggo.import_base_gait(tmp_path / "bag", joints=JOINTS).gait.frames, frames)


def test_what_is_odd_or_damaged_in_a_ros1_bag(tmp_path, frames):
    """A definition that nobody understands is no matter beside the joints; a message that is none is counted."""
    path = tmp_path / "walk.bag"
    with Writer1(path) as bag:
        channel = bag.add_connection("/joint_states", JOINT_TYPE, typestore=ROS1)
        odd = bag.add_connection("/odd", "my_msgs/msg/Odd", msgdef="no definition", md5sum="0" * 32)
        for number, (ns, state) in enumerate(states(ROS1)):
            data = bytes(ROS1.serialize_ros1(state, JOINT_TYPE))
            bag.write(channel, ns, data[:50] if number == 4 else data)
            bag.write(odd, ns, b"odd")
    report = ggo.import_base_gait(path, joints=JOINTS)
    np.testing.assert_allclose(report.gait.frames, frames, rtol=0.0, atol=1e-6)
    assert report.messages_read == len(TIMES) - 1
    assert len(report.losses) == 1, report.losses
    assert "1 message" in report.losses[0]


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("walk.bag", b"", "the file is empty"),
        ("walk.bag", b"no bag", "rosbags cannot read it: "),
        ("walk.bag", b"#ROSBAG V2.0\n" + bytes(80), "rosbags cannot read it: "),
        ("walk.db3", b"SQLite format 3\0" + bytes(200), "rosbags cannot read it: "),
        ("walk.mcap.zstd", b"", "the file is empty"),
        ("walk.mcap.zstd", b"\x28\xb5\x2f\xfd" + bytes(80), "not a zstd file, or damaged at its start"),
        ("walk.mcap.zstd", b"no zstd", "not a zstd file, or damaged at its start"),
        ("walk.mcap.zst", zstandard.ZstdCompressor().compress(b"a text, no log"), "this is a text file"),
    ],
)
def test_what_is_no_bag(tmp_path, capsys, name, data, words):
    path = tmp_path / name
    path.write_bytes(data)
    assert main(["inspect", str(path)]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"ggo: {path}: {words}")
    assert len(error.splitlines()) == 1
    with pytest.raises(ggo.LogError, match=words):
        ggo.import_base_gait(path, joints=JOINTS)


def test_a_bag_under_another_name_is_told_by_its_first_bytes(tmp_path, frames):
    path = write_ros1(tmp_path / "walk.bag")
    path.rename(tmp_path / "walk.old")
    assert np.array_equal(ggo.import_base_gait(tmp_path / "walk.old", joints=JOINTS).gait.frames, frames)


def test_nothing_larger_than_the_disk_is_unpacked(tmp_path, mcap, monkeypatch):
    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    with pytest.raises(ggo.LogError, match="more than half of the free disk"):
        ggo.import_base_gait(compressed(mcap, tmp_path / "walk.mcap.zstd"), joints=JOINTS)
