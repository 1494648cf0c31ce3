"""How far the ground's push (ZMP) is from where it acts in the base gait, or from a support."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.check.report import STANDARD, Report, Tolerances
from ggo_factors.errors import InputError, Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.zero_moment import held_points, push, start_shift, triples
from ggo_factors.support.inputs import Array, as_array

NO_FRAMES = np.zeros(0)


def off_balance(gait: Gait, model: LegModel, held: Gait | tuple[float, float]) -> Array:
    """Distances of the ZMP from the base gait's own in each inner frame, or from a support, in [m], shape (k,).

    A gait that starts differently from the base gait is given time, see `zero_moment.held_points`. One that was slowed
    is held to the base gait as if at its pace, to a support as it is walked.
    Frames in which the base gait nearly falls are left out; so are all where the gaits differ in their frames.

    Args:
        gait: the step.
        model: the legs.
        held: the base gait, or x of the back and front end of the support in [m], from the supporting ankle.
    """
    if len(gait) < 3:
        return NO_FRAMES
    if gait.paced is not None and not isinstance(held, Gait):
        gait = gait.resampled(len(gait))
    moment, force = push(model, triples(gait.frames), gait.dt)
    points = moment / force
    if not isinstance(held, Gait):
        back, front = held
        return np.asarray(np.maximum(np.maximum(back - points, points - front), 0.0))
    if len(held) != len(gait):
        return NO_FRAMES
    shift = start_shift(model, held.frames, held.dt, gait.frames[0])
    off = np.abs(points - held_points(model, held.frames, held.dt, shift))
    return np.asarray(off[~np.isnan(off)])


def balance_faults(
    gait: Gait, model: LegModel, held: Gait | tuple[float, float], allowed: Tolerances
) -> tuple[float, float, list[Violation]]:
    """Mean and largest distance of the ZMP, see `off_balance`, in [m], and whether the mean is too large."""
    off = off_balance(gait, model, held)
    if not len(off):
        return math.nan, math.nan, []
    mean, found = float(off.mean()), list[Violation]()
    if not mean <= allowed.balance:
        found.append(Violation("balance", None, mean, allowed.balance, "m", "mean distance of the ZMP"))
    return mean, float(off.max()), found


def with_balance(report: Report, gait: Gait, model: LegModel, base: Gait) -> Report:
    """The report of a step that was to be balanced; whether it is, is for the caller to say."""
    mean, largest, _ = balance_faults(gait, model, base, STANDARD)
    return replace(report, zmp_off=mean, zmp_off_largest=largest)


def balance_asked(gait: Gait, balance: object) -> Gait | tuple[float, float]:
    """What a user holds the balance of a gait to.

    Raises:
        InputError: where it is neither a gait of as many frames nor a support.
    """
    if isinstance(balance, Gait):
        if len(balance) != len(gait):
            raise InputError(f"balance: the base gait has {len(balance)} frames, the gait {len(gait)}")
        return balance
    return support_of(balance, "balance")


def support_of(value: object, name: str) -> tuple[float, float]:
    """X of the back and front end of a support in [m].

    Raises:
        InputError: where they are not two numbers, the back end behind the front end.
    """
    back, front = as_array(cast(ArrayLike, value), name, (2,)).tolist()
    if not back < front:
        raise InputError(f"{name}: its back end, {back:g} m, must be behind its front end, {front:g} m")
    return back, front
