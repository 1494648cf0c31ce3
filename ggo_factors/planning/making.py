"""The steps of a plan made and checked, and others chosen where one is refused or costs far more than was expected."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ggo_factors.errors import InfeasibleGaitError
from ggo_factors.planning.footholds import GRID
from ggo_factors.planning.people import Height, boxes_in, height_over
from ggo_factors.planning.reach import FAR_SINKS
from ggo_factors.planning.scene import Footholds
from ggo_factors.planning.search import Search
from ggo_factors.planning.whynot import Ban, no_way
from ggo_factors.procedures.task import StepSolution
from ggo_factors.procedures.walker import Walker, Way
from ggo_factors.walking.on_terrain import step_on
from ggo_factors.walking.step import MOST_LIFT, Step, verify_step
from ggo_factors.walking.walk import Walk

MOST_STUCK = 3
"""After so many first steps that were refused for the frame that they begin in there is no plan."""
MOST_REFUSED = 60
"""After so many refused steps there is no plan."""
STEP_WORK = 2600.0
"""So much may be spent on a step of a plan, half of what is spent on one that was asked for: there are others."""
EARLY, LATE = 0.05, 0.75
"""Shares of a step: what goes wrong before the first has to do with how the step before ended, after the second with
where this one lands, and not with where it began."""
DEAR, MUCH = 1.3, 0.1
"""A step that costs so many times what was expected, and more than it by this share of the whole plan, is a reason to
look once more for another plan."""
LESS = 0.95
"""Another plan is made where it is expected to cost so much of this one."""
HEIGHTS = 3
"""So many times a step over boxes is made, until its foot passes as high as people's."""
NEAR = 0.005
"""Nearer to that than this in [m] it is well enough."""
SLOPES = 0.3, 1.5
"""A foot that is drawn 1 m higher passes not less and not more than so many metres higher."""
FINER = 2.0
"""Where there is no way, candidates so many times as close and longer steps are looked at before a plan is refused."""


Progress = Callable[[float], None]


def costs_of(solutions: Sequence[StepSolution]) -> tuple[float, ...]:
    """What each step costs in its graph in [rad^2]."""
    return tuple(float(solution.error_history[-1]) for solution in solutions)


@dataclass(frozen=True, eq=False)
class Found:
    """What a search came to.

    Attributes:
        footholds: the footholds, and what was expected of their steps.
        solutions: the steps made.
        banned: steps that were refused on the way there.
    """

    footholds: Footholds
    solutions: tuple[StepSolution, ...]
    banned: tuple[Ban, ...]

    @property
    def cost(self) -> float:
        """What all steps cost in [rad^2]."""
        return math.fsum(costs_of(self.solutions))


def planned(
    search: Search,
    finish: Callable[[Sequence[StepSolution]], Walk],
    progress: Progress | None = None,
    most_refused: int = MOST_REFUSED,
    work: float = STEP_WORK,
) -> tuple[Found, Walk]:
    """The cheapest footholds whose steps can be made, and the walk that they finish.

    Args:
        search: a search for them.
        finish: what makes the walk of the steps.
        progress: as for `plan_walk`.
        most_refused: after so many refused steps there is no plan.
        work: so much may be spent on a step.

    Raises:
        InfeasibleGaitError: where there is no way, with the place where it ends.
    """
    walker, search = search.walker, _trying(search, work)
    banned: list[Ban] = []
    stuck = 0
    ways: dict[tuple[float, ...], Way] = {}
    while True:
        footholds = search.best()
        if footholds is None and search.grid == GRID:
            search = replace(search, grid=GRID / FINER, around=search.around / FINER, sinks=FAR_SINKS)
            footholds = search.best()
        if footholds is None or len(banned) >= most_refused:
            raise no_way(search, banned)
        places = feet_of(search, footholds)
        try:
            solutions = _made(search, places, ways, progress)
            found = Found(footholds, solutions, tuple(banned)), finish(solutions)
            return _cheaper(search, found, ways, finish)
        except InfeasibleGaitError as error:
            # Steps are numbered from 1, and each has two feet before it.
            number = 1 if error.step is None else error.step
            if not 1 <= number <= len(places) - 2:
                raise  # a step that is walked or in the air, which no other foothold mends
            stands_in = [fault for fault in error.violations if fault.frame == 0] if number == 1 else []
            stuck += bool(stands_in)
            if stuck == MOST_STUCK:
                what = "; ".join(map(str, stands_in))
                message = f"no foothold mends how the walker stands now, over x = {places[1]:.3f} m: {what}"
                raise InfeasibleGaitError(message, tuple(stands_in)) from error
            behind, stands, lands = places[number - 1 : number + 2]
            banned.append(Ban(behind, stands, lands, str(error)))
            search.banned.append(_cause(error, walker, places[max(number - 2, 0) : number + 2]))


def _trying(search: Search, work: float) -> Search:
    """The search with nothing banned, its steps made with so much work and given up where they are refused."""
    settings = replace(search.walker.settings, work=work, nearest=False)
    return replace(search, walker=replace(search.walker, settings=settings), banned=[])


def along(
    search: Search, footholds: Footholds, finish: Callable[[Sequence[StepSolution]], Walk]
) -> tuple[Found, Walk] | None:
    """The walk over given footholds, as `planned` has it; None where a step of it is refused."""
    if not all(map(math.isfinite, footholds.costs)):
        return None
    search = _trying(search, search.walker.settings.work)
    try:
        solutions = _made(search, feet_of(search, footholds), {}, None)
        return Found(footholds, solutions, ()), finish(solutions)
    except InfeasibleGaitError:
        return None


def _cheaper(
    search: Search,
    found: tuple[Found, Walk],
    ways: dict[tuple[float, ...], Way],
    finish: Callable[[Sequence[StepSolution]], Walk],
) -> tuple[Found, Walk]:
    """The plan, or another one that costs less, looked for once where a step cost far more than was expected."""
    if search.keep:
        return found  # footholds of a plan before stay: noise in what is seen makes a step dear for once
    first, _ = found
    costs = costs_of(first.solutions)
    total, steps = first.cost, len(first.footholds.places) - 2  # a closing step lands where it must
    pairs = zip(costs[:steps], first.footholds.costs, strict=False)
    if not any(cost > DEAR * expected > 0.0 and cost - expected > MUCH * total for cost, expected in pairs):
        return found
    footholds = search.best((first.footholds, costs[:steps]))
    if footholds is None or math.fsum(footholds.costs) > LESS * total:
        return found
    try:
        solutions = _made(search, feet_of(search, footholds), ways, None)
        other = Found(footholds, solutions, first.banned)
        if other.cost < total:
            return other, finish(solutions)
    except InfeasibleGaitError:
        pass  # the plan that was found stays
    return found


def _cause(error: InfeasibleGaitError, walker: Walker, places: tuple[float, ...]) -> tuple[float, float, float]:
    """What to ban of a step that was refused: three places in [m], the first NaN where it is of no account.

    Args:
        error: the refusal.
        walker: the walker at the start.
        places: where the step before began to swing, where this one does, where it stands, where it was to land, in
            [m]; without the first of them for the first step.
    """
    *_, behind, stands, lands = places
    if lands == stands:
        return behind, stands, lands  # a closing step lands where it must, wherever it comes from
    frames = [fault.frame for fault in error.violations if fault.frame is not None]
    motions = len(walker.base) - 1
    if frames and min(frames) > LATE * motions:
        return math.nan, stands, lands
    if frames and max(frames) <= EARLY * motions and len(places) > 3:
        return math.nan, behind, stands  # as it moves now: the step before must not end so
    return behind, stands, lands


def _made(
    search: Search, places: tuple[float, ...], ways: dict[tuple[float, ...], Way], progress: Progress | None
) -> tuple[StepSolution, ...]:
    """The steps over some places in [m], those that were made before taken from `ways`.

    Raises:
        InfeasibleGaitError: where a step is refused.
    """
    way, last = Way(search.walker), len(places) - 1
    for n in range(2, len(places)):
        known = ways.get(places[: n + 1])
        if known is None:
            known = _then(search, way, places[n - 2 : n + 1], n == last, n - 1, last + 1 - n)
            ways[places[: n + 1]] = known
            if progress is not None:
                progress((places[n] - places[1]) / max(search.goal - places[1], 1e-9))
        way = known
    return way.solutions


def feet_of(search: Search, footholds: Footholds) -> tuple[float, ...]:
    """X of both feet at the start and of each landing in [m], the closing step's too."""
    return (*footholds.places, footholds.places[-1]) if search.to_standing else footholds.places


def _then(search: Search, way: Way, places: Sequence[float], last: bool, number: int, left: int) -> Way:
    """The way with one more step, over boxes as high as people lift their feet where that is preferred and can be had.

    Raises:
        InfeasibleGaitError: where no gait is found.
    """
    behind, stands, lands = places
    step = step_on(search.terrain, search.walker.model, behind, stands, lands, last and search.to_standing)
    height = None if search.preference is None else height_over(step, behind - stands)
    high = None if height is None else _high(way, step, number, left, height)
    return way.then(step, number, left) if high is None else high


def _over(way: Way, step: Step) -> float:
    """Least height of the foot over the boxes that people lift it over in the last step of a way, in [m]."""
    return verify_step(way.solutions[-1].gait, replace(step, obstacles=boxes_in(step)), way.walker.model).clearance


def _high(way: Way, step: Step, number: int, left: int, height: Height) -> Way | None:
    """The way with a step that passes over boxes most nearly as high as it should; None where each try is refused.

    Soft edges draw a foot not quite as far as they are told to: the secant through what was tried tells what to try
    next. Where the first is refused it is tried half as high.
    """
    best, off, lift = None, math.inf, height.lift
    before: tuple[float, float] | None = None
    for attempt in range(HEIGHTS):
        try:
            made = way.then(replace(step, lift=lift), number, left)
        except InfeasibleGaitError:
            if attempt:
                break
            lift *= 0.5
            continue
        over = _over(made, step)
        if abs(over - height.wanted) < off:
            best, off = made, abs(over - height.wanted)
        if off <= NEAR or not math.isfinite(over):
            return made
        slope = 1.0 if before is None else (over - before[1]) / (lift - before[0])
        before = lift, over
        lift += (height.wanted - over) / min(max(slope, SLOPES[0]), SLOPES[1])
        if not 0.0 < lift <= MOST_LIFT:
            break
    return best
