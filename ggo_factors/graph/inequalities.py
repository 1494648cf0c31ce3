"""Limits of a gait that get an edge only where a solve breaks them: knees, the hip's height, joint limits.

An edge on every frame would cost time and, where nothing is broken, change nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.leg_collision import FOOT_SPARE, SEGMENTS, blocks_of
from ggo_factors.factors import Edge, LegFunction, hip_edge, knee_edge, leg_edge, limit_edge
from ggo_factors.factors.knee import KNEES
from ggo_factors.graph.lifting import thinned
from ggo_factors.graph.requests import HARD_GAIN, HARD_TOLERANCE
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Ground, Obstacle
from ggo_factors.support.inputs import Array

LIMIT_GAIN = 10.0
"""Gain of an edge on a joint limit, whose error is a share of the limit."""
LEG_GAIN = 100.0
"""Gain of a leg edge, in [1/m^2]."""
HIP_GAIN = 50.0
"""Gain of a hip edge, in [1/m^2]."""


@dataclass(frozen=True)
class Limit:
    """One kind of limit.

    Attributes:
        name: what to call it.
        family: of its costs.
        excess: frames (m, 4) in [rad] to how far each is beyond the limit, shape (m,), in the unit of the edge's error.
        edge: the edge of a frame, its error shifted by so much, shape (rows,); None: not shifted.
        gain: gain of the edge.
        hard_gain: the same where the limit is a constraint.
        of_ground: whether it comes from obstacles or stairs, and so is no constraint before the rounds lift over them.
    """

    name: str
    family: str
    excess: Callable[[Array], Array]
    edge: Callable[[int, Array | None], Edge]
    gain: float
    hard_gain: float = HARD_GAIN
    of_ground: bool = False

    def constraint(self, frame: int) -> str:
        """Name of the constraint that a hard limit is at a frame."""
        return f"{self.name} at frame {frame}"


@dataclass(frozen=True, eq=False)
class Joined:
    """The frames that have an edge of one limit, with how many each stands for, and all those that they stand for."""

    weights: dict[int, float]
    covered: NDArray[np.bool_]

    def and_broken(self, broken: NDArray[np.bool_], spacing: int) -> Joined:
        """The same with the frames that break the limit now; none ever leaves."""
        return Joined(self.weights | thinned(broken & ~self.covered, spacing), self.covered | broken)


def broken(limit: Limit, frames: Array, anchored: Collection[int], hard: bool) -> NDArray[np.bool_]:
    """The frames beyond a limit that an edge could move, shape (m,)."""
    mask = np.asarray(limit.excess(frames) > (HARD_TOLERANCE / 2.0 if hard else 0.0))
    for n in np.flatnonzero(mask).tolist():
        mask[n] = not set(limit.edge(n, None).frames) <= set(anchored)
    return mask


def limit_edges(limit: Limit, weights: dict[int, float], hard: bool, shifts: dict[str, Array]) -> list[Edge]:
    """The edges of a limit on the frames that joined; of a hard limit those of constraints, shifted."""
    if not hard:
        return [limit.edge(n, None).counting(limit.gain * weight) for n, weight in weights.items()]
    named = [(n, limit.constraint(n)) for n in weights]
    return [limit.edge(n, shifts.get(name)).counting(limit.hard_gain, name) for n, name in named]


def knee_limit(gain: float, least: Array) -> Limit:
    """Knees do not bend backwards.

    Args:
        gain: gain of the edges.
        least: the least angles of the knees in each frame in [rad], shape (m, 2): 0, but where the walker's own start
            bends a knee backwards and constraints would tear it out of that in one frame.
    """

    def excess(frames: Array) -> Array:
        return np.asarray((least - frames[:, KNEES]).max(axis=1))

    def edge(frame: int, shift: Array | None) -> Edge:
        return knee_edge(frame, 1.0, least[frame] + (0.0 if shift is None else shift))

    return Limit("knee", "knee", excess, edge, gain)


def knees_at_the_start(frames: Array) -> Array:
    """The least angles of the knees that constraints ask for, of frames (m, 4) that nothing has bent yet.

    0, but for the frames at the start before a knee that begins bent backwards is straight.
    """
    knees = frames[:, KNEES]
    begins = np.logical_and.accumulate(knees < 0.0, axis=0)
    return np.where(begins, knees, 0.0)


def hip_limit(model: LegModel, least: float) -> Limit:
    """The hip stays above a height over the supporting ankle in [m]."""

    def excess(frames: Array) -> Array:
        return np.asarray(least - model.hip_height(frames))

    def edge(frame: int, shift: Array | None) -> Edge:
        return hip_edge(frame, model, least + (0.0 if shift is None else float(shift[0])), 1.0)

    return Limit("hip", "limits", excess, edge, HIP_GAIN)


def leg_limits(
    model: LegModel, obstacles: Sequence[Obstacle], ground: Ground | None, margin: float, gain: float
) -> list[Limit]:
    """Thighs and shanks that have a radius stay clear of obstacles and stairs by a margin in [m]."""
    blocks = blocks_of(model, obstacles, ground)
    radii = (model.shank_radius, model.thigh_radius, model.thigh_radius, model.shank_radius)
    bare = max(0.0, model.shank_radius + FOOT_SPARE - model.foot.ankle_height) / model.shank
    made = []
    for number, block in enumerate(blocks):
        for segment, radius in enumerate(radii):
            if radius > 0.0:
                function = LegFunction(model, segment, tuple(block.tolist()), radius + margin, bare)
                made.append(_leg_limit(f"{SEGMENTS[segment]} and block {number}", function, gain))
    return made


def _leg_limit(name: str, function: LegFunction, gain: float) -> Limit:
    def excess(frames: Array) -> Array:
        every = function.together([function] * len(frames))
        return np.where((errors := every(frames, False)[0].max(axis=1)) > 0.0, errors, -np.inf)

    def edge(frame: int, shift: Array | None) -> Edge:
        aimed = function if shift is None else replace(function, shift=tuple(shift.tolist()))
        return leg_edge(frame, aimed, 1.0)

    return Limit(name, "limits", excess, edge, gain, of_ground=True)


def joint_limits(limits: JointLimits, dt: float, gain: float = LIMIT_GAIN) -> list[Limit]:
    """Angles, speeds and accelerations of the joints, by differences of frames `dt` [s] apart."""
    most, speed, jerky = limits.upper, limits.speed * dt, limits.acceleration * dt**2
    return [
        _difference_limit("joint angle", 0, limits.lower, most, most - limits.lower, gain),
        _difference_limit("joint speed", 1, -speed, speed, speed, gain),
        _difference_limit("joint acceleration", 2, -jerky, jerky, jerky, gain),
    ]


def start_limit(limits: JointLimits, dt: float, motion: Array, free: float = 1.0, gain: float = LIMIT_GAIN) -> Limit:
    """The joints' acceleration at the start of a graph that begins with a motion, as `rate_edge` counts it.

    Args:
        limits: the limits.
        dt: time between frames in [s].
        motion: from one frame to the next at the start, shape (4,) in [rad].
        free: share of the first motion that is not given.
        gain: gain of the edge.
    """
    half = free * limits.acceleration * dt**2 / 2.0
    lower, upper = motion - half, motion + half

    def excess(frames: Array) -> Array:
        beyond = np.full(len(frames), -np.inf)
        first = frames[1] - frames[0]
        beyond[0] = (np.maximum(lower - first, first - upper) / half).max()
        return beyond

    def edge(_: int, shift: Array | None) -> Edge:
        return limit_edge("start acceleration", (0, 1), lower, upper, half, 1.0, shift)

    return Limit("start acceleration", "limits", excess, edge, gain, HARD_GAIN * float(half.min()) ** 2)


def _difference_limit(name: str, order: int, lower: Array, upper: Array, scale: Array, gain: float) -> Limit:
    """The limit on the differences of so high an order; that of a frame begins there, or is centred on it."""
    before = order // 2

    def excess(frames: Array) -> Array:
        rates = np.diff(frames, n=order, axis=0)
        beyond = np.full(len(frames), -np.inf)
        beyond[before : before + len(rates)] = (np.maximum(lower - rates, rates - upper) / scale).max(axis=1)
        return beyond

    def edge(frame: int, shift: Array | None) -> Edge:
        return limit_edge(name, range(frame - before, frame - before + order + 1), lower, upper, scale, 1.0, shift)

    return Limit(name, "limits", excess, edge, gain, HARD_GAIN * float(scale.min()) ** 2)
