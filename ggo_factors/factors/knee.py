"""Knee edge: keeps both knees from bending backwards (paper, Eq. res_2, squared)."""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.factors.checked import FRAME_SIZE, EdgeFunction, checked_factor, precision

SUPPORT, SWING = 1, 3  # columns of beta1 and beta2


def knee_function() -> EdgeFunction:
    """Error `[ReLU(-beta1), ReLU(-beta2)]` in [rad], 2 rows."""

    def evaluate(frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        error, block = np.zeros(2), np.zeros((2, FRAME_SIZE), order="F")
        for row, column in enumerate((SUPPORT, SWING)):
            if frame[column] < 0.0:
                error[row], block[row, column] = -frame[column], -1.0
        return error, (block,)

    return evaluate


def knee_factor(frame: int, gain: float) -> gtsam.CustomFactor:
    """The knee edge of `frame`; `gain` is the paper's lambda."""
    return checked_factor("knee", (frame,), 2, knee_function(), precision(2, gain))
