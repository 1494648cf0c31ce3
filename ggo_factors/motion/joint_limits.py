"""What the joints of an exoskeleton can do: how far, how fast, and how suddenly they move."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

from ggo_factors.errors import InputError
from ggo_factors.support.inputs import Array, as_angles, as_array, as_number

UNREACHED = 1e6
"""A speed in [rad/s], and an acceleration in [rad/s^2], beyond any joint's."""


@dataclass(frozen=True)
class JointLimits:
    """Limits of the hips and of the knees, the same for both legs, in [rad], [rad/s] and [rad/s^2].

    The hip's angle is that of the thigh from the vertical: that of a machine's hip while the trunk is upright.

    The ranges are those of the MARCH IV exoskeleton for paraplegics (Project MARCH, TU Delft), within the stops and the
    buffers before them that its robot description states (march4.xacro in its public repository: hips from -20.2 to
    99.0 degrees with buffers of 3, knees from -4.9 to 112.4 with 3.5 and 3). Others have as much: an exoskeleton with
    hips from -30 to 115 and knees from 0 to 100 degrees is in PMC10918848, table 2.

    Speeds and accelerations are assumed: what a healthy pace needs, with room for a step over an obstacle. The
    paper's base gait at 0.5 s a step reaches 141 and 346 degrees/s, 1,143 and 3,857 degrees/s^2 at hip and knee. A
    machine may allow much less: MARCH IV 2.0 and 2.5 rad/s (115 and 143 degrees/s), for which that gait takes 1.2 s a
    step. Give the numbers of your own machine.

    Attributes:
        hip_back: least angle of the thigh from the vertical.
        hip_forward: largest angle of the thigh.
        knee_straight: least angle of the knee; below 0 is hyperextension.
        knee_bent: largest angle of the knee.
        hip_speed: largest speed of the thigh, either way.
        knee_speed: the same of the knee.
        hip_acceleration: largest acceleration of the thigh, either way.
        knee_acceleration: the same of the knee.

    Raises:
        InputError: where an angle is not finite or not below 2 pi, a range is empty, or a rate is not above 0.
    """

    hip_back: float = math.radians(-17.0)
    hip_forward: float = math.radians(95.0)
    knee_straight: float = math.radians(-1.0)
    knee_bent: float = math.radians(109.0)
    hip_speed: float = math.radians(250.0)
    knee_speed: float = math.radians(500.0)
    hip_acceleration: float = math.radians(3000.0)
    knee_acceleration: float = math.radians(10000.0)

    def __post_init__(self) -> None:
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            if name.endswith(("_speed", "_acceleration")):
                unit = "rad/s" if name.endswith("_speed") else "rad/s^2"
                object.__setattr__(self, name, as_number(value, name, above=0.0, unit=unit))
            else:
                object.__setattr__(self, name, float(as_angles(value, name, ())))
        for low, high in (("hip_back", "hip_forward"), ("knee_straight", "knee_bent")):
            least, most = getattr(self, low), getattr(self, high)
            if not least < most:
                raise InputError(f"{high}: {most:g} rad must be above {low} {least:g} rad")

    @property
    def lower(self) -> Array:
        """Least angle of each column of a frame in [rad], shape (4,)."""
        return _of_a_frame(self.hip_back, self.knee_straight)

    @property
    def upper(self) -> Array:
        """Largest angle of each column of a frame in [rad], shape (4,)."""
        return _of_a_frame(self.hip_forward, self.knee_bent)

    @property
    def speed(self) -> Array:
        """Largest speed of each column of a frame in [rad/s], shape (4,)."""
        return _of_a_frame(self.hip_speed, self.knee_speed)

    @property
    def acceleration(self) -> Array:
        """Largest acceleration of each column of a frame in [rad/s^2], shape (4,)."""
        return _of_a_frame(self.hip_acceleration, self.knee_acceleration)

    def angles_only(self) -> JointLimits:
        """The limits with speeds and accelerations that no joint reaches."""
        return replace(self, **dict.fromkeys(_RATES, UNREACHED))

    def tightened(self, share: float) -> JointLimits:
        """The limits with all speeds and accelerations smaller by a share."""
        left = {name: getattr(self, name) * (1.0 - share) for name in _RATES}
        return replace(self, **left)


_RATES = ("hip_speed", "knee_speed", "hip_acceleration", "knee_acceleration")


def _of_a_frame(hip: float, knee: float) -> Array:
    return as_array([hip, knee, hip, knee], "limits", (4,))
