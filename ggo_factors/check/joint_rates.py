"""Speeds, accelerations and jerks of the joints of a gait, and where they break joint limits."""

from __future__ import annotations

import math

import numpy as np

from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.support.inputs import Array

LEGS = ("support leg", "swing leg")


SPIKE = math.radians(3.0)
"""How far one frame may stand out from the cubic through its neighbours, in [rad]. At 51 frames the gaits of the
procedures stand out by up to 0.05 degrees over random boxes, those of the paper's graph, with its kinks, by 1.2."""
SPIKE_MOTIONS = 30
"""Below so many motions a frame may stand out more, as the square of what is lacking: the frames are further apart."""
STANDS_OUT = 3.0
"""A frame is a spike where it stands out by so many times as far as any frame of the step that is not beside it."""


def joint_rates(gait: Gait, order: int) -> Array:
    """Joint speeds (order 1), accelerations (2) or jerks (3) by differences between frames, shape (m - order, 4).

    In [rad/s], [rad/s^2], [rad/s^3]; a gait of no more than `order` frames has none.
    """
    return np.asarray(np.diff(gait.frames, order, axis=0) / gait.dt**order, dtype=np.float64)


def limit_faults(gait: Gait, limits: JointLimits, slack: float = 0.0) -> list[Violation]:
    """Where a gait breaks joint limits: the worst of each kind, rates by differences between its frames.

    Args:
        gait: the step.
        limits: the limits.
        slack: how far beyond a limit still counts as kept, as a share of it, for angles of their range.
    """
    reach = limits.upper - limits.lower
    checks = (
        ("angle", "deg", limits.lower, limits.upper, reach),
        ("speed", "deg/s", -limits.speed, limits.speed, limits.speed),
        ("acceleration", "deg/s2", -limits.acceleration, limits.acceleration, limits.acceleration),
    )
    found = []
    for order, (kind, unit, low, high, scale) in enumerate(checks):
        rates = joint_rates(gait, order)
        beyond = np.maximum(rates - high, low - rates) / scale
        for first, joint in enumerate(("hip", "knee")):
            own = beyond[:, first::2]
            if own.size and own.max() > slack:
                row, leg = np.unravel_index(own.argmax(), own.shape)
                value = rates[row, first::2][leg]
                limit = high[first] if value > high[first] else low[first]
                # The difference of two frames is a rate between them, that of three one at the middle frame.
                when, name = float(row + order / 2.0), f"{joint} {kind}"
                found.append(Violation(name, when, math.degrees(value), math.degrees(limit), unit, LEGS[leg]))
    return found


def spikes(gait: Gait) -> list[Violation]:
    """Where a single frame stands out of the motion as no continuous one does: a number that was changed, or lost."""
    if len(gait) < 7:
        return []
    frames, found = gait.frames, []
    middle = (4.0 * (frames[1:-3] + frames[3:-1]) - frames[:-4] - frames[4:]) / 6.0
    out = np.abs(frames[2:-2] - middle)
    most = SPIKE * max(1.0, SPIKE_MOTIONS / (len(gait) - 1)) ** 2
    for joint in range(4):
        row = int(out[:, joint].argmax())
        others = np.delete(out[:, joint], range(max(row - 2, 0), min(row + 3, len(out))))
        limit = max(most, STANDS_OUT * float(others.max(initial=0.0)))
        if out[row, joint] > limit:
            name, value = f"{('hip', 'knee')[joint % 2]} spike", math.degrees(out[row, joint])
            found.append(Violation(name, float(row + 2), value, math.degrees(limit), "deg", LEGS[joint // 2]))
    return found
