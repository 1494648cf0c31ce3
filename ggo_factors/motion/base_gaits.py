"""Several base gaits of one walker: one for each leg, and others beside them for stairs up and down."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.gait import (
    CLOSED,
    FRAME_COLUMNS,
    PAPER_MODEL,
    SPREAD_COLUMNS,
    Gait,
    check_angles_deg,
    gait_from_table,
    gait_header,
    swap_roles,
)
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.recorded import GROUNDS, recorded_from
from ggo_factors.support.csv_table import read_table, write_table
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_count, as_instance, short_text

Leg = Literal["right", "left"]
"""A leg by name; of a base gait the one that swings."""
Kind = Literal["level", "up", "down", "first up", "first down", "last up", "last down"]
"""The kind of ground that a base gait was walked on, as `GROUNDS` says."""
AFTER_FIRST: Mapping[Kind, Kind] = {"first up": "up", "first down": "down"}
"""The kind of the steps that follow the first step of a flight."""
ENDS: Mapping[Kind, tuple[Kind, str]] = {
    "first up": ("up", "first_step"),
    "first down": ("down", "first_step"),
    "last up": ("up", "last_step"),
    "last down": ("down", "last_step"),
}
"""Ends of flights: the kind of the gait from stair to stair, and the name there of the one for this end."""

LEGS: tuple[Leg, Leg] = ("left", "right")
BOTH = "both"
"""The leg that swings in a gait for both, as files say it."""
STAIR = 0.05
"""A base gait that lands by more than this above or below its supporting foot, in [m], walks stairs: half of the lowest
risers that are built, and more than what a recording of level ground is off by."""
COLUMNS = ("gait", *FRAME_COLUMNS)
"""Columns of a file of base gaits: the number of the gait from 1, and the angles of a frame in degrees."""
SPREAD_TOO = (*COLUMNS, *SPREAD_COLUMNS)
VERSIONS = (COLUMNS, SPREAD_TOO, SPREAD_TOO)
"""Those of its versions 1 to 3: from 2 on with the spread of recorded strides, 0 for a gait that is no mean of such;
in 3 with first and last steps of flights."""


def other_leg(leg: Leg) -> Leg:
    """The leg that swings in the step after one in which `leg` swings."""
    return "left" if leg == "right" else "right"


def as_leg(leg: str, name: str) -> Leg:
    """`leg`, if it is one.

    Raises:
        InputError: naming the argument where it is neither `"right"` nor `"left"`.
    """
    for known in LEGS:
        if leg == known:
            return known
    raise InputError(f"{name}: {leg!r:.40} is neither 'right' nor 'left'")


@dataclass(frozen=True, eq=False)
class BaseGaits:
    """Base gaits of one walker; each step of a walk bends the one that fits its swinging leg and its ground.

    A step from level ground onto a stair bends the `Gait.first_step` of the gait for stairs, where that has one; a step
    from a stair to feet together on level ground its `Gait.last_step`.

    All have the same legs and the same time step: where theirs differ, each is resampled to a step of dt, the mean of
    the two level gaits' time per motion, in the whole number of frames whose duration is nearest to its own; that
    changes its duration by at most dt / 2. A pair that closes (each leg's step begins where the other's ends) still
    does.

    Attributes:
        left: the step in which the left leg swings, on level ground.
        right: the step in which the right leg swings.
        up: a step up stairs: one gait for both legs, or a pair for each; None where steps up bend the level gaits.
        down: the same down.

    Raises:
        InputError: where the legs' lengths differ, or `up` and `down` do not lead there.
    """

    left: Gait
    right: Gait
    up: Gait | BaseGaits | None = None
    down: Gait | BaseGaits | None = None

    def __post_init__(self) -> None:
        for name in LEGS:
            as_instance(getattr(self, name), name, Gait)
        pairs = dict(self._pairs())
        for kind, pair in pairs.items():
            for leg, gait in zip(LEGS, pair, strict=True):
                if gait.model != self.left.model:
                    raise InputError(
                        f"{kind}: its gait for the {leg} leg has other leg lengths than the left level one"
                    )
        for kind, sign in (("up", 1.0), ("down", -1.0), ("first up", 1.0), ("first down", -1.0)):
            for gait in pairs.get(kind, ()):
                if gait.model is not None and not sign * landing_height(gait) > STAIR:
                    height, way = landing_height(gait), kind.rpartition(" ")[2]
                    raise InputError(f"{kind}: {gait.name!r} lands at {height:+.3f} m, which is no step {way} stairs")
                apart = 0.0 if gait.model is None or kind in ("up", "down") else gait.endpoints()[0, 1]
                if abs(apart) > STAIR:
                    raise InputError(f"{kind}: {gait.name!r} begins with a foot at {apart:+.3f} m, not on level ground")
        for kind in ("last up", "last down"):
            for gait in pairs.get(kind, ()):
                if gait.model is not None and abs(height := landing_height(gait)) > STAIR:
                    raise InputError(f"{kind}: {gait.name!r} lands at {height:+.3f} m, which is not on level ground")
        every = self.gaits
        if any(gait.dt != every[0].dt or gait.paced is not None for gait in every):
            motions = len(self.left) + len(self.right) - 2
            self._resample(pairs, (self.left.duration + self.right.duration) / motions)

    def _pairs(self) -> Iterator[tuple[str, tuple[Gait, Gait]]]:
        """Left and right gait of each kind of ground that has its own."""
        yield "level", (self.left, self.right)
        for kind in ("up", "down"):
            own = getattr(self, kind)
            if isinstance(own, BaseGaits):
                if own.up is not None or own.down is not None:
                    raise InputError(f"{kind}: it has gaits for stairs beside its own; a pair of legs is expected")
                yield kind, (own.left, own.right)
            elif own is not None:
                yield kind, (as_instance(own, kind, Gait),) * 2
        yield from self._flight_ends()

    def _flight_ends(self) -> Iterator[tuple[str, tuple[Gait, Gait]]]:
        """First and last steps of flights, left and right; what one leg's gait lacks, the other's has for both."""
        # Gaits for stairs may stand alone, without level ones.
        alone = "up" if landing_height(self.left, self.left.model or PAPER_MODEL) > 0.0 else "down"
        for end, (kind, name) in ENDS.items():
            beside = getattr(self, kind)
            if beside is None and kind == alone:
                beside = self
            if beside is not None:
                pair = (beside.left, beside.right) if isinstance(beside, BaseGaits) else (beside, beside)
                left, right = (getattr(gait, name) for gait in pair)
                if left is not None or right is not None:
                    yield end, (left or right, right or left)

    def _resample(self, pairs: dict[str, tuple[Gait, Gait]], dt: float) -> None:
        made = _with_flight_ends({kind: _at_rate(*pair, dt) for kind, pair in pairs.items()})
        for leg, gait in zip(LEGS, made["level"], strict=True):
            object.__setattr__(self, leg, gait)
        for kind in ("up", "down"):
            object.__setattr__(self, kind, _one_or_both(made.get(kind)))

    def __repr__(self) -> str:
        names = ", ".join(f"{kind} {short_text(pair[0].name)}" for kind, pair in self._pairs())
        return f"BaseGaits({names}, {self.left.dt:.4g} s apart)"

    def _repr_html_(self) -> str:
        from ggo_factors.motion.cards import base_gaits_card  # only here: nothing but a notebook needs it

        named: dict[str, Gait] = {}
        for kind, (left, right) in self._pairs():
            one = left is right
            named |= (
                {f"{kind}, both legs": left} if one else {f"{kind}, left swings": left, f"{kind}, right swings": right}
            )
        facts = {name: f"{gait.name}: {len(gait)} frames, {gait.duration:.4g} s" for name, gait in named.items()}
        frames = {name: gait.frames for name, gait in named.items()}
        return base_gaits_card(frames, self.model, {"time step": f"{self.left.dt:.4g} s"} | facts)

    @property
    def model(self) -> LegModel | None:
        """The legs, if known."""
        return self.left.model

    @property
    def gaits(self) -> tuple[Gait, ...]:
        """All gaits, left and right of each kind of ground in turn; one for both legs occurs twice."""
        return tuple(gait for _, pair in self._pairs() for gait in pair)

    def gait(self, kind: Kind, leg: Leg) -> Gait:
        """The gait for a kind of ground in which `leg` swings; the level one where the kind has none of its own."""
        own = dict(self._pairs())
        return own.get(kind, own["level"])[LEGS.index(leg)]

    def kind_for(self, rise: float, model: LegModel, start: Array | None = None, closes: bool = False) -> Kind:
        """The kind of the gait for a step that lands `rise` above its supporting foot, in [m], for these legs.

        Up, or down, where it lands higher than half way between level ground and where that gait lands; the first
        step up, or down, where `start`, the frame that the step starts in, shape (4,) in [rad], has both feet on level
        ground; the last one where it starts on a stair and `closes`, with the feet together.
        """
        own = dict(self._pairs())
        kinds: list[Kind] = ["up", "down"]
        behind = math.nan if start is None else float(model.endpoint(start)[1])
        last: Kind = "last up" if behind < 0.0 else "last down"
        if closes and abs(rise) < STAIR < abs(behind) and last in own:
            return last
        if abs(behind) < STAIR:
            kinds = ["first up", "first down", *kinds]
        for kind in kinds:
            height = landing_height(own[kind][0], model) if kind in own else 0.0
            if height and rise / height > 0.5:
                return kind
        return "level"

    def changed(self, change: Callable[[Gait], Gait]) -> BaseGaits:
        """The same with each gait changed, once where it is for both legs."""
        made: dict[str, tuple[Gait, Gait]] = {}
        for kind, (left, right) in self._pairs():
            first = change(left)
            made[kind] = first, (first if right is left else change(right))
        return _joined(made)

    def legs(self, model: LegModel | None = None) -> LegModel:
        """`model` if given, else the gaits' own; errors as for `Gait.legs`."""
        return self.left.legs(model)

    def resampled(self, frames: int) -> BaseGaits:
        """The same at another rate: as many frames as make a level step of mean duration, the others by their duration.

        Raises:
            InputError: where `frames` is below 2.
        """
        motions = as_count(frames, "frames", 2) - 1
        return self.at((self.left.duration + self.right.duration) / 2.0 / motions)

    def at(self, dt: float) -> BaseGaits:
        """The same with its frames `dt` apart in [s], each gait's duration to the nearest whole number of them."""
        made = replace(self)
        made._resample(dict(made._pairs()), dt)
        return made

    def save(self, path: PathLike) -> None:
        """Write the gaits as CSV, angles in degrees, whole or not at all.

        The form is `# ggo-base-gaits 1`, or 2 with the spread of the strides where gaits are means of recorded ones,
        or 3 with first and last steps of flights.

        Raises:
            InputError: where the file cannot be written.
        """
        header, rows = gait_header(self.left), list[Array]()
        del header["name"], header["origin"]
        version = 1 if all(gait.recorded is None for gait in self.gaits) else 2
        if any(True for _ in self._flight_ends()):
            version = 3
        for kind, (left, right) in self._pairs():
            one = left is right
            for leg, gait in ((BOTH, left),) if one else zip(LEGS, (left, right), strict=True):
                spread = np.zeros((len(gait), len(VERSIONS[version - 1]) - len(COLUMNS)))
                said: dict[str, object] = {"ground": kind, "swing": leg, "name": gait.name, "origin": gait.origin}
                said["fingerprint"] = gait.fingerprint
                if gait.recorded is not None:
                    spread = np.degrees(gait.recorded.spread_at(len(gait)))
                    said["strides"] = gait.recorded.strides
                rows.append(np.column_stack([np.full(len(gait), len(rows) + 1), np.degrees(gait.frames), spread]))
                header[f"gait {len(rows)}"] = json.dumps(said)
        columns = VERSIONS[version - 1]
        write_table(path, "ggo-base-gaits", header, columns, np.concatenate(rows), counts=1, version=version)


def load_base_gaits(path: PathLike, *, edited: bool = False) -> BaseGaits:
    """Read base gaits that `BaseGaits.save` wrote.

    Args:
        path: the file.
        edited: take a file whose numbers were changed after it was written.

    Raises:
        InputError: naming the file, the line and the value that is wrong; where numbers were changed.
    """
    table = read_table(path, "ggo-base-gaits", VERSIONS, counts=1)
    check_angles_deg(table, table.values[:, 1:5], FRAME_COLUMNS)
    found: dict[tuple[str, str], Gait] = {}
    count = sum(key.startswith("gait ") for key in table.header)
    for row in np.flatnonzero((table.values[:, 0] > count) | (table.values[:, 0] < 1.0))[:1]:
        line = table.first_line + row
        raise InputError(f"{path}, line {line}: the header says nothing of gait {table.values[row, 0]:g}")
    for number in range(1, count + 1):
        key = f"gait {number}"
        rows = table.values[table.values[:, 0] == number, 1:]
        if len(rows) < 2:
            raise InputError(f"{path}: {key} has {len(rows)} frames, expected at least 2")
        try:
            said = json.loads(table.text(key))
            kind, swing, name, origin = (str(said[what]) for what in ("ground", "swing", "name", "origin"))
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            raise InputError(f"{path}: header {key!r} does not describe a gait: {table.text(key):.60}") from error
        gait = replace(gait_from_table(table, np.radians(rows[:, :4]), None), name=name, origin=origin)
        if "strides" in said and rows.shape[1] > 4:
            gait = replace(gait, recorded=recorded_from(table, said, rows[:, 4:]))
        for leg in LEGS if swing == BOTH else (swing,):
            if (kind, leg) in found:
                raise InputError(f"{path}: header {key!r}: there is a gait for {kind!r} and the {leg} leg before it")
            found[kind, leg] = gait
    try:
        base = _of(found)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    notes = table.require_unchanged(edited)
    return base.changed(lambda gait: replace(gait, notes=notes)) if notes else base


def _of(found: dict[tuple[str, str], Gait]) -> BaseGaits:
    """The gaits of a file by their ground and leg.

    Raises:
        InputError: where one is missing, of an unknown kind, or leads elsewhere.
    """
    kinds = {"level"} | {kind for kind, _ in found}
    wanted = {(kind, leg) for kind in kinds & {*GROUNDS} for leg in LEGS}
    if odd := sorted(wanted ^ found.keys()):
        raise InputError(
            f"expected a gait of each leg for level ground, and for each other ground both or none; "
            f"missing or unknown: {', '.join(f'{kind} {leg}' for kind, leg in odd)}"
        )
    return _joined({kind: (found[kind, "left"], found[kind, "right"]) for kind in kinds})


def _joined(pairs: dict[str, tuple[Gait, Gait]]) -> BaseGaits:
    """Base gaits of pairs by their kind of ground."""
    made = _with_flight_ends(pairs)
    left, right = made["level"]
    up, down = (_one_or_both(made.get(kind)) for kind in ("up", "down"))
    return BaseGaits(left, right, up=up, down=down)


def with_flight_step(gait: Gait, name: str, own: Gait) -> Gait:
    """A gait for stairs with another `first_step` or `last_step`, whichever is named."""
    return replace(gait, first_step=own) if name == "first_step" else replace(gait, last_step=own)


def _with_flight_ends(pairs: Mapping[str, tuple[Gait, Gait]]) -> dict[str, tuple[Gait, Gait]]:
    """Pairs by their kind of ground, first and last steps of flights within the gaits for the stairs between them."""
    made = {kind: pair for kind, pair in pairs.items() if kind not in ENDS}
    for end, (kind, name) in ENDS.items():
        if end in pairs:
            beside = kind if kind in made else "level"
            pair = [with_flight_step(gait, name, own) for gait, own in zip(made[beside], pairs[end], strict=True)]
            one = made[beside][0] is made[beside][1] and pairs[end][0] is pairs[end][1]
            made[beside] = pair[0], (pair[0] if one else pair[1])
    return made


def _one_or_both(pair: tuple[Gait, Gait] | None) -> Gait | BaseGaits | None:
    if pair is None:
        return None
    return pair[0] if pair[0] is pair[1] else BaseGaits(*pair)


def both(base: Gait | BaseGaits) -> BaseGaits:
    """Base gaits as given, or one gait for both legs and every step.

    Raises:
        InputError: where it is neither.
    """
    return base if isinstance(base, BaseGaits) else BaseGaits(as_instance(base, "base", Gait), base)


def landing_height(gait: Gait, model: LegModel | None = None) -> float:
    """How far a gait lands above its supporting foot in [m]."""
    return float(gait.legs(model).endpoint(gait.frames[-1])[1])


def _at_rate(left: Gait, right: Gait, dt: float) -> tuple[Gait, Gait]:
    """A pair of gaits with frames `dt` apart in [s]."""
    if left.dt == dt and right.dt == dt and left.paced is None and right.paced is None:
        return left, right
    evenly = [gait if gait.paced is None else gait.resampled(len(gait)) for gait in (left, right)]
    counts = [max(2, round(gait.duration / dt) + 1) for gait in evenly]
    first, second = evenly
    closes = (
        np.abs(swap_roles(first.frames[-1]) - second.frames[0]).max() <= CLOSED
        and np.abs(swap_roles(second.frames[-1]) - first.frames[0]).max() <= CLOSED
    )
    if left is right or not closes:
        made = [replace(gait.resampled(count), dt=dt) for gait, count in zip(evenly, counts, strict=True)]
        return made[0], (made[0] if left is right else made[1])
    from scipy.interpolate import CubicSpline  # here, since it takes longer to import than all the rest

    cycle = np.concatenate([first.frames, swap_roles(second.frames[1:-1]), first.frames[:1]])
    times = np.concatenate([first.times, first.duration + second.times[1:]])
    spline = CubicSpline(times, cycle, bc_type="periodic")
    before = spline(np.linspace(0.0, first.duration, counts[0]))
    after = swap_roles(spline(np.linspace(first.duration, times[-1], counts[1])))
    after[0], after[-1] = swap_roles(before[-1]), swap_roles(before[0])
    return replace(first, frames=before, dt=dt), replace(second, frames=after, dt=dt)
