"""The cheapest footholds on a terrain by what steps cost, before any of them is made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.leg_collision import BESIDE
from ggo_factors.check.report import STANDARD
from ggo_factors.motion.gait import swap_roles
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.choice import chosen
from ggo_factors.planning.footholds import GRID, blocked, candidates, free_stretches, may_stand
from ggo_factors.planning.known import Known
from ggo_factors.planning.near_cost import NearCosts
from ggo_factors.planning.network import Network, Unseen, pairs_between, triples_of
from ggo_factors.planning.people import LEADING_MEAN, PeoplePreference
from ggo_factors.planning.postures import postures, upright
from ggo_factors.planning.reach import SHORTEST, SINKS, Reach, reach_on
from ggo_factors.planning.step_cost import MARGIN, Roof, StepCosts, blocks_on, roof_of
from ggo_factors.procedures.walker import Walker
from ggo_factors.support.inputs import Array
from ggo_factors.walking.step import STANDING

SLIDES = (GRID / 2.0, GRID / 4.0)
"""Footholds slide to one side or the other by so much in [m], or stay, one time after the other."""
WAYS = 3
"""So many ways through the network are looked at nearly, at most."""
KEPT = 0.04
"""What it costs in [rad^2] to land further than `GRID` from all footholds of the plan before, or to leave one out.

Two steps over a low box cost as much. Noise of 1 cm in the ground changes what a plan costs by less; with a quarter of
this 16 and 22 of 25 plans on two courses keep their footholds, with this all do."""
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
class Search:
    """A search for footholds.

    Attributes:
        terrain: the ground.
        walker: the walker at the start.
        feet: x of its swing ankle and its supporting ankle in the world frame in [m].
        goal: where it is to arrive, in [m].
        to_standing: whether it then stands, the feet beside each other.
        preference: what is preferred beside little change, or None.
        keep: footholds of a plan before in [m], which are kept where little speaks against it.
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
    banned: list[tuple[float, float, float]] = field(default_factory=list)
    around: float = GRID / 2.0
    grid: float = GRID
    sinks: float = SINKS
    _known: dict[int, Unseen] = field(default_factory=dict, init=False)

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
        """How long steps may be."""
        limits = self.walker.settings.limits
        return reach_on(self.terrain, self.walker.model, self.step_costs.base, limits, self.sinks)

    def best(self, made: Made | None = None) -> Footholds | None:
        """The cheapest footholds; None where there is no way.

        Args:
            made: footholds that were found before, and what their steps cost.
        """
        steps = self._steps()
        known = Known(*steps.network.steps())
        if made is not None:
            footholds, costs = made
            known.add(footholds.places, costs, self._roughly(footholds.places))
        best, least, seen = list[int](), math.inf, list[list[int]]()
        for _ in range(WAYS):
            way, numbers, _ = steps.settled(known.times).cheapest()
            if not way or way in seen:
                break
            # What seemed cheap may not be, and another way be cheaper.
            seen.append(way)
            if not numbers:
                closing = (
                    self._closing(np.array(self.feet[:1]), self.walker.frame[None]).tolist() if self.to_standing else ()
                )
                return Footholds(self.feet, tuple(closing), tuple(steps.network.places[2:].tolist()))
            near = self._near_costs(*steps.steps(numbers), np.array(numbers) == numbers[0], made)
            cost = float(near.sum() + steps.network.closing[steps.network.after[numbers[-1]]])
            if not best or cost < least:
                best, least = way, cost
            known.add(steps.network.places[way], near, steps.network.costs[numbers])
        return self._slid(steps.network.places, best, made) if best else None

    def _roughly(self, feet: Sequence[float]) -> Array:
        """What the steps between places in [m] cost roughly, shape (n,) in [rad^2]."""
        places = np.array(feet)
        begins, ends, _ = self._postures(places[:-1], places[1:])
        begins[0] = self.walker.frame
        first = np.arange(len(places) - 2) < 1
        return self._rough_costs(places[:-2], places[1:-1], places[2:], begins[:-1], ends[1:], first)

    def _slid(self, places: Array, way: Sequence[int], made: Made | None) -> Footholds:
        """The cheapest footholds around a way over candidates; the last foothold is the goal."""
        feet: list[float] = places[way].tolist()
        costs: tuple[float, ...] = ()
        for apart in SLIDES:
            around = np.array([-apart, 0.0, apart])
            options = [self._allowed(place + around, place) for place in feet[2:-1]]
            feet, costs = self._chosen([*options, np.array(feet[-1:])], feet[2:], made)
        return Footholds(tuple(feet), costs, tuple(places[2:].tolist()))

    def network(self) -> Network:
        """All candidates and what all steps between them cost, roughly."""
        return self._steps().whole()

    def _steps(self) -> Unseen:
        """All candidates and the steps between them, but for those that are banned."""
        found = self._known.get(len(self.banned))
        if found is None:
            found = self._known[len(self.banned)] = self._opened()
        return found

    def _opened(self) -> Unseen:
        stands = self.feet[1]
        ahead = candidates(self.stretches, stands + SHORTEST, self.goal, (*self._kept(), self.goal), self.grid)
        ahead = ahead[ahead > stands + SHORTEST / 2.0]
        places = np.concatenate([self.feet, ahead])
        pairs = pairs_between(places, self.reach.most, SHORTEST)
        far = places[pairs[:, 1]] - places[pairs[:, 0]]
        pairs = pairs[far <= self.reach.over(self._ankles(places)[pairs] @ [-1.0, 1.0]) + 1e-9]
        begins, ends, good = self._postures(places[pairs[:, 0]], places[pairs[:, 1]])
        begins[0], good[0] = self.walker.frame, True
        keep = np.flatnonzero(good)
        pairs, begins, ends = pairs[keep], begins[keep], ends[keep]
        before, after = triples_of(pairs, len(places))
        behind, stands, lands = places[pairs[before, 0]], places[pairs[before, 1]], places[pairs[after, 1]]
        costs = self._costs(behind, stands, lands, begins[before], ends[after], before == 0)
        closing, (at_goal,) = np.full(len(pairs), np.inf), np.nonzero(pairs[:, 1] == len(places) - 1)
        closing[at_goal] = self._closing(places[pairs[at_goal, 0]], begins[at_goal]) if self.to_standing else 0.0
        network = Network(places, pairs, before, after, costs, closing)
        return Unseen(network, self._met(behind, lands) & np.isfinite(costs), begins, ends, self._in_the_way)

    def _kept(self) -> tuple[float, ...]:
        places = np.array(self.keep)
        within = (places > self.feet[1] + SHORTEST) & (places < self.goal)
        # A place that is blocked now gives way to the nearest free one.
        free = np.array(free_stretches(self.stretches, self.feet[1] + SHORTEST, self.goal)).reshape(-1, 2)
        if not within.any() or not len(free):
            return ()
        inside = np.clip(places[within][:, None], free[:, 0], free[:, 1])
        nearest = np.abs(inside - places[within][:, None]).argmin(axis=1)
        return tuple(np.unique(inside[np.arange(len(inside)), nearest]).tolist())

    def _allowed(self, places: Array, otherwise: float) -> Array:
        good = may_stand(places, self.stretches) & (places > self.feet[1] + SHORTEST / 2.0) & (places < self.goal)
        return np.unique(np.append(places[good], otherwise))

    def _chosen(
        self, options: Sequence[Array], known: Sequence[float], made: Made | None
    ) -> tuple[list[float], tuple[float, ...]]:
        """The cheapest of the footholds that each step may take, by the factor graph, given some that are `known`.

        Returns:
            X of both feet at the start and of each foothold in [m]; what each step costs nearly, in [rad^2].
        """
        columns = [np.array([self.feet[0]]), np.array([self.feet[1]]), *options]
        sizes = [len(column) for column in columns]
        begins, ends = [], []
        for first, second in pairwise(columns):
            begins.append(np.repeat(first, len(second)))
            ends.append(np.tile(second, len(first)))
        behind_goal, cuts = begins[-1], np.cumsum([len(each) for each in begins])[:-1]
        starts, lands, _ = self._postures(np.concatenate(begins), np.concatenate(ends))
        starts[0] = self.walker.frame
        starts_of, lands_of = np.split(starts, cuts), np.split(lands, cuts)
        steps, frames = [], []
        for n in range(2, len(columns)):
            a, b, c = np.meshgrid(*(np.arange(size) for size in sizes[n - 2 : n + 1]), indexing="ij")
            steps.append([columns[n - 2][a].ravel(), columns[n - 1][b].ravel(), columns[n][c].ravel()])
            into, out = (a * sizes[n - 1] + b).ravel(), (b * sizes[n] + c).ravel()
            frames.append([starts_of[n - 2][into], lands_of[n - 1][out]])
        behind, stands, lands = (np.concatenate(column) for column in zip(*steps, strict=True))
        begin, end = (np.concatenate(column) for column in zip(*frames, strict=True))
        first = np.arange(len(lands)) < len(steps[0][0])
        every = self._near_costs(behind, stands, lands, begin, end, first, made)
        costs = np.split(every, np.cumsum([len(step[0]) for step in steps])[:-1])
        closing = self._closing(behind_goal, starts_of[-1]) if self.to_standing else np.zeros(sizes[-2] * sizes[-1])
        costs[-1] = costs[-1] + np.tile(closing, len(costs[-1]) // len(closing))
        shapes = [tuple(sizes[max(2, n - 2) : n + 1]) for n in range(2, len(columns))]
        tables = [np.asarray(cost.reshape(shape)) for cost, shape in zip(costs, shapes, strict=True)]
        counts = sizes[2:]
        near = [int(np.abs(option - place).argmin()) for option, place in zip(options, known, strict=True)]
        choice = chosen(tables, counts, near)
        each = [float(table[tuple(choice[max(0, n - 2) : n + 1])]) for n, table in enumerate(tables)]
        if self.to_standing:
            # The factor graph has the closing step in the last one: the way there is all that it depends on.
            before = choice[-2] if len(choice) > 1 else 0
            last = float(closing.reshape(sizes[-2:])[before, choice[-1]])
            each[-1:] = [each[-1] - last, last]
        found = [float(column[n]) for column, n in zip(options, choice, strict=True)]
        return [*self.feet, *found], tuple(each)

    def _postures(self, behind: Array, ahead: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Frames after feet have landed ahead of one another: of the step after, of the step itself; which there are.

        Shapes (n, 4) in [rad], twice, and (n,), of places in [m], shape (n,) each.
        """
        base = self.step_costs.base
        apart = np.stack([ahead - behind, self._ankles(ahead) - self._ankles(behind)], -1)
        # Steps that are alike have one posture.
        unique, which = np.unique(np.round(apart / ALIKE).astype(np.int64), axis=0, return_inverse=True)
        relative = np.asarray(unique * ALIKE, dtype=np.float64)
        ends = postures(self.walker.model, base.frames[-1], relative, self.walker.settings.limits)
        far = relative[:, 0] > self.reach.over(relative[:, 1]) + ALIKE / 2.0
        ends[far | (relative[:, 0] < SHORTEST / 2.0)] = np.nan
        low = self.walker.model.hip_height(ends) - relative[:, 1] < STANDARD.hip_height * self.walker.model.reach
        ends, low = ends[which.ravel()], low[which.ravel()]
        # No step begins with the hip so low: only the last one may end so.
        ends[low & (self.to_standing | (ahead < self.goal - 1e-9))] = np.nan
        if self.walker.model.bones == "lines" and len(self.step_costs.blocks):
            ends = upright(self.walker.model, ends, self.step_costs.room.at(ahead, BESIDE))
        return swap_roles(ends), ends, np.asarray(np.isfinite(ends).all(axis=1))

    def _ankles(self, x: Array) -> Array:
        """Height of ankles over `x` in the world frame in [m], of feet that stand there."""
        heights, foot = self.terrain.height_at(x), self.walker.model.foot
        if not foot.ankle_height or not self.terrain.whole.slopes:
            return heights + foot.ankle_height
        tilts = np.array([self.terrain.slope_at(place) for place in x.tolist()])
        return np.asarray(heights + foot.ankle_height / np.cos(tilts))

    def _costs(
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

    def _rough_costs(
        self, behind: Array, stands: Array, lands: Array, begins: Array, ends: Array, first: NDArray[np.bool_]
    ) -> Array:
        """What steps cost roughly with what is in their way, shape (n,); arguments as for `_costs`."""
        costs = self._costs(behind, stands, lands, begins, ends, first)
        (met,) = np.nonzero(self._met(behind, lands) & np.isfinite(costs))
        if len(met):
            costs[met] += self._in_the_way(behind[met], stands[met], lands[met], begins[met], ends[met])
        return costs

    def _near_costs(
        self,
        behind: Array,
        stands: Array,
        lands: Array,
        begins: Array,
        ends: Array,
        first: NDArray[np.bool_],
        made: Made | None,
    ) -> Array:
        """What steps cost nearly with what is in their way, shape (n,); arguments as for `_costs`."""
        costs = np.full(len(lands), np.inf)
        (some,) = np.nonzero(np.isfinite(begins + ends).all(axis=1))
        begins, ends, behind, stands, lands = (each[some] for each in (begins, ends, behind, stands, lands))
        leaves = np.where(first[some, None], self.walker.velocity_offset, 0.0)
        met = self._met(behind, lands)
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
        return np.asarray(KEPT * (np.minimum(off / GRID, 1.0) ** 2 + np.abs(near - 1)))

    def _in_the_way(self, behind: Array, stands: Array, lands: Array, begins: Array, ends: Array) -> Array:
        """What steps cost besides for what is in their way, shape (n,); arguments as for `_costs`."""
        costs = self.step_costs.lifts(begins, ends, stands, self.terrain.height_at(stands))
        if self.walker.model.bones == "lines":
            costs = costs + self.step_costs.leans(begins, ends, behind, stands, lands)
        return costs

    def _met(self, behind: Array, lands: Array) -> NDArray[np.bool_]:
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

    def _closing(self, behind: Array, begins: Array) -> Array:
        """What it costs to end at the goal beside the other foot, standing, shape (n,).

        Args:
            behind: x of the foot that closes in [m], shape (n,).
            begins: frame that it begins in, shape (n, 4) in [rad].
        """
        frames, ends, goal = (
            self.step_costs.base.frames,
            np.tile(STANDING, (len(begins), 1)),
            np.full(len(behind), self.goal),
        )
        costs = self.step_costs.of(begins, ends, arrives=frames[-2] - frames[-1])
        met = self._met(behind, goal) | (self.terrain.slope_at(self.goal) != 0.0)
        some = np.flatnonzero(met & np.isfinite(costs))
        if len(some):
            costs[some] += self._in_the_way(behind[some], goal[some], goal[some], begins[some], ends[some])
        costs[self._is_banned(behind, goal, goal)] = np.inf
        return costs
