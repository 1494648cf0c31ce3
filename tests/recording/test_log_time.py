"""Times of a log: which clock, and what is done about steps, disorder, bursts, ties and drift."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
from log_files import (
    JOINT_STATE,
    JOINT_TYPE,
    NAMES,
    START_NS,
    joint_state,
    walk_angles,
    write_joint_log,
    write_messages,
)

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.read_log import read_log

COUNT = 800
MS = 10**6


def times(count=COUNT):
    return START_NS + 10 * MS * np.arange(count)


def said(log, words):
    return any(words in note for note in log.notes)


def check_time(log, expected_ns):
    assert np.allclose(log.times, (expected_ns - expected_ns[0]) * 1e-9, rtol=0, atol=1e-8)
    assert np.all(np.diff(log.times) > 0)


def test_the_stamp_comes_first(tmp_path):
    values = walk_angles(COUNT)
    bursts = START_NS + 250 * MS * (np.arange(COUNT) // 25)
    log = read_log(write_joint_log(tmp_path / "a.mcap", values, times_ns=times(), log_ns=bursts))
    assert log.time_source == "header.stamp"
    check_time(log, times())
    assert not said(log, "as fast as")


@pytest.mark.parametrize("stamp_ns", [0, 5 * 10**9])
def test_a_stamp_that_is_not_set_or_stands_still_is_not_used(tmp_path, stamp_ns):
    messages = [
        ("/j", ns + 400_000, ns + 100_000, joint_state(stamp_ns, NAMES, row))
        for ns, row in zip(times().tolist(), walk_angles(COUNT).tolist(), strict=True)
    ]
    path = write_messages(tmp_path / "a.mcap", {"/j": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages)
    log = read_log(path)
    assert log.time_source == "publish_time"
    assert said(log, "header.stamp")
    check_time(log, times())
    messages = [(topic, ns, 0, data) for topic, ns, _, data in messages]
    log = read_log(write_messages(path, {"/j": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages))
    assert log.time_source == "log_time"


def test_bursts_without_a_stamp_are_spread(tmp_path):
    values = walk_angles(COUNT)
    bursts = START_NS + 250 * MS * (np.arange(COUNT) // 25)
    messages = [
        ("/j", ns, ns, joint_state(0, NAMES, row)) for ns, row in zip(bursts.tolist(), values.tolist(), strict=True)
    ]
    log = read_log(write_messages(tmp_path / "a.mcap", {"/j": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages))
    assert said(log, "bursts")
    assert np.array_equal(log.values, values)
    check_time(log, times())


@pytest.mark.parametrize("step_s", [-3.0, -3600.0, 5.0, 3e8])
@pytest.mark.parametrize("logged", [True, False])
def test_a_step_of_the_clock_splits_the_log(tmp_path, step_s, logged):
    stepped = times() + np.where(np.arange(COUNT) >= 300, int(step_s * 1e9), 0)
    values = walk_angles(COUNT)
    path = write_joint_log(tmp_path / "a.mcap", values, times_ns=stepped, log_ns=stepped if logged else times())
    log = read_log(path)
    if logged and step_s == 5.0:  # that is a gap
        assert log.segments == ((0, COUNT),)
        assert log.times[300] - log.times[299] == pytest.approx(5.01)
        return
    assert log.segments == ((0, 300), (300, COUNT))
    assert said(log, "clock steps")
    assert np.array_equal(log.values, values)
    check_time(log, times())


def test_two_clocks_on_one_topic_are_not_believed(tmp_path):
    stamps = times() + 2 * 10**9 * (np.arange(COUNT) % 2)
    log = read_log(write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT), times_ns=stamps, log_ns=times()))
    assert log.time_source == "log_time"
    assert said(log, "two clocks")
    check_time(log, times())


def test_disorder_is_sorted_and_said(tmp_path):
    values = walk_angles(COUNT)
    order = np.argsort(np.arange(COUNT) + np.random.default_rng(3).uniform(0, 30, COUNT))
    path = write_joint_log(tmp_path / "a.mcap", values[order], times_ns=times()[order])
    log = read_log(path)
    assert np.array_equal(log.values, values)
    check_time(log, times())
    assert said(log, "sorted")


def test_chunks_in_the_wrong_order_are_sorted(tmp_path):
    values = walk_angles(COUNT)
    for cuts in ((400,), (200, 400, 650)):
        pieces = np.split(np.arange(COUNT), cuts)
        order = np.concatenate([pieces[i] for i in np.random.default_rng(1).permutation(len(pieces))[::-1]])
        assert not np.array_equal(order, np.arange(COUNT))
        log = read_log(write_joint_log(tmp_path / "a.mcap", values[order], times_ns=times()[order]))
        assert np.array_equal(log.values, values)
        assert log.segments == ((0, COUNT),)
        assert said(log, "sorted")


def test_ties_keep_the_first_value_and_are_counted(tmp_path):
    stamps = times().copy()
    stamps[2::3] = stamps[1::3][: len(stamps[2::3])]
    values = walk_angles(COUNT)
    values[5] = values[4]
    log = read_log(write_joint_log(tmp_path / "a.mcap", values, times_ns=stamps))
    keep = np.append(True, np.diff(stamps) > 0)
    assert np.array_equal(log.values, values[keep])
    assert said(log, f"{(~keep).sum() - 1} messages have the time of an earlier one but other")
    assert said(log, "1 messages repeat")


def test_a_fast_clock_is_said(tmp_path):
    stamps = START_NS + 15 * MS * np.arange(COUNT)
    log = read_log(write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT), times_ns=stamps, log_ns=times()))
    assert said(log, "runs 1.500 times as fast")
    check_time(log, stamps)


@pytest.mark.parametrize("step_s", [-0.8, 0.8])
def test_a_small_step_is_not_called_a_fast_clock(tmp_path, step_s):
    stamps = times() + np.where(np.arange(COUNT) >= 300, int(step_s * 1e9), 0)
    log = read_log(write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT), times_ns=stamps, log_ns=times()))
    assert said(log, f"steps {'back' if step_s < 0 else 'ahead'} by 0.80 s against the recorder's clock at 3.00 s")
    assert not said(log, "as fast as")


@pytest.mark.parametrize("listed", [True, False])
def test_a_file_given_twice_is_read_once(tmp_path, listed):
    bag = tmp_path / "bag"
    bag.mkdir()
    values = walk_angles(COUNT)
    path = write_joint_log(bag / "bag_0.mcap", values)
    if listed:
        (bag / "metadata.yaml").write_text("x:\n  relative_file_paths:\n    - bag_0.mcap\n    - bag_0.mcap\n")
    else:
        (bag / "bag_1.mcap").write_bytes(path.read_bytes())
    log = read_log(bag)
    assert np.array_equal(log.values, values)
    assert log.segments == ((0, COUNT),)
    assert said(log, "800 samples are in the recording twice") != listed
    # Other values at the same times are not the same file.
    write_joint_log(bag / "bag_1.mcap", values + 0.01)
    (bag / "metadata.yaml").unlink(missing_ok=True)
    assert len(read_log(bag).times) == 2 * COUNT


def test_a_single_absurd_time_is_dropped_and_counted(tmp_path):
    values, stamps = walk_angles(COUNT), times()
    stamps[100] += 2**20 * 10**9
    stamps[0] = 77
    log = read_log(write_joint_log(tmp_path / "a.mcap", values, times_ns=stamps, log_ns=times()))
    assert np.array_equal(log.values, np.delete(values, [0, 100], axis=0))
    assert sum(loss.count for loss in log.losses) == 2
    check_time(log, np.delete(times(), [0, 100]))


@pytest.mark.parametrize(
    ("field", "unit"), [("t", 1), ("time_ms", 1e3), ("timestamp", 1e6), ("stamp_ns", 1e9), ("ts", 1e3)]
)
@pytest.mark.parametrize("start", [0, START_NS])
def test_the_unit_of_a_time_in_json(tmp_path, field, unit, start):
    ns = start + 10 * MS * np.arange(COUNT)
    messages = [
        ("/a", log, log, json.dumps({field: at * 1e-9 * unit, "left_hip": 0.1 * i, "left_knee": 1}).encode())
        for i, (log, at) in enumerate(zip(times().tolist(), ns.tolist(), strict=True))
    ]
    log = read_log(write_messages(tmp_path / "a.mcap", {"/a": ("", "", "", "json")}, messages))
    assert log.names == ("left_hip", "left_knee")
    assert log.time_source == field
    assert np.allclose(log.times, 0.01 * np.arange(COUNT), rtol=0, atol=1e-6)


def test_two_publishers_with_a_channel_each_are_read_in_file_order(tmp_path):
    from mcap.writer import Writer

    values = walk_angles(COUNT)
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=200_000)
        writer.start()
        schema = writer.register_schema(JOINT_TYPE, "ros2msg", JOINT_STATE.encode())
        channels = [writer.register_channel("/j", "cdr", schema) for _ in range(2)]
        channels[1] = writer.register_channel("/j", "cdr", schema, {"publisher": "2"})
        for i, (ns, row) in enumerate(zip(times().tolist(), values.tolist(), strict=True)):
            writer.add_message(channels[0], ns, joint_state(ns, NAMES[:2], row[:2]), ns, i)
            writer.add_message(channels[1], ns, joint_state(ns + 2 * MS, NAMES[2:], row[2:]), ns, i)
        writer.finish()
    log = read_log(path)
    assert log.segments == ((0, COUNT),)
    assert log.messages_read == log.messages_expected == 2 * COUNT
    assert np.array_equal(log.values[:, :2], values[:, :2])
    middle = values[:-1, 2:] * 0.2 + values[1:, 2:] * 0.8
    assert np.allclose(log.values[1:, 2:], middle, atol=1e-12)
    assert said(log, "logged separately")
    only = read_log(path, names=["hip_r", "knee_r"])
    assert np.array_equal(only.values, values[:, 2:])


def test_bad_arguments_are_named(tmp_path):
    path = write_joint_log(tmp_path / "a.mcap", walk_angles(20))
    for arguments in ({"topic": 3}, {"names": "hip_l"}, {"names": []}, {"names": ["a", "a"]}, {"names": [1]}):
        with pytest.raises(InputError):
            read_log(path, **arguments)
    with pytest.raises(InputError):
        read_log(3)
    empty = tmp_path / "empty"
    empty.mkdir()
    for bad in (tmp_path / "absent.mcap", empty, tmp_path / "a\0b"):
        with pytest.raises(LogError):
            read_log(bad)
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe")
        with pytest.raises(LogError, match="pipe"):
            read_log(tmp_path / "pipe")


def test_progress_runs_to_its_end(tmp_path):
    seen = []
    read_log(write_joint_log(tmp_path / "a.mcap", walk_angles(COUNT)), progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


@pytest.mark.parametrize(("gap_ms", "bridged"), [(100, True), (150, True), (160, False), (600, False), (1400, False)])
def test_a_leg_logged_apart_is_interpolated_over_short_gaps_only(tmp_path, gap_ms, bridged):
    values = walk_angles(COUNT)
    last, first = 300, 300 + gap_ms // 10  # the samples of the right leg on both sides of its gap
    messages = []
    for i, (ns, row) in enumerate(zip(times().tolist(), values.tolist(), strict=True)):
        messages.append(("/left", ns, ns, joint_state(ns, NAMES[:2], row[:2])))
        if not last < i < first:
            messages.append(("/right", ns, ns, joint_state(ns, NAMES[2:], row[2:])))
    kinds = dict.fromkeys(("/left", "/right"), (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr"))
    path = write_messages(tmp_path / "a.mcap", kinds, messages)
    log = read_log(path, names=[f"/left:{name}" for name in NAMES[:2]] + [f"/right:{name}" for name in NAMES[2:]])
    check_time(log, times())
    expected = values.copy()
    expected[last : first + 1, 2:] = np.linspace(values[last, 2:], values[first, 2:], first - last + 1)
    if not bridged:
        expected[last + 1 : first, 2:] = np.nan
    np.testing.assert_allclose(log.values, expected, rtol=0, atol=1e-9)
