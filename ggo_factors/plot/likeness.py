"""A picture of likeness: how far gaits are from what a person did, over the step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ggo_factors.errors import InputError
from ggo_factors.evaluate.likeness import METHODS, Comparison
from ggo_factors.plot.panels import (
    ANGLE_TITLES,
    BASE_COLOUR,
    PATH_COLOUR,
    SUPPORT_COLOUR,
    SWING_COLOUR,
    finish_panels,
    four_panels,
    legend_above_figure,
)
from ggo_factors.support.inputs import as_instance

COLOURS = (SWING_COLOUR, SUPPORT_COLOUR, BASE_COLOUR, "#999999", PATH_COLOUR, "#56B4E9", "#E69F00")
"""One colour for each method, in their order."""


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
    for method, colour in zip(METHODS, COLOURS, strict=True):
        off = made.by_frame_deg(method)
        percent = np.linspace(0.0, 100.0, len(off))
        label = f"{method.replace('_', ' ')} ({made.rmse_deg(method):.2f})"
        for ax, curve in zip(panels, off.T, strict=True):
            ax.plot(percent, curve, color=colour, lw=2.2 if method == METHODS[0] else 1.2, label=label, gid=method)
    for ax, title in zip(panels, ANGLE_TITLES, strict=True):
        ax.set_title(title, fontsize="medium")
        ax.set_ylim(bottom=0.0)
    finish_panels(panels, "step [%]", "RMSE [deg]")
    legend_above_figure(panels, panels[0].get_legend_handles_labels()[0])
    return panels
