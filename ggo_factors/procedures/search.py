"""One step of a walk: solved with the paper's gains, with stiffer ones where the check is not content, or refused."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ggo_factors.check.joint_rates import limit_faults
from ggo_factors.check.leg_collision import SEGMENTS
from ggo_factors.check.uncertainty import all_cautious
from ggo_factors.check.verify import STANDARD, Report
from ggo_factors.errors import GraphError, InfeasibleGaitError
from ggo_factors.graph.gait_graph import GaitGraph
from ggo_factors.graph.inequalities import LEG_GAIN, LIMIT_GAIN
from ggo_factors.graph.sampling import Sampling
from ggo_factors.motion.gait import Gait
from ggo_factors.procedures.feasibility import impossible
from ggo_factors.procedures.task import MOST_MOTIONS, StepSolution, StepTask
from ggo_factors.support.inputs import Array
from ggo_factors.walking.walk import verify_step

# How often a step is solved with the edge that broke its limit made stiffer, and how much stiffer.
MOST_ATTEMPTS = 5
MOST_WITHIN_LIMITS = 3  # of the joints: what three attempts do not mend contradicts them (none of 300 replans was lost)
MOST_ITERATIONS, MOST_SEARCHED = 500, 400
"""No other attempt after so many iterations of the solver, and no other foothold: what takes long is not to be had."""
STIFFER = 10.0
STEEPER = 2.0
POSE_GAIN = 5.0
HELD_FASTER = 3.0
HIGHER = 0.01
OBSTACLE_MARGIN = 0.02  # the paper's delta
CAUTIOUS_MARGIN = 0.01  # the box itself is larger than it was measured
LEG_MARGIN = 0.01
INSIDE, SAFER, MOST_BETWEEN = 0.02, 1.2, 0.35
"""An upsampled gait is held to speeds and accelerations smaller by the first share: a spline swings beyond the frames
that it goes through. Where that does not do, they are made smaller by so many times what it still swings beyond them,
unless that is more than the last share, which no spline does."""
HARD_MARGIN = 0.005  # a constraint gives way nowhere but between two frames
GROUND_MARGIN = 0.01
HIP_SINKS = 0.1
"""Share of the leg by which the hip may sink before an edge pushes it up, half of what the check allows."""
END_GAIN, SMOOTH_END_GAIN = 5.0, 10.0
"""Gain of the end edge for each frame: the paper's, and where second-order edges pull against it too."""
# The foothold is aimed at more closely than the check asks for: two errors may meet between one step and the next.
FOOTHOLD_AIM = 0.0005
RATE_KINDS = {f"{joint} {kind}" for joint in ("hip", "knee") for kind in ("speed", "acceleration")}
LIMIT_KINDS = RATE_KINDS | {"hip angle", "knee angle"}
SEARCH_SHIFTS = (0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.24, 0.31)


@dataclass(frozen=True)
class _Stiffness:
    """Gains of one attempt at a step, the paper's at first."""

    end: float
    knee: float = 5.0
    limits: float = LIMIT_GAIN
    legs: float = LEG_GAIN
    gamma: float = 4.0
    hold: float = 1.0
    spare: float = 0.0  # height in [m] beyond the margins
    inside: float = 0.0  # share by which speeds and accelerations are to stay inside their limits

    def against(self, kinds: set[str], end_given: bool, between: float) -> _Stiffness:
        """Stiffer where a limit of one of these kinds was broken.

        Args:
            kinds: kinds of violations.
            end_given: whether the end edge keeps its gain.
            between: share by which joints go beyond their limits between the frames that were solved for, which a
                stiffer edge does not mend.
        """
        low = bool(kinds & {"obstacle", "ground", "hit probability"})
        hit = any(kind.startswith(SEGMENTS) for kind in kinds)
        return _Stiffness(
            self.end * (STIFFER if kinds & {"foothold", "shank"} and not end_given else 1.0),
            self.knee * (STIFFER if "knee" in kinds else 1.0),
            self.limits * (STIFFER if kinds & LIMIT_KINDS and not between else 1.0),
            self.legs * (STIFFER if hit else 1.0),
            self.gamma * (STEEPER if low else 1.0),
            self.hold * (HELD_FASTER if "hip drop" in kinds else 1.0),
            self.spare + (HIGHER if low or hit else 0.0),
            self.inside + SAFER * between,
        )


def _first_stiffness(task: StepTask) -> _Stiffness:
    motions = len(task.base) - 1
    inside = INSIDE if motions > MOST_MOTIONS else 0.0
    if task.manner.gain is None:
        per_frame = SMOOTH_END_GAIN if task.manner.smoothness else END_GAIN
        return _Stiffness(per_frame * (min(motions, MOST_MOTIONS) + 1), inside=inside)
    return _Stiffness(task.manner.gain * max(1.0, motions / MOST_MOTIONS), inside=inside)


def checked_step(task: StepTask) -> StepSolution:
    """A solution that passes the check.

    Raises:
        InfeasibleGaitError: with the step's name and number, the violations, and the nearest foothold that works.
    """
    task.model.require_reach(*task.step.landing(task.model), name=f"{task.name}: ", step=task.number)
    violations = tuple(impossible(task))
    if violations:
        message = "; ".join(str(violation) for violation in violations)
    else:
        try:
            solution = _best_solution(task)
        except GraphError as error:
            raise InfeasibleGaitError(f"{task.name}: no gait found: {error}", (), None, task.number) from error
        if solution.ok:
            return solution
        violations = solution.violations
        faults = ([] if solution.converged else [solution.reason]) + [str(violation) for violation in violations]
        message = "no gait found that passes the check: " + "; ".join(faults)
    nearest = _nearest_foothold(task)
    hint = "" if nearest is None else f"; nearest foothold that works: ({nearest[0]:.3f}, {nearest[1]:.3f}) m"
    raise InfeasibleGaitError(f"{task.name}: {message}{hint}", violations, nearest, task.number)


def _best_solution(task: StepTask) -> StepSolution:
    """The step solved with the paper's gains, then with the edges stiffer that broke their limits."""
    stiffness = _first_stiffness(task)
    try:
        solution = _solve(task, stiffness)
    except GraphError:
        if task.manner.limits is None or task.manner.hard:
            raise
        # Limits that are too tight make soft edges too stiff to be solved; constraints tell which cannot be met.
        return _solve(task.held(hard=True), stiffness)
    spent = solution.iterations
    for attempt in range(1, MOST_ATTEMPTS if task.manner.limits is None else MOST_WITHIN_LIMITS):
        if spent > MOST_ITERATIONS:
            return solution
        if not solution.converged and (task.manner.hard or attempt > 1):
            break  # constraints that contradict each other stay so, and what is too stiff gets no better by more of it
        broken = {violation.kind for violation in solution.violations}
        if solution.report.foothold_error > FOOTHOLD_AIM:
            broken.add("foothold")
        given = task.manner.gain is not None or task.manner.hard
        stiffer = stiffness.against(broken, given, _between(task, solution))
        if stiffer == stiffness:
            break
        stiffness = stiffer
        try:
            solution = _solve(task, stiffness, solution)
        except GraphError:
            break  # too stiff to be solved: what the last attempt left broken is the answer
        spent += solution.iterations
    if task.manner.limits is not None and not task.manner.hard and not solution.ok:
        # Joint limits and the rest pull against each other: constraints tell whether all can be had.
        with suppress(GraphError):
            kept = _solve(task.held(hard=True), _first_stiffness(task))
            return kept if kept.ok or not solution.converged else solution
    return solution


def _between(task: StepTask, solution: StepSolution) -> float:
    """The share by which an upsampled gait goes beyond limits of the joints' rates.

    0 where every frame was solved for, or the share is so large that frames solved for break the limit too.
    """
    rates = [fault for fault in solution.violations if fault.kind in RATE_KINDS]
    if solution.frames_apart == 1.0 or not rates:
        return 0.0
    share = max(abs(fault.value / fault.limit) for fault in rates) - 1.0
    return share if share < MOST_BETWEEN else 0.0


def _solve(task: StepTask, stiffness: _Stiffness, before: StepSolution | None = None) -> StepSolution:
    """The step solved with these gains, from where the attempt before ended if there was one."""
    step, model, manner, done = task.step, task.model, task.manner, task.done
    fine, rest, every = task.ahead
    smoothness = manner.smoothness / every**2
    lifted = None if manner.hard else fine
    graph = GaitGraph(rest, model, knee_gain=stiffness.knee, smoothness=smoothness, hard=manner.hard, fine=lifted)
    graph.anchor(task.walked[-1])
    carried = task.carried
    if carried is not None:
        # The walker is in motion: a first frame that follows from it joins the steps without a jump in joint speed.
        if every == 1.0:
            graph.anchor(carried, frame=1)
        else:
            # The first frame of the full rate is not among those of the graph.
            graph.begin_with(every * task.slowed, 1.0 / every)
    if manner.limits is not None:
        graph.limit_joints(manner.limits.tightened(stiffness.inside), stiffness.limits)
    landing = step.landing(model)
    hip = float(model.hip_height(task.walked[0]))
    graph.keep_hip_above(hip - max(0.0, -float(landing[1])) - HIP_SINKS * model.reach)
    hold, gamma = stiffness.hold, stiffness.gamma
    held = all_cautious(step.obstacles)
    for obstacle, box in zip(step.obstacles, held, strict=True):
        margin = HARD_MARGIN if manner.hard else CAUTIOUS_MARGIN if obstacle.is_uncertain else OBSTACLE_MARGIN
        graph.add_obstacle(box, hold=hold, gamma=gamma, margin=margin + stiffness.spare)
    graph.keep_legs_clear(held, step.ground, LEG_MARGIN + stiffness.spare, stiffness.legs)
    graph.add_ground(step.ground, hold=hold, gamma=gamma, margin=GROUND_MARGIN + stiffness.spare)
    if step.end_frame is not None:
        graph.anchor(step.end_frame, frame=-1)
    else:
        graph.end(landing, step.shank_angle, stiffness.end, hard=manner.hard)
        if task.pose is not None:
            graph.end(pose=task.pose, gain=POSE_GAIN)
    solution = graph.solve(initial=None if before is None else before.solved)
    origin = f"generated from {task.base.name}" if task.base.name else task.base.origin
    bent = solution.gait.frames if every == 1.0 else _upsampled(solution.gait, task)
    frames, name = np.concatenate([task.walked[:-1], bent]), f"step to {landing[0]:.3f} m"
    gait = replace(fine, frames=frames, model=model, name=name, origin=origin)
    made = {field.name: getattr(solution, field.name) for field in fields(solution)}
    made |= {"gait": gait, "check": partial(_checked, task, gait)}
    made |= {"keyframes": tuple(done + round(every * n) for n in solution.keyframes)}
    made |= {"first_frame": done, "frames_apart": every}
    return StepSolution(**made, task=task, solved=solution.gait.frames)


def _upsampled(bent: Gait, task: StepTask) -> Array:
    """Frames at the full rate: the offset from the base gait, solved for at fewer, is a cubic spline through them."""
    fine, rest, every = task.ahead
    weights = _curvature_weights(len(rest), moving=bool(task.manner.smoothness))
    curvature = weights @ np.vstack([bent.frames - rest.frames, every * task.slowed])
    sampling = Sampling(rest.frames, fine.frames)
    frames = sampling.frames(bent.frames) + sampling.curved(curvature)
    frames[[0, -1]] = bent.frames[[0, -1]]
    return np.asarray(frames)


@lru_cache(maxsize=8)
def _curvature_weights(count: int, moving: bool) -> Array:
    """How much values at `count` knots and the slope at the first count in the second derivatives of a spline there.

    Shape (count, count + 1). Without curvature at the ends, but at the first where it has the slope.
    """
    from scipy.interpolate import CubicSpline  # here, since it takes longer to import than all the rest

    free: Any = (2, np.zeros(count + 1))
    knots, values, slope = np.arange(count), np.eye(count, count + 1), np.eye(count + 1)[-1]
    spline = CubicSpline(knots, values, bc_type=((1, slope) if moving else free, free))
    return np.asarray(spline(knots, 2))


def _checked(task: StepTask, gait: Gait) -> Report:
    """The dense check of the whole step, joint limits of what is not walked yet."""
    report = verify_step(gait, task.step, task.model, task.walked[0])
    if task.manner.limits is None:
        return report
    first = max(len(task.walked) - 2, 0)
    ahead = replace(gait, frames=gait.frames[first:])
    faults = limit_faults(ahead, task.manner.limits, STANDARD.limits)
    found = [replace(fault, frame=None if fault.frame is None else fault.frame + first) for fault in faults]
    return replace(report, violations=(*report.violations, *found))


def _softly_first(task: StepTask) -> list[StepTask]:
    return [task.held(hard=False), task] if task.manner.hard else [task]


def _nearest_foothold(task: StepTask) -> tuple[float, float] | None:
    """The nearest of some footholds on the ground around the wanted one that a checked gait reaches, or None."""
    if task.step.end_frame is not None:
        return None
    x, _ = task.step.landing(task.model)
    spent = 0
    for shift in SEARCH_SHIFTS:
        for place in (x - shift, x + shift):
            foothold = (round(place, 6), float(task.step.ground.height_at(place)))
            moved = replace(task, step=replace(task.step, foothold=foothold))
            faults = impossible(moved)
            if any(violation.kind.startswith("obstacle") and "foothold" not in violation.kind for violation in faults):
                return None  # a standing foot is in the way, or nothing gets over: no foothold helps
            if faults or math.hypot(*foothold) > 2.0 * task.model.reach:
                continue
            if spent > MOST_SEARCHED:
                return None
            with suppress(GraphError):
                # Soft edges tell in a fraction of the time where constraints have no chance.
                for each in _softly_first(moved):
                    solution = _solve(each, _first_stiffness(each))
                    spent += solution.iterations
                    if not solution.ok:
                        break
                else:
                    return foothold
    return None
