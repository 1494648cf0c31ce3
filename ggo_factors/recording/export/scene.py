"""What a walk steps over, and where its legs are, as ROS 2 messages: ground, boxes, pits, footholds, transforms."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.export.ros2_log import Ros2Log, header, stamp
from ggo_factors.recording.export.urdf import COLOURS, legs_urdf
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import Step

DESCRIPTION_TOPIC, SCENE_TOPIC, TF_TOPIC = "/robot_description", "/gait/scene", "/tf"
"""Topics of the legs' URDF, of what they step over (both latched), and of where each link is."""
FRAME_ID = "map"
"""Frame of all markers (x forward, z up): the one that RViz shows by default."""
CUBE, SPHERE = 1, 2
"""Types of `visualization_msgs/Marker`."""
WIDTH_M = 0.6
"""Ground and boxes reach this far across, in [m]: wider than the legs stand apart."""
MARGIN_M = 0.5
"""The ground begins this far behind the first foot and ends this far past the last one, in [m]."""
THICKNESS_M = 0.02
"""Thickness of the ground and diameter of a foothold in [m]; pits are drawn half as thick, on the ground."""
GREY, BROWN, BLACK, GREEN = (0.75, 0.75, 0.75), (0.55, 0.34, 0.16), (0.1, 0.1, 0.1), (0.0, 0.62, 0.45)

Span = tuple[float, float, float, float]


def add_scene(
    log: Ros2Log, gaits: Sequence[Gait], plan: Sequence[Step], model: LegModel, joints: JointMap | None
) -> None:
    """Declare the topics of the scene and write, at time 0, the legs' URDF and what the walk steps over.

    Args:
        log: an open log.
        gaits: the steps.
        plan: what each had to do, in its own body frame; empty where not known: nothing is drawn then.
        model: the legs.
        joints: the robot's joint map, whose joints the URDF has where it can.
    """
    log.add_topic(DESCRIPTION_TOPIC, "std_msgs/String", latched=True)
    log.add_topic(SCENE_TOPIC, "visualization_msgs/MarkerArray", latched=True)
    log.add_topic(TF_TOPIC, "tf2_msgs/TFMessage")
    log.write(DESCRIPTION_TOPIC, 0, {"data": legs_urdf(model, joints)})
    log.write(SCENE_TOPIC, 0, {"markers": scene_markers(gaits, plan, model)})


def scene_markers(gaits: Sequence[Gait], plan: Sequence[Step], model: LegModel) -> list[dict[str, Any]]:
    """Ground, boxes, pits and footholds of a walk as markers; the origin is the first supporting ankle."""
    stands = np.concatenate([np.zeros((1, 2)), np.cumsum([model.endpoint(gait.frames[-1]) for gait in gaits], axis=0)])
    sole = model.foot.ankle_height
    ground, boxes, pits = list[Span](), dict[tuple[float, float], Span](), dict[tuple[float, float], Span]()
    footholds = list[tuple[float, float]]()
    for number, step in enumerate(plan):
        (x, y), (ahead, _) = stands[number].tolist(), stands[number + 1].tolist()
        low = x - MARGIN_M if number == 0 else x
        high = ahead + MARGIN_M if number == len(plan) - 1 else ahead
        bounds = [low, *(x + edge for edge in step.ground.edges if low < x + edge < high), high]
        for start, end in pairwise(bounds):
            if end > start:
                top = float(step.ground.height_at((start + end) / 2.0 - x)) + y - sole
                ground.append((start, end, top - THICKNESS_M, top))
        # A box that several steps see is drawn once, as the first one saw it: below a foot its height is cut to 0.
        for box in step.obstacles:
            base = float(step.ground.height_at([box.x_start, box.x_end]).min())
            top = max(box.height, base + THICKNESS_M / 2.0)
            span = (x + box.x_start, x + box.x_end, base + y - sole, top + y - sole)
            boxes.setdefault((round(span[0], 6), round(span[1], 6)), span)
        for gap in step.gaps:
            level = float(step.ground.height_at((gap.x_start + gap.x_end) / 2.0)) + y - sole
            span = (x + gap.x_start, x + gap.x_end, level, level + THICKNESS_M / 2.0)
            pits.setdefault((round(span[0], 6), round(span[1], 6)), span)
        landing = step.landing(model)
        footholds.append((x + landing[0], y + landing[1] - sole))
    solids = [("ground", GREY, ground), ("boxes", BROWN, boxes.values()), ("gaps", BLACK, pits.values())]
    return [
        *(_solid(name, number, span, rgb) for name, rgb, spans in solids for number, span in enumerate(spans)),
        *(_ball(number, x, z) for number, (x, z) in enumerate(footholds)),
    ]


def transforms(time_ns: int, stick: Mapping[str, Array], tilt: float) -> dict[str, Any]:
    """Where each link of the URDF is at a time in [ns], as a `tf2_msgs/TFMessage`.

    Args:
        time_ns: the time.
        stick: ankle, knee and hip of each leg in [m], shape (3, 2), see `stick_figures`.
        tilt: of the pelvis in [rad], backward positive.
    """
    hip_x, hip_z = stick["left"][2].tolist()
    moved = [_transform(time_ns, FRAME_ID, "pelvis", (hip_x, 0.0, hip_z), tilt)]
    for side in COLOURS:
        ankle, knee, hip = stick[side]
        thigh, shank = (math.atan2(low[0] - top[0], top[1] - low[1]) for top, low in ((hip, knee), (knee, ankle)))
        lengths = [float(np.hypot(*(top - low))) for top, low in ((hip, knee), (knee, ankle))]
        upper, lower = f"{side}_thigh", f"{side}_shank"
        moved += [
            _transform(time_ns, "pelvis", upper, (0.0, 0.0, 0.0), thigh - tilt),
            _transform(time_ns, upper, lower, (0.0, 0.0, -lengths[0]), shank - thigh),
            _transform(time_ns, lower, f"{side}_ankle", (0.0, 0.0, -lengths[1]), 0.0),
        ]
    return {"transforms": moved}


def _transform(
    time_ns: int, parent: str, child: str, place: tuple[float, float, float], forward: float
) -> dict[str, Any]:
    """A frame at a place in [m], turned by `forward` [rad]: what hangs down swings forward."""
    x, y, z = place
    turned = {"x": 0.0, "y": -math.sin(forward / 2.0), "z": 0.0, "w": math.cos(forward / 2.0)}
    return {
        "header": header(time_ns, parent),
        "child_frame_id": child,
        "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": turned},
    }


def marker(
    time_ns: int, space: str, number: int, kind: int, rgb: tuple[float, float, float], **fields: Any
) -> dict[str, Any]:
    """A `visualization_msgs/Marker` with the fields that most markers share; `fields` go over them."""
    red, green, blue = rgb
    nowhere = {"x": 0.0, "y": 0.0, "z": 0.0}
    common = {
        "header": header(time_ns, FRAME_ID),
        "ns": space,
        "id": number,
        "type": kind,
        "action": 0,
        "pose": {"position": nowhere, "orientation": {**nowhere, "w": 1.0}},
        "scale": nowhere,
        "color": {"r": red, "g": green, "b": blue, "a": 1.0},
        "lifetime": stamp(0),
        "frame_locked": False,
        "points": [],
        "colors": [],
        "texture_resource": "",
        "texture": {"header": header(0), "format": "", "data": b""},
        "uv_coordinates": [],
        "text": "",
        "mesh_resource": "",
        "mesh_file": {"filename": "", "data": b""},
        "mesh_use_embedded_materials": False,
    }
    return {**common, **fields}


def _at(x: float, z: float) -> dict[str, Any]:
    return {"position": {"x": x, "y": 0.0, "z": z}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}


def _solid(space: str, number: int, span: Span, rgb: tuple[float, float, float]) -> dict[str, Any]:
    start, end, low, high = span
    scale = {"x": end - start, "y": WIDTH_M, "z": high - low}
    return marker(0, space, number, CUBE, rgb, pose=_at((start + end) / 2.0, (low + high) / 2.0), scale=scale)


def _ball(number: int, x: float, z: float) -> dict[str, Any]:
    size = dict.fromkeys("xyz", THICKNESS_M)
    return marker(0, "footholds", number, SPHERE, GREEN, pose=_at(x, z), scale=size)
