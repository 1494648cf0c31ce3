"""`ggo compare`: gaits beside what a person did in a recording."""

from __future__ import annotations

import json

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import EDITED, JSON, LARGEST_CHUNK, LEGS, RECORDING, STYLE
from ggo_factors.cli.loading import legs_of, load_bases, require_log
from ggo_factors.cli.output import PICTURES, require_ending, save_figure, say_written

OWN = "own"
"""What BASE is called that is made of the steps that are skipped."""


@click.command()
@click.argument("base", metavar="BASE")
@click.argument("log", type=click.Path())
@RECORDING
@click.option("--skip", type=int, default=0, show_default=True, help="Steps at the beginning that are not compared.")
@LEGS
@EDITED
@STYLE
@click.option("-o", "--output", type=click.Path(), help="Draw the errors over the step: PNG, PDF or SVG.")
@LARGEST_CHUNK
@JSON
def compare(
    base: str,
    log: str,
    topic: str | None,
    joints: str | None,
    unit: str | None,
    activity: str,
    skip: int,
    thigh: float | None,
    shank: float | None,
    edited: bool,
    style: str | None,
    output: str | None,
    largest_chunk: int,
    as_json: bool,
) -> None:
    """Compare gaits with what a person did in a recording.

    Each step of LOG beside what is made of BASE for its start frame, the motion there, and its foothold: by the library
    (ggo), by the graph of the paper, by BASE moved to the start (no change), by fading that offset out, and by rivals
    in closed form. Errors are in degrees over frames and joints, at equal shares of the step.

    BASE may hold several gaits: each step is compared with that of the leg that swings, on stairs with that for stairs.

    BASE may be the word `own`: gaits made of the first steps of LOG, those that --skip leaves out, one for each leg.
    From 12 such steps on a style is learned from them too, and the library's gaits made with it as well (ggo style); of
    other gaits they are with --style.
    """
    from ggo_factors.cli.console import comparison_lines, console, progress_bar

    require_log(log)
    if output is not None:
        require_ending(output, PICTURES)
    gait = None if base == OWN else load_bases(base, thigh, shank, edited)
    model = legs_of(None, thigh, shank) if gait is None else gait.legs()
    with progress_bar("comparing") as progress:
        made = ggo.compare(
            gait,
            log,
            topic=topic,
            joints=joints,
            unit=unit,
            model=model,
            activity=activity,
            skip=skip,
            progress=progress,
            largest_chunk=largest_chunk,
            style=None if style is None else ggo.load_style(style),
        )
    if not made.counted:
        reason = next(reason for step in made.steps for reason in step.refused.values())
        raise ggo.InfeasibleGaitError(f"{log}: {len(made.steps)} steps, none with a gait by every method: {reason}")
    if output is not None:
        from ggo_factors.plot import plot_comparison

        save_figure(plot_comparison(made)[0], output)
    if as_json:
        click.echo(json.dumps(made.to_json(), indent=1, allow_nan=False))
    else:
        console().print(*comparison_lines(made), sep="\n")
    say_written(output, as_json)
