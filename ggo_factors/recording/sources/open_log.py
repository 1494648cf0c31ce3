"""The seam: whatever holds joint values over time, as one `JointLog`."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_log import COLUMNS, JointLog, from_start
from ggo_factors.recording.log.joint_map import UNITS
from ggo_factors.recording.log.read_log import read_log
from ggo_factors.recording.sources.bags import as_mcap, bag_kind
from ggo_factors.recording.sources.c3d_log import read_c3d
from ggo_factors.recording.sources.columns import unit_in
from ggo_factors.recording.sources.csv_log import read_csv
from ggo_factors.recording.sources.objects import is_frame, log_of_frame, log_of_mapping
from ggo_factors.recording.sources.opensim import read_opensim
from ggo_factors.support.files import PathLike

LogLike = Any
"""What can be imported: a path, a `JointLog`, a mapping of names to arrays, a data frame."""

READERS: Mapping[str, Callable[[PathLike], JointLog]] = {
    ".csv": read_csv,
    ".tsv": read_csv,
    ".txt": read_csv,
    ".mot": read_opensim,
    ".sto": read_opensim,
    ".c3d": read_c3d,
}
"""Readers of files that are tables, by ending; any other path is taken for an MCAP log or a bag."""

Progress = Callable[[float], None] | None


def open_log(
    log: LogLike,
    topic: str | None = None,
    names: Sequence[str] | None = None,
    progress: Progress = None,
    largest_chunk: int = CHUNK_MIB,
) -> JointLog:
    """Read joint values from whatever holds them; times count from the first one.

    Args:
        log: a path (MCAP, rosbag2 folder, ROS 1 bag, `.mot`, `.sto`, `.csv`, `.c3d`), a `JointLog`, a mapping of
            names to arrays of shape (n,), or a data frame.
        topic: the topic to read, where the log has topics.
        names: the logged values wanted, where it has topics; None: all of the topic that looks like joints.
        progress: called with the part that was read, 0 to 1.
        largest_chunk: the most of a file that is unpacked as one, in [MiB].

    Raises:
        InputError: where an argument is of no use.
        LogError: where the log cannot be read, or does not hold what is wanted.
    """
    if (table := table_of(log)) is not None:
        if topic is not None and topic != table.topic:
            which = "columns and no topics: leave topic= out" if table.topic == COLUMNS else f"topic= is {table.topic}"
            raise LogError(f"{table.source}: it has {which} (topic={topic!r:.60})")
        return table
    with plain_mcap(log, progress) as (path, rest):
        read = read_log(path, topic=topic, names=names, progress=rest, largest_chunk=largest_chunk)
    if read.unit is None:  # no convention: a name may say it
        named = {name: unit for name in read.names if (unit := unit_in(name)) in UNITS and unit is not None}
        read = replace(read, units=named)
    return read if path == log else replace(read, source=str(log))


def table_of(log: LogLike) -> JointLog | None:
    """The log of a table in a file or in memory; None where `log` is a path of something with topics.

    Raises:
        InputError: where `log` is nothing that holds joint values.
        LogError: where the table cannot be read.
    """
    if isinstance(log, JointLog):
        return replace(log, times=from_start(log.times))
    if isinstance(log, Mapping):
        return log_of_mapping(log)
    if is_frame(log):
        return log_of_frame(log)
    if not isinstance(log, (str, os.PathLike)):
        kind = type(log).__name__
        raise InputError(
            f"log: expected a path, a JointLog, a mapping of names to arrays or a data frame, got a {kind}"
        )
    reader = READERS.get(Path(log).suffix.lower())
    if reader is None or Path(log).is_dir():
        return None
    try:
        return reader(log)
    except MemoryError as error:
        raise LogError(f"{log}: does not fit into memory") from error


@contextmanager
def plain_mcap(log: LogLike, progress: Progress) -> Iterator[tuple[PathLike, Progress]]:
    """A log's path as one of MCAP, and who is told of the progress of reading it; errors name the log itself.

    Raises:
        LogError: where it cannot be made MCAP.
    """
    kind = bag_kind(log)
    if not kind:
        yield log, progress
        return

    def half(before: float) -> Progress:
        return None if progress is None else lambda part: progress(0.5 * (before + part))

    with as_mcap(log, kind, half(0.0)) as path:
        try:
            yield path, half(1.0)
        except LogError as error:
            error.args = (str(error).replace(str(path), str(log)),)
            raise
