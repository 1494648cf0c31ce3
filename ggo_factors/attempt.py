"""One step of a walk: solved with the paper's gains, with stiffer ones where the check is not content, or refused."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ggo_factors.active import LIMIT_GAIN
from ggo_factors.arrays import Array
from ggo_factors.errors import GraphError, InfeasibleGaitError, UnreachableFootholdError, Violation
from ggo_factors.gait import Gait
from ggo_factors.graph import GaitGraph
from ggo_factors.limits import JointLimits
from ggo_factors.model import LegModel
from ggo_factors.solve import Solution
from ggo_factors.verify import Tolerances, misplaced
from ggo_factors.walk import Step, verify_step

# How often a step is solved with the edge that broke its limit made stiffer, and how much stiffer.
MOST_ATTEMPTS = 5
STIFFER = 10.0
STEEPER = 2.0
POSE_GAIN = 5.0
HELD_FASTER = 3.0
HIGHER = 0.01
OBSTACLE_MARGIN = 0.02  # the paper's delta
GROUND_MARGIN = 0.01
HIP_SINKS = 0.1
"""Share of the leg by which the hip may sink before an edge pushes it up, half of what the check allows."""
# The foothold is aimed at more closely than the check asks for: two errors may meet between one step and the next.
FOOTHOLD_AIM = 0.0005
LEAST_FRAMES_FOR_A_RATE = 4
LIMIT_KINDS = {f"{joint} {kind}" for joint in ("hip", "knee") for kind in ("angle", "speed", "acceleration")}
SEARCH_SHIFTS = (0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.24, 0.31)


@dataclass(frozen=True)
class Manner:
    """How steps are made.

    Attributes:
        gain: omega of the end edge, or None for 5 m.
        smoothness: gain of the second-order edges.
        hard: whether foothold, knees, clearance and joint limits are constraints.
        limits: of the joints, or None.
    """

    gain: float | None
    smoothness: float
    hard: bool
    limits: JointLimits | None


@dataclass(frozen=True)
class Task:
    """One step to be made: what it bends, what it must do, and where the walker stands."""

    base: Gait
    step: Step
    model: LegModel
    start: Array
    drift: Array  # what the offset from the base gait changes by from one frame to the next, where the step begins
    pose: Array | None  # to land in, as far as the foothold lets it
    manner: Manner


@dataclass(frozen=True)
class _Stiffness:
    """Gains of one attempt at a step, the paper's at first."""

    end: float
    knee: float = 5.0
    limits: float = LIMIT_GAIN
    gamma: float = 4.0
    hold: float = 1.0
    spare: float = 0.0  # height in [m] beyond the margins

    def against(self, kinds: set[str], end_given: bool) -> _Stiffness:
        """Stiffer where a limit of one of these kinds was broken."""
        low = bool(kinds & {"obstacle", "ground"})
        return _Stiffness(
            self.end * (STIFFER if kinds & {"foothold", "shank"} and not end_given else 1.0),
            self.knee * (STIFFER if "knee" in kinds else 1.0),
            self.limits * (STIFFER if kinds & LIMIT_KINDS else 1.0),
            self.gamma * (STEEPER if low else 1.0),
            self.hold * (HELD_FASTER if "hip drop" in kinds else 1.0),
            self.spare + (HIGHER if low else 0.0),
        )


def _first_stiffness(task: Task) -> _Stiffness:
    return _Stiffness(5.0 * len(task.base) if task.manner.gain is None else task.manner.gain)


def checked_step(task: Task, number: int) -> Solution:
    """A solution that passes the check.

    Raises:
        InfeasibleGaitError: with the step's number, the violations, and the nearest foothold that works.
    """
    _require_reach(task, number)
    violations = tuple(_impossible(task))
    if violations:
        message = "; ".join(str(violation) for violation in violations)
    else:
        try:
            solution = _best_solution(task)
        except GraphError as error:
            raise InfeasibleGaitError(f"step {number}: no gait found: {error}", (), None, number) from error
        if solution.ok:
            return solution
        violations = solution.violations
        faults = ([] if solution.converged else [solution.reason]) + [str(violation) for violation in violations]
        message = "no gait found that passes the check: " + "; ".join(faults)
    nearest = _nearest_foothold(task)
    hint = "" if nearest is None else f"; nearest foothold that works: ({nearest[0]:.3f}, {nearest[1]:.3f}) m"
    raise InfeasibleGaitError(f"step {number}: {message}{hint}", violations, nearest, number)


def _best_solution(task: Task) -> Solution:
    """The step solved with the paper's gains, then with the edges stiffer that broke their limits."""
    stiffness = _first_stiffness(task)
    solution = _solve(task, stiffness)
    for _ in range(MOST_ATTEMPTS - 1):
        if task.manner.hard and not solution.converged:
            break  # constraints that contradict each other stay so
        broken = {violation.kind for violation in solution.violations}
        if solution.report.foothold_error > FOOTHOLD_AIM:
            broken.add("foothold")
        stiffer = stiffness.against(broken, task.manner.gain is not None or task.manner.hard)
        if stiffer == stiffness:
            break
        stiffness = stiffer
        try:
            solution = _solve(task, stiffness)
        except GraphError:
            break  # too stiff to be solved: what the last attempt left broken is the answer
    return solution


def _solve(task: Task, stiffness: _Stiffness) -> Solution:
    step, model, manner = task.step, task.model, task.manner
    graph = GaitGraph(task.base, model, knee_gain=stiffness.knee, smoothness=manner.smoothness, hard=manner.hard)
    graph.anchor(task.start)
    if manner.smoothness and len(task.base) >= LEAST_FRAMES_FOR_A_RATE:
        # The walker is in motion: a first frame that follows from it joins the steps without a jump in joint speed.
        graph.anchor(task.start + np.diff(task.base.frames[:2], axis=0)[0] + task.drift, frame=1)
    if manner.limits is not None:
        graph.limit_joints(manner.limits, stiffness.limits)
    landing = step.landing(model)
    hip = float(model.joints(task.start)[2, 1])
    graph.keep_hip_above(hip - max(0.0, -float(landing[1])) - HIP_SINKS * model.reach)
    hold, gamma = stiffness.hold, stiffness.gamma
    for obstacle in step.obstacles:
        graph.add_obstacle(obstacle, hold=hold, gamma=gamma, margin=OBSTACLE_MARGIN + stiffness.spare)
    graph.add_ground(step.ground, hold=hold, gamma=gamma, margin=GROUND_MARGIN + stiffness.spare)
    if step.end_frame is not None:
        graph.anchor(step.end_frame, frame=-1)
    else:
        graph.end(landing, step.shank_angle, stiffness.end, hard=manner.hard)
        if task.pose is not None:
            graph.end(pose=task.pose, gain=POSE_GAIN)
    solution = graph.solve()
    origin = f"generated from {task.base.name}" if task.base.name else task.base.origin
    gait = replace(solution.gait, name=f"step to {landing[0]:.3f} m", origin=origin)
    return replace(solution, gait=gait, check=partial(verify_step, gait, step, model, task.start, limits=manner.limits))


def _require_reach(task: Task, number: int) -> None:
    x, y = task.step.landing(task.model)
    distance, reach = math.hypot(x, y), 2.0 * task.model.reach
    if distance > reach:
        raise UnreachableFootholdError(
            f"step {number}: foothold ({x:g}, {y:g}) is {distance:.3f} m from the supporting foot, "
            f"two legs reach {reach:.3f} m",
            distance,
            reach,
            number,
        )


def _impossible(task: Task) -> list[Violation]:
    """What speaks against any gait at all for this step, whatever the graph says."""
    step, model = task.step, task.model
    from_x, from_y = model.endpoint(task.start).tolist()
    found = misplaced(
        model, (from_x, from_y), step.landing(model), step.obstacles, step.gaps, step.ground, Tolerances()
    )
    for obstacle in step.obstacles:
        if obstacle.height > 2.0 * model.reach:
            found.append(Violation("obstacle's height", None, obstacle.height, 2.0 * model.reach, "m", str(obstacle)))
    return found


def _softly_first(task: Task) -> list[Task]:
    return [replace(task, manner=replace(task.manner, hard=False)), task] if task.manner.hard else [task]


def _nearest_foothold(task: Task) -> tuple[float, float] | None:
    """The nearest of some footholds on the ground around the wanted one that a checked gait reaches, or None."""
    if task.step.end_frame is not None:
        return None
    x, _ = task.step.landing(task.model)
    for shift in SEARCH_SHIFTS:
        for place in (x - shift, x + shift):
            foothold = (round(place, 6), float(task.step.ground.height_at(place)))
            moved = replace(task, step=replace(task.step, foothold=foothold))
            faults = _impossible(moved)
            if any(violation.kind.startswith("obstacle") and "foothold" not in violation.kind for violation in faults):
                return None  # a standing foot is in the way, or nothing gets over: no foothold helps
            if faults or math.hypot(*foothold) > 2.0 * task.model.reach:
                continue
            try:
                # Soft edges tell in a fraction of the time where constraints have no chance.
                if all(_solve(each, _first_stiffness(each)).ok for each in _softly_first(moved)):
                    return foothold
            except GraphError:
                continue
    return None
