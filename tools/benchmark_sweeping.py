"""The benchmark of many gaits: what a second worker is worth."""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import click
import numpy as np
from machine import stated
from rich.table import Table

import ggo_factors as ggo
from ggo_factors.cli.console import console
from ggo_factors.support.files import write_text

GOAL = 1.7
FOOTHOLD = (0.39, 0.0)


@click.command()
@click.option("--gaits", type=click.IntRange(1), default=1000, show_default=True)
@click.option("--workers", type=click.IntRange(2), default=2, show_default=True, help="Compared with one.")
@click.option("--repeats", type=click.IntRange(1), default=3, show_default=True, help="Interleaved.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def sweeping(gaits: int, workers: int, repeats: int, json_path: Path | None) -> None:
    """Step over many seeded obstacles with one worker and with more, in turn."""
    machine, base, tasks = stated(), ggo.paper_base_gait(), _tasks(gaits)
    rows = {count: _Timed(count) for count in (1, workers)}
    for _ in range(repeats):
        for row in rows.values():
            row.make(tasks, base)
    one, more = rows[1], rows[workers]
    faster, alone, cold = one.median_s / more.median_s, more.gait_ms / one.gait_ms, more.wall_s[0]
    table = Table(title=f"{gaits} obstacles", title_justify="left")
    for heading in ("workers", "s", "gaits/s", "ms a gait in its worker", "gaits made"):
        table.add_column(heading, justify="right")
    for row in rows.values():
        speed = gaits / row.median_s
        table.add_row(str(row.workers), f"{row.median_s:.2f}", f"{speed:.0f}", f"{row.gait_ms:.2f}", str(row.made))
    console().print(table)
    lines = [
        f"{workers} workers are {faster:.2f} times as fast as one (goal {GOAL:g}, for 2)",
        f"a gait takes {alone:.2f} times as long beside another as alone; {workers / alone:.2f} would be the most",
        f"the first time, with the start of the workers' server: {cold:.2f} s, {one.median_s / cold:.2f} times",
        *(f"{key}: {value}" for key, value in machine.items()),
    ]
    for line in lines:
        console().print(line, markup=False)
    if json_path:
        told = [
            {"workers": row.workers, "median_s": row.median_s, "first_s": row.wall_s[0], "gait_ms": row.gait_ms}
            for row in rows.values()
        ]
        ratios = {"ratio": faster, "gait_ratio": alone, "goal": GOAL, "met": faster >= GOAL}
        content = {"format_version": 1, "machine": machine, "gaits": gaits, "rows": told, **ratios}
        write_text(json_path, json.dumps(content, indent=1) + "\n")


@dataclass
class _Timed:
    """How long some workers took for all gaits, and for each by the clock of the worker."""

    workers: int
    wall_s: list[float] = field(default_factory=list)
    means_ms: list[float] = field(default_factory=list)
    made: int = 0

    def make(self, tasks: Sequence[ggo.Task], base: ggo.Gait) -> None:
        begin = time.perf_counter()
        rows = ggo.generate_many(tasks, base, workers=self.workers)
        self.wall_s.append(time.perf_counter() - begin)
        self.means_ms.append(statistics.mean(row.milliseconds for row in rows))
        self.made = sum(row.ok for row in rows)

    @property
    def median_s(self) -> float:
        return statistics.median(self.wall_s)

    @property
    def gait_ms(self) -> float:
        return statistics.median(self.means_ms)


def _tasks(count: int) -> Sequence[ggo.Task]:
    """Boxes of all sizes that a step may meet, some too high to clear."""
    random = np.random.default_rng(1)
    places, widths, heights = random.uniform((-0.25, 0.02, 0.05), (0.22, 0.08, 0.18), (count, 3)).T
    return [
        ggo.Task("step_over", {"obstacles": (ggo.Obstacle(x, x + wide, high),), "foothold": FOOTHOLD})
        for x, wide, high in zip(places.tolist(), widths.tolist(), heights.tolist(), strict=True)
    ]
