"""`ggo plot`: a file drawn."""

from __future__ import annotations

from pathlib import Path

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import EDITED, LEGS
from ggo_factors.cli.loading import comforts_of, load, load_beside
from ggo_factors.cli.output import PICTURES, require_ending, save_figure, say_written


@click.command()
@click.argument("file", metavar="FILE")
@click.option("--base", help="Base gait to draw beside it; of several each step's own.")
@click.option(
    "--what",
    type=click.Choice(["stick", "angles", "residual", "joints", "comfort", "plan"]),
    default="stick",
    show_default=True,
    help="Stick figure and path of the swing ankle; joint angles; residual of every frame; "
    "joints of both legs over time; speed, acceleration and jerk of each joint; "
    "of a walk that `ggo plan` wrote: footholds considered, chosen and refused.",
)
@LEGS
@EDITED
@click.option("-o", "--output", type=click.Path(), required=True, help="Picture: PNG, PDF or SVG by its ending.")
def plot(
    file: str, base: str | None, what: str, thigh: float | None, shank: float | None, edited: bool, output: str
) -> None:
    """Draw a gait or a walk; or a terrain, FILE ending in .toml."""
    require_ending(output, PICTURES)
    from ggo_factors import plot as plots

    if file.lower().endswith(".toml"):
        save_figure(plots.plot_terrain(ggo.load_terrain(file)), output)
        say_written(output, False)
        return
    loaded = load(file, thigh, shank, edited)
    beside = load_beside(base, loaded, thigh, shank, edited)
    if what == "stick":
        drawn = plots.plot_stick_figure(loaded, base=beside)
    elif what == "plan":
        drawn = plots.plot_plan(ggo.load_plan(file, edited=edited))
    elif what == "joints":
        of_walk = loaded if isinstance(loaded, ggo.Walk) else ggo.joint_trajectory([loaded])
        (drawn, *_) = plots.plot_joint_trajectory(of_walk)
    elif what == "comfort":
        (drawn, *_) = plots.plot_comfort(comforts_of(Path(file).stem, loaded, beside))
    elif what == "angles":
        (drawn, *_) = plots.plot_joint_angles(loaded, beside)
    elif beside is None:
        raise ggo.InputError("--base: the residual is the difference from a base gait; give it")
    else:
        drawn = plots.plot_residual(loaded, beside)
    save_figure(drawn, output)
    say_written(output, False)
