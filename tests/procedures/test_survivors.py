"""The acceleration of the joints where one motion takes over from another: a step's first, and a replan's."""

import math

import numpy as np
import pytest

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


@pytest.mark.parametrize("most", [1600.0, 2500.0])
def test_a_base_gait_that_does_not_close_in_speed_keeps_the_limits_across_the_change_of_legs(most):
    """Its swinging thigh ends some 0.5 rad/s too fast: carried on as it is, the hip's acceleration is 2998 deg/s2."""
    frames = BASE.frames.copy()
    frames[41:, 2] += math.radians(1.2) * (np.arange(1, 11) / 10.0) ** 3
    own = frames[1] - frames[0] - np.roll(frames[-1] - frames[-2], 2)
    assert np.degrees(own[0]) / BASE.dt**2 == pytest.approx(-2998.0, abs=1.0)
    limits = ggo.JointLimits(hip_acceleration=math.radians(most))
    walk = ggo.walk(ggo.Gait(frames, BASE.dt, model=BASE.model), [ggo.Step((0.39, 0.0))] * 2, limits=limits)
    one, two = (gait.frames for gait in walk.gaits)
    over = np.degrees(two[1] - two[0] - np.roll(one[-1] - one[-2], 2)) / BASE.dt**2
    assert np.abs(over[::2]).max() == pytest.approx(most, rel=1e-6)


@pytest.mark.parametrize(("frame", "x", "found"), [(10, 0.48, "1555"), (30, 0.36, "-1671")])
def test_without_smoothness_the_acceleration_in_the_frame_where_a_replan_begins_is_checked(frame, x, found):
    """Nothing carries the walker's speed on then, so that only the check sees how suddenly it changes there."""
    step = ggo.step_over(BASE, [], foothold=(0.39, 0.0), smoothness=0.0)
    limits = ggo.JointLimits(hip_acceleration=math.radians(1300.0))
    with pytest.raises(ggo.InfeasibleGaitError, match=rf"hip acceleration \(swing leg\) at frame {frame}: {found} deg"):
        ggo.replan(step, frame, foothold=(x, 0.0), limits=limits)
