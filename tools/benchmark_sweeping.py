"""The benchmark of many gaits: what a second worker is worth."""

from __future__ import annotations

import json
import os
import statistics
import time
from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
from machine import stated
from rich.table import Table

import ggo_factors as ggo
from ggo_factors.console import console
from ggo_factors.files import write_text

GOAL = 1.7
FOOTHOLD = (0.39, 0.0)


@click.command()
@click.option("--gaits", type=click.IntRange(1), default=1000, show_default=True)
@click.option("--workers", type=click.IntRange(2), default=2, show_default=True, help="Compared with one.")
@click.option("--repeats", type=click.IntRange(1), default=3, show_default=True, help="Interleaved.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def sweeping(gaits: int, workers: int, repeats: int, json_path: Path | None) -> None:
    """Step over many seeded obstacles with one worker and with more; start-up of the workers included."""
    machine, base, tasks = stated(), ggo.paper_base_gait(), _tasks(gaits)
    times: dict[int, list[tuple[float, float]]] = {1: [], workers: []}
    made: dict[int, list[bool]] = {}
    for _ in range(repeats):
        for count, each in times.items():
            begin, cpu = time.perf_counter(), _cpu_seconds()
            made[count] = [row.ok for row in ggo.generate_many(tasks, base, workers=count)]
            each.append((time.perf_counter() - begin, _cpu_seconds() - cpu))
    medians = {
        count: (statistics.median(wall for wall, _ in each), statistics.median(cpu for _, cpu in each))
        for count, each in times.items()
    }
    faster = medians[1][0] / medians[workers][0]
    undisturbed = workers * medians[1][1] / medians[workers][1]
    table = Table(title=f"{gaits} obstacles", title_justify="left")
    for heading in ("workers", "s", "CPU s", "gaits/s", "gaits made"):
        table.add_column(heading, justify="right")
    for count, (wall, cpu) in medians.items():
        table.add_row(str(count), f"{wall:.2f}", f"{cpu:.2f}", f"{gaits / wall:.0f}", str(sum(made[count])))
    console().print(table)
    lines = [
        f"{workers} workers are {faster:.2f} times as fast as one (goal {GOAL:g}, for 2)",
        f"by CPU time {undisturbed:.2f} times, had each of them a processor to itself",
        *(f"{key}: {value}" for key, value in machine.items()),
    ]
    for line in lines:
        console().print(line, markup=False)
    if json_path:
        rows = [{"workers": count, "median_s": wall, "cpu_s": cpu} for count, (wall, cpu) in medians.items()]
        ratios = {"ratio": faster, "cpu_ratio": undisturbed, "goal": GOAL, "met": faster >= GOAL}
        content = {"format_version": 1, "machine": machine, "gaits": gaits, "rows": rows, **ratios}
        write_text(json_path, json.dumps(content, indent=1) + "\n")


def _tasks(count: int) -> Sequence[ggo.Task]:
    """Boxes of all sizes that a step may meet, some too high to clear."""
    random = np.random.default_rng(1)
    places, widths, heights = random.uniform((-0.25, 0.02, 0.05), (0.22, 0.08, 0.18), (count, 3)).T
    return [
        ggo.Task("step_over", {"obstacles": (ggo.Obstacle(x, x + wide, high),), "foothold": FOOTHOLD})
        for x, wide, high in zip(places.tolist(), widths.tolist(), heights.tolist(), strict=True)
    ]


def _cpu_seconds() -> float:
    """CPU time of this process and of its workers that have ended, as all have when a sweep is done."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system
