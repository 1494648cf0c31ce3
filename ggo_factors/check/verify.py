"""The dense check of a finished gait, independent of the graph that made it.

It knows nothing of edges, keyframes or gains: it plays the gait as an exoskeleton would, joint angles linear
between frames, and looks at what the foot and the knees do.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors.check.joint_rates import limit_faults
from ggo_factors.check.leg_collision import leg_faults
from ggo_factors.check.uncertainty import HIT_PROBABILITY, all_cautious, hit_probability
from ggo_factors.errors import Violation
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.support.inputs import Array, as_angles, as_array, as_instance, as_number, as_tuple_of

LEAST_INSTANTS = 500
FOOTHOLD_ZONE = 0.020
"""How near a foothold, in [m], P may come close to the ground on stairs."""
BESIDE_ZONE = 0.100
"""The same where the foot stands beside the other one, within this distance of it: a knee that bends out of a straight
stance first draws the ankle back, and one that straightens into it draws it in, both close to the ground."""


def near_footholds(x: Array, y_top: Array, ends: Array, ground: Ground) -> NDArray[np.bool_]:
    """Where P may come close to the ground on stairs.

    Args:
        x: places in [m], shape (n,).
        y_top: height of the ground there in [m], shape (n,).
        ends: P at the start and at the landing in [m], shape (2, 2).
        ground: the ground that P must stay above.
    """
    near = np.zeros(len(x), dtype=bool)
    for end in ends[:, 0]:
        distance = np.abs(x - end)
        near |= distance <= FOOTHOLD_ZONE
        if abs(end) <= BESIDE_ZONE:
            near |= (distance <= BESIDE_ZONE) & (y_top == ground.height_at(end))
    return near


@dataclass(frozen=True)
class Tolerances:
    """What a good gait may be off by, in [m] and [rad].

    Attributes:
        foothold: largest distance of the landing P from its foothold.
        ground: deepest that P may dip under the ground.
        ground_at_ends: the same within `end_zone` of an end of the step that is itself off the ground by that
            (a recorded base gait rarely stands to the millimetre).
        end_zone: how far around such an end.
        stair_clearance: least height over stairs, further than `FOOTHOLD_ZONE` from both footholds, on the
            tread where the feet stand together further than `BESIDE_ZONE`.
        knee: least knee angle; below 0 is hyperextension.
        knee_bent: largest knee angle.
        thigh_back: least thigh angle from the vertical.
        thigh_forward: largest thigh angle from the vertical. These three are wider than healthy ranges of motion (about
            140, -30 and 120 degrees): what lies beyond them no walker can follow.
        hip_drop: deepest that the hip may sink below its height in the first frame, beyond what the foothold lies below
            the supporting foot, as a share of the leg's length: a supporting leg that gives way is no step.
        clearance: least height over an obstacle.
        start: largest difference of the first frame from the frame that the walker stands in.
        end_frame: the same of the last frame from the one that it must end in.
        shank: largest difference of the shank from its wanted angle at landing.
        limits: how far beyond a joint's limit, as a share of it, for angles of their range.
        hit_probability: how probable it may be that the swinging foot hits an obstacle that was measured with an error;
            thighs and shanks stay clear of the boxes that `uncertainty.all_cautious` makes of them for it.

    Raises:
        InputError: where a number is not finite, or the probability is not above 0 and at most 1.
    """

    foothold: float = 0.001
    ground: float = 0.001
    ground_at_ends: float = 0.010
    end_zone: float = 0.05
    stair_clearance: float = 0.005
    knee: float = math.radians(-0.3)
    knee_bent: float = math.radians(150.0)
    thigh_back: float = math.radians(-50.0)
    thigh_forward: float = math.radians(130.0)
    hip_drop: float = 0.20
    clearance: float = 0.0
    start: float = 1e-9
    end_frame: float = 1e-6
    shank: float = math.radians(1.0)
    limits: float = 0.001
    hit_probability: float = HIT_PROBABILITY

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, as_number(getattr(self, field.name), field.name))
        as_number(self.hit_probability, "hit_probability", above=0.0, at_most=1.0)


STANDARD = Tolerances()
"""The tolerances that every gait is held to unless the user gives others."""


@dataclass(frozen=True)
class Report:
    """What the dense check saw.

    Attributes:
        violations: every limit that is broken; empty where the gait is good.
        foothold_error: distance of the landing P from its foothold in [m]; NaN without a foothold.
        clearance: least height of P over the obstacles in [m]; infinite where it crosses none.
        ground_clearance: least height of P over the ground, away from both footholds, in [m].
        knee: least knee angle in [rad].
        instants: how many instants were looked at.
        leg_clearance: least distance of thighs and shanks from obstacles and stairs in [m], below 0 where one reaches
            in; infinite where there is none, or the legs have no radius. Obstacles that were measured with an error
            count as `uncertainty.all_cautious` makes them.
        hit_probability: how probable it is that P, or the sole, hits one of the obstacles that were measured with an
            error: the sum over them, at most 1, which holds however their errors belong together. 0 without any. Start
            and landing are points of its path; the supporting foot stands where it does, whatever was measured, and is
            held against the measured box alone.
    """

    violations: tuple[Violation, ...]
    foothold_error: float
    clearance: float
    ground_clearance: float
    knee: float
    instants: int
    leg_clearance: float = math.inf
    hit_probability: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether no limit is broken."""
        return not self.violations


def verify(
    gait: Gait,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    obstacles: Sequence[Obstacle] = (),
    gaps: Sequence[Gap] = (),
    foothold: tuple[float, float] | None = None,
    shank_angle: float | None = None,
    tolerances: Tolerances | None = None,
    ground: Ground | None = None,
    end_frame: ArrayLike | None = None,
    limits: JointLimits | None = None,
) -> Report:
    """Check one step densely: all frames, and never fewer than 500 instants.

    Args:
        gait: the step.
        model: the legs; the gait's own if None.
        start: frame that the walker stands in, shape (4,) in [rad]; not checked if None.
        obstacles: boxes that P must clear, in the body frame of this step.
        gaps: stretches that P must not land in.
        foothold: where P must land in [m], shape (2,); not checked if None.
        shank_angle: wanted angle of the shank to the ground at landing in [rad]; not checked if None.
        tolerances: what may be off by how much.
        ground: height of the ground. If None it is level at 0, or as low as the lower end of the step where that
            is more than `ground_at_ends` below 0: where a riser stands is then unknown and not checked.
        end_frame: frame that the step must end in, shape (4,) in [rad]; not checked if None.
        limits: what the joints can do; not checked if None, but for what no leg can do, see `Tolerances`.

    Raises:
        InputError: where an argument has a wrong shape or is not finite.
    """
    allowed = STANDARD if tolerances is None else as_instance(tolerances, "tolerances", Tolerances)
    legs = as_instance(gait, "gait", Gait).legs(model)
    boxes, pits = as_tuple_of(obstacles, "obstacles", Obstacle), as_tuple_of(gaps, "gaps", Gap)
    if ground is not None:
        as_instance(ground, "ground", Ground)
    frames, times = _densely(gait.frames)
    joints = legs.joints(frames)
    path = joints[:, 4]
    ends = path[[0, -1]]
    goal = None if foothold is None else as_array(foothold, "foothold", (2,))
    surface = (_level_under(ends, allowed) if ground is None else ground).for_ankle(legs.foot)
    landing = (float(ends[1, 0]), float(ends[1, 1])) if goal is None else (float(goal[0]), float(goal[1]))
    violations = misplaced(legs, (float(ends[0, 0]), float(ends[0, 1])), landing, boxes, pits, ground, allowed)

    for kind, frame, wanted, limit in (
        ("start", 0, start, allowed.start),
        ("end frame", len(gait) - 1, end_frame, allowed.end_frame),
    ):
        if wanted is not None:
            off = float(np.abs(gait.frames[frame] - as_angles(wanted, kind, (4,))).max())
            if off > limit:
                violations.append(Violation(kind, frame, off, limit, "rad"))

    thighs, knees = frames[:, ::2], frames[:, 1::2]
    for kind, angles, sign, limit in (
        ("knee", knees, 1.0, allowed.knee),
        ("knee bent", knees, -1.0, allowed.knee_bent),
        ("thigh back", thighs, 1.0, allowed.thigh_back),
        ("thigh forward", thighs, -1.0, allowed.thigh_forward),
    ):
        value = float(angles.min() if sign > 0.0 else angles.max())
        if sign * value < sign * limit:
            when = float(times[(sign * angles).argmin() // 2])
            violations.append(Violation(kind, when, math.degrees(value), math.degrees(limit), "deg"))

    hips = joints[:, 2, 1]
    sunk = hips[0] - hips - max(0.0, -float(ends[1, 1]))
    if sunk.max() > allowed.hip_drop * legs.reach:
        where = float(times[sunk.argmax()])
        violations.append(Violation("hip drop", where, float(sunk.max()), allowed.hip_drop * legs.reach, "m"))

    clearance = math.inf
    for obstacle in boxes:
        box = obstacle.for_ankle(legs.foot)
        height, where = _lowest_in_span(path, times, box.x_start, box.x_end)
        clearance = min(clearance, height - box.height)
        if height - box.height < allowed.clearance:
            violations.append(Violation("obstacle", where, height - box.height, allowed.clearance, "m", str(obstacle)))
    hits = [(hit_probability(box.for_ankle(legs.foot), path), str(box)) for box in boxes if box.is_uncertain]
    hit = min(math.fsum(probability for probability, _ in hits), 1.0)
    if hit > allowed.hit_probability:
        violations.append(Violation("hit probability", None, hit, allowed.hit_probability, "a step", max(hits)[1]))

    least_ground, ground_violation = _check_ground(path, times, surface, goal, ground is not None, allowed)
    violations += ground_violation
    held_off = all_cautious(boxes, allowed.hit_probability)
    leg_clearance, leg_violations = leg_faults(legs, joints, times, held_off, ground)
    violations += leg_violations

    error = math.nan
    if goal is not None:
        error = float(np.hypot(*(ends[1] - goal)))
        if error > allowed.foothold:
            violations.append(Violation("foothold", len(gait) - 1, error, allowed.foothold, "m"))
    if shank_angle is not None:
        angle = math.pi / 2.0 + gait.frames[-1, 2] - gait.frames[-1, 3]
        off = abs(float(angle) - float(as_angles(shank_angle, "shank_angle", ())))
        if off > allowed.shank:
            violations.append(Violation("shank", len(gait) - 1, math.degrees(off), math.degrees(allowed.shank), "deg"))
    if limits is not None:
        violations += limit_faults(gait, as_instance(limits, "limits", JointLimits), allowed.limits)
    least_knee = float(knees.min())
    return Report(tuple(violations), error, clearance, least_ground, least_knee, len(frames), leg_clearance, hit)


def misplaced(
    model: LegModel,
    start: tuple[float, float],
    landing: tuple[float, float],
    obstacles: Sequence[Obstacle],
    gaps: Sequence[Gap],
    ground: Ground | None,
    tolerances: Tolerances,
) -> list[Violation]:
    """What is wrong with where the feet stand, whatever they do between.

    Args:
        model: the legs.
        start: P at the start in [m].
        landing: P at the landing in [m].
        obstacles: boxes in the body frame of the step.
        gaps: pits in the body frame of the step.
        ground: height of the ground, or None where it is not known.
        tolerances: what may be off by how much.
    """
    found: list[Violation] = []
    x, y = landing
    feet = (("supporting foot", 0.0, 0.0), ("swinging foot's start", *start), ("foothold", x, y))
    for obstacle in obstacles:
        box = obstacle.for_ankle(model.foot)
        for name, at, height in feet:
            # An obstacle is in the way of a standing foot whatever its height; a foot may stand right on its top.
            if box.x_start <= at <= box.x_end and (name == "supporting foot" or height < box.height):
                near = box.x_start if at - box.x_start < box.x_end - at else box.x_end
                found.append(Violation(f"obstacle in the {name}", None, at, near, "m", str(obstacle)))
    for gap in gaps:
        pit = gap.for_ankle(model.foot)
        if pit.x_start < x < pit.x_end:
            near = pit.x_start if x - pit.x_start < pit.x_end - x else pit.x_end
            found.append(Violation("foothold in a gap", None, x, near, "m", str(gap)))
    if ground is not None:
        surface = ground.for_ankle(model.foot)
        for name, at, height in (feet[0], feet[2]):
            level = float(surface.height_at(at))
            if abs(height - level) > 2.0 * tolerances.foothold:
                # Where the ankle alone would stand right, it is the sole that reaches under a higher tread.
                stands = abs(height - float(ground.height_at(at))) <= 2.0 * tolerances.foothold
                fault = f"stair in the {name}" if stands else f"{name} off the ground"
                found.append(Violation(fault, None, height, level, "m"))
    return found


def _densely(frames: Array) -> tuple[Array, Array]:
    """Frames at every instant, and the (fractional) frame number of each."""
    times, shares = _instants(len(frames) - 1)
    # An angle after the other in memory: all that follows runs along the instants.
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


def _level_under(ends: Array, allowed: Tolerances) -> Ground:
    low = float(ends[:, 1].min())
    return Ground(heights=(low if low < -allowed.ground_at_ends else 0.0,))


def _lowest_in_span(path: Array, times: Array, x_start: float, x_end: float) -> tuple[float, float]:
    """Lowest y of the path over [x_start, x_end], its pieces cut at the span's ends, and when; inf if never there."""
    x, y = path.T
    (index,) = np.nonzero((np.minimum(x[:-1], x[1:]) <= x_end) & (np.maximum(x[:-1], x[1:]) >= x_start))
    if not len(index):
        return math.inf, math.nan
    run, rise = x[index + 1] - x[index], y[index + 1] - y[index]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.stack([(x_start - x[index]) / run, (x_end - x[index]) / run])
    # A piece that stands still lies in the span with all of it.
    shares = np.clip(np.sort(np.where(run == 0.0, [[0.0], [1.0]], shares), axis=0), 0.0, 1.0)
    heights = y[index] + shares * rise
    side, piece = np.unravel_index(heights.argmin(), heights.shape)
    when = times[index[piece]] + shares[side, piece] * (times[1] - times[0])
    return float(heights[side, piece]), float(when)


def _with_crossings(path: Array, times: Array, edges: Sequence[float]) -> tuple[Array, Array]:
    """The path with the points added where it passes over an edge, so that no riser falls between two instants."""
    points, when = [path], [times]
    for edge in edges:
        share = (edge - path[:-1, 0]) / np.where(path[1:, 0] == path[:-1, 0], np.nan, np.diff(path[:, 0]))
        (index,) = np.nonzero((share > 0.0) & (share < 1.0))
        part = share[index]
        y = path[index, 1] + part * (path[index + 1, 1] - path[index, 1])
        points.append(np.stack([np.full(len(index), edge), y], -1))
        when.append(times[index] + part * (times[1] - times[0]))
    return np.concatenate(points), np.concatenate(when)


def _check_ground(
    path: Array, times: Array, surface: Ground, goal: Array | None, known: bool, allowed: Tolerances
) -> tuple[float, list[Violation]]:
    """Least height over the ground away from both footholds, and the worst violation if there is one."""
    ends = [path[0], path[-1] if goal is None else goal]
    path, times = _with_crossings(path, times, surface.edges)
    top = surface.height_at(path[:, 0])
    height = path[:, 1] - top
    limit = np.full(len(height), -allowed.ground)
    near = near_footholds(path[:, 0], top, np.array(ends), surface)
    for end in ends:
        distance = np.abs(path[:, 0] - end[0])
        depth = float(surface.height_at(end[0]) - end[1])
        # The landing must be within the foothold's own tolerance; a start, or an end without a foothold, is given.
        if 0.0 < depth <= allowed.ground_at_ends and (goal is None or end is not goal):
            limit = np.where(distance <= allowed.end_zone, np.minimum(limit, -depth - 1e-12), limit)
    away = ~near
    if known and surface.edges:
        limit = np.where(away, allowed.stair_clearance, limit)
    least = float(height[away].min()) if away.any() else float(height.min())
    worst = int((height - limit).argmin())
    if height[worst] >= limit[worst]:
        return least, []
    return least, [Violation("ground", float(times[worst]), float(height[worst]), float(limit[worst]), "m")]
