"""What speaks against any gait at all for a step, whatever the graph says: told before anything is solved."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ggo_factors.check.joint_rates import LEGS, limit_faults
from ggo_factors.check.leg_collision import can_hit, leg_faults
from ggo_factors.check.verify import STANDARD, misplaced
from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.procedures.task import StepTask


def impossible(task: StepTask) -> list[Violation]:
    """What speaks against any gait at all for this step, whatever the graph says."""
    step, model = task.step, task.model
    from_x, from_y = model.endpoint(task.walked[-1]).tolist()
    found = misplaced(model, (from_x, from_y), step.landing(model), step.obstacles, step.gaps, step.ground, STANDARD)
    for obstacle in step.obstacles:
        if obstacle.height > 2.0 * model.reach:
            found.append(Violation("obstacle's height", None, obstacle.height, 2.0 * model.reach, "m", str(obstacle)))
    carried, done = task.carried, task.done
    if carried is not None and carried[1::2].min() < STANDARD.knee:
        knees, at = np.degrees(carried[1::2]), done + task.ahead[2]
        leg = f"{LEGS[int(knees.argmin())]}, as it moves now"
        found.append(Violation("knee", at, float(knees.min()), math.degrees(STANDARD.knee), "deg", leg))
    found += _beyond_limits(task)
    if can_hit(model, step.obstacles, step.ground):
        here, now = model.joints(task.walked[-1:]), np.array([float(done)])
        found += leg_faults(model, here, now, step.obstacles, step.ground)[1]
    return found


def _beyond_limits(task: StepTask) -> list[Violation]:
    """The joint limits that the walker is beyond now: in angle, or in speed by more than it can slow by in a frame."""
    limits, here, dt = task.manner.limits, task.walked[-1], task.base.dt
    if limits is None:
        return []
    found = [
        replace(fault, frame=float(task.done), note=f"{fault.note}, as it stands now")
        for fault in limit_faults(Gait(np.array([here, here]), dt), limits, STANDARD.limits)
    ]
    if task.carried is not None:
        speeds = task.onward / dt
        beyond = np.abs(speeds) - limits.acceleration * dt > limits.speed * (1.0 + STANDARD.limits)
        for n in np.flatnonzero(beyond).tolist():
            kind, note = ("hip speed", "knee speed")[n % 2], f"{LEGS[n // 2]}, as it moves now"
            value = math.degrees(speeds[n])
            most = math.copysign(math.degrees(limits.speed[n]), value)
            found.append(Violation(kind, task.done + 0.5, value, most, "deg/s", note))
    return found
