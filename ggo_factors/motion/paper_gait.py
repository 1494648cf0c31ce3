"""The paper's base gait, in closed form."""

from __future__ import annotations

import numpy as np

from ggo_factors.motion.gait import PAPER_MODEL, Gait
from ggo_factors.support.inputs import Array, as_bool, as_count


def paper_base_gait(frames: int = 51, endpoint: bool = True) -> Gait:
    """The paper's base gait, its Eq. (trajectory): half a cycle of 1 s, swing from 0.89 s, support from 1.39 s.

    Args:
        frames: number of frames.
        endpoint: whether the last frame is the pose at landing; without it the next step would begin there.

    Raises:
        InputError: where `frames` is below 2, or `endpoint` is neither True nor False.
    """
    count = as_count(frames, "frames", 2)
    time, dt = np.linspace(0.0, 0.5, count, endpoint=as_bool(endpoint, "endpoint"), retstep=True)

    def hip(t: Array) -> Array:
        w = 2.0 * np.pi * t
        return np.asarray(3.76 + 12.94 * np.sin(w - 0.29) + 3.76 + 4.78 * np.sin(2.0 * w - 0.64))

    def knee(t: Array) -> Array:
        w = 2.0 * np.pi * t
        return np.asarray(11.35 + 23.69 * np.sin(w + 1.02) + 11.35 + 18.54 * np.sin(2.0 * w + 0.41))

    swing, support = time + 0.89, time + 1.39
    angles_deg = np.stack([hip(support), knee(support), hip(swing), knee(swing)], -1)
    origin = "Zhang et al., Gait Graph Optimization, Eq. (trajectory)"
    return Gait(np.radians(angles_deg), float(dt), "paper base gait", origin, PAPER_MODEL)
