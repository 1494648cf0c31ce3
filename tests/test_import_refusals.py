"""Recordings that look like a walk and would make a wrong base gait: refused, each by what gives it away."""

from pathlib import Path

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, joint_state, write_messages

import ggo_factors as ggo
from ggo_factors.cli import main

NAMES = ("left_hip", "left_knee", "right_hip", "right_knee")
SAMPLE = Path(__file__).parent.parent / "datasets" / "children_walk.mcap"


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
        (lambda a: a + np.radians([30.0, 0, 30.0, 0]), "no base gait: .* degrees were needed to stand both feet"),
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
    assert "pelvis_tilt stands in the log and preset 'direct' does not use it" in said
    assert list(tmp_path.iterdir()) == []
