"""Balance edges: the ground's push acts where it acts in the base gait (zero moment point, ZMP), or within a support.

The error is the moment of the push about that place over the weight, in [m]: the distance of the ZMP times the share of
the weight that the ground carries. So it stays smooth where the links nearly fall and the ZMP runs off to infinity.

The base gait's ZMP is held where it is from the supporting ankle, not moved with a longer or shorter step: that foot is
the one that carries, and it does not move. Where the walker starts differently, `zero_moment.held_points` says how it
gets there. Not in the paper, which compares gaits by their ZMP.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from ggo_factors.factors.edge import Edge, ManyFunction, NeighboursFunction
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.zero_moment import push, push_jacobians, weight
from ggo_factors.support.inputs import Array


@dataclass(frozen=True)
class BalanceFunction(NeighboursFunction):
    """Error of three neighbouring frames in [m], 1 row: moment of the push about the support's nearer end over weight.

    0 where the push acts within the support.

    Attributes:
        model: the legs.
        dt: time between two frames in [s].
        back: x of the support's back end in [m], from the supporting ankle.
        front: x of its front end in [m]; where that is `back` too, the push is held to that place.
    """

    model: LegModel
    dt: float
    back: float
    front: float

    def alike(self) -> Hashable:
        """What functions that are evaluated together have in common."""
        return BalanceFunction, self.model, self.dt

    @staticmethod
    def together(functions: Sequence[BalanceFunction]) -> ManyFunction:
        """One function for as many triples of frames as functions."""
        model, dt = functions[0].model, functions[0].dt
        back, front = np.array(list(map(attrgetter("back", "front"), functions))).T
        whole = weight(model)

        def evaluate(frames: Array, want_jacobian: bool) -> tuple[Array, Array]:
            moment, force = push(model, frames, dt)
            place = np.where(moment > front * force, front, back)
            error = (moment - place * force) / whole
            inside = (error > 0.0) & (place < front)
            error[inside] = 0.0
            if not want_jacobian:
                return error[:, None], frames
            by_moment, by_force = push_jacobians(model, frames, dt)
            jacobian = (by_moment - place[:, None, None] * by_force) / whole
            jacobian[inside] = 0.0
            return error[:, None], jacobian[:, None]

        return evaluate


def balance_edges(model: LegModel, dt: float, gain: float, places: Array) -> list[Edge]:
    """The balance edges of the inner frames of a gait.

    Args:
        model: the legs.
        dt: time between two frames in [s].
        gain: gain of each edge in [1/m^2].
        places: x of the back and front end of each frame's support in [m], from the supporting ankle, shape (m - 2, 2);
            a place where the two are equal, no edge where they are NaN.
    """
    made = []
    for n, (back, front) in enumerate(places.tolist()):
        if not math.isnan(back):
            made.append(Edge("balance", (n, n + 1, n + 2), 1, gain, BalanceFunction(model, dt, back, front)))
    return made
