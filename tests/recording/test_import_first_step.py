"""First and last step of a flight in recordings of stairs: found, bent for other stairs, like the person's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_cut_strides import UP, periodic
from test_import_base_gait import import_log, logged  # noqa: F401  (a fixture)
from test_import_each_leg import PAPER, STAIRS

import ggo_factors as ggo
from ggo_factors.recording.sources.open_log import open_log

MOST_DEG = 10.0
"""Steps made from another recording of the person's are to be at most so far from the person's own steps."""
BOTH_WAYS = [tuple(STAIRS), tuple(reversed(STAIRS))]


def flight(folder, pair, start=None, level=PAPER, without=False):
    """A flight on the stairs of one recording, bent from the other, and how far each step is from the person's."""
    base, walked = (import_log(folder, name, activity="stairs-up") for name in pair)
    up = replace(base.gait, first_step=None) if without else base.gait
    both = ggo.BaseGaits(level, level, up=up)
    walk = ggo.climb_stairs(both, STAIRS[pair[1]], tread=0.29, first_edge=0.2, steps=3, start=start)
    off = [
        made.resampled(len(swing.frames)).frames - swing.frames
        for made, swing in zip(walk.gaits, walked.used, strict=True)
    ]
    return walk, [float(np.degrees(np.sqrt(np.mean(each**2)))) for each in off]


@pytest.mark.parametrize("pair", BOTH_WAYS)
@pytest.mark.parametrize("start", [None, ggo.STANDING])
def test_every_step_of_a_flight_is_like_the_persons(recordings, pair, start):
    walk, off = flight(recordings, pair, start)
    assert [step.task.kind for step in walk.steps] == ["first up", "up", "up"]
    assert all(report.ok for report in walk.verify())
    assert max(off) < MOST_DEG


@pytest.mark.parametrize("pair", BOTH_WAYS)
@pytest.mark.parametrize("name", ["level_nonan_middle", "level_csic_s10"])
def test_from_level_walking_it_is_more_like_the_persons_than_without(recordings, pair, name):
    """The person put the feet together before the stairs: a walker in mid-stride starts 12 to 16 degrees off."""
    level = import_log(recordings, name).gait
    _, off = flight(recordings, pair, level.frames[0], level)
    _, without = flight(recordings, pair, level.frames[0], level, without=True)
    assert off[0] < without[0] - 1.0
    assert off[0] < 15.0
    assert max(off[1:]) < MOST_DEG


@pytest.mark.parametrize("name", STAIRS)
@pytest.mark.parametrize("leg", ["mean", "each"])
def test_an_import_knows_the_swing_from_level_ground(recordings, name, leg):
    report = import_log(recordings, name, activity="stairs-up", leg=leg)
    first = report.gait.first_step
    recorded = report.used[0]
    assert first is report.left.first_step is report.right.first_step
    assert (first.recorded.strides, first.recorded.ground, first.recorded.swing) == (1, "first up", "right")
    assert first.duration == pytest.approx(recorded.duration)
    np.testing.assert_allclose(first.endpoints()[[0, -1], 1], [0.0, report.riser], atol=1e-9)
    assert first.frames[:, 1::2].min() > np.radians(-0.3) - 1e-9
    off = first.resampled(len(recorded.frames)).frames - recorded.frames
    assert np.degrees(np.sqrt(np.mean(off**2))) < 3.0
    assert sum("1 swing from level ground onto the stairs" in line for line in report.decisions) == 1
    assert report.to_dict()["gait"]["first_step"]["frames_deg"] == np.degrees(first.frames).tolist()


@pytest.mark.parametrize("name", STAIRS)
def test_one_leg_alone_is_the_swing_that_starts_on_a_stair(recordings, name):
    """The swing before it is the other leg's: the right leg swings from the ground and from the first stair."""
    options = {"activity": "stairs-up", "min_strides": 1}
    each = import_log(recordings, name, leg="each", **options)
    right, left = (import_log(recordings, name, leg=leg, **options) for leg in ("right", "left"))
    from_ground, from_stair = right.used
    assert [swing.start for swing in right.used] == [swing.start for swing in each.used if swing.leg == "right"]
    assert right.steps == (from_stair,)
    assert right.gait.recorded.strides == 1
    assert right.gait.duration == pytest.approx(from_stair.duration)
    assert right.gait.first_step.duration == pytest.approx(from_ground.duration)
    assert right.gait.last_step is left.gait.first_step is None
    assert any(note.startswith("no right swing on these stairs ends feet together") for note in right.notes)
    assert any(note.startswith("no left swing on these stairs starts from level ground") for note in left.notes)
    assert right.covariance["right"].shape == (101, 4, 101, 4)
    with pytest.raises(ggo.LogError, match="found 2 right swings on stairs up, 3 needed; min_strides=2 would"):
        import_log(recordings, name, activity="stairs-up", leg="right")


def landing(folder, name):
    """What the person does after the last stair until they stand: the frames, at 100 Hz, the right leg supporting."""
    log, swing = open_log(folder / f"{name}.mcap"), import_log(folder, name, activity="stairs-up").used[-1]
    order = [log.names.index(joint) for joint in ("right_hip", "right_knee", "left_hip", "left_knee")]
    frames = log.values[log.times - log.times[0] >= swing.end][:, order]
    fast = np.abs(np.gradient(frames, 0.01, axis=0)).max(axis=1) > np.radians(15.0)
    return frames[: np.flatnonzero(fast)[-1] + 1]


@pytest.mark.parametrize("pair", BOTH_WAYS)
def test_the_step_onto_the_landing_is_like_the_persons(recordings, pair):
    base, walked = import_log(recordings, pair[0], activity="stairs-up").gait, landing(recordings, pair[1])
    off = []
    for up in (base, replace(base, last_step=None)):
        both = ggo.BaseGaits(PAPER, PAPER, up=up)
        walk = ggo.climb_stairs(both, STAIRS[pair[1]], tread=0.29, first_edge=0.2, steps=3, to_standing=True)
        assert all(report.ok for report in walk.verify())
        made = walk.gaits[-1].resampled(len(walked)).frames
        off.append(float(np.degrees(np.sqrt(np.mean((made - walked) ** 2)))))
    assert off[0] < MOST_DEG
    assert off[1] > MOST_DEG
    assert base.last_step.duration == pytest.approx(0.01 * len(walked), abs=0.15)
    assert (base.last_step.recorded.ground, base.last_step.recorded.swing) == ("last up", "left")


def test_a_saved_import_keeps_it(recordings, tmp_path):
    report = import_log(recordings, next(iter(STAIRS)), activity="stairs-up")
    report.save(tmp_path / "import.json")
    read = ggo.load_import_report(tmp_path / "import.json")
    np.testing.assert_array_equal(read.left.first_step.frames, report.left.first_step.frames)
    assert read.gait.first_step.recorded.ground == "first up"


@pytest.mark.parametrize("start", [None, ggo.STANDING])
@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
@pytest.mark.parametrize("first_swing", ["right", "left"])
def test_that_of_an_exported_flight_is_as_it_was(tmp_path, procedure, start, first_swing):
    kind = "up" if procedure is ggo.climb_stairs else "down"
    ends = {"start": start, "to_standing": True}
    made = procedure(PAPER, 0.15, tread=0.3, first_edge=0.2, steps=5, first_swing=first_swing, **ends)
    ggo.export_mcap(made, tmp_path / "flight.mcap")
    report = ggo.import_base_gait(tmp_path / "flight.mcap", joints="direct", activity=f"stairs-{kind}")
    first = report.gait.first_step
    assert (first.recorded.ground, first.recorded.swing) == (f"first {kind}", first_swing)
    assert np.degrees(np.sqrt(np.mean((first.frames - made.gaits[0].frames) ** 2))) < 1.0
    both = ggo.BaseGaits(PAPER, PAPER, **{kind: report.gait})
    again = procedure(both, 0.15, tread=0.3, first_edge=0.2, steps=3, to_standing=True)
    assert [step.task.kind for step in again.steps] == [f"first {kind}", kind, kind, f"last {kind}"]
    last = report.gait.last_step
    assert np.degrees(np.sqrt(np.mean((last.frames - made.gaits[-1].frames) ** 2))) < 5.0
    assert all(checked.ok for checked in again.verify())


def test_stairs_without_a_beginning_have_none(logged):  # noqa: F811
    times = np.arange(1200) * 0.01
    report = logged(times, periodic(UP, times), activity="stairs-up")
    assert report.gait.first_step is report.left.first_step is None
    assert report.gait.last_step is report.right.last_step is None
    assert sum("no swing on these stairs starts from level ground" in note for note in report.notes) == 1
    assert sum("no swing on these stairs ends feet together" in note for note in report.notes) == 1
