"""The ROS 2 example without ROS: frames of a recorded log at 50 Hz, a box that comes into view, deadlines counted."""

from __future__ import annotations

import sys

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from ros2.replan_node import RATE_HZ, Replanner

import ggo_factors as ggo

FOOTHOLD = (0.39, 0.0)


@pytest.fixture
def log(tmp_path):
    """Times in [s] of a recorded step of 1 s."""
    path = tmp_path / "step.mcap"
    ggo.export_mcap(ggo.paper_base_gait(), path)
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        messages = list(reader.iter_decoded_messages(topics=["/joint_states"]))
    return [message.log_time / 1e9 for _, _, message, _ in messages]


def test_a_box_that_moves_is_replanned_for_and_misses_are_counted(log):
    base = ggo.paper_base_gait()
    planner = Replanner(ggo.step_over(base, [], foothold=FOOTHOLD), deadline=1.0)
    first = planner.step.gait.frames[0].copy()
    made = 0
    for tick in range(int(log[-1] * RATE_HZ)):
        at = min(range(len(log)), key=lambda k: abs(log[k] - tick / RATE_HZ))
        boxes = [ggo.Obstacle(0.2 + 0.001 * (min(tick, 5) - 3), 0.25, 0.06)] if tick >= 3 else []
        made += planner.see(boxes, at)
    assert "rclpy" not in sys.modules
    assert (planner.calls, planner.missed, made, planner.refused) == (3, 0, 3, [])
    assert planner.step.task.step.obstacles == tuple(boxes)
    assert (planner.step.gait.frames[0] == first).all()
    assert len(planner.planned().time) == len(planner.step.gait)


def test_a_call_that_takes_longer_is_a_miss_and_the_step_stays():
    step = ggo.step_over(ggo.paper_base_gait(), [], foothold=FOOTHOLD)
    planner = Replanner(step, deadline=1e-6)
    assert not planner.see([ggo.Obstacle(0.2, 0.25, 0.06)], 3)
    assert (planner.missed, len(planner.refused)) == (1, 1)
    assert planner.step is step
