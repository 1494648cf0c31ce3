"""Terrains seen by simulated cameras: a sample of the scenes that the campaign looks at, and single ones."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from depth_camera import KINECT_2
from seen_scenes import Scene, frames_of, judge, random_scene

from ggo_factors import (
    Gap,
    InputError,
    Obstacle,
    Sighting,
    Terrain,
    load_terrain,
    terrain_from_points,
    terrain_from_sightings,
)

SEEDS = range(16)


@cache
def judged(seed):
    scene = random_scene(seed)
    return judge(scene, terrain_from_points(scene.points(), **scene.told()))


def a_scene(terrain, depths=(), **camera):
    return Scene(terrain, depths, (), replace(KINECT_2, **camera), 3)


def seen(scene, **changes):
    return terrain_from_points(scene.points(), **{**scene.told(), **changes})


def holds(terrain, x):
    """Whether a foot may stand at x."""
    return x <= terrain.x_end and not any(g.x_start <= x <= g.x_end for g in (*terrain.pits, *terrain.boxes))


@pytest.mark.parametrize("seed", SEEDS)
def test_no_pit_is_ground_and_no_near_riser_is_missed(seed):
    found = judged(seed)
    assert not found.fallen
    assert not [edge for edge in found.edges if edge.off is None and edge.x < 1.5]


def test_edges_and_risers_are_near_the_true_ones_and_within_what_is_stated():
    edges = [edge for seed in SEEDS for edge in judged(seed).edges]
    heights = [height for seed in SEEDS for height in judged(seed).heights]
    assert len(edges) > 30
    assert np.mean([edge.off is not None and abs(edge.off) < 0.02 for edge in edges]) >= 0.95
    assert np.mean([abs(edge.rise_off) < 0.01 for edge in edges if edge.rise_off is not None]) >= 0.95
    inside = [abs(edge.off) < 1.96 * edge.std for edge in edges if edge.off is not None]
    inside += [abs(off) < 1.96 * std for off, std in heights]
    assert np.mean(inside) >= 0.9


def test_stairs_up_and_a_box_by_their_numbers():
    ground = Terrain.level(0.9) + Terrain.stairs(2, riser=0.15, tread=0.3) + Terrain.level(5)
    terrain = seen(a_scene(ground.with_boxes(Obstacle(1.8, 1.9, 0.1))))
    assert [s.x_start for s in terrain.surfaces[1:]] == pytest.approx([0.9, 1.2], abs=0.004)
    assert terrain.rises == pytest.approx([0.15, 0.15], abs=0.002)
    (box,) = terrain.boxes
    assert (box.x_start, box.x_end, box.height) == pytest.approx((1.8, 1.9, 0.1), abs=0.012)
    assert 0.003 < box.edge_std < 0.012
    assert 0.003 < box.height_std < 0.006


def test_what_a_box_hides_is_unknown_and_no_foothold():
    box = Obstacle(1.0, 1.2, 0.25)
    scene = a_scene(Terrain.level(6).with_boxes(box))
    terrain = seen(scene)
    (eye_x, eye_y, _) = scene.camera.at
    shadow = box.x_end + box.height * (box.x_end - eye_x) / (eye_y - box.height)
    hidden = next(pit for pit in terrain.pits if pit.unknown and pit.x_end > box.x_end)
    assert (hidden.x_start, hidden.x_end) == pytest.approx((box.x_end, shadow), abs=0.02)
    assert not holds(terrain, (box.x_end + shadow) / 2)
    assert holds(terrain, shadow + 0.05)
    assert holds(terrain, 0.9)


def test_ground_between_the_foot_and_the_first_point_is_unknown():
    scene = a_scene(Terrain.level(6), pitch=math.radians(30))
    near = scene.camera.at[0] + scene.camera.at[1] / math.tan(math.radians(30) + math.atan(212 / 365.5))
    terrain = seen(scene)
    assert terrain.pits[0].unknown
    assert terrain.pits[0].x_end == pytest.approx(near, abs=0.02)
    assert holds(terrain, 0.1)
    assert not holds(terrain, near - 0.05)


def test_a_pit_without_a_bottom_is_a_pit_and_a_dark_patch_is_unknown():
    pit = Gap(1.1, 1.3)
    terrain = seen(a_scene(Terrain.level(6).with_pits(pit), (1.0,)))
    found = [p for p in terrain.pits if p.x_end > 1.0]
    assert [p.unknown for p in found] == [False]
    assert (found[0].x_start, found[0].x_end) == pytest.approx((1.1, 1.3), abs=0.012)
    scene = a_scene(Terrain.level(6))
    points = scene.points()
    x = (points.reshape(-1, 3) - scene.camera.place([0, 0, 0])) @ scene.camera.into([1, 0, 0])
    points.reshape(-1, 3)[(x > 1.1) & (x < 1.3)] = np.nan
    terrain = terrain_from_points(points, **scene.told())
    found = [p for p in terrain.pits if p.x_end > 1.0]
    assert [p.unknown for p in found] == [True]
    assert (found[0].x_start, found[0].x_end) == pytest.approx((1.1, 1.3), abs=0.02)
    assert len(terrain.surfaces) == 1


def test_a_ramp_is_told_by_its_slope_and_its_ends():
    slope = math.radians(8.0)
    terrain = seen(a_scene(Terrain.level(1.0) + Terrain.ramp(0.9, slope) + Terrain.level(4)))
    assert [s.slope for s in terrain.surfaces] == pytest.approx([0.0, slope, 0.0], abs=math.radians(0.3))
    assert [s.x_start for s in terrain.surfaces[1:]] == pytest.approx([1.0, 1.9], abs=0.015)


def test_a_wall_ends_the_terrain():
    terrain = seen(a_scene(Terrain.level(6).with_boxes(Obstacle(1.5, 3.0, 2.5))))
    assert terrain.x_end == pytest.approx(1.5, abs=0.02)
    (wall,) = terrain.boxes
    assert wall.x_start == pytest.approx(1.5, abs=0.01)
    assert wall.height > 0.5


def test_a_drop_ends_the_terrain():
    terrain = seen(a_scene(Terrain.level(1.2) + Terrain.level(5, rise=-0.6)))
    assert terrain.x_end == pytest.approx(1.2, abs=0.012)


def test_a_floor_that_is_told_a_little_tilted_is_level():
    scene = a_scene(Terrain.level(1.0) + Terrain.level(5, rise=0.1))
    one, other = seen(scene), seen(replace(scene, tilt=math.radians(1.0)))
    assert [s.slope for s in other.surfaces] == [0.0, 0.0]
    assert other.rises == pytest.approx(one.rises, abs=0.003)
    steep = seen(replace(scene, tilt=math.radians(4.0)))
    assert steep.surfaces[-1].slope == pytest.approx(math.radians(4.0), abs=math.radians(0.2))


def test_a_camera_mounted_upside_down_sees_the_same():
    ground = Terrain.level(1.0) + Terrain.level(5, rise=0.1)
    one, other = seen(a_scene(ground)), seen(a_scene(ground, roll=math.pi))
    assert other.rises == pytest.approx(one.rises, abs=0.002)
    assert other.surfaces[1].x_start == pytest.approx(one.surfaces[1].x_start, abs=0.004)


def test_axes_of_the_points_and_their_order_do_not_matter():
    scene = a_scene(Terrain.level(1.0) + Terrain.level(5, rise=0.1))
    points, told = scene.points().astype(float), scene.told()
    turn = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    shuffled = np.random.default_rng(0).permutation(points.reshape(-1, 3)) @ turn.T
    other = terrain_from_points(shuffled, **{name: turn @ value for name, value in told.items()})
    one = terrain_from_points(points, **told)
    assert len(one.surfaces) == len(other.surfaces) == 2
    for a, b in zip(one.surfaces, other.surfaces, strict=True):
        assert (a.x_start, a.height, a.edge_std) == pytest.approx((b.x_start, b.height, b.edge_std), abs=1e-6)


def test_without_at_the_origin_is_under_the_camera_on_the_ground():
    scene = a_scene(Terrain.level(1.0) + Terrain.level(5, rise=0.1))
    one, other = seen(scene), seen(scene, at=None)
    assert other.surfaces[0].height == pytest.approx(0.0, abs=0.002)
    assert other.surfaces[1].x_start == pytest.approx(one.surfaces[1].x_start - scene.camera.at[0], abs=0.004)
    assert other.rises == pytest.approx(one.rises, abs=0.002)


def test_what_the_points_have_in_common_is_in_every_standard_deviation():
    scene = a_scene(Terrain.level(1.0) + Terrain.level(5, rise=0.1))
    sure, unsure = seen(scene, std=0.0), seen(scene, std=0.02)
    for a, b in zip(sure.surfaces[1:], unsure.surfaces[1:], strict=True):
        assert b.edge_std == pytest.approx(math.hypot(a.edge_std, 0.02))
        assert b.height_std == pytest.approx(math.hypot(a.height_std, 0.02))
    assert sure.surfaces[1].edge_std < 0.004


def test_frames_that_disagree_are_moved_to_agree_and_the_estimate_tightens():
    common = 0.012
    ground = Terrain.level(0.9) + Terrain.stairs(2, riser=0.12, tread=0.32) + Terrain.level(5)
    scene = a_scene(ground.with_boxes(Obstacle(2.1, 2.2, 0.1)))
    frames = frames_of(scene, [0.0, 0.1, 0.2, 0.3], common=common)
    sightings = [Sighting(frame.points(), **frame.told()) for frame in frames]
    alone = [judge(frames[0], terrain_from_sightings([one], std=common)) for one in sightings]
    fused = terrain_from_sightings(sightings, std=common)
    together = judge(frames[0], fused)
    assert len(together.edges) == 4
    assert all(edge.off is not None for edge in together.edges)
    stated = [np.mean([edge.std for edge in found.edges]) for found in (*alone, together)]
    assert stated[-1] < 0.6 * min(stated[:-1])

    def worst(found):
        return max(abs(edge.off) for edge in found.edges)

    # The mean of four errors, not one of them.
    mean = abs(np.mean([frame.offset[0] for frame in frames]))
    assert worst(together) == pytest.approx(mean, abs=0.006)
    assert worst(together) < max(map(worst, alone))


def test_frames_on_the_way_see_what_the_first_one_did_not():
    ground = Terrain.level(2.5) + Terrain.level(5, rise=0.1)
    frames = frames_of(a_scene(ground, pitch=math.radians(45)), [0.0, 0.5, 1.0, 1.5], common=0.003)
    sightings = [Sighting(frame.points(), **frame.told()) for frame in frames]
    fused = terrain_from_sightings(sightings)
    assert fused.x_end > terrain_from_sightings(sightings[:1]).x_end + 0.5
    assert fused.surfaces[1].x_start == pytest.approx(2.5, abs=0.012)
    with pytest.raises(InputError, match="each needs its at"):
        terrain_from_sightings([*sightings, Sighting(frames[0].points(), up=[0, -1, 0], heading=[0, 0, 1])])
    with pytest.raises(InputError, match="there are none"):
        terrain_from_sightings([])


def test_a_terrain_that_was_seen_goes_through_its_file(tmp_path):
    scene = random_scene(3)
    terrain = terrain_from_points(scene.points(), **scene.told())
    terrain.save(tmp_path / "seen.toml")
    assert load_terrain(tmp_path / "seen.toml") == terrain
