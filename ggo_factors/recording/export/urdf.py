"""The legs as a URDF: a pelvis, two thighs, two shanks, and frames at the ankles."""

from __future__ import annotations

from ggo_factors.motion.leg_model import LegModel

HIP_OFFSET_M = 0.08
"""The hips stand this far to each side in [m], so that the legs can be told apart; the model is planar."""
LEAST_RADIUS_M = 0.02
"""Bones are drawn at least this thick, in [m]."""
COLOURS = {"left": (0.0, 0.447, 0.698), "right": (0.835, 0.369, 0.0)}
"""Red, green and blue of each leg, 0 to 1: blue and orange, which colour-blind people can tell apart."""
SIDES = {"left": HIP_OFFSET_M, "right": -HIP_OFFSET_M}
"""Where the hips are in y, to the left, in [m]."""


def legs_urdf(model: LegModel) -> str:
    """The legs as the text of a URDF, x forward, y to the left, z up.

    At joint values 0 both legs hang straight down from the root `pelvis`. Joints `left_hip`, `left_knee`, `right_hip`
    and `right_knee` in [rad]: hips forward positive, knees flexion positive, as in `JointTrajectory`; links
    `left_thigh`, `left_shank`, `left_ankle` and the same of the right. Each mass is at the middle of its
    link, as in the model; inertias are those of thin rods, since simulators refuse inertias of 0.
    """
    parts = ['<?xml version="1.0"?>', '<robot name="ggo_legs">', '  <link name="pelvis"/>']
    for side, (red, green, blue) in COLOURS.items():
        parts.append(f'  <material name="{side}"><color rgba="{red} {green} {blue} 1"/></material>')
    for side, offset in SIDES.items():
        parts += [
            _link(f"{side}_thigh", side, model.thigh, model.thigh_mass, model.thigh_radius),
            _link(f"{side}_shank", side, model.shank, model.shank_mass, model.shank_radius),
            f'  <link name="{side}_ankle"/>',
            _turning(f"{side}_hip", "pelvis", f"{side}_thigh", f"0 {offset!r} 0", "0 -1 0"),
            _turning(f"{side}_knee", f"{side}_thigh", f"{side}_shank", f"0 0 {-model.thigh!r}", "0 1 0"),
            f'  <joint name="{side}_ankle" type="fixed"><parent link="{side}_shank"/><child link="{side}_ankle"/>'
            f'<origin xyz="0 0 {-model.shank!r}"/></joint>',
        ]
    return "\n".join([*parts, "</robot>", ""])


def _link(name: str, side: str, length: float, mass: float, radius: float) -> str:
    """A rod that hangs down from its joint; lengths in [m], the mass in [kg]."""
    thick = max(radius, LEAST_RADIUS_M)
    across, along = mass * length**2 / 12.0, mass * thick**2 / 2.0
    middle = f'<origin xyz="0 0 {-length / 2.0!r}"/>'
    return (
        f'  <link name="{name}">\n'
        f'    <inertial>{middle}<mass value="{mass!r}"/><inertia ixx="{across!r}" ixy="0" ixz="0" iyy="{across!r}" '
        f'iyz="0" izz="{along!r}"/></inertial>\n'
        f'    <visual>{middle}<geometry><cylinder radius="{thick!r}" length="{length!r}"/></geometry>'
        f'<material name="{side}"/></visual>\n'
        "  </link>"
    )


def _turning(name: str, parent: str, child: str, xyz: str, axis: str) -> str:
    """A joint without limits: those of a gait stand in its file."""
    return (
        f'  <joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/></joint>'
    )
