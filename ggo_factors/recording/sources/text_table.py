"""Rows of numbers in a text file: read fast where all is well, cell by cell where something is not."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.sources.columns import SECONDS, named_unit, require_seconds, time_column, unit_in
from ggo_factors.support.files import PathLike, read_text
from ggo_factors.support.inputs import Array

LARGEST_BYTES = 2**30
"""Largest text file that is read, in [byte]: some hours of a walk at 1 kHz."""
_MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "."}
"""Cells that say that there is no value."""
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(e[+-]?\d+)?", re.IGNORECASE)
_DATE = re.compile(r"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:\.\d{1,9})?)?)(Z|[+-]\d\d:?\d\d)?")
_EXACT = 1e5
"""Times beyond this many units are read digit by digit: a float of a clock's seconds since 1970 keeps only 0.2 us."""


@dataclass(frozen=True, eq=False)
class TextTable:
    """The rows below a header.

    Attributes:
        path: the file.
        names: the columns' names, none twice.
        separator: between cells, or None for any white space.
        lines: the rows as they stand in the file.
        first_line: number of the first row's line, from 1.
    """

    path: str
    names: tuple[str, ...]
    separator: str | None
    lines: Sequence[str]
    first_line: int

    def row(self, number: int) -> str:
        """What a row is called in a message, by its number from 0."""
        return f"line {self.first_line + number}"

    def cells(self, line: str) -> list[str]:
        """The cells of a row."""
        return split(line, self.separator)

    def numbers(self) -> tuple[dict[str, Array], list[str]]:
        """The columns that hold numbers (NaN where a cell is empty), and the names of those that hold none.

        Raises:
            LogError: naming line, column and cell where a column of numbers holds something else.
        """
        try:
            rows = np.loadtxt(
                self.lines, delimiter=self.separator, comments=None, ndmin=2, quotechar='"', dtype=np.float64
            )
        except ValueError:
            return self._numbers_one_by_one()
        if rows.shape[1] != len(self.names):
            raise self._wrong_count(0)
        return dict(zip(self.names, rows.T, strict=True)), []

    def times(self, units: Mapping[str, str]) -> tuple[str, Array] | None:
        """The name of the time column and its times in [s] from the first one, where floats would not do.

        Args:
            units: what the file states of columns beside their names.

        Returns:
            None where the column's numbers are good enough as they are.

        Raises:
            LogError: where there is no such column, or a date among its dates is none.
        """
        name = time_column(self.names, self.path)
        stated = units.get(name) or unit_in(name)
        unit = stated or "s"
        first = self._column(name, self.lines[:1])
        dates = bool(first and _DATE.match(first[0]))
        if not dates and not (first and unit in SECONDS and _is_large(first[0])):
            return None
        stamps = self._column(name, self.lines)
        if len(stamps) < len(self.lines):
            return None  # the numbers' own reader says which row is short
        if dates:
            return name, self._dates(name, stamps)
        scale = Decimal(str(SECONDS[unit])) * 10**9
        try:
            digits = [Decimal(stamp) for stamp in stamps]
            ns = [int((value - digits[0]) * scale) for value in digits]
        except (InvalidOperation, ValueError, OverflowError):
            return None  # nor a cell that is no number
        times = np.array(ns, dtype=np.float64) * 1e-9
        if stated is None:
            require_seconds(times, name, self.path)
        return name, times

    def _column(self, name: str, lines: Sequence[str]) -> list[str]:
        """The cells of a column, without those of rows that are too short."""
        at = self.names.index(name)
        rows = (self.cells(line) for line in lines)
        return [row[at].strip().strip('"') for row in rows if len(row) > at]

    def _dates(self, name: str, stamps: Sequence[str]) -> Array:
        """Times in [s] from the first of dates in one time zone."""
        dates = [_DATE.fullmatch(stamp) for stamp in stamps]
        zone = dates[0][2] if dates[0] else None
        ns = np.zeros(len(stamps), np.int64)
        for number, (date, stamp) in enumerate(zip(dates, stamps, strict=True)):
            if date is None or date[2] != zone:
                raise LogError(f"{self.path}, {self.row(number)}: {name} is {stamp!r:.40}, no date like the first")
            ns[number] = np.datetime64(date[1], "ns").astype(np.int64)
        return np.asarray((ns - ns[0]) * 1e-9, dtype=np.float64)

    def _numbers_one_by_one(self) -> tuple[dict[str, Array], list[str]]:
        columns: list[list[float | str]] = [[] for _ in self.names]
        for number, line in enumerate(self.lines):
            cells = self.cells(line)
            if len(cells) != len(self.names):
                raise self._wrong_count(number)
            for column, cell in zip(columns, cells, strict=True):
                column.append(_cell(cell))
        found: dict[str, Array] = {}
        words: list[str] = []
        for name, column in zip(self.names, columns, strict=True):
            wrong = [number for number, value in enumerate(column) if isinstance(value, str)]
            known = any(isinstance(value, float) and np.isfinite(value) for value in column)
            if wrong and not known and not _DECIMAL_COMMA.fullmatch(str(column[wrong[0]])):
                words.append(name)
                continue
            if wrong:
                cell = str(column[wrong[0]])
                comma = ": write decimals with a point" if _DECIMAL_COMMA.fullmatch(cell) else ", no number"
                raise LogError(f"{self.path}, {self.row(wrong[0])}: {name} is {cell!r:.40}{comma}")
            found[name] = np.array(column, dtype=np.float64)
        return found, words

    def _wrong_count(self, number: int) -> LogError:
        cells = self.cells(self.lines[number])
        commas = ""
        if self.separator == "," and len(cells) > len(self.names):
            commas = "; decimals need a point, for the comma parts columns"
        return LogError(
            f"{self.path}, {self.row(number)}: {len(cells)} values, the header has {len(self.names)} names{commas}"
        )


def read_lines(path: PathLike) -> list[str]:
    """The lines of a text file, without empty ones at its end.

    Raises:
        LogError: where it is empty, or larger than is read.
        InputError: where it is missing or no text.
    """
    file = Path(path)
    if file.is_file() and (size := file.stat().st_size) > LARGEST_BYTES:
        raise LogError(f"{path}: {size / 1e9:.1f} GB of text (limit {LARGEST_BYTES / 1e9:.1f} GB): cut out the walk")
    lines = read_text(path).rstrip().splitlines()
    if not lines:
        raise LogError(f"{path}: the file is empty")
    return lines


def table_below(path: PathLike, lines: list[str], header: str, at: int, separator: str | None) -> TextTable:
    """The table whose rows begin at `lines[at]`, of columns that `header` names.

    Raises:
        LogError: where a name stands twice, or there is no row.
    """
    plain = [name.strip().strip('"').strip() for name in split(header, separator)]
    names = tuple(name or f"column {number}" for number, name in enumerate(plain, start=1))
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        first, second = [n + 1 for n, name in enumerate(names) if name == twice][:2]
        raise LogError(f"{path}, line {at}: columns {first} and {second} are both named {twice!r:.60}")
    rows = lines[at:]
    if not rows:
        raise LogError(f"{path}: no row below the names {listed(names)}")
    empty = next((number for number, line in enumerate(rows) if not line.strip()), None)
    if empty is not None:
        raise LogError(f"{path}, line {at + empty + 1}: the line is empty")
    return TextTable(str(path), names, separator, rows, at + 1)


def split(line: str, separator: str | None) -> list[str]:
    """The cells of a line; quotes keep a separator in a cell."""
    if separator is None:
        return line.split()
    return next(csv.reader(io.StringIO(line), delimiter=separator)) if '"' in line else line.split(separator)


def is_number(cell: str) -> bool:
    """Whether a cell is a number, or says that there is none."""
    return isinstance(_cell(cell), float)


def unit_row(cells: Sequence[str]) -> list[str] | None:
    """The units in a row of them below the names (``s,deg,deg``), or None where it is none."""
    units = [named_unit(cell.strip().strip('"[]()')) for cell in cells]
    return units if {*units} & {"deg", "rad"} and not any(is_number(cell) and cell.strip() for cell in cells) else None


def _is_large(cell: str) -> bool:
    try:
        return abs(float(cell)) > _EXACT
    except ValueError:
        return False


def _cell(text: str) -> float | str:
    word = text.strip().strip('"').strip()
    if word.lower() in _MISSING:
        return np.nan
    try:
        return float(word)
    except ValueError:
        return word
