"""Random walks and boxes, how fast joints are on a grid of 1 ms by SciPy's splines, and a search that has time."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

import ggo_factors as ggo

STANDING = ggo.Step(end_frame=tuple(ggo.STANDING.tolist()))
TIGHT = ggo.JointLimits(
    **{
        name: float(np.radians(value))
        for name, value in (
            ("hip_speed", 180.0),
            ("knee_speed", 380.0),
            ("hip_acceleration", 1800.0),
            ("knee_acceleration", 5000.0),
        )
    }
)
FRAMES = (51, 101, 151, 201, 301, 401, 501, 801)
LOG = Path(__file__).parents[1] / "datasets" / "children_walk.mcap"
SMOOTHNESSES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
"""Times the default smoothness."""


def base_gait(name):
    """The paper's base gait, or that of the sample log."""
    if name == "paper":
        return ggo.paper_base_gait()
    return ggo.import_base_gait(LOG, joints=LOG.with_suffix(".toml"), model=ggo.LegModel(0.39, 0.39)).gait


def rates(walk):
    """Largest speed and acceleration of hips and knees on a grid of 1 ms, and at the frames, shape (2, 2).

    By a spline of SciPy's through the frames; where the walker does not rest at an end, it has the acceleration there
    of the frame beside it, which is looked up.
    """
    trajectory = walk.joint_trajectory()
    times, own = trajectory.time, trajectory.played
    ends = [
        (1, np.zeros(4)) if rests else (2, own.accelerations[n])
        for n, rests in ((1, own.starts_at_rest), (-2, own.ends_at_rest))
    ]
    spline = CubicSpline(times, trajectory.positions, bc_type=tuple(ends))
    grid = np.unique(np.concatenate([np.arange(0.0, times[-1], 0.001), times]))
    most = np.stack([np.abs(spline(grid, order)).max(axis=0) for order in (1, 2)])
    return most.reshape(2, 2, 2).max(axis=1)


def beyond(walk, limits):
    """By how many times the trajectory goes beyond a limit of rates, at worst."""
    most = np.stack([limits.speed[:2], limits.acceleration[:2]])
    return float((rates(walk) / most).max())


def paces(walk):
    """Share of the base gait's pace between each frame and the next, shape (k - 1,)."""
    return walk.gaits[0].dt / np.diff(walk.times)


def random_plan(rng, most=10):
    """Steps, and where the walker starts (None: as the base gait does)."""
    count, steps = int(rng.integers(1, most + 1)), []
    for _ in range(count):
        length, boxes = float(rng.uniform(0.33, 0.42)), ()
        if rng.random() < 0.4:
            x = float(rng.uniform(0.08, length - 0.12))
            boxes = (ggo.Obstacle(x, x + float(rng.uniform(0.02, 0.06)), float(rng.uniform(0.02, 0.10))),)
        steps.append(ggo.Step((length, 0.0), boxes))
    if count > 1 and rng.random() < 0.5:
        steps[-1] = STANDING
    return steps, ggo.STANDING if rng.random() < 0.5 else None


def random_limits(rng):
    """Limits with rates of a quarter to twice the default ones, and its angles."""
    names = ("hip_speed", "knee_speed", "hip_acceleration", "knee_acceleration")
    wide = ggo.JointLimits()
    scale = np.exp(rng.uniform(np.log(0.25), np.log(2.0), 4))
    return ggo.JointLimits(**{name: getattr(wide, name) * float(by) for name, by in zip(names, scale, strict=True)})


def can_be_made(base, box, foothold, limits, paces):
    """How an unhurried search makes a step over a box: smoothness, whether with constraints, pace; None if it cannot.

    It uses the same graph, but none of the library's choices: eight smoothnesses, soft edges and constraints.
    """
    default = (0.2 * (len(base) - 1)) ** 2
    for pace, times, hard in product(paces, sorted(SMOOTHNESSES, key=lambda s: abs(np.log(s))), (False, True)):
        try:
            ggo.step_over(
                base,
                [ggo.Obstacle(*box)],
                foothold=foothold,
                smoothness=times * default,
                hard=hard,
                limits=limits,
                pace=pace,
                deadline=2.0,
            )
        except ggo.InfeasibleGaitError:
            continue
        return times, hard, pace
    return None
