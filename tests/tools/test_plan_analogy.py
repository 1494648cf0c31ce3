"""Chapters (j) and (k) of the tutorial, `tools/plan_analogy.py`: what they claim, held against their numbers."""

from __future__ import annotations

import gtsam
import numpy as np
import plan_analogy as tool
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure


@pytest.fixture(scope="module")
def numbers() -> dict[str, dict[str, float]]:
    return tool.run(Figure(figsize=(13.0, 9.0)))


def test_elimination_finds_the_least_of_all_choices(numbers):
    assert numbers["j"]["cost"] == pytest.approx(numbers["j"]["least"])
    for found, least in (("cost", "least"), ("cost_grid", "least_grid")):
        assert numbers["k"][found] == pytest.approx(numbers["k"][least], abs=1e-6)


def test_doors_chosen_together_are_right_more_often_than_one_by_one_and_not_always(numbers):
    right = [numbers["j"][name] for name in ("nearest by odometry alone", "one by one", "all together")]
    assert right[0] < right[1] < right[2] < tool.DRIVES


def test_in_the_drive_shown_they_cost_less_and_are_nearer_to_the_truth(numbers):
    j = numbers["j"]
    assert j["error"] < j["error_single"]
    assert j["off"] < j["off_single"] / 2.0
    assert j["cost"] == pytest.approx(j["error"], rel=0.05)


def test_the_plan_arrives_where_one_by_one_ends_at_a_pit(numbers):
    k = numbers["k"]
    assert k["arrived"] == 0.0
    assert k["error_single"] > k["error"]
    assert k["expected"] == pytest.approx(k["error"], rel=0.2)
    assert k["cost"] == pytest.approx(k["expected"])
    assert k["cost"] < k["cost_grid"]
    assert k["most"] == 3.0


def test_every_choice_costs_what_its_entries_of_the_tables_sum_to():
    drive = tool.drive(tool.SHOWN)
    choice = tool.doors_of(drive)
    every = choice.every_cost()
    assert every.shape == (tool.DOORS,) * len(tool.STOPS)
    for taken in ([0, 3, 7, 15], drive.doors):
        first, *others = choice.tables
        wanted = first[taken[0]] + sum(t[a, b] for t, a, b in zip(others, taken, taken[1:], strict=False))
        assert every[tuple(taken)] == pytest.approx(wanted)
    assert choice.one_by_one()[0] == int(choice.tables[0].argmin())


def test_the_table_of_a_pair_is_the_error_of_the_pose_graph_between_them():
    """With both ends given and the motions free, the least error of a chain is that of the motions joined."""
    drive = tool.drive(3)
    first, last = tool.STOPS[:2]
    for a, b in ((drive.doors[0], drive.doors[1]), (drive.doors[0], drive.doors[1] - 1)):
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        noise = gtsam.noiseModel.Diagonal.Sigmas(tool.SPREAD)
        for n, pose in ((first, drive.stops[0][a]), (last, drive.stops[1][b])):
            graph.add(gtsam.PriorFactorPose2(n, pose, gtsam.noiseModel.Isotropic.Sigma(3, 1e-5)))
        pose = drive.stops[0][a]
        for n in range(first, last):
            graph.add(gtsam.BetweenFactorPose2(n, n + 1, drive.odometry[n], noise))
            values.insert(n, pose)
            pose = pose.compose(drive.odometry[n])
        values.insert(last, pose)
        solved = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
        assert tool.doors_of(drive).tables[1][a, b] == pytest.approx(graph.error(solved), rel=0.15)


def test_doors_stand_on_the_ring_unevenly():
    places = np.stack([tool.on_ring(turn).translation() for turn in tool.doors()])
    centre = np.mean(tool.pose_path(tool.TRUTH)[:-1], axis=0)
    np.testing.assert_allclose(np.linalg.norm(places - centre, axis=1), np.linalg.norm(centre), rtol=1e-6)
    gaps = np.diff(tool.doors())
    assert gaps.max() > 2.0 * gaps.min()


def test_it_prints_its_tables_and_saves_one_figure(tmp_path):
    ran = CliRunner().invoke(tool.main, ["--out", str(tmp_path / "new")])
    assert ran.exit_code == 0, ran.output
    assert all(f"({letter}) " in ran.output for letter in "jk")
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["plan_analogy.png"]
    assert (tmp_path / "new" / "plan_analogy.png").read_bytes().startswith(b"\x89PNG")
