"""What some steps turned out to cost, for steps that are alike."""

import numpy as np
import pytest

from ggo_factors.planning.known import ALIKE, Known


def test_a_step_is_as_many_times_dearer_as_it_was_and_one_far_away_is_not():
    behind = np.array([0.0, 0.0, 0.0, 0.5])
    stands = np.array([0.4, 0.4, 0.4, 1.2])
    lands = np.array([0.8, 0.8 + ALIKE, 1.8, 1.8])
    known = Known(behind, stands, lands)
    assert known.times == pytest.approx(1.0)
    known.add([0.0, 0.4, 0.8], [0.06], np.array([0.02]))
    assert known.times == pytest.approx([3.0, 3.0 ** np.exp(-1.0), 1.0, 1.0])
    known.add([0.5, 1.2, 1.8], [0.01], np.array([0.02]))
    assert known.times == pytest.approx([3.0, 3.0 ** np.exp(-1.0), 1.0, 0.5])


def test_what_was_found_twice_is_the_mean_and_what_is_no_cost_does_not_count():
    known = Known(np.zeros(1), np.full(1, 0.4), np.full(1, 0.8))
    for cost in (0.08, 0.02, np.inf, 0.0):
        known.add([0.0, 0.4, 0.8], [cost], np.array([0.02]))
    assert known.times == pytest.approx(2.0)
