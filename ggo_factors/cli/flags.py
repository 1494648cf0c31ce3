"""The flags of the command line: how they are parsed, and those that several commands share."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, TypeVar, get_args

import click

import ggo_factors as ggo
from ggo_factors.motion.leg_model import Bones
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_map import UNITS
from ggo_factors.recording.log.presets import PRESETS

Command = TypeVar("Command", bound=Callable[..., Any])


class Numbers(click.ParamType[Any]):
    """Comma-separated numbers, as many as the named places, made into a value of the library.

    Args:
        places: their names, comma-separated; those that may be left out, all or none, in brackets at the end.
        make: what makes the value of them.
    """

    def __init__(self, places: str, make: Callable[..., object] | None = None) -> None:
        self.name = places
        self._counts = {part.count(",") + 1 for part in (places, places.split("[")[0])}
        self._make = make

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The numbers of one flag.

        Raises:
            click.BadParameter: where there are too few or too many, or one is no number.
        """
        if not isinstance(value, str):
            return value
        numbers = _numbers(value)
        if numbers is None:
            self.fail(f"{value!r} is not {self.name} in numbers", param, ctx)
        if len(numbers) not in self._counts:
            self.fail(f"{value!r} has {len(numbers)} numbers, expected {self.name}", param, ctx)
        return self._make(*numbers) if self._make else numbers


class NumberList(click.ParamType[Any]):
    """One number or several, comma-separated."""

    name = "H[,H...]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """A float for one number, else a tuple.

        Raises:
            click.BadParameter: where one is no number.
        """
        if not isinstance(value, str):
            return value
        numbers = _numbers(value)
        if numbers is None:
            self.fail(f"{value!r} is not a number or a list of numbers", param, ctx)
        return numbers if len(numbers) > 1 else numbers[0]


class Pace(click.ParamType[Any]):
    """A share of the base gait's pace, or `auto`."""

    name = "SHARE|auto"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """A float, or ``"auto"``.

        Raises:
            click.BadParameter: where it is neither.
        """
        if value == "auto" or not isinstance(value, str):
            return value
        numbers = _numbers(value)
        if numbers is None or len(numbers) != 1:
            self.fail(f"{value!r} is neither a number nor 'auto'", param, ctx)
        return numbers[0]


def _numbers(text: str) -> tuple[float, ...] | None:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        return None


def with_flags(message: str, group: click.Group, given: Sequence[str]) -> str:
    """An error of the library, which speaks of arguments, in the flags of the command line.

    ``unit='deg'`` becomes ``--unit deg``, ``edited=True`` ``--edited``, ``joints=`` ``--joints``; and the argument that
    an error begins with (``min_strides: 0 must be ...``) its flag, where that was given.

    Args:
        message: the error's text.
        group: all commands.
        given: the words of the command line.
    """
    command = next((group.commands[word] for word in given if word in group.commands), None)
    options = [] if command is None else [o for o in command.params if isinstance(o, click.Option)]
    flags = {option.name: max(option.opts, key=len) for option in options if option.name}
    if not flags:
        return message

    def flag(match: re.Match[str]) -> str:
        value = (match[2] or "").strip("'")
        return flags[match[1]] + (f" {value}" if value and value != "True" else "")

    names = "|".join(map(re.escape, flags))
    message = re.sub(rf"(?<![\w./-])({names})=('[^']*'|True\b|-?[\d.]*\d)?", flag, message)
    first = re.match(rf"({names})(?=: )", message)
    if first and any(word.split("=")[0] == flags[first[1]] for word in given):
        message = flags[first[1]] + message[first.end() :]
    return message


def options(*options: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Several click options as one decorator, listed by --help in this order."""

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add


OBSTACLES = click.option(
    "--obstacle",
    "obstacles",
    type=Numbers("XS,XE,H[,SE,SH]", ggo.Obstacle),
    multiple=True,
    help="Box in m, with the standard deviations of its measured edges and height if there are; repeatable.",
)
GAPS = click.option(
    "--gap", "gaps", type=Numbers("XS,XE", ggo.Gap), multiple=True, help="Pit without foothold, in m; repeatable."
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
EDITED = click.option("--edited", is_flag=True, help="Take files whose numbers were changed after they were written.")
LEGS = options(
    click.option("--thigh", type=float, help="Thigh length in m; from the file if left out."),
    click.option("--shank", type=float, help="Shank length in m; from the file if left out."),
)
LARGEST_CHUNK = click.option(
    "--largest-chunk",
    type=int,
    default=CHUNK_MIB,
    metavar="MIB",
    show_default=True,
    help="Read no larger chunk of LOG.",
)
TOPIC = click.option("--topic", help="Topic to read; found by its joints if left out.")
UNIT = click.option("--unit", type=click.Choice(UNITS), help="Unit of the angles, where the log does not say.")
RECORDING = options(
    TOPIC,
    click.option(
        "--joints",
        metavar="MAP.toml|PRESET",
        help=f"Which logged values make up the four angles. Presets: {', '.join(PRESETS)}.",
    ),
    UNIT,
    click.option(
        "--activity",
        type=click.Choice(["level", "stairs-up", "stairs-down"]),
        default="level",
        show_default=True,
        help="What to look for.",
    ),
)
BONES = click.option(
    "--bones",
    type=click.Choice(get_args(Bones)),
    help="Whether thighs and shanks are lines that hit obstacles and stairs, or the paper's points, which do not; "
    "from the file if left out, else lines.",
)
FROM_STANDING = click.option("--from-standing", is_flag=True, help="Start with the feet together, legs straight.")
TO_STANDING = click.option("--to-standing", is_flag=True, help="Close with one more step, feet together.")
FIRST_SWING = click.option(
    "--first-swing", type=click.Choice(["right", "left"]), default="right", help="Leg that swings first."
)
STAIR_GAITS = options(
    click.option("--up", metavar="FILE", help="Base gait up stairs (import --activity stairs-up), for steps up."),
    click.option("--down", metavar="FILE", help="Base gait down stairs, for steps down."),
)
STYLE = click.option("--style", metavar="FILE", help="Bend steps as people vary theirs; a file that `ggo learn` wrote.")
BENT = options(
    LEGS,
    BONES,
    EDITED,
    STAIR_GAITS,
    FIRST_SWING,
    click.option("--frames", type=int, help="Resample the base gait to this many frames."),
)
KEPT = options(
    click.option("--hard", is_flag=True, help="Meet footholds, knees, clearance and limits to 1e-6, as constraints."),
    click.option("--limits", is_flag=True, help="Keep joint angles, speeds and accelerations within JointLimits."),
    click.option("--pace", type=Pace(), help="Share of BASE's pace, to 1; auto: as slow as needed, as with --limits."),
)
ALIKE = options(
    click.option(
        "--balance", type=float, help="Hold the ZMP to the base gait's by edges of this gain; 2 is a good one."
    ),
    STYLE,
)
WALK = click.option("-o", "--output", type=click.Path(), help="Write the walk as CSV, or as MCAP where FILE ends so.")
GENERATE = options(
    click.argument("base", metavar="BASE"),
    BENT,
    click.option("--smoothness", type=float, help="Gain of the second-order edges; 0 is the paper's graph."),
    KEPT,
    click.option("--step-time", type=float, help="Time of a step in s, in place of --pace; no shorter than BASE's."),
    click.option("--deadline", type=float, help="Seconds that the search may take."),
    ALIKE,
    WALK,
    JSON,
)
