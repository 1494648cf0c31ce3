"""From mean cycles to one step that closes at the change of roles and stands on the ground."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from ggo_factors.motion.gait import swap_roles
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

KNEE_STRAIGHT = math.radians(-0.3)
"""Least knee angle in [rad] that is taken as straight: what the check of a finished gait allows."""


def stand_with_bent_knees(
    frames: Array, model: LegModel, rise: float = 0.0, advance: float | None = None
) -> tuple[Array, float]:
    """`stand_on_ground`, and where a knee is then overstretched, all knee angles raised by one constant.

    A sensor's zero, or a joint that a person has and the model has not, lets knees dip below straight. A constant is
    what a gait graph does not see: it holds to the differences between frames.

    Returns:
        The frames, and the constant in [rad], 0 where none was needed.
    """
    (stood,), raised = steps_with_bent_knees((frames,), model, rise, advance)
    return stood, raised


def steps_with_bent_knees(
    steps: Sequence[Array], model: LegModel, rise: float = 0.0, advance: float | None = None
) -> tuple[list[Array], float]:
    """`stand_with_bent_knees` for a step of both legs, or for one of each, with one constant for all knees.

    Of two steps each ends where the other begins, and still does.

    Returns:
        The steps, and the constant in [rad], 0 where none was needed.
    """
    raised = 0.0
    stood = stand_on_ground(steps, model, rise, advance)
    least = KNEE_STRAIGHT
    for _ in range(100):
        low = min(float(frames[:, [1, 3]].min()) for frames in stood)
        if low >= least:
            break
        least = -1e-9
        raised -= low
        bent = [frames + raised * np.array([0.0, 1.0, 0.0, 1.0]) for frames in steps]
        stood = stand_on_ground(bent, model, rise, advance)
    return stood, raised


def flight_end_with_bent_knees(frames: Array, model: LegModel, heights: tuple[float, float]) -> Array:
    """The first or last step of a flight changed by little, its swing ankle at these heights at the start and the end.

    The heights are over the supporting ankle in [m]. The change runs linearly from the first frame to the last, each of
    which is the nearest that stands there, wherever along the ground; all knee angles are raised by one constant where
    one is overstretched. Shapes (m, 4) in [rad].
    """
    share, raised = np.linspace(0.0, 1.0, len(frames))[:, None], 0.0
    for _ in range(100):
        bent = frames + raised * np.array([0.0, 1.0, 0.0, 1.0])
        begin, end = (_at_height(bent[end], model, heights[end]) for end in (0, -1))
        stood = bent + (1.0 - share) * (begin - bent[0]) + share * (end - bent[-1])
        low = float(stood[:, [1, 3]].min())
        if low >= (KNEE_STRAIGHT if not raised else -1e-9):
            break
        raised -= low
    return np.asarray(stood, dtype=np.float64)


def _at_height(frame: Array, model: LegModel, height: float) -> Array:
    """The frame nearest to one, (4,) in [rad], with the swing ankle this far above the supporting one in [m]."""
    change = np.zeros(4)
    for _ in range(50):
        slope = model.endpoint_jacobian(frame + change)[1]
        off = float(model.endpoint(frame + change)[1]) - height
        wanted = slope * (slope @ change - off) / (slope @ slope)
        done = float(np.abs(wanted - change).max()) < 1e-13
        change = wanted
        if done:
            break
    return np.asarray(frame + change, dtype=np.float64)


def stand_on_ground(
    steps: Sequence[Array], model: LegModel, rise: float = 0.0, advance: float | None = None
) -> list[Array]:
    """Steps changed by as little as possible so that both feet stand on the ground in the first frame and the last.

    The change runs linearly from the first frame to the last, which is what the residual edges of a gait graph make
    of two end edges, and its last value is its first with the legs exchanged, so that a gait that closes at the change
    of roles still does. Of all such changes it has the least sum of squares over the gait.

    Args:
        steps: one step, shape (m, 4) in [rad], its last frame the first with the roles exchanged; or two, each of which
            ends where the other begins.
        model: the legs.
        rise: height of the landing place over the support in [m].
        advance: distance of the landing place ahead of the support in [m]; left as it comes if None.
    """
    share, count = np.linspace(0.0, 1.0, len(steps[0]))[:, None], len(steps)
    exchange = np.eye(4)[[2, 3, 0, 1]]
    # The sum over the gait of |(1 - s) d + s E d'|^2, d' the change at the start of the next step.
    weights = np.zeros((4 * count, 4 * count))
    for k in range(count):
        own, following = np.zeros((4, 4 * count)), np.zeros((4, 4 * count))
        own[:, 4 * k : 4 * k + 4] = np.eye(4)
        following[:, 4 * ((k + 1) % count) :][:, :4] = exchange
        parts = (1.0 - share)[:, :, None] * own + share[:, :, None] * following
        weights += np.einsum("nij,nik->jk", parts, parts)
    inverse = np.linalg.inv(weights)
    rows = [1] if advance is None else [0, 1]
    # In the first frame the swing ankle is the foot behind: as far back and below as it will land ahead and above.
    target = -np.array([0.0 if advance is None else advance, rise])
    starts, change = np.array([frames[0] for frames in steps]), np.zeros((count, 4))
    jacobian = np.zeros((count, len(rows), count, 4))
    for _ in range(50):
        off = (model.endpoint(starts + change) - target)[:, rows]
        for k, frame in enumerate(starts + change):
            jacobian[k, :, k] = model.endpoint_jacobian(frame)[rows]
        flat = jacobian.reshape(count * len(rows), 4 * count)
        short = off.ravel() - flat @ change.ravel()
        wanted = (-inverse @ flat.T @ np.linalg.solve(flat @ inverse @ flat.T, short)).reshape(count, 4)
        done = float(np.abs(wanted - change).max()) < 1e-13
        change = wanted
        if done:
            break
    return [
        np.asarray(frames + (1.0 - share) * change[k] + share * swap_roles(change[(k + 1) % count]), dtype=np.float64)
        for k, frames in enumerate(steps)
    ]


def closed(cycle: Array) -> Array:
    """A mean cycle (n + 1, k) made to end where it begins, the difference spread over the cycle."""
    share = np.linspace(0.5, -0.5, len(cycle))[:, None]
    closed = cycle + share * (cycle[-1] - cycle[0])
    closed[-1] = closed[0]
    return np.asarray(closed, dtype=np.float64)


def level_step(cycle: Array, count: int) -> Array:
    """One step of a walker whose legs both follow `cycle` (n + 1, 2), half a cycle apart: (count, 4)."""
    spline = CubicSpline(np.linspace(0.0, 1.0, len(cycle)), cycle, bc_type="periodic")
    phase = np.linspace(0.0, 0.5, count)
    frames = np.concatenate([spline(phase), spline(phase + 0.5)], axis=1)
    frames[-1] = swap_roles(frames[0])
    return np.asarray(frames, dtype=np.float64)


def resampled_step(frames: Array, count: int) -> Array:
    """A step of any number of frames (n, 4) in `count` frames, both ends included."""
    return np.asarray(CubicSpline(np.linspace(0.0, 1.0, len(frames)), frames)(np.linspace(0.0, 1.0, count)))


def closed_step(frames: Array) -> Array:
    """A step whose last frame is its first with the legs exchanged, the difference spread over the step."""
    share = np.linspace(0.0, 1.0, len(frames))[:, None]
    gap = swap_roles(frames[-1]) - frames[0]
    closed = frames + 0.5 * (1.0 - share) * gap - 0.5 * share * swap_roles(gap)
    closed[-1] = swap_roles(closed[0])
    return np.asarray(closed, dtype=np.float64)


def spread(stack: Array) -> Array:
    """Standard deviation over the first axis; 0 where there is one cycle only."""
    return np.asarray(stack.std(axis=0, ddof=1) if len(stack) > 1 else np.zeros(stack.shape[1:]), dtype=np.float64)
