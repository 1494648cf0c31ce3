"""A gait as a text file: a controller's goal in YAML or JSON, a table in CSV, an OpenSim motion."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ggo_factors.errors import InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.recording.export.controller import check_rules, goal, joined, number_text, warn_of_degrees
from ggo_factors.recording.export.played import as_walk, require_within_limits, tilt_of, trajectory_of
from ggo_factors.recording.export.robot_joints import RobotMotion, as_map, robot_motion
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.support.files import PathLike, write_text
from ggo_factors.walking.walk import Walk

GOALS, TABLES = (".yaml", ".yml", ".json"), (".csv", ".mot")
"""Endings of goals, and of tables of time and joints."""


def export_trajectory(
    walk: Walk | Solution | Gait,
    path: PathLike,
    *,
    joints: PathLike | JointMap | None = None,
    rate: float | None = None,
    pelvis_tilt: float = 0.0,
    first_swing: str | None = None,
    ends_moving: bool = False,
) -> None:
    """Write what a robot's joints do over time as text, whole or not at all; the ending of `path` says how.

    ``.yaml`` and ``.json``: a goal of control_msgs/action/FollowJointTrajectory with positions, velocities and
    accelerations of the trajectory that the gait plays, as `ros2 action send_goal` takes it. ``.csv``: time in [s] and
    the joints. ``.mot``: the same for OpenSim.

    Args:
        walk: a walk, the solution of one step, or the gait of one step.
        path: the file to write.
        joints: the map, or its TOML file, by which `import_base_gait` reads what the robot logs: its names, signs,
            offsets, units and fixed joints are written; of degrees in a goal it warns, since ROS 2 expects radians. By
            default left_hip, left_knee, right_hip, right_knee in [rad]; in a ``.mot`` OpenSim's names in degrees.
        rate: points a second; the frames' own times if None.
        pelvis_tilt: in [rad], backward positive: taken from the hips.
        first_swing: as for `export_mcap`.
        ends_moving: whether a goal may end in motion: a controller refuses it unless its
            `allow_nonzero_velocity_at_trajectory_end` is set.

    Raises:
        InputError: where an argument is of no use, a controller would refuse the goal, or the file cannot be written.
        InfeasibleGaitError: where a solution did not pass its check, or a walk breaks its own joint limits.
    """
    ending = Path(path).suffix.lower() if isinstance(path, str | Path) else ""
    if ending not in (*GOALS, *TABLES):
        raise InputError(f"path: must end in {', '.join((*GOALS, *TABLES))}, got {path!r:.80}")
    tilt, chosen = tilt_of(pelvis_tilt), as_map(joints)
    played = as_walk(walk)
    require_within_limits(played)
    trajectory = trajectory_of(played, first_swing)
    if rate is not None:
        trajectory = trajectory.resampled(rate)
    if chosen is None and ending == ".mot":
        chosen, tilt = _opensim(tilt), 0.0
    motion = robot_motion(trajectory, chosen, tilt)
    check_rules(motion, ends_moving=ends_moving or ending in TABLES)
    if ending in GOALS:
        warn_of_degrees(motion)
    write_text(path, _TEXTS[ending](motion))


def _opensim(tilt: float) -> JointMap:
    """OpenSim's coordinates in degrees, the pelvis tilted by so many [rad]."""
    return JointMap(
        {
            f"{angle}_{side}": terms
            for side in ("right", "left")
            for angle, terms in (
                ("alpha", {f"hip_flexion_{side[0]}": 1.0, "pelvis_tilt": 1.0}),
                ("beta", {f"knee_angle_{side[0]}": 1.0}),
            )
        },
        "deg",
        "OpenSim",
        fixed={"pelvis_tilt": tilt},
        order=("pelvis_tilt", "hip_flexion_r", "knee_angle_r", "hip_flexion_l", "knee_angle_l"),
    )


def _csv(motion: RobotMotion) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(["time", *motion.names])
    return out.getvalue() + _rows(motion, ",")


def _mot(motion: RobotMotion) -> str:
    if odd := [name for name in motion.names if len(name.split()) != 1]:
        raise InputError(f"joints: {odd[0]!r}: no name with white space can stand in a .mot")
    degrees = "yes" if motion.unit == "deg" else "no"
    size = f"nRows={len(motion.time)}\nnColumns={len(motion.names) + 1}"
    head = f"gait\nversion=1\n{size}\ninDegrees={degrees}\nendheader\n"
    return head + "\t".join(["time", *motion.names]) + "\n" + _rows(motion, "\t")


def _rows(motion: RobotMotion, between: str) -> str:
    rows = zip(motion.time.tolist(), motion.positions.tolist(), strict=True)
    return "".join(joined([time, *row], between) + "\n" for time, row in rows)


def _json(motion: RobotMotion) -> str:
    return _flow(goal(motion)) + "\n"


def _flow(value: Any) -> str:
    """JSON, a line for each point, that YAML reads as well."""
    if isinstance(value, float):
        return number_text(value)
    if isinstance(value, list):
        return f"[{(', ' if not value or not isinstance(value[0], dict) else ',' + chr(10)).join(map(_flow, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {_flow(item)}" for key, item in value.items()) + "}"
    return json.dumps(value)


def _yaml(motion: RobotMotion) -> str:
    made = goal(motion)
    points = made["trajectory"].pop("points")
    lines = ["trajectory:", *(f"  {key}: {_flow(value)}" for key, value in made.pop("trajectory").items()), "  points:"]
    for point in points:
        inner = [f"{key}: {_flow(value)}" for key, value in point.items()]
        lines += [f"  - {inner[0]}", *(f"    {line}" for line in inner[1:])]
    return "\n".join([*lines, *(f"{key}: {_flow(value)}" for key, value in made.items())]) + "\n"


_TEXTS: dict[str, Callable[[RobotMotion], str]] = {
    ".yaml": _yaml,
    ".yml": _yaml,
    ".json": _json,
    ".csv": _csv,
    ".mot": _mot,
}
