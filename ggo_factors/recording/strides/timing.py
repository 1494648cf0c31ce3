"""Whether the legs keep one time: a leg that was logged by a clock of its own steps too early, too late, or drifts."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ggo_factors.recording.strides.cut_strides import TIME_OFF, Cycles
from ggo_factors.recording.strides.steps import LEGS
from ggo_factors.support.inputs import Array

UNEVEN = 0.08
"""Noted: a leg that lands further from the middle of the other's stride, in strides; healthy ones stay within 0.03."""
_STEADY = 0.05
"""Largest spread of that place about its own line in a walk whose clocks run evenly, in strides."""
_DRIFT = 0.1
"""A place that moves so far over a recording, in strides, is noted."""
_RATE = 0.015
"""Stride times of the legs that differ by a larger share, and surely, are noted: over minutes both legs step alike."""


def clock_notes(cycles: Cycles) -> Iterator[str]:
    """What speaks for a clock of each leg, or a limp."""
    times, places, stride = _landings(cycles)
    if len(places) < 3:
        return
    turns = np.unwrap(places, period=1.0)
    line = np.polyfit(times, turns, 1) if np.ptp(times) > 0.0 else np.array([0.0, float(turns.mean())])
    drift, around = float(line[0] * np.ptp(times)), float(np.std(turns - np.polyval(line, times)))
    place = float(np.mean(turns) % 1.0)
    if abs(drift) > _DRIFT and around < _STEADY:
        yield (
            f"the left leg moves by {drift:+.2f} of a stride against the right one over the recording: two clocks that "
            "run at different rates?"
        )
    elif abs(place - 0.5) > UNEVEN and around < _STEADY:
        yield (
            f"the left leg lands at {100.0 * place:.0f} % of the right one's stride, {abs(place - 0.5) * stride:.2f} s "
            f"{'late' if place > 0.5 else 'early'}: a limp, or a clock of its own"
        )
    means, errors = {}, {}
    for leg in LEGS:
        rows = np.array(
            [s.duration for s in cycles.strides if s.leg == leg and abs(s.duration / stride - 1.0) < TIME_OFF]
        )
        if len(rows) < 3:
            return
        means[leg], errors[leg] = float(rows.mean()), float(rows.std(ddof=1) / np.sqrt(len(rows)))
    apart = means["left"] - means["right"]
    if abs(apart) > _RATE * stride and abs(apart) > 4.0 * float(np.hypot(errors["left"], errors["right"])):
        yield (
            f"a stride takes {means['right']:.3f} s with the right leg and {means['left']:.3f} s with the left: no "
            "walker's does; two clocks that run at different rates?"
        )


def _landings(cycles: Cycles) -> tuple[Array, Array, float]:
    """When the left leg lands in strides of the right one, and where in them, 0 to 1; and the median stride time."""
    stride = float(np.median([s.duration for s in cycles.strides] or [np.nan]))
    left, found = cycles.strikes["left"], []
    for s in cycles.strides:
        if s.leg == "right" and abs(s.duration / stride - 1.0) < TIME_OFF:
            inside = left[(left > s.start) & (left <= s.end)]
            found += [(s.start, float((inside[0] - s.start) / s.duration))] if len(inside) == 1 else []
    times, places = np.array(found).reshape(-1, 2).T
    return times, places, stride
