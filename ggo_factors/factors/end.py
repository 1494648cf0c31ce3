"""End edges: bring P onto its foothold, turn the shank (paper, Eq. end_3, squared), hold a pose."""

from __future__ import annotations

import math

import gtsam
import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.factors.anchor import anchor_function
from ggo_factors.factors.checked import FRAME_SIZE, EdgeFunction, checked_factor, precision
from ggo_factors.model import LegModel


def foothold_function(model: LegModel, foothold: tuple[float, float]) -> EdgeFunction:
    """Error `P - foothold` in [m], 2 rows."""
    target_x, target_y = foothold

    def evaluate(frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        px, py, row_x, row_y = model.endpoint_rows(frame)
        return np.array([px - target_x, py - target_y]), (np.array([row_x, row_y], order="F"),)

    return evaluate


def foothold_factor(frame: int, model: LegModel, foothold: tuple[float, float], gain: float) -> gtsam.CustomFactor:
    """The end edge of `frame` onto `foothold` in [m]; `gain` is the paper's omega, infinite for a hard edge."""
    return checked_factor("end", (frame,), 2, foothold_function(model, foothold), precision(2, gain))


def shank_angle(frame: Array) -> float:
    """Angle of the swinging shank to the ground in [rad], pi/2 where it is upright.

    The paper's epsilon, alpha2 - beta2, is the angle from the vertical: with its target of 90 degrees the shank
    would lie flat. Here it is pi/2 + alpha2 - beta2.
    """
    return math.pi / 2.0 + float(frame[2] - frame[3])


def shank_function(angle: float) -> EdgeFunction:
    """Error `epsilon - angle` in [rad], 1 row."""
    block = np.array([[0.0, 0.0, 1.0, -1.0]], order="F")

    def evaluate(frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        return np.array([shank_angle(frame) - angle]), (block,)

    return evaluate


def shank_factor(frame: int, angle: float, gain: float) -> gtsam.CustomFactor:
    """The edge that turns the swinging shank of `frame` to `angle` in [rad] from the ground."""
    return checked_factor("shank", (frame,), 1, shank_function(angle), precision(1, gain))


def pose_factor(frame: int, pose: Array, gain: float) -> gtsam.CustomFactor:
    """The edge that draws the whole of `frame` to `pose`, shape (4,) in [rad]: an anchor that gives way."""
    return checked_factor("pose", (frame,), FRAME_SIZE, anchor_function(pose), precision(FRAME_SIZE, gain))
