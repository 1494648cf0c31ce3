"""The cheapest footholds on a terrain by what steps cost, before any of them is made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ggo_factors.planning.choice import chosen
from ggo_factors.planning.footholds import GRID, candidates, may_stand
from ggo_factors.planning.known import Known
from ggo_factors.planning.network import Network, Unseen, pairs_between, triples_of
from ggo_factors.planning.reach import SHORTEST
from ggo_factors.planning.scene import Footholds, Made, Scene
from ggo_factors.support.inputs import Array

SLIDES = (GRID / 2.0, GRID / 4.0)
"""Footholds slide to one side or the other by so much in [m], or stay, one time after the other."""
WAYS = 3
"""So many ways through the network are looked at nearly, at most."""


@dataclass(frozen=True, eq=False)
class Search(Scene):
    """A search for footholds: the attributes are the scene's."""

    _known: dict[int, Unseen] = field(default_factory=dict, init=False)

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
                behind, begin = np.array(self.feet[:1]), self.walker.frame[None]
                closing = self.closing(behind, begin).tolist() if self.to_standing else ()
                return Footholds(self.feet, tuple(closing), tuple(steps.network.places[2:].tolist()))
            near = self.costs_nearly(*steps.steps(numbers), np.array(numbers) == numbers[0], made)
            cost = float(near.sum() + steps.network.closing[steps.network.after[numbers[-1]]])
            if not best or cost < least:
                best, least = way, cost
            known.add(steps.network.places[way], near, steps.network.costs[numbers])
        return self._slid(steps.network.places, best, made) if best else None

    def over(self, footholds: Sequence[float]) -> Footholds:
        """These footholds, x in [m], with what their steps cost nearly; infinite where there is no such step."""
        places, costs = self._chosen([np.array([place]) for place in footholds], footholds, None)
        return Footholds(tuple(places), costs, tuple(self._steps().network.places[2:].tolist()))

    def _roughly(self, feet: Sequence[float]) -> Array:
        """What the steps between places in [m] cost roughly, shape (n,) in [rad^2]."""
        places = np.array(feet)
        begins, ends, _ = self.postures_between(places[:-1], places[1:])
        begins[0] = self.walker.frame
        first = np.arange(len(places) - 2) < 1
        return self.rough_costs(places[:-2], places[1:-1], places[2:], begins[:-1], ends[1:], first)

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
        pairs = pairs_between(places, self.reach.most, self.reach.shortest)
        far = places[pairs[:, 1]] - places[pairs[:, 0]]
        within = self.reach.has(far, self.ankles_over(places)[pairs] @ [-1.0, 1.0], 1e-9)
        pairs = pairs[within | (np.arange(len(pairs)) == 0)]
        begins, ends, good = self.postures_between(places[pairs[:, 0]], places[pairs[:, 1]])
        begins[0], good[0] = self.walker.frame, True
        keep = np.flatnonzero(good)
        pairs, begins, ends = pairs[keep], begins[keep], ends[keep]
        before, after = triples_of(pairs, len(places))
        behind, stands, lands = places[pairs[before, 0]], places[pairs[before, 1]], places[pairs[after, 1]]
        costs = self.costs(behind, stands, lands, begins[before], ends[after], before == 0)
        closing, (at_goal,) = np.full(len(pairs), np.inf), np.nonzero(pairs[:, 1] == len(places) - 1)
        closing[at_goal] = self.closing(places[pairs[at_goal, 0]], begins[at_goal]) if self.to_standing else 0.0
        network = Network(places, pairs, before, after, costs, closing)
        return Unseen(network, self.met(behind, lands) & np.isfinite(costs), begins, ends, self.in_the_way)

    def _kept(self) -> tuple[float, ...]:
        within = [place for place in self.keep if self.feet[1] + SHORTEST < place < self.goal]
        return tuple(np.unique(self.free_near(within)).tolist())

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
        starts, lands, _ = self.postures_between(np.concatenate(begins), np.concatenate(ends))
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
        every = self.costs_nearly(behind, stands, lands, begin, end, first, made)
        costs = np.split(every, np.cumsum([len(step[0]) for step in steps])[:-1])
        closing = self.closing(behind_goal, starts_of[-1]) if self.to_standing else np.zeros(sizes[-2] * sizes[-1])
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
