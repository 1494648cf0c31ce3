"""How near gaits are to what people did: their own steps beside gaits for the same start frames and footholds."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ggo_factors.errors import InfeasibleGaitError
from ggo_factors.evaluate.rivals import RIVALS, first_rate
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.graph.touchdown import touchdown_posture
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import Foot, LegModel
from ggo_factors.motion.style import Style
from ggo_factors.motion.terrain import Ground
from ggo_factors.procedures.steps import walk
from ggo_factors.support.data_frame import pandas
from ggo_factors.support.inputs import Array, short_text
from ggo_factors.walking.step import Step

LIBRARY: Mapping[str, Mapping[str, Any]] = {
    "ggo": {},
    "paper_graph": {"smoothness": 0.0, "start_rate": None},
}
"""The library's own gaits, each with what `walk` is asked for besides: as by default, and the graph of the paper."""
METHODS = (*LIBRARY, *RIVALS)
"""The names of all that is compared, in the order of tables; `STYLED` comes after the first where there is a style."""
STYLED = "ggo_style"
"""The library's gaits as by default, with a style beside."""
PARTS = ("first_third", "middle_third", "last_third")
"""The parts of a step that have numbers of their own."""
LEAST_FRAMES = 10
"""Fewest frames of a base gait that can be compared: three in each part, and those at both ends."""
FORMAT_VERSION = 1
"""Version of the JSON; raised when a key changes its meaning or goes."""
UNDER_FOOT, PIT = 0.01, -0.5
"""How far the ground under a foot reaches to either side, and the height of the ground elsewhere, both in [m]: where an
ankle is at a heel strike, one heel lifted, says nothing of the ground between the feet. With 0.02 m the swing ankle
passes over the ground that it lands on, is lifted there, and steps of 21 frames miss their foothold."""


@dataclass(frozen=True, eq=False)
class ComparedStep:
    """One recorded step, and the gaits that were made for its start frame, its motion there and its foothold.

    Attributes:
        leg: the swinging leg, ``"right"`` or ``"left"``.
        start: time in the recording at which it starts, in [s].
        end: time at which it lands in [s].
        foothold: where its swing ankle lands, from the supporting one, in [m].
        recorded: what the person did: angles at equal shares of the step in [rad], shape (m, 4).
        made: frames by method in [rad], shape (m, 4) each.
        refused: why a method has none, by method.
    """

    leg: str
    start: float
    end: float
    foothold: tuple[float, float]
    recorded: Array = field(repr=False)
    made: Mapping[str, Array] = field(repr=False)
    refused: Mapping[str, str]

    def rmse_deg(self, method: str) -> float:
        """Root mean square error over frames and joints in degrees; NaN where the method has no gait."""
        return rms_deg(self.made[method] - self.recorded) if method in self.made else math.nan

    def to_json(self) -> dict[str, Any]:
        """The same for a JSON file, without the frames."""
        return {
            "leg": self.leg,
            "start_s": self.start,
            "end_s": self.end,
            "foothold_m": list(self.foothold),
            "rmse_deg": {
                method: _finite(self.rmse_deg(method))
                for method in methods_of(STYLED in self.made or STYLED in self.refused)
            },
            "refused": dict(self.refused),
        }


@dataclass(frozen=True, eq=False)
class Comparison:
    """A base gait against the steps of a recording.

    All errors are over the steps for which every method has a gait, `counted`; given frames at the start count too.

    Attributes:
        base: name of the base gait.
        source: the recording.
        activity: ``"level"``, ``"stairs-up"`` or ``"stairs-down"``.
        steps: the steps that were compared, in the order of time.
        skipped: how many steps before them were left out as asked.
        from_ground: how many stair swings were left out since they start from the ground and not from a stair.
        knees_raised: the constant in [rad] that was added to all knees, of the base gait and of the person: some bent
            backwards, which no gait of the library does.
        model: the legs that all angles were read with.
        style: what the gaits of `STYLED` vary by; None where there are none.
        why_no_style: why a style that was asked for, or looked for, is not used; "" where it is, or none was.
    """

    base: str
    source: str
    activity: str
    steps: tuple[ComparedStep, ...]
    skipped: int
    from_ground: int
    knees_raised: float
    model: LegModel
    style: Style | None = None
    why_no_style: str = ""

    def __repr__(self) -> str:
        steps = f"{len(self.counted)} of {len(self.steps)} steps of {short_text(self.source)}"
        off = f"{self.rmse_deg(METHODS[0]):.2f} degrees off, no change {self.rmse_deg('no_change'):.2f}"
        return f"Comparison({short_text(self.base)}, {steps}, {off})"

    def _repr_html_(self) -> str:
        from ggo_factors.notebook.card import card  # only here: nothing but a notebook needs it

        def told(method: str) -> str:
            refused = sum(self.refusals(method).values())
            return f"{self.rmse_deg(method):.2f} degrees{f', {refused} steps refused' if refused else ''}"

        facts = {
            "recording": f"{self.source}, {self.activity}",
            "base gait": self.base,
            "steps": f"{len(self.counted)} of {len(self.steps)}, for which every method has a gait",
            "RMS error": [f"{method.replace('_', ' ')}: {told(method)}" for method in METHODS],
        }
        return card("Comparison with recorded steps", facts)

    @property
    def methods(self) -> tuple[str, ...]:
        """The names of all that was compared, in the order of tables."""
        return methods_of(self.style is not None)

    @property
    def counted(self) -> tuple[ComparedStep, ...]:
        """The steps for which every method has a gait."""
        return tuple(step for step in self.steps if not step.refused)

    def errors(self, method: str) -> Array:
        """The method's angles less the person's in [rad], shape (counted steps, m, 4)."""
        return np.array([step.made[method] - step.recorded for step in self.counted])

    def rmse_deg(self, method: str) -> float:
        """Root mean square error over steps, frames and joints in degrees; NaN where no step counts."""
        return rms_deg(self.errors(method))

    def ratio(self, method: str) -> float:
        """How many times as far from the person as no change; NaN where no step counts or that is not off."""
        off = self.rmse_deg("no_change")
        return self.rmse_deg(method) / off if off > 0.0 else math.nan

    def by_joint_and_part_deg(self, method: str) -> Array:
        """Root mean square errors in degrees of `JOINTS` in `PARTS` of the step, shape (4, 3)."""
        errors = self.errors(method)
        if not len(errors):
            return np.full((len(JOINTS), len(PARTS)), math.nan)
        thirds = np.array_split(errors, len(PARTS), axis=1)
        return np.degrees([np.sqrt(np.mean(third**2, axis=(0, 1))) for third in thirds]).T

    def by_joint_deg(self, method: str) -> Array:
        """Root mean square error of each joint in degrees, shape (4,)."""
        return np.array([rms_deg(self.errors(method)[..., n : n + 1]) for n in range(len(JOINTS))])

    def by_part_deg(self, method: str) -> Array:
        """Root mean square error of each part of the step in degrees, shape (3,)."""
        return np.asarray(np.sqrt(np.mean(self.by_joint_and_part_deg(method) ** 2, axis=0)))

    def by_frame_deg(self, method: str) -> Array:
        """Root mean square error over the steps of each frame and joint in degrees, shape (m, 4)."""
        return np.asarray(np.degrees(np.sqrt(np.mean(self.errors(method) ** 2, axis=0))))

    def foothold_off(self, method: str) -> float:
        """Mean distance of the landing from the person's own in [m]; NaN where no step counts."""
        off = [self.model.endpoint(step.made[method][-1]) - step.foothold for step in self.counted]
        return float(np.linalg.norm(off, axis=1).mean()) if off else math.nan

    def refusals(self, method: str) -> dict[str, int]:
        """How many steps the method has no gait for, by reason without its numbers, the most frequent first."""
        refused = [step.refused[method] for step in self.steps if method in step.refused]
        reasons = Counter(reason.rpartition(": ")[0] or reason for reason in refused)
        return dict(reasons.most_common())

    def to_json(self) -> dict[str, Any]:
        """The same for a JSON file, angles in degrees; null where no step counts."""
        return {
            "format_version": FORMAT_VERSION,
            "base": self.base,
            "source": self.source,
            "activity": self.activity,
            "skipped": self.skipped,
            "from_ground": self.from_ground,
            "compared": len(self.steps),
            "counted": len(self.counted),
            "knees_raised_deg": math.degrees(self.knees_raised),
            "style": None if self.style is None else {"steps": self.style.steps, "fingerprint": self.style.fingerprint},
            "why_no_style": self.why_no_style,
            "methods": {method: self._numbers(method) for method in self.methods},
            "steps": [step.to_json() for step in self.steps],
        }

    def to_dataframe(self) -> Any:
        """A `pandas.DataFrame` with a row for each step: leg, start and end in [s], the RMSE of each method in degrees.

        Raises:
            ImportError: where pandas is not installed.
        """
        return pandas().DataFrame(
            {"leg": step.leg, "start": step.start, "end": step.end}
            | {f"{method}_deg": step.rmse_deg(method) for method in self.methods}
            for step in self.steps
        )

    def _numbers(self, method: str) -> dict[str, Any]:
        both = self.by_joint_and_part_deg(method).tolist()
        off = self.foothold_off(method) * 1e3
        return {
            "rmse_deg": _finite(self.rmse_deg(method)),
            "ratio_to_no_change": _finite(self.ratio(method)),
            "by_joint_deg": _named(JOINTS, self.by_joint_deg(method)),
            "by_part_deg": _named(PARTS, self.by_part_deg(method)),
            "by_joint_and_part_deg": {n: _named(PARTS, row) for n, row in zip(JOINTS, both, strict=True)},
            "foothold_off_mm": _finite(off),
            "refused": self.refusals(method),
        }


def methods_of(styled: bool) -> tuple[str, ...]:
    """The names of all that is compared, in the order of tables."""
    return (METHODS[0], STYLED, *METHODS[1:]) if styled else METHODS


def compare_step(base: Gait, frames: Array, style: Style | None = None) -> tuple[dict[str, Array], dict[str, str]]:
    """What each method makes of a base gait for the start, its motion and the foothold of a person's step.

    Legs have no soles and no thickness here: a recording of angles does not tell what they stood on or beside.

    Args:
        base: the base gait, with its legs.
        frames: the person's step at as many equal shares, shape (m, 4) in [rad].
        style: how the person varies steps, for `STYLED`; without it that is not among the methods.

    Returns:
        Frames in [rad], shape (m, 4), of each method that has them; why the others have none.
    """
    legs = replace(base.legs(), foot=Foot(), thigh_radius=0.0, shank_radius=0.0)
    base = replace(base, model=legs)
    x, y = legs.endpoint(frames[-1]).tolist()
    motion = first_rate(frames)
    made, refused = dict[str, Array](), dict[str, str]()
    library = LIBRARY if style is None else {**LIBRARY, STYLED: {"style": style}}
    for method, asked in library.items():
        try:
            step = Step((x, y), ground=_under_feet(x, y))
            bent = walk(base, [step], start=frames[0], **{"start_rate": motion / base.duration, **asked})
            made[method] = bent.gaits[0].frames
        except InfeasibleGaitError as error:
            refused[method] = str(error).removeprefix("step 1: ").partition(";")[0]
    landing = touchdown_posture(legs, base.frames[-1], (x, y))
    for method, rival in RIVALS.items():
        if landing is None:
            refused[method] = "no touchdown posture"
        else:
            made[method] = rival(base.frames, frames[0], motion, landing)
    return made, refused


def _under_feet(x: float, y: float) -> Ground:
    """Ground under a supporting foot and one that lands on (x, y), and nowhere else.

    Raises:
        InfeasibleGaitError: where that one does not land before the supporting one.
    """
    if x <= 2.0 * UNDER_FOOT:
        raise InfeasibleGaitError(f"the foot lands on the supporting one or behind it: {x:.3f} m ahead")
    return Ground((-UNDER_FOOT, UNDER_FOOT, x - UNDER_FOOT), (PIT, 0.0, PIT, y))


def rms_deg(angles: Array) -> float:
    """Root mean square of angles in [rad], in degrees; NaN where there are none."""
    return float(np.degrees(np.sqrt(np.mean(angles**2)))) if angles.size else math.nan


def _named(names: tuple[str, ...], values: Any) -> dict[str, float | None]:
    return {name: _finite(float(value)) for name, value in zip(names, values, strict=True)}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
