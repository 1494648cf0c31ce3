"""Cleaning: each kind of damage is put into a clean signal, counted, and gone from the result."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.joint_map import ANGLES, JointMap
from ggo_factors.recording.log.read_log import JointLog
from ggo_factors.recording.strides.signals import clean, unit_of

NAMES = ("hip_r", "knee_r", "hip_l", "knee_l")
MAP = JointMap({angle: {name: 1.0} for angle, name in zip(ANGLES, NAMES, strict=True)})


def angles_at(times, period=1.1):
    """Thigh and knee of both legs in [rad] at `times`: shape (n, 4)."""
    columns = []
    for shift in (0.0, 0.5):
        w = 2.0 * np.pi * (times / period + shift)
        columns += [10.0 + 22.0 * np.cos(w), 30.0 + 22.0 * np.cos(w + 1.6) + 12.0 * np.cos(2.0 * w + 2.0)]
    return np.radians(np.stack(columns, -1))


def log_of(times, values, unit="rad", segments=None):
    return JointLog(
        times, values, NAMES, unit, "x.mcap", topic="/joints", message_type="t", encoding="cdr",
        time_source="header.stamp", segments=segments or (),
    )  # fmt: skip


TIMES = np.arange(1200) * 0.01


def rms_deg(signals, start=0.5, end=11.5):
    stretch = signals.stretches[0]
    inside = (stretch.times > start) & (stretch.times < end)
    off = np.degrees(stretch.angles[inside] - angles_at(stretch.times[inside]))
    return float(np.sqrt(np.nanmean(off**2)))


def test_a_clean_signal_stays_as_it_is():
    signals = clean(log_of(TIMES, angles_at(TIMES)), MAP, "rad")
    assert signals.counts == {}
    assert signals.rate == pytest.approx(100.0)
    assert rms_deg(signals) < 0.1
    assert np.isfinite(signals.stretches[0].angles).all()


def test_the_filter_has_no_delay_and_takes_noise_away():
    noisy = angles_at(TIMES) + np.random.default_rng(1).normal(0.0, math.radians(1.0), (len(TIMES), 4))
    stretch = clean(log_of(TIMES, noisy), MAP, "rad").stretches[0]
    off = np.degrees(stretch.angles - angles_at(stretch.times))[50:-50]
    assert np.sqrt((off**2).mean()) < 0.5
    true = np.degrees(angles_at(stretch.times))[50:-50]
    lags = [np.mean((np.roll(off + true, k, 0) - true)[5:-5] ** 2) for k in (-1, 0, 1)]
    assert np.argmin(lags) == 1


def test_the_filter_is_at_half_power_at_its_cut_off():
    times = np.arange(4000) * 0.005
    values = np.full((4000, 4), 0.2)
    values[:, 0] = 0.2 * np.sin(2.0 * np.pi * 6.0 * times)
    values[:, 1] = 0.2 * np.sin(2.0 * np.pi * 1.0 * times)
    stretch = clean(log_of(times, values), MAP, "rad").stretches[0]
    middle = stretch.angles[1000:-1000]
    assert np.ptp(middle[:, 0]) / 0.4 == pytest.approx(math.sqrt(0.5), abs=0.01)
    assert np.ptp(middle[:, 1]) / 0.4 > 0.995


@pytest.mark.parametrize("rate", [20.0, 31.7, 50.0, 100.0, 333.0, 1000.0])
def test_rates(rate):
    times = np.arange(round(12.0 * rate)) / rate
    signals = clean(log_of(times, angles_at(times)), MAP, "rad")
    assert rms_deg(signals) < 0.35
    assert signals.counts == {}


def test_a_rate_below_the_filter_is_refused():
    times = np.arange(120) * 0.1
    with pytest.raises(LogError, match=r"10\.0 Hz.*12 Hz"):
        clean(log_of(times, angles_at(times)), MAP, "rad")


def test_jitter_and_messages_at_almost_the_same_time():
    rng = np.random.default_rng(2)
    times = np.sort(TIMES + rng.uniform(-0.004, 0.004, len(TIMES)))
    times[1::7] = times[0::7][: len(times[1::7])] + 1e-6
    signals = clean(log_of(times, angles_at(times)), MAP, "rad")
    assert rms_deg(signals) < 0.15


def test_times_in_bursts_are_refused():
    times = np.floor(TIMES / 0.25) * 0.25 + 1e-4 * np.arange(len(TIMES)) / 25.0
    with pytest.raises(LogError, match=r"bursts, 47 pauses of some 0\.25 s"):
        clean(log_of(times, angles_at(TIMES)), MAP, "rad")


def test_spikes_are_counted_and_gone():
    values = angles_at(TIMES)
    at = np.random.default_rng(3).choice(np.arange(20, 1180, 5), 24, replace=False)
    values[at, 2] += np.where(np.arange(24) % 2, 2.5, -0.35)
    signals = clean(log_of(TIMES, values), MAP, "rad")
    assert signals.counts["spikes"] == {"hip_l": 24}
    assert rms_deg(signals) < 0.15


def test_one_absurd_value_is_damage():
    values = angles_at(TIMES)
    values[500, 1] = 7e307
    signals = clean(log_of(TIMES, values), MAP, "rad")
    assert signals.counts["out of range"] == {"knee_r": 1}
    assert rms_deg(signals) < 0.15


@pytest.mark.parametrize("offset", [0.0, math.pi, -2.0 * math.pi])
def test_wrapped_angles(offset):
    values = np.mod(angles_at(TIMES) - offset, 2.0 * math.pi) + offset
    assert np.ptp(values[:, 0]) > 6.0 or offset == math.pi
    signals = clean(log_of(TIMES, values), MAP, "rad")
    assert rms_deg(signals) < 0.15
    if offset == 0.0:
        assert set(signals.counts["wraps"]) == {"hip_r", "hip_l"}


@pytest.mark.parametrize(("gap", "bridged"), [(0.05, True), (0.14, True), (0.17, False), (0.6, False)])
def test_gaps(gap, bridged):
    values = angles_at(TIMES)
    lost = np.abs(TIMES - 6.0 - gap / 2.0) < gap / 2.0 - 0.004
    values[lost, 3] = np.nan
    signals = clean(log_of(TIMES, values), MAP, "rad")
    stretch = signals.stretches[0]
    hole = np.isnan(stretch.angles)
    assert hole[:, :3].sum() == 0
    assert bool(hole[:, 3].any()) is not bridged
    assert signals.counts["gaps bridged" if bridged else "gaps too long to bridge"] == {"knee_l": 1}
    assert signals.counts["missing"] == {"knee_l": lost.sum()}
    if not bridged:
        assert hole[:, 3].sum() * stretch.dt == pytest.approx(gap, abs=0.025)


def test_a_stuck_sensor_is_found_only_while_others_move():
    values = angles_at(TIMES)
    values[400:900, 1] = values[400, 1]
    signals = clean(log_of(TIMES, values), MAP, "rad")
    assert signals.counts["stuck"] == {"knee_r": pytest.approx(4.99, abs=0.02)}
    stretch = signals.stretches[0]
    assert np.isnan(stretch.angles[420:880, 1]).all()
    assert stretch.stuck[420:880, 1].all()
    assert not stretch.stuck[:, [0, 2, 3]].any()
    still = angles_at(TIMES)
    still[400:900] = still[400]
    assert "stuck" not in clean(log_of(TIMES, still), MAP, "rad").counts


def test_a_coarse_encoder_is_not_stuck():
    values = np.radians(np.round(np.degrees(angles_at(TIMES)), 0))
    signals = clean(log_of(TIMES, values), MAP, "rad")
    assert "stuck" not in signals.counts
    assert rms_deg(signals) < 0.4


def test_time_is_not_bridged_between_segments():
    values = angles_at(TIMES)
    signals = clean(log_of(TIMES, values, segments=((0, 600), (600, 1200))), MAP, "rad")
    assert len(signals.stretches) == 2
    assert signals.stretches[1].times[0] == pytest.approx(6.0)


def test_legs_logged_in_turn_are_not_missing_values():
    times = np.arange(2400) * 0.005
    values = angles_at(times)
    values[0::2, :2] = np.nan
    values[1::2, 2:] = np.nan
    signals = clean(log_of(times, values), MAP, "rad")
    assert signals.counts == {}
    assert signals.rate == pytest.approx(100.0)
    assert rms_deg(signals) < 0.15


def test_a_value_that_is_never_there():
    values = angles_at(TIMES)
    values[:, 3] = np.nan
    with pytest.raises(LogError, match="knee_l has no value in the whole log"):
        clean(log_of(TIMES, values), MAP, "rad")


def test_sums_of_the_map():
    pitch = JointMap(
        {
            "alpha_right": {"hip_r": 1.0},
            "beta_right": {"hip_r": 1.0, "knee_r": -1.0},
            "alpha_left": {"hip_l": 1.0},
            "beta_left": {"hip_l": 1.0, "knee_l": -1.0},
        }
    )
    values = angles_at(TIMES)
    values[:, [1, 3]] = values[:, [0, 2]] - values[:, [1, 3]]
    assert rms_deg(clean(log_of(TIMES, values), pitch, "rad")) < 0.1
    degrees = clean(log_of(TIMES, np.degrees(values), "deg"), pitch, "deg")
    assert rms_deg(degrees) < 0.1


def test_unit():
    values = angles_at(TIMES)
    assert unit_of(MAP, None, log_of(TIMES, values)) == "rad"
    assert unit_of(MAP, "deg", log_of(TIMES, np.degrees(values))) == "deg"
    in_degrees = JointMap(MAP.terms, "deg")
    assert unit_of(in_degrees, None, log_of(TIMES, np.degrees(values), None)) == "deg"
    with pytest.raises(LogError, match="unit='rad' or unit='deg'"):
        unit_of(MAP, None, log_of(TIMES, values, None))
    with pytest.raises(LogError, match=r"looks like degrees.*unit='deg'"):
        unit_of(MAP, None, log_of(TIMES, np.degrees(values)))
    with pytest.raises(LogError, match=r"give unit='rad'"):
        unit_of(MAP, "deg", log_of(TIMES, values))
    with pytest.raises(LogError, match="which is it"):
        unit_of(in_degrees, "rad", log_of(TIMES, values))
    with pytest.raises(InputError, match="'rad' or 'deg'"):
        unit_of(MAP, "grad", log_of(TIMES, values))


@pytest.mark.parametrize("period", [1.1, 8.0])
def test_turns_and_jumps_are_not_called_degrees(period):
    values = angles_at(TIMES, period)
    with pytest.raises(LogError, match="looks like degrees"):
        unit_of(MAP, None, log_of(TIMES, np.degrees(values)))
    turned = values.copy()
    turned[400:, 1] += 2.0 * math.pi
    assert unit_of(MAP, None, log_of(TIMES, turned)) == "rad"
    np.testing.assert_allclose(
        clean(log_of(TIMES, turned), MAP, "rad").stretches[0].angles,
        clean(log_of(TIMES, values), MAP, "rad").stretches[0].angles,
        atol=1e-9,
    )
    turned[800:, 1] += 7.0
    with pytest.raises(LogError, match=r"knee_r runs from 0\.\d to 1\d\.\d, .* whole turns counted on"):
        unit_of(MAP, None, log_of(TIMES, turned))


def test_a_gap_makes_no_spikes_of_the_samples_beside_it():
    values = angles_at(TIMES)
    for start in range(90, 1100, 137):
        values[start : start + 30] = np.nan
    signals = clean(log_of(TIMES, values), MAP, "rad")
    assert set(signals.counts) == {"missing", "gaps too long to bridge"}
    values[200, 1] += 0.6
    assert clean(log_of(TIMES, values), MAP, "rad").counts["spikes"] == {"knee_r": 1}


def test_wrapped_radians_are_not_taken_for_degrees():
    values = np.mod(angles_at(TIMES), 2.0 * math.pi)
    assert unit_of(MAP, None, log_of(TIMES, values)) == "rad"


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_whatever_is_lost_no_wrong_value_comes_out(seed):
    rng = np.random.default_rng(seed)
    values = angles_at(TIMES)
    for _ in range(rng.integers(1, 6)):
        start, length = rng.integers(0, 1150), rng.integers(1, 60)
        values[start : start + length, rng.integers(0, 4)] = np.nan
    keep = rng.random(len(TIMES)) > 0.1
    signals = clean(log_of(TIMES[keep], values[keep]), MAP, "rad")
    for stretch in signals.stretches:
        off = np.degrees(np.abs(stretch.angles - angles_at(stretch.times)))
        # A bridge of 0.15 s over the bend of a swinging knee may be some degrees off, not more.
        assert np.nanmax(off) < 8.0
        assert np.nanmedian(off) < 0.1
