"""`ggo learn`: how people vary their steps, learned from MCAP logs."""

from __future__ import annotations

import json

import click

from ggo_factors.cli.flags import JSON
from ggo_factors.cli.loading import legs_of
from ggo_factors.cli.output import require_ending, say_written
from ggo_factors.motion.style import Style


@click.command()
@click.argument("logs", metavar="LOG...", nargs=-1, required=True, type=click.Path())
@click.option("--topic", help="Topic to read; found by its joints if left out.")
@click.option("--joints", metavar="MAP.toml|PRESET", help="Which logged values make up the four angles.")
@click.option("--unit", type=click.Choice(["rad", "deg"]), help="Unit of the angles, where the logs do not say.")
@click.option(
    "--activity",
    type=click.Choice(["level", "stairs-up", "stairs-down"]),
    default="level",
    show_default=True,
    help="What to look for.",
)
@click.option("--thigh", type=float, help="Thigh length of the walkers in m; both the paper's if left out.")
@click.option("--shank", type=float, help="Shank length of the walkers in m.")
@click.option("-o", "--output", type=click.Path(), help="Write the style as .npz.")
@JSON
def learn(
    logs: tuple[str, ...],
    topic: str | None,
    joints: str | None,
    unit: str | None,
    activity: str,
    thigh: float | None,
    shank: float | None,
    output: str | None,
    as_json: bool,
) -> None:
    """Learn how people vary their steps, for --style of the other commands.

    Each LOG is an MCAP file or a rosbag2 folder of another person; 12 steps or more are needed for a style to help.
    """
    from ggo_factors.cli.console import progress_bar
    from ggo_factors.recording.learning import learn_from_logs

    if output is not None:
        require_ending(output, (".npz",))
    with progress_bar("reading") as progress:
        style = learn_from_logs(
            logs,
            topic=topic,
            joints=joints,
            unit=unit,
            model=legs_of(None, thigh, shank),
            activity=activity,
            progress=progress,
        )
    if output is not None:
        style.save(output)
    if as_json:
        click.echo(json.dumps(_numbers(style), indent=1))
    else:
        for line in _lines(style):
            click.echo(line)
    if style.why_not:
        click.echo(f"ggo: note: steps are not bent with this style: {style.why_not}", err=True)
    say_written(output, as_json)


def _numbers(style: Style) -> dict[str, object]:
    return {
        "format_version": 1,
        "numbers": style.directions.shape[2],
        "ground": style.ground,
        "steps": style.steps,
        "people": style.people,
        "explained": style.explained,
        "variance_rad2": style.variance,
        "likelihood_nats": {"with": style.likelihood[0], "without": style.likelihood[1]},
        "error_deg": {"with": style.error_deg[0], "without": style.error_deg[1]},
        "helps": style.helps,
        "why_not": style.why_not,
    }


def _lines(style: Style) -> tuple[str, ...]:
    """What was learned, for reading."""
    return (
        f"style: {style.directions.shape[2]} numbers a step, of {style.steps} steps of {style.people} people",
        f"  explained    {100.0 * style.explained:.1f} % of the variance of these steps",
        f"  held out     {style.error_deg[0]:.2f} degrees off given start and foothold, "
        f"{style.error_deg[1]:.2f} without style",
        f"  likelihood   {style.likelihood[0]:.2f} nats an angle held out, {style.likelihood[1]:.2f} without style",
    )
