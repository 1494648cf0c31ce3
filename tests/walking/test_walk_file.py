"""The walk file: its checksum and its joint limits."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from changed_rows import CHANGES
from made_gaits import ascent, pair

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
PLAN = (ggo.Step((0.39, 0.0)), ggo.Step((0.39, 0.0)))
LIMITS = ggo.JointLimits(knee_speed=2.5, hip_acceleration=31.0)
WALK = ggo.Walk((BASE, BASE), PLAN, limits=LIMITS)


@pytest.mark.parametrize("change", CHANGES)
def test_every_change_of_a_walk_is_told(tmp_path, change):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    text = path.read_text()
    for seed in range(100):
        path.write_text(CHANGES[change](text, np.random.default_rng(seed)))
        assert path.read_text() != text
        with pytest.raises(ggo.InputError, match=r"walk\.csv"):
            ggo.load_walk(path)


def test_limits_are_carried(tmp_path):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    read = ggo.load_walk(path)
    assert read.notes == ()
    for name, value in vars(LIMITS).items():
        assert getattr(read.limits, name) == pytest.approx(value, rel=1e-11), name
    read.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == path.read_text()
    ggo.Walk((BASE, BASE), PLAN, limits=ggo.JointLimits()).save(path)
    assert ggo.load_walk(path).limits == ggo.JointLimits()
    stated = re.search(r"(?m)^# limits: (.*)$", path.read_text())
    assert stated is not None
    assert json.loads(stated[1])["knee_acceleration_deg_s2"] == 10000.0
    ggo.Walk((BASE, BASE), PLAN).save(path)
    assert ggo.load_walk(path).limits is None
    assert "limits" not in path.read_text()


def test_a_walk_and_each_of_its_steps_keep_their_names(tmp_path):
    path, last = tmp_path / "walk.csv", replace(BASE, name="onto the kerb", origin="generated from stairs")
    first, bare = replace(BASE, name="to the kerb", origin="generated from level"), replace(BASE, name="")
    for gaits, name in (
        ((BASE, BASE), "walk of 2 steps, paper base gait"),
        ((first, first), "walk of 2 steps, generated from level"),
        ((first, last, first), "walk of 3 steps, generated from level and 1 more"),
        ((last,), "walk of 1 step, generated from stairs"),
        ((bare, bare), "walk of 2 steps"),
    ):
        walk = ggo.Walk(gaits, PLAN[:1] * len(gaits))
        assert walk.name == name
        walk.save(path)
        assert f"\n# name: {name}\n" in path.read_text()
        read = ggo.load_walk(path)
        assert read.name == name
        assert [gait.name for gait in read.gaits] == [gait.name for gait in gaits]


def test_in_a_file_of_before_all_steps_have_the_name_of_the_file(tmp_path):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    before = path.read_text().replace('"name": "paper base gait", ', "").replace("walk of 2 steps, paper", "some")
    path.write_text(before)
    assert [gait.name for gait in ggo.load_walk(path).gaits] == ["some base gait"] * 2
    path.write_text(before.replace('"origin":', '"name": 5, "origin":', 1))
    with pytest.raises(ggo.InputError, match="header 'step 1': name is 5, no text"):
        ggo.load_walk(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda given: given | {"hip_speed_deg_s": given["hip_speed_deg_s"] + 1.0}, "limits were changed"),
        (lambda given: given | {"knee_bent_deg": -30.0}, "header 'limits': knee_bent"),
        (lambda given: given | {"knee_bent_deg": math.nan}, "header 'limits': knee_bent_deg: nan is not finite"),
        (lambda given: given | {"knee_bent_deg": "far"}, "header 'limits': knee_bent_deg: expected a number"),
        (lambda given: {}, "header 'limits' lacks 'hip_back_deg'"),
        (lambda given: 5, "header 'limits' does not describe joint limits: 5"),
    ],
)
def test_limits_that_were_changed_or_cannot_be_used(tmp_path, change, message):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    changed = re.sub(
        r"(?m)^# limits: (.*)$", lambda found: f"# limits: {json.dumps(change(json.loads(found[1])))}", path.read_text()
    )
    path.write_text(changed)
    with pytest.raises(ggo.InputError, match=rf"walk\.csv: .*{message}"):
        ggo.load_walk(path)


def test_what_a_step_must_do_is_free_to_edit(tmp_path):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    path.write_text(path.read_text().replace('"foothold_m": [0.39, 0.0]', '"foothold_m": [0.41, 0.0]', 1))
    read = ggo.load_walk(path)
    assert (read.plan[0].foothold, read.notes) == ((0.41, 0.0), ())
    assert not read.verify()[0].ok


def test_a_walk_without_checksum_is_read_with_a_note(tmp_path):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    path.write_text(re.sub(r"(?m)^# checksum: .*\n", "", path.read_text()))
    assert ggo.load_walk(path).notes == (f"{path}: has no checksum, so changed numbers cannot be told",)


def test_limits_of_another_kind_are_refused():
    with pytest.raises(ggo.InputError, match="limits: expected a JointLimits, got 3"):
        ggo.Walk((BASE,), PLAN[:1], limits=3)


@pytest.mark.parametrize("styled", [False, True])
def test_each_step_says_what_it_was_bent_from(tmp_path, styled):
    (left, right), _ = pair()
    base, path = ggo.BaseGaits(left, right, up=ascent()), tmp_path / "walk.csv"
    phase = np.linspace(0.0, np.pi, 51)[:, None, None]
    style = ggo.Style(
        0.03 * np.sin(phase + np.arange(4)[:, None] + np.arange(2)), 3e-6, 60, 1, 0.99, (5.0, 4.0), (0.7, 0.8)
    )
    made = ggo.climb_stairs(base, 0.15, tread=0.3, steps=2, to_standing=True, style=style if styled else None)
    made.save(path)
    read = ggo.load_walk(path)
    for gait, step, swing, kind in zip(
        read.gaits, made.steps, ("right", "left", "right"), ("up", "up", "level"), strict=True
    ):
        bent = base.gait(kind, swing)
        said = (gait.bent.name, gait.bent.fingerprint, gait.bent.ground, gait.bent.swing)
        assert said == (bent.name, bent.fingerprint, kind, swing)
        assert gait.bent.style == (style.fingerprint if step.style is not None else "")
        np.testing.assert_allclose(gait.bent.numbers, [] if step.style is None else step.style, atol=1e-6)
    assert any(step.style is not None for step in made.steps) == styled
    read.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == path.read_text()


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ('{"name": 3}', "bent_from: name"),
        ("[]", "bent_from: expected"),
        ('{"name": "a", "fingerprint": "b", "ground": "up", "swing": "left", "numbers": [null]}', "bent_from: numbers"),
    ],
)
def test_what_says_no_such_thing_is_refused(tmp_path, said, message):
    path = tmp_path / "walk.csv"
    WALK.save(path)
    path.write_text(path.read_text().replace('"origin":', f'"bent_from": {said}, "origin":', 1))
    with pytest.raises(ggo.InputError, match=rf"walk\.csv: header: {message}"):
        ggo.load_walk(path)
