"""A stretch of ground that carries a foot."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ggo_factors.errors import InputError
from ggo_factors.motion.terrain import LARGEST_STD, STEEPEST
from ggo_factors.support.inputs import as_number

WORLD = 1000.0
"""How far from the origin of the world frame anything lies at most, in [m]: beyond it the numbers are millimetres."""


@dataclass(frozen=True)
class Surface:
    """A stretch of ground that carries a foot: level, or a ramp.

    Attributes:
        x_start: where it begins in [m], in the world frame.
        x_end: where it ends in [m].
        height: its height at `x_start` in [m].
        slope: its slope in [rad], up positive, at most 15 degrees.
        edge_std: standard deviation of `x_start` in [m], at most `LARGEST_STD`; 0 where it is known.
        height_std: the same of its height.

    Raises:
        InputError: where a number is not finite or out of its range.
    """

    x_start: float
    x_end: float
    height: float = 0.0
    slope: float = 0.0
    edge_std: float = 0.0
    height_std: float = 0.0

    def __post_init__(self) -> None:
        for name in ("x_start", "x_end", "height"):
            number = as_number(getattr(self, name), name, at_least=-WORLD, at_most=WORLD, unit="m")
            object.__setattr__(self, name, number)
        if not self.x_start < self.x_end:
            raise InputError(f"x_end: {self.x_end:g} m must be above x_start {self.x_start:g} m")
        slope = as_number(self.slope, "slope", unit="rad")
        if abs(slope) > STEEPEST + 1e-9:
            most = math.degrees(STEEPEST)
            raise InputError(f"slope: {math.degrees(slope):g} degrees is beyond {most:g} degrees, the steepest ramp")
        object.__setattr__(self, "slope", slope)
        for name in ("edge_std", "height_std"):
            number = as_number(getattr(self, name), name, at_least=0.0, at_most=LARGEST_STD, unit="m")
            object.__setattr__(self, name, number)

    def __str__(self) -> str:
        what = f"ramp of {math.degrees(self.slope):.3g} degrees" if self.slope else "level"
        return f"{what} from {self.x_start:g} to {self.x_end:g} m, at {self.height:g} m"

    @property
    def end_height(self) -> float:
        """Its height at `x_end` in [m]."""
        return self.height + math.tan(self.slope) * (self.x_end - self.x_start)

    def shifted(self, x: float, y: float) -> Surface:
        """The surface `x` further on and `y` higher, both in [m]."""
        return replace(self, x_start=self.x_start + x, x_end=self.x_end + x, height=self.height + y)
