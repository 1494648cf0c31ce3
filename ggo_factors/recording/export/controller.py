"""What a joint trajectory controller asks of a trajectory, and the goal that its action client sends."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.recording.export.robot_joints import RobotMotion
from ggo_factors.recording.log.joint_map import listed

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""
AT_REST = float(np.finfo(np.float32).eps)
"""A last velocity up to this is none, as in `joint_trajectory_controller`, in the unit of the joints per s."""


def whole_times(motion: RobotMotion) -> list[int]:
    """The times of a motion in whole [ns], as messages have them.

    Raises:
        InputError: where they do not grow, or do not fit a message.
    """
    times = np.rint(motion.time * NANOSECONDS).astype(np.int64)
    if not (np.diff(times) > 0).all() or times[-1] >= 2**31 * NANOSECONDS:
        least = float(np.diff(motion.time).min(initial=np.inf))
        raise InputError(f"dt: {least:g} s cannot be written as 32-bit seconds and whole nanoseconds")
    return [int(time) for time in times]


def check_rules(motion: RobotMotion, *, ends_moving: bool) -> None:
    """Refuse what `joint_trajectory_controller` of ros2_controllers would refuse, before it is written.

    Args:
        motion: what is to be played.
        ends_moving: whether the joints may move at its end.

    Raises:
        InputError: naming the rule: names (each once, none empty), numbers, times that grow, a last velocity of 0.
    """
    if odd := [name for n, name in enumerate(motion.names) if not name.strip() or name in motion.names[:n]]:
        raise InputError(f"joints: {odd[0]!r} is empty or stands twice; a controller wants each joint once")
    for what in ("positions", "velocities", "accelerations"):
        values = getattr(motion, what)
        if values.shape != (len(motion.time), len(motion.names)) or not np.isfinite(values).all():
            raise InputError(f"{what}: expected a finite number for each of {listed(motion.names)} at each time")
    whole_times(motion)
    last = np.abs(motion.velocities[-1])
    if not ends_moving and last.max() > AT_REST:
        name = motion.names[int(last.argmax())]
        raise InputError(
            f"ends_moving: {name} moves at {last.max():.3g} {motion.unit}/s at the end, which a controller refuses; "
            f"end in standing, or give ends_moving=True (allow_nonzero_velocity_at_trajectory_end)"
        )


def warn_of_degrees(motion: RobotMotion) -> None:
    """Warn where ROS 2 would get degrees: a controller that takes them for radians turns 57 times as far."""
    if motion.unit == "deg":
        told = 'positions are in degrees, as the joint map has them, but ROS 2 expects radians: say units = "rad" in it'
        warnings.warn(told, stacklevel=3)


def trajectory_points(motion: RobotMotion) -> list[dict[str, Any]]:
    """The points of a trajectory_msgs/JointTrajectory."""
    rows = (values.tolist() for values in (motion.positions, motion.velocities, motion.accelerations))
    return [
        {
            "positions": position,
            "velocities": velocity,
            "accelerations": acceleration,
            "effort": [],
            "time_from_start": {"sec": time // NANOSECONDS, "nanosec": time % NANOSECONDS},
        }
        for time, position, velocity, acceleration in zip(whole_times(motion), *rows, strict=True)
    ]


def goal(motion: RobotMotion) -> dict[str, Any]:
    """A goal of control_msgs/action/FollowJointTrajectory: start now, tolerances as the controller has them."""
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    points = trajectory_points(motion)
    return {
        "trajectory": {"header": header, "joint_names": list(motion.names), "points": points},
        "path_tolerance": [],
        "goal_tolerance": [],
        "goal_time_tolerance": {"sec": 0, "nanosec": 0},
    }


def number_text(value: float) -> str:
    """A number that JSON and YAML 1.1 both read, to the bit: the latter takes 1e-05 for a word."""
    text = repr(float(value))
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def joined(values: Sequence[float], between: str = ", ") -> str:
    """Numbers in one line."""
    return between.join(map(number_text, values))
