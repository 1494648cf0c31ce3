"""What is exported: a walk, a solution or a gait as the steps that are played."""

from __future__ import annotations

import math

from ggo_factors.check.joint_rates import angle_faults
from ggo_factors.check.report import STANDARD
from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.procedures.task import StepSolution
from ggo_factors.support.inputs import as_number
from ggo_factors.walking.trajectory import JointTrajectory, joint_trajectory
from ggo_factors.walking.walk import Walk


def as_walk(walk: Walk | Solution | Gait) -> Walk | Gait:
    """A walk or a gait; of a solution its own, if it passed its check.

    Raises:
        InputError: where it is none of these.
        InfeasibleGaitError: where a solution did not pass its check.
    """
    if isinstance(walk, Solution):
        walk.require_ok()
        if isinstance(walk, StepSolution):
            swing = walk.task.swing if walk.task.number == 1 else "right"
            return Walk((walk.gait,), (walk.task.step,), first_swing=swing)
        return walk.gait
    if isinstance(walk, Walk | Gait):
        return walk
    raise InputError(f"walk: expected a Walk, a Solution or a Gait, got {walk!r:.80}")


def first_swing_of(walk: Walk | Gait, first_swing: str | None) -> str:
    """The leg that swings first: the one told, a walk's own, of a gait the right."""
    if first_swing is not None:
        return first_swing
    return walk.first_swing if isinstance(walk, Walk) else "right"


def trajectory_of(walk: Walk | Gait, first_swing: str | None) -> JointTrajectory:
    """The joints over time at the frames' own times."""
    first = first_swing_of(walk, first_swing)
    return walk.joint_trajectory(first) if isinstance(walk, Walk) else joint_trajectory((walk,), first)


def require_within_limits(walk: Walk | Gait) -> None:
    """Refuse a walk that breaks the joint limits it carries.

    Raises:
        InfeasibleGaitError: with the limits that are broken.
    """
    if isinstance(walk, Gait) or walk.limits is None:
        return
    faults = [fault for step in walk.trajectory_faults(walk.limits) for fault in step]
    faults += [fault for gait in walk.gaits for fault in angle_faults(gait.frames, walk.limits, STANDARD.limits)]
    if faults:
        raise InfeasibleGaitError(f"walk: breaks its joint limits: {'; '.join(map(str, faults[:3]))}", tuple(faults))


def tilt_of(pelvis_tilt: float) -> float:
    """The pelvis tilt in [rad].

    Raises:
        InputError: where it is no angle, or looks like degrees.
    """
    tilt = as_number(pelvis_tilt, "pelvis_tilt", unit="rad")
    if not abs(tilt) < math.pi:
        raise InputError(f"pelvis_tilt: {tilt:g} rad is not below pi; looks like degrees")
    return tilt
