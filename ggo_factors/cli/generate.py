"""`ggo stride`, `step-over`, `stairs` and `walk`: gaits made, checked and written."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import FROM_STANDING, GAPS, GENERATE, OBSTACLES, TO_STANDING, NumberList, Numbers
from ggo_factors.cli.loading import asked_of, load_bases
from ggo_factors.cli.output import WALKS, require_ending, rows_of, say_written, show, write_walk
from ggo_factors.motion.base_gaits import both
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

    def make(gait: ggo.Gait | ggo.BaseGaits, how: dict[str, Any]) -> ggo.Walk:
        target = foothold or (float(both(gait).gait("level", how["first_swing"]).endpoints()[-1, 0]), 0.0)
        return ggo.walk(gait, [ggo.Step(target, obstacles, gaps)], **how)

    _generate(base, make, **rest)


@click.command()
@GENERATE
@click.argument("direction", type=click.Choice(["up", "down"]))
@click.option("--riser", type=NumberList(), default="0.10", show_default=True, help="Height of the risers, or of each.")
@click.option("--tread", type=float, default=0.39, show_default=True, help="Depth of the treads.")
@click.option("--first-edge", type=float, default=0.29, show_default=True, help="x of the first riser.")
@click.option("--steps", type=int, help="Number of steps; 2, or one a riser, if left out.")
@FROM_STANDING
@click.option("--from-walking", is_flag=True, help="Start out of a level step, as without a recorded first step.")
@click.option("--on-stairs", is_flag=True, help="Start in the middle of a flight, as BASE, --up or --down does.")
@TO_STANDING
def stairs(
    base: str,
    direction: str,
    riser: float | tuple[float, ...],
    tread: float,
    first_edge: float,
    steps: int | None,
    from_standing: bool,
    from_walking: bool,
    on_stairs: bool,
    to_standing: bool,
    **rest: Any,
) -> None:
    """Walk stairs up or down, foot over foot."""
    if from_standing + from_walking + on_stairs > 1:
        raise ggo.InputError("--from-standing, --from-walking, --on-stairs: one of them, a flight has one start")
    procedure: Callable[..., ggo.Walk] = ggo.climb_stairs if direction == "up" else ggo.descend_stairs
    where = {"tread": tread, "first_edge": first_edge, "steps": steps}
    ends = {"on_stairs": on_stairs, "to_standing": to_standing}

    def make(gait: ggo.Gait | ggo.BaseGaits, how: dict[str, Any]) -> ggo.Walk:
        start = ggo.STANDING if from_standing else None
        if from_walking:
            start = both(gait).gait("level", how["first_swing"]).frames[0]
        return procedure(gait, riser, start=start, **where, **ends, **how)

    _generate(base, make, **rest)


@click.command()
@GENERATE
@click.option(
    "--foothold",
    "footholds",
    type=Numbers("X[,Y]"),
    multiple=True,
    help="Landing of each step, from its supporting foot; with --terrain its x in TERRAIN's frame; repeatable.",
)
@click.option("--terrain", metavar="TERRAIN.toml", help="The ground along the way.")
@click.option("--at", type=float, default=0.0, help="x of the supporting ankle at the start in TERRAIN's frame.")
@OBSTACLES
@GAPS
@FROM_STANDING
@TO_STANDING
def walk(
    base: str,
    footholds: tuple[tuple[float, ...], ...],
    terrain: str | None,
    at: float,
    obstacles: tuple[ggo.Obstacle, ...],
    gaps: tuple[ggo.Gap, ...],
    from_standing: bool,
    to_standing: bool,
    **rest: Any,
) -> None:
    """Take several steps, on a terrain or on level ground, obstacles and gaps seen from where the walk starts."""
    start = ggo.STANDING if from_standing else None
    if terrain is not None:
        if obstacles or gaps or any(len(foothold) > 1 for foothold in footholds):
            raise ggo.InputError("--terrain: says where the ground, boxes and pits are; give --foothold X alone")
        ground, places = ggo.load_terrain(terrain), [foothold[0] for foothold in footholds]
        where: dict[str, Any] = {"terrain": ground, "at": at, "to_standing": to_standing, "start": start}
        _generate(base, lambda gait, how: ggo.walk(gait, places, **where, **how), **rest)
        return
    if any(len(foothold) == 1 for foothold in footholds):
        raise ggo.InputError("--foothold: without --terrain it is X,Y, from the supporting foot of its step")
    plan = [ggo.Step((foothold[0], foothold[1])) for foothold in footholds]
    if to_standing:
        plan.append(ggo.Step(end_frame=tuple(ggo.STANDING.tolist())))

    def make(gait: ggo.Gait | ggo.BaseGaits, how: dict[str, Any]) -> ggo.Walk:
        return ggo.walk(gait, across(plan, gait.legs(), obstacles, gaps), start=start, **how)

    _generate(base, make, **rest)


def _generate(
    base: str,
    make: Callable[[ggo.Gait | ggo.BaseGaits, dict[str, Any]], ggo.Walk],
    *,
    thigh: float | None,
    shank: float | None,
    bones: Bones | None,
    edited: bool,
    up: str | None,
    down: str | None,
    first_swing: str,
    frames: int | None,
    smoothness: float | None,
    hard: bool,
    limits: bool,
    pace: float | str | None,
    step_time: float | None,
    deadline: float | None,
    balance: float | None,
    style: str | None,
    output: str | None,
    as_json: bool,
) -> None:
    gait = load_bases(base, thigh, shank, edited, bones, {"up": up, "down": down})
    if output is not None:
        require_ending(output, WALKS)
    if frames is not None:
        gait = gait.resampled(frames)
    if step_time is not None:
        pace = _pace_of(gait, step_time, pace)
    asked = asked_of(hard, limits, pace, balance, style, first_swing)
    began = time.perf_counter()
    made = make(gait, {"smoothness": smoothness, "deadline": deadline, **asked})
    spent = (time.perf_counter() - began) * 1e3 / len(made.steps)
    rows = rows_of(made, spent)
    if output is not None:
        write_walk(made, output)
    show(rows, as_json)
    say_written(output, as_json)


def _pace_of(base: ggo.Gait | ggo.BaseGaits, step_time: float, pace: float | str | None) -> float:
    """The pace at which a step takes so many seconds."""
    if pace is not None:
        raise ggo.InputError("--pace and --step-time: give one of them")
    several = both(base)
    duration = (several.left.duration + several.right.duration) / 2.0
    if not step_time >= duration * (1.0 - 1e-9):
        raise ggo.InputError(f"--step-time: {step_time:g} s is shorter than a step of BASE, {duration:.4g} s")
    return min(1.0, duration / step_time)
