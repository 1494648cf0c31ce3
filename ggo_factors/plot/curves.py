"""Curves of gaits: joint angles, the residual of each frame, the trajectory of both legs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ggo_factors.errors import InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.plot.panels import (
    ANGLE_COLOURS,
    ANGLE_NAMES,
    ANGLE_TITLES,
    BASE_COLOUR,
    SUPPORT_COLOUR,
    SWING_COLOUR,
    finish_panels,
    four_panels,
    gaits_of,
    legend_above_all,
    new_axes,
)
from ggo_factors.support.inputs import Array
from ggo_factors.walking.trajectory import JointTrajectory
from ggo_factors.walking.walk import Walk

JOINT_TITLES = {
    "right_hip": "right hip",
    "right_knee": "right knee",
    "left_hip": "left hip",
    "left_knee": "left knee",
}


def plot_joint_angles(
    gait: Gait | Solution,
    base: Gait | None = None,
    *,
    label: str = "generated gait",
    colour: str = SUPPORT_COLOUR,
    axes: Axes | Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """The four joint angles in degrees over the step in percent, the base gait dashed.

    Args:
        gait: the gait, or its solution.
        base: the base gait to compare with.
        label: what the legend calls the gait.
        colour: colour of the gait where each angle has its panel; in one axes each angle has its own.
        axes: one axes for all four angles, or four; a new figure of four panels by default. To compare several
            gaits, call again on the axes returned.

    Raises:
        InputError: where `axes` are neither one nor four.
    """
    (gait,) = gaits_of(gait)
    panels = four_panels(axes)
    for number, name in enumerate(ANGLE_NAMES):
        ax = panels[number % len(panels)]
        shared = len(panels) == 1
        if base is not None:
            ax.plot(
                _percent(base),
                np.degrees(base.frames[:, number]),
                color=ANGLE_COLOURS[number] if shared else BASE_COLOUR,
                ls="--",
                lw=1.2,
                label=f"{name}, base gait" if shared else "base gait",
            )
        ax.plot(
            _percent(gait),
            np.degrees(gait.frames[:, number]),
            color=ANGLE_COLOURS[number] if shared else colour,
            lw=1.8,
            label=name if shared else label,
        )
        if not shared:
            ax.set_title(f"{ANGLE_TITLES[number]} {name}", fontsize="medium")
    finish_panels(panels, "step [%]", "angle [deg]")
    for ax in panels:
        ax.set_xlim(0.0, 100.0)
    legend_above_all(panels)
    return panels


def plot_residual(
    gait: Gait | Solution,
    base: Gait,
    *,
    label: str = "generated gait",
    colour: str = SWING_COLOUR,
    ax: Axes | None = None,
) -> Axes:
    """How much each frame moves on otherwise than in the base gait: the norm of e_g(n) - e_z(n) in degrees.

    Args:
        gait: the gait, or its solution, of as many frames as the base gait.
        base: the base gait.
        label: what the legend calls the gait.
        colour: colour of its curve.
        ax: axes to draw on; new ones by default. To compare several gaits, call again on the axes returned.

    Raises:
        InputError: where the gaits differ in their number of frames.
    """
    (gait,) = gaits_of(gait)
    if len(gait) != len(base):
        raise InputError(f"gait: has {len(gait)} frames, the base gait {len(base)}")
    ax = new_axes(1, 1, (5.6, 3.2))[0] if ax is None else ax
    residual = np.linalg.norm(np.diff(gait.frames - base.frames, axis=0), axis=1)
    ax.plot(np.arange(1, len(gait)), np.degrees(residual), color=colour, lw=1.8, label=label)
    ax.set_xlim(1, max(len(gait) - 1, 2))
    ax.set_ylim(0.0, 1.1 * max(float(np.max(line.get_ydata())) for line in ax.lines) or 1.0)
    finish_panels((ax,), "frame n", r"$\|\mathbf{e}_g(n) - \mathbf{e}_z(n)\|$ [deg]")
    legend_above_all((ax,))
    return ax


def plot_joint_trajectory(
    trajectory: JointTrajectory | Walk,
    *,
    first_swing: str = "right",
    label: str | None = None,
    axes: Axes | Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Hip (thigh from the vertical) and knee of both legs in degrees over time.

    Args:
        trajectory: the trajectory, or the walk to take it of.
        first_swing: the leg that swings first, where a walk is given.
        label: what the legend calls the trajectory where each joint has its panel; no legend by default.
        axes: one axes for all four joints, or four; a new figure of four panels by default.

    Raises:
        InputError: where `axes` are neither one nor four, or `first_swing` is neither leg.
    """
    if isinstance(trajectory, Walk):
        trajectory = trajectory.joint_trajectory(first_swing)
    panels = four_panels(axes)
    colours = (SWING_COLOUR, "#E69F00", SUPPORT_COLOUR, "#56B4E9")
    shared = len(panels) == 1
    for number, ((joint, title), colour) in enumerate(zip(JOINT_TITLES.items(), colours, strict=True)):
        ax = panels[number % len(panels)]
        name = title if shared else label
        ax.plot(trajectory.time, np.degrees(getattr(trajectory, joint)), color=colour, lw=1.8, label=name)
        ax.set_xlim(float(trajectory.time[0]), float(trajectory.time[-1]))
        if not shared:
            ax.set_title(title, fontsize="medium")
    finish_panels(panels, "time [s]", "angle [deg]")
    legend_above_all(panels)
    return panels


def _percent(gait: Gait) -> Array:
    return np.linspace(0.0, 100.0, len(gait))
