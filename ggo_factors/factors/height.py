"""Height edges: hinges that keep a joint over a height: the hip, or the swing ankle where clearance is a constraint.

The hip edge is ours; the paper leaves the posture to the residual edges.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np

from ggo_factors.factors.edge import Edge, ManyFunction, PointFunction
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

HIP, ANKLE = 2, 4
"""Rows of the hip and of the swing ankle in `LegModel.joints`."""


@dataclass(frozen=True)
class HeightFunction(PointFunction):
    """Error `ReLU(least - y)` in [m], 1 row; y is the height of a joint over the supporting ankle.

    Attributes:
        model: the legs.
        joint: `HIP` or `ANKLE`.
        least: least height of the joint in [m].
    """

    model: LegModel
    joint: int
    least: float

    def __call__(self, frame: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        """The error, and the Jacobian."""
        errors, blocks = self.together([self])(frame[None], want_jacobian)
        return errors[0], (np.asfortranarray(blocks[0]),)

    def curvature(self, frame: Array) -> Array:
        """Sum over the rows of error times second derivative, shape (4, 4)."""
        (low,), _ = self(frame, False)
        bent = self.model.endpoint_hessian(frame, 0.0, -low)
        if self.joint == HIP:
            bent[2:, 2:] = 0.0  # the swinging leg does not move the hip
        return bent

    def alike(self) -> Hashable:
        """What functions that can be evaluated together have in common."""
        return HeightFunction, self.model

    @staticmethod
    def together(functions: Sequence[HeightFunction]) -> ManyFunction:
        """The same for as many frames as functions."""
        model, each = functions[0].model, np.arange(len(functions))
        joint = np.array([function.joint for function in functions])
        least = np.array([function.least for function in functions])

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            points, moves = model.joints_and_jacobian(frames)
            low = least - points[each, joint, 1]
            under = low > 0.0
            slopes = np.where(under[:, None], -moves[each, joint, 1], 0.0)
            return np.where(under, low, 0.0)[:, None], slopes[:, None]

        return evaluate


def hip_edge(frame: int, model: LegModel, least: float, gain: float) -> Edge:
    """The edge that keeps the hip of `frame` over a height in [m]."""
    return Edge("hip", (frame,), 1, gain, HeightFunction(model, HIP, least))


def clear_edge(frame: int, model: LegModel, height: float, gain: float) -> Edge:
    """The edge that keeps the swing ankle of `frame` over a height in [m]: what an obstacle edge is as a constraint."""
    return Edge("obstacle", (frame,), 1, gain, HeightFunction(model, ANKLE, height))
