"""The benchmark of refusals: how soon they come, and how many a search that has time contradicts."""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import click
import numpy as np
from benchmark_solving import FOOTHOLD
from machine import stated
from rich.table import Table

import ggo_factors as ggo
from ggo_factors.cli.console import console
from ggo_factors.support.files import write_text

SMOOTHNESSES = (1.0, 3.0, 0.3, 10.0, 0.1, 30.0, 0.03, 0.01)
"""Times the default smoothness, the likeliest first."""
PATIENCE = 2.0
"""So long the search may take with each smoothness in [s]."""
SLOWEST = 0.25
SOON_GOAL, MS_GOAL, TRUE_GOAL = 0.99, 300.0, 0.97


@dataclass(frozen=True)
class Row:
    """One box: whether it is stepped over, in what CPU time; where it is refused, what the search finds."""

    kind: str
    box: tuple[float, float, float]
    made: bool
    cpu_ms: float
    found: str
    search_cpu_ms: float


@click.command()
@click.option("--boxes", type=click.IntRange(1), default=60, show_default=True, help="Seeded, each in three ways.")
@click.option("--search/--no-search", default=True, show_default=True, help="Look for a way where one is refused.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def refusals(boxes: int, search: bool, json_path: Path | None) -> None:
    """Hard boxes without limits, within limits at any pace and at the base gait's, beside a search that has time."""
    machine, base = stated(), ggo.paper_base_gait()
    limits = ggo.JointLimits()
    kinds: dict[str, tuple[ggo.JointLimits | None, float | None, float]] = {
        "no limits": (None, None, 1.0),
        "limits": (limits, None, SLOWEST),
        "limits, pace 1": (limits, 1.0, 1.0),
    }
    ggo.step_over(base, [ggo.Obstacle(0.1, 0.15, 0.03)], foothold=FOOTHOLD, limits=limits)  # imports take their time
    rows = []
    for box, (name, (held, pace, slowest)) in product(_boxes(boxes), kinds.items()):
        begin = time.process_time()
        made = _made(base, box, limits=held, pace=pace)
        spent, begin = time.process_time() - begin, time.process_time()
        found = "" if made or not search else _search(base, box, held, slowest)
        rows.append(Row(name, box, made, spent * 1e3, found, (time.process_time() - begin) * 1e3))
    table = Table(title=f"{boxes} boxes, {len(rows)} steps", title_justify="left")
    for heading in ("steps", "made", "refused", "CPU, median\nms", "most\nms", "within\n300 ms", "untrue"):
        table.add_column(heading, justify="left" if heading == "steps" else "right")
    table.add_column("search, median\nms", justify="right")
    summary = {}
    for name in kinds:
        mine = [row for row in rows if row.kind == name]
        refused = [row for row in mine if not row.made]
        spent_ms = [row.cpu_ms for row in refused]
        summary[name] = found_of = {
            "made": len(mine) - len(refused),
            "refused": len(refused),
            "cpu_ms_median": statistics.median(spent_ms) if refused else None,
            "cpu_ms_most": max(spent_ms, default=None),
            "within_300_ms": sum(spent <= MS_GOAL for spent in spent_ms),
            "untrue": sum(bool(row.found) for row in refused) if search else None,
            "search_cpu_ms_median": statistics.median(row.search_cpu_ms for row in refused)
            if refused and search
            else None,
        }
        table.add_row(name, *("" if value is None else f"{value:.4g}" for value in found_of.values()))
    table.add_row("goal", "", "", "", "1000", f"{SOON_GOAL:.0%}", f"{1.0 - TRUE_GOAL:.0%}", "")
    console().print(table)
    for key, value in machine.items():
        console().print(f"{key}: {value}", markup=False)
    if json_path:
        content = {"format_version": 1, "machine": machine, "summary": summary, "rows": [asdict(row) for row in rows]}
        write_text(json_path, json.dumps(content, indent=1) + "\n")


def _boxes(count: int) -> Iterator[tuple[float, float, float]]:
    """Boxes that end shortly before the foothold, up to 0.18 m high."""
    random = np.random.default_rng(14)
    for _ in range(count):
        height, width, before = random.uniform((0.05, 0.005, 0.001), (0.18, 0.08, 0.02)).tolist()
        yield FOOTHOLD[0] - before - width, FOOTHOLD[0] - before, height


def _made(
    base: ggo.Gait,
    box: tuple[float, float, float],
    *,
    limits: ggo.JointLimits | None,
    pace: float | None,
    smoothness: float | None = None,
    hard: bool = False,
    deadline: float | None = None,
) -> bool:
    try:
        ggo.step_over(
            base,
            [ggo.Obstacle(*box)],
            foothold=FOOTHOLD,
            limits=limits,
            pace=pace,
            smoothness=smoothness,
            hard=hard,
            deadline=deadline,
        )
    except ggo.InfeasibleGaitError:
        return False
    return True


def _search(base: ggo.Gait, box: tuple[float, float, float], limits: ggo.JointLimits | None, slowest: float) -> str:
    """How a search without haste makes the step, at the slowest pace that is allowed; nothing where it does not."""
    default = (0.2 * (len(base) - 1)) ** 2
    for times, hard in product(SMOOTHNESSES, (False, True)):
        smooth = times * default
        if _made(base, box, limits=limits, pace=slowest, smoothness=smooth, hard=hard, deadline=PATIENCE):
            return f"{times:g} times the smoothness{' and constraints' if hard else ''}, pace {slowest:g}"
    return ""
