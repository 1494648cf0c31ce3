"""The benchmark of balance: steps of 1 s over the paper's boxes and random ones, with balance edges and without."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import click
import numpy as np
from benchmark_solving import FOOTHOLD, PAPER_OBSTACLES
from machine import stated, tell
from paper_gaits import paper_base
from rich.table import Table

import ggo_factors as ggo
from ggo_factors.evaluate.metrics import zmp

STEP_TIME = 1.0  # of a patient in an exoskeleton; in s
MEAN_GOAL, LARGEST_GOAL, CHANGE_GOAL, ACCELERATION_GOAL, MS_GOAL, RATIO_GOAL = 5.0, 15.0, 1.02, 1.05, 40.0, 10.0


@dataclass(frozen=True)
class Row:
    """One box, without balance edges and with them: mean distance of the ZMP from the base gait's, and what it costs.

    Pairs are of the step without and with; times of CPU, the least of the repeats.
    """

    box: str
    zmp_off_mm: tuple[float, float]
    change_deg: tuple[float, float]
    acceleration_rad_s2: tuple[float, float]
    cpu_ms: tuple[float, float]


@click.command()
@click.option("--boxes", type=click.IntRange(0), default=100, show_default=True, help="Random boxes beside the five.")
@click.option("--gain", type=click.FloatRange(0.0, min_open=True), default=2.0, show_default=True)
@click.option("--repeats", type=click.IntRange(1), default=3, show_default=True, help="Interleaved.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def balance(boxes: int, gain: float, repeats: int, json_path: Path | None) -> None:
    """Balanced steps beside the same without balance edges."""
    machine, base = stated(), replace(paper_base(), dt=STEP_TIME / 50)
    cases = {**PAPER_OBSTACLES, **{f"random-{n + 1}": box for n, box in enumerate(_boxes(boxes))}}
    rows = []
    for name, box in cases.items():
        with suppress(ggo.InfeasibleGaitError):
            rows.append(_row(name, box, base, gain, repeats))
    groups = {name: chosen for name, chosen in _groups(rows).items() if chosen}
    judged = {name: _judged(chosen) for name, chosen in groups.items()}
    table = Table(title=f"{len(rows)} of {len(cases)} boxes made, gain {gain:g}", title_justify="left")
    for heading in ("boxes", "mean ZMP off\nmm", "largest mean\nmm", "change\nratio", "acceleration\nratio"):
        table.add_column(heading, justify="right")
    for heading in ("CPU, median\nms", "most\nms", "times as long\nmedian"):
        table.add_column(heading, justify="right")
    for name, found in judged.items():
        table.add_row(name, *(f"{value:.3g}" for value in found.values()))
    goals = (MEAN_GOAL, LARGEST_GOAL, CHANGE_GOAL, ACCELERATION_GOAL, MS_GOAL, None, RATIO_GOAL)
    table.add_row("goal", *("" if goal is None else f"{goal:g}" for goal in goals))
    tell(table, machine, json_path, gain=gain, judged=judged, rows=[asdict(row) for row in rows])


def _boxes(count: int) -> list[ggo.Obstacle]:
    """Boxes of all sizes that a step may meet, none within 0.03 m of the supporting foot."""
    random, made = np.random.default_rng(1), list[ggo.Obstacle]()
    while len(made) < count:
        start, width, height = random.uniform((-0.30, 0.02, 0.02), (0.25, 0.08, 0.18)).tolist()
        if start > 0.03 or start + width < -0.03:
            made.append(ggo.Obstacle(start, start + width, height))
    return made


def _row(name: str, box: ggo.Obstacle, base: ggo.Gait, gain: float, repeats: int) -> Row:
    gaits, spent = dict[float | None, ggo.Gait](), {None: list[float](), gain: list[float]()}
    for _ in range(repeats):
        for each, times in spent.items():
            gc.collect()
            begin = time.process_time()
            gaits[each] = ggo.step_over(base, [box], foothold=FOOTHOLD, balance=each).gait
            times.append((time.process_time() - begin) * 1e3)
    free, held = gaits[None], gaits[gain]

    def off(gait: ggo.Gait) -> float:
        return float(np.abs(zmp(gait) - zmp(base)).mean()) * 1e3

    def change(gait: ggo.Gait) -> float:
        return float(np.degrees(np.abs(gait.frames - base.frames).mean()))

    def peak(gait: ggo.Gait) -> float:
        return float(np.abs(np.diff(gait.frames, 2, axis=0)).max()) / base.dt**2

    return Row(
        name,
        (off(free), off(held)),
        (change(free), change(held)),
        (peak(free), peak(held)),
        (min(spent[None]), min(spent[gain])),
    )


def _groups(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The paper's boxes, the random ones, and all."""
    paper = [row for row in rows if row.box in PAPER_OBSTACLES]
    return {"paper": paper, "random": [row for row in rows if row not in paper], "all": list(rows)}


def _judged(rows: Sequence[Row]) -> dict[str, float]:
    """The numbers that stand beside the goals."""
    off, change, bend, spent = (
        np.array([getattr(row, name) for row in rows])
        for name in ("zmp_off_mm", "change_deg", "acceleration_rad_s2", "cpu_ms")
    )
    return {
        "mean_zmp_off_mm": float(off[:, 1].mean()),
        "largest_mean_zmp_off_mm": float(off[:, 1].max()),
        "change_ratio": float(change[:, 1].mean() / change[:, 0].mean()),
        "acceleration_ratio": float(bend[:, 1].mean() / bend[:, 0].mean()),
        "cpu_ms_median": statistics.median(spent[:, 1].tolist()),
        "cpu_ms_most": float(spent[:, 1].max()),
        "times_as_long": statistics.median((spent[:, 1] / spent[:, 0]).tolist()),
    }
