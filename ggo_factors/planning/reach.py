"""How long steps of a plan may be, by how far the hip sinks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.footholds import DEVIATIONS
from ggo_factors.planning.postures import postures
from ggo_factors.support.inputs import Array

SHORTEST = 0.05
"""Footholds are looked for from so far ahead in [m] on. No step of a plan is shorter than half of it, but for the
closing one; where places of edges are uncertain, none is shorter than all of it."""
LENGTH = 0.02
"""How finely lengths of steps are tried in [m]."""
SINKS = 0.19
"""Largest share of the leg that the hip may sink by in a step on level ground: 0.94 m with the paper's legs."""
FAR_SINKS = 0.26
"""The same where no shorter steps lead on: 1.06 m with the paper's legs, a third more than they are long. Such a step
can be made after one of 0.6 m or more, since the hip is low already; with run-up the check passes even 1.3 m, which
nobody walks."""
MOST_SPARED = 0.08
"""Steps are at most so much shorter in [m] for edges that are uncertain."""
LOWER = 0.1
"""A step down is at most so much longer in [m] than one on level ground, and no more than it goes down."""


@dataclass(frozen=True)
class Reach:
    """How long steps may be.

    Attributes:
        level: the longest step on level ground in [m].
        shortest: the shortest step but for the closing one in [m].
    """

    level: float
    shortest: float

    @property
    def most(self) -> float:
        """No step is longer in [m]."""
        return self.level + LOWER

    def over(self, rise: Array) -> Array:
        """No step that rises by so much is longer, both in [m], shape (n,): on the way down legs reach further."""
        return np.asarray(self.level + np.clip(-rise, 0.0, LOWER))

    def has(self, far: Array, rise: Array, within: float) -> NDArray[np.bool_]:
        """Which steps there may be that go so `far` and rise so much, shape (n,) each, `within` so much, all in [m]."""
        return np.asarray((far >= self.shortest - within) & (far <= self.over(rise) + within))


def reach_on(
    terrain: Terrain, model: LegModel, base: Gait, limits: JointLimits | None, sinks: float, kept: bool
) -> Reach:
    """How long steps on a terrain may be, on which the hip sinks by no more than a share `sinks` of the leg.

    Where places of edges are uncertain they are shorter by as much as soles keep away from them: a plan that goes as
    far as legs reach could not be kept when the edges turn out to be elsewhere. Nor could one with two feet so close
    together that edges elsewhere leave room for one. Where footholds are `kept` nothing is spared.
    """
    edges = [part.edge_std for kind in (terrain.surfaces, terrain.boxes, terrain.no_footholds) for part in kind]
    spare = 0.0 if kept else DEVIATIONS * max(map(float, edges))
    level = max(SHORTEST, longest_step(model, base, limits, sinks) - min(spare, MOST_SPARED))
    return Reach(level, SHORTEST / 2.0 + min(spare, SHORTEST / 2.0))


@lru_cache(maxsize=16)
def longest_step(model: LegModel, base: Gait, limits: JointLimits | None, sinks: float) -> float:
    """The longest step on level ground in [m], to `LENGTH`, on which the hip sinks by no more than `sinks`; 0 if none.

    Args:
        model: the legs.
        base: the base gait.
        limits: angles that the joints keep to, or None.
        sinks: share of the leg's length.
    """
    lengths = LENGTH * np.arange(1, 60)
    found = postures(model, base.frames[-1], np.stack([lengths, 0.0 * lengths], -1), limits)
    drop = model.hip_height(base.frames[0]) - model.hip_height(found)
    good = np.isfinite(found).all(axis=1) & (drop < sinks * model.reach)
    return float(lengths[good].max(initial=0.0))
