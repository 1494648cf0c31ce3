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
