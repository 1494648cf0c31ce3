"""Obstacle edge: lifts P over a height (paper, Eq. obs_1), and holds it there."""

from __future__ import annotations

import math

import gtsam
import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.factors.checked import Edge, EdgeFunction
from ggo_factors.model import LegModel


def obstacle_function(model: LegModel, height: float, gamma: float, hold: float, hold_x: float) -> EdgeFunction:
    """Error `[exp(gamma ReLU(height - Py)) - 1]`, and with a hold `rho (Px - hold_x)` as second row.

    Args:
        model: the legs.
        height: height that P must clear, the margin included, in [m].
        gamma: steepness in [1/m].
        hold: rho, pull towards `hold_x` in [1/m]; 0 leaves the row out.
        hold_x: where P is held in [m].
    """
    rows = 2 if hold else 1

    def evaluate(frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        px, py, row_x, row_y = model.endpoint_rows(frame)
        growth = math.exp(gamma * (height - py)) if py < height else 1.0
        error = np.array([growth - 1.0, hold * (px - hold_x)][:rows])
        if not want_jacobian:
            return error, ()
        slope = -gamma * growth if py < height else 0.0
        lines = ([slope * value for value in row_y], [hold * value for value in row_x])
        return error, (np.array(lines[:rows], order="F"),)

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
    """The obstacle edge of `frame`; arguments as `obstacle_function`."""
    function = obstacle_function(model, height, gamma, hold, hold_x)

    def curvature(at: Array) -> Array:
        px, py, _, row_y = model.endpoint_rows(at)
        by_x, low = hold * hold * (px - hold_x), height - py
        if low <= 0.0:
            return model.endpoint_hessian(at, by_x, 0.0)
        growth = math.exp(gamma * low)
        pull = gamma * growth * (growth - 1.0)
        return model.endpoint_hessian(at, by_x, -pull) + gamma * pull * np.multiply.outer(row_y, row_y)

    return Edge("obstacle", (frame,), 2 if hold else 1, gain, function, curvature)


def obstacle_factor(frame: int, model: LegModel, height: float, **weights: float) -> gtsam.CustomFactor:
    """`obstacle_edge` as a factor."""
    return obstacle_edge(frame, model, height, **weights).factor()
