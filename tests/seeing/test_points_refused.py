"""Points and directions that are of no use are one true line; what is only odd is read."""

import math
import time

import numpy as np
import pytest
from depth_camera import KINECT_2
from seen_scenes import Scene

from ggo_factors import InputError, Sighting, Terrain, terrain_from_points

SCENE = Scene(Terrain.level(1.0) + Terrain.level(5, rise=0.1), (), (), KINECT_2, 1)
POINTS, TOLD = SCENE.points(), SCENE.told()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.empty((0, 3)), "points: there are none"),
        (np.full((500, 3), np.nan), "points: none of 500 is finite"),
        (np.zeros((500, 4)), r"points: expected shape \(n, 3\) or \(rows, columns, 3\), got \(500, 4\)"),
        (np.zeros(3), "points: expected shape"),
        ("cloud", "points: expected numbers"),
        ([["a", "b", "c"]], "points: expected numbers"),
        (np.zeros((500, 3), complex), "points: expected numbers"),
        (np.ma.masked_array(np.zeros((500, 3))), "points: expected numbers"),
        (1e3 * POINTS, "median distance of .*e.03 m.*check up, heading and at"),
        (POINTS.reshape(-1, 3)[:100], "at least 200 are needed"),
    ],
)
def test_points_of_no_use(points, message):
    with pytest.raises(InputError, match=message):
        terrain_from_points(points, **TOLD)


@pytest.mark.parametrize(
    ("told", "message"),
    [
        ({"up": [0.0, 0.0, 0.0]}, "up: .* has no direction"),
        ({"up": [0.0, np.nan, 0.0]}, "up: value nan"),
        ({"heading": TOLD["up"]}, "heading: .* points along up"),
        ({"heading": [1.0, 0.0]}, "heading: expected shape"),
        ({"up": -TOLD["up"]}, "camera's own frame, whose origin is -"),
        ({"up": -TOLD["up"], "at": None}, "lie in the strip that is walked on"),
        ({"heading": -TOLD["heading"]}, "lie in the strip that is walked on"),
        ({"at": [0.0, 0.0, 0.0]}, "camera's own frame"),
        ({"std": -0.001}, "std: .* at least 0"),
        ({"std": 3.0}, "std: .* at most 0.05"),
    ],
)
def test_what_is_told_wrongly(told, message):
    with pytest.raises(InputError, match=message):
        terrain_from_points(POINTS, **{**TOLD, **told})


def test_a_slope_that_no_foot_stands_on_is_no_ground():
    steep = Scene(Terrain.level(6), (), (), KINECT_2, 1, tilt=math.radians(25.0))
    with pytest.raises(InputError, match="no ground is seen"):
        terrain_from_points(steep.points(), **steep.told())


def test_a_wall_right_ahead_is_no_ground():
    from ggo_factors import Obstacle

    near = Scene(Terrain.level(6).with_boxes(Obstacle(0.45, 2.0, 2.5)), (), (), KINECT_2, 1)
    with pytest.raises(InputError, match="no ground is seen"):
        terrain_from_points(near.points(), **near.told())


def test_holes_infinities_and_doubles_are_read_alike():
    one = terrain_from_points(POINTS, **TOLD)
    spoilt = np.where(np.isnan(POINTS), np.inf, POINTS)
    assert terrain_from_points(spoilt, **TOLD) == one
    assert terrain_from_points(POINTS.reshape(-1, 3).tolist(), **TOLD).rises == pytest.approx(one.rises, abs=1e-6)


def test_a_million_points_and_how_long_a_frame_takes():
    million = np.tile(POINTS.reshape(-1, 3), (5, 1))[:1_000_000]
    assert len(million) == 1_000_000
    assert terrain_from_points(million, **TOLD).rises == pytest.approx([0.1], abs=0.003)
    spent = []
    for _ in range(5):
        began = time.process_time()
        terrain_from_points(POINTS, **TOLD)
        spent.append(time.process_time() - began)
    assert POINTS.size / 3 > 200_000
    # At most 0.1 s on one core; the suite runs on machines that are shared.
    assert min(spent) < 0.2


def test_a_sighting_at_a_prompt_is_a_line():
    assert len(repr(Sighting(POINTS, **TOLD)).splitlines()) == 1
    with pytest.raises(InputError, match="points: there are none"):
        Sighting(np.empty((0, 3)), [0, 0, 1], [1, 0, 0])
