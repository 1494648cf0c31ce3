"""The walks that the README shows are what it says of them."""

import draw_walks as tool
import numpy as np
from click.testing import CliRunner

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


def test_with_landing_edges_the_walk_comes_home_and_without_it_does_not():
    level = tool.supporting_knee(tool.over_one_box(BASE, box=False))
    home, bent = (tool.supporting_knee(tool.over_one_box(BASE, landing=landing)) for landing in (True, False))
    np.testing.assert_allclose(home[2:], level[2:], atol=0.5)
    assert (bent[2:] > level[2:] + 20.0).all()


def test_the_course_is_planned_from_standing_to_standing():
    plan = tool.course_plan(BASE)
    assert plan.to_standing
    assert plan.footholds[-2:] == (tool.COURSE_GOAL, tool.COURSE_GOAL)
    assert all(report.ok for report in plan.walk.verify())


def test_all_pictures_are_drawn(tmp_path):
    ran = CliRunner().invoke(tool.main, ["--out", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    assert "with landing edges: " in ran.output
    for name in ("course.png", "walk.png", "landing.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
