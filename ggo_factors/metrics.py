"""Numbers that say how far a gait is from its base gait."""

from __future__ import annotations

import numpy as np

from ggo_factors.arrays import Array
from ggo_factors.errors import InputError
from ggo_factors.gait import Gait


def mean_joint_change(gait: Gait, base: Gait) -> Array:
    """Mean absolute difference of each joint angle from the base gait in [rad], shape (4,) (paper, Table abs_err).

    Raises:
        InputError: where the gaits differ in their number of frames.
    """
    if len(gait) != len(base):
        raise InputError(f"base: {len(base)} frames, the gait has {len(gait)}")
    return np.asarray(np.abs(gait.frames - base.frames).mean(axis=0), dtype=np.float64)


def residuals(gait: Gait, base: Gait) -> Array:
    """Change of each frame-to-frame motion from the base gait's in [rad], shape (m - 1, 4): e_g - e_z of the paper.

    Raises:
        InputError: where the gaits differ in their number of frames.
    """
    if len(gait) != len(base):
        raise InputError(f"base: {len(base)} frames, the gait has {len(gait)}")
    return np.asarray(np.diff(gait.frames - base.frames, axis=0), dtype=np.float64)
