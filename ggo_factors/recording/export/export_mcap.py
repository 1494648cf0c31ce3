"""A gait as an MCAP log that ROS 2, Foxglove and PlotJuggler open: joint states, one trajectory, a stick figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.procedures.task import StepSolution
from ggo_factors.recording.export.ros2_log import NANOSECONDS, header, ros2_log, stamp
from ggo_factors.recording.export.scene import TF_TOPIC, add_scene, marker, transforms
from ggo_factors.recording.export.urdf import COLOURS
from ggo_factors.recording.played_log import LANDINGS_KEY
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_number
from ggo_factors.walking.trajectory import joint_trajectory
from ggo_factors.walking.walk import Walk

JOINTS = ("left_hip", "left_knee", "right_hip", "right_knee")
"""Names of the joints in the messages, in this order."""
JOINT_TOPIC, TRAJECTORY_TOPIC, STICK_TOPIC = "/joint_states", "/gait/trajectory", "/gait/stick"
"""Topics of the joint states, of the whole gait as one trajectory, and of the stick figure."""
LINE_STRIP = 4
"""The type LINE_STRIP of `visualization_msgs/Marker`."""
LINE_WIDTH_M = 0.02
"""Width of the stick figure's lines in [m]."""


def export_mcap(
    walk: Walk | Solution | Gait,
    path: PathLike,
    *,
    pelvis_tilt: float = 0.0,
    first_swing: str | None = None,
    model: LegModel | None = None,
) -> None:
    """Write a walk or one step as a ROS 2 log in MCAP, whole or not at all.

    The log begins at time 0. Its topics: `/joint_states` (sensor_msgs/JointState) with angles in [rad] and
    velocities in [rad/s], those of the trajectory that is played, of left_hip, left_knee, right_hip, right_knee;
    `/gait/trajectory` (trajectory_msgs/JointTrajectory), the same and accelerations in one message, stamped 0, which
    controllers take as "start now";
    `/gait/stick` (visualization_msgs/MarkerArray), the legs in the frame `map`, x forward, z up, the origin at
    the first supporting ankle; `/robot_description` (std_msgs/String), a URDF of the legs, moved by `/tf`
    (tf2_msgs/TFMessage); `/gait/scene` (visualization_msgs/MarkerArray), the ground, boxes, pits and footholds that
    were asked for. What is told once is latched. A metadata record `gait` says what was exported.

    A joint_trajectory_controller from ROS 2 Jazzy on wants `allow_nonzero_velocity_at_trajectory_end: true`
    unless the walk ends in standing: the legs move at the end of a step.

    Args:
        walk: a walk, the solution of one step, or the gait of one step.
        path: the file to write.
        pelvis_tilt: tilt of the pelvis in [rad], backward positive, as OpenSim has it: the hip joints are the
            thighs' angles from the vertical less this.
        first_swing: leg that swings in the first step, `"left"` or `"right"`; if None a walk's own, of one
            step right unless its walk began with it.
        model: the legs of the stick figure; by default the walk's own.

    Raises:
        InputError: where an argument is of no use, no leg lengths are known, or the file cannot be written.
        InfeasibleGaitError: where a solution did not pass its check. (To write it nonetheless, give its gait.)
    """
    gaits = _gaits(walk)
    tilt = as_number(pelvis_tilt, "pelvis_tilt", unit="rad")
    if not abs(tilt) < np.pi:
        raise InputError(f"pelvis_tilt: {tilt:g} rad is not below pi; looks like degrees")
    if isinstance(walk, StepSolution):
        swing = walk.task.swing if walk.task.number == 1 else "right"
        walk = Walk((walk.gait,), (walk.task.step,), first_swing=swing)
    if first_swing is None:
        first_swing = walk.first_swing if isinstance(walk, Walk) else "right"
    trajectory = walk.joint_trajectory(first_swing) if isinstance(walk, Walk) else joint_trajectory(gaits, first_swing)
    legs = gaits[0].legs(model)
    times_ns = np.rint(trajectory.time * NANOSECONDS).astype(np.int64)
    if not (np.diff(times_ns) > 0).all() or times_ns[-1] >= 2**31 * NANOSECONDS:
        raise InputError(f"dt: {gaits[0].dt:g} s cannot be written as 32-bit seconds and whole nanoseconds")
    positions, rates = trajectory.positions - [tilt, 0.0, tilt, 0.0], (trajectory.velocities, trajectory.accelerations)
    points = [
        {
            "positions": position,
            "velocities": velocity,
            "accelerations": acceleration,
            "effort": [],
            "time_from_start": stamp(time),
        }
        for time, position, velocity, acceleration in zip(
            times_ns.tolist(), positions.tolist(), *(rate.tolist() for rate in rates), strict=True
        )
    ]
    with ros2_log(path) as log:
        log.add_topic(JOINT_TOPIC, "sensor_msgs/JointState")
        log.add_topic(TRAJECTORY_TOPIC, "trajectory_msgs/JointTrajectory", latched=True)
        log.add_topic(STICK_TOPIC, "visualization_msgs/MarkerArray")
        add_scene(log, gaits, walk.plan if isinstance(walk, Walk) else (), legs)
        log.add_metadata("gait", _metadata(gaits, legs, tilt, first_swing, trajectory.time))
        log.write(TRAJECTORY_TOPIC, 0, {"header": header(0), "joint_names": JOINTS, "points": points})
        sticks = stick_figures(gaits, legs, first_swing)
        for time, point, stick in zip(times_ns.tolist(), points, sticks, strict=True):
            state = {"position": point["positions"], "velocity": point["velocities"], "effort": []}
            log.write(JOINT_TOPIC, time, {"header": header(time), "name": JOINTS, **state})
            markers = [_leg_marker(time, number, side, stick[side]) for number, side in enumerate(COLOURS)]
            log.write(STICK_TOPIC, time, {"markers": markers})
            log.write(TF_TOPIC, time, transforms(time, stick, tilt))


def stick_figures(gaits: Sequence[Gait], model: LegModel, first_swing: str) -> list[dict[str, Array]]:
    """Ankle, knee and hip of the left and the right leg in [m], shape (3, 2), for each frame of a walk.

    Each step's body frame is moved to where the step before put its foot down; a swap frame occurs once.
    """
    figures = []
    origin = np.zeros(2)
    swing, support = ("right", "left") if first_swing == "right" else ("left", "right")
    for number, gait in enumerate(gaits):
        joints = model.joints(gait.frames) + origin
        for points in joints[min(number, 1) :]:
            figures.append({support: points[:3], swing: points[:1:-1]})
        origin = joints[-1, 4]
        swing, support = support, swing
    return figures


def _gaits(walk: Walk | Solution | Gait) -> tuple[Gait, ...]:
    if isinstance(walk, Gait):
        return (walk,)
    if isinstance(walk, Solution):
        walk.require_ok()
        return (walk.gait,)
    if isinstance(walk, Walk):
        return walk.gaits
    raise InputError(f"walk: expected a Walk, a Solution or a Gait, got {walk!r:.80}")


def _metadata(gaits: Sequence[Gait], model: LegModel, tilt: float, first_swing: str, times: Array) -> dict[str, str]:
    foot, last = model.foot, np.cumsum([len(gait) - 1 for gait in gaits])
    return {
        "format_version": "1",
        "name": gaits[0].name,
        "origin": gaits[0].origin,
        "steps": str(len(gaits)),
        "frames": " ".join(str(len(gait)) for gait in gaits),
        "dt_s": " ".join(repr(gait.dt) for gait in gaits),
        LANDINGS_KEY: " ".join(map(repr, times[last].tolist())),
        "first_swing": first_swing,
        "pelvis_tilt_rad": repr(tilt),
        "hip": "thigh from the vertical, forward positive, less pelvis_tilt_rad",
        "thigh_m": repr(model.thigh),
        "shank_m": repr(model.shank),
        "thigh_mass_kg": repr(model.thigh_mass),
        "shank_mass_kg": repr(model.shank_mass),
        "ankle_height_m": repr(foot.ankle_height),
        "heel_m": repr(foot.heel),
        "toe_m": repr(foot.toe),
    }


def _leg_marker(time_ns: int, number: int, side: str, points: Array) -> dict[str, Any]:
    line = [{"x": x, "y": 0.0, "z": y} for x, y in points.tolist()]
    scale = {"x": LINE_WIDTH_M, "y": 0.0, "z": 0.0}
    return marker(time_ns, "legs", number, LINE_STRIP, COLOURS[side], scale=scale, points=line, text=side)
