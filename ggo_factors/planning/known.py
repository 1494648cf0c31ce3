"""What some steps turned out to cost, for steps that are alike: they are as many times dearer than was expected."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ggo_factors.support.inputs import Array

ALIKE = 0.08
"""What a step turned out to cost counts for steps whose places differ by about so much in [m]."""


class Known:
    """How many times what was expected steps cost, from some that are known: those alike are so many times dearer too.

    Args:
        behind: x of the swing ankle at the start of each step in [m], shape (n,).
        stands: x of its supporting ankle.
        lands: x at which its swing ankle lands.
    """

    def __init__(self, behind: Array, stands: Array, lands: Array) -> None:
        self.steps = np.stack([behind, stands, lands]).astype(np.float32)
        self.weights, self.logs = np.zeros(len(behind), np.float32), np.zeros(len(behind), np.float32)

    @property
    def times(self) -> Array:
        """How many times what was expected, shape (n,)."""
        return np.exp((self.logs / np.maximum(self.weights, 1.0)).astype(np.float64))

    def add(self, places: Sequence[float] | Array, costs: Sequence[float] | Array, expected: Array) -> None:
        """Take in what the steps between some places in [m] cost and what was expected of them."""
        for n, (cost, less) in enumerate(zip(costs, expected.tolist(), strict=False)):
            if not (0.0 < less < np.inf and 0.0 < cost < np.inf):
                continue
            off = np.abs(self.steps - np.array(places[n : n + 3], np.float32)[:, None]).max(axis=0)
            weights = np.exp(-((off / np.float32(ALIKE)) ** 2))
            self.weights += weights
            self.logs += weights * np.float32(math.log(cost / less))
