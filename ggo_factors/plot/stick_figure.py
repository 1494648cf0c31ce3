"""A picture of the legs: stick figures on their ground, with the path of the swing ankle, as in the paper."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ggo_factors.errors import InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import Foot, LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.plot.clearances import clearances_of, draw_clearances
from ggo_factors.plot.panels import (
    BASE_COLOUR,
    LEG_COLOURS,
    PATH_COLOUR,
    SUPPORT_COLOUR,
    SWING_COLOUR,
    bases_of,
    gaits_of,
    legs_of_step,
    lighter,
    name_figure,
    new_axes,
    show_legend,
)
from ggo_factors.plot.terrain import Place, draw_boxes, draw_grounds, draw_pits, draw_unseen
from ggo_factors.plot.titles import title_of
from ggo_factors.support.inputs import Array, as_count, as_tuple_of
from ggo_factors.walking.walk import Walk

INCHES = 3.7
"""Inches of a new figure to a metre, where it does not become wider than `WIDEST`."""
NARROWEST, WIDEST = 5.2, 12.0
"""Least and largest width of a new figure in inches."""

Around = tuple[Ground, tuple[Obstacle, ...], tuple[Gap, ...], tuple[float, float] | None]
"""Ground, boxes, pits and foothold of a step."""


@dataclass(frozen=True, eq=False)
class Pictured:
    """One step as it is drawn.

    Attributes:
        gait: the step.
        legs: the legs.
        ankle: the supporting ankle in the picture in [m], shape (2,).
        place: what is around the step.
        foothold: where the swing ankle was to land in [m], from the supporting ankle; or None.
        frames: which frames are drawn.
        names: what the legend calls the supporting and the swinging leg.
        colours: their colours.
    """

    gait: Gait
    legs: LegModel
    ankle: Array
    place: Place
    foothold: tuple[float, float] | None
    frames: list[int]
    names: tuple[str, str]
    colours: tuple[str, str]


def plot_stick_figure(
    walk: Walk | Solution | Gait,
    *,
    model: LegModel | None = None,
    obstacles: Sequence[Obstacle] = (),
    gaps: Sequence[Gap] = (),
    ground: Ground | None = None,
    foothold: tuple[float, float] | None = None,
    frames: int | Sequence[int] = 7,
    base: Gait | Sequence[Gait] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The legs at some frames, light at first and darker later, on their ground, with the path of the swing ankle.

    A walk is drawn in the body frame of its first step, with the ground and the obstacles of its own plan. Each leg of
    it keeps its colour, and marks at the hip say where the legs change roles. Where the legs have feet, they are drawn,
    and y is from the sole of the first supporting foot upwards. Above the legs an inset for each box says how far the
    ankle or sole passes over it. A box measured with an error has a band that holds 95 % of its edges and heights.

    Args:
        walk: a walk, the solution of one step, or the gait of one step.
        model: the legs; by default the gait's own.
        obstacles: boxes in the body frame of a single step; a walk has its own.
        gaps: pits in the body frame of a single step; a walk has its own.
        ground: ground of a single step, level by default; a walk has its own.
        foothold: where the swing ankle was to land in a single step in [m], shape (2,); a walk has its own.
        frames: how many figures to draw of each step, evenly spaced, or which frames.
        base: base gait whose path of the swing ankle is drawn dashed in each step, or that of each.
        ax: axes to draw on, without a title then; new ones by default.

    Raises:
        InputError: where no leg lengths are known, a frame is not there, or ground is given with a walk.
    """
    boxes, pits = as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap)
    around: list[Around] = [(ground or Ground(), boxes, pits, foothold)]
    if isinstance(walk, Walk):
        if boxes or pits or ground is not None or foothold is not None:
            raise InputError("obstacles, gaps, ground, foothold: a walk has its own; give them with a single step only")
        around = [(step.ground, step.obstacles, step.gaps, step.foothold) for step in walk.plan]
    legs = gaits_of(walk)[0].legs(model)
    asked = as_count(frames, "frames", 1) if isinstance(frames, int) else as_tuple_of(frames, "frames", int)
    steps = _pictured(walk, legs, around, asked)
    given, ax = ax is not None, new_axes(1, 1, (6.4, 4.0))[0] if ax is None else ax
    bases = bases_of(base, len(steps))
    for number, step in enumerate(steps):
        _draw_legs(ax, step, number > 0)
        _draw_paths(ax, step, bases[number])
        draw_boxes(ax, step.place)
        draw_pits(ax, step.place)
        if number + 1 < len(steps):
            hip = legs.joints(step.gait.frames[-1])[2] + step.ankle
            ax.plot(*hip, "D", color="k", mfc="w", ms=6, ls="none", gid="swap", label="legs swap", zorder=4)
    draw_grounds(ax, [step.place for step in steps])
    for step in steps:
        draw_unseen(ax, step.place)
    found = [clearance for step in steps for clearance in clearances_of(step.gait, legs, step.place, step.colours[1])]
    draw_clearances(ax, found, legs.reach)
    # At the top of its room, where the legend is, or the layout would leave none for it.
    ax.set_aspect("equal", anchor="N")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    if given:
        show_legend((ax,))
    else:
        _finish_figure(ax, title_of("", walk, model))
    return ax


def _pictured(
    walk: Walk | Solution | Gait,
    legs: LegModel,
    around: Sequence[Around],
    asked: int | tuple[int, ...],
) -> list[Pictured]:
    """The steps where they stand, the sole of the first supporting foot at y = 0."""
    steps: list[Pictured] = []
    ankle = np.array([0.0, around[0][0].ankle_over(legs.foot)])
    for number, (gait, (ground, boxes, pits, foothold)) in enumerate(zip(gaits_of(walk), around, strict=True)):
        names, colours = ("support leg", "swing leg"), (SUPPORT_COLOUR, SWING_COLOUR)
        if isinstance(walk, Walk):
            support, swing = legs_of_step(walk, number)
            names, colours = (f"{support} leg", f"{swing} leg"), (LEG_COLOURS[support], LEG_COLOURS[swing])
        x, y = ankle.tolist()
        place = Place(x, y - ground.ankle_over(legs.foot), ground, boxes, pits)
        steps.append(Pictured(gait, legs, ankle, place, foothold, _chosen(asked, gait), names, colours))
        ankle = ankle + gait.endpoints(legs)[-1]
    return steps


def _draw_legs(ax: Axes, step: Pictured, begun: bool) -> None:
    """The legs at the chosen frames; not the first frame where the step before has drawn it, as its last."""
    for shade, frame in zip(np.linspace(0.3, 1.0, len(step.frames)), step.frames, strict=True):
        if begun and frame == 0:
            continue
        joints = step.legs.joints(step.gait.frames[frame]) + step.ankle
        last = frame == step.frames[-1]
        for number, points in enumerate((joints[:3], joints[2:])):
            colour, name = lighter(step.colours[number], float(shade)), step.names[number] if last else None
            ax.plot(*points.T, color=colour, lw=1.8, marker="o", ms=2.5, solid_capstyle="round", label=name)
            # The supporting foot stands still: once is enough.
            if step.legs.foot != Foot() and (number or last):
                ankle = points[-1] if number else points[0]
                sole = foot_outline(step.legs.foot, ankle, _tilt(step, ankle))
                ax.plot(*sole.T, color=colour, lw=1.8, solid_capstyle="round", solid_joinstyle="round", gid="foot")


def foot_outline(foot: Foot, ankle: Array, tilt: float) -> Array:
    """Ankle, heel, toe and ankle again in [m], shape (4, 2), of a foot whose sole is tilted by `tilt` in [rad]."""
    along = np.array([math.cos(tilt), math.sin(tilt)])
    middle = ankle + foot.ankle_height * np.array([along[1], -along[0]])
    return np.array([ankle, middle - foot.heel * along, middle + foot.toe * along, ankle])


def _tilt(step: Pictured, ankle: Array) -> float:
    """Tilt of a sole in [rad]: that of the ground it leaves, on its way turned evenly by x to that it lands on."""
    path, ground = step.gait.endpoints(step.legs)[:, 0], step.place.ground
    x = float(ankle[0]) - step.place.x
    if not ground.slopes or x == 0.0:
        return ground.slope_at(0.0)
    return float(ground.sole_tilt(x, float(path[0]), float(path[-1])))


def _draw_paths(ax: Axes, step: Pictured, base: Gait | None) -> None:
    """The path of the swing ankle, that of the base gait, and where it was to land."""
    path = step.gait.endpoints(step.legs) + step.ankle
    ax.plot(*path.T, color=PATH_COLOUR, lw=2.0, gid="swing ankle", label="swing ankle", zorder=3)
    if base is not None:
        path, label = base.endpoints(step.legs) + step.ankle, "swing ankle, base gait"
        ax.plot(*path.T, color=BASE_COLOUR, ls="--", lw=1.2, gid="base path", label=label)
    if step.foothold is not None:
        x, y = step.place.x + step.foothold[0], step.place.y + step.foothold[1]
        ax.plot(x, y, "kx", ms=7, mew=1.5, ls="none", gid="foothold", label="foothold", zorder=4)


def _size_figure(ax: Axes) -> float:
    """Make a new figure as wide as the walk is long, so that legs keep their size on the page; inches to a metre."""
    width, height = float(np.ptp(ax.get_xlim())), float(np.ptp(ax.get_ylim()))
    inches = min(INCHES, (WIDEST - 0.9) / width)
    figure = ax.figure
    assert isinstance(figure, Figure)  # it was made for these axes
    figure.set_size_inches(max(0.9 + inches * width, NARROWEST), 1.5 + inches * height)
    return inches


def _finish_figure(ax: Axes, title: str) -> None:
    """A title and a legend, and then a new figure as high as these, the axes and their labels are.

    Axes of equal scales that are shrunk to their room mislead the layout, which then cuts a label off.
    """
    inches = _size_figure(ax)
    name_figure((ax,), title)
    show_legend((ax,))
    figure = ax.figure
    assert isinstance(figure, Figure)  # as above
    for _ in range(2):
        figure.draw_without_rendering()
        beside = figure.get_figheight() * (1.0 - ax.get_position(original=True).height)
        figure.set_figheight(inches * float(np.ptp(ax.get_ylim())) + beside)


def _chosen(frames: int | tuple[int, ...], gait: Gait) -> list[int]:
    """Numbers of the frames to draw of a gait."""
    if isinstance(frames, int):
        return sorted({int(n) for n in np.rint(np.linspace(0, len(gait) - 1, frames))})
    for frame in frames:
        if not 0 <= frame < len(gait):
            raise InputError(f"frames: {frame} is not among the frames 0 to {len(gait) - 1}")
    return list(frames)
