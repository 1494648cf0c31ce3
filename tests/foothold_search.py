"""Choices of footholds that know no plan: every one of a grid, the nearest to the walker's own stride, and by descent.

The library's own checked steps are the oracle: what is walked here passes the library's check step by step. Nothing of
the planner is used, neither its costs nor its candidates.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

import ggo_factors as ggo
from ggo_factors.graph.rounds import Budget
from ggo_factors.procedures import search
from ggo_factors.procedures.build import beginning_of, impossible
from ggo_factors.procedures.steps import walker_of

GRID = 0.025
"""Footholds are tried on a grid of so many metres."""
LONGEST, SHORTEST = 0.70, 0.0
"""No step is tried that is longer, or shorter, in [m]."""
AROUND = 0.35
"""So far behind the feet and beyond the foothold a step sees the ground, in [m]."""


@dataclass(eq=False)
class Feet:
    """A walker on a terrain: x of the foot that swings next and of the supporting one in [m], and what brought it here.

    `off` is where the supporting ankle really is beyond where it was to be, shape (2,) in [m].
    """

    walker: object
    before: float
    at: float
    off: np.ndarray
    made: object = None
    came: Feet | None = None

    def chain(self):
        """All from the start to here."""
        return [*([] if self.came is None else self.came.chain()), self]


@dataclass(eq=False)
class Ground:
    """A terrain with the legs that walk it; counts the steps that were tried.

    Attributes:
        terrain: of the library.
        base: the base gait.
        model: the legs, or the base gait's own.
        start: frame to start in, or None.
        work: how much may be spent on a step; the library's own budget if None.
    """

    terrain: ggo.Terrain
    base: ggo.Gait
    model: ggo.LegModel | None = None
    start: np.ndarray | None = None
    work: float | None = None
    tried: int = 0
    known: dict = field(default_factory=dict)

    def begin(self):
        """The walker at x = 0."""
        walker = walker_of(self.base, self.model, self.start, None, None, None, False, None, None)
        return Feet(walker, float(walker.model.endpoint(walker.frame)[0]), 0.0, np.zeros(2))

    def step(self, feet, to, end_frame=None):
        """What a step from these feet to a foothold must do."""
        foot, ground = feet.walker.model.foot, self.terrain
        low, high = min(feet.before, feet.at) - AROUND, max(to, feet.at) + AROUND
        rise = ground.ankle_at(to, foot) - ground.ankle_at(feet.at, foot)
        step = ggo.Step(
            None if end_frame is not None else (to - feet.at, rise),
            ground.boxes_from(feet.at, low, high, foot),
            ground.pits_from(feet.at, low, high),
            ground=ground.seen_from(feet.at, low, high),
            end_frame=end_frame,
        )
        return step.shifted(*feet.off.tolist()) if feet.off.any() else step

    def go(self, feet, to):
        """The walker after a step to a foothold, or None where the library refuses it."""
        step = self.step(feet, to)
        walker = feet.walker.toward(step)
        task = walker.task(step, 1, 1)
        if np.hypot(*step.foothold) > 2.0 * walker.model.reach:
            return None
        begin = beginning_of(task)
        if impossible(task, begin):
            return None
        self.tried += 1
        budget = Budget(task.settings.work if self.work is None else self.work, float("inf"))
        found = search._found(task, begin, budget)
        if isinstance(found, str) or not found.ok:
            return None
        off = walker.model.endpoint(found.gait.frames[-1]) - step.foothold
        return Feet(walker.after(found.gait, step), feet.at, to, off, found, feet)


def grid(low, high):
    """Places of the grid from `low` to `high` in [m]."""
    return [round(n * GRID, 6) for n in range(int(np.ceil(low / GRID - 1e-9)), int(np.floor(high / GRID + 1e-9)) + 1)]


def exhaustive(ground, goal, seconds=600.0, stride=0.39):
    """The feet at a goal by depth-first search over the whole grid; None where there is no way; and how far it came.

    A step depends on the last two footholds, and hardly on what was before them: each pair is looked at once.

    Raises:
        TimeoutError: where the time is over first, with how far it came.
    """
    began, dead, far = time.process_time(), set(), [0.0]

    def ways(feet):
        """Footholds ahead, those most like the walker's own stride first; a step that only closes up comes last."""
        places = grid(feet.at + SHORTEST, min(feet.at + LONGEST, goal + 0.05))
        return sorted((x for x in places if x > feet.at + 1e-9), key=lambda x: abs(x - feet.at - stride))

    stack = [(ground.begin(), None)]
    while stack:
        feet, left = stack.pop()
        if feet.at >= goal - GRID:
            return feet, feet.at
        if left is None:
            if (feet.before, feet.at) in dead:
                continue
            dead.add((feet.before, feet.at))
            left = ways(feet)
        for number, to in enumerate(left):
            if (feet.at, to) in dead:
                continue
            if time.process_time() - began > seconds:
                raise TimeoutError(f"{ground.tried} steps tried, as far as {far[0]:.3f} m")
            after = ground.go(feet, to)
            if after is not None:
                far[0] = max(far[0], to)
                stack.append((feet, left[number + 1 :]))
                stack.append((after, None))
                break
    return None, far[0]


def greedy(ground, goal, stride=0.39):
    """The feet at a goal, or where it gets stuck: of the grid always the possible foothold nearest to the own stride."""
    feet = ground.begin()
    while feet.at < goal - GRID:
        places = [x for x in grid(feet.at, min(feet.at + LONGEST, goal + 0.05)) if x > feet.at + 1e-9]
        for to in sorted(places, key=lambda x: abs(x - feet.at - stride)):
            after = ground.go(feet, to)
            if after is not None:
                break
        else:
            return feet, False
        feet = after
    return feet, True
