"""Where a swing ankle may come close to the ground: near a foothold, and farther beside the other foot."""

import math

import numpy as np
import pytest

from ggo_factors.check.ground import BESIDE_ZONE, FOOTHOLD_ZONE, near_footholds
from ggo_factors.motion.terrain import Ground

PLACES = np.linspace(-0.099, 0.099, 400)


def near(ground, lands):
    return near_footholds(PLACES, ground.height_at(PLACES), np.array([[-0.4, 0.0], [lands, 0.0]]), ground)


@pytest.mark.parametrize("degrees", [-14.0, -6.206516067865, 0.0, 0.1, 6.206516067865, 11.3])
def test_on_a_ramp_rounding_decides_nothing(degrees):
    """A plan that had passed was refused when its file was read: slopes are written in degrees."""
    ramp = Ground(slopes=(math.radians(degrees),))
    assert near(ramp, 0.0).all()
    assert near(ramp, 0.4).sum() == 0
    assert near(ramp, BESIDE_ZONE).tolist() == (PLACES >= 0.0).tolist()


def test_another_tread_is_other_ground():
    stair = Ground(edges=(0.03,), heights=(0.0, 0.1))
    assert near(stair, 0.0).tolist() == (PLACES < 0.03).tolist()
    assert near(Ground(edges=(0.01,), heights=(0.0, 0.1)), 0.0).tolist() == (PLACES <= FOOTHOLD_ZONE).tolist()
