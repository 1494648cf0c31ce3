"""What the dense check looked at, with which tolerance, and what it found: a row for each kind of check."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ggo_factors.check.joint_rates import SPIKE, joint_rates
from ggo_factors.check.report import STANDARD, Report, Tolerances
from ggo_factors.check.trajectory import LEAST_JUMP
from ggo_factors.errors import Violation
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import Foot
from ggo_factors.page.motion import ShownStep
from ggo_factors.walking.step import stands_in

Found = Callable[[ShownStep, Report], float]


@dataclass(frozen=True)
class Seen:
    """What was checked: the steps, what the check saw of each, and what they were held to.

    Attributes:
        steps: the steps.
        reports: what the dense check saw of each.
        limits: joint limits that they were held to; None where there were none.
        landing_speed: how fast a foot may come down in [m/s]; None where that was not asked.
    """

    steps: tuple[ShownStep, ...]
    reports: tuple[Report, ...]
    limits: JointLimits | None
    landing_speed: float | None


@dataclass(frozen=True)
class Check:
    """A row of the table.

    Attributes:
        key: its name in JSON.
        label: what it looks at, for a reader.
        kinds: which kinds of `Violation` are its own, a regular expression.
        unit: unit of what is found and allowed; "" where there is no number.
        tolerance: what is allowed, in that unit; None where there is no number.
        at_least: whether that is the least allowed, and not the most.
        found: the number of one step in that unit, NaN where it has none; None where there is none to tell.
        about: which steps it is about; None where it is about all.
        asked: whether it was looked at in steps that it is about; None where it always was.
    """

    key: str
    label: str
    kinds: str
    unit: str = ""
    tolerance: Callable[[Tolerances], float] | None = None
    at_least: bool = False
    found: Found | None = None
    about: Callable[[ShownStep], bool] | None = None
    asked: Callable[[Seen], bool] | None = None

    def row(self, seen: Seen) -> dict[str, Any]:
        """The check over all steps, for JSON."""
        pairs = [pair for pair in zip(seen.steps, seen.reports, strict=True) if self._is_about(pair[0])]
        asked = bool(pairs) and (self.asked is None or self.asked(seen))
        allowed = seen.landing_speed if self.key == "landing_speed" else self.tolerance and self.tolerance(STANDARD)
        broken = [number for number, fault in numbered_faults(seen) if self.is_own(seen.steps[number - 1], fault)]
        return {
            "check": self.key,
            "label": self.label,
            "asked": asked or bool(broken),
            "broken_in_steps": sorted(set(broken)),
            "found": self._worst(pairs) if asked else None,
            "allowed": None if allowed is None else round(allowed, 9),
            "at_least": self.at_least,
            "unit": self.unit,
        }

    def is_own(self, shown: ShownStep, violation: Violation) -> bool:
        """Whether a violation in a step is of this check."""
        return self._is_about(shown) and re.fullmatch(self.kinds, violation.kind) is not None

    def _is_about(self, shown: ShownStep) -> bool:
        return self.about is None or self.about(shown)

    def _worst(self, pairs: Sequence[tuple[ShownStep, Report]]) -> float | None:
        """The worst number of any step; None where no step has one."""
        numbers = [] if self.found is None else [self.found(*pair) for pair in pairs]
        known = [number for number in numbers if math.isfinite(number)]
        if not known:
            return None
        return round(min(known) if self.at_least else max(known), 6)


def numbered_faults(seen: Seen) -> list[tuple[int, Violation]]:
    """Every limit that is broken, with the number of its step from 1."""
    return [(number, fault) for number, report in enumerate(seen.reports, 1) for fault in report.violations]


def check_rows(seen: Seen) -> list[dict[str, Any]]:
    """A row for each check, and one more where something is broken that has no row."""
    rows = [check.row(seen) for check in CHECKS]
    strange = [
        fault.kind
        for number, fault in numbered_faults(seen)
        if not any(check.is_own(seen.steps[number - 1], fault) for check in CHECKS)
    ]
    return [*rows, Check("others", "Anything else", "|".join(map(re.escape, strange))).row(seen)] if strange else rows


def violation_rows(seen: Seen) -> list[dict[str, Any]]:
    """Every limit that is broken, for JSON, with its time since the start in [s]."""
    rows = []
    for number, fault in numbered_faults(seen):
        shown, at = seen.steps[number - 1], None
        if fault.frame is not None:
            within = np.interp(fault.frame, np.arange(len(shown.gait)), shown.gait.times)
            at = round(shown.begins + float(within), 4)
        numbers = {"value": fault.value, "limit": fault.limit, "unit": fault.unit, "note": fault.note}
        rows.append({"step": number, "kind": fault.kind, "time_s": at, **numbers})
    return rows


def _mm(name: str) -> Found:
    return lambda _, report: getattr(report, name) * 1e3


def _fastest(shown: ShownStep, _: Report) -> float:
    return math.degrees(float(np.abs(joint_rates(shown.gait, 1)).max()))


def _largest_knee(shown: ShownStep, _: Report) -> float:
    return math.degrees(float(shown.gait.frames[:, 1::2].max()))


def _thigh_back(shown: ShownStep, _: Report) -> float:
    return math.degrees(float(shown.gait.frames[:, ::2].min()))


def _thigh_forward(shown: ShownStep, _: Report) -> float:
    return math.degrees(float(shown.gait.frames[:, ::2].max()))


def _has_treads(shown: ShownStep) -> bool:
    return bool(shown.ground.edges)


def _has_no_treads(shown: ShownStep) -> bool:
    return not shown.ground.edges


def _is_uneven(shown: ShownStep) -> bool:
    # A sole turns on a ramp, so that what its ankle must stay above is no straight line.
    return _has_treads(shown) or (bool(shown.ground.slopes) and shown.gait.legs().foot != Foot())


def _is_even(shown: ShownStep) -> bool:
    return not _is_uneven(shown)


def _has_plan(shown: ShownStep) -> bool:
    return shown.step is not None


def _has_obstacles(shown: ShownStep) -> bool:
    return bool(shown.obstacles)


def _is_measured(shown: ShownStep) -> bool:
    return any(box.is_uncertain for box in shown.obstacles)


def _legs_can_hit(shown: ShownStep) -> bool:
    return shown.gait.legs().has_bodies and (_has_obstacles(shown) or _has_treads(shown))


def _ends_in_a_pose(shown: ShownStep) -> bool:
    return shown.step is not None and shown.step.end_frame is not None


def _has_shank_angle(shown: ShownStep) -> bool:
    return shown.step is not None and shown.step.shank_angle is not None


def _has_several_steps(seen: Seen) -> bool:
    return len(seen.steps) > 1


def _stands_at_an_end(seen: Seen) -> bool:
    first = seen.steps[0]
    return _has_plan(first) and (stands_in(first.gait.frames[0]) or any(map(_ends_in_a_pose, seen.steps)))


CHECKS = (
    Check(
        *("foothold", "Swinging foot lands on its foothold: distance", "foothold", "mm"),
        tolerance=lambda allowed: allowed.foothold * 1e3,
        found=_mm("foothold_error"),
        about=_has_plan,
    ),
    Check(
        *("clearance", "Swinging foot passes over obstacles: height to spare", "obstacle", "mm"),
        tolerance=lambda allowed: allowed.clearance * 1e3,
        at_least=True,
        found=_mm("clearance"),
        about=_has_obstacles,
    ),
    Check(
        *("hit_probability", "Probability that an obstacle measured with an error is hit", "hit probability", "a step"),
        tolerance=lambda allowed: allowed.hit_probability,
        found=lambda _, report: report.hit_probability,
        about=_is_measured,
    ),
    Check(
        *("legs", "Axes of thighs and shanks stay out of obstacles and stairs: distance", ".* in (obstacle|stairs)"),
        unit="mm",
        tolerance=lambda _: 0.0,
        at_least=True,
        found=_mm("axis_clearance"),
        about=_legs_can_hit,
    ),
    Check(
        *("ground", "Swinging foot stays above even ground, away from both footholds: least height", "ground", "mm"),
        tolerance=lambda allowed: -allowed.ground * 1e3,
        at_least=True,
        found=_mm("ground_clearance"),
        about=_is_even,
    ),
    Check(
        *(
            "uneven_ground",
            "Swinging foot stays above stairs and ramps, away from both footholds: least height",
            "ground",
            "mm",
        ),
        tolerance=lambda allowed: allowed.stair_clearance * 1e3,
        at_least=True,
        found=_mm("ground_clearance"),
        about=_is_uneven,
    ),
    Check(
        *("mid_swing", "Swinging foot does not drag in mid-swing on even ground", "foot drags in mid-swing", "mm"),
        tolerance=lambda allowed: allowed.mid_swing * 1e3,
        at_least=True,
        about=_has_no_treads,
    ),
    Check(
        "standing",
        "Feet stand on the ground, in no obstacle, gap or void",
        "obstacle in the .*|.* in a gap|.* over a void|stair in the .*|.* off the ground",
    ),
    Check(
        *("knee", "Knees do not bend backwards: least angle", "knee", "deg"),
        tolerance=lambda allowed: math.degrees(allowed.knee),
        at_least=True,
        found=lambda _, report: math.degrees(report.knee),
    ),
    Check(
        *("knee_bent", "Knees bend no further than a human knee: largest angle", "knee bent", "deg"),
        tolerance=lambda allowed: math.degrees(allowed.knee_bent),
        found=_largest_knee,
    ),
    Check(
        *("thigh_back", "Thighs go no further back than a human hip allows: least angle", "thigh back", "deg"),
        tolerance=lambda allowed: math.degrees(allowed.thigh_back),
        at_least=True,
        found=_thigh_back,
    ),
    Check(
        *("thigh_forward", "Thighs go no further forward than a human hip allows: largest angle", "thigh forward"),
        unit="deg",
        tolerance=lambda allowed: math.degrees(allowed.thigh_forward),
        found=_thigh_forward,
    ),
    Check(
        *("hip_drop", "Supporting leg does not give way: share of the leg's length that the hip sinks by", "hip drop"),
        unit="%",
        tolerance=lambda allowed: allowed.hip_drop * 1e2,
    ),
    Check(
        *("hip_height", "Hip stays over the supporting foot: least height, of the leg's length", "hip height", "%"),
        tolerance=lambda allowed: allowed.hip_height * 1e2,
        at_least=True,
    ),
    Check(
        *("joint_speed", "No joint turns faster than a human one: largest speed", "(hip|knee) turns", "deg/s"),
        tolerance=lambda allowed: math.degrees(allowed.joint_speed),
        found=_fastest,
    ),
    Check(
        *("spikes", "No single frame stands out of the motion", "(hip|knee) spike", "deg"),
        tolerance=lambda _: math.degrees(SPIKE),
    ),
    Check(
        *("start", "Each step begins in the pose in which the one before ended", "start", "deg"),
        tolerance=lambda allowed: math.degrees(allowed.start),
        asked=_has_several_steps,
    ),
    Check(
        *("jumps", "No joint's speed jumps where the legs change roles", "(hip|knee) speed jumps", "deg/s"),
        tolerance=lambda _: math.degrees(LEAST_JUMP),
        asked=_has_several_steps,
    ),
    Check(
        *("rest", "Joints are at rest where the walker stands", "(hip|knee) not at rest", "deg/s"),
        tolerance=lambda allowed: math.degrees(allowed.rest),
        asked=_stands_at_an_end,
    ),
    Check(
        *("end_frame", "Last step ends in the pose that was asked for", "end frame", "deg"),
        tolerance=lambda allowed: math.degrees(allowed.end_frame),
        about=_ends_in_a_pose,
    ),
    Check(
        *("shank", "Shank lands at the angle that was asked for", "shank", "deg"),
        tolerance=lambda allowed: math.degrees(allowed.shank),
        about=_has_shank_angle,
    ),
    Check(
        *("landing_speed", "Foot comes down slowly enough: largest speed", "landing speed", "m/s"),
        found=lambda _, report: report.landing_speed,
        asked=lambda seen: seen.landing_speed is not None,
    ),
    Check(
        *("limits", "Joints keep the machine's limits: share beyond one", "(hip|knee) (angle|speed|acceleration)", "%"),
        tolerance=lambda allowed: allowed.limits * 1e2,
        asked=lambda seen: seen.limits is not None,
    ),
    Check(
        *("balance", "Ground's push stays near that of the base gait", "balance", "mm"),
        tolerance=lambda allowed: allowed.balance * 1e3,
        found=_mm("zmp_off"),
        asked=lambda seen: any(math.isfinite(report.zmp_off) for report in seen.reports),
    ),
)
"""The checks in the order of the table. What `verify` and `Walk.verify` find belongs to exactly one of them."""
