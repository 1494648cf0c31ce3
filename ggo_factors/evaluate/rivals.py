"""What one would do without a gait graph: a base gait brought to another start and landing in closed form.

All work on the angles, in shares of the step from 0 to 1, and know no ground, no obstacle and no check. Who lands on a
foothold is given the same touchdown posture that landing edges aim at.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.interpolate import CubicSpline

from ggo_factors.support.inputs import Array

Rival = Callable[[Array, Array, Array, Array], Array]
"""From the base gait's frames, shape (m, 4) in [rad], the first frame in [rad], how fast the joints move there in
[rad/step], and the touchdown posture in [rad], shape (4,) each, to frames of the same shape."""

VIA_POINTS = 5
"""Poses of the base gait that the spline passes between start and landing. On six recordings fewer lose the base gait's
shape, more leave no room for the start to fade."""
DMP_STIFFNESS, DMP_DAMPING, DMP_PHASE = 25.0**2 / 4.0, 25.0, 25.0 / 3.0
"""Stiffness in [1/step^2], damping and decay of the phase in [1/step] of a movement primitive: critically damped, the
values of Ijspeert et al. (Neural Computation 25, 2013)."""


def no_change(base: Array, start: Array, rate: Array, landing: Array) -> Array:
    """The base gait moved to the start, its offset constant."""
    return np.asarray(base + (start - base[0]))


def faded(base: Array, start: Array, rate: Array, landing: Array) -> Array:
    """The base gait, the offset of the start faded out evenly over the step."""
    return np.asarray(base + (1.0 - _shares(base)) * (start - base[0]))


def minimum_jerk(base: Array, start: Array, rate: Array, landing: Array) -> Array:
    """The base gait and an offset of least jerk, from the start and its motion to the touchdown posture at rest."""
    s = _shares(base)
    first, speed, last = start - base[0], rate - first_rate(base), landing - base[-1]
    ease = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    moving = s - s**3 * (6.0 - 8.0 * s + 3.0 * s**2)
    return np.asarray(base + first + (last - first) * ease + speed * moving)


def via_points(base: Array, start: Array, rate: Array, landing: Array) -> Array:
    """A cubic spline from the start and its motion through poses of the base gait to the touchdown posture."""
    times = np.linspace(0.0, 1.0, VIA_POINTS + 2)
    poses = CubicSpline(_shares(base)[:, 0], base)(times)
    poses[0], poses[-1] = start, landing
    spline = CubicSpline(times, poses, bc_type=((1, rate), (1, -first_rate(base[::-1]))))
    return np.asarray(spline(_shares(base)[:, 0]))


def movement_primitive(base: Array, start: Array, rate: Array, landing: Array) -> Array:
    """A dynamic movement primitive that was taught the base gait, from the start to the touchdown posture.

    x'' = K (g - x) - D x' - K (g - x0) s + K f(s), s' = -a s (Hoffmann et al., ICRA 2009), its forcing term f exact and
    not fitted. Being linear, it is the base gait and an offset y with y'' = K (y_g - y) - D y' - K (y_g - y_0) s.
    """
    t = _shares(base)
    first, speed, last = start - base[0], rate - first_rate(base), landing - base[-1]
    driven = -DMP_STIFFNESS / (DMP_PHASE**2 - DMP_DAMPING * DMP_PHASE + DMP_STIFFNESS) * (last - first)
    free = first - last - driven
    slope = speed + DMP_PHASE * driven + 0.5 * DMP_DAMPING * free
    return np.asarray(
        base + last + driven * np.exp(-DMP_PHASE * t) + (free + slope * t) * np.exp(-0.5 * DMP_DAMPING * t)
    )


RIVALS: Mapping[str, Rival] = {
    "no_change": no_change,
    "faded": faded,
    "minimum_jerk": minimum_jerk,
    "via_points": via_points,
    "dmp": movement_primitive,
}
"""The rivals by the names that tables and JSON have for them."""


def first_rate(frames: Array) -> Array:
    """How fast the joints move at the first of these frames (m, 4), in [rad/step], shape (4,)."""
    return np.asarray((frames[1] - frames[0]) * (len(frames) - 1))


def _shares(base: Array) -> Array:
    """The share of the step at each frame, shape (m, 1)."""
    return np.linspace(0.0, 1.0, len(base))[:, None]
