"""Where the feet stand: not in an obstacle, over a pit, or off the ground, whatever they do between."""

from __future__ import annotations

from collections.abc import Sequence

from ggo_factors.check.report import Tolerances
from ggo_factors.errors import Violation
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle


def misplaced(
    model: LegModel,
    start: tuple[float, float],
    landing: tuple[float, float],
    obstacles: Sequence[Obstacle],
    gaps: Sequence[Gap],
    ground: Ground | None,
    tolerances: Tolerances,
) -> list[Violation]:
    """What is wrong with where the feet stand, whatever they do between.

    Args:
        model: the legs.
        start: P at the start in [m].
        landing: P at the landing in [m].
        obstacles: boxes in the body frame of the step.
        gaps: pits in the body frame of the step.
        ground: height of the ground, or None where it is not known.
        tolerances: what may be off by how much.
    """
    found: list[Violation] = []
    x, y = landing
    feet = (("supporting foot", 0.0, 0.0), ("swinging foot's start", *start), ("foothold", x, y))
    for obstacle in obstacles:
        box = obstacle.for_ankle(model.foot)
        for name, at, height in feet:
            # An obstacle is in the way of a standing foot whatever its height; a foot may stand right on its top.
            if box.x_start <= at <= box.x_end and (name == "supporting foot" or height < box.height):
                near = box.x_start if at - box.x_start < box.x_end - at else box.x_end
                found.append(Violation(f"obstacle in the {name}", None, at, near, "m", str(obstacle)))
    for gap in gaps:
        pit = gap.for_ankle(model.foot)
        if pit.x_start < x < pit.x_end:
            near = pit.x_start if x - pit.x_start < pit.x_end - x else pit.x_end
            found.append(Violation("foothold in a gap", None, x, near, "m", str(gap)))
    if ground is not None:
        surface = ground.for_ankle(model.foot)
        for name, at, height in (feet[0], feet[2]):
            level = float(surface.height_at(at))
            if abs(height - level) > 2.0 * tolerances.foothold:
                # Where the ankle alone would stand right, it is the sole that reaches under a higher tread.
                stands = abs(height - float(ground.height_at(at))) <= 2.0 * tolerances.foothold
                fault = f"stair in the {name}" if stands else f"{name} off the ground"
                found.append(Violation(fault, None, height, level, "m"))
    return found
