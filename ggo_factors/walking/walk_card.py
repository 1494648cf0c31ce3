"""What a notebook shows of a walk: its steps on their ground, or the angles where no leg lengths are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ggo_factors.motion.base_gaits import as_leg, other_leg
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.picture import WALK_LEGEND, Place, angles_picture, steps_picture
from ggo_factors.notebook.card import card
from ggo_factors.notebook.svg import LEFT, RIGHT
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import Step
from ggo_factors.walking.trajectory import JointTrajectory

MOST_STEPS = 40
"""Most steps in the picture of a walk: more cannot be told apart on a page."""


def places_of(
    gaits: Sequence[Gait], plan: Sequence[Step], model: LegModel, origins: Array, first_swing: str
) -> list[Place]:
    """The steps of a walk, each where it is in the body frame of the first."""
    places, swings = [], as_leg(first_swing, "first_swing")
    for gait, step, origin in zip(gaits, plan, origins, strict=True):
        ground, target = step.ground, step.landing(model)
        joints = model.joints(gait.frames)
        places.append(Place(joints, model.foot, origin, step.obstacles, step.gaps, ground, target, swings))
        swings = other_leg(swings)
    return places


def walk_card(title: str, places: Sequence[Place], facts: Mapping[str, str | Sequence[str]]) -> str:
    """A card of a walk of these steps, of the first `MOST_STEPS` a picture."""
    picture = steps_picture(places[:MOST_STEPS], "the legs at some frames of each step")
    cut = {"picture": f"the first {MOST_STEPS} steps"} if places[MOST_STEPS:] else {}
    return card(title, {**facts, **cut}, picture, WALK_LEGEND)


def trajectory_card(title: str, joints: JointTrajectory, facts: Mapping[str, str | Sequence[str]]) -> str:
    """A card of a walk of legs whose lengths are not known."""
    panels = []
    for name in ("hip", "knee"):
        curves = [(leg, colour, np.asarray(getattr(joints, f"{leg}_{name}")), None) for leg, colour in _LEGS.items()]
        panels.append(angles_picture(joints.time, curves, name, "s"))
    return card(title, facts, "".join(panels), {f"{leg} leg": colour for leg, colour in _LEGS.items()})


_LEGS = {"right": RIGHT, "left": LEFT}
