"""Which logged values make the four angles of the legs: a TOML map, or a preset for names that are widely used."""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.presets import PRESETS, is_leg, resolve
from ggo_factors.support.files import PathLike, read_text
from ggo_factors.support.inputs import as_number, as_tuple_of

ANGLES = ("alpha_right", "beta_right", "alpha_left", "beta_left")
"""The four angles of a joint map: thigh (alpha) and knee (beta) of each leg."""
UNITS = ("rad", "deg")
"""Units that logged angles may be in."""


@dataclass(frozen=True)
class JointMap:
    """Each of the four angles as a linear combination of logged values.

    Attributes:
        terms: for each of `ANGLES` (thigh from the vertical, forward positive; knee flexion, positive) the logged
            values by name and the factor of each.
        units: ``"rad"`` or ``"deg"``, the unit of the logged values; None where it is left open.
        origin: where the map comes from.
        notes: what the map could not take into account.
        offsets: what a value reads where it should be 0, by name, in [rad]: taken off before the factors.
        fixed: values that stay as they are while a robot plays a gait, by name, in [rad]: an ankle, a pelvis. Only an
            export needs them.
        order: in which order a robot wants the values of an export; that of the terms, then of `fixed`, if empty.

    Raises:
        InputError: where an angle is missing or unknown, has no term, a factor is not a finite number but 0, or offsets
            or order name what the map does not.
    """

    terms: Mapping[str, Mapping[str, float]]
    units: str | None = None
    origin: str = "joint map"
    notes: tuple[str, ...] = ()
    offsets: Mapping[str, float] = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    order: tuple[str, ...] = ()

    if TYPE_CHECKING:
        # For type checkers: what is made a tuple when it is made may be any list.
        def __init__(
            self,
            terms: Mapping[str, Mapping[str, float]],
            units: str | None = None,
            origin: str = "joint map",
            notes: Iterable[str] = (),
            offsets: Mapping[str, float] = ...,
            fixed: Mapping[str, float] = ...,
            order: Iterable[str] = (),
        ) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", as_tuple_of(self.notes, "notes", str))
        if not isinstance(self.terms, Mapping):
            raise InputError(f"{self.origin}: expected an angle: {{name: factor}} table, got {self.terms!r:.60}")
        for angle in self.terms:
            if angle not in ANGLES:
                raise InputError(f"{self.origin}: unknown angle {angle!r}; a map has {', '.join(ANGLES)}")
        checked: dict[str, Mapping[str, float]] = {}
        for angle in ANGLES:
            row = self.terms.get(angle)
            if not isinstance(row, Mapping) or not row:
                raise InputError(
                    f"{self.origin}: [{angle}] is missing or empty; it names logged values and their factors"
                )
            for name, value in row.items():
                if isinstance(value, bool) or not isinstance(value, (int, float)):
                    raise InputError(f"{self.origin}: [{angle}] {name}: expected a number, got {value!r:.60}")
                if as_number(value, f"{self.origin}: [{angle}] {name}") == 0.0:
                    raise InputError(f"{self.origin}: [{angle}] {name}: a factor of 0 leaves the value out")
            checked[angle] = MappingProxyType({str(name): float(value) for name, value in row.items()})
        object.__setattr__(self, "terms", MappingProxyType(checked))
        if self.units is not None and self.units not in UNITS:
            raise InputError(f"{self.origin}: units: expected 'rad' or 'deg', got {self.units!r:.40}")
        for table in ("fixed", "offsets"):
            object.__setattr__(self, table, MappingProxyType(self._angles_by_name(table)))
        all_names = (*self.names, *(name for name in self.fixed if name not in self.names))
        if odd := [name for name in self.offsets if name not in all_names]:
            raise InputError(f"{self.origin}: [offsets] {listed(odd)}: no value of this map")
        if self.order and sorted(self.order) != sorted(all_names):
            raise InputError(f"{self.origin}: order: expected each of {listed(all_names)} once, got {self.order!r:.80}")
        object.__setattr__(self, "order", tuple(self.order) or all_names)

    def _angles_by_name(self, table: str) -> dict[str, float]:
        rows = getattr(self, table)
        if not isinstance(rows, Mapping):
            raise InputError(f"{self.origin}: {table}: expected a table of names and numbers, got {rows!r:.60}")
        return {str(name): as_number(value, f"{self.origin}: [{table}] {name}") for name, value in rows.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """The logged values that the map needs, each once."""
        return tuple(dict.fromkeys(name for angle in ANGLES for name in self.terms[angle]))

    def check(self, names: Sequence[str], source: str) -> None:
        """Make sure that a log has all values that the map needs.

        Args:
            names: the values there are.
            source: the log, for the message.

        Raises:
            LogError: naming the value that is missing, the ones there are, and the likeliest one meant.
        """
        missing = [name for name in self.names if name not in names]
        if not missing:
            return
        near = [(name, difflib.get_close_matches(name, names, 1, 0.6)) for name in missing]
        meant = "".join(f"; did you mean {match[0]!r} for {name!r}?" for name, match in near[:2] if match)
        raise LogError(f"{source}: no value named {', '.join(map(repr, missing))}; there are {listed(names)}{meant}")


def load_joint_map(path: PathLike) -> JointMap:
    """Read a map from TOML: `units`, and a table of names and factors for each of the four angles.

    For a robot also tables `offsets` and `fixed` of names and values in these units, and `order`, a list of names.

    A path such as ``left.hip`` may stand bare or in quotes; a name with ``/``, ``[`` or ``:`` needs quotes.

    Raises:
        InputError: naming the file and what is wrong in it.
    """
    try:
        data = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f"{path}: not valid TOML: {error}; names with other characters than A-Z, a-z, 0-9, _ and - need quotes"
        ) from error
    units = data.pop("units", None)
    if units is not None and not isinstance(units, str):
        raise InputError(f"{path}: units: expected 'rad' or 'deg', got {units!r:.40}")
    order = data.pop("order", [])
    if not isinstance(order, list) or not all(isinstance(name, str) for name in order):
        raise InputError(f"{path}: order: expected a list of names, got {order!r:.60}")
    for angle, row in data.items():
        if isinstance(row, dict):
            data[angle] = dict(_flat(row))
    if units is None and (data.get("offsets") or data.get("fixed")):
        raise InputError(f"{path}: units: say 'rad' or 'deg', which [offsets] and [fixed] are in")
    offsets, fixed = (_in_radians(data.pop(table, {}), units, f"{path}: [{table}]") for table in ("offsets", "fixed"))
    return JointMap(data, units, str(path), offsets=offsets, fixed=fixed, order=tuple(order))


def _in_radians(row: Any, unit: str | None, what: str) -> Mapping[str, float]:
    if not isinstance(row, Mapping):
        raise InputError(f"{what}: expected names and numbers, got {row!r:.60}")
    scale = math.pi / 180.0 if unit == "deg" else 1.0
    return {name: as_number(value, f"{what} {name}") * scale for name, value in row.items()}


def joint_map(joints: PathLike | JointMap | None, names: Sequence[str], source: str) -> JointMap:
    """The map to use for a log that holds `names`: a given one, a preset by its name, or a TOML file.

    Args:
        joints: a `JointMap`, the name of a preset, or the path of a TOML file.
        names: the logged values there are.
        source: the log, for messages.

    Raises:
        InputError: where the file cannot be read or is no map.
        LogError: where the log lacks a value, or `joints` is None (with a suggestion).
    """
    if joints is None:
        raise LogError(f"{source}: joints= is needed: which value is which joint? {suggestion(names)}")
    if isinstance(joints, JointMap):
        chosen = joints
    elif str(joints) in PRESETS:
        chosen = preset_map(str(joints), names, source)
    else:
        chosen = read_map(joints)
    chosen.check(names, source)
    return chosen


def read_map(joints: PathLike) -> JointMap:
    """The map in a TOML file; where `joints` looks like no file, the message names the presets.

    Raises:
        InputError: naming the file and what is wrong in it.
    """
    try:
        return load_joint_map(joints)
    except InputError as error:
        if re.fullmatch(r"[\w-]+", str(joints)):
            raise InputError(f"{error}; the presets are {', '.join(PRESETS)}") from error
        raise


def suggestion(names: Sequence[str]) -> str:
    """What to give as the map for a log that holds `names`, in one line."""
    there = f"there are {listed(sorted(names, key=lambda name: not is_leg(name)))}"
    fitting = [name for name in PRESETS if not resolve(name, names)[1]]
    if fitting:
        return f"{there}: the names fit {' or '.join(f'joints={name!r}' for name in fitting)}"
    return (
        f'{there}; give joints= a MAP.toml ([beta_right], below it "NAME_OF_THE_RIGHT_KNEE" = 1.0; the others alike) '
        f"or a preset ({', '.join(PRESETS)})"
    )


def listed(names: Sequence[str], between: str = ", ", room: int = 100) -> str:
    """Names in one line of some `room` characters, the first ones of them; at least one."""
    shown: list[str] = []
    for name in names:
        if shown and len(between.join([*shown, name])) > room:
            break
        shown.append(name if len(name) <= room else f"{name[: room - 3]}...")
    more = f" and {len(names) - len(shown)} more" if len(names) > len(shown) else ""
    return (between.join(shown) or "none") + more


def preset_map(preset: str, names: Sequence[str], source: str) -> JointMap:
    """The map of a preset for a log that holds `names`.

    Raises:
        LogError: where a value that the preset needs is not there, or two could be meant.
    """
    terms, missing, notes = resolve(preset, names)
    if missing:
        lacking = "none of the angles" if set(missing) == set(ANGLES) else f"no {listed(missing, ', no ')}"
        raise LogError(f"{source}: preset {preset!r} finds {lacking}; {suggestion(names)}")
    return JointMap(terms, None, f"preset {preset}", tuple(notes))


def _flat(row: Mapping[str, Any], before: str = "") -> Iterable[tuple[str, Any]]:
    """A bare `left.hip = 1.0` is read by TOML as a table in a table: put it together again."""
    for key, value in row.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value
