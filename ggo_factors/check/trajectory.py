"""The check of the joint trajectory over time, across the start, the changes of legs and the end of a walk."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ggo_factors.check.joint_rates import LEGS, limit_faults
from ggo_factors.check.report import Tolerances
from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.support.inputs import Array

LEAST_JUMP = 2.0
"""A joint's speed that changes by less than this at a change of legs, in [rad/s], does not jump (2 rad/s are 115
degrees/s): the paper's base gait changes by 0.5 there, five recorded ones by 0.6 to 1.8."""
JUMPS_BY = 2.0
"""Nor does one that changes by less than this many times the largest change within the two steps: the paper's graph
has kinks at every lifted frame too."""


def trajectory_faults(
    gait: Gait,
    before: Array | None,
    stood: bool,
    stands: bool,
    limits: JointLimits | None,
    tolerances: Tolerances,
) -> list[Violation]:
    """What is wrong with how a step moves on from what came before it and comes to rest.

    Args:
        gait: the step.
        before: frames of the step before, in the roles of this one, shape (k, 4) in [rad]; None where there is none.
        stood: whether the walker stands still in the first frame.
        stands: the same of the last.
        limits: limits of the joints, checked at every frame, where the walker stands also against standing still; or
            None.
        tolerances: what a good gait may be off by.
    """
    frames, found = gait.frames, []
    for still, frame, motion in (
        (stood, 0.5, frames[1] - frames[0]),
        (stands, len(gait) - 1.5, frames[-1] - frames[-2]),
    ):
        if still and np.abs(motion).max() > tolerances.rest * gait.dt:
            joint = int(np.abs(motion).argmax())
            name, speed = f"{('hip', 'knee')[joint % 2]} not at rest", math.degrees(motion[joint] / gait.dt)
            limit = math.copysign(math.degrees(tolerances.rest), speed)
            found.append(Violation(name, frame, speed, limit, "deg/s", LEGS[joint // 2]))
    if before is not None and not stood:
        found += _jump(gait, before)
    if limits is not None:
        first = [frames[:1]] if stood else [before[-2:-1]] if before is not None else []
        last = [frames[-1:]] if stands else []
        whole = replace(gait, frames=np.concatenate([*first, frames, *last]))
        for fault in limit_faults(whole, limits, tolerances.limits):
            found.append(replace(fault, frame=None if fault.frame is None else fault.frame - len(first)))
    return found


def _jump(gait: Gait, before: Array) -> list[Violation]:
    """Whether a joint's speed jumps at the change of legs more than in a continuous motion."""
    jump = (gait.frames[1] - gait.frames[0]) - (before[-1] - before[-2])
    joint = int(np.abs(jump).argmax())
    bends = [np.abs(np.diff(frames, 2, axis=0)).max(initial=0.0) for frames in (before, gait.frames)]
    limit = max(LEAST_JUMP * gait.dt, JUMPS_BY * max(bends))
    if not abs(jump[joint]) > limit:
        return []
    name = f"{('hip', 'knee')[joint % 2]} speed jumps"
    values = [math.degrees(value / gait.dt) for value in (jump[joint], math.copysign(limit, jump[joint]))]
    return [Violation(name, 0.0, values[0], values[1], "deg/s", f"{LEGS[joint // 2]}, at the change of legs")]
