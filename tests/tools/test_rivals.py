"""The rivals of the benchmark at a step that no task of it has: one that ends in standing."""

import numpy as np
import pytest
from rival_minimisers import rivals
from rivals import default_smoothness, walk

import ggo_factors as ggo

WAYS = [(solver, way) for solver, ways in rivals(31).items() for way in ways]


@pytest.mark.parametrize(("solver", "way"), WAYS)
def test_a_step_to_standing_ends_at_rest_in_the_same_gait(solver, way):
    base = ggo.paper_base_gait(31)
    steps = [ggo.Step((0.39, 0.0), (ggo.Obstacle(0.20, 0.25, 0.06),)), ggo.Step(end_frame=tuple(ggo.STANDING))]
    ours = ggo.walk(base, steps)
    found = walk(base, steps, default_smoothness(31), rivals(31)[solver][way])
    assert found.ok
    for gait, theirs in zip(ours.gaits, found.gaits, strict=True):
        np.testing.assert_allclose(theirs, gait.frames, atol=1e-4)
    np.testing.assert_array_equal(found.gaits[-1][-1], found.gaits[-1][-2])
