"""Bent gaits beside what people did: steps with a known answer, and the recordings where they are."""

import importlib.util
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.recording.strides.mean_step import closed_step, stand_with_bent_knees

TOOL = Path(__file__).parents[2] / "tools" / "compare_with_people.py"
SPEC = importlib.util.spec_from_file_location("compare_with_people", TOOL)
tool = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = tool  # where its dataclasses look for their module
SPEC.loader.exec_module(tool)

BASE = ggo.adjust_stride(ggo.paper_base_gait(), steps=1).gaits[0]


def walker(*steps):
    return tool.Recording("someone", "level", BASE, steps, 0.0)


def test_who_walks_as_the_base_gait_does_is_met_exactly():
    row = tool.compare(walker(), walker(BASE.frames))
    assert (row.steps, row.refused, row.refusals) == (1, 0, ())
    assert max(row.no_change_deg, row.without_landing_deg, row.bent_deg) < 0.1


def test_a_constant_is_no_change_and_a_longer_step_is_followed():
    apart = walker(BASE.frames + np.radians([1.0, 2.0, 1.0, 2.0]))
    assert tool.compare(walker(), apart).no_change_deg == pytest.approx(0.0, abs=1e-9)
    longer = BASE.frames + np.linspace(0.0, 1.0, len(BASE))[:, None] ** 2 * np.radians([-4.0, 0.0, 4.0, 0.0])
    row = tool.compare(walker(), walker(longer))
    by_hand = np.degrees(np.sqrt(np.mean((longer - BASE.frames) ** 2)))
    assert row.no_change_deg == pytest.approx(by_hand)
    assert row.bent_deg < 0.7 * row.no_change_deg


def test_steps_that_no_gait_makes_are_counted_and_left_out():
    overstretched = BASE.frames + np.radians([0.0, -40.0, 0.0, -40.0])
    row = tool.compare(walker(), walker(BASE.frames, overstretched))
    assert (row.steps, row.refused) == (2, 1)
    assert "knee" in row.refusals[0]
    assert row.bent_deg < 0.1


def test_raised_knees_keep_the_base_gait_on_the_ground_and_periodic():
    frames, _ = stand_with_bent_knees(closed_step(BASE.frames), BASE.model)
    before = tool.Recording("someone", "level", replace(BASE, frames=frames), (frames,), 0.0)
    after = tool.with_knees_raised(before, np.radians(5.0))
    np.testing.assert_allclose(after.base.endpoints()[[0, -1], 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(after.base.swapped().frames[-1], after.base.frames[0], atol=1e-9)
    np.testing.assert_allclose(after.steps[0], after.base.frames, atol=1e-12)
    # Standing on the ground again takes some of it back.
    assert 2.5 < np.degrees((after.base.frames - frames)[:, 1::2].mean()) < 5.5


def test_on_recordings_bent_gaits_are_nearer_to_people_than_no_change(recordings):
    command = [sys.executable, "-W", "error", TOOL, recordings, "--json"]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    found = json.loads(ran.stdout)
    assert found["format_version"] == 1
    assert [row["log"] for row in found["logs"]] == [*tool.LEVEL, *2 * tool.STAIRS[::-1]]
    assert not any(row["refused"] for row in found["logs"])
    for kind in ("level", "stairs"):
        assert found["mean_ratio"][kind] <= found["goals"][kind]
