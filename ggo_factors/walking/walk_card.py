"""What a notebook shows of a walk: its steps on their ground, or the angles where no leg lengths are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ggo_factors.motion.base_gaits import as_leg, other_leg
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.picture import (
    PATH_POINTS,
    WALK_LEGEND,
    Place,
    angles_picture,
    ground_shapes,
    steps_picture,
)
from ggo_factors.notebook.animation import Animation, instants
from ggo_factors.notebook.card import card
from ggo_factors.notebook.svg import LEFT, PATH, RIGHT, Shape
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import Step

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


def trajectory_card(
    title: str, time: Array, angles: Mapping[str, Array], facts: Mapping[str, str | Sequence[str]]
) -> str:
    """A card of joint angles over time.

    Args:
        title: what moves.
        time: time in [s], shape (k,).
        angles: of each joint, by the names of `JOINT_NAMES`, in [rad], shape (k,).
        facts: what is to be known, by what it is.
    """
    panels = []
    for name in ("hip", "knee"):
        curves = [(leg, colour, angles[f"{leg}_{name}"], None) for leg, colour in _LEGS.items()]
        panels.append(angles_picture(time, curves, name, "s"))
    return card(title, facts, "".join(panels), {f"{leg} leg": colour for leg, colour in _LEGS.items()})


def animation(name: str, gaits: Sequence[Gait], places: Sequence[Place]) -> Animation:
    """The legs of a walk in motion, over their ground and the path of the swing ankle; the right leg first."""
    ends = np.cumsum([gait.duration for gait in gaits])
    corners = sum(len(leg) for leg in places[0].legs(0))
    times = instants(float(ends[-1]), 2 * corners)
    steps = np.minimum(np.searchsorted(ends, times), len(gaits) - 1)
    moving: dict[str, list[Array]] = {leg: [] for leg in _LEGS}
    for time, number in zip(times.tolist(), steps.tolist(), strict=True):
        gait, place = gaits[number], places[number]
        since = time - (float(ends[number]) - gait.duration)
        frame = np.interp(since, gait.times, np.arange(len(gait)))
        before = min(int(frame), len(gait) - 2)
        share = frame - before
        # Straight lines between neighbouring frames: no eye sees what the spline would add.
        legs = zip(place.legs(before), place.legs(before + 1), strict=True)
        stands, swings = ((1.0 - share) * one + share * other for one, other in legs)
        own = as_leg(place.swings, "swings")
        moving[own].append(swings)
        moving[other_leg(own)].append(stands)
    # Where the steps are many, each keeps the ends and the height of its path, and no more.
    some = max(5, PATH_POINTS // len(places))
    paths = [Shape(place.joints[_some(len(place.joints), some), 4] + place.origin, PATH, 1.2, 0.6) for place in places]
    lines = tuple(np.array(rows) for rows in moving.values())
    return Animation(name, (*ground_shapes(places), *paths), lines, tuple(_LEGS.values()), float(ends[-1]))


def _some(count: int, most: int) -> NDArray[np.int64]:
    """At most so many of `count` frames, evenly spaced."""
    return np.unique(np.rint(np.linspace(0, count - 1, most)).astype(np.int64))


_LEGS = {"right": RIGHT, "left": LEFT}
