"""What a notebook shows of gaits: their legs on level ground, or their angles where no leg lengths are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.picture import STEP_LEGEND, Place, angles_picture, steps_picture
from ggo_factors.notebook.card import card
from ggo_factors.notebook.svg import SUPPORT, SWING
from ggo_factors.support.inputs import Array

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
