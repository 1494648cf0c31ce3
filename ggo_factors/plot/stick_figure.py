"""A picture of the legs: stick figures on their ground, with the path of the swing ankle, as in the paper."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from ggo_factors.errors import InputError
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.plot.panels import (
    BASE_COLOUR,
    GROUND_COLOUR,
    OBSTACLE_COLOUR,
    PATH_COLOUR,
    SUPPORT_COLOUR,
    SWING_COLOUR,
    gaits_of,
    legend_above,
    lighter,
    new_axes,
)
from ggo_factors.support.inputs import as_count, as_tuple_of
from ggo_factors.walking.walk import Walk


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

    A walk is drawn in the body frame of its first step, with the ground and the obstacles of its own plan.

    Args:
        walk: a walk, the solution of one step, or the gait of one step.
        model: the legs; by default the gait's own.
        obstacles: boxes in the body frame of a single step; a walk has its own.
        gaps: pits in the body frame of a single step; a walk has its own.
        ground: ground of a single step, level by default; a walk has its own.
        foothold: where the swing ankle was to land in a single step in [m], shape (2,); a walk has its own.
        frames: how many figures to draw of each step, evenly spaced, or which frames.
        base: base gait whose path of the swing ankle is drawn dashed in each step, or that of each.
        ax: axes to draw on; new ones by default.

    Raises:
        InputError: where no leg lengths are known, a frame is not there, or ground is given with a walk.
    """
    boxes, pits = as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap)
    single = not isinstance(walk, Walk)
    if not single and (boxes or pits or ground is not None or foothold is not None):
        raise InputError("obstacles, gaps, ground, foothold: a walk has its own; give them with a single step only")
    gaits = gaits_of(walk)
    bases = () if base is None else (base,) * len(gaits) if isinstance(base, Gait) else as_tuple_of(base, "base", Gait)
    if bases and len(bases) != len(gaits):
        raise InputError(f"base: {len(bases)} base gaits for {len(gaits)} steps; one, or one each")
    legs = gaits[0].legs(model)
    origins = np.concatenate([np.zeros((1, 2)), np.cumsum([gait.endpoints(legs)[-1] for gait in gaits], axis=0)])
    asked = as_count(frames, "frames", 1) if isinstance(frames, int) else as_tuple_of(frames, "frames", int)
    pictured = [_chosen(asked, gait) for gait in gaits]
    new = ax is None
    ax = new_axes(1, 1, (6.4, 3.6))[0] if ax is None else ax
    has_pit = has_box = False
    grounds: list[tuple[Ground, float, float]] = []
    for number, (gait, chosen) in enumerate(zip(gaits, pictured, strict=True)):
        x, y = origins[number].tolist()
        step = walk.plan[number] if isinstance(walk, Walk) else None
        own_boxes, own_pits = (step.obstacles, step.gaps) if step else (boxes, pits)
        below = step.ground if step else ground or Ground()
        target = step.foothold if step else foothold
        grounds.append((below, x, y))
        for shade, frame in zip(np.linspace(0.3, 1.0, len(chosen)), chosen, strict=True):
            if number and frame == 0:
                continue  # The swap frame: the step before has drawn it.
            joints = legs.joints(gait.frames[frame]) + origins[number]
            for colour, points in ((SUPPORT_COLOUR, joints[:3]), (SWING_COLOUR, joints[2:])):
                ax.plot(*points.T, color=lighter(colour, shade), lw=1.8, marker="o", ms=2.5, solid_capstyle="round")
        for own in bases[number : number + 1]:
            ax.plot(*(own.endpoints(legs) + origins[number]).T, color=BASE_COLOUR, ls="--", lw=1.2, gid="base path")
        ax.plot(*(gait.endpoints(legs) + origins[number]).T, color=PATH_COLOUR, lw=2.0, gid="swing ankle", zorder=3)
        if target is not None:
            ax.plot(x + target[0], y + target[1], "kx", ms=7, mew=1.5, ls="none", gid="foothold", zorder=4)
        for pit in own_pits:
            has_pit = True
            ax.add_patch(_pit(pit, x, y))
        for box in own_boxes:
            if not _is_stair_edge(box, below):
                has_box = True
                ax.add_patch(_box(box, x, y))
    _draw_grounds(ax, grounds)
    if new:
        # As wide as the walk is long, so that the legs keep their size on the page.
        width, height = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
        ax.figure.set_size_inches(min(max(0.9 + 3.2 * width / height, 4.2), 12.0), 4.3)  # type: ignore[union-attr]
    ax.set_aspect("equal")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=SUPPORT_COLOUR, lw=1.8, label="support leg"),
        Line2D([], [], color=SWING_COLOUR, lw=1.8, label="swing leg"),
        Line2D([], [], color=PATH_COLOUR, lw=2.0, label="swing ankle"),
    ]
    if bases:
        handles.append(Line2D([], [], color=BASE_COLOUR, ls="--", lw=1.2, label="swing ankle, base gait"))
    if any(line.get_gid() == "foothold" for line in ax.lines):
        handles.append(Line2D([], [], color="k", marker="x", ms=7, mew=1.5, ls="none", label="foothold"))
    if has_box:
        handles.append(Patch(facecolor=OBSTACLE_COLOUR, edgecolor="k", label="obstacle"))
    if has_pit:
        handles.append(Patch(facecolor="w", edgecolor="k", hatch="////", label="gap"))
    legend_above(ax, handles, 3 if len(handles) != 4 else 2)
    return ax


def _chosen(frames: int | tuple[int, ...], gait: Gait) -> list[int]:
    """Numbers of the frames to draw of a gait."""
    if isinstance(frames, int):
        return sorted({int(n) for n in np.rint(np.linspace(0, len(gait) - 1, frames))})
    for frame in frames:
        if not 0 <= frame < len(gait):
            raise InputError(f"frames: {frame} is not among the frames 0 to {len(gait) - 1}")
    return list(frames)


def _is_stair_edge(box: Obstacle, ground: Ground) -> bool:
    """Whether an obstacle only stands for the edge of a stair, and so is part of the ground's picture."""
    return any(box.x_start <= x <= box.x_end and box.height <= ground.height_at(x) + 1e-9 for x in ground.edges)


def _box(box: Obstacle, x: float, y: float) -> Rectangle:
    corner, size = (x + box.x_start, y), (box.x_end - box.x_start, box.height)
    return Rectangle(corner, *size, facecolor=OBSTACLE_COLOUR, edgecolor="k", lw=0.8, zorder=2.5, gid="obstacle")


def _pit(gap: Gap, x: float, y: float) -> Rectangle:
    corner, width = (x + gap.x_start, y - 0.06), gap.x_end - gap.x_start
    return Rectangle(corner, width, 0.06, facecolor="w", edgecolor="k", hatch="////", lw=0.8, zorder=1.5, gid="gap")


def _draw_grounds(ax: Axes, grounds: Sequence[tuple[Ground, float, float]]) -> None:
    """The ground of each step, from its support ankle to the next one's; beyond at both ends."""
    ax.margins(0.04)
    ax.autoscale_view()
    left, right = ax.get_xlim()
    lowest, top = ax.get_ylim()
    borders = [left, *(x for _, x, _ in grounds[1:]), right]
    xs: list[float] = []
    ys: list[float] = []
    for (ground, x, y), low, high in zip(grounds, borders[:-1], borders[1:], strict=True):
        edges = [edge + x for edge in ground.edges]
        cuts = [low, *(edge for edge in edges if low < edge < high), high]
        for start, end in pairwise(cuts):
            height = float(ground.height_at((start + end) / 2.0 - x)) + y
            xs += [start, end]
            ys += [height, height]
    bottom = min(lowest, *ys) - 0.05
    ax.fill_between(xs, ys, bottom, color=GROUND_COLOUR, lw=0.0, zorder=0.5)
    ax.plot(xs, ys, color="k", lw=1.0, zorder=1.0, gid="ground")
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
