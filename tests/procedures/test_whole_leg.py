"""Thigh, shank and sole over random obstacles: clear by another's geometry, or refused where no motion gets over."""

import math
from dataclasses import replace

import numpy as np
import pytest
from free_space import way_exists
from independent import densely, leg_clearance, path_of

import ggo_factors as ggo

ANKLE, HEEL, TOE = FOOT = (0.08, 0.05, 0.15)
RADII = (0.05, 0.05)
LEGS = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(*FOOT), thigh_radius=RADII[0], shank_radius=RADII[1])
BASE = replace(ggo.paper_base_gait(), model=LEGS)
QUICK = ggo.JointLimits(knee_speed=math.radians(600.0))
"""Without limits the step bends its knee faster than `JointLimits` by default."""
START_X, LANDING_X = path_of(BASE.frames)[[0, -1], 0]
DRAWS = 20
"""How many boxes are drawn in the suite; the campaign draws 300. Of those 101 overlap no standing foot and 91 are
returned; 9 of the others reach into the supporting shank at the start, one is behind a heel that moves towards it."""


def random_obstacles(draws, seed):
    """Boxes anywhere along the step, those that overlap no standing foot."""
    rng = np.random.default_rng(seed)
    for _ in range(draws):
        start, width, height = rng.uniform(-0.5, 0.35), rng.uniform(0.01, 0.08), rng.uniform(0.03, 0.2)
        if not any(start - TOE <= at <= start + width + HEEL for at in (START_X, 0.0, LANDING_X)):
            yield (start, start + width, height)


def assert_clear(solution, box):
    frames = solution.gait.frames
    assert min(leg_clearance(frames, [box], foot=FOOT, radii=RADII)) > 0.0, box
    assert np.hypot(*(path_of(frames)[-1] - [LANDING_X, 0.0])) < 1e-3, box
    np.testing.assert_array_equal(frames[0], BASE.frames[0])


def way(box):
    # As a step goes on from the walker's present motion, the first two frames are what they are.
    return way_exists(LEGS, densely(BASE.frames[:2], 50), ggo.Obstacle(*box), (LANDING_X, 0.0))


@pytest.mark.parametrize("draws", [DRAWS, pytest.param(300, marks=pytest.mark.campaign)])
def test_random_obstacles_are_cleared_by_the_whole_leg_or_truly_refused(draws):
    returned, refused = 0, []
    for box in random_obstacles(draws, seed=2026):
        try:
            solution = ggo.step_over(BASE, [ggo.Obstacle(*box)])
        except ggo.InfeasibleGaitError:
            refused.append(box)
            continue
        assert_clear(solution, box)
        returned += 1
    assert returned >= 0.9 * (returned + len(refused))
    assert [box for box in refused if way(box)] == []


@pytest.mark.parametrize(
    "box",
    [
        (0.319, 0.3396, 0.112),  # a millimetre behind the heel of the landing foot: it comes down upright
        (0.293, 0.334, 0.154),
        (0.183, 0.273, 0.18),
        (-0.4799, -0.4491, 0.078),  # behind the heel at the start
    ],
)
def test_what_leaves_little_room_is_passed(box):
    assert_clear(ggo.step_over(BASE, [ggo.Obstacle(*box)]), box)


@pytest.mark.parametrize(
    ("box", "found"),
    [
        ((0.319, 0.3396, 0.112), True),
        ((0.319, 0.346, 0.112), False),  # under the heel
        ((-0.20, -0.15, 0.15), True),
        ((0.20, 0.22, 0.70), False),  # as high as the hip
        ((-0.11, -0.06, 0.19), False),  # in the supporting shank
        ((-0.479, -0.4425, 0.036), False),  # where the heel is about to be
    ],
)
def test_the_search_finds_what_ways_there_are(box, found):
    assert way(box) == found


@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
@pytest.mark.parametrize("hard", [False, True])
def test_stairs_with_the_whole_leg(procedure, hard):
    walk = procedure(BASE, 0.15, hard=hard)
    for gait, step in zip(walk.gaits, walk.plan, strict=True):
        boxes = [(box.x_start, box.x_end, box.height) for box in step.obstacles]
        clear = leg_clearance(gait.frames, boxes, step.ground.edges, step.ground.heights, foot=FOOT, radii=RADII)
        assert min(clear) > 0.0


@pytest.mark.parametrize(("frames", "hard"), [(51, False), (401, False), (51, True)])
def test_other_rates_constraints_and_replans(frames, hard):
    base = replace(ggo.paper_base_gait(frames), model=LEGS)
    box, nearer = (0.20, 0.25, 0.12), (0.19, 0.24, 0.13)
    solution = ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(LANDING_X, 0.0), hard=hard)
    assert_clear(solution, box)
    again = ggo.replan(solution, frames // 5, obstacles=[ggo.Obstacle(*nearer)], limits=QUICK)
    assert_clear(again, nearer)
    np.testing.assert_array_equal(again.gait.frames[: frames // 5], solution.gait.frames[: frames // 5])
