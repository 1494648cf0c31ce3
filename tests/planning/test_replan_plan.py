"""A plan made again in mid-walk: what is walked stays, footholds stay where little speaks against them."""

from dataclasses import replace

import numpy as np
import pytest
from courses import Course
from world_check import faults_of

import ggo_factors as ggo
from ggo_factors.check.joint_rates import limit_faults
from ggo_factors.planning.replan_plan import SHIFTS, replan_plan
from ggo_factors.planning.search import SLIDES

BASE = ggo.paper_base_gait()
T, BOX, GAP = ggo.Terrain, ggo.Obstacle, ggo.Gap
LEVEL = T.level(3.0)
TERRAIN = LEVEL.with_boxes(BOX(1.2, 1.3, 0.1))
PLAN = ggo.plan_walk(BASE, TERRAIN, goal=2.0)
TO_STANDING = ggo.plan_walk(BASE, TERRAIN, goal=2.0, start=ggo.STANDING, to_standing=True)


def checked(again, plan, step, at_frame):
    """A plan made again: frames walked to the bit, no fault in world coordinates."""
    for mine, theirs in zip(again.walk.gaits[: step - 1], plan.walk.gaits, strict=False):
        np.testing.assert_array_equal(mine.frames, theirs.frames)
    mine, theirs = (each.walk.gaits[step - 1].frames[: at_frame + 1] for each in (again, plan))
    np.testing.assert_array_equal(mine, theirs)
    terrain = again.terrain
    pieces = tuple((each.x_start, each.x_end, each.height, each.slope) for each in terrain.surfaces)
    boxes = tuple((box.x_start, box.x_end, box.height) for box in terrain.boxes)
    course = Course("again", pieces, boxes, tuple((pit.x_start, pit.x_end) for pit in terrain.pits), again.goal)
    end = ggo.STANDING if plan.to_standing else None
    assert faults_of(course, again.walk, footholds=again.footholds, end=end) == []
    assert len(again.costs) == len(again.expected) == len(again.footholds) == len(again.walk.gaits)
    assert again.footholds[: step - 1] == plan.footholds[: step - 1]
    assert again.footholds[-1] == pytest.approx(plan.goal)
    return again


FAST = T.level(0.9) + T.level(0.5, rise=0.1, edge_std=0.01, height_std=0.01) + T.level(1.6, rise=-0.14)
HIGH = FAST.with_boxes(BOX(1.9, 2.0, 0.2, 0.01, 0.01))


@pytest.mark.parametrize("at_frame", [5, 20, 35])
def test_a_plan_that_is_faster_than_default_limits_goes_on_over_the_same_ground(at_frame):
    plan = ggo.plan_walk(BASE, HIGH, goal=2.6)
    fast = [n for n, gait in enumerate(plan.walk.gaits, start=1) if limit_faults(gait, ggo.JointLimits())]
    assert fast
    for step in fast:
        again = checked(replan_plan(plan, HIGH, step=step, at_frame=at_frame), plan, step, at_frame)
        np.testing.assert_allclose(again.footholds, plan.footholds, atol=SLIDES[0])
        assert again.walk.limits is None


@pytest.mark.parametrize("at_frame", [0, 20])
@pytest.mark.parametrize("error", [-0.02, 0.02])
@pytest.mark.parametrize("after", [1, 2, 3])
def test_where_feet_stand_the_ground_is_as_high_however_it_is_seen(after, error, at_frame):
    plan = ggo.plan_walk(BASE, FAST, goal=2.6)
    on = next(n for n, x in enumerate(plan.footholds, start=1) if 0.9 < x < 1.4)
    seen = T.level(0.9) + T.level(0.5, rise=0.1 + error) + T.level(1.6, rise=-0.14 - error)
    again = replan_plan(plan, seen, step=on + after, at_frame=at_frame)
    for x in (0.0, *plan.footholds)[on + after - 2 : on + after]:  # where both feet are as the step begins
        assert float(again.terrain.height_at(x)) == pytest.approx(float(FAST.height_at(x)))


def test_ramps_that_meet_without_a_riser_still_do_when_the_ground_is_moved_under_the_feet():
    ground = T.level(0.9) + T.ramp(0.9, 0.1) + T.level(1.5)
    plan = ggo.plan_walk(BASE, ground, goal=2.6)
    seen = T(tuple(replace(each, height=each.height + 0.01) for each in ground.surfaces))
    again = replan_plan(plan, seen, step=3)
    assert [rise for *_, rise in again.terrain.seams] == [0.0, 0.0]
    assert again.terrain.surfaces[0].height == pytest.approx(0.0)


@pytest.mark.parametrize("at_frame", [0, 20])
def test_ground_that_is_far_from_where_the_feet_stand_is_another_ground_and_refused_with_numbers(at_frame):
    plan = ggo.plan_walk(BASE, FAST, goal=2.6)
    on = next(n for n, x in enumerate(plan.footholds, start=1) if 0.9 < x < 1.4)
    seen = T.level(0.9) + T.level(2.1, rise=0.01)
    with pytest.raises(ggo.InfeasibleGaitError, match=r"ground .*at frame 0: -0\.0\d+ m"):
        replan_plan(plan, seen, step=on + 1, at_frame=at_frame)


def test_a_walker_in_a_box_as_it_stands_is_refused_at_once():
    plan = ggo.plan_walk(BASE, LEVEL, goal=2.0)
    at = plan.footholds[1]
    with pytest.raises(ggo.InfeasibleGaitError, match=rf"stands now, over x = {at:.3f} m: support shank in obstacle"):
        replan_plan(plan, LEVEL.with_boxes(BOX(at - 0.1, at - 0.04, 0.3)), step=3)


@pytest.mark.parametrize("sole", [False, True])
def test_a_foot_in_the_air_may_be_over_a_pit_or_high_over_a_ramp(sole):
    """Both were refused: the foot was taken to stand where it was."""
    terrain = T.level(0.2) + T.ramp(0.5, 0.1) + T.level(1.0) if sole else LEVEL.with_pits(GAP(0.15, 0.3))
    model = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08, 0.08, 0.16)) if sole else None
    plan = ggo.plan_walk(BASE, terrain, goal=1.5, model=model)
    for step in (1, 2):
        path = plan.walk.gaits[step - 1].endpoints(plan.walk.model)[:, 0] + plan.walk.origins()[step - 1, 0]
        over = [20, 40] if sole else np.flatnonzero((path[:46] > 0.16) & (path[:46] < 0.29))[:2]
        assert len(over) == 2
        for at_frame in over:
            checked(replan_plan(plan, terrain, step=step, at_frame=int(at_frame)), plan, step, int(at_frame))


@pytest.mark.parametrize("plan", [PLAN, TO_STANDING], ids=["walk", "standing"])
@pytest.mark.parametrize(("step", "at_frame"), [(1, 0), (1, 20), (2, 0), (2, 40), (4, 0), (5, 0), (5, 25)])
def test_the_same_ground_keeps_the_footholds(plan, step, at_frame):
    again = checked(replan_plan(plan, TERRAIN, step=step, at_frame=at_frame), plan, step, at_frame)
    # They may slide, with what lies before them fixed now.
    assert again.footholds == pytest.approx(plan.footholds, abs=SLIDES[0] + 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_a_centimetre_of_noise_does_not_make_footholds_jump(seed):
    near, far, height = np.array([1.2, 1.3, 0.1]) + np.random.default_rng(seed).normal(0.0, 0.01, 3)
    again = checked(replan_plan(PLAN, LEVEL.with_boxes(BOX(near, far, height)), step=1), PLAN, 1, 0)
    assert again.footholds == pytest.approx(PLAN.footholds, abs=0.05)


@pytest.mark.parametrize(("step", "at_frame"), [(1, 0), (1, 20), (2, 20)])
def test_a_box_that_has_moved_is_gone_round(step, at_frame):
    moved = LEVEL.with_boxes(BOX(1.5, 1.6, 0.12))
    again = checked(replan_plan(PLAN, moved, step=step, at_frame=at_frame), PLAN, step, at_frame)
    assert again.terrain is moved


@pytest.mark.parametrize("at_frame", [1, 20, 40])
def test_a_pit_where_the_foot_was_to_land(at_frame):
    lands = PLAN.footholds[1]
    pit = GAP(lands - 0.03, lands + 0.03)
    again = checked(replan_plan(PLAN, TERRAIN.with_pits(pit), step=2, at_frame=at_frame), PLAN, 2, at_frame)
    off = again.footholds[1] - lands
    assert abs(off) >= 0.04 - 1e-9
    assert min(abs(off - shift) for shift in SHIFTS) < 1e-9


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"step": 0}, "step: 0 must be at least 1"),
        ({"step": 6}, "step: 6 must be at most 5"),
        ({"step": 1.5}, "step: expected a whole number"),
        ({"at_frame": -1}, "at_frame: -1 must be at least 0"),
        ({"at_frame": 51}, "at_frame: 51 must be at most 50"),
        ({"at_frame": None}, "at_frame: expected a whole number"),
        ({"plan": None}, "plan: expected a Plan, got None"),
        ({"plan": PLAN.walk}, "plan: expected a Plan, got a Walk"),
        ({"terrain": None}, "terrain: expected a Terrain, got None"),
        ({"terrain": T.level(1.5)}, "terrain: ends at 1.5 m, the goal of the plan is at 2 m"),
    ],
)
def test_arguments_are_checked(asked, told):
    given = {"plan": PLAN, "terrain": TERRAIN, "step": 2} | asked
    with pytest.raises(ggo.InputError, match=told):
        replan_plan(given.pop("plan"), given.pop("terrain"), **given)


@pytest.mark.parametrize("terrain", [T.level(2.0), T.level(2.005), LEVEL.with_pits(GAP(1.9, 2.1))])
@pytest.mark.parametrize("plan", [PLAN, TO_STANDING], ids=["walk", "standing"])
@pytest.mark.parametrize(("step", "at_frame"), [(2, 0), (4, 20)])
def test_a_goal_where_nobody_can_stand_any_more(plan, terrain, step, at_frame):
    with pytest.raises(ggo.InfeasibleGaitError, match=r"no foot can stand at the goal any more, x = 2\.000 m \("):
        replan_plan(plan, terrain, step=step, at_frame=at_frame)


@pytest.mark.parametrize("plan", [PLAN, TO_STANDING], ids=["walk", "standing"])
def test_too_late(plan):
    for at_frame in (49, 50):
        with pytest.raises(ggo.InfeasibleGaitError, match=f"replan at frame {at_frame}: too late"):
            replan_plan(plan, TERRAIN, step=2, at_frame=at_frame)
    stands = plan.footholds[0]
    all_of_it = TERRAIN.with_pits(GAP(stands + 0.01, 1.9))
    with pytest.raises(ggo.InfeasibleGaitError, match="step 2: at frame 20 no foothold is left"):
        replan_plan(plan, all_of_it, step=2, at_frame=20)


@pytest.fixture(scope="module", params=[PLAN, TO_STANDING], ids=["walk", "standing"])
def known_and_read(request, tmp_path_factory):
    """A plan, and what is read from its file."""
    path = tmp_path_factory.mktemp("plans") / "plan.csv"
    request.param.save(path)
    return request.param, ggo.load_plan(path)


@pytest.mark.parametrize(("step", "at_frame"), [(1, 0), (2, 20), (5, 25)])
def test_a_plan_from_a_file_is_made_again_with_its_base_gait(known_and_read, step, at_frame):
    known, read = known_and_read
    again = checked(replan_plan(read, TERRAIN, step=step, at_frame=at_frame, base=BASE), read, step, at_frame)
    same = replan_plan(known, TERRAIN, step=step, at_frame=at_frame)
    assert again.footholds == pytest.approx(same.footholds, abs=1e-6)
    for mine, theirs in zip(again.walk.gaits, same.walk.gaits, strict=True):
        np.testing.assert_allclose(mine.frames, theirs.frames, atol=1e-6)


def test_a_base_gait_is_asked_for_where_the_plan_has_none_and_nowhere_else(known_and_read):
    known, read = known_and_read
    with pytest.raises(ggo.InputError, match="base: a walk from a file does not carry the base gait"):
        replan_plan(read, TERRAIN, step=2)
    with pytest.raises(ggo.InputError, match="base: expected a Gait"):
        replan_plan(read, TERRAIN, step=2, base="paper")
    with pytest.raises(ggo.InputError, match="base: this walk knows which base gait it was bent from"):
        replan_plan(known, TERRAIN, step=2, base=BASE)


def test_no_way_is_told_with_its_place():
    with pytest.raises(
        ggo.InfeasibleGaitError, match=r"no foothold between x = 0\.79 and 1\.91 m: gap from 0\.8 to 1\.9"
    ):
        replan_plan(PLAN, LEVEL.with_pits(GAP(0.8, 1.9)), step=1)
