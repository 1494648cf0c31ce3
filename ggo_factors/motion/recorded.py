"""Where gaits come from: what a base gait is the mean of, and what a generated step was bent from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.support.csv_table import Table
from ggo_factors.support.inputs import Array, as_array, as_count, as_instance

BENT_FROM = "bent_from"
"""The key under which a file says what a generated step was bent from."""
GENERATED = "generated from "
"""How the origin of a gait begins that was bent from another one, whose name follows."""
GROUNDS = ("level", "up", "down", "first up", "first down", "last up", "last down")
"""What a gait is walked on: level ground, stairs, from level ground onto the first stair of a flight, or from its last
stair to feet together on level ground."""
ANGLE_STEP_DEG = 1e-6
"""Angles are counted in this unit for a fingerprint: a file's rounding is a millionth of it and changes none."""
FINGERPRINT_DIGITS = 8
"""Hexadecimal digits of a fingerprint: to tell a user's gaits and styles apart, not to prove anything."""
NUMBER_DIGITS = 6
"""Digits of a style's numbers in a file, in standard deviations."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """The strides that a base gait is the mean of.

    Attributes:
        strides: how many strides, on stairs swings; of a gait for one leg that leg's.
        spread: their standard deviation in [rad], evenly over the step from its start to its landing, shape (n, 4);
            0 where there was one.
        ground: what they were walked on, one of `GROUNDS`.
        swing: the leg that swings: ``"left"``, ``"right"`` or ``"both"``.

    Raises:
        InputError: where a value is none of these.
    """

    strides: int
    spread: Array
    ground: str = "level"
    swing: str = "both"

    def __post_init__(self) -> None:
        as_count(self.strides, "strides", 1)
        object.__setattr__(self, "spread", as_array(self.spread, "spread", (None, 4)))
        if len(self.spread) < 2 or self.spread.min() < 0.0:
            raise InputError("spread: a standard deviation is not below 0, and a step has at least 2 frames")
        for name, known in (("ground", GROUNDS), ("swing", ("left", "right", "both"))):
            if getattr(self, name) not in known:
                raise InputError(f"{name}: {getattr(self, name)!r:.40} is none of {', '.join(known)}")

    def spread_at(self, frames: int) -> Array:
        """The spread in another number of frames, shape (frames, 4) in [rad]."""
        if frames == len(self.spread):
            return self.spread
        own, asked = np.linspace(0.0, 1.0, len(self.spread)), np.linspace(0.0, 1.0, frames)
        return np.stack([np.interp(asked, own, column) for column in self.spread.T], axis=1)


@dataclass(frozen=True)
class BentFrom:
    """What a generated step was bent from.

    Attributes:
        name: name of the base gait.
        fingerprint: its `Gait.fingerprint`.
        ground: the kind of ground that it is for, one of `GROUNDS`.
        swing: the leg that swings, ``"left"`` or ``"right"``.
        style: `Style.fingerprint` of the style that the step varies it with; "" without one.
        numbers: how it does, in standard deviations of that style, as `Solution.style`; empty without one.
    """

    name: str
    fingerprint: str
    ground: str
    swing: str
    style: str = ""
    numbers: tuple[float, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The same for a file's header; without a style nothing is said of it."""
        said = asdict(self) | {"numbers": [round(number, NUMBER_DIGITS) for number in self.numbers]}
        return said if self.style else {key: said[key] for key in ("name", "fingerprint", "ground", "swing")}

    @classmethod
    def from_json(cls, given: Any) -> BentFrom:
        """What a file's header says.

        Raises:
            InputError: where it does not describe it.
        """
        said: Mapping[str, Any] = as_instance(given, "bent_from", dict)
        name, base, ground, swing, style = (
            as_instance(said.get(key, otherwise), f"bent_from: {key}", str)
            for key, otherwise in (
                ("name", None),
                ("fingerprint", None),
                ("ground", None),
                ("swing", None),
                ("style", ""),
            )
        )
        numbers = as_array(said.get("numbers", []), "bent_from: numbers", (None,)).tolist()
        return cls(name, base, ground, swing, style, tuple(numbers))


def fingerprint_of(angles: Array) -> str:
    """Hexadecimal digits that tell arrays of angles in [rad] apart."""
    counted = np.rint(np.degrees(angles) / ANGLE_STEP_DEG).astype("<i8")
    return hashlib.sha256(f"{counted.shape}".encode() + counted.tobytes()).hexdigest()[:FINGERPRINT_DIGITS]


def bent_line(bent: BentFrom) -> str:
    """What a step was bent from as the value of a header line."""
    return json.dumps(bent.to_json())


def recorded_from(table: Table, said: Mapping[str, object], spread_deg: Array) -> Recorded:
    """What a file says of the strides that a gait is the mean of.

    Args:
        table: the file.
        said: `ground`, `swing` and `strides` of the gait.
        spread_deg: their spread in degrees, shape (m, 4).

    Raises:
        InputError: naming the file, where it is missing or cannot be.
    """
    try:
        strides = said.get("strides")
        count = int(strides) if isinstance(strides, str) and strides.isdecimal() else strides
        ground, swing = str(said.get("ground")), str(said.get("swing"))
        return Recorded(as_count(count, "strides", 1), np.radians(spread_deg), ground, swing)
    except InputError as error:
        raise InputError(f"{table.path}: header: {error}") from error


def bent_from(table: Table, said: object) -> BentFrom:
    """What a file says that a step was bent from.

    Raises:
        InputError: naming the file, where it says no such thing.
    """
    try:
        return BentFrom.from_json(said)
    except InputError as error:
        raise InputError(f"{table.path}: header: {error}") from error


def header_json(table: Table, key: str) -> object:
    """The header's value of `key` as JSON.

    Raises:
        InputError: naming the file, where it is none.
    """
    try:
        return json.loads(table.text(key))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{table.path}: header {key!r} is no JSON: {table.text(key):.60}") from error
