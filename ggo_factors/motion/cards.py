"""What a notebook shows of gaits, terrains and styles: legs on level ground, ground from the side, or joint angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.picture import STEP_LEGEND, Place, angles_picture, steps_picture, terrain_picture
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.notebook.card import card
from ggo_factors.notebook.svg import GROUND, OBSTACLE, SUPPORT, SWING
from ggo_factors.support.inputs import Array

MOST_PIECES = 100
"""Most surfaces, boxes and pits of a terrain in its picture: what can be told apart, and keeps it below 20 kB."""

Facts = Mapping[str, str | Sequence[str]]


def gait_card(name: str, frames: Array, model: LegModel | None, facts: Facts) -> str:
    """A card of one gait, of its frames in [rad], shape (m, 4)."""
    legend = dict(list(STEP_LEGEND.items())[:2]) if model is None else STEP_LEGEND
    return card(f"Gait: {name}" if name else "Gait", facts, frames_picture(frames, model), legend)


def base_gaits_card(frames: Mapping[str, Array], model: LegModel | None, facts: Facts) -> str:
    """A card of several gaits, of their frames in [rad], shape (m, 4), by which they are."""
    pictures = [f"<div>{escape(name)}<br>{frames_picture(own, model)}</div>" for name, own in frames.items()]
    legend = dict(list(STEP_LEGEND.items())[:2]) if model is None else STEP_LEGEND
    return card("Base gaits", facts, "".join(pictures), legend)


def terrain_card(
    title: str,
    ground: Ground,
    ends: tuple[float, float],
    boxes: Sequence[tuple[Obstacle, float]],
    pits: Sequence[Gap],
    facts: Facts,
) -> str:
    """A card of a terrain; the first `MOST_PIECES` of each kind are drawn.

    Args:
        title: its title.
        ground: height of the ground in the world frame.
        ends: where it begins and ends in [m].
        boxes: its boxes, each with the height of its top in [m].
        pits: its pits.
        facts: what is to be known, by what it is.
    """
    low, high = ends
    boxes, pits = sorted(boxes, key=lambda box: box[0].x_start), sorted(pits, key=lambda pit: pit.x_start)
    begins = (ground.edges, [box.x_start for box, _ in boxes], [pit.x_start for pit in pits])
    until = min([high, *(places[MOST_PIECES] for places in begins if len(places) > MOST_PIECES)])
    boxes, pits = boxes[:MOST_PIECES], pits[:MOST_PIECES]
    drawn = [box for box in boxes if box[0].x_start < until], [pit for pit in pits if pit.x_start < until]
    cut = {"picture": f"as far as x = {until:.3f} m"} if until < high else {}
    picture = terrain_picture(ground, low, max(until, low + 1e-3), *drawn)
    return card(title, {**facts, **cut}, picture, {"ground": GROUND} | ({"box": OBSTACLE} if boxes else {}))


def frames_picture(frames: Array, model: LegModel | None) -> str:
    """The picture of one gait, of its frames in [rad], shape (m, 4)."""
    if model is not None:
        return steps_picture([Place(model.joints(frames), model.foot, np.zeros(2))], "the legs at some frames")
    percent = np.linspace(0.0, 100.0, len(frames))
    both = (("support leg", SUPPORT), ("swing leg", SWING))
    return "".join(
        angles_picture(percent, [(*leg, frames[:, 2 * n + joint], None) for n, leg in enumerate(both)], words)
        for joint, words in enumerate(("thigh", "knee"))
    )
