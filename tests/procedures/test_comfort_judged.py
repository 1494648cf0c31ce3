"""What a leg that wears a gait feels: accelerations near the base gait's, and no jump in speed between steps."""

from itertools import pairwise

import numpy as np
import pytest
from bare_bones import pointed
from independent import clearance, path_of

import ggo_factors as ggo
from ggo_factors.motion.gait import swap_roles

BASE = ggo.paper_base_gait()
BOXES = [(0.20, 0.25, 0.08), (0.20, 0.25, 0.15), (0.12, 0.16, 0.08), (0.12, 0.16, 0.15), (-0.33, -0.29, 0.175)]


def over(box, **options):
    """Frames of a step over a box, judged by P written out."""
    frames = ggo.step_over(pointed(BASE), [ggo.Obstacle(*box)], foothold=(0.39, 0.0), **options).gait.frames
    assert clearance(frames, *box) > 0.0
    assert np.hypot(*(path_of(frames)[-1] - [0.39, 0.0])) < 1e-3
    return frames


def peaks(frames):
    return np.abs(np.diff(frames, n=2, axis=0)).max(axis=0)


def test_the_papers_obstacles_ask_little_more_of_the_actuators_than_level_ground():
    smooth, kinked = (np.stack([over(box, **options) for box in BOXES]) for options in ({}, {"smoothness": 0.0}))
    for frames in smooth:
        assert (peaks(frames) <= 4.0 * peaks(BASE.frames)).all()
        assert peaks(frames).max() <= 1.5 * peaks(BASE.frames).max()
    # What it is for: without it an actuator would have to follow many times as much.
    assert max((peaks(frames) / peaks(BASE.frames)).max() for frames in kinked) > 10.0
    changed, without = (np.abs(frames - BASE.frames).mean() for frames in (smooth, kinked))
    assert changed <= 1.15 * without


def walks(base):
    yield ggo.walk(base, [ggo.Step((0.39, 0.0), (ggo.Obstacle(*box),)) for box in BOXES[:3]])
    yield ggo.walk(
        base, [ggo.Step((0.45, 0.0)), ggo.Step((0.39, 0.0), (ggo.Obstacle(*BOXES[1]),)), ggo.Step((0.35, 0.0))]
    )
    yield ggo.climb_stairs(base, 0.15, steps=3)
    yield ggo.descend_stairs(base, 0.15, steps=3)


@pytest.mark.parametrize("frames", [51, 201])
def test_the_joints_go_on_as_fast_when_the_legs_change_roles(frames):
    base = ggo.paper_base_gait(frames)
    for walk in walks(base):
        offsets = [np.diff(gait.frames - base.frames, axis=0) for gait in walk.gaits]
        fastest = max(np.abs(np.diff(gait.frames, axis=0)).max() for gait in walk.gaits)
        assert max(np.abs(rates[-1]).max() for rates in offsets[:-1]) > 0.02 * fastest  # or nothing would be joined
        for before, after in pairwise(offsets):
            assert np.abs(swap_roles(before[-1]) - after[0]).max() < 0.01 * fastest


def test_without_smoothing_they_jump():
    walk = ggo.walk(BASE, next(walks(BASE)).plan, smoothness=0.0)
    before, after = (np.diff(gait.frames - BASE.frames, axis=0) for gait in walk.gaits[:2])
    assert np.abs(swap_roles(before[-1]) - after[0]).max() > 0.05 * np.abs(np.diff(walk.gaits[1].frames, axis=0)).max()
