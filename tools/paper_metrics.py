"""Metrics that the paper's tables need beside the library's own: residual, smoothness, clearance and foothold error."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ggo_factors.check.joint_rates import joint_rates
from ggo_factors.errors import InputError
from ggo_factors.evaluate.metrics import zmp
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.support.inputs import Array, as_array, as_instance

LEAST_INSTANTS = 500
"""`clearance` looks at this many instants of a step or more."""


def residuals(gait: Gait, base: Gait) -> Array:
    """Change of each frame-to-frame motion from the base gait's in [rad], shape (m - 1, 4): e_g - e_z of the paper.

    Raises:
        InputError: where the gaits differ in their number of frames.
    """
    if len(gait) != len(base):
        raise InputError(f"base: {len(base)} frames, the gait has {len(gait)}")
    return np.asarray(np.diff(gait.frames - base.frames, axis=0), dtype=np.float64)


@dataclass(frozen=True)
class Smoothness:
    """How smoothly the four joints move, the largest of all joints and instants and the root mean square over them.

    Attributes:
        residual_largest: largest norm of e_g - e_z over a frame in [rad]; NaN without a base gait.
        residual_rms: root mean square of that norm over the frames in [rad]; NaN without a base gait.
        velocity_largest: joint velocity in [rad/s].
        velocity_rms: joint velocity in [rad/s].
        acceleration_largest: joint acceleration in [rad/s^2].
        acceleration_rms: joint acceleration in [rad/s^2].
        jerk_largest: joint jerk in [rad/s^3].
        jerk_rms: joint jerk in [rad/s^3].
    """

    residual_largest: float
    residual_rms: float
    velocity_largest: float
    velocity_rms: float
    acceleration_largest: float
    acceleration_rms: float
    jerk_largest: float
    jerk_rms: float


def smoothness(gait: Gait, base: Gait | None = None) -> Smoothness:
    """Residual, joint velocity, acceleration and jerk of a step, the latter by differences between frames.

    Args:
        gait: the step, of 4 frames or more.
        base: the base gait that the residual is counted from; none if None.

    Raises:
        InputError: where an argument is unusable, there are fewer than 4 frames, or the gaits differ in their number
            of frames.
    """
    if len(as_instance(gait, "gait", Gait)) < 4:
        raise InputError(f"gait: {len(gait)} frames, jerk needs at least 4")
    numbers = [math.nan, math.nan]
    if base is not None:
        norms = np.linalg.norm(residuals(gait, as_instance(base, "base", Gait)), axis=1)
        numbers = [float(norms.max()), _rms(norms)]
    for order in (1, 2, 3):
        rates = joint_rates(gait, order)
        numbers += [float(np.abs(rates).max()), _rms(rates)]
    return Smoothness(*numbers)


@dataclass(frozen=True)
class Clearance:
    """Least height of parts of the swinging leg over a box in [m]; infinite for what never passes over it.

    Attributes:
        endpoint: of the swing ankle, with the sole's length before and behind it where the model has a foot.
        knee: of the knee.
        shank: of all of the shank, knee to ankle.
    """

    endpoint: float
    knee: float
    shank: float


def clearance(gait: Gait, obstacle: Obstacle) -> Clearance:
    """Least heights over a box, densely: all frames, never fewer than 500 instants, joint angles linear between them.

    Args:
        gait: the step, with its legs.
        obstacle: the box, in the body frame of this step.

    Raises:
        InputError: where an argument is unusable.
    """
    legs = as_instance(gait, "gait", Gait).legs()
    box = as_instance(obstacle, "obstacle", Obstacle)
    pieces = len(gait) - 1
    at = np.linspace(0.0, pieces, pieces * math.ceil(LEAST_INSTANTS / pieces) + 1)
    joints = legs.joints(np.stack([np.interp(at, np.arange(len(gait)), column) for column in gait.frames.T], -1))
    knee, ankle = joints[:, 3], joints[:, 4]
    # Heights count from the supporting ankle, a box from the ground under its sole: for the swing ankle its own
    # sole takes off what the supporting foot adds; knee and shank have no sole.
    up = legs.foot.ankle_height
    return Clearance(
        _lowest_over(ankle[:-1], ankle[1:], box.for_ankle(legs.foot)),
        _lowest_over(knee[:-1], knee[1:], box) + up,
        _lowest_over(knee, ankle, box) + up,
    )


def foothold_error(gait: Gait, foothold: tuple[float, float]) -> float:
    """Distance of the swing ankle in the last frame from its foothold in [m].

    Args:
        gait: the step, with its legs.
        foothold: where the swing ankle was to land in [m], shape (2,).

    Raises:
        InputError: where an argument is unusable.
    """
    landing = as_instance(gait, "gait", Gait).endpoints()[-1]
    return float(np.hypot(*(landing - as_array(foothold, "foothold", (2,)))))


def zmp_off(gait: Gait, base: Gait, step_time: float) -> float:
    """Mean distance of the zero moment point from the base gait's own at that frame in [m], of as many frames."""
    return float(np.abs(zmp(gait, step_time=step_time) - zmp(base, step_time=step_time)).mean())


def _lowest_over(here: Array, there: Array, box: Obstacle) -> float:
    """Least height over a box of straight pieces from `here` to `there`, both (n, 2) in [m]; inf where none is over it.

    A piece is lowest where it ends, or where it enters or leaves the span.
    """
    run = there[:, 0] - here[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.stack([(box.x_start - here[:, 0]) / run, (box.x_end - here[:, 0]) / run])
    # An upright piece lies in the span with all of it, or not at all.
    shares = np.clip(np.sort(np.where(run == 0.0, [[0.0], [1.0]], shares), axis=0), 0.0, 1.0)
    low, high = np.minimum(here[:, 0], there[:, 0]), np.maximum(here[:, 0], there[:, 0])
    over = (low <= box.x_end) & (high >= box.x_start)
    heights = here[:, 1] + shares * (there[:, 1] - here[:, 1])
    return float(heights.min(axis=0)[over].min(initial=math.inf)) - box.height


def _rms(values: Array) -> float:
    return math.sqrt(float(np.mean(values**2)))
