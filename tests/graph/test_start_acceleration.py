"""A graph that begins with a motion: the joint limits hold from that motion to its first one too."""

import numpy as np
import pytest

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


@pytest.mark.parametrize("given", [0.0, 0.5, 0.9])
def test_the_joint_limits_hold_for_the_acceleration_at_the_start(given):
    """Held as constraints; with the limits of all later frames alone the first motion is 18 to 25 % beyond."""
    limits = ggo.JointLimits(hip_acceleration=20.0)
    offset = np.array([0.0, 0.0, 0.02, 0.0])
    graph = ggo.GaitGraph(BASE, smoothness=100.0, hard=True)
    graph.anchor(BASE.frames[0])
    graph.end((0.39, 0.0), gain=500.0)
    graph.begin_with(offset, given)
    graph.limit_joints(limits)
    solution = graph.solve()
    assert solution.converged, solution.reason
    before = BASE.frames[1] - BASE.frames[0] + offset
    change = np.abs(solution.gait.frames[1] - solution.gait.frames[0] - before)
    # From what is given, which lasts half of its share of the motion's time, to the middle of the first motion.
    share = change / ((1.0 - given) * limits.acceleration * BASE.dt**2 / 2.0)
    assert share.max() == pytest.approx(1.0, abs=1e-5)
