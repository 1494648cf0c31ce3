"""The dense check of a finished gait, independent of the graph that made it.

It knows nothing of edges, keyframes or gains: it plays the gait as an exoskeleton would, joint angles linear
between frames, and checks what the feet, the legs and the joints do. Each check is a function of its own below.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.check.balance import balance_asked, balance_faults
from ggo_factors.check.ground import ground_faults, in_mid_swing, level_under, lowest_in_span, misplaced
from ggo_factors.check.joint_rates import LEGS, SPIKE, joint_rates, limit_faults, spikes
from ggo_factors.check.leg_collision import LegAxes, leg_faults
from ggo_factors.check.report import STANDARD, Report, Tolerances
from ggo_factors.check.trajectory import landing_faults
from ggo_factors.check.uncertainty import all_cautious, hit_probability
from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.support.inputs import Array, as_angles, as_array, as_instance, as_tuple_of

LEAST_INSTANTS = 500
"""A step is looked at at so many instants at least: 1 ms apart in a step of 0.5 s."""


DRAGS = "foot drags in mid-swing"
"""Kind of the violation of a swing ankle that is too low over level ground half-way."""
POINTS = "bones are points: thighs and shanks may lie in what the foot passes"
"""Note on a step past something that legs without bones were checked against."""


@dataclass(frozen=True, eq=False)
class Asked:
    """What a step must do, its values valid; None where that is not checked. See `verify`."""

    start: Array | None = None
    obstacles: tuple[Obstacle, ...] = ()
    gaps: tuple[Gap, ...] = ()
    foothold: tuple[float, float] | None = None
    shank_angle: float | None = None
    ground: Ground | None = None
    end_frame: Array | None = None
    limits: JointLimits | None = None
    balance: Gait | tuple[float, float] | None = None
    tolerances: Tolerances = STANDARD


@dataclass(frozen=True, eq=False)
class _Played:
    """A gait at every instant: frames (k, 4) in [rad], their numbers (k,), and the joints (k, 5, 2) in [m]."""

    gait: Gait
    model: LegModel
    frames: Array
    times: Array
    joints: Array


def verify(
    gait: Gait,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    obstacles: Sequence[Obstacle] = (),
    gaps: Sequence[Gap] = (),
    foothold: ArrayLike | None = None,
    shank_angle: float | None = None,
    tolerances: Tolerances | None = None,
    ground: Ground | None = None,
    end_frame: ArrayLike | None = None,
    limits: JointLimits | None = None,
    balance: Gait | tuple[float, float] | None = None,
) -> Report:
    """Check one step densely: all frames, and never fewer than 500 instants.

    Args:
        gait: the step.
        model: the legs; the gait's own if None.
        start: frame that the walker is in, shape (4,) in [rad]; not checked if None.
        obstacles: boxes that the swing ankle must clear, in the body frame of this step.
        gaps: pits that the swing ankle must not land in.
        foothold: where the swing ankle must land in [m], shape (2,); not checked if None.
        shank_angle: target angle of the shank to the ground at landing in [rad]; not checked if None.
        tolerances: what a good gait may be off by; `STANDARD` if None.
        ground: height of the ground. If None it is level at 0, or as low as the lower end of the step where that
            is more than `ground_at_ends` below 0: where a riser stands is then unknown and not checked.
        end_frame: frame that the step must end in, shape (4,) in [rad]; not checked if None.
        limits: joint limits of the machine; if None only those of any human leg are checked, see `Tolerances`.
        balance: base gait of as many frames that the ZMP must keep near in each, see `zero_moment.held_points`; or x of
            the back and front end of a support in [m], from the supporting ankle; not checked if None.

    Raises:
        InputError: where an argument has a wrong shape or is not finite.
    """
    goal = None
    if foothold is not None:
        x, y = as_array(foothold, "foothold", (2,)).tolist()
        goal = (x, y)
    asked = Asked(
        start=None if start is None else as_angles(start, "start", (4,)),
        obstacles=as_tuple_of(obstacles, "obstacles", Obstacle),
        gaps=as_tuple_of(gaps, "gaps", Gap),
        foothold=goal,
        shank_angle=None if shank_angle is None else float(as_angles(shank_angle, "shank_angle", ())),
        ground=None if ground is None else as_instance(ground, "ground", Ground),
        end_frame=None if end_frame is None else as_angles(end_frame, "end frame", (4,)),
        limits=None if limits is None else as_instance(limits, "limits", JointLimits),
        balance=None if balance is None else balance_asked(gait, balance),
        tolerances=STANDARD if tolerances is None else as_instance(tolerances, "tolerances", Tolerances),
    )
    return look_at(as_instance(gait, "gait", Gait), gait.legs(model), asked)


def look_at(gait: Gait, model: LegModel, asked: Asked) -> Report:
    """As `verify`, with arguments that are known to be valid."""
    frames, times = _densely(gait.frames)
    played = _Played(gait, model, frames, times, model.joints(frames))
    path, allowed = played.joints[:, 4], asked.tolerances
    violations = _feet(played, asked)
    violations += _given_frames(gait, asked)
    violations += _posture(played, allowed)
    clearance, hit, found = _obstacles(played, asked)
    violations += found
    surface = level_under(path[[0, -1]], allowed) if asked.ground is None else asked.ground
    known = asked.ground is not None
    under = surface.for_ankle(model.foot, _swing_ends(path, asked))
    low, found = ground_faults(path, times, under, asked.foothold, known, allowed)
    violations += found
    leg_clearance = math.inf
    if model.has_bodies:
        boxes = all_cautious(asked.obstacles, allowed.hit_probability)
        leg_clearance, found = leg_faults(model, played.joints, times, boxes, asked.ground)
        violations += found
    error, found = _landing(played, asked)
    violations += found
    if asked.limits is not None:
        violations += limit_faults(gait, asked.limits, allowed.limits)
    violations += _motion(gait, allowed)
    violations += _drag(played, surface, allowed)
    axes, notes = None, list[str]()
    if asked.obstacles or surface.edges:
        axes = LegAxes(model, played.joints, asked.obstacles, asked.ground)
        if model.bones == "points":
            notes.append(POINTS)
    landed = landing_speed_of(gait, model)
    violations += landing_faults(landed, allowed.landing_speed, len(gait) - 1, allowed.limits)
    knee = float(frames[:, 1::2].min())
    zmp_off = zmp_off_largest = math.nan
    if asked.balance is not None:
        zmp_off, zmp_off_largest, found = balance_faults(gait, model, asked.balance, allowed)
        violations += found
    return Report(
        violations=tuple(violations),
        foothold_error=error,
        clearance=clearance,
        ground_clearance=low,
        knee=knee,
        instants=len(frames),
        leg_clearance=leg_clearance,
        hit_probability=hit,
        landing_speed=landed,
        zmp_off=zmp_off,
        zmp_off_largest=zmp_off_largest,
        axes=axes,
        notes=tuple(notes),
    )


def _swing_ends(path: Array, asked: Asked) -> tuple[float, float]:
    """Where the swing ankle starts and lands, or is to land, in [m]."""
    return float(path[0, 0]), float(path[-1, 0]) if asked.foothold is None else asked.foothold[0]


def landing_speed_of(gait: Gait, model: LegModel) -> float:
    """Speed of the swing ankle downwards in the last motion in [m/s]."""
    (_, before), (_, landed) = model.endpoint(gait.frames[-2:]).tolist()
    return float(before - landed) / float(np.diff(gait.times[-2:])[0])


def _feet(played: _Played, asked: Asked) -> list[Violation]:
    """Whether the feet stand where they may."""
    start, end = played.joints[[0, -1], 4].tolist()
    landing = (end[0], end[1]) if asked.foothold is None else asked.foothold
    begin = (start[0], start[1])
    return misplaced(played.model, begin, landing, asked.obstacles, asked.gaps, asked.ground, asked.tolerances)


def _given_frames(gait: Gait, asked: Asked) -> list[Violation]:
    """Whether the step starts and ends in the frames that it must."""
    found = []
    for kind, frame, wanted, limit in (
        ("start", 0, asked.start, asked.tolerances.start),
        ("end frame", len(gait) - 1, asked.end_frame, asked.tolerances.end_frame),
    ):
        if wanted is not None:
            off = float(np.abs(gait.frames[frame] - wanted).max())
            if off > limit:
                found.append(Violation(kind, frame, off, limit, "rad"))
    return found


def _posture(played: _Played, allowed: Tolerances) -> list[Violation]:
    """Whether knees and thighs keep to what any human joint can do, and whether the supporting leg gives way."""
    found = []
    thighs, knees = played.frames[:, ::2], played.frames[:, 1::2]
    for kind, angles, sign, limit in (
        ("knee", knees, 1.0, allowed.knee),
        ("knee bent", knees, -1.0, allowed.knee_bent),
        ("thigh back", thighs, 1.0, allowed.thigh_back),
        ("thigh forward", thighs, -1.0, allowed.thigh_forward),
    ):
        value = float(angles.min() if sign > 0.0 else angles.max())
        if sign * value < sign * limit:
            when = float(played.times[(sign * angles).argmin() // 2])
            found.append(Violation(kind, when, math.degrees(value), math.degrees(limit), "deg"))
    hips, landing = played.joints[:, 2, 1], float(played.joints[-1, 4, 1])
    sunk = hips[0] - hips - max(0.0, -landing)
    limit = allowed.hip_drop * played.model.reach
    if sunk.max() > limit:
        found.append(Violation("hip drop", float(played.times[sunk.argmax()]), float(sunk.max()), limit, "m"))
    least = allowed.hip_height * played.model.reach
    if hips.min() < least:
        found.append(Violation("hip height", float(played.times[hips.argmin()]), float(hips.min()), least, "m"))
    return found


def _motion(gait: Gait, allowed: Tolerances) -> list[Violation]:
    """Whether a joint turns faster than any walker's, or a single frame stands out of its motion."""
    motions = np.diff(gait.frames, axis=0)
    # What stands out by so much changes a motion by more than that.
    found = spikes(gait) if np.abs(np.diff(motions, axis=0)).max(initial=0.0) > SPIKE else []
    speeds = np.abs(joint_rates(gait, 1))
    if not speeds.max() > allowed.joint_speed:
        return found
    row, joint = np.unravel_index(speeds.argmax(), speeds.shape)
    value, name = math.degrees(speeds[row, joint]), ("hip turns", "knee turns")[joint % 2]
    limit = math.degrees(allowed.joint_speed)
    return [*found, Violation(name, float(row) + 0.5, value, limit, "deg/s", LEGS[joint // 2])]


def _drag(played: _Played, surface: Ground, allowed: Tolerances) -> list[Violation]:
    """Whether the foot drags over level ground in mid-swing; stairs have their own rule in `ground_faults`."""
    path = played.joints[:, 4]
    (middle,) = np.nonzero(in_mid_swing(path[:, 0]))
    if surface.edges or not len(middle):
        return []
    heights = path[middle, 1] - surface.height_at(path[middle, 0])
    if heights.min() >= allowed.mid_swing:
        return []
    when = float(played.times[middle[heights.argmin()]])
    return [Violation(DRAGS, when, float(heights.min()), allowed.mid_swing, "m")]


def _obstacles(played: _Played, asked: Asked) -> tuple[float, float, list[Violation]]:
    """Least height of the swing ankle over the boxes in [m], the probability of a hit, and violations of both."""
    path, foot, allowed = played.joints[:, 4], played.model.foot, asked.tolerances
    clearance, found = math.inf, []
    hits: list[tuple[float, str]] = []
    for obstacle in asked.obstacles:
        box = obstacle.for_ankle(foot)
        height, where = lowest_in_span(path, played.times, box.x_start, box.x_end)
        clearance = min(clearance, height - box.height)
        if height - box.height < allowed.clearance:
            found.append(Violation("obstacle", where, height - box.height, allowed.clearance, "m", str(obstacle)))
        if obstacle.is_uncertain:
            hits.append((hit_probability(box, path), str(obstacle)))
    hit = 0.0
    for probability, _ in hits:
        hit += probability
    hit = min(hit, 1.0)
    if hit > allowed.hit_probability:
        found.append(Violation("hit probability", None, hit, allowed.hit_probability, "a step", max(hits)[1]))
    return clearance, hit, found


def _landing(played: _Played, asked: Asked) -> tuple[float, list[Violation]]:
    """Distance of the swing ankle from its foothold at landing in [m], and violations of that and the shank's angle."""
    gait, allowed, found = played.gait, asked.tolerances, []
    error = math.nan
    if asked.foothold is not None:
        error = float(np.hypot(*(played.joints[-1, 4] - asked.foothold)))
        if error > allowed.foothold:
            found.append(Violation("foothold", len(gait) - 1, error, allowed.foothold, "m"))
    if asked.shank_angle is not None:
        angle = math.pi / 2.0 + float(gait.frames[-1, 2] - gait.frames[-1, 3])
        off = abs(angle - asked.shank_angle)
        if off > allowed.shank:
            found.append(Violation("shank", len(gait) - 1, math.degrees(off), math.degrees(allowed.shank), "deg"))
    return error, found


def _densely(frames: Array) -> tuple[Array, Array]:
    """Frames at every instant, shape (k, 4) in [rad], and the fractional frame number of each, shape (k,)."""
    times, shares = _instants(len(frames) - 1)
    # Each angle is contiguous in memory, since all that follows runs along the instants.
    dense = np.empty((4, len(times)))
    between = dense[:, :-1].reshape(4, *shares.shape)
    np.multiply((frames[1:] - frames[:-1]).T[..., None], shares, out=between)
    between += frames[:-1].T[..., None]
    dense[:, -1] = frames[-1]
    return dense.T, times


@lru_cache(maxsize=8)
def _instants(pieces: int) -> tuple[Array, Array]:
    """The number of the frame that each instant is or follows, with its share; and the shares by piece of the path."""
    between = math.ceil(LEAST_INSTANTS / pieces)
    times = as_array(np.arange(pieces * between + 1) / between, "times", (None,))
    shares = as_array(times[:-1].reshape(pieces, between) - np.arange(pieces)[:, None], "shares", (None, None))
    return times, shares
