"""Which strides and stair swings are alike enough to be averaged."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from ggo_factors.recording.strides.cut_strides import Cycles, Stride
from ggo_factors.recording.strides.steps import LEGS, Step
from ggo_factors.support.inputs import Array

SHORT = 0.6
"""A stride whose ankle travels less than this part of the median is a start, a stop or a turn."""
SHAPE_DEG = 5.0
"""A stride is an outlier only when it is further in degrees (RMS of thigh and knee) from the median of its leg, ..."""
SHAPE_TIMES = 4.0
"""... and also so many times as far from it as the median stride of the leg."""
SAME_TIME = 1e-6
"""Strikes of a stride and of a step in it that differ by no more in [s] are the same."""

_Cut = TypeVar("_Cut", Stride, Step)


def level_strides(cycles: Cycles) -> list[Stride]:
    """All strides; those that are not level walking, or unlike the others of their leg, are refused with a reason."""
    strides = []
    for stride in cycles.strides:
        inside = [
            step
            for step in cycles.steps
            if stride.start - SAME_TIME <= step.start and step.end <= stride.end + SAME_TIME
        ]
        stairs = [step for step in inside if step.activity != "level"]
        strides.append(replace(stride, reason="a stair") if stairs and not stride.reason else stride)
    travel = [float(np.ptp(np.sin(s.angles[:, 0]) + np.sin(s.angles[:, 0] - s.angles[:, 1]))) for s in strides]
    least = SHORT * float(np.median([t for t, s in zip(travel, strides, strict=True) if not s.reason] or [0.0]))
    strides = [
        replace(s, reason="short: a start, a stop or a turn") if not s.reason and t < least else s
        for t, s in zip(travel, strides, strict=True)
    ]
    return _without_outliers(strides, lambda stride: stride.angles)


def alike(swings: Sequence[Step]) -> list[Step]:
    """Swings on stairs; those unlike the others of their leg are refused with a reason."""
    return _without_outliers(swings, lambda step: step.frames, times=3.0)


def stair_swings(cycles: Cycles, activity: str) -> list[Step]:
    """The stair swings of one direction; those unlike the others are refused with a reason."""
    return alike([step for step in cycles.steps if step.activity == activity])


def _without_outliers(cuts: Sequence[_Cut], shape: Callable[[_Cut], Array], times: float = SHAPE_TIMES) -> list[_Cut]:
    """The cuts; those far from the median of their leg, and much further than the others, are refused with a reason."""
    result = list(cuts)
    for leg in LEGS:
        good = [i for i, cut in enumerate(cuts) if cut.leg == leg and not cut.reason]
        if len(good) < 3:
            continue
        angles = np.degrees([shape(cuts[i]) for i in good])
        apart = np.sqrt(np.mean((angles - np.median(angles, axis=0)) ** 2, axis=(1, 2)))
        limit = max(SHAPE_DEG, times * float(np.median(apart)))
        for i, far in zip(good, apart.tolist(), strict=True):
            if far > limit:
                result[i] = replace(
                    cuts[i], reason=f"unlike the others of its leg ({far:.1f} degrees RMS off their median)"
                )
    return result


def from_stair_to_stair(used: Sequence[Stride | Step], cuts: Sequence[Stride | Step]) -> Sequence[Stride | Step]:
    """All strides used; of stair swings those that follow another, if any do: the first one starts from the ground.

    Args:
        used: what is to be averaged.
        cuts: all strides or swings, used or not and of either leg: the swing before is the other leg's.
    """
    ends = {cut.end for cut in cuts if isinstance(cut, Step)}
    later = [cut for cut in used if isinstance(cut, Step) and cut.start in ends]
    return later or used


def steps_within(cuts: Sequence[Stride | Step], cycles: Cycles) -> tuple[Step, ...]:
    """The steps that cuts are made of, in the order of time: stair swings themselves, of strides the steps in them."""
    steps = [cut for cut in cuts if isinstance(cut, Step)]
    inside: dict[float, Step] = {}  # by their start: a step lies in a stride of each leg
    for leg in LEGS:
        strides = sorted((cut.start, cut.end) for cut in cuts if isinstance(cut, Stride) and cut.leg == leg)
        starts = [start for start, _ in strides]
        for step in cycles.steps if strides else ():
            n = bisect.bisect_right(starts, step.start + SAME_TIME) - 1
            if n >= 0 and step.end <= strides[n][1] + SAME_TIME:
                inside[step.start] = step
    return tuple(sorted([*steps, *inside.values()], key=lambda step: step.start))
