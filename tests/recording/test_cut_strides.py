"""Heel strikes, strides and steps of walks made for the purpose: start, stop, stand, stumble, gaps."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from test_signals import MAP, log_of

from ggo_factors.errors import LogError
from ggo_factors.motion.gait import PAPER_MODEL
from ggo_factors.motion.paper_gait import paper_base_gait
from ggo_factors.recording.plausible import check_angles, check_walking
from ggo_factors.recording.strides.cut_strides import find_cycles
from ggo_factors.recording.strides.mean_step import closed, level_step, stand_on_ground, stand_with_bent_knees
from ggo_factors.recording.strides.selection import level_strides
from ggo_factors.recording.strides.signals import clean
from ggo_factors.recording.strides.steps import LEGS

_STEP = paper_base_gait(51)
# One cycle of a leg: it stands for one step and swings for the next.
_CYCLE = CubicSpline(
    np.linspace(0.0, 1.0, 101), np.vstack([_STEP.frames[:, :2], _STEP.frames[1:, 2:]]), bc_type="not-a-knot"
)
STANDING = np.array([0.05, 0.08])


def walk(strides=8, period=1.1, stand=3.0, rate=100.0, shift=0.5, periods=None):
    """A log of standing, walking (ramped in and out over half a stride) and standing; and the strike phases' times."""
    periods = np.full(strides, period) if periods is None else np.asarray(periods)
    marks = stand + np.concatenate([[0.0], np.cumsum(periods)])
    times = np.arange(round((marks[-1] + stand) * rate)) / rate
    phase = np.interp(times, marks, np.arange(len(marks)), left=0.0, right=len(marks) - 1.0)
    share = np.clip(np.minimum(times - marks[0], marks[-1] - times) / 0.5, 0.0, 1.0)[:, None]
    columns = [share * _CYCLE((phase + s) % 1.0) + (1.0 - share) * STANDING for s in (0.0, shift)]
    return times, np.hstack(columns), marks


def cycles_of(times, values):
    return find_cycles(clean(log_of(times, values), MAP, "rad"), PAPER_MODEL)


def good(cycles, leg):
    return [stride for stride in level_strides(cycles) if stride.leg == leg and not stride.reason]


def test_a_steady_walk():
    times, values, marks = walk(10)
    cycles = cycles_of(times, values)
    for leg in LEGS:
        assert 7 <= len(good(cycles, leg)) <= 9
        durations = [stride.duration for stride in good(cycles, leg)]
        np.testing.assert_allclose(durations, 1.1, atol=0.03)
    # The same event in every stride: their distance from the marks is constant.
    steady = cycles.strikes["right"][2:-2]
    off = [(time - marks[np.argmin(np.abs(marks - time))]) for time in steady]
    assert np.ptp(off) < 0.004
    assert 0.55 < cycles.toe_off < 0.72
    assert {step.activity for step in cycles.steps} == {"level"}


def test_strikes_do_not_move_with_rate_or_noise():
    strikes = []
    rng = np.random.default_rng(0)
    for rate in (30.0, 100.0, 400.0):
        times, values, _ = walk(8, rate=rate)
        noisy = values + rng.normal(0.0, np.radians(0.5), values.shape)
        strikes.append(cycles_of(times, noisy).strikes["left"])
    assert len({len(row) for row in strikes}) == 1
    for row in strikes[1:]:
        np.testing.assert_allclose(row[:-1], strikes[0][:-1], atol=0.01)


def test_standing_has_no_strikes():
    times = np.arange(2000) * 0.01
    sway = 0.02 * np.sin(2.0 * np.pi * 0.3 * times)[:, None] * np.ones(4)
    noise = np.random.default_rng(0).normal(0.0, 0.003, (2000, 4))
    cycles = cycles_of(times, np.tile(STANDING, 2) + sway + noise)
    assert cycles.strides == ()
    assert cycles.steps == ()
    assert np.isnan(cycles.toe_off)


def test_start_and_stop_are_told_from_walking():
    cycles = cycles_of(*walk(8)[:2])
    refused = [stride for stride in level_strides(cycles) if stride.reason]
    assert refused
    assert all(word in " ".join(s.reason for s in refused) for word in ("start", "stop"))
    first = min(stride.start for stride in cycles.strides)
    assert first in {stride.start for stride in refused}


def test_a_stop_in_the_middle():
    a, b = walk(6)[:2], walk(6)[:2]
    times = np.concatenate([a[0], a[0][-1] + 0.01 + b[0]])
    cycles = cycles_of(times, np.concatenate([a[1], b[1]]))
    for leg in LEGS:
        counts = len(good(cycles, leg))
        assert counts == 2 * len(good(cycles_of(*a), leg))
    assert any("a stop in it (8.20 s, the median stride 1.10 s)" in stride.reason for stride in cycles.strides)


def test_a_very_slow_walker_does_not_stop_in_every_stride():
    periods = [5.0, 4.8, 5.2, 5.0, 9.0, 5.1, 4.9, 5.0]
    cycles = cycles_of(*walk(periods=periods)[:2])
    for leg in LEGS:
        assert len(good(cycles, leg)) >= 3
        np.testing.assert_allclose([stride.duration for stride in good(cycles, leg)], 5.0, atol=0.5)
    assert any(re.match(r"a stop in it \([789].*the median stride 5\.", stride.reason) for stride in cycles.strides)


def test_an_odd_stride_is_refused_with_its_time():
    cycles = cycles_of(*walk(periods=[1.1] * 5 + [1.7] + [1.1] * 5)[:2])
    odd = [stride for stride in cycles.strides if "the median stride" in stride.reason]
    assert odd
    assert all(1.3 < stride.duration < 1.8 for stride in odd)


def test_a_stumble_is_refused_by_its_shape():
    times, values, marks = walk(12)
    bump = np.exp(-(((times - marks[6] - 0.4) / 0.12) ** 2))
    values[:, 1] += np.radians(35.0) * bump
    strides = level_strides(cycles_of(times, values))
    unlike = [stride for stride in strides if "unlike" in stride.reason]
    assert [stride.leg for stride in unlike] == ["right"]
    assert unlike[0].start < marks[6] + 0.4 < unlike[0].end


def test_a_turn_on_the_spot_is_refused():
    times, values, marks = walk(12)
    turning = np.clip(1.0 - np.abs(times - marks[6]) / 1.2, 0.0, 0.5)[:, None]
    strides = level_strides(cycles_of(times, values * (1.0 - turning) + np.tile(STANDING, 2) * turning))
    assert any(stride.reason.startswith(("short", "unlike")) for stride in strides)
    for stride in strides:
        if not stride.reason:
            assert abs(0.5 * (stride.start + stride.end) - marks[6]) > 0.5


def test_a_gap_costs_only_its_strides():
    times, values, marks = walk(12)
    values[(times > marks[6] + 0.3) & (times < marks[6] + 0.9), 2] = np.nan
    cycles = cycles_of(times, values)
    whole = cycles_of(*walk(12)[:2])
    assert len(good(cycles, "right")) == len(good(whole, "right"))
    assert len(good(whole, "left")) - 2 <= len(good(cycles, "left")) < len(good(whole, "left"))
    assert any("data missing" in stride.reason for stride in cycles.strides)


def test_a_limp_is_not_refused():
    cycles = cycles_of(*walk(10, shift=0.58)[:2])
    assert len(good(cycles, "right")) >= 7
    assert len(good(cycles, "left")) >= 7


@pytest.mark.parametrize("period", [0.85, 1.1, 1.6, 2.6])
def test_slow_and_fast_walks(period):
    cycles = cycles_of(*walk(8, period=period)[:2])
    assert len(good(cycles, "right")) >= 5


def refused(values, times=None):
    times = np.arange(len(values)) * 0.01 if times is None else times
    signals = clean(log_of(times, values), MAP, "rad")
    with pytest.raises(LogError) as error:
        check_angles(signals, MAP, "x.mcap")
    return str(error.value)


def test_impossible_kinematics_are_refused_by_name():
    times, values, _ = walk(10)
    still = values.copy()
    still[:, 3] = np.radians(0.5) * np.sin(times)
    assert "the left knee (knee_l) moves by only" in refused(still)
    still = values.copy()
    still[:, 0] = np.radians(0.5) * np.sin(times)
    assert "the right thigh (hip_r) moves by only" in refused(still)
    negative = values * [1.0, -1.0, 1.0, -1.0]
    assert "counts knee flexion negative" in refused(negative)
    assert "no knee does" in refused(values * [1.0, 4.0, 1.0, 1.0])
    assert "not a thigh's angle from the vertical" in refused(values + np.array([np.pi / 2.0, 0.0, 0.0, 0.0]))
    assert "count forward negative" in refused(values * [-1.0, 1.0, -1.0, 1.0])
    assert "count forward negative" in refused(values[:, [0, 3, 2, 1]])


def test_running_is_refused():
    # As in running: short contact, the ankle goes forward for most of the cycle, fast steps.
    times = np.arange(1500) * 0.01
    columns = []
    for shift in (0.0, 0.5):
        w = 2.0 * np.pi * (times / 0.68 + shift)
        columns += [np.radians(12.0 + 36.0 * np.cos(w)), np.radians(58.0 + 42.0 * np.cos(w + 1.75))]
    cycles = cycles_of(times, np.stack(columns, -1))
    with pytest.raises(LogError, match=r"running, not walking.*Froude"):
        check_walking(cycles, PAPER_MODEL, "x.mcap")
    check_walking(cycles_of(*walk(10)[:2]), PAPER_MODEL, "x.mcap")


def test_mean_step_closes_at_the_change_of_roles():
    phases = np.linspace(0.0, 1.0, 101)
    cycle = closed(np.asarray(_CYCLE(phases)) + np.outer(phases, [0.05, -0.03]))
    np.testing.assert_allclose(cycle[0], cycle[-1])
    frames = level_step(cycle, 41)
    assert frames.shape == (41, 4)
    np.testing.assert_allclose(frames[-1], frames[0][[2, 3, 0, 1]], atol=1e-15)
    speed = np.diff(frames, axis=0)
    np.testing.assert_allclose(speed[-1], speed[0][[2, 3, 0, 1]], atol=0.02)


@pytest.mark.parametrize(("rise", "advance"), [(0.0, None), (0.15, None), (0.15, 0.3), (-0.17, 0.28)])
def test_standing_on_the_ground_is_the_smallest_change(rise, advance):
    from scipy.optimize import minimize

    frames = paper_base_gait(21).frames + np.radians([1.0, 2.0, -2.0, 3.0])
    frames[-1] = frames[0][[2, 3, 0, 1]]
    (stood,) = stand_on_ground((frames,), PAPER_MODEL, rise, advance)
    ends = PAPER_MODEL.endpoint(stood[[0, -1]])
    np.testing.assert_allclose(ends[:, 1], [-rise, rise], atol=1e-12)
    if advance is not None:
        np.testing.assert_allclose(ends[:, 0], [-advance, advance], atol=1e-12)
    np.testing.assert_allclose(stood[-1], stood[0][[2, 3, 0, 1]], atol=1e-15)
    share = np.linspace(0.0, 1.0, 21)[:, None]

    def change(d):
        return (1.0 - share) * d + share * d[[2, 3, 0, 1]]

    def ends_off(d):
        off = PAPER_MODEL.endpoint(frames[0] + d) + np.array([advance or 0.0, rise])
        return off if advance is not None else off[1:]

    other = minimize(
        lambda d: (change(d) ** 2).sum(), np.zeros(4), constraints={"type": "eq", "fun": ends_off}, tol=1e-14
    )
    assert ((stood - frames) ** 2).sum() == pytest.approx(other.fun, rel=1e-4, abs=1e-12)


def test_overstretched_knees_are_raised_by_a_constant():
    frames = level_step(closed(np.asarray(_CYCLE(np.linspace(0.0, 1.0, 101))) - [0.0, np.radians(5.0)]), 51)
    stood, raised = stand_with_bent_knees(frames, PAPER_MODEL)
    assert np.radians(4.0) < raised < np.radians(8.0)
    assert -1e-8 < stood[:, [1, 3]].min() < 1e-3
    assert abs(PAPER_MODEL.endpoint(stood[0])[1]) < 1e-12
    good_enough, none = stand_with_bent_knees(frames + np.array([0.0, 0.2, 0.0, 0.2]), PAPER_MODEL)
    assert none == 0.0
    assert good_enough[:, [1, 3]].min() > 0.0


def periodic(degrees, times, period=1.4):
    """Both legs half a cycle apart, of a thigh and a knee curve given at tenths of a cycle from the foot's contact."""
    curves = [CubicSpline(np.linspace(0.0, 1.0, 11), [*row, row[0]], bc_type="periodic") for row in degrees]
    phases = [(times / period + shift) % 1.0 for shift in (0.0, 0.5)]
    return np.radians(np.stack([curve(phase) for phase in phases for curve in curves], -1))


# Drawn after the curves of Riener, Rabuffetti and Frigo (Gait & Posture 15, 2002): not measured.
UP = ([58, 54, 42, 28, 15, 6, 5, 22, 45, 58], [65, 60, 48, 33, 20, 12, 18, 55, 88, 88])
DOWN = ([20, 20, 17, 14, 13, 16, 25, 38, 40, 30], [10, 18, 22, 25, 35, 55, 80, 88, 60, 25])


@pytest.mark.parametrize(("curves", "activity", "sign"), [(UP, "stairs-up", 1.0), (DOWN, "stairs-down", -1.0)])
def test_stairs_are_told_from_level_ground(curves, activity, sign):
    times = np.arange(1200) * 0.01
    for tilt in (-4.0, 0.0, 4.0):
        cycles = cycles_of(times, periodic(curves, times) + np.radians([tilt, 0.0, tilt, 0.0]))
        steps = cycles.steps[1:-1]
        assert len(steps) >= 10
        assert {step.activity for step in steps} == {activity}
        assert all(0.1 < sign * step.rise < 0.25 for step in steps)
        assert all(0.2 < step.travel < 0.5 for step in steps)
        assert not any(stride.leg for stride in level_strides(cycles) if not stride.reason)
