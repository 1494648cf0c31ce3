"""Walks planned over random courses, judged in world coordinates: a sample of tests/campaign/test_courses.py."""

import re

import pytest
from courses import blocked_course, random_course, shaken
from planned import BASE, apart, boxes_met, plan_on, replanned
from rival_footholds import Way, greedy
from world_check import faults_of

import ggo_factors as ggo

FEET = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.04, 0.10))


# All but the first were refused once, though the search finds a way.
@pytest.mark.parametrize("seed", [2, 6, 37, 120, 151, 239])
def test_random_courses_are_walked(seed):
    course = random_course(seed)
    plan = plan_on(course)
    assert plan.footholds[-1] == pytest.approx(course.goal, abs=1e-6)
    assert faults_of(course, plan.walk, footholds=plan.footholds, start=BASE.frames[0]) == []


@pytest.mark.parametrize("seed", [1, 3])
def test_from_and_to_standing(seed):
    course = random_course(seed)
    plan = plan_on(course, start=ggo.STANDING, to_standing=True)
    faults = faults_of(course, plan.walk, footholds=plan.footholds, start=ggo.STANDING, end=ggo.STANDING)
    assert faults == []
    assert plan.footholds[-2:] == pytest.approx([course.goal] * 2, abs=1e-6)


@pytest.mark.parametrize("seed", [4, 9])
def test_soles_stand_on_the_ground(seed):
    course = random_course(seed)
    plan = plan_on(course, model=FEET)
    assert faults_of(course, plan.walk, footholds=plan.footholds) == []


def test_greedy_choice_ends_where_a_plan_does_not():
    course = random_course(2)
    feet, arrived = greedy(Way(course.terrain(), BASE), course.goal)
    assert not arrived
    assert feet.at < plan_on(course).footholds[-1] - 1.0


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_a_refusal_names_the_place(seed):
    course = blocked_course(seed)
    with pytest.raises(ggo.InfeasibleGaitError) as error:
        plan_on(course)
    low, high = map(float, re.search(r"between x = (-?[\d.]+) and (-?[\d.]+)", str(error.value)).groups())
    barrier = {0: course.pits, 2: [(course.pieces[-1][0],) * 2], 3: [box[:2] for box in course.boxes]}[seed % 4][-1]
    assert low == pytest.approx(barrier[0], abs=0.05)
    assert high == pytest.approx(barrier[1], abs=0.05)


@pytest.mark.parametrize(("seed", "numbers"), [(7, (1, 8)), (44, (13,)), (45, (8,))])
def test_a_plan_made_again_for_the_ground_seen_anew_keeps_its_footholds(seed, numbers):
    course = random_course(seed)
    plan = plan_on(course, std=0.01)
    for number in numbers:
        seen = shaken(course, 0.01, number)
        again = replanned(plan, seen, 0.01)
        assert apart(plan, again) <= 0.05
        assert faults_of(seen, again.walk, footholds=again.footholds) == []


def test_people_step_over_a_box_in_the_middle_and_high():
    course = random_course(4)
    little, people = plan_on(course), plan_on(course, prefer="people")
    assert faults_of(course, people.walk, footholds=people.footholds) == []
    (share, clearance), (_, low) = boxes_met(course, people.walk)[0], boxes_met(course, little.walk)[0]
    assert 0.50 <= share <= 0.65
    assert clearance > low + 0.08
