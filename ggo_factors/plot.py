"""Pictures of gaits, as in the paper: stick figures, joint angles, residuals, the trajectory of both legs.

Every function draws on the axes it is given, or on new ones, and returns them; none shows or saves a figure.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from ggo_factors.arrays import Array
from ggo_factors.errors import InputError
from ggo_factors.gait import Gait
from ggo_factors.model import LegModel
from ggo_factors.solve import Solution
from ggo_factors.terrain import Gap, Ground, Obstacle
from ggo_factors.walk import JointTrajectory, Walk

if TYPE_CHECKING:
    from ggo_factors.recording.report import ImportReport

# Okabe and Ito's colours, which the colour-blind tell apart.
SUPPORT_COLOUR, SWING_COLOUR, PATH_COLOUR = "#0072B2", "#D55E00", "#009E73"
LEG_COLOURS = {"right": SWING_COLOUR, "left": SUPPORT_COLOUR}
BASE_COLOUR, GROUND_COLOUR, OBSTACLE_COLOUR = "#555555", "#DDD8CF", "#8C6D31"

ANGLE_NAMES = (r"$\alpha_1$", r"$\beta_1$", r"$\alpha_2$", r"$\beta_2$")
ANGLE_COLOURS = (SUPPORT_COLOUR, "#56B4E9", SWING_COLOUR, "#E69F00")
ANGLE_TITLES = ("support thigh", "support knee", "swing thigh", "swing knee")
JOINT_TITLES = {
    "right_hip": "right hip",
    "right_knee": "right knee",
    "left_hip": "left hip",
    "left_knee": "left knee",
}


def plot_stick_figure(
    walk: Walk | Solution | Gait,
    *,
    model: LegModel | None = None,
    obstacles: Sequence[Obstacle] = (),
    gaps: Sequence[Gap] = (),
    ground: Ground | None = None,
    foothold: tuple[float, float] | None = None,
    frames: int | Sequence[int] = 7,
    base: Gait | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The legs at some frames, light at first and darker later, on their ground, with the path of P.

    A walk is drawn in the body frame of its first step, with the ground and the obstacles of its own plan.

    Args:
        walk: a walk, the solution of one step, or the gait of one step.
        model: the legs; by default the gait's own.
        obstacles: boxes in the body frame of a single step; a walk has its own.
        gaps: pits in the body frame of a single step; a walk has its own.
        ground: ground of a single step, level by default; a walk has its own.
        foothold: where P was to land in a single step in [m], shape (2,); a walk has its own.
        frames: how many figures to draw of each step, evenly spaced, or which frames.
        base: base gait whose path of P is drawn dashed, in each step.
        ax: axes to draw on; new ones by default.

    Raises:
        InputError: where no leg lengths are known, a frame is not there, or ground is given with a walk.
    """
    single = not isinstance(walk, Walk)
    if not single and (obstacles or gaps or ground is not None or foothold is not None):
        raise InputError("obstacles, gaps, ground, foothold: a walk has its own; give them with a single step only")
    gaits = _gaits(walk)
    legs = gaits[0].legs(model)
    origins = np.concatenate([np.zeros((1, 2)), np.cumsum([gait.endpoints(legs)[-1] for gait in gaits], axis=0)])
    pictured = [_chosen(frames, gait) for gait in gaits]
    new = ax is None
    ax = new_axes(1, 1, (6.4, 3.6))[0] if ax is None else ax
    has_pit = has_box = False
    grounds: list[tuple[Ground, float, float]] = []
    for number, (gait, chosen) in enumerate(zip(gaits, pictured, strict=True)):
        x, y = origins[number].tolist()
        step = walk.plan[number] if isinstance(walk, Walk) else None
        boxes, pits = (step.obstacles, step.gaps) if step else (obstacles, gaps)
        below = step.ground if step else ground or Ground()
        target = step.foothold if step else foothold
        grounds.append((below, x, y))
        for shade, frame in zip(np.linspace(0.3, 1.0, len(chosen)), chosen, strict=True):
            if number and frame == 0:
                continue  # The swap frame: the step before has drawn it.
            joints = legs.joints(gait.frames[frame]) + origins[number]
            for colour, points in ((SUPPORT_COLOUR, joints[:3]), (SWING_COLOUR, joints[2:])):
                ax.plot(*points.T, color=_lighter(colour, shade), lw=1.8, marker="o", ms=2.5, solid_capstyle="round")
        if base is not None:
            ax.plot(*(base.endpoints(legs) + origins[number]).T, color=BASE_COLOUR, ls="--", lw=1.2, gid="base path")
        ax.plot(*(gait.endpoints(legs) + origins[number]).T, color=PATH_COLOUR, lw=2.0, gid="path of P", zorder=3)
        if target is not None:
            ax.plot(x + target[0], y + target[1], "kx", ms=7, mew=1.5, ls="none", gid="foothold", zorder=4)
        for pit in pits:
            has_pit = True
            ax.add_patch(_pit(pit, x, y))
        for box in boxes:
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
        Line2D([], [], color=PATH_COLOUR, lw=2.0, label="path of P"),
    ]
    if base is not None:
        handles.append(Line2D([], [], color=BASE_COLOUR, ls="--", lw=1.2, label="path of P, base gait"))
    if any(line.get_gid() == "foothold" for line in ax.lines):
        handles.append(Line2D([], [], color="k", marker="x", ms=7, mew=1.5, ls="none", label="foothold"))
    if has_box:
        handles.append(Patch(facecolor=OBSTACLE_COLOUR, edgecolor="k", label="obstacle"))
    if has_pit:
        handles.append(Patch(facecolor="w", edgecolor="k", hatch="////", label="gap"))
    _legend_above(ax, handles, 3 if len(handles) != 4 else 2)
    return ax


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
    (gait,) = _gaits(gait)
    panels = _panels(axes)
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
    (gait,) = _gaits(gait)
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
    panels = _panels(axes)
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


def plot_import(report: ImportReport, *, axes: Axes | Sequence[Axes] | None = None) -> tuple[Axes, ...]:
    """What a base gait was made of: every stride thin, their mean thick, one standard deviation shaded.

    Level strides in a panel for each joint and leg, from heel strike to heel strike; stair swings in a panel for each
    angle, both legs in it. Strides that were refused are dotted.

    Args:
        report: what the import found.
        axes: four axes to draw on; a new figure by default.

    Raises:
        InputError: where `axes` are not four.
    """
    panels = _panels(axes)
    if len(panels) != 4:
        raise InputError(f"axes: expected four, got {len(panels)}")
    level = report.activity == "level"
    legs = [leg for leg in LEG_COLOURS if leg in report.mean_cycle]
    shown = [(leg,) for leg in LEG_COLOURS for _ in range(2)] if level else [tuple(legs)] * 4
    if level:
        titles = [f"{leg} {joint}" for leg in LEG_COLOURS for joint in ("thigh", "knee")]
    else:
        titles = [f"{title} {name}" for title, name in zip(ANGLE_TITLES, ANGLE_NAMES, strict=True)]
    for number, ax in enumerate(panels):
        column = number % 2 if level else number
        for leg in shown[number]:
            colour = LEG_COLOURS[leg]
            for item in (*report.refused, *report.used):
                curves = getattr(item, "angles", None) if level else getattr(item, "frames", None)
                if item.leg != leg or curves is None:
                    continue
                style = {"color": BASE_COLOUR, "ls": ":"} if item.reason else {"color": _lighter(colour, 0.45)}
                percent = np.linspace(0.0, 100.0, len(curves))
                ax.plot(
                    percent, np.degrees(curves[:, column]), lw=0.6, gid="refused" if item.reason else "stride", **style
                )
            if leg in report.mean_cycle:
                mean, spread = (_closed(row[leg][:, column], level) for row in (report.mean_cycle, report.spread))
                percent = np.linspace(0.0, 100.0, len(mean))
                low, high = np.degrees(mean - spread), np.degrees(mean + spread)
                ax.fill_between(percent, low, high, color=colour, alpha=0.3, lw=0.0, zorder=2.5)
                ax.plot(percent, np.degrees(mean), color=colour, lw=2.2, zorder=3, gid="mean")
        ax.set_title(titles[number], fontsize="medium")
        ax.set_xlim(0.0, 100.0)
    finish_panels(panels, "stride [%]" if level else "step [%]", "angle [deg]")
    counts = report.strides_used
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=LEG_COLOURS[leg], lw=2.2, label=f"{leg} mean, {counts[leg]} used") for leg in legs
    ]
    handles.append(Patch(facecolor="0.8", label="\u00b1 1 standard deviation"))
    if report.refused:
        handles.append(Line2D([], [], color=BASE_COLOUR, ls=":", lw=1.0, label=f"{len(report.refused)} refused"))
    legend_above_figure(panels, handles)
    return panels


def _closed(values: Array, cyclic: bool) -> Array:
    """A curve over a whole cycle, which stops short of its end, with its first value once more."""
    return np.append(values, values[0]) if cyclic else values


def _gaits(walk: Walk | Solution | Gait) -> tuple[Gait, ...]:
    if isinstance(walk, Walk):
        return walk.gaits
    if isinstance(walk, Solution):
        return (walk.gait,)
    if isinstance(walk, Gait):
        return (walk,)
    raise InputError(f"gait: expected a Gait, a Solution or a Walk, got {walk!r:.80}")


def _chosen(frames: int | Sequence[int], gait: Gait) -> list[int]:
    """Numbers of the frames to draw of a gait."""
    if isinstance(frames, int):
        if frames < 1:
            raise InputError(f"frames: {frames} must be at least 1")
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


def _lighter(colour: str, shade: float) -> tuple[float, float, float]:
    """A colour mixed with white, not made see-through: overlapping lines would show through one another."""
    rgb = np.array(matplotlib.colors.to_rgb(colour))
    red, green, blue = (1.0 - shade * (1.0 - rgb)).tolist()
    return (red, green, blue)


def _percent(gait: Gait) -> Array:
    return np.linspace(0.0, 100.0, len(gait))


def new_axes(rows: int, columns: int, size: tuple[float, float]) -> tuple[Axes, ...]:
    """The axes of a new figure of a size in inches, row by row."""
    # Only pyplot gives a figure that a notebook or a window will show.
    from matplotlib import pyplot

    _, axes = pyplot.subplots(rows, columns, figsize=size, layout="constrained", sharex=True, squeeze=False)
    return tuple(axes.flat)


def _panels(axes: Axes | Sequence[Axes] | None) -> tuple[Axes, ...]:
    if axes is None:
        return new_axes(2, 2, (7.2, 4.8))
    panels = (axes,) if isinstance(axes, Axes) else tuple(np.ravel(np.asarray(axes, dtype=object)))
    if len(panels) not in (1, 4):
        raise InputError(f"axes: expected one or four, got {len(panels)}")
    return panels


def finish_panels(panels: Sequence[Axes], x_label: str, y_label: str) -> None:
    """Grid and labels; in a grid of panels only where they are the outermost."""
    for ax in panels:
        ax.grid(True, color="#E4E4E4", lw=0.6)
        ax.set_axisbelow(True)
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        place = ax.get_subplotspec()
        if len(panels) > 1 and place is not None:
            ax.xaxis.label.set_visible(place.is_last_row())
            ax.yaxis.label.set_visible(place.is_first_col())


def _legend_above(ax: Axes, handles: Sequence[Any], columns: int) -> None:
    """A legend over the axes, where no data can be."""
    ax.legend(
        handles=list(handles),
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=columns,
        frameon=False,
        fontsize="small",
    )


def legend_above_all(panels: Sequence[Axes]) -> None:
    """The legend of one axes over it, or of four over their figure."""
    handles, labels = panels[0].get_legend_handles_labels()
    if not handles:
        return
    if len(panels) == 1:
        _legend_above(panels[0], handles, min(len(handles), 4))
        return
    unique = dict(zip(labels, handles, strict=True))
    legend_above_figure(panels, list(unique.values()))


def legend_above_figure(panels: Sequence[Axes], handles: Sequence[Any]) -> None:
    """A legend over the figure of the axes, in place of the one that was there."""
    figure = panels[0].get_figure()
    assert figure is not None  # axes that can be drawn on are in a figure
    for old in list(figure.legends):
        old.remove()
    figure.legend(handles=list(handles), loc="outside upper center", ncols=4, frameon=False, fontsize="small")
