"""`ggo stride`, `step-over`, `stairs` and `walk`: gaits made, checked and written."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import GAPS, GENERATE, OBSTACLES, NumberList, Numbers
from ggo_factors.cli.loading import load_base
from ggo_factors.cli.output import require_ending, say_written, show
from ggo_factors.evaluate.summary import summarize
from ggo_factors.motion.leg_model import Bones
from ggo_factors.walking.step import across


@click.command()
@GENERATE
@click.option("--stride", type=float, help="Travel of the swinging foot; that of BASE, or past the gaps, if left out.")
@click.option("--steps", type=int, default=2, show_default=True, help="Number of steps.")
@GAPS
def stride(base: str, stride: float | None, steps: int, gaps: tuple[ggo.Gap, ...], **rest: Any) -> None:
    """Walk with another stride; step over pits."""
    _generate(base, lambda gait, how: ggo.adjust_stride(gait, stride, gaps=gaps, steps=steps, **how), **rest)


@click.command("step-over")
@GENERATE
@OBSTACLES
@GAPS
@click.option("--foothold", type=Numbers("X,Y"), help="Where to land; where BASE lands, on the ground, if left out.")
def step_over(
    base: str,
    obstacles: tuple[ggo.Obstacle, ...],
    gaps: tuple[ggo.Gap, ...],
    foothold: tuple[float, float] | None,
    **rest: Any,
) -> None:
    """Take one step over obstacles."""

    def make(gait: ggo.Gait, how: dict[str, Any]) -> ggo.Walk:
        target = foothold or (float(gait.endpoints()[-1, 0]), 0.0)
        return ggo.walk(gait, [ggo.Step(target, obstacles, gaps)], **how)

    _generate(base, make, **rest)


@click.command()
@GENERATE
@click.argument("direction", type=click.Choice(["up", "down"]))
@click.option("--riser", type=NumberList(), default="0.10", show_default=True, help="Height of the risers, or of each.")
@click.option("--tread", type=float, default=0.39, show_default=True, help="Depth of the treads.")
@click.option("--first-edge", type=float, default=0.29, show_default=True, help="x of the first riser.")
@click.option("--steps", type=int, help="Number of steps; 2, or one a riser, if left out.")
def stairs(
    base: str,
    direction: str,
    riser: float | tuple[float, ...],
    tread: float,
    first_edge: float,
    steps: int | None,
    **rest: Any,
) -> None:
    """Walk stairs up or down, foot over foot."""
    procedure: Callable[..., ggo.Walk] = ggo.climb_stairs if direction == "up" else ggo.descend_stairs
    _generate(
        base, lambda gait, how: procedure(gait, riser, tread=tread, first_edge=first_edge, steps=steps, **how), **rest
    )


@click.command()
@GENERATE
@click.option("--foothold", "footholds", type=Numbers("X,Y"), multiple=True, help="Landing of each step; repeatable.")
@OBSTACLES
@GAPS
@click.option("--from-standing", is_flag=True, help="Start with the feet together, legs straight.")
@click.option("--to-standing", is_flag=True, help="Close with one more step, feet together.")
def walk(
    base: str,
    footholds: tuple[tuple[float, float], ...],
    obstacles: tuple[ggo.Obstacle, ...],
    gaps: tuple[ggo.Gap, ...],
    from_standing: bool,
    to_standing: bool,
    **rest: Any,
) -> None:
    """Take several steps on level ground, obstacles and gaps seen from where the walk starts."""
    plan = [ggo.Step(foothold) for foothold in footholds]
    if to_standing:
        plan.append(ggo.Step(end_frame=tuple(ggo.STANDING.tolist())))
    start = ggo.STANDING if from_standing else None

    def make(gait: ggo.Gait, how: dict[str, Any]) -> ggo.Walk:
        return ggo.walk(gait, across(plan, gait.legs(), obstacles, gaps), start=start, **how)

    _generate(base, make, **rest)


def _generate(
    base: str,
    make: Callable[[ggo.Gait, dict[str, Any]], ggo.Walk],
    *,
    thigh: float | None,
    shank: float | None,
    bones: Bones | None,
    edited: bool,
    frames: int | None,
    smoothness: float | None,
    hard: bool,
    limits: bool,
    balance: float | None,
    style: str | None,
    output: str | None,
    as_json: bool,
) -> None:
    gait = load_base(base, thigh, shank, edited, bones)
    if output is not None:
        require_ending(output, (".csv", ".mcap"))
    if frames is not None:
        gait = gait.resampled(frames)
    began = time.perf_counter()
    bounds = ggo.JointLimits() if limits else None
    varied = None if style is None else ggo.load_style(style)
    how = {"smoothness": smoothness, "hard": hard, "limits": bounds, "balance": balance, "style": varied}
    made = make(gait, how)
    spent = (time.perf_counter() - began) * 1e3 / len(made.steps)
    rows = [
        summarize(f"step {number}", solution.gait, solution.report, gait, solution, spent)
        for number, solution in enumerate(made.steps, start=1)
    ]
    if output is not None:
        if Path(output).suffix.lower() == ".mcap":
            ggo.export_mcap(made, output)
        else:
            made.save(output)
    show(rows, as_json)
    say_written(output, as_json)
