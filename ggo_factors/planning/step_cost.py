"""What a step costs, without its graph being solved: for thousands of steps at once, near enough to choose footholds.

With landing edges a step depends on three places alone: where the swinging foot starts, where the other stands, where
it lands. It begins in the posture in which the step before landed and ends in its own touchdown posture. The residual
edges between those two, their inner frames eliminated, cost a constant times the square of the offset's change (the
exact span of `factors.span`). To lift the swing ankle by a height h at a frame costs h^2 / (J s J'), where s is the
variance that the residual edges leave that frame between its two ends, a bridge: a box costs the worst of its frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ggo_factors.check.report import STANDARD
from ggo_factors.check.uncertainty import cautious
from ggo_factors.factors.span import inner_weights, span_root
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import UP_AND_DOWN, LegModel
from ggo_factors.motion.world import SAME_PLACE, Terrain
from ggo_factors.planning.footholds import DEVIATIONS
from ggo_factors.support.inputs import Array

INSTANTS = 16
"""The path of the swing ankle is looked at at about so many instants."""
MARGIN = 0.02
"""Height to spare in [m] over boxes and edges, as `procedures.build` asks for."""
WIDER = 0.02
"""Boxes and treads count so much longer at both ends in [m] that none lies between two instants."""
LEAN_SPARE = 0.01
"""Distance in [m] that a shank keeps from the edge of a box or a tread beside its foot."""
FREE = 1.5
"""Tangent of a lean from the vertical beyond which no shank goes."""
ZONE = 0.02
"""Within this distance of its footholds in [m] the ankle may be near the ground."""
HIP_SHARE = 0.95
"""Share of the largest hip drop of the check that a plan makes use of."""
LEAST_VARIANCE = 0.02
"""Share of the largest bridge variance that every instant has: the last frames before landing are nearly given."""
HOME = 0.1
"""Share of a step's stiffness with which its touchdown posture is drawn to the base gait's own. Without it a long and a
short step in turn cost as little as two alike, since both move the foot as far as the base gait does: a limp."""
FARTHEST_LIFT = 0.6
"""A step whose ankle would have to be lifted further than this in [m] is none."""


@dataclass(frozen=True, eq=False)
class Roof:
    """What the swing ankle must stay above, as a piecewise straight function of x in the world frame.

    Attributes:
        x: where pieces begin, shape (k,) in [m].
        y: height there, shape (k,) in [m].
        slope: rise by metre, shape (k,).
        bare: the same heights of the ground alone, without boxes and without a margin, shape (k,) in [m].
    """

    x: Array
    y: Array
    slope: Array
    bare: Array

    def at(self, x: Array) -> tuple[Array, Array]:
        """Height with boxes and of the bare ground at `x` in [m], of any shape."""
        piece = np.clip(np.searchsorted(self.x, x, "right") - 1, 0, len(self.x) - 1)
        beyond = self.slope[piece] * (x - self.x[piece])
        return self.y[piece] + beyond, self.bare[piece] + beyond


def roof_of(terrain: Terrain, model: LegModel, lift: float = 0.0) -> Roof:
    """What the swing ankle must stay above: ground and boxes as far as the sole reaches, ankle heights cancelled.

    Args:
        terrain: the ground.
        model: the legs.
        lift: height over boxes in [m] beside the `MARGIN` that is kept anyway.
    """
    foot, whole = model.foot, terrain.whole
    edges = [edge for edge, rise in zip(whole.edges, terrain.rises, strict=True) if abs(rise) > SAME_PLACE]
    blocks = []
    for box, top in zip(terrain.boxes, terrain.tops, strict=True):
        wide = cautious(box)
        beyond = top + wide.height - box.height + lift
        blocks.append((wide.x_start - foot.toe - WIDER, wide.x_end + foot.heel + WIDER, beyond))
    cuts = {terrain.x_start - 10.0, *whole.edges}
    cuts |= {edge - foot.toe - WIDER for edge in edges} | {edge + foot.heel + WIDER for edge in edges}
    cuts |= {end for block in blocks for end in block[:2]}
    x = np.array(sorted(cuts))
    inside = np.append((x[:-1] + x[1:]) / 2.0, x[-1] + 1.0)
    pieces = [terrain.surfaces[terrain.surface_at(place)] for place in inside.tolist()]
    slope = np.tan([piece.slope for piece in pieces])
    bare = np.array([p.height + s * (a - p.x_start) for p, s, a in zip(pieces, slope, x, strict=True)])
    for edge, rise in zip(whole.edges, terrain.rises, strict=True):
        if abs(rise) > SAME_PLACE:
            # The higher side of a riser reaches as far as a sole that stands on it.
            top = float(whole.height_at(edge))
            near = (inside > edge - foot.toe - WIDER) & (inside < edge + foot.heel + WIDER)
            bare = np.where(near, np.maximum(bare, top), bare)
    y = bare.copy()
    for begins, ends, top in blocks:
        y = np.where((inside > begins) & (inside < ends), np.maximum(y, top), y)
    return Roof(x, y, slope, bare)


def blocks_on(terrain: Terrain) -> Array:
    """Left side, right side and top of each box and of each side of a riser that is higher, shape (k, 3) in [m]."""
    blocks = []
    for box, top in zip(terrain.boxes, terrain.tops, strict=True):
        wide = cautious(box)
        blocks.append((wide.x_start, wide.x_end, top + wide.height - box.height))
    for before, surface, rise in zip(terrain.surfaces, terrain.surfaces[1:], terrain.rises, strict=False):
        beyond = DEVIATIONS * surface.edge_std
        if rise > SAME_PLACE:
            blocks.append((surface.x_start - beyond, surface.x_end, surface.height))
        elif rise < -SAME_PLACE:
            blocks.append((before.x_start, before.x_end + beyond, before.end_height))
    return np.array(blocks).reshape(-1, 3)


@dataclass(frozen=True, eq=False)
class Room:
    """How far a shank may lean, by where its foot stands.

    Attributes:
        blocks: left side, right side and top of each box and tread in the world frame in [m], shape (k, 3).
        roof: the ground.
        model: the legs.
    """

    blocks: Array
    roof: Roof
    model: LegModel

    def at(self, x: Array) -> tuple[Array, Array]:
        """Furthest lean back and forward in [rad] of shanks whose ankles are over `x` in [m], shape (n,) each."""
        places, which = np.unique(x, return_inverse=True)
        back, forward = np.full(len(places), -FREE), np.full(len(places), FREE)
        _, ground = self.roof.at(places)
        for left, right, top in self.blocks.tolist():
            up = np.minimum(top - ground - self.model.foot.ankle_height, self.model.shank)
            high = up > 0.0
            ahead, behind = high & (left > places), high & (right < places)
            with np.errstate(divide="ignore", invalid="ignore"):
                forward = np.where(ahead, np.minimum(forward, (left - places - LEAN_SPARE) / up), forward)
                back = np.where(behind, np.maximum(back, (right - places + LEAN_SPARE) / up), back)
        return np.arctan(back)[which.ravel()], np.arctan(forward)[which.ravel()]


@dataclass(frozen=True, eq=False)
class StepCosts:
    """Costs of steps of one walker: base gait and legs, and how steps are made.

    Attributes:
        base: the base gait.
        model: the legs.
        smoothness: gain of the second-order edges at the base gait's rate.
        roof: what the swing ankle must stay above.
        blocks: left side, right side and top of each box and tread in the world frame in [m], shape (k, 3).
    """

    base: Gait
    model: LegModel
    smoothness: float
    roof: Roof
    blocks: Array

    def of(self, starts: Array, ends: Array, leaves: Array | None = None, arrives: Array | None = None) -> Array:
        """Cost of each step if nothing is in its way; infinite where there is none.

        Args:
            starts: frame that the step begins in, shape (n, 4) in [rad].
            ends: frame that it lands in, shape (n, 4) in [rad].
            leaves: change of the offset from the base gait in the first motion, shape (4,) in [rad]; 0 if None.
            arrives: the same in the last motion.

        Returns:
            Shape (n,), in [rad^2], as the graph's error: half the sum of squares.
        """
        first, last = self.base.frames[[0, -1]]
        change = (ends - last) - (starts - first)
        stiffness, _, _, root = bridge(len(self.base) - 1, self.smoothness)
        if leaves is None and arrives is None:
            costs = 0.5 * stiffness * (change**2).sum(axis=1)
        else:
            none = np.zeros(4)
            shares = np.array([none, none if leaves is None else leaves, none if arrives is None else -arrives, none])
            moved = root @ (np.array([0.0, 0.0, 1.0, 1.0])[:, None] * change[:, None] + shares)
            costs = 0.5 * (moved**2).sum(axis=(1, 2))
        costs += 0.5 * HOME * stiffness * ((ends - last) ** 2).sum(axis=1)
        landing = self.model.endpoint(ends)
        drop = self.model.hip_height(starts) - self.model.hip_height(ends) - np.maximum(0.0, -landing[:, 1])
        costs[~(drop <= HIP_SHARE * STANDARD.hip_drop * self.model.reach)] = np.inf
        costs[np.isnan(costs)] = np.inf
        return np.asarray(costs)

    def lifts(self, starts: Array, ends: Array, stands: Array, heights: Array) -> Array:
        """What it costs besides to lift the swing ankle over what is in its way, shape (n,).

        Args:
            starts: frame that the step begins in, shape (n, 4) in [rad].
            ends: frame that it lands in, shape (n, 4) in [rad].
            stands: x of the supporting ankle in the world frame, shape (n,) in [m].
            heights: height of the ground there, shape (n,) in [m].
        """
        base, every = self.base.frames, max(1, (len(self.base) - 1) // INSTANTS)
        _, weights, variances, _ = bridge(len(base) - 1, self.smoothness)
        at = slice(every, -1, every)
        first, change = starts - base[0], (ends - base[-1]) - (starts - base[0])
        x, y, squares = self._swing(base[at], first, weights[at], change)
        top, bare = self.roof.at(x + stands[:, None])
        near = np.zeros(x.shape, dtype=bool)
        for foot in (self.model.endpoint(starts), self.model.endpoint(ends)):
            near |= np.abs(x - foot[:, :1]) <= ZONE
        over = np.where(top > bare, top + MARGIN, np.where(near, bare, bare + MARGIN / 2.0))
        need = np.maximum(over - heights[:, None] - y, 0.0)
        loose = np.maximum(variances[at], LEAST_VARIANCE * variances.max())
        worst = (0.5 * need**2 / (squares * loose)).max(axis=1)
        worst[need.max(axis=1) > FARTHEST_LIFT] = np.inf
        return np.asarray(worst)

    def _swing(self, base: Array, first: Array, weights: Array, change: Array) -> tuple[Array, Array, Array]:
        """Swing ankle and the square of how its height changes with the angles, shape (n, k), thrice.

        In single precision: a hundred thousand instants of a plan, each of which needs to be right to a millimetre.
        """
        links = UP_AND_DOWN.astype(np.float32)
        begun, turned = (first @ links.T).astype(np.float32), (change @ links.T).astype(np.float32)
        along, share = (base @ links.T).astype(np.float32), weights.astype(np.float32)
        sines, heights = [], np.zeros((len(first), len(base)), np.float32)
        for link, length in enumerate((-self.model.shank, -self.model.thigh, self.model.thigh, self.model.shank)):
            angle = along[:, link] + begun[:, link, None] + share * turned[:, link, None]
            sines.append(np.float32(length) * np.sin(angle))
            heights -= np.float32(length) * np.cos(angle)
        shank1, thigh1, thigh2, shank2 = sines
        by_thigh1, by_thigh2 = thigh1 + shank1, thigh2 + shank2
        squares = by_thigh1**2 + shank1**2 + by_thigh2**2 + shank2**2
        ahead = by_thigh1 + by_thigh2
        return ahead.astype(np.float64), heights.astype(np.float64), squares.astype(np.float64)

    def leans(self, starts: Array, ends: Array, behind: Array, stands: Array, lands: Array) -> Array:
        """What it costs besides to keep shanks upright that would lean into what is beside their feet, shape (n,).

        Args:
            starts: frame that the step begins in, shape (n, 4) in [rad].
            ends: frame that it lands in, shape (n, 4) in [rad].
            behind: x of the swing ankle at the start in the world frame, shape (n,) in [m].
            stands: x of the supporting ankle.
            lands: x at which the swing ankle lands.
        """
        costs = np.zeros(len(starts))
        for frames, ankle, thigh in ((starts, behind, 2), (starts, stands, 0), (ends, stands, 0), (ends, lands, 2)):
            # A knee before its ankle is a negative angle: the shank points down and back.
            lean = frames[:, thigh + 1] - frames[:, thigh]
            back, forward = self.room.at(ankle)
            costs += 0.5 * (np.maximum(lean - forward, 0.0) + np.maximum(back - lean, 0.0)) ** 2
        return costs

    @cached_property
    def room(self) -> Room:
        """How far shanks may lean."""
        return Room(self.blocks, self.roof, self.model)


@lru_cache(maxsize=16)
def bridge(motions: int, smoothness: float) -> tuple[float, Array, Array, Array]:
    """A step's residual edges with both ends and the motions there given.

    Returns:
        Twice the cost for an offset that changes by 1 from end to end; the share of the change at each frame, shape
        (m,); the variance that is left to each frame, shape (m,); the root of the information of the offsets of the
        first two and last two frames, shape (k, 4).
    """
    count = motions + 1
    if not smoothness or motions < 4:
        at = np.arange(count)
        root = np.array([[-1.0, 0.0, 0.0, 1.0]]) / np.sqrt(motions)
        return 1.0 / motions, at / motions, at * (motions - at) / motions, root
    root = span_root(motions - 2, smoothness)
    ends = np.array([0.0, 0.0, 1.0, 1.0])
    weights = np.concatenate([[0.0, 0.0], inner_weights(motions - 2, smoothness) @ ends, [1.0, 1.0]])
    precision = np.zeros((count, count))
    for n in range(motions):
        precision[n : n + 2, n : n + 2] += [[1.0, -1.0], [-1.0, 1.0]]
    bend = np.array([1.0, -2.0, 1.0])
    for n in range(motions - 1):
        precision[n : n + 3, n : n + 3] += smoothness * np.outer(bend, bend)
    variances = np.zeros(count)
    variances[2:-2] = np.diag(np.linalg.inv(precision[2:-2, 2:-2]))
    return float(((root @ ends) ** 2).sum()), weights, variances, root
