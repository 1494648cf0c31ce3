"""Which time a message has, and one time line from it: clock steps, messages out of order, bursts and equal times."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ggo_factors.recording.log.decode_many import MISSING, Times
from ggo_factors.recording.log.recorder_clock import in_nanoseconds, too_fast
from ggo_factors.support.inputs import Array

_SECOND = 10**9
_STEP = _SECOND
"""Jump in [ns] that is a step of the clock; a smaller one back is a message out of order."""
_DAY = 86_400 * _SECOND
"""A jump ahead by more in [ns] is a step of the clock, whatever the recorder's clock says."""
_SLOPE = 0.005
"""How much faster or slower than the recorder's clock a message clock may run without a note."""

COARSE = 0.5
"""A message's own times with fewer values than this share of the recorder's are too coarse to use."""
WRONG_UNIT = 50.0
"""A clock off by more than this factor is in another unit: no clock drifts so much."""


@dataclass
class Moments:
    """The clocks of messages in file order, each of shape (n,).

    Attributes:
        stamps: the messages' own times: whole [ns], or plain numbers of unknown unit, or None.
        log: when they were recorded in [ns].
        publish: when they were sent in [ns].
        path: the field of the messages' own time.
        scale: [ns] in one unit of plain numbers, or None where it must be told from the data.
        relative: whether the times are those of the points of a trajectory.
    """

    stamps: Times | Array | None
    log: Times
    publish: Times
    path: str
    scale: float | None = None
    relative: bool = False


@dataclass
class TimeLine:
    """Times for messages in file order.

    Attributes:
        ns: times in [ns] with all steps taken out, shape (n,); `MISSING` where a message has none.
        segment: number of the stretch between clock steps that each lies in, shape (n,).
        source: field or clock that they come from.
        notes: what was decided, in words; `dropped` says how many messages lost their place in time, and why.
    """

    ns: Times
    segment: Times
    source: str
    notes: list[str] = field(default_factory=list)
    dropped: list[tuple[int, str]] = field(default_factory=list)


def time_line(moments: Moments, recorder_only: bool = False) -> TimeLine:
    """One time line for the messages of a topic: their own stamps, else the publish times, else the log times.

    Args:
        moments: the clocks.
        recorder_only: leave the messages' own stamps aside.
    """
    notes: list[str] = []
    dropped: list[tuple[int, str]] = []
    log, unit = in_nanoseconds(moments.log)
    sent, sent_unit = in_nanoseconds(moments.publish)
    moments = replace(moments, log=log, publish=sent)
    ns, source = None, moments.path
    if moments.stamps is not None and not recorder_only:
        ns = _own(moments, notes)
    if ns is None:
        # a recorder that knows no publish times repeats its own
        if _runs(sent) and (sent >= 0).all() and (sent == 0).sum() <= 1 and not np.array_equal(sent, moments.log):
            ns, source = sent.copy(), "publish_time"
        else:
            ns, source, sent_unit = moments.log.copy(), "log_time", unit
        if sent_unit:
            notes.append(f"{source} counts {sent_unit}, not nanoseconds: read as such")
    if moments.relative and source == moments.path:
        source = "time_from_start"
    notes.insert(0, f"times from {source}")
    if lacking := int((ns == MISSING).sum()):
        dropped.append((lacking, "their time is missing or impossible"))
    strange = _strange(ns)
    if strange.any():
        ns[strange] = MISSING
        dropped.append((int(strange.sum()), "their time is far from that of their neighbours"))
    good = np.flatnonzero(ns != MISSING)
    times, segment, steps = _unstep(ns[good], moments.log[good], source in ("log_time", "time_from_start"))
    if len(steps) > max(3, len(good) // 100) and source != "log_time":
        line = time_line(Moments(None, moments.log, moments.log, ""))
        line.notes.insert(1, f"{source} jumps {len(steps)} times by a second or more (two clocks?) and is not used")
        return line
    if len(steps) > max(3, len(good) // 100) or (steps and _seamless(ns[good], moments.log[good])):
        times, segment, steps = ns[good], np.zeros(len(good), np.int64), []
        notes.append("messages are far out of order in the file: sorted by time")
    for seconds in steps:
        way = "back" if seconds < 0 else "ahead"
        notes.append(f"the clock steps {way} by {abs(seconds):.2f} s: split there, the step removed")
    if source not in ("log_time", "publish_time", "time_from_start"):
        _compare(ns[good], moments.log[good], segment, source, notes)
    _disorder(times, segment, notes)
    line_ns = np.full(len(ns), MISSING)
    line_segment = np.zeros(len(ns), np.int64)
    line_ns[good], line_segment[good] = times, segment
    return TimeLine(line_ns, line_segment, source, notes, dropped)


def spread_bursts(ns: Times) -> Times | None:
    """Times of messages that were recorded in bursts, spread evenly; None where they were not.

    Args:
        ns: times in [ns] in order, shape (n,).
    """
    steps = np.diff(ns)
    if len(steps) < 8 or ns[-1] == ns[0]:
        return None
    short = steps < 0.1 * float(ns[-1] - ns[0]) / len(steps)
    if short.mean() <= 0.5:
        return None
    last = np.flatnonzero(np.append(~short, True))  # the last message of each burst
    if len(last) < 3:
        return None
    at, index = (ns[last] - ns[last[0]]).astype(float), np.arange(len(ns))
    spread = np.interp(index, last, at)
    each = (at[1] - at[0]) / (last[1] - last[0])
    spread[: last[0]] = -each * (last[0] - index[: last[0]])
    spread_ns: Times = ns[last[0]] + np.rint(spread).astype(np.int64)
    return spread_ns


def _own(moments: Moments, notes: list[str]) -> Times | None:
    stamps = moments.stamps
    assert stamps is not None
    if stamps.dtype == np.int64:
        # Zero is a stamp that was never set, but in a log that itself begins at zero.
        ns = np.where((stamps == 0) & (moments.log != 0), MISSING, stamps)
    else:
        scale = moments.scale or _unit(stamps.astype(np.float64), moments.log)
        if scale is None:
            notes.append(f"{moments.path} does not advance and is not used")
            return None
        with np.errstate(invalid="ignore", over="ignore"):
            scaled = stamps * scale
            good = np.abs(scaled) < 9e18
            ns = np.where(good, np.rint(np.where(good, scaled, 0)).astype(np.int64), MISSING)
    good = ns != MISSING
    if good.mean() < 0.9:
        what = "is never set" if not good.any() else f"is missing in {int((~good).sum())} of {len(ns)} messages"
        notes.append(f"{moments.path} {what} and is not used")
        return None
    if not _runs(ns[good]):
        notes.append(f"{moments.path} is the same in all messages and is not used")
        return None
    if fault := _worse_than_recorders(ns[good], moments.log[good]):
        notes.append(f"{moments.path} {fault} and is not used")
        return None
    return ns.astype(np.int64)


def _worse_than_recorders(ns: Times, log: Times) -> str:
    """What makes a message's own times useless beside the recorder's, or nothing."""
    own, recorded = len(np.unique(ns)), len(np.unique(log))
    if own < COARSE * recorded and recorded > 0.9 * len(log):
        return f"has only {own} values in {len(ns)} messages"
    # The typical step, which a clock that is set once does not change; and the whole, which bursts do not.
    steps = np.diff(ns)
    if not len(steps) or (steps < 0).mean() > 0.1 or too_fast(log):
        return ""  # several clocks, or messages out of order: decided later
    step, recorders = float(np.median(steps)), float(np.median(np.diff(log)))
    past = int(log[-1] - log[0])
    if past > 0 and 1.0 / WRONG_UNIT < float(ns[-1] - ns[0]) / past < WRONG_UNIT:
        return ""
    if step > 0.0 and recorders > 0.0 and not 1.0 / WRONG_UNIT < step / recorders < WRONG_UNIT:
        return f"runs {step / recorders:.3g} times as fast as the recorder's clock"
    return ""


def _runs(ns: Times) -> bool:
    return len(ns) == 1 or bool((ns != ns[0]).any())


def _unit(stamps: Array, log: Times) -> float | None:
    # seconds, or a thousandth, millionth, billionth of it: whichever agrees best with the recorder's clock
    good = np.isfinite(stamps)
    if good.sum() < 2:
        return 1e9
    low, high = np.percentile(stamps[good], (10, 90))
    if high <= low:
        return None
    past, now = np.percentile((log[good] - log[good][0]).astype(float), (10, 90))
    if now <= past:
        return 1e9
    if too_fast(log):  # written at once: the unit with which the rate is one of joints, 2 kHz to 5 Hz
        step = float(np.median(np.abs(np.diff(stamps[good]))))
        return next((scale for scale in (1e9, 1e6, 1e3, 1.0) if 5e5 <= step * scale <= 2e8), 1e9)
    return min((1e9, 1e6, 1e3, 1.0), key=lambda scale: abs(np.log(scale * (high - low) / (now - past))))


def _strange(ns: Times) -> NDArray[np.bool_]:
    # single times that are more than 10 s away from the median of their neighbours
    out = np.zeros(len(ns), bool)
    good = np.flatnonzero(ns != MISSING)
    if len(good) < 5:
        return out
    times = ns[good].astype(float) - float(ns[good[0]])
    jumps = np.abs(np.diff(times))
    if jumps.max() < 10 * _SECOND:
        return out
    from scipy.ndimage import median_filter

    half = 15
    middle = median_filter(times, size=2 * half + 1, mode="mirror")
    limit = 10 * _SECOND + 4 * half * float(np.median(jumps))
    out[good] = np.abs(times - middle) > limit
    return out


def _unstep(ns: Times, log: Times, own_clock: bool) -> tuple[Times, Times, list[float]]:
    # times without the clock's steps, the number of each one's stretch, and the steps in [s]
    if len(ns) < 2:
        return ns, np.zeros(len(ns), np.int64), []
    ahead, logged = np.diff(ns), np.diff(log)
    back = ahead <= -_STEP
    jump = ahead > _DAY
    if not own_clock:
        jump |= (ahead >= _STEP) & (ahead - logged >= np.maximum(_STEP, 0.6 * logged))
    at = np.flatnonzero(back | jump)
    if not len(at):
        return ns, np.zeros(len(ns), np.int64), []
    if len(at) > max(3, len(ns) // 100):
        return ns, np.zeros(len(ns), np.int64), [0.0] * len(at)
    usual = int(np.median(np.abs(ahead)))
    times, segment = ns.copy(), np.zeros(len(ns), np.int64)
    bounds = [*(at + 1).tolist(), len(ns)]
    for number, (a, b) in enumerate(pairwise(bounds), 1):
        step = int(logged[a - 1])
        gap = step if not own_clock and 0 < step < 60 * _SECOND else max(usual, 1)
        times[a:b] += int(times[:a].max()) + gap - int(ns[a:b].min())
        segment[a:b] = number
    return times, segment, [float(ahead[i]) * 1e-9 for i in at]


def _seamless(ns: Times, log: Times) -> bool:
    # whether stretches lie in the wrong order (a file may hold its chunks in any), and fit together without a seam
    steps = np.diff(ns)
    cuts = np.flatnonzero(np.abs(steps) >= _STEP)
    if (np.abs(np.diff(log)[cuts]) < _STEP).any():
        return False
    ends = sorted((int(s.min()), int(s.max())) for s in np.split(ns, cuts + 1))
    return all(0 < b[0] - a[1] < 20 * float(np.median(np.abs(steps))) for a, b in pairwise(ends))


def _compare(ns: Times, log: Times, segment: Times, source: str, notes: list[str]) -> None:
    # does the messages' clock run as fast as the recorder's?
    longest = segment == np.bincount(segment).argmax() if len(segment) else segment == 0
    a, b = log[longest], ns[longest]
    if too_fast(a):
        notes.append("the recorder's clock is too fast for a measurement (written at once?): not compared with it")
        return
    if len(a) < 20 or a[-1] - a[0] < 2 * _SECOND:
        return
    x, y = (a - a[0]) * 1e-9, (b - b[0]) * 1e-9
    x = x - x.mean()
    limit = max(_SLOPE, 0.02 / (float(a[-1] - a[0]) * 1e-9))
    slope = float((x * (y - y.mean())).sum() / (x * x).sum())
    if abs(slope - 1) <= limit:
        return
    ahead = (b - a) * 1e-9
    at = int(np.abs(np.diff(ahead)).argmax()) + 1
    step = float(ahead[at] - ahead[at - 1])
    y[at:] -= step
    if abs(float((x * (y - y.mean())).sum() / (x * x).sum()) - 1) <= limit:
        notes.append(
            f"{source} steps {'ahead' if step > 0 else 'back'} by {abs(step):.2f} s against the recorder's clock at "
            f"{(a[at] - a[0]) * 1e-9:.2f} s: too little to remove, so a stride there is too long or too short"
        )
    else:
        notes.append(
            f"{source} runs {slope:.3f} times as fast as the recorder's clock: the cadence depends on the clock"
        )


def _disorder(times: Times, segment: Times, notes: list[str]) -> None:
    late = (np.diff(times) < 0) & (np.diff(segment) == 0)
    if late.any():
        worst = float((np.maximum.accumulate(times) - times).max()) * 1e-9
        notes.append(
            f"{int(late.sum())} messages have a time before that of an earlier one (up to {worst:.3f} s): sorted"
        )
