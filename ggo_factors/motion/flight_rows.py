"""First and last step of a flight in a gait's file: their rows behind the gait's own, and what the header says."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.recorded import Recorded, header_json, recorded_from
from ggo_factors.support.csv_table import Table
from ggo_factors.support.inputs import Array, as_count, as_instance

FLIGHT_STEPS = ("first_step", "last_step")
"""The keys under which a file says how many of its last rows are the first step, before those how many are the last
step, and what each is called."""


@dataclass(frozen=True, eq=False)
class FlightRows:
    """A first or last step as a file has it.

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
        """The value of its line in the header."""
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


def flight_rows(table: Table) -> dict[str, FlightRows]:
    """The first and the last step that a gait file holds behind its gait, by their keys; empty where it has neither.

    Raises:
        InputError: naming the file and what is wrong.
    """
    found, rows = {}, table.values
    for key in FLIGHT_STEPS:
        if key in table.header:
            found[key] = _last_rows(table, key, rows)
            rows = rows[: len(rows) - len(found[key].frames)]
    return found


def _last_rows(table: Table, key: str, rows: Array) -> FlightRows:
    """The step of one key, which the last ones of `rows` are."""
    said = header_json(table, key)
    try:
        told = as_instance(said, key, dict)
        count = as_count(told.get("frames"), f"{key}: frames", 2, len(rows) - 2)
        own = rows[len(rows) - count :]
        if own.shape[1] != 9 or own[0, 0] or not (np.diff(own[:, 0]) > 0.0).all():
            raise InputError(f"{key}: the times of its {count} rows do not grow from 0")
        name, origin = (as_instance(told.get(what, ""), f"{key}: {what}", str) for what in ("name", "origin"))
    except InputError as error:
        raise InputError(f"{table.path}: header: {error}") from error
    recorded = recorded_from(table, told, own[:, 5:]) if "strides" in told else None
    return FlightRows(np.radians(own[:, 1:5]), float(own[-1, 0]) / (count - 1), name, origin, recorded)
