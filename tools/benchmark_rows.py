"""What the benchmark of solving measured: rows, grouped and judged."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

OURS, FIRST_ORDER = "ggo_factors", "ours, first order"
# What the finished library is to reach: rival, tasks, frames, how many times faster.
GOALS = (
    ("textbook", "obstacle", 51, 5.0),
    ("SciPy", "obstacle", 51, 3.0),
    ("pyceres", "obstacle", 51, 1.0),
    ("textbook", "stride", 51, 8.0),
)
FLAT_FROM, FLAT_TO, FLAT_GOAL = 101, 1601, 1.5
SMOOTH_AT, SMOOTH_GOAL = 51, 1.5
OFF_GOAL = 0.01  # of the residual cost, above `FLAT_FROM` frames, where the library solves fewer


@dataclass(frozen=True)
class Row:
    """One solver at one task and sampling rate; `seconds` is the median of the repeats, `ratio` that over ours.

    The same by CPU time, which a busy machine disturbs less, but which counts every thread that SciPy's dense algebra
    keeps busy. Costs are of the finished frames, computed alike for everyone; `off` is how much more, as a share, the
    motion between frames costs than ours does.
    """

    task: str
    frames: int
    smoothness: float
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
    smoothness_cost: float
    off: float
    ok: bool


def groups(rows: Sequence[Row]) -> dict[str, tuple[str, ...]]:
    """Tasks shown together: the obstacles as one, by the median."""
    names = dict.fromkeys(row.task for row in rows)
    boxes = tuple(name for name in names if name.startswith("obstacle"))
    groups = {("obstacles" if name in boxes else name): (name,) for name in names}
    return {**groups, **({"obstacles": boxes} if boxes else {})}


def middle(rows: Sequence[Row], tasks: Sequence[str], count: int, solver: str, value: str) -> float | None:
    """The median over tasks, or None where one of them was not run."""
    found = [row for row in rows if row.task in tasks and row.frames == count and row.solver == solver]
    return statistics.median(getattr(row, value) for row in found) if found and len(found) == len(tasks) else None


def judged(rows: Sequence[Row]) -> list[dict[str, object]]:
    """Each goal that these rows can tell of, what was reached by wall and CPU time, and whether that is enough."""
    found: list[dict[str, object]] = []

    def judge(what: str, ratios: tuple[float, float] | None, goal: float, more: bool) -> None:
        if ratios is not None:
            met = ratios[0] >= goal if more else ratios[0] <= goal
            found.append({"what": what, "ratio": ratios[0], "cpu_ratio": ratios[1], "goal": goal, "met": met})

    every = groups(rows)
    for rival, kind, count, goal in GOALS:
        tasks = next((tasks for name, tasks in every.items() if name.startswith(kind)), ())
        what = f"{kind}, {count} frames: times faster than {rival}"
        judge(what, _over(rows, tasks, (count, rival), (count, OURS)), goal, more=True)
    for name, tasks in every.items():
        what = f"{name}: time at {FLAT_TO} frames over time at {FLAT_FROM}"
        judge(what, _over(rows, tasks, (FLAT_TO, OURS), (FLAT_FROM, OURS)), FLAT_GOAL, more=False)
    for name, tasks in every.items():
        what = f"{name}, {SMOOTH_AT} frames: time with second-order edges over time without"
        judge(what, _over(rows, tasks, (SMOOTH_AT, OURS), (SMOOTH_AT, FIRST_ORDER)), SMOOTH_GOAL, more=False)
    off = [abs(ours.residual_cost / full.residual_cost - 1.0) for ours, full in _beside_full(rows)]
    for name, share in (("median", statistics.median(off)), ("worst", max(off))) if off else ():
        what = f"above {FLAT_FROM} frames: residual cost off the full graph's, {name}"
        found.append({"what": what, "ratio": share, "cpu_ratio": None, "goal": OFF_GOAL, "met": share <= OFF_GOAL})
    return found


def _beside_full(rows: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Ours and the full graph, wherever both were run at a high sampling rate."""
    at = {(row.task, row.frames, row.solver): row for row in rows if row.frames > FLAT_FROM}
    return [
        (ours, at[task, count, "textbook"])
        for (task, count, solver), ours in at.items()
        if solver == OURS and (task, count, "textbook") in at
    ]


def _over(
    rows: Sequence[Row], tasks: Sequence[str], slow: tuple[int, str], fast: tuple[int, str]
) -> tuple[float, float] | None:
    """Ratio of two solvers, each with its frames, by wall and CPU time: the median over tasks, if all were run."""
    at = {(row.task, row.frames, row.solver): row for row in rows}
    pairs = [(at.get((task, *slow)), at.get((task, *fast))) for task in tasks]
    known = [(one, other) for one, other in pairs if one and other]
    if not known or len(known) < len(pairs):
        return None
    return (
        statistics.median(one.seconds / other.seconds for one, other in known),
        statistics.median(one.cpu_seconds / other.cpu_seconds for one, other in known),
    )
