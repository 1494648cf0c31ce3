"""Walks planned on ground that a simulated camera saw, and what they do on the true ground and on many like it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from seen_scenes import COMMON_STD, Judged, frames_of, judge, random_scene

import ggo_factors as ggo

PLACES = (-0.9, -0.6, -0.3, 0.0)
FARTHEST_GOAL = 2.3
BASE = ggo.paper_base_gait()


Near = tuple[np.ndarray, tuple[ggo.Obstacle, ...], float]


@dataclass(frozen=True, eq=False)
class SeenWalk:
    """A walk over what was seen.

    Attributes:
        judged: what was seen how well.
        steps: how many steps it has; none where there is no way over what was seen.
        near: of each step by boxes or risers measured with an error: path, boxes, stated probability of a hit.
        unseen: landings in [m] that the camera did not see from any place, or where no foot may stand.
        struck: true boxes and risers that the swing ankle passes lower than their top.
    """

    judged: Judged
    steps: int = 0
    near: tuple[Near, ...] = ()
    unseen: tuple[float, ...] = ()
    struck: tuple[str, ...] = ()


def seen_walk(seed):
    """The walk over a random scene that a walker sees from four places on the way to where the walk begins."""
    scene = random_scene(seed)
    frames = frames_of(scene, PLACES, common=COMMON_STD)
    terrain = ggo.terrain_from_sightings([ggo.Sighting(f.points(), **f.told()) for f in frames], std=COMMON_STD)
    judged = judge(frames[-1], terrain)
    plan = planned(terrain)
    if plan is None:
        return SeenWalk(judged)
    visible = np.zeros_like(scene.visible()[1])
    for frame in frames:
        grid, seen = frame.visible()
        visible |= seen
    unseen = []
    for x in plan.footholds:
        near = np.abs(grid - x) < 0.02
        bad = any(shape.x_start <= x <= shape.x_end for shape in (*scene.terrain.pits, *scene.terrain.boxes))
        if bad or not visible[near].any():
            unseen.append(x)
    hit = tuple(struck(scene.terrain, plan.walk))
    return SeenWalk(judged, len(plan.footholds), near_boxes(plan.walk), tuple(unseen), hit)


def planned(terrain):
    """A plan as far as one can be had, or None."""
    for goal in np.arange(min(FARTHEST_GOAL, terrain.x_end - 0.1), 0.5, -0.15):
        try:
            return ggo.plan_walk(BASE, terrain, goal=float(goal))
        except (ggo.InputError, ggo.InfeasibleGaitError):
            continue
    return None


def dense_path(gait, model, between=12):
    """The swing ankle of a step, joint angles linear between frames, shape (n, 2) in [m]."""
    share = np.linspace(0.0, 1.0, between, endpoint=False)[:, None]
    dense = np.concatenate(
        [one + share * (other - one) for one, other in zip(gait.frames, gait.frames[1:], strict=False)]
    )
    return model.joints(np.concatenate([dense, gait.frames[-1:]]))[:, 4]


def struck(truth, walk):
    """Boxes of the true ground that the swing ankle passes too low."""
    x, y, found = 0.0, float(truth.height_at(0.0)), []
    for gait in walk.gaits:
        path = np.add(dense_path(gait, walk.model), [x, y])
        for box, top in zip(truth.boxes, truth.tops, strict=True):
            over = (path[:, 0] > box.x_start) & (path[:, 0] < box.x_end)
            if (path[over, 1] < top).any():
                found.append(f"{box} at {path[over, 1].min():.3f} m")
        x, y = path[-1].tolist()
    return found


def near_boxes(walk):
    """The steps by boxes or risers that were measured with an error."""
    found = []
    for gait, step, solution in zip(walk.gaits, walk.plan, walk.steps, strict=True):
        boxes = tuple(box for box in step.obstacles if box.is_uncertain)
        if boxes:
            found.append((dense_path(gait, walk.model), boxes, float(solution.report.hit_probability)))
    return tuple(found)


def hit_share(path, boxes, edge_errors, height_errors, rng, draws=10_000):
    """How often a path hits boxes whose errors are drawn from those that cameras made.

    Args:
        path: the swing ankle in [m], shape (n, 2).
        boxes: as they were seen.
        edge_errors: errors of edges, each over its stated standard deviation.
        height_errors: the same of heights.
        rng: for the draws.
        draws: how many.
    """
    hit = np.zeros(draws, bool)
    for box in boxes:
        near, far = (x - box.edge_std * rng.choice(edge_errors, draws) for x in (box.x_start, box.x_end))
        top = box.height - box.height_std * rng.choice(height_errors, draws)
        close = path[(path[:, 0] > box.x_start - 0.2) & (path[:, 0] < box.x_end + 0.2)]
        for x, y in close:
            hit |= (x > np.minimum(near, far)) & (x < np.maximum(near, far)) & (y < top)
    return float(hit.mean())
