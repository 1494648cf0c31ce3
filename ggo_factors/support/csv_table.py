"""CSV with a header of `# key: value` lines: the one format of gait and walk files.

The line `# checksum: ...` tells whether the numbers are those that were written. It is over what a walker's joints will
do, the rows and the header's time step, limits and landing speed; the other header lines are free to edit.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.support.files import PathLike, read_text, write_text
from ggo_factors.support.inputs import Array

DIGITS = 12
"""Digits after the point, in degrees: rounding stays below 1e-14 rad, far under the 1e-9 rad within which one step must
start where the last one ended."""

CHECKSUM_KEYS = ("dt", "limits", "landing_speed")
"""The header lines that the checksum is over, those that a file has, before its rows."""

CHECKSUM_DIGITS = 16
"""Hexadecimal digits of a checksum: against mistakes, not against forgers; one change in 2^64 goes unseen."""


@dataclass(frozen=True, eq=False)
class Table:
    """A file of one kind: its header and its columns of numbers.

    Attributes:
        path: where it was read from.
        header: the `# key: value` lines in their order.
        values: numbers, shape (rows, columns).
        first_line: number of the line of the first row, from 1.
        checksum: that of the numbers as they stand in the file now.
    """

    path: str
    header: Mapping[str, str]
    values: Array
    first_line: int
    checksum: str = ""

    def text(self, key: str) -> str:
        """The header's value of `key`.

        Raises:
            InputError: where the header lacks it.
        """
        if key not in self.header:
            raise InputError(f"{self.path}: the header has no line '# {key}: ...'")
        return self.header[key]

    def number(self, key: str, unit: str = "") -> float:
        """The header's value of `key` as a finite number, with or without its unit behind it.

        Raises:
            InputError: where it is missing, no finite number, or in another unit.
        """
        text = self.text(key)
        value, _, said = text.partition(" ") if unit else (text, "", "")
        if said.strip() not in ("", unit):
            raise InputError(f"{self.path}: header '{key}' is in {said.strip()!r}, expected {unit!r}")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            raise InputError(f"{self.path}: header '{key}' is {value!r}, not a finite number")
        return number

    def require_unchanged(self, edited: bool) -> tuple[str, ...]:
        """What is to be said of a file whose numbers may not be those that were written, a line each.

        Raises:
            InputError: where they were changed and it is not said that the file was `edited`.
        """
        if "checksum" not in self.header:
            return (f"{self.path}: has no checksum, so changed numbers cannot be told",)
        if self.header["checksum"] == self.checksum:
            return ()
        if not edited:
            raise InputError(
                f"{self.path}: its rows, dt or limits were changed since it was written (checksum {self.checksum}, its "
                f"header says {self.header['checksum']:.40}); to take it as it is: edited=True"
            )
        return (f"{self.path}: taken as edited, its rows, dt or limits were changed since it was written",)


def kind_of(path: PathLike) -> str:
    """The kind that the first line of a file states, for example ``"ggo-gait"``; "" where it states none."""
    first, _, _ = read_text(path).partition("\n")
    words = first.lstrip("# ").split()
    return words[0] if first.startswith("#") and words else ""


def write_table(
    path: PathLike,
    kind: str,
    header: Mapping[str, str],
    columns: Sequence[str],
    rows: Array,
    counts: int = 0,
    version: int = 1,
) -> None:
    """Write a file of `kind` in a version of its format; the first `counts` columns are whole numbers.

    Raises:
        InputError: where a header value spans lines or the file cannot be written.
    """
    for key, value in header.items():
        if not value.isprintable():
            raise InputError(f"{key}: {value!r:.80} must be one printable line to stand in a file's header")
    lines = _row_lines(rows, counts)
    described = {**header, "frames": str(len(rows)), "checksum": _checksum(header, lines)}
    head = [f"# {kind} {version}", *(f"# {key}: {value}" for key, value in described.items()), ",".join(columns)]
    write_text(path, "\n".join(head + lines) + "\n")


def _row_lines(rows: Array, counts: int) -> list[str]:
    return [
        ",".join([str(int(v)) for v in row[:counts]] + [f"{v:.{DIGITS}f}" for v in row[counts:]])
        for row in rows.tolist()
    ]


def _checksum(header: Mapping[str, str], lines: Sequence[str]) -> str:
    """SHA-256, shortened, over the header lines in `CHECKSUM_KEYS` and the rows as `write_table` writes both."""
    head = [f"# {key}: {header[key]}" for key in CHECKSUM_KEYS if key in header]
    return hashlib.sha256("\n".join(head + list(lines)).encode()).hexdigest()[:CHECKSUM_DIGITS]


def read_table(path: PathLike, kind: str, versions: Sequence[Sequence[str]], counts: int = 0) -> Table:
    """Read a file that `write_table` wrote, or one made by hand in the same form.

    `versions` are the columns of the format's version 1, 2 and so on.

    Whether its numbers are those that were written is told by `Table.require_unchanged`, once they are known to be
    usable: what is wrong with a number says more.

    Raises:
        InputError: naming the file and the line: not of this kind or version, a wrong column, a row of
            another length, a value that is no finite number, fewer frames than the header says.
    """
    text = read_text(path)
    if not text.strip():
        raise InputError(f"{path}: the file is empty")
    lines = [line.removesuffix("\r") for line in text.removesuffix("\n").split("\n")]
    heads = [f"# {kind} {number}" for number in range(1, len(versions) + 1)]
    if lines[0].strip() not in heads:
        expected = " or ".join(f"'{head}'" for head in heads)
        raise InputError(f"{path}, line 1: expected {expected}, found {lines[0]!r:.60}")
    columns = versions[heads.index(lines[0].strip())]
    header: dict[str, str] = {}
    at = 1
    while at < len(lines) and lines[at].startswith("#"):
        key, colon, value = lines[at].lstrip("# ").partition(":")
        if not colon:
            raise InputError(f"{path}, line {at + 1}: expected '# key: value', found {lines[at]!r:.60}")
        if key.strip() in header:
            raise InputError(f"{path}, line {at + 1}: '{key.strip()}' stands twice in the header")
        header[key.strip()] = value.strip()
        at += 1
    names = [name.strip() for name in lines[at].split(",")] if at < len(lines) else []
    if names != list(columns):
        found = repr(lines[at])[:80] if at < len(lines) else "the end of the file"
        raise InputError(f"{path}, line {at + 1}: expected the columns {','.join(columns)}, found {found}")
    rows: list[list[float]] = []
    for number, line in enumerate(lines[at + 1 :], start=at + 2):
        if not line.strip():
            raise InputError(f"{path}, line {number}: the line is empty")
        cells = line.split(",")
        if len(cells) != len(columns):
            raise InputError(f"{path}, line {number}: expected {len(columns)} values, found {len(cells)}")
        rows.append([_cell(path, number, name, cell) for name, cell in zip(columns, cells, strict=True)])
    values = np.array(rows, dtype=np.float64).reshape(len(rows), len(columns))
    # Over the rows as they would be written: another program may have cut zeros or ended lines in its own way.
    table = Table(str(path), header, values, at + 2, _checksum(header, _row_lines(values, counts)))
    if "frames" in header and table.number("frames") != len(rows):
        raise InputError(f"{path}: {len(rows)} frames, its header says {header['frames']}: the file is cut or changed")
    if "frames" in header and not text.endswith("\n"):
        raise InputError(f"{path}, line {len(lines)}: the line has no end: the file is cut")
    return table


def _cell(path: PathLike, line: int, column: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}, line {line}: {column} is {text.strip()!r:.40}, not a finite number")
    return value
