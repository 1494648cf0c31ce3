"""Several sources on one topic: a second publisher, commands beside states, zeros between. One walker has one source.

Sources are told apart by their channel, their frame and the joints that they name; where all of these agree, as in a
bag that gives a topic one channel, by messages that alternate between two motions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ggo_factors.recording.log.decode_many import Times
from ggo_factors.support.inputs import Array

SAME_SENDER = "messages of"
"""How a source is called that is known by the joints that it names alone; one sender may leave some out."""
ALIKE = 0.03
"""Sources whose values differ by less, in the median and in ranges of motion, say the same."""
_SWITCHES = 10
"""Fewer changes from source to source are restarts, one after the other, and no mixture."""
_COMPARED_S = 0.06
"""Longest time in [s] between two messages of a source between which another one is compared with it."""
_CONSTANT = 0.02
"""Least share of messages with one and the same pose that can be a source that does not move."""
_RUN = 5.0
"""Longest run of that pose, in the mean, that lies between the messages of another source and is no standing still."""
_WINDOWS, _WIDTH, _REACH, _JOINTS = 25, 200, 6, 8
"""Stretches that are looked at for two motions, messages in each, how far apart those of one motion may lie, and joints
that are looked at."""
_CLOSE = 0.25
"""Share of a jump within which a message of either motion has another of its own."""
_JUMPS = {1: np.inf, 2: 0.12, 3: 0.12}
"""Least jump in ranges of motion, by the number of joints; `ALIKE` with more: noise seldom moves four alike."""
_MIXED = 0.15
"""Share of steps that are such jumps in a mixture; single spikes have no others of their own."""
_LAG = 0.4
"""A mixture with a fixed pattern: its steps over a few messages are on average so much shorter than over one."""

Mask = NDArray[np.bool_]


class MixedError(Exception):
    """A topic holds more than one motion; the text says how that is seen."""


def one_source(values: Array, ns: Times, source: Times, words: list[str], notes: list[str]) -> Mask | None:
    """Which messages are those of the one source that moves; None: all.

    Args:
        values: in file order, shape (n, k).
        ns: times in [ns], shape (n,).
        source: number of the source of each, as far as the log tells, shape (n,).
        words: what each number stands for.
        notes: gets what was left out.

    Raises:
        MixedError: where there are several, and they move differently.
    """
    keep = _moving(values, notes)
    if keep is not None:
        values, ns, source = values[keep], ns[keep], source[keep]
    scale = _ranges(values)
    if not scale.any():
        return keep
    if len(words) > 1:
        _compare_sources(values / scale, ns, source, words, notes)
    jumps = _jumping(values / scale)
    if (
        jumps > 0.0 and (np.diff(ns) < 0).any()
    ):  # in the order of the times, too: stamps may be out of order, or messages
        jumps = _jumping(values[np.argsort(ns, kind="stable")] / scale)
    if jumps > 0.0:
        raise MixedError(
            f"its messages alternate between two motions, {100.0 * jumps:.0f} % of the range of motion apart in the "
            "median: two walkers, or commands beside states? A base gait needs one; record or filter it by itself"
        )
    return keep


def _ranges(values: Array) -> Array:
    # the range of motion of each column, infinite where it does not move
    result = np.full(values.shape[1], np.inf)
    for i, column in enumerate(values[:: max(1, len(values) // 20_000)].T):
        finite = column[np.isfinite(column)]
        if len(finite) > 3:
            low, high = np.percentile(finite, (1.0, 99.0))
            result[i] = high - low if high > low else np.inf
    return result


def _moving(values: Array, notes: list[str]) -> Mask | None:
    """Mask without the messages of a source that does not move, between those of one that does."""
    some = values[np.linspace(0, len(values) - 1, 400).astype(int)] if len(values) > 20 else values[:0]
    rows, counts = np.unique(some, axis=0, return_counts=True)
    for pose in rows[counts >= max(2.0, 0.5 * _CONSTANT * len(some))]:
        still = (values == pose).all(axis=1)
        edges = np.flatnonzero(np.diff(still))
        runs = 0.5 * (len(edges) + 1)
        if not _CONSTANT <= still.mean() < 1.0 or len(edges) < 2 * _SWITCHES or still.sum() > _RUN * runs:
            continue
        jump = np.median(np.nanmax(np.abs(values[edges + 1] - values[edges]), axis=1))
        rest = values[~still]
        step = np.median(np.nanmax(np.abs(np.diff(rest, axis=0)), axis=1)) if len(rest) > 2 else np.inf
        if jump > 3.0 * step:
            what = "zero in every joint" if not pose.any() else "one and the same pose"
            notes.append(
                f"{int(still.sum())} messages hold {what} between the others: a source that does not move, left out"
            )
            moving: Mask = ~still
            return moving
    return None


def _compare_sources(scaled: Array, ns: Times, source: Times, words: list[str], notes: list[str]) -> None:
    """Refuse sources that go on side by side and differ; note those that say the same."""
    counts = np.bincount(source, minlength=len(words))
    main = int(counts.argmax())
    for other in np.flatnonzero(counts).tolist():
        pair = (source == main) | (source == other)
        if other == main or np.count_nonzero(np.diff(source[pair])) < _SWITCHES:
            continue
        apart = _apart(scaled[source == main], ns[source == main], scaled[source == other], ns[source == other])
        if apart is None:
            continue
        both = f"{words[main]} ({counts[main]} messages) and {words[other]} ({counts[other]})"
        if apart > ALIKE:
            raise MixedError(
                f"it has two sources, {both}, {100.0 * apart:.0f} % of the range of motion apart in the median: two "
                "walkers, or commands beside states? A base gait needs one; record or filter it by itself"
            )
        if not words[other].startswith(SAME_SENDER):
            notes.append(f"two sources, {both}, say the same: both are read")


def _apart(a: Array, a_ns: Times, b: Array, b_ns: Times) -> float | None:
    # how far b lies from a in the median, in ranges of motion; None where they cannot be compared
    order = np.argsort(a_ns, kind="stable")
    a, a_ns = a[order], a_ns[order]
    if len(a) < 2:
        return None
    right = np.clip(np.searchsorted(a_ns, b_ns), 1, len(a) - 1)
    gap = (a_ns[right] - a_ns[right - 1]).astype(float)
    near = (a_ns[right - 1] <= b_ns) & (b_ns <= a_ns[right]) & (gap < _COMPARED_S * 1e9)
    part = ((b_ns - a_ns[right - 1]) / np.maximum(gap, 1.0))[:, None]
    off = np.abs(b - (a[right - 1] + part * (a[right] - a[right - 1])))[near]
    off = off[np.isfinite(off).any(axis=1)]
    return float(np.median(np.nanmax(off, axis=1))) if len(off) >= _SWITCHES else None


def _jumping(scaled: Array) -> float:
    """Median jump between two motions that alternate, in ranges of motion; 0 where there is one."""
    scaled = scaled[:, np.isfinite(scaled).mean(axis=0) > 0.5]
    scaled = scaled[np.isfinite(scaled).all(axis=1)]
    n, joints = scaled.shape
    if n < 4 * _REACH or not joints:
        return 0.0
    width = min(n, _WIDTH)
    starts = np.unique(np.linspace(0, n - width, _WINDOWS).astype(int))
    x = scaled[starts[:, None] + np.arange(width), :_JOINTS]
    apart = [np.abs(x[:, lag:] - x[:, :-lag]) for lag in range(1, _REACH + 1)]
    largest = [part.max(axis=2) for part in apart]
    mean = [float(part.mean()) for part in largest]
    if mean[0] > 0.01 and min(mean[1:]) < _LAG * mean[0]:
        return mean[0]
    if joints == 1:
        return 0.0
    jump = np.partition(apart[0], -2, axis=2)[:, :, -2]
    ahead, behind = (np.full((_REACH, *x.shape[:2]), np.inf) for _ in range(2))
    for lag, part in enumerate(largest, 1):
        ahead[lag - 1, :, :-lag] = part
        behind[lag - 1, :, lag:] = part
    # On either side of a jump there is another message of the same motion.
    before = np.minimum(ahead[1:].min(axis=0), behind.min(axis=0))[:, :-1]
    after = np.minimum(ahead.min(axis=0), behind[1:].min(axis=0))[:, 1:]
    switch = (jump > _JUMPS.get(joints, ALIKE)) & (before < _CLOSE * jump) & (after < _CLOSE * jump)
    return float(np.median(jump[switch])) if switch.mean() > _MIXED else 0.0
