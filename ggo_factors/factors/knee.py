"""Knee edge: keeps both knees from bending backwards (paper, Eq. res_2, squared)."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import gtsam
import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.factors.checked import FRAME_SIZE, Edge, ManyFunction, PointFunction

SUPPORT, SWING = 1, 3  # columns of beta1 and beta2


class KneeFunction(PointFunction):
    """Error `[ReLU(-beta1), ReLU(-beta2)]` in [rad], 2 rows."""

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobian."""
        error, block = np.zeros(2), np.zeros((2, FRAME_SIZE), order="F")
        for row, column in enumerate((SUPPORT, SWING)):
            if frame[column] < 0.0:
                error[row], block[row, column] = -frame[column], -1.0
        return error, (block,)

    def alike(self) -> Hashable:
        """What functions that are evaluated together have in common."""
        return KneeFunction

    @staticmethod
    def together(functions: Sequence[KneeFunction]) -> ManyFunction:
        """The same for as many frames as functions."""

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            bent = frames[:, [SUPPORT, SWING]]
            blocks = np.zeros((len(frames), 2, FRAME_SIZE))
            blocks[:, [0, 1], [SUPPORT, SWING]] = np.where(bent < 0.0, -1.0, 0.0)
            return np.maximum(-bent, 0.0), blocks

        return evaluate


def knee_edge(frame: int, gain: float) -> Edge:
    """The knee edge of `frame`; `gain` is the paper's lambda."""
    return Edge("knee", (frame,), 2, gain, KneeFunction())


def knee_factor(frame: int, gain: float) -> gtsam.CustomFactor:
    """`knee_edge` as a factor."""
    return knee_edge(frame, gain).factor()
