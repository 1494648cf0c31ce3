"""Replanning in mid-step: what is walked stays, the rest bends to the ground as it is seen now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ggo_factors.errors import InfeasibleGaitError, Violation
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.procedures.search import checked_step
from ggo_factors.procedures.task import LEAST_FRAMES_FOR_A_RATE, StepSolution
from ggo_factors.support.inputs import as_array, as_count, as_instance, as_tuple_of
from ggo_factors.walking.step import verify_step


def replan(
    solution: Solution,
    at_frame: int,
    *,
    obstacles: Sequence[Obstacle] | None = None,
    foothold: tuple[float, float] | None = None,
    gaps: Sequence[Gap] | None = None,
    ground: Ground | None = None,
    limits: JointLimits | None = None,
) -> StepSolution:
    """The rest of a step made again for other ground, checked as a whole.

    What is left out stays as it was asked for. Unless the step was made without smoothness the joints go on as fast as
    they move at that frame. What can be reached in the time that is left is told by limits of the joints, which the
    check holds to `Tolerances.limits`: without any a foot could land anywhere in one frame.

    Args:
        solution: a step from `step_over` or `Walk.steps`, or an earlier replan.
        at_frame: the last frame that is walked; it and those before it stay as they are, to the bit.
        obstacles: boxes to step over, in the body frame of the step.
        foothold: where P must land in [m], shape (2,).
        gaps: pits with no foothold in them.
        ground: height of the ground.
        limits: of the joints; those that the step was made with, or else the default ones of `JointLimits`, if None.

    Returns:
        The solution of the whole step; its graph is that of the rest, whose frame 0 is `at_frame`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where it is too late, or no gait passes the check, with the numbers and the nearest
            foothold that works.
    """
    task = as_instance(solution, "solution", StepSolution).task
    frames, last = solution.gait.frames, len(solution.gait) - LEAST_FRAMES_FOR_A_RATE
    done = as_count(at_frame, "at_frame", 0, len(frames) - 1)
    if done > last:
        raise InfeasibleGaitError(
            f"replan at frame {done}: too late, {len(frames) - 1 - done} frames are left and "
            f"{LEAST_FRAMES_FOR_A_RATE - 1} are needed"
        )
    step = task.step
    if obstacles is not None:
        step = replace(step, obstacles=as_tuple_of(obstacles, "obstacles", Obstacle))
    if gaps is not None:
        step = replace(step, gaps=as_tuple_of(gaps, "gaps", Gap))
    if ground is not None:
        step = replace(step, ground=as_instance(ground, "ground", Ground))
    if foothold is not None:
        x, y = as_array(foothold, "foothold", (2,)).tolist()
        step = replace(step, foothold=(x, y), end_frame=None)
    hit = [fault for fault in verify_step(solution.gait, step, task.model).violations if _is_walked(fault, done)]
    if hit:
        raise InfeasibleGaitError(
            f"replan at frame {done}: too late, already walked: " + "; ".join(map(str, hit)),
            tuple(hit),
            None,
            task.number,
        )
    if limits is None:
        limits = task.settings.limits or JointLimits()
    offset = task.velocity_offset
    if done:
        offset = np.diff((frames - task.base.frames)[done - 1 : done + 1], axis=0)[0]
    return checked_step(
        replace(
            task,
            step=step,
            walked=frames[: done + 1],
            velocity_offset=offset,
            settings=replace(task.settings, limits=as_instance(limits, "limits", JointLimits)),
            name=f"replan at frame {done}",
        )
    )


def _is_walked(fault: Violation, done: int) -> bool:
    """Whether a gait hit something before the frame after this one."""
    return fault.frame is not None and fault.frame <= done and fault.kind.startswith(("obstacle", "ground"))
