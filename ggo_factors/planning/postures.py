"""Touchdown postures for many footholds at once, near enough to compare plans; `graph.touchdown` has the exact ones."""

from __future__ import annotations

import numpy as np

from ggo_factors.check.report import STANDARD
from ggo_factors.graph.touchdown import BOUND_GAIN, BOUND_SLACK, LARGEST_STEP, NEAR, STRAIGHTEST
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

STEPS = 8
"""Newton steps; the search from the base gait's own landing takes 4 to 6."""
BENT = np.radians([0.0, 6.0, 25.0, 60.0])
"""Where the search begins again where the nearest posture is far: a short step up, the swinging knee bent."""
UPRIGHTS = 3
"""Newton steps from a touchdown posture to one with a more upright shank."""
INSIDE = np.radians(1.5)
"""How far inside joint limits postures are, in [rad]: joints move on a little at the start of the next step."""
TINY = 1e-12
"""Added to the diagonal so that no system is exactly singular."""
MET = 1e-4
"""A posture counts where the swing ankle is this near to its foothold in [m]."""


def postures(model: LegModel, landing: Array, footholds: Array, limits: JointLimits | None = None) -> Array:
    """The frames nearest to a base gait's last one that land on given footholds, all at once.

    Args:
        model: the legs.
        landing: last frame of the base gait, shape (4,) in [rad].
        footholds: swing ankle in [m], shape (n, 2).
        limits: angles that the joints keep to, or None.

    Returns:
        Frames in [rad], shape (n, 4); NaN where the search finds none.
    """
    bounds = _bounds(limits)
    best = _from(model, landing, footholds, landing, bounds)
    change = ((best - landing) ** 2).sum(axis=1)
    (far,) = np.nonzero(~(change <= NEAR))
    if len(far):
        others = _from(model, landing, footholds[far], BENT, bounds)
        better = ~(((others - landing) ** 2).sum(axis=1) >= change[far]) & np.isfinite(others).all(axis=1)
        best[far[better]] = others[better]
    return best


def upright(model: LegModel, ends: Array, leans: tuple[Array, Array]) -> Array:
    """Touchdown postures with the landing shank as upright as passes beside what is next to it, as steps have it.

    Args:
        model: the legs.
        ends: touchdown postures, shape (n, 4) in [rad].
        leans: how far each shank may lean back and forward, shape (n,) each in [rad].
    """
    lean = ends[:, 3] - ends[:, 2]
    wanted = np.clip(lean, *leans)
    (some,) = np.nonzero(np.isfinite(lean) & (wanted != lean))
    if not len(some):
        return ends
    frames, lands = ends[some], model.endpoint(ends[some])
    for _ in range(UPRIGHTS):
        points, rows = model.endpoint_and_jacobian(frames)
        off = np.concatenate([lands - points, (wanted[some] - frames[:, 3] + frames[:, 2])[:, None]], axis=1)
        rows = np.concatenate([rows, np.tile([[[0.0, 0.0, -1.0, 1.0]]], (len(some), 1, 1))], axis=1)
        gram = rows @ rows.transpose(0, 2, 1) + TINY * np.eye(3)
        frames = frames + (rows.transpose(0, 2, 1) @ np.linalg.solve(gram, off[..., None]))[..., 0]
    found = ends.copy()
    found[some] = frames
    return found


def _from(model: LegModel, landing: Array, footholds: Array, begin: Array, bounds: tuple[Array, Array]) -> Array:
    """As `postures`, searched from a frame `begin`, shape (4,) in [rad]."""
    lower, upper = bounds
    floor = lower.copy()
    floor[1::2] = np.maximum(lower[1::2], np.minimum(landing[1::2], STRAIGHTEST))
    count = len(footholds)
    frames = np.asarray(np.tile(begin, (count, 1)), dtype=np.float64)
    duals = np.asarray(np.zeros((count, 2)))
    system, right = np.zeros((count, 6, 6)), np.zeros((count, 6, 1))
    with np.errstate(all="ignore"):
        for _ in range(STEPS):
            points, rows = model.endpoint_and_jacobian(frames)
            beyond = np.where(frames < floor, floor - frames, np.where(frames > upper, upper - frames, 0.0))
            system[:, :4, :4] = _hessians(rows, duals)
            system[:, range(4), range(4)] += 1.0 + BOUND_GAIN * (beyond != 0.0)
            system[:, 4:, :4], system[:, :4, 4:] = rows, rows.transpose(0, 2, 1)
            right[:, :4, 0] = landing - frames + BOUND_GAIN * beyond
            right[:, 4:, 0] = footholds - points
            lost = ~np.isfinite(system).all(axis=(1, 2))
            system[lost] = np.eye(6)  # legs that are one straight line spoil their own row alone
            step = np.asarray(np.linalg.solve(system + TINY * np.eye(6), right)[..., 0], dtype=np.float64)
            largest = np.abs(step[:, :4]).max(axis=1)
            share = np.asarray(LARGEST_STEP / np.maximum(largest, LARGEST_STEP), dtype=np.float64)
            frames = np.asarray(frames + share[:, None] * step[:, :4], dtype=np.float64)
            duals = step[:, 4:]
        off = np.hypot(*(model.endpoint(frames) - footholds).T)
        within = ((frames > lower - BOUND_SLACK) & (frames < upper + BOUND_SLACK)).all(axis=1)
    frames[~((off < MET) & within)] = np.nan
    return np.asarray(frames)


def _bounds(limits: JointLimits | None) -> tuple[Array, Array]:
    """Least and largest angles, shape (4,) each in [rad]: those of the check, and of a machine."""
    lower = np.array([STANDARD.thigh_back, STANDARD.knee] * 2)
    upper = np.array([STANDARD.thigh_forward, STANDARD.knee_bent] * 2)
    if limits is None:
        return lower, upper
    return np.maximum(lower, limits.lower + INSIDE), np.minimum(upper, limits.upper - INSIDE)


def _hessians(rows: Array, duals: Array) -> Array:
    """Second derivatives of the duals times the swing ankle by the frames, shape (n, 4, 4)."""
    # That of a link by its angle to the vertical is its first one, turned by a right angle.
    turned = rows[:, 1, :] * -duals[:, :1] + rows[:, 0, :] * duals[:, 1:]
    found = np.zeros((len(rows), 4, 4))
    for thigh, knee in ((0, 1), (2, 3)):
        found[:, thigh, thigh] = turned[:, thigh]
        found[:, thigh, knee] = found[:, knee, thigh] = turned[:, knee]
        found[:, knee, knee] = -turned[:, knee]
    return found
