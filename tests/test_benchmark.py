"""The benchmark of solving runs and says what it should; how long anything takes is not asserted."""

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

TOOL = Path(__file__).parent.parent / "tools" / "benchmark.py"


def solving(*options):
    command = [sys.executable, "-W", "error", str(TOOL), "solving", "--repeats", "1", *options]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_rivals_reach_the_same_optimum(tmp_path):
    ran = solving("--frames", "21", "--tasks", "stride,obstacle-3,stairs-down", "--out", str(tmp_path))
    assert ran.returncode == 0, ran.stderr
    result = json.loads((tmp_path / "benchmark.json").read_text())
    assert result["format_version"] == 1
    assert "gtsam" in result["machine"]["software"]
    assert (tmp_path / "benchmark.png").read_bytes().startswith(b"\x89PNG")
    solvers = {"ggo_factors", "textbook", "SciPy"} | ({"pyceres"} if find_spec("pyceres") else set())
    for task in ("stride", "obstacle-3", "stairs-down"):
        rows = {row["solver"]: row for row in result["rows"] if row["task"] == task}
        assert set(rows) == solvers
        ours = rows["ggo_factors"]
        assert ours["ratio"] == 1.0
        for row in rows.values():
            assert row["ok"], row
            assert row["objective"] == pytest.approx(ours["objective"], rel=1e-3)
            assert row["residual_cost"] == pytest.approx(ours["residual_cost"], rel=1e-2)
            assert (row["clearance_m"] is None) == (task == "stride")
    assert "pyceres" in ran.stdout


def test_a_slow_rival_goes_no_further(tmp_path):
    options = ("--frames", "11,21", "--tasks", "stride", "--rivals", "textbook", "--budget", "0.000001")
    ran = solving(*options, "--out", str(tmp_path))
    assert ran.returncode == 0, ran.stderr
    result = json.loads((tmp_path / "benchmark.json").read_text())
    assert [(row["frames"], row["solver"]) for row in result["rows"]] == [
        (11, "ggo_factors"),
        (11, "textbook"),
        (21, "ggo_factors"),
    ]
    assert result["notes"] == ["textbook goes no further than 11 frames at stride: a call took more than 1e-06 s"]
    assert "stopped" in ran.stdout


@pytest.mark.parametrize(("option", "value"), [("--frames", "1"), ("--frames", "ten"), ("--tasks", "hop")])
def test_bad_options_are_refused(option, value):
    ran = solving(option, value)
    assert ran.returncode == 2
    assert option in ran.stderr
