"""What an import must be told is asked for at once, in the words of Python or of the command line."""

from __future__ import annotations

import json

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, joint_state, write_messages
from test_cut_strides import walk
from test_signals import MAP, NAMES

import ggo_factors as ggo
from ggo_factors.cli import main

TIMES, VALUES, _ = walk(6)
JSON_TOPIC = ("", "", "", "json")
STATE_TOPIC = (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")


def json_message(names, row, ns):
    return json.dumps({"t": ns * 1e-9} | dict(zip(names, row, strict=True))).encode()


def log(tmp_path, topics, names=NAMES):
    """A walk on each of some topics, in JSON (whose unit nobody knows) or as JointState."""
    messages = []
    for number, row in enumerate(VALUES.tolist()):
        ns = START_NS + number * 10**7
        for topic, kind in topics.items():
            data = json_message(names, row, ns) if kind is JSON_TOPIC else joint_state(ns, names, row)
            messages.append((topic, ns, ns, data))
    return write_messages(tmp_path / "walk.mcap", topics, messages)


def refused(path, **options):
    with pytest.raises(ggo.LogError) as caught:
        ggo.import_base_gait(path, **options)
    words = str(caught.value)
    assert words.startswith(str(path))
    return words.removeprefix(str(path))


def test_three_answers_are_asked_for_at_once(tmp_path, capsys):
    path = log(tmp_path, {"/left/angles": JSON_TOPIC, "/other/angles": JSON_TOPIC})
    words = refused(path)
    assert words.startswith(
        ": three answers are needed: topic= (one of /left/angles, /other/angles); joints= (a preset"
    )
    assert words.endswith("unit='rad' or unit='deg'; inspect lists what each topic holds")
    assert len(words) < 260
    assert main(["import", str(path)]) == 2
    error = capsys.readouterr().err
    assert "=" not in error.removeprefix(f"ggo: {path}")
    assert "--topic (one of /left/angles, /other/angles); --joints (a preset" in error
    assert "--unit rad or --unit deg" in error
    # each answer that is given is asked for no more
    assert "two answers are needed: topic= (one of" in refused(path, unit="rad")
    assert "two answers are needed: topic= (one of" in refused(path, joints=MAP)
    assert ": /left/angles, /other/angles may each hold the joints" in refused(path, joints=MAP, unit="rad")
    assert ggo.import_base_gait(path, topic="/left/angles", joints=MAP, unit="rad").strides_used


def test_two_answers_where_the_convention_says_the_unit(tmp_path):
    path = log(tmp_path, {"/left/states": STATE_TOPIC, "/other/states": STATE_TOPIC})
    words = refused(path)
    assert words.startswith(": two answers are needed: topic= (one of /left/states, /other/states); joints= (a preset")
    assert "unit" not in words


def test_two_answers_where_one_topic_or_none_can_be_meant(tmp_path):
    path = log(tmp_path, {"/angles": JSON_TOPIC})
    assert refused(path).startswith(": two answers are needed: unit='rad' or unit='deg'; joints=: there are hip_r")
    assert refused(path, unit="rad").startswith(": joints= is needed: which value is which joint? there are hip_r")
    assert "unit='rad' or unit='deg'" in refused(path, joints=MAP)
    csv = tmp_path / "walk.csv"
    np.savetxt(csv, np.column_stack([TIMES, VALUES]), delimiter=",", header=",".join(("time", *NAMES)), comments="")
    assert "two answers are needed: unit='rad' or unit='deg'; joints=: there are hip_r" in refused(csv)
    assert "joints='direct' or joints='direct-knee-negative' (the knees are positive in the middle)" in refused(csv)


def test_a_name_in_a_log_may_say_its_unit(tmp_path):
    path = log(tmp_path, {"/angles": JSON_TOPIC}, [f"{name}_rad" for name in NAMES])
    assert ggo.import_base_gait(path, joints="direct").unit == "rad"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--joints", "direct", "--min-strides", "9"), "; --min-strides 3 would take them"),
        (("--joints", "direct", "--min-strides", "0"), "ggo: --min-strides: 0 must be at least 1"),
        (("--joints", "direct", "--frames", "2"), "ggo: --frames: 2 must be at least 3"),
        (("--joints", "direct", "--unit", "deg"), "if these are radians, give --unit rad"),
        (("--joints", "direct", "--topic", "/no"), "it has columns and no topics: leave --topic out (--topic /no)"),
        (("--joints", "direct", "--activity", "stairs-up"), "0 swings on stairs up"),
        ((), "the names fit --joints direct or --joints direct-knee-negative"),
        (("--joints", "no.toml"), "no.toml: cannot be read"),
    ],
)
def test_the_command_line_speaks_of_flags(tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    np.savetxt("a.csv", np.column_stack([TIMES, VALUES]), delimiter=",", header=",".join(("time", *NAMES)), comments="")
    told = () if "--unit" in arguments else ("--unit", "rad")
    assert main(["import", "a.csv", *arguments, *told]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert len(error.splitlines()) == 1
    assert "joints=" not in error


def test_what_is_no_argument_of_the_command_stays_as_it_is(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("unit=x.csv", "topic: a.csv"):
        assert main(["inspect", name]) == 2
        assert capsys.readouterr().err.startswith(f"ggo: {name}: cannot be read")
    # in a folder's name too, also of a command that has such a flag
    assert main(["import", "a/unit=x.csv", "--unit", "rad"]) == 2
    assert "ggo: a/unit=x.csv: cannot be read" in capsys.readouterr().err
