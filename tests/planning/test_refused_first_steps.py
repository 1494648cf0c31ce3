"""Refusals of the very first step, and of one that is in the air: others are chosen, or one true line."""

import contextlib

import pytest

import ggo_factors as ggo
from ggo_factors.planning.making import _cause
from ggo_factors.procedures.steps import walker_of

BASE = ggo.paper_base_gait()
WALKER = walker_of(BASE, None, None, None, None, None, False, None, None)


@pytest.mark.parametrize("frame", [1.0, 20.0, 49.0, None])
@pytest.mark.parametrize("count", [3, 4])
def test_a_refused_step_is_banned_whichever_it_is(frame, count):
    fault = ggo.Violation("knee", frame, -1.0, 0.0, "deg")
    places = (-0.4, 0.0, 0.4, 0.8)[4 - count :]
    banned = _cause(ggo.InfeasibleGaitError("refused", (fault,)), WALKER, places)
    assert len(banned) == 3
    assert banned[1:] in (places[-2:], places[-3:-1])


@pytest.fixture(scope="module")
def over_box():
    """Level ground, and a plan over a box on it."""
    ground = ggo.Terrain.level(3.0)
    boxes = ground.with_boxes(ggo.Obstacle(1.3, 1.4, 0.1))
    return ground, ggo.plan_walk(BASE, boxes, goal=2.4, start=ggo.STANDING)


@pytest.mark.parametrize(
    ("at_frame", "moved"),
    [
        *((at_frame, moved) for at_frame in (0, 10, 20, 30) for moved in (-0.08, -0.04, 0.04, 0.08)),
        (45, 0.08),  # five frames before touchdown a search takes a second
        *(pytest.param(45, moved, marks=pytest.mark.campaign) for moved in (-0.08, -0.04, 0.04)),
    ],
)
def test_a_box_that_moves_while_a_foot_is_in_the_air_is_walked_over_or_refused(over_box, at_frame, moved):
    ground, plan = over_box
    seen = ground.with_boxes(ggo.Obstacle(1.3 + moved, 1.4 + moved, 0.1))
    with contextlib.suppress(ggo.InfeasibleGaitError):  # a refusal is an answer; anything else is none
        again = ggo.replan_plan(plan, seen, step=3, at_frame=at_frame)
        assert all(report.ok for report in again.walk.verify())


def test_results_are_one_line_at_a_prompt():
    assert "\n" not in repr(ggo.joint_trajectory([BASE]))
    report = ggo.import_base_gait(ggo.datasets.children_walk(), joints=ggo.datasets.children_walk_joints())
    assert "\n" not in repr(report)
    assert len(repr(report)) < 200
