"""The comfort report: its numbers by hand and by the metrics, its table, its JSON and its picture."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from paper_metrics import smoothness

mpl.use("Agg")

from matplotlib import pyplot as plt

import ggo_factors as ggo
from ggo_factors.cli import main
from ggo_factors.evaluate.comfort import WALK_JOINTS, comfort
from ggo_factors.evaluate.metrics import zmp
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.plot import plot_comfort

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.20, 0.25, 0.08)


@pytest.fixture(scope="module")
def over() -> ggo.Gait:
    return ggo.step_over(BASE, [BOX], foothold=(0.39, 0.0)).gait


@pytest.fixture(scope="module")
def stairs() -> ggo.Walk:
    return ggo.climb_stairs(BASE)


def of_step(gait, name="gait", base=BASE):
    return comfort(name, [gait], [ggo.verify(gait, obstacles=[BOX])], base)


def test_one_step_by_hand():
    # alpha2 goes 0, 1, 4, 9 degrees in frames 0.1 s apart: 10, 30, 50 degrees/s; 200 degrees/s^2; no jerk.
    frames = np.zeros((4, 4))
    frames[:, 2] = np.radians([0.0, 1.0, 4.0, 9.0])
    gait = ggo.Gait(frames, 0.1, model=BASE.model)
    made = comfort("by hand", [gait], [ggo.verify(gait)])
    assert made.joints == JOINTS
    np.testing.assert_allclose(np.degrees(made.peaks[:, 2]), [50.0, 200.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(np.degrees(made.rms[:, 2]), [math.sqrt((100 + 900 + 2500) / 3), 200.0, 0.0], atol=1e-9)
    assert not made.peaks[:, [0, 1, 3]].any()
    assert math.isnan(made.change)
    assert made.clearance == made.leg_clearance == math.inf


def test_one_step_beside_the_metrics(over):
    made = of_step(over)
    known = smoothness(over, BASE)
    largest = [known.velocity_largest, known.acceleration_largest, known.jerk_largest]
    np.testing.assert_allclose(made.peaks.max(axis=1), largest, rtol=1e-12)
    rms = [known.velocity_rms, known.acceleration_rms, known.jerk_rms]
    np.testing.assert_allclose(np.sqrt((made.rms**2).mean(axis=1)), rms, rtol=1e-12)
    assert made.zmp == pytest.approx(np.abs(zmp(over)).mean())
    off = np.abs(zmp(over) - zmp(BASE))
    assert (made.zmp_off, made.zmp_off_largest) == pytest.approx((off.mean(), off.max()))
    assert of_step(BASE).zmp_off == of_step(BASE).zmp_off_largest == 0.0
    assert math.isnan(of_step(over, base=None).zmp_off)
    assert made.change == pytest.approx(np.abs(over.frames - BASE.frames).mean())
    assert made.clearance == ggo.verify(over, obstacles=[BOX]).clearance
    assert of_step(BASE).change == 0.0


def test_a_walk_runs_on_across_the_change_of_legs(stairs):
    made = comfort("stairs", stairs.gaits, stairs.verify(), BASE)
    assert made.joints == WALK_JOINTS
    trajectory = stairs.joint_trajectory(first_swing="right")
    columns = [getattr(trajectory, joint.replace(" ", "_")) for joint in made.joints]
    for order in (1, 2, 3):
        rates = np.diff(np.stack(columns, -1), order, axis=0) / BASE.dt**order
        np.testing.assert_allclose(made.peaks[order - 1], np.abs(rates).max(axis=0), rtol=1e-9)
        np.testing.assert_allclose(made.rms[order - 1], np.sqrt((rates**2).mean(axis=0)), rtol=1e-9)


def test_a_kink_where_the_legs_change_is_felt():
    # Each step is as smooth as the base gait; the second one goes on at half the pace.
    slow = BASE.frames[:25:1]
    stretched = np.stack([np.interp(np.linspace(0, 24, 51), np.arange(25), column) for column in slow.T], -1)
    second = replace(BASE, frames=stretched + BASE.swapped().frames[-1] - stretched[0])
    gaits = (BASE, second)
    reports = [ggo.verify(gait) for gait in gaits]
    alone = max(comfort("", [gait], [report]).peaks[2].max() for gait, report in zip(gaits, reports, strict=True))
    assert comfort("", gaits, reports).peaks[2].max() > 2.0 * alone


def test_steps_that_do_not_join_count_each_for_itself():
    apart = replace(BASE, frames=BASE.frames + 0.1)
    made = comfort("", [BASE, apart], [ggo.verify(BASE)] * 2)
    one = comfort("", [BASE], [ggo.verify(BASE)])
    both = np.maximum(one.peaks, one.peaks[:, [2, 3, 0, 1]])
    np.testing.assert_allclose(made.peaks, both, rtol=1e-9)


def test_what_has_no_numbers_is_refused():
    report = ggo.verify(BASE)
    with pytest.raises(ggo.InputError, match="reports: 0 for 1 steps"):
        comfort("", [BASE], [])
    with pytest.raises(ggo.InputError, match="reports: 0 for 0 steps"):
        comfort("", [], [])
    with pytest.raises(ggo.InputError, match="step 1: 3 frames, jerk needs at least 4"):
        comfort("", [replace(BASE, frames=BASE.frames[:3])], [report])
    with pytest.raises(ggo.InputError, match="base: 21 frames, the gait has 51"):
        comfort("", [BASE], [report], BASE.resampled(21))
    with pytest.raises(ggo.InputError, match="2 base gaits for 1 steps"):
        comfort("", [BASE], [report], [BASE, BASE])


def test_the_picture_shows_the_numbers(over):
    gait, base = of_step(over, "over"), of_step(BASE, "base gait")
    panels = plot_comfort([gait, base])
    for row, ax in enumerate(panels):
        bars = {made.name: [p.get_height() for p in ax.patches if p.get_gid() == made.name] for made in (gait, base)}
        np.testing.assert_allclose(bars["over"], np.degrees(gait.peaks[row]))
        np.testing.assert_allclose(bars["base gait"], np.degrees(base.peaks[row]))
        marks = np.concatenate([[y for _, y in line[:1]] for marks in ax.collections for line in marks.get_segments()])
        np.testing.assert_allclose(marks, np.degrees([*gait.rms[row], *base.rms[row]]))
    (legend,) = panels[0].figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["over", "base gait", "root mean square"]
    plt.close("all")


def test_the_picture_refuses_what_cannot_be_compared(over, stairs):
    walk = comfort("stairs", stairs.gaits, stairs.verify())
    with pytest.raises(ggo.InputError, match="'stairs' is of left hip, left knee"):
        plot_comfort([of_step(over), walk])
    with pytest.raises(ggo.InputError, match="0 gaits, from 1 to 5"):
        plot_comfort([])
    with pytest.raises(ggo.InputError, match="axes: expected three, got 0"):
        plot_comfort([walk], axes=[])
    assert plt.get_fignums() == []


def test_the_command_puts_the_base_gait_beside_it(over, tmp_path, capsys):
    file = tmp_path / "over.csv"
    over.save(file)
    assert main(["verify", str(file), "--obstacle", "0.2,0.25,0.08", "--report", "--base", "paper", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    mine, base = said["comfort"]
    made = of_step(over)
    assert list(mine["acceleration_peak_deg_s2"]) == list(JOINTS)
    assert list(mine["acceleration_peak_deg_s2"].values()) == pytest.approx(np.degrees(made.peaks[1]), rel=1e-6)
    assert mine["clearance_mm"] == pytest.approx(made.clearance * 1e3, abs=1e-6)
    assert (base["name"], base["mean_change_deg"]) == ("base gait", None)
    assert base["clearance_mm"] < 0.0  # it walks through the box
    assert mine["leg_clearance_mm"] is None
    assert said["steps"][0]["change_deg"]["alpha2"] == pytest.approx(
        math.degrees(np.abs(over.frames - BASE.frames)[:, 2].mean())
    )


def test_the_command_reports_a_walk_in_a_table(stairs, tmp_path, capsys):
    file = tmp_path / "stairs.csv"
    stairs.save(file)
    assert main(["verify", str(file), "--report"]) == 0
    out = capsys.readouterr().out
    made = comfort("", stairs.gaits, stairs.verify())
    for joint, peak in zip(WALK_JOINTS, np.degrees(made.peaks[1]), strict=True):
        (line,) = [line for line in out.splitlines() if joint in line]
        assert f" {peak:.0f} " in line
    assert main(["verify", str(file)]) == 0
    assert "left hip" not in capsys.readouterr().out


def test_the_command_draws_it(stairs, tmp_path, capsys):
    file, picture = tmp_path / "stairs.csv", tmp_path / "comfort.png"
    stairs.save(file)
    assert main(["plot", str(file), "--what", "comfort", "--base", "paper", "-o", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
