"""What a user sees at a prompt: one line for each object; and objects that compare without raising."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.procedures.task import StepSolution

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.2, 0.25, 0.08)
LONG = replace(BASE, name="a name that somebody made far too long to be read by anybody " * 5)


def graph(base: ggo.Gait = BASE) -> ggo.GaitGraph:
    made = ggo.GaitGraph(base)
    made.anchor(base.frames[0])
    made.add_obstacle(BOX)
    made.end((0.39, 0.0))
    return made


def test_a_gait_in_a_line():
    legs = "thigh 0.39 m, shank 0.39 m"
    assert repr(BASE) == f"Gait('paper base gait', 51 frames, 0.01 s apart, 0.5 s, {legs})"
    assert repr(ggo.Gait(np.zeros((2, 4)), 1.0 / 3.0)) == "Gait('', 2 frames, 0.3333 s apart, 0.3333 s, no leg lengths)"


def test_an_obstacle_in_a_line_that_makes_it_again():
    measured = replace(BOX, edge_std=0.01)
    assert repr(BOX) == "Obstacle(0.2, 0.25, 0.08)"
    assert repr(measured) == "Obstacle(0.2, 0.25, 0.08, edge_std=0.01, height_std=0.0)"
    for box in (BOX, measured):
        assert eval(repr(box), {"Obstacle": ggo.Obstacle}) == box


def test_a_graph_in_a_line():
    assert repr(graph()) == (
        "GaitGraph('paper base gait', 51 frames, 1 anchors, 1 obstacles, 1 ends, 0 factors of your own, "
        "thigh 0.39 m, shank 0.39 m)"
    )


def test_a_solution_in_a_line():
    solution = graph().solve()
    told = f"51 frames, {len(solution.keyframes)} keyframes, {solution.iterations} iterations, converged"
    assert len(solution.violations) == 1  # the paper's graph does not keep the foot off the ground
    assert repr(solution) == f"Solution('paper base gait', {told}, 1 limit broken)"
    assert repr(graph().solve(max_iterations=1)).endswith(" iterations, not converged, 1 limit broken)")


def test_a_step_and_a_walk_in_a_line():
    walk = ggo.adjust_stride(BASE, 0.8)
    assert repr(walk) == (
        "Walk('walk of 2 steps, generated from paper base gait', 102 frames, 0.01 s apart, 1 s, 0.8 m forward, "
        "thigh 0.39 m, shank 0.39 m)"
    )
    assert isinstance(walk.steps[0], StepSolution)
    line = repr(walk.steps[0])
    assert line.startswith("StepSolution('step to 0.400 m', 51 frames, ")
    assert line.endswith(" iterations, converged, checked)")
    bare = ggo.Walk((replace(BASE, model=None),), (ggo.Step((0.39, 0.0)),))
    assert repr(bare) == "Walk('walk of 1 step, paper base gait', 51 frames, 0.01 s apart, 0.5 s, no leg lengths)"


def test_a_long_name_still_makes_a_line():
    walk = ggo.Walk((LONG, LONG), (ggo.Step((0.39, 0.0)),) * 2)
    for thing in (LONG, graph(LONG), graph(LONG).solve(max_iterations=1), walk):
        line = repr(thing)
        assert len(line) < 200, line
        assert "\n" not in line


def dataclasses_of_the_package():
    for module in pkgutil.walk_packages(ggo.__path__, "ggo_factors."):
        if not module.name.endswith("__main__"):
            for made in vars(importlib.import_module(module.name)).values():
                if isinstance(made, type) and is_dataclass(made) and made.__module__ == module.name:
                    yield made


def test_frozen_classes_that_hold_arrays_are_compared_by_identity():
    classes = [made for made in dataclasses_of_the_package() if made.__dataclass_params__.frozen]
    assert {ggo.Gait, ggo.Walk, ggo.Solution, ggo.Obstacle} <= set(classes)
    for made in classes:
        held = [
            field.name
            for field in fields(made)
            # A field of functions on arrays holds none itself.
            if any(word in str(field.type) for word in ("Array", "Mask")) and "Callable" not in str(field.type)
        ]
        assert not held or not made.__dataclass_params__.eq, f"{made.__name__}: {held}"


@pytest.mark.parametrize(
    "make",
    [
        lambda: ggo.Gait(BASE.frames, BASE.dt),
        lambda: graph().solve(),
        lambda: ggo.adjust_stride(BASE),
        lambda: ggo.joint_trajectory([BASE]),
        lambda: ggo.Task("climb_stairs", {"start": np.array(BASE.frames[0])}),
    ],
)
def test_two_that_are_alike_compare_without_raising(make):
    one, other = make(), make()
    assert one == one
    assert one != other
    assert len({one, other}) == 2
