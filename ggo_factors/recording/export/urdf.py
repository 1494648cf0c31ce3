"""The legs as a URDF: a pelvis, two thighs, two shanks, and frames at the ankles."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.export.robot_joints import Hinge, hinges
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.walking.trajectory import JOINT_NAMES

SIDE_M = 0.08
"""Bones are drawn this far to each side in [m], so that the legs can be told apart; the model is planar."""
LEAST_RADIUS_M = 0.02
"""Bones are drawn at least this thick, in [m]."""
COLOURS = {"left": (0.0, 0.447, 0.698), "right": (0.835, 0.369, 0.0)}
"""Red, green and blue of each leg, 0 to 1: blue and orange, which colour-blind people can tell apart."""


def legs_urdf(model: LegModel, joints: JointMap | None = None) -> str:
    """The legs as the text of a URDF, x forward, y to the left, z up, all joints in the plane y = 0.

    Where all joint angles are 0 both legs hang straight down from the root `pelvis`. Joints `left_hip`, `left_knee`,
    `right_hip` and `right_knee` in [rad]: hips forward positive, knees flexion positive, as in `JointTrajectory`; links
    `left_thigh`, `left_shank`, `left_ankle` and the same of the right. Each mass is at the middle of its
    link, as in the model; inertias are those of thin rods, since simulators refuse inertias of 0.

    Args:
        model: the legs.
        joints: a robot's joint map: the URDF's joints then have its names, signs and zeros, so that the robot's joint
            states move it, where each angle is one value in [rad]. Where not (`hinges`), they have their own.
    """
    parts = ['<?xml version="1.0"?>', '<robot name="ggo_legs">', '  <link name="pelvis"/>']
    for side, (red, green, blue) in COLOURS.items():
        parts.append(f'  <material name="{side}"><color rgba="{red} {green} {blue} 1"/></material>')
    own = dict(zip(JOINT_NAMES, hinges(joints) or hinges(None) or (), strict=True))
    for side, across in (("left", SIDE_M), ("right", -SIDE_M)):
        thigh, shank = f"{side}_thigh", f"{side}_shank"
        parts += [
            _link(thigh, side, model.thigh, model.thigh_mass, model.thigh_radius, across),
            _link(shank, side, model.shank, model.shank_mass, model.shank_radius, across),
            f'  <link name="{side}_ankle"/>',
            _turning(own[f"{side}_hip"], "pelvis", thigh, 0.0, -1.0),
            _turning(own[f"{side}_knee"], thigh, shank, -model.thigh, 1.0),
            f'  <joint name="{side}_ankle_end" type="fixed"><parent link="{shank}"/><child link="{side}_ankle"/>'
            f'<origin xyz="0 0 {-model.shank!r}"/></joint>',
        ]
    return "\n".join([*parts, "</robot>", ""])


def _link(name: str, side: str, length: float, mass: float, radius: float, across: float) -> str:
    """A rod that hangs down from its joint, drawn `across` to the side; lengths in [m], the mass in [kg]."""
    thick, middle = max(radius, LEAST_RADIUS_M), -length / 2.0
    beside, along = mass * length**2 / 12.0, mass * thick**2 / 2.0
    return (
        f'  <link name="{name}">\n'
        f'    <inertial><origin xyz="0 0 {middle!r}"/><mass value="{mass!r}"/>'
        f'<inertia ixx="{beside!r}" ixy="0" ixz="0" iyy="{beside!r}" iyz="0" izz="{along!r}"/></inertial>\n'
        f'    <visual><origin xyz="0 {across!r} {middle!r}"/><geometry><cylinder radius="{thick!r}" '
        f'length="{length!r}"/></geometry><material name="{side}"/></visual>\n'
        "  </link>"
    )


def _turning(hinge: Hinge, parent: str, child: str, z: float, y: float) -> str:
    """A joint whose angle counts about (0, `y`, 0), `z` [m] above its parent; without limits, which a gait's file has.

    Its frame is turned by its angle at the robot's zero.
    """
    return (
        f'  <joint name={quoteattr(hinge.name)} type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 {z!r}" rpy="0 {y * hinge.at_zero + 0.0!r} 0"/><axis xyz="0 {y * hinge.sign:g} 0"/></joint>'
    )
