"""A user's factor on frames of a gait, in a graph that has other frames: fewer of them, or only those still ahead.

A graph of fewer frames solves for the offset from the base gait, which runs straight between two of its frames, as it
does for the library's own edges at a higher sampling rate (`between`). A frame that is walked is a constant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import gtsam
import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE, checked_factor, frame_of_key
from ggo_factors.support.inputs import Array


@dataclass(frozen=True, eq=False)
class Place:
    """Where a frame of the gait is in the graph: `offset + sum of share * frame`.

    Attributes:
        offset: in [rad], shape (4,).
        shares: of frames of the graph, by number; none where the frame is given.
    """

    offset: Array
    shares: Mapping[int, float]


def placed_factor(
    factor: gtsam.NoiseModelFactor, places: Mapping[int, Place], edge: str
) -> gtsam.NoiseModelFactor | None:
    """A factor on frames of the gait as one on frames of the graph; None where all its frames are given.

    Args:
        factor: on keys `g<frame>`, which GTSAM cannot give other keys where it is a custom factor.
        places: of each of its frames.
        edge: what to call it in an error.
    """
    keys = list(dict.fromkeys(factor.keys()))
    at = [places[frame_of_key(key) or 0] for key in keys]
    frames = sorted({n for place in at for n in place.shares})
    if not frames:
        return None
    noise, column = factor.noiseModel(), {n: k for k, n in enumerate(frames)}

    def function(*arguments: Array | bool) -> tuple[Array, tuple[Array, ...]]:
        *given, want_jacobian = arguments
        values = gtsam.Values()
        for key, place in zip(keys, at, strict=True):
            frame = place.offset.copy()
            for n, share in place.shares.items():
                frame += share * given[column[n]]
            values.insert(key, frame)
        error = factor.unwhitenedError(values)
        if not want_jacobian:
            return error, ()
        jacobian, blocks = _jacobian(factor, values, error), np.zeros((len(frames), len(error), FRAME_SIZE))
        for k, key in enumerate(factor.keys()):
            for n, share in at[keys.index(key)].shares.items():
                blocks[column[n]] += share * jacobian[:, FRAME_SIZE * k : FRAME_SIZE * (k + 1)]
        return error, tuple(map(np.asfortranarray, blocks))

    return checked_factor(edge, frames, factor.dim(), function, noise)


def _jacobian(factor: gtsam.NoiseModelFactor, values: gtsam.Values, error: Array) -> Array:
    """The Jacobian of a factor's error, shape (rows, k), which GTSAM gives whitened only."""
    linear, noise, weight = factor.linearize(values), factor.noiseModel(), 1.0
    assert isinstance(linear, gtsam.JacobianFactor)  # of a noise model's factor
    if isinstance(noise, gtsam.noiseModel.Robust):
        # GTSAM has multiplied it by the square root of the robust loss's weight too.
        noise = noise.noise()
        length = float(np.linalg.norm(noise.whiten(error)))
        weight = float(np.linalg.norm(linear.getb())) / length if length else 1.0
    root = np.stack([noise.whiten(row) for row in np.eye(len(error))], -1)
    jacobian = np.array(linear.getA())
    return np.asarray(np.linalg.solve(root, jacobian / weight if weight else jacobian))
