"""`ggo verify`: a file checked."""

from __future__ import annotations

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import BONES, EDITED, GAPS, JSON, LEGS, OBSTACLES, Numbers
from ggo_factors.cli.loading import checked, comforts_of, load, load_beside, steps_of
from ggo_factors.cli.output import require_safe, show
from ggo_factors.evaluate.summary import summarize
from ggo_factors.motion.leg_model import Bones


@click.command()
@click.argument("file", metavar="FILE")
@LEGS
@BONES
@EDITED
@OBSTACLES
@GAPS
@click.option("--foothold", type=Numbers("X,Y"), help="Where the gait must land.")
@click.option("--base", help="Base gait, or gaits, to count the change from, and to put beside it in the report.")
@click.option("--report", is_flag=True, help="Say how the joints move: speed, acceleration, jerk; balance; clearance.")
@click.option("--limits", is_flag=True, help="Hold it to JointLimits; a walk made within limits is held to its own.")
@JSON
def verify(
    file: str,
    thigh: float | None,
    shank: float | None,
    bones: Bones | None,
    edited: bool,
    obstacles: tuple[ggo.Obstacle, ...],
    gaps: tuple[ggo.Gap, ...],
    foothold: tuple[float, float] | None,
    base: str | None,
    report: bool,
    limits: bool,
    as_json: bool,
) -> None:
    """Check a gait or a walk densely; a walk against the ground that its file states."""
    loaded = load(file, thigh, shank, edited, bones)
    if isinstance(loaded, ggo.Walk):
        if obstacles or gaps or foothold:
            raise ggo.InputError(f"{file}: a walk states its own ground; --obstacle, --gap, --foothold are for a gait")
        name, names = "walk", [f"step {number}" for number in range(1, len(loaded.gaits) + 1)]
    else:
        name = loaded.name or "gait"
        names = [name]
    beside = load_beside(base, loaded, thigh, shank, edited)
    asked = {"obstacles": obstacles, "gaps": gaps, "foothold": foothold, "limits": _limits(loaded) if limits else None}
    reports = checked(loaded, **asked)
    steps = steps_of(loaded)
    bases = beside or (None,) * len(steps)
    rows = [summarize(*row) for row in zip(names, steps, reports, bases, strict=True)]
    show(rows, as_json, comforts_of(name, loaded, beside, **asked) if report else ())
    require_safe(file, reports)


def _limits(loaded: ggo.Gait | ggo.Walk) -> ggo.JointLimits:
    """The limits that a walk was made within, or the default ones."""
    return (loaded.limits if isinstance(loaded, ggo.Walk) else None) or ggo.JointLimits()
