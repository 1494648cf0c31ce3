"""`ggo sweep`: a grid of gaits into one netCDF file."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, TypeVar

import click
import numpy as np

from ggo_factors.cli.flags import BONES, EDITED, STAIR_GAITS, STYLE
from ggo_factors.cli.loading import named_bases, with_bones
from ggo_factors.motion.leg_model import Bones
from ggo_factors.motion.style import load_style
from ggo_factors.sweeps.grid import Grid
from ggo_factors.sweeps.netcdf import outcome
from ggo_factors.sweeps.netcdf import sweep as make_sweep

DIGITS = 12
"""Values of a range are rounded to so many digits: 0.1:0.2:3 then holds 0.15, and not 0.15000000000000002."""
MOST_VALUES = 100_000
"""A range of more values is refused: it is surely a mistake, and would fill the memory."""

Command = TypeVar("Command", bound=Callable[..., Any])


class Values(click.ParamType[Any]):
    """Numbers and ranges, comma-separated; a range has both its ends."""

    name = "VALUES"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The numbers of one axis.

        Raises:
            click.BadParameter: where a part is neither a number nor a range.
        """
        if not isinstance(value, str):
            return value
        numbers: list[float] = []
        for part in value.split(","):
            try:
                start, *rest = part.split(":")
                if rest:
                    stop, count = rest
                    if not 1 <= int(count) <= MOST_VALUES:
                        raise ValueError
                    numbers += np.round(np.linspace(float(start), float(stop), int(count)), DIGITS).tolist()
                else:
                    numbers.append(float(start))
            except ValueError:
                self.fail(f"{part!r} is neither a number nor START:STOP:COUNT", param, ctx)
        return tuple(numbers)


def _axis(flag: str, what: str) -> Callable[[Command], Command]:
    return click.option(flag, type=Values(), help=f"{what}, in m.")


@click.command()
@click.argument("base", metavar="BASE")
@_axis("--obstacle-x", "Near edges of the box to step over")
@_axis("--obstacle-width", "Its widths; 0.05 if left out")
@_axis("--obstacle-height", "Its heights")
@_axis("--stride", "Travels of the swinging foot")
@_axis("--riser", "Heights of stairs, below 0 downwards")
@_axis("--tread", "Depths of their treads")
@_axis("--first-edge", "x of the first riser")
@_axis("--thigh", "Thigh lengths; from the file if left out")
@_axis("--shank", "Shank lengths; from the file if left out")
@click.option("--steps", type=int, help="Number of steps of a stride or of stairs; 2 if left out.")
@BONES
@EDITED
@STAIR_GAITS
@STYLE
@click.option("--frames", type=int, help="Resample the base gait to this many frames.")
@click.option("--keep-frames", is_flag=True, help="Write the gaits themselves too.")
@click.option("--workers", type=int, help="Processes to use; one a processor if left out.")
@click.option("-o", "--output", type=click.Path(), required=True, help="netCDF file to write (.nc).")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a line.")
def sweep(
    base: str,
    steps: int | None,
    bones: Bones | None,
    edited: bool,
    up: str | None,
    down: str | None,
    style: str | None,
    frames: int | None,
    keep_frames: bool,
    workers: int | None,
    output: str,
    as_json: bool,
    **axes: tuple[float, ...] | None,
) -> None:
    """Make the gaits of a whole grid: every combination of the VALUES given.

    VALUES are numbers and ranges START:STOP:COUNT, comma-separated, as in 0.05,0.1:0.2:5. With obstacles each row is
    one step over a box, with risers a flight of stairs, else steps of another stride. A row without a safe gait is a
    result too: it says why. A sweep that was stopped goes on where it was, given the same grid and FILE.
    """
    from ggo_factors.cli.console import progress_bar

    grid = Grid(**axes, steps=steps)
    gait = named_bases(base, edited, lambda _, each: with_bones(each, bones), {"up": up, "down": down})
    varied = None if style is None else load_style(style)
    if frames is not None:
        gait = gait.resampled(frames)
    with progress_bar("sweeping") as progress:
        found = make_sweep(
            grid, gait, output, workers=workers, progress=progress, keep_frames=keep_frames, style=varied
        )
    counts = outcome(found)
    if as_json:
        click.echo(json.dumps({"format_version": 1, **counts, "output": output}, indent=1))
        return
    click.echo(f"{counts['rows']} rows, {counts['ok']} gaits")
    for what, numbers in (("refused", counts["errors"]), ("limits broken", counts["violations"])):
        if numbers:
            click.echo(f"{what}: " + ", ".join(f"{name} {count}" for name, count in numbers.items()))
    click.echo(f"wrote {output}")
