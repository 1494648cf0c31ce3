"""The bulk path on a longer log: values and memory. How fast it is, `tools/benchmark.py` says."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, joint_state, walk_angles, write_messages

from ggo_factors.recording.log.read_log import read_log

COUNT = 40_000
NAMES = tuple(f"{side}_{joint}_joint" for side in ("left", "right") for joint in ("hip", "knee", "ankle"))


def write(path, count):
    values = walk_angles(count)
    values = np.hstack([values, 1.0 - values[:, :2]])
    first = bytearray(joint_state(0, NAMES, values[0], values[0]))
    at = [i for i in range(len(first) - 8) if bytes(first[i : i + 8]) == values[0, :1].tobytes()]
    messages = []
    for i, row in enumerate(values):  # patched, for the encoder is slow
        ns = START_NS + i * 10**6
        first[4:12] = np.array([ns // 10**9, ns % 10**9], "<u4").tobytes()
        for start in at:
            first[start : start + 48] = row.tobytes()
        messages.append(("/joint_states", ns, ns, bytes(first)))
    write_messages(path, {"/joint_states": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages, chunk_size=2**20)
    return values


def test_the_bulk_path_gives_what_was_written(tmp_path):
    values = write(tmp_path / "a.mcap", COUNT)
    assert np.array_equal(read_log(tmp_path / "a.mcap").values, values)


def test_memory_stays_near_what_is_returned(tmp_path):
    path = tmp_path / "a.mcap"
    write(path, COUNT)
    code = (
        "import resource, sys, mcap.records, mcap.data_stream, zstandard, lz4.frame\n"
        "from ggo_factors.recording.log.read_log import read_log\n"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "before = peak()\nread_log(sys.argv[1])\nprint(peak() - before)\n"
    )
    out = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True).stdout
    assert int(out) < 45 * (1024 if sys.platform == "linux" else 2**20)
