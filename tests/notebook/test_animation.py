"""Animations of walks: where the legs are and when, the page in a browser, GIF and MP4."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html import unescape

import numpy as np
import pytest
from pictures import read
from PIL import Image

import ggo_factors as ggo
from ggo_factors.notebook import svg as colours

BASE = ggo.paper_base_gait()
FEET = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(ankle_height=0.07, heel=0.05, toe=0.12))
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def stairs():
    return ggo.climb_stairs(BASE, 0.12, tread=0.35, steps=4, pace=0.8)


def test_the_legs_are_where_the_walk_has_them(stairs):
    made = stairs.animate()
    right, left = made.lines
    assert made.colours == (colours.RIGHT, colours.LEFT)
    times = np.linspace(0.0, made.duration, len(right))
    assert made.duration == pytest.approx(stairs.times[-1])
    assert times[1] == pytest.approx(1.0 / 25.0, rel=0.02)
    # Thighs and shanks by the joint trajectory, which knows nothing of steps and places.
    path = stairs.joint_trajectory()
    for leg, line in (("right", right), ("left", left)):
        thigh = np.interp(times, path.time, getattr(path, f"{leg}_hip"))
        shank = thigh - np.interp(times, path.time, getattr(path, f"{leg}_knee"))
        for angle, (up, down) in ((thigh, (0, 1)), (shank, (1, 2))):
            bone = line[:, down] - line[:, up]
            assert bone == pytest.approx(0.39 * np.stack([np.sin(angle), -np.cos(angle)], -1), abs=1e-3)
    assert right[:, 0] == pytest.approx(left[:, 0], abs=1e-9)
    # The last step's foot lands four risers up.
    assert left[-1, 2, 1] == pytest.approx(0.48, abs=0.002)
    assert len(made.still) > 4


def test_the_page_holds_every_picture_to_the_millimetre(stairs):
    made = stairs.animate()
    page = made.html()
    steps = np.array(json.loads(re.search(r"steps = (\[\[.*?\]\])", page)[1]))
    shown = np.cumsum(steps, axis=0)
    want = np.hstack([(row * [1e3, -1e3]).reshape(len(row), -1) for row in made.lines])
    assert shown == pytest.approx(want, abs=0.51)
    assert len(page.encode()) < 60_000
    assert "http" not in page.replace("http-equiv", "")
    assert "@" not in page


def test_a_notebook_shows_the_page_in_a_frame_of_its_own(stairs):
    made = stairs.animate()
    html = made._repr_html_()
    assert read(html)[0] == {"iframe"}
    assert unescape(re.search(r'srcdoc="(.*?)"', html, re.DOTALL)[1]) == made.html()
    assert repr(made) == f"Animation({made.name!r}, {len(made.lines[0])} pictures, {made.duration:.4g} s)"


def test_a_long_walk_is_followed_and_stays_small():
    made = ggo.Walk((BASE,) * 60, (ggo.Step((0.39, 0.0)),) * 60).animate()
    assert len(made.html().encode()) < 60_000
    views = made.views
    assert np.ptp(views[:, 2] - views[:, 0]) == pytest.approx(0.0, abs=1e-9)
    assert views[0, 0] == pytest.approx(made.corners[0])
    assert views[-1, 2] == pytest.approx(made.corners[2])
    for line in made.lines:
        assert (line[..., 0] > views[:, :1]).all()
        assert (line[..., 0] < views[:, 2:3]).all()


def test_any_name_is_only_text():
    gait = ggo.Gait(BASE.frames, BASE.dt, "</title><script>alert(1)</script>", model=BASE.model)
    page = ggo.Walk((gait,), (ggo.Step((0.39, 0.0)),)).animate().html()
    assert page.count("<script>") == 1
    assert "&lt;script&gt;alert(1)" in page


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
def test_in_a_browser_the_legs_move_and_the_slider_with_them(stairs, tmp_path):
    made = stairs.animate()
    page = tmp_path / "walk.html"
    made.save(page)
    # The slider is moved as a hand would; the script must then stop playing and show that picture.
    last = len(made.lines[0]) - 1
    moved = f"<script>slider = document.querySelector('input'); slider.value = {last}; slider.oninput();</script>"
    page.write_text(page.read_text().replace("</body>", f"{moved}</body>"))
    flags = ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")
    asked = [CHROMIUM, *flags, f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", page.as_uri()]
    dom = subprocess.run(asked, capture_output=True, text=True, check=True, timeout=120).stdout
    drawn = re.findall(r'class="moves"[^>]* points="([^"]*)"', dom)
    for line, points in zip(made.lines, drawn, strict=True):
        shown = np.array([float(x) for x in points.split(",")]).reshape(-1, 2)
        assert shown == pytest.approx(line[-1] * [1e3, -1e3], abs=0.51)
    assert f"{made.duration:.2f} s of {made.duration:.2f}" in dom
    assert ">Play</button>" in dom


def test_a_gif_shows_the_legs_of_each_picture(tmp_path):
    gait = ggo.Gait(BASE.frames, BASE.dt, model=FEET)
    made = ggo.Walk((gait,), (ggo.Step((0.39, 0.0)),)).animate()
    made.save(tmp_path / "walk.gif")
    with Image.open(tmp_path / "walk.gif") as picture:
        assert picture.n_frames == len(made.lines[0])
        picture.seek(picture.n_frames - 1)
        last = np.asarray(picture.convert("RGB")).astype(int)
        times = []
        for number in range(picture.n_frames):
            picture.seek(number)
            times.append(picture.info["duration"])
    assert sum(times[:-1]) / 1e3 == pytest.approx(made.duration, abs=0.03)
    left, _, right, _ = made.views[-1]
    orange = np.abs(last - [int(colours.RIGHT[n : n + 2], 16) for n in (1, 3, 5)]).sum(axis=2) < 60
    columns = np.flatnonzero(orange.any(axis=0)) * (right - left) / last.shape[1] + left
    assert columns.max() == pytest.approx(made.lines[0][-1, :, 0].max(), abs=0.02)
    assert columns.min() == pytest.approx(made.lines[0][-1, :, 0].min(), abs=0.02)


def test_a_film_needs_ffmpeg_and_says_so(stairs, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ggo.InputError, match=r"walk\.mp4: needs the program ffmpeg"):
        stairs.animate().save(tmp_path / "walk.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg")
def test_a_film_is_written(stairs, tmp_path):
    stairs.animate().save(tmp_path / "walk.mp4")
    assert (tmp_path / "walk.mp4").read_bytes()[4:8] == b"ftyp"


def test_another_ending_is_refused(stairs, tmp_path):
    with pytest.raises(ggo.InputError, match=r"walk\.png: must end in \.html, \.gif or \.mp4"):
        stairs.animate().save(tmp_path / "walk.png")


def test_a_walk_of_unknown_legs_is_refused():
    bare = ggo.Gait(BASE.frames, BASE.dt)
    with pytest.raises(ggo.InputError, match="states no leg lengths"):
        ggo.Walk((bare,), (ggo.Step((0.39, 0.0)),)).animate()
