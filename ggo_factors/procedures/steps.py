"""The paper's procedures: one step or many, each gait checked before it is returned."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Gap, Obstacle, stair_ground
from ggo_factors.procedures.search import checked_step
from ggo_factors.procedures.task import Manner, StepSolution, StepTask
from ggo_factors.support.inputs import Array, as_angles, as_array, as_count, as_instance, as_number, as_tuple_of
from ggo_factors.walking.step import Step
from ggo_factors.walking.walk import Walk

UPRIGHT = math.pi / 2.0
# Half the width of the box that stands for the edge of a stair (paper, section V-C: [0.28, 0.30] for an edge at 0.29).
EDGE_HALF_WIDTH = 0.01
MOST_STEPS = 1000
FASTEST = 50.0
"""No joint of a walker moves faster, in [rad/s]."""
SMOOTHING = 0.2
"""Share of a step's duration over which its offset from the base gait bends: the smoothness is the square of so many
frames, 100 for 51 of them."""


def step_over(
    base: Gait,
    obstacles: Sequence[Obstacle],
    foothold: tuple[float, float] | None = None,
    model: LegModel | None = None,
    gain: float | None = None,
    gaps: Sequence[Gap] = (),
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
) -> StepSolution:
    """One step over obstacles (paper, section V-B), checked.

    Args:
        base: the base gait.
        obstacles: boxes to step over, in the body frame of this step.
        foothold: where P must land in [m], shape (2,); where the base gait lands, on the ground, if None.
        model: the legs; the base gait's own if None.
        gain: omega of the end edge; 10 m if None, 5 m without smoothness, raised where that leaves the foothold by more
            than the tolerance.
        gaps: pits with no foothold in them.
        start: frame that the walker is in, shape (4,) in [rad]; the base gait's first if None.
        start_rate: how fast its joints move there, shape (4,) in [rad/s]; if None, as the base gait does where no
            `start` is given, else not at all.
        smoothness: gain of the second-order edges, see `GaitGraph`; by default what keeps the joints' accelerations
            near the base gait's, 0 for the paper's graph.
        hard: whether foothold, knees, clearance and joint limits are met to 1e-6, as constraints.
        limits: angles, speeds and accelerations that the joints must keep to; not looked at if None.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check, with the numbers and the nearest foothold that works.
    """
    as_instance(base, "base", Gait)
    target = (float(base.endpoints(model)[-1, 0]), 0.0) if foothold is None else foothold
    step = Step(target, as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap))
    return _solved(base, [step], model, start, gain, start_rate, smoothness, hard, limits)[0]


def walk(
    base: Gait,
    steps: Sequence[Step],
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    gain: float | None = None,
    start_rate: ArrayLike | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
) -> Walk:
    """Any sequence of steps, the legs' roles swapped between them, each anchored where the last one ended.

    Args:
        base: the base gait, which every step bends.
        steps: what each step must do.
        model: the legs; the base gait's own if None.
        start: frame that the walker is in, shape (4,) in [rad], for example `STANDING`; the base gait's first if None.
        gain: as for `step_over`.
        start_rate: as for `step_over`. Each later step goes on as fast as the one before ended.
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step, with its number, the numbers, and the nearest
            foothold that works.
    """
    solutions = _solved(base, steps, model, start, gain, start_rate, smoothness, hard, limits)
    gaits, plan = (solution.gait for solution in solutions), (solution.task.step for solution in solutions)
    return Walk(tuple(gaits), tuple(plan), tuple(solutions))


def _solved(
    base: Gait,
    steps: Sequence[Step],
    model: LegModel | None,
    start: ArrayLike | None,
    gain: float | None,
    start_rate: ArrayLike | None,
    smoothness: float | None,
    hard: bool,
    limits: JointLimits | None,
) -> list[StepSolution]:
    """The steps of a walk, as it says."""
    legs = as_instance(base, "base", Gait).legs(model)
    asked = as_tuple_of(steps, "steps", Step)
    if not asked:
        raise InputError("steps: a walk needs at least one step")
    omega = None if gain is None else as_number(gain, "gain", above=0.0)
    if limits is not None:
        as_instance(limits, "limits", JointLimits)
    frame = base.frames[0] if start is None else as_angles(start, "start", (4,))
    if start_rate is None:
        drift = np.zeros(4) if start is None else -np.diff(base.frames[:2], axis=0)[0]
    else:
        rate = as_array(start_rate, "start_rate", (4,))
        if not np.abs(rate).max() <= FASTEST:
            raise InputError(f"start_rate: {np.abs(rate).max():g} rad/s is above {FASTEST:g} rad/s")
        if smoothness == 0.0:
            raise InputError("start_rate: without smoothness nothing keeps the rate; leave one of the two out")
        drift = rate * base.dt - np.diff(base.frames[:2], axis=0)[0]
    manner = Manner(omega, _smoothness(base, smoothness), bool(hard), limits)
    solutions: list[StepSolution] = []
    off = np.zeros(2)  # where the supporting foot stands beyond where it was to stand
    for number, step in enumerate(asked, start=1):
        seen = step.shifted(*off.tolist()) if off.any() else step
        pose = solutions[-1].gait.frames[-1] if step.keep_pose and solutions else None
        solution = checked_step(StepTask(base, seen, legs, frame[None], drift, pose, manner, f"step {number}", number))
        solutions.append(solution)
        frame = swap_roles(solution.gait.frames[-1])
        drift = swap_roles(np.diff((solution.gait.frames - base.frames)[-2:], axis=0)[0])
        off = legs.endpoint(solution.gait.frames[-1]) - seen.landing(legs)
    return solutions


def adjust_stride(
    base: Gait,
    stride: float | None = None,
    model: LegModel | None = None,
    gaps: Sequence[Gap] = (),
    steps: int = 2,
    start: ArrayLike | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
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
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.

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
    return walk(base, plan, model=legs, start=start, smoothness=smoothness, hard=hard, limits=limits)


def climb_stairs(
    base: Gait,
    riser: float | Sequence[float] = 0.10,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
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
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step.
    """
    return _stairs(base, riser, 1.0, tread, first_edge, steps, model, start, smoothness, hard, limits)


def descend_stairs(
    base: Gait,
    riser: float | Sequence[float] = 0.10,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
) -> Walk:
    """Stairs down, foot over foot; arguments and errors as for `climb_stairs`."""
    return _stairs(base, riser, -1.0, tread, first_edge, steps, model, start, smoothness, hard, limits)


def _stairs(
    base: Gait,
    riser: float | Sequence[float],
    direction: float,
    tread: float,
    first_edge: float,
    steps: int | None,
    model: LegModel | None,
    start: ArrayLike | None,
    smoothness: float | None,
    hard: bool,
    limits: JointLimits | None,
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
    return walk(base, plan, model=model, start=start, smoothness=smoothness, hard=hard, limits=limits)


def _smoothness(base: Gait, wanted: float | None) -> float:
    """The gain that was asked for, or the default, which bends alike at any sampling rate."""
    if wanted is None:
        return (SMOOTHING * (len(base) - 1)) ** 2
    return as_number(wanted, "smoothness", at_least=0.0)


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
