"""Landing edges: at touchdown the base gait's own posture and motion, as far as the foothold lets them be.

Residual edges know differences only, as odometry does: whatever offset from the base gait an obstacle or a stair brings
in is carried on for ever, for of the four angles of a last frame the foothold fixes two. These edges are the absolute
fix at the end of each step (GPS, compass) that brings the walker home. They are not in the paper.
"""

from __future__ import annotations

import gtsam

from ggo_factors.factors.edge import Edge, LinearFunction
from ggo_factors.factors.end import pose_edge
from ggo_factors.factors.residual import MOTION
from ggo_factors.support.inputs import Array


def landing_edges(base: Array, posture: Array, posture_gain: float, motion_gain: float) -> tuple[Edge, Edge]:
    """The edges of the last frame m and of the last motion.

    Errors `g(m) - e` and `(g(m) - g(m-1)) - (z(m) - z(m-1))` in [rad], 4 rows each.

    Args:
        base: base frames z in [rad], shape (m + 1, 4).
        posture: touchdown posture e, shape (4,) in [rad].
        posture_gain: gain of the first edge.
        motion_gain: gain of the second.
    """
    last = len(base) - 1
    motion = LinearFunction(MOTION, base[last] - base[last - 1])
    return (
        pose_edge(last, posture, posture_gain),
        Edge("landing motion", (last - 1, last), len(posture), motion_gain, motion),
    )


def landing_factors(
    base: Array, posture: Array, posture_gain: float, motion_gain: float
) -> tuple[gtsam.CustomFactor, gtsam.CustomFactor]:
    """`landing_edges` as factors."""
    at, moving = landing_edges(base, posture, posture_gain, motion_gain)
    return at.factor(), moving.factor()
