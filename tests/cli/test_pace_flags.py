"""`--pace`, `--step-time` and `--deadline`: what they make, what is written, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.cli import main

OVER = ("step-over", "paper", "--obstacle", "0.32,0.385,0.17", "--foothold", "0.39,0")
"""No edges on rates keep this one within the default limits."""


@pytest.fixture
def ggo_command(capsys):
    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def test_limits_slow_a_step_and_say_so(ggo_command, tmp_path):
    path = tmp_path / "walk.csv"
    code, out, err = ggo_command(*OVER, "--limits", "-o", path)
    assert code == 0, err
    assert "slowed to" in out + err
    walk = ggo.load_walk(path)
    assert walk.gaits[0].slowdown > 1.01
    assert path.read_text().startswith("# ggo-walk 2\n")
    code, out, err = ggo_command("verify", path)
    assert (code, err) == (0, "")
    table = tmp_path / "fast.csv"
    ggo.Walk(tuple(ggo.Gait(g.frames, g.dt, model=g.model) for g in walk.gaits), walk.plan, limits=walk.limits).save(
        table
    )
    assert ggo_command("verify", table)[0] == 3


def test_auto_needs_no_limits(ggo_command, tmp_path):
    near = ("step-over", "paper", "--obstacle", "0.32,0.37,0.1", "--foothold", "0.39,0", "--json")
    speeds = {}
    for name, flags in {"fast": (), "soft": ("--pace", "auto")}.items():
        code, out, err = ggo_command(*near, *flags)
        assert code == 0, err
        speeds[name] = json.loads(out)["steps"][0]["landing_speed_m_s"]
    assert speeds["fast"] > 1.5
    assert speeds["soft"] <= 1.001


@pytest.mark.parametrize(("flags", "duration"), [(("--pace", "0.5"), 1.0), (("--step-time", "0.8"), 0.8), ((), 0.5)])
def test_a_fixed_pace(ggo_command, tmp_path, flags, duration):
    path = tmp_path / "walk.csv"
    code, _, err = ggo_command(*OVER, *flags, "-o", path)
    assert code == 0, err
    (gait,) = ggo.load_walk(path).gaits
    assert gait.duration == pytest.approx(duration)
    np.testing.assert_allclose(np.diff(gait.times), duration / 50.0)


def test_too_fast_at_a_fixed_pace_says_at_which(ggo_command):
    code, _, err = ggo_command(*OVER, "--limits", "--pace", "1")
    assert code == 3
    assert "works at 2." in err
    assert "times the time" in err


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (("--pace", "fast"), "'fast'"),
        (("--pace", "0"), "pace"),
        (("--pace", "1.5"), "pace"),
        (("--pace", "nan"), "pace"),
        (("--step-time", "0.3"), "--step-time: 0.3 s is shorter than a step of BASE"),
        (("--step-time", "nan"), "--step-time"),
        (("--pace", "0.5", "--step-time", "1"), "--pace and --step-time: give one of them"),
        (("--deadline", "0"), "deadline"),
        (("--deadline", "-1"), "deadline"),
    ],
)
def test_flags_of_no_use_are_refused(ggo_command, flags, message):
    code, _, err = ggo_command(*OVER, *flags)
    assert code == 2
    assert message in err


def test_a_deadline_ends_a_search(ggo_command):
    # A step that nothing makes: with a deadline that has passed it is refused all the same, and says what was tried.
    code, _, err = ggo_command("step-over", "paper", "--obstacle", "0.2,0.25,0.6", "--deadline", "0.001")
    assert code == 3
    assert "no gait found" in err
    assert ggo_command(*OVER, "--deadline", "20")[0] == 0
