"""The whole chain in one run: a recorded walk in; other strides, obstacles, stairs and a whole course out, in files.

Run by `make demo`; see `--help`.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import click
from draw_walks import course_plan, save_plan
from matplotlib.figure import Figure

import ggo_factors as ggo
from ggo_factors import plot
from ggo_factors.cli.console import console, summary_table
from ggo_factors.evaluate.summary import StepSummary, refusal, summarize
from ggo_factors.plot.titles import title_of
from ggo_factors.support.files import replacing, write_text

DATASETS = Path(os.path.relpath(Path(__file__).parent.parent / "datasets"))

PAPER_OBSTACLES = {
    "obstacle 1": ggo.Obstacle(0.20, 0.25, 0.08),
    "obstacle 2": ggo.Obstacle(0.20, 0.25, 0.15),
    "obstacle 3": ggo.Obstacle(0.12, 0.16, 0.08),
    "obstacle 4": ggo.Obstacle(0.12, 0.16, 0.15),
    "obstacle 5": ggo.Obstacle(-0.33, -0.29, 0.175),
}
FOOTHOLD = (0.39, 0.0)


def _over(box: ggo.Obstacle) -> Callable[[ggo.Gait], ggo.Walk]:
    # The paper's legs are points, or obstacle 5 would stand in one at the start.
    return lambda base: ggo.walk(base, [ggo.Step(FOOTHOLD, (box,))], model=replace(base.legs(), bones="points"))


TASKS: dict[str, Callable[[ggo.Gait], ggo.Walk]] = {
    "stride 0.975 m": lambda base: ggo.adjust_stride(base, 0.975),
    "stride 0.585 m": lambda base: ggo.adjust_stride(base, 0.585),
    **{name: _over(box) for name, box in PAPER_OBSTACLES.items()},
    "stairs up 0.10 m": lambda base: ggo.climb_stairs(base, 0.10),
    "stairs down 0.10 m": lambda base: ggo.descend_stairs(base, 0.10),
}


@click.command()
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("out"), show_default=True, help="Folder to write to."
)
def main(out: Path) -> None:
    """Import the sample log, make every gait of the paper from its gait and from the paper's own, walk a course."""
    screen = console()
    began = time.perf_counter()
    out.mkdir(parents=True, exist_ok=True)
    report = ggo.import_base_gait(DATASETS / "children_walk.mcap", joints=DATASETS / "children_walk.toml")
    screen.rule("[bold]A recorded walk in")
    screen.print(report.text(), markup=False)
    write_text(out / "import.json", json.dumps(report.to_json(), indent=1) + "\n")
    _picture(
        out / "import.png", (9.0, 6.0), lambda figure: plot.plot_import(report, axes=figure.subplots(2, 2).ravel())
    )

    screen.rule("[bold]Gaits for other strides, obstacles and stairs out")
    rows: list[StepSummary] = []
    bases = {"imported": report.gait, "paper": ggo.paper_base_gait()}
    for source, base in bases.items():
        base.save(out / f"{source}_base.csv")
        lines = [
            line for task, make in TASKS.items() for line in _run(task, make, base, out / f"{source}_{_slug(task)}")
        ]
        title = f"\nfrom the {source} base gait, {base.stride():.3f} m stride, {len(base)} frames"
        screen.print(summary_table(lines, title))
        rows += lines

    screen.rule("[bold]A course planned and walked, from standing to standing")
    for source, base in bases.items():
        lines = _walk_course(base, out / f"{source}_course")
        good, seconds = sum(line.ok for line in lines), sum(line.duration_s or 0.0 for line in lines)
        screen.print(f"from the {source} base gait: {good} of {len(lines)} steps ok, {seconds:.1f} s of walking")
        rows += lines
    write_text(
        out / "demo.json", json.dumps({"format_version": 1, "steps": [r.to_json() for r in rows]}, indent=1) + "\n"
    )
    good = sum(row.ok for row in rows)
    screen.print(
        "\nfoot: distance of the landing from its foothold; clear: least height over the obstacle or the stair's edge;"
        "\nground: least height over the ground away from both footholds;"
        "\naxes: least distance of the legs' axes from boxes and stairs; lands: speed downwards at landing;"
        "\nknee: least knee angle;"
        "\nalpha, beta: mean change of each joint from the base gait (1 supporting, 2 swinging leg)."
        f"\n{good} of {len(rows)} steps ok; files and pictures in {out}/; {time.perf_counter() - began:.1f} s."
    )
    if good < len(rows):
        raise SystemExit(3)


def _run(task: str, make: Callable[[ggo.Gait], ggo.Walk], base: ggo.Gait, stem: Path) -> list[StepSummary]:
    began = time.perf_counter()
    try:
        walk = make(base)
    except ggo.InfeasibleGaitError as error:
        return [refusal(task, error, (time.perf_counter() - began) * 1e3)]
    each = (time.perf_counter() - began) * 1e3 / len(walk.steps)
    walk.save(stem.with_suffix(".csv"))
    ggo.export_mcap(walk, stem.with_suffix(".mcap"))
    _picture(stem.with_suffix(".png"), (11.0, 8.4), lambda figure: _draw(figure, walk, base))
    several = len(walk.steps) > 1
    return [
        summarize(f"{task}, step {n}" if several else task, s.gait, s.report, base, s, each)
        for n, s in enumerate(walk.steps, start=1)
    ]


def _walk_course(base: ggo.Gait, stem: Path) -> list[StepSummary]:
    """The sample course planned and walked: its steps in numbers, files and a picture."""
    began = time.perf_counter()
    try:
        plan = course_plan(base)
    except ggo.InfeasibleGaitError as error:
        return [refusal("course", error, (time.perf_counter() - began) * 1e3)]
    each = (time.perf_counter() - began) * 1e3 / len(plan.walk.steps)
    plan.walk.save(stem.with_suffix(".csv"))
    ggo.export_mcap(plan.walk, stem.with_suffix(".mcap"))
    save_plan(stem.with_suffix(".png"), plan, 110)
    return [
        summarize(f"course, step {n}", s.gait, s.report, base, s, each) for n, s in enumerate(plan.walk.steps, start=1)
    ]


def _draw(figure: Figure, walk: ggo.Walk, base: ggo.Gait) -> None:
    """Stick figure above; residual of every frame and the four joint angles below."""
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.6), height_ratios=(1.1, 1.0))
    plot.plot_stick_figure(walk, base=base, ax=figure.add_subfigure(grid[0, :]).subplots())
    residual = figure.add_subfigure(grid[1, 0]).subplots()
    angles = figure.add_subfigure(grid[1, 1]).subplots(2, 2).ravel()
    plot.plot_residual(walk, base, ax=residual)
    plot.plot_joint_angles(walk, base, axes=angles)
    figure.suptitle(title_of("", walk), fontsize="medium")


def _picture(path: Path, size: tuple[float, float], draw: Callable[[Figure], object]) -> None:
    figure = Figure(figsize=size, layout="constrained")
    draw(figure)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=110)


def _slug(task: str) -> str:
    return task.replace(" ", "_").replace(".", "")


if __name__ == "__main__":
    main()
