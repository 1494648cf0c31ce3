"""Campaigns: hundreds of boxes, flights, walks and replans, judged by independent code (`make campaign`).

The suite runs a seeded sample of each elsewhere: tests/procedures, tests/check. These take minutes.
"""

from __future__ import annotations

import numpy as np
import pytest
from bare_bones import pointed
from independent import clearance, densely, least_knee_deg, path_of, way_over

import ggo_factors as ggo
from ggo_factors.motion.gait import swap_roles

pytestmark = pytest.mark.campaign

BASE = ggo.paper_base_gait()
STANDING = ggo.Step(end_frame=tuple(ggo.STANDING.tolist()))
LIMITS = ggo.JointLimits()


def boxes(count, seed):
    """Boxes that do not come within 0.03 m of the supporting foot."""
    rng = np.random.default_rng(seed)
    while count:
        start, width, height = rng.uniform(-0.30, 0.25), rng.uniform(0.02, 0.08), rng.uniform(0.02, 0.20)
        if start > 0.03 or start + width < -0.03:
            count -= 1
            yield start, start + width, height


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("frames", [51, 201])
def test_three_hundred_boxes(seed, frames):
    base, refused = pointed(ggo.paper_base_gait(frames)), []  # as `way_over` knows P alone; bones: test_bones.py
    for box in boxes(300, seed):
        try:
            gait = ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0)).gait.frames
        except ggo.InfeasibleGaitError:
            refused.append(box)
            continue
        assert clearance(gait, *box) > 0.0, box
        assert np.hypot(*(path_of(gait)[-1] - [0.39, 0.0])) < 1e-3, box
        assert least_knee_deg(gait) > -0.3, box
        assert path_of(densely(gait))[:, 1].min() > -1e-3, box
    assert len(refused) <= 3, refused
    assert not any(way_over(base.frames, box, (0.39, 0.0)) for box in refused)


@pytest.mark.parametrize("height", [0.03, 0.08, 0.12, 0.15])
def test_walks_come_home_from_any_box(height):
    free = ggo.walk(BASE, [ggo.Step((0.39, 0.0))] * 4)
    for x in np.linspace(0.06, 0.28, 23):
        box = ggo.Obstacle(float(x), float(x) + 0.05, height)
        walk = ggo.walk(BASE, [ggo.Step((0.39, 0.0), (box,)), *[ggo.Step((0.39, 0.0))] * 3])
        for mine, theirs in zip(walk.gaits[2:], free.gaits[2:], strict=True):
            assert np.degrees(np.abs(mine.frames - theirs.frames).mean(axis=0)).max() < 1.0, x


@pytest.mark.parametrize("limits", [None, LIMITS], ids=["free", "limits"])
def test_walks_from_and_to_standing(limits):
    rng, made = np.random.default_rng(7), 0
    for number in range(100):
        if number % 2:
            x, length = rng.uniform(0.1, 0.25), rng.uniform(0.3, 0.45)
            box = ggo.Obstacle(x, x + 0.05, rng.uniform(0.02, 0.12))
            plan = [ggo.Step((length, 0.0), (box,)), ggo.Step((length, 0.0)), STANDING]
        else:
            rise, edge = rng.uniform(0.05, 0.17) * rng.choice([-1, 1]), rng.uniform(0.15, 0.25)
            ground = ggo.stair_ground(edge, 0.3, [rise])
            end = ggo.Step(end_frame=STANDING.end_frame, ground=ground.shifted(0.32, rise))
            plan = [ggo.Step((0.32, rise), ground=ground), end]
        try:
            walk = ggo.walk(BASE, plan, start=ggo.STANDING, limits=limits)
        except ggo.InfeasibleGaitError:
            continue
        made += 1
        frames = [gait.frames if k % 2 == 0 else swap_roles(gait.frames) for k, gait in enumerate(walk.gaits)]
        whole = np.concatenate([frames[0][:1], frames[0], *(each[1:] for each in frames[1:]), frames[-1][-1:]])
        np.testing.assert_array_equal(whole[2], whole[1])
        np.testing.assert_array_equal(whole[-3], whole[-2])
        if limits is not None:
            speeds, bends = (np.abs(np.diff(whole, order, axis=0)).max(axis=0) / BASE.dt**order for order in (1, 2))
            assert (speeds <= limits.speed * 1.0011).all()
            assert (bends <= limits.acceleration * 1.0011).all()
    assert made >= 85


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_replanned_walks(seed):
    rng, made = np.random.default_rng(seed), 0
    for _ in range(50):
        x, steps = rng.uniform(0.1, 0.25), [ggo.Step((0.4, 0.0))] * 3
        walk = ggo.walk(BASE, [ggo.Step((0.4, 0.0), (ggo.Obstacle(x, x + 0.05, 0.06),)), *steps], limits=LIMITS)
        step, frame, foothold = int(rng.integers(1, 5)), int(rng.integers(0, 40)), (float(rng.uniform(0.37, 0.43)), 0.0)
        try:
            again = ggo.replan(walk, step=step, at_frame=frame, foothold=foothold)
        except ggo.InfeasibleGaitError:
            continue
        made += 1
        for number in range(step - 1):
            np.testing.assert_array_equal(again.gaits[number].frames, walk.gaits[number].frames)
        ahead, before = again.gaits[step - 1].frames[: frame + 1], walk.gaits[step - 1].frames[: frame + 1]
        np.testing.assert_array_equal(ahead, before)
        assert all(report.ok for report in again.verify())
    assert made >= 40
