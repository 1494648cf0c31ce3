"""What the benchmark of solving measured, as tables and a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from benchmark_rows import FIRST_ORDER, OURS, Row, groups, middle
from matplotlib.figure import Figure
from rich.table import Table


def _solvers(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row.solver for row in rows))


def ratio_table(rows: Sequence[Row], stopped: Mapping[tuple[str, str], int], budget: float) -> Table:
    """How many times as long as ours each of the others takes."""
    solvers = [solver for solver in _solvers(rows) if solver != OURS]
    title = f"How many times as long the others take; none further than where one call took more than {budget:g} s"
    table = _table(title, ("task", "frames", *solvers, "ours ms"))
    for name, tasks in groups(rows).items():
        for count in dict.fromkeys(row.frames for row in rows):
            cells = []
            for solver in solvers:
                ratio = middle(rows, tasks, count, solver, "ratio")
                over = any(stopped.get((task, solver), count) < count for task in tasks)
                cells.append("stopped" if over else _cell(ratio, ".1f"))
            seconds = middle(rows, tasks, count, OURS, "seconds")
            shown = f"{name}, median" if len(tasks) > 1 else name
            table.add_row(shown, str(count), *cells, _cell(None if seconds is None else seconds * 1e3, ".1f"))
    return table


def goals_table(judged: Sequence[Mapping[str, object]]) -> Table:
    """The goals and what was reached."""
    table = _table("Goals", ("what", "ratio", "by CPU time", "goal", "met"))
    for each in judged:
        cpu = "" if each["cpu_ratio"] is None else f"{each['cpu_ratio']:.2f}"
        numbers = (f"{each['ratio']:.3g}", cpu, f"{each['goal']:g}")
        table.add_row(str(each["what"]), *numbers, "yes" if each["met"] else "no")
    return table


def absolute_table(rows: Sequence[Row]) -> Table:
    """Every row in numbers."""
    costs = ("residual", "smoothness", "off")
    table = _table(
        "Medians. Costs of the finished frames, computed alike for all; off: how much more than ours, as a share",
        ("task", "frames", "solver", "ms", "repeats", "iter", "rounds", "keys", "clear mm", *costs, "ok"),
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
            f"{row.smoothness_cost:.4e}",
            "" if row.solver in (OURS, FIRST_ORDER) else f"{row.off:+.0e}",
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


def picture(rows: Sequence[Row]) -> Figure:
    """Time over sampling rate, both logarithmic."""
    every = groups(rows)
    figure = Figure(figsize=(3.2 * len(every) + 0.8, 3.6), layout="constrained")
    panels = figure.subplots(1, len(every), sharey=True, squeeze=False)[0]
    counts = sorted({row.frames for row in rows})
    for axes, (name, tasks) in zip(panels, every.items(), strict=True):
        for solver, mark in zip(_solvers(rows), "ovsd^", strict=False):
            times = {count: middle(rows, tasks, count, solver, "seconds") for count in counts}
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
