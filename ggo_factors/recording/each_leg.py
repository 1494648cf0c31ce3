"""A step for each leg: from the mean cycles of both legs, or their mean stair swings, closed and on the ground."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicSpline

from ggo_factors.motion.base_gaits import Kind
from ggo_factors.motion.gait import swap_roles
from ggo_factors.motion.recorded import Recorded
from ggo_factors.recording.strides.cut_strides import Cycles
from ggo_factors.recording.strides.mean_step import resampled_step
from ggo_factors.recording.strides.steps import LEGS
from ggo_factors.support.inputs import Array

EVERY_LEG = ("mean", "each", *LEGS)
"""What a base gait can be made of: the mean of both legs, each leg for itself, one leg alone."""
KINDS: Mapping[str, Kind] = {"level": "level", "stairs-up": "up", "stairs-down": "down"}
"""The kind of ground of each activity of a recording."""
MOST_APART_DEG = 10.0
"""Legs whose steps differ by more, RMS over the step and its four angles in degrees, have no mean: it would be nobody's
gait. In recordings healthy legs are 2 to 8 apart; a badly set marker or a sensor's zero makes it 15 and more."""


def left_share(cycles: Cycles, activity: str) -> float:
    """Share of the stride that the step takes in which the left leg swings, in the median; half where one has none."""
    times = [[s.duration for s in cycles.steps if s.leg == leg and s.activity == activity] for leg in ("left", "right")]
    if not all(times):
        return 0.5
    left, right = (float(np.median(row)) for row in times)
    return left / (left + right)


def level_pair(cycles: Mapping[str, Array], share: float, count: int) -> dict[str, Array]:
    """The steps of a walker whose legs follow their own mean cycles, by the leg that swings, each (count, 4) in [rad].

    Each ends where the other begins. In the left one the right leg stands from its heel strike on, for `share` of the
    stride, and the left leg swings to its own.

    Args:
        cycles: thigh and knee at the phases 0, 1/n, ..., (n-1)/n of each leg's cycle in [rad], shape (n, 2); where
            there is one leg only the other is taken to do the same.
        share: of the stride that the left leg's step takes.
        count: frames of each step.
    """
    splines = {}
    for leg in LEGS:
        cycle = cycles.get(leg, next(iter(cycles.values())))
        phases = np.linspace(0.0, 1.0, len(cycle) + 1)
        splines[leg] = CubicSpline(phases, np.vstack([cycle, cycle[:1]]), bc_type="periodic")
    made = {}
    for swing, support, length in (("left", "right", share), ("right", "left", 1.0 - share)):
        phase = np.linspace(0.0, length, count)
        made[swing] = np.concatenate([splines[support](phase), splines[swing](phase + 1.0 - length)], axis=1)
    return made


def closed_pair(left: Array, right: Array) -> tuple[Array, Array]:
    """Two steps (m, 4), each made to end where the other begins, the legs swapped; the gaps are spread over both."""
    share = np.linspace(0.0, 1.0, len(left))[:, None]
    to_right, to_left = swap_roles(left[-1]) - right[0], swap_roles(right[-1]) - left[0]
    left = left + 0.5 * (1.0 - share) * to_left - 0.5 * share * swap_roles(to_right)
    right = right + 0.5 * (1.0 - share) * to_right - 0.5 * share * swap_roles(to_left)
    left[-1], right[-1] = swap_roles(right[0]), swap_roles(left[0])
    return left, right


def recorded_strides(
    deviations: Mapping[str, Array], activity: str, share: float, count: int, strides: Mapping[str, int]
) -> dict[str, Recorded]:
    """What the base gait of each leg, and that of both, is the mean of.

    Args:
        deviations: standard deviation of each leg's strides at the phases of their mean, as `ImportReport.spread`.
        activity: what was walked.
        share: of the stride that the left leg's step takes.
        count: frames of a step.
        strides: how many strides each leg has; one that has none is taken to do as the other.
    """
    kind, one = KINDS[activity], next(iter(strides.values()))
    own = _step_spreads(deviations, activity, share, count)
    kept = {leg: Recorded(strides.get(leg, one), own[leg], kind, leg) for leg in LEGS}
    halves = _step_spreads(deviations, activity, 0.5, count)
    pooled = np.sqrt((halves["left"] ** 2 + halves["right"] ** 2) / 2.0)
    return kept | {"both": Recorded(sum(strides.values()), pooled, kind)}


def _step_spreads(spread: Mapping[str, Array], activity: str, share: float, count: int) -> dict[str, Array]:
    """How the strides of each leg spread over the step in which it swings, in [rad], shape (count, 4)."""
    if activity == "level":
        made = level_pair(spread, share, count)
    else:
        one = next(iter(spread.values()))
        made = {leg: resampled_step(spread.get(leg, one), count) for leg in LEGS}
    # A spline may dip below a deviation that is nearly 0.
    return {leg: np.maximum(row, 0.0) for leg, row in made.items()}
