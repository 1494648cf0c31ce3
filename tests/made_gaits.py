"""Base gaits made for tests: of a walker with a limp, and up stairs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

import ggo_factors as ggo
from ggo_factors.motion.gait import PAPER_MODEL

PAPER = ggo.paper_base_gait()


def pair(left_time=0.52, right_time=0.45, frames=51):
    """Steps of one walker: both legs follow the paper's curves at the times of their own cycle; and those curves."""
    step = ggo.paper_base_gait(201).frames
    leg = CubicSpline(np.linspace(0.0, 1.0, 401), closed(np.vstack([step[:, :2], step[1:, 2:]])), bc_type="periodic")
    stride, made = left_time + right_time, []
    for own in (left_time, right_time):
        phase = np.linspace(0.0, own / stride, frames)
        angles = np.hstack([leg(phase), leg(phase + 1.0 - own / stride)])
        made.append(ggo.Gait(angles, own / (frames - 1), f"{own:g} s", "made", PAPER_MODEL))
    return made, leg


def closed(cycle):
    """A cycle that ends where it begins."""
    return cycle + np.linspace(0.0, 1.0, len(cycle))[:, None] * (cycle[0] - cycle[-1])


def ascent(riser=0.17, tread=0.29):
    """A step up stairs, by the library from the paper's gait."""
    return replace(ggo.climb_stairs(PAPER, riser, tread=tread, first_edge=0.2, steps=3).gaits[2], name="up")


def first_step(riser=0.17, tread=0.29):
    """The step from standing onto the first stair, by the library from the paper's gait."""
    return replace(
        ggo.climb_stairs(PAPER, riser, tread=tread, first_edge=0.2, start=ggo.STANDING).gaits[0], name="first"
    )


def last_step(riser=0.17, tread=0.29):
    """The step from a stair to feet together on level ground, by the library from the paper's gait."""
    flight = ggo.climb_stairs(PAPER, riser, tread=tread, first_edge=0.2, to_standing=True)
    return replace(flight.gaits[-1], name="last")
