"""From mean cycles to one step that closes at the change of roles and stands on the ground."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from ggo_factors.arrays import Array
from ggo_factors.gait import swap_roles
from ggo_factors.model import LegModel


def stand_on_ground(frames: Array, model: LegModel, rise: float = 0.0) -> Array:
    """The frames changed by as little as possible so that both feet stand on the ground in the first and the last.

    The change runs linearly from the first frame to the last, which is what the residual edges of a gait graph make
    of two end edges, and its last value is its first with the legs exchanged, so that a gait that closes at the change
    of roles still does. Of all such changes it has the least sum of squares over the gait.

    Args:
        frames: a step, shape (m, 4) in [rad], its last frame the first with the roles exchanged.
        model: the legs.
        rise: height of the landing place over the support in [m].
    """
    share = np.linspace(0.0, 1.0, len(frames))[:, None]
    exchange = np.eye(4)[[2, 3, 0, 1]]
    # Sum over the gait of |(1 - s) d + s E d|^2 = d' W d.
    weights = sum(
        part.T @ part for part in ((1.0 - s) * np.eye(4) + s * exchange for s in share[:, 0])
    )  # fmt: skip
    inverse = np.linalg.inv(np.asarray(weights))
    change = np.zeros(4)
    for _ in range(50):
        first = frames[0] + change
        row = model.endpoint_jacobian(first)[1]
        off = float(model.endpoint(first)[1]) + rise - float(row @ change)
        step = -inverse @ row * (off / float(row @ inverse @ row)) - change
        change = change + step
        if np.abs(step).max() < 1e-13:
            break
    return np.asarray(frames + (1.0 - share) * change + share * swap_roles(change), dtype=np.float64)


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
