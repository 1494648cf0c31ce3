"""From logged values to clean angles of both legs on one uniform clock."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator
from scipy.ndimage import median_filter
from scipy.signal import butter, sosfiltfilt

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.joint_map import ANGLES, UNITS, JointMap
from ggo_factors.recording.log.joint_table import BRIDGE_S
from ggo_factors.support.inputs import Array

CUTOFF_HZ = 6.0
"""Cut-off of the zero-phase low-pass in [Hz], at -3 dB: gait lies below it, marker and sensor noise above."""

STUCK_S = 0.4
"""A sensor is stuck when its value does not change at all for so long in [s] while another value moves."""

GRID_S = (1.0 / 200.0, 1.0 / 100.0)
"""Shortest and longest step of the uniform clock in [s]."""

_LARGEST_RAD = 4.0 * math.pi
"""Largest angle in [rad], two turns: no joint turns so far and no sensor drifts so far, so more is damage."""
_TURN_RAD = 2.0 * math.pi + 0.5
"""Largest angle in [rad] without an offset or counted turns: one turn and some noise."""
_QUICK_S, _QUICK_RAD = 0.25, 2.5
"""In 0.25 s no leg angle of a walk changes by more than 2.5 rad; in degrees it does, so the values are degrees."""
_FAR_SPIKE_RAD = 1.0
"""A sample so far in [rad] from the running median is a spike: no joint moves so far in 0.04 s."""
_SPIKE_RAD = math.radians(6.0)
"""Least distance in [rad] from the running median that can be a spike; less is noise."""
_FASTEST_RAD_S2 = 200.0
"""Angular acceleration beyond what a knee reaches in walking or running, in [rad/s^2]."""
_MOVES_RAD = math.radians(5.0)
"""A value that changes by more in [rad] shows that the person moves while another sensor is stuck."""
_SHORTEST_S = 0.5
"""Valid stretches shorter than this in [s] are left out: they hold no stride and are too short to filter."""

Mask = NDArray[np.bool_]
Counts = dict[str, dict[str, float]]


@dataclass(frozen=True, eq=False)
class Stretch:
    """The four angles on a uniform clock, over a time in which the clock does not step.

    Attributes:
        times: in [s], shape (n,), equally spaced.
        angles: `ANGLES` in [rad], shape (n, 4); NaN where nothing valid was logged.
        stuck: where an angle is missing because its sensor stuck, shape (n, 4).
    """

    times: Array
    angles: Array
    stuck: Mask

    @property
    def dt(self) -> float:
        """Step of the clock in [s]."""
        return float(self.times[1] - self.times[0])


@dataclass(frozen=True, eq=False)
class Signals:
    """All stretches of a log, and what had to be done to its values.

    Attributes:
        stretches: in the order of the log.
        rate: median rate of the logged values in [Hz].
        unit: unit that the values were read in.
        counts: what was found (``missing``, ``out of range``, ``wraps``, ``spikes``, ``gaps bridged``,
            ``gaps too long to bridge``: samples or gaps; ``stuck``: seconds), by logged value.
    """

    stretches: tuple[Stretch, ...]
    rate: float
    unit: str
    counts: Counts

    def lines(self) -> tuple[str, ...]:
        """What was done, one line for each kind."""
        return tuple(
            f"{kind}: "
            + ", ".join(f"{name} {number:g}{' s' if kind == 'stuck' else ''}" for name, number in row.items())
            for kind, row in self.counts.items()
        )


def unit_of(joints: JointMap, unit: str | None, log: JointLog) -> str:
    """The unit of the logged values: the map's, else the one given, else what ROS says, else refused.

    Raises:
        InputError: where `unit` is neither ``"rad"`` nor ``"deg"``.
        LogError: where none is known, or the values cannot be in it.
    """
    if unit is not None and unit not in UNITS:
        raise InputError(f"unit: expected 'rad' or 'deg', got {unit!r:.40}")
    if joints.units and unit and joints.units != unit:
        raise LogError(f"{joints.origin} says units {joints.units!r}, unit= says {unit!r}: which is it?")
    chosen = joints.units or unit or log.unit
    if chosen is None:
        raise LogError(
            f"{log.source}: the unit of the angles is not known ({log.encoding} {log.message_type or 'without a type'} "
            f"has no convention); give unit='rad' or unit='deg', or units in the joint map"
        )
    used = log.values[:, [log.names.index(name) for name in joints.names]]
    spans = {}
    for name, column in zip(joints.names, used.T, strict=True):
        finite = column[np.isfinite(column)]
        spans[name] = np.percentile(finite, [1.0, 99.0]) if len(finite) else np.zeros(2)
    name, span = max(spans.items(), key=lambda item: float(np.abs(item[1]).max()))
    if chosen == "rad" and np.abs(span).max() > _TURN_RAD:
        moves = max(_moves(log.times, column) for column in used.T)
        runs = f"{log.source}: {name} runs from {span[0]:.1f} to {span[1]:.1f}"
        if moves > _QUICK_RAD:
            raise LogError(f"{runs}: looks like degrees, not radians; give unit='deg', or units in the map")
        if np.abs(span).max() > _LARGEST_RAD:
            raise LogError(
                f"{runs}, in radians more than two turns, and no value moves by more than {moves:.1f} in "
                f"{_QUICK_S:g} s, too little for a walk in degrees: an offset, or whole turns counted on? "
                "(unit='deg' if these are degrees)"
            )
    widest = max(float(span[1] - span[0]) for span in spans.values())
    if chosen == "deg" and 0.3 < widest < 2.5:
        raise LogError(
            f"{log.source}: no value moves by more than {widest:.2f}: "
            "nobody walks with so few degrees; if these are radians, give unit='rad'"
        )
    return chosen


def _moves(times: Array, values: Array) -> float:
    """How far a value moves in `_QUICK_S` where it moves fast; a rare jump does not count."""
    known = np.isfinite(values)
    t, x = times[known], values[known]
    after = np.searchsorted(t, t + _QUICK_S)
    before = after < len(t)
    return float(np.percentile(np.abs(x[after[before]] - x[before]), 90.0)) if before.any() else 0.0


def clean(log: JointLog, joints: JointMap, unit: str) -> Signals:
    """Angles of both legs on a uniform clock: damage removed, short gaps bridged, filtered without delay.

    Each logged value by itself: not finite or beyond two turns -> missing; wrapped angles unwrapped; spikes
    (samples far from the median of their neighbours) and stuck stretches -> missing; resampled; gaps of up to
    `BRIDGE_S` bridged. Then the map's sums, and a second-order Butterworth low-pass run forward and backward.

    Raises:
        LogError: where a value has no valid sample, or the rate is too low for the filter.
    """
    scale = math.pi / 180.0 if unit == "deg" else 1.0
    columns = {
        name: log.values[:, log.names.index(name)] * scale - joints.offsets.get(name, 0.0) for name in joints.names
    }
    for name, column in columns.items():
        if not np.isfinite(column).any():
            raise LogError(f"{log.source}: {name} has no value in the whole log ({len(column)} samples, all missing)")
    # Of one value, not of the log: publishers of a leg each are merged by time.
    step = max(_step(log.times[np.isfinite(column)]) for column in columns.values())
    if step > 0.5 / CUTOFF_HZ:
        raise LogError(
            f"{log.source}: sampled at {1.0 / step:.1f} Hz by its times ({log.time_source}), "
            f"the filter at {CUTOFF_HZ:g} Hz needs {2.0 * CUTOFF_HZ:g} Hz"
        )
    _check_bursts(log, step)
    grid = float(np.clip(step, *GRID_S))
    counts: Counts = {}
    stretches = []
    for first, last in log.segments or ((0, len(log.times)),):
        times = log.times[first:last]
        if len(times) < 2 or times[-1] - times[0] < _SHORTEST_S:
            continue
        clock = times[0] + grid * np.arange(int((times[-1] - times[0]) / grid + 1e-6) + 1)
        sound = {name: _sound(name, times, column[first:last], step, counts) for name, column in columns.items()}
        values: dict[str, Array] = {}
        stuck: dict[str, Mask] = {}
        for name, (t, x) in sound.items():
            runs = _stuck_runs(name, sound)
            stuck[name] = np.zeros(len(clock), dtype=bool)
            free = np.ones(len(t), dtype=bool)
            for start, end in runs:
                stuck[name] |= (clock > t[start]) & (clock <= t[end])
                free[start + 1 : end + 1] = False
                _count(counts, "stuck", name, float(t[end] - t[start]))
            values[name] = _on_clock(name, t[free], x[free], clock, step, counts)
            values[name][stuck[name]] = np.nan
        angles = [sum(factor * values[name] for name, factor in joints.terms[angle].items()) for angle in ANGLES]
        held = [np.any([stuck[name] for name in joints.terms[angle]], axis=0) for angle in ANGLES]
        filtered = [_low_pass(np.asarray(angle), grid) for angle in angles]
        stretches.append(Stretch(clock, np.stack(filtered, -1), np.stack(held, -1)))
    return Signals(tuple(stretches), 1.0 / step, unit, counts)


def _count(counts: Counts, kind: str, name: str, number: float) -> None:
    if number:
        row = counts.setdefault(kind, {})
        row[name] = round(row.get(name, 0) + number, 3)


def _step(times: Array) -> float:
    return float(np.median(np.diff(times))) if len(times) > 1 else math.inf


def _check_bursts(log: JointLog, step: float) -> None:
    """Refuse times at which messages were stored in bursts: they are not the times of the measurement."""
    gaps = np.diff(log.times)
    pauses = gaps > max(BRIDGE_S, 5.0 * step)
    if pauses.sum() > 10 and gaps[pauses].sum() > 0.5 * gaps.sum():
        raise LogError(
            f"{log.source}: the times ({log.time_source}) come in bursts, {int(pauses.sum())} pauses of some "
            f"{np.median(gaps[pauses]):.2f} s with samples {1e3 * step:.3g} ms apart between them: "
            f"they cannot be the times of the movement"
        )


def _sound(name: str, times: Array, logged: Array, step: float, counts: Counts) -> tuple[Array, Array]:
    """Times and values that can be trusted, unwrapped."""
    finite = np.isfinite(logged)
    far = finite & (np.abs(np.where(finite, logged, 0.0)) > _LARGEST_RAD)
    _count(counts, "out of range", name, int(far.sum() + np.isinf(logged).sum()))
    t, x = times[finite & ~far], logged[finite & ~far]
    if len(x) < 4:
        return t, x
    _count(counts, "missing", name, int(np.maximum(np.round(np.diff(t) / step) - 1, 0).sum()))
    half = max(2, round(0.04 / step))
    # Far spikes go before the unwrapping, which would take one of nearly half a turn for a wrap and shift all after it.
    middle = np.arctan2(*(_running_median(t, part, half, step) for part in (np.sin(x), np.cos(x))))
    near = np.abs(np.angle(np.exp(1j * (x - middle)))) <= _FAR_SPIKE_RAD
    far_spikes = int((~near).sum())
    t, x = t[near], x[near]
    if len(x) < 4:
        _count(counts, "spikes", name, far_spikes)
        return t, x
    smooth = np.unwrap(x)
    _count(counts, "wraps", name, int((np.abs(np.diff(smooth - x)) > math.pi).sum()))
    smooth -= 2.0 * math.pi * np.round(np.median(smooth) / (2.0 * math.pi))
    apart = np.abs(smooth - _running_median(t, smooth, half, step))
    # A clean signal leaves its running median only where it bends: by half its acceleration times time squared.
    bend = math.radians(10.0) + 0.5 * _FASTEST_RAD_S2 * (0.5 * half * step) ** 2
    spike = apart > np.clip(4.0 * np.percentile(apart, 90.0), _SPIKE_RAD, bend)
    _count(counts, "spikes", name, far_spikes + int(spike.sum()))
    return t[~spike], smooth[~spike]


def _running_median(t: Array, x: Array, half: int, step: float) -> Array:
    """The median over `half` samples on either side, none of them beyond a gap, where the joint has moved on."""
    width = 2 * half + 1
    middle = np.asarray(median_filter(x, width, mode="nearest"), dtype=np.float64)
    gaps = np.flatnonzero(np.diff(t) > half * step) + 1
    for part in np.split(np.arange(len(x)), gaps) if len(gaps) else ():
        if len(part) >= width:  # fewer samples cannot tell a spike by themselves
            middle[part] = median_filter(x[part], width, mode="nearest")
    return middle


def _stuck_runs(name: str, sound: dict[str, tuple[Array, Array]]) -> Iterator[tuple[int, int]]:
    """First and last sample of each stretch in which a value stands still while another moves."""
    t, x = sound[name]
    if not len(x) or np.ptp(x) <= 1e-9:
        return  # constant over the whole log, such as a pelvis tilt that was set: not a stuck sensor
    edges = np.flatnonzero(np.concatenate([[True], np.abs(np.diff(x)) > 1e-9, [True]]))
    for start, after in itertools.pairwise(edges.tolist()):
        if t[after - 1] - t[start] < STUCK_S:
            continue
        others = [v[(u >= t[start]) & (u <= t[after - 1])] for key, (u, v) in sound.items() if key != name]
        if any(len(other) and np.ptp(other) > _MOVES_RAD for other in others):
            yield start, after - 1


def _on_clock(name: str, t: Array, x: Array, clock: Array, step: float, counts: Counts) -> Array:
    """The values at the ticks of `clock`; NaN outside them and in gaps that are too long to bridge."""
    if len(t) < 4:
        return np.full(len(clock), np.nan)
    bridge = max(BRIDGE_S, 1.5 * step)
    gaps = np.diff(t)
    # Where a value has many samples a tick, or two at almost the same time, their mean is what is meant.
    _, tick = np.unique(np.round((t - clock[0]) / (clock[1] - clock[0])), return_inverse=True)
    weight = np.bincount(tick)
    t_mean, x_mean = np.bincount(tick, t - clock[0]) / weight + clock[0], np.bincount(tick, x) / weight
    if len(t_mean) < 4:
        return np.full(len(clock), np.nan)
    values = np.asarray(Akima1DInterpolator(t_mean, x_mean)(np.clip(clock, t_mean[0], t_mean[-1])), dtype=np.float64)
    tolerance = 0.5 * (clock[1] - clock[0])
    values[(clock < t[0] - tolerance) | (clock > t[-1] + tolerance)] = np.nan
    for before in np.flatnonzero(gaps > bridge):
        values[(clock > t[before] + tolerance) & (clock < t[before + 1] - tolerance)] = np.nan
    _count(counts, "gaps bridged", name, int(((gaps > 1.5 * step) & (gaps <= bridge)).sum()))
    _count(counts, "gaps too long to bridge", name, int((gaps > bridge).sum()))
    return values


def _low_pass(values: Array, step: float) -> Array:
    """Each valid stretch filtered forward and backward; NaN elsewhere and where it is too short."""
    # Run twice, so the single pass has its -3 dB point higher (Winter, Biomechanics and Motor Control, 2.4).
    single = CUTOFF_HZ / (math.sqrt(2.0) - 1.0) ** 0.25
    sos = butter(2, min(single, 0.45 / step), fs=1.0 / step, output="sos")
    result = np.full(len(values), np.nan)
    valid = np.concatenate([[False], np.isfinite(values), [False]])
    for start, end in np.flatnonzero(valid[1:] != valid[:-1]).reshape(-1, 2):
        if (end - start) * step >= _SHORTEST_S:
            pad = min(end - start - 1, round(2.0 / (CUTOFF_HZ * step)))
            result[start:end] = sosfiltfilt(sos, values[start:end], padlen=pad)
    return result
