"""Anchor: a frame that is given, as the first pose of a pose graph is."""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, LinearFunction
from ggo_factors.support.inputs import Array

IDENTITY = np.eye(FRAME_SIZE, order="F")
"""Jacobian of a frame by itself."""


def anchor_function(target: Array) -> LinearFunction:
    """Error `g - target` in [rad], 4 rows."""
    return LinearFunction((IDENTITY,), target)


def anchor_edge(frame: int, target: Array) -> Edge:
    """The hard edge that keeps `frame` at `target`, shape (4,) in [rad]."""
    return Edge("anchor", (frame,), FRAME_SIZE, np.inf, anchor_function(target))


def anchor_factor(frame: int, target: Array) -> gtsam.CustomFactor:
    """`anchor_edge` as a factor."""
    return anchor_edge(frame, target).factor()
