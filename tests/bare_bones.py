"""Bones and boxes by code of its own: whether an axis of a gait lies in a box, and whether any motion passes one."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from independent import densely

LEG = 0.39
"""Length of thigh and shank in [m]."""
PACES = np.linspace(0.0, 1.0, 240)


def joints(frames):
    """Support ankle, knee, hip, swing knee and ankle in [m], shape (m, 5, 2): the paper's legs, written out."""
    a1, b1, a2, b2 = np.asarray(frames).T
    knee = LEG * np.stack([-np.sin(a1 - b1), np.cos(a1 - b1)], -1)
    hip = knee + LEG * np.stack([-np.sin(a1), np.cos(a1)], -1)
    other = hip + LEG * np.stack([np.sin(a2), -np.cos(a2)], -1)
    ankle = other + LEG * np.stack([np.sin(a2 - b2), -np.cos(a2 - b2)], -1)
    return np.stack([np.zeros_like(knee), knee, hip, other, ankle], -2)


def deepest(points, box):
    """How long a stretch of an axis, in [m], lies in a box (x_start, x_end, height), of joints (m, 5, 2).

    Each axis is cut at the box's sides and at its top: what is left between the cuts lies in it.
    """
    start, run = points[:, :-1], np.diff(points, axis=1)
    low, high = np.zeros(start.shape[:2]), np.ones(start.shape[:2])
    for at, slope in (
        (start[..., 0] - box[0], run[..., 0]),
        (box[1] - start[..., 0], -run[..., 0]),
        (box[2] - start[..., 1], -run[..., 1]),
    ):
        with np.errstate(divide="ignore", invalid="ignore"):
            cut = -at / slope
        low = np.where(slope > 0.0, np.maximum(low, cut), np.where((slope == 0.0) & (at <= 0.0), 2.0, low))
        high = np.where(slope < 0.0, np.minimum(high, cut), high)
    return float((np.maximum(high - low, 0.0) * LEG).max())


def axis_in(gait, box):
    """The longest stretch in [m] of an axis in a box, of a gait played on a grid of 1 ms or finer."""
    return deepest(joints(densely(gait.frames, 10 * round(1e2 * gait.duration / 1.0 + 1) + 1)), box)


def bent(hip, foot):
    """The knee of a leg from hips to feet, both (m, 2) in [m], bent forwards; NaN where it does not reach."""
    run = foot - hip
    distance = np.hypot(run[:, 0], run[:, 1])
    with np.errstate(invalid="ignore"):
        out = np.sqrt(LEG**2 - distance**2 / 4.0)
    # From hip down to foot, forwards is to the left of the way.
    return hip + run / 2.0 + (out / distance)[:, None] * np.stack([-run[:, 1], run[:, 0]], -1)


def way_past(frame, box, foothold):
    """Whether some motion takes the swing ankle from a frame (4,) in [rad] over a box to a foothold, bones clear.

    The hip goes straight to a place of a grid, at most a fifth of a leg lower; the ankle up before the box, over it and
    down behind it, at several heights and places. It knows no comfort, no speed, no graph: what it finds exists.
    """
    start = joints(frame[None])[0]
    hip_from, ankle_from = start[2], start[4]
    before, behind, top = box[0] - ankle_from[0], foothold[0] - box[1], box[2]
    hips = product(
        np.linspace(hip_from[0] + 0.05, foothold[0], 9), hip_from[1] - np.array([0.0, 0.03, 0.07, 0.11, 0.15])
    )
    for hip_x, hip_y in hips:
        for turn, lift, beyond, early in product((0.5, 0.75), (0.005, 0.05, 0.12), (0.5, 1.0, 2.0), (0.3, 0.6)):
            times = np.array([0.0, 0.3 * turn, turn, turn + 0.5 * (1.0 - turn), 1.0])
            xs = [ankle_from[0], ankle_from[0] + 0.3 * before, foothold[0] + (beyond - 1.0) * behind]
            ankle = np.stack(
                [
                    np.interp(PACES, times, [*xs, foothold[0] + 0.5 * (beyond - 1.0) * behind, foothold[0]]),
                    np.interp(PACES, times, [ankle_from[1], top + lift, top + lift, 0.5 * (top + lift), foothold[1]]),
                ],
                -1,
            )
            share = np.interp(PACES, [0.0, early, 1.0], [0.0, 0.8, 1.0])[:, None]
            hip = (1.0 - share) * hip_from + share * [hip_x, hip_y]
            support, swing = bent(hip, np.zeros_like(hip)), bent(hip, ankle)
            support[0], swing[0] = start[1], start[3]
            points = np.stack([np.zeros_like(hip), support, hip, swing, ankle], 1)
            if np.isfinite(points).all() and deepest(points, box) <= 0.0:
                return True
    return False


def pointed(gait):
    """A gait on the paper's legs, whose bones are points."""
    return replace(gait, model=replace(gait.model, bones="points"))


def random_boxes(foothold_x, count, seed, hard=False):
    """Boxes (x_start, x_end, height) before a foothold, 1 to 100 mm off and to 0.18 m high; hard ones near and high."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        height, width = rng.uniform(0.05 if hard else 0.0, 0.18), rng.uniform(0.005, 0.08)
        end = foothold_x - rng.uniform(0.001, 0.02 if hard else 0.1)
        yield float(end - width), float(end), float(height)
