"""Bytes that a strict reader stumbles on: behind a message, packed by themselves, in chunks of any size."""

from __future__ import annotations

import gzip

import lz4.frame
import numpy as np
import pytest
import zstandard
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, float64, joint_state, write_messages
from mcap.writer import CompressionType
from test_import_refusals import NAMES, log_of, walk

import ggo_factors as ggo
from ggo_factors.cli import main

STATE = {"/joint_states": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}
ANGLES = walk(700)
TIMES = [START_NS + n * 10**7 for n in range(len(ANGLES))]


def states(change=lambda data: data):
    """Messages of a walk, each changed."""
    return [
        ("/joint_states", at, at, change(joint_state(at, NAMES, row)))
        for at, row in zip(TIMES, ANGLES.tolist(), strict=True)
    ]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return ggo.import_base_gait(log_of(tmp_path_factory.mktemp("log") / "a.mcap", ANGLES), joints="direct")


@pytest.mark.parametrize("tail", [bytes(8), bytes(1000), b"\xa7" * 12, bytes(range(100, 164))])
def test_bytes_behind_a_message(tmp_path, tail, whole):
    path = write_messages(tmp_path / "a.mcap", STATE, states(lambda data: data + tail))
    report = ggo.import_base_gait(path, joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)
    (note,) = (note for note in report.notes if "behind what their schema says" in note)
    assert f"700 messages of /joint_states go on for {len(tail)} bytes" in note
    assert not report.losses


def test_bytes_behind_some_messages_in_any_number(tmp_path, whole):
    rng = np.random.default_rng(0)
    path = write_messages(tmp_path / "a.mcap", STATE, states(lambda data: data + bytes(int(rng.integers(0, 40)))))
    report = ggo.import_base_gait(path, joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)
    assert any("go on for 8 to 39 bytes" in note for note in report.notes)


@pytest.mark.parametrize(("tail", "read"), [(bytes(16), True), (b"\x01" * 16, False)])
def test_numbers_without_names_may_be_followed_by_zeros_only(tmp_path, tail, read):
    kinds = {"/left_hip": ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr")}
    messages = [("/left_hip", at, at, float64(row[0]) + tail) for at, row in zip(TIMES, ANGLES, strict=True)]
    path = write_messages(tmp_path / "a.mcap", kinds, messages)
    (topic,) = ggo.inspect_log(path).topics
    assert ("16 bytes too many" in topic.problem) is not read


@pytest.mark.parametrize(
    ("pack", "what"),
    [(zstandard.ZstdCompressor().compress, "zstd"), (lz4.frame.compress, "lz4"), (gzip.compress, "gzip")],
)
@pytest.mark.parametrize("schema", ["ros2msg", "json"])
def test_messages_compressed_by_themselves(tmp_path, pack, what, schema):
    kinds = STATE if schema == "ros2msg" else {"/joint_states": ("", "", "", "json")}
    path = write_messages(tmp_path / "a.mcap", kinds, states(pack))
    for call in (ggo.import_base_gait, lambda path, joints: ggo.import_base_gait(path, "/joint_states", joints)):
        with pytest.raises(ggo.LogError) as error:
            call(path, joints="direct")
        assert f"each message is compressed by itself with {what}" in str(error.value)
        assert "ggo-factors[rosbags]" in str(error.value)
        assert "CDR" not in str(error.value)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_a_giant_chunk_is_read_where_it_is_asked_for(tmp_path, compression, whole, capsys):
    kinds = STATE | {"/camera": ("", "", "", "json")}
    # Half a picture compresses, as pictures do; the other half is zeros.
    picture = np.random.default_rng(0).bytes(2**20) + bytes(66 * 2**20)
    messages = states()
    messages.insert(300, ("/camera", TIMES[300], TIMES[300], picture))
    path = write_messages(tmp_path / "a.mcap", kinds, messages, chunk_size=2**30, compression=compression)
    assert main(["import", str(path), "--joints", "direct", "--topic", "/joint_states"]) == 2
    said = capsys.readouterr().err
    assert "68 MiB unpacked (limit 64 MiB; --largest-chunk 68)" in said
    report = ggo.import_base_gait(path, joints="direct", largest_chunk=68)
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)
    assert main(["import", str(path), "--joints", "direct", "--largest-chunk", "68"]) == 0
    assert "/camera" in {topic.topic for topic in ggo.inspect_log(path, largest_chunk=68).topics}


def test_the_limit_of_a_chunk_is_a_positive_number(tmp_path):
    with pytest.raises(ggo.InputError, match="largest_chunk: 0 must be at least 1"):
        ggo.import_base_gait(tmp_path / "a.mcap", joints="direct", largest_chunk=0)
