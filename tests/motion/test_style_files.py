"""Style files, and styles as data."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.motion import style as module

WAVES = np.sin(np.linspace(0.0, 3.0, 51)[:, None, None] + np.arange(4)[:, None] + np.arange(3)) / 40.0
STYLE = ggo.Style(WAVES, 3e-6, 56, 1, 0.99, (5.9, 4.4), (0.68, 0.77), ground="up", lands=True, start_variance=1e-5)


def numbers_of(style):
    return {field.name: getattr(style, field.name) for field in fields(style)}


def written(path, **changes):
    """A style file with some entries changed; None leaves one out."""
    found = {"kind": "ggo-style", "format_version": 3, **numbers_of(STYLE), **changes}
    np.savez(path, **{name: value for name, value in found.items() if value is not None})
    return path


def test_a_file_gives_back_what_was_saved(tmp_path):
    STYLE.save(tmp_path / "a.npz")
    again = ggo.load_style(tmp_path / "a.npz")
    for name, value in numbers_of(STYLE).items():
        np.testing.assert_array_equal(getattr(again, name), value)
    assert not again.directions.flags.writeable
    assert again.fingerprint == STYLE.fingerprint != replace(STYLE, directions=1.01 * WAVES).fingerprint
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_a_file_of_before_says_nothing_of_its_ground(tmp_path):
    newer = {"lands": None, "start_variance": None}
    old = ggo.load_style(written(tmp_path / "old.npz", format_version=1, ground=None, **newer))
    assert (old.ground, old.lands, old.start_variance) == ("", False, np.inf)
    second = ggo.load_style(written(tmp_path / "second.npz", format_version=2, **newer))
    assert (second.ground, second.lands, second.start_variance) == ("up", False, np.inf)
    np.testing.assert_array_equal(old.directions, WAVES)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"format_version": 4}, "version 4"),
        ({"ground": None}, "ground missing"),
        ({"lands": None}, "lands missing"),
        ({"lands": 1}, "lands: expected"),
        ({"start_variance": 0.0}, "start_variance"),
        ({"start_variance": np.nan}, "start_variance"),
        ({"start_variance": np.array([np.inf, np.inf])}, "start_variance"),
        ({"lands": "yes"}, "lands: expected True or False"),
        ({"ground": np.array(["up"])}, "ground: expected a text"),
        ({"variance": True}, "variance: expected numbers"),
        ({"ground": "sand"}, "ground: 'sand' is none of"),
        ({"ground": 1}, "ground: expected a text"),
        ({"format_version": "1"}, "version"),
        ({"kind": "ggo-gait"}, "mark"),
        ({"kind": None}, "mark"),
        ({"directions": None}, "directions missing"),
        ({"directions": WAVES[:, :3]}, "expected shape"),
        ({"directions": WAVES[:3]}, "3 frames"),
        ({"directions": WAVES[:, :, :0]}, "0 numbers"),
        ({"directions": np.where(WAVES[7, 1, 2] == WAVES, np.nan, WAVES)}, r"\[7, 1, 2\]"),
        ({"directions": np.array(["x"])}, "expected numbers"),
        ({"directions": 1e3 * WAVES}, "looks like degrees"),
        ({"variance": 0.0}, "variance"),
        ({"variance": np.inf}, "variance"),
        ({"variance": np.array([1e-6, 1e-6])}, "variance"),
        ({"steps": 0}, "steps"),
        ({"people": 57}, "people"),
        ({"explained": 1.5}, "explained"),
        ({"likelihood": (1.0, 2.0, 3.0)}, "likelihood"),
        ({"error_deg": (1.0, np.nan)}, "error_deg"),
    ],
)
def test_a_wrong_file_is_refused_by_name(tmp_path, changes, words):
    path = written(tmp_path / "wrong.npz", **changes)
    with pytest.raises(ggo.InputError, match=f"wrong.npz.*{words}"):
        ggo.load_style(path)


def test_what_is_no_style_file_is_refused(tmp_path):
    whole = written(tmp_path / "whole.npz").read_bytes()
    big = tmp_path / "big.npz"
    np.savez_compressed(big, kind="ggo-style", format_version=1, directions=np.zeros((400_000, 4)))
    assert big.stat().st_size < 50_000
    cases = {"empty": b"", "text": b"alpha1_deg\n", "cut": whole[: len(whole) // 2], "object": None}
    np.savez(tmp_path / "object", kind=np.array([{}], dtype=object))
    for name, content in cases.items():
        path = tmp_path / f"{name}.npz"
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(ggo.InputError, match="style file"):
            ggo.load_style(path)
    with pytest.raises(ggo.InputError, match="it holds"):
        ggo.load_style(big)
    for missing in (tmp_path / "none.npz", tmp_path):
        with pytest.raises(ggo.InputError, match="cannot be read"):
            ggo.load_style(missing)
    with pytest.raises(ggo.InputError, match="ends in"):
        STYLE.save(tmp_path / "a.csv")


def test_it_helps_where_enough_steps_and_held_out_ones_say_so():
    assert STYLE.helps
    assert not STYLE.why_not
    assert "11 steps" in replace(STYLE, steps=module.LEAST_STEPS - 1).why_not
    assert "likelier" in replace(STYLE, likelihood=(4.4, 4.4)).why_not
    assert "nearer" in replace(STYLE, error_deg=(0.8, 0.77)).why_not


def test_the_directions_at_other_frames_are_those_of_the_same_phases():
    np.testing.assert_allclose(STYLE.at(51), WAVES, atol=1e-12)
    np.testing.assert_allclose(STYLE.at(101)[::2], WAVES, atol=1e-12)
    np.testing.assert_allclose(STYLE.at(26), WAVES[::2], atol=1e-12)
    np.testing.assert_allclose(STYLE.at(11, 0.8), WAVES[40:], atol=1e-12)
