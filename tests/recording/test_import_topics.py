"""Which topic holds the joints: told where it is plain, else refused with what to write or why each fell out."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, float64, joint_state, write_messages
from test_import_refusals import NAMES, log_of, walk

import ggo_factors as ggo
from ggo_factors.cli import main

STATE = (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")
ANGLES = walk(700)
TIMES = [START_NS + n * 10**7 for n in range(len(ANGLES))]


def a_topic_a_leg(path, names=("hip", "knee")):
    messages = []
    for at, row in zip(TIMES, ANGLES.tolist(), strict=True):
        messages.append(("/left", at, at, joint_state(at, names, row[:2])))
        messages.append(("/right", at, at, joint_state(at, names, row[2:])))
    return write_messages(path, dict.fromkeys(("/left", "/right"), STATE), messages)


def refusal(path, **options):
    with pytest.raises(ggo.LogError) as error:
        ggo.import_base_gait(path, **{"joints": "direct"} | options)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_a_topic_a_leg_is_refused_with_the_map_to_write(tmp_path):
    path = a_topic_a_leg(tmp_path / "a.mcap")
    said = refusal(path)
    (value,) = re.findall(r'"(\S+)" = 1\.0', said)
    assert value == "/left:hip"
    assert '"/left:NAME" = 1.0' in refusal(path, topic="/left,/right")
    # What it says to write works.
    terms = {f"{angle}_{leg}": {f"/{leg}:{joint}": 1.0} for leg in ("left", "right") for angle, joint in
             (("alpha", "hip"), ("beta", "knee"))}  # fmt: skip
    whole = ggo.import_base_gait(log_of(tmp_path / "b.mcap", ANGLES), joints="direct")
    report = ggo.import_base_gait(path, joints=ggo.JointMap(terms))
    np.testing.assert_allclose(report.gait.frames, whole.gait.frames, atol=1e-12)


@pytest.mark.parametrize(
    ("schema", "names", "payload", "why"),
    [
        (JOINT_STATE.replace("float64[] position", "float32[] position"), NAMES, None, "do not fit their schema (the"),
        (JOINT_STATE, ("a", "a", "b", "c"), None, "name 'a' twice"),
        (JOINT_STATE, NAMES, b"\x01\x02", "do not fit their schema (the first is 2 bytes long)"),
    ],
    ids=["schema that lies", "a name twice", "garbage"],
)
def test_why_a_topic_of_joints_fell_out(tmp_path, schema, names, payload, why):
    messages = [
        ("/joint_states", at, at, payload or joint_state(at, names, row))
        for at, row in zip(TIMES, ANGLES.tolist(), strict=True)
    ]
    path = write_messages(tmp_path / "a.mcap", {"/joint_states": (JOINT_TYPE, schema, "ros2msg", "cdr")}, messages)
    joints = ggo.JointMap({f"{angle}_{leg}": {angle: 1.0} for angle in ("alpha", "beta") for leg in ("left", "right")})
    for said in (refusal(path), refusal(path, joints=joints), refusal(path, topic="/joint_states")):
        assert why in said


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ({"data": [0.1] * 100}, "/a: no joint among data[0], data[1], data[2], data[3] and 96 more"),
        ({"data": "none"}, "/a: no numbers"),
    ],
)
def test_why_other_topics_are_none(tmp_path, value, why):
    messages = [("/a", at, at, json.dumps(value).encode()) for at in TIMES]
    assert why in refusal(write_messages(tmp_path / "a.mcap", {"/a": ("", "", "", "json")}, messages))


def test_of_many_topics_the_first_are_listed(tmp_path, capsys):
    kinds = {f"/t{i}": ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr") for i in range(500)}
    path = write_messages(tmp_path / "a.mcap", kinds, [(topic, START_NS, START_NS, float64(1.0)) for topic in kinds])
    for said in (refusal(path), refusal(path, topic="/x")):
        assert re.search(r"and 4[89]\d more", said)
        assert len(said) < 400 + len(str(path))
    assert main(["inspect", str(path)]) == 0
    said = capsys.readouterr().out
    assert "/t99 " in said
    assert "/t100 " not in said
    assert "400 more topics are not shown; --json lists all" in said
