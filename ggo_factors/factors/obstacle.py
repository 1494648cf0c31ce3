"""Obstacle edge: lifts the swing ankle over a height (paper, Eq. obs_1), and holds its x while it does."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from operator import attrgetter

import gtsam
import numpy as np

from ggo_factors.factors.edge import Edge, ManyFunction, PointFunction
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

_NUMBERS = attrgetter("height", "gamma", "hold", "hold_x")


@dataclass(frozen=True)
class ObstacleFunction(PointFunction):
    """Error `[exp(gamma ReLU(height - Py)) - 1]`, and with a hold `rho (Px - hold_x)` as second row.

    (Px, Py) is the swing ankle.

    Attributes:
        model: the legs.
        height: height that the swing ankle must clear, the margin included, in [m].
        gamma: steepness in [1/m].
        hold: rho, pull towards `hold_x` in [1/m]; 0 leaves the row out.
        hold_x: x at which the swing ankle is held in [m].
    """

    model: LegModel
    height: float
    gamma: float
    hold: float = 0.0
    hold_x: float = 0.0

    @property
    def rows(self) -> int:
        """Length of the error."""
        return 2 if self.hold else 1

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobian."""
        px, py, row_x, row_y = self.model.endpoint_rows(frame)
        growth = math.exp(self.gamma * (self.height - py)) if py < self.height else 1.0
        error = np.array([growth - 1.0, self.hold * (px - self.hold_x)][: self.rows])
        if not want_jacobian:
            return error, ()
        slope = -self.gamma * growth if py < self.height else 0.0
        lines = ([slope * value for value in row_y], [self.hold * value for value in row_x])
        return error, (np.array(lines[: self.rows], order="F"),)

    def curvature(self, frame: Array) -> Array:
        """Sum over the rows of error times second derivative, shape (4, 4)."""
        px, py, _, row_y = self.model.endpoint_rows(frame)
        by_x, low = self.hold * self.hold * (px - self.hold_x), self.height - py
        if low <= 0.0:
            return self.model.endpoint_hessian(frame, by_x, 0.0)
        growth = math.exp(self.gamma * low)
        pull = self.gamma * growth * (growth - 1.0)
        return self.model.endpoint_hessian(frame, by_x, -pull) + self.gamma * pull * np.multiply.outer(row_y, row_y)

    def alike(self) -> Hashable:
        """What functions that are evaluated together have in common."""
        return ObstacleFunction, self.model, self.hold > 0.0

    @staticmethod
    def together(functions: Sequence[ObstacleFunction]) -> ManyFunction:
        """The same for as many frames as functions."""
        model, rows = functions[0].model, 2 if functions[0].hold else 1
        height, gamma, hold, hold_x = np.array(list(map(_NUMBERS, functions))).T

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            point, block = model.endpoint_and_jacobian(frames)
            low = height - point[:, 1]
            growth = np.exp(gamma * np.maximum(low, 0.0))
            error, turned = np.empty((len(frames), 2)), np.empty_like(block)
            error[:, 0], error[:, 1] = growth - 1.0, hold * (point[:, 0] - hold_x)
            turned[:, 0] = np.where(low > 0.0, -gamma * growth, 0.0)[:, None] * block[:, 1]
            turned[:, 1] = hold[:, None] * block[:, 0]
            return error[:, :rows], turned[:, :rows]

        return evaluate


def obstacle_edge(
    frame: int,
    model: LegModel,
    height: float,
    *,
    gamma: float = 4.0,
    hold: float = 0.0,
    hold_x: float = 0.0,
    gain: float = 1.0,
) -> Edge:
    """The obstacle edge of `frame`; arguments as `ObstacleFunction`."""
    function = ObstacleFunction(model, height, gamma, hold, hold_x)
    return Edge("obstacle", (frame,), 2 if hold else 1, gain, function)


def obstacle_factor(frame: int, model: LegModel, height: float, **weights: float) -> gtsam.CustomFactor:
    """`obstacle_edge` as a factor."""
    return obstacle_edge(frame, model, height, **weights).factor()
