"""Where on a terrain a foot may stand: the sole wholly on one surface, clear of edges, boxes and pits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ggo_factors.motion.leg_model import Foot
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.motion.world import RAMP_BESIDE, Terrain
from ggo_factors.support.inputs import Array

SPARE = 0.01
"""How far in [m] a sole stays from edges, boxes and pits whose places are known."""
DEVIATIONS = 4.0
"""By so many standard deviations of an edge's place it stays further away: the edge is nearer in 1 of 30,000, as one of
several edges of a step may be within its probability of a hit."""
GRID = 0.05
"""Distance of footholds that are considered in [m]; the cost is flat, and they slide afterwards."""
NARROW = 0.15
"""A stretch narrower than this in [m] has a candidate in its middle too."""


def blocked(terrain: Terrain, foot: Foot) -> Array:
    """Stretches of x in [m] in which no ankle may stand, shape (k, 2), by what is there; they may overlap."""
    stretches = []
    for before, surface, rise in terrain.seams:
        spare = (SPARE if rise else 0.0) + DEVIATIONS * surface.edge_std
        if rise or before.slope != surface.slope:
            # A sole on a ramp is further on, or back, than its ankle.
            spare += foot.ankle_height * math.sin(max(abs(before.slope), abs(surface.slope)))
            stretches.append((surface.x_start - foot.toe - spare, surface.x_start + foot.heel + spare))
    shapes: list[Obstacle | Gap] = [*terrain.boxes, *terrain.no_footholds]
    for shape in shapes:
        steepest = terrain.steepest_between(shape.x_start - RAMP_BESIDE, shape.x_end + RAMP_BESIDE)
        spare = SPARE + DEVIATIONS * shape.edge_std + foot.ankle_height * math.sin(steepest)
        stretches.append((shape.x_start - foot.toe - spare, shape.x_end + foot.heel + spare))
    return np.array(stretches).reshape(-1, 2)


def may_stand(x: Array, stretches: Array) -> NDArray[np.bool_]:
    """Which ankles at `x` in [m], shape (n,), stand outside all blocked stretches (k, 2)."""
    inside = (x[:, None] > stretches[:, 0] + 1e-12) & (x[:, None] < stretches[:, 1] - 1e-12)
    return np.asarray(~inside.any(axis=1))


def free_stretches(stretches: Array, low: float, high: float) -> list[tuple[float, float]]:
    """The stretches of x in [m] between `low` and `high` that are not blocked, ascending."""
    free, at = list[tuple[float, float]](), low
    for begins, ends in sorted(stretches.tolist()):
        if begins > high:
            break
        if begins >= at:
            free.append((at, begins))
        at = max(at, ends)
    if at <= high:
        free.append((at, high))
    return free


def candidates(stretches: Array, low: float, high: float, keep: tuple[float, ...], apart: float = GRID) -> Array:
    """Footholds to consider between `low` and `high` in [m], ascending: a grid from `low`, and ends of free stretches.

    Args:
        stretches: what is blocked, shape (k, 2) in [m].
        low: the first place in [m].
        high: the last one.
        keep: places that are among them in any case, in [m].
        apart: how far apart they are, in [m].
    """
    grid = np.asarray(low + apart * np.arange(math.floor((high - low) / apart) + 1), dtype=np.float64)
    places = [*grid[may_stand(grid, stretches)].tolist(), *keep]
    for begins, ends in free_stretches(stretches, low, high):
        places += [begins, ends] + ([(begins + ends) / 2.0] if ends - begins < NARROW else [])
    every = np.unique(np.round(places, 6))
    near = np.diff(every, append=math.inf) < apart / 5.0
    kept = np.isin(every, np.round(keep, 6))
    drop = near & ~kept & ~np.append(kept[1:], False)
    found = every[~drop]
    for place in keep:
        found[np.abs(found - place).argmin()] = place  # to the last bit
    return np.asarray(found)
