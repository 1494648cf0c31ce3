"""What one step of a walk must do, and the check of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import gtsam
import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.check.report import STANDARD, Report, Tolerances
from ggo_factors.check.verify import Asked, look_at
from ggo_factors.errors import InputError
from ggo_factors.factors import frames_of
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import LEVEL, Gap, Ground, Obstacle
from ggo_factors.support.inputs import Array, as_angles, as_array, as_instance, as_number, as_tuple_of

STANDING: Array = as_array(np.zeros(4), "STANDING", (4,))
"""The frame of a walker who stands straight, feet together."""
MOST_LIFT = 0.5
"""Nobody lifts a foot further over a box, in [m]."""
ALIKE = 1e-6
"""Legs whose angles differ by no more than this, in [rad], stand alike: the walker stands."""


def stands_in(frame: Array) -> bool:
    """Whether a walker stands in a frame, shape (4,) in [rad]: both legs have the same angles."""
    return bool(np.abs(frame[:2] - frame[2:]).max() <= ALIKE)


def closes(step: Step) -> bool:
    """Whether a step ends standing, with the feet together."""
    return step.end_frame is not None and stands_in(np.asarray(step.end_frame))


@dataclass(frozen=True)
class Step:
    """What one step of a walk must do. All places are in the body frame of this step.

    Attributes:
        foothold: where the swing ankle must land in [m], shape (2,); may be left out where `end_frame` is given.
        obstacles: boxes to step over.
        gaps: pits with no foothold in them.
        shank_angle: target angle of the swinging shank to the ground at landing in [rad], or None.
        ground: height of the ground; level at 0 by default.
        end_frame: frame to end in exactly, shape (4,) in [rad], for example `STANDING`; or None.
        lift: height over boxes that the swing ankle is drawn to in [m], where that is more than it must keep; it gives
            way to all else, and the check does not ask for it. Not over one that only stands for the edge of a riser.
        factors: GTSAM factors of your own, with a noise model, on frames of this step: ``gtsam.symbol("g", n)`` is
            frame n of the base gait that it bends, at that gait's own rate. `checked_factor` makes them. A step of more
            than 100 motions is solved at fewer frames, and meets them to about 1e-4 rad between two of those (1e-3
            without smoothness). The check does not know them, and files do not carry them.

    Raises:
        InputError: where there is neither foothold nor end frame, or a value is unusable.
    """

    foothold: tuple[float, float] | None = None
    obstacles: tuple[Obstacle, ...] = ()
    gaps: tuple[Gap, ...] = ()
    shank_angle: float | None = None
    ground: Ground = LEVEL
    end_frame: tuple[float, float, float, float] | None = None
    lift: float = 0.0
    factors: tuple[gtsam.NoiseModelFactor, ...] = field(default=(), repr=False)

    if TYPE_CHECKING:
        # For type checkers: what is made a tuple when it is made may be any list or array.
        def __init__(
            self,
            foothold: ArrayLike | None = None,
            obstacles: Iterable[Obstacle] = (),
            gaps: Iterable[Gap] = (),
            shank_angle: float | None = None,
            ground: Ground = LEVEL,
            end_frame: ArrayLike | None = None,
            lift: float = 0.0,
            factors: Iterable[gtsam.NoiseModelFactor] = (),
        ) -> None: ...

    def __post_init__(self) -> None:
        if self.foothold is not None:
            object.__setattr__(self, "foothold", tuple(as_array(self.foothold, "foothold", (2,)).tolist()))
        if self.end_frame is not None:
            object.__setattr__(self, "end_frame", tuple(as_angles(self.end_frame, "end_frame", (4,)).tolist()))
        if self.foothold is None and self.end_frame is None:
            raise InputError("foothold: a step needs a foothold, or an end frame")
        if self.shank_angle is not None:
            object.__setattr__(self, "shank_angle", float(as_angles(self.shank_angle, "shank_angle", ())))
        object.__setattr__(self, "obstacles", as_tuple_of(self.obstacles, "obstacles", Obstacle))
        object.__setattr__(self, "gaps", as_tuple_of(self.gaps, "gaps", Gap))
        as_instance(self.ground, "ground", Ground)
        lift = as_number(self.lift, "lift", at_least=0.0, at_most=MOST_LIFT, unit="m")
        object.__setattr__(self, "lift", lift)
        object.__setattr__(self, "factors", as_tuple_of(self.factors, "factors", gtsam.NoiseModelFactor))
        for number, factor in enumerate(self.factors):
            frames_of(factor, f"factors[{number}]")

    def landing(self, model: LegModel) -> tuple[float, float]:
        """Where the swing ankle lands in [m]: the foothold, or where the end frame puts it."""
        if self.foothold is not None:
            return self.foothold
        x, y = model.endpoint(np.array(self.end_frame)).tolist()
        return (x, y)

    def shifted(self, x: float, y: float) -> Step:
        """The step as seen from a body frame that stands `x` further on and `y` higher, both in [m]."""
        foothold = None if self.foothold is None else (self.foothold[0] - x, self.foothold[1] - y)
        return replace(
            self,
            foothold=foothold,
            obstacles=tuple(obstacle.shifted(x, y) for obstacle in self.obstacles),
            gaps=tuple(gap.shifted(x) for gap in self.gaps),
            ground=self.ground.shifted(x, y),
        )


def across(
    plan: Sequence[Step], model: LegModel, obstacles: Sequence[Obstacle], gaps: Sequence[Gap]
) -> tuple[Step, ...]:
    """Steps on level ground, each with all obstacles and gaps, as seen from its own supporting foot.

    Args:
        plan: the steps.
        model: the legs.
        obstacles: boxes in the body frame of the first step.
        gaps: pits in the body frame of the first step.
    """
    placed, stands = [], 0.0
    for step in plan:
        boxes = [box.shifted(stands) for box in obstacles]
        pits = [gap.shifted(stands) for gap in gaps]
        placed.append(replace(step, obstacles=(*step.obstacles, *boxes), gaps=(*step.gaps, *pits)))
        stands += step.landing(model)[0]
    return tuple(placed)


def verify_step(
    gait: Gait,
    step: Step,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    tolerances: Tolerances | None = None,
) -> Report:
    """The dense check of one step against what was asked of it; see `verify`."""
    legs = gait.legs(model)
    asked = Asked(
        start=None if start is None else as_angles(start, "start", (4,)),
        obstacles=step.obstacles,
        gaps=step.gaps,
        foothold=step.landing(legs),
        shank_angle=step.shank_angle,
        ground=step.ground,
        end_frame=None if step.end_frame is None else np.array(step.end_frame),
        tolerances=STANDARD if tolerances is None else as_instance(tolerances, "tolerances", Tolerances),
    )
    return look_at(gait, legs, asked)
