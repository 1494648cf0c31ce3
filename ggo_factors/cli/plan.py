"""`ggo plan`: footholds over a terrain, and the checked walk over them."""

from __future__ import annotations

import json
import time
from typing import get_args

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import ALIKE, BENT, FROM_STANDING, JSON, KEPT, TO_STANDING, WALK
from ggo_factors.cli.loading import asked_of, load_bases
from ggo_factors.cli.output import PICTURES, WALKS, require_ending, rows_of, save_figure, say_written, show, write_walk
from ggo_factors.motion.leg_model import Bones
from ggo_factors.planning.people import Prefer
from ggo_factors.planning.plan import furthest_goal


@click.command()
@click.argument("terrain", metavar="TERRAIN.toml")
@click.argument("base", metavar="BASE")
@click.option("--goal", type=float, help="x of the last foothold; as far as TERRAIN goes if left out.")
@click.option("--at", type=float, default=0.0, show_default=True, help="x of the supporting ankle at the start.")
@click.option(
    "--prefer",
    type=click.Choice(get_args(Prefer)),
    default="least_change",
    show_default=True,
    help="Change the base gait little, or place and lift feet at boxes as people do.",
)
@FROM_STANDING
@TO_STANDING
@BENT
@KEPT
@ALIKE
@WALK
@click.option("--picture", type=click.Path(), help="Draw the plan: PNG, PDF or SVG by its ending.")
@JSON
def plan(
    terrain: str,
    base: str,
    goal: float | None,
    at: float,
    prefer: Prefer,
    from_standing: bool,
    to_standing: bool,
    thigh: float | None,
    shank: float | None,
    bones: Bones | None,
    edited: bool,
    up: str | None,
    down: str | None,
    first_swing: str,
    frames: int | None,
    hard: bool,
    limits: bool,
    pace: float | str | None,
    balance: float | None,
    style: str | None,
    output: str | None,
    picture: str | None,
    as_json: bool,
) -> None:
    """Choose footholds over a terrain to a goal, and walk there.

    All places are in TERRAIN's frame: x forward, y up, in metres.
    """
    if output is not None:
        require_ending(output, WALKS)
    if picture is not None:
        require_ending(picture, PICTURES)
    ground = ggo.load_terrain(terrain)
    gait = load_bases(base, thigh, shank, edited, bones, {"up": up, "down": down})
    if frames is not None:
        gait = gait.resampled(frames)
    from ggo_factors.cli.console import progress_bar

    asked = asked_of(hard, limits, pace, balance, style, first_swing)
    began = time.perf_counter()
    with progress_bar("planning") as progress:
        made = ggo.plan_walk(
            gait,
            ground,
            goal=furthest_goal(ground, gait.legs()) if goal is None else goal,
            at=at,
            to_standing=to_standing,
            prefer=prefer,
            start=ggo.STANDING if from_standing else None,
            progress=progress,
            **asked,
        )
    spent = (time.perf_counter() - began) * 1e3 / len(made.walk.steps)
    if output is not None:
        write_walk(made, output)
    if picture is not None:
        from ggo_factors.plot import plot_plan

        save_figure(plot_plan(made), picture)
    rows = rows_of(made.walk, spent)
    if as_json:
        steps = [row.to_json() for row in rows]
        click.echo(json.dumps({"format_version": 1, "plan": made.to_json(), "steps": steps}, indent=1))
    else:
        show(rows, False)
        footholds = ", ".join(f"{place:.3f}" for place in made.footholds)
        click.echo(f"footholds at x = {footholds} m; {len(made.banned)} steps refused on the way to this plan")
        for ban in made.banned:
            click.echo(f"refused: {ban}")
    say_written(output, as_json)
    say_written(picture, as_json)
