"""`ggo plot`: pictures in every format, of a gait and of a walk, with text that stays text."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import pytest

mpl.use("Agg")

from test_plot import BASE, two_steps

from ggo_factors import plot
from ggo_factors.cli import main
from ggo_factors.motion.terrain import Obstacle

BEGINS = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}


@pytest.fixture
def walk_file(tmp_path: Path) -> Path:
    path = tmp_path / "walk.csv"
    replace(two_steps(obstacles=(Obstacle(0.30, 0.35, 0.012, edge_std=0.005),)), first_swing="left").save(path)
    return path


def words(path: Path) -> str:
    """The text of an SVG file, without its marks."""
    return "\n".join(re.findall(r">([^<>]+)</(?:text|tspan)>", path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("ending", BEGINS)
def test_a_picture_is_written_as_its_name_ends(walk_file, ending):
    output = walk_file.with_suffix(ending)
    assert main(["plot", str(walk_file), "-o", str(output)]) == 0
    assert output.read_bytes().startswith(BEGINS[ending])
    if ending == ".pdf":
        assert b"/Type3" not in output.read_bytes()


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("stick", ["Walk of 2 steps", "left leg swings first", "legs swap", "95 % of edges and heights", "clearance"]),
        ("angles", ["Joint angles: walk of 2 steps", "step 1, left swings", "base gait"]),
        ("residual", ["Residual of each frame: walk of 2 steps", "left leg swings", "legs swap"]),
        ("joints", ["Joint trajectory of both legs: walk of 2 steps", "left leg swings first", "legs swap"]),
        ("comfort", ["Peak and root mean square of each joint: walk, base gait"]),
    ],
)
def test_a_picture_says_what_it_shows(walk_file, what, said):
    output = walk_file.with_suffix(".svg")
    assert main(["plot", str(walk_file), "--what", what, "--base", "paper", "-o", str(output)]) == 0
    for text in said:
        assert text in words(output)


def test_settings_are_as_they_were_afterwards(walk_file):
    before = dict(mpl.rcParams)
    assert main(["plot", str(walk_file), "-o", str(walk_file.with_suffix(".svg"))]) == 0
    assert {name: mpl.rcParams[name] for name in plot.VECTOR_TEXT} == {name: before[name] for name in plot.VECTOR_TEXT}


@pytest.mark.parametrize("what", ["stick", "angles", "joints"])
def test_a_gait_by_itself_has_no_swap(tmp_path, what):
    gait, output = tmp_path / "gait.csv", tmp_path / "gait.svg"
    BASE.save(gait)
    assert main(["plot", str(gait), "--what", what, "-o", str(output)]) == 0
    assert "legs swap" not in words(output)
