"""Curves of gaits: joint angles, the residual of each frame, the trajectory of both legs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from ggo_factors.errors import InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.plot.panels import (
    ANGLE_NAMES,
    ANGLE_TITLES,
    BASE_COLOUR,
    JOINT_STYLES,
    LEG_COLOURS,
    SUPPORT_COLOUR,
    SWING_COLOUR,
    bases_of,
    finish_panels,
    four_panels,
    gaits_of,
    legs_of_step,
    lighter,
    name_figure,
    new_axes,
    show_legend,
)
from ggo_factors.plot.titles import title_of
from ggo_factors.support.inputs import Array
from ggo_factors.walking.trajectory import JointTrajectory
from ggo_factors.walking.walk import Walk

JOINT_TITLES = {
    "right_hip": "right hip",
    "right_knee": "right knee",
    "left_hip": "left hip",
    "left_knee": "left knee",
}
SWAP_COLOUR = "#777777"
MOST_NAMED = 6
"""Steps of a walk that the legend names one by one; of more, the first and the last, their shades between."""
PALEST = 0.4
"""Shade of the first step of a walk whose steps lie over each other; that of the last is 1."""


def plot_joint_angles(
    gait: Gait | Solution | Walk,
    base: Gait | Sequence[Gait] | None = None,
    *,
    label: str = "generated gait",
    colour: str | None = None,
    axes: Axes | Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """The four joint angles in degrees over the step in percent, the base gait dashed.

    Each leg has its colour, in all panels. The steps of a walk lie over each other, the first pale and the last dark.

    Args:
        gait: the gait, its solution, or a walk.
        base: the base gait to compare with, or that of each step.
        label: what the legend calls the gait; the steps of a walk have their numbers.
        colour: colour of the gait where each angle has its panel, to tell several gaits; each leg's own by default.
        axes: one axes for all four angles, or four; a new figure of four panels by default. To compare several
            gaits, call again on the axes returned.

    Raises:
        InputError: where `axes` are neither one nor four.
    """
    gaits = gaits_of(gait)
    # A base gait that several steps have is drawn once.
    bases = {own.fingerprint: own for own in bases_of(base, len(gaits)) if own is not None}.values()
    panels = four_panels(axes)
    shared = len(panels) == 1
    for number, name in enumerate(ANGLE_NAMES):
        ax, style = panels[number % len(panels)], JOINT_STYLES[number % 2]
        for each in bases:
            own = lighter((SUPPORT_COLOUR, SWING_COLOUR)[number // 2], 0.5) if shared else BASE_COLOUR
            shown, called = (style, f"{name}, base gait") if shared else ("--", "base gait")
            ax.plot(_percent(each), np.degrees(each.frames[:, number]), color=own, ls=shown, lw=1.2, label=called)
        for step, made in enumerate(gaits):
            legs, called = ("left", "right"), name if shared else label
            if isinstance(gait, Walk):
                legs, called = legs_of_step(gait, step), _step_label(gait, step)
                called = f"{name}, {called}" if called and shared else called
            leg_colour = LEG_COLOURS[legs[number // 2]]
            shade = 1.0 if len(gaits) == 1 else PALEST + (1.0 - PALEST) * step / (len(gaits) - 1)
            ax.plot(
                _percent(made),
                np.degrees(made.frames[:, number]),
                color=lighter(leg_colour if shared or colour is None else colour, shade),
                ls=style if shared else "-",
                lw=1.8,
                label=called,
            )
        if not shared:
            ax.set_title(f"{ANGLE_TITLES[number]} {name}", fontsize="medium")
    finish_panels(panels, "step [%]", "angle [deg]")
    for ax in panels:
        ax.set_xlim(0.0, 100.0)
    show_legend(panels)
    if axes is None:
        name_figure(panels, title_of("Joint angles", gait))
    return panels


def plot_residual(
    gait: Gait | Solution | Walk,
    base: Gait | Sequence[Gait],
    *,
    label: str = "generated gait",
    colour: str = SWING_COLOUR,
    ax: Axes | None = None,
) -> Axes:
    """How much each frame moves on otherwise than in the base gait: the norm of e_g(n) - e_z(n) in degrees.

    The steps of a walk follow each other in the colour of the leg that swings, with a mark where the legs change roles.

    Args:
        gait: the gait, its solution or a walk, each step of as many frames as the base gait.
        base: the base gait, or that of each step.
        label: what the legend calls the gait; those of a walk are called by the leg that swings.
        colour: colour of its curve; the steps of a walk have that of the leg that swings.
        ax: axes to draw on; new ones by default. To compare several gaits, call again on the axes returned.

    Raises:
        InputError: where the gaits differ in their number of frames.
    """
    gaits = gaits_of(gait)
    bases = [own for own in bases_of(base, len(gaits)) if own is not None]
    for made, own in zip(gaits, bases, strict=True):
        if len(made) != len(own):
            raise InputError(f"gait: has {len(made)} frames, the base gait {len(own)}")
    given, ax = ax is not None, new_axes(1, 1, (6.4, 3.8))[0] if ax is None else ax
    first = 0
    for step, (made, own) in enumerate(zip(gaits, bases, strict=True)):
        residual = np.linalg.norm(np.diff(made.frames - own.frames, axis=0), axis=1)
        if isinstance(gait, Walk):
            (_, swing) = legs_of_step(gait, step)
            label, colour = f"{swing} leg swings", LEG_COLOURS[swing]
        ax.plot(
            first + np.arange(1, len(made)), np.degrees(residual), color=colour, lw=1.8, label=label, gid="residual"
        )
        first += len(made) - 1
    _mark_swaps((ax,), np.cumsum([len(made) - 1 for made in gaits[:-1]]).tolist())
    ax.set_xlim(1, max(first, 2))
    curves = [line for line in ax.lines if line.get_gid() == "residual"]
    ax.set_ylim(0.0, 1.1 * max(float(np.max(line.get_ydata())) for line in curves) or 1.0)
    finish_panels((ax,), "frame n", r"$\|\mathbf{e}_g(n) - \mathbf{e}_z(n)\|$ [deg]")
    show_legend((ax,))
    if not given:
        name_figure((ax,), title_of("Residual of each frame", gait))
    return ax


def plot_joint_trajectory(
    trajectory: JointTrajectory | Walk,
    *,
    first_swing: str | None = None,
    label: str | None = None,
    axes: Axes | Sequence[Axes] | None = None,
) -> tuple[Axes, ...]:
    """Hip (thigh from the vertical) and knee of both legs in degrees over time.

    Each leg has its colour. Where a walk is given, dotted lines mark the frames in which the legs change roles.

    Args:
        trajectory: the trajectory, or the walk to take it of.
        first_swing: the leg that swings first, where a walk is given; the walk's own by default.
        label: what the legend calls the trajectory where each joint has its panel; no entry by default.
        axes: one axes for all four joints, or four; a new figure of four panels by default.

    Raises:
        InputError: where `axes` are neither one nor four, or `first_swing` is neither leg.
    """
    swaps: list[float] = []
    title = "Joint trajectory of both legs"
    if isinstance(trajectory, Walk):
        if first_swing is not None:
            trajectory = replace(trajectory, first_swing=first_swing)
        title = title_of(title, trajectory)
        swaps = np.cumsum([gait.duration for gait in trajectory.gaits[:-1]]).tolist()
        trajectory = trajectory.joint_trajectory()
    else:
        title += f": {trajectory.time[-1] - trajectory.time[0]:.2f} s"
    panels = four_panels(axes)
    shared = len(panels) == 1
    for number, (joint, name) in enumerate(JOINT_TITLES.items()):
        ax = panels[number % len(panels)]
        leg, _, _ = joint.partition("_")
        ax.plot(
            trajectory.time,
            np.degrees(getattr(trajectory, joint)),
            color=LEG_COLOURS[leg],
            ls=JOINT_STYLES[number % 2] if shared else "-",
            lw=1.8,
            label=name if shared else label,
        )
        ax.set_xlim(float(trajectory.time[0]), float(trajectory.time[-1]))
        if not shared:
            ax.set_title(name, fontsize="medium")
    _mark_swaps(panels, swaps)
    finish_panels(panels, "time [s]", "angle [deg]")
    show_legend(panels)
    if axes is None:
        name_figure(panels, title)
    return panels


def _mark_swaps(panels: Sequence[Axes], places: Sequence[float]) -> None:
    """A dotted line wherever the legs change roles."""
    for ax in panels:
        for place in places:
            ax.axvline(place, color=SWAP_COLOUR, lw=1.0, ls=":", zorder=1.5, gid="swap", label="legs swap")


def _step_label(walk: Walk, number: int) -> str:
    """What the legend calls a step of a walk: of many, only the first and the last."""
    count, (_, swing) = len(walk.gaits), legs_of_step(walk, number)
    return f"step {number + 1}, {swing} swings" if count <= MOST_NAMED or number in (0, count - 1) else ""


def _percent(gait: Gait) -> Array:
    return np.linspace(0.0, 100.0, len(gait))
