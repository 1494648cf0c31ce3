"""`ggo learn` and `--style`."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.cli import main

FOLDER = Path(os.environ.get("GGO_RECORDINGS", "no such folder"))


def test_a_step_is_bent_with_a_style_file(tmp_path, capsys):
    waves = np.sin(np.linspace(0.0, 3.0, 51)[:, None, None] + np.arange(4)[:, None] + np.arange(3)) / 40.0
    path = tmp_path / "style.npz"
    for steps, told in ((56, False), (6, True)):
        ggo.Style(waves, 3e-6, steps, 1, 0.99, (5.9, 4.4), (0.68, 0.77)).save(path)
        box = ["--obstacle", "0.2,0.25,0.08", "--foothold", "0.42,0"]
        assert main(["step-over", "paper", *box, "--style", str(path), "--json"]) == 0
        assert ("6 steps" in capsys.readouterr().out) == told


def test_a_wrong_style_file_is_bad_input(tmp_path, capsys):
    path = tmp_path / "style.npz"
    path.write_text("no style")
    assert main(["stride", "paper", "--style", str(path)]) == 2
    assert "no style file" in capsys.readouterr().err


@pytest.mark.skipif(not FOLDER.is_dir(), reason="GGO_RECORDINGS names no folder")
def test_learned_from_a_log(tmp_path, capsys):
    path = tmp_path / "style.npz"
    log = str(FOLDER / "level_nonan_middle.mcap")
    assert main(["learn", log, "--joints", "segment-pitch", "-o", str(path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["helps"]
    assert told["steps"] == ggo.load_style(path).steps == 112
