"""The errors of the library, each carrying the numbers that caused it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


class GgoError(Exception):
    """Root of every error that this library raises on purpose."""


class InputError(GgoError, ValueError):
    """A value handed in is not usable; the message names the field, the value and the limit."""


class LogError(GgoError):
    """A recording cannot be read, or does not hold what a gait needs."""


class GraphError(GgoError):
    """The factor graph cannot be solved: not anchored, singular, or an edge that is not finite."""


@dataclass(frozen=True)
class Violation:
    """One way in which a finished gait breaks a limit.

    Attributes:
        kind: what is broken, for example ``"obstacle"``, ``"foothold"``, ``"knee"``.
        frame: frame of the worst value (fractional between two frames), or None.
        value: the worst value found.
        limit: the limit that it breaks.
        unit: unit of both.
        note: which of several things, where that is not plain.
    """

    kind: str
    frame: float | None
    value: float
    limit: float
    unit: str
    note: str = ""

    def __str__(self) -> str:
        where = "" if self.frame is None else f" at frame {self.frame:.6g}"
        note = f" ({self.note})" if self.note else ""
        return f"{self.kind}{note}{where}: {self.value:.4g} {self.unit} (limit {self.limit:.4g} {self.unit})"


class InfeasibleGaitError(GgoError):
    """No gait was found that passes the check.

    Attributes:
        violations: what the best gait found still breaks.
        nearest_foothold: the nearest foothold in [m] that does work, shape (2,), or None where none
            was found or searched.
        step: number of the step in its walk, from 1, or None.
    """

    def __init__(
        self,
        message: str,
        violations: Sequence[Violation] = (),
        nearest_foothold: tuple[float, float] | None = None,
        step: int | None = None,
    ) -> None:
        super().__init__(message)
        self.violations = tuple(violations)
        self.nearest_foothold = nearest_foothold
        self.step = step


class UnreachableFootholdError(InfeasibleGaitError):
    """A target lies out of the leg's reach.

    Attributes:
        distance: distance to the target in [m].
        reach: the largest (or, for a target too near, the smallest) distance that can be reached in [m].
    """

    def __init__(self, message: str, distance: float, reach: float, step: int | None = None) -> None:
        super().__init__(message, (Violation("reach", None, distance, reach, "m"),), None, step)
        self.distance = distance
        self.reach = reach
