"""The very frame where a replan begins: what is hit there is walked, what the joints do there is still to come."""

import math

import numpy as np
import pytest

import ggo_factors as ggo
from tests.independent import path_of

BASE = ggo.paper_base_gait()


def test_a_hit_in_the_frame_where_a_replan_begins_is_walked_already():
    first = ggo.step_over(BASE, [ggo.Obstacle(0.20, 0.25, 0.08)], foothold=(0.39, 0.0))
    seen = []
    for frame in range(31, 43):
        # The foot comes down: over a box that ends where it is now, now is when it is lowest.
        x, y = path_of(first.gait.frames)[frame]
        box = ggo.Obstacle(x - 0.02, x, y + 0.01)
        hits = [fault.frame for fault in ggo.verify(first.gait, obstacles=[box]).violations if fault.kind == "obstacle"]
        if hits == [float(frame)]:  # to the bit, which rounding spares most of them
            seen.append(frame)
            with pytest.raises(ggo.InfeasibleGaitError, match=f"frame {frame}: too late, already walked: obstacle"):
                ggo.replan(first, frame, obstacles=[box])
    assert seen


def test_the_joints_keep_their_limits_in_the_frame_where_a_replan_begins():
    """The swinging knee slows from frame 24 on: its acceleration there is beyond the limit, that at frame 25 is not."""
    step = ggo.step_over(BASE, [])
    knee = np.degrees(np.diff(step.gait.frames[:, 3], n=2)) / BASE.dt**2
    limits = ggo.JointLimits(knee_acceleration=math.radians(3420.0))
    assert abs(knee[23]) > 3450.0
    assert np.abs(knee[24:]).max() < 3400.0
    for frame in (24, 25):
        again = ggo.replan(step, frame, limits=limits)
        assert again.ok
        late = np.degrees(np.diff(again.gait.frames[frame - 1 :, 3], n=2)) / BASE.dt**2
        assert np.abs(late).max() < 3420.0 * 1.0011
