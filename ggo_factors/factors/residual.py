"""Residual edge: keeps the motion between two frames as it is in the base gait, as odometry does in SLAM.

Between two keyframes i < j the offsets d = g - z from the base gait that minimise the sum of |d(k+1) - d(k)|^2
lie on a straight line and cost |d(j) - d(i)|^2 / (j - i): a span is one edge, exactly, with nothing left out.
"""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, LinearFunction
from ggo_factors.support.inputs import Array

_PLUS = np.eye(FRAME_SIZE, order="F")
MOTION = (-_PLUS, _PLUS)
"""Jacobians of the motion between two frames."""


def residual_function(motion: Array) -> LinearFunction:
    """Error `g(j) - g(i) - motion` in [rad], 4 rows; `motion` is z(j) - z(i) of the base gait, shape (4,)."""
    return LinearFunction(MOTION, motion)


def residual_edge(base: Array, first: int, last: int) -> Edge:
    """The residual edge between frames `first` < `last` of the base frames, shape (m, 4) in [rad]."""
    gain = 1.0 / (last - first)
    return Edge("residual", (first, last), FRAME_SIZE, gain, residual_function(base[last] - base[first]))


def rate_edge(base: Array, velocity_offset: Array, smoothness: float, given: float = 0.0) -> Edge:
    """The second-order residual edge that begins with the walker's motion, on frames 0 and 1.

    At the start of a chain the offset d from the base gait already changes, by r in [rad] from frame to frame. A
    chain at a higher sampling rate is given its first motion, a share s of the one from frame 0 to 1, and so changes
    by r up to s / 2. From there to the middle of frames 0 and 1 the second derivative is
    2 (d(1) - d(0) - r) / (1 - s), which counts for (1 - s) / 2 of a frame. With s near 1 that is an anchor of frame 1.

    Args:
        base: base frames in [rad], shape (m, 4).
        velocity_offset: r, shape (4,) in [rad] a frame.
        smoothness: gain of the second-order edges.
        given: the share s, from 0 to below 1.
    """
    gain = 2.0 * smoothness / (1.0 - given)
    return Edge("rate", (0, 1), FRAME_SIZE, gain, residual_function(base[1] - base[0] + velocity_offset))


def residual_factor(base: Array, first: int, last: int) -> gtsam.CustomFactor:
    """`residual_edge` as a factor."""
    return residual_edge(base, first, last).factor()
