"""First and last step of a flight as gaits beside that from stair to stair: what bends them, at what rate, in files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_gaits import ascent, first_step, last_step
from test_base_gaits import recorded

import ggo_factors as ggo
from ggo_factors.motion.gait import PAPER_MODEL, swap_roles

PAPER = ggo.paper_base_gait()
FIRST = first_step()
UP = replace(ascent(), first_step=FIRST)
WHOLE = replace(UP, last_step=last_step())
ON_STAIRS = UP.frames[0]


def kinds(bases, start):
    return [bases.kind_for(rise, PAPER_MODEL, start) for rise in (-0.2, 0.0, 0.08, 0.12, 0.3)]


def test_a_step_from_level_ground_onto_a_stair_bends_it():
    both = ggo.BaseGaits(PAPER, PAPER, up=UP)
    assert kinds(both, PAPER.frames[0]) == kinds(both, ggo.STANDING) == ["level"] * 3 + ["first up"] * 2
    assert kinds(both, ON_STAIRS) == kinds(both, None) == ["level"] * 3 + ["up"] * 2
    assert both.gait("first up", "left") is both.gait("first up", "right")
    assert kinds(ggo.BaseGaits(PAPER, PAPER, up=ascent()), ggo.STANDING) == ["level"] * 3 + ["up"] * 2
    assert kinds(ggo.BaseGaits(UP, UP), ggo.STANDING) == ["level"] * 3 + ["first up"] * 2


def test_a_step_from_a_stair_to_feet_together_bends_the_last_one():
    both = ggo.BaseGaits(PAPER, PAPER, up=WHOLE)
    chosen = [both.kind_for(rise, PAPER_MODEL, ON_STAIRS, closes=True) for rise in (0.0, 0.17)]
    assert chosen == ["last up", "up"]
    assert both.kind_for(0.0, PAPER_MODEL, ON_STAIRS) == "level"
    assert both.kind_for(0.0, PAPER_MODEL, PAPER.frames[0], closes=True) == "level"
    assert PAPER_MODEL.endpoint(swap_roles(ON_STAIRS))[1] > 0.1
    assert both.kind_for(0.0, PAPER_MODEL, swap_roles(ON_STAIRS), closes=True) == "level"
    assert ggo.BaseGaits(PAPER, PAPER, up=UP).kind_for(0.0, PAPER_MODEL, ON_STAIRS, closes=True) == "level"


def test_a_leg_without_one_takes_that_of_the_other():
    pair = ggo.BaseGaits(UP, replace(ascent(), name="right"))
    both = ggo.BaseGaits(PAPER, PAPER, up=pair)
    assert both.gait("first up", "left") is both.gait("first up", "right")
    two = ggo.BaseGaits(UP, replace(UP, name="right", first_step=replace(FIRST, name="other")))
    assert ggo.BaseGaits(PAPER, PAPER, up=two).gait("first up", "right").name == "other"


def test_all_gaits_have_one_rate_and_the_same_legs():
    slow = replace(UP, first_step=replace(FIRST, dt=2.0 * FIRST.dt))
    both = ggo.BaseGaits(PAPER, PAPER, up=slow)
    assert {gait.dt for gait in both.gaits} == {PAPER.dt}
    assert both.gait("first up", "left").duration == pytest.approx(2.0 * FIRST.duration)
    assert len(both.resampled(201).gait("first up", "left")) == pytest.approx(401, abs=1)
    paced = both.changed(lambda gait: replace(gait, dt=2.0 * gait.dt))
    assert paced.gait("first up", "right").duration == pytest.approx(4.0 * FIRST.duration)
    taller = ggo.LegModel(0.45, 0.43)
    assert replace(UP, model=taller).first_step.model == taller
    assert UP.swapped().first_step is None


def test_one_that_leads_elsewhere_is_refused():
    with pytest.raises(ggo.InputError, match=r"first up: 'paper base gait' lands at -0\.010 m, which is no step up "):
        ggo.BaseGaits(PAPER, PAPER, up=replace(UP, first_step=PAPER))
    with pytest.raises(ggo.InputError, match=r"last up: 'up' lands at \+0\.170 m, which is not on level ground"):
        ggo.BaseGaits(PAPER, PAPER, up=replace(UP, last_step=ascent()))
    with pytest.raises(ggo.InputError, match=r"first up: 'up' begins with a foot at -0\.170 m, not on level ground"):
        ggo.BaseGaits(PAPER, PAPER, up=replace(UP, first_step=ascent()))
    with pytest.raises(ggo.InputError, match="first_step: expected a Gait"):
        replace(UP, first_step=FIRST.frames)


@pytest.mark.parametrize("ends", [("first_step",), ("last_step",), ("first_step", "last_step")])
@pytest.mark.parametrize("spread", [False, True])
@pytest.mark.parametrize("pace", [1.0, 1.25])
def test_a_gait_file_carries_them(tmp_path, spread, pace, ends):
    kept = recorded("both", 4, "up") if spread else None
    first = replace(FIRST, dt=0.0123, recorded=recorded("right", 2, "first up") if spread else None)
    last = replace(last_step().resampled(37), recorded=recorded("left", 3, "last up") if spread else None)
    others = {key: own for key, own in (("first_step", first), ("last_step", last)) if key in ends}
    paced = None if pace == 1.0 else UP.times * np.linspace(1.0, pace, len(UP))
    gait = replace(ascent(), recorded=kept, paced=paced, **others)
    gait.save(tmp_path / "up.csv")
    assert (tmp_path / "up.csv").read_text().startswith("# ggo-gait 4\n")
    read = ggo.load_gait(tmp_path / "up.csv")
    assert [key for key in ("first_step", "last_step") if getattr(read, key) is not None] == list(ends)
    for mine, theirs in ((read, gait), *((getattr(read, key), getattr(gait, key)) for key in ends)):
        np.testing.assert_allclose(mine.frames, theirs.frames, atol=1e-13)
        np.testing.assert_allclose(mine.times, theirs.times, atol=1e-11)
        assert (mine.name, mine.origin, mine.model) == (theirs.name, theirs.origin, theirs.model)
        assert (mine.recorded is not None) == spread
        if spread:
            assert vars(mine.recorded).keys() == vars(theirs.recorded).keys()
            assert (mine.recorded.strides, mine.recorded.ground) == (theirs.recorded.strides, theirs.recorded.ground)
            np.testing.assert_allclose(mine.recorded.spread, theirs.recorded.spread_at(len(theirs)), atol=1e-13)
    read.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == (tmp_path / "up.csv").read_text()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('{"frames": 51', '{"frames": 50', "the times of its 50 rows do not grow from 0"),
        ('{"frames": 51', '{"frames": 101', "first_step: frames: 101 must be at most 100"),
        ('{"frames": 51', '{"rows": 51', "first_step: frames: expected a whole number"),
        ('# first_step: {"', "# first_step: [", "is no JSON"),
    ],
)
def test_a_damaged_file_is_refused_by_name(tmp_path, old, new, said):
    path = tmp_path / "up.csv"
    UP.save(path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(ggo.InputError, match=rf"up\.csv: header.*{said}"):
        ggo.load_gait(path)


@pytest.mark.parametrize("alone", [False, True])
def test_a_file_of_base_gaits_carries_it(tmp_path, alone):
    pair = ggo.BaseGaits(WHOLE, replace(WHOLE, name="right", first_step=replace(FIRST, name="other")))
    both = pair if alone else ggo.BaseGaits(PAPER, PAPER, up=pair, down=None)
    both.save(tmp_path / "base.csv")
    assert (tmp_path / "base.csv").read_text().startswith("# ggo-base-gaits 3\n")
    read = ggo.load_base_gaits(tmp_path / "base.csv")
    assert len(read.gaits) == len(both.gaits) == (6 if alone else 8)
    for leg in ("left", "right"):
        mine, theirs = read.gait("first up", leg), both.gait("first up", leg)
        np.testing.assert_allclose(mine.frames, theirs.frames, atol=1e-13)
        assert (mine.name, mine.dt) == (theirs.name, theirs.dt)
    assert read.gait("last up", "left").name == "last"
    assert "first up" in repr(read)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"swing": "right"', '"swing": "both"', "header 'gait 2': there is a gait for 'level' and the left leg before"),
        ('"ground": "last up"', '"ground": "down"', r"down: 'last' lands at [+-]0\.\d+ m, which is no step down"),
    ],
)
def test_a_damaged_file_of_base_gaits_is_refused_by_name(tmp_path, old, new, said):
    path = tmp_path / "base.csv"
    ggo.BaseGaits(PAPER, replace(PAPER, name="right"), up=WHOLE).save(path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ggo.InputError, match=rf"base\.csv: {said}"):
        ggo.load_base_gaits(path)
