"""Why no gait at all can make a step: found before anything is solved."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ggo_factors.check.ground import misplaced
from ggo_factors.check.joint_rates import LEGS, limit_faults
from ggo_factors.check.leg_collision import leg_faults
from ggo_factors.check.report import STANDARD
from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.procedures.task import Beginning, StepTask


def impossible(task: StepTask, begin: Beginning) -> list[Violation]:
    """Why no gait at all can make a step, whatever the graph finds; empty where nothing is known against it.

    Args:
        task: the step.
        begin: how what is left of it begins.
    """
    step, model = task.step, task.model
    from_x, from_y = model.endpoint(task.walked[-1]).tolist()
    found = misplaced(model, (from_x, from_y), step.landing(model), step.obstacles, step.gaps, step.ground, STANDARD)
    for obstacle in step.obstacles:
        if obstacle.height > 2.0 * model.reach:
            found.append(Violation("obstacle's height", None, obstacle.height, 2.0 * model.reach, "m", str(obstacle)))
    if begin.carried is not None and begin.carried[1::2].min() < STANDARD.knee:
        knees = np.degrees(begin.carried[1::2])
        leg = f"{LEGS[int(knees.argmin())]}, as it moves now"
        limit = math.degrees(STANDARD.knee)
        found.append(Violation("knee", begin.done + begin.every, float(knees.min()), limit, "deg", leg))
    if task.settings.limits is not None:
        found += _beyond_limits(task, begin, task.settings.limits)
    if model.has_bodies:
        here, now = model.joints(task.walked[-1:]), np.array([float(begin.done)])
        found += leg_faults(model, here, now, step.obstacles, step.ground)[1]
    return found


def _beyond_limits(task: StepTask, begin: Beginning, limits: JointLimits) -> list[Violation]:
    """The joint limits that the walker is beyond now: in angle, or in speed by more than it can slow by in a frame."""
    here, dt = task.walked[-1], task.base.dt
    found = [
        replace(fault, frame=float(begin.done), note=f"{fault.note}, as it stands now")
        for fault in limit_faults(Gait(np.array([here, here]), dt), limits, STANDARD.limits)
    ]
    if begin.carried is not None:
        speeds = begin.extrapolated / dt
        beyond = np.abs(speeds) - limits.acceleration * dt > limits.speed * (1.0 + STANDARD.limits)
        for n in np.flatnonzero(beyond).tolist():
            kind, note = ("hip speed", "knee speed")[n % 2], f"{LEGS[n // 2]}, as it moves now"
            value = math.degrees(speeds[n])
            most = math.copysign(math.degrees(limits.speed[n]), value)
            found.append(Violation(kind, begin.done + 0.5, value, most, "deg/s", note))
    return found
