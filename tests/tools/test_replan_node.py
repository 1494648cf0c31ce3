"""The ROS 2 example without ROS: a recorded walk heard at 50 Hz, boxes come into view, missed deadlines counted."""

from __future__ import annotations

import sys
import time
from concurrent.futures import Executor, Future

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from ros2.replan_node import Replanner, changeable

import ggo_factors as ggo

PERIOD = 1.0 / 50.0
BOX = ggo.Obstacle(0.55, 0.60, 0.06)


def walk_ahead():
    """Four steps of 1 s on level ground, at a frame a tick."""
    base = ggo.paper_base_gait()
    slow = ggo.Gait(base.frames, 0.02, model=base.model)
    return ggo.walk(slow, [ggo.Step((0.39, 0.0))] * 4)


def heard(walk, tmp_path):
    """Times in [s] of the joint states of a walk that was recorded at 50 Hz."""
    ggo.export_mcap(walk, tmp_path / "walk.mcap", rate=1.0 / PERIOD)
    with (tmp_path / "walk.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        states = [state for _, _, _, state in reader.iter_decoded_messages(topics=["/joint_states"])]
    return [state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec for state in states]


class LateWorker(Executor):
    """A worker that has its answer ready only when told to."""

    def __init__(self):
        self.jobs = []

    def submit(self, fn, /, *args, **kwargs):
        self.jobs.append((future := Future(), lambda: fn(*args, **kwargs)))
        return future

    def finish(self):
        future, job = self.jobs.pop()
        future.set_result(job())


@pytest.mark.campaign  # in real time, which a machine under load may miss
def test_a_log_at_50_hz_is_heard_without_a_miss_while_the_walk_is_made_again(tmp_path):
    walk = walk_ahead()
    planner, times = Replanner(walk), heard(walk, tmp_path)[:120]
    changed, missed, played = [], 0, []
    began = time.perf_counter()
    for tick, now in enumerate(times):
        if (early := began + tick * PERIOD - time.perf_counter()) > 0.0:
            time.sleep(early)
        missed += time.perf_counter() - began > (tick + 1) * PERIOD
        # The box is seen from 0.2 s on, 3 cm nearer from 0.8 s on.
        planner.see([] if now < 0.2 else [BOX if now < 0.8 else BOX.shifted(0.03)])
        if planner.tick(now):
            changed.append(now)
        played.append(planner.walk.joint_trajectory().played.at(np.array([now]))[0][0])
    assert "rclpy" not in sys.modules
    assert (planner.asked, planner.late, planner.refused, len(changed)) == (2, 0, [], 2)
    # A machine under load may lose a few of 120; a tick that waited for a replan would lose more.
    assert missed <= 6
    # What was played is one smooth walk: a tick turns no joint by more than its fastest does, changes of plan or not.
    fastest = np.abs(planner.walk.joint_trajectory().velocities).max()
    assert np.abs(np.diff(played, axis=0)).max() < 1.05 * fastest * PERIOD
    made = planner.walk
    assert [report.violations for report in made.verify()] == [()] * 4
    x, y = made.origins()[1]
    assert made.plan[1].obstacles == (BOX.shifted(0.03).shifted(x, y),)
    assert all(step.obstacles for step in made.plan[1:])


def test_what_is_walked_stays_to_the_bit_and_the_change_begins_ahead():
    walk, worker = walk_ahead(), LateWorker()
    planner = Replanner(walk, worker=worker)
    planner.see([BOX])
    assert not planner.tick(0.2)
    assert not planner.tick(0.22)
    worker.finish()
    assert planner.tick(0.24)
    before, after = (each.joint_trajectory() for each in (walk, planner.walk))
    same = (before.positions[: len(after.time)] == after.positions).all(axis=1)
    assert same[before.time <= 0.5].all()
    assert not same.all()
    # A walk that is told the same boxes again stays.
    planner.see([BOX])
    assert not planner.tick(0.26)
    assert planner.asked == 1


def test_an_answer_that_comes_too_late_is_counted_dropped_and_asked_for_again():
    walk, worker = walk_ahead(), LateWorker()
    planner = Replanner(walk, worker=worker)
    planner.see([BOX])
    planner.tick(0.0)
    worker.finish()
    assert not planner.tick(0.4)
    assert planner.walk is walk
    assert (planner.asked, planner.late) == (2, 1)
    worker.finish()
    assert planner.tick(0.42)


def test_a_box_that_cannot_be_stepped_over_is_refused_and_the_walk_stays():
    planner = Replanner(walk := walk_ahead())
    planner.see([ggo.Obstacle(0.3, 0.9, 0.3)])
    planner.tick(0.0)
    planner.worker.shutdown()
    assert not planner.tick(0.1)
    assert planner.walk is walk
    assert len(planner.refused) == 1
    planner.see([])
    assert not planner.tick(3.9)
    assert "nearly over" in planner.refused[1]


@pytest.mark.parametrize(("time_s", "place"), [(0.0, (0, 0)), (0.41, (0, 21)), (0.95, (1, 0)), (2.5, (2, 25))])
def test_the_place_of_a_change_is_the_first_frame_that_leaves_time_to_land(time_s, place):
    step, frame, begins = changeable(walk_ahead(), time_s)
    assert (step, frame) == place
    assert begins == pytest.approx(step + 0.02 * frame)
    assert begins >= time_s
