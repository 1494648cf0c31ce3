"""The joint angles of both legs over consecutive steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ggo_factors.check.report import Tolerances
from ggo_factors.errors import InputError
from ggo_factors.motion.gait import SAME_TIME, Gait, swap_roles
from ggo_factors.motion.played import Played
from ggo_factors.support.inputs import Array, as_array, as_bool, as_number, as_tuple_of

STILL = 1e-12
"""Joints that turn by no more than this in [rad] from one frame to the next stand still: rounding leaves 1e-16."""
MOST_INSTANTS = 10_000_000
"""A trajectory resampled to more instants is refused as a mistake."""

JOINT_NAMES = ("left_hip", "left_knee", "right_hip", "right_knee")
"""The joints of a trajectory, in this order."""


@dataclass(frozen=True, eq=False)
class JointTrajectory:
    """Joint angles of both legs over time: what an exoskeleton replays.

    Between the times it moves on a cubic spline, see `Played`: positions, velocities and accelerations belong together.

    Attributes:
        time: time in [s], shape (k,).
        left_hip: thigh from the vertical, forward positive, in [rad], shape (k,).
        left_knee: flexion in [rad], shape (k,).
        right_hip: as `left_hip`.
        right_knee: as `left_knee`.
        starts_at_rest: whether the walker stands still in the first frame.
        ends_at_rest: the same of the last.
        path: the trajectory that these are instants of, where they are not its own frames.

    Raises:
        InputError: where there are fewer than 2 instants, times do not grow from 0, a joint has another number of
            angles, or a value is not finite.
    """

    time: Array
    left_hip: Array
    left_knee: Array
    right_hip: Array
    right_knee: Array
    starts_at_rest: bool = False
    ends_at_rest: bool = False
    path: Played | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        time = as_array(self.time, "time", (None,))
        if len(time) < 2 or time[0] or not (np.diff(time) > 0.0).all():
            raise InputError("time: a trajectory has at least 2 instants, and their times grow from 0")
        object.__setattr__(self, "time", time)
        for name in JOINT_NAMES:
            object.__setattr__(self, name, as_array(getattr(self, name), name, (len(time),)))
        for name in ("starts_at_rest", "ends_at_rest"):
            object.__setattr__(self, name, as_bool(getattr(self, name), name))

    def __repr__(self) -> str:
        return f"JointTrajectory({len(self.time)} instants, {self.time[-1] - self.time[0]:.4g} s)"

    def _repr_html_(self) -> str:
        from ggo_factors.walking.walk_card import trajectory_card  # only here: nothing but a notebook needs it

        rates = [np.degrees(np.abs(values).max(axis=0)) for values in (self.velocities, self.accelerations)]
        rests = [end for end, still in (("start", self.starts_at_rest), ("end", self.ends_at_rest)) if still]
        facts = {
            "instants": f"{len(self.time)}",
            "time": f"{self.time[-1] - self.time[0]:.4g} s",
            "at rest": " and ".join(rests) or "at neither end",
            "fastest": _largest(rates[0], "deg/s"),
            "largest acceleration": _largest(rates[1], "deg/s²"),
        }
        return trajectory_card("Joint trajectory", self.time, self.by_name, facts)

    @property
    def by_name(self) -> dict[str, Array]:
        """The angles in [rad] of each joint by its name, shape (k,) each."""
        return {name: getattr(self, name) for name in JOINT_NAMES}

    @property
    def positions(self) -> Array:
        """All four angles in [rad], shape (k, 4), in the order of the attributes."""
        return np.stack([self.left_hip, self.left_knee, self.right_hip, self.right_knee], -1)

    @cached_property
    def played(self) -> Played:
        """The trajectory between the times."""
        return self.path or Played(self.time, self.positions, self.starts_at_rest, self.ends_at_rest)

    @property
    def velocities(self) -> Array:
        """Their velocities in [rad/s], shape (k, 4), 0 where the walker stands at an end."""
        return self._rates[1]

    @property
    def accelerations(self) -> Array:
        """Their accelerations in [rad/s^2], shape (k, 4)."""
        return self._rates[2]

    @cached_property
    def _rates(self) -> tuple[Array, Array, Array]:
        if self.path is None:
            return self.played.positions, self.played.velocities, self.played.accelerations
        return self.path.at(self.time)

    def resampled(self, rate: float) -> JointTrajectory:
        """The same trajectory at a controller's rate in [1/s]; its last instant is kept, however near the one before.

        Raises:
            InputError: where the rate is not above 0, or makes more than `MOST_INSTANTS`.
        """
        per_second = as_number(rate, "rate", above=0.0, unit="1/s")
        duration = float(self.time[-1])
        if duration * per_second > MOST_INSTANTS:
            raise InputError(f"rate: {rate:g} 1/s makes more than {MOST_INSTANTS} instants in {duration:.4g} s")
        time = np.arange(math.floor(duration * per_second * (1.0 + 1e-12)) + 1) / per_second
        if duration - time[-1] > SAME_TIME:
            time = np.append(time, duration)
        time[-1] = duration
        return _trajectory(time, self.played.at(time)[0], self.starts_at_rest, self.ends_at_rest, self.played)

    def to_dataframe(self) -> Any:
        """A `pandas.DataFrame` with the time in [s] as its index and a column for each joint in [rad].

        Raises:
            ImportError: where pandas is not installed.
        """
        from ggo_factors.support.data_frame import pandas  # only here: nothing else needs it

        pd = pandas()
        index = pd.Index(self.time, name="time")
        return pd.DataFrame(self.by_name, index)


def joint_trajectory(
    gaits: Sequence[Gait],
    first_swing: str = "right",
    *,
    starts_at_rest: bool = False,
    ends_at_rest: bool = False,
    rate: float | None = None,
) -> JointTrajectory:
    """The joint angles of both legs over steps on end; the frame at a role swap occurs once.

    Args:
        gaits: the steps, each starting in the last frame of the one before with the roles swapped.
        first_swing: the leg that swings first, ``"right"`` or ``"left"``.
        starts_at_rest: whether the walker stands still in the first frame; so it is too where its motion is none.
        ends_at_rest: the same of the last.
        rate: instants a second, as a controller plays them; the frames' own times if None.

    Raises:
        InputError: where `first_swing` is neither, the time steps differ, `rate` is of no use, or a step does not
            start where the one before ended (1e-9 rad).
    """
    if first_swing not in ("right", "left"):
        raise InputError(f"first_swing: {first_swing!r} is neither 'right' nor 'left'")
    gaits = as_tuple_of(gaits, "gaits", Gait)
    if not gaits:
        raise InputError("gaits: a trajectory needs at least one step")
    parts = list[Array]()
    for number, gait in enumerate(gaits, start=1):
        if gait.dt != gaits[0].dt:
            raise InputError(f"step {number}: dt is {gait.dt:g} s, in step 1 {gaits[0].dt:g} s")
        swinging_left = (first_swing == "left") == (number % 2 == 1)
        # Columns: left hip, left knee, right hip, right knee.
        frames = swap_roles(gait.frames) if swinging_left else gait.frames
        if parts:
            jump = float(np.abs(frames[0] - parts[-1][-1]).max())
            if jump > Tolerances().start:
                raise InputError(f"step {number}: starts {jump:.3g} rad away from the end of step {number - 1}")
        parts.append(frames[1:] if parts else frames)
    joined = np.concatenate(parts)
    still = [float(np.abs(joined[k + 1] - joined[k]).max()) <= STILL for k in (0, len(joined) - 2)]
    made = _trajectory(times_of(gaits), joined, starts_at_rest or still[0], ends_at_rest or still[1])
    return made if rate is None else made.resampled(rate)


def times_of(gaits: Sequence[Gait]) -> Array:
    """Time of each frame of steps on end from the first in [s], shape (k,); a frame at a role swap occurs once."""
    if all(gait.paced is None for gait in gaits):
        # Evenly apart they are multiples of dt, to the last digit.
        motions = sum(len(gait) - 1 for gait in gaits)
        return np.asarray(np.arange(motions + 1) * gaits[0].dt, dtype=np.float64)
    ran, parts = 0.0, [np.zeros(1)]
    for gait in gaits:
        parts.append(ran + gait.times[1:])
        ran = float(parts[-1][-1])
    return np.concatenate(parts)


def _largest(values: Array, unit: str) -> str:
    """The largest of the hips and of the knees, of values in the order of `JOINT_NAMES`, shape (4,)."""
    return f"hip {values[::2].max():.0f}, knee {values[1::2].max():.0f} {unit}"


def _trajectory(time: Array, positions: Array, starts: bool, ends: bool, path: Played | None = None) -> JointTrajectory:
    left_hip, left_knee, right_hip, right_knee = positions.T
    return JointTrajectory(time, left_hip, left_knee, right_hip, right_knee, starts, ends, path)
