"""A gait as an MCAP log that ROS 2, Foxglove and PlotJuggler open: joint states, one trajectory, a stick figure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.export.cloud import cloud_message, points_of_scene
from ggo_factors.recording.export.controller import check_rules, trajectory_points, warn_of_degrees, whole_times
from ggo_factors.recording.export.played import as_walk, first_swing_of, require_within_limits, tilt_of, trajectory_of
from ggo_factors.recording.export.robot_joints import as_map, robot_motion
from ggo_factors.recording.export.ros2_log import NANOSECONDS, header, ros2_log
from ggo_factors.recording.export.scene import FRAME_ID, TF_TOPIC, add_scene, marker, transforms
from ggo_factors.recording.export.urdf import COLOURS
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.recording.played_log import LANDINGS_KEY
from ggo_factors.seeing.strip import Sighting
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_tuple_of
from ggo_factors.walking.trajectory import JOINT_NAMES
from ggo_factors.walking.walk import Walk

JOINTS = JOINT_NAMES
"""Names of the joints in the messages where no map says others, in this order."""
JOINT_TOPIC, TRAJECTORY_TOPIC, STICK_TOPIC = "/joint_states", "/gait/trajectory", "/gait/stick"
"""Topics of the joint states, of the whole gait as one trajectory, and of the stick figure."""
CLOUD_TOPIC = "/seen/points"
"""Topic of the points that a depth camera saw, where they are given."""
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
    joints: PathLike | JointMap | None = None,
    rate: float | None = None,
    sightings: Iterable[Sighting] = (),
) -> None:
    """Write a walk or one step as a ROS 2 log in MCAP, whole or not at all.

    The log begins at time 0. Its topics: `/joint_states` (sensor_msgs/JointState) with angles in [rad] and
    velocities in [rad/s] of the trajectory that is played, 0 where the walker stands, of left_hip, left_knee,
    right_hip, right_knee; `/gait/trajectory` (trajectory_msgs/JointTrajectory), the same with its accelerations in one
    message, stamped 0, which controllers take as "start now";
    `/gait/stick` (visualization_msgs/MarkerArray), the legs in the frame `map`, x forward, z up, the origin at
    the first supporting ankle; `/robot_description` (std_msgs/String), a URDF of the legs in the exported joints,
    moved by `/tf` (tf2_msgs/TFMessage); `/gait/scene` (visualization_msgs/MarkerArray), the ground, boxes, pits and
    footholds that were asked for. What is told once is latched. A metadata record `gait` says what was exported.

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
        joints: the map, or its TOML file, by which `import_base_gait` reads what a robot logs: its joints are written
            in its names, order, signs and units, with offsets and fixed joints; of degrees it warns, since ROS 2
            expects radians. `export_trajectory` takes it too.
        rate: joint states and points a second; the frames' own times if None. The stick figure keeps its frames.
        sightings: what a depth camera saw of the ground, its origin the ground under the first supporting ankle: also
            written, as one cloud on `/seen/points` (sensor_msgs/PointCloud2), latched.

    Raises:
        InputError: where an argument is of no use, no leg lengths are known, or the file cannot be written.
        InfeasibleGaitError: where a solution did not pass its check (to write it nonetheless, give its gait), or a walk
            breaks its own joint limits.
    """
    tilt, chosen, walk = tilt_of(pelvis_tilt), as_map(joints), as_walk(walk)
    seen = as_tuple_of(sightings, "sightings", Sighting)
    gaits = walk.gaits if isinstance(walk, Walk) else (walk,)
    first_swing = first_swing_of(walk, first_swing)
    framed = trajectory_of(walk, first_swing)
    motion = robot_motion(framed if rate is None else framed.resampled(rate), chosen, tilt)
    legs = gaits[0].legs(model)
    check_rules(motion, ends_moving=True)
    warn_of_degrees(motion)
    require_within_limits(walk)
    points = trajectory_points(motion)
    figure_times = np.rint(framed.time * NANOSECONDS).astype(np.int64).tolist()
    states: list[tuple[int, Any, Any]] = [(*both, None) for both in zip(whole_times(motion), points, strict=True)]
    sticks = zip(figure_times, stick_figures(gaits, legs, first_swing), strict=True)
    # Sorted by time: players go through the file once.
    moments = sorted([*states, *((time, None, stick) for time, stick in sticks)], key=lambda moment: moment[0])
    with ros2_log(path) as log:
        log.add_topic(JOINT_TOPIC, "sensor_msgs/JointState")
        log.add_topic(TRAJECTORY_TOPIC, "trajectory_msgs/JointTrajectory", latched=True)
        log.add_topic(STICK_TOPIC, "visualization_msgs/MarkerArray")
        add_scene(log, gaits, walk.plan if isinstance(walk, Walk) else (), legs, chosen)
        if seen:
            log.add_topic(CLOUD_TOPIC, "sensor_msgs/PointCloud2", latched=True)
            log.write(CLOUD_TOPIC, 0, cloud_message(points_of_scene(seen, legs.foot.ankle_height), 0, FRAME_ID))
        log.add_metadata("gait", _metadata(walk.name, gaits, legs, tilt, first_swing, framed.time))
        log.write(TRAJECTORY_TOPIC, 0, {"header": header(0), "joint_names": motion.names, "points": points})
        for time, point, stick in moments:
            if point is not None:
                state = {"position": point["positions"], "velocity": point["velocities"], "effort": []}
                log.write(JOINT_TOPIC, time, {"header": header(time), "name": motion.names, **state})
            if stick is not None:
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


def _metadata(
    name: str, gaits: Sequence[Gait], model: LegModel, tilt: float, first_swing: str, times: Array
) -> dict[str, str]:
    foot, last = model.foot, np.cumsum([len(gait) - 1 for gait in gaits])
    return {
        "format_version": "1",
        "name": name,
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
