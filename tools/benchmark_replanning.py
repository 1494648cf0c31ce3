"""The benchmark of replanning: the rest of a step solved again, beside an incremental solver that changes its edges.

All ways have the same edges in the same rounds and start from the first gait. None makes edges stiffer, and none checks
the gait within the time that is measured.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Hashable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import click
import gtsam
import numpy as np
from benchmark_solving import FOOTHOLD, PAPER_OBSTACLES
from machine import stated, tell
from rich.table import Table
from rival_minimisers import factors, textbook
from rivals import OBSTACLE_MARGIN, Gains, Minimum, Problem, default_smoothness, least_hip_height, rounds

import ggo_factors as ggo
from ggo_factors.factors import frame_key
from ggo_factors.graph.optimizer import RELATIVE_TOLERANCE
from ggo_factors.support.inputs import Array

AGAIN, COLD, ISAM2, FULL = "ours, warm start", "ours, from the base gait", "ISAM2", "full graph, warm start"
MOST_UPDATES = 300


@dataclass(frozen=True)
class Case:
    """A step and its gait, the last frame that is walked, and what the step is to do now."""

    before: Problem
    step: ggo.Step
    gait: Array
    frame: int
    after: Problem
    now: ggo.Step


@dataclass(frozen=True)
class Row:
    """One way to replan one case; `off` is how much more, as a share, the motion costs than ours."""

    case: int
    frame: int
    solver: str
    seconds: float
    cpu_seconds: float
    iterations: int
    rounds: int
    cost: float
    off: float
    ok: bool


@click.command()
@click.option("--replans", type=click.IntRange(1), default=4, show_default=True, help="Seeded, of each of five gaits.")
@click.option("--frames", type=click.IntRange(21), default=51, show_default=True)
@click.option("--repeats", type=click.IntRange(1), default=3, show_default=True, help="Interleaved.")
@click.option("--json", "json_path", type=click.Path(path_type=Path), help="Write the numbers here too.")
def replanning(replans: int, frames: int, repeats: int, json_path: Path | None) -> None:
    """Replan steps in mid-air: solved again from the warm start, against ISAM2 with edges taken out and put in."""
    machine, base = stated(), ggo.paper_base_gait(frames)
    rows = [row for number, case in enumerate(_cases(base, replans)) for row in _measured(number, case, base, repeats)]
    table = Table(title=f"Replans in mid-step, {frames} frames: medians", title_justify="left")
    for heading in ("solver", "ms", "CPU ms", "ratio", "iter", "rounds", "most off", "ok"):
        table.add_column(heading, justify="left" if heading == "solver" else "right")
    summary = {}
    for solver in dict.fromkeys(row.solver for row in rows):
        mine = [row for row in rows if row.solver == solver]
        pairs = zip(mine, (row for row in rows if row.solver == AGAIN), strict=True)
        ratio = statistics.median(row.seconds / ours.seconds for row, ours in pairs)
        seconds, cpu, iterations, solves = (
            statistics.median(getattr(row, name) for row in mine)
            for name in ("seconds", "cpu_seconds", "iterations", "rounds")
        )
        off, ok = max((row.off for row in mine), key=abs), sum(row.ok for row in mine)
        summary[solver] = {"median_s": seconds, "ratio": ratio, "most_off": off}
        counts = (f"{iterations:g}", f"{solves:g}", f"{off:+.0e}", f"{ok} of {len(mine)}")
        table.add_row(solver, f"{seconds * 1e3:.1f}", f"{cpu * 1e3:.1f}", f"{ratio:.1f}", *counts)
    tell(table, machine, json_path, summary=summary, rows=[asdict(row) for row in rows])


def _cases(base: ggo.Gait, count: int) -> Iterator[Case]:
    """Each gait of the paper, its obstacle seen elsewhere before the foot has come to it, and another foothold."""
    model, random = base.legs(), np.random.default_rng(5)
    for box in PAPER_OBSTACLES.values():
        step = ggo.Step(FOOTHOLD, (box,))
        before = _problem(base, base.frames[:2], base.frames[0], step)
        gait = rounds(before, step, textbook)[-1].frames
        path = model.endpoint(gait)
        latest = int(np.flatnonzero(path[:, 0] < box.x_start)[-1]) if path[0, 0] < box.x_start else 0
        for _ in range(count):
            k = int(random.integers(2, max(latest - 4, 3)))
            forward, higher, further = random.uniform((0.0, -0.03, -0.02), (0.03, 0.02, 0.04)).tolist()
            seen = replace(box.shifted(-forward, 0.0), height=box.height + higher)
            now = ggo.Step((FOOTHOLD[0] + further, 0.0), (seen,))
            # The joints go on as fast as they move, as the offset from the base gait does.
            ahead = gait[k] + base.frames[k + 1] - base.frames[k] + np.diff((gait - base.frames)[k - 1 : k + 1], axis=0)
            given = np.concatenate([gait[: k + 1], ahead])
            yield Case(before, step, gait, k, _problem(base, given, gait[0], now), now)


def _problem(base: ggo.Gait, given: Array, start: Array, step: ggo.Step) -> Problem:
    model, landing = base.legs(), step.landing(base.legs())
    hip = least_hip_height(model, start, landing)
    gains = Gains(5.0 * len(base))
    return Problem(base.frames, model, given, landing, None, default_smoothness(len(base)), gains, hip)


def _measured(number: int, case: Case, base: ggo.Gait, repeats: int) -> list[Row]:
    makes: dict[str, Callable[[], Callable[[], tuple[Array, int, int]]]] = {
        AGAIN: lambda: partial(_again, case, base, case.gait[case.frame :]),
        COLD: lambda: partial(_again, case, base, None),
        ISAM2: lambda: partial(_on_full_graph, case, _Incremental(case)),
        FULL: lambda: partial(_on_full_graph, case, textbook),
    }
    times: dict[str, list[tuple[float, float]]] = {solver: [] for solver in makes}
    found = {}
    for turn in range(repeats + 1):
        for solver, make in makes.items():
            run = make()
            gc.collect()
            begin, cpu = time.perf_counter(), time.process_time()
            found[solver] = run()
            if turn:
                times[solver].append((time.perf_counter() - begin, time.process_time() - cpu))
    costs = {solver: _cost(base, frames) for solver, (frames, _, _) in found.items()}
    return [
        Row(
            case=number,
            frame=case.frame,
            solver=solver,
            seconds=statistics.median(wall for wall, _ in times[solver]),
            cpu_seconds=statistics.median(cpu for _, cpu in times[solver]),
            iterations=iterations,
            rounds=solves,
            cost=costs[solver],
            off=costs[solver] / costs[AGAIN] - 1.0,
            ok=ggo.verify(
                ggo.Gait(frames, base.dt),
                base.legs(),
                start=case.gait[0],
                obstacles=case.now.obstacles,
                foothold=case.now.foothold,
                ground=case.now.ground,
            ).ok,
        )
        for solver, (frames, iterations, solves) in found.items()
    ]


def _cost(base: ggo.Gait, frames: Array) -> float:
    offset = frames - base.frames
    first, second = (0.5 * float((np.diff(offset, n=order, axis=0) ** 2).sum()) for order in (1, 2))
    return first + default_smoothness(len(base)) * second


# -- the ways ---------------------------------------------------------------------------------------------------


def _again(case: Case, base: ggo.Gait, initial: Array | None) -> tuple[Array, int, int]:
    """The rest of the step as a gait graph of its own."""
    k, gains, problem = case.frame, case.after.gains, case.after
    graph = ggo.GaitGraph(replace(base, frames=base.frames[k:]), smoothness=problem.smoothness)
    graph.anchor(problem.given[k])
    graph.anchor(problem.given[k + 1], frame=1)
    graph.keep_hip_above(problem.hip)
    for box in case.now.obstacles:
        graph.add_obstacle(box, hold=gains.hold, gamma=gains.gamma, margin=OBSTACLE_MARGIN)
    graph.add_ground(case.now.ground, hold=gains.hold, gamma=gains.gamma)
    graph.end(problem.foothold, gain=gains.end)
    solution = graph.solve(initial=initial)
    return np.concatenate([case.gait[:k], solution.gait.frames]), solution.iterations, solution.rounds


def _on_full_graph(case: Case, minimise: Callable[[Problem, Array], Minimum]) -> tuple[Array, int, int]:
    minima = rounds(case.after, case.now, minimise, case.gait)
    return minima[-1].frames, sum(minimum.iterations for minimum in minima), len(minima)


class _Incremental:
    """ISAM2 on the full graph, as it is after the first gait: a problem changes its factors, and its values stay."""

    def __init__(self, case: Case) -> None:
        params = gtsam.ISAM2Params()
        params.setOptimizationParams(gtsam.ISAM2DoglegParams())
        params.setFactorization("QR")  # which constraints, the frames that are given, need
        params.setRelinearizeThreshold(1e-7)
        params.relinearizeSkip = 1
        self._isam, self._places, self._new = gtsam.ISAM2(params), dict[Hashable, int](), gtsam.Values()
        for n, frame in enumerate(case.gait):
            self._new.insert(frame_key(n), frame)
        rounds(case.before, case.step, self)

    def __call__(self, problem: Problem, _: Array) -> Minimum:
        wanted = factors(problem)
        # What pulled on single frames may go; motions between frames that are walked stay.
        gone = [key for key in self._places if key not in wanted and isinstance(key, tuple) and key[0] == "point"]
        graph, added = gtsam.NonlinearFactorGraph(), [key for key in wanted if key not in self._places]
        for key in added:
            graph.add(wanted[key]())
        result = self._isam.update(graph, self._new, [self._places.pop(key) for key in gone])
        self._new = gtsam.Values()
        self._places |= zip(added, result.getNewFactorsIndices(), strict=True)
        before, error, updates = np.inf, self._error(), 1
        while abs(before - error) > RELATIVE_TOLERANCE * error and updates < MOST_UPDATES:
            self._isam.update()
            before, error, updates = error, self._error(), updates + 1
        values = self._isam.calculateEstimate()
        return Minimum(np.stack([values.atVector(frame_key(n)) for n in range(len(problem.base))]), updates)

    def _error(self) -> float:
        return float(self._isam.getFactorsUnsafe().error(self._isam.calculateEstimate()))
