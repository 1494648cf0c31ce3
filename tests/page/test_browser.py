"""The page of a report in a real browser without a window: Chromium, driven by chromedriver."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.plot.panels import LEG_COLOURS

BROWSERS = ("chrome", "google-chrome", "chromium", "chromium-browser")
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update", "--disable-dev-shm-usage"),
)
REQUIRED = "GGO_BROWSER_REQUIRED"
"""Environment variable: where it is set, no browser is a failure and not a reason to skip."""
NARROW, WIDE = 360, 1600


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    browsers = [found for found in map(shutil.which, BROWSERS) if found]
    driver = shutil.which("chromedriver")
    if not browsers or driver is None:
        message = "Chromium and chromedriver are not there"
        if os.environ.get(REQUIRED):
            pytest.fail(message)
        pytest.skip(message)
    webdriver = pytest.importorskip("selenium.webdriver")
    options = webdriver.ChromeOptions()
    options.binary_location = browsers[0]
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    made = webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=driver))
    yield made
    made.quit()


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Pages of walks and gaits of several kinds."""
    folder, base = tmp_path_factory.mktemp("pages"), ggo.paper_base_gait()
    box = ggo.Obstacle(0.20, 0.25, 0.08, 0.005, 0.005)
    steps = [ggo.Step((0.45, 0.0), obstacles=(box,)), ggo.Step((0.39, 0.0))]
    foot = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.05, 0.13))
    ramp = ggo.Terrain.level(0.9) + ggo.Terrain.ramp(1.2, 0.14)
    made = {
        "box": ggo.walk(base, steps, first_swing="left"),
        "stairs": ggo.climb_stairs(base),
        "ramp": ggo.plan_walk(ggo.Gait(base.frames, base.dt, "<script>", model=foot), ramp, goal=1.6).walk,
        "gait": base,
        "unsafe": ggo.Walk((base,), (ggo.Step((0.39, 0.0), obstacles=(box,)),)),
    }
    for name, walk in made.items():
        walk.save(folder / f"{name}.csv")
        code = main(["report", str(folder / f"{name}.csv"), "--base", "paper", "-o", str(folder / f"{name}.html")])
        assert code == (3 if name == "unsafe" else 0)
    return {name: folder / f"{name}.html" for name in made}


def opened(browser: Any, page: Path, width: int = WIDE) -> dict[str, Any]:
    """Open a page in a window of some width, and read its numbers."""
    size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    browser.get(page.as_uri())
    return json.loads(browser.execute_script("return document.getElementById('numbers').textContent"))


def text(browser: Any, name: str) -> str:
    return browser.find_element("id", name).text


def points(browser: Any, selector: str) -> np.ndarray:
    """The points of a line or a polygon, shape (n, 2)."""
    given = browser.find_element("css selector", selector).get_attribute("points")
    return np.array([[float(value) for value in point.split(",")] for point in given.split()])


def move_to(browser: Any, at: int) -> None:
    browser.execute_script(
        "const s = document.getElementById('slider'); s.value = arguments[0]; s.dispatchEvent(new Event('input'));", at
    )


@pytest.mark.parametrize("width", [NARROW, WIDE])
@pytest.mark.parametrize("name", ["box", "stairs", "ramp", "gait", "unsafe"])
def test_no_page_is_wider_than_its_window_nor_has_an_error(browser, pages, name, width):
    opened(browser, pages[name], width)
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    for tag in ("table", "figure", ".player", "dd", "li"):
        rights = browser.execute_script(
            "return [...document.querySelectorAll(arguments[0])].map((e) => e.getBoundingClientRect().right)", tag
        )
        assert max(rights, default=0.0) <= width, tag
    assert browser.get_log("browser") == []
    assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0


@pytest.mark.parametrize("name", ["box", "ramp"])
def test_the_slider_moves_the_legs(browser, pages, name):
    numbers = opened(browser, pages[name])
    motion = numbers["motion"]
    for at in (0, len(motion["time_s"]) // 3, len(motion["time_s"]) - 1):
        move_to(browser, at)
        places = np.reshape(motion["joints_m"][at], (5, 2)) * (1e3, -1e3)
        np.testing.assert_allclose(points(browser, "#stage .leg.left"), places[[2, 1, 0]], atol=0.051)
        np.testing.assert_allclose(points(browser, "#stage .leg.right"), places[[2, 3, 4]], atol=0.051)
        view = browser.execute_script("return document.getElementById('stage').getAttribute('viewBox')")
        left, top, width, height = map(float, view.split())
        inside = (places > (left, top)).all(axis=0) & (places < (left + width, top + height)).all(axis=0)
        assert inside.all()
    if name == "ramp":
        ankle, (heel, toe, top) = places[4], points(browser, "#stage .foot.right")
        np.testing.assert_allclose(top, ankle, atol=0.051)
        assert np.hypot(*(toe - heel)) == pytest.approx(180.0, abs=0.2)
        assert np.arctan2(heel[1] - toe[1], toe[0] - heel[0]) == pytest.approx(motion["tilt_rad"][-1][1], abs=1e-3)


def test_arrow_keys_move_on_and_tell_what_is_seen(browser, pages):
    motion = opened(browser, pages["box"])["motion"]
    over = [at for at, clear in enumerate(motion["clearance_mm"]) if clear is not None]
    move_to(browser, over[0] - 1)
    assert text(browser, "clearance") == "not over one"
    slider = browser.find_element("id", "slider")
    slider.send_keys("\ue014")  # right
    assert slider.get_attribute("value") == str(over[0])
    assert text(browser, "clearance") == f"{motion['clearance_mm'][over[0]]:.1f} mm"
    assert text(browser, "time") == f"{motion['time_s'][over[0]]:.2f} s"
    assert text(browser, "step") == "1 of 2"
    assert text(browser, "swings") == "left"
    assert slider.get_attribute("aria-valuetext").endswith(text(browser, "clearance"))
    assert slider.accessible_name == "Time"
    slider.send_keys("\ue010")  # end
    assert text(browser, "step") == "2 of 2"
    assert text(browser, "clearance") == "none in this step"
    assert text(browser, "swings") == "right"


def test_space_plays_and_pauses(browser, pages):
    from selenium.webdriver.support.ui import WebDriverWait

    motion = opened(browser, pages["box"])["motion"]
    slider, play = browser.find_element("id", "slider"), browser.find_element("id", "play")
    assert play.text == "Play"
    slider.send_keys(" ")
    assert play.text == "Pause"
    WebDriverWait(browser, 20).until(lambda _: int(slider.get_attribute("value")) > 5)
    slider.send_keys("\n")
    assert play.text == "Play"
    stopped = slider.get_attribute("value")
    assert browser.execute_async_script("setTimeout(arguments[0], 200)") is None
    assert slider.get_attribute("value") == stopped
    # Played to its end it stops, and begins again when it is played again.
    move_to(browser, len(motion["time_s"]) - 3)
    play.send_keys(" ")
    WebDriverWait(browser, 20).until(lambda _: play.text == "Play")
    assert slider.get_attribute("value") == str(len(motion["time_s"]) - 1)
    play.send_keys("\n")
    assert int(slider.get_attribute("value")) < len(motion["time_s"]) - 1


def test_the_cursor_of_the_charts_goes_with_the_slider(browser, pages):
    motion = opened(browser, pages["box"])["motion"]
    at = len(motion["time_s"]) // 4
    move_to(browser, at)
    share = motion["time_s"][at] / motion["time_s"][-1]
    lines = browser.find_elements("css selector", ".chart .now")
    assert len(lines) == 4
    for line in lines:
        first, last = (float(line.get_attribute(f"data-{end}")) for end in ("first", "last"))
        assert float(line.get_attribute("x1")) == pytest.approx(first + share * (last - first), abs=0.06)


@pytest.mark.parametrize("name", ["box", "stairs", "unsafe"])
def test_numbers_are_the_jsons_rounded(browser, pages, name):
    numbers = opened(browser, pages[name], NARROW)
    shown = browser.execute_script(
        "return [...document.querySelectorAll('data')].map((e) => [e.dataset.path, e.textContent, e.value])"
    )
    assert len(shown) > 60
    for path, said, value in shown:
        told: Any = numbers
        for key in path.split("/"):
            told = told[int(key) if isinstance(told, list) else key]
        assert float(value) == told
        written = said.replace("\u2212", "-")
        mantissa, _, power = written.partition("e")
        place = len(mantissa.partition(".")[2]) - int(power or 0)
        assert abs(float(written) - told) <= 0.5001 * 10.0**-place or f"{told:.4g}" == written, path


def test_a_leg_has_one_colour_everywhere(browser, pages):
    opened(browser, pages["ramp"])
    for leg, colour in LEG_COLOURS.items():
        rgb = "rgb({}, {}, {})".format(*(int(colour[k : k + 2], 16) for k in (1, 3, 5)))
        drawn = browser.execute_script(
            "return [...document.querySelectorAll('.leg.NAME, .own.NAME, .joint.NAME')]"
            ".map((e) => getComputedStyle(e).stroke)".replace("NAME", leg)
        )
        assert len(drawn) > 20
        assert set(drawn) == {rgb}


def test_print_shows_figures_in_place_of_the_animation(browser, pages):
    opened(browser, pages["box"])
    player, strip = (browser.find_element("css selector", name) for name in (".player", ".strip"))
    assert (player.is_displayed(), strip.is_displayed()) == (True, False)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert (player.is_displayed(), strip.is_displayed()) == (False, True)
    assert len(strip.find_elements("css selector", "figure")) == 8
    printed = browser.execute_cdp_cmd("Page.printToPDF", {"paperWidth": 8.27, "paperHeight": 11.69})
    assert len(printed["data"]) > 10_000


def test_what_is_broken_is_read_without_colour(browser, pages):
    numbers = opened(browser, pages["unsafe"])
    verdict = browser.find_element("css selector", ".verdict").text
    assert verdict.startswith("\u2717 Not safe: ")
    assert verdict.count("the limit is") == len(numbers["violations"]) > 0
    least = numbers["steps"][0]["clearance_mm"]
    assert least < 0.0
    assert text(browser, "least") == f"\u2212{-least:.1f} mm"
