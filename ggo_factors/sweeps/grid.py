"""A grid of tasks: every combination of strides, obstacles, stairs and leg lengths."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from itertools import product
from typing import Any

from ggo_factors.errors import InputError
from ggo_factors.motion.base_gaits import BaseGaits, both
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LONGEST, LegModel
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.procedures.steps import MOST_STEPS
from ggo_factors.support.inputs import as_array, as_count, as_number
from ggo_factors.sweeps.tasks import Task

MOST_ROWS = 1_000_000
"""Most rows of a grid: more than an hour of work at 5 ms a gait."""
USUAL_WIDTH = 0.05
"""Width in [m] of an obstacle whose width is left out: that of the paper's obstacles."""
USUAL_STEPS = 2
"""Steps of a stride or of stairs if not given: one with each leg."""

Axis = tuple[float, ...]

OBSTACLE_AXES = ("obstacle_x", "obstacle_width", "obstacle_height")
STAIR_AXES = ("riser", "tread", "first_edge")


@dataclass(frozen=True)
class Grid:
    """Values in [m] to combine, each with each. An axis is one number or several; if left out, the procedure's default.

    With obstacles each row is one step over one box (`step_over`), with risers a flight of stairs (`climb_stairs`,
    `descend_stairs`), otherwise steps with another stride (`adjust_stride`).

    Attributes:
        obstacle_x: near edge of the box, in the body frame of the step.
        obstacle_width: its extent along x; 0.05 if left out.
        obstacle_height: its height.
        stride: distance that the swing ankle travels in a full step; it lands half of it ahead of the supporting foot.
        riser: height of the risers; positive upstairs, negative downstairs.
        tread: depth of the treads.
        first_edge: x of the first riser.
        thigh: length of the thigh.
        shank: length of the shank.
        steps: number of steps of a stride or of stairs; 2 if None.

    Raises:
        InputError: where a value is unusable or given twice, or axes do not go together.
    """

    obstacle_x: float | Iterable[float] | None = None
    obstacle_width: float | Iterable[float] | None = None
    obstacle_height: float | Iterable[float] | None = None
    stride: float | Iterable[float] | None = None
    riser: float | Iterable[float] | None = None
    tread: float | Iterable[float] | None = None
    first_edge: float | Iterable[float] | None = None
    thigh: float | Iterable[float] | None = None
    shank: float | Iterable[float] | None = None
    steps: int | None = None

    def __post_init__(self) -> None:
        for name in self.names():
            given = getattr(self, name)
            if given is not None:
                object.__setattr__(self, name, _axis(given, name))
        axes = self.axes
        if not axes:
            raise InputError(f"grid: give at least one of {', '.join(self.names())}")
        boxes, stairs = set(OBSTACLE_AXES) & set(axes), set(STAIR_AXES) & set(axes)
        if boxes and not {"obstacle_x", "obstacle_height"} <= boxes:
            raise InputError(f"{sorted(boxes)[0]}: an obstacle needs obstacle_x and obstacle_height")
        if stairs and "riser" not in axes:
            raise InputError(f"{sorted(stairs)[0]}: stairs need a riser")
        for name in (*sorted(boxes), "stride"):
            if stairs and name in axes:
                raise InputError(f"{name}: does not go with riser")
        if self.steps is not None:
            as_count(self.steps, "steps", 1, MOST_STEPS)
            if boxes:
                raise InputError("steps: a step over an obstacle is one")
        if self.size > MOST_ROWS:
            raise InputError(f"grid: {self.size} rows, at most {MOST_ROWS}")

    @staticmethod
    def names() -> tuple[str, ...]:
        """The names of all axes, in the order in which the results have them."""
        return tuple(field.name for field in fields(Grid) if field.name != "steps")

    @property
    def axes(self) -> dict[str, Axis]:
        """The values of each axis that is given, in [m]."""
        return {name: getattr(self, name) for name in self.names() if getattr(self, name) is not None}

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def size(self) -> int:
        """Number of rows."""
        return math.prod(self.shape)

    @property
    def steps_a_row(self) -> int:
        """Number of steps that each row has."""
        return 1 if self.obstacle_x is not None else USUAL_STEPS if self.steps is None else self.steps

    def tasks(self, base: Gait | BaseGaits, model: LegModel | None = None) -> tuple[Task, ...]:
        """The task of each row, the last axis changing fastest.

        Args:
            base: the base gait, or gaits for each leg and for stairs.
            model: the legs, where no axis gives their lengths; the base gait's own if None.

        Raises:
            InputError: where the leg lengths are not known.
        """
        base = both(base)
        if model is None and base.model is None and self.thigh is not None and self.shank is not None:
            legs = LegModel(1.0, 1.0)  # both lengths are replaced
        else:
            legs = base.legs(model)
        axes = self.axes
        return tuple(self._task(dict(zip(axes, values, strict=True)), legs) for values in product(*axes.values()))

    def _task(self, at: dict[str, float], legs: LegModel) -> Task:
        model = replace(legs, thigh=at.get("thigh", legs.thigh), shank=at.get("shank", legs.shank))
        arguments: dict[str, Any] = {"model": model}
        if "obstacle_x" in at:
            near = at["obstacle_x"]
            far = near + at.get("obstacle_width", USUAL_WIDTH)
            arguments["obstacles"] = (Obstacle(near, far, at["obstacle_height"]),)
            if "stride" in at:
                arguments["foothold"] = (at["stride"] / 2.0, 0.0)
            return Task("step_over", arguments)
        arguments["steps"] = self.steps_a_row
        if "riser" in at:
            arguments |= {name: at[name] for name in ("tread", "first_edge") if name in at}
            arguments["riser"] = abs(at["riser"])
            return Task("climb_stairs" if at["riser"] > 0.0 else "descend_stairs", arguments)
        return Task("adjust_stride", arguments | {"stride": at.get("stride")})


def _axis(given: Any, name: str) -> Axis:
    if isinstance(given, (int, float)):
        given = [given]
    elif isinstance(given, Iterator):
        given = tuple(given)
    values = as_array(given, name, (None,)).tolist()
    if not values:
        raise InputError(f"{name}: an axis needs at least one value")
    if len(set(values)) < len(values):
        twice = next(value for value in values if values.count(value) > 1)
        raise InputError(f"{name}: {twice:g} m stands twice")
    for value in values:
        if name == "obstacle_height":
            as_number(value, name, at_least=0.0, unit="m")
        elif name in ("thigh", "shank"):
            as_number(value, name, above=0.0, at_most=LONGEST, unit="m")
        elif name == "riser":
            if value == 0.0:
                raise InputError("riser: 0 m is neither up nor down")
        elif name != "obstacle_x":
            as_number(value, name, above=0.0, unit="m")
    return tuple(values)
