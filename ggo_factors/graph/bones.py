"""Which bare bones come too near to a box or a stair in a solve, and at which few frames an edge keeps them out."""

from __future__ import annotations

import math

import numpy as np

from ggo_factors.check.leg_collision import SEGMENTS, blocks_of, bones_near, left_out
from ggo_factors.factors import BoneFunction
from ggo_factors.factors.leg import SUPPORT_SHANK, SWING_SHANK
from ggo_factors.graph.lifting import runs
from ggo_factors.graph.requests import LegRequest
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

MARGIN_SHARE = 0.5
"""Share of the margin of thighs and shanks that bare bones keep, at most: 5 of 10 mm, more than they move towards a
corner between two frames."""
ROOM_SHARE = 0.5
"""The same of the way from an ankle on the ground to a block beside it: no more can be kept there."""
TOO_NEAR = 0.5
"""A bone gets an edge where it is nearer than this share of what the edge then keeps: edges are soft."""
EVERY = 5
"""Of so many neighbouring frames that are too near the worst gets an edge, and takes the others along."""


class Bones:
    """The bones of a graph that no capsule around them keeps out of blocks.

    Attributes:
        functions: the error of each bone with each block, by name.
    """

    def __init__(self, model: LegModel, request: LegRequest, feet: Array) -> None:
        """Bones of a model, and what they stay out of.

        Args:
            model: the legs.
            request: the obstacles and the ground.
            feet: where ankles are at start and landing in [m], shape (n, 2).
        """
        self.functions: dict[str, BoneFunction] = {}
        boxes = len(request.obstacles)
        for number, block in enumerate(blocks_of(model, request.obstacles, request.ground).tolist()):
            beside = np.maximum(block[0] - feet[:, 0], feet[:, 0] - block[1])
            room = float(beside[beside > 0.0].min(initial=math.inf))
            far = min(MARGIN_SHARE * request.margin, ROOM_SHARE * room)
            low = 0.0 if number < boxes else left_out(model, 0.0)
            for segment, name in enumerate(SEGMENTS[:-1]):
                shank = segment in (SUPPORT_SHANK, SWING_SHANK)
                radius = model.shank_radius if shank else model.thigh_radius
                if radius == 0.0 or (shank and left_out(model, radius) > low):
                    function = BoneFunction(model, segment, tuple(block), far, low / model.shank if shank else 0.0)
                    self.functions[f"bone of {name} and block {number}"] = function
        self._model, self._all = model, list(self.functions.values())
        self._blocks = np.array([function.block for function in self._all]).reshape(-1, 3)
        self._far = np.array([function.far for function in self._all])
        self._frames: Array | None = None
        self._excess: dict[str, Array] = {}

    def excess(self, name: str, frames: Array) -> Array:
        """How much too near a bone is in [m], shape (m,), of frames (m, 4) in [rad].

        It is -inf on all frames but the worst of every few. All bones are looked at together, once for given frames.
        """
        if frames is not self._frames:
            self._frames = frames
            self._excess = dict(zip(self.functions, self._too_near(frames), strict=True))
        return self._excess[name]

    def _too_near(self, frames: Array) -> Array:
        """The same of all bones, shape (k, m)."""
        found = np.full((len(self._all), len(frames)), -np.inf)
        joints = self._model.joints(frames)
        near = bones_near(joints, self._blocks, TOO_NEAR * self._far[:, None, None])
        segments = np.array([function.segment for function in self._all], dtype=np.intp)
        rows, numbers = np.nonzero(near[np.arange(len(segments)), segments])
        beside = _beside(joints[numbers, segments[rows]], joints[numbers, segments[rows] + 1], self._blocks[rows])
        some = beside < TOO_NEAR * self._far[rows]
        rows, numbers = rows[some], numbers[some]
        if not len(rows):
            return found
        together = BoneFunction.together([self._all[row] for row in rows.tolist()])
        errors = np.full(found.shape, -np.inf)
        errors[rows, numbers] = together(frames[numbers], False)[0].max(axis=1) - (1.0 - TOO_NEAR) * self._far[rows]
        for row in set(rows.tolist()):
            for first, last in runs(errors[row] > 0.0):
                count = -(-(last + 1 - first) // EVERY)
                for cell in np.array_split(np.arange(first, last + 1), count):
                    worst = cell[errors[row, cell].argmax()]
                    found[row, worst] = errors[row, worst]
        return found


def _beside(begins: Array, ends: Array, blocks: Array) -> Array:
    """How far blocks (n, 3) lie below lines through axes with ends (n, 2) in [m], shape (n,): no axis is nearer."""
    run, rise = (ends - begins).T
    scale = np.where(run < 0.0, -1.0, 1.0) / np.maximum(np.hypot(run, rise), np.finfo(np.float64).tiny)
    across, up = -rise * scale, run * scale
    corner = np.where(across > 0.0, blocks[:, 1], blocks[:, 0])
    return np.asarray(across * (begins[:, 0] - corner) + up * (begins[:, 1] - blocks[:, 2]))
