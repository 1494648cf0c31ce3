"""Heel strikes, and between them the strides of a recording, each good or with the reason against it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import find_peaks

from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.strides.signals import Signals, Stretch
from ggo_factors.recording.strides.steps import LEGS, SAMPLES, Step, ankle_path, find_steps
from ggo_factors.support.inputs import Array

# What a walker can do, in [s], in leg lengths, and in degrees. None of these is fitted to a recording.
SWING = 0.12
"""Least travel of the ankle relative to the hip, in leg lengths, that counts as a step; less is sway."""
STRIKE_APART_S = 0.4
"""Least time between two strikes of the same leg in [s]."""
LONGEST_STRIDE_S = 4.0
"""A stride that lasts longer in [s] holds a stop, unless most strides of the recording do: then the walker is slow."""
TIME_OFF = 0.3
"""Largest difference of a stride's time from the median, as a share of the median."""


@dataclass(frozen=True, eq=False)
class Stride:
    """One leg from a heel strike to its next.

    Attributes:
        leg: ``"right"`` or ``"left"``.
        start: time of the first strike in [s].
        end: time of the second strike in [s].
        angles: thigh and knee at the phases 0, 1/`SAMPLES`, ..., 1 in [rad], shape (SAMPLES + 1, 2); NaN if missing.
        toe_off: phase at which the ankle is furthest behind; NaN if data are missing.
        reason: why it is not used; "" where it is.
    """

    leg: str
    start: float
    end: float
    angles: Array
    toe_off: float
    reason: str = ""

    @property
    def duration(self) -> float:
        """Stride time in [s]."""
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
    pelvis position, works when the legs are exchanged, and on a treadmill as on the ground.
    """
    strikes: dict[str, list[float]] = {leg: [] for leg in LEGS}
    strides: list[Stride] = []
    steps: list[Step] = []
    for stretch in signals.stretches:
        ahead = [ankle_path(stretch.angles[:, 2 * i : 2 * i + 2], model)[:, 0] for i in range(2)]
        found = [_peaks(x, stretch.dt, SWING * model.reach) for x in ahead]
        splines = [_spline(stretch, i) for i in range(2)]
        for i, leg in enumerate(LEGS):
            strikes[leg] += (stretch.times[0] + found[i] * stretch.dt).tolist()
            for a, b in itertools.pairwise(found[i]):
                strides.append(_stride(leg, stretch, i, a, b, ahead[i], found[1 - i], splines[i]))
        steps += find_steps(stretch, found, splines, model)
    strides = _without_odd_times(sorted(strides, key=lambda s: (s.start, s.leg)))
    toe_offs = [stride.toe_off for stride in strides if not stride.reason]
    return Cycles(
        {leg: np.array(times) for leg, times in strikes.items()},
        tuple(strides),
        tuple(sorted(steps, key=lambda s: s.start)),
        float(np.mean(sorted(toe_offs))) if toe_offs else math.nan,
    )


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
) -> Stride:
    """The stride from sample a to b, refused where something in it alone is wrong."""
    inside = slice(math.floor(a), math.ceil(b) + 1)
    lost = ~np.isfinite(stretch.angles[inside])
    own = lost[:, 2 * i : 2 * i + 2].any(axis=1)
    between = other[(other > a) & (other < b)]
    reason, toe_off = "", math.nan
    angles = np.full((SAMPLES + 1, 2), np.nan)
    if own.any():
        stuck = stretch.stuck[inside, 2 * i : 2 * i + 2].any()
        reason = f"{'sensor stuck' if stuck else 'data missing'} ({own.sum() * stretch.dt:.2f} s)"
    else:
        angles = np.asarray(spline(np.linspace(a, b, SAMPLES + 1)), dtype=np.float64)
        toe_off = float((np.argmin(ahead[inside]) + math.floor(a) - a) / (b - a))
        if not lost.any():
            if len(between) != 1:
                reason = f"the other leg does not step once in it ({len(between)} times)"
            elif not 0.25 <= (between[0] - a) / (b - a) <= 0.75:
                share = 100.0 * (between[0] - a) / (b - a)
                reason = f"a start, stop or turn (the other leg lands at {share:.0f} % of it)"
        around = 0.75 * (b - a)
        if not reason and _rests(stretch.angles, other, a - around, a):
            reason = "starting: the other leg does not step before it"
        elif not reason and _rests(stretch.angles, other, b, b + around):
            reason = "stopping: the other leg does not step after it"
    start, end = (float(stretch.times[0] + place * stretch.dt) for place in (a, b))
    return Stride(leg, start, end, angles, toe_off, reason)


def _rests(angles: Array, strikes: Array, start: float, end: float) -> bool:
    """Whether a leg is seen not to strike between two samples."""
    first, last = math.floor(start), math.ceil(end) + 1
    if first < 0 or last > len(angles) or not np.isfinite(angles[first:last]).all():
        return False
    return not ((strikes > start) & (strikes < end)).any()


def _without_odd_times(strides: Sequence[Stride]) -> list[Stride]:
    """Refuse strides much longer or shorter than the median of both legs; very long ones contain a stop."""
    durations = [stride.duration for stride in strides if not stride.reason]
    if not durations:
        return list(strides)
    median = float(np.median(durations))
    result = list(strides)
    for i, stride in enumerate(strides):
        off = stride.duration - median
        times = f"({stride.duration:.2f} s, the median stride {median:.2f} s)"
        if off > TIME_OFF * median and stride.duration > LONGEST_STRIDE_S and np.isfinite(stride.angles).all():
            result[i] = replace(stride, reason=f"a stop in it {times}")
        elif not stride.reason and abs(off) > TIME_OFF * median:
            result[i] = replace(stride, reason=f"too {'long' if off > 0.0 else 'short'} {times}")
    return result
