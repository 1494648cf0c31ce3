"""The benchmarks run and say what they should; how long anything takes is not asserted."""

import gc
import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import benchmark
import pytest
from click.testing import CliRunner

TOOL = Path(__file__).parents[2] / "tools" / "benchmark.py"


@pytest.fixture(autouse=True, scope="module")
def _little_to_collect():
    """Benchmarks collect garbage before each call; what the tests hold besides is none, and there is much of it."""
    gc.collect()
    gc.freeze()
    yield
    gc.unfreeze()


def solving(*options):
    return CliRunner().invoke(benchmark.cli, ["solving", "--repeats", "1", *options])


@pytest.mark.parametrize(("smoothness", "tasks"), [("default", ("obstacle-3",)), ("0", ("stride",))])
def test_rivals_reach_the_same_optimum(tmp_path, smoothness, tasks):
    options = ("--frames", "21", "--tasks", ",".join(tasks), "--smoothness", smoothness)
    ran = solving(*options, "--out", str(tmp_path))
    assert ran.exit_code == 0, ran.output
    result = json.loads((tmp_path / "benchmark.json").read_text())
    assert result["format_version"] == 2
    assert f"second-order residual edges: {'the default' if smoothness == 'default' else '0'}" in result["notes"][0]
    assert "gtsam" in result["machine"]["software"]
    assert (tmp_path / "benchmark.png").read_bytes().startswith(b"\x89PNG")
    solvers = {"ggo_factors", "textbook", "SciPy"} | ({"pyceres"} if find_spec("pyceres") else set())
    for task in tasks:
        rows = {row["solver"]: row for row in result["rows"] if row["task"] == task}
        first_order = rows.pop("ours, first order", None)
        assert set(rows) == solvers
        ours = rows["ggo_factors"]
        assert ours["ratio"] == 1.0
        for row in rows.values():
            assert row["ok"], row
            # Motion alone is no minimum, other edges pull too: solvers that stop 5e-6 rad apart differ so much in it.
            assert abs(row["off"]) < 5e-5, row
            assert row["residual_cost"] == pytest.approx(ours["residual_cost"], rel=1e-3)
            assert (row["clearance_m"] is None) == (task == "stride")
            assert (row["smoothness_cost"] > 0.0) == (smoothness == "default")
        if smoothness == "default":
            # The first-order optimum is the smaller one by its own measure.
            assert first_order["residual_cost"] < ours["residual_cost"]
            assert first_order["smoothness_cost"] == first_order["smoothness"] == 0.0
        else:
            assert first_order is None
    assert "pyceres" in ran.output


def test_a_slow_rival_goes_no_further(tmp_path):
    options = ("--frames", "11,21", "--tasks", "stride", "--rivals", "textbook", "--budget", "0.000001")
    ran = solving(*options, "--out", str(tmp_path))
    assert ran.exit_code == 0, ran.output
    result = json.loads((tmp_path / "benchmark.json").read_text())
    assert [(row["frames"], row["solver"]) for row in result["rows"] if row["solver"] != "ours, first order"] == [
        (11, "ggo_factors"),
        (11, "textbook"),
        (21, "ggo_factors"),
    ]
    assert result["notes"][1:] == ["textbook goes no further than 11 frames at stride: a call took more than 1e-06 s"]
    assert "stopped" in ran.output


@pytest.mark.parametrize(
    ("option", "value"),
    [("--frames", "3"), ("--frames", "ten"), ("--tasks", "hop"), ("--smoothness", "-1"), ("--smoothness", "much")],
)
def test_bad_options_are_refused(option, value):
    ran = solving(option, value)
    assert ran.exit_code == 2
    assert option in ran.stderr


def run(tmp_path, name, *options):
    ran = CliRunner().invoke(benchmark.cli, [name, *options, "--json", str(tmp_path / "found.json")])
    assert ran.exit_code == 0, (ran.output, ran.exception)
    return json.loads((tmp_path / "found.json").read_text())


def test_importing_names_the_slowest_modules(tmp_path):
    found = run(tmp_path, "importing", "--repeats", "1")
    assert found["met"] == (found["more_s"] <= found["goal_s"])
    assert found["slowest_s"]
    assert not {"gtsam", "numpy", "matplotlib", "mcap"} & set(found["slowest_s"])


def test_sweeping_compares_workers(tmp_path):
    # As a program: its worker processes load its file too.
    options = ["sweeping", "--gaits", "4", "--repeats", "1", "--json", str(tmp_path / "found.json")]
    command = [sys.executable, "-W", "error", str(TOOL), *options]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    found = json.loads((tmp_path / "found.json").read_text())
    assert [row["workers"] for row in found["rows"]] == [1, 2]
    one, two = found["rows"]
    assert found["ratio"] == pytest.approx(one["median_s"] / two["median_s"])
    assert found["gait_ratio"] == pytest.approx(two["gait_ms"] / one["gait_ms"])
    assert two["first_s"] * 1e3 > 4 / 2 * two["gait_ms"]


def test_replanning_ends_in_the_same_gait_every_way(tmp_path):
    found = run(tmp_path, "replanning", "--replans", "1", "--frames", "21", "--repeats", "1")
    solvers = ["ours, warm start", "ours, from the base gait", "ISAM2", "full graph, warm start"]
    assert [row["solver"] for row in found["rows"]] == 5 * solvers
    verdicts = [row["ok"] for row in found["rows"]]
    assert True in verdicts
    for row in found["rows"]:
        assert row["ok"] == verdicts[4 * row["case"]], row  # alike, though none makes edges stiffer until all is well
        assert abs(row["off"]) < 1e-4, row
        assert row["iterations"] >= row["rounds"] >= 2
    assert found["summary"]["ours, warm start"]["ratio"] == 1.0


def test_balance_stands_beside_what_it_costs(tmp_path):
    found = run(tmp_path, "balance", "--boxes", "2", "--repeats", "1")
    assert [row["box"] for row in found["rows"]] == [*(f"obstacle-{n}" for n in range(1, 6)), "random-1", "random-2"]
    assert set(found["judged"]) == {"paper", "random", "all"}
    every = found["judged"]["all"]
    assert every["mean_zmp_off_mm"] == pytest.approx(sum(row["zmp_off_mm"][1] for row in found["rows"]) / 7)
    assert every["largest_mean_zmp_off_mm"] == max(row["zmp_off_mm"][1] for row in found["rows"])
    for row in found["rows"]:
        assert row["zmp_off_mm"][1] < row["zmp_off_mm"][0]
        assert row["change_deg"][1] < 1.02 * row["change_deg"][0]


def test_paces_stand_beside_one_pace_for_all(tmp_path):
    found = run(tmp_path, "pace", "--walks", "2", "--repeats", "1")
    assert [row["steps"] for row in found["rows"]] == [1, 1, 3, 3, 10, 10]
    for row in found["rows"]:
        assert row["used"] <= 1.0
        assert row["duration_s"] <= row["slowed_s"] <= 1.005 * row["one_pace_s"]
    longest = found["summary"]["10"]
    assert longest["most_used"] == max(row["used"] for row in found["rows"][4:])
    assert longest["slowed_ratio"] < longest["one_pace_ratio"]


def test_refusals_stand_beside_a_search(tmp_path):
    found = run(tmp_path, "refusals", "--boxes", "3", "--no-search")
    assert [row["kind"] for row in found["rows"]] == 3 * ["no limits", "limits", "limits, pace 1"]
    for kind, counts in found["summary"].items():
        mine = [row for row in found["rows"] if row["kind"] == kind]
        assert counts["made"] == sum(row["made"] for row in mine)
        assert counts["made"] + counts["refused"] == 3
        assert counts["untrue"] is None
    # What is made at the base gait's pace is made at any.
    for free, slowed, paced in zip(found["rows"][::3], found["rows"][1::3], found["rows"][2::3], strict=True):
        assert paced["made"] <= slowed["made"] <= free["made"]


def test_plans_stand_beside_greedy_choice(tmp_path):
    found = run(tmp_path, "planning", "--courses", "2", "--repeats", "1")
    ways = ["least change", "people", "standing to standing", "nearest to the own stride"]
    assert [(row["seed"], row["way"]) for row in found["rows"]] == [(seed, way) for seed in range(2) for way in ways]
    counts = found["summary"]
    assert [counts[way]["walked"] for way in ways] == [2, 2, 2, 1]
    for row in found["rows"]:
        if row["walked"]:
            assert row["cost"] > 0.0
            assert 6 <= row["steps"] <= 14
    assert counts["least change"]["cost_ratio"] == 1.0
    assert counts["nearest to the own stride"]["cost_ratio"] > 1.5
