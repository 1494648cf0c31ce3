"""A dense check and a kinematic search that share no code with the library they judge."""

from __future__ import annotations

import math

import numpy as np


def path_of(frames, thigh=0.39, shank=0.39):
    """P by the paper's Eq. 1, written out."""
    a1, b1, a2, b2 = np.asarray(frames).T
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
