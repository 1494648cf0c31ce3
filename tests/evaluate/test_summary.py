"""The line of a step that was not solved, and of one that there is no safe gait for."""

from __future__ import annotations

import pytest

import ggo_factors as ggo
from ggo_factors.evaluate.summary import refusal, summarize

BASE = ggo.paper_base_gait()


def test_a_solve_that_was_stopped_is_not_ok():
    graph = ggo.GaitGraph(BASE)
    graph.anchor(BASE.frames[0])
    graph.add_obstacle(ggo.Obstacle(0.2, 0.25, 0.08))
    graph.end(foothold=(0.39, 0.0))
    solution = graph.solve(max_iterations=1)
    row = summarize("step 1", solution.gait, ggo.verify(solution.gait), solution=solution)
    assert not row.ok
    assert row.verdict.startswith(solution.reason)
    assert row.iterations == solution.iterations
    assert row.change_deg is None


def test_a_refusal_tells_why():
    with pytest.raises(ggo.InfeasibleGaitError) as caught:
        ggo.step_over(BASE, [ggo.Obstacle(0.2, 0.25, 0.9)], foothold=(0.39, 0.0))
    row = refusal("wall", caught.value, milliseconds=2.0)
    assert not row.ok
    assert row.to_json()["verdict"] == f"refused: {caught.value}"
    assert (row.milliseconds, row.clearance_mm) == (2.0, None)
