"""What a notebook shows of an import: the mean cycle of each leg with its spread, and what was found and decided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ggo_factors.motion.picture import angles_picture
from ggo_factors.notebook.card import card
from ggo_factors.notebook.svg import LEFT, RIGHT
from ggo_factors.support.inputs import Array

COLOURS = {"right": RIGHT, "left": LEFT}


def import_card(
    title: str, cycle: Mapping[str, Array], spread: Mapping[str, Array], facts: Mapping[str, str | Sequence[str]]
) -> str:
    """A card of an import.

    Args:
        title: what was imported.
        cycle: `ImportReport.mean_cycle`.
        spread: `ImportReport.spread`.
        facts: what is to be known, by what it is.
    """
    panels = []
    for place, name in ((-2, "thigh"), (-1, "knee")):  # on stairs the swinging leg's are the last two
        curves = [(leg, COLOURS[leg], row[:, place], spread[leg][:, place]) for leg, row in cycle.items()]
        phases = np.arange(len(curves[0][2])) * 100.0 / len(curves[0][2])
        panels.append(angles_picture(phases, curves, name))
    legend = {f"{leg} leg, mean and standard deviation": COLOURS[leg] for leg in cycle}
    return card(title, facts, "".join(panels), legend)
