"""The speed of the joints over a role swap."""

import numpy as np

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


def test_a_step_goes_on_with_the_last_motion_of_the_one_before():
    steps = [ggo.Step((0.42, 0.0), obstacles=[ggo.Obstacle(0.20, 0.25, 0.08)]), ggo.Step((0.39, 0.0))]
    before, after = (np.diff(gait.frames - BASE.frames, axis=0) for gait in ggo.walk(BASE, steps).gaits)
    np.testing.assert_allclose(after[0], before[-1][[2, 3, 0, 1]], rtol=0.0, atol=1e-12)
    assert np.abs(before[-1] - before[-2]).max() > 1e-5  # or another motion would do as well
