"""An import read back from its file."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from ggo_factors.check.report import violations_from
from ggo_factors.errors import InputError
from ggo_factors.motion.flight_rows import FLIGHT_STEPS
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import Foot, LegModel
from ggo_factors.motion.recorded import BentFrom, Recorded
from ggo_factors.recording.report import KIND, ImportReport
from ggo_factors.recording.strides.cut_strides import Stride
from ggo_factors.recording.strides.steps import Step
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_instance, as_tuple_of
from ggo_factors.support.plain import read_array, read_number, read_plain


def load_import_report(path: PathLike) -> ImportReport:
    """Read an import that `ImportReport.save` wrote; the recording itself is not needed.

    Raises:
        InputError: naming the file and what is wrong with it.
    """
    given = read_plain(path, KIND)
    try:
        kinds = {each.name: str(each.type) for each in fields(ImportReport)}
        return ImportReport(**{name: _read(name, kind, given[name]) for name, kind in kinds.items()})
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: is no saved import: {type(error).__name__}: {error}") from error


def _read(name: str, kind: str, value: Any) -> Any:
    """A field of a report by its type; errors as Python has them."""
    if kind == "Gait":
        return _gait(value)
    if kind == "Array":
        return read_array(value, name, 2)
    if kind == "Mapping[str, Array]":
        return {leg: read_array(row, name, 1 if name == "heel_strikes" else 2) for leg, row in value.items()}
    if kind in ("tuple[Step, ...]", "tuple[Stride | Step, ...]"):
        return tuple(map(_item, value))
    if kind == "tuple[Violation, ...]":
        return violations_from(value)
    if kind == "tuple[str, ...]":
        return as_tuple_of(value, name, str)
    if kind == "tuple[float, float]":
        mean, sd = value
        return read_number(mean, name), read_number(sd, name)
    if kind == "Mapping[str, float]":
        return {key: read_number(number, name) for key, number in value.items()}
    if kind == "Mapping[str, Mapping[str, float]]":
        return {key: {what: read_number(number, name) for what, number in row.items()} for key, row in value.items()}
    if kind in ("float", "float | None"):
        return None if value is None and kind != "float" else read_number(value, name)
    if kind in ("int", "int | None"):
        return None if value is None and kind != "int" else as_instance(value, name, int)
    return as_instance(value, name, str)


def _gait(given: dict[str, Any]) -> Gait:
    model, paced, recorded, bent = (given.get(name) for name in ("model", "paced", "recorded", "bent"))
    first_step, last_step = (None if given.get(key) is None else _gait(given[key]) for key in FLIGHT_STEPS)
    return Gait(
        given["frames"],
        given["dt"],
        given["name"],
        given["origin"],
        None if model is None else LegModel(**{**model, "foot": Foot(**model["foot"])}),
        tuple(given["notes"]),
        None if paced is None else read_array(paced, "paced", 1),
        None if recorded is None else Recorded(**recorded | {"spread": read_array(recorded["spread"], "spread", 2)}),
        None if bent is None else BentFrom.from_json(bent),
        first_step,
        last_step,
    )


def _item(given: dict[str, Any]) -> Stride | Step:
    made: dict[str, Any] = {}
    for name, value in given.items():
        if name in ("leg", "activity", "reason"):
            made[name] = as_instance(value, name, str)
        else:
            made[name] = read_array(value, name, 2) if name in ("angles", "frames") else read_number(value, name)
    return (Step if "frames" in given else Stride)(**made)
