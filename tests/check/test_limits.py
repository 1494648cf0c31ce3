"""Joint limits: what they say of a gait, worked by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
MODEL = ggo.LegModel(0.39, 0.39)
WIDE = ggo.JointLimits()


def faults(frames, limits, dt=0.1, slack=0.0):
    gait = ggo.Gait(np.radians(np.array(frames, dtype=float)), dt, model=MODEL)
    tolerances = ggo.Tolerances(limits=slack, hip_drop=9.0, ground=9.0, ground_at_ends=9.0)
    return [str(violation) for violation in ggo.verify(gait, limits=limits, tolerances=tolerances).violations]


STILL = [[0.0, 10.0, 0.0, 10.0]] * 5


def moved(frame, column, degrees):
    frames = np.array(STILL)
    frames[frame, column] += degrees
    return frames


def test_nothing_is_said_of_a_gait_that_keeps_them():
    assert faults(STILL, WIDE) == []
    assert ggo.verify(BASE, limits=WIDE).ok


def test_nothing_is_said_without_limits():
    assert faults(moved(2, 3, 60.0), None) == []


def test_a_knee_that_jumps():
    # 0, 60, 0 degrees in frames 0.1 s apart: 600 degrees/s either way, 12,000 degrees/s^2 at the top.
    assert faults(moved(2, 3, 60.0), WIDE) == [
        "knee speed (swing leg) at frame 1.5: 600 deg/s (limit 500 deg/s)",
        "knee acceleration (swing leg) at frame 2: -1.2e+04 deg/s2 (limit -1e+04 deg/s2)",
    ]


def test_a_thigh_too_far_back():
    slow = replace(WIDE, hip_speed=100.0, hip_acceleration=1000.0)
    assert faults(moved(0, 0, -20.0), slow)[:1] == ["hip angle (support leg) at frame 0: -20 deg (limit -17 deg)"]
    assert faults(moved(4, 2, 96.0), slow) == ["hip angle (swing leg) at frame 4: 96 deg (limit 95 deg)"]


def test_the_worst_is_told_once_for_hips_and_once_for_knees():
    frames = moved(2, 0, 30.0)
    frames[1:, 2] += 40.0
    assert [text.split(" at ")[0] for text in faults(frames, WIDE)][:2] == [
        "hip speed (swing leg)",
        "hip acceleration (support leg)",
    ]


def test_half_the_time_doubles_speeds_and_quadruples_accelerations():
    speeds = np.abs(np.diff(BASE.frames, axis=0)).max(axis=0) / BASE.dt
    accelerations = np.abs(np.diff(BASE.frames, 2, axis=0)).max(axis=0) / BASE.dt**2
    limits = replace(
        WIDE,
        hip_speed=speeds[::2].max() * 1.9,
        knee_speed=speeds[1::2].max() * 2.1,
        hip_acceleration=accelerations[::2].max() * 3.9,
        knee_acceleration=accelerations[1::2].max() * 4.1,
    )
    assert ggo.verify(BASE, limits=limits).ok
    hurried = replace(BASE, dt=BASE.dt / 2.0)
    kinds = [violation.kind for violation in ggo.verify(hurried, limits=limits).violations]
    assert kinds == ["hip speed", "hip acceleration"]


def test_a_solver_may_be_off_by_a_thousandth():
    exact = replace(WIDE, knee_speed=math.radians(600.0), knee_acceleration=math.radians(12000.0))
    over = moved(2, 3, 60.03)
    assert faults(over, exact, slack=0.001) == []
    assert len(faults(over, exact, slack=0.0)) == 2


def test_arrays_are_in_the_order_of_a_frame():
    limits = ggo.JointLimits(-0.1, 1.0, 0.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    np.testing.assert_array_equal(limits.lower, [-0.1, 0.0, -0.1, 0.0])
    np.testing.assert_array_equal(limits.upper, [1.0, 2.0, 1.0, 2.0])
    np.testing.assert_array_equal(limits.speed, [3.0, 4.0, 3.0, 4.0])
    np.testing.assert_array_equal(limits.acceleration, [5.0, 6.0, 5.0, 6.0])
    assert not limits.lower.flags.writeable


def test_two_frames_have_no_acceleration():
    assert faults([[0, 0, 0, 0], [1, 1, 1, 1]], WIDE) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"hip_back": -17.0}, "hip_back: angle -17 rad at .* looks like degrees"),
        ({"knee_bent": -0.5}, r"knee_bent: -0\.5 rad must be above knee_straight -0\.0174533 rad"),
        ({"hip_speed": 0.0}, "hip_speed: 0 rad/s must be above 0 rad/s"),
        ({"knee_acceleration": math.nan}, r"knee_acceleration: nan rad/s\^2 is not finite"),
        ({"knee_straight": "straight"}, "knee_straight: expected numbers"),
    ],
)
def test_limits_are_checked_when_made(arguments, message):
    with pytest.raises(ggo.InputError, match=message):
        ggo.JointLimits(**arguments)


def test_limits_of_another_kind_are_refused():
    with pytest.raises(ggo.InputError, match="limits: expected a JointLimits"):
        ggo.verify(BASE, limits=3.0)
