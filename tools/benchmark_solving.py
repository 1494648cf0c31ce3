"""The benchmark of solving: measures the library and its rivals side by side, and shows it.

`tools/benchmark.py solving` runs it.
"""

from __future__ import annotations

import gc
import json
import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import click
import numpy as np
from machine import stated
from matplotlib.figure import Figure
from rich.table import Table
from rival_minimisers import rivals
from rivals import Found, Minimiser
from rivals import walk as rival_walk

import ggo_factors as ggo
from ggo_factors.console import console, progress_bar
from ggo_factors.files import replacing, write_text

OURS = "ggo_factors"
FOOTHOLD, STRIDE, RISER, TREAD, FIRST_EDGE = (0.39, 0.0), 0.975, 0.10, 0.39, 0.29
PAPER_OBSTACLES = {
    "obstacle-1": ggo.Obstacle(0.20, 0.25, 0.08),
    "obstacle-2": ggo.Obstacle(0.20, 0.25, 0.15),
    "obstacle-3": ggo.Obstacle(0.12, 0.16, 0.08),
    "obstacle-4": ggo.Obstacle(0.12, 0.16, 0.15),
    "obstacle-5": ggo.Obstacle(-0.33, -0.29, 0.175),
}
# What the finished library is to reach: rival, tasks, frames, how many times faster.
GOALS = (
    ("textbook", "obstacle", 51, 5.0),
    ("SciPy", "obstacle", 51, 3.0),
    ("pyceres", "obstacle", 51, 1.0),
    ("textbook", "stride", 51, 8.0),
)
FLAT_FROM, FLAT_TO, FLAT_GOAL = 101, 1601, 1.5

_Pair = tuple[float, float]  # seconds, and seconds of CPU time


@dataclass(frozen=True)
class Task:
    """One task: how the library is asked for it, and what its steps must do."""

    ours: Callable[[ggo.Gait], ggo.Walk]
    plan: tuple[ggo.Step, ...]


@dataclass(frozen=True)
class Row:
    """One solver at one task and sampling rate; `seconds` is the median of the repeats, `ratio` that over ours.

    The same by CPU time, which a busy machine disturbs less, but which counts every thread that SciPy's dense algebra
    keeps busy.
    """

    task: str
    frames: int
    solver: str
    variant: str
    seconds: float
    cpu_seconds: float
    repeats: int
    ratio: float
    cpu_ratio: float
    iterations: int
    rounds: int
    keyframes: int
    clearance_m: float | None
    residual_cost: float
    objective: float
    ok: bool


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
    return Task(lambda base: ggo.walk(base, [step]), (step,))


TASKS: dict[str, Task] = {
    "stride": Task(lambda base: ggo.adjust_stride(base, STRIDE), (ggo.Step((STRIDE / 2.0, 0.0)),) * 2),
    **{name: _over(box) for name, box in PAPER_OBSTACLES.items()},
    "stairs-up": Task(lambda base: ggo.climb_stairs(base, RISER, TREAD, FIRST_EDGE), _stairs(1.0)),
    "stairs-down": Task(lambda base: ggo.descend_stairs(base, RISER, TREAD, FIRST_EDGE), _stairs(-1.0)),
}


def _numbers(_: click.Context, option: click.Parameter, text: str) -> tuple[int, ...]:
    try:
        numbers = tuple(sorted({int(word) for word in text.split(",")}))
    except ValueError as error:
        raise click.BadParameter(f"{text!r} is not a list of numbers", param=option) from error
    if numbers[0] < 2:
        raise click.BadParameter("a gait has at least 2 frames", param=option)
    return numbers


def _names(_: click.Context, option: click.Parameter, text: str) -> tuple[str, ...]:
    chosen = tuple(name for name in TASKS if any(name.startswith(word.strip()) for word in text.split(",")))
    if not chosen:
        raise click.BadParameter(f"{text!r} is none of {', '.join(TASKS)}", param=option)
    return chosen


@click.command()
@click.option("--frames", default="51,101,201,401,801,1601", show_default=True, callback=_numbers)
@click.option("--tasks", default=",".join(TASKS), show_default=True, callback=_names, help="Names, or how they begin.")
@click.option("--rivals", "chosen", default="textbook,SciPy,pyceres", show_default=True, help="Empty: ours alone.")
@click.option("--repeats", type=click.IntRange(1), default=11, show_default=True, help="Interleaved, after a warm-up.")
@click.option(
    "--budget", type=float, default=5.0, show_default=True, help="Seconds a call; a rival beyond it goes no further."
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for benchmark.json and benchmark.png.")
def solving(
    frames: tuple[int, ...], tasks: tuple[str, ...], chosen: str, repeats: int, budget: float, out: Path | None
) -> None:
    """Make verified gaits: ours against the textbook graph, SciPy and Ceres, all with the same edges and check."""
    rows: list[Row] = []
    machine, race = stated(), _Race(tuple(chosen.split(",")), repeats, budget)
    with progress_bar("solving") as advance:
        for done, (count, name) in enumerate((count, name) for count in frames for name in tasks):
            rows += race.measure(name, count)
            if advance:
                advance((done + 1) / (len(frames) * len(tasks)))
    notes = [
        f"{solver} goes no further than {last} frames at {name}: a call took more than {budget:g} s"
        for (name, solver), last in race.stopped.items()
        if last < frames[-1]
    ]
    if "pyceres" in chosen and "pyceres" not in rivals(2):
        notes.append("pyceres is not installed (extra 'benchmark') and left out")
    judged = _judged(rows)
    screen = console()
    for table in (_ratio_table(rows, race.stopped, budget), _goals_table(judged), _absolute_table(rows)):
        screen.print(table if table.row_count else "")
    for line in (*notes, *(f"{key}: {value}" for key, value in machine.items())):
        screen.print(line, markup=False)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        content = {
            "format_version": 1,
            "machine": machine,
            "judged": judged,
            "notes": notes,
            "rows": [asdict(row) for row in rows],
        }
        write_text(out / "benchmark.json", json.dumps(content, indent=1) + "\n")
        with replacing(out / "benchmark.png") as part:
            _picture(rows).savefig(part, format="png", dpi=150)


class _Race:
    """The solvers side by side; remembers who was too slow to go on."""

    def __init__(self, chosen: Sequence[str], repeats: int, budget: float) -> None:
        self._chosen, self._repeats, self._budget = chosen, repeats, budget
        self.stopped: dict[tuple[str, str], int] = {}
        self._beaten: set[tuple[str, str, str]] = set()

    def measure(self, name: str, count: int) -> list[Row]:
        """All solvers at one task, in turn, so that a busy moment of the machine meets all of them."""
        task, base = TASKS[name], ggo.paper_base_gait(count)
        warm = {OURS: _timed(lambda: _found(task.ours(base)))[0][0]}
        runs: dict[str, Callable[[], Found]] = {OURS: lambda: _found(task.ours(base))}
        variants = {OURS: ""}
        for solver, choices in rivals(count).items():
            if solver not in self._chosen or (name, solver) in self.stopped:
                continue
            left = {way: each for way, each in choices.items() if (name, solver, way) not in self._beaten}
            variants[solver], warm[solver] = self._fastest(name, solver, left, base)
            runs[solver] = partial(rival_walk, base, task.plan, choices[variants[solver]])
            if warm[solver] > self._budget:
                self.stopped[name, solver] = count
        turns = {solver: max(1, min(self._repeats, int(self._budget / warm[solver]))) for solver in runs}
        times: dict[str, list[_Pair]] = {solver: [] for solver in runs}
        found: dict[str, Found] = {}
        for turn in range(self._repeats):
            for solver, run in runs.items():
                if turn < turns[solver]:
                    taken, found[solver] = _timed(run)
                    times[solver].append(taken)
        medians = {
            solver: (statistics.median(wall for wall, _ in each), statistics.median(cpu for _, cpu in each))
            for solver, each in times.items()
        }
        return [
            _row(name, base, solver, variants[solver], len(times[solver]), medians[solver], medians[OURS], each)
            for solver, each in found.items()
        ]

    def _fastest(self, name: str, solver: str, ways: Mapping[str, Minimiser], base: ggo.Gait) -> tuple[str, float]:
        """The way that takes least time among those that find a good gait, and its seconds; each is run once."""
        taken: dict[str, tuple[bool, float]] = {}
        for way, minimise in ways.items():
            (seconds, _), found = _timed(partial(rival_walk, base, TASKS[name].plan, minimise))
            taken[way] = (not found.ok, seconds)
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
        sum(sum(step.costs.values()) for step in walk.steps),
        min(step.report.clearance for step in walk.steps),
        all(step.ok for step in walk.steps),
    )


def _row(
    name: str, base: ggo.Gait, solver: str, way: str, repeats: int, seconds: _Pair, ours: _Pair, found: Found
) -> Row:
    # What a gait's motion deviates from the base gait's, from the finished frames and so alike for everyone.
    residual = sum(0.5 * float((np.diff(frames - base.frames, axis=0) ** 2).sum()) for frames in found.gaits)
    return Row(
        name,
        len(base),
        solver,
        way,
        seconds[0],
        seconds[1],
        repeats,
        seconds[0] / ours[0],
        seconds[1] / ours[1],
        found.iterations,
        found.rounds,
        found.keyframes,
        None if math.isinf(found.clearance) else found.clearance,
        residual,
        found.objective,
        found.ok,
    )


# -- showing ----------------------------------------------------------------------------------------------------


def _groups(rows: Sequence[Row]) -> dict[str, tuple[str, ...]]:
    """Tasks shown together: the obstacles as one, by the median."""
    names = dict.fromkeys(row.task for row in rows)
    boxes = tuple(name for name in names if name.startswith("obstacle"))
    groups = {("obstacles" if name in boxes else name): (name,) for name in names}
    return {**groups, **({"obstacles": boxes} if boxes else {})}


def _middle(rows: Sequence[Row], tasks: Sequence[str], count: int, solver: str, value: str) -> float | None:
    """The median over tasks, or None where one of them was not run."""
    found = [row for row in rows if row.task in tasks and row.frames == count and row.solver == solver]
    return statistics.median(getattr(row, value) for row in found) if found and len(found) == len(tasks) else None


def _judged(rows: Sequence[Row]) -> list[dict[str, object]]:
    groups, judged = _groups(rows), []
    for rival, kind, count, goal in GOALS:
        tasks = next((tasks for name, tasks in groups.items() if name.startswith(kind)), ())
        ratio, cpu = (_middle(rows, tasks, count, rival, value) for value in ("ratio", "cpu_ratio"))
        if ratio is not None:
            what = f"{kind}, {count} frames: times faster than {rival}"
            judged.append({"what": what, "ratio": ratio, "cpu_ratio": cpu, "goal": goal, "met": ratio >= goal})
    for name, tasks in groups.items():
        ratio, cpu = (_growth(rows, tasks, value) for value in ("seconds", "cpu_seconds"))
        if ratio is not None:
            what, met = f"{name}: time at {FLAT_TO} frames over time at {FLAT_FROM}", ratio <= FLAT_GOAL
            judged.append({"what": what, "ratio": ratio, "cpu_ratio": cpu, "goal": FLAT_GOAL, "met": met})
    return judged


def _growth(rows: Sequence[Row], tasks: Sequence[str], value: str) -> float | None:
    slow, fast = (_middle(rows, tasks, count, OURS, value) for count in (FLAT_TO, FLAT_FROM))
    return None if slow is None or fast is None else slow / fast


def _solvers(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row.solver for row in rows))


def _ratio_table(rows: Sequence[Row], stopped: Mapping[tuple[str, str], int], budget: float) -> Table:
    solvers = [solver for solver in _solvers(rows) if solver != OURS]
    title = f"How many times as long the others take; none further than where one call took more than {budget:g} s"
    table = _table(title, ("task", "frames", *solvers, "ours ms"))
    for name, tasks in _groups(rows).items():
        for count in dict.fromkeys(row.frames for row in rows):
            cells = []
            for solver in solvers:
                ratio = _middle(rows, tasks, count, solver, "ratio")
                over = any(stopped.get((task, solver), count) < count for task in tasks)
                cells.append("stopped" if over else _cell(ratio, ".1f"))
            seconds = _middle(rows, tasks, count, OURS, "seconds")
            shown = f"{name}, median" if len(tasks) > 1 else name
            table.add_row(shown, str(count), *cells, _cell(None if seconds is None else seconds * 1e3, ".1f"))
    return table


def _goals_table(judged: Sequence[Mapping[str, object]]) -> Table:
    table = _table("Goals", ("what", "ratio", "by CPU time", "goal", "met"))
    for each in judged:
        numbers = (f"{each['ratio']:.2f}", f"{each['cpu_ratio']:.2f}", f"{each['goal']:g}")
        table.add_row(str(each["what"]), *numbers, "yes" if each["met"] else "no")
    return table


def _absolute_table(rows: Sequence[Row]) -> Table:
    headings = (
        "solver",
        "ms",
        "repeats",
        "iter",
        "rounds",
        "keyframes",
        "clear mm",
        "residual cost",
        "objective",
        "ok",
    )
    table = _table(
        "Medians; keys: keyframes, residual: cost of the finished frames, computed alike for all",
        ("task", "frames", *headings),
    )
    for row in rows:
        table.add_row(
            row.task,
            str(row.frames),
            f"{row.solver} ({row.variant})" if row.variant else row.solver,
            f"{row.seconds * 1e3:.1f}",
            str(row.repeats),
            str(row.iterations),
            str(row.rounds),
            str(row.keyframes),
            _cell(None if row.clearance_m is None else row.clearance_m * 1e3, ".1f"),
            f"{row.residual_cost:.4e}",
            f"{row.objective:.4e}",
            "yes" if row.ok else "NO",
        )
    return table


def _table(title: str, headings: Sequence[str]) -> Table:
    table = Table(title=title, title_justify="left")
    for heading in headings:
        table.add_column(heading, justify="left" if heading in ("task", "solver", "what") else "right", no_wrap=True)
    return table


def _cell(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _picture(rows: Sequence[Row]) -> Figure:
    """Time over sampling rate, both logarithmic."""
    groups = _groups(rows)
    figure = Figure(figsize=(3.2 * len(groups) + 0.8, 3.6), layout="constrained")
    panels = figure.subplots(1, len(groups), sharey=True, squeeze=False)[0]
    counts = sorted({row.frames for row in rows})
    for axes, (name, tasks) in zip(panels, groups.items(), strict=True):
        for solver, mark in zip(_solvers(rows), "osd^", strict=False):
            times = {count: _middle(rows, tasks, count, solver, "seconds") for count in counts}
            known = {count: 1e3 * seconds for count, seconds in times.items() if seconds is not None}
            axes.loglog(list(known), list(known.values()), marker=mark, label=solver)
        axes.set_title(f"{name}, median" if len(tasks) > 1 else name)
        axes.set_xticks(counts, [str(count) for count in counts], minor=False)
        axes.set_xticks([], minor=True)
        axes.set_xlabel("frames a step")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("time of a verified gait in ms")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure
