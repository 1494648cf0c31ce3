"""What a step costs, without its graph being solved: for thousands of steps at once, near enough to choose footholds.

With landing edges a step depends on three places alone: where the swinging foot starts, where the other stands, where
it lands. It begins in the posture in which the step before landed and ends in its own touchdown posture. The residual
edges between those two, their inner frames eliminated, cost a constant times the square of the offset's change (the
exact span of `factors.span`). To lift the swing ankle by a height h at a frame costs h^2 / (J s J'), where s is the
variance that the residual edges leave that frame between its two ends, a bridge: a box costs the worst of its frames.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.ground import BESIDE_ZONE, FOOTHOLD_ZONE
from ggo_factors.check.leg_collision import BESIDE
from ggo_factors.check.report import STANDARD
from ggo_factors.check.uncertainty import HIT_PROBABILITY, cautious
from ggo_factors.factors.span import inner_weights, span_root
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import UP_AND_DOWN, Foot, LegModel
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.motion.world import Terrain
from ggo_factors.procedures.build import HIP_SINKS
from ggo_factors.support.inputs import Array

INSTANTS = 12
"""The path of the swing ankle is looked at at about so many instants."""
MARGIN = 0.02
"""Height to spare in [m] over boxes and edges, as `procedures.build` asks for."""
WIDER = 0.01
"""Boxes and treads count so much longer at both ends in [m]: a step lifts its ankle before and after too."""
SAMPLE = 0.005
"""How finely the roof is sampled in [m]."""
AROUND = 1.0
"""The roof reaches so far beyond the terrain in [m]."""
TOGETHER = 4
"""So many things that were measured with an error share the probability of a hit in one step."""
LEAN_SPARE = 0.01
"""Distance in [m] that a shank keeps from the edge of a box or a tread beside its foot."""
FREE = 20.0
"""Tangent of a lean from the vertical beyond which no shank goes."""
HIP_SHARE = 0.95
"""Share of the largest hip drop of the check that a plan makes use of."""
SHORT, BESIDE_OTHER = 0.003, 0.15
"""A foot that lands beside the other one, less than the second of these before it in [m], costs up to the first of them
more in [rad^2]: it comes down low from far behind. Steps to 0.04, 0.05, 0.076 and 0.09 m cost 18, 15, 26 and 11e-4 more
than without this."""
HIP_GAIN = 100.0
"""What a hip that sinks by more than `build.HIP_SINKS` of the leg costs in [rad^2/m^2], times 1/2: the graph keeps it
up by other angles, at such a cost in 60 steps of 0.75 to 0.86 m."""
CROUCH, CROUCH_GAIN = 0.55, 100.0
"""A hip lower over either foot than the first of these of the leg costs the second times 1/2 in [rad^2/m^2]: who climbs
that far lands sitting on the own foot, which passes the check down to `Tolerances.hip_height` and no person does."""
LEAST_VARIANCE = 0.02
"""Share of the largest bridge variance that every instant has: the last frames before landing are nearly given."""
HOME = 0.1
"""Share of a step's stiffness with which its touchdown posture is drawn to the base gait's own. Without it a long and a
short step in turn cost as little as two alike, since both move the foot as far as the base gait does: a limp."""
FARTHEST_LIFT = 0.6
"""A step whose ankle would have to be lifted further than this in [m] is none."""


@dataclass(frozen=True, eq=False)
class Roof:
    """What the swing ankle must stay above, sampled over x in the world frame.

    Attributes:
        begins: x of the first sample in [m].
        top: the highest of ground and boxes in [m] over 1, 2, 4, ... samples from each one on, shape (levels, k).
        bare: the same of the ground alone.
    """

    begins: float
    top: Array
    bare: Array

    def over(self, low: Array, high: Array) -> tuple[Array, Array]:
        """The highest with boxes, and of the bare ground, between two places in [m], arrays of one shape."""
        first, last = self._sample(low), self._sample(high)
        level = np.log2(last - first + 1).astype(np.intp)
        second = last + 1 - 2**level
        return tuple(np.maximum(of[level, first], of[level, second]) for of in (self.top, self.bare))

    def ground_at(self, x: Array) -> Array:
        """Height of the bare ground at `x` in [m]."""
        return np.asarray(self.bare[0, self._sample(x)])

    def _sample(self, x: Array) -> NDArray[np.intp]:
        return np.clip(((x - self.begins) / SAMPLE).astype(np.intp), 0, self.top.shape[1] - 1)


def _doubled(values: Array) -> Array:
    """The highest of 1, 2, 4, ... values from each on, shape (levels, k)."""
    levels, wide = [values], 1
    while 2 * wide <= len(values):
        beyond = np.concatenate([levels[-1][wide:], np.full(wide, -np.inf)])
        levels.append(np.maximum(levels[-1], beyond))
        wide *= 2
    return np.array(levels)


def roof_of(terrain: Terrain, model: LegModel, lift: float = 0.0) -> Roof:
    """What the swing ankle must stay above: ground and boxes as far as the sole reaches, ankle heights cancelled.

    Args:
        terrain: the ground.
        model: the legs.
        lift: height over boxes in [m] beside the `MARGIN` that is kept anyway.
    """
    foot, whole = model.foot, terrain.whole
    edges = [surface.x_start for _, surface, rise in terrain.seams if rise]
    blocks = [
        (box.x_start - foot.toe - WIDER, box.x_end + foot.heel + WIDER, box.height + (lift if solid else 0.0))
        for box, solid in _hazards(terrain)
    ]
    begins = terrain.x_start - AROUND
    x = np.arange(begins, terrain.x_end + AROUND, SAMPLE)
    bare: Array = np.array(whole.height_at(x), dtype=np.float64)
    for edge in edges:
        # The higher side of a riser reaches as far as a sole that stands on it.
        near = (x > edge - foot.toe - WIDER) & (x < edge + foot.heel + WIDER)
        bare = np.where(near, np.maximum(bare, float(whole.height_at(edge))), bare)
    roof = bare
    for first, last, height in blocks:
        over = (x > first - SAMPLE) & (x < last + SAMPLE)
        roof = np.where(over, np.maximum(roof, height), roof)
    return Roof(begins, _doubled(roof), _doubled(bare))


def _hazards(terrain: Terrain) -> list[tuple[Obstacle, bool]]:
    """What a step must clear, as `uncertainty.cautious` has it, in the world frame; whether it is a box."""
    found = []
    for box in terrain.boxes_from(0.0, -math.inf, math.inf, Foot()):
        certain = cautious(box, HIT_PROBABILITY / TOGETHER)
        found.append((certain, not box.is_edge))
    y = float(terrain.height_at(0.0))
    return [(replace(box, height=box.height + y, base=box.base + y), solid) for box, solid in found]


def blocks_on(terrain: Terrain) -> Array:
    """Left side, right side and top of each box and of each side of a riser that is higher, shape (k, 3) in [m]."""
    blocks = [(box.x_start, box.x_end, box.height) for box, _ in _hazards(terrain)]
    for before, surface, rise in terrain.seams:
        if rise > 0.0:
            blocks.append((surface.x_start, surface.x_end, surface.height))
        elif rise < 0.0:
            blocks.append((before.x_start, before.x_end, before.end_height))
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

    def at(self, x: Array, share: float) -> tuple[Array, Array]:
        """Furthest lean back and forward in [rad] of shanks whose ankles are over `x` in [m], shape (n,) each.

        They lean over `share` of the way to a block; that which lands does so over `leg_collision.BESIDE` of it.
        """
        places, which = np.unique(x, return_inverse=True)
        back, forward = np.full(len(places), -FREE), np.full(len(places), FREE)
        ground = self.roof.ground_at(places)
        for left, right, top in self.blocks.tolist():
            up = np.minimum(top - ground - self.model.foot.ankle_height, self.model.shank)
            high = up > 0.0
            ahead, behind = high & (left > places), high & (right < places)
            with np.errstate(divide="ignore", invalid="ignore"):
                forward = np.where(ahead, np.minimum(forward, share * (left - places - LEAN_SPARE) / up), forward)
                back = np.where(behind, np.maximum(back, share * (right - places + LEAN_SPARE) / up), back)
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
        costs = self._spans(starts, ends, leaves, arrives) + self.postures(starts, ends, beside=arrives is not None)
        costs[np.isnan(costs)] = np.inf
        return costs

    def _spans(self, starts: Array, ends: Array, leaves: Array | None, arrives: Array | None) -> Array:
        """What the residual edges between two frames cost, shape (n,); arguments as for `of`."""
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
        return np.asarray(costs)

    def postures(self, starts: Array, ends: Array, beside: bool = False) -> Array:
        """What postures cost for themselves: hips that sink, feet too near to each other, shape (n,) in [rad^2].

        Args:
            starts: frame that the step begins in, shape (n, 4) in [rad].
            ends: frame that it lands in, shape (n, 4) in [rad].
            beside: whether it is to end with the feet beside each other.
        """
        costs = np.zeros(len(starts))
        landing, reach = self.model.endpoint(ends), self.model.reach
        drop = self.model.hip_height(starts) - self.model.hip_height(ends) - np.maximum(0.0, -landing[:, 1])
        if not beside:
            costs += SHORT * np.maximum(1.0 - landing[:, 0] / BESIDE_OTHER, 0.0)
        costs += 0.5 * HIP_GAIN * np.maximum(drop - HIP_SINKS * reach, 0.0) ** 2
        low = np.minimum(self.model.hip_height(ends), self.model.hip_height(ends) - landing[:, 1])
        costs += 0.5 * CROUCH_GAIN * np.maximum(CROUCH * reach - low, 0.0) ** 2
        costs[~(drop <= HIP_SHARE * STANDARD.hip_drop * reach)] = np.inf
        costs[self.model.hip_height(ends) < STANDARD.hip_height * reach] = np.inf
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
        over = self.least_height(x, stands, self.model.endpoint(starts)[:, :1], self.model.endpoint(ends)[:, :1])
        need = np.clip(over - heights[:, None] - y, 0.0, 2.0 * FARTHEST_LIFT)
        loose = np.maximum(variances[at], LEAST_VARIANCE * variances.max())
        # A base gait of one motion has no frame on the way.
        worst = (0.5 * need**2 / (squares * loose)).max(axis=1, initial=0.0)
        worst[need.max(axis=1, initial=0.0) > FARTHEST_LIFT] = np.inf
        return np.asarray(worst)

    def least_height(self, x: Array, stands: Array, begins: Array, lands: Array) -> Array:
        """What the swing ankle must be above at each instant of a path, in the world frame, shape (n, k) in [m].

        Args:
            x: of the swing ankle from the supporting one, shape (n, k) in [m].
            stands: x of the supporting ankle in the world frame, shape (n,) in [m].
            begins: x of the swing ankle at the start from the supporting one, shape (n, 1) in [m].
            lands: the same where it lands.
        """
        world = x + stands[:, None]
        halfway = (world[:, 1:] + world[:, :-1]) / 2.0
        halfway = np.concatenate([world[:, :1], halfway, world[:, -1:]], axis=1)
        low, high = np.minimum(halfway[:, 1:], halfway[:, :-1]), np.maximum(halfway[:, 1:], halfway[:, :-1])
        top, bare = self.roof.over(np.minimum(low, world), np.maximum(high, world))
        near = np.zeros(x.shape, dtype=bool)
        for foot in (begins, lands):
            # A foot beside the other one may come close to the ground on its way.
            near |= np.abs(x - foot) <= np.where(np.abs(foot) <= BESIDE_ZONE, BESIDE_ZONE, FOOTHOLD_ZONE)
        return np.where(top > bare, top + MARGIN, np.where(near, bare, bare + MARGIN / 2.0))

    def _swing(self, base: Array, first: Array, weights: Array, change: Array) -> tuple[Array, Array, Array]:
        """Swing ankle, and the square of how its height changes with the angles at the same x, shape (n, k), thrice.

        In single precision: a hundred thousand instants of a plan, each of which needs to be right to a millimetre.
        """
        links = UP_AND_DOWN.astype(np.float32)
        begun, turned = (first @ links.T).astype(np.float32), (change @ links.T).astype(np.float32)
        along, share = (base @ links.T).astype(np.float32), weights.astype(np.float32)
        sines, cosines, heights = [], [], np.zeros((len(first), len(base)), np.float32)
        for link, length in enumerate((-self.model.shank, -self.model.thigh, self.model.thigh, self.model.shank)):
            angle = along[:, link] + begun[:, link, None] + share * turned[:, link, None]
            sines.append(np.float32(length) * np.sin(angle))
            cosines.append(np.float32(length) * np.cos(angle))
            heights -= cosines[-1]
        # The swing ankle's height changes with the sines of the links, its place with their cosines. It is to rise
        # where it is: what moves it forward as well is of no use.
        up, ahead = _by_angles(sines), _by_angles(cosines)
        across = sum(one * other for one, other in zip(up, ahead, strict=True))
        squares = sum(one**2 for one in up) - across**2 / sum(one**2 for one in ahead)
        x = sines[0] + sines[1] + sines[2] + sines[3]
        return x.astype(np.float64), heights.astype(np.float64), np.asarray(squares, dtype=np.float64)

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
            back, forward = self.room.at(ankle, BESIDE if frames is ends and thigh == 2 else 1.0)
            costs += 0.5 * (np.maximum(lean - forward, 0.0) + np.maximum(back - lean, 0.0)) ** 2
        return costs

    @cached_property
    def room(self) -> Room:
        """How far shanks may lean."""
        return Room(self.blocks, self.roof, self.model)


def _by_angles(links: Sequence[Any]) -> list[Any]:
    """Derivatives by the four angles of a frame of a sum over links, of those by the links' angles to the vertical."""
    shank1, thigh1, thigh2, shank2 = links
    return [thigh1 + shank1, -shank1, thigh2 + shank2, -shank2]


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
