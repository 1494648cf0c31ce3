"""Campaign: walks planned over random courses, judged in world coordinates and by searches that know no plan.

The suite runs a seeded sample in tests/planning/test_sampled_courses.py.
"""

from __future__ import annotations

import re
from statistics import median
from time import process_time

import numpy as np
import pytest
from courses import blocked_course, random_course, shaken
from planned import BASE, apart, boxes_met, plan_on, replanned
from rival_footholds import GRID, Way, descent, exhaustive, greedy
from world_check import faults_of

import ggo_factors as ggo
from ggo_factors.planning.people import LEADING_MEAN, LEADING_STD

pytestmark = pytest.mark.campaign

FEET = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.04, 0.10))
NEAR = 1.2
"""The search of a refusal begins so far before the place that it names, in [m]."""
UNHURRIED = 600.0
"""So long the search may take for a course in [s] of CPU."""


def falls_short(reason):
    """A judged threshold that is not met yet: it stays as it is, and says by how much it was missed."""
    return pytest.mark.xfail(reason=reason, strict=False)


def judged(seeds, model=None, start=None, **asked):
    """Plans by seed, what is wrong with them, which were refused, and the time of each in [s] of CPU."""
    plans, faults, refused, spent = {}, {}, {}, []
    plan_on(random_course(0), model=model, **asked)  # imports take their time
    for seed in seeds:
        course, plan, began = random_course(seed), None, process_time()
        try:
            plans[seed] = plan = plan_on(course, model=model, start=start, **asked)
        except ggo.InfeasibleGaitError as error:
            refused[seed] = str(error)
        spent.append(process_time() - began)
        if plan is not None:
            end = ggo.STANDING if asked.get("to_standing") else None
            wrong = faults_of(course, plan.walk, start=start, end=end, footholds=plan.footholds)
            if abs(plan.footholds[-1] - course.goal) > 1e-3:
                wrong.append(f"ends at {plan.footholds[-1]:.3f}, not at the goal {course.goal:.3f}")
            faults |= {seed: wrong} if wrong else {}
    print(f"{len(plans)} walked, {len(refused)} refused: {refused}; unsafe: {faults}")
    print(f"CPU: median {median(spent) * 1e3:.0f} ms, 95 of 100 within {np.quantile(spent, 0.95) * 1e3:.0f} ms")
    return plans, faults, refused, spent


def untrue(refused, model=None, start=None, limits=None):
    """Which of the courses that were refused the unhurried search walks all the same."""
    found = []
    for seed in refused:
        course = random_course(seed)
        way = Way(course.terrain(), BASE, model, start, limits)
        ends = exhaustive(way, course.goal, UNHURRIED)
        print(f"course {seed}: {'walked' if ends.feet else 'no way'} by the search, as far as {ends.landed:.3f} m")
        found += [seed] if ends.feet is not None else []
    return found


def test_three_hundred_courses():
    plans, faults, refused, spent = judged(range(300))
    assert not faults
    false = untrue(refused)
    assert len(false) <= 0.01 * (len(plans) + len(false)), false
    for seed in range(7, 300, 30):
        course = random_course(seed)
        ends = exhaustive(Way(course.terrain(), BASE), course.goal, UNHURRIED)
        assert (ends.feet is None) == (seed not in plans), seed
    print(f"CPU of plan and walk: median {median(spent):.3f} s")
    assert median(spent) < 0.150
    assert np.quantile(spent, 0.95) < 0.400


def test_greedy_choice_beside():
    arrived, ratios = 0, []
    for seed in range(100):
        course = random_course(seed)
        feet, at_goal = greedy(Way(course.terrain(), BASE), course.goal)
        arrived += at_goal
        if at_goal:
            plan = plan_on(course)
            ratios.append(feet.cost() / plan.cost)
    print(f"greedy choice walks {arrived} of 100, at {median(ratios):.2f} times the cost")
    assert arrived < 90
    assert median(ratios) > 1.0


@falls_short("1.00 to 1.14, median 1.02; course 7 alone above 1.10, by a step that lands 2 cm behind the other foot")
def test_cost_beside_coordinate_search():
    ratios = {}
    for seed in range(20):
        course = random_course(seed)
        way, plan = Way(course.terrain(), BASE), plan_on(course)
        found = descent(way, plan.footholds)
        ratios[seed] = plan.cost / found.cost()
    print({seed: round(ratio, 3) for seed, ratio in ratios.items()}, f"median {median(ratios.values()):.3f}")
    assert max(ratios.values()) <= 1.10


WITHIN = pytest.param(
    ggo.JointLimits(),
    id="limits",
    marks=falls_short("58 of 60 walked, some after 10 to 50 s; the search walks 27 and 55, where hips pass limits"),
)


@pytest.mark.parametrize("limits", [pytest.param(None, id="free"), WITHIN])
def test_from_and_to_standing(limits):
    plans, faults, refused, _ = judged(range(60), start=ggo.STANDING, to_standing=True, limits=limits)
    assert not faults
    assert len(untrue(refused, start=ggo.STANDING, limits=limits)) <= 0.01 * len(plans)


def test_feet_with_soles():
    plans, faults, refused, _ = judged(range(60), model=FEET)
    assert not faults
    assert len(untrue(refused, model=FEET)) <= 0.01 * len(plans)


@pytest.mark.parametrize("seed", range(50))
def test_noise_does_not_make_footholds_jump(seed):
    course = random_course(seed)
    plan = plan_on(course, std=0.01)
    off = [apart(plan, replanned(plan, shaken(course, 0.01, number), 0.01)) for number in range(50)]
    print(f"{sum(each <= 0.05 for each in off)} of 50 within 5 cm; largest {np.sort(off)[-5:]}")
    assert sum(each <= 0.05 for each in off) >= 48


def test_people():
    shares, clearances = [], []
    for seed in range(100):
        course = random_course(seed)
        if course.boxes:
            people = plan_on(course, prefer="people")
            assert not faults_of(course, people.walk, footholds=people.footholds), seed
            for share, clearance in boxes_met(course, people.walk):
                shares.append(share)
                clearances.append(clearance)
    for name, values in (("share before", shares), ("leading clearance", clearances)):
        print(name, len(values), np.round(np.quantile(values, [0.05, 0.25, 0.5, 0.75, 0.95]), 3))
    assert np.mean([0.50 <= share <= 0.65 for share in shares]) > 0.8
    assert np.mean([abs(clearance - LEADING_MEAN) <= LEADING_STD for clearance in clearances]) > 0.8


@falls_short("a foot 0.15 m over a box of 0.15 m costs three times what one of 0.01 m over it does: 2 to 36 times")
def test_what_people_cost():
    ratios = {}
    for seed in range(40):
        course = random_course(seed)
        if course.boxes:
            ratios[seed] = plan_on(course, prefer="people").cost / plan_on(course).cost
    print({seed: round(ratio, 2) for seed, ratio in ratios.items()}, f"median {median(ratios.values()):.2f}")
    assert max(ratios.values()) <= 2.0


@pytest.mark.parametrize("seed", range(20))
def test_refusals_name_a_place_where_there_is_none(seed):
    course = blocked_course(seed)
    with pytest.raises(ggo.InfeasibleGaitError) as error:
        plan_on(course)
    low, high = map(float, re.search(r"between x = (-?[\d.]+) and (-?[\d.]+)", str(error.value)).groups())
    # The search begins where greedy choice comes to before the place, so that its time goes where it matters.
    way, near = Way(course.terrain(), BASE), max(low - NEAR, 0.1)
    begin, arrived = greedy(way, near)
    ends = exhaustive(way, course.goal, UNHURRIED, begin if arrived else None)
    assert ends.feet is None
    assert ends.onward <= high
    assert low <= ends.landed + 2.0 * GRID
