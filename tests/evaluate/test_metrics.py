"""Metrics against hand-worked numbers and against models that share no code with them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.errors import InputError
from ggo_factors.evaluate import metrics

BASE = ggo.paper_base_gait()
LEGS = ggo.LegModel(0.39, 0.39)


def gait(frames, dt=0.01, model=LEGS):
    return ggo.Gait(np.array(frames, dtype=float), dt, model=model)


def test_zmp_of_a_still_stance_is_the_centre_of_mass():
    # Straight legs, 0.2 rad to either side: middles at 1/4 and 3/4 of a leg, mirrored about the hip's x.
    hip_x = -0.78 * math.sin(0.2)
    points = metrics.zmp(gait([[0.2, 0.0, -0.2, 0.0]] * 5))
    by_hand = np.mean([hip_x * share for share in (0.25, 0.75)] * 1 + [hip_x * (1 + share) for share in (0.25, 0.75)])
    np.testing.assert_allclose(points, by_hand, atol=1e-12)
    heavy = ggo.LegModel(0.39, 0.39, thigh_mass=14.0, shank_mass=7.0)
    weights = np.array([7.0, 14.0, 14.0, 7.0])
    weighted = weights @ (hip_x * np.array([0.25, 0.75, 1.25, 1.75])) / weights.sum()
    np.testing.assert_allclose(metrics.zmp(gait([[0.2, 0.0, -0.2, 0.0]] * 5, model=heavy)), weighted, atol=1e-12)


def test_zmp_of_one_frame_worked_by_hand():
    # Upright legs; the swing thigh and shank turn together, 0 -> 0.1 -> 0 rad, the hip stays at (0, 0.78).
    dt, angle = 0.1, 0.1
    (point,) = metrics.zmp(gait([[0, 0, 0, 0], [0, 0, angle, 0], [0, 0, 0, 0]], dt))
    top = bottom = 0.0
    for far, stands in ((0.195, True), (0.585, True), (0.195, False), (0.585, False)):
        x, y = (0.0, far) if stands else (far * math.sin(angle), 0.78 - far * math.cos(angle))
        ax, ay = (0.0, 0.0) if stands else (-2 * x / dt**2, -2 * (y - (0.78 - far)) / dt**2)
        top += (ay + 9.81) * x - y * ax
        bottom += ay + 9.81
    assert point == pytest.approx(top / bottom, abs=1e-12)


def test_step_time_takes_the_place_of_the_gaits_own():
    slow = ggo.Gait(BASE.frames, 1.18 / 50, model=LEGS)
    np.testing.assert_allclose(metrics.zmp(BASE, step_time=1.18), metrics.zmp(slow), atol=1e-12)


def test_rotational_inertia_is_that_of_many_particles():
    fine = ggo.paper_base_gait(201)
    joints = LEGS.joints(fine.frames)
    parts = 100
    shares = (np.arange(parts) + 0.5) / parts
    x, y = np.moveaxis(
        (joints[:, :-1, None] + shares[:, None] * (joints[:, 1:, None] - joints[:, :-1, None])).reshape(201, -1, 2),
        -1,
        0,
    )
    dt = 1.18 / 200
    ax, ay = np.diff(x, 2, axis=0) / dt**2, np.diff(y, 2, axis=0) / dt**2
    x, y = x[1:-1], y[1:-1]
    particles = ((ay + 9.81) * x - y * ax).sum(axis=1) / (ay + 9.81).sum(axis=1)
    rods = metrics.zmp(fine, step_time=1.18, rotational_inertia=True)
    np.testing.assert_allclose(rods, particles, atol=2e-5)
    assert np.abs(metrics.zmp(fine, step_time=1.18) - particles).max() > 5e-3


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: metrics.zmp(gait(np.zeros((2, 4)))), "need at least 3"),
        (lambda: metrics.zmp(BASE, step_time=0.0), "step_time"),
        (lambda: metrics.zmp(ggo.Gait(BASE.frames, 0.01)), "states no leg lengths"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(InputError, match=words):
        call()
