"""Damaged logs: whatever is whole is read, whatever is lost is said, and nothing is wrong."""

from __future__ import annotations

import random
import resource
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
import zstandard
from log_files import START_NS, walk_angles, write_joint_log
from mcap.writer import CompressionType, IndexType

from ggo_factors.errors import LogError
from ggo_factors.recording.log.inspect import inspect_log
from ggo_factors.recording.log.read_log import read_log

COUNT = 900
FORMS = {
    "zstd": {},
    "lz4": {"compression": CompressionType.LZ4},
    "none": {"compression": CompressionType.NONE},
    "no statistics": {"use_statistics": False},
    "not repeated": {"repeat_channels": False, "repeat_schemas": False},
    "bare": {
        "use_statistics": False,
        "repeat_channels": False,
        "repeat_schemas": False,
        "index_types": IndexType.NONE,
        "use_summary_offsets": False,
    },
    "unchunked": {"use_chunking": False, "enable_data_crcs": True},
}


def damaged(data, seed):
    rng = random.Random(seed)
    data = bytearray(data)
    kind = rng.choice(["flip", "flip", "cut", "zeros", "insert", "delete"])
    at = rng.randrange(len(data))
    length = rng.choice([1, 4, 16, 64, 512, 4096])
    if kind == "flip":
        data[at] ^= 1 << rng.randrange(8)
    elif kind == "cut":
        del data[at:]
    elif kind == "zeros":
        data[at : at + length] = bytes(len(data[at : at + length]))
    elif kind == "insert":
        data[at:at] = rng.randbytes(length % 100 + 1)
    else:
        del data[at : at + length % 100 + 1]
    return bytes(data), f"{kind} at {at}, seed {seed}"


def read_or_message(path):
    try:
        return read_log(path), ""
    except LogError as error:
        return None, str(error)


def test_damage_that_took_nothing_is_no_loss(tmp_path):
    path = write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT))
    data = bytearray(path.read_bytes())
    data[data.index(b"zstd") + 100] ^= 1  # takes the first chunk's messages
    second = data.index(b"zstd", data.index(b"zstd") + 1000)
    behind = second + 4 + 8 + int.from_bytes(data[second + 4 : second + 12], "little")
    data[behind:behind] = bytes(40)  # takes nothing
    path.write_bytes(data)
    log = read_log(path)
    assert [str(loss).partition(" ")[0] for loss in log.losses] == [str(COUNT - len(log.times))]
    assert any(f"no record can be read at byte {behind}; no message was lost" in note for note in log.notes)


SEEDS = pytest.mark.parametrize("seeds", [45, pytest.param(500, marks=pytest.mark.campaign)])


@SEEDS
@pytest.mark.parametrize("form", FORMS)
def test_no_wrong_value_and_no_silent_loss(tmp_path, form, seeds):
    values = walk_angles(COUNT)
    path = write_joint_log(tmp_path / "whole.mcap", values, **FORMS[form])
    whole = path.read_bytes()
    row_of = {row.tobytes(): i for i, row in enumerate(values)}
    broken = tmp_path / "broken.mcap"
    read = 0
    for seed in range(seeds):
        data, what = damaged(whole, seed)
        broken.write_bytes(data)
        log, message = read_or_message(broken)
        if log is None:
            assert message.startswith(str(broken)), what
            assert len(message.splitlines()) == 1, what
            continue
        read += 1
        rows = [row_of.get(row.tobytes(), -1) for row in log.values]
        assert min(rows) >= 0, what
        assert np.allclose(log.times, 0.01 * (np.array(rows) - rows[0]), rtol=0, atol=1e-9), what
        if len(rows) < COUNT:
            assert log.losses, what
            counts = [loss.count for loss in log.losses]
            assert None in counts or sum(counts) == COUNT - len(rows), what
        for loss in log.losses:
            assert "\n" not in str(loss)
    assert read > (0.1 if form == "unchunked" else 0.65) * seeds


@SEEDS
def test_without_checksums_no_exception_and_it_is_said(tmp_path, seeds):
    path = write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT), enable_crcs=False, compression=CompressionType.NONE)
    whole = path.read_bytes()
    for seed in range(seeds):
        path.write_bytes(damaged(whole, seed)[0])
        try:
            log = read_log(path, names=["hip_l", "knee_r"])
        except LogError:
            continue
        assert any("no checksums" in note for note in log.notes)
        assert np.all(np.diff(log.times) > 0)
        if log.messages_expected:
            lost = log.messages_expected - log.messages_read
            assert lost <= 0 or log.losses


def chunk_file(path, compression, size, data, crc=0):
    name = compression.encode()
    body = struct.pack("<QQQII", 0, 1, size, crc, len(name)) + name + struct.pack("<Q", len(data)) + data
    magic = b"\x89MCAP0\r\n"
    header = b"\x01" + struct.pack("<Q", 8) + bytes(8)
    end = b"\x0f" + struct.pack("<QI", 4, 0) + b"\x02" + struct.pack("<QQQI", 20, 0, 0, 0)
    path.write_bytes(magic + header + b"\x06" + struct.pack("<Q", len(body)) + body + end + magic)
    return path


@pytest.mark.parametrize("claim", [512, 60, 20])
def test_a_bomb_is_refused_and_stays_small(tmp_path, claim):
    zeros = zstandard.ZstdCompressor().compress(bytes(claim * 2**20))
    path = chunk_file(tmp_path / "bomb.mcap", "zstd", claim * 2**20, zeros)
    code = (
        "import resource, sys, mcap.records, mcap.data_stream, zstandard, scipy\n"
        "from ggo_factors.errors import LogError\nfrom ggo_factors.recording.log.read_log import read_log\n"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "before = peak()\n"
        "try:\n    read_log(sys.argv[1])\nexcept LogError as error:\n"
        "    print(peak() - before, error)\n"
    )
    out = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True).stdout
    grown, message = out.split(" ", 1)
    per_mb = 1024 if sys.platform == "linux" else 2**20
    assert float(grown) / per_mb < 40
    assert "MiB" in message


def test_a_bomb_of_whole_records_is_refused(tmp_path):
    record = b"\x05" + struct.pack("<QHIQQ", 1000, 1, 0, 0, 0) + bytes(978)
    data = zstandard.ZstdCompressor().compress(record * 60_000)
    with pytest.raises(LogError, match="no log compresses like that"):
        read_log(chunk_file(tmp_path / "a.mcap", "zstd", len(record) * 60_000, data))


def test_claims_are_checked_before_memory_is_given(tmp_path):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    frame = zstandard.ZstdCompressor().compress(bytes(100))
    for compression, size, data in (
        ("", 2**31, bytes(100)),
        ("zstd", 2**31, frame),
        ("zstd", 5000, frame),
        ("lz4", 2**20, bytes(100)),
        ("brotli", 100, bytes(100)),
        ("", 10, bytes(10)),
    ):
        with pytest.raises(LogError, match="nothing can be read"):
            read_log(chunk_file(tmp_path / "a.mcap", compression, size, data))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 40 * 1024 * (
        1 if sys.platform == "linux" else 1024
    )


def test_a_chunk_with_a_wrong_checksum_is_named_with_its_place(tmp_path):
    path = write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT), compression=CompressionType.NONE)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 4
    path.write_bytes(data)
    log = read_log(path)
    (loss,) = log.losses
    assert loss.count == COUNT - len(log.times) == log.messages_expected - log.messages_read
    assert loss.where < len(data) // 2
    assert log.times[0] < loss.from_s < loss.to_s < log.times[-1]
    gap = int(np.argmax(np.diff(log.times)))
    assert (loss.from_s, loss.to_s) == pytest.approx((log.times[gap], log.times[gap + 1]))
    assert f"{loss.count} messages lost between" in str(loss)
    assert "CRC" in str(loss)
    assert inspect_log(path).damaged


@pytest.mark.parametrize(
    ("start", "why"),
    [
        (b"", "empty"),
        (b"\x89MCAP0\r\n", "nothing after"),
        (b"SQLite format 3\x00" + bytes(90), "ros2 bag convert"),
        (b"#ROSBAG V2.0\n", "ROS 1 bag"),
        (b"\x1f\x8b\x08\x00" + bytes(30), "gunzip"),
        (zstandard.ZstdCompressor().compress(b"\x89MCAP0\r\n"), "zstd -d"),
        (b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        (b"time,left_hip,left_knee\n0.0,1.0,2.0\n", "text file"),
        (b"\x00MCAP0\r\n" + bytes(90), "magic"),
        (bytes(100), "not an MCAP file"),
    ],
)
def test_what_is_no_mcap_is_named(tmp_path, start, why):
    path = tmp_path / "a.mcap"
    path.write_bytes(start)
    for read in (read_log, inspect_log):
        with pytest.raises(LogError, match=why):
            read(path)


def test_an_end_that_is_not_as_it_should_be_costs_nothing(tmp_path):
    path = write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT))
    whole = path.read_bytes()
    for data in (whole[:-1], whole[:-8] + bytes(8), whole + bytes(100)):
        path.write_bytes(data)
        log = read_log(path)
        assert len(log.times) == COUNT
        assert not log.losses
        assert any("magic" in note for note in log.notes)


def test_two_whole_files_after_each_other_are_two_logs_and_damage_in_one_is_not_silent(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    values = walk_angles(COUNT)
    times = START_NS + 10**7 * np.arange(COUNT)
    for number, part in enumerate((slice(0, 400), slice(400, COUNT))):
        write_joint_log(bag / f"bag_{number}.mcap", values[part], times_ns=times[part])
    (bag / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.mcap\n    - bag_1.mcap\n  version: 5\n"
    )
    log = read_log(bag)
    assert np.array_equal(log.values, values)
    assert not log.losses
    (bag / "bag_1.mcap").unlink()
    log = read_log(bag)
    assert len(log.times) == 400
    assert "bag_1.mcap" in str(log.losses[0])


def test_a_crc_is_checked_not_only_present(tmp_path):
    record = b"\x05" + struct.pack("<QHIQQ", 22, 1, 0, 0, 0)
    with pytest.raises(LogError, match="CRC"):
        read_log(chunk_file(tmp_path / "a.mcap", "", len(record), record, zlib.crc32(record) ^ 1))
