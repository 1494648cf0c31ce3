"""A trajectory is checked when it is made, as a gait is."""

import numpy as np
import pytest

import ggo_factors as ggo

TIME, STILL = np.arange(5) * 0.1, np.zeros(5)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"time": TIME[:1]}, "at least 2 instants"),
        ({"time": []}, "at least 2 instants"),
        ({"time": TIME[::-1]}, "times grow from 0"),
        ({"time": TIME + 1.0}, "times grow from 0"),
        ({"time": TIME * np.nan}, "time: value nan"),
        ({"left_knee": STILL[:4]}, r"left_knee: expected shape \(5,\), got \(4,\)"),
        ({"right_hip": STILL + np.inf}, "right_hip: value inf"),
        ({"ends_at_rest": "no"}, "ends_at_rest: expected True or False"),
    ],
)
def test_what_nobody_can_replay_is_refused(changed, said):
    joints = dict.fromkeys(("left_hip", "left_knee", "right_hip", "right_knee"), STILL)
    assert ggo.JointTrajectory(TIME, **joints).time.tolist() == TIME.tolist()
    with pytest.raises(ggo.InputError, match=said):
        ggo.JointTrajectory(**{"time": TIME, **joints, **changed})
