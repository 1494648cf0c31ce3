"""One line a step: how it was found and what the dense check saw, in numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ggo_factors.check.report import Report
from ggo_factors.errors import InfeasibleGaitError
from ggo_factors.evaluate.metrics import mean_joint_change
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait

JOINTS = ("alpha1", "beta1", "alpha2", "beta2")
"""The angles of a frame as tables and JSON name them, in their order."""


@dataclass(frozen=True)
class StepSummary:
    """One step in numbers; None where one is not known or does not apply.

    Attributes:
        name: which step of what.
        verdict: ``"ok"``, or what is wrong.
        iterations: of the solver, over all rounds.
        milliseconds: time taken to make and check it.
        foothold_error_mm: distance of the landing from its foothold.
        clearance_mm: least height over the obstacles.
        ground_clearance_mm: least height over the ground, away from the footholds.
        knee_deg: least knee angle.
        change_deg: mean absolute change of each joint from the base gait.
        hit_probability: of an obstacle that was measured with an error, see `Report`.
        duration_s: time that the step takes.
        slowdown: how many times as long as at the base gait's pace, see `Gait.slowdown`.
        landing_speed_m_s: speed of the swing ankle downwards at landing.
        axis_clearance_mm: least distance of the legs' axes from obstacles and stairs.
        zmp_off_mm: mean distance of the ZMP from the base gait's, or from the support, where balance was asked for.
        zmp_off_largest_mm: the largest such distance.
        notes: what should be known though it breaks no limit.
    """

    name: str
    verdict: str
    iterations: int | None = None
    milliseconds: float | None = None
    foothold_error_mm: float | None = None
    clearance_mm: float | None = None
    ground_clearance_mm: float | None = None
    knee_deg: float | None = None
    change_deg: tuple[float, ...] | None = None
    hit_probability: float | None = None
    duration_s: float | None = None
    slowdown: float | None = None
    landing_speed_m_s: float | None = None
    axis_clearance_mm: float | None = None
    zmp_off_mm: float | None = None
    zmp_off_largest_mm: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return self.verdict == "ok"

    def to_json(self) -> dict[str, Any]:
        """The same for a JSON file."""
        numbers = {name: getattr(self, name) for name in self.__dataclass_fields__}
        if self.change_deg is not None:
            numbers["change_deg"] = dict(zip(JOINTS, self.change_deg, strict=True))
        return numbers


def summarize(
    name: str,
    gait: Gait,
    report: Report,
    base: Gait | None = None,
    solution: Solution | None = None,
    milliseconds: float | None = None,
) -> StepSummary:
    """The line of one step; `base` for the change from it, `solution` for how it was found."""
    faults = [str(violation) for violation in report.violations]
    if solution is not None and not solution.converged:
        faults.insert(0, solution.reason)
    change = None
    if base is not None:
        change = tuple(np.degrees(mean_joint_change(gait, base)).tolist())
    return StepSummary(
        name,
        "; ".join(faults) or "ok",
        None if solution is None else solution.iterations,
        milliseconds,
        _finite(report.foothold_error * 1e3),
        _finite(report.clearance * 1e3),
        _finite(report.ground_clearance * 1e3),
        math.degrees(report.knee),
        change,
        report.hit_probability,
        gait.duration,
        gait.slowdown,
        _finite(report.landing_speed),
        _finite(report.axis_clearance * 1e3),
        _finite(report.zmp_off * 1e3),
        _finite(report.zmp_off_largest * 1e3),
        report.notes,
    )


def refusal(name: str, error: InfeasibleGaitError, milliseconds: float | None = None) -> StepSummary:
    """The line of a step for which there is no safe gait."""
    return StepSummary(name, f"refused: {error}", milliseconds=milliseconds)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
