"""All steps between candidate footholds, and the cheapest way through them: how many steps, and where about.

A way costs a sum over triples of footholds, so what is walked over are pairs of them: where one foot stands and where
the other landed. Footholds only go forward, so one pass from behind to ahead finds the cheapest way to each pair.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ggo_factors.support.inputs import Array

Indices = NDArray[np.intp]
AT_ONCE = 3000
"""So many steps are looked at at once for what is in their way, those on the ways that seem cheapest."""


@dataclass(frozen=True, eq=False)
class Network:
    """Pairs of candidate footholds, and the costs of the steps from pair to pair.

    Attributes:
        places: x of each candidate in the world frame, ascending, shape (n,) in [m].
        pairs: numbers of the foot behind and the one ahead of each pair, shape (p, 2), by the foot ahead; the first is
            how the walker stands now.
        before: the pair that each step leaves, shape (t,), by the foot that stands.
        after: the pair that it leads to, shape (t,).
        costs: what each step costs, shape (t,); infinite where there is none.
        closing: what it costs to end in each pair, shape (p,); infinite where the walk cannot end there.
    """

    places: Array
    pairs: Indices
    before: Indices
    after: Indices
    costs: Array
    closing: Array

    @cached_property
    def _blocks(self) -> list[tuple[slice, Indices, Indices]]:
        """The steps over each standing foot, from behind to ahead, and the pairs that they lead to and leave."""
        stands = self.pairs[self.before, 1]
        bounds = np.flatnonzero(np.diff(stands, prepend=-1, append=-1)).tolist()
        blocks = []
        for first, last in pairwise(bounds):
            into = np.flatnonzero(self.after[first:last] != self.after[first])
            count = int(into[0]) if len(into) else last - first
            blocks.append((slice(first, last), self.after[first:last:count], self.before[first : first + count]))
        return blocks

    def at(self, costs: Array) -> Network:
        """The same network with other costs."""
        other = replace(self, costs=costs)
        other.__dict__["_blocks"] = self._blocks
        return other

    def steps(self) -> tuple[Array, Array, Array]:
        """The three places of each step in [m], shape (t,) each."""
        stands, lands = self.places[self.pairs[self.after]].T
        return self.places[self.pairs[self.before, 0]], stands, lands

    def reached(self) -> tuple[Array, Indices]:
        """The least cost of each pair, shape (p,), and the step that reaches it so; infinite and -1 where none does."""
        least = np.full(len(self.pairs), np.inf)
        through = np.full(len(self.pairs), -1, dtype=np.intp)
        least[0] = 0.0
        for steps, onto, leave in self._blocks:
            total = least[leave] + self.costs[steps].reshape(len(onto), len(leave))
            best = total.argmin(axis=1)
            rows = np.arange(len(onto))
            least[onto] = total[rows, best]
            through[onto] = steps.start + rows * len(leave) + best
        through[np.isinf(least)] = -1
        return least, through

    def least_through(self) -> Array:
        """The least cost of any way through each step, shape (t,)."""
        forward, _ = self.reached()
        onward, total = self.closing.copy(), np.empty(len(self.costs))
        for steps, onto, leave in reversed(self._blocks):
            ahead = onward[onto][:, None] + self.costs[steps].reshape(len(onto), len(leave))
            onward[leave] = np.minimum(onward[leave], ahead.min(axis=0))
            total[steps] = (forward[leave] + ahead).ravel()
        return total

    def cheapest(self) -> tuple[list[int], list[int], float]:
        """The cheapest way: numbers of its footholds, the two feet of the start first, of its steps, and its cost.

        Empty and infinite where there is none.
        """
        least, through = self.reached()
        total = least + self.closing
        pair = int(total.argmin())
        if not np.isfinite(total[pair]):
            return [], [], np.inf
        way, steps = [int(self.pairs[pair, 1])], list[int]()
        while through[pair] >= 0:
            steps.append(int(through[pair]))
            way.append(int(self.pairs[pair, 0]))
            pair = int(self.before[steps[-1]])
        way.append(int(self.pairs[pair, 0]))
        return way[::-1], steps[::-1], float(total.min())


@dataclass(eq=False)
class Unseen:
    """A network some of whose steps cost more than is known: what is in their way is looked at where it matters.

    Attributes:
        network: the steps, with what is known of their costs.
        unseen: the steps that may cost more, shape (t,).
        begins: the frame after each pair of feet has come to be, in which the next step begins, shape (p, 4) in [rad].
        ends: the frame in which it comes to be, shape (p, 4) in [rad].
        more: what some steps, of which the three places in [m] and both frames are given, cost more.
    """

    network: Network
    unseen: NDArray[np.bool_]
    begins: Array
    ends: Array
    more: Callable[[Array, Array, Array, Array, Array], Array]

    def steps(self, some: Indices | list[int]) -> tuple[Array, Array, Array, Array, Array]:
        """The three places of some steps in [m], shape (n,) each, and their first and last frames, (n, 4) in [rad]."""
        before, after = self.network.before[some], self.network.after[some]
        stands, lands = self.network.places[self.network.pairs[after]].T
        behind = self.network.places[self.network.pairs[before, 0]]
        return behind, stands, lands, self.begins[before], self.ends[after]

    def looked(self, some: Indices) -> None:
        """Look at some steps."""
        costs = self.network.costs.copy()
        costs[some] += self.more(*self.steps(some))
        self.unseen[some] = False
        self.network = self.network.at(costs)

    def whole(self) -> Network:
        """The network with all steps looked at."""
        (left,) = np.nonzero(self.unseen)
        if len(left):
            self.looked(left)
        return self.network

    def settled(self, times: Array | float = 1.0) -> Network:
        """The network, the costs of each step so many times higher, looked at until no way is cheaper than one seen."""
        while True:
            network = self.network.at(self.network.costs * times)
            if not self.unseen.any():
                return network
            through = network.least_through()
            (left,) = np.nonzero(self.unseen & np.isfinite(through))
            if not len(left) or through[left].min() > through.min() + 1e-12:
                return network
            count = min(AT_ONCE, len(left))
            self.looked(left[np.argpartition(through[left], count - 1)[:count]])


def pairs_between(places: Array, longest: float, shortest: float) -> Indices:
    """All pairs of places, the first two of which are the walker's feet, that a step may put feet on, shape (p, 2).

    The first is the walker's own; the others go forward by `shortest` to `longest` in [m], from the supporting foot on.
    """
    apart = places[None, :] - places[:, None]
    behind, ahead = np.nonzero((apart >= shortest - 1e-9) & (apart <= longest + 1e-9))
    good = (behind >= 1) & (ahead >= 2)
    pairs = np.stack([behind[good], ahead[good]], -1)
    pairs = pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]
    return np.concatenate([[[0, 1]], pairs])


def triples_of(pairs: Indices, places: int) -> tuple[Indices, Indices]:
    """Pairs (before, after) that share the foot that stands: a step each, ordered by that foot, then by `after`."""
    ahead = np.searchsorted(pairs[:, 1], np.arange(places + 1))
    before, after = [], []
    by_behind = np.argsort(pairs[:, 0], kind="stable")
    starts = np.searchsorted(pairs[by_behind, 0], np.arange(places + 1))
    for stands in range(1, places):
        into = np.arange(ahead[stands], ahead[stands + 1])
        out = np.sort(by_behind[starts[stands] : starts[stands + 1]])
        if len(into) and len(out):
            after.append(np.repeat(out, len(into)))
            before.append(np.tile(into, len(out)))
    if not before:
        none = np.zeros(0, dtype=np.intp)
        return none, none
    return np.concatenate(before), np.concatenate(after)
