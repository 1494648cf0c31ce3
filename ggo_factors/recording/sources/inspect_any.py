"""What any source of joint values holds, at a glance."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from ggo_factors.recording.log import inspect
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.inspect import LogSummary, summary_of
from ggo_factors.recording.sources.open_log import LogLike, plain_mcap, table_of
from ggo_factors.support.inputs import as_progress


def inspect_log(
    log: LogLike, progress: Callable[[float], None] | None = None, *, largest_chunk: int = CHUNK_MIB
) -> LogSummary:
    """Say what a recording holds.

    Args:
        log: what `import_base_gait` takes: a path, a `JointLog`, a mapping of names to arrays, or a data frame.
        progress: called with the part that was read, 0 to 1.
        largest_chunk: the most of a file that is unpacked as one, in [MiB].

    Raises:
        InputError: where `log` is nothing that holds joint values.
        LogError: where nothing in it can be read.
    """
    progress = as_progress(progress)
    if (table := table_of(log)) is not None:
        return summary_of(table, Path(log).stat().st_size if isinstance(log, (str, os.PathLike)) else 0)
    with plain_mcap(log, progress) as (path, rest):
        summary = inspect.inspect_log(path, rest, largest_chunk=largest_chunk)
    if path == log:
        return summary
    return replace(summary, source=str(log), size_bytes=_size(Path(log)))


def _size(path: Path) -> int:
    files = path.iterdir() if path.is_dir() else (path,)
    return sum(file.stat().st_size for file in files if file.is_file())
