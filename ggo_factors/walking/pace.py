"""The pace along a walk: the path stays, and is walked slower where the joints, or the landing foot, would be too fast.

The pace is ds/dt, s the time at the base gait's pace. Its square b(s) is the largest that all limits leave, by a linear
program: along a path q(s) a joint's acceleration is q'' b + q' b'/2, linear in b, and its speed bounds b itself
(Verscheure et al., IEEE TAC 54(10), 2009). What is added is that the pace changes slowly.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.played import Played
from ggo_factors.support.inputs import Array

LEAST_LANDING_SPEED = 1.0
"""A foot may land at least so fast in [m/s], downwards; or `LANDS_FASTER` times as fast as the base gait's."""
LANDS_FASTER = 1.2
CELLS = 60
"""The pace is linear over at most so many cells a step, between frames."""
BENDS_OVER = 0.2
"""Share of a step's time within which the pace may change from 0 to 1, and its change too: no bang-bang."""
AT_ONCE = 0.02
"""The same where a walker who moves must slow down as fast as the joints let him."""
WITHIN = 0.998
"""Share of the limits that is used: the spline through the slowed frames is not quite the path."""
SLOWEST = 1e-3
"""No pace is smaller."""
EVEN = 1e-9
"""A pace squared this near to 1 is 1."""
MOST_PROGRAMS = 6
"""So often the limits are drawn in by what the played trajectory still goes beyond them."""


def allowed_landing_speed(base: Gait, model: LegModel) -> float:
    """How fast a foot may come down at landing in [m/s], for a base gait."""
    heights = model.endpoint(base.frames[-2:])[:, 1]
    return max(LEAST_LANDING_SPEED, LANDS_FASTER * float(heights[0] - heights[1]) / base.dt)


def slowed_times(
    path: Played, limits: JointLimits | None, most: Array, step_time: float, first: int, held: bool
) -> Array | None:
    """Times at which a path is walked as fast as it may be, never faster than it is given.

    Args:
        path: the path at the base gait's pace.
        limits: of its joints, or None.
        most: largest pace at each frame, 0 to 1, shape (k,).
        step_time: time of a step in [s], for how slowly the pace changes.
        first: number of the frame that the walker is in; those before it stay.
        held: whether the pace there is that of the path.

    Returns:
        Time of each frame in [s], shape (k,); those of the path itself where nothing speaks against it; None where the
        joints cannot slow down in time.
    """
    # What bends at a frame whose pace is given is given too.
    free = first + held
    if most[first:].min() >= 1.0 and (limits is None or _excess(path, limits, free) <= 1.0):
        return path.times
    drawn_in = limits
    for _ in range(MOST_PROGRAMS):
        pace = _program(path, drawn_in, most, step_time, first, held, smooth=True)
        if pace is None and held:
            pace = _program(path, drawn_in, most, step_time, first, held, smooth=False)
        if pace is None:
            return None
        times = path.times.copy()
        times[first:] += np.concatenate([[0.0], _delays(path.times[first:], *pace)])
        if limits is None or drawn_in is None:
            return times
        excess = _excess(replace(path, times=times), limits, free)
        if excess <= 1.0:
            return times
        drawn_in = drawn_in.tightened(1.0 - WITHIN / excess)
    return None


def _excess(path: Played, limits: JointLimits, first: int) -> float:
    """By how many times the trajectory goes beyond a limit of rates, at worst."""
    speeds, bends = path.fastest[max(first - 1, 0) :], path.accelerations[first:]
    return max(float(np.abs(speeds / limits.speed).max()), float(np.abs(bends / limits.acceleration).max()))


def _program(
    path: Played,
    limits: JointLimits | None,
    most: Array,
    step_time: float,
    first: int,
    held: bool,
    smooth: bool,
) -> tuple[Array, Array] | None:
    """Places s in [s] and the pace squared there, from the frame `first` on; None where there is none.

    Where it must be, the pace changes as suddenly as the limits let it: not `smooth`.
    """
    from scipy.optimize import linprog  # here, since it takes longer to import than all the rest
    from scipy.sparse import coo_array, vstack

    every = max(1, round(step_time / CELLS / float(np.median(np.diff(path.times)))))
    knots = np.unique(np.append(np.arange(first, len(path.times), every), len(path.times) - 1))
    places, count = path.times[knots], len(knots)
    lengths = np.diff(places)
    # The pace of a cell is bounded by all frames in it.
    within = np.minimum.reduceat(most, knots)
    high = np.minimum(within, np.append(1.0, np.minimum(within[:-1], most[knots[1:]]))) ** 2
    bends = (BENDS_OVER if smooth else AT_ONCE) * step_time
    rows = [(np.arange(count - 1), -1.0 / lengths, 1.0 / lengths, np.full(count - 1, 2.0 / bends))]
    if limits is not None:
        rows += _rate_rows(path, limits, places, bends, held, high)
    starts, before, after, bounds = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    # The change of the pace squared changes slowly too.
    row, inner = np.arange(len(starts)), np.arange(1, count - 1)
    own, both = len(starts) + inner - 1, lengths[:-1] + lengths[1:]
    left, right = 2.0 / (lengths[:-1] * both), 2.0 / (lengths[1:] * both)
    values = np.concatenate([before, after, left, -(left + right), right])
    columns = np.concatenate([starts, starts + 1, inner - 1, inner, inner + 1])
    entries = (values, (np.concatenate([row, row, own, own, own]), columns))
    one_way: Any = coo_array(entries, shape=(len(starts) + len(inner), count)).tocsr()
    bounds = np.tile(np.append(bounds, np.full(len(inner), 4.0 / bends**2)), 2)
    low = np.full(count, SLOWEST**2)
    if held:
        low[0] = high[0] = 1.0
    weights = np.append(lengths, 0.0) + np.append(0.0, lengths)
    box: Any = np.stack([low, high], -1)
    found: Any = linprog(-weights, A_ub=vstack([one_way, -one_way]), b_ub=bounds, bounds=box, method="highs")
    if found.status != 0:
        return None
    pace = np.clip(found.x, low, high)
    return places, np.where(pace > 1.0 - EVEN, 1.0, pace)


def _rate_rows(
    path: Played, limits: JointLimits, places: Array, bends: float, held: bool, high: Array
) -> list[tuple[Any, Any, Any, Any]]:
    """Rows that bound the joints' accelerations: cells, weights of b where each begins and ends, the bounds.

    `high`, the largest b at each place, is lowered to what the joints' speeds leave.
    """
    rows, lengths = [], np.diff(places)
    for share in (0.0, 0.5, 1.0):
        _, speeds, bent = path.at(places[:-1] + share * lengths)
        fast = (limits.speed / np.maximum(np.abs(speeds), 1e-12)).min(axis=1) ** 2
        high[:-1], high[1:] = np.minimum(high[:-1], fast), np.minimum(high[1:], fast)
        # A row that no pace within the other bounds can break is left out.
        bind = np.abs(bent) + np.abs(speeds) / bends > limits.acceleration
        if held and not share:
            bind[0] = False
        here, joint = np.nonzero(bind)
        turn, along = bent[here, joint], speeds[here, joint] / (2.0 * lengths[here])
        rows.append((here, (1.0 - share) * turn - along, share * turn + along, limits.acceleration[joint]))
    return rows


def _delays(times: Array, places: Array, squares: Array) -> Array:
    """By how much later than at the base gait's pace each frame but the first is reached in [s]."""
    roots = np.sqrt(squares)
    whole = np.concatenate([[0.0], np.cumsum(np.diff(places) * (2.0 / (roots[:-1] + roots[1:]) - 1.0))])
    cell = np.clip(np.searchsorted(places, times[1:], side="left") - 1, 0, len(places) - 2)
    on = times[1:] - places[cell]
    here = np.sqrt(squares[cell] + (squares[cell + 1] - squares[cell]) * on / np.diff(places)[cell])
    return whole[cell] + on * (2.0 / (roots[cell] + here) - 1.0)
