"""Limit edges: what a joint must not go beyond, as hinges on its angle, speed and acceleration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, LinearFunction
from ggo_factors.support.inputs import Array


def limit_edge(
    name: str, frames: Sequence[int], lower: Array, upper: Array, scale: Array, gain: float, shift: Array | None = None
) -> Edge:
    """The hinge on a difference of neighbouring frames: none for an angle, first for a speed, second for acceleration.

    Error `[ReLU(lower - D), ReLU(D - upper)] / scale`, 8 rows, D the difference of as many orders as there are frames
    beyond the first.

    Args:
        name: what to call it.
        frames: one, two or three neighbouring frames.
        lower: least difference, shape (4,) in [rad].
        upper: largest difference, shape (4,) in [rad].
        scale: difference beyond the limit that counts as an error of 1, shape (4,) in [rad].
        gain: gain of the edge.
        shift: how far inside the limit it aims, shape (8,), in units of the error.
    """
    identity = np.eye(FRAME_SIZE) / scale
    both = np.concatenate([-identity, identity])
    weights = ((1.0,), (-1.0, 1.0), (1.0, -2.0, 1.0))[len(frames) - 1]
    blocks = [np.asfortranarray(weight * both) for weight in weights]
    target = np.concatenate([-lower / scale, upper / scale]) - (0.0 if shift is None else shift)
    return Edge(name, tuple(frames), 2 * FRAME_SIZE, gain, LinearFunction(blocks, target, hinge=True))
