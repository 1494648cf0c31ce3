"""A step for each leg: from the mean cycles of both legs, or their mean stair swings, closed and on the ground."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicSpline

from ggo_factors.motion.gait import swap_roles
from ggo_factors.recording.strides.cut_strides import Cycles
from ggo_factors.recording.strides.steps import LEGS
from ggo_factors.support.inputs import Array

EVERY_LEG = ("mean", "each", *LEGS)
"""What a base gait can be made of: the mean of both legs, each leg for itself, one leg alone."""
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
