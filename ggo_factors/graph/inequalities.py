"""Inequalities that get an edge only on frames that break them in a solve: knees, hip, legs, joint limits.

An edge on every frame would cost time and, on frames that keep the limit, change nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.leg_collision import SEGMENTS, blocks_of, left_out
from ggo_factors.factors import BoneFunction, Edge, LegFunction, bone_edge, hip_edge, knee_edge, leg_edge, limit_edge
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.factors.knee import KNEES, NOT_BACKWARDS
from ggo_factors.factors.leg import SUPPORT_SHANK, SWING_SHANK
from ggo_factors.graph.bones import Bones
from ggo_factors.graph.lifting import thinned
from ggo_factors.graph.problem import Problem
from ggo_factors.graph.requests import HARD_GAIN, HARD_TOLERANCE, JointLimitRequest, LegRequest
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.inputs import Array

HIP_GAIN = 50.0
"""Gain of a hip edge, in [1/m^2]."""
BONE_STIFFER = 10.0
"""Factor on the gain of leg edges for those of bones, which keep less and have fewer frames."""


@dataclass(frozen=True)
class Inequality:
    """One kind of limit of a gait.

    Attributes:
        name: what to call it.
        family: family that its cost counts to.
        excess: how far each of the frames (m, 4) in [rad] is beyond the limit, shape (m,), in the unit of the edge's
            error.
        edge: the edge of a frame, its error shifted by an array of shape (rows,), not at all if None.
        gain: gain of the edge.
        hard_gain: the same where the limit is a constraint.
        of_ground: whether it comes from obstacles or stairs, and so is left out until the rounds lift over them, where
            it is a constraint.
        is_bone: whether it is left out until then in any case.
    """

    name: str
    family: str
    excess: Callable[[Array], Array]
    edge: Callable[[int, Array | None], Edge]
    gain: float
    hard_gain: float = HARD_GAIN
    of_ground: bool = False
    is_bone: bool = False

    def constraint(self, frame: int) -> str:
        """Name of the constraint that a hard limit is at a frame."""
        return f"{self.name} at frame {frame}"


@dataclass(frozen=True, eq=False)
class Joined:
    """The frames with an edge of one limit, how many frames each stands for, and which those are."""

    weights: dict[int, float]
    covered: NDArray[np.bool_]

    def and_broken(self, broken: NDArray[np.bool_], spacing: int) -> Joined:
        """The same with the frames that break the limit now added; none ever leaves."""
        return Joined(self.weights | thinned(broken & ~self.covered, spacing), self.covered | broken)


def broken(inequality: Inequality, frames: Array, anchored: Collection[int], hard: bool) -> NDArray[np.bool_]:
    """The frames beyond a limit that an edge could move, shape (m,)."""
    mask = np.asarray(inequality.excess(frames) > (HARD_TOLERANCE / 2.0 if hard else 0.0))
    for n in np.flatnonzero(mask).tolist():
        mask[n] = not set(inequality.edge(n, None).frames) <= set(anchored)
    return mask


def inequality_edges(
    inequality: Inequality, weights: dict[int, float], hard: bool, shifts: dict[str, Array]
) -> list[Edge]:
    """The edges of a limit on the frames that joined; of a hard limit those of constraints, shifted."""
    made = []
    for n, weight in weights.items():
        if hard:
            name = inequality.constraint(n)
            gain, shift = inequality.hard_gain, shifts.get(name)
        else:
            name, gain, shift = None, inequality.gain * weight, None
        edge = inequality.edge(n, shift)
        made.append(Edge(edge.name, edge.frames, edge.rows, gain, edge.function, name))
    return made


def inequalities_of(problem: Problem, unbent: Array) -> tuple[Inequality, ...]:
    """All inequalities of a gait graph.

    Args:
        problem: the graph.
        unbent: frames (m, 4) in [rad] that nothing but the anchors has bent yet.
    """
    model, dt = problem.model, problem.base.dt
    least = knees_at_the_start(unbent) if problem.hard else np.zeros((len(unbent), 2))
    found = [knee_inequality(problem.knee_gain, least)]
    for asked in problem.joints:
        found += joint_inequalities(asked.limits, dt, asked.gain)
    for height in problem.least_hips:
        found.append(hip_inequality(model, height))
    landings = [end.foothold for end in problem.ends if end.foothold is not None]
    ends = model.endpoint(unbent[[0, -1]]).tolist()
    feet = np.array([(0.0, 0.0), ends[0], *(landings or ends[1:])])
    for request in problem.legs:
        found += leg_inequalities(model, request)
        if model.bones == "lines":
            found += bone_inequalities(Bones(model, request, feet), request.gain)
    if problem.start is not None:
        motion = problem.base.frames[1] - problem.base.frames[0] + problem.start.velocity_offset
        free = 1.0 - problem.start.given
        found += [end_inequality("start", 0, asked, dt, motion, free) for asked in problem.joints]
    for frame in problem.rests:
        still = np.zeros(FRAME_SIZE)
        found += [end_inequality(f"rest {frame}", frame, asked, dt, still, 1.0) for asked in problem.joints]
    return tuple(found)


def knee_inequality(gain: float, least: Array) -> Inequality:
    """Knees do not bend backwards.

    Args:
        gain: gain of the edges.
        least: least angles of the knees in each frame in [rad], shape (m, 2): 0, but below where the walker starts with
            a knee bent backwards, which constraints would straighten in one frame.
    """

    def excess(frames: Array) -> Array:
        return np.asarray((least - frames[:, KNEES]).max(axis=1))

    bent = set(np.flatnonzero(least.any(axis=1)).tolist())

    def edge(frame: int, shift: Array | None) -> Edge:
        if shift is None and frame not in bent:
            return Edge("knee", (frame,), 2, 1.0, NOT_BACKWARDS)
        return knee_edge(frame, 1.0, least[frame] + (0.0 if shift is None else shift))

    return Inequality("knee", "knee", excess, edge, gain)


def knees_at_the_start(frames: Array) -> Array:
    """The least angles of the knees that constraints ask for, of frames (m, 4) that nothing has bent yet.

    0, but for the frames at the start before a knee that begins bent backwards is straight.
    """
    knees = frames[:, KNEES]
    begins = np.logical_and.accumulate(knees < 0.0, axis=0)
    return np.where(begins, knees, 0.0)


def hip_inequality(model: LegModel, least: float) -> Inequality:
    """The hip stays above a height over the supporting ankle in [m]."""

    def excess(frames: Array) -> Array:
        return np.asarray(least - model.hip_height(frames))

    def edge(frame: int, shift: Array | None) -> Edge:
        return hip_edge(frame, model, least + (0.0 if shift is None else float(shift[0])), 1.0)

    return Inequality("hip", "limits", excess, edge, HIP_GAIN)


def leg_inequalities(model: LegModel, request: LegRequest) -> Iterable[Inequality]:
    """Thighs and shanks, those that have a radius and bones that are lines, stay clear of obstacles and stairs."""
    blocks = blocks_of(model, request.obstacles, request.ground)
    for number, block in enumerate(blocks.tolist()):
        for segment, name in enumerate(SEGMENTS[:-1]):
            radius = model.shank_radius if segment in (SUPPORT_SHANK, SWING_SHANK) else model.thigh_radius
            if radius > 0.0:
                bare = left_out(model, radius) / model.shank
                function = LegFunction(model, segment, tuple(block), radius + request.margin, bare)
                yield _leg_inequality(f"{name} and block {number}", function, request.gain)


def _leg_inequality(name: str, function: LegFunction, gain: float) -> Inequality:
    def excess(frames: Array) -> Array:
        every = function.together([function] * len(frames))
        return np.where((errors := every(frames, False)[0].max(axis=1)) > 0.0, errors, -np.inf)

    def edge(frame: int, shift: Array | None) -> Edge:
        aimed = function if shift is None else replace(function, shift=tuple(shift.tolist()))
        return leg_edge(frame, aimed, 1.0)

    return Inequality(name, "limits", excess, edge, gain, of_ground=True)


def bone_inequalities(bones: Bones, gain: float) -> Iterable[Inequality]:
    """The bare axes of thighs and shanks stay out of blocks, where no capsule around them sees to that."""
    for name, function in bones.functions.items():
        excess, edge = partial(bones.excess, name), partial(_bone_edge, function)
        yield Inequality(name, "limits", excess, edge, BONE_STIFFER * gain, of_ground=True, is_bone=True)


def _bone_edge(function: BoneFunction, frame: int, shift: Array | None) -> Edge:
    aimed = function if shift is None else replace(function, shift=tuple(shift.tolist()))
    return bone_edge(frame, aimed, 1.0)


def joint_inequalities(limits: JointLimits, dt: float, gain: float) -> list[Inequality]:
    """Angles, speeds and accelerations of the joints, by differences of frames `dt` [s] apart."""
    most, speed, jerky = limits.upper, limits.speed * dt, limits.acceleration * dt**2
    return [
        _difference_inequality("joint angle", 0, limits.lower, most, most - limits.lower, gain),
        _difference_inequality("joint speed", 1, -speed, speed, speed, gain),
        _difference_inequality("joint acceleration", 2, -jerky, jerky, jerky, gain),
    ]


def end_inequality(
    which: str, frame: int, asked: JointLimitRequest, dt: float, motion: Array, free: float
) -> Inequality:
    """The joints' acceleration where a graph begins with a motion or ends at rest, as `rate_edge` counts it.

    Args:
        which: what to call the end.
        frame: the first of the two frames there.
        asked: the limits.
        dt: time between frames in [s].
        motion: from one frame to the next at the very end, shape (4,) in [rad].
        free: share of the motion between the two frames that is not given.
    """
    half = free * asked.limits.acceleration * dt**2 / 2.0
    lower, upper = motion - half, motion + half
    name, frames_there = f"{which} acceleration", (frame, frame + 1)

    def excess(frames: Array) -> Array:
        beyond = np.full(len(frames), -np.inf)
        there = frames[frame + 1] - frames[frame]
        beyond[frame] = (np.maximum(lower - there, there - upper) / half).max()
        return beyond

    def edge(_: int, shift: Array | None) -> Edge:
        return limit_edge(name, frames_there, lower, upper, half, 1.0, shift)

    return Inequality(name, "limits", excess, edge, asked.gain, HARD_GAIN * float(half.min()) ** 2)


def _difference_inequality(name: str, order: int, lower: Array, upper: Array, scale: Array, gain: float) -> Inequality:
    """The limit on the differences of so high an order; that of a frame begins there, or is centred on it."""
    before = order // 2

    def excess(frames: Array) -> Array:
        rates = np.diff(frames, n=order, axis=0)
        beyond = np.full(len(frames), -np.inf)
        beyond[before : before + len(rates)] = (np.maximum(lower - rates, rates - upper) / scale).max(axis=1)
        return beyond

    def edge(frame: int, shift: Array | None) -> Edge:
        return limit_edge(name, range(frame - before, frame - before + order + 1), lower, upper, scale, 1.0, shift)

    return Inequality(name, "limits", excess, edge, gain, HARD_GAIN * float(scale.min()) ** 2)
