"""Heel strikes, and between them the strides and steps of a recording, each with its kind or the reason against it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import find_peaks

from ggo_factors.arrays import Array
from ggo_factors.gait import swap_roles
from ggo_factors.model import LegModel
from ggo_factors.recording.signals import Signals, Stretch

LEGS = ("right", "left")
ACTIVITIES = ("level", "stairs-up", "stairs-down")

SAMPLES = 100
"""Phases of a cycle: 0, 1/100, ..., 99/100. A stride also has the sample at 1, which is the next one's 0."""

# What a walker can do, in [s], in leg lengths, and in degrees. None of these is fitted to a recording.
SWING = 0.12
"""Least travel of the ankle relative to the hip, in leg lengths, that is a step and not sway."""
STRIKE_APART_S = 0.4
"""Least time between two strikes of the same leg in [s]."""
SHORTEST_STEP_S = 0.1
"""Two legs that strike within less time in [s] do not step in turn."""
LONGEST_STRIDE_S = 4.0
"""A stride that lasts longer in [s] holds a stop."""
SHORT = 0.6
"""A stride whose ankle travels less than this part of the median is a start, a stop or a turn."""
TIME_OFF = 0.3
"""A stride may last longer or shorter than the median by this part."""
SHAPE_DEG = 5.0
"""A stride this far (RMS of hip and knee) from its leg's median may be refused; ..."""
SHAPE_TIMES = 4.0
"""... if it is also so many times as far as the median stride."""
KNEE_UP_DEG = 20.0
"""Knee of the landing leg less the trailing one's at a strike: some -10 on level ground, +50 up stairs."""
KNEE_DOWN_DEG = 60.0
"""Knee of the trailing leg at toe-off: 25 to 50 on level ground, 70 to 90 down stairs, where it lowers the body; ..."""
KNEES_APART_DEG = 40.0
"""... and so much more than the leading one's."""
RISE = 0.08
"""Least rise of the hip in a step, in leg lengths, that is a stair."""


@dataclass(frozen=True, eq=False)
class Stride:
    """One leg from a heel strike to its next.

    Attributes:
        leg: ``"right"`` or ``"left"``.
        start: time of the first strike in [s].
        end: time of the second strike in [s].
        angles: thigh and knee at the phases 0, 1/`SAMPLES`, ..., 1 in [rad], shape (SAMPLES + 1, 2); NaN if missing.
        reason: why it is not used; "" where it is.
    """

    leg: str
    start: float
    end: float
    angles: Array
    reason: str = ""

    @property
    def duration(self) -> float:
        """Stride time in [s]."""
        return self.end - self.start

    def __str__(self) -> str:
        return f"{self.leg} {self.start:.2f}-{self.end:.2f} s" + (f": {self.reason}" if self.reason else "")


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


@dataclass(frozen=True, eq=False)
class Cycles:
    """Everything that was found in a recording, in the order of time.

    Attributes:
        strikes: times of the heel strikes in [s] of each leg.
        strides: all strides, good or not.
        steps: all steps between two alternating strikes with complete data.
        toe_off: mean phase of the toe-off in the strides of both legs; below 0.5 there is no double support.
    """

    strikes: dict[str, Array]
    strides: tuple[Stride, ...]
    steps: tuple[Step, ...]
    toe_off: float


def find_cycles(signals: Signals, model: LegModel) -> Cycles:
    """Cut a recording at its heel strikes.

    A heel strikes where its ankle is furthest ahead of the hip, L1 sin(alpha) + L2 sin(alpha - beta) (Zeni, Richards
    and Higginson, Gait & Posture 27, 2008), and its toe leaves the ground where the ankle is furthest behind. Needs no
    pelvis position, is indifferent to which leg is called which, and works on a treadmill as on the ground.
    """
    strikes: dict[str, list[float]] = {leg: [] for leg in LEGS}
    strides: list[Stride] = []
    steps: list[Step] = []
    toe_offs: list[float] = []
    for stretch in signals.stretches:
        ahead = [_ankle(stretch.angles[:, 2 * i : 2 * i + 2], model)[:, 0] for i in range(2)]
        found = [_peaks(x, stretch.dt, SWING * model.reach) for x in ahead]
        splines = [_spline(stretch, i) for i in range(2)]
        for i, leg in enumerate(LEGS):
            strikes[leg] += (stretch.times[0] + found[i] * stretch.dt).tolist()
            for a, b in itertools.pairwise(found[i]):
                stride, toe_off = _stride(leg, stretch, i, a, b, ahead[i], found[1 - i], splines[i])
                strides.append(stride)
                toe_offs += [toe_off] if not stride.reason else []
        steps += _steps(stretch, found, splines, model)
    strides = _without_odd_times(sorted(strides, key=lambda s: (s.start, s.leg)))
    return Cycles(
        {leg: np.array(times) for leg, times in strikes.items()},
        tuple(strides),
        tuple(sorted(steps, key=lambda s: s.start)),
        float(np.mean(sorted(toe_offs))) if toe_offs else math.nan,
    )


def _ankle(angles: Array, model: LegModel) -> Array:
    """Ankle of a leg relative to its hip in [m], shape (n, 2), of thigh and knee angles (n, 2)."""
    shank = angles[:, 0] - angles[:, 1]
    x = model.thigh * np.sin(angles[:, 0]) + model.shank * np.sin(shank)
    return np.stack([x, -model.thigh * np.cos(angles[:, 0]) - model.shank * np.cos(shank)], -1)


def _peaks(x: Array, dt: float, travel: float) -> Array:
    """Places of the forward extremes between samples, shape (k,); the ankle swings by `travel` before and after."""
    places: list[float] = []
    valid = np.concatenate([[False], np.isfinite(x), [False]])
    edge, second, lookout = max(2, round(0.03 / dt)), round(0.6 / dt), round(2.0 / dt)
    for start, end in np.flatnonzero(valid[1:] != valid[:-1]).reshape(-1, 2):
        part = x[start:end]
        # An extreme near the end of the data counts by its inner side: beyond it anything may have been.
        low = part.min() - 2.0 * travel
        peaks, _ = find_peaks(
            np.concatenate([[low], part, [low]]), prominence=travel, distance=max(1, round(STRIKE_APART_S / dt))
        )
        for peak in (peaks - 1).tolist():
            if not edge <= peak < len(part) - edge:
                continue
            before, after = part[max(0, peak - lookout) : peak + 1], part[peak : peak + lookout]
            rises = part[peak] - before.min() >= travel or peak < second
            falls = part[peak] - after.min() >= travel or len(part) - peak < second
            if rises and falls:
                left, top, right = part[peak - 1 : peak + 2]
                bend = left - 2.0 * top + right
                places.append(start + peak + (0.5 * (left - right) / bend if bend < 0.0 else 0.0))
    return np.array(places)


def _spline(stretch: Stretch, leg: int) -> CubicSpline:
    """A leg's angles by sample number; the values in gaps mean nothing and are never taken."""
    angles = stretch.angles[:, 2 * leg : 2 * leg + 2]
    known = np.isfinite(angles).all(axis=1)
    if known.sum() < 2:
        return CubicSpline([0.0, 1.0], np.zeros((2, 2)))
    return CubicSpline(np.flatnonzero(known), angles[known])


def _stride(
    leg: str, stretch: Stretch, i: int, a: float, b: float, ahead: Array, other: Array, spline: CubicSpline
) -> tuple[Stride, float]:
    """The stride from sample a to b, refused where something in it alone is wrong; and its phase of toe-off."""
    inside = slice(math.floor(a), math.ceil(b) + 1)
    lost = ~np.isfinite(stretch.angles[inside])
    own = lost[:, 2 * i : 2 * i + 2].any(axis=1)
    between = other[(other > a) & (other < b)]
    reason, toe_off = "", math.nan
    angles = np.full((SAMPLES + 1, 2), np.nan)
    if (b - a) * stretch.dt > LONGEST_STRIDE_S and not own.any():
        reason = f"a stop: {(b - a) * stretch.dt:.1f} s between two heel strikes"
    elif own.any():
        stuck = stretch.stuck[inside, 2 * i : 2 * i + 2].any()
        reason = f"{'sensor stuck' if stuck else 'data missing'} for {own.sum() * stretch.dt:.2f} s"
    else:
        angles = np.asarray(spline(np.linspace(a, b, SAMPLES + 1)), dtype=np.float64)
        toe_off = float((np.argmin(ahead[inside]) + math.floor(a) - a) / (b - a))
        if not lost.any():
            if len(between) != 1:
                reason = f"the other leg steps {len(between)} times in it, not once"
            elif not 0.25 <= (between[0] - a) / (b - a) <= 0.75:
                reason = (
                    f"the other leg lands at {100.0 * (between[0] - a) / (b - a):.0f} % of it: a start, stop or turn"
                )
        around = 0.75 * (b - a)
        if not reason and _rests(stretch.angles, other, a - around, a):
            reason = "starting: the other leg does not step before it"
        elif not reason and _rests(stretch.angles, other, b, b + around):
            reason = "stopping: the other leg does not step after it"
    start, end = (float(stretch.times[0] + place * stretch.dt) for place in (a, b))
    return Stride(leg, start, end, angles, reason), toe_off


def _rests(angles: Array, strikes: Array, start: float, end: float) -> bool:
    """Whether a leg is seen not to strike between two samples."""
    first, last = math.floor(start), math.ceil(end) + 1
    if first < 0 or last > len(angles) or not np.isfinite(angles[first:last]).all():
        return False
    return not ((strikes > start) & (strikes < end)).any()


def _without_odd_times(strides: Sequence[Stride]) -> list[Stride]:
    """Strides too long or too short against the median of both legs are refused."""
    durations = [stride.duration for stride in strides if not stride.reason]
    if not durations:
        return list(strides)
    median = float(np.median(durations))
    return [
        replace(s, reason=f"lasts {s.duration:.2f} s, the median stride {median:.2f} s")
        if not s.reason and abs(s.duration - median) > TIME_OFF * median
        else s
        for s in strides
    ]


def _steps(stretch: Stretch, found: Sequence[Array], splines: Sequence[CubicSpline], model: LegModel) -> list[Step]:
    """The steps of a stretch: from each strike to the next, where that is the other leg's."""
    steps = []
    strikes = sorted((place, i) for i in range(2) for place in found[i].tolist())
    for (a, support), (b, swing) in itertools.pairwise(strikes):
        inside = stretch.angles[math.floor(a) : math.ceil(b) + 1]
        if support == swing or not np.isfinite(inside).all():
            continue
        if not SHORTEST_STEP_S <= (b - a) * stretch.dt <= LONGEST_STRIDE_S:
            continue
        phases = np.linspace(a, b, SAMPLES + 1)
        frames = np.concatenate([splines[leg](phases) for leg in (support, swing)], axis=1)
        rise = _rise(frames, (b - a) * stretch.dt, model)
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
    return np.asarray(frames[np.argmin(_ankle(frames[:, :2], model)[:, 0])], dtype=np.float64)


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
    body = -np.gradient(_ankle(frames[:, :2], model)[:, 0]) * (len(frames) - 1)
    passing = np.abs(apart) <= max(abs(float(apart[-1])) / 3.0, float(np.abs(apart).min()))
    return float(body[passing].mean())


def _rise(frames: Array, duration: float, model: LegModel) -> float:
    """Height of the landing place over the support in [m], of a step's frames (n, 4).

    Not the ankles' difference at landing: the trailing heel has left the ground by then, and the ankle with it. While
    the feet pass each other the support foot is flat, and from the landing on the swing foot stands; so the hip's
    height is known before and after, and moves between as its speed and acceleration at both ends say.
    """
    passed = np.flatnonzero(model.endpoint(frames)[:, 0] >= 0.0)
    first = int(min(passed[0] if len(passed) else 0, len(frames) - 5))
    dt = duration / (len(frames) - 1)
    height = -np.stack([_ankle(frames[:, :2], model)[:, 1], _ankle(frames[:, 2:], model)[:, 1]], -1)
    speed = np.gradient(height, dt, axis=0)
    bend = np.gradient(speed, dt, axis=0)
    time = (len(frames) - 1 - first) * dt
    travelled = 0.5 * time * (speed[first, 0] + speed[-1, 1]) + time**2 / 12.0 * (bend[first, 0] - bend[-1, 1])
    return float(height[first, 0] + travelled - height[-1, 1])
