"""What one would do without a graph: held to the conditions that define it, by other means."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import BPoly, CubicSpline

from ggo_factors.evaluate import rivals
from ggo_factors.evaluate.rivals import RIVALS
from ggo_factors.motion.paper_gait import paper_base_gait

BASE = paper_base_gait(2001).frames
TIMES = np.linspace(0.0, 1.0, len(BASE))
START = BASE[0] + np.radians([3.0, -2.0, 5.0, 1.0])
RATE = rivals.first_rate(BASE) + np.radians([20.0, -30.0, 10.0, 40.0])
LANDING = BASE[-1] + np.radians([-4.0, 2.0, 1.0, 6.0])


@pytest.mark.parametrize("name", RIVALS)
def test_who_starts_and_lands_as_the_base_gait_does_gets_it(name):
    made = RIVALS[name](BASE, BASE[0], rivals.first_rate(BASE), BASE[-1])
    # The spline alone knows the base gait at a few poses only.
    np.testing.assert_allclose(made, BASE, atol=np.radians(2.0) if name == "via_points" else 1e-12)


@pytest.mark.parametrize("name", RIVALS)
def test_each_starts_where_the_walker_is(name):
    np.testing.assert_allclose(RIVALS[name](BASE, START, RATE, LANDING)[0], START, atol=1e-12)


@pytest.mark.parametrize("name", ["minimum_jerk", "via_points", "dmp"])
def test_those_that_know_motion_and_landing_keep_them(name):
    made = RIVALS[name](BASE, START, RATE, LANDING)
    np.testing.assert_allclose(rivals.first_rate(made), RATE, atol=0.02)
    # A movement primitive comes near its goal and never to it.
    np.testing.assert_allclose(made[-1], LANDING, atol=1e-3 if name == "dmp" else 1e-9)


def test_no_change_is_a_constant_and_a_faded_offset_is_gone_at_landing():
    np.testing.assert_allclose(np.ptp(RIVALS["no_change"](BASE, START, RATE, LANDING) - BASE, axis=0), 0.0, atol=1e-12)
    off = RIVALS["faded"](BASE, START, RATE, LANDING) - BASE
    np.testing.assert_allclose(off[[1000, -1]], [(START - BASE[0]) / 2.0, np.zeros(4)], atol=1e-12)


def test_least_jerk_is_the_quintic_of_its_ends():
    off = RIVALS["minimum_jerk"](BASE, START, RATE, LANDING) - BASE
    ends = [
        np.array([START - BASE[0], RATE - rivals.first_rate(BASE), np.zeros(4)]),
        np.array([LANDING - BASE[-1], np.zeros(4), np.zeros(4)]),
    ]
    np.testing.assert_allclose(off, BPoly.from_derivatives([0.0, 1.0], ends)(TIMES), atol=1e-12)


def test_via_points_are_poses_of_the_base_gait():
    made = RIVALS["via_points"](BASE, START, RATE, LANDING)
    poses = np.linspace(0, len(BASE) - 1, rivals.VIA_POINTS + 2)[1:-1]
    between = CubicSpline(np.arange(len(BASE)), made)(poses)
    np.testing.assert_allclose(between, CubicSpline(np.arange(len(BASE)), BASE)(poses), atol=1e-9)


def test_a_movement_primitive_is_what_integrating_it_gives():
    """The forcing term as it is taught: of the base gait's own accelerations, with its own start and goal."""
    stiff, damping, decay = rivals.DMP_STIFFNESS, rivals.DMP_DAMPING, rivals.DMP_PHASE
    base = CubicSpline(TIMES, BASE)

    def forcing(t):
        pull = stiff * (BASE[-1] - base(t)) - damping * base(t, 1) - stiff * (BASE[-1] - BASE[0]) * np.exp(-decay * t)
        return base(t, 2) - pull

    def motion(t, state):
        x, speed = state[:4], state[4:]
        pull = stiff * (LANDING - x) - damping * speed - stiff * (LANDING - START) * np.exp(-decay * t)
        return np.concatenate([speed, pull + forcing(t)])

    speed = base(0.0, 1) + RATE - rivals.first_rate(BASE)
    found = solve_ivp(motion, (0.0, 1.0), [*START, *speed], t_eval=TIMES, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(RIVALS["dmp"](BASE, START, RATE, LANDING), found.y[:4].T, atol=1e-6)
