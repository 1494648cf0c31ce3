"""The recorder's clock: in which unit it counts, and whether it can have run while the person walked."""

from __future__ import annotations

import numpy as np

from ggo_factors.recording.log.decode_many import MISSING, Times

FASTEST_NS = 10**5
"""Least mean time in [ns] between messages of a topic, 10 kHz: joints are logged at 10 Hz to 2 kHz."""
_UNITS = ((10**3, "microseconds"), (10**6, "milliseconds"), (10**9, "seconds"))
_EPOCH = (10**18, 4 * 10**18)
"""Times of the years 2001 to 2096 in [ns]: a clock that counts another unit lies far outside."""
_REGULAR = 0.8
"""Share of steps near the typical one in a clock that ran with the measurement, not with a program that wrote it."""


def too_fast(times: Times) -> bool:
    """Whether messages follow each other faster than any joint is measured."""
    good = times[times != MISSING]
    return len(good) > 7 and good[-1] > good[0] and int(good[-1] - good[0]) < FASTEST_NS * (len(good) - 1)


def in_nanoseconds(times: Times) -> tuple[Times, str]:
    """Times of the recorder in [ns], and the unit that they were in where it is another; "" where it is not.

    A clock that is too fast counts microseconds, milliseconds or seconds where these give a time of our days, or, of a
    clock that starts near zero, where its steps are regular and give a rate at which joints are measured.
    """
    if not too_fast(times):
        return times, ""
    middle = int(np.median(times))
    for factor, unit in _UNITS:
        if _EPOCH[0] <= middle * factor <= _EPOCH[1]:
            return times * factor, unit
    steps = np.abs(np.diff(times)).astype(float)
    typical = float(np.median(steps))
    near = (steps >= 0.5 * typical) & (steps <= 2.0 * typical)
    if middle >= _EPOCH[0] or typical == 0.0 or near.mean() < _REGULAR:
        return times, ""
    for factor, unit in _UNITS:
        if typical * factor >= FASTEST_NS:
            return times * factor, unit
    return times, ""
