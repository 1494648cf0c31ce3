"""Bones as lines: never in a box, refused only where no motion passes, files and flags that name them."""

from dataclasses import replace

import numpy as np
import pytest
from bare_bones import axis_in, deepest, joints, pointed, random_boxes, way_past

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.motion.gait import PAPER_MODEL

BASE = ggo.paper_base_gait()
FOOTHOLD = (0.39, 0.0)
SHIN = ggo.Obstacle(-0.33, -0.29, 0.175)
"""The paper's obstacle 5: in the swinging shank at the start."""


def test_random_boxes_are_passed_by_all_bones_or_truly_refused():
    bones_in, refused = 0, []
    for box in random_boxes(FOOTHOLD[0], 25, seed=5):
        boxes = [ggo.Obstacle(*box)]
        bones_in += axis_in(ggo.step_over(pointed(BASE), boxes, foothold=FOOTHOLD).gait, box) > 0.0
        try:
            solution = ggo.step_over(BASE, boxes, foothold=FOOTHOLD)
        except ggo.InfeasibleGaitError:
            refused.append(box)
            continue
        assert axis_in(solution.gait, box) == 0.0, box
        assert solution.report.axis_clearance > 0.0
    assert bones_in >= 3  # of the paper's model, or nothing would be tested
    assert [box for box in refused if way_past(BASE.frames[0], box, FOOTHOLD)] == []


@pytest.mark.parametrize("box", [(0.33, 0.38, 0.17), (0.37, 0.388, 0.10), (0.30, 0.35, 0.18), (0.26, 0.389, 0.15)])
def test_boxes_right_before_the_foothold(box):
    solution = ggo.step_over(BASE, [ggo.Obstacle(*box)], foothold=FOOTHOLD)
    assert axis_in(solution.gait, box) == 0.0
    assert solution.ok


def test_a_bone_in_the_box_at_the_start_is_refused_by_name_and_points_are_not():
    assert deepest(joints(BASE.frames[:1]), (-0.33, -0.29, 0.175)) > 0.0
    with pytest.raises(ggo.InfeasibleGaitError) as caught:
        ggo.step_over(BASE, [SHIN], foothold=FOOTHOLD)
    (fault,) = caught.value.violations
    assert (fault.kind, fault.frame) == ("swing shank in obstacle", 0.0)
    report = ggo.step_over(pointed(BASE), [SHIN], foothold=FOOTHOLD).report
    assert report.ok
    assert report.axis_clearance < 0.0
    assert any("bones are points" in note for note in report.notes)


def test_a_bone_where_the_walker_is_about_to_be_is_refused_too():
    # A thin post between where the swinging shank is now, and where it is a frame later, lower at that place.
    (now, soon), (left, right) = joints(BASE.frames[:2])[:, 3:], (-0.37, -0.28)
    places = np.linspace(left, right, 50)
    heights = [np.interp(places, *each[np.argsort(each[:, 0])].T) for each in (now, soon)]
    lower = int((heights[0] - heights[1]).argmax())
    post = (places[lower] - 1e-5, places[lower] + 1e-5, (heights[0] + heights[1])[lower] / 2.0)
    inside = [deepest(joints(BASE.frames[n : n + 1]), post) > 0.0 for n in (0, 1)]
    assert inside == [False, True]
    with pytest.raises(ggo.InfeasibleGaitError) as caught:
        ggo.step_over(BASE, [ggo.Obstacle(*post)], foothold=FOOTHOLD)
    (fault,) = caught.value.violations
    assert (fault.kind, fault.frame) == ("swing shank in obstacle", 1.0)


@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
@pytest.mark.parametrize("riser", [0.10, 0.17])
def test_stairs_are_walked_with_bones(procedure, riser):
    walk = procedure(BASE, riser, steps=3)
    assert min(report.axis_clearance for report in walk.verify()) > 0.0


def test_level_walking_and_low_boxes_cost_what_points_cost():
    for boxes in ([], [ggo.Obstacle(0.15, 0.20, 0.01)]):
        lines, points = (ggo.step_over(base, boxes, foothold=FOOTHOLD) for base in (BASE, pointed(BASE)))
        assert (lines.rounds, lines.iterations, lines.keyframes) == (points.rounds, points.iterations, points.keyframes)
        np.testing.assert_array_equal(lines.gait.frames, points.gait.frames)


@pytest.mark.parametrize("bones", ["point", "", None, 1])
def test_other_bones_are_refused(bones):
    with pytest.raises(ggo.InputError, match="'lines' or 'points'"):
        ggo.LegModel(0.39, 0.39, bones=bones)


def test_files_say_which(tmp_path):
    path = tmp_path / "gait.csv"
    for base in (BASE, pointed(BASE)):
        base.save(path)
        assert ggo.load_gait(path).model == base.model
        walk = ggo.walk(base, [ggo.Step(FOOTHOLD)])
        walk.save(tmp_path / "walk.csv")
        assert ggo.load_walk(tmp_path / "walk.csv").model == base.model
    text = (tmp_path / "walk.csv").read_text()
    (tmp_path / "walk.csv").write_text(text.replace("# bones: points\n", ""))
    assert ggo.load_walk(tmp_path / "walk.csv").model.bones == "points"
    path.write_text(path.read_text().replace("# bones: points\n", ""))
    assert ggo.load_gait(path).model == PAPER_MODEL
    path.write_text(path.read_text().replace("# thigh:", "# bones: wires\n# thigh:"))
    with pytest.raises(ggo.InputError, match=r"gait\.csv: header: bones: 'wires'"):
        ggo.load_gait(path)


def test_the_flag(capsys, tmp_path):
    asked = ["step-over", "paper", "--foothold", "0.39,0", "--obstacle", "-0.33,-0.29,0.175"]
    path = str(tmp_path / "walk.csv")
    assert main(asked) == 3
    assert "swing shank in obstacle" in capsys.readouterr().err
    assert main([*asked, "--bones", "points", "-o", path]) == 0
    capsys.readouterr()
    assert main(["verify", path]) == 0
    assert "bones are" in capsys.readouterr().out
    assert main(["verify", path, "--bones", "lines"]) == 3


def test_bodies_on_point_feet_have_bones_down_to_the_ankle():
    # The capsule of a shank begins 60 mm above a point foot: a low box beside the ankle meets the bone alone.
    legs, low = replace(PAPER_MODEL, thigh_radius=0.05, shank_radius=0.05), (0.001, 0.002, 0.008)
    for lean, hit in ((0.3, False), (-0.3, True)):
        frames = np.tile([lean, 0.0, 0.8, 0.0], (2, 1))
        assert (deepest(joints(frames), low) > 0.0) == hit
        for bones, told in (("lines", hit), ("points", False)):
            report = ggo.verify(ggo.Gait(frames, 0.1), replace(legs, bones=bones), obstacles=[ggo.Obstacle(*low)])
            assert ("support shank in obstacle" in [fault.kind for fault in report.violations]) == told
