"""A trajectory controller that wants its goal at rest takes every export of a walk that ends in standing.

Its rules are those of `joint_trajectory_controller` in ros2_controllers, before it executes a message: every joint has
a name that it knows, each once; each point has a position and a velocity for every joint; times rise strictly; the last
velocity is 0 (unless `allow_nonzero_velocity_at_trajectory_end`); and the first point is where the robot is.
"""

from __future__ import annotations

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
JOINTS = ["left_hip", "left_knee", "right_hip", "right_knee"]
STANDING = ggo.Step(end_frame=tuple(ggo.STANDING.tolist()))


def refusals(message, robot):
    """What a controller of the four joints has against a trajectory, where the robot is in these angles [rad]."""
    found = []
    if sorted(message.joint_names) != sorted(JOINTS):
        found.append("names")
    times = [point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec for point in message.points]
    if not message.points or any(len(point.positions) != 4 or len(point.velocities) != 4 for point in message.points):
        return [*found, "sizes"]
    if not (np.diff(times) > 0.0).all():
        found.append("times")
    if any(message.points[-1].velocities):
        found.append("velocity at the goal")
    if np.abs(np.array(message.points[0].positions) - robot).max() > 1e-9:
        found.append("not where the robot is")
    return found


def exported(walk, path):
    ggo.export_mcap(walk, path)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        ((_, _, _, message),) = reader.iter_decoded_messages(topics=["/gait/trajectory"])
        return message


def kerb(height):
    """Up or down a kerb and to standing on it."""
    ground = ggo.stair_ground(0.2, 0.3, [height])
    return [
        ggo.Step((0.32, height), ground=ground),
        ggo.Step(end_frame=STANDING.end_frame, ground=ground.shifted(0.32, height)),
    ]


@pytest.mark.parametrize("frames", [26, 51, 151])
@pytest.mark.parametrize(
    "plan",
    [
        [ggo.Step((0.4, 0.0)), STANDING],
        [ggo.Step((0.42, 0.0), (ggo.Obstacle(0.2, 0.25, 0.1),)), ggo.Step((0.4, 0.0)), STANDING],
        kerb(0.1),
        kerb(-0.1),
    ],
    ids=["level", "box", "kerb up", "kerb down"],
)
def test_a_walk_to_standing_is_taken(plan, frames, tmp_path):
    walk = ggo.walk(ggo.paper_base_gait(frames), plan, start=ggo.STANDING)
    message = exported(walk, tmp_path / "walk.mcap")
    assert refusals(message, np.zeros(4)) == []
    assert not any(message.points[0].velocities)


def test_a_walk_that_goes_on_is_not(tmp_path):
    walk = ggo.walk(BASE, [ggo.Step((0.4, 0.0))], start=ggo.STANDING)
    assert refusals(exported(walk, tmp_path / "walk.mcap"), np.zeros(4)) == ["velocity at the goal"]


def test_one_step_to_standing_is_taken_from_its_solution_too(tmp_path):
    walk = ggo.walk(BASE, [ggo.Step((0.4, 0.0)), STANDING], start=ggo.STANDING)
    last = walk.steps[-1]
    # Columns of a frame: supporting leg, swinging leg; the right leg swings first.
    assert refusals(exported(last, tmp_path / "step.mcap"), last.gait.frames[0]) == []
