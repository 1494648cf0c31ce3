"""Whether the other foot gets over the same boxes in the step after."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from ggo_factors.errors import InfeasibleGaitError
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.procedures.task import StepSolution
from ggo_factors.procedures.walker import Walker, Way
from ggo_factors.walking.step import Step

SHARE_OF_WORK = 0.5
"""The step after may take this share of the work of a step."""
SPARE = 0.01
"""How far from boxes and pits its foothold is put, in [m]."""


def with_next_step(walker: Walker, made: StepSolution) -> StepSolution:
    """The solution of a step with the step after it, or with a note that says why there is none.

    The step after swings the other foot over the same boxes and pits, on level ground, to where the base gait would
    land, or as little further as keeps it out of them.

    Args:
        walker: the walker before the step.
        made: the step.
    """
    step = made.task.step
    if step.end_frame is not None or not step.obstacles or time.perf_counter() >= walker.settings.until:
        return made
    settings = replace(walker.settings, work=SHARE_OF_WORK * walker.settings.work, nearest=False)
    x, y = made.gait.endpoints(walker.model)[-1].tolist()
    boxes = tuple(box.shifted(x, y) for box in step.obstacles)
    pits = tuple(pit.shifted(x) for pit in step.gaps)
    faced = replace(walker, settings=settings).toward(step)
    after = faced.after(made.gait, step)
    lands = _foothold(after, boxes, pits)
    way = Way(faced, (made,), (0.0, 0.0), step)
    try:
        following = way.then(Step((lands, -y), boxes, pits), 2, 1).solutions[-1]
    except InfeasibleGaitError as error:
        said = f"no next step over the same boxes to {lands:.3f} m: {error}"
        return replace(made, report=replace(made.report, notes=(*made.report.notes, said)))
    return replace(made, next_step=following)


def _foothold(walker: Walker, boxes: tuple[Obstacle, ...], pits: tuple[Gap, ...]) -> float:
    """Where the next foot lands in [m]: as far as the base gait's, or a little further, out of boxes and pits."""
    own, foot = float(walker.base.endpoints(walker.model)[-1, 0]), walker.model.foot
    stretches = [(box.for_ankle(foot).x_start, box.for_ankle(foot).x_end) for box in boxes]
    stretches += [(pit.for_ankle(foot).x_start, pit.for_ankle(foot).x_end) for pit in pits]
    for begins, ends in sorted(stretches):
        if begins - SPARE < own < ends + SPARE:
            own = ends + SPARE
    return float(np.round(own, 6))
