"""The paper's metrics against hand-worked numbers and against models that share no code with them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import paper_metrics as metrics
import pytest
from independent import clearance as least_height

import ggo_factors as ggo
from ggo_factors.errors import InputError

BASE = ggo.paper_base_gait()
LEGS = ggo.LegModel(0.39, 0.39)


def gait(frames, dt=0.01):
    return ggo.Gait(np.array(frames, dtype=float), dt, model=LEGS)


def test_smoothness_in_another_step_time():
    slow = metrics.smoothness(replace(BASE, dt=2.0 * BASE.dt))
    assert slow.jerk_largest * 8 == pytest.approx(metrics.smoothness(BASE).jerk_largest)


def test_smoothness_by_hand():
    base = gait(np.zeros((5, 4)), dt=0.5)
    moved = np.zeros((5, 4))
    moved[:, 2] = [0.0, 0.1, 0.1, 0.1, 0.1]
    moved[:, 3] = [0.0, 0.0, 0.2, 0.2, 0.2]
    s = metrics.smoothness(gait(moved, dt=0.5), base)
    assert s.residual_largest == pytest.approx(0.2)
    assert s.residual_rms == pytest.approx(math.sqrt((0.01 + 0.04) / 4))
    assert s.velocity_largest == pytest.approx(0.4)
    assert s.velocity_rms == pytest.approx(math.sqrt((0.2**2 + 0.4**2) / 16))
    assert s.acceleration_largest == pytest.approx(0.8)
    assert s.acceleration_rms == pytest.approx(math.sqrt((0.4**2 + 2 * 0.8**2) / 12))
    assert s.jerk_largest == pytest.approx(3.2)
    assert s.jerk_rms == pytest.approx(math.sqrt((0.8**2 + 3.2**2 + 1.6**2) / 8))
    assert math.isnan(metrics.smoothness(base).residual_rms)


def test_clearance_by_hand():
    # The hip stays over the origin at 0.78; the swing leg hangs straight at 0.5 rad, its thigh over a box ahead.
    still = gait([[0.0, 0.0, 0.5, 0.0]] * 2)
    knee_x, knee_y = 0.39 * math.sin(0.5), 0.78 - 0.39 * math.cos(0.5)
    ankle_x, ankle_y = 0.78 * math.sin(0.5), 0.78 - 0.78 * math.cos(0.5)
    under_ankle = metrics.clearance(still, ggo.Obstacle(ankle_x - 0.01, ankle_x + 0.01, 0.05))
    assert under_ankle.endpoint == pytest.approx(ankle_y - 0.05)
    assert under_ankle.shank == pytest.approx(ankle_y - 0.05)
    assert under_ankle.knee == math.inf
    under_shank = metrics.clearance(still, ggo.Obstacle(knee_x + 0.05, knee_x + 0.06, 0.3))
    assert under_shank.endpoint == math.inf
    assert under_shank.shank == pytest.approx(0.78 - (knee_x + 0.06) / math.tan(0.5) - 0.3)
    assert metrics.clearance(still, ggo.Obstacle(knee_x - 0.01, knee_x + 0.01, 0.1)).knee == pytest.approx(knee_y - 0.1)


def test_an_upright_shank_is_over_its_box_or_not():
    still = gait([[0.0, 0.0, 0.0, 0.0]] * 2)
    assert metrics.clearance(still, ggo.Obstacle(-0.1, 0.1, 0.1)).shank == pytest.approx(-0.1)
    assert metrics.clearance(still, ggo.Obstacle(0.1, 0.2, 0.1)) == metrics.Clearance(math.inf, math.inf, math.inf)


def test_a_foot_widens_the_box_for_the_ankle_and_lifts_knee_and_shank():
    foot = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(ankle_height=0.08, heel=0.05, toe=0.12))
    box = ggo.Obstacle(0.20, 0.25, 0.02)
    bare, shod = metrics.clearance(BASE, box), metrics.clearance(replace(BASE, model=foot), box)
    assert shod.endpoint == pytest.approx(metrics.clearance(BASE, ggo.Obstacle(0.08, 0.30, 0.02)).endpoint)
    assert shod.knee == pytest.approx(bare.knee + 0.08)
    assert shod.shank == pytest.approx(bare.shank + 0.08)


@pytest.mark.parametrize("box", [(0.2, 0.25, 0.01), (-0.33, -0.29, 0.175), (-0.35, 0.38, 0.3)])
def test_clearance_of_the_swing_ankle_agrees_with_the_independent_check(box):
    ours = metrics.clearance(BASE, ggo.Obstacle(*box)).endpoint
    assert ours == pytest.approx(least_height(BASE.frames, *box), abs=5e-4)


def test_foothold_error():
    landing = BASE.endpoints()[-1]
    assert metrics.foothold_error(BASE, (landing[0] + 0.03, landing[1] - 0.04)) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: metrics.smoothness(gait(np.zeros((3, 4)))), "needs at least 4"),
        (lambda: metrics.smoothness(BASE, ggo.paper_base_gait(21)), "frames"),
        (lambda: metrics.clearance(BASE, (0.1, 0.2, 0.1)), "obstacle"),
        (lambda: metrics.foothold_error(BASE, (0.1,)), "foothold"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(InputError, match=words):
        call()
