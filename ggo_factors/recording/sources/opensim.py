"""Joint angles from OpenSim: motion (.mot) and storage (.sto) files."""

from __future__ import annotations

import re

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.sources.columns import Columns, log_of_columns
from ggo_factors.recording.sources.text_table import read_lines, table_below
from ggo_factors.support.files import PathLike

_HEADER_LINES = 1000
"""A header is sought in so many lines."""
_LENGTH = re.compile(r"_t[xyz](/value)?$", re.IGNORECASE)
"""Coordinates that are lengths in [m], such as ``pelvis_tx``; a file in degrees does not mean them."""
_NO_ANGLE = re.compile(
    r"force|torque|moment|activation|fiber|excitation|speed$|_u$|_[vp][xyz]$|_[vp]$|reserve", re.IGNORECASE
)
"""Columns of forces, moments, muscles and speeds."""


def read_opensim(path: PathLike) -> JointLog:
    """Read the coordinates of a `.mot` or `.sto` file, in the unit that its header states (``inDegrees``).

    Raises:
        LogError: naming file and line where something is wrong, or where it holds forces.
        InputError: where the file is missing or no text.
    """
    lines = read_lines(path)
    end = next((n for n, line in enumerate(lines[:_HEADER_LINES]) if line.strip().lower() == "endheader"), None)
    if end is None:
        raise LogError(f"{path}: no line 'endheader' in its first {min(len(lines), _HEADER_LINES)} lines: cut?")
    said = _header(lines[:end])
    at = next((n for n in range(end + 1, len(lines)) if lines[n].strip()), None)
    if at is None:
        raise LogError(f"{path}: nothing below its header: the file is cut")
    table = table_below(path, lines, lines[at], at + 1, None)
    values, words = table.numbers()
    for key, found, what in (("ncolumns", len(table.names), "columns"), ("nrows", len(table.lines), "rows")):
        if said.get(key, "").isdigit() and int(said[key]) != found:
            raise LogError(f"{path}: {found} {what}, its header says {said[key]}: cut or changed")
    named = [name for name in table.names if name.lower() != "time"]
    if all(_NO_ANGLE.search(name) for name in named):
        raise LogError(
            f"{path}: forces, moments, muscles or speeds ({listed(named)}), no joint angles; "
            f"the .mot of inverse kinematics has them"
        )
    if words:
        raise LogError(f"{path}, {table.row(0)}: {words[0]} is no number")
    unit = {"yes": "deg", "no": "rad"}.get(said.get("indegrees", "").lower())
    return log_of_columns(Columns(str(path), _ending(path), values, _units(named, unit), table.row))


def _header(lines: list[str]) -> dict[str, str]:
    """Keys and values of a header: ``nRows=153`` and, as older files have it, ``datarows 153``."""
    said = dict[str, str]()
    for line in lines:
        key, _, value = line.partition("=") if "=" in line else line.strip().partition(" ")
        said[key.strip().lower()] = value.strip()
    older = {"datarows": "nrows", "datacolumns": "ncolumns"}
    return {older.get(key, key): value for key, value in said.items()}


def _units(names: list[str], unit: str | None) -> dict[str, str]:
    units = {name: "m" for name in names if _LENGTH.search(name)}
    for name in names:
        if name not in units and _NO_ANGLE.search(name):
            units[name] = "no angle"
        elif name not in units and unit is not None:
            units[name] = unit
    return units


def _ending(path: PathLike) -> str:
    return str(path).rpartition(".")[2].lower()
