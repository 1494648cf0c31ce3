"""The check of the joint trajectory over time, across the start, the changes of legs and the end of a walk."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ggo_factors.check.joint_rates import LEGS, joint_rates, limit_faults, rate_faults
from ggo_factors.check.report import Tolerances
from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.played import Played

LEAST_JUMP = 2.0
"""A joint's speed that changes by less than this at a change of legs, in [rad/s], does not jump (2 rad/s are 115
degrees/s): the paper's base gait changes by 0.5 there, five recorded ones by 0.6 to 1.8."""
JUMPS_BY = 2.0
"""Nor does one that changes by less than this many times the largest change within the two steps: the paper's graph
has kinks at every lifted frame too."""

OUT_OF_REST = 0.05
"""Share of a step's motions, at rest at one end, whose limits are held as they are played. A first motion of none is
a standstill for differences between frames; the spline takes a run-up in it, and its acceleration in the frame behind
is 1.4 times the difference's at 51 frames, 2 times at 201, a tenth of that three motions on."""


def trajectory_faults(
    gait: Gait,
    before: Gait | None,
    stood: bool,
    stands: bool,
    limits: JointLimits | None,
    tolerances: Tolerances,
) -> list[Violation]:
    """What is wrong with how a step moves on from what came before it and comes to rest.

    Args:
        gait: the step.
        before: the step before, in the roles of this one; None where there is none.
        stood: whether the walker stands still in the first frame.
        stands: the same of the last.
        limits: limits of the joints, checked by differences between frames, where the walker stands also against
            standing still and as they are played there; None where there is none, or it is the trajectory of the whole
            walk that is held to them.
        tolerances: what a good gait may be off by.
    """
    speeds, found = joint_rates(gait, 1), list[Violation]()
    for still, frame, rates in ((stood, 0.5, speeds[0]), (stands, len(gait) - 1.5, speeds[-1])):
        if still and np.abs(rates).max() > tolerances.rest:
            joint = int(np.abs(rates).argmax())
            name, speed = f"{('hip', 'knee')[joint % 2]} not at rest", math.degrees(rates[joint])
            limit = math.copysign(math.degrees(tolerances.rest), speed)
            found.append(Violation(name, frame, speed, limit, "deg/s", LEGS[joint // 2]))
    if before is not None and not stood:
        found += _jump(gait, before)
    if limits is not None:
        frames, times = gait.frames, gait.times
        first = [frames[:1]] if stood else [before.frames[-2:-1]] if before is not None else []
        last = [frames[-1:]] if stands else []
        whole = replace(gait, frames=np.concatenate([*first, frames, *last]), paced=None)
        if gait.paced is not None:
            came = gait.dt if before is None else float(np.diff(before.times[-2:])[0])
            around = np.concatenate([[-came] * len(first), times, [times[-1] + gait.dt] * len(last)])
            whole = replace(whole, paced=around - around[0])
        for fault in limit_faults(whole, limits, tolerances.limits):
            found.append(replace(fault, frame=None if fault.frame is None else fault.frame - len(first)))
        known = {fault.kind for fault in found}
        found += [fault for fault in _rest_faults(gait, stood, stands, limits, tolerances) if fault.kind not in known]
    return found


def _rest_faults(gait: Gait, stood: bool, stands: bool, limits: JointLimits, tolerances: Tolerances) -> list[Violation]:
    """Where the trajectory that is played breaks limits on its way out of rest, or into it."""
    last, path = len(gait) - 1, Played(gait.times, gait.frames, stood, stands)
    few = max(2, math.ceil(OUT_OF_REST * last))
    ends = [(0, min(few, last), "out of")] * stood + [(max(last - few, 0), last, "into")] * stands
    return [
        replace(
            fault, frame=None if fault.frame is None else fault.frame + begins, note=f"{fault.note}, played {way} rest"
        )
        for begins, ends_at, way in ends
        for fault in rate_faults(path, limits, tolerances.limits, begins, ends_at)
    ]


def _jump(gait: Gait, before: Gait) -> list[Violation]:
    """Whether a joint's speed jumps at the change of legs more than in a continuous motion."""
    speeds = [joint_rates(step, 1) for step in (before, gait)]
    jump = speeds[1][0] - speeds[0][-1]
    joint = int(np.abs(jump).argmax())
    bends = [np.abs(np.diff(rates, axis=0)).max(initial=0.0) for rates in speeds]
    limit = max(LEAST_JUMP, JUMPS_BY * max(bends))
    if not abs(jump[joint]) > limit:
        return []
    name = f"{('hip', 'knee')[joint % 2]} speed jumps"
    values = [math.degrees(value) for value in (jump[joint], math.copysign(limit, jump[joint]))]
    return [Violation(name, 0.0, values[0], values[1], "deg/s", f"{LEGS[joint // 2]}, at the change of legs")]


def landing_faults(speed: float, most: float | None, frame: int, slack: float) -> list[Violation]:
    """Whether the foot comes down faster in [m/s] than it may, by more than a share `slack`."""
    if most is None or not speed > most * (1.0 + slack):
        return []
    return [Violation("landing speed", float(frame), speed, most, "m/s")]
