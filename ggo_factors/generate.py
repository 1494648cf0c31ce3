"""The paper's procedures: one step or many, each gait checked before it is returned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.arrays import Array, as_angles, as_array, as_count, as_instance, as_number, as_tuple_of
from ggo_factors.errors import GraphError, InfeasibleGaitError, InputError, UnreachableFootholdError, Violation
from ggo_factors.gait import Gait, swap_roles
from ggo_factors.graph import GaitGraph
from ggo_factors.model import LegModel
from ggo_factors.solve import Solution
from ggo_factors.terrain import Gap, Obstacle, stair_ground
from ggo_factors.verify import Tolerances, misplaced
from ggo_factors.walk import Step, Walk, verify_step

UPRIGHT = math.pi / 2.0
# Half the width of the box that stands for the edge of a stair (paper, section V-C: [0.28, 0.30] for an edge at 0.29).
EDGE_HALF_WIDTH = 0.01
# How often a step is solved with the edge that broke its limit made stiffer, and how much stiffer.
MOST_ATTEMPTS = 5
STIFFER = 10.0
STEEPER = 2.0
POSE_GAIN = 5.0
HELD_FASTER = 3.0
HIGHER = 0.01
OBSTACLE_MARGIN = 0.02  # the paper's delta
GROUND_MARGIN = 0.01
# The foothold is aimed at more closely than the check asks for: two errors may meet between one step and the next.
FOOTHOLD_AIM = 0.0005
MOST_STEPS = 1000
SEARCH_SHIFTS = (0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.24, 0.31)


def step_over(
    base: Gait,
    obstacles: Sequence[Obstacle],
    foothold: tuple[float, float] | None = None,
    model: LegModel | None = None,
    gain: float | None = None,
    gaps: Sequence[Gap] = (),
    start: ArrayLike | None = None,
) -> Solution:
    """One step over obstacles (paper, section V-B), checked.

    Args:
        base: the base gait.
        obstacles: boxes to step over, in the body frame of this step.
        foothold: where P must land in [m], shape (2,); where the base gait lands, on the ground, if None.
        model: the legs; the base gait's own if None.
        gain: omega of the end edge; 5 m if None, raised where that leaves the foothold by more than the tolerance.
        gaps: pits with no foothold in them.
        start: frame that the walker stands in, shape (4,) in [rad]; the base gait's first if None.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check, with the numbers and the nearest foothold that works.
    """
    as_instance(base, "base", Gait)
    target = (float(base.endpoints(model)[-1, 0]), 0.0) if foothold is None else foothold
    step = Step(target, as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap))
    return walk(base, [step], model=model, start=start, gain=gain).steps[0]


def walk(
    base: Gait,
    steps: Sequence[Step],
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    gain: float | None = None,
) -> Walk:
    """Any sequence of steps, the legs' roles swapped between them, each anchored where the last one ended.

    Args:
        base: the base gait, which every step bends.
        steps: what each step must do.
        model: the legs; the base gait's own if None.
        start: frame that the walker stands in, shape (4,) in [rad], for example `STANDING`; the base gait's first
            if None.
        gain: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step, with its number, the numbers, and the nearest
            foothold that works.
    """
    legs = as_instance(base, "base", Gait).legs(model)
    asked = as_tuple_of(steps, "steps", Step)
    if not asked:
        raise InputError("steps: a walk needs at least one step")
    omega = None if gain is None else as_number(gain, "gain", above=0.0)
    frame = base.frames[0] if start is None else as_angles(start, "start", (4,))
    solutions: list[Solution] = []
    plan: list[Step] = []
    off = np.zeros(2)  # where the supporting foot stands beyond where it was to stand
    for number, step in enumerate(asked, start=1):
        seen = step.shifted(*off.tolist()) if off.any() else step
        pose = solutions[-1].gait.frames[-1] if step.keep_pose and solutions else None
        solution = _checked_step(_Task(base, seen, legs, frame, pose, omega), number)
        solutions.append(solution)
        plan.append(seen)
        frame = swap_roles(solution.gait.frames[-1])
        off = legs.endpoint(solution.gait.frames[-1]) - seen.landing(legs)
    return Walk(tuple(solution.gait for solution in solutions), tuple(plan), tuple(solutions))


def adjust_stride(
    base: Gait,
    stride: float | None = None,
    model: LegModel | None = None,
    gaps: Sequence[Gap] = (),
    steps: int = 2,
    start: ArrayLike | None = None,
) -> Walk:
    """Steps of another stride (paper, section V-A); a pit is stepped over by a longer one.

    Args:
        base: the base gait.
        stride: distance that P travels in a full step in [m]; if None, that of the base gait, or the nearest to it
            whose footholds keep out of the gaps.
        model: the legs; the base gait's own if None.
        gaps: pits with no foothold in them, in the body frame of the first step.
        steps: number of steps.
        start: frame that the walker stands in; the base gait's first if None.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where a foothold lies in a gap, or no gait passes the check.
    """
    legs = as_instance(base, "base", Gait).legs(model)
    count = as_count(steps, "steps", 1, MOST_STEPS)
    pits = as_tuple_of(gaps, "gaps", Gap)
    if stride is None:
        half = _half_stride_past(base.stride(legs) / 2.0, [pit.for_ankle(legs.foot) for pit in pits], count, legs)
    else:
        half = as_number(stride, "stride", above=0.0, unit="m") / 2.0
    plan = [Step((half, 0.0), gaps=tuple(pit.shifted(half * k) for pit in pits)) for k in range(count)]
    return walk(base, plan, model=legs, start=start)


def climb_stairs(
    base: Gait,
    riser: float | Sequence[float] = 0.10,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
) -> Walk:
    """Stairs up, foot over foot, the shank upright at landing (paper, section V-C).

    Args:
        base: the base gait.
        riser: height of the risers in [m], above 0; a number, or one for each step.
        tread: depth of the treads and distance of the footholds in [m].
        first_edge: x of the first riser in the body frame of the first step in [m], between 0 and `tread`.
        steps: number of steps; 2, or as many as there are risers, if None.
        model: the legs; the base gait's own if None.
        start: frame that the walker stands in; the base gait's first if None.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step.
    """
    return _stairs(base, riser, 1.0, tread, first_edge, steps, model, start)


def descend_stairs(
    base: Gait,
    riser: float | Sequence[float] = 0.10,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
) -> Walk:
    """Stairs down, foot over foot; arguments and errors as for `climb_stairs`."""
    return _stairs(base, riser, -1.0, tread, first_edge, steps, model, start)


def _stairs(
    base: Gait,
    riser: float | Sequence[float],
    direction: float,
    tread: float,
    first_edge: float,
    steps: int | None,
    model: LegModel | None,
    start: ArrayLike | None,
) -> Walk:
    depth = as_number(tread, "tread", above=0.0, unit="m")
    edge = as_number(first_edge, "first_edge", above=0.0, unit="m")
    if not edge < depth:
        raise InputError(f"first_edge: {edge:g} m must be below the tread {depth:g} m, where the first foothold is")
    rises = direction * _risers(riser, steps)
    ground = stair_ground(edge, depth, rises.tolist())
    plan = []
    for k, rise in enumerate(rises):
        here = ground.shifted(depth * k, float(rises[:k].sum()))
        ahead = Obstacle(edge - EDGE_HALF_WIDTH, edge + EDGE_HALF_WIDTH, max(float(rise), 0.0))
        # The paper's stairs have two steps; from the third on the pose of the second is the one to keep.
        plan.append(Step((depth, float(rise)), (ahead,), shank_angle=UPRIGHT, ground=here, keep_pose=k >= 2))
    return walk(base, plan, model=model, start=start)


def _risers(riser: float | Sequence[float], steps: int | None) -> Array:
    if np.ndim(riser) == 0:
        count = as_count(2 if steps is None else steps, "steps", 1, MOST_STEPS)
        return np.full(count, as_number(riser, "riser", above=0.0, unit="m"))
    rises = as_array(riser, "riser", (None,))
    for rise in rises:
        as_number(rise, "riser", above=0.0, unit="m")
    if len(rises) == 0 or (steps is not None and as_count(steps, "steps", 1) != len(rises)):
        raise InputError(f"riser: {len(rises)} risers for {steps if steps is not None else 'at least 1'} steps")
    return rises


def _half_stride_past(half: float, pits: Sequence[Gap], count: int, model: LegModel) -> float:
    """The half stride nearest to `half` whose footholds all keep clear of the pits, longer ones first on a tie."""
    spare = 0.01
    every = np.arange(1, count + 1)
    shifts = np.arange(0.0, 2.0 * model.reach, 0.005)
    for candidate in np.stack([half + shifts, half - shifts], -1).ravel():
        places = candidate * every
        if candidate > 0.0 and not any(
            ((pit.x_start - spare < places) & (places < pit.x_end + spare)).any() for pit in pits
        ):
            return float(candidate)
    raise InfeasibleGaitError(f"no stride within the legs' reach of {model.reach:g} m keeps out of the gaps")


# -- one step ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Task:
    """One step to be made: what it bends, what it must do, and where the walker stands."""

    base: Gait
    step: Step
    model: LegModel
    start: Array
    pose: Array | None  # to land in, as far as the foothold lets it
    gain: float | None  # omega, or None for 5 m


@dataclass(frozen=True)
class _Stiffness:
    """Gains of one attempt at a step, the paper's at first."""

    end: float
    knee: float = 5.0
    gamma: float = 4.0
    hold: float = 1.0
    spare: float = 0.0  # height in [m] beyond the margins

    def against(self, kinds: set[str], end_given: bool) -> _Stiffness:
        """Stiffer where a limit of one of these kinds was broken."""
        low = bool(kinds & {"obstacle", "ground"})
        return _Stiffness(
            self.end * (STIFFER if kinds & {"foothold", "shank"} and not end_given else 1.0),
            self.knee * (STIFFER if "knee" in kinds else 1.0),
            self.gamma * (STEEPER if low else 1.0),
            self.hold * (HELD_FASTER if "hip drop" in kinds else 1.0),
            self.spare + (HIGHER if low else 0.0),
        )


def _first_stiffness(task: _Task) -> _Stiffness:
    return _Stiffness(5.0 * len(task.base) if task.gain is None else task.gain)


def _checked_step(task: _Task, number: int) -> Solution:
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


def _best_solution(task: _Task) -> Solution:
    """The step solved with the paper's gains, then with the edges stiffer that broke their limits."""
    stiffness = _first_stiffness(task)
    solution = _solve(task, stiffness)
    for _ in range(MOST_ATTEMPTS - 1):
        broken = {violation.kind for violation in solution.violations}
        if solution.report.foothold_error > FOOTHOLD_AIM:
            broken.add("foothold")
        stiffer = stiffness.against(broken, task.gain is not None)
        if stiffer == stiffness:
            break
        stiffness = stiffer
        try:
            solution = _solve(task, stiffness)
        except GraphError:
            break  # too stiff to be solved: what the last attempt left broken is the answer
    return solution


def _solve(task: _Task, stiffness: _Stiffness) -> Solution:
    step, model = task.step, task.model
    graph = GaitGraph(task.base, model, knee_gain=stiffness.knee)
    graph.anchor(task.start)
    hold, gamma = stiffness.hold, stiffness.gamma
    for obstacle in step.obstacles:
        graph.add_obstacle(obstacle, hold=hold, gamma=gamma, margin=OBSTACLE_MARGIN + stiffness.spare)
    graph.add_ground(step.ground, hold=hold, gamma=gamma, margin=GROUND_MARGIN + stiffness.spare)
    if step.end_frame is not None:
        graph.anchor(step.end_frame, frame=-1)
    else:
        graph.end(step.landing(model), step.shank_angle, stiffness.end)
        if task.pose is not None:
            graph.end(pose=task.pose, gain=POSE_GAIN)
    solution = graph.solve()
    origin = f"generated from {task.base.name}" if task.base.name else task.base.origin
    gait = replace(solution.gait, name=f"step to {step.landing(model)[0]:.3f} m", origin=origin)
    return replace(solution, gait=gait, check=partial(verify_step, gait, step, model, task.start))


def _require_reach(task: _Task, number: int) -> None:
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


def _impossible(task: _Task) -> list[Violation]:
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


def _nearest_foothold(task: _Task) -> tuple[float, float] | None:
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
                if _solve(moved, _first_stiffness(moved)).ok:
                    return foothold
            except GraphError:
                continue
    return None
