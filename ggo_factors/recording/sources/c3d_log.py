"""Joint angles from a C3D file as Vicon's Plug-in Gait writes them: flexion is the first component, in degrees."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.sources.columns import Columns, few, log_of_columns, named_unit
from ggo_factors.recording.sources.extras import needed, require_content
from ggo_factors.support.files import PathLike

ENDING = "angles"
"""Labels of joint angles end so, in any case: ``LHipAngles``."""

_HEAD = 16 * 512
"""Bytes at the start of a file that hold its header and the first bytes of its parameters."""
_BIG_ENDIAN = 86
"""Kind of processor, in the parameters, whose numbers have their high byte first."""
_MANY = 65535
"""Number of the last frame where there are more than the header can count."""


def read_c3d(path: PathLike) -> JointLog:
    """Read the flexion angles of a C3D file; a frame whose angles are all exactly zero was not measured.

    Raises:
        LogError: where ezc3d is not installed or cannot read the file, or it holds no angles.
    """
    ezc3d = needed("ezc3d", "c3d", path, "a C3D file")
    require_content(path)
    try:
        content = ezc3d.c3d(str(path))
    except Exception as error:  # whatever a damaged file makes of a C++ parser
        raise LogError(f"{path}: ezc3d cannot read it: {(str(error) or repr(error)).splitlines()[0]:.160}") from error
    points = np.asarray(content["data"]["points"], dtype=np.float64)
    stated = _stated_frames(_start(Path(path)))
    if stated > points.shape[2]:
        raise LogError(f"{path}: {points.shape[2]} of the {stated} frames that its header states: the file is cut")
    parameters = content["parameters"]["POINT"]
    rate = float(_value(parameters, "RATE", [0.0])[0])
    if not rate > 0.0:
        raise LogError(f"{path}: its rate is {rate:g} Hz")
    labels = list(_labels(parameters))
    angles = [(number, label) for number, label in enumerate(labels) if label.lower().endswith(ENDING)]
    if not angles:
        raise LogError(
            f"{path}: no joint angles (LHipAngles, LKneeAngles, ...) among {few(labels)}: run the model, "
            f"such as Plug-in Gait, and export its angles"
        )
    values = {name: _flexion(points[:3, number]) for name, number in _named(angles, path).items()}
    unit = named_unit(str(_value(parameters, "ANGLE_UNITS", ["deg"])[0]) or "deg")
    times = np.arange(points.shape[2]) / rate
    return log_of_columns(
        Columns(str(path), "c3d", values, dict.fromkeys(values, unit), _frame, times, f"rate {rate:.6g} Hz")
    )


def _start(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(_HEAD)


def _stated_frames(head: bytes) -> int:
    """How many frames the header of a file states, which ezc3d sets to those it found; 0 where it cannot say."""
    parameters = (head[0] - 1) * 512 + 3 if head else 0
    big = parameters < len(head) and head[parameters] == _BIG_ENDIAN
    first, last = struct.unpack_from(">HH" if big else "<HH", head, 6) if len(head) >= 10 else (1, 0)
    return 0 if last == _MANY else last - first + 1


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
