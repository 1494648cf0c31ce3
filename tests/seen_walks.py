"""Walks planned on ground that a simulated camera saw, and what they do on the true ground and on many like it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from seen_scenes import COMMON_STD, Judged, frames_of, judge, random_scene

import ggo_factors as ggo

PLACES = (-0.9, -0.6, -0.3, 0.0)
FARTHEST_GOAL = 2.3
BASE = ggo.paper_base_gait()


@dataclass(frozen=True)
class SeenWalk:
    """A walk over what was seen.

    Attributes:
        judged: what was seen how well.
        plan: the plan, or None where there is no way over what was seen.
        unseen: landings in [m] that the camera did not see from any place, or where no foot may stand.
        struck: true boxes and risers that the swing ankle passes lower than their top.
    """

    judged: Judged
    plan: ggo.Plan | None
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
        return SeenWalk(judged, None)
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
    return SeenWalk(judged, plan, tuple(unseen), tuple(struck(scene.terrain, plan.walk)))


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
        path = [*dense_path(gait, walk.model), x, y]
        for box, top in zip(truth.boxes, truth.tops, strict=True):
            over = (path[:, 0] > box.x_start) & (path[:, 0] < box.x_end)
            if (path[over, 1] < top).any():
                found.append(f"{box} at {path[over, 1].min():.3f} m")
        x, y = path[-1].tolist()
    return found


def hits(plan, edge_errors, height_errors, rng, draws=10_000):
    """How often the walk hits boxes and risers whose errors are drawn from those that cameras made.

    Args:
        plan: the plan, on what was seen.
        edge_errors: errors of edges, each over its stated standard deviation.
        height_errors: the same of heights.
        rng: for the draws.
        draws: of each step.

    Returns:
        For each step with such a box the share of draws with a hit, and the stated probability.
    """
    found = []
    for gait, step, solution in zip(plan.walk.gaits, plan.walk.plan, plan.walk.steps, strict=True):
        boxes = [box for box in step.obstacles if box.is_uncertain]
        if not boxes:
            continue
        path = dense_path(gait, plan.walk.model)
        hit = np.zeros(draws, bool)
        for box in boxes:
            near, far = (x - box.edge_std * rng.choice(edge_errors, draws) for x in (box.x_start, box.x_end))
            top = box.height - box.height_std * rng.choice(height_errors, draws)
            close = path[(path[:, 0] > box.x_start - 0.2) & (path[:, 0] < box.x_end + 0.2)]
            for x, y in close:
                hit |= (x > np.minimum(near, far)) & (x < np.maximum(near, far)) & (y < top)
        found.append((float(hit.mean()), solution.report.hit_probability))
    return found
