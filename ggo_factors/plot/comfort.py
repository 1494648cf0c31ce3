"""A picture of comfort: speed, acceleration and jerk of each joint, several gaits side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ggo_factors.errors import InputError
from ggo_factors.evaluate.comfort import RATES, Comfort
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.plot.panels import (
    ANGLE_NAMES,
    BASE_COLOUR,
    PATH_COLOUR,
    finish_panels,
    given_axes,
    lighter,
    name_figure,
    new_axes,
    show_legend,
)
from ggo_factors.plot.titles import short_name
from ggo_factors.support.inputs import as_tuple_of

COLOURS = (PATH_COLOUR, BASE_COLOUR, "#CC79A7", "#E69F00", "#56B4E9")
"""One colour for each gait, none that of a leg; more than five are hard to tell apart."""
POWERS = {"deg/s2": "deg/s\u00b2", "deg/s3": "deg/s\u00b3"}
"""Units as a picture can write them."""


def plot_comfort(comforts: Sequence[Comfort], *, axes: Sequence[Axes] | None = None) -> tuple[Axes, ...]:
    """Peak (bar) and root mean square (mark in it) of each joint's speed, acceleration and jerk, a panel for each.

    Args:
        comforts: the gaits to compare, up to five, of the same joints.
        axes: three axes to draw on; a new figure by default.

    Raises:
        InputError: where there are no gaits or too many, their joints differ, or `axes` are not three.
    """
    made = as_tuple_of(comforts, "comforts", Comfort)
    if not 1 <= len(made) <= len(COLOURS):
        raise InputError(f"comforts: {len(made)} gaits, from 1 to {len(COLOURS)} can be told apart")
    joints = made[0].joints
    for other in made[1:]:
        if other.joints != joints:
            raise InputError(f"comforts: {other.name!r} is of {', '.join(other.joints)}, not of {', '.join(joints)}")
    panels = new_axes(1, 3, (9.6, 3.4)) if axes is None else given_axes(axes)
    if len(panels) != len(RATES):
        raise InputError(f"axes: expected three, got {len(panels)}")
    width = 0.8 / len(made)
    for row, (ax, (rate, unit)) in enumerate(zip(panels, RATES.items(), strict=True)):
        for number, (gait, colour) in enumerate(zip(made, COLOURS, strict=False)):
            places = np.arange(len(joints)) + (number - (len(made) - 1) / 2.0) * width
            style: dict[str, Any] = {"color": lighter(colour, 0.55), "gid": gait.name, "label": gait.name}
            ax.bar(places, np.degrees(gait.peaks[row]), 0.9 * width, **style)
            marks = places - 0.45 * width, places + 0.45 * width
            ax.hlines(np.degrees(gait.rms[row]), *marks, color=colour, lw=2.2, gid="rms", label="root mean square")
        ax.set_xticks(np.arange(len(joints)), ANGLE_NAMES if joints == JOINTS else joints)
        ax.set_title(f"{rate} [{POWERS.get(unit, unit)}]", fontsize="medium")
    finish_panels(panels, "", "")
    for ax in panels:
        ax.grid(False, axis="x")
        if joints != JOINTS:
            ax.tick_params(axis="x", labelrotation=30)
    show_legend(panels)
    if axes is None:
        names = ", ".join(short_name(gait.name) for gait in made)
        name_figure(panels, f"Peak and root mean square of each joint: {names}")
    return panels
