"""The benchmark of paces: random walks within random limits, slowed where they must be, beside one pace for all."""

from __future__ import annotations

import gc
import json
import statistics
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import click
import numpy as np
from benchmark_solving import FOOTHOLD
from machine import stated
from rich.table import Table

import ggo_factors as ggo
from ggo_factors.cli.console import console
from ggo_factors.support.files import write_text

LANDING = 2.0  # no foot of these walks lands faster; in m/s
STEPS = (1, 3, 10)
MS_GOAL = 60.0
RATES = ("hip_speed", "knee_speed", "hip_acceleration", "knee_acceleration")


@dataclass(frozen=True)
class Row:
    """One walk: its time at the base gait's pace, at one slower pace for all, slowed where it must be, and the cost.

    `used` is the largest share of a limit that the slowed trajectory uses, on a grid of 1 ms; times of CPU, least of
    the repeats: of making the walk without limits on rates, and of slowing it.
    """

    steps: int
    duration_s: float
    one_pace_s: float
    slowed_s: float
    used: float
    made_ms: float
    slowed_ms: float


@click.command()
@click.option("--walks", type=click.IntRange(1), default=20, show_default=True, help="Seeded, of each length.")
@click.option("--repeats", type=click.IntRange(1), default=3, show_default=True, help="Interleaved.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def pace(walks: int, repeats: int, json_path: Path | None) -> None:
    """Walks slowed to random joint limits, beside making them, and beside the same walks at one pace for all."""
    machine, base = stated(), ggo.paper_base_gait()
    rows = [_row(base, count, seed, repeats) for count in STEPS for seed in range(walks)]
    table = Table(title=f"{len(rows)} walks: medians", title_justify="left")
    for heading in (
        "steps",
        "one pace\nratio",
        "slowed\nratio",
        "limits used\nmost",
        "making\nCPU ms",
        "slowing\nCPU ms",
    ):
        table.add_column(heading, justify="right")
    table.add_column("most\nCPU ms", justify="right")
    summary = {}
    for count in STEPS:
        mine = [row for row in rows if row.steps == count]
        summary[str(count)] = found = {
            "one_pace_ratio": statistics.median(row.one_pace_s / row.duration_s for row in mine),
            "slowed_ratio": statistics.median(row.slowed_s / row.duration_s for row in mine),
            "most_used": max(row.used for row in mine),
            "made_ms": statistics.median(row.made_ms for row in mine),
            "slowed_ms": statistics.median(row.slowed_ms for row in mine),
            "slowed_ms_most": max(row.slowed_ms for row in mine),
        }
        table.add_row(str(count), *(f"{value:.4g}" for value in found.values()))
    table.add_row("goal", "", "", "1", "", f"{MS_GOAL:g}", "")
    console().print(table)
    for key, value in machine.items():
        console().print(f"{key}: {value}", markup=False)
    if json_path:
        content = {"format_version": 1, "machine": machine, "summary": summary, "rows": [asdict(row) for row in rows]}
        write_text(json_path, json.dumps(content, indent=1) + "\n")


def _row(base: ggo.Gait, count: int, seed: int, repeats: int) -> Row:
    random, plan = np.random.default_rng([count, seed]), list[ggo.Step]()
    for number in range(count):
        x, width, height = random.uniform((0.08, 0.02, 0.02), (0.20, 0.06, 0.10)).tolist()
        plan.append(ggo.Step(FOOTHOLD, (ggo.Obstacle(x, x + width, height),) if number % 3 == 0 else ()))
    wide, scales = ggo.JointLimits(), np.exp(random.uniform(np.log(0.4), np.log(2.0), len(RATES))).tolist()
    limits = replace(wide, **{name: getattr(wide, name) * by for name, by in zip(RATES, scales, strict=True)})
    made_ms, slowed_ms = list[float](), list[float]()
    for _ in range(repeats):
        gc.collect()
        begin = time.process_time()
        walk = ggo.walk(base, plan)
        made_ms.append((time.process_time() - begin) * 1e3)
        held = replace(walk, limits=limits)
        begin = time.process_time()
        slowed = held.slowed(LANDING)
        slowed_ms.append((time.process_time() - begin) * 1e3)
    played = walk.joint_trajectory().played
    by_speed = float((np.abs(played.fastest) / limits.speed).max())
    by_acceleration = float((np.abs(played.accelerations) / limits.acceleration).max())
    fine = slowed.joint_trajectory(rate=1000.0)
    used = max(
        float((np.abs(fine.velocities) / limits.speed).max()),
        float((np.abs(fine.accelerations) / limits.acceleration).max()),
    )
    duration = float(walk.times[-1])
    return Row(
        steps=count,
        duration_s=duration,
        one_pace_s=duration * max(1.0, by_speed, by_acceleration**0.5),
        slowed_s=float(slowed.times[-1]),
        used=used,
        made_ms=min(made_ms),
        slowed_ms=min(slowed_ms),
    )
