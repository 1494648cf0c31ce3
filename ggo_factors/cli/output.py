"""What the commands write and print, and which files they refuse."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import ggo_factors as ggo
from ggo_factors.evaluate.comfort import Comfort
from ggo_factors.evaluate.summary import StepSummary, summarize
from ggo_factors.support.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALKS = (".csv", ".mcap")
"""Endings of the walks that can be written."""
PICTURES = (".png", ".pdf", ".svg")
"""Endings of the pictures that can be written."""


def require_ending(output: str, endings: Sequence[str]) -> None:
    """Refuse a file to write whose name does not end as what it will hold.

    Raises:
        InputError: where it does not.
    """
    if Path(output).suffix.lower() not in endings:
        raise ggo.InputError(f"{output}: must end in {' or '.join(endings)}")


def require_safe(file: str, reports: Sequence[ggo.Report]) -> None:
    """Refuse a file whose gaits are not safe.

    Raises:
        InfeasibleGaitError: at the first step that is not.
    """
    for number, report in enumerate(reports, start=1):
        if not report.ok:
            faults = "; ".join(str(violation) for violation in report.violations)
            raise ggo.InfeasibleGaitError(f"{file}: step {number} is not safe: {faults}", report.violations)


def rows_of(walk: ggo.Walk, milliseconds: float) -> list[StepSummary]:
    """A line of the table for each step of a walk that was just made, in so many milliseconds each."""
    return [
        summarize(f"step {number}", made.gait, made.report, _bent_from(made), made, milliseconds)
        for number, made in enumerate(walk.steps, start=1)
    ]


def _bent_from(solution: ggo.Solution) -> ggo.Gait | None:
    """The base gait that a step was bent from."""
    return solution.task.base if isinstance(solution, ggo.StepSolution) else None


def show(rows: Sequence[StepSummary], as_json: bool, comforts: Sequence[Comfort] = ()) -> None:
    """Print a table of steps, and of how their joints move; or both as JSON."""
    if as_json:
        said: dict[str, Any] = {"format_version": 1, "steps": [row.to_json() for row in rows]}
        if comforts:
            said["comfort"] = [made.to_json() for made in comforts]
        click.echo(json.dumps(said, indent=1))
        return
    from ggo_factors.cli.console import comfort_tables, console, summary_table

    console().print(summary_table(rows), *(comfort_tables(comforts) if comforts else ()), sep="\n")


def write_walk(made: ggo.Walk | ggo.Plan, output: str) -> None:
    """Write a walk, or a plan with its walk, as what the file's name says, see `WALKS`."""
    if Path(output).suffix.lower() == ".mcap":
        ggo.export_mcap(made if isinstance(made, ggo.Walk) else made.walk, output)
    else:
        made.save(output)


def save_figure(drawn: Axes, output: str) -> None:
    """Write the figure of these axes, and close it."""
    from matplotlib import pyplot, rc_context

    from ggo_factors.plot import VECTOR_TEXT

    figure = drawn.get_figure(root=True)
    assert figure is not None  # it was just drawn
    with replacing(output) as temporary, rc_context(VECTOR_TEXT):
        figure.savefig(temporary, dpi=200, bbox_inches="tight")
    pyplot.close(figure)


def say_written(output: str | None, as_json: bool) -> None:
    """Say which file was written, where nothing but text was asked for."""
    if output is not None and not as_json:
        click.echo(f"wrote {output}")
