"""Knee edge: keeps both knees from bending backwards (paper, Eq. res_2, squared)."""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.factors.checked import FRAME_SIZE, Edge, EdgeFunction

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


def knee_edge(frame: int, gain: float) -> Edge:
    """The knee edge of `frame`; `gain` is the paper's lambda."""
    return Edge("knee", (frame,), 2, gain, knee_function())


def knee_factor(frame: int, gain: float) -> gtsam.CustomFactor:
    """`knee_edge` as a factor."""
    return knee_edge(frame, gain).factor()
