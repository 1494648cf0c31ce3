"""Terrain files: what is written comes back, and what is wrong in one is named."""

import math
from dataclasses import replace

import pytest

import ggo_factors as ggo

FIRST = "# ggo-terrain 1\n"
GROUND = f"{FIRST}[[ground]]\nx_end = 2\n"


@pytest.mark.parametrize("name", ["", "Flur 3, \u00fc", "\U0001f600", 'a"b\\c', "\n\t\x00\x1f\x7f\x85\u2028"])
def test_any_name_comes_back(tmp_path, name):
    terrain = replace(ggo.Terrain.level(1.0), name=name)
    terrain.save(tmp_path / "t.toml")
    assert ggo.load_terrain(tmp_path / "t.toml") == terrain


def test_a_name_that_is_no_text_leaves_the_file_as_it_was(tmp_path):
    path = tmp_path / "t.toml"
    ggo.Terrain.level(1.0).save(path)
    before = path.read_bytes()
    with pytest.raises(ggo.InputError, match=r"t\.toml: cannot be written: .*surrogates"):
        replace(ggo.Terrain.level(1.0), name="\ud800").save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_all_that_a_terrain_has_comes_back_to_the_bit(tmp_path):
    surfaces = (
        ggo.Surface(-0.7, 1 / 3, -1e-7, math.radians(7.0)),
        ggo.Surface(1 / 3, 2.0, 0.1, 0.0, 0.02, 0.01),
        ggo.Surface(2.0, 5.5, -0.3, math.radians(-15.0)),
    )
    boxes = (ggo.Obstacle(0.5, 0.6, 0.1), ggo.Obstacle(-0.1, 2.5, 0.0, 0.01, 0.02))
    pits = (ggo.Gap(1.0, 1.5), ggo.Gap(1.2, 90.0, 0.1, unknown=True))
    terrain = ggo.Terrain(surfaces, boxes, pits, "all")
    terrain.save(tmp_path / "t.toml")
    assert ggo.load_terrain(tmp_path / "t.toml") == terrain


def test_what_is_0_may_be_left_out(tmp_path):
    path = tmp_path / "t.toml"
    path.write_text(f"{GROUND}[[box]]\nx_start = 0.5\nx_end = 0.6\nheight = 0\n[[pit]]\nx_start = 1\nx_end = 1.2\n")
    boxes, pits = (ggo.Obstacle(0.5, 0.6, 0.0),), (ggo.Gap(1.0, 1.2),)
    assert ggo.load_terrain(path) == ggo.Terrain((ggo.Surface(0.0, 2.0),), boxes, pits)
    path.write_bytes(b"\xef\xbb\xbf" + GROUND.replace("\n", "\r\n").encode())
    assert ggo.load_terrain(path) == ggo.Terrain.level(2.0)


BOX = f"{GROUND}[[box]]\nx_start = 0.5\n"
PIT = f"{GROUND}[[pit]]\nx_start = 0.5\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "is no terrain file: it begins with ''"),
        ("[[ground]]\nx_end = 2\n", "is no terrain file"),
        ("# ggo-terrain 2\n", "is no terrain file"),
        (FIRST, "surfaces: 0 must be at least 1"),
        (f"{FIRST}[[ground]]\n", "ground 1: lacks 'x_end'"),
        (f"{GROUND}[[ground]]\nx_end = 1\n", "ground 2: x_end: 1 m must be above x_start 2 m"),
        (f"{GROUND}[[ground]]\nx_end = nan\n", "ground 2: x_end: nan is not finite"),
        (f"{GROUND}[[ground]]\nx_end = 1e400\n", "ground 2: x_end: inf is not finite"),
        (f"{GROUND}[[ground]]\nx_end = '3'\n", "ground 2: x_end: expected a number, got '3'"),
        (f"{GROUND}[[ground]]\nx_end = true\n", "ground 2: x_end: expected a number, got True"),
        (f"{GROUND}[[ground]]\nx_end = 2020-01-01\n", "ground 2: x_end: expected a number, got datetime.date"),
        (f"{GROUND}height = -inf\n", "ground 1: height: -inf is not finite"),
        (f"{GROUND}slope_deg = 16\n", "ground 1: slope: 16 degrees is beyond 15 degrees"),
        (f"{GROUND}edge_std = -1\n", "ground 1: edge_std: -1 m must be at least 0 m"),
        (f"{GROUND}height_std = []\n", r"ground 1: height_std: expected a number, got \[\]"),
        (f"{GROUND}depth = 1\n", "ground 1: unknown key 'depth'; known: x_end, height, slope_deg"),
        (f"{FIRST}x_start = 'a'\n[[ground]]\nx_end = 2\n", "x_start: expected a number, got 'a'"),
        (f"{FIRST}name = 3\n[[ground]]\nx_end = 2\n", "name: expected text, got 3"),
        (f"{FIRST}goal = 3\n", "unknown key 'goal'; known: name, x_start, ground, box, pit"),
        (f"{FIRST}ground = 3\n", r"ground: expected tables \[\[ground\]\], got 3"),
        (f"{FIRST}ground = [3]\n", r"ground: expected tables \[\[ground\]\]"),
        (f"{FIRST}[ground]\nx_end = 2\n", r"ground: expected tables \[\[ground\]\]"),
        (BOX, "box 1: lacks 'x_end'"),
        (f"{BOX}x_end = 0.4\nheight = 0.1\n", "box 1: x_end: 0.4 m must be above x_start 0.5 m"),
        (f"{BOX}x_end = 0.6\nheight = -0.1\n", "box 1: height: -0.1 m must be at least 0 m"),
        (f"{BOX}x_end = 0.6\nheight = 0.1\nbase = 0\n", "box 1: unknown key 'base'"),
        (f"{BOX}x_end = 0.6\nheight = 0.1\nedge_std = 1\n", "box 1: edge_std: 1 m must be at most 0.1 m"),
        (f"{GROUND}[[box]]\nx_start = 3\nx_end = 4\nheight = 0.1\n", "boxes: box from 3 to 4 m, .* beyond the end"),
        (f"{PIT}x_end = 0.6\nunknown = 1\n", "pit 1: unknown: expected True or False, got 1"),
        (f"{PIT}x_end = 0.6\n[[pit]]\nx_end = 0.6\n", "pit 2: lacks 'x_start'"),
        (f"{PIT}x_end = inf\n", "pit 1: x_end: inf is not finite"),
        (f"{FIRST}[[ground]\n", "is not TOML"),
        (f"{FIRST}a = {'[' * 5000}\n", "is not TOML"),
        (f"{FIRST}[[ground]]\nx_end = {'9' * 5000}\n", "is not TOML"),
        (f"{FIRST}[[ground]]\nx_end = {'9' * 400}\n", "ground 1: x_end: expected a number"),
        (FIRST + "".join(f"[[ground]]\nx_end = {n / 20}\n" for n in range(1, 1002)), "1001 must be at most 1000"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, told):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ggo.InputError, match=told) as error:
        ggo.load_terrain(path)
    assert str(error.value).startswith(f"{path}: ")


def test_files_that_cannot_be_read_or_written(tmp_path):
    (tmp_path / "latin.toml").write_bytes(b"# ggo-terrain 1\n# \xff")
    for name, told in (("latin.toml", "not a text file"), ("none.toml", "No such file"), (".", "Is a directory")):
        with pytest.raises(ggo.InputError, match=told):
            ggo.load_terrain(tmp_path / name)
    with pytest.raises(ggo.InputError, match="cannot be written"):
        ggo.Terrain.level(1.0).save(tmp_path / "none" / "t.toml")
    for path in (None, 1, "", "\0"):
        with pytest.raises(ggo.InputError, match="expected the name of a file"):
            ggo.load_terrain(path)
