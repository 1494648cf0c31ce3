"""Results as plain JSON, exactly: no number is rounded, and one that is not finite is a word."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.support.files import PathLike, read_text, write_text
from ggo_factors.support.inputs import Array

_WORDS = ("nan", "inf", "-inf")


def to_plain(value: Any) -> Any:
    """A value as JSON holds it: dataclasses and mappings as objects, arrays and tuples as lists.

    JSON has no number for what is not finite: it is ``"nan"``, ``"inf"`` or ``"-inf"``, which `float` reads.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if is_dataclass(value):
        return {each.name: to_plain(getattr(value, each.name)) for each in fields(value)}
    if isinstance(value, Mapping):
        return {name: to_plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def write_plain(path: PathLike, kind: str, content: Mapping[str, Any]) -> None:
    """Write JSON whose first key, `format`, says what it is and in which version, whole or not at all.

    Raises:
        InputError: where the file cannot be written.
    """
    write_text(path, json.dumps({"format": kind, **content}, allow_nan=False) + "\n")


def read_plain(path: PathLike, kind: str) -> dict[str, Any]:
    """What `write_plain` wrote.

    Raises:
        InputError: naming the file, where it is no JSON or of another kind.
    """
    try:
        found = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: is no JSON: {error}") from error
    said = found.get("format") if isinstance(found, dict) else None
    if said != kind:
        raise InputError(f"{path}: its format is {said!r:.40}, expected {kind!r}")
    return dict(found)


def read_number(value: Any, name: str) -> float:
    """A number as `to_plain` wrote it.

    Raises:
        InputError: where it is none.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value
    if value in _WORDS:
        return float(value)
    raise InputError(f"{name}: expected a number, got {value!r:.80}")


def read_array(value: Any, name: str, dimensions: int) -> Array:
    """Numbers as `to_plain` wrote an array of so many dimensions.

    Raises:
        InputError: where they are none.
    """
    if not isinstance(value, list):
        raise InputError(f"{name}: expected a list, got {value!r:.80}")
    rows = [read_number(item, name) if dimensions == 1 else read_array(item, name, dimensions - 1) for item in value]
    try:
        return np.array(rows, dtype=np.float64)
    except ValueError as error:
        raise InputError(f"{name}: its rows differ in length") from error
