"""One log of joint values, read from an MCAP file."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.errors import LogError
from ggo_factors.files import PathLike


@dataclass(frozen=True)
class Loss:
    """What a recording holds no more, or held in a form that cannot be used.

    Attributes:
        what: what was lost and why, in words.
        count: number of messages (or values) lost, or None where nothing in the file tells.
        from_s: time of the last sample before the loss in [s] from the first sample, or None.
        to_s: time of the first sample after it in [s], or None.
        where: byte of the file at which the damage begins, or None.
    """

    what: str
    count: int | None = None
    from_s: float | None = None
    to_s: float | None = None
    where: int | None = None

    def __str__(self) -> str:
        return self.what


@dataclass(frozen=True, eq=False)
class JointLog:
    """Logged joint values over time.

    Attributes:
        source: the path as it was given.
        topic: topic, or topics separated by commas.
        message_type: type of the messages, for example ``"sensor_msgs/msg/JointState"``.
        encoding: their encoding, for example ``"cdr"``.
        names: what was logged, as it stands in the log: a name, a path ``left.hip``, ``data[3]``, ``/left_hip:data``.
        times: times in [s] from the first sample, strictly increasing, shape (n,).
        values: values as they were logged (NaN where missing), shape (n, len(names)).
        time_source: field or clock that the times come from.
        unit: ``"rad"`` where the ROS convention says so, else None (not known).
        messages_read: messages of the topic that were read.
        messages_expected: messages of the topic by the file's own statistics, or None where it has none.
        losses: what was lost, each with its place.
        notes: decisions that were taken, in words.
        segments: index ranges [a, b) between which time may not be bridged; one range when all is well.
    """

    source: str
    topic: str
    message_type: str
    encoding: str
    names: tuple[str, ...]
    times: Array
    values: Array
    time_source: str
    unit: str | None
    messages_read: int
    messages_expected: int | None
    losses: tuple[Loss, ...]
    notes: tuple[str, ...]
    segments: tuple[tuple[int, int], ...]


def read_log(
    path: PathLike,
    topic: str | None = None,
    names: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> JointLog:
    """Read joint values from a recording (first version: healthy ROS 2 JointState and JSON logs)."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    rows: list[tuple[float, dict[str, float]]] = []
    source = "header.stamp"
    with open(path, "rb") as file:
        factory = DecoderFactory()
        chosen: Any = None
        for schema, channel, message in make_reader(file).iter_messages():
            is_json = channel.message_encoding == "json"
            if not is_json and (schema is None or "JointState" not in schema.name):
                continue
            if topic not in (None, channel.topic):
                continue
            chosen = chosen or (channel, schema)
            if is_json:
                tree = json.loads(message.data)
                stamp, source = message.log_time * 1e-9, "log_time"
                for key in ("t", "time"):
                    if key in tree:
                        stamp, source = float(tree.pop(key)), key
                values = _flat(tree)
            else:
                decoder: Any = factory.decoder_for(channel.message_encoding, schema)
                decoded = decoder(message.data)
                stamp = decoded.header.stamp.sec + decoded.header.stamp.nanosec * 1e-9
                values = dict(zip(decoded.name, decoded.position, strict=True))
            rows.append((stamp, values))
    if not rows:
        raise LogError(f"{path}: no topic with joints")
    columns = tuple(names) if names is not None else tuple(dict.fromkeys(n for _, v in rows for n in v))
    rows.sort(key=lambda row: row[0])
    times = np.array([t - rows[0][0] for t, _ in rows])
    table = np.array([[v.get(n, np.nan) for n in columns] for _, v in rows], dtype=float)
    keep = np.append(True, np.diff(times) > 0)
    times, table = times[keep], table[keep]
    channel, schema = chosen
    is_json = channel.message_encoding == "json"
    return JointLog(
        str(path), channel.topic, schema.name if schema else "", channel.message_encoding, columns, times, table,
        source, None if is_json else "rad", len(rows), len(rows), (), (), ((0, len(times)),),
    )  # fmt: skip


def _flat(tree: dict[str, Any], prefix: str = "") -> dict[str, float]:
    out: dict[str, float] = {}
    for key, value in tree.items():
        if isinstance(value, dict):
            out |= _flat(value, f"{prefix}{key}.")
        elif isinstance(value, (int, float)):
            out[prefix + key] = float(value)
    return out
