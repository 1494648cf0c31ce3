"""Plans over courses, and what they do at boxes."""

from __future__ import annotations

import math

import numpy as np
from world_check import ankle_on, between, joints_of, legs_of, sole_of

import ggo_factors as ggo
from ggo_factors.planning.replan_plan import replan_plan

BASE = ggo.paper_base_gait()


def plan_on(course, std=0.0, **asked):
    """The library's plan from x = 0 to a course's goal, which is known to a standard deviation in [m]."""
    return ggo.plan_walk(BASE, course.terrain(std), goal=course.goal, **asked)


def replanned(plan, course, std):
    """The plan made again before its first step, for a course as it is seen now."""
    return replan_plan(plan, course.terrain(std), step=1)


def apart(plan, other):
    """How far any foothold of one plan is from that of another in [m]; infinite where one has more steps."""
    if len(plan.footholds) != len(other.footholds):
        return math.inf
    return float(np.abs(np.subtract(plan.footholds, other.footholds)).max())


def boxes_met(course, walk):
    """Of each box, where a foot first steps over it: share of the step before it, and least height of the sole over it.

    The step is from where the foot stands that is not lifted to where the other one lands; the box begins at its near
    edge. In [m].
    """
    legs, at, met = legs_of(walk.model), ankle_on(course, legs_of(walk.model), 0.0), {}
    for gait in walk.gaits:
        ankle = at + joints_of(between(gait.frames, gait.times, 400), legs)[3]
        share = np.clip((ankle.real - ankle[0].real) / (ankle[-1] - ankle[0]).real, 0.0, 1.0)
        tilts = [course.piece_at(end.real)[3] for end in (ankle[0], ankle[-1])]
        heel, toe = sole_of(legs, ankle, tilts[0] + share * (tilts[1] - tilts[0]))
        for box in course.boxes:
            if box not in met and at.real < box[0] and ankle[-1].real > box[1]:
                over = (heel.real < box[1]) & (toe.real > box[0])
                least = np.minimum(heel.imag, toe.imag)[over].min() - course.top_of(box)
                met[box] = ((box[0] - at.real) / (ankle[-1] - at).real, float(least))
        at = complex(ankle[-1])
    return list(met.values())
