"""The check in world coordinates, which judges plans: what is wrong with a walk or its course, it tells."""

import math

import numpy as np
import pytest
from courses import Course, random_course, shaken
from rival_footholds import Way, descent, exhaustive, greedy
from world_check import Legs, faults_of, faults_of_walk, joints_of, legs_of

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
FOOT = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.05, 0.12))
BOX = (0.20, 0.25, 0.08)


def flat(**changed):
    whole = {"pieces": ((0.0, 5.0, 0.0, 0.0),), "boxes": (BOX,), "pits": ()} | changed
    return Course("flat", goal=4.0, **whole)


def walk_of(course, footholds, model=None):
    return Way(course.terrain(), BASE, model).along(footholds)


@pytest.fixture(scope="module")
def over_box():
    return walk_of(flat(), [0.39, 0.78, 1.17])


@pytest.fixture(scope="module")
def with_feet():
    return walk_of(flat(), [0.39, 0.78, 1.17], FOOT)


def test_a_walk_of_the_library_has_no_fault():
    walk = ggo.walk(BASE, [ggo.Step((0.39, 0.0), (ggo.Obstacle(*BOX),)), ggo.Step((0.39, 0.0))])
    assert faults_of(flat(), walk, footholds=[0.39, 0.78], start=BASE.frames[0]) == []
    stairs = ((0.0, 0.29, 0.0, 0.0), (0.29, 0.68, -0.1, 0.0), (0.68, 3.0, -0.2, 0.0))
    walk = ggo.descend_stairs(BASE, 0.1, tread=0.39, first_edge=0.29, steps=2)
    assert faults_of(flat(pieces=stairs, boxes=()), walk) == []


def test_its_kinematics_are_the_library_s():
    frames = np.random.default_rng(0).uniform(-1.0, 1.0, (9, 4))
    model = ggo.LegModel(0.4, 0.37)
    ours = np.stack(joints_of(frames, legs_of(model)), -1)
    np.testing.assert_allclose(np.stack([ours.real, ours.imag], -1), model.joints(frames)[:, 1:], atol=1e-12)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"boxes": (BOX, (0.50, 0.52, 0.2))}, "swinging sole in box 2"),
        ({"boxes": (BOX, (0.70, 0.72, 0.4))}, "supporting shank in box 2"),
        ({"boxes": (BOX, (0.45, 0.47, 0.6))}, "swinging thigh in box 2"),
        ({"boxes": (BOX, (0.77, 0.79, 0.01))}, "in a box from 0.770 to 0.790"),
        ({"pits": ((0.70, 0.79),)}, "step 2, landing at x = 0.780: in a pit"),
        ({"pits": ((-0.10, 0.01),)}, "step 1, supporting foot at x = 0.000: in a pit"),
        ({"pieces": ((0.0, 0.6, 0.0, 0.0), (0.6, 5.0, 0.002, 0.0))}, "step 2, landing at x = 0.780: ankle -2."),
        ({"pieces": ((0.0, 0.45, 0.0, 0.0), (0.45, 0.6, 0.2, 0.0), (0.6, 5.0, 0.0, 0.0))}, "swinging sole in ground"),
        ({"pieces": ((0.0, 0.6, 0.0, 0.0), (0.6, 5.0, 0.0, -0.1))}, "off the ground"),
        ({"pieces": ((0.0, 1.0, 0.0, 0.0),)}, "step 3, landing at x = 1.170: beyond the end"),
    ],
)
def test_another_course_is_told(over_box, changed, told):
    assert any(told in fault for fault in faults_of_walk(flat(**changed), over_box.steps(), Legs()))


def test_the_trailing_foot_meets_the_box_too():
    high = (0.25, 0.28, 0.18)
    unaware = ggo.walk(BASE, [ggo.Step((0.39, 0.0), (ggo.Obstacle(*high),)), ggo.Step((0.39, 0.0))])
    told = faults_of(flat(boxes=(high,)), unaware)
    assert any(fault.startswith("step 2: swinging sole in box 1") for fault in told)
    assert not any(fault.startswith("step 1") for fault in told)
    aware = walk_of(flat(boxes=(high,)), [0.39, 0.78])
    assert faults_of_walk(flat(boxes=(high,)), aware.steps(), Legs()) == []


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"pits": ((0.899, 1.0),)}, "step 2, landing at x = 0.780: in a pit"),
        ({"pits": ((0.62, 0.731),)}, "step 2, landing at x = 0.780: in a pit"),
        ({"pieces": ((0.0, 0.899, 0.0, 0.0), (0.899, 5.0, -0.1, 0.0))}, "an edge at 0.899 under its sole"),
        ({"boxes": (BOX, (0.85, 0.87, 0.02))}, "in a box from 0.850 to 0.870"),
    ],
)
def test_soles_are_looked_at(with_feet, changed, told):
    assert faults_of_walk(flat(), with_feet.steps(), legs_of(FOOT)) == []
    assert any(told in fault for fault in faults_of_walk(flat(**changed), with_feet.steps(), legs_of(FOOT)))


def test_a_tilted_sole_stands_on_its_ramp():
    slope = math.radians(12.0)
    course = flat(pieces=((0.0, 0.30, 0.0, 0.0), (0.30, 2.0, 0.0, slope)), boxes=())
    for model in (None, FOOT):
        made = walk_of(course, [0.17, 0.50, 0.80], model)
        assert faults_of_walk(course, made.steps(), legs_of(model or BASE.model), footholds=[0.17, 0.50, 0.80]) == []
    level = faults_of_walk(flat(boxes=()), made.steps(), legs_of(FOOT))
    assert any("step 2, landing at x = 0.500: ankle +43" in fault for fault in level)


def changed_step(steps, number, change):
    changed = [(frames.copy(), times) for frames, times in steps]
    change(changed[number][0])
    return changed


@pytest.mark.parametrize(
    ("number", "change", "told"),
    [
        (1, lambda f: f.__iadd__(np.radians([0.5, 0, 0, 0])), "step 2: begins 0.5000 deg off"),
        (1, lambda f: f.__iadd__(np.radians([0.5, 0, 0, 0])), "step 2: the foot that stood moves by"),
        (1, lambda f: f[20:30, 3].__isub__(1.5), "step 2: knee from"),
        (1, lambda f: f[20:30, 2].__isub__(1.5), "step 2: hip from"),
        (1, lambda f: f[20:30, 1].__iadd__(2.2), "step 2: hip down to"),
        (1, lambda f: f[25:, 0].__iadd__(0.3), "step 2: a joint turns at"),
        (2, lambda f: f[:, 2].__iadd__(0.08 * np.arange(len(f))), "step 3: a joint's speed jumps by"),
        (2, lambda f: f[-1:, 2].__iadd__(0.01), "step 3: lands"),
    ],
)
def test_other_frames_are_told(over_box, number, change, told):
    frames = changed_step(over_box.steps(), number, change)
    faults = faults_of_walk(flat(), frames, Legs(), footholds=[0.39, 0.78, 1.17])
    assert any(told in fault for fault in faults), faults


def test_start_and_end_are_held_to_what_was_asked(over_box):
    faults = faults_of_walk(flat(), over_box.steps(), Legs(), start=ggo.STANDING, end=ggo.STANDING)
    assert faults == ["first frame: not the one asked for", "last frame: not the one asked for"]


def test_random_courses_are_as_they_are_said_to_be():
    courses = [random_course(seed) for seed in range(60)]
    for course in courses:
        ends = [piece[1] for piece in course.pieces[:-1]]
        assert ends == [piece[0] for piece in course.pieces[1:]]
        rises = [b[2] - a[2] - math.tan(a[3]) * (a[1] - a[0]) for a, b in zip(course.pieces, course.pieces[1:])]  # noqa: B905
        assert all(abs(rise) < 1e-9 or 0.05 <= abs(rise) <= 0.18 for rise in rises)
        assert all(0.03 <= box[2] <= 0.25 for box in course.boxes)
        assert all(0.08 <= pit[1] - pit[0] <= 0.38 for pit in course.pits)
        terrain = course.terrain()
        for x in np.random.default_rng(1).uniform(0.0, course.goal, 20).tolist():
            assert float(terrain.height_at(x)) == pytest.approx(course.height_at(x), abs=1e-12)
        assert terrain.tops == pytest.approx([course.top_of(box) for box in course.boxes])
    assert sum(any(piece[3] for piece in course.pieces) for course in courses) == 20
    one = shaken(courses[1], 0.01, 0)
    moved = np.subtract([piece[0] for piece in one.pieces], [piece[0] for piece in courses[1].pieces])
    assert moved[0] == 0.0
    assert 0.001 < moved[1:].std() < 0.03


def test_a_search_finds_what_greedy_choice_misses():
    # The own stride ends so near behind the box that the foot cannot leave from there.
    course = flat(boxes=((0.32, 0.39, 0.19),))
    way = Way(course.terrain(), BASE)
    feet, arrived = greedy(way, 1.2)
    assert not arrived
    assert feet.footholds() == [0.4, 0.8]
    found = exhaustive(way, 1.2).feet
    assert min(x for x in found.footholds() if x > 0.39) > 0.4
    assert faults_of_walk(course, found.steps(), Legs(), footholds=found.footholds()) == []
    better = descent(way, found.footholds())
    assert better.cost() < found.cost()
    assert better.footholds()[-1] == found.footholds()[-1]


def test_where_there_is_no_way_the_search_says_how_far_one_is():
    ends = exhaustive(Way(flat(boxes=(), pits=((0.15, 1.40),)).terrain(), BASE), 1.6)
    assert ends.feet is None
    assert ends.landed == 0.15
    assert ends.onward == 0.125


def test_no_sole_of_a_search_lies_over_an_edge():
    """The heel over a riser passes the library's step check; a plan has its soles wholly on the ground."""
    terrain = ggo.Terrain.level(0.4) + ggo.Terrain.level(1.0, rise=0.1)
    way = Way(terrain, BASE, ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.04, 0.10)))
    assert way.go(way.begin(), 0.42) is None
    assert way.tried == 0
    assert way.go(way.begin(), 0.45).at == 0.45
