"""One step of a walk: solved with the first gains, then with stiffer ones until it passes the check, or refused."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ggo_factors.check.balance import with_balance
from ggo_factors.check.joint_rates import limit_faults
from ggo_factors.check.report import STANDARD, Report
from ggo_factors.errors import GraphError, InfeasibleGaitError
from ggo_factors.graph.rounds import solve_in_rounds
from ggo_factors.motion.gait import Gait
from ggo_factors.procedures.build import beginning_of, gait_of, impossible, problem_of
from ggo_factors.procedures.gains import RATE_KINDS, Gains, stiffer
from ggo_factors.procedures.task import Beginning, StepSolution, StepTask
from ggo_factors.walking.step import verify_step

MOST_ATTEMPTS = 5
"""A step is solved at most so often, each time with stiffer edges where a limit was broken."""
MOST_WITHIN_LIMITS = 3
"""With joint limits: three attempts; in 300 replans a fourth never helped."""
MOST_ITERATIONS = 500
"""Stop retrying after this many solver iterations; a step that needs more has never succeeded."""
MOST_SEARCHED = 400
"""Stop looking for another foothold after this many solver iterations."""
FOOTHOLD_AIM = 0.0005
"""Attempts go on until the foothold is met to this, in [m]: closer than the check asks for, since the landing errors
of two steps may add up."""
MOST_BETWEEN = 0.35
"""Largest share by which an upsampled spline swings beyond limits that its frames keep; where it is larger, the frames
break the limits too."""
NO_LANDING = "found only without landing edges: the step after it brings the walker home"
"""Note on a step for which no gait with landing edges passed the check."""
NOT_BALANCED = "not balanced: start and foothold leave the ZMP {:.0f} mm from the base gait's on average"
"""Note on a step that was to be balanced and is made without balance edges, which would bend it much and not help."""
SEARCH_SHIFTS = (0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.24, 0.31)
"""Distances in [m] before and beyond a refused foothold at which others are tried."""


def checked_step(task: StepTask) -> StepSolution:
    """The solution of a step, which passes the check.

    Raises:
        InfeasibleGaitError: with the step's name and number, the violations, and the nearest foothold that works.
    """
    task.model.require_reach(*task.step.landing(task.model), name=f"{task.name}: ", step=task.number)
    begin = beginning_of(task)
    violations = tuple(impossible(task, begin))
    if violations:
        message = "; ".join(str(violation) for violation in violations)
    else:
        try:
            best = _balanced_or_not if task.settings.balance else _best_or_without_landing
            solution = best(task, begin)
        except GraphError as error:
            raise InfeasibleGaitError(f"{task.name}: no gait found: {error}", (), None, task.number) from error
        if solution.converged and not solution.report.violations:
            return solution
        violations = solution.violations
        faults = ([] if solution.converged else [solution.reason]) + [str(violation) for violation in violations]
        message = "no gait found that passes the check: " + "; ".join(faults)
    nearest = _nearest_foothold(task, begin)
    hint = "" if nearest is None else f"; nearest foothold that works: ({nearest[0]:.3f}, {nearest[1]:.3f}) m"
    raise InfeasibleGaitError(f"{task.name}: {message}{hint}", violations, nearest, task.number)


def _balanced_or_not(task: StepTask, begin: Beginning) -> StepSolution:
    """The step with balance edges, or without where they do not bring the ZMP within its tolerance."""
    solution, settings = None, task.settings
    with suppress(GraphError):
        solution = _best_or_without_landing(task, begin)
        if solution.ok and not solution.report.zmp_off > STANDARD.balance:
            return solution
    try:
        free = replace(settings, balance=0.0, gains=replace(settings.gains, hold=Gains.hold))
        plain = _best_or_without_landing(replace(task, settings=free), begin)
    except GraphError:
        if solution is None:
            raise
        plain = solution
    if plain.ok or solution is None or not solution.ok:
        solution = plain
    report = with_balance(solution.report, solution.gait, task.model, task.base)
    notes = (*report.notes, NOT_BALANCED.format(report.zmp_off * 1e3))
    return replace(solution, task=task, report=replace(report, notes=notes))


def _best_or_without_landing(task: StepTask, begin: Beginning) -> StepSolution:
    """The step with landing edges, or without where no gait with them passes the check."""
    settings = task.settings
    if not settings.landing or settings.landing_forced or task.step.end_frame is not None:
        return _best_solution(task, begin)
    try:
        solution = _best_solution(task, begin)
        if solution.converged and not solution.report.violations:
            return solution
    except GraphError:
        solution = None
    try:
        freer = _best_solution(replace(task, settings=replace(settings, landing=False)), begin)
    except GraphError:
        if solution is None:
            raise
        return solution
    if solution is not None and not freer.ok:
        return solution
    return replace(freer, task=task, report=replace(freer.report, notes=(*freer.report.notes, NO_LANDING)))


def _best_solution(task: StepTask, begin: Beginning) -> StepSolution:
    """The step solved with the first gains, then with the edges stiffer that broke their limits."""
    gains, settings = task.settings.gains, task.settings
    try:
        solution = _attempt(task, begin, gains)
    except GraphError:
        if settings.limits is None or settings.hard:
            raise
        # Limits that are too tight make soft edges too stiff to be solved; constraints tell which cannot be met.
        return _attempt(_held(task, True), begin, gains)
    spent = solution.iterations
    for attempt in range(1, MOST_ATTEMPTS if settings.limits is None else MOST_WITHIN_LIMITS):
        if spent > MOST_ITERATIONS:
            return solution
        if not solution.converged and (settings.hard or attempt > 1):
            break  # contradicting constraints stay so, and a graph too stiff to converge gets no better when stiffer
        broken = set()
        for violation in solution.report.violations:
            broken.add(violation.kind)
        if solution.report.foothold_error > FOOTHOLD_AIM:
            broken.add("foothold")
        if not broken:
            break
        next_gains = stiffer(gains, broken, settings.gain_given or settings.hard, _between(solution))
        if next_gains == gains:
            break
        gains = next_gains
        try:
            solution = _attempt(task, begin, gains, solution)
        except GraphError:
            break  # too stiff to be solved: the last attempt is the answer
        spent += solution.iterations
    if settings.limits is not None and not settings.hard and not solution.ok:
        # Soft edges for joint limits and targets pull against each other: constraints show whether all can be met.
        with suppress(GraphError):
            kept = _attempt(_held(task, True), begin, settings.gains)
            return kept if kept.ok or not solution.converged else solution
    return solution


def _between(solution: StepSolution) -> float:
    """The share by which an upsampled gait goes beyond limits of the joints' rates.

    It is 0 where every frame was solved for, or where the share is so large that those solved for break limits too.
    """
    if solution.frames_apart == 1.0:
        return 0.0
    rates = [fault for fault in solution.violations if fault.kind in RATE_KINDS]
    share = max((abs(fault.value / fault.limit) for fault in rates), default=1.0) - 1.0
    return share if share < MOST_BETWEEN else 0.0


def _attempt(task: StepTask, begin: Beginning, gains: Gains, before: StepSolution | None = None) -> StepSolution:
    """The step solved with these gains, from where the attempt before ended if there was one, and checked."""
    initial = None if before is None else before.graph.state.frames
    solved = solve_in_rounds(problem_of(task, begin, gains), initial)
    gait = gait_of(task, begin, solved.graph.state.frames)
    return StepSolution(
        gait=gait,
        graph=solved.graph,
        converged=solved.converged,
        reason=solved.reason,
        iterations=solved.iterations,
        error_history=solved.error_history,
        rounds=solved.rounds,
        report=_checked(task, gait),
        first_frame=begin.done,
        frames_apart=begin.every,
        task=task,
    )


def _checked(task: StepTask, gait: Gait) -> Report:
    """The dense check of the whole step; joint limits only from where the walker is now."""
    report = verify_step(gait, task.step, task.model, task.walked[0])
    if task.settings.balance:
        report = with_balance(report, gait, task.model, task.base)
    if task.settings.limits is None:
        return report
    first, frames = max(len(task.walked) - 2, 0), gait.frames
    if len(task.walked) == 1 and task.last_motion is not None:
        first, frames = -1, np.concatenate([frames[:1] - task.last_motion, frames])
    ahead = replace(gait, frames=frames[max(first, 0) :])
    faults = limit_faults(ahead, task.settings.limits, STANDARD.limits)
    found = [replace(fault, frame=None if fault.frame is None else fault.frame + first) for fault in faults]
    return replace(report, violations=(*report.violations, *found))


def _held(task: StepTask, hard: bool) -> StepTask:
    """The same step with its limits and targets as constraints, or as soft edges."""
    return replace(task, settings=replace(task.settings, hard=hard))


def _nearest_foothold(task: StepTask, begin: Beginning) -> tuple[float, float] | None:
    """The nearest foothold around the refused one, of `SEARCH_SHIFTS`, for which a gait passes the check, or None."""
    if task.step.end_frame is not None:
        return None
    x, _ = task.step.landing(task.model)
    spent = 0
    for place in np.ravel([(x - shift, x + shift) for shift in SEARCH_SHIFTS]).tolist():
        foothold = (round(place, 6), float(task.step.ground.height_at(place)))
        moved = replace(task, step=replace(task.step, foothold=foothold))
        faults = impossible(moved, begin)
        if any(violation.kind.startswith("obstacle") and "foothold" not in violation.kind for violation in faults):
            return None  # an obstacle under a standing foot, or higher than the legs: no other foothold helps
        if faults or math.hypot(*foothold) > 2.0 * task.model.reach:
            continue
        if spent > MOST_SEARCHED:
            return None
        with suppress(GraphError):
            # Soft edges find out in a fraction of the time where constraints have no chance.
            for each in [_held(moved, False), moved] if task.settings.hard else [moved]:
                solution = _attempt(each, begin, each.settings.gains)
                spent += solution.iterations
                if not solution.ok:
                    break
            else:
                return foothold
    return None
