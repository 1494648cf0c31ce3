"""Steps of a recording: on level ground or on stairs, how far they go, and how high."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from ggo_factors.motion.gait import swap_roles
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.strides.signals import Stretch
from ggo_factors.support.inputs import Array

LEGS = ("right", "left")
"""The legs, in the order of the columns of the angles."""
ACTIVITIES = ("level", "stairs-up", "stairs-down")
"""What a step of a recording can be."""

SAMPLES = 100
"""Phases of a cycle: 0, 1/100, ..., 99/100. A stride also has the sample at 1, which is the next one's 0."""

# What a walker can do, in [s], in leg lengths, and in degrees. None of these is fitted to a recording.
SHORTEST_STEP_S = 0.1
"""Least time in [s] between the strikes of two legs that step in turn."""
LONGEST_STEP_S = 4.0
"""Longest time in [s] between the strikes of two legs in a step; beyond it the walker has stopped."""
KNEE_UP_DEG = 20.0
"""Knee of the landing leg less the trailing one's at a strike: some -10 on level ground, +50 up stairs."""
KNEE_DOWN_DEG = 60.0
"""Knee of the trailing leg at toe-off: 25 to 50 on level ground, 70 to 90 down stairs, where it lowers the body; ..."""
KNEES_APART_DEG = 40.0
"""... and so much more than the leading one's."""
RISE = 0.08
"""Least rise of the hip in a step, in leg lengths, that is a stair."""
LEVEL_SHARE = 0.5
"""A swing starts from level ground where its feet are apart in height by less than this share of the riser: half way
between level ground and the next stair. A trailing ankle that its heel lifts is 0.02 to 0.05 m off."""


@dataclass(frozen=True, eq=False)
class Step:
    """A swing of one leg: from the other leg's heel strike to its own.

    Attributes:
        leg: the swinging leg.
        start: time of the other leg's strike in [s].
        end: time of the landing in [s].
        frames: ``[alpha1, beta1, alpha2, beta2]`` at the phases 0, 1/`SAMPLES`, ..., 1 in [rad], (SAMPLES + 1, 4).
        activity: one of `ACTIVITIES`.
        rise: height of the landing place over the support in [m].
        advance: distance in [m] at which the foot is ahead of the support at its strike.
        travel: how far the body goes forward in the step in [m].
        reason: why it is not used; "" where it is.
    """

    leg: str
    start: float
    end: float
    frames: Array
    activity: str
    rise: float
    advance: float
    travel: float
    reason: str = ""

    @property
    def duration(self) -> float:
        """Step time in [s]."""
        return self.end - self.start

    def __str__(self) -> str:
        return f"{self.leg} {self.start:.2f}-{self.end:.2f} s" + (f": {self.reason}" if self.reason else "")


def ankle_path(angles: Array, model: LegModel) -> Array:
    """Ankle of a leg relative to its hip in [m], shape (n, 2), of thigh and knee angles (n, 2)."""
    shank = angles[:, 0] - angles[:, 1]
    x = model.thigh * np.sin(angles[:, 0]) + model.shank * np.sin(shank)
    return np.stack([x, -model.thigh * np.cos(angles[:, 0]) - model.shank * np.cos(shank)], -1)


def find_steps(stretch: Stretch, found: Sequence[Array], splines: Sequence[CubicSpline], model: LegModel) -> list[Step]:
    """The steps of a stretch: from each strike to the next, where that is the other leg's."""
    steps = []
    strikes = sorted((place, i) for i in range(2) for place in found[i].tolist())
    for (a, support), (b, swing) in itertools.pairwise(strikes):
        inside = stretch.angles[math.floor(a) : math.ceil(b) + 1]
        if support == swing or not np.isfinite(inside).all():
            continue
        if not SHORTEST_STEP_S <= (b - a) * stretch.dt <= LONGEST_STEP_S:
            continue
        phases = np.linspace(a, b, SAMPLES + 1)
        frames = np.concatenate([splines[leg](phases) for leg in (support, swing)], axis=1)
        rise = _rise(frames, [splines[leg] for leg in (support, swing)], a, b, stretch.dt, model)
        activity = "level"
        if math.degrees(frames[-1, 3] - frames[-1, 1]) > KNEE_UP_DEG and rise > RISE * model.reach:
            activity = "stairs-up"
        leaving = _toe_off(stretch, support, b, b + 0.6 * (b - a), model)
        bent, apart, drop = math.degrees(leaving[1]), math.degrees(leaving[1] - leaving[3]), _drop(leaving, model)
        if bent > KNEE_DOWN_DEG and apart > KNEES_APART_DEG and drop > RISE * model.reach:
            activity, rise = "stairs-down", -drop
        start, end = (float(stretch.times[0] + place * stretch.dt) for place in (a, b))
        advance = float(model.endpoint(frames[-1])[0])
        travel = _travel(frames, model)
        steps.append(Step(LEGS[swing], start, end, frames, activity, rise, advance, travel))
    return steps


def _toe_off(stretch: Stretch, trailing: int, strike: float, end: float, model: LegModel) -> Array:
    """The frame (trailing leg first) after a strike in which the trailing ankle is furthest behind; 0 if unseen."""
    frames = stretch.angles[math.ceil(strike) : math.floor(end) + 1]
    if not len(frames) or not np.isfinite(frames).all():
        return np.zeros(4)
    frames = frames if trailing == 0 else swap_roles(frames)
    return np.asarray(frames[np.argmin(ankle_path(frames[:, :2], model)[:, 0])], dtype=np.float64)


def _drop(leaving: Array, model: LegModel) -> float:
    """How far the landing place of a step down lies under the support in [m], of the frame at toe-off.

    At the strike the foot is in the air still, and it lands toes first; here it is flat. But the trailing heel is
    lifted, so this is an upper bound.
    """
    return -float(model.endpoint(leaving)[1])


def _travel(frames: Array, model: LegModel) -> float:
    """How far the body goes forward in a step in [m], at the speed it has over the flat support foot.

    That is while the feet pass each other, no further apart than a third of the step. The ankles' distance at the
    strike tells less: the foot is drawn back before it lands, and the trailing ankle moves with its lifted heel.
    """
    apart = model.endpoint(frames)[:, 0]
    body = -np.gradient(ankle_path(frames[:, :2], model)[:, 0]) * (len(frames) - 1)
    passing = np.abs(apart) <= max(abs(float(apart[-1])) / 3.0, float(np.abs(apart).min()))
    return float(body[passing].mean())


def _rise(frames: Array, splines: Sequence[CubicSpline], a: float, b: float, dt: float, model: LegModel) -> float:
    """Height of the landing place over the support in [m], of a step from sample a to b.

    Not the ankles' difference at landing: the trailing heel has left the ground by then, and the ankle with it. While
    the feet pass each other the support foot is flat, and from the landing on the swing foot stands; so the hip's
    height is known before and after, and moves between as its speed and acceleration at both ends say.

    Args:
        frames: the step, shape (n, 4) in [rad].
        splines: angles by sample number, of the supporting leg and of the swinging one.
        a: where it starts.
        b: where it ends.
        dt: time between two samples in [s].
        model: the legs.
    """
    passed = np.flatnonzero(model.endpoint(frames)[:, 0] >= 0.0)
    share = min(passed[0] if len(passed) else 0, len(frames) - 5) / (len(frames) - 1)
    passing = a + share * (b - a)
    (high, up, bend), (high_after, up_after, bend_after) = (
        _hip_motion(spline, place, dt, model) for spline, place in zip(splines, (passing, b), strict=True)
    )
    time = (b - passing) * dt
    return high + 0.5 * time * (up + up_after) + time**2 / 12.0 * (bend - bend_after) - high_after


def _hip_motion(spline: CubicSpline, place: float, dt: float, model: LegModel) -> tuple[float, float, float]:
    """Height, speed and acceleration of the hip over a leg's ankle in [m], [m/s] and [m/s^2], at a sample's place."""
    thigh, knee = spline(place).tolist()
    thigh_speed, knee_speed = (spline(place, 1) / dt).tolist()
    thigh_bend, knee_bend = (spline(place, 2) / dt**2).tolist()
    height = speed = bend = 0.0
    for length, angle, turn, change in (
        (model.thigh, thigh, thigh_speed, thigh_bend),
        (model.shank, thigh - knee, thigh_speed - knee_speed, thigh_bend - knee_bend),
    ):
        height += length * math.cos(angle)
        speed -= length * math.sin(angle) * turn
        bend -= length * (math.cos(angle) * turn**2 + math.sin(angle) * change)
    return height, speed, bend
