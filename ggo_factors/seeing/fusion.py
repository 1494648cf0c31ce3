"""Frames of one camera moved to agree on the edges and heights that they share: a small factor graph.

As in SLAM with landmarks: each frame is off by a shift that is known to `std` beforehand (a prior), each edge is a
landmark, and each sight of it is a factor between both. Heights have a graph of their own. It is linear, so that one
elimination solves it, and its marginals tell how well what is shared is known: by the root of the number of frames
better than by one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import gtsam
import numpy as np

from ggo_factors.motion.world import Terrain
from ggo_factors.seeing.strip import Strip

SAME_EDGE = 0.06
"""Edges of one kind in two frames that are nearer than this in [m] are the same: half the shortest pit."""
SAME_HEIGHT = 0.04
"""Level ground in two frames that overlaps and differs by less than this in [m] is the same."""
OVERLAP = 0.1
"""Over how much of the way in [m] level ground must overlap to be compared."""
LEAST_RISE = 0.015
"""Risers lower than this in [m] are no landmarks."""
LEAST_STD = 1e-4
"""Everything in the graph is off by this in [m] at least."""


class Sight(NamedTuple):
    """A landmark as one frame saw it: number of the frame and of the landmark, value and standard deviation in [m]."""

    frame: int
    landmark: int
    value: float
    std: float


def aligned(strips: Sequence[Strip], seen: Sequence[Terrain], std: float) -> tuple[list[Strip], tuple[float, float]]:
    """The strips, moved; and what edges and heights are still off by in common, as standard deviations in [m].

    Args:
        strips: of each frame.
        seen: the terrain that each shows alone.
        std: standard deviation in [m] of what the points of one frame have in common.
    """
    along, along_std = _shifts(_edge_sights(seen, std), len(strips), std)
    upward, upward_std = _shifts(_height_sights(seen, std), len(strips), std)
    moved = [strip.shifted(-x, -y) for strip, x, y in zip(strips, along, upward, strict=True)]
    return moved, (along_std, upward_std)


def _shifts(sights: Sequence[Sight], frames: int, std: float) -> tuple[list[float], float]:
    """By how much each frame is off in [m], and the largest standard deviation of that."""
    if std < LEAST_STD:
        return [0.0] * frames, std
    graph, one = gtsam.GaussianFactorGraph(), np.eye(1)
    keys = [gtsam.symbol("s", frame) for frame in range(frames)]
    for key in keys:
        graph.add(key, one, np.zeros(1), gtsam.noiseModel.Isotropic.Sigma(1, std))
    for sight in sights:
        noise = gtsam.noiseModel.Isotropic.Sigma(1, max(sight.std, LEAST_STD))
        landmark = gtsam.symbol("l", sight.landmark)
        graph.add(keys[sight.frame], one, landmark, one, np.array([sight.value]), noise)
    solution = graph.optimize()
    marginals = gtsam.Marginals(graph, solution)
    largest = max(float(marginals.marginalCovariance(key)[0, 0]) for key in keys)
    return [float(solution.at(key)[0]) for key in keys], math.sqrt(largest)


def _edge_sights(seen: Sequence[Terrain], std: float) -> list[Sight]:
    found, known = list[Sight](), dict[str, list[float]]()
    count = 0
    numbers = dict[tuple[str, int], int]()
    for frame, terrain in enumerate(seen):
        for kind, x, edge_std in _edges(terrain):
            places = known.setdefault(kind, [])
            near = [n for n, place in enumerate(places) if abs(place - x) < SAME_EDGE]
            if near:
                number = min(near, key=lambda n: abs(places[n] - x))
            else:
                number = len(places)
                places.append(x)
                numbers[kind, number] = count
                count += 1
            found.append(Sight(frame, numbers[kind, number], x, math.sqrt(max(edge_std**2 - std**2, 0.0))))
    return found


def _edges(terrain: Terrain) -> list[tuple[str, float, float]]:
    risers = [
        ("up" if rise > 0.0 else "down", surface.x_start, surface.edge_std)
        for surface, rise in zip(terrain.surfaces[1:], terrain.rises, strict=True)
        if abs(rise) > LEAST_RISE and surface.edge_std
    ]
    boxes = [(kind, x, box.edge_std) for box in terrain.boxes for kind, x in (("up", box.x_start), ("down", box.x_end))]
    pits = [
        (kind, x, pit.edge_std)
        for pit in terrain.pits
        if not pit.unknown
        for kind, x in (("down", pit.x_start), ("up", pit.x_end))
    ]
    return [*risers, *boxes, *pits]


def _height_sights(seen: Sequence[Terrain], std: float) -> list[Sight]:
    found, known = list[Sight](), list[tuple[float, float, float]]()
    for frame, terrain in enumerate(seen):
        for surface in terrain.surfaces:
            if surface.slope:
                continue
            start, end = surface.x_start, surface.x_end
            same = [
                n
                for n, (low, high, height) in enumerate(known)
                if min(end, high) - max(start, low) > OVERLAP and abs(height - surface.height) < SAME_HEIGHT
            ]
            number = same[0] if same else len(known)
            if not same:
                known.append((start, end, surface.height))
            found.append(Sight(frame, number, surface.height, math.sqrt(max(surface.height_std**2 - std**2, 0.0))))
    return found
