"""Choices of footholds that know no plan: any of a grid, the nearest to the walker's own stride, and by descent.

The library's own checked steps are the oracle: what is walked here passes the library's check step by step. Nothing of
the planner is used, neither its costs nor its candidates.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

import ggo_factors as ggo
from ggo_factors.graph.solution import Solution
from ggo_factors.procedures.search import checked_step
from ggo_factors.procedures.steps import walker_of
from ggo_factors.procedures.walker import Walker
from ggo_factors.support.inputs import Array
from ggo_factors.walking.on_terrain import step_on

GRID = 0.025
"""Footholds are tried on a grid of so many metres."""
LONGEST = 1.16
"""No step is tried that is longer, in [m]: plans with the paper's legs go as far down, and 1.06 m on level ground."""
OFTEN = 3
"""A step refused from so many places of the foot behind is not asked for from others."""
STRIDE = 0.39
"""Half a stride of the paper's base gait in [m]."""
QUICK = 0.25
"""Share of the library's own budget that the exhaustive search grants a step: a refusal takes most of its time."""
SPARE = 0.01
"""A plan's soles are so far from edges in [m]; the coordinate search keeps to it too."""
SHIFTS = (0.05, 0.02, 0.0075)
"""How far the coordinate search moves a foothold, in [m]."""


@dataclass(eq=False)
class Feet:
    """A walker on a terrain.

    Attributes:
        walker: as the library has it, between two steps.
        before: x of the foot that swings next in [m].
        at: x of the supporting foot in [m].
        off: where the supporting ankle really is beyond where it was to be, shape (2,) in [m].
        made: the solution of the step that brought it here, None at the start.
        came: from where.
    """

    walker: Walker
    before: float
    at: float
    off: Array
    made: Solution | None = None
    came: Feet | None = None

    def chain(self) -> list[Feet]:
        """What it was after each step, from the first one to this."""
        chain, feet = list[Feet](), self
        while feet.came is not None:
            chain.append(feet)
            feet = feet.came
        return chain[::-1]

    def footholds(self) -> list[float]:
        """Where each step landed, x in [m]."""
        return [feet.at for feet in self.chain()]

    def solutions(self) -> list[Solution]:
        """Each step."""
        return [feet.made for feet in self.chain() if feet.made is not None]

    def steps(self) -> list[tuple[Array, Array]]:
        """Frames and times of each step."""
        return [(made.gait.frames, made.gait.times) for made in self.solutions()]

    def cost(self) -> float:
        """Cost of all steps, see `cost_of`."""
        return sum(map(cost_of, self.solutions()))


def cost_of(solution: Solution) -> float:
    """What a step costs in its graph, half the sum of squares in [rad^2], as `Plan.costs` has it."""
    return float(solution.error_history[-1])


@dataclass(eq=False)
class Way:
    """A terrain with the legs that walk it.

    Attributes:
        terrain: of the library.
        base: the base gait.
        model: the legs, or None for the base gait's own.
        start: the frame to start in, or None for the base gait's first.
        limits: of the joints, or None.
        share: of the library's own budget that a step is granted.
        tried: how many steps were asked for.
    """

    terrain: ggo.Terrain
    base: ggo.Gait
    model: ggo.LegModel | None = None
    start: Array | None = None
    limits: ggo.JointLimits | None = None
    share: float = 1.0
    tried: int = 0

    def begin(self) -> Feet:
        """The walker over x = 0."""
        walker = walker_of(self.base, self.model, self.start, None, None, None, False, self.limits, None)
        settings = replace(walker.settings, nearest=False, work=self.share * walker.settings.work)
        walker = replace(walker, settings=settings)
        return Feet(walker, float(walker.model.endpoint(walker.frame)[0]), 0.0, np.zeros(2))

    def go(self, feet: Feet, to: float, to_standing: bool = False) -> Feet | None:
        """The walker after a step to `to` in [m], or None where the library refuses it or an edge is under the sole."""
        if not is_clear(self.terrain, feet.walker.model.foot, to, spare=0.0):
            return None
        step = step_on(self.terrain, feet.walker.model, feet.before, feet.at, to, to_standing)
        seen = step.shifted(*feet.off.tolist()) if feet.off.any() else step
        walker = feet.walker.toward(seen)
        self.tried += 1
        try:
            made = checked_step(walker.task(seen, 1, 1))
        except ggo.InfeasibleGaitError:
            return None
        off = walker.model.endpoint(made.gait.frames[-1]) - seen.landing(walker.model)
        return Feet(walker.after(made.gait, seen), feet.at, to, off, made, feet)

    def along(self, footholds: Sequence[float], begin: Feet | None = None) -> Feet | None:
        """The walker after steps to these footholds from where it begins, or None where one is refused."""
        feet: Feet | None = self.begin() if begin is None else begin
        for to in footholds:
            if feet is not None:
                feet = self.go(feet, to)
        return feet


def ahead(feet: Feet, goal: float) -> list[float]:
    """Places of the grid that a step may reach, those most like the walker's own stride first."""
    first, last = math.floor(feet.at / GRID + 1e-9) + 1, math.floor(min(feet.at + LONGEST, goal + 0.05) / GRID + 1e-9)
    return sorted((round(n * GRID, 6) for n in range(first, last + 1)), key=lambda x: abs(x - feet.at - STRIDE))


@dataclass(frozen=True)
class Ends:
    """What an exhaustive search came to.

    Attributes:
        feet: at the goal, to the grid; None where there is no way.
        landed: the furthest foothold that a foot came to in [m].
        onward: the furthest that another step was made from; a foot may be put where nobody can go on.
    """

    feet: Feet | None
    landed: float
    onward: float


def exhaustive(way: Way, goal: float, seconds: float = 600.0, begin: Feet | None = None) -> Ends:
    """The way to a goal, to the grid, or how far there is one.

    Depth first over the whole grid. A step depends on its two last footholds and hardly on those before: each pair is
    looked at once.

    Args:
        way: the terrain and who walks it.
        goal: where to go in [m].
        seconds: time of CPU after which it gives up.
        begin: from where; from the beginning if None.

    Raises:
        TimeoutError: where the time is over first.
    """
    way = replace(way, share=QUICK * way.share, tried=0)
    start = way.begin() if begin is None else begin
    until, seen, landed, onward = time.process_time() + seconds, set[tuple[float, float]](), start.at, start.at
    refused = Counter[tuple[float, float]]()
    stack = [(start, iter(ahead(start, goal)))]
    while stack:
        feet, left = stack[-1]
        to = next((x for x in left if (feet.at, x) not in seen and refused[feet.at, x] < OFTEN), None)
        if to is None:
            stack.pop()
            continue
        if time.process_time() > until:
            raise TimeoutError(f"{way.tried} steps tried, as far as {landed:.3f} m")
        after = way.go(feet, to)
        if after is None:
            refused[feet.at, to] += 1
            continue
        seen.add((feet.at, to))
        landed, onward = max(landed, to), max(onward, feet.at)
        if to >= goal - GRID:
            return Ends(after, landed, onward)
        stack.append((after, iter(ahead(after, goal))))
    return Ends(None, landed, onward)


def greedy(way: Way, goal: float) -> tuple[Feet, bool]:
    """The feet where they end, always at the possible foothold nearest to the own stride; and whether at the goal."""
    feet = way.begin()
    while feet.at < goal - GRID:
        for to in ahead(feet, goal):
            after = way.go(feet, to)
            if after is not None:
                feet = after
                break
        else:
            return feet, False
    return feet, True


def is_clear(terrain: ggo.Terrain, foot: ggo.Foot, x: float, spare: float = SPARE) -> bool:
    """Whether a sole over `x` in [m] is so far from risers, boxes and pits in [m], as a plan's are unless said."""
    ends = [(edge, edge) for edge, rise in zip(terrain.whole.edges, terrain.rises, strict=True) if rise]
    ends += [(box.x_start, box.x_end) for box in terrain.boxes] + [(pit.x_start, pit.x_end) for pit in terrain.pits]
    return all(x + foot.toe <= low - spare or x - foot.heel >= high + spare for low, high in ends)


def descent(
    way: Way, footholds: Sequence[float], cost: Callable[[Feet], float] = Feet.cost, sweeps: int = 20
) -> Feet | None:
    """Coordinate search on the true cost: each foothold but the last moved both ways as long as the walk gets cheaper.

    Returns:
        The walker after the cheapest walk found, None where the first one is refused.
    """
    best = way.along(footholds)
    if best is None:
        return None
    for shift in SHIFTS:
        for _ in range(sweeps):
            better = False
            for number in range(len(footholds) - 1):
                for by in (shift, -shift):
                    chain = best.chain()
                    places = best.footholds()
                    places[number] += by
                    moved = None
                    if is_clear(way.terrain, best.walker.model.foot, places[number]):
                        moved = way.along(places[number:], chain[number].came)
                    if moved is not None and cost(moved) < cost(best) * (1.0 - 1e-4):
                        best, better = moved, True
                        break
            if not better:
                break
    return best
