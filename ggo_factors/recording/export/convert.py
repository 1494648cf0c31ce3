"""Any recording of joint values as a clean MCAP log: one topic, each name once, radians, times that rise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.export.ros2_log import header, ros2_log
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_log import NANOSECONDS, JointLog
from ggo_factors.recording.log.joint_map import UNITS, listed
from ggo_factors.recording.sources.choices import RADIANS
from ggo_factors.recording.sources.columns import require_radians
from ggo_factors.recording.sources.open_log import LogLike, open_log
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_progress

TOPIC = "/joint_states"
"""Topic of what is written."""
PAUSE_S = 2.0
"""Put where the clock of the recording stepped, in [s]: nobody may bridge the time between, and any reader sees it."""


def convert_log(
    log: LogLike,
    path: PathLike,
    *,
    topic: str | None = None,
    unit: str | None = None,
    progress: Callable[[float], None] | None = None,
    largest_chunk: int = CHUNK_MIB,
) -> JointLog:
    """Write the joint values of any recording as `sensor_msgs/JointState` in an MCAP file, whole or not at all.

    Names stay as the source has them, so a joint map fits both. Angles are written in [rad], lengths that the source
    states in [m] as they are; values in other units are left out. The log begins at time 0.

    Args:
        log: what `import_base_gait` takes: a path, a `JointLog`, a mapping of names to arrays, or a data frame.
        path: the file to write.
        topic: topic of the joints, where there are topics; found by itself where only one can be meant.
        unit: ``"rad"`` or ``"deg"``, where the source does not say it.
        progress: called with the part of the file that has been read, 0 to 1.
        largest_chunk: the most of the file that is unpacked as one, in [MiB].

    Returns:
        What was written.

    Raises:
        InputError: where an argument is of no use or the file cannot be written.
        LogError: where the recording cannot be read, or needs a choice (topic, unit).
    """
    progress = as_progress(progress)
    if unit is not None and unit not in UNITS:
        raise InputError(f"unit: expected 'rad' or 'deg', got {unit!r:.40}")
    read = _in_radians(open_log(log, topic, None, progress, largest_chunk), unit)
    times = np.rint(_with_pauses(read) * NANOSECONDS).astype(np.int64)
    with ros2_log(path) as file:
        file.add_topic(TOPIC, "sensor_msgs/JointState")
        notes = {f"note_{number}": note for number, note in enumerate(read.notes, start=1)}
        file.add_metadata("recording", {"source": read.source, "time_source": read.time_source, **notes})
        for time, row in zip(times.tolist(), read.values.tolist(), strict=True):
            state = {"name": read.names, "position": row, "velocity": [], "effort": []}
            file.write(TOPIC, time, {"header": header(time), **state})
    return read


def _in_radians(log: JointLog, unit: str | None) -> JointLog:
    """The angles of a log in [rad], its lengths in [m], without its values in other units."""
    units = {name: log.units.get(name) or unit or log.unit for name in log.names}
    silent = [name for name in log.names if units[name] is None]
    if silent:
        raise LogError(f"{log.source}: the unit of {listed(silent)} is not known; give unit='rad' or unit='deg'")
    kept = [name for name in log.names if units[name] in ("rad", "deg", "m")]
    if not kept:
        raise LogError(f"{log.source}: no angle among {listed(log.names)}")
    left = [name for name in log.names if name not in kept]
    columns = [log.names.index(name) for name in kept]
    values = log.values[:, columns] * [RADIANS.get(str(units[name]), 1.0) for name in kept]
    made = JointLog(
        times=log.times,
        values=values,
        names=tuple(kept),
        unit="rad",
        source=log.source,
        time_source=log.time_source,
        losses=log.losses,
        notes=(*log.notes, *([f"{listed(left)}: neither angles nor lengths, left out"] if left else ())),
        segments=log.segments,
    )
    # Not what is radians by the convention of its messages only: a wheel beside the legs turns and turns.
    require_radians(made, [name for name in kept if (log.units.get(name) or unit) == "rad"])
    return made


def _with_pauses(log: JointLog) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The times of a log in [s], a pause before each stretch but the first."""
    times = np.array(log.times)
    for first, _ in log.segments[1:]:
        times[first:] += PAUSE_S
    return times
