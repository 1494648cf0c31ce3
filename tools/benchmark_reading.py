"""The benchmark of reading: a long log, ours beside what mcap's own packages take."""

from __future__ import annotations

import json
import multiprocessing
import platform
import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import click
import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory
from rich.table import Table

from ggo_factors.cli.console import console
from ggo_factors.recording.export.ros2_log import encode, header, schema_text
from ggo_factors.recording.log.read_log import read_log
from ggo_factors.support.files import write_text

TOPIC = "/joint_states"
JOINTS = tuple(f"{side}_{joint}_joint" for side in ("left", "right") for joint in ("hip", "knee", "ankle"))


@click.command()
@click.option("--minutes", type=float, default=10.0, show_default=True, help="Length of the log.")
@click.option(
    "--repeats", type=int, default=3, show_default=True, help="Interleaved repeats after one warm-up of ours."
)
@click.option("--json", "json_path", type=click.Path(), help="Write the numbers here too.")
def reading(minutes: float, repeats: int, json_path: str | None) -> None:
    """Read a JointState log of 6 joints at 1 kHz: ours against mcap's reader with mcap-ros2-support."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "walk.mcap"
        count = _write_log(path, minutes)
        size = path.stat().st_size / 1e6
        readers: dict[str, Callable[[Path], int]] = {"ggo_factors": _ours, "mcap + mcap-ros2-support": _official}
        _measured(_ours, path)
        runs: dict[str, list[tuple[float, float]]] = {name: [] for name in readers}
        for _ in range(repeats):
            for name, reader in readers.items():
                runs[name].append(_measured(reader, path))
    table = Table(title=f"{count} messages, {size:.0f} MB, {platform.platform()}, Python {platform.python_version()}")
    for heading in ("reader", "median s", "k messages/s", "peak MB above imports", "ratio"):
        table.add_column(heading, justify="left" if heading == "reader" else "right")
    medians = {name: statistics.median(seconds for seconds, _ in each) for name, each in runs.items()}
    rows = []
    for name, each in runs.items():
        row = {
            "reader": name,
            "median_s": medians[name],
            "messages_per_s": count / medians[name],
            "peak_mb": statistics.median(grown for _, grown in each),
            "ratio": medians[name] / medians["ggo_factors"],
        }
        rows.append(row)
        table.add_row(
            name,
            f"{row['median_s']:.2f}",
            f"{count / medians[name] / 1e3:.0f}",
            f"{row['peak_mb']:.0f}",
            f"{row['ratio']:.1f}",
        )
    console().print(table)
    if json_path:
        write_text(json_path, json.dumps({"format_version": 1, "messages": count, "rows": rows}, indent=1) + "\n")


def _write_log(path: Path, minutes: float) -> int:
    """A log at 1 kHz; each message is the first one with other numbers put in, as encoding all would take minutes."""
    count = int(minutes * 60_000)
    time_s = np.arange(count)[:, None] * 1e-3
    angles = 0.3 + 0.4 * np.sin(2.0 * np.pi * time_s / 1.1 + np.arange(len(JOINTS)))
    marks = [float(n) * 1.25 + 1e6 for n in range(3 * len(JOINTS))]
    fields = {"position": marks[:6], "velocity": marks[6:12], "effort": marks[12:]}
    message = bytearray(encode("sensor_msgs/JointState", {"header": header(0), "name": list(JOINTS), **fields}))
    places = [bytes(message).index(np.float64(mark).tobytes()) for mark in (marks[0], marks[6], marks[12])]
    width = 8 * len(JOINTS)
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=2**20, compression=CompressionType.ZSTD)
        writer.start("ros2", "benchmark")
        definition = schema_text("sensor_msgs/JointState").encode()
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", definition)
        channel = writer.register_channel(TOPIC, "cdr", schema)
        for number, row in enumerate(angles):
            stamp = number * 10**6
            message[4:12] = np.array([stamp // 10**9, stamp % 10**9], "<u4").tobytes()
            for place in places:
                message[place : place + width] = row.tobytes()
            writer.add_message(channel, stamp, bytes(message), stamp)
        writer.finish()  # type: ignore[no-untyped-call]
    return count


def _ours(path: Path) -> int:
    return len(read_log(path).times)


def _official(path: Path) -> int:
    positions = []
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=[TOPIC]):
            positions.append(message.position)
    return len(np.array(positions))


def _measured(reader: Callable[[Path], int], path: Path) -> tuple[float, float]:
    """Seconds and growth of peak memory in [MB], in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_timed, (reader, path))


def _timed(reader: Callable[[Path], int], path: Path) -> tuple[float, float]:
    per_mb = 1e3 if sys.platform == "linux" else 1e6
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    reader(path)
    spent = time.perf_counter() - start
    return spent, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / per_mb
