"""What has to be chosen before a log can be imported: topic, joints, unit; what is missing is asked for at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.joint_map import UNITS, JointMap, joint_map, listed, read_map, suggestion
from ggo_factors.recording.log.presets import PRESETS
from ggo_factors.recording.log.read_log import by_convention
from ggo_factors.recording.log.topic_streams import Stream
from ggo_factors.recording.log.topics import TopicNeededError
from ggo_factors.recording.sources.columns import require_radians
from ggo_factors.recording.sources.open_log import LogLike, open_log
from ggo_factors.support.files import PathLike

RADIANS = {"rad": 1.0, "deg": np.pi / 180.0}
"""[rad] in each unit."""
_COUNT = {2: "two", 3: "three"}


def chosen_log(
    log: LogLike,
    topic: str | None,
    joints: PathLike | JointMap | None,
    unit: str | None,
    progress: Callable[[float], None] | None = None,
    largest_chunk: int = CHUNK_MIB,
) -> tuple[JointLog, JointMap, str | None]:
    """The log with the values that the joint map needs, the map, and the unit that is still to be told by `unit`.

    Args:
        log: what `open_log` takes.
        topic: topic of the joints, or None.
        joints: a map, its file, or the name of a preset; None is asked for.
        unit: ``"rad"``, ``"deg"`` or None.
        progress: called with the part that was read, 0 to 1.
        largest_chunk: the most of a file that is unpacked as one, in [MiB].

    Raises:
        InputError: where an argument or the joint map is wrong.
        LogError: where the log cannot be read, or a choice is missing: all that are, in one message.
    """
    if unit is not None and unit not in UNITS:
        raise InputError(f"unit: expected 'rad' or 'deg', got {unit!r:.40}")
    # A map in a file is read first, so that its errors come first.
    if joints is not None and not isinstance(joints, JointMap) and str(joints) not in PRESETS:
        joints = read_map(joints)
    names = joints.names if isinstance(joints, JointMap) else None
    told = unit is not None or (isinstance(joints, JointMap) and joints.units is not None)
    try:
        read = open_log(log, topic, names, progress, largest_chunk)
    except TopicNeededError as error:
        if joints is not None and (told or all(map(by_convention, error.streams))):
            raise
        raise LogError(_questions(error.streams, joints is None, told, str(log))) from error
    told = told or read.unit is not None or bool(read.units)
    if joints is None and not told:
        raise LogError(f"{read.source}: two answers are needed: unit='rad' or unit='deg'; joints=: {_joints(read)}")
    if joints is None:
        raise LogError(f"{read.source}: joints= is needed: which value is which joint? {_joints(read)}")
    return _in_stated_unit(read, joint_map(joints, read.names, read.source), unit)


def _questions(streams: Sequence[Stream], joints: bool, told: bool, source: str) -> str:
    """What to ask where several topics may hold the joints, each answer once."""
    topics = listed(list(dict.fromkeys(stream.topic for stream in streams)))
    asked = [f"topic= (one of {topics})"]
    if joints:
        asked.append(f"joints= (a preset, or a map of names such as {listed(streams[0].names[:4])})")
    if not told and not all(map(by_convention, streams)):
        asked.append("unit='rad' or unit='deg'")
    return f"{source}: {_COUNT[len(asked)]} answers are needed: {'; '.join(asked)}; inspect lists what each topic holds"


def _joints(log: JointLog) -> str:
    """Which presets fit, and of two that differ in the sign of the knee the one that fits the values."""
    knees = [n for n, name in enumerate(log.names) if "knee" in name.lower()]
    middle = [float(np.median(x[np.isfinite(x)])) for x in log.values.T[knees] if np.isfinite(x).any()]
    words = suggestion(log.names)
    if middle and " or joints=" in words and (all(m < 0.0 for m in middle) or all(m > 0.0 for m in middle)):
        way = "negative" if middle[0] < 0.0 else "positive"
        words += f" (the knees are {way} in the middle)"
    return words


def _in_stated_unit(log: JointLog, joints: JointMap, unit: str | None) -> tuple[JointLog, JointMap, str | None]:
    """The log in one unit where its source states units, which come before the map's; then map and `unit` are None."""
    units = {name: log.units[name] for name in joints.names if name in log.units}
    if not units:
        return log, joints, unit
    wrong = next((name for name in units if units[name] not in UNITS), None)
    if wrong is not None:
        raise LogError(f"{log.source}: {wrong} is no angle (it is in {units[wrong]!r:.20})")
    notes = list(log.notes)
    stated = " and ".join(sorted(set(units.values())))
    silent = [name for name in joints.names if name not in units]
    other = unit or joints.units or log.unit
    if unit is not None and not silent and unit not in units.values():  # whoever gives it knows that the file is wrong
        notes.append(f"the source states {stated}, unit= says {unit}: taken as {unit}")
        units = dict.fromkeys(units, unit)
    if joints.units is not None and not silent and joints.units not in units.values():
        notes.append(f"the source states {stated}, {joints.origin} {joints.units}: taken as the source states it")
    if silent and other is None:
        raise LogError(f"{log.source}: {listed(silent)} states no unit, {next(iter(units))} does; give unit=")
    units |= dict.fromkeys(silent, str(other))
    values, said = log.values, units[joints.names[0]]
    if len(set(units.values())) > 1:
        values, said = log.values * [RADIANS[units.get(name, "rad")] for name in log.names], "rad"
        notes.append("values in degrees and in radians: all brought to radians")
    log = replace(log, values=values, unit=said, notes=tuple(notes))
    if said == "rad":
        require_radians(log, joints.names)
    return log, replace(joints, units=None), None
