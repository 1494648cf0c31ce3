"""Factors of a user's own on frames of a step, looked at, and on the frames that the step is solved at."""

from __future__ import annotations

import gtsam

from ggo_factors.factors import Place, placed_factor, require_fit
from ggo_factors.factors.checked import CheckedFactor
from ggo_factors.graph.problem import factor_frames
from ggo_factors.graph.sampling import Sampling
from ggo_factors.motion.gait import Gait
from ggo_factors.procedures.task import StepTask


def own_factors(task: StepTask, rest: Gait, fine: Gait) -> tuple[gtsam.NoiseModelFactor, ...]:
    """The factors of a step that have a frame which is still ahead, on frames of `rest`.

    Args:
        task: the step.
        rest: the base gait from the present frame on, at the rate that the step is solved at.
        fine: the same at its own rate.

    Raises:
        InputError: where a factor does not fit the step.
    """
    done, made = len(task.walked) - 1, []
    sampling = Sampling(rest.frames, fine.frames)
    for number, factor in enumerate(task.step.factors):
        name = f"{task.name}: factors[{number}]"
        frames = factor_frames(factor, len(task.base), name)
        require_fit(factor, task.base.frames, name)
        whole = rest is fine and not done
        if whole and (isinstance(factor, CheckedFactor) or not isinstance(factor, gtsam.CustomFactor)):
            made.append(factor)
            continue
        places = {}
        for n in frames:
            shares, offset = ({}, task.walked[n]) if n < done else sampling.between(n - done)
            places[n] = Place(offset, shares)
        edge = factor.edge if isinstance(factor, CheckedFactor) else type(factor).__name__
        if not whole:
            edge += f" (of the step's frames {sorted(frames)})"
        # A raw factor is placed in any case: what its function raises has a name then.
        placed = placed_factor(factor, places, edge)
        if placed is not None:
            made.append(placed)
    return tuple(made)
