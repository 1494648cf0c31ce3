"""The summary of a log: topics, joints and what they look like, unit, damage."""

from __future__ import annotations

import json

import numpy as np
import pytest
from log_files import (
    JOINT_STATE,
    JOINT_TYPE,
    START_NS,
    float64,
    joint_state,
    walk_angles,
    write_joint_log,
    write_messages,
)
from rich.console import Console

from ggo_factors.cli.console import log_tables
from ggo_factors.errors import LogError
from ggo_factors.recording.log.inspect import inspect_log

COUNT = 400
VALUES = walk_angles(COUNT)


def shown(summary):
    """What the command line prints of a summary."""
    screen = Console(width=200)
    with screen.capture() as capture:
        screen.print(*log_tables(summary), sep="\n")
    return capture.get()


def roles(summary):
    return {joint.looks_like: joint.name for joint in summary.joints if joint.looks_like}


@pytest.mark.parametrize(
    "names",
    [
        ("left_hip_joint", "left_knee_joint", "right_hip_joint", "right_knee_joint"),
        ("hip_flexion_l", "knee_angle_l", "hip_flexion_r", "knee_angle_r"),
        ("l_hip_z", "l_knee_z", "r_hip_z", "r_knee_z"),
        ("LHip", "LKnee", "RHip", "RKnee"),
        ("thigh_pitch_l", "shank_pitch_l", "thigh_pitch_r", "shank_pitch_r"),
        ("exo/left/hip", "exo/left/knee", "exo/right/hip", "exo/right/knee"),
    ],
)
def test_hip_and_knee_are_known_by_their_names(tmp_path, names):
    summary = inspect_log(write_joint_log(tmp_path / "a.mcap", VALUES, names=names))
    assert roles(summary) == dict(zip(("left_hip", "left_knee", "right_hip", "right_knee"), names, strict=True))


def test_of_three_axes_the_one_that_bends(tmp_path):
    names = ("left_hip_aa", "left_hip_fe", "left_hip_ie", "pelvis_tilt")
    assert roles(inspect_log(write_joint_log(tmp_path / "a.mcap", VALUES, names=names))) == {"left_hip": "left_hip_fe"}
    values = VALUES * (0.1, 0.2, 1.0, 1.0)
    names = ("r_hip_x", "r_hip_y", "r_hip_z", "neck")
    summary = inspect_log(write_joint_log(tmp_path / "a.mcap", values, names=names))
    assert roles(summary) == {"right_hip": "r_hip_z"}


@pytest.mark.parametrize(
    ("factor", "shift", "guess"), [(1.0, 0.0, "rad"), (57.3, 0.0, "deg"), (1.0, 5.0, "rad"), (1e-3, 0.0, "rad")]
)
def test_the_unit_by_convention_and_by_look(tmp_path, factor, shift, guess):
    summary = inspect_log(write_joint_log(tmp_path / "a.mcap", VALUES * factor + shift))
    assert (summary.unit, summary.unit_guess) == ("rad", guess)
    assert "values from" in summary.unit_why


@pytest.mark.parametrize(("factor", "guess"), [(1.0, "rad"), (57.3, "deg"), (0.1, None)])
def test_the_unit_of_json_is_a_guess(tmp_path, factor, guess):
    messages = [
        (
            "/a",
            START_NS + i * 10**7,
            0,
            json.dumps({"left_hip": row[0] * factor, "left_knee": row[1] * factor}).encode(),
        )
        for i, row in enumerate(VALUES.tolist())
    ]
    summary = inspect_log(write_messages(tmp_path / "a.mcap", {"/a": ("", "", "", "json")}, messages))
    assert (summary.unit, summary.unit_guess) == (None, guess)


def test_all_is_told_and_goes_through_json(tmp_path):
    kinds = {
        "/joint_states": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr"),
        "/temp": ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr"),
        "/odd": ("x/Y", "---", "ros2msg", "cdr"),
        "/none": ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr"),
    }
    values = VALUES.copy()
    values[:7, 1] = np.nan
    messages = []
    for i, row in enumerate(values):
        at = START_NS + i * 10**7
        messages.append(("/joint_states", at, at, joint_state(at, ("hip_l", "knee_l", "hip_r", "knee_r"), row)))
        messages += [("/temp", at, at, float64(20)), ("/odd", at, at, b"x")][: 2 if i % 2 else 0]
    path = write_messages(tmp_path / "a.mcap", kinds, messages, chunk_size=5000)
    summary = inspect_log(path)
    assert {t.topic: t.count for t in summary.topics} == {"/joint_states": 400, "/temp": 200, "/odd": 200, "/none": 0}
    assert {t.topic: round(t.rate_hz) for t in summary.topics} == {
        "/joint_states": 100,
        "/temp": 50,
        "/odd": 50,
        "/none": 0,
    }
    assert next(t.problem for t in summary.topics if t.topic == "/odd")
    assert summary.topic == "/joint_states"
    assert [(j.name, j.missing) for j in summary.joints] == [("hip_l", 0), ("knee_l", 7), ("hip_r", 0), ("knee_r", 0)]
    assert summary.joints[0].low == pytest.approx(np.percentile(values[:, 0], 1))
    assert summary.checksums
    assert not summary.damaged
    data = bytearray(path.read_bytes())
    data[data.index(b"zstd", len(data) // 2) + 100] ^= 1
    path.write_bytes(data)
    broken = inspect_log(path)
    assert broken.damaged
    values = json.loads(json.dumps(broken.to_json()))
    assert values["format_version"] == 1
    assert values["damaged"]
    assert values["losses"][0]["text"] == str(broken.losses[0])
    text = shown(broken)
    assert "lost: " in text
    assert "/joint_states" in text
    assert "knee_l" in text


def test_where_the_topic_must_be_told_it_says_so(tmp_path):
    kinds = dict.fromkeys(("/measured", "/wanted"), (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr"))
    messages = [
        (topic, START_NS + i, START_NS + i, joint_state(START_NS + i, ("hip_l", "knee_l"), (0.1, 0.2)))
        for i, topic in enumerate(("/measured", "/wanted", "/measured"))
    ]
    summary = inspect_log(write_messages(tmp_path / "a.mcap", kinds, messages))
    assert summary.topic is None
    assert len(summary.joints) == 4
    assert any("give the topic" in note for note in summary.notes)
    assert "has to be told" in shown(summary)


def test_what_holds_nothing(tmp_path):
    summary = inspect_log(write_joint_log(tmp_path / "a.mcap", VALUES[:0]))
    assert summary.topics[0].count == 0
    assert summary.topic is None
    path = write_joint_log(tmp_path / "b.mcap", VALUES)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(LogError, match="nothing can be read: chunk at byte"):
        inspect_log(path)
