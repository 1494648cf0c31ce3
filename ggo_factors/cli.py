"""The `ggo` command: recordings in, gaits out, each checked before it is written."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import ggo_factors as ggo
from ggo_factors.comfort import Comfort
from ggo_factors.files import printable, replacing, write_text
from ggo_factors.flags import GAPS, GENERATE, JSON, LEGS, OBSTACLES, NumberList, Numbers
from ggo_factors.loading import checked, comforts_of, legs_of, load, load_base, load_beside, steps_of
from ggo_factors.recording.presets import PRESETS
from ggo_factors.summary import StepSummary, summarize
from ggo_factors.sweep_command import sweep
from ggo_factors.walk import across

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EXIT_OTHER, EXIT_INPUT, EXIT_UNSAFE = 1, 2, 3
TOPICS_SHOWN = 100
PICTURES = (".png", ".pdf", ".svg")


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(ggo.__version__, prog_name="ggo")
def cli() -> None:
    """Variable gaits for lower-limb exoskeletons, bent from one recorded base gait.

    BASE is a gait file (CSV), or the word `paper` for the base gait of the paper. Lengths are in metres, in the body
    frame of the step: origin at the ankle of the supporting foot, x forward.

    Exit codes: 0 done, 2 bad input, 3 no safe gait, 1 anything else.
    """


@cli.command("import")
@click.argument("log", type=click.Path())
@click.option("--topic", help="Topic to read; found by its joints if left out.")
@click.option(
    "--joints",
    metavar="MAP.toml|PRESET",
    help=f"Which logged values make up the four angles. Presets: {', '.join(PRESETS)}.",
)
@click.option("--unit", type=click.Choice(["rad", "deg"]), help="Unit of the angles, where the log does not say.")
@click.option("--frames", type=int, default=51, show_default=True, help="Frames of the base gait.")
@click.option("--min-strides", type=int, default=3, show_default=True, help="Fewer usable strides a leg are refused.")
@click.option(
    "--activity",
    type=click.Choice(["level", "stairs-up", "stairs-down"]),
    default="level",
    show_default=True,
    help="What to look for.",
)
@click.option("--thigh", type=float, help="Thigh length of the walker in m; both the paper's if left out.")
@click.option("--shank", type=float, help="Shank length of the walker in m.")
@click.option("-o", "--output", type=click.Path(), help="Write the base gait as CSV.")
@click.option("--report", type=click.Path(), help="Write the report as JSON.")
@click.option("--picture", type=click.Path(), help="Draw all strides, their mean and spread.")
@JSON
def import_command(
    log: str,
    topic: str | None,
    joints: str | None,
    unit: str | None,
    frames: int,
    min_strides: int,
    activity: str,
    thigh: float | None,
    shank: float | None,
    output: str | None,
    report: str | None,
    picture: str | None,
    as_json: bool,
) -> None:
    """Make a base gait from a walk recorded in an MCAP log.

    LOG is an MCAP file or a rosbag2 folder. Without --joints the names in it are told, and the presets that fit them.
    """
    from ggo_factors.console import progress_bar

    _require_log(log)
    if picture is not None:
        _require_ending(picture, PICTURES)
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
        )
    if output is not None:
        _require_ending(output, (".csv",))
    if report is not None:
        write_text(report, made.to_json() + "\n")
    if picture is not None:
        from ggo_factors.plot import plot_import

        _save_figure(plot_import(made)[0], picture)
    if output is not None:
        made.gait.save(output)
    click.echo(made.to_json() if as_json else made.text())
    for loss in made.losses:
        click.echo(f"ggo: {loss}", err=True)
    for violation in made.violations:
        click.echo(f"ggo: the base gait itself is not safe to walk: {violation}", err=True)
    _say_written(output, as_json)


@cli.command()
@GENERATE
@click.option("--stride", type=float, help="Travel of the swinging foot; that of BASE, or past the gaps, if left out.")
@click.option("--steps", type=int, default=2, show_default=True, help="Number of steps.")
@GAPS
def stride(base: str, stride: float | None, steps: int, gaps: tuple[ggo.Gap, ...], **rest: Any) -> None:
    """Walk with another stride; step over pits."""
    _generate(base, lambda gait, how: ggo.adjust_stride(gait, stride, gaps=gaps, steps=steps, **how), **rest)


@cli.command("step-over")
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


@cli.command()
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
    procedure = ggo.climb_stairs if direction == "up" else ggo.descend_stairs
    _generate(base, lambda gait, how: procedure(gait, riser, tread, first_edge, steps, **how), **rest)


@cli.command()
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


@cli.command()
@click.argument("file", metavar="FILE")
@LEGS
@OBSTACLES
@GAPS
@click.option("--foothold", type=Numbers("X,Y"), help="Where the gait must land.")
@click.option("--base", help="Base gait to count the change from, and to put beside it in the report.")
@click.option("--report", is_flag=True, help="Say how the joints move: speed, acceleration, jerk; balance; clearance.")
@JSON
def verify(
    file: str,
    thigh: float | None,
    shank: float | None,
    obstacles: tuple[ggo.Obstacle, ...],
    gaps: tuple[ggo.Gap, ...],
    foothold: tuple[float, float] | None,
    base: str | None,
    report: bool,
    as_json: bool,
) -> None:
    """Check a gait or a walk densely; a walk against the ground that its file states."""
    loaded = load(file, thigh, shank)
    if isinstance(loaded, ggo.Walk):
        if obstacles or gaps or foothold:
            raise ggo.InputError(f"{file}: a walk states its own ground; --obstacle, --gap, --foothold are for a gait")
        name, names = "walk", [f"step {number}" for number in range(1, len(loaded.gaits) + 1)]
    else:
        name = loaded.name or "gait"
        names = [name]
    beside = load_beside(base, loaded, thigh, shank)
    asked = {"obstacles": obstacles, "gaps": gaps, "foothold": foothold}
    reports = checked(loaded, **asked)
    rows = [summarize(*row, beside) for row in zip(names, steps_of(loaded), reports, strict=True)]
    _show(rows, as_json, comforts_of(name, loaded, beside, **asked) if report else ())
    _require_safe(file, reports)


@cli.command()
@click.argument("log", type=click.Path())
@JSON
def inspect(log: str, as_json: bool) -> None:
    """Say what an MCAP log holds: topics, joints, units, damage."""
    from ggo_factors.console import console, log_tables, progress_bar

    _require_log(log)
    with progress_bar("reading") as progress:
        found = ggo.inspect_log(log, progress=progress)
    if as_json:
        click.echo(json.dumps(found.to_json(), indent=1))
    else:
        console().print(*log_tables(replace(found, topics=found.topics[:TOPICS_SHOWN])), sep="\n")
        if len(found.topics) > TOPICS_SHOWN:
            click.echo(f"{len(found.topics) - TOPICS_SHOWN} more topics are not shown; --json lists all")


@cli.command()
@click.argument("file", metavar="FILE")
@click.option("--base", help="Base gait to draw beside it.")
@click.option(
    "--what",
    type=click.Choice(["stick", "angles", "residual", "joints", "comfort"]),
    default="stick",
    show_default=True,
    help="Stick figure and path of P; joint angles; residual of every frame; joints of both legs over time; "
    "speed, acceleration and jerk of each joint.",
)
@LEGS
@click.option("-o", "--output", type=click.Path(), required=True, help="Picture: PNG, PDF or SVG by its ending.")
def plot(file: str, base: str | None, what: str, thigh: float | None, shank: float | None, output: str) -> None:
    """Draw a gait or a walk."""
    _require_ending(output, PICTURES)
    from ggo_factors import plot as plots

    loaded = load(file, thigh, shank)
    gaits, beside = steps_of(loaded), load_beside(base, loaded, thigh, shank)
    if what == "stick":
        drawn = plots.plot_stick_figure(loaded, base=beside)
    elif what == "joints":
        (drawn, *_) = plots.plot_joint_trajectory(ggo.joint_trajectory(gaits))
    elif what == "comfort":
        from ggo_factors.plot_comfort import plot_comfort

        (drawn, *_) = plot_comfort(comforts_of(Path(file).stem, loaded, beside))
    elif what == "angles":
        axes = None
        for number, gait in enumerate(gaits, start=1):
            axes = plots.plot_joint_angles(
                gait, beside if axes is None else None, label=f"step {number}", colour=f"C{number - 1}", axes=axes
            )
        assert axes is not None  # a walk has at least one step
        drawn = axes[0]
    elif beside is None:
        raise ggo.InputError("--base: the residual is the difference from a base gait; give it")
    else:
        ax = None
        for number, gait in enumerate(gaits, start=1):
            ax = plots.plot_residual(gait, beside, label=f"step {number}", colour=f"C{number - 1}", ax=ax)
        assert ax is not None  # as above
        drawn = ax
    _save_figure(drawn, output)
    _say_written(output, False)


@cli.command()
@click.argument("file", metavar="FILE")
@click.option("--first-swing", type=click.Choice(["right", "left"]), default="right", help="Leg that swings first.")
@click.option("--pelvis-tilt", type=float, default=0.0, help="In degrees, taken from the hip angles.")
@LEGS
@click.option("-o", "--output", type=click.Path(), required=True, help="MCAP file to write.")
def export(
    file: str, first_swing: str, pelvis_tilt: float, thigh: float | None, shank: float | None, output: str
) -> None:
    """Write a checked gait or walk as an MCAP log with sensor_msgs/JointState."""
    _require_ending(output, (".mcap",))
    loaded = load(file, thigh, shank)
    _require_safe(file, checked(loaded))
    ggo.export_mcap(loaded, output, first_swing=first_swing, pelvis_tilt=math.radians(pelvis_tilt))
    _say_written(output, False)


cli.add_command(sweep)


# -- shared ---------------------------------------------------------------------------------------------------------


def _generate(
    base: str,
    make: Callable[[ggo.Gait, dict[str, Any]], ggo.Walk],
    *,
    thigh: float | None,
    shank: float | None,
    frames: int | None,
    smoothness: float | None,
    hard: bool,
    limits: bool,
    output: str | None,
    as_json: bool,
) -> None:
    gait = load_base(base, thigh, shank)
    if output is not None:
        _require_ending(output, (".csv", ".mcap"))
    if frames is not None:
        gait = gait.resampled(frames)
    began = time.perf_counter()
    made = make(gait, {"smoothness": smoothness, "hard": hard, "limits": ggo.JointLimits() if limits else None})
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
    _show(rows, as_json)
    _say_written(output, as_json)


def _save_figure(drawn: Axes, output: str) -> None:
    from matplotlib import pyplot

    figure = drawn.get_figure(root=True)
    assert figure is not None  # it was just drawn
    with replacing(output) as temporary:
        figure.savefig(temporary, dpi=200, bbox_inches="tight")
    pyplot.close(figure)


def _require_log(log: str) -> None:
    if log == "paper" and not Path(log).exists():
        raise ggo.InputError(
            "paper: that is the base gait of the paper, not a recording; LOG is an MCAP file or folder"
        )


def _require_ending(output: str, endings: Sequence[str]) -> None:
    if Path(output).suffix.lower() not in endings:
        raise ggo.InputError(f"{output}: must end in {' or '.join(endings)}")


def _require_safe(file: str, reports: Sequence[ggo.Report]) -> None:
    for number, report in enumerate(reports, start=1):
        if not report.ok:
            faults = "; ".join(str(violation) for violation in report.violations)
            raise ggo.InfeasibleGaitError(f"{file}: step {number} is not safe: {faults}", report.violations)


def _show(rows: Sequence[StepSummary], as_json: bool, comforts: Sequence[Comfort] = ()) -> None:
    if as_json:
        said: dict[str, Any] = {"format_version": 1, "steps": [row.to_json() for row in rows]}
        if comforts:
            said["comfort"] = [made.to_json() for made in comforts]
        click.echo(json.dumps(said, indent=1))
        return
    from ggo_factors.console import comfort_tables, console, summary_table

    console().print(summary_table(rows), *(comfort_tables(comforts) if comforts else ()), sep="\n")


def _say_written(output: str | None, as_json: bool) -> None:
    if output is not None and not as_json:
        click.echo(f"wrote {output}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; every error is one line on stderr and an exit code."""
    try:
        result = cli.main(args=arguments, prog_name="ggo", standalone_mode=False)
        return result if isinstance(result, int) else 0
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.exceptions.NoArgsIsHelpError as help_text:
        click.echo(help_text.format_message(), err=True)
        return EXIT_INPUT
    except click.ClickException as error:
        return _fail(error.format_message(), EXIT_INPUT)
    except click.Abort:
        return _fail("stopped", EXIT_OTHER)
    except ggo.InfeasibleGaitError as error:
        return _fail(str(error), EXIT_UNSAFE)
    except (ggo.InputError, ggo.LogError) as error:
        return _fail(str(error), EXIT_INPUT)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_OTHER
    except Exception as error:
        if os.environ.get("GGO_DEBUG"):
            raise
        return _fail(f"{type(error).__name__}: {error} (GGO_DEBUG=1 shows where)", EXIT_OTHER)


def _fail(message: str, code: int) -> int:
    click.echo("ggo: " + printable(" ".join(message.split())), err=True)
    return code


if __name__ == "__main__":
    sys.exit(main())
