"""`ggo report`: a file checked, as a page that a clinician can open."""

from __future__ import annotations

import json

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import BONES, EDITED, LEGS
from ggo_factors.cli.loading import checked, comforts_of, load, load_beside
from ggo_factors.cli.output import require_ending, require_safe, say_written
from ggo_factors.motion.leg_model import Bones
from ggo_factors.support.files import write_text


@click.command()
@click.argument("file", metavar="FILE")
@LEGS
@BONES
@EDITED
@click.option("--base", help="Base gait to put beside it; of several each step's own.")
@click.option("--limits", is_flag=True, help="Hold it to JointLimits; a walk made within limits is held to its own.")
@click.option("-o", "--output", type=click.Path(), help="Page to write, HTML; it needs no other file, and no network.")
@click.option("--json", "as_json", is_flag=True, help="Print the numbers of the page as JSON.")
def report(
    file: str,
    thigh: float | None,
    shank: float | None,
    bones: Bones | None,
    edited: bool,
    base: str | None,
    limits: bool,
    output: str | None,
    as_json: bool,
) -> None:
    """Check a gait or a walk, and write what was seen as one page: animation, angles, speeds, landings, checks.

    The page is written whatever the check says; where it is not safe the exit code is 3.
    """
    if output is not None:
        require_ending(output, (".html", ".htm"))
    elif not as_json:
        raise ggo.InputError("--output: give the page to write, or --json")
    from ggo_factors.page.html import report_page
    from ggo_factors.page.numbers import Subject, report_numbers

    loaded = load(file, thigh, shank, edited, bones)
    beside = load_beside(base, loaded, thigh, shank, edited)
    held = loaded.limits if isinstance(loaded, ggo.Walk) else None
    if held is None and limits:
        held = ggo.JointLimits()
    reports, comforts = checked(loaded, limits=held), comforts_of(file, loaded, beside)
    numbers = report_numbers(Subject(loaded, reports, tuple(comforts), held, file, beside or (), base), ggo.__version__)
    if output is not None:
        write_text(output, report_page(numbers))
    if as_json:
        click.echo(json.dumps(numbers, indent=1))
    say_written(output, as_json)
    require_safe(file, reports)
