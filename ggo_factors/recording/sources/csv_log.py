"""Joint values from CSV: any separator, names in the header, units in the names or in a row below them."""

from __future__ import annotations

from dataclasses import replace

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.sources.columns import Columns, log_of_columns, time_column
from ggo_factors.recording.sources.text_table import is_number, read_lines, split, table_below, unit_row
from ggo_factors.support.files import PathLike

SEPARATORS = (";", "\t", ",")
"""Between columns; the first of those in the header that occurs most, white space where none does."""
_OWN = ("# ggo-gait", "# ggo-walk")
_NEXUS = {"joints", "model outputs", "trajectories", "devices", "segments"}
"""First lines of the tables that Vicon Nexus exports: names, components and units in rows of their own."""


def read_csv(path: PathLike) -> JointLog:
    """Read a CSV of a time column and a column for each joint value.

    Raises:
        LogError: naming file, line and column where something is wrong.
        InputError: where the file is missing or no text.
    """
    lines = read_lines(path)
    if lines[0].startswith(_OWN):
        raise LogError(f"{path}: is a gait or walk of this library, a base gait already, not a recording")
    if lines[0].strip(" ,;\t").lower() in _NEXUS:
        raise LogError(f"{path}: a table of Vicon Nexus with several header rows; import the .c3d, or leave one")
    header, at = _header(path, lines)
    separator = _separator(header)
    table = table_below(path, lines, header, at, separator)
    units: dict[str, str] = {}
    if below := unit_row(table.cells(table.lines[0])):
        units = {name: unit for name, unit in zip(table.names, below, strict=False) if unit}
        table = table_below(path, lines, header, at + 1, separator)
    notes: list[str] = []
    if len(table.lines) > 2 and len(table.cells(table.lines[-1])) < len(table.names):
        notes.append(f"{table.row(len(table.lines) - 1)}, the last one, is cut: left out")
        table = replace(table, lines=table.lines[:-1])
    exact = table.times(units)
    values, words = table.numbers()
    times, time_source = None, ""
    if exact is not None:
        time_source, times = f"column {exact[0]}", exact[1]
        values.pop(exact[0], None)
        words = [name for name in words if name != exact[0]]
    elif (name := time_column(table.names, str(path))) in words:
        cell = table.cells(table.lines[0])[table.names.index(name)]
        raise LogError(f"{path}, {table.row(0)}: {name} is {cell!r:.40}, neither a number nor a date with a time")
    if words:
        notes.append(f"{listed(words)}: no numbers, left out")
    return log_of_columns(Columns(str(path), "csv", values, units, table.row, times, time_source, tuple(notes)))


def _header(path: PathLike, lines: list[str]) -> tuple[str, int]:
    """The line of names, and the index of the line below it."""
    at = next((number for number, line in enumerate(lines) if not line.startswith("#")), len(lines))
    if at == len(lines):
        raise LogError(f"{path}: holds comments only")
    cells = split(lines[at], _separator(lines[at]))
    if not all(is_number(cell) for cell in cells):
        return lines[at], at + 1
    # numpy.savetxt puts the names into a comment
    last = lines[at - 1].lstrip("# ") if at else ""
    if last and len(split(last, _separator(last))) == len(cells):
        return last, at
    raise LogError(f"{path}, line {at + 1}: numbers where the columns' names should be: {lines[at]!r:.60}")


def _separator(header: str) -> str | None:
    return max((s for s in SEPARATORS if s in header), key=header.count, default=None)
