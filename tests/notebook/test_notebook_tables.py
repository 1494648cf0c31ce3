"""Results as data frames, and what is said where pandas is not there."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.evaluate.likeness import METHODS, ComparedStep, Comparison

BASE = ggo.paper_base_gait()


@pytest.fixture(scope="module")
def found():
    return ggo.import_base_gait(ggo.datasets.children_walk(), joints=ggo.datasets.children_walk_joints())


@pytest.fixture(scope="module")
def rows():
    tasks = [ggo.Task("step_over", {"obstacles": [], "foothold": (far, 0.0)}) for far in (0.4, 2.0)]
    return ggo.generate_many(tasks, BASE, workers=1)


@pytest.fixture
def compared():
    off = BASE.frames + np.radians(1.0)
    step = ComparedStep("left", 1.0, 1.5, (0.4, 0.0), BASE.frames, {METHODS[0]: off, METHODS[1]: BASE.frames}, {})
    return Comparison("a base gait", "a log", "level", (step,), 0, 0, 0.0, BASE.model)


def test_the_strides_of_an_import(found):
    table = found.to_dataframe()
    assert list(table.columns) == ["leg", "start", "end", "used", "reason"]
    assert len(table) == len(found.used) + len(found.refused)
    assert table["start"].is_monotonic_increasing
    counts = table[table["used"]].groupby("leg").size().to_dict()
    assert counts == found.strides_used
    assert sorted(table[~table["used"]]["reason"]) == sorted(item.reason for item in found.refused)
    times = table[table["used"]]["end"] - table[table["used"]]["start"]
    assert times.mean() == pytest.approx(found.stride_time[0], rel=0.02)


def test_the_rows_of_many_tasks(rows):
    table = rows.to_dataframe()
    assert table["ok"].tolist() == [True, False]
    assert table["error"].tolist() == ["", rows[1].error]
    assert table["violations"][1] == "reach"
    assert table["foothold_error"][0] == rows[0].foothold_error
    assert table["change_beta2"][0] == rows[0].change[3]
    assert "frames" not in table
    assert isinstance(rows, list)


def test_the_steps_of_a_comparison(compared):
    table = compared.to_dataframe()
    assert table[["leg", "start", "end"]].to_numpy().tolist() == [["left", 1.0, 1.5]]
    assert table[f"{METHODS[0]}_deg"][0] == pytest.approx(1.0)
    assert table[f"{METHODS[1]}_deg"][0] == 0.0
    assert np.isnan(table[f"{METHODS[2]}_deg"][0])


def test_without_pandas_one_error_says_what_to_install(found, rows, compared, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    walk = ggo.Walk((BASE,), (ggo.Step((0.39, 0.0)),))
    for thing in (BASE, walk, walk.joint_trajectory(), found, rows, compared):
        with pytest.raises(ImportError, match=r"^to_dataframe: needs pandas: pip install 'ggo-factors\[pandas\]'$"):
            thing.to_dataframe()
