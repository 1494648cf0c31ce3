"""A gait: frames of joint angles of one step, at a fixed rate; in memory and as CSV."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.flight_rows import FLIGHT_STEPS, FlightRows, flight_rows
from ggo_factors.motion.leg_model import Bones, Foot, LegModel
from ggo_factors.motion.played import Played
from ggo_factors.motion.recorded import (
    BENT_FROM,
    BentFrom,
    Recorded,
    bent_from,
    bent_line,
    fingerprint_of,
    header_json,
    recorded_from,
)
from ggo_factors.support.csv_table import Table, read_table, write_table
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import (
    ANGLE_LIMIT_RAD,
    Array,
    as_angles,
    as_array,
    as_count,
    as_instance,
    as_number,
    as_tuple_of,
    short_text,
)

FRAME_COLUMNS = ("alpha1_deg", "beta1_deg", "alpha2_deg", "beta2_deg")
"""Columns of a gait file: the angles of a frame in degrees."""
TIME_COLUMN = "t_s"
"""First column from version 2 on: the time of each frame in [s]. In version 2 they are not evenly apart."""
SPREAD_COLUMNS = tuple(f"sd_{column}" for column in FRAME_COLUMNS)
"""Last columns of version 3: standard deviation of the recorded strides that the gait is the mean of, in degrees."""
RECORDED_COLUMNS = (TIME_COLUMN, *FRAME_COLUMNS, *SPREAD_COLUMNS)
VERSIONS = (FRAME_COLUMNS, (TIME_COLUMN, *FRAME_COLUMNS), RECORDED_COLUMNS, RECORDED_COLUMNS)
"""Columns of a gait file by its version, from 1."""

PAPER_MODEL = LegModel(thigh=0.39, shank=0.39)
"""The legs of the paper's experiments: 0.39 m and 7 kg a segment."""

RADII = ("thigh_radius", "shank_radius")
"""Numbers of the legs that a file leaves out where they are 0, so that files without them read as before."""
BONES: Bones = "lines"
"""What the bones of a gait file are that does not say so: it was made by hand, or checked against nothing yet."""
MODEL_UNITS = (
    {"thigh": "m", "shank": "m", "thigh_mass": "kg", "shank_mass": "kg"}
    | dict.fromkeys(("ankle_height", "heel", "toe"), "m")
    | dict.fromkeys(RADII, "m")
)
"""The numbers of the legs that a file's header states, and their units."""


SAME_TIME = 1e-9
"""Times no further apart than this in [s] are the same."""

SHORTEST_STEP, LONGEST_STEP = 0.1, 60.0
"""Least and largest time of a step in [s]. Sprinters take 0.2 s, the slowest patients a few seconds; beyond these
bounds `dt` is in another unit than seconds, or slipped by a factor. The step is bounded and not `dt`, since 5001 frames
of one second are as good as 51."""

FASTEST_TURN, LEAST_TURN = 20.0, 0.6
"""In less than the shortest step, the speed in [rad/s] and the turn in [rad] of a joint from its least angle to its
largest that no leg has both: 1146 degrees/s, three times the paper's knee, and 34 degrees. Frames that move less may be
a part of a step, as in a replan near its end."""

JOINED_DT = 0.1
"""Frames at most this far apart, in [s], may last longer than a step: they may be many steps joined into one gait."""

CLOSED = 1e-6
"""A gait is periodic where its last frame is its first with the roles swapped within this, in [rad]: what files and
recordings leave, far below what anyone could see."""


@dataclass(frozen=True, eq=False)
class Gait:
    """The joint angles of one step, from the start of the swing to the landing. Immutable.

    Attributes:
        frames: ``[alpha1, beta1, alpha2, beta2]`` of each frame in [rad], shape (m, 4), m >= 2.
        dt: time between two frames in [s].
        name: what to call it.
        origin: where it comes from.
        model: the legs it was recorded with or made for, if known.
        notes: what was noticed about the file that it was read from, a line each; gaits made of it keep them.
        paced: time of each frame from the first in [s], shape (m,), of a gait that was slowed where its joints would
            be too fast: frames that are not evenly apart. None where they are, `dt` from each other.
        recorded: the strides that a base gait is the mean of, if known.
        first_step: of a base gait for stairs the step from level ground onto the first stair, as a gait of its own on
            the same legs; None where none is known.
        last_step: the same of the step that brings the feet together on level ground after the last stair.
        bent: what a generated step was bent from, if known.

    Raises:
        InputError: where the shape is wrong, a value is not finite or not below 2 pi, dt is not above 0, times do not
            grow from 0, or the frames last shorter or longer than a step can.
    """

    frames: Array
    dt: float
    name: str = ""
    origin: str = ""
    model: LegModel | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)
    paced: Array | None = field(default=None, repr=False)
    recorded: Recorded | None = field(default=None, repr=False)
    bent: BentFrom | None = field(default=None, repr=False)
    first_step: Gait | None = field(default=None, repr=False)
    last_step: Gait | None = field(default=None, repr=False)

    if TYPE_CHECKING:
        # For type checkers: what is made an array or a tuple when it is made may be any list.
        def __init__(
            self,
            frames: ArrayLike,
            dt: float,
            name: str = "",
            origin: str = "",
            model: LegModel | None = None,
            notes: Iterable[str] = (),
            paced: ArrayLike | None = None,
            recorded: Recorded | None = None,
            bent: BentFrom | None = None,
            first_step: Gait | None = None,
            last_step: Gait | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "frames", as_angles(self.frames, "frames", (None, 4)))
        if len(self.frames) < 2:
            raise InputError(f"frames: a gait needs at least 2 frames, got {len(self.frames)}")
        object.__setattr__(self, "dt", as_number(self.dt, "dt", above=0.0, unit="s"))
        for name in ("name", "origin"):
            object.__setattr__(self, name, as_instance(getattr(self, name), name, str).strip())
        if self.model is not None:
            as_instance(self.model, "model", LegModel)
        object.__setattr__(self, "notes", as_tuple_of(self.notes, "notes", str))
        if self.paced is not None:
            paced = as_array(self.paced, "paced", (len(self.frames),))
            if paced[0] or not (np.diff(paced) > 0.0).all():
                raise InputError("paced: the times of the frames must grow, from 0 on")
            object.__setattr__(self, "paced", paced)
        for key in FLIGHT_STEPS:
            own = getattr(self, key)
            if own is not None and as_instance(own, key, Gait).model != self.model:
                object.__setattr__(self, key, replace(own, model=self.model))
        if not SHORTEST_STEP <= self.duration <= LONGEST_STEP:
            self._require_step_time()

    def _require_step_time(self) -> None:
        """Refuse a time step with which no leg makes these frames, see `SHORTEST_STEP` and what follows it."""
        turn = float(np.ptp(self.frames, axis=0).max())
        too_short = self.duration < SHORTEST_STEP and turn > max(FASTEST_TURN * self.duration, LEAST_TURN)
        if too_short or (self.duration > LONGEST_STEP and self.dt > JOINED_DT):
            raise InputError(
                f"dt: {self.dt:g} s makes {len(self)} frames last {self.duration:g} s, with a joint that turns by "
                f"{np.degrees(turn):.0f} degrees; a step takes {SHORTEST_STEP:g} to {LONGEST_STEP:g} s"
            )

    def __len__(self) -> int:
        return len(self.frames)

    def __repr__(self) -> str:
        legs = "no leg lengths" if self.model is None else self.model.lengths()
        apart = f"{self.dt:.4g} s apart" if self.paced is None else "slowed"
        return f"Gait({short_text(self.name)}, {len(self)} frames, {apart}, {self.duration:.4g} s, {legs})"

    def _repr_html_(self) -> str:
        from ggo_factors.motion.cards import gait_card  # only here: nothing but a notebook needs it

        facts = {
            "frames": f"{len(self)}, {f'{self.dt:.4g} s apart' if self.paced is None else 'slowed'}",
            "time": f"{self.duration:.4g} s",
            "stride": "" if self.model is None else f"{self.stride():.3f} m",
            "legs": "not known" if self.model is None else self.model.lengths(),
            "from": self.origin,
            "first step": "" if self.first_step is None else f"from level ground, {self.first_step.duration:.4g} s",
            "last step": "" if self.last_step is None else f"to feet together, {self.last_step.duration:.4g} s",
            "notes": self.notes,
        }
        return gait_card(self.name, self.frames, self.model, facts)

    @property
    def times(self) -> Array:
        """Time of each frame from the first in [s], shape (m,)."""
        return np.asarray(np.arange(len(self)) * self.dt, dtype=np.float64) if self.paced is None else self.paced

    @property
    def duration(self) -> float:
        """Time from the first frame to the last in [s]."""
        return (len(self) - 1) * self.dt if self.paced is None else float(self.paced[-1])

    @property
    def slowdown(self) -> float:
        """How many times as long as at `dt` from frame to frame it takes; 1 where it was not slowed."""
        return self.duration / ((len(self) - 1) * self.dt)

    def pace(self, frame: int) -> float:
        """How fast it goes on from a frame, as a share of `dt` from frame to frame; 1 where it was not slowed."""
        return 1.0 if self.paced is None else self.dt / float(self.paced[frame + 1] - self.paced[frame])

    @cached_property
    def fingerprint(self) -> str:
        """Digits that tell its angles from others, whatever it is called and at any pace; a file keeps them."""
        return fingerprint_of(self.frames)

    @cached_property
    def played(self) -> Played:
        """The trajectory that its joints play between the frames, as if there were no steps before and after it."""
        return Played(self.times, self.frames)

    def legs(self, model: LegModel | None = None) -> LegModel:
        """`model` if given, else the gait's own.

        Raises:
            InputError: where neither is known.
        """
        chosen = self.model if model is None else as_instance(model, "model", LegModel)
        if chosen is None:
            raise InputError(f"model: gait {self.name!r} states no leg lengths; give thigh and shank")
        return chosen

    def endpoints(self, model: LegModel | None = None) -> Array:
        """Swing ankle of each frame in [m], shape (m, 2), in the body frame.

        Raises:
            InputError: where no leg lengths are known.
        """
        return self.legs(model).endpoint(self.frames)

    def stride(self, model: LegModel | None = None) -> float:
        """How far the swing ankle travels forward over the step in [m] (paper, section V-A)."""
        path = self.endpoints(model)
        return float(path[-1, 0] - path[0, 0])

    def swapped(self) -> Gait:
        """The same motion with the roles of supporting and swinging leg exchanged."""
        return replace(self, frames=swap_roles(self.frames), recorded=None, first_step=None, last_step=None)

    def resampled(self, frames: int) -> Gait:
        """The same motion in another number of frames, evenly apart, by a cubic spline through the old ones.

        Where the step is periodic (its last frame is its first with the roles swapped), so is the spline, over both
        steps of a cycle: speeds and accelerations run on across the change of legs.

        Raises:
            InputError: where `frames` is below 2.
        """
        count = as_count(frames, "frames", 2)
        if self.paced is not None:
            evenly = self.played.at(np.linspace(0.0, self.duration, count))[0]
            return replace(self, frames=evenly, dt=self.duration / (count - 1), paced=None)
        if count == len(self):
            return self
        from scipy.interpolate import CubicSpline  # here, since it takes longer to import than all the rest

        times = np.linspace(0.0, self.duration, count)
        if np.abs(swap_roles(self.frames[-1]) - self.frames[0]).max() <= CLOSED:
            cycle = np.concatenate([self.frames, swap_roles(self.frames[1:-1]), self.frames[:1]])
            spline = CubicSpline(np.arange(len(cycle)) * self.dt, cycle, bc_type="periodic")
        else:
            spline = CubicSpline(self.times, self.frames, bc_type="natural" if len(self) < 4 else "not-a-knot")
        return replace(self, frames=spline(times), dt=self.duration / (count - 1))

    def evenly(self) -> Gait:
        """The same motion with its frames evenly apart, as a base gait has them."""
        return self if self.paced is None else self.resampled(len(self))

    def to_dataframe(self) -> Any:
        """A `pandas.DataFrame` with the time in [s] as its index and alpha1, beta1, alpha2 and beta2 in [rad].

        Raises:
            ImportError: where pandas is not installed.
        """
        from ggo_factors.support.data_frame import pandas  # only here: nothing else needs it

        pd = pandas()
        names = [column.removesuffix("_deg") for column in FRAME_COLUMNS]
        return pd.DataFrame(self.frames, pd.Index(self.times, name="time"), names)

    def save(self, path: PathLike) -> None:
        """Write the gait as CSV, angles in degrees, whole or not at all.

        The form is `# ggo-gait 1`, or 2 with a column of times where the frames are not evenly apart, or 3 with the
        spread of the strides too where it is the mean of recorded ones, or 4 with the rows of its last and its first
        step behind.

        Raises:
            InputError: where the file cannot be written.
        """
        header, columns = gait_header(self), [np.degrees(self.frames)]
        if self.bent is not None:
            header[BENT_FROM] = bent_line(self.bent)
        if self.recorded is not None:
            recorded = self.recorded
            header |= {"ground": recorded.ground, "swing": recorded.swing, "strides": str(recorded.strides)}
            columns.append(np.degrees(recorded.spread_at(len(self))))
        version = 3 if self.recorded is not None else 1 if self.paced is None else 2
        others = {key: own.evenly() for key in FLIGHT_STEPS if (own := getattr(self, key)) is not None}
        if version > 1 or others:
            columns.insert(0, self.times[:, None])
        rows = np.hstack(columns)
        if others:
            version, behind = 4, list[Array]()
            for key, own in others.items():
                said = FlightRows(own.frames, own.dt, own.name, own.origin, own.recorded)
                header[key] = said.line
                behind.insert(0, said.rows)
            without = np.zeros((len(self), len(RECORDED_COLUMNS) - rows.shape[1]))
            rows = np.vstack([np.hstack([rows, without]), *behind])
        write_table(path, "ggo-gait", header, VERSIONS[version - 1], rows, version=version)


def load_gait(path: PathLike, *, edited: bool = False) -> Gait:
    """Read a gait that `Gait.save` wrote, or one made by hand in the same form.

    Args:
        path: the file.
        edited: take a file whose numbers were changed after it was written.

    Raises:
        InputError: naming the file, the line and the value that is wrong; where numbers were changed.
    """
    table = read_table(path, "ggo-gait", VERSIONS)
    columns = VERSIONS[[len(version) for version in VERSIONS].index(table.values.shape[1])]
    angles = len(columns) % 4  # a column of times stands before those of angles
    degrees = table.values[:, angles : angles + 4]
    check_angles_deg(table, degrees, FRAME_COLUMNS)
    others = flight_rows(table)
    count = len(degrees) - sum(len(own.frames) for own in others.values())
    degrees = degrees[:count]
    times = table.values[:count, 0] if angles else None
    if times is not None and np.abs(times - np.arange(len(times)) * table.number("dt", "s")).max() <= SAME_TIME:
        times = None
    gait = gait_from_table(table, np.radians(degrees), times)
    if columns is RECORDED_COLUMNS and (not others or "strides" in table.header):
        gait = replace(gait, recorded=recorded_from(table, table.header, table.values[:count, -4:]))
    if BENT_FROM in table.header:
        gait = replace(gait, bent=bent_from(table, header_json(table, BENT_FROM)))
    made = {key: Gait(own.frames, own.dt, own.name, own.origin, recorded=own.recorded) for key, own in others.items()}
    first, last = map(made.get, FLIGHT_STEPS)
    return replace(gait, notes=table.require_unchanged(edited), first_step=first, last_step=last)


def gait_header(gait: Gait) -> dict[str, str]:
    """The header lines that describe a gait's rate, units, origin and legs."""
    header = {"dt": f"{gait.dt!r} s", "units": "deg", "name": gait.name, "origin": gait.origin}
    if gait.model is not None:
        numbers = vars(gait.model) | vars(gait.model.foot)
        stated = [key for key in MODEL_UNITS if numbers[key] or key not in RADII]
        header |= {key: f"{numbers[key]!r} {MODEL_UNITS[key]}" for key in stated}
        if gait.model.bones != BONES:
            header["bones"] = gait.model.bones
    return header


def gait_from_table(table: Table, frames: Array, paced: Array | None, bones: Bones = BONES) -> Gait:
    """A gait of `frames` in [rad] at times `paced` in [s] or evenly apart, with what the table's header says of it.

    Its bones are `bones` where the header does not say.

    Raises:
        InputError: naming the file and the header line that is wrong.
    """
    if table.header.get("units", "deg") != "deg":
        raise InputError(f"{table.path}: header 'units' is {table.header['units']!r}; this format knows 'deg'")
    lacking = {"thigh", "shank"} - set(table.header)
    model = None
    if len(lacking) == 1:
        raise InputError(f"{table.path}: the header has no line '# {lacking.pop()}: ...'")
    if not lacking:
        known = {key: table.number(key, MODEL_UNITS[key]) for key in MODEL_UNITS if key in table.header}
        foot = {key: known.pop(key) for key in vars(PAPER_MODEL.foot) if key in known}
        try:
            model = LegModel(**known, foot=Foot(**foot), bones=cast(Bones, table.header.get("bones", bones)))
        except InputError as error:
            raise InputError(f"{table.path}: header: {error}") from error
    dt = table.number("dt", "s")
    try:
        return Gait(frames, dt, table.header.get("name", ""), table.header.get("origin", ""), model, paced=paced)
    except InputError as error:
        raise InputError(f"{table.path}: {error}") from error


def check_angles_deg(table: Table, values: Array, columns: tuple[str, ...]) -> None:
    """Refuse an angle of 360 degrees or more, naming its line.

    Raises:
        InputError: naming the file, the line, the column and the value.
    """
    limit = np.degrees(ANGLE_LIMIT_RAD)
    for row, column in np.argwhere(np.abs(values) >= limit)[:1]:
        raise InputError(
            f"{table.path}, line {table.first_line + row}: {columns[column]} is {values[row, column]:.6g}, "
            f"not below {limit:g} degrees"
        )


def swap_roles(frames: ArrayLike) -> Array:
    """Frames (..., 4) with the roles of supporting and swinging leg exchanged."""
    return np.asarray(frames, dtype=np.float64)[..., [2, 3, 0, 1]]
