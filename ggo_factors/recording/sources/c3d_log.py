"""Joint angles from a C3D file as Vicon's Plug-in Gait writes them: flexion is the first component, in degrees."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.sources.columns import Columns, log_of_columns, named_unit
from ggo_factors.recording.sources.extras import needed, require_content
from ggo_factors.support.files import PathLike

ENDING = "angles"
"""Labels of joint angles end so, in any case: ``LHipAngles``."""

_BLOCK = 512
"""Bytes of a block: the header is one, and places are counted in them from 1."""
_KEY = 0x50
"""Second byte of every C3D file."""
_DEC, _BIG_ENDIAN = 85, 86
"""Kinds of processor, in the parameters: one with floats of its own, one whose numbers have their high byte first."""
_MANY = 65535
"""Number of the last frame where there are more than the header can count."""


def read_c3d(path: PathLike) -> JointLog:
    """Read the flexion angles of a C3D file; a frame whose angles are all exactly zero was not measured.

    Raises:
        LogError: where ezc3d is not installed or cannot read the file, or it holds no angles.
    """
    ezc3d = needed("ezc3d", "c3d", path, "a C3D file")
    require_content(path)
    _require_whole(Path(path))
    try:
        content = ezc3d.c3d(str(path))
    except Exception as error:  # whatever a damaged file makes of a C++ parser
        raise LogError(f"{path}: ezc3d cannot read it: {(str(error) or repr(error)).splitlines()[0]:.160}") from error
    points = np.asarray(content["data"]["points"], dtype=np.float64)
    parameters = content["parameters"]["POINT"]
    rate = float(_value(parameters, "RATE", [0.0])[0])
    if not rate > 0.0:
        raise LogError(f"{path}: its rate is {rate:g} Hz")
    labels = list(_labels(parameters))
    angles = [(number, label) for number, label in enumerate(labels) if label.lower().endswith(ENDING)]
    if not angles:
        raise LogError(
            f"{path}: no joint angles (LHipAngles, LKneeAngles, ...) among {listed(labels)}: run the model, "
            f"such as Plug-in Gait, and export its angles"
        )
    values = {name: _flexion(points[:3, number]) for name, number in _named(angles, path).items()}
    unit = named_unit(str(_value(parameters, "ANGLE_UNITS", ["deg"])[0]) or "deg")
    times = np.arange(points.shape[2]) / rate
    return log_of_columns(
        Columns(str(path), "c3d", values, dict.fromkeys(values, unit), _frame, times, f"rate {rate:.6g} Hz")
    )


def _require_whole(path: Path) -> None:
    """Refuse a file that is shorter than its header states: ezc3d reads on in nothing, for minutes or without a word.

    Raises:
        LogError: where it is, or where it is no C3D file.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_BLOCK)
        if len(head) < 2 or head[1] != _KEY:
            raise LogError(f"{path}: not a C3D file (its second byte is not 50 hex)")
        file.seek(_BLOCK * (head[0] - 1) + 3 if head[0] else 0)
        kind = file.read(1)
    if len(head) < _BLOCK or not kind:
        raise LogError(f"{path}: {size} bytes, its header or its parameters are cut")
    order = ">" if kind[0] == _BIG_ENDIAN else "<"
    points, analog, first, last = struct.unpack_from(f"{order}4H", head, 2)
    (block,) = struct.unpack_from(f"{order}H", head, 16)
    # A negative scale says that numbers are of 4 bytes, not 2; its sign is where this processor has it.
    sign = head[{_BIG_ENDIAN: 12, _DEC: 13}.get(kind[0], 15)]
    frame = (4 * points + analog) * (4 if sign & 0x80 else 2)
    frames = last - first + 1
    there = (size - _BLOCK * (block - 1)) // frame if frame else frames
    if last != _MANY and there < frames:
        raise LogError(f"{path}: {max(there, 0)} of the {frames} frames that its header states: the file is cut")


def _frame(number: int) -> str:
    return f"frame {number + 1}"


def _value(parameters: Mapping[str, Any], key: str, default: list[Any]) -> list[Any]:
    value = parameters.get(key, {}).get("value")
    return default if value is None or not len(value) else list(value)


def _labels(parameters: Mapping[str, Any]) -> Iterator[str]:
    """All labels: a parameter holds 255, more go on in LABELS2, LABELS3."""
    for key in ("LABELS", *(f"LABELS{number}" for number in range(2, 100))):
        if key not in parameters:
            return
        yield from (str(label).strip() for label in _value(parameters, key, []))


def _named(angles: list[tuple[int, str]], path: PathLike) -> dict[str, int]:
    """Places by name; the prefix of the only subject (``Anna:LHipAngles``) is left out."""
    subjects = {label.rpartition(":")[0] for _, label in angles}
    names = [label.rpartition(":")[2] if len(subjects) == 1 else label for _, label in angles]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise LogError(f"{path}: two trajectories are named {twice!r:.60}")
    return {name: number for name, (number, _) in zip(names, angles, strict=True)}


def _flexion(components: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The first of three components, shape (3, n); NaN where all are exactly zero."""
    return np.where((components == 0.0).all(axis=0), np.nan, components[0])
