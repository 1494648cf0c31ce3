"""Every result is written and read back: the same to the bit, and refused by name where it is not what was written."""

from __future__ import annotations

import json
import math
from dataclasses import fields, replace

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.recorded import BentFrom

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.2, 0.25, 0.08)
ROUNDING = 1e-13
"""Gait files hold degrees of 12 digits after the point, which is below 1e-14 rad."""


@pytest.fixture(scope="module")
def over():
    return ggo.step_over(BASE, [BOX], foothold=(0.45, 0.0), first_swing="left")


@pytest.fixture(scope="module")
def level():
    return ggo.import_base_gait(ggo.datasets.children_walk(), joints=ggo.datasets.children_walk_joints(), leg="each")


def same(one, other):
    """Whether two values are alike in every part, arrays to the bit and NaN like NaN."""
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    return type(one) is type(other) and one == other


def test_a_step_is_a_walk_of_one_step_that_can_be_checked(over, tmp_path):
    over.save(tmp_path / "step.csv")
    walk = ggo.load_walk(tmp_path / "step.csv")
    assert walk.plan == (over.task.step,)
    assert walk.first_swing == "left"
    assert np.abs(walk.gaits[0].frames - over.gait.frames).max() < ROUNDING
    (report,) = walk.verify()
    assert report.ok
    assert report.clearance == pytest.approx(over.report.clearance, abs=1e-9)


def test_a_slowed_step_keeps_its_times_and_limits(tmp_path):
    limits = ggo.JointLimits(knee_speed=4.0)
    slow = ggo.step_over(BASE, [BOX], foothold=(0.45, 0.0), limits=limits)
    assert slow.gait.paced is not None
    slow.save(tmp_path / "step.csv")
    walk = ggo.load_walk(tmp_path / "step.csv")
    assert walk.gaits[0].times == pytest.approx(slow.gait.times, abs=1e-12)
    assert walk.limits.knee_speed == pytest.approx(4.0, abs=1e-10)
    assert walk.landing_speed == slow.as_walk().landing_speed is not None
    assert walk.verify()[0].ok


def test_the_solution_of_a_graph_is_its_gait(tmp_path):
    graph = ggo.GaitGraph(BASE)
    graph.anchor(BASE.frames[0])
    graph.end((0.45, 0.0))
    solution = graph.solve()
    solution.save(tmp_path / "gait.csv")
    gait = ggo.load_gait(tmp_path / "gait.csv")
    assert np.abs(gait.frames - solution.gait.frames).max() < ROUNDING
    assert (gait.dt, gait.name, gait.model) == (solution.gait.dt, solution.gait.name, solution.gait.model)


@pytest.mark.parametrize("case", ["good", "broken", "level"])
def test_a_report_comes_back_to_the_bit(case, over, tmp_path):
    wall = ggo.Obstacle(0.2, 0.25, 0.3, edge_std=0.01, height_std=0.01)
    report = {
        "good": over.report,
        "broken": ggo.verify(BASE, obstacles=[wall], foothold=(0.5, 0.0)),
        "level": replace(ggo.verify(BASE), notes=("a note", 'another "one"')),
    }[case]
    assert report.ok == (case == "good") or case == "level"
    report.save(tmp_path / "report.json")
    again = ggo.load_report(tmp_path / "report.json")
    for field in fields(report):
        if field.name != "axes":
            assert same(getattr(report, field.name), getattr(again, field.name)), field.name
    assert same(report.axis_clearance, again.axis_clearance)
    assert again._repr_html_() == report._repr_html_()
    again.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "report.json").read_bytes()


def test_an_import_comes_back_to_the_bit(level, tmp_path):
    level.save(tmp_path / "import.json")
    again = ggo.load_import_report(tmp_path / "import.json")
    assert same(level, again)
    assert again.text() == level.text()
    assert again.to_json() == level.to_json()
    assert same(again.covariance, level.covariance)
    assert (tmp_path / "import.json").stat().st_size < 2_000_000


def test_an_import_of_stairs_and_of_one_leg_comes_back_too(level, tmp_path):
    # What a level import never has: swings among the used ones, numbers that are None or not finite, slowed gaits.
    bent = BentFrom("a gait", "0123", "up", "left", "4567", (0.5, -1.5))
    slowed = Gait(BASE.frames, BASE.dt, paced=np.arange(51) * 0.02, recorded=None, bent=bent)
    odd = replace(
        level,
        used=level.steps[:3],
        riser=0.17,
        tread=None,
        messages_expected=None,
        speed=math.nan,
        left=slowed,
        violations=(ggo.Violation("knee", None, -math.inf, 0.0, "rad", "a note"),),
        signal_counts={"gaps": {"left_hip": 2.0}},
        mean_cycle={"left": np.zeros((2, 4))},
    )
    odd.save(tmp_path / "import.json")
    assert same(odd, ggo.load_import_report(tmp_path / "import.json"))


@pytest.mark.parametrize("load", [ggo.load_report, ggo.load_import_report])
def test_another_file_is_refused_by_name(load, tmp_path, over):
    path = tmp_path / "file.json"
    for text, said in (
        ("{", "is no JSON"),
        ("[1]", "format is None"),
        ('{"format": "ggo-report 9"}', "format is 'ggo-report 9'"),
        ("[" * 100_000, "is no JSON"),
    ):
        path.write_text(text)
        with pytest.raises(ggo.InputError, match=rf"file\.json: .*{said}"):
            load(path)
    with pytest.raises(ggo.InputError, match="cannot be read"):
        load(tmp_path / "missing.json")


def test_a_file_with_a_wrong_value_is_refused(level, over, tmp_path):
    path = tmp_path / "file.json"
    # Every key is tried, but not in a file of a megabyte each time.
    short = replace(level, used=level.used[:1], refused=level.refused[:1], steps=level.steps[:1])
    for result, load, kind in ((over.report, ggo.load_report, "report"), (short, ggo.load_import_report, "import")):
        result.save(path)
        good = json.loads(path.read_text())
        for key in good:
            if key == "format":
                continue
            for bad in ({}, {key: {"wrong": [None]}}):
                path.write_text(json.dumps({name: value for name, value in good.items() if name != key} | bad))
                with pytest.raises(ggo.InputError, match=rf"file\.json: is no saved {kind}: "):
                    load(path)
