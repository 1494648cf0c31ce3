"""What `ggo import` writes beside the gait, and what it says of a log with faults."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import ggo_factors as ggo
from ggo_factors.cli import main

DATASETS = Path(__file__).parents[2] / "datasets"
LOG = DATASETS / "children_walk.mcap"
IMPORT = ["import", str(LOG), "--joints", str(DATASETS / "children_walk.toml")]


def test_picture_report_and_legs(capsys, tmp_path):
    base, picture, report = (tmp_path / name for name in ("base.csv", "strides.png", "report.json"))
    files = ["-o", str(base), "--picture", str(picture), "--report", str(report)]
    assert main([*IMPORT, *files, "--thigh", "0.4", "--shank", "0.38"]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert json.loads(report.read_text())["format_version"] == 1
    legs = ggo.load_gait(base).model
    assert (legs.thigh, legs.shank) == (0.4, 0.38)
    assert f"wrote {base}" in capsys.readouterr().out


@pytest.mark.parametrize("flag", ["--thigh", "--shank"])
def test_half_a_leg_is_no_leg(capsys, flag):
    assert main([*IMPORT, flag, "0.4"]) == 2
    assert capsys.readouterr().err == "ggo: --thigh and --shank: give both\n"


def test_a_picture_in_an_unknown_form_is_refused_first(capsys, tmp_path):
    assert main([*IMPORT, "-o", str(tmp_path / "base.csv"), "--picture", str(tmp_path / "strides.doc")]) == 2
    assert "strides.doc: must end in " in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_what_a_damaged_log_lost_is_said(capsys, tmp_path):
    content = LOG.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[: len(content) * 3 // 4])
    assert main(["import", str(cut), *IMPORT[2:]]) == 0
    captured = capsys.readouterr()
    losses = ggo.import_base_gait(cut, joints=IMPORT[3]).losses
    assert losses
    assert captured.err.splitlines() == [f"ggo: {loss}" for loss in losses]
