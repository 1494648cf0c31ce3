"""Recordings that look like a walk and would make a wrong base gait: refused, each by what gives it away."""

from pathlib import Path

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, joint_state, write_messages
from scipy.interpolate import CubicSpline

import ggo_factors as ggo
from ggo_factors.cli import main

NAMES = ("left_hip", "left_knee", "right_hip", "right_knee")
SAMPLE = Path(__file__).parents[2] / "datasets" / "children_walk.mcap"


def walk(count=1500, stride_time=1.1):
    """Thigh and knee of both legs in [rad] at 100 Hz, shape (count, 4): two harmonics each, legs half a cycle apart."""
    phase = np.arange(count)[:, None] / 100.0 / stride_time + np.array([0.0, 0.5])
    hip = np.radians(9 + 21 * np.cos(2 * np.pi * (phase - 0.93)) + 3 * np.cos(4 * np.pi * (phase - 0.1)))
    knee = np.radians(24 - 22 * np.cos(2 * np.pi * (phase - 0.27)) - 16 * np.cos(4 * np.pi * (phase - 0.47)))
    angles = np.stack([hip, np.maximum(knee, np.radians(1))], -1).reshape(count, 4)
    return angles + np.random.default_rng(1).normal(0, 0.002, angles.shape)


def log_of(path, angles, names=NAMES):
    times = [START_NS + n * 10**7 for n in range(len(angles))]
    messages = [
        ("/joint_states", at, at, joint_state(at, names, row)) for at, row in zip(times, angles.tolist(), strict=True)
    ]
    write_messages(path, {"/joint_states": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages)
    return path


def test_the_walk_itself_is_taken(tmp_path):
    assert ggo.import_base_gait(log_of(tmp_path / "a.mcap", walk()), joints="direct").gait.stride() > 0.9


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda a: a[:, [0, 3, 2, 3]], r"the left knee \(left_knee\) bends while its own thigh swings back"),
        (lambda a: a + np.radians([30.0, 0, 30.0, 0]), "no base gait: .* degrees for both feet to stand"),
    ],
    ids=["one knee twice", "hips off by 30 degrees"],
)
def test_wrong_kinematics_are_refused(tmp_path, change, message):
    path = log_of(tmp_path / "a.mcap", change(walk()))
    with pytest.raises(ggo.LogError, match=message):
        ggo.import_base_gait(path, joints="direct")


def test_a_preset_that_passes_over_the_pelvis_writes_no_gait(tmp_path, capsys):
    assert main(["import", str(SAMPLE), "--joints", "direct", "-o", str(tmp_path / "x.csv")]) == 2
    said = capsys.readouterr().err
    assert "no base gait" in said
    assert "pelvis_tilt is in the log and preset 'direct' does not use it" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("degrees", [-178.0, 174.0, 179.5, 186.0])
def test_one_spike_near_half_a_turn_is_taken_out(tmp_path, degrees):
    angles = walk()
    whole = ggo.import_base_gait(log_of(tmp_path / "a.mcap", angles), joints="direct")
    angles[700, 1] = np.radians(degrees)
    report = ggo.import_base_gait(log_of(tmp_path / "b.mcap", angles), joints="direct")
    assert report.signal_counts["spikes"]["left_knee"] == 1
    np.testing.assert_allclose(report.gait.frames, whole.gait.frames, atol=np.radians(0.2))


def test_legs_that_differ_are_noted(tmp_path):
    angles = walk()
    angles[:, 3] *= 0.6
    report = ggo.import_base_gait(log_of(tmp_path / "a.mcap", angles), joints="direct")
    assert any("from left strides only is" in note for note in report.notes)


def test_a_slow_run_is_refused(tmp_path):
    phase = np.arange(1500)[:, None] / 75.0 + np.array([0.0, 0.5])
    at = [0.0, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0]
    curves = np.array([[25, 15], [20, 32], [10, 40], [-12, 30], [-5, 65], [18, 80], [32, 50], [30, 20], [25, 15]])
    spline = CubicSpline(at, curves, bc_type="periodic")
    angles = np.radians(spline(phase % 1.0)).reshape(1500, 4)
    with pytest.raises(ggo.LogError, match="running, not walking"):
        ggo.import_base_gait(log_of(tmp_path / "a.mcap", angles), joints="direct")


@pytest.mark.parametrize(
    ("shank", "message"), [(0.0, "it holds no walking: 0 times"), (0.5, "marching on the spot or")]
)
def test_marching_on_the_spot_is_called_so(tmp_path, shank, message):
    phase = (np.arange(1500)[:, None] / 120.0 + np.array([0.0, 0.5])) % 1.0
    lift = np.where(phase < 0.5, np.sin(2.0 * np.pi * phase) ** 2, 0.0) * np.radians(50.0)
    # The shank leans back as much as the thigh forward, so that the ankle goes straight up; or it hangs.
    angles = np.stack([lift + 0.05, (2.0 - 2.0 * shank) * lift + 0.1], -1).reshape(1500, 4)
    angles += np.random.default_rng(1).normal(0, 0.002, angles.shape)
    with pytest.raises(ggo.LogError, match=message):
        ggo.import_base_gait(log_of(tmp_path / "a.mcap", angles), joints="direct")


def test_a_very_slow_walk_is_taken_and_noted(tmp_path):
    report = ggo.import_base_gait(log_of(tmp_path / "a.mcap", walk(4000, 5.0)), joints="direct")
    assert report.stride_time[0] == pytest.approx(5.0, abs=0.05)
    assert any("strides of 5.0 s: a very slow walker, or" in note for note in report.notes)


def test_names_cannot_speak_to_the_terminal(tmp_path, capsys):
    path = log_of(tmp_path / "a.mcap", walk(200), ("left\x1b[31m_hip", "left\nknee", "right_hip", "right_knee"))
    assert main(["inspect", str(path)]) == 0
    assert main(["import", str(path)]) == 2
    said = "".join(capsys.readouterr())
    assert "\x1b" not in said
    assert "left\\x1b[31m_hip" in said


@pytest.mark.parametrize(
    ("stamp", "note"),
    [(lambda ns: ns // 10**9 * 10**9, "has only 15 values in 1500 messages"), (lambda ns: ns // 1000, "times as fast")],
)
def test_stamps_that_say_less_than_the_recorder_are_not_used(tmp_path, stamp, note):
    angles = walk()
    times = [START_NS + n * 10**7 for n in range(len(angles))]
    messages = [
        ("/joint_states", at, at, joint_state(stamp(at), NAMES, row))
        for at, row in zip(times, angles.tolist(), strict=True)
    ]
    path = tmp_path / "a.mcap"
    write_messages(path, {"/joint_states": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages)
    report = ggo.import_base_gait(path, joints="direct")
    assert report.time_source == "log_time"
    assert any(note in line for line in report.notes)


def test_our_own_export_is_whole(tmp_path):
    ggo.export_mcap(ggo.adjust_stride(ggo.paper_base_gait(), 0.9), tmp_path / "walk.mcap")
    assert ggo.inspect_log(tmp_path / "walk.mcap").losses == ()
