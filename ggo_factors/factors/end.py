"""End edges: bring the swing ankle onto its foothold, turn the shank (paper, Eq. end_3, squared), hold a pose."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import gtsam
import numpy as np

from ggo_factors.factors.anchor import IDENTITY
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, LinearFunction, ManyFunction, PointFunction
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array


@dataclass(frozen=True)
class FootholdFunction(PointFunction):
    """Error `P - foothold` in [m], 2 rows; P is the swing ankle.

    Attributes:
        model: the legs.
        foothold: target of the swing ankle in [m].
    """

    model: LegModel
    foothold: tuple[float, float]

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobian."""
        px, py, row_x, row_y = self.model.endpoint_rows(frame)
        return np.array([px - self.foothold[0], py - self.foothold[1]]), (np.array([row_x, row_y], order="F"),)

    def curvature(self, frame: Array) -> Array:
        """Sum over the rows of error times second derivative, shape (4, 4)."""
        px, py, _, _ = self.model.endpoint_rows(frame)
        return self.model.endpoint_hessian(frame, px - self.foothold[0], py - self.foothold[1])

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        return FootholdFunction, self.model

    @staticmethod
    def together(functions: Sequence[FootholdFunction]) -> ManyFunction:
        """The same for as many frames as functions."""
        model, footholds = functions[0].model, np.array([function.foothold for function in functions])

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            point, block = model.endpoint_and_jacobian(frames)
            return point - footholds, block

        return evaluate


def foothold_edge(frame: int, model: LegModel, foothold: tuple[float, float], gain: float) -> Edge:
    """The end edge of `frame` onto `foothold` in [m]; `gain` is the paper's omega, infinite for a hard edge."""
    return Edge("end", (frame,), 2, gain, FootholdFunction(model, foothold))


def foothold_factor(frame: int, model: LegModel, foothold: tuple[float, float], gain: float) -> gtsam.CustomFactor:
    """`foothold_edge` as a factor."""
    return foothold_edge(frame, model, foothold, gain).factor()


def shank_angle(frame: Array) -> float:
    """Angle of the swinging shank to the ground in [rad], pi/2 where it is upright.

    The paper's epsilon, alpha2 - beta2, is the angle from the vertical: with its target of 90 degrees the shank
    would lie flat. Here it is pi/2 + alpha2 - beta2.
    """
    return math.pi / 2.0 + float(frame[2] - frame[3])


def shank_function(angle: float) -> LinearFunction:
    """Error `epsilon - angle` in [rad], 1 row."""
    return LinearFunction((np.array([[0.0, 0.0, 1.0, -1.0]], order="F"),), np.array([angle - math.pi / 2.0]))


def shank_edge(frame: int, angle: float, gain: float) -> Edge:
    """The edge that turns the swinging shank of `frame` to `angle` in [rad] from the ground."""
    return Edge("shank", (frame,), 1, gain, shank_function(angle))


def shank_factor(frame: int, angle: float, gain: float) -> gtsam.CustomFactor:
    """`shank_edge` as a factor."""
    return shank_edge(frame, angle, gain).factor()


def pose_edge(frame: int, pose: Array, gain: float) -> Edge:
    """The edge that draws the whole of `frame` to `pose`, shape (4,) in [rad]: an anchor that gives way."""
    return Edge("pose", (frame,), FRAME_SIZE, gain, LinearFunction((IDENTITY,), pose))


def pose_factor(frame: int, pose: Array, gain: float) -> gtsam.CustomFactor:
    """`pose_edge` as a factor."""
    return pose_edge(frame, pose, gain).factor()
