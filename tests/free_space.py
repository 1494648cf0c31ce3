"""Whether any motion at all takes the swinging foot to its foothold: a search that knows no comfort and no graph.

It goes from state to neighbouring state of a grid: angles of the supporting hip and knee, and place of the swinging
ankle, to which inverse kinematics bends the other leg. A foothold beside a box stands on the grid, so a passage a few
millimetres wide is not lost there. From one state to the next, what may touch a box moves by less than half of what a
shank is thick or a sole is long: no box, however thin, is jumped through; at most a corner is cut by millimetres.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.ndimage import label

import ggo_factors as ggo
from ggo_factors.check.leg_collision import leg_clearance

TURN = np.radians(4.0)
STEP = 0.010
SLACK = 0.002
"""How far in [m] a leg may reach into a box, or beyond its length, and count as free here all the same."""


def free_states(model, box, alphas, betas, places, lowest_hip):
    """Which states are free: joints in the range that `verify` allows, whole leg and sole clear of the box.

    Args:
        model: the legs.
        box: the obstacle.
        alphas: angles of the supporting hip in [rad], shape (a,).
        betas: angles of the supporting knee in [rad], shape (b,).
        places: of the swinging ankle in [m], shape (n, 2).
        lowest_hip: least height of the hip over the supporting ankle in [m].

    Returns:
        Shape (a, b, n).
    """
    allowed = ggo.Tolerances()
    around = box.for_ankle(model.foot)
    high = (places[:, 1] >= box.height - SLACK) | (places[:, 0] <= around.x_start + SLACK)
    outside = high | (places[:, 0] >= around.x_end - SLACK)
    free = np.zeros((len(alphas), len(betas), len(places)), dtype=bool)
    for i, j in product(range(len(alphas)), range(len(betas))):
        hip = model.joints(np.array([alphas[i], betas[j], 0.0, 0.0]))[2]
        away = np.hypot(*(places - hip).T)
        near = np.flatnonzero(outside & (abs(model.thigh - model.shank) <= away) & (away <= model.reach + SLACK))
        if hip[1] < lowest_hip or not near.size:
            continue
        drawn = hip + (places[near] - hip) * np.minimum(1.0, model.reach / away[near])[:, None]
        support = np.broadcast_to([alphas[i], betas[j]], drawn.shape)
        thigh, knee = model.inverse_kinematics(drawn, support).T
        human = (allowed.thigh_back <= thigh) & (thigh <= allowed.thigh_forward) & (knee <= allowed.knee_bent)
        frames = np.column_stack([support, thigh, knee])[human]
        clear = leg_clearance(model, frames, [box])[:, :4].min(axis=(1, 2)) >= -SLACK
        free[i, j, near[human][clear]] = True
    return free


def way_exists(model, moving, box, foothold):
    """Whether free states lead to a foothold on level ground.

    Args:
        model: the legs.
        moving: frames of the walker's present motion in [rad], shape (k, 4), which the search goes on from.
        box: the obstacle.
        foothold: where the swinging ankle must land in [m], shape (2,).
    """
    if leg_clearance(model, moving, [box]).min() < 0.0:
        return False
    lowest_hip = model.joints(moving[0])[2, 1] - ggo.Tolerances().hip_drop * model.reach
    start, ankle = moving[-1], model.endpoint(moving[-1])
    alphas, betas = np.arange(np.radians(-50.0), np.radians(80.0), TURN), np.arange(0.0, np.radians(100.0), TURN)
    xs = foothold[0] + np.arange(np.floor((ankle[0] - foothold[0] - 0.1) / STEP), 0.1 / STEP) * STEP
    ys = foothold[1] + np.arange(0.0, (box.height + 0.15) / STEP) * STEP
    places = np.stack(np.meshgrid(xs, ys, indexing="ij"), -1)
    free = free_states(model, box, alphas, betas, places.reshape(-1, 2), lowest_hip)
    pieces, _ = label(free.reshape(*free.shape[:2], *places.shape[:2]), np.ones((3, 3, 3, 3)))
    axes = zip((alphas, betas, xs, ys), (*start[:2], *ankle), (TURN, TURN, STEP, STEP), strict=True)
    here = pieces[np.ix_(*(np.flatnonzero(np.abs(axis - at) <= 1.01 * cell) for axis, at, cell in axes))]
    landed = pieces[:, :, np.abs(xs - foothold[0]).argmin(), 0]
    return bool(np.intersect1d(here[here > 0], landed[landed > 0]).size)
