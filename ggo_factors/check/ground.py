"""The dense check of the ground: where the feet stand, and how low the swing ankle passes over what is there.

The graph finds frames that pass too low by code of its own (`graph.lifting`), so that a fault in one is seen by the
other. Both share only where a foot may come near the ground: `near_footholds` and `in_mid_swing`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.report import Tolerances
from ggo_factors.errors import Violation
from ggo_factors.motion.leg_model import Foot, LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.support.inputs import Array

FOOTHOLD_ZONE = 0.020
"""Distance from a foothold in [m] within which the swing ankle may come close to the ground on stairs."""
BESIDE_ZONE = 0.100
"""The same in [m] where the foot stands within this distance of the other one: a knee that bends out of a straight
stance first draws the ankle back, and one that straightens into it draws it in, both close to the ground."""
SAME_HEIGHT = 1e-9
"""Heights of ground that differ by no more in [m] are the same; on a ramp rounding would decide what is near a foot."""
VOID = 0.010
"""Ground that lies deeper under the sole than this in [m] does not carry it."""
SOLE_SAMPLES = 101
"""So many places of a sole on a ramp are looked at."""
MOST_OVERHANG = 0.5
"""Largest share of a sole's length without ground under it: a foot whose middle stands on the edge tips over it."""
SHORTEST_WAY = 0.05
"""A foot that moves forward by less than this in [m] has no mid-swing."""
MIDDLE = (0.25, 0.75)
"""Mid-swing lies between these shares of the way forward."""


def in_mid_swing(x: Array) -> NDArray[np.bool_]:
    """Which points of a path lie in the middle of its way forward, of their x in [m], shape (n,)."""
    way = x[-1] - x[0]
    if abs(way) < SHORTEST_WAY:
        return np.zeros(len(x), dtype=bool)
    share = (x - x[0]) / way
    return np.asarray((share > MIDDLE[0]) & (share < MIDDLE[1]))


def near_footholds(x: Array, y_top: Array, ends: Array, ground: Ground) -> NDArray[np.bool_]:
    """Which places are so near a foothold that the swing ankle may come close to the ground on stairs.

    Args:
        x: places in [m], shape (n,).
        y_top: height of the ground there in [m], shape (n,).
        ends: the swing ankle at the start and at the landing in [m], shape (2, 2).
        ground: the ground that it must stay above.
    """
    near = np.zeros(len(x), dtype=bool)
    for end in ends[:, 0]:
        distance = np.abs(x - end)
        near |= distance <= FOOTHOLD_ZONE
        if abs(end) <= BESIDE_ZONE:
            alike = np.abs(y_top - ground.height_at(end)) <= ground.steepest * distance + SAME_HEIGHT
            near |= (distance <= BESIDE_ZONE) & alike
    return near


def ground_faults(
    path: Array, times: Array, ground: Ground, goal: tuple[float, float] | None, known: bool, allowed: Tolerances
) -> tuple[float, list[Violation]]:
    """Least height over the ground away from both footholds, and the worst violation if there is one.

    Args:
        path: points of the swing ankle in [m], shape (n, 2).
        times: frame number of each, shape (n,).
        ground: the ground that the ankle must stay above.
        goal: the foothold in [m], or None.
        known: whether the ground was given; if not, the places of risers are unknown.
        allowed: what a good gait may be off by.
    """
    landing = (float(path[-1, 0]), float(path[-1, 1])) if goal is None else goal
    ends = ((float(path[0, 0]), float(path[0, 1]), True), (*landing, goal is None))
    path, times = _with_crossings(path, times, ground.edges)
    top = ground.height_at(path[:, 0])
    height = path[:, 1] - top
    limit = np.full(len(height), -allowed.ground)
    near = near_footholds(path[:, 0], top, np.array(ends)[:, :2], ground)
    for x, y, given in ends:
        distance = np.abs(path[:, 0] - x)
        depth = float(ground.height_at(x) - y)
        # The landing must be within the foothold's own tolerance; a start, or an end without a foothold, is given.
        if 0.0 < depth <= allowed.ground_at_ends and given:
            limit = np.where(distance <= allowed.end_zone, np.minimum(limit, -depth - 1e-12), limit)
    away = ~near
    if known and ground.edges:
        limit = np.where(away, allowed.stair_clearance, limit)
    least = float(height[away].min()) if away.any() else float(height.min())
    worst = int((height - limit).argmin())
    if height[worst] >= limit[worst]:
        return least, []
    return least, [Violation("ground", float(times[worst]), float(height[worst]), float(limit[worst]), "m")]


def _over_a_void(foot: Foot, name: str, x: float, height: float, ground: Ground) -> list[Violation]:
    """Whether more than half of a sole hangs over ground that lies lower."""
    length = foot.heel + foot.toe
    if ground.slopes:
        # The sole lies parallel to the ground under its ankle; `height` is that of the ground there.
        tilt = ground.slope_at(x)
        along = np.linspace(-foot.heel, foot.toe, SOLE_SAMPLES)
        deep = height + along * math.tan(tilt) - ground.height_at(x + along) > VOID
        hangs = float(deep.mean()) * length
        if hangs <= MOST_OVERHANG * length:
            return []
        limit = MOST_OVERHANG * length
        return [Violation(f"{name} over a void", None, hangs, limit, "m", "length of sole without ground")]
    bounds = np.clip([x - foot.heel, *ground.edges, x + foot.toe], x - foot.heel, x + foot.toe)
    pieces = np.diff(bounds)
    hangs = float(pieces[np.array(ground.heights) < height - VOID].sum())
    if hangs <= MOST_OVERHANG * length:
        return []
    return [Violation(f"{name} over a void", None, hangs, MOST_OVERHANG * length, "m", "length of sole without ground")]


def level_under(ends: Array, allowed: Tolerances) -> Ground:
    """Level ground at 0, or at the lower end of a step where that lies below it; ends of shape (2, 2) in [m]."""
    low = float(ends[:, 1].min())
    return Ground(heights=(low if low < -allowed.ground_at_ends else 0.0,))


def lowest_in_span(path: Array, times: Array, x_start: float, x_end: float) -> tuple[float, float]:
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


def misplaced(
    model: LegModel,
    start: tuple[float, float],
    landing: tuple[float, float],
    obstacles: Sequence[Obstacle],
    gaps: Sequence[Gap],
    ground: Ground | None,
    tolerances: Tolerances,
    in_the_air: bool = False,
) -> list[Violation]:
    """What is wrong with the places where the feet stand, whatever the motion between.

    Args:
        model: the legs.
        start: the swing ankle at the start in [m].
        landing: the swing ankle at the landing in [m].
        obstacles: boxes in the body frame of the step.
        gaps: pits in the body frame of the step.
        ground: height of the ground, or None where it is not known.
        tolerances: what a good gait may be off by.
        in_the_air: whether the swinging foot has left the ground: it may be over a pit then, but not in a box.
    """
    found: list[Violation] = []
    x, y = landing
    feet = (("supporting foot", 0.0, 0.0), ("swinging foot's start", *start), ("foothold", x, y))
    standing = feet[::2] if in_the_air else feet
    for obstacle in obstacles:
        box = obstacle.for_ankle(model.foot)
        for name, at, height in feet:
            # An obstacle is in the way of a standing foot whatever its height; a foot may stand right on its top.
            if box.x_start <= at <= box.x_end and (name == "supporting foot" or height < box.height):
                near = box.x_start if at - box.x_start < box.x_end - at else box.x_end
                found.append(Violation(f"obstacle in the {name}", None, at, near, "m", str(obstacle)))
    for gap in gaps:
        pit = gap.for_ankle(model.foot)
        for name, at, _ in standing:
            if pit.x_start < at < pit.x_end:
                near = pit.x_start if at - pit.x_start < pit.x_end - at else pit.x_end
                found.append(Violation(f"{name} in a gap", None, at, near, "m", str(gap)))
    if ground is not None:
        if ground.edges and model.foot.heel + model.foot.toe > 0.0:
            for name, at, height in standing:
                found += _over_a_void(model.foot, name, at, height, ground)
        for name, at, height in feet[::2]:
            level = ground.ankle_on(model.foot, at)
            if abs(height - level) > 2.0 * tolerances.foothold:
                # Where the ankle alone would stand right, it is the sole that reaches under a higher tread.
                stands = abs(height - float(ground.height_at(at))) <= 2.0 * tolerances.foothold
                fault = f"stair in the {name}" if stands else f"{name} off the ground"
                found.append(Violation(fault, None, height, level, "m"))
    return found
