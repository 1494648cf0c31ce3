"""A terrain from the side, and a plan over it: footholds considered, refused and chosen, the walk, what steps cost."""

from __future__ import annotations

import string
import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from ggo_factors.motion.leg_model import Foot
from ggo_factors.motion.world import SAME_PLACE, Terrain
from ggo_factors.planning.plan import Plan
from ggo_factors.planning.whynot import Ban
from ggo_factors.plot.panels import (
    BASE_COLOUR,
    GROUND_COLOUR,
    LEG_COLOURS,
    LETTERS_PER_INCH,
    finish_panels,
    legs_of_step,
    lighter,
    name_figure,
    new_axes,
    show_legend,
)
from ggo_factors.plot.stick_figure import INCHES, WIDEST, foot_outline
from ggo_factors.plot.terrain import BAND, BAND_COLOUR, PIT_DEPTH, draw_box
from ggo_factors.plot.titles import short_name, title_of
from ggo_factors.support.inputs import Array, as_instance

BESIDE = 0.5
"""So much ground in [m] is drawn before and beyond what the picture is about."""
DEPTH = 0.22
"""How deep the lowest ground is drawn in [m]: the numbers of the steps stand in it."""
ROWS = {"right": 0.08, "left": 0.15}
"""How far below the ground the numbers of each foot's steps stand in [m]: feet may land side by side."""
HALO = withStroke(linewidth=2.0, foreground=GROUND_COLOUR)
"""Keeps the numbers readable where an edge or a tick is behind them."""
PALE = 0.3
"""Shade of the legs, which are not what the picture is about."""
SEAM = 0.01
"""The band of an edge without a riser reaches so far above and below the ground in [m]."""
NARROWEST = 7.2
"""Least width of a new figure in inches: the legend needs it."""
COSTS_INCHES = 0.9
"""Height of the panel of costs in inches."""
BAR = 0.05
"""Width of the bar of a step in [m]."""
TOLD = 4
"""So many refused steps are told in words."""
NEAR = 0.1
"""Refused steps that were to land within this distance of each other in [m] share their letters' place."""


def plot_terrain(terrain: Terrain, *, ax: Axes | None = None) -> Axes:
    """A terrain from the side: its surfaces with risers and ramps, boxes, pits, and what nobody saw.

    What was measured with an error has a band that holds 95 % of its edges and heights.

    Args:
        terrain: the terrain.
        ax: axes to draw on, without a title then; new ones by default.

    Raises:
        InputError: where it is no terrain.
    """
    as_instance(terrain, "terrain", Terrain)
    left, right = terrain.x_start - BESIDE, terrain.x_end + BESIDE
    given, ax = ax is not None, _new_axes(1, left, right)[0] if ax is None else ax
    top = max(
        *(height for surface in terrain.surfaces for height in (surface.height, surface.end_height)), *terrain.tops
    )
    _draw_terrain(ax, terrain, left, right, top + DEPTH)
    ax.set_xlabel("x [m]")
    _finish((ax,), None if given else f"Terrain: {short_name(terrain.name)}, {terrain.length:.4g} m")
    return ax


def plot_plan(plan: Plan, *, ax: Axes | None = None) -> Axes:
    """A plan over its terrain: where feet might land, where they do, the paths of both ankles, and what steps cost.

    Footholds chosen are numbered by their steps. The legs are pale, half way through each step and where it lands. A
    step that was refused is a cross where it was to land; below the picture it says why.

    Args:
        plan: the plan.
        ax: axes to draw on, without a title and without the costs then; new ones by default, those of the costs below.

    Returns:
        The axes of the terrain.

    Raises:
        InputError: where it is no plan.
    """
    as_instance(plan, "plan", Plan)
    joints = [gait.legs(plan.walk.model).joints(gait.frames) + at for gait, at in _placed(plan)]
    drawn = np.concatenate([step.reshape(-1, 2) for step in joints])
    left, right = float(drawn[:, 0].min()) - BESIDE, float(drawn[:, 0].max()) + BESIDE
    panels = _new_axes(2, left, right) if ax is None else (ax,)
    main = panels[0]
    _draw_terrain(main, plan.terrain, left, right, float(drawn[:, 1].max()) + 0.1)
    _draw_walk(main, plan, joints)
    _draw_footholds(main, plan)
    for panel in panels[1:]:
        _draw_costs(panel, plan)
    panels[-1].set_xlabel("x [m]")
    _tell_refused(main, panels[-1], plan)
    title = f"{title_of(f'Plan over {short_name(plan.terrain.name)}', plan.walk)}; cost {plan.cost:.4g} rad\u00b2"
    _finish(panels, title if ax is None else None)
    return main


def _new_axes(rows: int, left: float, right: float) -> tuple[Axes, ...]:
    """Axes of a new figure, one below the other, as wide as the ground is long."""
    # The height is fitted at the end.
    return new_axes(rows, 1, (min(max(0.9 + INCHES * (right - left), NARROWEST), WIDEST), 3.6))


# -- the terrain ------------------------------------------------------------------------------------------------------


def _draw_terrain(ax: Axes, terrain: Terrain, left: float, right: float, top: float) -> None:
    """The terrain from `left` to `right` in [m], and room up to `top`."""
    whole = terrain.whole
    line = whole.line(left, right)
    bottom = float(line[:, 1].min()) - DEPTH
    ax.fill_between(line[:, 0], line[:, 1], bottom, color=GROUND_COLOUR, lw=0.0, zorder=0.5, gid="ground")
    ax.plot(*line.T, color="k", lw=1.0, zorder=1.0, gid="ground")
    for gap in terrain.no_footholds:
        start, end = max(gap.x_start, left), min(gap.x_end, right)
        if start < end:
            surface = whole.line(start, end)
            outline = np.concatenate([surface, surface[::-1] - np.array([0.0, PIT_DEPTH])])
            look: dict[str, Any] = {"hatch": "////", "gid": "gap", "label": "gap"}
            if gap.unknown:
                look = {"ls": ":", "gid": "unseen", "label": "ground nobody saw"}
            ax.add_patch(Polygon(outline, facecolor="w", edgecolor="k", lw=0.8, zorder=1.5, **look))
    for box, height in zip(terrain.boxes, terrain.tops, strict=True):
        if box.x_end > left and box.x_start < right:
            draw_box(ax, box, float(terrain.height_at([box.x_start, box.x_end]).min()), height)
    _draw_bands(ax, terrain, left, right)
    ax.set_aspect("equal", anchor="N")
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    ax.set_ylabel("y [m]")


def _draw_bands(ax: Axes, terrain: Terrain, left: float, right: float) -> None:
    """Where edges and heights of the ground are in 95 of 100 cases, of those measured with an error."""
    bands: list[Array] = []
    for gap in terrain.pits:
        for x in (gap.x_start, gap.x_end) if gap.edge_std else ():
            y = float(terrain.height_at(x))
            bands.append(_upright(x, BAND * gap.edge_std, y - PIT_DEPTH, y))
    for before, surface, rise in zip(terrain.surfaces, terrain.surfaces[1:], terrain.rises, strict=False):
        if surface.edge_std:
            low, high = sorted((before.end_height, surface.height))
            spare = SEAM if abs(rise) <= SAME_PLACE else 0.0
            bands.append(_upright(surface.x_start, BAND * surface.edge_std, low - spare, high + spare))
    for surface in terrain.surfaces:
        if surface.height_std:
            over = BAND * surface.height_std
            ends = np.array([[surface.x_start, surface.height], [surface.x_end, surface.end_height]])
            aside = np.array([0.0, over])
            bands.append(np.concatenate([ends + aside, ends[::-1] - aside]))
    for outline in bands:
        if outline[:, 0].max() > left and outline[:, 0].min() < right:
            path = Path(np.concatenate([outline, outline[:1]]), closed=True)
            look: dict[str, Any] = {"facecolor": BAND_COLOUR, "edgecolor": BAND_COLOUR, "lw": 0.6, "ls": ":"}
            ax.add_patch(PathPatch(path, alpha=0.45, zorder=2.6, gid="band", label="95 % of edges and heights", **look))


def _upright(x: float, aside: float, low: float, high: float) -> Array:
    """Corners in [m] of a band around `x`, shape (4, 2)."""
    return np.array([[x - aside, low], [x + aside, low], [x + aside, high], [x - aside, high]])


# -- the plan ---------------------------------------------------------------------------------------------------------


def _placed(plan: Plan) -> list[tuple[Any, Array]]:
    """Each step's gait, and where its supporting ankle stands in the world frame in [m], shape (2,)."""
    first = np.array([plan.at, plan.terrain.ankle_at(plan.at, plan.walk.model.foot)])
    return list(zip(plan.walk.gaits, plan.walk.origins() + first, strict=True))


def _draw_walk(ax: Axes, plan: Plan, joints: list[Array]) -> None:
    """The legs of each step half way and at its end, pale, and the paths of both ankles, by joints in [m]."""
    foot = plan.walk.model.foot
    for number, step in enumerate(joints):
        support, swing = (LEG_COLOURS[leg] for leg in legs_of_step(plan.walk, number))
        for at in (0, len(step) // 2, len(step) - 1) if number == 0 else (len(step) // 2, len(step) - 1):
            for points, colour in ((step[at, :3], support), (step[at, 2:], swing)):
                ax.plot(*points.T, color=lighter(colour, PALE), lw=1.2, solid_capstyle="round", gid="leg", zorder=1.8)
        name = f"{legs_of_step(plan.walk, number)[1]} ankle"
        ax.plot(*step[:, 4].T, color=swing, lw=1.6, gid="ankle", label=name, zorder=3.0)
        if foot != Foot():
            for ankle, colour in ((step[0, 4], swing), (step[0, 0], support), (step[-1, 4], swing)):
                sole = foot_outline(foot, ankle, plan.terrain.slope_at(float(ankle[0])))
                ax.plot(*sole.T, color=lighter(colour, 2.0 * PALE), lw=1.2, gid="foot", zorder=1.9)


def _draw_footholds(ax: Axes, plan: Plan) -> None:
    """Footholds considered, where the feet stand at the start, and those chosen with the numbers of their steps."""
    ground = plan.terrain.height_at
    if plan.considered:
        at = np.array(plan.considered)
        look: dict[str, Any] = {"color": BASE_COLOUR, "marker": "|", "ms": 6, "mew": 0.7, "ls": "none"}
        ax.plot(at, ground(at), gid="considered", label="foothold considered", zorder=2.0, **look)
    support, swing = legs_of_step(plan.walk, 0)
    behind = float(plan.walk.model.endpoint(plan.walk.gaits[0].frames[0])[0]) + plan.at
    for x, leg in ((behind, swing), (plan.at, support)):
        look = {"color": LEG_COLOURS[leg], "mfc": "w", "marker": "o", "ms": 5, "ls": "none"}
        ax.plot(x, ground(x), gid="start", label="start", zorder=4.0, **look)
    for number, x in enumerate(plan.footholds):
        leg, y = legs_of_step(plan.walk, number)[1], float(ground(x))
        look = {"color": LEG_COLOURS[leg], "mec": "w", "marker": "o", "ms": 6, "ls": "none"}
        ax.plot(x, y, gid="chosen", label="foothold chosen", zorder=4.1, **look)
        words: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 8, "color": LEG_COLOURS[leg]}
        ax.text(x, y - ROWS[leg], str(number + 1), zorder=4.2, path_effects=[HALO], **words)


def _draw_costs(ax: Axes, plan: Plan) -> None:
    """What each step costs where it lands, and what was expected of it."""
    look: dict[str, Any] = {"color": "k", "marker": "_", "ms": 7, "mew": 1.2, "ls": "none"}
    for number, (x, cost, expected) in enumerate(zip(plan.footholds, plan.costs, plan.expected, strict=True)):
        leg = legs_of_step(plan.walk, number)[1]
        # Side by side: at the end of a walk both feet land at one place.
        middle = x + (BAR if leg == "right" else -BAR) / 2.0
        bar: dict[str, Any] = {"color": LEG_COLOURS[leg], "lw": 3.5, "solid_capstyle": "butt"}
        ax.plot([middle] * 2, [0.0, cost], gid="cost", **bar)
        ax.plot(middle, expected, gid="expected", label="cost expected", zorder=3.0, **look)
    finish_panels((ax,), "", "cost [rad\u00b2]")
    ax.set_ylim(0.0, None)


def _tell_refused(ax: Axes, lowest: Axes, plan: Plan) -> None:
    """A cross where each refused step was to land, its letter over it, and below the lowest panel what was wrong."""
    for ban in plan.banned:
        look: dict[str, Any] = {"color": "k", "marker": "x", "ms": 6, "mew": 1.4, "ls": "none"}
        ax.plot(ban.lands, plan.terrain.height_at(ban.lands), gid="refused", label="step refused", zorder=4.3, **look)
    told = list(zip(string.ascii_lowercase, plan.banned[:TOLD], strict=False))
    for group in _together(told):
        x = float(np.mean([ban.lands for _, ban in group]))
        y = max(float(plan.terrain.height_at(ban.lands)) for _, ban in group)
        words: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": "small", "weight": "bold"}
        at: dict[str, Any] = {"xytext": (0.0, 5.0), "textcoords": "offset points"}
        ax.annotate(", ".join(letter for letter, _ in group), (x, y), zorder=4.3, **at, **words)
    if not told:
        return
    lines = [f"{letter}: {ban}" for letter, ban in told]
    if len(plan.banned) > TOLD:
        lines.append(f"and {len(plan.banned) - TOLD} more steps refused")
    figure = ax.figure
    width = int(1.15 * LETTERS_PER_INCH * figure.bbox.width / figure.dpi)
    text = "\n".join(part for line in lines for part in textwrap.wrap(line, width, subsequent_indent="    "))
    at = {"parse_math": False, "xycoords": "axes fraction", "xytext": (0.0, -32.0), "textcoords": "offset points"}
    lowest.annotate(text, (0.0, 0.0), va="top", fontsize="small", **at)


def _together(told: list[tuple[str, Ban]]) -> list[list[tuple[str, Ban]]]:
    """Refused steps with their letters, those that were to land near each other together."""
    groups: list[list[tuple[str, Ban]]] = []
    for item in sorted(told, key=lambda item: item[1].lands):
        if groups and item[1].lands - groups[-1][0][1].lands < NEAR:
            groups[-1].append(item)
        else:
            groups.append([item])
    return [sorted(group, key=lambda item: item[0]) for group in groups]


def _finish(panels: tuple[Axes, ...], title: str | None) -> None:
    """A legend; and of a new figure its title, and a height at which the terrain is as wide as the costs below it."""
    if title is None:
        show_legend(panels)
        return
    name_figure(panels, title)
    show_legend(panels)
    figure, ax = panels[0].figure, panels[0]
    assert isinstance(figure, Figure)  # it was made for these axes
    shape = float(np.ptp(ax.get_ylim())) / float(np.ptp(ax.get_xlim()))
    place, below = ax.get_subplotspec(), [COSTS_INCHES] * (len(panels) - 1)
    assert place is not None  # as above
    for _ in range(3):
        figure.draw_without_rendering()
        width, height = figure.get_size_inches().tolist()
        rooms = [panel.get_position(original=True) for panel in panels]
        # A hundredth more, so that it is the width that the terrain fills.
        terrain = 1.01 * shape * width * rooms[0].width
        place.get_gridspec().set_height_ratios([terrain, *below])
        beside = height * (1.0 - sum(room.height for room in rooms))
        figure.set_figheight(terrain + sum(below) + beside)
