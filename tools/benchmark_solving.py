"""The benchmark of solving: measures the library and its rivals side by side.

`tools/benchmark.py solving` runs it.
"""

from __future__ import annotations

import gc
import json
import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path

import click
import numpy as np
from benchmark_rows import FIRST_ORDER, OURS, Row, judged
from benchmark_tables import absolute_table, goals_table, picture, ratio_table
from machine import stated
from rival_minimisers import rivals
from rivals import Found, default_smoothness
from rivals import walk as rival_walk

import ggo_factors as ggo
from ggo_factors.cli.console import console, progress_bar
from ggo_factors.motion.gait import PAPER_MODEL
from ggo_factors.support.files import replacing, write_text
from ggo_factors.support.inputs import as_number

FOOTHOLD, STRIDE, RISER, TREAD, FIRST_EDGE = (0.39, 0.0), 0.975, 0.10, 0.39, 0.29
PAPER_OBSTACLES = {
    "obstacle-1": ggo.Obstacle(0.20, 0.25, 0.08),
    "obstacle-2": ggo.Obstacle(0.20, 0.25, 0.15),
    "obstacle-3": ggo.Obstacle(0.12, 0.16, 0.08),
    "obstacle-4": ggo.Obstacle(0.12, 0.16, 0.15),
    "obstacle-5": ggo.Obstacle(-0.33, -0.29, 0.175),
}
_Pair = tuple[float, float]  # seconds, and seconds of CPU time


@dataclass(frozen=True)
class Task:
    """One task: how the library is asked for it, and what its steps must do."""

    ours: Callable[[ggo.Gait, float | None], ggo.Walk]  # with its smoothness, None for the default
    plan: tuple[ggo.Step, ...]


def _stairs(direction: float) -> tuple[ggo.Step, ...]:
    rises = (direction * RISER,) * 2
    ground = ggo.stair_ground(FIRST_EDGE, TREAD, rises)
    edge = ggo.Obstacle(FIRST_EDGE - 0.01, FIRST_EDGE + 0.01, max(rises[0], 0.0))
    return tuple(
        ggo.Step((TREAD, rise), (edge,), shank_angle=math.pi / 2.0, ground=ground.shifted(TREAD * k, sum(rises[:k])))
        for k, rise in enumerate(rises)
    )


def _over(box: ggo.Obstacle) -> Task:
    step = ggo.Step(FOOTHOLD, (box,))
    return Task(lambda base, smooth: ggo.walk(base, [step], smoothness=smooth), (step,))


def _stride(base: ggo.Gait, smoothness: float | None) -> ggo.Walk:
    return ggo.adjust_stride(base, STRIDE, smoothness=smoothness)


def _up(base: ggo.Gait, smoothness: float | None) -> ggo.Walk:
    return ggo.climb_stairs(base, RISER, tread=TREAD, first_edge=FIRST_EDGE, smoothness=smoothness)


def _down(base: ggo.Gait, smoothness: float | None) -> ggo.Walk:
    return ggo.descend_stairs(base, RISER, tread=TREAD, first_edge=FIRST_EDGE, smoothness=smoothness)


TASKS: dict[str, Task] = {
    "stride": Task(_stride, (ggo.Step((STRIDE / 2.0, 0.0)),) * 2),
    **{name: _over(box) for name, box in PAPER_OBSTACLES.items()},
    "stairs-up": Task(_up, _stairs(1.0)),
    "stairs-down": Task(_down, _stairs(-1.0)),
}


def _numbers(_: click.Context, option: click.Parameter, text: str) -> tuple[int, ...]:
    try:
        numbers = tuple(sorted({int(word) for word in text.split(",")}))
    except ValueError as error:
        raise click.BadParameter(f"{text!r} is not a list of numbers", param=option) from error
    if numbers[0] < 4:
        raise click.BadParameter("at least 4 frames, for the first two of a step say how fast it begins", param=option)
    return numbers


def _gain(_: click.Context, option: click.Parameter, text: str) -> float | None:
    try:
        return None if text == "default" else as_number(float(text), "smoothness", at_least=0.0)
    except ValueError as error:
        raise click.BadParameter(f"{text!r} is neither a gain nor 'default'", param=option) from error


def _names(_: click.Context, option: click.Parameter, text: str) -> tuple[str, ...]:
    chosen = tuple(name for name in TASKS if any(name.startswith(word.strip()) for word in text.split(",")))
    if not chosen:
        raise click.BadParameter(f"{text!r} is none of {', '.join(TASKS)}", param=option)
    return chosen


@click.command()
@click.option("--frames", default="51,101,201,401,801,1601", show_default=True, callback=_numbers)
@click.option("--tasks", default=",".join(TASKS), show_default=True, callback=_names, help="Names, or how they begin.")
@click.option(
    "--smoothness", default="default", show_default=True, callback=_gain, help="Gain of the second-order edges, or 0."
)
@click.option("--rivals", "chosen", default="textbook,SciPy,pyceres", show_default=True, help="Empty: ours alone.")
@click.option("--repeats", type=click.IntRange(1), default=15, show_default=True, help="Interleaved, after a warm-up.")
@click.option(
    "--budget", type=float, default=3.0, show_default=True, help="Seconds a call; a rival beyond it goes no further."
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for benchmark.json and benchmark.png.")
def solving(
    frames: tuple[int, ...],
    tasks: tuple[str, ...],
    smoothness: float | None,
    chosen: str,
    repeats: int,
    budget: float,
    out: Path | None,
) -> None:
    """Make verified gaits: ours against the textbook graph, SciPy and Ceres, all with the same edges and check."""
    rows: list[Row] = []
    machine, race = stated(), _Race(tuple(chosen.split(",")), smoothness, repeats, budget)
    with progress_bar("solving") as advance:
        for done, name in enumerate(tasks):
            rows += race.measure(name, frames)
            if advance:
                advance((done + 1) / len(tasks))
    gain = "the default" if smoothness is None else f"{smoothness:g}"
    notes = [f"smoothness, the gain of the second-order residual edges: {gain}"]
    notes += race.failed
    notes += [
        f"{solver} goes no further than {last} frames at {name}: a call took more than {budget:g} s"
        for (name, solver), last in race.stopped.items()
        if last < frames[-1]
    ]
    if "pyceres" in chosen and "pyceres" not in rivals(4):
        notes.append("pyceres is not installed (extra 'benchmark') and left out")
    goals = judged(rows)
    screen = console()
    for table in (ratio_table(rows, race.stopped, budget), goals_table(goals), absolute_table(rows)):
        screen.print(table if table.row_count else "")
    for line in (*notes, *(f"{key}: {value}" for key, value in machine.items())):
        screen.print(line, markup=False)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        content = {
            "format_version": 2,
            "machine": machine,
            "judged": goals,
            "notes": notes,
            "rows": [asdict(row) for row in rows],
        }
        write_text(out / "benchmark.json", json.dumps(content, indent=1) + "\n")
        with replacing(out / "benchmark.png") as part:
            picture(rows).savefig(part, format="png", dpi=150)


@dataclass
class _Run:
    """One solver at one task, and how long it took each time."""

    base: ggo.Gait
    solver: str
    variant: str
    smoothness: float
    make: Callable[[], Found]
    turns: int
    times: list[_Pair] = field(default_factory=list)
    found: Found | None = None

    def time(self) -> None:
        taken, self.found = _timed(self.make)
        self.times.append(taken)


class _Race:
    """The solvers side by side; remembers who was too slow to go on."""

    def __init__(self, chosen: Sequence[str], smoothness: float | None, repeats: int, budget: float) -> None:
        self._chosen, self._smoothness, self._repeats, self._budget = chosen, smoothness, repeats, budget
        self.stopped: dict[tuple[str, str], int] = {}
        self.failed: list[str] = []
        self._beaten: set[tuple[str, str, str]] = set()

    def measure(self, name: str, counts: Sequence[int]) -> list[Row]:
        """All solvers at one task, at all sampling rates in turn, so that a busy moment meets all of them."""
        runs = [self._runs(name, count) for count in counts]
        for turn in range(self._repeats):
            for run in chain(*runs):
                if turn < run.turns:
                    run.time()
        return [row for beside in runs for row in _rows(name, beside)]

    def _runs(self, name: str, count: int) -> list[_Run]:
        """The solvers that take part, ours first, each run once."""
        task, base = TASKS[name], replace(ggo.paper_base_gait(count), model=replace(PAPER_MODEL, bones="points"))
        gain = default_smoothness(count) if self._smoothness is None else self._smoothness
        ways: dict[str, dict[str, Callable[[], Found]]] = {
            OURS: {"": lambda: _found(task.ours(base, self._smoothness))}
        }
        if gain:
            ways[FIRST_ORDER] = {"": lambda: _found(task.ours(base, 0.0))}
        for solver, choices in rivals(count).items():
            if solver in self._chosen and (name, solver) not in self.stopped:
                left = {
                    way: each for way, each in choices.items() if (name, solver, way) not in self._beaten
                } or choices
                ways[solver] = {way: partial(rival_walk, base, task.plan, gain, each) for way, each in left.items()}
        runs: list[_Run] = []
        for solver, each in ways.items():
            fastest = self._fastest(name, solver, each)
            if fastest is None:
                self.failed.append(f"{solver} fails at {name}, {count} frames")
                continue
            variant, warm = fastest
            if warm > self._budget and solver not in (OURS, FIRST_ORDER):
                self.stopped[name, solver] = count
            turns = max(1, min(self._repeats, int(self._budget / warm)))
            runs.append(_Run(base, solver, variant, 0.0 if solver == FIRST_ORDER else gain, each[variant], turns))
        return runs if runs and runs[0].solver == OURS else []

    def _fastest(self, name: str, solver: str, ways: Mapping[str, Callable[[], Found]]) -> tuple[str, float] | None:
        """The way that takes least time among those that find a good gait, and its seconds; each is run once."""
        taken: dict[str, tuple[bool, float]] = {}
        for way, run in ways.items():
            with suppress(ggo.GgoError):
                (seconds, _), found = _timed(run)
                taken[way] = (not found.ok, seconds)
        if not taken:
            return None
        best = min(taken, key=taken.__getitem__)
        # The ways differ in how they grow with the frames: what is far behind is not tried with more of them.
        self._beaten |= {(name, solver, way) for way, (_, each) in taken.items() if each > 3.0 * taken[best][1]}
        return best, taken[best][1]


def _timed(run: Callable[[], Found]) -> tuple[_Pair, Found]:
    """Seconds, seconds of CPU time, and what was found."""
    gc.collect()
    begin, cpu = time.perf_counter(), time.process_time()
    found = run()
    return (time.perf_counter() - begin, time.process_time() - cpu), found


def _found(walk: ggo.Walk) -> Found:
    return Found(
        tuple(gait.frames for gait in walk.gaits),
        sum(step.iterations for step in walk.steps),
        sum(step.rounds for step in walk.steps),
        max(len(step.keyframes) for step in walk.steps),
        min(step.report.clearance for step in walk.steps),
        all(step.ok for step in walk.steps),
    )


def _rows(name: str, runs: Sequence[_Run]) -> list[Row]:
    rows: list[Row] = []
    for run in runs:
        assert run.found is not None  # each has at least one turn
        offsets = [frames - run.base.frames for frames in run.found.gaits]
        seconds, cpu = (statistics.median(taken[k] for taken in run.times) for k in (0, 1))
        residual, smoothness = (
            sum(0.5 * gain * float((np.diff(offset, n=order, axis=0) ** 2).sum()) for offset in offsets)
            for order, gain in ((1, 1.0), (2, run.smoothness))
        )
        ours = rows[0] if rows else None
        rows.append(
            Row(
                task=name,
                frames=len(run.base),
                smoothness=run.smoothness,
                solver=run.solver,
                variant=run.variant,
                seconds=seconds,
                cpu_seconds=cpu,
                repeats=len(run.times),
                ratio=seconds / ours.seconds if ours else 1.0,
                cpu_ratio=cpu / ours.cpu_seconds if ours else 1.0,
                iterations=run.found.iterations,
                rounds=run.found.rounds,
                keyframes=run.found.keyframes,
                clearance_m=None if math.isinf(run.found.clearance) else run.found.clearance,
                residual_cost=residual,
                smoothness_cost=smoothness,
                off=(residual + smoothness) / (ours.residual_cost + ours.smoothness_cost) - 1.0 if ours else 0.0,
                ok=run.found.ok,
            )
        )
    return rows
