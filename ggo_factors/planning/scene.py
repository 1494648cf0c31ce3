"""A walker on a terrain, on the way to a goal: which steps there may be, and what they cost, before any is made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.leg_collision import BESIDE
from ggo_factors.check.report import STANDARD
from ggo_factors.motion.gait import swap_roles
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.footholds import GRID, blocked, free_stretches
from ggo_factors.planning.known import Known
from ggo_factors.planning.near_cost import NearCosts
from ggo_factors.planning.people import LEADING_MEAN, PeoplePreference
from ggo_factors.planning.postures import postures, upright
from ggo_factors.planning.reach import SHORTEST, SINKS, Reach, reach_on
from ggo_factors.planning.step_cost import MARGIN, Roof, StepCosts, blocks_on, roof_of
from ggo_factors.procedures.walker import Walker
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import STANDING

ALIKE = 1e-4
"""Pairs of feet whose places relative to each other differ by less in [m] have one posture."""
TURN = 0.03
"""A change of slope under a swing in [m] of way counts as something in its way so far around it."""


@dataclass(frozen=True, eq=False)
class Footholds:
    """Footholds of a plan by what its steps cost.

    Attributes:
        places: x of both feet at the start, the one behind first, and of each landing, in [m].
        costs: what each step costs, the closing one's last where there is one, in [rad^2].
        considered: x of each candidate in [m].
    """

    places: tuple[float, ...]
    costs: tuple[float, ...]
    considered: tuple[float, ...]


Made = tuple[Footholds, Sequence[float]]
"""Footholds that were found before, and what their steps really cost, in [rad^2]."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A walker on a terrain, on the way to a goal: which steps there may be, and what they cost.

    Attributes:
        terrain: the ground.
        walker: the walker at the start.
        feet: x of its swing ankle and its supporting ankle in the world frame in [m].
        goal: where it is to arrive, in [m].
        to_standing: whether it then stands, the feet beside each other.
        preference: what is preferred beside little change, or None.
        keep: footholds of a plan before in [m], which are kept where little speaks against it.
        kept: what it costs in [rad^2] to land further than `GRID` from all of those, or to leave one out.
        banned: steps that were refused, by their three places in [m]; the first is NaN where it is of no account.
        around: steps whose places differ from a banned one's by no more than this in [m] are banned too.
        grid: distance of candidates in [m].
        sinks: share of the leg by which the hip may sink in a step on level ground.
    """

    terrain: Terrain
    walker: Walker
    feet: tuple[float, float]
    goal: float
    to_standing: bool
    preference: PeoplePreference | None = None
    keep: tuple[float, ...] = ()
    kept: float = 0.0
    banned: list[tuple[float, float, float]] = field(default_factory=list)
    around: float = GRID / 2.0
    grid: float = GRID
    sinks: float = SINKS

    @cached_property
    def stretches(self) -> Array:
        """Where no ankle may stand, shape (k, 2) in [m]."""
        return blocked(self.terrain, self.walker.model.foot)

    @cached_property
    def roof(self) -> Roof:
        """What the swing ankle must stay above."""
        lift = 0.0 if self.preference is None else LEADING_MEAN - MARGIN
        return roof_of(self.terrain, self.walker.model, lift)

    @cached_property
    def step_costs(self) -> StepCosts:
        """Costs of steps bent from the base gait for level ground."""
        walker = self.walker
        base = walker.bases.gait("level", walker.swing)
        return StepCosts(base, walker.model, walker.settings.smoothness, self.roof, blocks_on(self.terrain))

    @cached_property
    def near_costs(self) -> NearCosts:
        """The same steps' costs, nearly."""
        return NearCosts(self.step_costs)

    @cached_property
    def reach(self) -> Reach:
        """How long and how short steps may be. Feet of a plan before spare no more for the ground as it is seen now."""
        limits = self.walker.settings.limits
        return reach_on(self.terrain, self.walker.model, self.step_costs.base, limits, self.sinks, bool(self.keep))

    def free_near(self, places: Sequence[float]) -> tuple[float, ...]:
        """The free place nearest to each in [m]: one that is blocked now gives way; none where nothing is free."""
        free = np.array(free_stretches(self.stretches, self.feet[1] + SHORTEST, self.goal)).reshape(-1, 2)
        if not len(free):
            return ()
        at = np.array(places).reshape(-1, 1)
        inside = np.clip(at, free[:, 0], free[:, 1])
        return tuple(inside[np.arange(len(inside)), np.abs(inside - at).argmin(axis=1)].tolist())

    def postures_between(self, behind: Array, ahead: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Frames after feet have landed ahead of one another: of the step after, of the step itself; which there are.

        Shapes (n, 4) in [rad], twice, and (n,), of places in [m], shape (n,) each.
        """
        base = self.step_costs.base
        apart = np.stack([ahead - behind, self.ankles_over(ahead) - self.ankles_over(behind)], -1)
        # Steps that are alike have one posture.
        unique, which = np.unique(np.round(apart / ALIKE).astype(np.int64), axis=0, return_inverse=True)
        relative = np.asarray(unique * ALIKE, dtype=np.float64)
        ends = postures(self.walker.model, base.frames[-1], relative, self.walker.settings.limits)
        ends[~self.reach.has(relative[:, 0], relative[:, 1], ALIKE / 2.0)] = np.nan
        low = self.walker.model.hip_height(ends) - relative[:, 1] < STANDARD.hip_height * self.walker.model.reach
        ends, low = ends[which.ravel()], low[which.ravel()]
        # No step begins with the hip so low: only the last one may end so.
        ends[low & (self.to_standing | (ahead < self.goal - 1e-9))] = np.nan
        if self.walker.model.bones == "lines" and len(self.step_costs.blocks):
            ends = upright(self.walker.model, ends, self.step_costs.room.at(ahead, BESIDE))
        return swap_roles(ends), ends, np.asarray(np.isfinite(ends).all(axis=1))

    def ankles_over(self, x: Array) -> Array:
        """Height of ankles over `x` in the world frame in [m], of feet that stand there."""
        heights, foot = self.terrain.height_at(x), self.walker.model.foot
        if not foot.ankle_height or not self.terrain.whole.slopes:
            return heights + foot.ankle_height
        tilts = np.array([self.terrain.slope_at(place) for place in x.tolist()])
        return np.asarray(heights + foot.ankle_height / np.cos(tilts))

    def costs(
        self, behind: Array, stands: Array, lands: Array, begins: Array, ends: Array, first: NDArray[np.bool_]
    ) -> Array:
        """What steps cost if nothing is in their way, shape (n,).

        Args:
            behind: x of the swing ankle at the start in [m], shape (n,).
            stands: x of the supporting ankle.
            lands: x at which the swing ankle lands.
            begins: frame that each step begins in, shape (n, 4) in [rad].
            ends: frame that it lands in, shape (n, 4) in [rad].
            first: whether it is the walker's first step, which begins as fast as the walker moves now, shape (n,).
        """
        costs = self.step_costs.of(begins, ends)
        costs[first] = self.step_costs.of(begins[first], ends[first], leaves=self.walker.velocity_offset)
        return np.asarray(costs + self._asked(behind, stands, lands))

    def _asked(self, behind: Array, stands: Array, lands: Array) -> Array:
        """What steps cost for what is preferred, kept and banned, shape (n,), of places in [m]."""
        costs = np.zeros(len(stands))
        if self.preference is not None:
            costs = costs + self.preference(behind, stands, lands)
        if self.keep:
            costs = costs + self._moved(stands, lands)
        costs[self._is_banned(behind, stands, lands)] = np.inf
        return costs

    def _is_banned(self, behind: Array, stands: Array, lands: Array) -> NDArray[np.bool_]:
        """Which steps are banned, shape (n,), of places in [m]."""
        found = np.zeros(len(stands), dtype=bool)
        for step in self.banned:
            off = np.abs(np.stack([behind, stands, lands], -1) - step)
            # Where the foot came from does not count in some, see `banned`.
            found |= np.nanmax(off, axis=1) <= self.around
        return found

    def rough_costs(
        self, behind: Array, stands: Array, lands: Array, begins: Array, ends: Array, first: NDArray[np.bool_]
    ) -> Array:
        """What steps cost roughly with what is in their way, shape (n,); arguments as for `costs`."""
        costs = self.costs(behind, stands, lands, begins, ends, first)
        (met,) = np.nonzero(self.met(behind, lands) & np.isfinite(costs))
        if len(met):
            costs[met] += self.in_the_way(behind[met], stands[met], lands[met], begins[met], ends[met])
        return costs

    def costs_nearly(
        self,
        behind: Array,
        stands: Array,
        lands: Array,
        begins: Array,
        ends: Array,
        first: NDArray[np.bool_],
        made: Made | None,
    ) -> Array:
        """What steps cost nearly with what is in their way, shape (n,); arguments as for `costs`."""
        costs = np.full(len(lands), np.inf)
        (some,) = np.nonzero(np.isfinite(begins + ends).all(axis=1))
        begins, ends, behind, stands, lands = (each[some] for each in (begins, ends, behind, stands, lands))
        leaves = np.where(first[some, None], self.walker.velocity_offset, 0.0)
        met = self.met(behind, lands)
        found = self.near_costs.of(begins, ends, stands, leaves, met)
        if self.walker.model.bones == "lines":
            found[met] += self.step_costs.leans(begins[met], ends[met], behind[met], stands[met], lands[met])
        found += self.step_costs.postures(begins, ends)
        if made is not None:
            before, really = made
            known = Known(behind, stands, lands)
            known.add(before.places, really, np.array(before.costs))
            found *= known.times
        costs[some] = found + self._asked(behind, stands, lands)
        return costs

    def _moved(self, stands: Array, lands: Array) -> Array:
        """What it costs to land elsewhere than before, or to leave out or add a step, shape (n,), of places in [m]."""
        before = np.array([self.feet[1], *self.keep])
        before = before[before >= self.feet[1] - 1e-9]
        off = np.abs(lands[:, None] - before).min(axis=1)
        near = np.abs(lands[:, None] - before).argmin(axis=1) - np.abs(stands[:, None] - before).argmin(axis=1)
        return np.asarray(self.kept * (np.minimum(off / GRID, 1.0) ** 2 + np.abs(near - 1)))

    def in_the_way(self, behind: Array, stands: Array, lands: Array, begins: Array, ends: Array) -> Array:
        """What steps cost besides for what is in their way, shape (n,); arguments as for `costs`."""
        costs = self.step_costs.lifts(begins, ends, stands, self.terrain.height_at(stands))
        if self.walker.model.bones == "lines":
            costs = costs + self.step_costs.leans(begins, ends, behind, stands, lands)
        return costs

    def met(self, behind: Array, lands: Array) -> NDArray[np.bool_]:
        """Which swings pass over a box or an edge, shape (n,)."""
        low, high = np.minimum(behind, lands), np.maximum(behind, lands)
        begins, ends = (np.sort(column) for column in self._features.T)
        return np.asarray(np.searchsorted(begins, high) > np.searchsorted(ends, low))

    @cached_property
    def _features(self) -> Array:
        """Both ends of each box and edge in [m], shape (k, 2), as far as a sole reaches."""
        foot = self.walker.model.foot
        spans = [(box.x_start, box.x_end) for box in self.terrain.boxes]
        for before, surface, rise in self.terrain.seams:
            if rise or surface.slope != before.slope:
                spans.append((surface.x_start, surface.x_start))
        return np.array([(a - foot.toe - TURN, b + foot.heel + TURN) for a, b in spans]).reshape(-1, 2)

    def closing(self, behind: Array, begins: Array) -> Array:
        """What it costs to end at the goal beside the other foot, standing, shape (n,).

        Args:
            behind: x of the foot that closes in [m], shape (n,).
            begins: frame that it begins in, shape (n, 4) in [rad].
        """
        frames, goal = self.step_costs.base.frames, np.full(len(behind), self.goal)
        ends = np.tile(STANDING, (len(begins), 1))
        costs = self.step_costs.of(begins, ends, arrives=frames[-2] - frames[-1])
        met = self.met(behind, goal) | (self.terrain.slope_at(self.goal) != 0.0)
        some = np.flatnonzero(met & np.isfinite(costs))
        if len(some):
            costs[some] += self.in_the_way(behind[some], goal[some], goal[some], begins[some], ends[some])
        costs[self._is_banned(behind, goal, goal)] = np.inf
        return costs
