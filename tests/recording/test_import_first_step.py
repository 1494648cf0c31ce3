"""The first step of a flight in recordings of stairs: found, bent for other stairs, like the person's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_cut_strides import UP, periodic
from test_import_base_gait import import_log, logged  # noqa: F401  (a fixture)
from test_import_each_leg import PAPER, STAIRS

import ggo_factors as ggo

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
    assert sum("1 swing starts from level ground" in line for line in report.decisions) == 1
    assert report.to_dict()["gait"]["first_step"]["frames_deg"] == np.degrees(first.frames).tolist()


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
    made = procedure(PAPER, 0.15, tread=0.3, first_edge=0.2, steps=5, start=start, first_swing=first_swing)
    ggo.export_mcap(made, tmp_path / "flight.mcap")
    report = ggo.import_base_gait(tmp_path / "flight.mcap", joints="direct", activity=f"stairs-{kind}")
    first = report.gait.first_step
    assert (first.recorded.ground, first.recorded.swing) == (f"first {kind}", first_swing)
    assert np.degrees(np.sqrt(np.mean((first.frames - made.gaits[0].frames) ** 2))) < 1.0
    both = ggo.BaseGaits(PAPER, PAPER, **{kind: report.gait})
    again = procedure(both, 0.15, tread=0.3, first_edge=0.2, steps=3)
    assert again.steps[0].task.kind == f"first {kind}"
    assert all(checked.ok for checked in again.verify())


def test_stairs_without_a_beginning_have_none(logged):  # noqa: F811
    times = np.arange(1200) * 0.01
    report = logged(times, periodic(UP, times), activity="stairs-up")
    assert report.gait.first_step is report.left.first_step is None
    assert sum("no swing starts from level ground" in note for note in report.notes) == 1
