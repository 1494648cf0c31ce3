"""A terrain as a TOML file, `# ggo-terrain 1`.

The file has a table `[[ground]]` for each surface in order: `x_end` in [m], `height` at its near edge in [m],
`slope_deg`, `edge_std` and `height_std` in [m]; a table `[[box]]` for each box with `x_start`, `x_end` and `height`
above the ground it stands on in [m], and both standard deviations; a table `[[pit]]` for each pit with `x_start`,
`x_end`, `edge_std`, and `unknown = true` for ground that nobody saw. What has a standard deviation of 0 may leave it
out; `x_start` of the whole is 0 unless it says so.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ggo_factors.errors import InputError
from ggo_factors.motion.surface import Surface
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.support.inputs import as_bool, as_number

Parts = tuple[tuple[Surface, ...], tuple[Obstacle, ...], tuple[Gap, ...], str]

FIRST_LINE = "# ggo-terrain 1"
"""What a terrain file begins with."""
DIGITS = 12
"""Decimals of slopes in degrees: few enough to cut off the rounding of a conversion to radians and back."""
GROUND = ("x_end", "height", "slope_deg", "edge_std", "height_std")
BOX = ("x_start", "x_end", "height", "edge_std", "height_std")
PIT = ("x_start", "x_end", "edge_std", "unknown")


def terrain_text(surfaces: Sequence[Surface], boxes: Sequence[Obstacle], pits: Sequence[Gap], name: str) -> str:
    """A terrain as TOML."""
    # JSON would write what lies beyond 16 bits as two halves, which TOML refuses.
    text = json.dumps(name, ensure_ascii=False).replace("\x7f", "\\u007f")
    lines = [FIRST_LINE, f"name = {text}", f"x_start = {surfaces[0].x_start!r}", ""]
    for surface in surfaces:
        slope = round(math.degrees(surface.slope), DIGITS)
        numbers = {"x_end": surface.x_end, "height": surface.height, "slope_deg": slope}
        spread = {"edge_std": surface.edge_std, "height_std": surface.height_std}
        lines += _table("ground", {**numbers, **spread}, GROUND[2:])
    for box in boxes:
        lines += _table("box", {name: getattr(box, name) for name in BOX}, BOX[3:])
    for pit in pits:
        lines += _table("pit", {name: getattr(pit, name) for name in PIT}, PIT[2:])
    return "\n".join(lines)


def parsed_terrain(text: str) -> Parts:
    """The surfaces, boxes, pits and name of what `terrain_text` gives.

    Raises:
        InputError: naming the table and the value that is wrong.
    """
    first = (text.splitlines() or [""])[0]
    if first.rstrip() != FIRST_LINE:
        raise InputError(f"is no terrain file: it begins with {first!r:.40}, expected {FIRST_LINE!r}")
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number of 4301 digits is no TOMLDecodeError
        raise InputError(f"is not TOML: {error}") from error
    return _parts(data)


def _parts(data: Mapping[str, Any]) -> Parts:
    _known(data, ("name", "x_start", "ground", "box", "pit"), "")
    x, surfaces = as_number(data.get("x_start", 0.0), "x_start", unit="m"), []
    for number, table in enumerate(_tables(data, "ground"), start=1):
        where = f"ground {number}"
        _known(table, GROUND, where)
        given = {name: _number(table, name, where, 0.0 if name != "x_end" else None) for name in GROUND}
        given["slope"] = math.radians(given.pop("slope_deg"))
        surface = _made(Surface, {"x_start": x, **given}, where)
        surfaces.append(surface)
        x = surface.x_end
    boxes, pits = [], []
    for number, table in enumerate(_tables(data, "box"), start=1):
        _known(table, BOX, f"box {number}")
        given = {name: _number(table, name, f"box {number}", 0.0 if "std" in name else None) for name in BOX}
        boxes.append(_made(Obstacle, given, f"box {number}"))
    for number, table in enumerate(_tables(data, "pit"), start=1):
        _known(table, PIT, f"pit {number}")
        given = {name: _number(table, name, f"pit {number}", 0.0 if "std" in name else None) for name in PIT[:3]}
        pit = _made(Gap, given, f"pit {number}")
        pits.append(replace(pit, unknown=as_bool(table.get("unknown", False), f"pit {number}: unknown")))
    name = data.get("name", "terrain")
    if not isinstance(name, str):
        raise InputError(f"name: expected text, got {name!r:.40}")
    return tuple(surfaces), tuple(boxes), tuple(pits), name


def _tables(data: Mapping[str, Any], name: str) -> list[Mapping[str, Any]]:
    tables = data.get(name, [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise InputError(f"{name}: expected tables [[{name}]], got {tables!r:.60}")
    return tables


def _known(table: Mapping[str, Any], names: tuple[str, ...], where: str) -> None:
    for name in table:
        if name not in names:
            raise InputError(f"{where + ': ' if where else ''}unknown key {name!r:.40}; known: {', '.join(names)}")


def _number(table: Mapping[str, Any], name: str, where: str, otherwise: float | None) -> float:
    if name not in table and otherwise is None:
        raise InputError(f"{where}: lacks {name!r}")
    return as_number(table.get(name, otherwise), f"{where}: {name}")


def _made(kind: type[Any], numbers: Mapping[str, float], where: str) -> Any:
    try:
        return kind(**numbers)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _table(name: str, values: Mapping[str, float | bool], optional: tuple[str, ...]) -> list[str]:
    shown = {key: value for key, value in values.items() if value or key not in optional}
    lines = [f"{key} = {'true' if value is True else repr(value)}" for key, value in shown.items()]
    return [f"[[{name}]]", *lines, ""]
