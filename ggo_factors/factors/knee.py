"""Knee edge: keeps both knees from bending backwards (paper, Eq. res_2, squared)."""

from __future__ import annotations

import gtsam
import numpy as np

from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.edge import Edge, LinearFunction
from ggo_factors.support.inputs import Array

KNEES = slice(1, 4, 2)  # columns of beta1 and beta2
_STRAIGHTER = np.asfortranarray(-np.eye(FRAME_SIZE)[KNEES])


def knee_function(least: Array | None = None) -> LinearFunction:
    """Error `[ReLU(least - beta1), ReLU(least - beta2)]` in [rad], 2 rows; `least`, shape (2,), is 0 if None."""
    return LinearFunction((_STRAIGHTER,), np.zeros(2) if least is None else -least, hinge=True)


NOT_BACKWARDS = knee_function()
"""The function that most knee edges share."""


def knee_edge(frame: int, gain: float, least: Array | None = None) -> Edge:
    """The knee edge of `frame`; `gain` is the paper's lambda, `least` as for `knee_function`."""
    return Edge("knee", (frame,), 2, gain, NOT_BACKWARDS if least is None else knee_function(least))


def knee_factor(frame: int, gain: float) -> gtsam.CustomFactor:
    """`knee_edge` as a factor."""
    return knee_edge(frame, gain).factor()
