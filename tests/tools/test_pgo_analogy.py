"""The tutorial `tools/pgo_analogy.py`: what it claims, held against its numbers and against closed forms."""

from __future__ import annotations

import gtsam
import numpy as np
import pgo_analogy as tool
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

from ggo_factors.factors import frame_key
from ggo_factors.graph.optimizer import graph_of


@pytest.fixture(scope="module")
def numbers() -> dict[str, dict[str, float]]:
    return tool.run(Figure(figsize=(18.0, 12.5)))


def test_the_closure_removes_the_drift(numbers):
    a = numbers["a"]
    assert a["end_before"] > 1.0
    assert a["end_after"] < 0.002
    assert a["mean_after"] < a["mean_before"] / 5.0


def test_a_displaced_closure_shifts_every_odometry_edge_alike(numbers):
    b = numbers["b"]
    assert b["miss"] < 0.002
    assert 1.0 <= b["ratio_drift"] < 1.001
    assert 1.0 <= b["ratio"] < 1.001
    assert b["ratio_turn"] > 1.2  # said, and not hidden


def test_a_displaced_foothold_bends_every_residual_edge_alike(numbers):
    c = numbers["c"]
    assert c["landing"] == pytest.approx(tool.FOOTHOLD_DISPLACED[0], abs=2e-3)
    assert c["ratio"] == pytest.approx(1.0, abs=1e-6)
    assert c["ratio_kneed_later"] == pytest.approx(1.0, abs=1e-6)
    assert c["ratio_kneed"] > 1.5
    assert 0.05 < c["error_deg"] < 0.2


def test_every_edge_of_the_graphs_is_drawn_in_its_family(numbers):
    d = numbers["d"]
    assert [d[f"pose graph, {f}"] for f in tool.FAMILIES] == [1, 16, 1, 0, 0]
    assert [d[f"gait graph, every frame, {f}"] for f in tool.FAMILIES] == [1, 16, 1, 2, 16]
    assert [d[f"gait graph, keyframes, {f}"] for f in tool.FAMILIES] == [1, 3, 1, 2, 3]


def test_uncertainty_is_small_at_anchor_and_closure_and_largest_between(numbers):
    e = numbers["e"]
    assert e["pose_end"] < 0.1
    assert e["foot_end"] < 0.2
    assert 0.3 < e["pose_peak"] < 0.7
    assert 0.3 < e["foot_peak"] < 0.7
    assert e["angles_end"] > 0.95  # said, and not hidden


def test_the_marginals_of_a_gait_are_a_bridge():
    edges = tool.gait_graph(tool.BASE, tool.FOOTHOLD_DISPLACED)
    values = tool.solved(edges, tool.frames_as_values(tool.BASE))
    marginals = gtsam.Marginals(graph_of(factor for _, factor in edges), values)
    last = len(tool.BASE) - 1
    jacobian = tool.BASE.legs(None).endpoint_jacobian(values.atVector(frame_key(last)))
    inner = np.linalg.inv(last * jacobian @ jacobian.T + np.eye(2) / tool.END_GAIN)
    for n in (1, 20, last):
        wanted = n * np.eye(4) - n * n * jacobian.T @ inner @ jacobian
        np.testing.assert_allclose(marginals.marginalCovariance(frame_key(n)), wanted, atol=1e-8)


def test_keyframes_give_the_answer_of_the_full_graph(numbers):
    f = numbers["f"]
    assert f["apart, longer stride"] < 1e-6
    assert f["apart, over a box"] < 1e-5
    assert f["variables, longer stride"] == 3
    assert f["variables, over a box"] < 12


def test_without_residual_edges_there_is_no_gait(numbers):
    g = numbers["g"]
    assert g["refused"] == 1.0
    assert g["frames_still"] == len(tool.BASE) - 1
    assert g["jump"] > 0.09
    assert g["jump"] > 3.0 * g["longest"]


def test_it_prints_its_tables_and_saves_one_figure(tmp_path):
    ran = CliRunner().invoke(tool.main, ["--out", str(tmp_path / "new")])
    assert ran.exit_code == 0, ran.output
    assert all(f"({letter}) " in ran.output for letter in "abcdefg")
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["pgo_analogy.png"]
    assert (tmp_path / "new" / "pgo_analogy.png").read_bytes().startswith(b"\x89PNG")


def test_the_style_variable_is_estimated_with_the_frames(numbers):
    i = numbers["i"]
    assert i["with"] < 0.25 * i["without"]
    assert i["c0"] == pytest.approx(1.2, abs=0.15)
    assert i["c1"] == pytest.approx(-0.8, abs=0.15)
