"""`compare` and `ggo compare`: made-up logs with a known answer, and the recordings where they are."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from log_files import write_joint_log
from test_cut_strides import walk
from test_import_base_gait import facts_of, map_of
from test_signals import MAP, NAMES

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.errors import InputError, LogError
from ggo_factors.evaluate.likeness import METHODS, STYLED
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.paper_gait import paper_base_gait
from ggo_factors.recording.base_gait import import_base_gait
from ggo_factors.recording.compare import KNEE_SPARE, compare
from ggo_factors.recording.strides.mean_step import resampled_step

LEVEL = ("level_csic_s10", "level_nonan_middle", "level_opensim_rajagopal", "level_opensim_subject01")
STAIRS = ("stairs_wpi_s04_riser173", "stairs_wpi_s04_riser192")
LEVEL_GOAL = 0.85
"""In the mean over the level recordings gaits are to be at most so many times as far from people as no change."""
STAIR_GOAL_DEG = 4.5
"""From the base gait of another stair, gaits are to be at most so far from a person's own steps."""
BASE = paper_base_gait()


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """Ten strides, all alike but for the last four, in which the knees bend a tenth more."""
    times, values, marks = walk(10)
    more = 1.0 + 0.1 * np.clip(times - marks[6], 0.0, 1.0)[:, None] * [0.0, 1.0, 0.0, 1.0]
    return write_joint_log(tmp_path_factory.mktemp("logs") / "made.mcap", values * more, NAMES)


@pytest.fixture(scope="module")
def report(log):
    return import_base_gait(log, joints=MAP)


@pytest.fixture(scope="module")
def compared(log, report):
    """The log's steps beside the base gait of its import, and how far along it was each time it said so."""
    done = []
    return compare(report.gait, log, joints=MAP, progress=done.append), done


@pytest.fixture(scope="module")
def beside_paper(log):
    return compare(BASE, log, joints=MAP)


@pytest.fixture(scope="module")
def limp(tmp_path_factory):
    """A log of strides that are all alike, the left knee bent by 15 % more; its import; its steps beside that."""
    _, values, _ = walk(10)
    log = write_joint_log(tmp_path_factory.mktemp("logs") / "limp.mcap", values * [1.0, 1.0, 1.0, 1.15], NAMES)
    report = import_base_gait(log, joints=MAP, leg="each")
    return log, report, compare(report.base_gaits, log, joints=MAP)


@pytest.fixture(scope="module")
def joints(tmp_path_factory):
    file = tmp_path_factory.mktemp("maps") / "map.toml"
    rows = [f"[{angle}]\n{name} = {factor}" for angle, row in MAP.terms.items() for name, factor in row.items()]
    file.write_text("\n".join(rows))
    return str(file)


def test_each_step_of_the_import_is_compared_as_the_import_changed_it(compared, report):
    made, done = compared
    assert [(step.leg, step.start, step.end) for step in made.steps] == [(s.leg, s.start, s.end) for s in report.steps]
    for step, cut in zip(made.steps, report.steps, strict=True):
        own = resampled_step(cut.frames, 51) + report.correction + made.knees_raised * np.array([0.0, 1.0, 0.0, 1.0])
        np.testing.assert_allclose(step.recorded, own, atol=1e-12)
        np.testing.assert_allclose(step.made["no_change"][0], own[0], atol=1e-12)
        assert step.foothold == pytest.approx(BASE.legs().endpoint(own[-1]), abs=1e-12)
    assert made.counted == made.steps
    assert 0.1 < made.rmse_deg("no_change") < 6.0
    assert done == sorted(done)
    assert done[-1] == 1.0


def test_steps_that_are_skipped_do_not_count_and_make_an_own_base_gait(log, report, compared):
    made = compare(report.gait, log, joints=MAP, skip=6)
    assert made.skipped == 6
    assert [step.start for step in made.steps] == [step.start for step in compared[0].steps[6:]]
    own = compare(None, log, joints=MAP, skip=6)
    assert own.base == "first 6 steps of made"
    assert [step.start for step in own.steps] == [step.start for step in made.steps]
    # The first steps bend the knees less than the last ones, which the base gait of all of them has seen.
    assert own.rmse_deg("no_change") > 1.2 * made.rmse_deg("no_change")


@pytest.mark.parametrize("left", [0.0, 6.0])
def test_own_base_gaits_are_what_an_import_makes_of_the_same_steps(tmp_path, left):
    _, values, _ = walk(10)
    log = write_joint_log(tmp_path / "even.mcap", values + np.radians([0.0, 0.0, 0.0, left]), NAMES)
    made = compare(None, log, joints=MAP, skip=10)
    same = compare(import_base_gait(log, joints=MAP, leg="each").base_gaits, log, joints=MAP, skip=10)
    for one, other in zip(made.steps, same.steps, strict=True):
        np.testing.assert_allclose(one.made["no_change"], other.made["no_change"], atol=np.radians(0.2))
        np.testing.assert_allclose(one.made["faded"], other.made["faded"], atol=np.radians(0.2))


def test_each_step_is_bent_from_the_base_gait_of_the_leg_that_swings(tmp_path, limp):
    log, report, made = limp
    bases = report.base_gaits
    one = compare(BASE, log, joints=MAP)
    assert made.base == "limp, left swings and limp, right swings"
    assert {step.leg for step in made.counted} == {"left", "right"}
    for step in made.steps:
        own = bases.gait("level", step.leg).resampled(len(step.recorded)).frames
        np.testing.assert_allclose(np.diff(step.made["no_change"], axis=0), np.diff(own, axis=0), atol=1e-9)
    # Every stride is the same: what is left is the start and the stop, and swapped legs are far off.
    swapped = compare(ggo.BaseGaits(bases.right, bases.left), log, joints=MAP)
    assert made.rmse_deg("no_change") < 0.5 * min(one.rmse_deg("no_change"), swapped.rmse_deg("no_change"))
    bases.save(tmp_path / "each.csv")
    read = compare(ggo.load_base_gaits(tmp_path / "each.csv"), log, joints=MAP)
    assert read.rmse_deg("ggo") == pytest.approx(made.rmse_deg("ggo"), abs=1e-6)


def test_steps_are_changed_by_what_the_import_added_to_their_leg(limp):
    _, report, made = limp
    for leg in ("left", "right"):
        recorded = np.mean([step.recorded for step in made.steps if step.leg == leg], axis=0)
        # Both feet are on the ground in the mean, as they are in the base gait of that leg.
        np.testing.assert_allclose(made.model.endpoint(recorded[[0, -1]])[:, 1], 0.0, atol=1e-6)
        found = np.degrees(np.abs(recorded - getattr(report, leg).resampled(len(recorded)).frames).max())
        assert found < 0.01


def test_one_gait_for_both_legs_is_no_other_comparison(log, beside_paper):
    pair = compare(ggo.BaseGaits(BASE, BASE), log, joints=MAP)
    np.testing.assert_array_equal(beside_paper.errors("ggo"), pair.errors("ggo"))
    assert beside_paper.base == pair.base


@pytest.mark.parametrize("frames", [31, 101])
def test_the_rate_of_the_base_gait_changes_no_number(log, report, compared, frames):
    usual, made = compared[0], compare(report.gait.resampled(frames), log, joints=MAP)
    assert made.errors("ggo").shape == (len(report.steps), 51, 4)
    for method in ("ggo", "paper_graph", "no_change", "minimum_jerk"):
        assert made.rmse_deg(method) == pytest.approx(usual.rmse_deg(method), abs=2e-3), method


def test_whatever_can_be_imported_can_be_compared_with():
    times, values, _ = walk(10)
    table = {"t": times} | dict(zip(NAMES, values.T, strict=True))
    gait = import_base_gait(table, joints=MAP, unit="rad").gait
    made = compare(gait, table, joints=MAP, unit="rad")
    assert made.counted == made.steps
    assert made.rmse_deg("ggo") < 1.0


def test_knees_that_bend_backwards_are_raised_alike(tmp_path):
    times, values, marks = walk(10)
    back = np.radians(-8.0) * (times > marks[5])[:, None] * [0.0, 1.0, 0.0, 1.0]
    log = write_joint_log(tmp_path / "back.mcap", values + back, NAMES)
    made = compare(BASE, log, joints=MAP)
    assert made.knees_raised > np.radians(2.0)
    least = min(step.recorded[:3, 1::2].min() for step in made.steps)
    assert least == pytest.approx(KNEE_SPARE)
    # No change keeps the base gait's own motion.
    motion = np.diff(made.steps[0].made["no_change"], axis=0)
    np.testing.assert_allclose(motion, np.diff(BASE.frames, axis=0), atol=1e-12)


@pytest.mark.parametrize(
    ("base", "options", "message"),
    [
        (BASE, {"skip": 400}, r"^skip: 400 steps, .*made\.mcap has \d+ \(level\)$"),
        (BASE, {"skip": -1}, "^skip"),
        (None, {"skip": 2}, "^skip: 1 steps of each leg are skipped, a base gait of them needs 3$"),
        (None, {}, "^skip: 0 steps of each leg"),
        (BASE.resampled(9), {}, "^base: 9 frames, a comparison needs at least 10$"),
        (Gait(BASE.frames, BASE.dt), {}, "states no leg lengths"),
        ("base.csv", {}, "^base: expected a Gait"),
        (BASE, {"activity": "up"}, "^activity"),
        (BASE, {"style": "style.npz"}, "^style: expected a Style"),
    ],
)
def test_bad_input_is_one_clear_line(log, base, options, message):
    with pytest.raises(InputError, match=message) as caught:
        compare(base, log, joints=MAP, **options)
    assert "\n" not in str(caught.value)


def test_a_log_without_such_steps_is_refused_as_by_the_import(log):
    with pytest.raises(LogError, match="0 swings on stairs up"):
        compare(BASE, log, joints=MAP, activity="stairs-up")


def test_command_prints_draws_and_counts_alike(capsys, tmp_path, log, joints, report, compared):
    picture = tmp_path / "errors.svg"
    assert (
        main(["compare", "own", str(log), "--joints", joints, "--unit", "rad", "--skip", "6", "-o", str(picture)]) == 0
    )
    said = capsys.readouterr()
    assert picture.read_text().lstrip().startswith("<?xml")
    assert said.err == ""
    assert said.out.endswith(f"wrote {picture}\n")
    base = tmp_path / "base.csv"
    report.gait.save(base)
    assert main(["compare", str(base), str(log), "--joints", joints, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    made, _ = compared
    assert list(found["methods"]) == list(METHODS)
    for method in METHODS:
        assert found["methods"][method]["rmse_deg"] == pytest.approx(made.rmse_deg(method), abs=1e-6)
        assert method.replace("_", " ") in said.out


@pytest.fixture(scope="module")
def varied(tmp_path_factory):
    """A walk of 24 strides, whose knees bend up to a fifth more or less from one to the next, at random."""
    times, values, marks = walk(24)
    sizes = 1.0 + 0.1 * np.clip(np.random.default_rng(4).standard_normal(len(marks)), -2.0, 2.0)
    by_knee = np.stack([np.interp(times, marks, sizes), np.interp(times, marks, sizes[::-1])], -1)
    more = np.ones_like(values)
    more[:, 1::2] = by_knee
    return write_joint_log(tmp_path_factory.mktemp("logs") / "varied.mcap", values * more, NAMES)


@pytest.fixture(scope="module")
def styled(varied):
    return compare(None, varied, joints=MAP, skip=24)


def test_own_gaits_have_a_style_of_the_steps_that_are_skipped(varied, styled):
    made = styled
    assert made.methods == (METHODS[0], STYLED, *METHODS[1:])
    assert made.style.steps == 24
    assert made.why_no_style == ""
    assert made.counted == made.steps
    # Steps vary by few numbers here, which start and foothold tell.
    assert made.rmse_deg(STYLED) < 0.9 * made.rmse_deg("ggo")
    given = compare(None, varied, joints=MAP, skip=24, style=made.style)
    np.testing.assert_array_equal(given.errors(STYLED), made.errors(STYLED))
    other = compare(BASE, varied, joints=MAP, skip=24, style=made.style)
    assert other.style is made.style
    assert np.abs(other.errors(STYLED) - other.errors("ggo")).max() > 0.0
    assert compare(BASE, varied, joints=MAP, skip=24).methods == METHODS


def test_a_style_that_is_not_used_says_why(log):
    few = compare(None, log, joints=MAP, skip=8)
    assert few.why_no_style == "8 steps are skipped, fewer than 12 to learn a style from"
    useless = ggo.Style(np.ones((51, 4, 1)), 1e-6, 24, 1, 0.5, (4.0, 5.0), (0.7, 0.8))
    told = compare(BASE, log, joints=MAP, style=useless)
    assert told.why_no_style == useless.why_not
    for made in (few, told):
        assert (made.methods, made.style) == (METHODS, None)
        assert made.to_json()["why_no_style"] == made.why_no_style


def test_command_has_a_row_for_the_style_in_table_picture_and_json(capsys, tmp_path, varied, styled, log, joints):
    picture, file = tmp_path / "errors.svg", tmp_path / "style.npz"
    assert main(["compare", "own", str(varied), "--joints", joints, "--skip", "24", "-o", str(picture)]) == 0
    said = capsys.readouterr().out
    assert re.search(r"^ *ggo style +\d\.\d\d ", said, re.MULTILINE)
    assert "ggo style: with a style of 24 steps\n" in said
    assert f'id="{STYLED}"' in picture.read_text()
    styled.style.save(file)
    assert main(["compare", "paper", str(log), "--joints", joints, "--style", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["style"] == {"steps": 24, "fingerprint": styled.style.fingerprint}
    assert list(found["methods"])[1] == STYLED
    assert all(step["rmse_deg"][STYLED] > 0.0 for step in found["steps"])
    assert main(["compare", "own", str(log), "--joints", joints, "--skip", "8"]) == 0
    assert "ggo style: not there: 8 steps are skipped, fewer than 12" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["paper", "paper"], 2, "paper: that is the base gait of the paper, not a recording"),
        (["nothing.csv", "LOG"], 2, "nothing.csv: "),
        (["own", "LOG"], 2, "skip: 0 steps of each leg"),
        (["paper", "LOG", "-o", "errors.doc"], 2, "errors.doc: must end in .png or .pdf or .svg"),
        (["own", "LOG", "--skip", "6", "--thigh", "0.4"], 2, "--thigh and --shank: give both"),
    ],
)
def test_command_refuses_in_one_line(capsys, log, joints, arguments, code, message):
    arguments = [str(log) if word == "LOG" else word for word in arguments]
    assert main(["compare", *arguments, "--joints", joints]) == code
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"ggo: {message}")
    assert said.err.count("\n") == 1


def test_what_should_be_known_of_the_numbers_stands_under_the_table(capsys, monkeypatch, log, joints, beside_paper):
    made = beside_paper
    refused = replace(made.steps[0], refused={"ggo": "knee at frame 1: -4.1 deg"})
    told = replace(made, steps=(refused, *made.steps[1:]), from_ground=3, knees_raised=np.radians(2.0))
    monkeypatch.setattr(ggo, "compare", lambda *_, **__: told)
    assert main(["compare", "paper", str(log), "--joints", joints]) == 0
    said = capsys.readouterr().out
    assert f"{len(made.steps) - 1} of {len(made.steps)} steps" in said
    assert "ggo: 1 refused: knee at frame 1\n" in said
    assert "not compared, as they start from the ground: 3 stair swings" in said
    assert "raised by 2.0 degrees" in said
    none = replace(made, steps=(refused,))
    monkeypatch.setattr(ggo, "compare", lambda *_, **__: none)
    assert main(["compare", "paper", str(log), "--joints", joints, "--json"]) == 3
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == f"ggo: {log}: 1 steps, none with a gait by every method: knee at frame 1: -4.1 deg\n"


def test_on_recordings_gaits_are_nearer_to_people_than_no_change(recordings):
    found = []
    for name in LEVEL:
        joints = map_of(facts_of(recordings, name))
        path = recordings / f"{name}.mcap"
        made = compare(import_base_gait(path, joints=joints, min_strides=1).gait, path, joints=joints)
        assert made.counted == made.steps
        found.append((made.rmse_deg("ggo"), made.rmse_deg("no_change"), made.rmse_deg("dmp")))
    ours, unchanged, taught = np.sum(found, axis=0)
    assert ours <= LEVEL_GOAL * unchanged
    assert ours < taught


@cache
def own_on_recording(recordings, name, skip):
    """Later steps of a recording beside the base gait of its first ones; for more than one test."""
    return compare(None, recordings / f"{name}.mcap", joints=map_of(facts_of(recordings, name)), skip=skip)


@pytest.mark.parametrize(("name", "skip"), [("level_nonan_middle", 56), ("level_csic_s10", 14)])
def test_on_recordings_an_own_base_gait_is_tried_on_later_steps(recordings, name, skip):
    made = own_on_recording(recordings, name, skip)
    assert made.counted == made.steps
    assert made.ratio("ggo") < 1.0


@pytest.mark.parametrize(
    ("name", "skip", "by_no_change", "by_ggo"),
    [("level_nonan_middle", 56, 0.75, 0.90), ("level_csic_s10", 14, 0.75, 1.0)],
)
def test_on_recordings_an_own_style_is_nearer_to_later_steps(recordings, name, skip, by_no_change, by_ggo):
    made = own_on_recording(recordings, name, skip)
    assert made.style.helps
    assert made.ratio(STYLED) <= by_no_change
    assert made.rmse_deg(STYLED) <= by_ggo * made.rmse_deg("ggo")


@pytest.mark.parametrize(
    ("name", "skip"),
    [
        ("level_csic_s10", 6),
        ("level_csic_s10", 12),
        pytest.param("level_nonan_middle", 6, marks=pytest.mark.campaign),
        pytest.param("level_nonan_middle", 12, marks=pytest.mark.campaign),
        ("level_nonan_middle", 24),
    ],
)
def test_on_recordings_few_steps_to_learn_from_mislead_nobody(recordings, name, skip):
    """The first log holds 20 steps."""
    made = compare(None, recordings / f"{name}.mcap", joints=map_of(facts_of(recordings, name)), skip=skip)
    if STYLED in made.methods:
        assert made.rmse_deg(STYLED) <= made.rmse_deg("ggo")
    else:
        assert made.why_no_style


@pytest.mark.parametrize(("one", "other"), [STAIRS, STAIRS[::-1]])
@pytest.mark.parametrize("each", [False, True])
def test_on_recordings_stairs_from_another_stair(recordings, one, other, each):
    base, steps = (map_of(facts_of(recordings, name)) for name in (one, other))
    report = import_base_gait(recordings / f"{one}.mcap", joints=base, min_strides=1, activity="stairs-up")
    gaits = ggo.BaseGaits(BASE, BASE, up=report.base_gaits) if each else report.gait
    made = compare(gaits, recordings / f"{other}.mcap", joints=steps, activity="stairs-up")
    assert (len(made.counted), made.from_ground) == (2, 1)
    assert made.rmse_deg("ggo") <= STAIR_GOAL_DEG
    assert all(step.foothold[1] > 0.1 for step in made.steps)


def test_on_recordings_legs_that_are_far_apart_have_a_base_gait_each(recordings):
    path, joints = recordings / "refuse_legs_apart.mcap", map_of(facts_of(recordings, "refuse_legs_apart"))
    bases = import_base_gait(path, joints=joints, min_strides=1, leg="each").base_gaits
    made, one = (compare(base, path, joints=joints) for base in (bases, bases.right))
    assert made.counted
    assert made.rmse_deg("no_change") < one.rmse_deg("no_change")
