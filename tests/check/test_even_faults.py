"""Limits of frames that need not be a gait: what is left of a step near its end."""

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.check.joint_rates import even_faults, limit_faults
from ggo_factors.motion.joint_limits import JointLimits

BASE = ggo.paper_base_gait()


def test_of_a_gait_they_are_those_of_its_limits():
    strict = JointLimits(hip_speed=1.0, knee_speed=2.0, hip_acceleration=5.0)
    assert even_faults(BASE.frames, BASE.dt, strict, 0.0) == limit_faults(BASE, strict)
    assert len(limit_faults(BASE, strict)) >= 3


def test_frames_too_fast_for_any_gait_break_them():
    """A replan three frames before the landing was an error about the time step of such a gait."""
    frames, dt = BASE.frames[[0, 10, 20, 30, 40]], 0.008892
    with pytest.raises(ggo.InputError, match="a step takes"):
        ggo.Gait(frames, dt)
    fastest = np.degrees(np.abs(np.diff(frames, axis=0)).max() / dt)
    speeds = [abs(fault.value) for fault in even_faults(frames, dt, JointLimits(), 0.0) if "speed" in fault.kind]
    assert max(speeds) == pytest.approx(fastest)
