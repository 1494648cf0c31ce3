"""What a wearer feels of a gait, in numbers: how fast and how suddenly the joints move, balance, change, clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ggo_factors.check.balance import off_balance
from ggo_factors.check.joint_rates import joint_rates
from ggo_factors.check.report import STANDARD, Report
from ggo_factors.errors import InputError
from ggo_factors.evaluate.metrics import mean_joint_change, zmp
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.motion.gait import Gait
from ggo_factors.support.inputs import Array, as_tuple_of

WALK_JOINTS = ("left hip", "left knee", "right hip", "right knee")
"""The joints of a walk of two steps or more, the right leg swinging first."""
RATES = {"speed": "deg/s", "acceleration": "deg/s2", "jerk": "deg/s3"}
"""The derivatives of a joint angle that are reported, by order, with their units in tables and JSON."""


@dataclass(frozen=True, eq=False)
class Comfort:
    """A gait or a walk in the numbers that its wearer feels.

    Attributes:
        name: what to call it.
        joints: names of the four joints: those of a frame for one step, those of both legs for a walk.
        peaks: largest speed, acceleration and jerk of each joint in [rad/s], [rad/s^2], [rad/s^3], shape (3, 4).
        rms: root mean squares of the same, shape (3, 4).
        zmp: mean distance of the zero moment point from the supporting ankle in [m].
        zmp_off: mean distance of the zero moment point from the base gait's own at that frame in [m]; NaN without one.
        zmp_off_largest: the largest such distance in [m].
        change: mean change of a joint from the base gait in [rad]; NaN without one.
        clearance: least height of the swing ankle over the obstacles in [m]; infinite where it crosses none.
        leg_clearance: least distance of thighs and shanks from obstacles and stairs in [m]; infinite as in `Report`.
    """

    name: str
    joints: tuple[str, ...]
    peaks: Array
    rms: Array
    zmp: float
    zmp_off: float
    zmp_off_largest: float
    change: float
    clearance: float
    leg_clearance: float

    def to_json(self) -> dict[str, Any]:
        """The same for a JSON file, in degrees and millimetres."""
        rates: dict[str, Any] = {}
        for rate, peaks, rms in zip(RATES, np.degrees(self.peaks).tolist(), np.degrees(self.rms).tolist(), strict=True):
            unit = RATES[rate].replace("/", "_")
            rates[f"{rate}_peak_{unit}"] = dict(zip(self.joints, peaks, strict=True))
            rates[f"{rate}_rms_{unit}"] = dict(zip(self.joints, rms, strict=True))
        return {"name": self.name, **rates, **self.others()}

    def others(self) -> dict[str, float | None]:
        """The numbers that are not of a single joint; None where one does not apply."""
        numbers = {
            "mean_zmp_mm": self.zmp * 1e3,
            "mean_zmp_off_mm": self.zmp_off * 1e3,
            "largest_zmp_off_mm": self.zmp_off_largest * 1e3,
            "mean_change_deg": math.degrees(self.change),
            "clearance_mm": self.clearance * 1e3,
            "leg_clearance_mm": self.leg_clearance * 1e3,
        }
        return {key: value if math.isfinite(value) else None for key, value in numbers.items()}


def comfort(
    name: str, gaits: Sequence[Gait], reports: Sequence[Report], base: Gait | Sequence[Gait] | None = None
) -> Comfort:
    """The numbers of a gait (one step) or of a walk.

    Where a step starts in the frame in which the one before ended, differences are taken across the change of legs,
    each joint with its own leg. Where it does not, each step counts for itself: a jump between two has no speed.

    Args:
        name: what to call it.
        gaits: the steps, each with its legs.
        reports: what the dense check saw of each.
        base: base gait that the change is counted from, or that of each step, of as many frames; none if None.

    Raises:
        InputError: where there is no step, a step has fewer than 4 frames, or the numbers of frames or steps differ.
    """
    gaits, reports = as_tuple_of(gaits, "gaits", Gait), as_tuple_of(reports, "reports", Report)
    if not gaits or len(gaits) != len(reports):
        raise InputError(f"reports: {len(reports)} for {len(gaits)} steps; one each, and at least one")
    for number, gait in enumerate(gaits, start=1):
        if len(gait) < 4:
            raise InputError(f"step {number}: {len(gait)} frames, jerk needs at least 4")
    pieces = _joined(gaits)
    rates = [np.concatenate([joint_rates(piece, order) for piece in pieces]) for order in (1, 2, 3)]
    change = off = farthest = math.nan
    if base is not None:
        bases = (base,) * len(gaits) if isinstance(base, Gait) else as_tuple_of(base, "base", Gait)
        if len(bases) != len(gaits):
            raise InputError(f"base: {len(bases)} base gaits for {len(gaits)} steps; one, or one each")
        pairs = list(zip(gaits, bases, strict=True))
        away = np.concatenate([off_balance(gait, gait.legs(), own) for gait, own in pairs])
        if len(away):
            off, farthest = float(away.mean()), float(away.max())
        change = float(np.mean([mean_joint_change(gait, own) for gait, own in pairs]))
    return Comfort(
        name,
        JOINTS if len(gaits) == 1 else WALK_JOINTS,
        np.array([np.abs(rate).max(axis=0) for rate in rates]),
        np.array([np.sqrt((rate**2).mean(axis=0)) for rate in rates]),
        float(np.abs(np.concatenate([zmp(gait) for gait in gaits])).mean()),
        off,
        farthest,
        change,
        min(report.clearance for report in reports),
        min(report.leg_clearance for report in reports),
    )


def _joined(gaits: Sequence[Gait]) -> list[Gait]:
    """The steps, columns always in the order of the first one's legs; those that continue one another are joined."""
    joined: list[Gait] = []
    for number, gait in enumerate(gaits):
        own = gait.swapped() if number % 2 else gait
        if joined and float(np.abs(own.frames[0] - joined[-1].frames[-1]).max()) <= STANDARD.start:
            before = joined.pop()
            paced = None
            if before.paced is not None or own.paced is not None:
                paced = np.concatenate([before.times, before.duration + own.times[1:]])
            own = replace(own, frames=np.concatenate([before.frames, own.frames[1:]]), paced=paced)
        joined.append(own)
    return joined
