"""What the dense check saw of a gait, and what a good gait may be off by."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

from ggo_factors.check.leg_collision import LegAxes
from ggo_factors.check.uncertainty import HIT_PROBABILITY
from ggo_factors.errors import InputError, Violation
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_instance, as_number, as_tuple_of

KIND = "ggo-report 1"
"""Kind and version of a saved report; the number grows when a key changes its meaning or goes."""


@dataclass(frozen=True)
class Tolerances:
    """What a good gait may be off by, in [m] and [rad].

    Attributes:
        foothold: largest distance of the swing ankle from its foothold at landing.
        ground: deepest that the swing ankle may dip under the ground.
        ground_at_ends: the same within `end_zone` of an end of the step that is itself off the ground by that
            (a recorded base gait rarely stands to the millimetre).
        end_zone: how far around such an end.
        stair_clearance: least height over stairs, further than `ground.FOOTHOLD_ZONE` from both footholds, on the
            tread where the feet stand together further than `ground.BESIDE_ZONE`.
        knee: least knee angle; below 0 is hyperextension.
        knee_bent: largest knee angle.
        thigh_back: least thigh angle from the vertical.
        thigh_forward: largest thigh angle from the vertical. These three are wider than healthy ranges of motion (about
            140, -30 and 120 degrees): no walker can follow beyond them.
        hip_drop: deepest that the hip may sink below its height in the first frame, beyond what the foothold lies below
            the supporting foot, as a share of the leg's length: a supporting leg that gives way is no step.
        hip_height: least height of the hip over the supporting ankle, as a share of the leg's length: who sits on the
            own foot climbs something too high.
        clearance: least height over an obstacle.
        start: largest difference of the first frame from the frame that the walker is in.
        end_frame: largest difference of the last frame from the one that the step must end in.
        shank: largest difference of the shank from its target angle at landing.
        limits: how far beyond a joint's limit, as a share of it, for angles of their range.
        joint_speed: largest speed of a joint in [rad/s]; 20 rad/s are 1146 degrees/s, faster than any walker's joint.
        rest: largest speed of a joint in [rad/s] where a walk says that the walker stands.
        mid_swing: least height of the swing ankle over the ground in the middle half of its way; a lower foot drags.
        landing_speed: largest speed of the swing ankle downwards at landing in [m/s]. If None that of the walk itself,
            which says it where its pace was chosen; any where it does not.
        balance: largest mean distance of the ZMP from the base gait's, or from the support, in [m], where `verify` is
            given one; a procedure makes a step that would be further off without balance edges, and says so in
            `Report.notes`. Steps of 1 s over boxes are up to 0.007 off balanced, 0.6 otherwise.
        hit_probability: largest probability that the swinging foot hits an obstacle that was measured with an error;
            thighs and shanks stay clear of the larger boxes that `uncertainty.all_cautious` makes for it.

    Raises:
        InputError: where a number is not finite, or the probability is not above 0 and at most 1.
    """

    foothold: float = 0.001
    ground: float = 0.001
    ground_at_ends: float = 0.010
    end_zone: float = 0.05
    stair_clearance: float = 0.005
    knee: float = math.radians(-0.3)
    knee_bent: float = math.radians(150.0)
    thigh_back: float = math.radians(-50.0)
    thigh_forward: float = math.radians(130.0)
    hip_drop: float = 0.20
    hip_height: float = 0.45
    clearance: float = 0.0
    start: float = 1e-9
    end_frame: float = 1e-6
    shank: float = math.radians(1.0)
    limits: float = 0.001
    joint_speed: float = 20.0
    rest: float = 0.1
    mid_swing: float = 0.005
    landing_speed: float | None = None
    balance: float = 0.05
    hit_probability: float = HIT_PROBABILITY

    def __post_init__(self) -> None:
        for each in fields(self):
            if each.name == "landing_speed" and self.landing_speed is None:
                continue
            object.__setattr__(self, each.name, as_number(getattr(self, each.name), each.name))
        as_number(self.hit_probability, "hit_probability", above=0.0, at_most=1.0)


@dataclass(frozen=True)
class KnownAxes:
    """What is left of `LegAxes` in a report that was read from a file.

    Attributes:
        least: least distance of the legs' axes from obstacles and stairs in [m].
    """

    least: float

    def clearance(self) -> float:
        """That distance."""
        return self.least


STANDARD = Tolerances()
"""The tolerances that every gait is held to unless the user gives others."""


@dataclass(frozen=True)
class Report:
    """What the dense check saw.

    Attributes:
        violations: every limit that is broken; empty where the gait is good.
        foothold_error: distance of the swing ankle from its foothold at landing in [m]; NaN without a foothold.
        clearance: least height of the swing ankle over the obstacles in [m]; infinite where it crosses none.
        ground_clearance: least height of the swing ankle over the ground, away from both footholds, in [m].
        knee: least knee angle in [rad].
        instants: number of instants that were checked.
        leg_clearance: least distance of thighs and shanks that have a radius from obstacles and stairs in [m], below 0
            where one reaches in; infinite where there is none, or the legs have no radius. Obstacles that were measured
            with an error count as `uncertainty.all_cautious` makes them.
        hit_probability: how probable it is that P, or the sole, hits one of the obstacles that were measured with an
            error: the sum over them, at most 1, which holds however their errors belong together. 0 without any. Start
            and landing are points of its path; the supporting foot stands where it does, whatever was measured, and is
            held against the measured box alone.
        landing_speed: speed of the swing ankle downwards in the last motion in [m/s].
        zmp_off: mean distance of the zero moment point (ZMP) from the base gait's own at that frame, or from the
            support, in [m]; NaN where no balance was asked for.
        zmp_off_largest: the largest such distance in [m].
        axes: where the legs' axes are, and what they may hit, for `axis_clearance`; None where there is nothing.
        notes: what should be known of the step though it breaks no limit, a line each.
    """

    violations: tuple[Violation, ...]
    foothold_error: float
    clearance: float
    ground_clearance: float
    knee: float
    instants: int
    leg_clearance: float = math.inf
    hit_probability: float = 0.0
    landing_speed: float = math.nan
    zmp_off: float = math.nan
    zmp_off_largest: float = math.nan
    axes: LegAxes | KnownAxes | None = field(default=None, repr=False, compare=False)
    notes: tuple[str, ...] = ()

    @cached_property
    def axis_clearance(self) -> float:
        """Least distance of the axes of thighs and shanks from obstacles and stairs in [m].

        Below 0 where a bare bone lies in one; infinite where there is none.
        """
        return math.inf if self.axes is None else self.axes.clearance()

    @property
    def ok(self) -> bool:
        """Whether no limit is broken."""
        return not self.violations

    def save(self, path: PathLike) -> None:
        """Write the report as JSON, every number exactly, whole or not at all; `load_report` reads it.

        Numbers are in [m], [rad] and [m/s]; one that does not apply is ``"nan"`` or ``"inf"``.

        Raises:
            InputError: where the file cannot be written.
        """
        from ggo_factors.support.plain import to_plain, write_plain  # here and below: only files need it

        told = {each.name: to_plain(getattr(self, each.name)) for each in fields(self) if each.name != "axes"}
        write_plain(path, KIND, {**told, "axis_clearance": to_plain(self.axis_clearance)})

    @property
    def lengths(self) -> dict[str, float]:
        """The distances in [m] by what they are; NaN or infinite where they do not apply."""
        return {
            "distance from the foothold": self.foothold_error,
            "height over obstacles": self.clearance,
            "height over the ground": self.ground_clearance,
            "legs with a radius clear by": self.leg_clearance,
            "bare bones clear by": self.axis_clearance,
            "ZMP off in the mean": self.zmp_off,
            "ZMP off at most": self.zmp_off_largest,
        }

    def _repr_html_(self) -> str:
        from ggo_factors.check.report_card import report_card, seen  # only here: nothing but a notebook needs it

        rows = seen({}, self.landing_speed, self.knee)
        if self.hit_probability:
            rows["probability of a hit"] = f"{self.hit_probability:.2g}"
        return report_card(self.violations, self.lengths, rows | {"instants": f"{self.instants}"}, self.notes)


def load_report(path: PathLike) -> Report:
    """Read a report that `Report.save` wrote.

    Raises:
        InputError: naming the file and what is wrong with it.
    """
    from ggo_factors.support.plain import read_number, read_plain

    given = read_plain(path, KIND)
    try:
        least = read_number(given["axis_clearance"], "axis_clearance")
        numbers = {
            each.name: read_number(given[each.name], each.name) for each in fields(Report) if each.type == "float"
        }
        return Report(
            **numbers,
            violations=violations_from(given["violations"]),
            instants=as_instance(given["instants"], "instants", int),
            axes=None if least == math.inf else KnownAxes(least),
            notes=as_tuple_of(given["notes"], "notes", str),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: is no saved report: {type(error).__name__}: {error}") from error


def violations_from(given: Any) -> tuple[Violation, ...]:
    """Violations that `to_plain` wrote; errors as Python has them."""
    from ggo_factors.support.plain import read_number

    return tuple(
        Violation(
            kind=as_instance(row["kind"], "kind", str),
            frame=None if row["frame"] is None else read_number(row["frame"], "frame"),
            value=read_number(row["value"], "value"),
            limit=read_number(row["limit"], "limit"),
            unit=as_instance(row["unit"], "unit", str),
            note=as_instance(row["note"], "note", str),
        )
        for row in given
    )
