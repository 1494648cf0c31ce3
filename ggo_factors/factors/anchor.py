"""Anchor: a frame that is given, as the first pose of a pose graph is."""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.factors.checked import FRAME_SIZE, EdgeFunction, checked_factor, precision


def anchor_function(target: Array) -> EdgeFunction:
    """Error `g - target` in [rad], 4 rows."""
    identity = np.eye(FRAME_SIZE, order="F")

    def evaluate(frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        return frame - target, (identity,)

    return evaluate


def anchor_factor(frame: int, target: Array) -> gtsam.CustomFactor:
    """The hard edge that keeps `frame` at `target`, shape (4,) in [rad]."""
    return checked_factor("anchor", (frame,), FRAME_SIZE, anchor_function(target), precision(FRAME_SIZE, np.inf))
