"""Two sources on one topic: one that does not move is left out, one that moves otherwise refused."""

from __future__ import annotations

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, START_NS, float64, stamp, write_messages
from mcap.writer import Writer
from mcap_ros2._dynamic import serialize_dynamic
from test_import_refusals import NAMES, log_of, walk

import ggo_factors as ggo
from ggo_factors.recording.log.read_log import read_log
from ggo_factors.recording.log.sources import one_source

ANGLES = walk(1500)
COUNT = len(ANGLES)
TIMES = START_NS + 10**7 * np.arange(COUNT)
LATER = np.random.default_rng(3).integers(10**5, 9 * 10**6, COUNT)
OTHER = np.roll(walk(1500, 1.23), 37, axis=0) * 0.9
COMMANDS = np.roll(ANGLES, -4, axis=0) * 1.04
_encode = serialize_dynamic(JOINT_TYPE, JOINT_STATE)[JOINT_TYPE]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return ggo.import_base_gait(log_of(tmp_path_factory.mktemp("log") / "a.mcap", ANGLES), joints="direct")


def mixed(path, sources, one_channel=True, frames=None):
    """A log of sources (times, angles) on one topic, by one channel or one each, each with its frame."""
    rows = sorted(
        (at, n, row)
        for n, (times, angles) in enumerate(sources)
        for at, row in zip(times, angles.tolist(), strict=True)
    )
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=20_000)
        writer.start("ros2", "tests")
        schema = writer.register_schema(JOINT_TYPE, "ros2msg", JOINT_STATE.encode())
        channels = [writer.register_channel("/joint_states", "cdr", schema, {"n": str(n)}) for n in range(len(sources))]
        for at, n, row in rows:
            header = {"stamp": stamp(at), "frame_id": frames[n] if frames else "exo"}
            data = _encode({"header": header, "name": list(NAMES), "position": row, "velocity": [], "effort": []})
            writer.add_message(channels[0 if one_channel else n], int(at), data, int(at))
        writer.finish()
    return path


@pytest.mark.parametrize("one_channel", [True, False])
@pytest.mark.parametrize("every", [1, 3, 20])
@pytest.mark.parametrize("pose", [[0.0] * 4, [0.3, 0.5, 0.3, 0.5]])
def test_a_source_that_does_not_move_is_left_out(tmp_path, one_channel, every, pose, whole):
    still = ((TIMES + LATER)[::every], np.tile(pose, (len(TIMES[::every]), 1)))
    report = ggo.import_base_gait(mixed(tmp_path / "a.mcap", [(TIMES, ANGLES), still], one_channel), joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)
    what = "one and the same pose" if any(pose) else "zero in every joint"
    (note,) = (note for note in report.notes if "does not move, left out" in note)
    assert f"{len(still[0])} messages hold {what} between the others" in note


def test_zeros_at_the_same_times(tmp_path, whole):
    path = mixed(tmp_path / "a.mcap", [(TIMES, np.zeros_like(ANGLES)), (TIMES, ANGLES)])
    np.testing.assert_array_equal(ggo.import_base_gait(path, joints="direct").gait.frames, whole.gait.frames)


@pytest.mark.parametrize("other", [OTHER, COMMANDS], ids=["second walker", "commands"])
@pytest.mark.parametrize("later", [LATER, 0 * LATER, 0 * LATER + 10**6], ids=["any time", "same time", "1 ms later"])
@pytest.mark.parametrize("how", ["channels", "frames", "nothing"])
def test_two_motions_are_refused(tmp_path, other, later, how):
    path = mixed(
        tmp_path / "a.mcap", [(TIMES, ANGLES), (TIMES + later, other)], how != "channels",
        ("exo", "wanted") if how == "frames" else None,
    )  # fmt: skip
    with pytest.raises(ggo.LogError) as error:
        ggo.import_base_gait(path, joints="direct")
    said = str(error.value)
    assert "/joint_states: it" in said
    assert "% of the range of motion apart" in said
    if how == "channels":
        assert "channel 1 (1500 messages) and channel 2 (1500)" in said
    if how == "frames":
        assert all(f"frame {frame!r} (1500" in said for frame in ("exo", "wanted"))


@pytest.mark.parametrize("every", [2, 3, 25])
def test_a_slower_second_walker(tmp_path, every):
    for one_channel in (False, True)[: 2 if every < 5 else 1]:
        sources = [(TIMES, ANGLES), ((TIMES + LATER)[::every], OTHER[::every])]
        with pytest.raises(ggo.LogError, match="of the range of motion apart"):
            ggo.import_base_gait(mixed(tmp_path / "a.mcap", sources, one_channel), joints="direct")


def test_two_sources_of_one_joint(tmp_path):
    rows = [x for pair in zip(ANGLES[:, 1], OTHER[:, 1], strict=True) for x in pair]
    messages = [
        ("/knee", at, at, float64(x))
        for at, x in zip(np.repeat(TIMES, 2) + np.tile([0, 10**6], COUNT), rows, strict=True)
    ]
    path = write_messages(
        tmp_path / "a.mcap", {"/knee": ("std_msgs/msg/Float64", "float64 data", "ros2msg", "cdr")}, messages
    )
    with pytest.raises(ggo.LogError, match="alternate between two motions"):
        read_log(path, topic="/knee")


def test_sources_that_say_the_same_are_both_read(tmp_path, whole):
    path = mixed(tmp_path / "a.mcap", [(TIMES, ANGLES), (TIMES + 10**6, ANGLES)], one_channel=False)
    report = ggo.import_base_gait(path, joints="direct")
    assert any("say the same: both are read" in note for note in report.notes)
    np.testing.assert_allclose(report.gait.frames, whole.gait.frames, atol=0.02)


def test_a_restart_is_no_second_source(tmp_path, whole):
    half = COUNT // 2
    sources = [(TIMES[:half], ANGLES[:half]), (TIMES[half:], ANGLES[half:])]
    report = ggo.import_base_gait(mixed(tmp_path / "a.mcap", sources, one_channel=False), joints="direct")
    np.testing.assert_array_equal(report.gait.frames, whole.gait.frames)


@pytest.mark.parametrize("rate", [15, 30, 100, 1000])
@pytest.mark.parametrize("noise_deg", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("joints", [1, 2, 4])
def test_one_walker_is_one_source(rate, noise_deg, joints, tmp_path):
    steps = np.arange(round(14.0 * rate)) * 100.0 / rate
    angles = np.stack([np.interp(steps, np.arange(COUNT), column) for column in ANGLES.T], -1)
    angles += np.random.default_rng(0).normal(0.0, np.radians(noise_deg), angles.shape)
    angles[::7, 1] = 1.5  # a sensor with many spikes
    times = START_NS + np.rint(steps * 1e7).astype(np.int64)
    notes: list[str] = []
    assert one_source(angles[:, :joints], times, np.zeros(len(times), np.int64), ["a"], notes) is None
    assert notes == []


def test_standing_still_is_no_second_source(tmp_path):
    angles = np.round(ANGLES, 3)
    angles[400:700] = angles[400]
    angles[900:905] = 0.0
    log = read_log(log_of(tmp_path / "a.mcap", angles))
    assert len(log.times) == COUNT
    assert not any("left out" in note for note in log.notes)
