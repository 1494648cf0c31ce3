"""Numbers that judge a gait: its distance from the base gait, and its balance (ZMP)."""

from __future__ import annotations

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.zero_moment import link_masses, push, triples
from ggo_factors.support.inputs import Array, as_instance, as_number


def mean_joint_change(gait: Gait, base: Gait) -> Array:
    """Mean absolute difference of each joint angle from the base gait in [rad], shape (4,) (paper, Table abs_err).

    Raises:
        InputError: where the gaits differ in their number of frames.
    """
    if len(gait) != len(base):
        raise InputError(f"base: {len(base)} frames, the gait has {len(gait)}")
    return np.asarray(np.abs(gait.frames - base.frames).mean(axis=0), dtype=np.float64)


def zmp(gait: Gait, step_time: float | None = None, rotational_inertia: bool = False) -> Array:
    """The zero moment point's x at each inner frame in [m], shape (m - 2,), from the supporting ankle.

    The paper's equation: four links, each a point mass at its middle, no trunk; accelerations by central second
    differences; on the level plane through that ankle, see `motion.zero_moment`. Where the links together fall nearly
    freely the point runs off to infinity, as the equation has it.

    Args:
        gait: the step, of 3 frames or more, with its legs.
        step_time: time from the first frame to the last in [s]; the gait's own if None.
        rotational_inertia: whether each link also turns as a uniform rod, m L^2 / 12, which the paper leaves out.

    Raises:
        InputError: where an argument is unusable or there are fewer than 3 frames.
    """
    if as_instance(gait, "gait", Gait).paced is not None and step_time is None:
        gait = gait.resampled(len(gait))  # a slowed gait, at instants that are evenly apart
    legs, dt = gait.legs(), _time_between_frames(gait, step_time)
    if len(gait) < 3:
        raise InputError(f"gait: {len(gait)} frames, accelerations need at least 3")
    moment, force = push(legs, triples(gait.frames), dt)
    if rotational_inertia:
        a1, b1, a2, b2 = gait.frames.T
        # Every link's angle from the vertical, which grows counterclockwise, as a moment about z does.
        turning = np.diff(np.stack([a1 - b1, a1, a2, a2 - b2], -1), 2, axis=0) / dt**2
        lengths = np.array([legs.shank, legs.thigh, legs.thigh, legs.shank])
        moment = moment + turning @ (link_masses(legs) * lengths**2 / 12.0)
    return np.asarray(moment / force, dtype=np.float64)


def _time_between_frames(gait: Gait, step_time: float | None) -> float:
    if step_time is None:
        return gait.dt
    return as_number(step_time, "step_time", above=0.0, unit="s") / (len(gait) - 1)
