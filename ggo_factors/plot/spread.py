"""A picture of spread: the joint angles of a generated gait, with a band of two standard deviations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ggo_factors.graph.solution import Solution
from ggo_factors.graph.spread import STEP_STD, joint_spread
from ggo_factors.motion.gait import Gait
from ggo_factors.plot.curves import plot_joint_angles
from ggo_factors.plot.panels import SUPPORT_COLOUR, SWING_COLOUR, name_figure, show_legend
from ggo_factors.plot.titles import title_of


def plot_spread(
    solution: Solution,
    base: Gait | None = None,
    *,
    step_std: float = STEP_STD,
    axes: Axes | Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """The four joint angles in degrees over the step in percent, two standard deviations shaded to either side.

    Args:
        solution: the solved graph.
        base: the base gait to compare with, dashed.
        step_std: how far healthy steps stray from the base gait in [rad], see `joint_spread`.
        axes: one axes for all four angles, or four; a new figure of four panels by default.

    Raises:
        InputError: where an argument is unusable.
    """
    spread = 2.0 * joint_spread(solution, step_std)
    panels = plot_joint_angles(solution, base, axes=axes)
    percent = np.linspace(0.0, 100.0, len(spread))
    frames = solution.gait.frames
    for number in range(frames.shape[1]):
        low, high = (np.degrees((frames + side * spread)[:, number]) for side in (-1.0, 1.0))
        panels[number % len(panels)].fill_between(
            percent,
            low,
            high,
            color=(SUPPORT_COLOUR, SWING_COLOUR)[number // 2],
            alpha=0.25,
            lw=0.0,
            gid="spread",
            label="\u00b1 2 standard deviations",
        )
    show_legend(panels)
    if axes is None:
        name_figure(panels, title_of("Joint angles and their spread", solution))
    return panels
