"""What a refusal offers instead must work."""

import pytest

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


@pytest.mark.parametrize(("x", "hard"), [(1.05, False), (1.10, False), (1.05, True)])
def test_the_foothold_that_a_refusal_offers_is_reached_by_a_gait_that_passes(x, hard):
    """Nearer ones are within the legs' reach, but the hip would drop too far."""
    with pytest.raises(ggo.InfeasibleGaitError, match="no gait found that passes the check") as caught:
        ggo.step_over(BASE, [], foothold=(x, 0.0), hard=hard)
    nearest = caught.value.nearest_foothold
    assert nearest is not None
    assert ggo.step_over(BASE, [], foothold=nearest, hard=hard).ok
    with pytest.raises(ggo.InfeasibleGaitError, match="no gait found that passes the check"):
        ggo.step_over(BASE, [], foothold=(x - 0.02, 0.0), hard=hard)
