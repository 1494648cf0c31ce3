"""The rivals: that they are honest ones, which clear what they are to clear, and do what their names say."""

from __future__ import annotations

import numpy as np
import pytest
from bare_bones import pointed
from independent import clearance, densely, least_knee_deg, path_of
from rival_paths import PotentialField, minimum_jerk, potential_field

import ggo_factors as ggo

BASE = pointed(ggo.paper_base_gait())
FOOTHOLD = (0.39, 0.0)
BOXES = ((0.20, 0.25, 0.08), (0.20, 0.25, 0.15), (0.12, 0.16, 0.08), (0.12, 0.16, 0.15), (-0.33, -0.29, 0.175))


@pytest.mark.parametrize("rival", [potential_field, minimum_jerk])
@pytest.mark.parametrize("numbers", BOXES)
def test_rivals_clear_the_papers_obstacles(rival, numbers):
    box = ggo.Obstacle(*numbers)
    gait = rival(BASE, [box], FOOTHOLD)
    report = ggo.verify(gait, obstacles=[box], foothold=FOOTHOLD)
    assert report.ok, report.violations
    assert clearance(gait.frames, *numbers) > 0.009
    assert np.hypot(*(path_of(gait.frames)[-1] - FOOTHOLD)) < 1e-9
    assert path_of(densely(gait.frames))[:, 1].min() > -1e-3
    assert least_knee_deg(gait.frames) > -0.3
    np.testing.assert_array_equal(gait.frames[:, :2], BASE.frames[:, :2])
    np.testing.assert_allclose(gait.frames[0], BASE.frames[0], atol=1e-9)


def test_without_its_tangential_part_the_field_stops_before_a_box():
    weak = PotentialField(repulsion=3e-4, reach=0.2, tangential=0.0, ground_repulsion=0.0, inertia=0.0)
    box = ggo.Obstacle(0.20, 0.25, 0.15)
    with pytest.raises(ggo.InfeasibleGaitError, match=r"the swing ankle stops at \(0\.1"):
        potential_field(BASE, [box], FOOTHOLD, field=weak)


def test_minimum_jerk_without_obstacles_is_one_quintic():
    path = minimum_jerk(BASE, [], FOOTHOLD).endpoints()
    # The seventh difference of a polynomial of degree five is zero.
    assert np.abs(np.diff(path, 6, axis=0)).max() < 1e-12
    start = BASE.endpoints()
    np.testing.assert_allclose(path[1] - path[0], start[1] - start[0], atol=2e-4)


def test_minimum_jerk_has_less_jerk_than_its_neighbours():
    box = ggo.Obstacle(0.20, 0.25, 0.08)
    path = minimum_jerk(BASE, [box], FOOTHOLD).endpoints()
    jerk = (np.diff(path, 3, axis=0) ** 2).sum()
    # A bump that leaves both ends to the second derivative, and the box, alone.
    u = np.linspace(0.0, 1.0, len(path))
    corner = np.abs(path[:, 0] - 0.225).argmin() / (len(path) - 1)
    bump = (u * (1 - u)) ** 4 * (u - corner) ** 2
    for size in (-0.3, -0.1, 0.1, 0.3):
        for axis in np.eye(2):
            bent = path + size * bump[:, None] * axis
            assert (np.diff(bent, 3, axis=0) ** 2).sum() > jerk * (1 - 1e-3)


@pytest.mark.parametrize("rival", [potential_field, minimum_jerk])
def test_several_boxes_and_the_default_foothold(rival):
    boxes = [ggo.Obstacle(-0.20, -0.15, 0.05), ggo.Obstacle(0.15, 0.20, 0.05)]
    gait = rival(BASE, boxes)
    assert gait.endpoints()[-1] == pytest.approx([BASE.endpoints()[-1, 0], 0.0], abs=1e-9)
    for box in boxes:
        assert clearance(gait.frames, box.x_start, box.x_end, box.height) > 0.0


@pytest.mark.parametrize("rival", [potential_field, minimum_jerk])
def test_a_foothold_out_of_reach_is_refused(rival):
    with pytest.raises(ggo.UnreachableFootholdError, match=r"the leg reaches 0\.78"):
        rival(BASE, [], (0.9, 0.0))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: PotentialField(reach=0.0), "reach"),
        (lambda: PotentialField(inertia=1.0), "inertia"),
        (lambda: PotentialField(repulsion=float("nan")), "repulsion"),
        (lambda: potential_field(BASE, [(0.1, 0.2, 0.1)], FOOTHOLD), "obstacles"),
        (lambda: minimum_jerk(ggo.paper_base_gait(3), [], FOOTHOLD), "at least 4"),
        (lambda: potential_field(BASE, [], (0.39,)), "foothold"),
    ],
)
def test_bad_input_is_named(call, words):
    with pytest.raises(ggo.InputError, match=words):
        call()
