"""A dense check and a kinematic search that share no code with the library they judge."""

from __future__ import annotations

import math

import numpy as np
import shapely


def path_of(frames, thigh=0.39, shank=0.39):
    """P by the paper's Eq. 1, written out."""
    a1, b1, a2, b2 = np.moveaxis(np.asarray(frames), -1, 0)
    x = thigh * (np.sin(a2) - np.sin(a1)) + shank * (np.sin(a2 - b2) - np.sin(a1 - b1))
    y = thigh * (np.cos(a1) - np.cos(a2)) + shank * (np.cos(a1 - b1) - np.cos(a2 - b2))
    return np.stack([x, y], -1)


def densely(frames, instants=2000):
    """Frames at many instants, joint angles linear between samples."""
    at = np.linspace(0, len(frames) - 1, instants)
    return np.stack([np.interp(at, np.arange(len(frames)), column) for column in np.asarray(frames).T], -1)


def clearance(frames, x_start, x_end, height, **legs):
    """Least height of P over a box; infinite where P never passes over it."""
    x, y = path_of(densely(frames), **legs).T
    inside = (x_start <= x) & (x <= x_end)
    return float((y[inside] - height).min()) if inside.any() else math.inf


def least_knee_deg(frames):
    """The least knee angle."""
    return float(np.degrees(np.asarray(frames)[:, [1, 3]].min()))


def stair_clearance(frames, edges, heights, zone=0.020, **legs):
    """Least height of P over a stair profile further than `zone` from both ends of the step."""
    path = path_of(densely(frames), **legs)
    profile = np.array(heights)[np.searchsorted(edges, path[:, 0], side="right")]
    away = (np.abs(path[:, 0] - path[0, 0]) > zone) & (np.abs(path[:, 0] - path[-1, 0]) > zone)
    return float((path[:, 1] - profile)[away].min())


def leg_clearance(
    frames, boxes=(), edges=(), heights=(0.0,), thigh=0.39, shank=0.39, foot=(0.0, 0.0, 0.0), radii=(0, 0)
):
    """Least distance of either leg's thigh and shank from boxes and stairs, and of the swinging sole from boxes.

    Densely, by shapely, in the frame of the supporting sole. For ankles that are higher above their sole than the shank
    is thick: no round end is cut.
    """
    ankle, heel, toe = foot
    a1, b1, a2, b2 = densely(frames).T
    down = -1j  # the plane as complex numbers: a link that hangs at an angle from the vertical is turned by it
    hip = 1j * ankle - shank * down * np.exp(1j * (a1 - b1)) - thigh * down * np.exp(1j * a1)
    knees = [hip + thigh * down * np.exp(1j * a) for a in (a1, a2)]
    ankles = [knee + shank * down * np.exp(1j * u) for knee, u in zip(knees, (a1 - b1, a2 - b2), strict=True)]
    bodies = [shapely.box(x_start, -9.0, x_end, height) for x_start, x_end, height in boxes]
    sole = _least(ankles[1] - 1j * ankle - heel, ankles[1] - 1j * ankle + toe, bodies)
    if len(edges):
        sides = zip([-9.0, *edges], [*edges, 9.0], heights, strict=True)
        bodies.append(shapely.union_all([shapely.box(low, -9.0, high, top) for low, high, top in sides]))
    thighs = min(_least(hip, knee, bodies) for knee in knees) - radii[0]
    shanks = min(_least(knee, end, bodies) for knee, end in zip(knees, ankles, strict=True)) - radii[1]
    return min(thighs, shanks), sole


def _least(starts, ends, bodies):
    pieces = shapely.linestrings(np.stack([[starts.real, starts.imag], [ends.real, ends.imag]]).transpose(2, 0, 1))
    return min((float(shapely.distance(pieces, body).min()) for body in bodies), default=math.inf)


def way_over(frames, box, foothold, thigh=0.39, shank=0.39, spare=0.005):
    """Whether inverse kinematics finds some way over a box, comfort aside: the support leg as in the base frames.

    P rises straight to `spare` over the box, passes it level, and comes down on the foothold, at several paces.
    """
    x_start, x_end, height = box
    start, top = path_of(frames, thigh, shank)[0], height + spare
    corners = np.array([start, [min(start[0], x_start - spare), top], [x_end + spare, top], foothold])
    for pace in (0.3, 0.45, 0.6, 0.75, 0.9):
        for before in (0.1, 0.2, 0.3, 0.4):
            times = np.array([0.0, before, max(pace, before + 0.05), 1.0])
            share = np.linspace(0.0, 1.0, 400)
            points = np.stack([np.interp(share, times, column) for column in corners.T], -1)
            support = densely(frames, 400)[:, :2]
            hip_x = -thigh * np.sin(support[:, 0]) - shank * np.sin(support[:, 0] - support[:, 1])
            hip_y = thigh * np.cos(support[:, 0]) + shank * np.cos(support[:, 0] - support[:, 1])
            right, down = points[:, 0] - hip_x, hip_y - points[:, 1]
            distance = np.hypot(right, down)
            if (distance > thigh + shank).any():
                continue
            knee = np.arccos((distance**2 - thigh**2 - shank**2) / (2 * thigh * shank))
            lift = np.arctan2(right, down) + np.arctan2(shank * np.sin(knee), thigh + shank * np.cos(knee))
            if np.degrees(knee).max() < 150 and np.degrees(lift).max() < 130 and np.degrees(lift).min() > -50:
                return True
    return False


def hit_share(path, box, edge_std, height_std, draws=100_000, seed=0):
    """Share of the draws of a box (x_start, x_end, height) that a path hits, by its points."""
    errors = np.random.default_rng(seed).standard_normal((3, draws))
    edges = np.sort(np.array(box[:2])[:, None] + edge_std * errors[:2], axis=0)
    top = box[2] + height_std * errors[2]
    hit = np.zeros(draws, dtype=bool)
    for x, y in np.asarray(path):
        hit |= (edges[0] <= x) & (x <= edges[1]) & (y < top)
    return float(hit.mean())
