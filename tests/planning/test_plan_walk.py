"""`plan_walk`: its arguments, its refusals, and walks as asked for, judged in world coordinates."""

import math
import re

import numpy as np
import pytest
from courses import Course, random_course
from planned import boxes_met, plan_on
from world_check import faults_of

import ggo_factors as ggo
from ggo_factors.planning.people import (
    LEADING_MEAN,
    LEADING_STD,
    TRAILING_MEAN,
    TRAILING_STD,
    PeoplePreference,
    height_over,
)
from ggo_factors.planning.search import Search
from ggo_factors.planning.whynot import Ban, no_way
from ggo_factors.procedures.steps import walker_of
from ggo_factors.walking.on_terrain import steps_on

BASE = ggo.paper_base_gait()
FEET = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.04, 0.10))
T, BOX, GAP = ggo.Terrain, ggo.Obstacle, ggo.Gap
LEVEL = T.level(3.0)
WITH_BOX = LEVEL.with_boxes(BOX(0.8, 0.9, 0.12))
UP = T.level(0.8) + T.stairs(2, riser=0.1, tread=0.3) + T.level(1.2)
RAMPS = T.level(0.8) + T.ramp(0.8, math.radians(10.0)) + T.ramp(0.6, math.radians(-12.0)) + T.level(0.8)


def course_of(terrain, goal):
    """The terrain as plain numbers."""
    pieces = tuple((each.x_start, each.x_end, each.height, each.slope) for each in terrain.surfaces)
    boxes = tuple((box.x_start, box.x_end, box.height) for box in terrain.boxes)
    return Course(terrain.name, pieces, boxes, tuple((pit.x_start, pit.x_end) for pit in terrain.pits), goal)


def checked(plan, **asked):
    """A plan without a fault in world coordinates."""
    course = course_of(plan.terrain, plan.goal)
    assert faults_of(course, plan.walk, footholds=plan.footholds, **asked) == []
    assert plan.footholds[-1] == pytest.approx(plan.goal)
    assert len(plan.costs) == len(plan.expected) == len(plan.footholds) == len(plan.walk.gaits)
    assert plan.cost == pytest.approx(sum(plan.costs))
    return plan


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"goal": math.nan}, "goal: nan m is not finite"),
        ({"goal": -math.inf}, "goal: -inf m is not finite"),
        ({"goal": "2"}, "goal: expected a number, got '2'"),
        ({"goal": [2.0]}, "goal: expected a number"),
        ({"goal": True}, "goal: expected a number, got True"),
        ({"goal": 10**400}, "goal: expected a number"),
        ({"goal": 0.0}, "goal: 0 m must be at least 0.05 m"),
        ({"goal": -1.0}, "goal: -1 m must be at least 0.05 m"),
        ({"goal": 0.02}, "goal: 0.02 m must be at least 0.05 m"),
        ({"goal": 0.02, "to_standing": True}, "goal: 0.02 m must be at least 0.05 m"),
        ({"at": 2.0}, "goal: 2 m must be at least 2.05 m"),
        ({"goal": 3.1}, "goal: 3.1 m must be at most 3 m"),
        ({"goal": 2.995}, r"goal: no foot can stand at x = 2.995 m \(the terrain ends at 3 m\); .* x = 2.990 m"),
        ({"at": math.nan}, "at: nan m is not finite"),
        ({"at": -1001.0}, "at: -1001 m must be at least -1000 m"),
        ({"to_standing": 1}, "to_standing: expected True or False, got 1"),
        ({"prefer": "style"}, "prefer: 'style' is neither 'least_change' nor 'people'"),
        ({"prefer": None}, "prefer: None is neither"),
        ({"terrain": None}, "terrain: expected a Terrain, got None"),
        ({"terrain": "level"}, "terrain: expected a Terrain, got 'level'"),
        ({"base": None}, "base: expected a Gait, got None"),
        ({"model": 0.39}, "model: expected a LegModel"),
        ({"start": [0.0] * 3}, r"start: expected shape \(4,\)"),
        ({"start": [10.0, 0.0, 0.0, 0.0]}, "start: .* looks like degrees"),
        ({"start_rate": [100.0, 0, 0, 0]}, "start_rate: 100 rad/s is above"),
        ({"hard": None}, "hard: expected True or False"),
        ({"limits": 1.0}, "limits: expected a JointLimits"),
        ({"pace": 0.0}, "pace: 0 must be above 0"),
        ({"pace": "fast"}, "pace: 'fast' is neither"),
        ({"balance": -1.0}, "balance: -1 must be at least 0"),
        ({"style": "mine"}, "style: expected a Style"),
        ({"first_swing": "both"}, "first_swing: 'both' is neither"),
    ],
)
def test_a_bad_argument_is_named_in_one_line(asked, told):
    given = {"base": BASE, "terrain": LEVEL, "goal": 2.0} | asked
    with pytest.raises(ggo.InputError, match=told) as error:
        ggo.plan_walk(given.pop("base"), given.pop("terrain"), **given)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("terrain", "told"),
    [
        (LEVEL.with_pits(GAP(-0.1, 0.1)), r"at: no foot can stand at x = 0.000 m \(gap from -0.1 to 0.1 m\)"),
        (LEVEL.with_boxes(BOX(-0.05, 0.05, 0.1)), r"at: no foot can stand .* x = -0.060 m"),
        (T((ggo.Surface(-1.0, 0.005), ggo.Surface(0.005, 3.0, 0.1))), r"at: .*riser of 0.1 m at 0.005 m"),
        (LEVEL.with_pits(GAP(1.9, 2.1)), r"goal: no foot can stand .*; the nearest place is x = 2.110 m"),
        (LEVEL.with_boxes(BOX(1.98, 2.5, 0.0)), r"goal: .*; the nearest place is x = 1.970 m"),
        (LEVEL.with_pits(GAP(-1e300, -0.2)), r"start: swinging foot's start in a gap \(gap from -1e\+300 to -0.2 m\)"),
        (LEVEL.with_boxes(BOX(-0.45, -0.35, 0.1)), "start: obstacle in the swinging foot's start"),
        (T.ramp(3.0, math.radians(15.0)), "start: the swinging foot is 0.114 m above the ground at x = -0.391 m"),
        (T.ramp(3.0, math.radians(-15.0)), "start: the swinging foot is 0.095 m under the ground"),
        (T((ggo.Surface(-1.0, -0.2), ggo.Surface(-0.2, 3.0, 0.15))), "start: the swinging foot is 0.160 m above"),
    ],
)
def test_nobody_can_stand_at_the_start_or_the_goal(terrain, told):
    with pytest.raises(ggo.InputError, match=told):
        ggo.plan_walk(BASE, terrain, goal=2.0)


@pytest.mark.parametrize(
    ("terrain", "low", "high", "told"),
    [
        (LEVEL.with_pits(GAP(0.5, 1.5)), 0.49, 1.51, "gap from 0.5 to 1.5 m; the longest step here is 1.00 m"),
        (LEVEL.with_boxes(BOX(0.5, 1.5, 0.02)), 0.49, 1.51, "box from 0.5 to 1.5 m, 0.02 m high"),
        (LEVEL.with_boxes(BOX(0.9, 1.0, 2.0)), 0.89, 1.01, "box from 0.9 to 1 m, 2 m high"),
        (LEVEL.with_boxes(BOX(0.9, 1.0, 1e300)), 0.89, 1.01, "box from 0.9 to 1 m"),
        (T.level(1.0) + T.level(2.0, rise=-2.0), 0.99, 1.01, "riser of -2 m at 1 m"),
        (T.level(1.0) + T.level(2.0, rise=2.0), 0.99, 1.01, "riser of 2 m at 1 m"),
    ],
)
def test_a_refusal_names_the_place_and_what_is_there(terrain, low, high, told):
    with pytest.raises(ggo.InfeasibleGaitError) as error:
        ggo.plan_walk(BASE, terrain, goal=2.0)
    message = str(error.value)
    assert told in message
    named = re.match(r"no foothold between x = (\d+\.\d+) and (\d+\.\d+) m: ", message)
    assert [float(place) for place in named.groups()] == pytest.approx([low, high])


@pytest.mark.parametrize("clutter", ["boxes", "pits", "surfaces"])
def test_a_refusal_names_few_of_many_things(clutter):
    spans = [(n * 0.005, n * 0.005 + 0.003) for n in range(-100, 500)]
    terrain = {
        "boxes": LEVEL.with_boxes(*(BOX(*span, 0.05) for span in spans)),
        "pits": LEVEL.with_pits(*(GAP(*span) for span in spans)),
        "surfaces": T(tuple(ggo.Surface(n * 0.01, n * 0.01 + 0.01, 0.01 * (n % 2)) for n in range(-100, 300))),
    }[clutter]
    with pytest.raises(ggo.InputError, match=r"at: .* and \d+ more\)") as error:
        ggo.plan_walk(BASE, terrain, goal=2.0)
    assert len(str(error.value)) < 300


@pytest.mark.parametrize("terrain", [LEVEL, WITH_BOX, UP, RAMPS], ids=["level", "box", "up", "ramps"])
def test_from_and_to_standing(terrain):
    plan = checked(
        ggo.plan_walk(BASE, terrain, goal=2.4, start=ggo.STANDING, to_standing=True),
        start=ggo.STANDING,
        end=ggo.STANDING,
    )
    assert plan.footholds[-1] == plan.footholds[-2] == 2.4
    assert plan.to_standing
    # What is expected of the closing step is its own, and of the one before it no more than that.
    assert plan.costs[-1] / 3.0 < plan.expected[-1] < 3.0 * plan.costs[-1]
    assert plan.costs[-2] / 3.0 < plan.expected[-2] < 3.0 * plan.costs[-2]


@pytest.mark.parametrize(
    "asked",
    [
        {"hard": True},
        {"limits": ggo.JointLimits()},
        {"pace": 0.5},
        {"pace": "auto"},
        {"balance": 0.5},
        {"model": FEET},
        {"prefer": "people"},
        {"first_swing": "left"},
    ],
    ids=str,
)
def test_a_walk_as_it_was_asked_for(asked):
    plan = checked(ggo.plan_walk(BASE, WITH_BOX, goal=2.0, **asked))
    assert all(report.ok for report in plan.walk.verify())
    walk = plan.walk
    assert walk.first_swing == asked.get("first_swing", "right")
    assert walk.limits == asked.get("limits")
    if asked.get("pace") == 0.5:
        plain = ggo.plan_walk(BASE, WITH_BOX, goal=2.0).walk
        times = [sum(float(gait.times[-1]) for gait in each.gaits) for each in (walk, plain)]
        assert times[0] > 1.8 * times[1]


def test_a_plan_begins_elsewhere_as_it_does_at_0():
    moved = T((ggo.Surface(-1.0, 5.0),)).with_boxes(BOX(1.8, 1.9, 0.12))
    here, there = ggo.plan_walk(BASE, WITH_BOX, goal=2.0), ggo.plan_walk(BASE, moved, goal=3.0, at=1.0)
    assert there.at == 1.0
    # The cost is flat, and the ground is sampled every 5 mm from where it begins.
    assert [x - 1.0 for x in there.footholds] == pytest.approx(here.footholds, abs=0.06)
    assert there.cost == pytest.approx(here.cost, rel=0.02)


def test_base_gaits_of_each_leg():
    turned = ggo.Gait(BASE.frames + np.radians([0.0, 0.1, 0.0, -0.1]), BASE.dt, model=BASE.model, name="other")
    bases = ggo.BaseGaits(right=BASE, left=turned)
    plan = checked(ggo.plan_walk(bases, WITH_BOX, goal=2.0, first_swing="left"))
    names = [solution.task.base.name for solution in plan.walk.steps]
    assert names == [turned.name, BASE.name] * (len(names) // 2) + [turned.name] * (len(names) % 2)


def test_walks_can_be_made_again_from_the_footholds_of_a_plan():
    plan = ggo.plan_walk(BASE, WITH_BOX, goal=2.0)
    asked = steps_on(WITH_BOX, plan.footholds, model=plan.walk.model, start=BASE.frames[0])
    for mine, theirs in zip(ggo.walk(BASE, asked).gaits, plan.walk.gaits, strict=True):
        np.testing.assert_allclose(mine.frames, theirs.frames, atol=1e-9)


def test_progress_goes_from_step_to_step_to_the_goal():
    told = list[float]()
    plan = ggo.plan_walk(BASE, WITH_BOX, goal=2.0, progress=told.append)
    assert told == pytest.approx([x / 2.0 for x in plan.footholds])


def test_a_plan_is_shown_in_a_line():
    plan = ggo.plan_walk(BASE, LEVEL, goal=0.39)
    assert re.fullmatch(r"Plan\(1 step from 0\.000 to 0\.390 m, cost \d\S*\)", repr(plan))
    assert plan.banned == ()


@pytest.mark.parametrize(
    "terrain",
    [
        LEVEL.with_boxes(*[BOX(0.8, 0.9, 0.1)] * 3, BOX(0.7, 0.85, 0.05), BOX(0.85, 0.86, 0.15)),
        LEVEL.with_boxes(BOX(0.8, 0.8 + 1e-12, 0.1)).with_pits(GAP(0.5, 0.5 + 1e-12)),
        LEVEL.with_pits(GAP(0.8, 1.0)).with_boxes(BOX(0.85, 0.95, 0.05)),
        T((ggo.Surface(1.0, 3.0),)),
        T((ggo.Surface(-100.0, 3.0),)),
        T(tuple(ggo.Surface(n * 0.02, n * 0.02 + 0.02, 0.01 * (max(n, 0) // 40)) for n in range(-50, 150))),
        T.level(0.8) + T.level(0.02, rise=0.1) + T.level(0.018, rise=0.1) + T.level(3.0),
        LEVEL.with_boxes(BOX(-1e300, -0.6, 0.1), BOX(2.05, 50.0, 0.4)),
        LEVEL.with_boxes(BOX(0.5, 0.6, 0.0)),
    ],
    ids=["overlapping", "thin", "box in a pit", "ahead", "behind", "many", "narrow", "beyond", "flat"],
)
def test_odd_terrains_are_walked(terrain):
    checked(ggo.plan_walk(BASE, terrain, goal=2.0))


def test_margins_grow_with_what_is_not_known():
    for std in (0.0, 0.01, 0.02):
        terrain = LEVEL.with_boxes(BOX(0.8, 0.9, 0.05, std, std)).with_pits(GAP(1.4, 1.5, std))
        plan = checked(ggo.plan_walk(BASE, terrain, goal=2.2))
        for begins, ends in ((0.8, 0.9), (1.4, 1.5)):
            assert min(max(begins - x, x - ends) for x in plan.footholds) >= 0.01 + 3.3 * std - 1e-6


def test_what_people_prefer():
    terrain = LEVEL.with_boxes(BOX(1.0, 1.1, 0.1), BOX(2.0, 2.1, 0.01))
    prefers = PeoplePreference.on(terrain)
    assert prefers.boxes.tolist() == [[1.0, 1.1]]
    behind = np.array([0.3, 0.3, 0.9, 1.5])
    stands, lands = np.array([0.65, 0.9, 1.3, 1.9]), np.array([0.65 + 0.35 / 0.585, 1.25, 1.7, 2.3])
    costs = prefers(behind, stands, lands)
    assert costs[0] == pytest.approx(0.0, abs=1e-9)
    assert costs[1] > 0.0
    assert costs[2:].tolist() == [0.0, 0.0]


def test_people_lift_their_feet_higher():
    plans = [ggo.plan_walk(BASE, WITH_BOX, goal=2.0, prefer=prefer) for prefer in ("least_change", "people")]
    ((_, low),), ((share, high),) = (boxes_met(course_of(WITH_BOX, 2.0), checked(plan).walk) for plan in plans)
    assert low < 0.06
    assert high == pytest.approx(LEADING_MEAN, abs=LEADING_STD)
    assert 0.50 <= share <= 0.65
    assert plans[1].cost > plans[0].cost


@pytest.mark.parametrize(("near", "height"), [(0.9, 0.05), (1.0, 0.10), (1.1, 0.15), (1.2, 0.20)])
def test_a_box_alone_is_stepped_over_as_people_do(near, height):
    terrain = LEVEL.with_boxes(BOX(near, near + 0.06, height))
    plan = checked(ggo.plan_walk(BASE, terrain, goal=2.4, prefer="people"))
    ((share, high),) = boxes_met(course_of(terrain, 2.4), plan.walk)
    assert 0.50 <= share <= 0.65
    assert abs(high - LEADING_MEAN) <= LEADING_STD


def test_how_high_people_lift_their_feet():
    ahead, beside = BOX(0.2, 0.3, 0.1), BOX(-0.2, -0.1, 0.1)
    leading = height_over(ggo.Step((0.5, 0.0), (ahead,)), -0.4)
    trailing = height_over(ggo.Step((0.5, 0.0), (beside,)), -0.4)
    assert abs(leading.wanted - LEADING_MEAN) <= LEADING_STD < abs(trailing.wanted - LEADING_MEAN)
    assert abs(trailing.wanted - TRAILING_MEAN) <= TRAILING_STD
    assert leading.lift >= leading.wanted
    assert height_over(ggo.Step((0.5, 0.0), (beside, ahead)), -0.4) == leading


@pytest.mark.parametrize(
    "box", [BOX(0.2, 0.3, 0.01), BOX(-0.6, -0.5, 0.1), BOX(0.6, 0.7, 0.1)], ids=["low", "behind", "beyond"]
)
def test_no_foot_is_lifted_where_it_passes_nothing(box):
    assert height_over(ggo.Step((0.5, 0.0), (box,)), -0.4) is None


def test_people_step_on_a_kerb_as_low_however_uncertain_its_edge_is():
    kerb = T.level(0.9) + T.level(1.6, rise=0.06, edge_std=0.01)
    little, people = (
        checked(ggo.plan_walk(BASE, kerb, goal=2.0, prefer=prefer)) for prefer in ("least_change", "people")
    )
    assert people.footholds == little.footholds
    assert people.costs == little.costs


def test_people_lift_their_feet_over_a_box_and_not_over_the_kerb_beside_it():
    ground = (T.level(0.7) + T.level(2.0, rise=0.06, edge_std=0.01)).with_boxes(BOX(1.15, 1.22, 0.1))
    plan = checked(ggo.plan_walk(BASE, ground, goal=2.2, prefer="people"))
    ((_, high),) = boxes_met(course_of(ground, 2.2), plan.walk)
    assert abs(high - LEADING_MEAN) <= LEADING_STD
    assert min(step.report.clearance for step in plan.walk.steps) < 0.08


@pytest.mark.parametrize(("seed", "box"), [(10, 0), (27, 1)])
def test_a_foot_that_passes_too_low_is_drawn_higher_until_it_passes_as_people_do(seed, box):
    course = random_course(seed)
    clearance = boxes_met(course, plan_on(course, prefer="people").walk)[box][1]
    assert abs(clearance - LEADING_MEAN) <= LEADING_STD


def test_a_step_down_may_be_longer_than_one_on_level_ground():
    """The longest level step is 1.06 m: over this pit and down there is no shorter one."""
    pit, away = GAP(1.5, 2.55), 0.1
    level = T.level(4.0).with_pits(pit)
    down = (T.level(1.5) + T.level(2.5, rise=-away)).with_pits(pit)
    with pytest.raises(ggo.InfeasibleGaitError, match=r"the longest step here is 1\.06 m"):
        ggo.plan_walk(BASE, level, goal=3.5)
    assert max(np.diff(checked(ggo.plan_walk(BASE, down, goal=3.5)).footholds)) > 1.069


def test_a_pit_that_long_steps_alone_cross_is_crossed_with_a_run_up():
    """1.02 m from a hip that a step of 0.8 m made low; with 0.4 m before it such a step does not pass the check."""
    footholds = [0.0, *checked(ggo.plan_walk(BASE, T.level(4.0).with_pits(GAP(1.5, 2.5)), goal=3.5)).footholds]
    across = int(np.argmax(np.diff(footholds)))
    assert np.diff(footholds)[across] == pytest.approx(1.02, abs=0.005)
    assert np.diff(footholds)[across - 1] > 0.6
    with pytest.raises(ggo.InfeasibleGaitError, match=r"the longest step here is 0\.96 m"):
        ggo.plan_walk(BASE, T.level(4.0).with_pits(GAP(0.4, 1.4)), goal=3.5)


def test_the_last_step_may_go_as_high_as_a_foot_can_be_put():
    """From a block of 0.45 m nobody goes on whose hip is so low, and the message does not speak of how far that is."""
    block = T.level(0.8) + T.level(1.5, rise=0.45)
    assert checked(ggo.plan_walk(BASE, block, goal=1.0)).footholds[-1] == 1.0
    for asked in ({"goal": 1.0, "to_standing": True}, {"goal": 2.0}):
        with pytest.raises(ggo.InfeasibleGaitError) as error:
            ggo.plan_walk(BASE, block, **asked)
        assert "between x = 0.79 and 0.81 m: riser of 0.45 m at 0.8 m; no step goes on there" in str(error.value)


@pytest.mark.parametrize("degrees", [-15.0, -12.0, -5.0, 5.0, 10.0, 15.0])
@pytest.mark.parametrize("goal", [0.62, 0.9])
def test_walkers_come_to_stand_on_ramps(degrees, goal):
    """Down a ramp the foot that closes comes from above: the step before it is short, and those refused are banned."""
    terrain = T((ggo.Surface(-1.0, 0.5), ggo.Surface(0.5, 2.5, 0.0, math.radians(degrees))))
    plan = checked(ggo.plan_walk(BASE, terrain, goal=goal, to_standing=True))
    assert plan.footholds[-2:] == (goal, goal)
    assert len(plan.banned) <= 6
    assert len({(ban.behind, ban.stands, ban.lands) for ban in plan.banned}) == len(plan.banned)


def test_steps_are_shorter_where_edges_are_uncertain():
    far = T.level(4.0).with_pits(GAP(1.5, 2.5))
    assert max(np.diff(checked(ggo.plan_walk(BASE, far, goal=3.5)).footholds)) > 1.0
    unsure = T.level(4.0).with_pits(ggo.Gap(1.5, 2.45, 0.01))
    with pytest.raises(ggo.InfeasibleGaitError, match=r"the longest step here is 1\.02 m"):
        ggo.plan_walk(BASE, unsure, goal=3.5)


def no_way_from(terrain, bans=(), banned=(), **asked):
    """What is said of a search that ended with these refused steps; `banned` of them are known to it."""
    walker = walker_of(BASE, None, None, None, None, None, False, None, None)
    search = Search(terrain, walker, (float(walker.model.endpoint(walker.frame)[0]), 0.0), banned=list(banned), **asked)
    return str(no_way(search, [Ban(*places, "why") for places in bans]))


def test_a_refusal_says_that_nobody_comes_to_stand():
    places = [(0.025 * n, 1.0, 1.0) for n in range(40)]
    message = no_way_from(LEVEL, places[-1:], places, goal=1.0, to_standing=True)
    assert message == (
        "no way to stand at x = 1.00 m: every step tried there was refused; "
        "the last of 1 refused: from 0.975 over 1.000 to 1.000 m: why"
    )


def test_a_refusal_names_what_the_foot_behind_cannot_be_taken_over():
    box = LEVEL.with_boxes(BOX(0.5, 0.55, 0.4))
    message = no_way_from(box, [(0.2, 0.95, 1.7), (0.1, 0.3, 0.6)], goal=1.9, to_standing=False)
    assert message.startswith("no way between x = 0.95 and 1.70 m: every step tried there was refused: box from 0.5 to")
