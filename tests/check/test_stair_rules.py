"""How near the swing ankle may come to stairs, and that no tread is too thin to be seen."""

import numpy as np
import pytest
from bare_bones import pointed

import ggo_factors as ggo
from tests.independent import densely, path_of, stair_clearance

BASE = ggo.paper_base_gait()
STEP = ggo.step_over(BASE, [ggo.Obstacle(0.20, 0.25, 0.08)], foothold=(0.39, 0.0), smoothness=0.0).gait


def test_the_swing_ankle_keeps_five_millimetres_over_stairs():
    edges = (0.10, 0.30)
    x, y = path_of(densely(STEP.frames, 5001)).T
    lowest = float(y[(edges[0] <= x) & (x <= edges[1])].min())

    def report(clearance, **options):
        return ggo.verify(STEP, ground=ggo.Ground(edges, (0.0, lowest - clearance, 0.0)), **options)

    assert stair_clearance(STEP.frames, edges, (0.0, lowest - 0.003, 0.0)) == pytest.approx(0.003, abs=5e-4)
    (fault,) = report(0.003).violations
    assert (fault.kind, fault.limit) == ("ground", 0.005)
    assert fault.value == pytest.approx(0.003, abs=5e-4)
    assert report(0.007).ok
    assert report(0.003, tolerances=ggo.Tolerances(stair_clearance=0.002)).ok


@pytest.mark.parametrize("instant", [260, 300, 330])
def test_a_tread_that_lies_between_two_instants_of_the_check_is_seen(instant):
    path = path_of(densely(STEP.frames, 501))  # the instants of the check for 51 frames
    x, y = path[instant : instant + 2].mean(axis=0)
    edges = (x - 1e-5, x + 1e-5)
    assert np.abs(path[:, 0] - x).min() > 1e-4
    (fault,) = ggo.verify(pointed(STEP), ground=ggo.Ground(edges, (0.0, y - 0.003, 0.0))).violations
    assert fault.kind == "ground"
    assert instant / 10 < fault.frame < (instant + 1) / 10
    assert ggo.verify(pointed(STEP), ground=ggo.Ground(edges, (0.0, y - 0.007, 0.0))).ok
