"""Thighs, shanks and sole against obstacles and stairs: by hand, by shapely, and by a dense check of its own."""

from __future__ import annotations

import math
from dataclasses import replace

import independent
import numpy as np
import pytest
import shapely
from bare_bones import pointed
from hypothesis import given, settings
from hypothesis import strategies as st

import ggo_factors as ggo
from ggo_factors.check.leg_collision import FOOT_SPARE, SEGMENTS, leg_clearance, leg_faults

BASE = ggo.paper_base_gait()
FOOT = ggo.Foot(0.08, 0.05, 0.15)
POINT = ggo.LegModel(0.39, 0.39, thigh_radius=0.05, shank_radius=0.05)
LEGS = replace(POINT, foot=FOOT)
UPRIGHT = np.zeros((1, 4))
SIZES = {"foot": (0.08, 0.05, 0.15), "radii": (0.05, 0.05)}

numbers = st.floats(-0.6, 0.6)


def at_once(clear):
    """The clearances of a single frame and a single block, by segment."""
    assert clear.shape == (1, 5, 1)
    return dict(zip(SEGMENTS, clear[0, :, 0], strict=True))


def faults_of(model, frames, ground):
    return leg_faults(model, model.joints(frames), np.arange(float(len(frames))), (), ground)


@pytest.mark.parametrize(
    ("box", "shank", "thigh", "sole"),
    [
        # Both legs upright over x = 0: ankles 0.08 m, knees 0.47 m over the sole, which reaches from -0.05 to 0.15 m.
        ((0.20, 0.30, 0.20), 0.20 - 0.05, math.hypot(0.20, 0.27) - 0.05, 0.05),
        ((0.03, 0.30, 0.20), 0.03 - 0.05, math.hypot(0.03, 0.27) - 0.05, -0.12),
        ((-0.30, -0.02, 0.05), math.hypot(0.02, 0.03) - 0.05, math.hypot(0.02, 0.42) - 0.05, -0.03),
        ((-0.01, 0.04, 0.50), -0.01 - 0.05, -0.01 - 0.05, -0.025),
    ],
)
def test_upright_legs_worked_by_hand(box, shank, thigh, sole):
    clear = at_once(leg_clearance(LEGS, UPRIGHT, [ggo.Obstacle(*box)]))
    assert clear["support shank"] == clear["swing shank"] == pytest.approx(shank, abs=1e-12)
    assert clear["support thigh"] == clear["swing thigh"] == pytest.approx(thigh, abs=1e-12)
    assert clear["swing sole"] == pytest.approx(sole, abs=1e-12)


@settings(max_examples=300)
@given(frame=st.tuples(*[st.floats(-1.5, 1.5)] * 4), start=numbers, width=st.floats(1e-3, 0.5), top=st.floats(0.0, 0.7))
def test_any_pose_against_shapely(frame, start, width, top):
    model = ggo.LegModel(0.39, 0.42, thigh_radius=0.06, shank_radius=0.05, foot=FOOT)
    clear = at_once(leg_clearance(model, [frame], [ggo.Obstacle(start, start + width, top)]))
    block = shapely.box(start, -9.0, start + width, top)
    points = model.joints(np.array(frame)) + np.array([0.0, 0.08])
    lines = [*(points[[k, k + 1]] for k in range(4)), points[4] + np.array([[-0.05, -0.08], [0.15, -0.08]])]
    for line, radius, segment in zip(lines, (0.05, 0.06, 0.06, 0.05, 0.0), SEGMENTS, strict=True):
        outside = shapely.LineString(line).distance(block)
        if outside > 0.0:
            assert clear[segment] + radius == pytest.approx(outside, abs=1e-12)
            continue
        along = shapely.points(line[0] + np.linspace(0.0, 1.0, 500)[:, None] * (line[1] - line[0]))
        depth = np.where(shapely.contains(block, along), shapely.distance(block.exterior, along), 0.0).max()
        assert -clear[segment] - radius == pytest.approx(depth, abs=2e-3)


@pytest.mark.parametrize(
    ("model", "bodies"), [(replace(POINT, shank_radius=0.0), 2), (replace(POINT, thigh_radius=0.0), 2)]
)
def test_a_segment_without_radius_is_no_body(model, bodies):
    clear = leg_clearance(replace(model, bones="points"), BASE.frames, [ggo.Obstacle(-0.5, 0.5, 0.7)])
    assert np.isfinite(clear[:, :4]).all(axis=0).sum() == bodies
    assert np.isfinite(clear[:, 4]).all()


def test_legs_without_radius_are_judged_by_p_alone():
    report = ggo.verify(
        BASE, replace(LEGS, thigh_radius=0.0, shank_radius=0.0, bones="points"), obstacles=[ggo.Obstacle(0.2, 0.3, 0.3)]
    )
    assert report.leg_clearance == math.inf
    assert [violation.kind for violation in report.violations] == ["obstacle"]


def test_verify_names_what_hits_what():
    # The paper's obstacle 5: P passes over it, the supporting shank leans into it before the landing.
    box = ggo.Obstacle(0.10, 0.15, 0.175)
    gait = ggo.step_over(pointed(BASE), [box], foothold=(0.39, 0.0), smoothness=0).gait
    report = ggo.verify(gait, POINT, obstacles=[box])
    (violation,) = report.violations
    assert (violation.kind, violation.note, violation.limit, violation.unit) == (
        "support shank in obstacle",
        str(box),
        0.0,
        "m",
    )
    assert violation.frame == 50
    assert violation.value == report.leg_clearance == pytest.approx(-0.064, abs=1e-3)


def test_the_sole_in_the_air_is_left_to_p_and_told_once():
    box = ggo.Obstacle(0.20, 0.22, 0.03)
    report = ggo.verify(BASE, LEGS, obstacles=[box])
    assert [violation.kind for violation in report.violations] == ["obstacle"]
    assert report.leg_clearance > 0.0 > report.clearance
    assert leg_clearance(LEGS, BASE.frames, [box])[:, 4].min() < 0.0


@pytest.mark.parametrize("foot", [ggo.Foot(), FOOT])
@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
def test_a_shank_does_not_hit_the_ground_that_its_foot_stands_on(foot, procedure):
    walk = procedure(replace(BASE, model=replace(POINT, foot=foot, shank_radius=0.0, thigh_radius=0.0)))
    for gait, step in zip(walk.gaits, walk.plan, strict=True):
        least, faults = faults_of(replace(POINT, foot=foot), gait.frames, step.ground)
        assert not faults
        assert least == pytest.approx(max(FOOT_SPARE, foot.ankle_height - 0.05), abs=1e-3)


def test_where_the_foot_is_no_higher_than_the_shank_is_thick_the_riser_beside_it_still_counts():
    riser = ggo.Ground((0.04,), (0.0, 0.1))
    least, faults = faults_of(POINT, UPRIGHT, riser)
    assert [fault.kind for fault in faults] == ["support shank in stairs", "swing shank in stairs"]
    assert least == pytest.approx(0.04 - 0.05)
    behind = ggo.Ground((-0.04,), (-0.1, 0.0))  # the tread ends, nothing stands up
    assert faults_of(POINT, UPRIGHT, behind) == (pytest.approx(FOOT_SPARE), [])


def test_a_lying_shank_is_not_cut_away():
    # Both thighs upright, the swinging shank level behind the knee, 0.39 m over the ground: a box under its middle.
    frame = np.array([[0.0, 0.0, 0.0, math.pi / 2]])
    clear = at_once(leg_clearance(POINT, frame, [ggo.Obstacle(-0.20, -0.15, 0.36)]))
    assert clear["swing shank"] == pytest.approx(0.39 - 0.36 - 0.05)


@pytest.mark.parametrize("ahead", [1.0, -1.0])
def test_treads_are_as_deep_as_the_ground_beside_them(ahead):
    edges, heights = np.array([-0.3, 0.3, 0.6]), (0.2, 0.0, 0.1, 0.3)
    ground = ggo.Ground(edges, heights) if ahead > 0.0 else ggo.Ground(-edges[::-1], heights[::-1])
    clear = leg_clearance(LEGS, [[0.0, 0.0, 1.2 * ahead, 0.0]], (), ground)[:, :, :: int(ahead)]
    assert clear.shape == (1, 5, 4)
    # The stretched swinging leg ends at (0.73, 0.58): 0.58 over the floor and all that lies on it, 0.28 over the top.
    ankle = 0.08 + 0.78 * (1.0 - math.cos(1.2))
    np.testing.assert_allclose(clear[0, 3, 1:], ankle - np.array([0.0, 0.1, 0.3]) - 0.05, atol=1e-12)


BOXES = st.tuples(st.floats(-0.45, 0.45), st.floats(0.005, 0.15), st.floats(0.0, 0.3))


@settings(max_examples=40, deadline=None)
@given(boxes=st.lists(BOXES, min_size=1, max_size=2), turn=st.floats(-0.2, 0.2))
def test_report_against_an_independent_dense_check(boxes, turn):
    frames = BASE.frames + turn * np.sin(np.linspace(0.0, np.pi, 51))[:, None]
    obstacles = [ggo.Obstacle(start, start + width, height) for start, width, height in boxes]
    ends = [(box.x_start, box.x_end, box.height) for box in obstacles]
    report = ggo.verify(replace(BASE, frames=frames), LEGS, obstacles=obstacles)
    sole = leg_clearance(LEGS, independent.densely(frames), obstacles)[:, 4].min()
    legs_too, sole_too = independent.leg_clearance(frames, ends, **SIZES)
    # Shapely knows no depth: an axis that lies in a box is 0 away from it.
    assert max(report.leg_clearance, -0.05) == pytest.approx(legs_too, abs=5e-4)
    assert max(sole, 0.0) == pytest.approx(sole_too, abs=1e-9)


@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
def test_stairs_against_an_independent_dense_check(procedure):
    walk = procedure(replace(BASE, model=LEGS))
    for gait, step, report in zip(walk.gaits, walk.plan, walk.verify(), strict=True):
        boxes = [(box.x_start, box.x_end, box.height) for box in step.obstacles]
        other, _ = independent.leg_clearance(gait.frames, boxes, step.ground.edges, step.ground.heights, **SIZES)
        assert report.leg_clearance == pytest.approx(other, abs=5e-4)


def test_radii_are_checked_and_stand_in_the_file_where_there_are_any(tmp_path):
    with pytest.raises(ggo.InputError, match=r"shank_radius: -0\.01 m must be at least 0 m"):
        ggo.LegModel(0.39, 0.39, shank_radius=-0.01)
    with pytest.raises(ggo.InputError, match=r"thigh_radius: 5 m must be at most 2 m"):
        ggo.LegModel(0.39, 0.39, thigh_radius=5)
    path = tmp_path / "gait.csv"
    BASE.save(path)
    assert "radius" not in path.read_text()
    replace(BASE, model=replace(LEGS, thigh_radius=0.0)).save(path)
    assert "# shank_radius: 0.05 m\n" in path.read_text()
    assert "thigh_radius" not in path.read_text()
    assert ggo.load_gait(path).model == replace(LEGS, thigh_radius=0.0)
