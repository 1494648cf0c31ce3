"""Verdicts on the motion: who runs, how fast a walk is, which knee is bent back, whose clock a leg follows."""

from __future__ import annotations

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, joint_state, write_messages
from test_import_base_gait import import_log
from test_import_refusals import NAMES, log_of, walk

import ggo_factors as ggo
from ggo_factors.recording.log.read_log import read_log

STATE = (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")
ANGLES = walk(2000)


def crouched(bend_deg, period, sway_deg=18.0, count=3000):
    """An exoskeleton's crouched step: knees bent by `bend_deg` all the time, and more in the swing."""
    phase = np.arange(count)[:, None] / 100.0 / period + np.array([0.0, 0.5])
    hip = 0.5 * bend_deg + sway_deg * np.cos(2 * np.pi * (phase - 0.95))
    lift = np.maximum(0.0, np.sin(2 * np.pi * (phase - 0.5))) ** 2
    knee = bend_deg + 30.0 * lift
    angles = np.radians(np.stack([hip + 10.0 * lift, knee], -1)).reshape(count, 4)
    return angles + np.random.default_rng(1).normal(0, 0.001, angles.shape)


@pytest.mark.parametrize("name", ["level_wpi_s03_slow", "level_exo_march"])
def test_the_slow_do_not_run(recordings, name):
    report = import_log(recordings, name, min_strides=2)
    assert report.speed == pytest.approx(report.gait.stride() / report.stride_time[0])
    assert 0.05 < report.speed < 0.8
    assert not any("climb" in note for note in report.notes)


@pytest.mark.parametrize(("bend", "period"), [(25.0, 2.0), (35.0, 3.0), (45.0, 4.0)])
def test_a_crouched_slow_step_is_no_run(tmp_path, bend, period):
    path = log_of(tmp_path / "a.mcap", crouched(bend, period))
    report = ggo.import_base_gait(path, joints="direct")
    assert 0.2 < report.speed < 1.0
    assert any("toe-off at 48 % of the stride, so no double support" in note for note in report.notes)


@pytest.mark.parametrize("lifted", [0.4, 0.5, 0.6, 0.7])
@pytest.mark.parametrize("degrees", [50.0, 80.0])
def test_marching_is_no_walk(tmp_path, lifted, degrees):
    phase = (np.arange(1500)[:, None] / 120.0 + np.array([0.0, 0.5])) % 1.0
    lift = np.where(phase < lifted, np.sin(np.pi * phase / lifted) ** 2, 0.0) * np.radians(degrees)
    angles = np.stack([lift + 0.05, lift + 0.1], -1).reshape(1500, 4)
    angles += np.random.default_rng(1).normal(0, 0.002, angles.shape)
    with pytest.raises(ggo.LogError, match="not walking: toe-off at"):
        ggo.import_base_gait(log_of(tmp_path / "a.mcap", angles), joints="direct")


@pytest.mark.parametrize("slower", [1.0, 1.6])
@pytest.mark.parametrize("foothold", [0.2, 0.3, 0.45])
def test_own_walks_are_read_as_fast_as_they_are(tmp_path, foothold, slower):
    base = ggo.paper_base_gait(51)
    ggo.export_mcap(ggo.walk(base, [ggo.Step(foothold=(foothold, 0.0))] * 9), tmp_path / "a.mcap")
    log = read_log(tmp_path / "a.mcap", topic="/joint_states", names=NAMES)
    clock = np.arange(0.0, slower * log.times[-1], 0.01)
    angles = np.stack([np.interp(clock, slower * log.times, column) for column in log.values.T], -1)
    report = ggo.import_base_gait(log_of(tmp_path / "b.mcap", angles), joints="direct")
    assert report.speed == pytest.approx(foothold / (slower * base.duration), rel=0.12)
    assert report.speed == pytest.approx(report.gait.stride() / report.stride_time[0])
    assert all(length > 0.0 for length in report.step_lengths.values())


def test_runners_are_still_refused(recordings):
    with pytest.raises(ggo.LogError, match=r"running, not walking.* m/s \(Froude number"):
        import_log(recordings, "refuse_running", min_strides=1)


@pytest.mark.parametrize("joints", [(1, 3), (3,), (0, 1, 2, 3)])
@pytest.mark.parametrize("degrees", [20, 28])
def test_a_hyperextended_knee_is_the_reason(tmp_path, joints, degrees):
    angles = ANGLES.copy()
    angles[:, joints] -= np.radians(degrees)
    with pytest.raises(ggo.LogError) as error:
        ggo.import_base_gait(log_of(tmp_path / "a.mcap", angles), joints="direct")
    for leg, column in (("left", 1), ("right", 3)):
        assert (f"the {leg} one by {degrees - 1} degrees" in str(error.value).replace(" and", " degrees and")) is (
            column in joints
        )
    assert "hyperextended" in str(error.value)
    assert "the stride is" not in str(error.value)


def late(angles, samples, leg=slice(0, 2)):
    """The angles with one leg behind by `samples`, a number or one for each sample."""
    result = angles.copy()
    at = np.arange(len(angles), dtype=float)
    for column in range(*leg.indices(4)):
        result[:, column] = np.interp(at - samples, at, angles[:, column])
    return result[300:-300]


@pytest.mark.parametrize("samples", [-20, 15, 20])
def test_a_leg_that_is_late_is_noted(tmp_path, samples):
    report = ggo.import_base_gait(log_of(tmp_path / "a.mcap", late(ANGLES, samples)), joints="direct")
    (note,) = (note for note in report.notes if "a limp, or a clock of its own" in note)
    place = 50.0 + samples / 1.1
    assert f"{abs(samples) / 100:.2f} s {'late' if samples > 0 else 'early'}" in note
    assert abs(float(note.split(" at ")[1].split(" %")[0]) - place) < 2.0


def test_a_leg_that_is_very_late_is_the_reason(tmp_path):
    with pytest.raises(ggo.LogError, match=r"left leg lands at (8\d|9\d) % .* a clock of its own"):
        ggo.import_base_gait(log_of(tmp_path / "a.mcap", late(ANGLES, 38)), joints="direct")


@pytest.mark.parametrize("rate", [0.98, 1.015])
def test_a_clock_that_drifts_is_noted(tmp_path, rate):
    angles = late(ANGLES, (1.0 - rate) * (np.arange(len(ANGLES)) - 1000.0))
    report = ggo.import_base_gait(log_of(tmp_path / "a.mcap", angles), joints="direct")
    assert any("two clocks that run at different rates?" in note for note in report.notes)


def test_an_even_walk_has_no_note_of_clocks(tmp_path, recordings):
    for report in (
        ggo.import_base_gait(log_of(tmp_path / "a.mcap", ANGLES), joints="direct"),
        import_log(recordings, "level_csic_s10"),
        import_log(recordings, "level_nonan_middle"),
    ):
        assert not any("clock" in note for note in report.notes)


@pytest.mark.parametrize(
    ("offset", "rate", "said"),
    [(0.2, 1.0, "+0.20 s"), (-0.15, 1.0, "-0.15 s"), (0.0, 1.01, "+0.01 s from /left at the start and +0.19 s at")],
)
def test_topics_on_two_clocks(tmp_path, offset, rate, said):
    messages = []
    for n, row in enumerate(ANGLES.tolist()):
        at = START_NS + n * 10**7
        other = START_NS + int((offset + n * 0.01 * rate) * 1e9)
        messages.append(("/left", at, at, joint_state(at, NAMES[:2], row[:2])))
        messages.append(("/right", at + 10**6, at + 10**6, joint_state(other + 10**6, NAMES[2:], row[2:])))
    path = write_messages(tmp_path / "a.mcap", dict.fromkeys(("/left", "/right"), STATE), messages)
    (note,) = (note for note in read_log(path, names=NAMES).notes if "two clocks?" in note)
    assert f"/right is {said}" in note
