"""A picture of likeness: how far gaits are from what a person did, over the step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ggo_factors.errors import InputError
from ggo_factors.evaluate.likeness import METHODS, STYLED, Comparison
from ggo_factors.plot.panels import (
    ANGLE_TITLES,
    BASE_COLOUR,
    PATH_COLOUR,
    finish_panels,
    four_panels,
    name_figure,
    show_legend,
)
from ggo_factors.plot.titles import file_name, short_name
from ggo_factors.support.inputs import as_instance

LINES = (
    (PATH_COLOUR, "-"),
    ("#CC79A7", "-"),
    (BASE_COLOUR, "--"),
    ("#999999", "-."),
    ("#E69F00", "-"),
    ("#56B4E9", "-"),
    ("#000000", ":"),
)
"""Colour and style of the line of each of `METHODS`, in their order; none has the colour of a leg."""
STYLED_LINE = ("#332288", "-")
"""Those of `STYLED`."""


def plot_comparison(comparison: Comparison, *, axes: Sequence[Axes] | None = None) -> tuple[Axes, ...]:
    """Root mean square error of each angle in degrees over the step in percent, a line for each method.

    Args:
        comparison: what `compare` returned.
        axes: four axes, one for each angle; a new figure by default.

    Raises:
        InputError: where no step was compared by all methods, or `axes` are not four.
    """
    made = as_instance(comparison, "comparison", Comparison)
    if not made.counted:
        raise InputError("comparison: there is no step for which every method has a gait")
    panels = four_panels(axes)
    if len(panels) != len(ANGLE_TITLES):
        raise InputError(f"axes: expected four, got {len(panels)}")
    lines = dict(zip(METHODS, LINES, strict=True)) | {STYLED: STYLED_LINE}
    for method in made.methods:
        colour, style = lines[method]
        off = made.by_frame_deg(method)
        percent = np.linspace(0.0, 100.0, len(off))
        label = f"{method.replace('_', ' ')} ({made.rmse_deg(method):.2f})"
        for ax, curve in zip(panels, off.T, strict=True):
            width = 2.4 if method in (METHODS[0], STYLED) else 1.3
            ax.plot(percent, curve, color=colour, ls=style, lw=width, label=label, gid=method)
    for ax, title in zip(panels, ANGLE_TITLES, strict=True):
        ax.set_title(title, fontsize="medium")
        ax.set_xlim(0.0, 100.0)
        ax.set_ylim(bottom=0.0)
    finish_panels(panels, "step [%]", "RMSE [deg]")
    show_legend(panels)
    if axes is None:
        steps = f"{len(made.counted)} step{'s' if len(made.counted) > 1 else ''} of {file_name(made.source)}"
        kind = "" if made.activity == "level" else f" ({made.activity.replace('-', ' ')})"
        name_figure(panels, f"Root mean square error against {steps}{kind}\nbase gait: {short_name(made.base)}")
    return panels
