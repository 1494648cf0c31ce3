"""`ggo report`: what it writes and prints, its exit codes, and that no text from a file is obeyed."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.motion.recorded import Recorded
from ggo_factors.plot.panels import LEG_COLOURS

BASE = ggo.paper_base_gait()
HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"' &amp; \u2028"


class Page(HTMLParser):
    """Tags with their attributes, the text of each script, and the text that is seen."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags, self.scripts, self.seen, self.inside = [], [], "", ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.inside = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag):
        self.inside = ""
        if tag in ("td", "th", "li", "p", "dt", "dd"):
            self.seen += "\n"

    def handle_data(self, data):
        if self.inside == "script":
            self.scripts[-1] += data
        elif self.inside != "style":
            self.seen += data


def written(tmp_path: Path, gait: ggo.Gait | ggo.Walk, *flags: object) -> tuple[int, Page]:
    """The exit code of the command, and the page that it wrote."""
    path, page = tmp_path / "walk.csv", tmp_path / "report.html"
    gait.save(path)
    code = main(["report", str(path), "-o", str(page), *map(str, flags)])
    return code, Page(page.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def over_a_box() -> ggo.Walk:
    return ggo.walk(BASE, [ggo.Step((0.45, 0.0), obstacles=(ggo.Obstacle(0.20, 0.25, 0.08),))])


@pytest.fixture
def damaged(over_a_box) -> ggo.Walk:
    frames = over_a_box.gaits[0].frames.copy()
    frames[20, 3] += np.radians(25.0)
    return replace(over_a_box, gaits=(replace(over_a_box.gaits[0], frames=frames),))


def test_the_page_holds_the_numbers_that_json_prints(over_a_box, tmp_path, capsys):
    code, page = written(tmp_path, over_a_box, "--base", "paper", "--json")
    printed = json.loads(capsys.readouterr().out)
    assert code == 0
    assert json.loads(page.scripts[0]) == printed
    assert (printed["format"], printed["format_version"], printed["kind"]) == ("ggo-report", 1, "walk")


def test_steps_are_those_of_verify(over_a_box, tmp_path, capsys):
    over_a_box.save(tmp_path / "walk.csv")
    told = []
    for command in ("verify", "report"):
        assert main([command, str(tmp_path / "walk.csv"), "--base", "paper", "--json"]) == 0
        told.append(json.loads(capsys.readouterr().out)["steps"][0])
    assert told[1].items() >= told[0].items()


def test_without_a_page_json_alone_is_printed(over_a_box, tmp_path, capsys):
    over_a_box.save(tmp_path / "walk.csv")
    assert main(["report", str(tmp_path / "walk.csv"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ok"] is True
    assert [path.name for path in tmp_path.iterdir()] == ["walk.csv"]


@pytest.mark.parametrize(
    ("flags", "said"),
    [((), "--output: give the page to write, or --json"), (("-o", "report.pdf"), "must end in .html or .htm")],
)
def test_what_to_write_must_be_plain(over_a_box, tmp_path, capsys, flags, said):
    over_a_box.save(tmp_path / "walk.csv")
    assert main(["report", str(tmp_path / "walk.csv"), *flags]) == 2
    assert said in capsys.readouterr().err


def test_a_page_that_cannot_be_written_leaves_nothing(over_a_box, tmp_path, capsys, monkeypatch):
    over_a_box.save(tmp_path / "walk.csv")
    old = tmp_path / "report.html"
    old.write_text("the old one")

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    assert main(["report", str(tmp_path / "walk.csv"), "-o", str(old)]) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert old.read_text() == "the old one"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "walk.csv"]


def test_what_is_broken_is_said_in_words_and_the_page_is_there(damaged, tmp_path, capsys):
    code, page = written(tmp_path, damaged)
    assert code == 3
    assert "step 1 is not safe: knee spike" in capsys.readouterr().err
    numbers = json.loads(page.scripts[0])
    assert numbers["ok"] is False
    assert f"Not safe: {len(numbers['violations'])} limits are broken" in page.seen
    fault = numbers["violations"][0]
    assert f"knee spike (swing leg) is {fault['value']:.4g} deg; the limit is {fault['limit']:.4g} deg" in page.seen
    assert "BROKEN in step 1" in page.seen
    assert "Every check is kept" not in page.seen


def test_one_broken_limit_is_in_the_singular(over_a_box, tmp_path):
    high = replace(over_a_box.plan[0], obstacles=(ggo.Obstacle(0.20, 0.25, 0.13),))
    points = ggo.LegModel(0.39, 0.39, bones="points")
    walk = replace(over_a_box, plan=(high,), gaits=(replace(over_a_box.gaits[0], model=points),))
    code, page = written(tmp_path, walk)
    assert code == 3
    assert "Not safe: 1 limit is broken" in page.seen


def test_text_from_a_file_is_shown_and_not_obeyed(tmp_path):
    gait = replace(BASE, name=HOSTILE.replace("\u2028", ""), origin=HOSTILE.replace("\u2028", ""))
    code, page = written(tmp_path, gait)
    assert code == 0
    assert [tag for tag, _ in page.tags].count("script") == 2
    assert "img" not in [tag for tag, _ in page.tags]
    assert json.loads(page.scripts[0])["name"] == gait.name
    assert page.seen.count(gait.name) >= 2  # heading, and where it comes from


def test_a_file_may_be_called_anything(over_a_box, tmp_path):
    path = tmp_path / "<b>&'\u2028\x01.csv"
    over_a_box.save(path)
    assert main(["report", str(path), "-o", str(tmp_path / "report.html")]) == 0
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert ("b", {}) not in page.tags
    assert "<b>&'\\u2028\\x01.csv" in page.seen
    assert json.loads(page.scripts[0])["source"]["file"] == path.name


def test_nothing_is_asked_of_the_net(over_a_box, tmp_path):
    _, page = written(tmp_path, over_a_box)
    for tag, attributes in page.tags:
        assert "src" not in attributes
        assert "action" not in attributes
        assert attributes.get("href", "data:,") == "data:,", tag
    (policy,) = [tags["content"] for tag, tags in page.tags if tags.get("http-equiv") == "Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; ")
    assert "http" not in (tmp_path / "report.html").read_text(encoding="utf-8").replace("http-equiv", "")


def test_every_number_is_the_jsons_and_has_its_unit(damaged, tmp_path):
    _, page = written(tmp_path, damaged, "--base", "paper", "--limits")
    numbers, told = json.loads(page.scripts[0]), 0
    for tag, attributes in page.tags:
        if tag == "data":
            value = numbers
            for key in attributes["data-path"].split("/"):
                value = value[int(key) if isinstance(value, list) else key]
            assert float(attributes["value"]) == value, attributes
            told += 1
    assert told > 60
    for name in ("mm", "m/s", "deg", "deg/s", "deg/s\u00b2", "%", "s"):
        assert re.search(rf"\d\u00a0{re.escape(name)}(?![\w/])", page.seen), name


def test_a_gait_of_unknown_legs_is_named_by_its_roles(tmp_path):
    _, page = written(tmp_path, BASE)
    assert "Swinging knee" in page.seen
    assert "supporting leg" in page.seen
    assert "Right knee" not in page.seen


def test_legs_have_the_colours_of_the_figures(over_a_box, tmp_path):
    written(tmp_path, over_a_box)
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert {leg: re.search(rf"--{leg}: (#\w+);", text)[1] for leg in LEG_COLOURS} == LEG_COLOURS


def test_the_spread_of_the_base_gaits_strides_is_a_band_around_it(over_a_box, tmp_path):
    spread = np.radians(np.full((51, 4), 5.0))
    replace(BASE, recorded=Recorded(12, spread)).save(tmp_path / "base.csv")
    _, page = written(tmp_path, over_a_box, "--base", tmp_path / "base.csv")
    assert "with a band of one standard deviation of its strides" in page.seen
    assert "paper base gait: 12" in page.seen
    bands, dashed = (
        [tags["points"] for _, tags in page.tags if tags.get("class") == name] for name in ("band", "base")
    )
    assert len(bands) == len(dashed) == 4
    for band, middle in zip(bands, dashed, strict=True):
        around, between = (np.array([point.split(",") for point in line.split()], float) for line in (band, middle))
        np.testing.assert_allclose((around[:51] + around[:50:-1]) / 2.0, between, atol=0.11)
        assert np.ptp(around[:51, 1] - around[:50:-1, 1]) <= 0.21
        assert (around[:51, 1] < between[:, 1] - 5.0).all()


def test_print_has_a_strip_with_the_least_clearance(over_a_box, tmp_path):
    _, page = written(tmp_path, over_a_box)
    least = min(clear for clear in json.loads(page.scripts[0])["motion"]["clearance_mm"] if clear is not None)
    assert f"clears by {least:.1f} mm" in page.seen
    assert [tag for tag, _ in page.tags].count("figcaption") == 4 + 8


def test_what_the_bones_are_is_noted(over_a_box, tmp_path):
    _, page = written(tmp_path, over_a_box, "--bones", "points")
    assert "bones are points" in page.seen
