"""All steps between candidate footholds, and the cheapest way through them: how many steps, and where about.

A way costs a sum over triples of footholds, so what is walked over are pairs of them: where one foot stands and where
the other landed. Footholds only go forward, so one pass from behind to ahead finds the cheapest way to each pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ggo_factors.support.inputs import Array

Indices = NDArray[np.intp]


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

    def cheapest(self) -> tuple[list[int], float]:
        """Numbers of the footholds of the cheapest way, the two feet of the start first, and its cost.

        Empty and infinite where there is none.
        """
        least, through = self.reached()
        total = least + self.closing
        pair = int(total.argmin())
        if not np.isfinite(total[pair]):
            return [], np.inf
        way = [int(self.pairs[pair, 1])]
        while through[pair] >= 0:
            step = int(through[pair])
            way.append(int(self.pairs[pair, 0]))
            pair = int(self.before[step])
        way.append(int(self.pairs[pair, 0]))
        return way[::-1], float(total.min())


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
