"""A plan made again in mid-walk: the ground is seen differently now."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate

import numpy as np

from ggo_factors.check.joint_rates import widened
from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.motion.base_gaits import BaseGaits
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.footholds import GRID, blocked, may_stand
from ggo_factors.planning.making import MOST_REFUSED, STEP_WORK, Found, along, costs_of, feet_of, planned
from ggo_factors.planning.people import PeoplePreference
from ggo_factors.planning.plan import Plan
from ggo_factors.planning.reach import SHORTEST
from ggo_factors.planning.scene import Footholds
from ggo_factors.planning.search import Search
from ggo_factors.planning.whynot import what_is_at
from ggo_factors.procedures.replan import How, how_of, joined, rest_of_step, walker_in
from ggo_factors.procedures.task import StepSolution
from ggo_factors.procedures.walker import Walker
from ggo_factors.support.inputs import as_count, as_instance
from ggo_factors.walking.on_terrain import step_on
from ggo_factors.walking.walk import Walk

SHIFTS = (0.0, 0.025, -0.025, 0.05, -0.05, 0.1, -0.1, 0.15, -0.15, 0.2, -0.2)
"""Where a foot in the air may land instead of where it was to, in [m] from there, tried in this order."""
KEPT, KEPT_SHARE = 0.04, 0.5
"""What it costs to land elsewhere than in the plan before, or to leave a foothold out: the first of them in [rad^2],
two steps over a low box, or the second of what that plan costs, if that is more.

Noise of 1 cm in the ground changes what a plan costs by less, in proportion: with the first alone 29 of 50 plans over
high boxes kept their footholds, with both 48."""
SEEN_OFF = 0.05
"""Where a foot stands the ground may be seen so much higher or lower in [m]: an error of seeing, not another ground."""
SPARE = 0.1
"""Where a plan without limits goes beyond the default ones the foot in the air may do so by this share more."""
MOST_REFUSED_IN_THE_AIR, MOST_LANDINGS = 4, 4
"""After so many refused steps beyond a place where the foot in the air may land, it may not land there; and from so
many of those a way is looked for: a foot in the air does not wait."""


def replan_plan(
    plan: Plan, terrain: Terrain, *, step: int, at_frame: int = 0, base: Gait | BaseGaits | None = None
) -> Plan:
    """The rest of a plan made again for the ground as it is seen now, from the present step on.

    The frames that are walked stay, to the bit. The footholds of the plan before are kept where little speaks against
    them, so that noise in what is seen does not make them jump: to land elsewhere costs a little. In mid-step the
    foot in the air lands within joint limits: the plan's, or else the default ones, wider where the plan itself goes
    beyond them.

    Args:
        plan: the plan.
        terrain: the ground as it is seen now, in the same world frame.
        step: number of the step in which the walker is, from 1.
        at_frame: the last frame of it that is walked.
        base: of a plan that `load_plan` read: the base gait, or gaits, that its steps were bent from. The new steps
            have neither balance edges nor a style then: the file does not carry them.

    Raises:
        InputError: where an argument is unusable, or the base gait of a plan from a file is missing.
        InfeasibleGaitError: where it is too late, or there is no way, with the place where it ends.
    """
    walk = as_instance(plan, "plan", Plan).walk
    as_instance(terrain, "terrain", Terrain)
    number = as_count(step, "step", 1, len(walk.gaits)) - 1
    if plan.goal > terrain.x_end:
        raise InputError(f"terrain: ends at {terrain.x_end:g} m, the goal of the plan is at {plan.goal:g} m")
    if not may_stand(np.array([plan.goal]), blocked(terrain, walk.model.foot))[0]:
        what = what_is_at(terrain, plan.goal)
        raise InfeasibleGaitError(f"no foot can stand at the goal any more, x = {plan.goal:.3f} m ({what})")
    # Of a plan without limits the foot in the air is held to what the plan does where that is beyond the default.
    how = how_of(walk.limits or widened(JointLimits(), walk.gaits, SPARE), None, None)
    walker = walker_in(walk, number, base, how)
    # A plan without limits stays one; and it takes the time that it needs, a step that is walked goes on meanwhile.
    walker = replace(walker, settings=replace(walker.settings, limits=walk.limits, until=math.inf))
    feet = _feet_at(plan)[number : number + 3]
    terrain = _stood_on(terrain, plan.terrain, feet[:2])
    if at_frame == 0:
        return _from(plan, terrain, number, walker, feet[:2], how, ())
    return _in_mid_step(plan, terrain, number, at_frame, walker, feet, how)


def _stood_on(terrain: Terrain, before: Terrain, feet: tuple[float, ...]) -> Terrain:
    """A terrain as it is seen now, moved to be as high under both feet as `before`: feet know better than cameras.

    Args:
        terrain: the ground.
        before: the ground that the feet were put on.
        feet: x of the foot behind and of the one that stands in [m].
    """
    above, off = (float(before.height_at(x) - terrain.height_at(x)) for x in feet)
    if max(abs(above), abs(off)) > SEEN_OFF or not (above or off):
        return terrain
    # What meets without a riser still does.
    levels = [0, *accumulate(bool(rise) for _, _, rise in terrain.seams)]
    behind, stands = (levels[terrain.surface_at(x)] for x in feet)
    surfaces = (
        replace(surface, height=surface.height + (above if level == behind != stands else off))
        for level, surface in zip(levels, terrain.surfaces, strict=True)
    )
    return replace(terrain, surfaces=tuple(surfaces))


def _feet_at(plan: Plan) -> tuple[float, ...]:
    """X of both feet at the start and of each landing in [m]."""
    frame = plan.walk.gaits[0].frames[0]
    return (plan.at + float(plan.walk.model.endpoint(frame)[0]), plan.at, *plan.footholds)


def _search(plan: Plan, terrain: Terrain, walker: Walker, feet: tuple[float, ...]) -> Search:
    behind, stands = feet
    preference = PeoplePreference.if_preferred(plan.prefer, terrain)
    kept = max(KEPT, KEPT_SHARE * plan.cost)
    return Search(terrain, walker, (behind, stands), plan.goal, plan.to_standing, preference, plan.footholds, kept)


def _from(
    plan: Plan,
    terrain: Terrain,
    number: int,
    walker: Walker,
    feet: tuple[float, ...],
    how: How,
    now: tuple[StepSolution, ...],
    done: int = 0,
) -> Plan:
    """The plan made again from the start of a step, counted from 0, or from behind the present one, made as `now`.

    Raises:
        InfeasibleGaitError: where there is no way.
    """
    search = _search(plan, terrain, walker, feet)

    def finish(solutions: Sequence[StepSolution]) -> Walk:
        try:
            return joined(plan.walk, number, (*now, *solutions), walker, replace(how, limits=plan.walk.limits), done)
        except InfeasibleGaitError as error:
            # Numbered in the whole walk; the search counts the steps that it chose.
            step = number + 1 if error.step is None else error.step
            raise InfeasibleGaitError(str(error), error.violations, None, step - ahead) from error

    ahead = number + len(now)
    landed = plan.footholds[:number] + (feet[1:] if now else ())
    if not search.to_standing and abs(search.goal - feet[1]) < SHORTEST / 2.0:
        found, walk = Found(Footholds(search.feet, (), ()), (), ()), finish(())
    else:
        before = plan.footholds[ahead : len(plan.footholds) - plan.to_standing]
        found, walk = _as_before(search, finish, before, bool(now))
    footholds = (*landed, *feet_of(search, found.footholds)[2:]) if found.solutions else landed
    return replace(
        plan,
        terrain=terrain,
        footholds=footholds,
        costs=(*plan.costs[:number], *costs_of((*now, *found.solutions))),
        expected=(*plan.expected[:ahead], *found.footholds.costs),
        considered=found.footholds.considered,
        banned=(*plan.banned, *found.banned),
        walk=walk,
    )


def _as_before(
    search: Search, finish: Callable[[Sequence[StepSolution]], Walk], before: Sequence[float], in_the_air: bool
) -> tuple[Found, Walk]:
    """What `planned` finds; or the walk over the footholds of the plan `before`, x in [m], if that costs little more.

    What steps are expected to cost is not what they cost: an error there must not make the footholds jump.

    Raises:
        InfeasibleGaitError: where there is neither.
    """
    kept = (*search.free_near(before[:-1]), search.goal)

    def again() -> tuple[Found, Walk] | None:
        return along(search, search.over(kept), finish) if len(kept) == len(before) else None

    # Footholds of a plan before are as good as asked for, and worth the whole effort; a foot in the air does not wait.
    most = MOST_REFUSED_IN_THE_AIR if in_the_air else MOST_REFUSED
    try:
        found = planned(search, finish, None, most, STEP_WORK if in_the_air else search.walker.settings.work)
    except InfeasibleGaitError:
        walked = again()
        if walked is None:
            raise
        return walked
    places = found[0].footholds.places[2:]
    if len(places) == len(kept) and np.abs(np.subtract(places, kept)).max() <= GRID:
        return found
    walked = again()
    return found if walked is None or walked[0].cost > found[0].cost + search.kept else walked


def _in_mid_step(
    plan: Plan, terrain: Terrain, number: int, at_frame: int, walker: Walker, feet: tuple[float, ...], how: How
) -> Plan:
    """The plan made again while a foot is in the air: it lands where it was to if it may, else as near as it can.

    Raises:
        InfeasibleGaitError: where it is too late, or there is no way from where it may land.
    """
    behind, stands, lands = feet
    model, walk = walker.model, plan.walk
    closes = plan.to_standing and number == len(walk.gaits) - 1
    short: InfeasibleGaitError | None = None
    beyond: list[InfeasibleGaitError] = []
    stretches = blocked(terrain, model.foot)
    places = [lands] if closes else [lands + shift for shift in SHIFTS]
    good = may_stand(np.array(places), stretches)
    for place, free in zip(places, good.tolist(), strict=True):
        if not free or (not closes and not stands + SHORTEST <= place <= plan.goal + GRID / 100.0):
            continue
        step = step_on(terrain, model, behind, stands, place, closes)
        task = replace(walker.task(step, number + 1, len(walk.gaits) - number), settings=walker.settings)
        try:
            now = rest_of_step(task, walk.gaits[number], at_frame, {}, how)
        except InfeasibleGaitError as error:
            short = short or error
            continue
        try:
            if closes:
                made = joined(walk, number, (now,), walker, replace(how, limits=walk.limits), at_frame)
                costs = (*plan.costs[:number], *costs_of((now,)))
                return replace(plan, terrain=terrain, walk=made, costs=costs)
            after = walker.after(now.gait, step)
            return _from(plan, terrain, number, after, (stands, place), how, (now,), at_frame)
        except InfeasibleGaitError as error:
            beyond.append(error)
            if len(beyond) == MOST_LANDINGS:
                break
    where = f"step {number + 1}: at frame {at_frame} no foothold is left that the foot in the air can reach"
    # That there is no way on says more than that one foothold is out of reach.
    raise next(iter(beyond), short) or InfeasibleGaitError(where, (), None, number + 1)
