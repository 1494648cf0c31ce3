"""The benchmark of plans: random courses planned and walked, beside the foothold nearest to the own stride."""

from __future__ import annotations

import statistics
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import click
import numpy as np
from courses import random_course
from machine import stated, tell
from rich.table import Table
from rival_footholds import Way, greedy

import ggo_factors as ggo

MEDIAN_GOAL, MOST_GOAL = 150.0, 400.0
"""Plan and walk of ten steps in [ms] of CPU: half the courses, and 95 of 100."""
MOST = 0.95


@dataclass(frozen=True)
class Row:
    """One course in one way: whether it is walked, what it costs, how many steps were refused before, CPU times.

    Of the way that takes the foothold nearest to the own stride nothing is refused that it does not see itself.
    """

    way: str
    seed: int
    steps: int
    walked: bool
    cost: float
    refused_before: int
    cpu_ms: float


@click.command()
@click.option("--courses", type=click.IntRange(2), default=60, show_default=True, help="Seeded.")
@click.option("--repeats", type=click.IntRange(1), default=2, show_default=True, help="Of each; the least time counts.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def planning(courses: int, repeats: int, json_path: Path | None) -> None:
    """Random courses of about ten steps by `plan_walk`, as it is, as people walk, to standing; and by greedy choice."""
    machine, base = stated(), ggo.paper_base_gait()
    _planned(base, 0, "least change")  # imports take their time
    rows = []
    for seed in range(courses):
        for way in ("least change", "people", "standing to standing"):
            rows.append(min((_planned(base, seed, way) for _ in range(repeats)), key=lambda row: row.cpu_ms))
        rows.append(_greedy(base, seed))
    table = Table(title=f"{courses} courses", title_justify="left")
    for heading in ("way", "walked", "steps", "cost,\nof the first", "refused\nbefore", "CPU, median\nms"):
        table.add_column(heading, justify="left" if heading == "way" else "right")
    table.add_column("95 of 100\nms", justify="right")
    summary = {}
    costs = {row.seed: row.cost for row in rows if row.way == "least change" and row.walked}
    for way in dict.fromkeys(row.way for row in rows):
        mine = [row for row in rows if row.way == way]
        walked = [row for row in mine if row.walked]
        spent_ms = [row.cpu_ms for row in mine]
        summary[way] = found = {
            "walked": len(walked),
            "steps": statistics.median(row.steps for row in walked),
            "cost_ratio": statistics.median(row.cost / costs[row.seed] for row in walked if row.seed in costs),
            "refused_before": sum(row.refused_before for row in mine),
            "cpu_ms_median": statistics.median(spent_ms),
            "cpu_ms_95": float(np.quantile(spent_ms, MOST)),
        }
        table.add_row(way, *(f"{value:.4g}" for value in found.values()))
    table.add_row("goal", f"{0.99 * courses:.4g}", "", "", "", f"{MEDIAN_GOAL:g}", f"{MOST_GOAL:g}")
    tell(table, machine, json_path, summary=summary, rows=[asdict(row) for row in rows])


def _planned(base: ggo.Gait, seed: int, way: str) -> Row:
    course = random_course(seed)
    terrain, stands = course.terrain(), way == "standing to standing"
    start = ggo.STANDING if stands else None
    prefer: Literal["people", "least_change"] = "people" if way == "people" else "least_change"
    begin = time.process_time()
    try:
        plan = ggo.plan_walk(base, terrain, goal=course.goal, start=start, to_standing=stands, prefer=prefer)
    except ggo.InfeasibleGaitError:
        return Row(way, seed, 0, False, 0.0, 0, (time.process_time() - begin) * 1e3)
    spent = (time.process_time() - begin) * 1e3
    return Row(way, seed, len(plan.footholds), True, plan.cost, len(plan.banned), spent)


def _greedy(base: ggo.Gait, seed: int) -> Row:
    course = random_course(seed)
    way, begin = Way(course.terrain(), base), time.process_time()
    feet, walked = greedy(way, course.goal)
    spent, steps = (time.process_time() - begin) * 1e3, len(feet.footholds())
    return Row("nearest to the own stride", seed, steps, walked, feet.cost(), way.tried - steps, spent)
