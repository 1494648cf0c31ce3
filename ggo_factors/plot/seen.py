"""A picture of a terrain that was seen: its surfaces over the points, edges with their spread, what nobody saw."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from ggo_factors.motion.world import Terrain
from ggo_factors.plot.panels import OBSTACLE_COLOUR, PATH_COLOUR, name_figure, new_axes
from ggo_factors.seeing.strip import Sighting, strip_of
from ggo_factors.support.inputs import as_instance, as_tuple_of

MOST_POINTS = 20_000
"""More points of a frame are thinned out: the picture would show no more."""
DEVIATIONS = 1.96
"""Edges are drawn with bars of this many standard deviations to both sides: 95 of 100 true ones lie within."""
LINE = "0.35"
"""Grey of the ground, dark enough to be seen over the points."""
DEPTH_M = 0.08
"""How deep pits and unknown ground are drawn, in [m]."""


def plot_seen(terrain: Terrain, sightings: Iterable[Sighting] = (), *, ax: Axes | None = None) -> Axes:
    """The terrain from the side, in [m], over the points that it was made of.

    Args:
        terrain: the terrain.
        sightings: the frames it was seen in; only their points are drawn.
        ax: axes to draw on, without a title then; new ones by default.

    Raises:
        InputError: where an argument is no terrain, or no sighting.
    """
    as_instance(terrain, "terrain", Terrain)
    frames = as_tuple_of(sightings, "sightings", Sighting)
    new = ax is None
    ax = new_axes(1, 1, (9.0, 3.6))[0] if ax is None else ax
    for frame in frames:
        strip = strip_of(frame)
        every = max(1, len(strip.x) // MOST_POINTS)
        ax.plot(strip.x[::every], strip.y[::every], ",", color=PATH_COLOUR, alpha=0.5, gid="points", zorder=1)
    for pit in terrain.pits:
        ground = float(terrain.height_at(pit.x_start))
        end = min(pit.x_end, terrain.x_end)
        hatch, colour = ("////", "none") if pit.unknown else ("", "0.15")
        size = max(end - pit.x_start, 0.0), DEPTH_M
        ax.add_patch(Rectangle((pit.x_start, ground - DEPTH_M), *size, fc=colour, ec="0.15", hatch=hatch, zorder=2))
    for box, top in zip(terrain.boxes, terrain.tops, strict=True):
        corner, size = (box.x_start, top - box.height), (box.x_end - box.x_start, box.height)
        ax.add_patch(Rectangle(corner, *size, fc=OBSTACLE_COLOUR, ec="0.15", lw=0.8, alpha=0.6, zorder=3))
        for x in (box.x_start, box.x_end):
            _bar(ax, x, top, box.edge_std, box.height_std)
    before = None
    for surface in terrain.surfaces:
        ends = [surface.x_start, surface.x_end], [surface.height, surface.end_height]
        if before is not None:
            ax.plot([surface.x_start] * 2, [before.end_height, surface.height], color=LINE, lw=2.0, zorder=4)
            _bar(ax, surface.x_start, surface.height, surface.edge_std, surface.height_std)
        ax.plot(*ends, color=LINE, lw=2.0, zorder=4)
        before = surface
    ax.set_aspect("equal")
    low, high = ax.get_ylim()
    ax.set_ylim(max(low, float(np.min(_heights(terrain))) - 0.4), min(high, float(np.max(_heights(terrain))) + 0.4))
    ax.set_xlim(min(0.0, terrain.x_start), terrain.x_end + 0.1)
    ax.set_xlabel("x from the supporting ankle [m]")
    ax.set_ylabel("height [m]")
    handles = _handles(terrain, bool(frames))
    ax.legend(
        handles=handles,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=len(handles),
        frameon=False,
        fontsize="small",
    )
    if new:
        name_figure((ax,), _title(terrain, len(frames)))
    return ax


def _title(terrain: Terrain, frames: int) -> str:
    seen = f", seen in {frames} frame{'s' if frames != 1 else ''}" if frames else ""
    return f"Ground from the side: {terrain.name}, {terrain.length:.2f} m{seen}"


def _heights(terrain: Terrain) -> list[float]:
    ground = [height for surface in terrain.surfaces for height in (surface.height, surface.end_height)]
    return [*ground, *terrain.tops]


def _bar(ax: Axes, x: float, y: float, edge_std: float, height_std: float) -> None:
    across, along = DEVIATIONS * edge_std, DEVIATIONS * height_std
    ax.errorbar(x, y, xerr=across, yerr=along, color="black", lw=1.0, capsize=2.0, gid="spread", zorder=5)


def _handles(terrain: Terrain, points: bool) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = [Line2D([], [], color=LINE, lw=2.0, label="ground")]
    if points:
        handles.append(Line2D([], [], color=PATH_COLOUR, marker=".", ls="none", label="points seen"))
    if terrain.boxes:
        handles.append(Patch(fc=OBSTACLE_COLOUR, ec="0.15", alpha=0.6, label="box"))
    if any(not pit.unknown for pit in terrain.pits):
        handles.append(Patch(fc="0.15", label="pit"))
    if any(pit.unknown for pit in terrain.pits):
        handles.append(Patch(fc="none", ec="0.15", hatch="////", label="nobody saw it"))
    handles.append(Line2D([], [], color="black", lw=1.0, marker="|", label="95 % interval"))
    return handles
