"""A walk as CSV: frames of its steps in rows; in the header what each step had to do, and the joint limits."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, fields, replace

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.gait import (
    FRAME_COLUMNS,
    SAME_TIME,
    TIME_COLUMN,
    Gait,
    check_angles_deg,
    gait_from_table,
    gait_header,
)
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import Bones
from ggo_factors.motion.recorded import BENT_FROM, bent_from
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.support.csv_table import Table, read_table, write_table
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_array, as_number
from ggo_factors.walking.step import Step

COLUMNS = ("step", *FRAME_COLUMNS)
TIMED_COLUMNS = ("step", TIME_COLUMN, *FRAME_COLUMNS)
"""Columns of version 2, with the time of each frame since the walk began: its frames are not evenly apart."""

VERSIONS = (COLUMNS, TIMED_COLUMNS, TIMED_COLUMNS)
"""Columns of each version. Version 3 has what a reader of version 2 would take for level ground: slopes, boxes on lower
ground, and pits whose edges were measured with an error, or that are ground which nobody saw."""

BONES_BEFORE: Bones = "points"
"""What the bones of a walk file are that does not say so: it was made and checked before bones were looked at."""
FIRST_SWING = "right"
"""The leg that swings first in a walk file that does not say so, as none of before does."""
LIMIT_DIGITS = 10
"""Decimals of limits in degrees: few enough to cut off the rounding of a conversion to radians and back."""


def write_walk(
    path: PathLike,
    gaits: Sequence[Gait],
    plan: Sequence[Step],
    limits: JointLimits | None,
    landing_speed: float | None,
    first_swing: str,
    described: Mapping[str, str] | None = None,
) -> None:
    """Write steps as CSV (`# ggo-walk 1`, 2 where their frames are not evenly apart, 3 on uneven ground).

    Whole or not at all; see `VERSIONS`. `described` has more lines of the header, among them the walk's name.

    Raises:
        InputError: where the file cannot be written.
    """
    header = gait_header(gaits[0])
    if gaits[0].model is not None:
        header["bones"] = gaits[0].model.bones
    if limits is not None:
        header["limits"] = json.dumps(_limits_to_json(limits))
    if first_swing != FIRST_SWING:
        header["first_swing"] = first_swing
    for number, (gait, step) in enumerate(zip(gaits, plan, strict=True), start=1):
        said = _step_to_json(step) | {"name": gait.name, "origin": gait.origin}
        if gait.bent is not None:
            said[BENT_FROM] = gait.bent.to_json()
        header[f"step {number}"] = json.dumps(said)
    if landing_speed is not None:
        header["landing_speed"] = f"{landing_speed!r} m/s"
    header.update(described or {})
    uneven = any(_needs_version_3(step) for step in plan)
    rows, ran, evenly = [], 0.0, all(gait.paced is None for gait in gaits) and not uneven
    for number, gait in enumerate(gaits, start=1):
        times = [] if evenly else [ran + gait.times]
        rows.append(np.column_stack([np.full(len(gait), number), *times, np.degrees(gait.frames)]))
        ran += gait.duration
    version = 1 if evenly else 3 if uneven else 2
    write_table(path, "ggo-walk", header, VERSIONS[version - 1], np.concatenate(rows), counts=1, version=version)


def read_walk(
    path: PathLike, edited: bool
) -> tuple[tuple[Gait, ...], tuple[Step, ...], JointLimits | None, float | None, str, tuple[str, ...]]:
    """The gaits, plan, limits, landing speed and first swinging leg of a file by `write_walk`, and remarks on it.

    Raises:
        InputError: naming the file, the line and the value that is wrong; where numbers were changed and not `edited`.
    """
    table = read_table(path, "ggo-walk", VERSIONS, counts=1)
    numbers, degrees = table.values[:, 0], table.values[:, -4:]
    times = table.values[:, 1] if table.values.shape[1] > len(COLUMNS) else None
    check_angles_deg(table, degrees, FRAME_COLUMNS)
    count = sum(key.startswith("step ") for key in table.header)
    plan = tuple(_step_from_json(table, f"step {number}") for number in range(1, count + 1))
    jumps = np.diff(numbers, prepend=1.0)
    for row in np.flatnonzero(((jumps != 0.0) & (jumps != 1.0)) | (numbers > count))[:1]:
        line = table.first_line + row
        raise InputError(f"{path}, line {line}: step {numbers[row]:g} does not follow the header's steps")
    gaits: list[Gait] = []
    for number in range(1, count + 1):
        rows = degrees[numbers == number]
        if len(rows) < 2:
            raise InputError(f"{path}: step {number} has {len(rows)} frames, expected at least 2")
        own = _own_times(table, times, numbers, number)
        gait = gait_from_table(table, np.radians(rows), own, BONES_BEFORE)
        said = json.loads(table.text(f"step {number}"))
        bent = bent_from(table, said[BENT_FROM]) if BENT_FROM in said else None
        name, origin = (_said(table, number, said, key, getattr(gait, key)) for key in ("name", "origin"))
        gaits.append(replace(gait, name=name, origin=origin, bent=bent))
    if not gaits:
        raise InputError(f"{path}: the header has no line '# step 1: ...'")
    limits = _limits_from_json(table) if "limits" in table.header else None
    landing_speed = table.number("landing_speed", "m/s") if "landing_speed" in table.header else None
    swing = table.header.get("first_swing", FIRST_SWING)
    if swing not in ("right", "left"):
        raise InputError(f"{path}: header 'first_swing' is {swing:.40}, neither right nor left")
    return tuple(gaits), plan, limits, landing_speed, swing, table.require_unchanged(edited)


def _said(table: Table, number: int, said: Mapping[str, object], key: str, otherwise: str) -> str:
    """The name or origin that a step states, if that is text; in older files that of the whole file counts for all."""
    text = said.get(key, otherwise)
    if not isinstance(text, str):
        raise InputError(f"{table.path}: header 'step {number}': {key} is {text!r:.40}, no text")
    return text


def _own_times(table: Table, times: Array | None, numbers: Array, number: int) -> Array | None:
    """The times of a step's frames from its first; None where they are `dt` apart.

    Raises:
        InputError: where times do not grow, or the step does not begin at the time at which the one before ended,
            naming the line.
    """
    if times is None:
        return None
    (rows,) = np.nonzero(numbers == number)
    begins = 0.0 if number == 1 else times[rows[0] - 1]
    if times[rows[0]] != begins:
        line = table.first_line + rows[0]
        raise InputError(f"{table.path}, line {line}: {TIME_COLUMN} is {times[rows[0]]:g}, expected {begins:g}")
    own = times[rows] - begins
    for row in np.flatnonzero(np.diff(own) <= 0.0)[:1].tolist():
        line, now, after = table.first_line + rows[row + 1], times[rows[row + 1]], times[rows[row]]
        raise InputError(f"{table.path}, line {line}: {TIME_COLUMN} is {now:g}, expected more than {after:g}")
    evenly = np.arange(len(own)) * table.number("dt", "s")
    return None if np.abs(own - evenly).max() <= SAME_TIME else own


def _limits_to_json(limits: JointLimits) -> dict[str, float]:
    """Each limit in degrees, by its name with the unit behind it."""
    return {key: round(math.degrees(getattr(limits, name)), LIMIT_DIGITS) for name, key in _LIMIT_KEYS.items()}


def _limit_key(name: str) -> str:
    if name.endswith("_speed"):
        return f"{name}_deg_s"
    return f"{name}_deg_s2" if name.endswith("_acceleration") else f"{name}_deg"


_LIMIT_KEYS = {field.name: _limit_key(field.name) for field in fields(JointLimits)}


def _limits_from_json(table: Table) -> JointLimits:
    text = table.text("limits")
    try:
        given = json.loads(text)
        return JointLimits(**{name: math.radians(as_number(given[key], key)) for name, key in _LIMIT_KEYS.items()})
    except (InputError, KeyError) as error:
        problem = f"'limits' lacks {error}" if isinstance(error, KeyError) else f"'limits': {error}"
        raise InputError(f"{table.path}: header {problem}") from error
    except (ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{table.path}: header 'limits' does not describe joint limits: {text:.60}") from error


def _step_to_json(step: Step) -> dict[str, object]:
    return {
        "foothold_m": step.foothold,
        "obstacles_m": [_obstacle_to_json(obstacle) for obstacle in step.obstacles],
        "gaps_m": [_gap_to_json(gap) for gap in step.gaps],
        "shank_angle_deg": None if step.shank_angle is None else math.degrees(step.shank_angle),
        "ground_edges_m": step.ground.edges,
        "ground_heights_m": step.ground.heights,
        **({"ground_slopes_deg": [math.degrees(slope) for slope in step.ground.slopes]} if step.ground.slopes else {}),
        "end_frame_deg": None if step.end_frame is None else [math.degrees(angle) for angle in step.end_frame],
        **({"lift_m": step.lift} if step.lift else {}),
    }


def _obstacle_to_json(obstacle: Obstacle) -> list[float]:
    numbers = list(astuple(obstacle))
    return numbers if obstacle.base else numbers[:5] if obstacle.is_uncertain else numbers[:3]


def _gap_to_json(gap: Gap) -> list[float]:
    numbers = list(astuple(gap))
    return numbers if gap.unknown else numbers[:3] if gap.edge_std else numbers[:2]


def _needs_version_3(step: Step) -> bool:
    """Whether a step has what older readers do not know, see `VERSIONS`."""
    gaps = any(gap.edge_std or gap.unknown for gap in step.gaps)
    return bool(step.ground.slopes) or gaps or any(obstacle.base for obstacle in step.obstacles)


def _step_from_json(table: Table, key: str) -> Step:
    text = table.text(key)
    try:
        given = json.loads(text)
        angle, frame = given["shank_angle_deg"], given["end_frame_deg"]
        return Step(
            foothold=given["foothold_m"],
            obstacles=tuple(Obstacle(*numbers) for numbers in given["obstacles_m"]),
            gaps=tuple(Gap(*numbers) for numbers in given["gaps_m"]),
            shank_angle=None if angle is None else math.radians(as_number(angle, "shank_angle_deg")),
            ground=Ground(
                tuple(given["ground_edges_m"]),
                tuple(given["ground_heights_m"]),
                tuple(np.radians(as_array(given.get("ground_slopes_deg", ()), "ground_slopes_deg", (None,))).tolist()),
            ),
            lift=given.get("lift_m", 0.0),
            end_frame=None if frame is None else tuple(np.radians(as_array(frame, "end_frame_deg", (4,))).tolist()),
        )
    except (InputError, KeyError) as error:
        problem = f"{key!r} lacks {error}" if isinstance(error, KeyError) else f"{key!r}: {error}"
        raise InputError(f"{table.path}: header {problem}") from error
    except (ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{table.path}: header {key!r} does not describe a step: {text:.60}") from error


def described(path: PathLike, key: str) -> str | None:
    """A line of a walk file's header, see `write_walk`; None where it has none of that key.

    Raises:
        InputError: where the file is no walk file.
    """
    return read_table(path, "ggo-walk", VERSIONS, counts=1).header.get(key)
