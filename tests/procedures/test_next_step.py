"""`step_over` says whether the other foot gets over the same boxes in the step after."""

import numpy as np
import pytest
from independent import path_of

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.2, 0.25, 0.1)


@pytest.mark.parametrize("box", [BOX, ggo.Obstacle(0.1, 0.15, 0.2), ggo.Obstacle(0.36, 0.385, 0.1)])
def test_the_other_foot_goes_over_the_same_box(box):
    made = ggo.step_over(BASE, [box])
    after = made.next_step
    assert after is not None
    assert not made.report.notes
    np.testing.assert_allclose(after.gait.frames[0], made.gait.frames[-1][[2, 3, 0, 1]], atol=1e-9)
    (same,) = after.task.step.obstacles
    x, y = path_of(made.gait.frames)[-1]
    assert (same.x_start + x, same.x_end + x) == pytest.approx((box.x_start, box.x_end), abs=1e-9)
    path = path_of(after.gait.frames)
    over = (path[:, 0] > same.x_start) & (path[:, 0] < same.x_end)
    assert over.any()
    assert path[over, 1].min() > same.height
    assert path[-1, 1] == pytest.approx(-y, abs=2e-3)
    assert ggo.verify(after.gait, made.task.model, obstacles=[same]).ok


@pytest.mark.parametrize("high", [0.25, 0.35])
def test_a_box_that_the_shank_of_the_other_foot_stands_against(high):
    made = ggo.step_over(BASE, [ggo.Obstacle(0.1, 0.15, high)])
    assert made.next_step is None
    (note,) = made.report.notes
    assert note.startswith("no next step over the same boxes to 0.391 m: step 2: ")
    assert "shank" in note


def test_the_next_foot_lands_beyond_a_pit():
    made = ggo.step_over(BASE, [BOX], gaps=[ggo.Gap(0.7, 0.85)])
    x = path_of(made.gait.frames)[-1, 0]
    lands = path_of(made.next_step.gait.frames)[-1, 0]
    assert 0.85 <= x + lands < 0.90


def test_without_boxes_none_is_looked_for():
    made = ggo.step_over(BASE, [], foothold=(0.4, 0.0))
    assert made.next_step is None
    assert not made.report.notes
