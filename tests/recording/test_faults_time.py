"""Times that are none: in another unit, in bursts, written at once; angles that wrap in another unit."""

from __future__ import annotations

import json

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, float64, joint_state, write_messages
from test_import_refusals import NAMES, log_of, walk

import ggo_factors as ggo
from ggo_factors.recording.log.clock import Moments, time_line
from ggo_factors.recording.log.recorder_clock import in_nanoseconds

STATE = {"/joint_states": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}
ANGLES = walk(1500)
COUNT = len(ANGLES)
TIMES = START_NS + 10**7 * np.arange(COUNT)
UNSET = np.zeros(COUNT, np.int64)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return ggo.import_base_gait(log_of(tmp_path_factory.mktemp("log") / "a.mcap", ANGLES), joints="direct")


def imported(path, stamps, log):
    messages = [
        ("/joint_states", at, at, joint_state(own, NAMES, row))
        for own, at, row in zip(stamps, log, ANGLES.tolist(), strict=True)
    ]
    return ggo.import_base_gait(write_messages(path, STATE, messages), joints="direct")


@pytest.mark.parametrize(
    ("start", "factor", "unit"),
    [
        (0, 10**3, "microseconds"), (0, 10**6, "milliseconds"), (START_NS, 10**3, "microseconds"),
        (START_NS, 10**6, "milliseconds"), (START_NS, 10**9, "seconds"),
    ],
)  # fmt: skip
def test_a_recorder_that_counts_another_unit(tmp_path, start, factor, unit, whole):
    log = (TIMES - START_NS + start) // factor
    report = imported(tmp_path / "a.mcap", UNSET, log)
    assert f"log_time counts {unit}, not nanoseconds: read as such" in report.notes
    np.testing.assert_allclose(report.gait.frames, whole.gait.frames, atol=1e-6)
    stamped = imported(tmp_path / "b.mcap", TIMES, log)
    assert stamped.time_source == "header.stamp"
    np.testing.assert_array_equal(stamped.gait.frames, whole.gait.frames)


def test_numbers_of_unknown_unit_beside_a_recorder_of_another(tmp_path, whole):
    messages = [
        ("/a", at, at, json.dumps({"t": (own - START_NS) * 1e-9, "name": NAMES, "position": row}).encode())
        for own, at, row in zip(TIMES.tolist(), TIMES // 1000, ANGLES.tolist(), strict=True)
    ]
    path = write_messages(tmp_path / "a.mcap", {"/a": ("", "", "", "json")}, messages)
    report = ggo.import_base_gait(path, joints="direct", unit="rad")
    assert report.time_source == "t"
    assert report.stride_time == pytest.approx(whole.stride_time)


def test_a_log_that_was_written_at_once(tmp_path, whole):
    log = START_NS + np.cumsum(np.random.default_rng(0).integers(8000, 40000, COUNT))
    with pytest.raises(ggo.LogError, match=r"samples follow each other at .*e\+04 Hz: written at once"):
        imported(tmp_path / "a.mcap", UNSET, log)
    report = imported(tmp_path / "b.mcap", TIMES, log)
    assert any("too fast for a measurement (written at once?)" in note for note in report.notes)
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)


@pytest.mark.parametrize("rate", [15, 100, 1000])
def test_a_clock_in_nanoseconds_stays(rate):
    for start in (0, START_NS):
        log = start + np.arange(300) * (10**9 // rate)
        assert in_nanoseconds(log)[1] == ""
        assert time_line(Moments(None, log, log, "")).source == "log_time"


@pytest.mark.parametrize("within", [0, 20_000, 200_000])
def test_times_of_receipt_in_bursts(tmp_path, within, whole):
    log = TIMES // 250_000_000 * 250_000_000 + np.arange(COUNT) % 25 * within
    for name, stamps in (("a", UNSET), ("b", log)):  # no stamp; a stamp that is the time of receipt
        report = imported(tmp_path / f"{name}.mcap", stamps, log)
        assert any("bursts: their times are spread evenly" in note for note in report.notes)
        assert report.rate == pytest.approx(100.0, rel=0.01)
        np.testing.assert_allclose(report.gait.frames, whole.gait.frames, atol=0.01)
    stamped = imported(tmp_path / "c.mcap", TIMES, log)
    np.testing.assert_array_equal(stamped.gait.frames, whole.gait.frames)
    assert stamped.notes == ("times from header.stamp",)


def test_copies_of_a_message_are_no_burst(tmp_path, whole):
    messages = [
        ("/joint_states", at, at, joint_state(at, NAMES, row))
        for at, row in zip(TIMES.tolist(), ANGLES.tolist(), strict=True)
        for _ in range(3)
    ]
    report = ggo.import_base_gait(write_messages(tmp_path / "a.mcap", STATE, messages), joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)


@pytest.mark.parametrize("unit", ["deg", "rad"])
@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("rate", [20, 100])
def test_joints_that_are_published_apart_in_either_unit(tmp_path, unit, wrap, rate):
    turn = 360.0 if unit == "deg" else 2.0 * np.pi
    values = (np.degrees(ANGLES) if unit == "deg" else ANGLES)[:: 100 // rate]
    values = values % turn if wrap else values
    kinds = {f"/{name}": ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr") for name in NAMES}
    messages = [
        (f"/{name}", at + late, at + late, float64(value))
        for at, row in zip(TIMES[:: 100 // rate].tolist(), values, strict=True)
        for name, late, value in zip(NAMES, (0, 10**6, 3 * 10**6, 5 * 10**6), row, strict=True)
    ]
    path = write_messages(tmp_path / "a.mcap", kinds, messages)
    joints = ggo.JointMap(
        {
            angle: {f"/{name}:data": 1.0}
            for angle, name in zip(("alpha_left", "beta_left", "alpha_right", "beta_right"), NAMES, strict=True)
        }
    )
    gait = ggo.import_base_gait(path, joints=joints, unit=unit).gait
    for other in ("deg", "rad"):
        scale = 1.0 if other == unit else 180.0 / np.pi if other == "deg" else np.pi / 180.0
        alike = [(topic, at, _, float64(scale * np.frombuffer(data[4:])[0])) for topic, at, _, data in messages]
        again = ggo.import_base_gait(write_messages(tmp_path / "b.mcap", kinds, alike), joints=joints, unit=other).gait
        np.testing.assert_allclose(again.frames, gait.frames, atol=1e-9)
    if wrap:
        return
    from ggo_factors.recording.log.read_log import read_log

    log = read_log(path)
    known = np.isfinite(log.values)
    steps = np.abs(np.diff(log.values, axis=0))[known[1:] & known[:-1]]
    # Interpolation makes no step that the joint does not make itself.
    assert steps.max() <= np.abs(np.diff(values, axis=0)).max() + 1e-9
