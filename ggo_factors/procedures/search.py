"""One step of a walk: solved in one way after the other until it passes the check, or refused.

A way is a set of edges; in each the gains of edges that broke their limit grow. Where joints have limits, the path
comes first and how fast they move on it second: most paths keep the limits anyway, and one that cannot be had without
them cannot be had with them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from ggo_factors.check.balance import with_balance
from ggo_factors.check.joint_rates import even_faults, rate_faults
from ggo_factors.check.report import STANDARD, Report
from ggo_factors.errors import GraphError, InfeasibleGaitError, Violation
from ggo_factors.graph.rounds import Budget, Solver, solve_in_rounds
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.played import Played
from ggo_factors.procedures.build import beginning_of, gait_of, impossible, problem_of
from ggo_factors.procedures.gains import RATE_KINDS, Gains, stiffer
from ggo_factors.procedures.task import MOST_MOTIONS, Beginning, Settings, StepSolution, StepTask
from ggo_factors.walking.step import verify_step

MOST_ATTEMPTS = 5
"""A step is solved at most so often in one way, each time with stiffer edges where a limit was broken."""
MOST_WITHIN_LIMITS = 3
"""With joint limits: three attempts; in 300 replans a fourth never helped."""
ON_FOOTHOLDS = 0.5
"""So large a share of a step's work is granted for the search for another foothold once it is refused."""
ON_THE_FIRST, ON_ANOTHER, ON_RATES = 0.6, 0.5, 0.35
"""The first way may not spend a larger share, and no other, so that all are tried; of the gaits that edges on rates
made nine in ten took less."""
PATIENCE = 5.0
"""A path that may be walked slower is looked for with so many times the work, and so is one that is only too fast:
hardly one of them is refused."""
USUAL_MOTIONS = 50
"""A step of so many frame-to-frame motions has the usual work."""
BODIES = 3.0
"""Legs that have a body take so many times the work."""
SAME = 0.01
"""A violation that stiffer edges change by a smaller share than this stays as it is."""
MOST_EXCEEDED, HARDLY_HELPED = 3.2, 2.2
"""Where a path's joints would be faster than their limits by more than the first of these no edge on rates ever helped,
by more than the second only with a smoother motion."""
SMOOTHER, FREER, FREEST = 3.0, 0.1, 0.001
"""By so much the smoothness is larger, and smaller, where nothing is found with the usual one."""
FOOTHOLD_AIM = 0.0005
"""Attempts go on until the foothold is met to this, in [m]: closer than the check asks for, since the landing errors
of two steps may add up."""
CLEARANCE_AIM = 0.003
"""Nor are they enough that pass lower than this over an obstacle in [m], anywhere, also between two frames: soft edges
leave less than the margin that they aim at."""
MOST_BETWEEN = 0.35
"""Largest share by which an upsampled spline swings beyond limits that its frames keep; where it is larger, the frames
break the limits too."""
AS_ASKED, NO_LANDING, CONSTRAINTS = "as asked", "without landing edges", "targets and limits as constraints"
NO_STYLE = "without style"
SMOOTH = "{:g} times the smoothness"
"""What the ways are called in notes and refusals."""
HOME = "the step after it brings the walker home"
"""What is said besides of a step without landing edges."""
NOT_BALANCED = "not balanced: start and foothold leave the ZMP {:.0f} mm from the base gait's on average"
"""Note on a step that was to be balanced and is made without balance edges, which would bend it much and not help."""
SEARCH_SHIFTS = (0.02, 0.04, 0.06, 0.09, 0.13, 0.18, 0.24, 0.31)
"""Distances in [m] before and beyond a refused foothold at which others are tried."""
TURNS = ("hip turns", "knee turns")
"""Kinds of violations of joints faster than any walker's, which a slower pace mends."""


def checked_step(task: StepTask) -> StepSolution:
    """The solution of a step, which passes the check.

    Raises:
        InfeasibleGaitError: with the step's name and number, the violations, what was tried, and the nearest foothold
            that works.
    """
    task.model.require_reach(*task.step.landing(task.model), name=f"{task.name}: ", step=task.number)
    begin, settings = beginning_of(task), task.settings
    faults = impossible(task, begin)
    too_fast = any(fault.kind in RATE_KINDS for fault in faults)
    budget = Budget(_work(task) * (PATIENCE if settings.slows else 1.0), settings.until)
    limits, path, beginning = settings.limits, task, begin
    if limits is not None:
        path = replace(task, settings=replace(settings, limits=limits.angles_only()))
        beginning = beginning_of(path)
        if settings.slows and not task.moves:
            faults = [fault for fault in faults if fault.kind not in RATE_KINDS]
    found = faults or _found(path, beginning, budget)
    if isinstance(found, StepSolution) and limits is not None:
        found = _within_rates(task, begin, found, budget, too_fast)
    if isinstance(found, StepSolution) and found.ok:
        return replace(found, gait=replace(found.gait, bent=found.bent_from()))
    raise _refused(task, begin, found, budget)


def _work(task: StepTask) -> float:
    """How much may be spent on a step: more on one of more frames, up to those that a step is solved as."""
    more = max(1.0, min(len(task.base) - 1, MOST_MOTIONS) / USUAL_MOTIONS)
    return task.settings.work * more * (BODIES if task.model.thigh_radius or task.model.shank_radius else 1.0)


def _found(task: StepTask, begin: Beginning, budget: Budget, excess: float | None = None) -> StepSolution | str:
    """A gait that passes the check; else the first one found that does not, or why there is none."""
    return (_balanced_or_not if task.settings.balance else _of_any_way)(task, begin, budget, excess)


def _of_any_way(task: StepTask, begin: Beginning, budget: Budget, excess: float | None) -> StepSolution | str:
    """As `_found`, by the ways that there are with these settings."""
    first: StepSolution | str = ""
    style, whole, patient = task.settings.style, budget.work, False
    ways = _ways(task, excess) if style is None or not style.helps else _ways_with_style(task, excess)
    for number, (settings, name) in enumerate(ways):
        budget.tried.append(name if excess is None else f"{name} at the base gait's pace")
        most = whole * (ON_RATES if excess is not None else ON_ANOTHER if number else ON_THE_FIRST)
        own = Budget(min(most, budget.work), budget.until)
        spent = own.work
        try:
            solution = _best_solution(replace(task, settings=settings), begin, own)
        except GraphError as error:
            first = first or str(error)
        else:
            if solution.ok:
                notes = solution.report.notes
                if style is not None and not style.helps:
                    notes = (*notes, f"made without style: {style.why_not}")
                if name != AS_ASKED:
                    notes = (*notes, f"found only {name}" + (f": {HOME}" if NO_LANDING in name else ""))
                return replace(solution, task=task, report=replace(solution.report, notes=notes))
            if not isinstance(first, StepSolution) or (solution.converged and not first.converged):
                first = replace(solution, task=task)
        if spent < math.inf:
            budget.work -= spent - own.work
        if excess is None and not patient and isinstance(first, StepSolution) and _only_turns(first):
            # There is a path, a little too fast at this pace: one that is not is near.
            patient, whole = True, PATIENCE * whole
            budget.work += whole
        if not budget.iterations(0):
            break
    return first


def _only_turns(solution: StepSolution) -> bool:
    """Whether nothing is wrong with a gait but that a joint turns faster than any walker's."""
    return solution.converged and all(fault.kind in TURNS for fault in solution.violations)


def _balanced_or_not(task: StepTask, begin: Beginning, budget: Budget, excess: float | None) -> StepSolution | str:
    """As `_found`, with balance edges, or without where they do not bring the ZMP within its tolerance."""
    balanced = _of_any_way(task, begin, budget, excess)
    if isinstance(balanced, StepSolution) and balanced.ok and not balanced.report.zmp_off > STANDARD.balance:
        return balanced
    settings = replace(task.settings, balance=0.0, gains=replace(task.settings.gains, hold=Gains.hold))
    plain = _of_any_way(replace(task, settings=settings), begin, replace(budget, work=settings.work), excess)
    if isinstance(balanced, StepSolution) and balanced.ok and not (isinstance(plain, StepSolution) and plain.ok):
        plain = balanced
    if not isinstance(plain, StepSolution) or not plain.ok:
        return balanced
    report = with_balance(plain.report, plain.gait, task.model, task.base)
    notes = (*report.notes, NOT_BALANCED.format(report.zmp_off * 1e3))
    return replace(plain, task=task, report=replace(report, notes=notes))


def _ways(task: StepTask, excess: float | None) -> Iterator[tuple[Settings, str]]:
    """How a step is tried, and what is noted where it is found so; what was asked for by name stays.

    A smoother motion has lower peaks, a freer one bends where it must, constraints meet what soft edges trade.

    Args:
        task: the step.
        excess: by how many times its joints are faster than their limits, where edges on rates are to mend that.
    """
    settings = task.settings
    free, freely = settings, list[str]()
    if settings.landing and not settings.landing_forced and task.step.end_frame is None:
        free, freely = replace(settings, landing=False), [NO_LANDING]
    ways = [(settings, AS_ASKED), (free, NO_LANDING)]
    if not settings.smoothness_given:
        smoother, both = _smooth(settings, [], SMOOTHER), _smooth(free, freely, SMOOTHER)
        ways = [*ways, smoother, _smooth(free, freely, FREER)] if excess is None else [ways[0], both, smoother, ways[1]]
    if not settings.hard and not settings.gain_given and excess is None:
        ways.append((replace(settings, hard=True), f"with {CONSTRAINTS}"))
        ways.append((replace(free, hard=True), " and ".join([*freely, f"with {CONSTRAINTS}"])))
    if not settings.smoothness_given and excess is None:
        ways.append(_smooth(free, freely, FREEST))
    if excess is not None and excess > HARDLY_HELPED:
        del ways[0]
    done = list[Settings]()
    for way, name in ways:
        if way not in done:
            done.append(way)
            yield way, name


def _smooth(settings: Settings, names: list[str], times: float) -> tuple[Settings, str]:
    """A way with so many times the smoothness, and what it is called besides `names`."""
    smooth = replace(settings, smoothness=times * settings.smoothness)
    return smooth, " and ".join([*names, f"with {SMOOTH.format(times)}"])


def _ways_with_style(task: StepTask, excess: float | None) -> Iterator[tuple[Settings, str]]:
    """As `_ways`, first with style as asked, then all without: it is for likeness, and bends no step more easily."""
    yield task.settings, AS_ASKED
    plain = replace(task, settings=replace(task.settings, style=None))
    for settings, name in _ways(plain, excess):
        yield settings, NO_STYLE if name == AS_ASKED else f"{name} and {NO_STYLE}"


def _within_rates(task: StepTask, begin: Beginning, path: StepSolution, budget: Budget, too_fast: bool) -> StepSolution:
    """A gait in which the joints keep their rates too: this one, one with edges on rates, or this one to be slowed.

    Where the walker is `too_fast` already, no edge helps.
    """
    if not path.ok:
        return path
    checked = replace(path, task=task, report=_checked(task, path.gait, path.report))
    if checked.ok:
        return checked
    excess = max(abs(fault.value / fault.limit) for fault in checked.violations)
    if excess <= MOST_EXCEEDED and not too_fast:
        now = time.perf_counter()
        own = replace(budget, work=min(budget.work, _work(task)), until=now + (budget.until - now) / task.left)
        kept = _found(task, begin, own, excess)
        if isinstance(kept, StepSolution) and kept.ok:
            return kept
    return replace(path, task=task) if task.settings.slows else checked


def _refused(
    task: StepTask, begin: Beginning, found: StepSolution | str | list[Violation], budget: Budget
) -> InfeasibleGaitError:
    """Why there is no gait for a step, with the nearest foothold that works."""
    violations, hint, nearest = tuple[Violation, ...](), "", None
    if isinstance(found, str):
        message = f"no gait found: {found}"
    elif isinstance(found, list):
        violations = tuple(found)
        message = "; ".join(map(str, violations))
    else:
        violations = found.violations
        faults = ([] if found.converged else [found.reason]) + [str(violation) for violation in violations]
        message = "no gait found that passes the check: " + "; ".join(faults)
        hint = _slower(task, found)
    if not hint and task.settings.nearest:
        budget.work = max(budget.work, ON_FOOTHOLDS * _work(task))
        nearest = _nearest_foothold(task, begin, budget, {fault.kind for fault in violations})
    if nearest is not None:
        hint = f"; nearest foothold that works: ({nearest[0]:.3f}, {nearest[1]:.3f}) m"
    tried = f"; tried {', '.join(budget.tried)}" if budget.tried else ""
    return InfeasibleGaitError(f"{task.name}: {message}{hint}{tried}", violations, nearest, task.number)


def _slower(task: StepTask, found: StepSolution) -> str:
    """At which pace a path can be walked on which nothing but the joints' rates is wrong."""
    fast = RATE_KINDS | set(TURNS)
    if not found.converged or any(fault.kind not in fast for fault in found.violations) or len(task.walked) > 1:
        return ""
    times = 1.0
    for fault in found.violations:
        ratio = abs(fault.value / fault.limit)
        times = max(times, math.sqrt(ratio) if fault.kind.endswith("acceleration") else ratio)
    return f"; works at {math.ceil(100.0 * times) / 100.0:.2f} times the time, or slowed where it must be: pace='auto'"


def _best_solution(task: StepTask, begin: Beginning, budget: Budget) -> StepSolution:
    """The step solved with the first gains, then with the edges stiffer that broke their limits.

    Raises:
        GraphError: where the first attempt cannot be solved.
    """
    gains, settings = task.settings.gains, task.settings
    solution = _attempt(task, begin, gains, budget)
    few = settings.limits is not None and not settings.played
    for attempt in range(1, MOST_WITHIN_LIMITS if few else MOST_ATTEMPTS):
        if not solution.converged and (settings.hard or attempt > 1):
            break  # contradicting constraints stay so, and a graph too stiff to converge gets no better when stiffer
        broken = set()
        for violation in solution.report.violations:
            broken.add(violation.kind)
        if solution.report.foothold_error > FOOTHOLD_AIM:
            broken.add("foothold")
        if solution.report.clearance < CLEARANCE_AIM and not settings.hard:
            broken.add("obstacle")
        if not broken:
            break
        next_gains = stiffer(gains, broken, settings.gain_given or settings.hard, _between(solution))
        if next_gains == gains:
            break
        gains, before = next_gains, solution
        try:
            solution = _attempt(task, begin, gains, budget, before)
        except GraphError:
            break  # too stiff to be solved: the last attempt is the answer
        if before.converged and before.ok and not solution.ok:
            return before  # it was to land still nearer
        if _stays(before, solution):
            break
    return solution


def _stays(before: StepSolution, after: StepSolution) -> bool:
    """Whether stiffer edges changed nothing about what is wrong."""
    if len(before.violations) != len(after.violations) or not after.violations:
        return False
    for one, other in zip(before.violations, after.violations, strict=True):
        if one.kind != other.kind or abs(one.value - other.value) > SAME * abs(one.value - one.limit):
            return False
    return True


def _between(solution: StepSolution) -> float:
    """The share by which an upsampled gait goes beyond limits of the joints' rates.

    It is 0 where every frame was solved for, or where the share is so large that those solved for break limits too.
    """
    if solution.frames_apart == 1.0 and not solution.task.settings.played:
        return 0.0
    rates = [fault for fault in solution.violations if fault.kind in RATE_KINDS]
    share = max((abs(fault.value / fault.limit) for fault in rates), default=1.0) - 1.0
    return share if share < MOST_BETWEEN else 0.0


def _attempt(
    task: StepTask, begin: Beginning, gains: Gains, budget: Budget, before: StepSolution | None = None
) -> StepSolution:
    """The step solved with these gains, from where the attempt before ended if there was one, and checked."""
    initial = None if before is None else before.graph.state.frames
    solved = solve_in_rounds(problem_of(task, begin, gains), initial, Solver(budget=budget))
    gait = gait_of(task, begin, solved.graph.state.frames)
    return StepSolution(
        gait=gait,
        graph=solved.graph,
        converged=solved.converged,
        reason=solved.reason,
        iterations=solved.iterations,
        error_history=solved.error_history,
        rounds=solved.rounds,
        report=_checked(task, gait, None),
        first_frame=begin.done,
        frames_apart=begin.every,
        whole=partial(gait_of, task, begin),
        task=task,
    )


def _checked(task: StepTask, gait: Gait, seen: Report | None) -> Report:
    """The dense check of the whole step, or what it saw; joint limits only from where the walker is now."""
    report = verify_step(gait, task.step, task.model, task.walked[0]) if seen is None else seen
    if task.settings.balance:
        report = with_balance(report, gait, task.model, task.base)
    limits = task.settings.limits
    if limits is None:
        return report
    kept = report.violations
    if task.settings.slows:
        kept = tuple(fault for fault in kept if fault.kind not in TURNS)
    done, into = len(task.walked) - 1, task.motion_into()
    frames = gait.frames[done:]
    if into is not None:
        frames = np.concatenate([frames[:1] - into, frames])
    first = done - (into is not None)
    faults = even_faults(frames, gait.dt, limits, STANDARD.limits)
    if task.settings.played and not faults:
        # How the joints bend in the present frame is not to be changed any more.
        now = 1 + (into is not None)
        ahead = Played(np.arange(len(frames), dtype=np.float64) * gait.dt, frames)
        faults = rate_faults(ahead, limits, STANDARD.limits, now)
        faults = [replace(fault, frame=(fault.frame or 0.0) + now) for fault in faults]
    found = [replace(fault, frame=None if fault.frame is None else fault.frame + first) for fault in faults]
    return replace(report, violations=(*kept, *found))


def _nearest_foothold(task: StepTask, begin: Beginning, budget: Budget, kinds: set[str]) -> tuple[float, float] | None:
    """The nearest foothold around the refused one, of `SEARCH_SHIFTS`, for which a gait passes the check, or None.

    `kinds` are those of what is wrong with the refused one.
    """
    if task.step.end_frame is not None:
        return None
    x, _ = task.step.landing(task.model)
    soft = replace(task, settings=replace(task.settings, hard=False))
    # Where the hip gives way for a longer step than the base gait's, one that is longer still is none.
    far = kinds & {"hip drop", "foothold"} and x > task.model.endpoint(task.base.frames[-1])[0]
    sides = (-1.0,) if far else (-1.0, 1.0)
    for place in [x + side * shift for shift in SEARCH_SHIFTS for side in sides]:
        foothold = (round(place, 6), float(task.step.ground.height_at(place)))
        moved = replace(soft, step=replace(task.step, foothold=foothold))
        faults = impossible(moved, begin)
        if any(violation.kind.startswith("obstacle") and "foothold" not in violation.kind for violation in faults):
            return None  # an obstacle under a standing foot, or higher than the legs: no other foothold helps
        if faults or math.hypot(*foothold) > 2.0 * task.model.reach:
            continue
        try:
            # Soft edges find out in a fraction of the time where constraints have no chance.
            found = _attempt(moved, begin, moved.settings.gains, budget).ok
            if found and task.settings.hard:
                held = replace(moved, settings=task.settings)
                found = _attempt(held, begin, held.settings.gains, budget).ok
        except GraphError:
            found = False
        if found:
            return foothold
        if not budget.iterations(0):
            return None
    return None
