"""Gait and walk files with one thing changed, as a slip of the hand or a broken copy would change it."""

import re
from collections.abc import Callable

import numpy as np


def _rows(text: str) -> tuple[list[str], list[str]]:
    lines = text.splitlines()
    first = next(n for n, line in enumerate(lines) if not line.startswith("#")) + 1
    return lines[:first], lines[first:]


def _joined(head: list[str], rows: list[str]) -> str:
    head = [f"# frames: {len(rows)}" if line.startswith("# frames:") else line for line in head]
    return "\n".join(head + rows) + "\n"


def _angle(text: str, rng: np.random.Generator) -> str:
    head, rows = _rows(text)
    n = rng.integers(len(rows))
    cells = rows[n].split(",")
    k = len(cells) - 1 - rng.integers(4)
    cells[k] = f"{float(cells[k]) + rng.choice([-20.0, 20.0]):.12f}"
    rows[n] = ",".join(cells)
    return _joined(head, rows)


def _dropped(text: str, rng: np.random.Generator) -> str:
    head, rows = _rows(text)
    del rows[rng.integers(len(rows))]
    return _joined(head, rows)


def _doubled(text: str, rng: np.random.Generator) -> str:
    head, rows = _rows(text)
    n = rng.integers(len(rows))
    rows.insert(n, rows[n])
    return _joined(head, rows)


def _swapped(text: str, rng: np.random.Generator) -> str:
    head, rows = _rows(text)
    n = rng.integers(len(rows) - 1)
    rows[n], rows[n + 1] = rows[n + 1], rows[n]
    return _joined(head, rows)


def _slowed(text: str, rng: np.random.Generator) -> str:
    return re.sub(r"(?m)^# dt: (\S+) s$", lambda found: f"# dt: {10.0 * float(found[1])!r} s", text)


CHANGES: dict[str, Callable[[str, np.random.Generator], str]] = {
    "an angle by 20 degrees": _angle,
    "a row dropped": _dropped,
    "a row doubled": _doubled,
    "two rows swapped": _swapped,
    "dt times 10": _slowed,
}
"""Each takes a file's text and chance, and gives the changed text; its count of frames is set right."""
