"""Hard constraints of a user's own that cannot be met: the solution must not be called converged."""

import re

import gtsam
import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.factors import checked_factor, frame_key

BASE = ggo.paper_base_gait()
HARD = gtsam.noiseModel.Constrained.All


def never_zero(frame, want_jacobian):
    return np.array([1.0 + frame[2] ** 2]), (np.array([[0.0, 0.0, 2.0 * frame[2], 0.0]]),)


def thigh_at(angle):
    def function(frame, want_jacobian):
        return np.array([frame[2] - angle]), (np.array([[0.0, 0.0, 1.0, 0.0]]),)

    return checked_factor("thigh", (25,), 1, function, HARD(1))


@pytest.mark.parametrize(
    ("factors", "missed"),
    [
        ([checked_factor("never zero", (25,), 1, never_zero, HARD(1))], "frame 25 is missed by 1"),
        (
            [gtsam.PriorFactorVector(frame_key(25), BASE.frames[25] + offset, HARD(4)) for offset in (0.0, 0.05)],
            "frame 25 is missed by 0.05",
        ),
        ([thigh_at(0.1), thigh_at(0.2)], r"frame 25 is missed by 0\.[01]"),
        ([gtsam.PriorFactorVector(frame_key(0), BASE.frames[0] + 0.05, HARD(4))], "frame 0 is missed by 0.05"),
    ],
)
def test_a_hard_constraint_of_ones_own_that_is_missed_is_seen(factors, missed):
    graph = ggo.GaitGraph(BASE)
    graph.anchor(BASE.frames[0])
    graph.end((0.39, 0.0), gain=250.0)
    for factor in factors:
        graph.add_factor(factor)
    solution = graph.solve()
    assert not solution.converged
    assert re.search(missed, solution.reason)
    with pytest.raises(ggo.InfeasibleGaitError, match="contradicting: a hard edge"):
        solution.require_ok()
