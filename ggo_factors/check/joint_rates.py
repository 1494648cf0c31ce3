"""Speeds, accelerations and jerks of the joints of a gait, and where they break joint limits."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.played import Played
from ggo_factors.support.inputs import Array

LEGS = ("support leg", "swing leg")


SPIKE = math.radians(3.0)
"""How far one frame may stand out from the cubic through its neighbours, in [rad]. At 51 frames the gaits of the
procedures stand out by up to 0.05 degrees over random boxes, those of the paper's graph, with its kinks, by 1.2."""
SPIKE_MOTIONS = 30
"""Below so many motions a frame may stand out more, as the square of what is lacking: the frames are further apart."""
STANDS_OUT = 3.0
"""A frame is a spike where it stands out by so many times as far as any frame of the step that is not beside it."""


def joint_rates(gait: Gait, order: int) -> Array:
    """Joint speeds (order 1), accelerations (2) or jerks (3) by differences between frames, shape (m - order, 4).

    In [rad/s], [rad/s^2], [rad/s^3]; a gait of no more than `order` frames has none.
    """
    if gait.paced is None:
        return _even_rates(gait.frames, gait.dt, order)
    rates, times = gait.frames, gait.paced
    for _ in range(order):
        rates = np.diff(rates, axis=0) / np.diff(times)[:, None]
        times = (times[1:] + times[:-1]) / 2.0
    return np.asarray(rates)


def _even_rates(frames: Array, dt: float, order: int) -> Array:
    """As `joint_rates`, of frames `dt` from each other in [s]."""
    return np.asarray(np.diff(frames, order, axis=0) / dt**order, dtype=np.float64)


def widened(limits: JointLimits, gaits: Sequence[Gait], spare: float) -> JointLimits:
    """The limits, wider where gaits reach beyond them, by a share `spare` more; but no knee may be straighter."""
    frames = np.concatenate([gait.frames for gait in gaits]).reshape(-1, 2)
    speeds, bends = (np.concatenate([joint_rates(gait, order) for gait in gaits]).reshape(-1, 2) for order in (1, 2))
    low, high = frames.min(axis=0).tolist(), frames.max(axis=0).tolist()
    fast, bent = (((1.0 + spare) * np.abs(rates).max(axis=0)).tolist() for rates in (speeds, bends))
    room = spare * (frames.max(axis=0) - frames.min(axis=0))
    return JointLimits(
        hip_back=min(limits.hip_back, low[0] - room[0]),
        hip_forward=max(limits.hip_forward, high[0] + room[0]),
        knee_straight=limits.knee_straight,
        knee_bent=max(limits.knee_bent, high[1] + room[1]),
        hip_speed=max(limits.hip_speed, fast[0]),
        knee_speed=max(limits.knee_speed, fast[1]),
        hip_acceleration=max(limits.hip_acceleration, bent[0]),
        knee_acceleration=max(limits.knee_acceleration, bent[1]),
    )


def limit_faults(gait: Gait, limits: JointLimits, slack: float = 0.0) -> list[Violation]:
    """Where a gait breaks joint limits: the worst of each kind.

    Rates are differences between frames where those are evenly apart: what edges of a graph hold. Those of a gait that
    was slowed are looked at at every instant of the trajectory that it plays, which may be faster between frames by up
    to a half.

    Args:
        gait: the step.
        limits: the limits.
        slack: how far beyond a limit still counts as kept, as a share of it, for angles of their range.
    """
    if gait.paced is None:
        return even_faults(gait.frames, gait.dt, limits, slack)
    return angle_faults(gait.frames, limits, slack) + rate_faults(gait.played, limits, slack)


def even_faults(frames: Array, dt: float, limits: JointLimits, slack: float) -> list[Violation]:
    """Where frames, shape (m, 4) in [rad], `dt` from each other in [s], break joint limits; as `limit_faults`.

    They need not be a gait: what is left of a step may turn faster than any.
    """
    most, most_bent = limits.speed, limits.acceleration
    found = angle_faults(frames, limits, slack)
    found += _worst("speed", "deg/s", _even_rates(frames, dt, 1), -most, most, most, slack, 0.5)
    bent = _even_rates(frames, dt, 2)
    return found + _worst("acceleration", "deg/s2", bent, -most_bent, most_bent, most_bent, slack, 1.0)


def angle_faults(frames: Array, limits: JointLimits, slack: float) -> list[Violation]:
    """Where frames, shape (m, 4) in [rad], break limits of the joints' angles; as `limit_faults`."""
    return _worst("angle", "deg", frames, limits.lower, limits.upper, limits.upper - limits.lower, slack, 0.0)


def rate_faults(
    played: Played, limits: JointLimits, slack: float, first: int = 0, last: int | None = None, swapped: bool = False
) -> list[Violation]:
    """Where a trajectory breaks limits of its joints' rates; as `limit_faults`.

    Args:
        played: the trajectory, its joints in the order of a frame.
        limits: the limits.
        slack: as for `limit_faults`.
        first: number of the frame to look from; the frames told are counted from it.
        last: number of the last frame to look at; that of the trajectory if None.
        swapped: whether the legs' roles are exchanged there.
    """
    end = len(played.times) - 1 if last is None else last
    speeds, bends = played.fastest[first:end], played.accelerations[first : end + 1]
    if swapped:
        speeds, bends = swap_roles(speeds), swap_roles(bends)
    most, most_bent = limits.speed, limits.acceleration
    found = _worst("speed", "deg/s", speeds, -most, most, most, slack, 0.5)
    return found + _worst("acceleration", "deg/s2", bends, -most_bent, most_bent, most_bent, slack, 0.0)


def _worst(
    kind: str, unit: str, values: Array, low: Array, high: Array, scale: Array, slack: float, when: float
) -> list[Violation]:
    """The worst hip and the worst knee of values (k, 4), the first of which belongs to frame `when`."""
    found, beyond = [], np.maximum(values - high, low - values) / scale
    for first, joint in enumerate(("hip", "knee")):
        own = beyond[:, first::2]
        if own.size and own.max() > slack:
            row, leg = np.unravel_index(own.argmax(), own.shape)
            value = values[row, first::2][leg]
            limit = high[first] if value > high[first] else low[first]
            name, frame = f"{joint} {kind}", float(row) + when
            found.append(Violation(name, frame, math.degrees(value), math.degrees(limit), unit, LEGS[leg]))
    return found


def spikes(gait: Gait) -> list[Violation]:
    """Where a single frame stands out of the motion as no continuous one does: a number that was changed, or lost."""
    if len(gait) < 7:
        return []
    frames, found = gait.frames, []
    middle = (4.0 * (frames[1:-3] + frames[3:-1]) - frames[:-4] - frames[4:]) / 6.0
    out = np.abs(frames[2:-2] - middle)
    most = SPIKE * max(1.0, SPIKE_MOTIONS / (len(gait) - 1)) ** 2
    for joint in range(4):
        row = int(out[:, joint].argmax())
        others = np.delete(out[:, joint], range(max(row - 2, 0), min(row + 3, len(out))))
        limit = max(most, STANDS_OUT * float(others.max(initial=0.0)))
        if out[row, joint] > limit:
            name, value = f"{('hip', 'knee')[joint % 2]} spike", math.degrees(out[row, joint])
            found.append(Violation(name, float(row + 2), value, math.degrees(limit), "deg", LEGS[joint // 2]))
    return found
