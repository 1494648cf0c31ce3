"""Base gaits for each leg and for stairs: one rate, which is bent for what, and their file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_gaits import ascent, pair

import ggo_factors as ggo
from ggo_factors.motion import recorded as ggo_recorded
from ggo_factors.motion.gait import PAPER_MODEL, swap_roles

PAPER = ggo.paper_base_gait()


def test_steps_of_other_durations_get_one_rate_and_still_close():
    (left, right), leg = pair()
    both = ggo.BaseGaits(left, right)
    assert both.left.dt == both.right.dt == pytest.approx(0.97 / 100.0)
    for mine, given in ((both.left, left), (both.right, right)):
        assert abs(mine.duration - given.duration) <= both.left.dt / 2.0 + 1e-12
        share = np.linspace(0.0, given.duration / 0.97, len(mine))
        np.testing.assert_allclose(mine.frames[:, :2], leg(share), atol=1e-4)
        np.testing.assert_allclose(mine.frames[:, 2:], leg(share + 1.0 - share[-1]), atol=1e-4)
    assert len(both.left) > len(both.right)
    np.testing.assert_array_equal(swap_roles(both.left.frames[-1]), both.right.frames[0])
    np.testing.assert_array_equal(swap_roles(both.right.frames[-1]), both.left.frames[0])
    finer = both.resampled(201)
    assert len(finer.left) + len(finer.right) - 2 == pytest.approx(400, abs=1)
    np.testing.assert_array_equal(swap_roles(finer.left.frames[-1]), finer.right.frames[0])


def test_gaits_of_one_rate_stay_as_they_are():
    other = replace(PAPER, name="other")
    both = ggo.BaseGaits(PAPER, other)
    assert both.left is PAPER
    assert both.right is other


def test_a_gait_up_is_bent_for_steps_up_alone():
    up = ascent()
    both = ggo.BaseGaits(PAPER, PAPER, up=up)
    kinds = [both.kind_for(rise, PAPER_MODEL) for rise in (-0.2, 0.0, 0.08, 0.09, 0.3)]
    assert kinds == ["level", "level", "level", "up", "up"]
    assert both.gait("up", "left") is both.gait("up", "right") is up
    assert both.gait("down", "left") is PAPER
    two = ggo.BaseGaits(PAPER, PAPER, up=ggo.BaseGaits(up, replace(up, name="right")))
    assert two.gait("up", "right").name == "right"


def test_what_does_not_belong_together_is_refused():
    up = ascent()
    with pytest.raises(ggo.InputError, match=r"up: 'paper base gait' lands at -0\.010 m"):
        ggo.BaseGaits(PAPER, PAPER, up=PAPER)
    with pytest.raises(ggo.InputError, match=r"down: 'up' lands at \+0\.170 m"):
        ggo.BaseGaits(PAPER, PAPER, down=up)
    with pytest.raises(ggo.InputError, match="other leg lengths"):
        ggo.BaseGaits(PAPER, replace(PAPER, model=ggo.LegModel(0.5, 0.4)))
    with pytest.raises(ggo.InputError, match="a pair of legs is expected"):
        ggo.BaseGaits(PAPER, PAPER, up=ggo.BaseGaits(PAPER, PAPER, up=up))


@pytest.mark.parametrize("for_each", [True, False])
def test_a_file_gives_back_what_was_saved(tmp_path, for_each):
    (left, right), _ = pair() if for_each else ((PAPER, PAPER), None)
    up = ascent()
    both = ggo.BaseGaits(left, right, up=up if not for_each else ggo.BaseGaits(up, replace(up, name="other")))
    both.save(tmp_path / "base.csv")
    read = ggo.load_base_gaits(tmp_path / "base.csv")
    for kind in ("level", "up", "down"):
        for leg in ("left", "right"):
            mine, theirs = read.gait(kind, leg), both.gait(kind, leg)
            np.testing.assert_allclose(mine.frames, theirs.frames, atol=1e-13)
            assert (mine.dt, mine.name, mine.origin, mine.model) == (
                theirs.dt,
                theirs.name,
                theirs.origin,
                theirs.model,
            )
    assert (read.gait("up", "left") is read.gait("up", "right")) != for_each
    with pytest.raises(ggo.InputError, match="ggo-gait 1"):
        ggo.load_gait(tmp_path / "base.csv")


def recorded(swing, strides, ground="level"):
    """Strides whose spread grows over the step, in 21 frames."""
    spread = np.linspace(0.01, 0.05, 21)[:, None] * np.array([1.0, 2.0, 3.0, 4.0])
    return ggo_recorded.Recorded(strides, spread, ground, swing)


def test_a_file_carries_how_the_strides_spread_and_how_many_they_were(tmp_path):
    (left, right), _ = pair()
    up = replace(ascent(), recorded=recorded("both", 7, "up"))
    both = ggo.BaseGaits(replace(left, recorded=recorded("left", 12)), right, up=up)
    both.save(tmp_path / "base.csv")
    assert (tmp_path / "base.csv").read_text().startswith("# ggo-base-gaits 2\n")
    read = ggo.load_base_gaits(tmp_path / "base.csv")
    for kind, leg, strides in (("level", "left", 12), ("up", "right", 7)):
        gait = read.gait(kind, leg)
        assert (gait.recorded.strides, gait.recorded.ground) == (strides, kind)
        wanted = np.linspace(0.01, 0.05, len(gait))[:, None] * np.array([1.0, 2.0, 3.0, 4.0])
        np.testing.assert_allclose(gait.recorded.spread, wanted, atol=1e-12)
        assert gait.fingerprint == both.gait(kind, leg).fingerprint
        assert f'"fingerprint": "{gait.fingerprint}"' in (tmp_path / "base.csv").read_text()
    assert read.right.recorded is None
    assert len({gait.fingerprint for gait in read.gaits}) == 3
    text = (tmp_path / "base.csv").read_text()
    (tmp_path / "base.csv").write_text(text.replace('"strides": 12', '"strides": 0'))
    with pytest.raises(ggo.InputError, match=r"base.csv: header: strides: 0"):
        ggo.load_base_gaits(tmp_path / "base.csv")


@pytest.mark.parametrize("pace", [1.0, 1.25])
def test_a_gait_file_carries_them_too(tmp_path, pace):
    paced = None if pace == 1.0 else PAPER.times * np.linspace(1.0, pace, len(PAPER))
    gait, path = replace(PAPER, recorded=recorded("right", 31), paced=paced), tmp_path / "gait.csv"
    gait.save(path)
    read = ggo.load_gait(path)
    np.testing.assert_allclose(read.frames, gait.frames, atol=1e-13)
    np.testing.assert_allclose(read.recorded.spread, gait.recorded.spread_at(51), atol=1e-13)
    assert (read.recorded.strides, read.recorded.swing, read.recorded.ground) == (31, "right", "level")
    assert (read.paced is None) == (paced is None)
    assert read.notes == ()
    path.write_text(path.read_text().replace("# swing: right", "# swing: none"))
    with pytest.raises(ggo.InputError, match=r"gait.csv: header: swing: 'none' is none of left, right, both"):
        ggo.load_gait(path)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"swing": "both"', '"swing": "left"', "missing or unknown: level right"),
        ('"ground": "level"', '"ground": "sand"', "missing or unknown"),
        ('# gait 1: {"ground"', '# gait 1: {"grund"', "does not describe a gait"),
        ("\n1,", "\n7,", "the header says nothing of gait 7"),
        ("# dt: 0.01 s", "# dt: 0.02 s", "were changed since it was written"),
    ],
)
def test_a_damaged_file_is_refused_by_name(tmp_path, old, new, said):
    path = tmp_path / "base.csv"
    ggo.BaseGaits(PAPER, PAPER).save(path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ggo.InputError, match=said):
        ggo.load_base_gaits(path)
