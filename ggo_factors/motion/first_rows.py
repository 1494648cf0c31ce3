"""The first step of a flight in a gait's file: its rows behind the gait's own, and what the header says of them."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.recorded import Recorded, header_json, recorded_from
from ggo_factors.support.csv_table import Table
from ggo_factors.support.inputs import Array, as_count, as_instance

FIRST_STEP = "first_step"
"""The key under which a file says how many of its last rows are the first step, and what that is called."""


@dataclass(frozen=True, eq=False)
class FirstRows:
    """A first step as a file has it.

    Attributes:
        frames: its frames in [rad], shape (m, 4).
        dt: time between two of them in [s].
        name: what it is called.
        origin: where it comes from.
        recorded: the swings that it is the mean of, if known.
    """

    frames: Array
    dt: float
    name: str
    origin: str
    recorded: Recorded | None

    @property
    def line(self) -> str:
        """The value of the header's line `FIRST_STEP`."""
        said: dict[str, object] = {"frames": len(self.frames), "name": self.name, "origin": self.origin}
        if self.recorded is not None:
            kept = self.recorded
            said |= {"ground": kept.ground, "swing": kept.swing, "strides": kept.strides}
        return json.dumps(said)

    @property
    def rows(self) -> Array:
        """Time, angles in degrees and their spread, shape (m, 9)."""
        times, spread = np.arange(len(self.frames)) * self.dt, np.zeros_like(self.frames)
        if self.recorded is not None:
            spread = self.recorded.spread_at(len(self.frames))
        return np.column_stack([times, np.degrees(self.frames), np.degrees(spread)])


def first_rows(table: Table) -> FirstRows | None:
    """The first step that a gait file holds behind its gait, if it does.

    Raises:
        InputError: naming the file and what is wrong.
    """
    if FIRST_STEP not in table.header:
        return None
    said = header_json(table, FIRST_STEP)
    try:
        told = as_instance(said, FIRST_STEP, dict)
        count = as_count(told.get("frames"), f"{FIRST_STEP}: frames", 2, len(table.values) - 2)
        rows = table.values[len(table.values) - count :]
        if rows.shape[1] != 9 or rows[0, 0] or not (np.diff(rows[:, 0]) > 0.0).all():
            raise InputError(f"{FIRST_STEP}: the times of the last {count} rows do not grow from 0")
        name, origin = (as_instance(told.get(key, ""), f"{FIRST_STEP}: {key}", str) for key in ("name", "origin"))
    except InputError as error:
        raise InputError(f"{table.path}: header: {error}") from error
    recorded = recorded_from(table, told, rows[:, 5:]) if "strides" in told else None
    return FirstRows(np.radians(rows[:, 1:5]), float(rows[-1, 0]) / (count - 1), name, origin, recorded)
