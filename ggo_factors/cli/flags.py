"""The flags of the command line: how they are parsed, and those that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, get_args

import click

import ggo_factors as ggo
from ggo_factors.motion.leg_model import Bones

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


def _numbers(text: str) -> tuple[float, ...] | None:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        return None


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
BONES = click.option(
    "--bones",
    type=click.Choice(get_args(Bones)),
    help="Whether thighs and shanks are lines that hit obstacles and stairs, or the paper's points, which do not; "
    "from the file if left out, else lines.",
)
GENERATE = options(
    click.argument("base", metavar="BASE"),
    LEGS,
    BONES,
    EDITED,
    click.option("--frames", type=int, help="Resample the base gait to this many frames."),
    click.option("--smoothness", type=float, help="Gain of the second-order edges; 0 is the paper's graph."),
    click.option("--hard", is_flag=True, help="Meet footholds, knees, clearance and limits to 1e-6, as constraints."),
    click.option("--limits", is_flag=True, help="Keep joint angles, speeds and accelerations within JointLimits."),
    click.option(
        "--balance", type=float, help="Hold the ZMP to the base gait's by edges of this gain; 2 is a good one."
    ),
    click.option("--style", metavar="FILE", help="Bend steps as people vary theirs; a file that `ggo learn` wrote."),
    click.option("-o", "--output", type=click.Path(), help="Write the walk as CSV, or as MCAP where FILE ends so."),
    JSON,
)
