"""`ggo import`, `inspect`, `convert` and `export`: recordings in, MCAP logs out."""

from __future__ import annotations

import json
import math
import warnings
from dataclasses import replace

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import EDITED, JSON, LARGEST_CHUNK, LEGS, RECORDING, TOPIC, UNIT
from ggo_factors.cli.loading import checked, legs_of, load, require_log
from ggo_factors.cli.output import PICTURES, require_ending, require_safe, save_figure, say_written
from ggo_factors.recording.each_leg import EVERY_LEG
from ggo_factors.recording.export.export_trajectory import GOALS, TABLES
from ggo_factors.support.files import write_text

TOPICS_SHOWN = 100
"""Topics that `ggo inspect` lists on a screen; --json lists all."""


@click.command("import")
@click.argument("log", type=click.Path())
@RECORDING
@click.option("--frames", type=int, default=51, show_default=True, help="Frames of the base gait.")
@click.option("--min-strides", type=int, default=3, show_default=True, help="Fewer usable strides a leg are refused.")
@click.option(
    "--leg",
    type=click.Choice(EVERY_LEG),
    default="mean",
    show_default=True,
    help="One gait for both legs, a gait for each, or the strides of one leg alone.",
)
@click.option("--thigh", type=float, help="Thigh length of the walker in m; both the paper's if left out.")
@click.option("--shank", type=float, help="Shank length of the walker in m.")
@click.option("-o", "--output", type=click.Path(), help="Write the base gait as CSV.")
@click.option("--style", type=click.Path(), help="Write the style of the steps as .npz, where it helps.")
@click.option("--report", type=click.Path(), help="Write the report as JSON.")
@click.option("--picture", type=click.Path(), help="Draw all strides, their mean and spread.")
@LARGEST_CHUNK
@JSON
def import_command(
    log: str,
    topic: str | None,
    joints: str | None,
    unit: str | None,
    frames: int,
    min_strides: int,
    activity: str,
    leg: str,
    thigh: float | None,
    shank: float | None,
    output: str | None,
    style: str | None,
    report: str | None,
    picture: str | None,
    largest_chunk: int,
    as_json: bool,
) -> None:
    """Make a base gait from a recorded walk.

    LOG is an MCAP file, a rosbag2 folder or other bag, OpenSim .mot or .sto, CSV, or Vicon .c3d. What else must be told
    (topic, joints, unit) is asked for, with the names that LOG has and the presets that fit them.
    """
    from ggo_factors.cli.console import progress_bar

    require_log(log)
    if picture is not None:
        require_ending(picture, PICTURES)
    with progress_bar("reading") as progress:
        made = ggo.import_base_gait(
            log,
            topic=topic,
            joints=joints,
            unit=unit,
            model=legs_of(None, thigh, shank),
            frames=frames,
            min_strides=min_strides,
            activity=activity,
            progress=progress,
            leg=leg,
            largest_chunk=largest_chunk,
        )
    if output is not None:
        require_ending(output, (".csv",))
    if style is not None:
        require_ending(style, (".npz",))
    learned = None if style is None else ggo.style_of(made)
    if report is not None:
        write_text(report, made.to_json() + "\n")
    if picture is not None:
        from ggo_factors.plot import plot_import

        save_figure(plot_import(made)[0], picture)
    if output is not None:
        (made.base_gaits if leg == "each" else made.gait).save(output)
    if style is not None and learned is not None:
        learned.save(style)
    click.echo(made.to_json() if as_json else made.text())
    if style is not None and learned is None:
        why = "held-out steps say that it does not help, or they are too few"
        click.echo(f"ggo: no style written: {len(made.steps)} steps; {why}", err=True)
    for loss in made.losses:
        click.echo(f"ggo: {loss}", err=True)
    for violation in made.violations:
        click.echo(f"ggo: the base gait itself is not safe to walk: {violation}", err=True)
    say_written(output, as_json)
    say_written(style if learned is not None else None, as_json)


@click.command()
@click.argument("log", type=click.Path())
@LARGEST_CHUNK
@JSON
def inspect(log: str, largest_chunk: int, as_json: bool) -> None:
    """Say what a recording holds: topics, joints, units, damage."""
    from ggo_factors.cli.console import console, log_tables, progress_bar

    require_log(log)
    with progress_bar("reading") as progress:
        found = ggo.inspect_log(log, progress=progress, largest_chunk=largest_chunk)
    if as_json:
        click.echo(json.dumps(found.to_json(), indent=1))
    else:
        console().print(*log_tables(replace(found, topics=found.topics[:TOPICS_SHOWN])), sep="\n")
        if len(found.topics) > TOPICS_SHOWN:
            click.echo(f"{len(found.topics) - TOPICS_SHOWN} more topics are not shown; --json lists all")


@click.command()
@click.argument("log", type=click.Path())
@TOPIC
@UNIT
@click.option("-o", "--output", type=click.Path(), required=True, help="MCAP file to write.")
@LARGEST_CHUNK
def convert(log: str, topic: str | None, unit: str | None, output: str, largest_chunk: int) -> None:
    """Write the joint values of any recording as a clean MCAP log.

    LOG is what `ggo import` takes. The log has one topic of sensor_msgs/JointState: names as LOG has them, angles in
    radians, times that rise from 0.
    """
    from ggo_factors.cli.console import progress_bar

    require_log(log)
    require_ending(output, (".mcap",))
    with progress_bar("reading") as progress:
        read = ggo.convert_log(log, output, topic=topic, unit=unit, progress=progress, largest_chunk=largest_chunk)
    for loss in read.losses:
        click.echo(f"ggo: {loss}", err=True)
    say_written(output, False)


@click.command()
@click.argument("file", metavar="FILE")
@click.option("--first-swing", type=click.Choice(["right", "left"]), help="Leg that swings first; FILE's if left out.")
@click.option("--pelvis-tilt", type=float, default=0.0, help="In degrees, taken from the hip angles.")
@click.option("--joints", type=click.Path(), help="MAP.toml: the robot's joints, as `ggo import --joints` reads them.")
@click.option("--rate", type=float, help="Points a second; the gait's own frames if left out.")
@click.option("--ends-moving", is_flag=True, help="A goal may end in motion, which controllers refuse by default.")
@LEGS
@EDITED
@click.option(
    "-o", "--output", type=click.Path(), required=True, help="File to write: .mcap, .yaml, .json, .csv or .mot."
)
def export(
    file: str,
    first_swing: str | None,
    pelvis_tilt: float,
    joints: str | None,
    rate: float | None,
    ends_moving: bool,
    thigh: float | None,
    shank: float | None,
    edited: bool,
    output: str,
) -> None:
    """Write a checked gait or walk for a robot.

    By the ending of OUTPUT: .mcap a log with sensor_msgs/JointState and a JointTrajectory, .yaml or .json a goal of
    control_msgs/action/FollowJointTrajectory, .csv time and joints, .mot the same for OpenSim.
    """
    require_ending(output, (".mcap", *GOALS, *TABLES))
    loaded = load(file, thigh, shank, edited)
    require_safe(file, checked(loaded))
    tilt = math.radians(pelvis_tilt)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        if output.lower().endswith(".mcap"):
            ggo.export_mcap(loaded, output, joints=joints, rate=rate, first_swing=first_swing, pelvis_tilt=tilt)
        else:
            ggo.export_trajectory(
                loaded,
                output,
                joints=joints,
                rate=rate,
                first_swing=first_swing,
                pelvis_tilt=tilt,
                ends_moving=ends_moving,
            )
    for warning in told:
        click.echo(f"ggo: {warning.message}", err=True)
    say_written(output, False)
