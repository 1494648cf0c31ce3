"""Many gaits: procedures called with many sets of arguments, on all processors or on a cluster."""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ggo_factors.errors import InfeasibleGaitError, InputError, Violation
from ggo_factors.evaluate.metrics import mean_joint_change
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.base_gaits import BaseGaits, both
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.procedures.stairs import climb_stairs, descend_stairs
from ggo_factors.procedures.steps import adjust_stride, step_over, walk
from ggo_factors.procedures.task import StepSolution
from ggo_factors.support.data_frame import pandas
from ggo_factors.support.inputs import Array, as_array, as_instance, as_progress, as_tuple_of
from ggo_factors.sweeps.workers import run

if TYPE_CHECKING:
    from distributed import Client

Progress = Callable[[float], None]

PROCEDURES: Mapping[str, Callable[..., Any]] = {
    procedure.__name__: procedure for procedure in (step_over, walk, adjust_stride, climb_stairs, descend_stairs)
}
WORKER_DIED = "WorkerDied"
"""The `error` of a row whose task killed every process that it was given to."""


@dataclass(frozen=True, eq=False)
class Task:
    """One call of a procedure of this library, described so that another process can make it.

    Attributes:
        procedure: its name, for example ``"step_over"``.
        arguments: its arguments by name, all but `base`; an iterator is read once and kept as a tuple.

    Raises:
        InputError: where there is no such procedure, or it takes no such arguments.
    """

    procedure: str
    arguments: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.procedure, str) or self.procedure not in PROCEDURES:
            raise InputError(f"procedure: {self.procedure!r:.80} is not known; {', '.join(PROCEDURES)}")
        try:
            # An iterator can be read once, but a task may be run again and must travel to its worker.
            given = {**self.arguments}
            kept = {name: tuple(value) if isinstance(value, Iterator) else value for name, value in given.items()}
            object.__setattr__(self, "arguments", kept)
            inspect.signature(PROCEDURES[self.procedure]).bind(None, **self.arguments)
        except TypeError as error:
            raise InputError(f"{self.procedure}: {error}") from error


@dataclass(frozen=True, eq=False)
class Row:
    """The result of one task: a gait in numbers, or why there is none. Of several steps the worst counts.

    Attributes:
        ok: whether there is a gait; it was checked as every gait of the procedures is.
        error: class of the error, for example ``"InfeasibleGaitError"``; "" where there is a gait.
        reason: what the error says; "" where there is a gait.
        violations: every limit that the best gait found breaks.
        iterations: of the solver, over all steps; 0 where there is no gait.
        milliseconds: time taken to make and check it, or to refuse it.
        foothold_error: distance of the landing swing ankle from its foothold in [m]; without a gait this and all that
            follows is NaN.
        clearance: least height of the swing ankle over the obstacles in [m]; infinite where it crosses none.
        ground_clearance: least height of the swing ankle over the ground, away from the footholds, in [m].
        knee: least knee angle in [rad].
        change: mean absolute change of each joint from the base gait in [rad], shape (4,).
        frames: the gait itself in [rad], shape (steps, m, 4), where asked for; else None. Base gaits of other legs or
            ground last longer: steps that have fewer frames than the longest of them are resampled.
    """

    ok: bool
    error: str = ""
    reason: str = ""
    violations: tuple[Violation, ...] = ()
    iterations: int = 0
    milliseconds: float = math.nan
    foothold_error: float = math.nan
    clearance: float = math.nan
    ground_clearance: float = math.nan
    knee: float = math.nan
    change: tuple[float, ...] = (math.nan,) * 4
    frames: Array | None = None

    def to_json(self) -> dict[str, Any]:
        """The same in lists and plain numbers, bit for bit; NaN and infinity stay such."""
        numbers = {name: getattr(self, name) for name in self.__dataclass_fields__}
        numbers["violations"] = [asdict(violation) for violation in self.violations]
        numbers["frames"] = None if self.frames is None else self.frames.tolist()
        return numbers

    @classmethod
    def from_json(cls, given: Mapping[str, Any]) -> Row:
        """The row that `to_json` described.

        Raises:
            InputError: where it does not describe one.
        """
        try:
            frames = given["frames"]
            return cls(
                ok=as_instance(given["ok"], "ok", bool),
                error=as_instance(given["error"], "error", str),
                reason=as_instance(given["reason"], "reason", str),
                violations=tuple(Violation(**violation) for violation in given["violations"]),
                iterations=as_instance(given["iterations"], "iterations", int),
                change=tuple(as_instance(value, "change", float) for value in given["change"]),
                frames=None if frames is None else as_array(frames, "frames", (None, None, 4)),
                **{name: as_instance(given[name], name, float) for name in _NUMBERS},
            )
        except (KeyError, TypeError) as error:
            raise InputError(f"not a row: {type(error).__name__}: {error}") from error


class Rows(list[Row]):
    """The rows of many tasks, a list."""

    def to_dataframe(self) -> Any:
        """A `pandas.DataFrame` with a row for each task.

        Columns: those of `Row` but `frames`, in [m], [rad] and [ms]; `violations` as the kinds that are broken, and
        `change` as a column for each joint.

        Raises:
            ImportError: where pandas is not installed.
        """
        told = []
        for row in self:
            numbers = {name: getattr(row, name) for name in row.__dataclass_fields__ if name != "frames"}
            numbers["violations"] = ", ".join(dict.fromkeys(violation.kind for violation in row.violations))
            changes = zip(JOINTS, numbers.pop("change"), strict=True)
            told.append({**numbers, **{f"change_{joint}": value for joint, value in changes}})
        return pandas().DataFrame(told)


_NUMBERS = ("milliseconds", "foothold_error", "clearance", "ground_clearance", "knee")


def generate_many(
    tasks: Sequence[Task],
    base: Gait | BaseGaits,
    *,
    model: LegModel | None = None,
    workers: int | None = None,
    client: Client | None = None,
    progress: Progress | None = None,
    keep_frames: bool = False,
    style: Style | None = None,
) -> Rows:
    """Call a procedure for each task. A call that fails gives a row that says why.

    The rows are the same, bit for bit, with any number of workers.

    Args:
        tasks: the calls to make.
        base: the base gait of all calls, or gaits for each leg and for stairs.
        model: the legs of tasks that name none; the base gait's own if None.
        workers: number of processes on this machine; one for each processor if None. A script that uses more than one
            must call this under ``if __name__ == "__main__":``.
        client: a `dask.distributed.Client` of a cluster to use instead; its workers need this library too.
        progress: called with the fraction that is done, 0 to 1.
        keep_frames: whether the rows hold the gaits themselves.
        style: how a person varies steps, for tasks that name none; see `step_over`.

    Returns:
        A row for each task, in their order; `to_dataframe` makes them a table.

    Raises:
        InputError: where an argument is unusable; an unusable argument of a task gives a row instead.
        GgoError: where workers cannot start, or the cluster refuses the work.
    """
    progress = as_progress(progress)
    asked = as_tuple_of(tasks, "tasks", Task)
    rows: list[Row | None] = [None] * len(asked)
    done = 0
    with closing(make_rows(asked, base, model, style, workers, client, keep_frames)) as batches:
        for batch in batches:
            for number, row in batch:
                rows[number] = row
            done += len(batch)
            if progress is not None:
                progress(done / len(asked))
    return Rows(row for row in rows if row is not None)


def make_rows(
    tasks: Sequence[Task],
    base: Gait | BaseGaits,
    model: LegModel | None,
    style: Style | None,
    workers: int | None,
    client: Client | None,
    keep_frames: bool,
) -> Generator[list[tuple[int, Row]], None, None]:
    """The row of each task with its number, in the order they are finished; arguments and errors as `generate_many`."""
    both(base)
    if model is not None:
        as_instance(model, "model", LegModel)
    given = {"model": model, "style": None if style is None else as_instance(style, "style", Style)}
    return run(partial(_rows_of, base, given, keep_frames), tasks, _died, workers, client)


def _rows_of(base: Gait | BaseGaits, given: Mapping[str, Any], keep_frames: bool, tasks: list[Task]) -> list[Row]:
    return [_row_of(base, given, keep_frames, task) for task in tasks]


def _row_of(base: Gait | BaseGaits, given: Mapping[str, Any], keep_frames: bool, task: Task) -> Row:
    """The row of a task; `given` are the arguments that it may leave out."""
    began = time.perf_counter()
    try:
        made = PROCEDURES[task.procedure](base, **{**given, **task.arguments})
        row = _described((made,) if isinstance(made, Solution) else made.steps, frames_of(base) if keep_frames else 0)
    except Exception as error:  # whatever it is, the other rows must be made
        violations = error.violations if isinstance(error, InfeasibleGaitError) else ()
        row = Row(False, type(error).__name__, str(error), violations)
    return replace(row, milliseconds=(time.perf_counter() - began) * 1e3)


def frames_of(base: Gait | BaseGaits) -> int:
    """How many frames each step of a row has: as many as the longest of the base gaits."""
    return max(map(len, both(base).gaits))


def _described(steps: Sequence[Solution], kept: int) -> Row:
    """The row of these steps, with `kept` frames of each, or none."""
    reports = [step.report for step in steps]
    made = [step for step in steps if isinstance(step, StepSolution)]
    changes = np.mean([mean_joint_change(step.gait, step.task.base) for step in made], axis=0)
    frames = np.stack([_in_frames(step.gait, kept) for step in steps]) if kept else None
    return Row(
        ok=True,
        iterations=sum(step.iterations for step in steps),
        foothold_error=max(report.foothold_error for report in reports),
        clearance=min(report.clearance for report in reports),
        ground_clearance=min(report.ground_clearance for report in reports),
        knee=min(report.knee for report in reports),
        change=tuple(changes.tolist()),
        frames=None if frames is None else as_array(frames, "frames", (None, None, 4)),
    )


def _in_frames(gait: Gait, count: int) -> Array:
    return (gait if len(gait) == count else gait.resampled(count)).frames


def _died(task: Task) -> Row:
    return Row(False, WORKER_DIED, f"the process that ran {task.procedure} died, each time that it was tried")
