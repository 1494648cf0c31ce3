"""The figures of the paper, drawn from the gaits of `paper_gaits.py`; written by `reproduce_paper.py`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from paper_gaits import FOOTHOLD, LITERAL, OBSTACLES, ROBOT, SWITCHED_STRIDES, Made, Results

import ggo_factors as ggo
from ggo_factors import plot
from ggo_factors.support.files import replacing

COLOURS = {
    "verified": "#0072B2",
    "potential field": "#D55E00",
    "minimum jerk": "#009E73",
    "literal_span": "#CC79A7",
    "literal_paper": "#E69F00",
}
PERCENTS = (0, 20, 40, 60, 80, 100)


def draw_all(results: Results, out: Path, formats: Sequence[str], dpi: float) -> list[Path]:
    """Write every figure in every format; the paths written."""
    figures: dict[str, tuple[tuple[float, float], Callable[[Figure, Results], None]]] = {
        "exp_relu": ((4.6, 3.2), _exp_relu),
        "base_gait": ((6.4, 3.2), _base_gait),
        "strides": ((10.0, 7.6), _strides),
        "stride_trajectory": ((11.0, 4.8), _stride_trajectory),
        "stride_switch": ((9.0, 5.0), _stride_switch),
        "obstacle_gaits": ((9.0, 9.4), _obstacle_gaits),
        "obstacle_trajectory": ((11.0, 4.8), _obstacle_trajectory),
        "obstacle_paths": ((12.0, 4.0), _obstacle_paths),
        "stair_ascent": ((12.0, 4.4), lambda figure, r: _stairs(figure, r, "up")),
        "stair_descent": ((12.0, 4.4), lambda figure, r: _stairs(figure, r, "down")),
        "equivalent_stair": ((5.6, 3.2), _equivalent_stair),
        "collected_gait": ((9.0, 4.4), _collected_gait),
        "robot_path": ((6.0, 3.6), _robot_path),
        "robot_joints": ((8.0, 5.2), _robot_joints),
    }
    written = []
    for name, (size, draw) in figures.items():
        figure = Figure(figsize=size, layout="constrained")
        draw(figure, results)
        for suffix in formats:
            path = out / f"{name}.{suffix}"
            with replacing(path) as temporary, rc_context(plot.VECTOR_TEXT):
                figure.savefig(temporary, dpi=dpi)
            figure.set_layout_engine("none")  # placed once, for all formats
            written.append(path)
    return written


def _exp_relu(figure: Figure, _: Results) -> None:
    ax = figure.subplots()
    x = np.linspace(-2.0, 2.0, 401)
    ax.plot(x, np.exp(np.maximum(x, 0.0)), color=COLOURS["verified"], lw=2.0)
    ax.set_xlabel("x")
    ax.set_ylabel("exp(ReLU(x))")
    ax.set_ylim(0.0, None)
    ax.grid(True, color="#E4E4E4", lw=0.6)


def _base_gait(figure: Figure, results: Results) -> None:
    """Hip and knee over the time of the paper's formula, the swing red and the support blue as in the paper."""
    for ax, joint, title in zip(figure.subplots(1, 2), (0, 1), ("hip", "knee"), strict=True):
        for columns, begin, colour, label in (
            (2, 0.89, plot.SWING_COLOUR, "swing"),
            (0, 1.39, plot.SUPPORT_COLOUR, "support"),
        ):
            degrees = np.degrees(results.base.frames[:, columns + joint])
            ax.plot(begin + results.base.times, degrees, color=colour, lw=2.0, label=label)
        ax.set_title(title, fontsize="medium")
        ax.set_xlabel("t [s]")
        ax.set_ylabel("angle [deg]")
        ax.grid(True, color="#E4E4E4", lw=0.6)
        ax.legend(frameon=False)


def _strides(figure: Figure, results: Results) -> None:
    for ax, stride, letter in zip(figure.subplots(2, 1), (0.975, 0.585), "ab", strict=True):
        walk = ggo.adjust_stride(results.base, stride)
        plot.plot_stick_figure(walk, base=results.base, frames=6, ax=ax)
        ax.set_title(f"({letter}) stride {stride:g} m", loc="left", fontsize="medium")
    _one_legend(figure)


def _stride_trajectory(figure: Figure, results: Results) -> None:
    """(a) joint trajectories of both steps of both strides; (b) their residuals."""
    left, right = _halves(figure)
    angles, residual = left.subplots(2, 2, sharex=True).ravel(), right.subplots()
    for stride, colour in ((0.975, "#CC79A7"), (0.585, "#009E73")):
        for number, (made, style) in enumerate(zip(results.strides["verified", stride], ("-", ":"), strict=True), 1):
            label = f"{stride:g} m, step {number}"
            first = stride == 0.975 and number == 1
            plot.plot_joint_angles(made.gait, results.base if first else None, label=label, colour=colour, axes=angles)
            plot.plot_residual(made.gait, results.base, label=label, colour=colour, ax=residual)
            for ax in (*angles, residual):
                ax.lines[-1].set_linestyle(style)
    _legend_again(angles, 3)
    _legend(residual, 2)


def _stride_switch(figure: Figure, results: Results) -> None:
    panels = figure.subplots(2, 2, sharex=True).ravel()
    plot.plot_joint_trajectory(results.switched, axes=panels)
    ends = np.cumsum([gait.duration for gait in results.switched.gaits])
    for ax in panels:
        low, high = ax.get_ylim()
        for end, stride in zip(ends, SWITCHED_STRIDES, strict=True):
            ax.text(end - 0.25, high, f"{stride:g} m", ha="center", va="bottom", fontsize="x-small")
        ax.set_ylim(low, high)
        ax.set_title(ax.get_title(), fontsize="medium", pad=14)
    figure.suptitle(f"Walk of {len(SWITCHED_STRIDES)} steps whose stride changes", fontsize="medium")


def _obstacle_gaits(figure: Figure, results: Results) -> None:
    names = ("verified", "potential field", "minimum jerk", "literal_paper")
    titles = ("GGO (verified)", "artificial potential field", "minimum jerk", "GGO to the letter (literal_paper)")
    for ax, name, title in zip(figure.subplots(2, 2).ravel(), names, titles, strict=True):
        gait = results.obstacles[name][0].gait
        plot.plot_stick_figure(gait, obstacles=OBSTACLES[:1], foothold=FOOTHOLD, base=results.base, frames=9, ax=ax)
        ax.set_title(title, loc="left", fontsize="medium")
    _one_legend(figure)


def _obstacle_trajectory(figure: Figure, results: Results) -> None:
    left, right = _halves(figure)
    angles, residual = left.subplots(2, 2, sharex=True).ravel(), right.subplots()
    for name in ("verified", "potential field", "minimum jerk"):
        gait, base = results.obstacles[name][0].gait, results.base
        first = name == "verified"
        plot.plot_joint_angles(gait, base if first else None, label=name, colour=COLOURS[name], axes=angles)
        plot.plot_residual(gait, base, label=name, colour=COLOURS[name], ax=residual)
    _legend_again(angles, 4)
    _legend(residual, 3)


def _obstacle_paths(figure: Figure, results: Results) -> None:
    """The path of the swing ankle over each obstacle, by every row."""
    panels = figure.subplots(2, 3).ravel()
    for number, (ax, box) in enumerate(zip(panels, OBSTACLES, strict=False)):
        ax.add_patch(_box(box))
        ax.plot(*results.base.endpoints().T, color=plot.BASE_COLOUR, ls="--", lw=1.0)
        for name, colour in COLOURS.items():
            path = results.obstacles[name][number].gait.endpoints()
            ax.plot(*path.T, color=colour, lw=1.6, ls=":" if name.startswith("literal") else "-")
        ax.set_title(f"obstacle {number + 1}", fontsize="medium")
        ax.set_xlabel("x [m]")
        ax.set_ylabel("y [m]")
        ax.set_aspect("equal")
        ax.grid(True, color="#E4E4E4", lw=0.6)
    handles = [Line2D([], [], color=plot.BASE_COLOUR, ls="--", lw=1.0, label="base gait")]
    for name, colour in COLOURS.items():
        style = ":" if name.startswith("literal") else "-"
        sampled = next((f", {v.frames} frames" for v in LITERAL if v.name == name), "")
        handles.append(Line2D([], [], color=colour, lw=1.6, ls=style, label=name + sampled))
    panels[5].axis("off")
    panels[5].legend(handles=handles, loc="center", frameon=False, title="swing ankle")


def _stairs(figure: Figure, results: Results, way: str) -> None:
    """A row for each step, a panel for each t = n %."""
    rows = figure.subplots(2, len(PERCENTS), sharex="row", sharey="row")
    for number, (row, made) in enumerate(zip(rows, results.stairs["verified", way], strict=True)):
        step = results.stair_plan[way][number]
        low = made.gait.legs().joints(made.gait.frames)[..., 1].min()
        row[0].set_xlim(-0.5, 0.55)
        row[0].set_ylim(min(low, *step.ground.heights) - 0.06, 0.86)
        for ax, percent in zip(row, PERCENTS, strict=True):
            legs = ("left", "right") if number % 2 == 0 else ("right", "left")
            _snapshot(ax, made, step, percent, [plot.LEG_COLOURS[leg] for leg in legs])
            ax.label_outer()
        row[0].set_ylabel(f"step {number + 1}\ny [m]")


def _snapshot(ax: Axes, made: Made, step: ggo.Step, percent: int, colours: Sequence[str]) -> None:
    """Both legs on the stair at one time, in their colours, with the whole path of the swing ankle."""
    legs, gait = made.gait.legs(), made.gait
    joints = legs.joints(gait.frames[round(percent / 100.0 * (len(gait) - 1))])
    x, y = step.ground.line(-0.5, 0.55).T
    ax.fill_between(x, y, -1.0, color=plot.GROUND_COLOUR, lw=0.0)
    ax.plot(x, y, color="k", lw=1.0)
    ax.plot(*gait.endpoints().T, color=plot.PATH_COLOUR, lw=1.2)
    for colour, points in zip(colours, (joints[:3], joints[2:]), strict=True):
        ax.plot(*points.T, color=colour, lw=2.2, marker="o", ms=3.5)
    if step.foothold is not None:
        ax.plot(*step.foothold, "kx", ms=7)
    ax.set_aspect("equal")
    ax.set_xlabel("x [m]")
    ax.set_title(f"t = {percent} %", fontsize="medium")


def _equivalent_stair(figure: Figure, results: Results) -> None:
    ax = figure.subplots()
    ground, foot = results.robot.plan[0].ground, ROBOT.foot
    edge, rise, up = ground.edges[0], ground.heights[1], foot.ankle_height
    x = np.array([-0.2, edge, edge, 0.5])
    ax.fill_between(x, [0.0, 0.0, rise, rise], -0.03, color=plot.GROUND_COLOUR)
    ax.plot(x, [0.0, 0.0, rise, rise], "k", lw=1.2, label="stair")
    near = np.array([-0.2, edge - foot.toe, edge - foot.toe, 0.5])
    ax.plot(
        near, [up, up, rise + up, rise + up], color=COLOURS["potential field"], ls="--", label="equivalent stair of P"
    )
    for ankle_x, ground_y, colour, label in (
        (0.0, 0.0, plot.SUPPORT_COLOUR, "supporting foot"),
        (results.robot.plan[0].landing(ROBOT)[0], rise, plot.SWING_COLOUR, "swinging foot, landed"),
    ):
        ax.plot([ankle_x - foot.heel, ankle_x + foot.toe], [ground_y, ground_y], color=colour, lw=5, label=label)
        ax.plot([ankle_x, ankle_x], [ground_y, ground_y + up], color=colour, lw=2, marker="o", ms=5, markevery=[1])
    ax.annotate("", (edge - foot.toe, 0.2), (edge, 0.2), arrowprops={"arrowstyle": "<->"})
    ax.text(edge - foot.toe / 2.0, 0.205, "$L_f$", ha="center")
    ax.annotate("", (0.42, rise), (0.42, rise + up), arrowprops={"arrowstyle": "<->"})
    ax.text(0.43, rise + up / 2.0, "$L_a$", va="center")
    ax.set_ylim(-0.03, 0.24)
    ax.set_xlim(-0.15, 0.5)
    ax.set_aspect("equal")
    ax.set_xlabel("x from the supporting ankle [m]")
    ax.set_ylabel("height above the ground [m]")
    _legend(ax, 2)


def _collected_gait(figure: Figure, results: Results) -> None:
    for ax, number, letter in zip(figure.subplots(1, 2), (0, 1), "ab", strict=True):
        # A walk of this step alone, so that each leg keeps its colour.
        gait, step = results.collected.gaits[number], results.collected.plan[number]
        step = replace(step, foothold=step.landing(ROBOT))
        one = ggo.Walk((gait,), (step,), first_swing=("right", "left")[number])
        plot.plot_stick_figure(one, model=ROBOT, frames=7, ax=ax)
        ax.set_title(f"({letter}) step {number + 1}", loc="left", fontsize="medium")
    _one_legend(figure, "stand-in for the collected gait, 0.12 m riser: no reproduction")


def _robot_path(figure: Figure, results: Results) -> None:
    ax = figure.subplots()
    for walk, colour, label in (
        (results.collected, plot.BASE_COLOUR, "stand-in for the collected gait"),
        (results.robot, COLOURS["verified"], "generated gait"),
    ):
        for number, (gait, origin) in enumerate(zip(walk.gaits, walk.origins(), strict=True)):
            path = gait.endpoints(ROBOT) + origin
            name = f"{label}, step {number + 1}"
            ax.plot(*path.T, color=colour, lw=1.8, ls="-" if number == 0 else "--", label=name)
    ax.set_xlabel("x from the first supporting ankle [m]")
    ax.set_ylabel("y [m]")
    ax.set_aspect("equal")
    ax.grid(True, color="#E4E4E4", lw=0.6)
    _legend(ax, 2)


def _robot_joints(figure: Figure, results: Results) -> None:
    panels = figure.subplots(2, 2, sharex=True).ravel()
    plot.plot_joint_trajectory(results.collected, label="stand-in for the collected gait", axes=panels)
    for ax in panels:
        ax.lines[0].set(color=plot.BASE_COLOUR, linestyle="--", linewidth=1.4)
    plot.plot_joint_trajectory(results.robot, label="generated gait", axes=panels)


# -- small things -----------------------------------------------------------------------------------------------


def _halves(figure: Figure) -> tuple[SubFigure, SubFigure]:
    grid = figure.add_gridspec(1, 2, width_ratios=(1.5, 1.0))
    return figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])


def _box(box: ggo.Obstacle) -> Rectangle:
    width = box.x_end - box.x_start
    return Rectangle((box.x_start, 0.0), width, box.height, facecolor=plot.OBSTACLE_COLOUR, edgecolor="k", lw=0.8)


def _legend(ax: Axes, columns: int) -> None:
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns, frameon=False, fontsize="small")


def _legend_again(panels: Sequence[Axes], columns: int) -> None:
    """The legend over a subfigure once more, with the line styles as they are now."""
    handles, labels = panels[0].get_legend_handles_labels()
    parent = panels[0].get_figure()
    assert parent is not None  # panels are in a figure
    for old in list(parent.legends):
        old.remove()
    unique = dict(zip(labels, handles, strict=True))
    parent.legend(
        handles=list(unique.values()),
        labels=list(unique),
        loc="outside upper center",
        ncols=columns,
        frameon=False,
        fontsize="small",
    )


def _one_legend(figure: Figure, title: str | None = None) -> None:
    """One legend for all panels, in place of each panel's own."""
    named: dict[str, Artist] = {}
    for ax in figure.axes:
        legend = ax.get_legend()
        if legend is not None:
            for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
                if handle is not None:
                    named[text.get_text()] = handle
            legend.remove()
    columns = 6 if len(named) <= 6 else 4
    figure.legend(
        list(named.values()), list(named), loc="outside upper center", ncols=columns, frameon=False, title=title
    )
