"""Touchdown posture: how a base gait lands on a foothold that is not its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from ggo_factors.check.report import STANDARD
from ggo_factors.errors import UnreachableFootholdError
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

Symmetric = tuple[float, float, float]
"""A symmetric matrix of two rows: first, mixed and second entry."""

STRAIGHTEST = math.radians(5.0)
"""No knee lands straighter than this, in [rad], unless the base gait's own does: people land at 2 to 8 degrees, and a
straight leg cannot yield to the impact."""
BOUND_GAIN = 1e7
"""Weight of the square of a bound's excess against the square of the distance: bounds give way to nearness by less than
0.001 degrees, and as little as possible where foothold and shank leave no choice."""
BOUND_SLACK = math.radians(0.01)
"""Largest excess over the check's tolerances in [rad] of a posture that counts: bounds give way by less."""
NEAR = 0.1
"""A posture whose angles differ from the base gait's by no more than this sum of squares in [rad^2] (9 degrees in the
mean) is the nearest; further away there are others, mirrored in the feet, and the search begins elsewhere too."""
AGREED = 1e-6
"""Two searches whose sums of squares differ by less in [rad^2] have found the same posture, and no third is made."""
OTHER_SUPPORTS = np.radians([[-10.0, 8.0], [30.0, 40.0], [45.0, 10.0]])
"""Supporting legs ``[alpha1, beta1]`` in [rad] that the search starts from besides: behind the hip, before it, deeply
bent."""
LARGEST_STEP = 0.6
"""Largest change of an angle in one Newton step in [rad]: beyond, the motion of the swing ankle is far from linear."""
MOST_STEPS = 20
"""Limit of Newton steps; 4 to 8 are taken where there is a posture."""
CONVERGED = 1e-10
"""Change in [rad], and distance from the foothold in [m], at which the steps end."""


def touchdown_posture(
    model: LegModel, landing: Array, foothold: tuple[float, float], shank_angle: float | None = None
) -> Array | None:
    """The frame nearest to a base gait's last one that lands on a foothold.

    Nearest in the sum of squares over the four angles, with the swing ankle on the foothold, the shank at its angle,
    and no knee straighter than it lands in the base gait or `STRAIGHTEST`, whichever is less. Where not all can be met,
    nearness gives way first, then the least knee angles; without foothold and shank there is no posture.

    Args:
        model: the legs.
        landing: last frame of the base gait in [rad], shape (4,).
        foothold: where the swing ankle lands in [m], shape (2,).
        shank_angle: angle of the swinging shank to the ground in [rad], pi/2 where it is upright; free if None.

    Returns:
        The frame in [rad], shape (4,); None where the legs do not reach, or only with a joint beyond the check's
        `STANDARD` tolerances.
    """
    return posture_on(foothold, model, tuple(landing.tolist()), shank_angle)


@lru_cache(maxsize=64)
def posture_on(
    foothold: tuple[float, float], model: LegModel, last: tuple[float, ...], shank_angle: float | None
) -> Array | None:
    """`touchdown_posture`, of what can be looked up: a walk has many steps that are alike."""
    landing = np.array(last)
    if math.hypot(*foothold) > 2.0 * model.reach:
        return None
    lower = np.array([STANDARD.thigh_back, STANDARD.knee, STANDARD.thigh_back, STANDARD.knee])
    upper = np.array([STANDARD.thigh_forward, STANDARD.knee_bent, STANDARD.thigh_forward, STANDARD.knee_bent])
    floor = lower.copy()
    floor[1::2] = np.maximum(lower[1::2], np.minimum(landing[1::2], STRAIGHTEST))
    tilt = None if shank_angle is None else shank_angle - math.pi / 2.0
    best, least = None, math.inf
    for start in _starts(landing, model, foothold):
        try:
            frame = _nearest(start, landing, model, foothold, tilt, (floor, upper))
        except (ZeroDivisionError, OverflowError):
            continue  # legs that are one straight line
        if frame is None or (frame < lower - BOUND_SLACK).any() or (frame > upper + BOUND_SLACK).any():
            continue
        change, below = frame - landing, np.minimum(frame - floor, 0.0)
        cost = float(change @ change + BOUND_GAIN * (below @ below))
        if cost <= NEAR or abs(cost - least) < AGREED:
            best = frame
            break
        if cost < least:
            best, least = frame, cost
    if best is not None:
        best.setflags(write=False)
    return best


def _starts(wanted: Array, model: LegModel, foothold: tuple[float, float]) -> Iterator[Array]:
    """Frames to search from, shape (4,) in [rad]."""
    yield wanted
    for support in OTHER_SUPPORTS:
        try:
            yield np.concatenate([support, model.inverse_kinematics(foothold, support)])
        except UnreachableFootholdError:
            continue
    ahead, up = foothold
    apart = math.hypot(ahead, up)
    if apart > 0.0:
        # Both legs straight, the hip above the middle between the feet.
        high = math.copysign(math.sqrt(model.reach**2 - apart**2 / 4.0) / apart, ahead)
        x, y = ahead / 2.0 - high * up, up / 2.0 + high * ahead
        yield np.array([math.atan2(-x, y), 0.0, math.atan2(ahead - x, y - up), 0.0])


def _nearest(
    start: Array,
    wanted: Array,
    model: LegModel,
    foothold: tuple[float, float],
    tilt: float | None,
    bounds: tuple[Array, Array],
) -> Array | None:
    """The frame nearest to `wanted` under the constraints, by Newton steps on the Lagrangian; None if there is none.

    In plain floats: the Hessian of each leg is a block of its own, so a step is two systems of two unknowns and one of
    the two multipliers. With a tilt the swinging leg has one unknown, since its knee follows its thigh.

    Args:
        start: where to start, shape (4,) in [rad].
        wanted: shape (4,) in [rad].
        model: the legs.
        foothold: where the swing ankle is in [m].
        tilt: alpha2 - beta2 in [rad], or None where it is free.
        bounds: lowest and highest angles in [rad], each shape (4,), which count `BOUND_GAIN`.
    """
    target, limits = wanted.tolist(), tuple(zip(*(bound.tolist() for bound in bounds), strict=True))
    frame = start.tolist()
    if tilt is not None:
        frame[3] = frame[2] - tilt
    by_x = by_y = 0.0
    for _ in range(MOST_STEPS):
        x, y, row_x, row_y = model.endpoint_rows(np.array(frame))
        pull, stiff = [0.0] * 4, [1.0] * 4
        for n, (angle, (low, high)) in enumerate(zip(frame, limits, strict=True)):
            pull[n] = target[n] - angle
            if not low <= angle <= high:
                stiff[n] += BOUND_GAIN
                pull[n] += BOUND_GAIN * ((low if angle < low else high) - angle)
        # The second derivative of a link by its angle is its first one, turned by a right angle.
        turned = [by_x * down - by_y * along for along, down in zip(row_x, row_y, strict=True)]
        first = _inverse(stiff[0] - turned[0], -turned[1], stiff[1] + turned[1])
        if tilt is None:
            second = _inverse(stiff[2] - turned[2], -turned[3], stiff[3] + turned[3])
        else:
            one = 1.0 / (stiff[2] + stiff[3] - turned[2] - turned[3])
            second = one, one, one
        free, along_x, along_y = (_times(first, second, column) for column in (pull, row_x, row_y))
        off_x = foothold[0] - x - _dot(row_x, free)
        off_y = foothold[1] - y - _dot(row_y, free)
        xx, xy, yy = _inverse(_dot(row_x, along_x), _dot(row_x, along_y), _dot(row_y, along_y))
        by_x, by_y = -(xx * off_x + xy * off_y), -(xy * off_x + yy * off_y)
        change = [f - by_x * a - by_y * b for f, a, b in zip(free, along_x, along_y, strict=True)]
        largest = max(map(abs, change))
        if not math.isfinite(largest):
            return None
        share = min(1.0, LARGEST_STEP / max(largest, LARGEST_STEP))
        frame = [angle + share * step for angle, step in zip(frame, change, strict=True)]
        if largest < CONVERGED and math.hypot(foothold[0] - x, foothold[1] - y) < CONVERGED:
            return np.array(frame)
    return None


def _inverse(first: float, mixed: float, second: float) -> Symmetric:
    """The inverse of the symmetric matrix [[first, mixed], [mixed, second]], in the same order."""
    determinant = first * second - mixed * mixed
    return second / determinant, -mixed / determinant, first / determinant


def _times(first: Symmetric, second: Symmetric, column: Sequence[float]) -> Sequence[float]:
    """Two symmetric blocks on the diagonal times a column of four."""
    a, b, c, d = column
    return (
        first[0] * a + first[1] * b,
        first[1] * a + first[2] * b,
        second[0] * c + second[1] * d,
        second[1] * c + second[2] * d,
    )


def _dot(row: Sequence[float], column: Sequence[float]) -> float:
    return row[0] * column[0] + row[1] * column[1] + row[2] * column[2] + row[3] * column[3]
