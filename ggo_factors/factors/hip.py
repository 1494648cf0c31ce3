"""Hip edge: keeps the supporting leg from giving way (ours; the paper leaves the posture to the residual edges)."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, ManyFunction, PointFunction
from ggo_factors.model import LegModel


@dataclass(frozen=True)
class HipFunction(PointFunction):
    """Error `ReLU(least - Hy)` in [m], 1 row; Hy is the height of the hip over the supporting ankle.

    Attributes:
        model: the legs.
        least: least height of the hip in [m].
    """

    model: LegModel
    least: float

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobian."""
        error, block = np.zeros(1), np.zeros((1, FRAME_SIZE), order="F")
        a1, b1 = float(frame[0]), float(frame[1])
        low = self.least - self.model.thigh * math.cos(a1) - self.model.shank * math.cos(a1 - b1)
        if low > 0.0:
            shank = self.model.shank * math.sin(a1 - b1)
            error[0], block[0, :2] = low, (self.model.thigh * math.sin(a1) + shank, -shank)
        return error, (block,)

    def curvature(self, frame: Array) -> Array:
        """Sum over the rows of error times second derivative, shape (4, 4)."""
        bent = np.zeros((FRAME_SIZE, FRAME_SIZE))
        (low,), _ = self(frame, False)
        if low > 0.0:
            thigh = low * self.model.thigh * math.cos(frame[0])
            shank = low * self.model.shank * math.cos(frame[0] - frame[1])
            bent[:2, :2] = [[thigh + shank, -shank], [-shank, shank]]
        return bent

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        return HipFunction, self.model

    @staticmethod
    def together(functions: Sequence[HipFunction]) -> ManyFunction:
        """The same for as many frames as functions."""
        model, least = functions[0].model, np.array([function.least for function in functions])

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            a1, u1 = frames[:, 0], frames[:, 0] - frames[:, 1]
            low = least - model.thigh * np.cos(a1) - model.shank * np.cos(u1)
            under = low > 0.0
            blocks = np.zeros((len(frames), 1, FRAME_SIZE))
            shank = model.shank * np.sin(u1)
            blocks[:, 0, 0], blocks[:, 0, 1] = (model.thigh * np.sin(a1) + shank) * under, -shank * under
            return np.where(under, low, 0.0)[:, None], blocks

        return evaluate


def hip_edge(frame: int, model: LegModel, least: float, gain: float) -> Edge:
    """The hip edge of `frame`; arguments as `HipFunction`."""
    return Edge("hip", (frame,), 1, gain, HipFunction(model, least))
