"""The paper's procedures: one step or many, each gait checked before it is returned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.arrays import Array, as_angles, as_array, as_count, as_number
from ggo_factors.errors import GraphError, InfeasibleGaitError, InputError, UnreachableFootholdError, Violation
from ggo_factors.gait import Gait, swap_roles
from ggo_factors.graph import GaitGraph
from ggo_factors.model import LegModel
from ggo_factors.solve import Solution
from ggo_factors.terrain import Gap, Obstacle, stair_ground
from ggo_factors.verify import Tolerances
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
SEARCH_STEP = 0.02
SEARCH_MOST = 60


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
    target = (float(base.endpoints(model)[-1, 0]), 0.0) if foothold is None else foothold
    step = Step(foothold=target, obstacles=tuple(obstacles), gaps=tuple(gaps))
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
    legs = base.legs(model)
    plan = tuple(steps)
    if not plan:
        raise InputError("steps: a walk needs at least one step")
    for step in plan:
        if not isinstance(step, Step):
            raise InputError(f"steps: expected Steps, got {step!r:.80}")
    omega = None if gain is None else as_number(gain, "gain", above=0.0)
    frame = base.frames[0] if start is None else as_angles(start, "start", (4,))
    solutions: list[Solution] = []
    for number, step in enumerate(plan, start=1):
        pose = solutions[-1].gait.frames[-1] if step.keep_pose and solutions else None
        solution = _checked_step(_Task(base, step, legs, frame, pose, omega), number)
        solutions.append(solution)
        frame = swap_roles(solution.gait.frames[-1])
    return Walk(tuple(solution.gait for solution in solutions), plan, tuple(solutions))


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
    legs = base.legs(model)
    count = as_count(steps, "steps", 1)
    if stride is None:
        half = _half_stride_past(base.stride(legs) / 2.0, [gap.for_ankle(legs.foot) for gap in gaps], count, legs)
    else:
        half = as_number(stride, "stride", above=0.0, unit="m") / 2.0
    plan = [Step((half, 0.0), gaps=tuple(gap.shifted(half * k) for gap in gaps)) for k in range(count)]
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
    if isinstance(riser, (int, float)):
        count = as_count(2 if steps is None else steps, "steps", 1)
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
    impossible = _impossible(task)
    if impossible is None:
        solution = _best_solution(task)
        if solution.ok:
            return solution
        faults = ([] if solution.converged else [solution.reason]) + [str(v) for v in solution.violations]
        message, violations = "no gait found that passes the check: " + "; ".join(faults), solution.violations
    elif isinstance(impossible, UnreachableFootholdError):
        raise UnreachableFootholdError(f"step {number}: {impossible}", impossible.distance, impossible.reach, number)
    else:
        message, violations = str(impossible), impossible.violations
    nearest = _nearest_foothold(task)
    hint = "" if nearest is None else f"; nearest foothold that works: ({nearest[0]:.3f}, {nearest[1]:.3f}) m"
    raise InfeasibleGaitError(f"step {number}: {message}{hint}", violations, nearest, number)


def _best_solution(task: _Task) -> Solution:
    """The step solved with the paper's gains, then with the edges stiffer that broke their limits."""
    stiffness = _first_stiffness(task)
    solution = _solve(task, stiffness)
    for _ in range(MOST_ATTEMPTS - 1):
        stiffer = stiffness.against({violation.kind for violation in solution.violations}, task.gain is not None)
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
    return replace(solution, gait=gait, report=verify_step(gait, step, model, task.start))


def _impossible(task: _Task) -> InfeasibleGaitError | None:
    """Why no gait at all can do this step, whatever the graph says; None where nothing is known against it."""
    step, foot = task.step, task.model.foot
    x, y = step.landing(task.model)
    distance, reach = math.hypot(x, y), 2.0 * task.model.reach
    if distance > reach:
        return UnreachableFootholdError(
            f"foothold ({x:g}, {y:g}) is {distance:.3f} m from the supporting foot, two legs reach {reach:.3f} m",
            distance,
            reach,
        )
    from_x, from_y = task.model.endpoint(task.start).tolist()
    for obstacle in step.obstacles:
        box = obstacle.for_ankle(foot)
        what = f"obstacle [{obstacle.x_start:g}, {obstacle.x_end:g}] m, height {obstacle.height:g} m,"
        for name, at, height in (("supporting foot", 0.0, 0.0), ("swinging foot's start", from_x, from_y)):
            if box.x_start <= at <= box.x_end and height <= box.height:
                fault = Violation(f"obstacle in the {name}", None, at, box.x_start, "m")
                return InfeasibleGaitError(f"{what} stands in the {name} at x = {at:.3f} m", (fault,))
        if box.x_start <= x <= box.x_end and y < box.height:
            fault = Violation("foothold in an obstacle", None, x, box.x_start, "m")
            return InfeasibleGaitError(f"{what} stands on the foothold at x = {x:g} m", (fault,))
    for gap in step.gaps:
        pit = gap.for_ankle(foot)
        if pit.x_start < x < pit.x_end:
            fault = Violation("foothold in a gap", None, x, pit.x_start, "m")
            return InfeasibleGaitError(
                f"foothold x = {x:g} m lies in the gap [{gap.x_start:g}, {gap.x_end:g}] m", (fault,)
            )
    level = float(step.ground.height_at(x))
    if abs(y - level) > Tolerances().foothold:
        fault = Violation("foothold off the ground", None, y, level, "m")
        return InfeasibleGaitError(
            f"foothold ({x:g}, {y:g}) m is not on the ground, which is at {level:g} m there; give the step its ground",
            (fault,),
        )
    return None


def _nearest_foothold(task: _Task) -> tuple[float, float] | None:
    """The nearest foothold on the ground, forward or back, that a checked gait reaches; None where none is found."""
    if task.step.end_frame is not None:
        return None
    x, _ = task.step.landing(task.model)
    shifts = SEARCH_STEP * np.arange(1, SEARCH_MOST // 2 + 1)
    for place in np.stack([x - shifts, x + shifts], -1).ravel():
        foothold = (round(float(place), 6), float(task.step.ground.height_at(place)))
        moved = replace(task, step=replace(task.step, foothold=foothold))
        fault = _impossible(moved)
        if fault is not None:
            if any(violation.kind.startswith("obstacle in the s") for violation in fault.violations):
                return None  # a standing foot is in the way: no foothold helps
            continue
        if _solve(moved, _first_stiffness(moved)).ok:
            return foothold
    return None
