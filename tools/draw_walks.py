"""The pictures of the README: `docs/course.png`, `docs/walk.png` and `docs/landing.png`."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np
from matplotlib.figure import Figure

import ggo_factors as ggo
from ggo_factors import plot
from ggo_factors.cli.console import console
from ggo_factors.plot import BASE_COLOUR
from ggo_factors.plot.titles import title_of
from ggo_factors.support.files import replacing
from ggo_factors.support.inputs import Array

FOOTHOLD = (0.39, 0.0)
WALK_BOXES = (None, ggo.Obstacle(0.16, 0.21, 0.10), ggo.Obstacle(0.17, 0.22, 0.08))
HIGH_BOX = ggo.Obstacle(0.20, 0.25, 0.15)
STEPS = 8
COURSE_GOAL = 6.6
COLOURS = {"without landing edges": "#CC79A7", "with landing edges": "#009E73"}


def course_plan(base: ggo.Gait) -> ggo.Plan:
    """A plan over the sample course, from standing to standing."""
    course = ggo.load_terrain(ggo.datasets.course())
    return ggo.plan_walk(base, course, goal=COURSE_GOAL, start=ggo.STANDING, to_standing=True)


def two_boxes(base: ggo.Gait) -> ggo.Walk:
    """A level step, and two over boxes."""
    return ggo.walk(base, [ggo.Step(FOOTHOLD, () if box is None else (box,)) for box in WALK_BOXES])


def over_one_box(base: ggo.Gait, box: bool = True, landing: bool = True) -> ggo.Walk:
    """Eight level steps, the first over a high box."""
    first = ggo.Step(FOOTHOLD, (HIGH_BOX,) if box else ())
    return ggo.walk(base, [first, *[ggo.Step(FOOTHOLD)] * (STEPS - 1)], landing=landing)


def supporting_knee(walk: ggo.Walk) -> Array:
    """Of each step at its last frame, where the other foot lands, in [deg]."""
    return np.degrees([gait.frames[-1, 1] for gait in walk.gaits])


def hip(walk: ggo.Walk) -> tuple[Array, Array]:
    """Time in steps, and the hip's height over the supporting ankle in [m], of every frame."""
    times = [np.linspace(k, k + 1, len(gait)) for k, gait in enumerate(walk.gaits)]
    return np.concatenate(times), np.concatenate([gait.legs().hip_height(gait.frames) for gait in walk.gaits])


def save_plan(path: Path, plan: ggo.Plan, dpi: float) -> None:
    """A picture of a plan as PNG, whole or not at all."""
    figure = plot.plot_plan(plan).figure
    assert isinstance(figure, Figure)  # new axes are in no other
    with replacing(path) as part:
        figure.savefig(part, format="png", dpi=dpi)


def draw_walk(figure: Figure, walk: ggo.Walk, base: ggo.Gait) -> None:
    """The stick figures of a walk."""
    plot.plot_stick_figure(walk, base=base, ax=figure.subplots())
    figure.suptitle(title_of("", walk), fontsize="medium")


def draw_landing(figure: Figure, walks: dict[str, ggo.Walk], level: ggo.Walk) -> None:
    """The walk without and with landing edges: stick figures, the supporting knee at each landing, the hip's height."""
    grid = figure.add_gridspec(3, 2, height_ratios=(1.25, 1.25, 1.0))
    for row, (name, walk) in enumerate(walks.items()):
        ax = figure.add_subplot(grid[row, :])
        last = len(walk.gaits[0]) - 1
        plot.plot_stick_figure(walk, frames=(last // 2, last), ax=ax)
        legend = ax.get_legend()
        if legend is not None:
            legend.remove()
            if row == 0:
                named = ax.get_legend_handles_labels()
                entries = dict(zip(named[1], named[0], strict=True))
                figure.legend(entries.values(), entries, loc="outside lower center", ncols=7, frameon=False)
        ax.set(xlim=(-0.5, STEPS * FOOTHOLD[0] + 0.15))
        ax.set_title(f"{name}: each step half way (pale) and where it lands", loc="left", fontsize=10)
    knees, hips = (figure.add_subplot(grid[2, column]) for column in (0, 1))
    everyone = {"no box": (level, BASE_COLOUR, "--"), **{n: (w, COLOURS[n], "-") for n, w in walks.items()}}
    for name, (walk, colour, style) in everyone.items():
        knees.plot(np.arange(1, STEPS + 1), supporting_knee(walk), style, marker="o", ms=4, color=colour, label=name)
        hips.plot(*hip(walk), style, color=colour, lw=1.2)
    knees.set(xlabel="step", ylabel="angle [deg]", ylim=(0.0, None))
    knees.set_title("supporting knee at landing", loc="left", fontsize=10)
    hips.set(xlabel="step", ylabel="height [m]")
    hips.set_title("hip over the supporting ankle", loc="left", fontsize=10)
    for ax in (knees, hips):
        ax.grid(True, color="#E4E4E4", lw=0.6)
    figure.suptitle(f"Walks of {STEPS} steps, the first over a box of {1e3 * HIGH_BOX.height:.0f} mm")
    knees.legend(fontsize=8, frameon=False)


@click.command()
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("docs"), show_default=True, help="Folder to write to."
)
def main(out: Path) -> None:
    """Draw a plan over a course, course.png; a walk over two boxes, walk.png; one that comes home, landing.png."""
    base = ggo.paper_base_gait()
    walks = {name: over_one_box(base, landing=name.startswith("with ")) for name in COLOURS}
    level = over_one_box(base, box=False)
    out.mkdir(parents=True, exist_ok=True)
    save_plan(out / "course.png", course_plan(base), 130)
    pictures = {"walk.png": ((8.6, 6.6), 160), "landing.png": ((11.0, 10.2), 110)}
    for file, (size, dpi) in pictures.items():
        figure = Figure(figsize=size, layout="constrained")
        if file == "walk.png":
            draw_walk(figure, two_boxes(base), base)
        else:
            draw_landing(figure, walks, level)
        with replacing(out / file) as part:
            figure.savefig(part, format="png", dpi=dpi)
    for name, walk in {"no box": level, **walks}.items():
        knees = ", ".join(f"{knee:.1f}" for knee in supporting_knee(walk))
        console().print(f"supporting knee at landing [deg], {name}: {knees}", markup=False)


if __name__ == "__main__":
    main()
