"""The posture in which a step lands: the nearest to the base gait's own with the swing ankle on its foothold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache

import numpy as np

from ggo_factors.check.report import STANDARD
from ggo_factors.errors import UnreachableFootholdError
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

STRAIGHTEST = math.radians(5.0)
"""A landing knee need not be more bent than this in [rad]; one that is straighter in the base gait may stay so. People
land with 5 to 15 degrees."""
MOST_STEPS = 40
"""Newton's steps; most postures take 4 to 8."""
CLOSE = 1e-8
"""How nearly the foothold in [m] and the angles in [rad] are met."""
MOST_PLAIN = 8
"""Plain steps before the careful ones."""
_DIAGONAL = (np.arange(4), np.arange(4))
CONVEX = 0.05
"""Least curvature of the Lagrangian along the constraints for a step of Newton's; 1 is that of nearness alone."""
LONGEST_STEP = 0.3
"""Newton's steps are cut to this in [rad], so that they stay on the base gait's branch."""


def touchdown_posture(
    model: LegModel, landing: Array, foothold: tuple[float, float], shank_angle: float | None = None
) -> Array | None:
    """The touchdown posture on a foothold.

    Of all frames with the swing ankle on the foothold, and the swinging shank at its angle where one is given, the
    nearest to the base gait's last frame whose knees are no straighter than there or 5 degrees, whichever is less.
    Where not all can be had, the foothold comes before the shank, that before the knees, those before nearness.

    Args:
        model: the legs.
        landing: last frame of the base gait, shape (4,) in [rad].
        foothold: target of the swing ankle in [m].
        shank_angle: target of the swinging shank's angle to the ground in [rad], or None.

    Returns:
        Shape (4,) in [rad]; None where there is none that a human leg can take.
    """
    return _posture(model, tuple(landing.tolist()), foothold, shank_angle)


@lru_cache(maxsize=64)
def _posture(
    model: LegModel, last: tuple[float, ...], foothold: tuple[float, float], shank_angle: float | None
) -> Array | None:
    """`touchdown_posture`, kept for steps that are alike."""
    landing = np.array(last)
    floors, shank = np.minimum(landing[1::2], STRAIGHTEST), shank_angle is not None
    found, fixed = None, list[int]()
    while True:
        bent = _near(model, landing, foothold, shank_angle, floors, fixed)
        if bent is None:
            bent = _nearest(model, landing, foothold, shank_angle, floors, fixed)
        if bent is None:
            break  # what the knees ask for is given up first
        found, lack = bent, floors - bent[1::2]
        lack[fixed] = 0.0
        if lack.max() <= CLOSE or len(fixed) + shank == 2:
            break
        fixed.append(int(lack.argmax()))
    if found is None or not _is_human(found):
        return None
    found.setflags(write=False)
    return found


def _is_human(frame: Array) -> bool:
    """Whether thighs and knees are within what any walker can follow, as the check has it."""
    thighs, knees = frame[::2], frame[1::2]
    return bool(
        knees.min() >= STANDARD.knee
        and knees.max() <= STANDARD.knee_bent
        and thighs.min() >= STANDARD.thigh_back
        and thighs.max() <= STANDARD.thigh_forward
    )


def _near(
    model: LegModel,
    landing: Array,
    foothold: tuple[float, float],
    shank_angle: float | None,
    floors: Array,
    fixed: Sequence[int],
) -> Array | None:
    """`_nearest` where plain Newton steps from the landing find it, in a fraction of the time; else None."""
    count = 2 + (shank_angle is not None) + len(fixed)
    system, right = np.zeros((4 + count, 4 + count)), np.zeros(4 + count)
    if shank_angle is not None:
        system[6, 2:4] = system[2:4, 6] = 1.0, -1.0
    for row, knee in enumerate(fixed, start=4 + count - len(fixed)):
        system[row, 1 + 2 * knee] = system[1 + 2 * knee, row] = 1.0
    frame, by_x, by_y = landing, 0.0, 0.0
    for _ in range(MOST_PLAIN):
        x, y, row_x, row_y = model.endpoint_rows(frame)
        system[4, :4], system[5, :4], system[:4, 4], system[:4, 5] = row_x, row_y, row_x, row_y
        system[:4, :4] = model.endpoint_hessian(frame, by_x, by_y)
        system[_DIAGONAL] += 1.0
        right[:4], right[4], right[5] = landing - frame, foothold[0] - x, foothold[1] - y
        if shank_angle is not None:
            right[6] = shank_angle - math.pi / 2.0 - frame[2] + frame[3]
        for row, knee in enumerate(fixed, start=4 + count - len(fixed)):
            right[row] = floors[knee] - frame[1 + 2 * knee]
        try:
            step = np.linalg.solve(system, right)
        except np.linalg.LinAlgError:
            return None
        moved = max(map(abs, step[:4].tolist()))
        if moved > LONGEST_STEP:
            return None
        frame, by_x, by_y = frame + step[:4], float(step[4]), float(step[5])
        if moved < math.sqrt(CLOSE):  # the next step would be its square
            signs = np.linalg.eigvalsh(system)
            return frame if (signs < 0.0).sum() == count else None  # a minimum, and no saddle
    return None


def _nearest(
    model: LegModel,
    landing: Array,
    foothold: tuple[float, float],
    shank_angle: float | None,
    floors: Array,
    fixed: Sequence[int],
) -> Array | None:
    """The nearest frame to the landing that meets the constraints, by Newton's method on the Lagrangian; or None.

    Args:
        model: the legs.
        landing: as for `touchdown_posture`, and so are the next two.
        foothold: target of the swing ankle.
        shank_angle: target of the shank.
        floors: least angles of the knees in [rad], shape (2,).
        fixed: which knees are at theirs.
    """
    begin = landing.copy()
    with suppress(UnreachableFootholdError):
        # On the branch on which knees bend the human way.
        begin[2:] = model.inverse_kinematics(np.array(foothold), landing[:2])
    count = 2 + (shank_angle is not None) + len(fixed)
    jacobian = np.zeros((count, 4))
    if shank_angle is not None:
        jacobian[2, 2:] = 1.0, -1.0
    for row, knee in enumerate(fixed, start=count - len(fixed)):
        jacobian[row, 1 + 2 * knee] = 1.0

    def missed(frame: Array) -> Array:
        """By how much each constraint is missed."""
        x, y, jacobian[0], jacobian[1] = model.endpoint_rows(frame)
        misses = [x - foothold[0], y - foothold[1]]
        if shank_angle is not None:
            misses.append(math.pi / 2.0 + frame[2] - frame[3] - shank_angle)
        return np.array(misses + [frame[1 + 2 * knee] - floors[knee] for knee in fixed])

    frame, multipliers = begin, np.zeros(count)
    misses = missed(frame)
    for _ in range(MOST_STEPS):
        slope = frame - landing
        if np.abs(misses).max() < CLOSE and np.abs(slope + multipliers @ jacobian).max() < CLOSE:
            return frame
        # Along the constraints the Lagrangian's second derivative, across them whatever meets them.
        axes, triangle = np.linalg.qr(jacobian.T, mode="complete")
        triangle, across, along = triangle[:count], axes[:, :count], axes[:, count:]
        if np.abs(np.diag(triangle)).min() < CLOSE:
            return None
        curved = np.eye(4) + model.endpoint_hessian(frame, float(multipliers[0]), float(multipliers[1]))
        step = across @ np.linalg.solve(triangle.T, -misses)
        if count < 4:
            reduced = along.T @ curved @ along
            if np.linalg.eigvalsh(reduced)[0] < CONVEX:
                curved, reduced = np.eye(4), np.eye(4 - count)  # far from a minimum
            step = step - along @ np.linalg.solve(reduced, along.T @ (slope + curved @ step))
        multipliers = np.linalg.solve(triangle, -across.T @ (slope + curved @ step))
        share = min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), CLOSE))
        frame = frame + share * step
        misses = missed(frame)
    return None
