"""The cheapest way through all steps between candidates, against every way there is."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ggo_factors.planning.network import Network, Unseen, pairs_between, triples_of


def networks():
    return st.tuples(st.integers(0, 10**6), st.integers(1, 6), st.floats(0.1, 1.2), st.floats(0.0, 0.8)).map(made)


def made(what):
    """A network of a few candidates with random costs, a share of them infinite."""
    seed, ahead, longest, none = what
    random = np.random.default_rng(seed)
    places = np.sort(random.uniform(0.05, 1.5, ahead))
    places = np.concatenate([[-random.uniform(0.0, 0.4), 0.0], places])
    pairs = pairs_between(places, longest, 0.05)
    keep = random.uniform(size=len(pairs)) > 0.1
    keep[0] = True
    pairs = pairs[keep]
    before, after = triples_of(pairs, len(places))
    costs = 10.0 ** random.uniform(-4.0, 1.0, len(before))
    costs[random.uniform(size=len(costs)) < none] = np.inf
    closing = np.where(random.uniform(size=len(pairs)) < 0.5, random.uniform(size=len(pairs)), np.inf)
    return Network(places, pairs, before, after, costs, closing)


def every_way(network):
    """All ways from how the walker stands, as the numbers of their steps, and what they cost without closing."""
    leaving = {}
    for step, pair in enumerate(network.before.tolist()):
        leaving.setdefault(pair, []).append(step)
    ways = [((), 0, 0.0)]
    for steps, pair, cost in ways:
        for step in leaving.get(pair, []):
            ways.append(((*steps, step), int(network.after[step]), cost + float(network.costs[step])))
    return ways


@given(networks())
def test_the_cheapest_way_is_the_cheapest_of_all(network):
    ways = every_way(network)
    least = min(cost + float(network.closing[pair]) for _, pair, cost in ways)
    way, found, cost = network.cheapest()
    assert cost == pytest.approx(least)
    assert bool(way) == math.isfinite(least)
    if way:
        assert way[:2] == [0, 1]
        of_pairs = {pair: n for n, pair in enumerate(map(tuple, network.pairs.tolist()))}
        numbers = [of_pairs[pair] for pair in pairwise(way)]
        of_steps = {step: n for n, step in enumerate(zip(network.before.tolist(), network.after.tolist(), strict=True))}
        steps = [of_steps[step] for step in pairwise(numbers)]
        assert found == steps
        assert network.costs[steps].sum() + network.closing[numbers[-1]] == pytest.approx(least)


@given(networks())
def test_what_is_reached_and_what_leads_through_each_step(network):
    ways = every_way(network)
    least, through = network.reached()
    onward = network.least_through()
    for pair in range(len(network.pairs)):
        costs = [cost for _, last, cost in ways if last == pair]
        assert least[pair] == pytest.approx(min(costs, default=np.inf))
        assert (through[pair] >= 0) == (pair > 0 and np.isfinite(least[pair]))
    for step in range(len(network.costs)):
        costs = [cost + float(network.closing[pair]) for steps, pair, cost in ways if step in steps]
        assert onward[step] == pytest.approx(min(costs, default=np.inf))


@given(st.lists(st.integers(1, 60), unique=True, max_size=8), st.integers(2, 20))
def test_pairs_and_steps_are_all_that_lie_within_reach(ahead, longest):
    places = np.array([-0.4, 0.0, *sorted(n / 20.0 for n in ahead)])
    pairs = pairs_between(places, longest / 20.0, 0.05)
    wanted = {(0, 1)} | {
        (a, b)
        for a in range(1, len(places))
        for b in range(2, len(places))
        if 0.05 - 1e-9 <= places[b] - places[a] <= longest / 20.0 + 1e-9
    }
    assert sorted(map(tuple, pairs.tolist())) == sorted(wanted)
    before, after = triples_of(pairs, len(places))
    steps = {(int(a), int(b)) for a, b in zip(before, after, strict=True)}
    assert len(steps) == len(before)
    assert steps == {(a, b) for a in range(len(pairs)) for b in range(len(pairs)) if pairs[a, 1] == pairs[b, 0]}


@given(networks(), st.integers(0, 2**32 - 1))
def test_no_way_is_cheaper_than_one_that_was_looked_at(network, seed):
    rng = np.random.default_rng(seed)
    count = len(network.costs)
    more, times = rng.uniform(0.0, 2.0, count), rng.uniform(0.5, 2.0, count)
    met = rng.random(count) < 0.7
    frames = np.zeros((len(network.pairs), 4))
    numbers = {key: n for n, key in enumerate(zip(*map(tuple, network.steps()), strict=True))}

    def looked(*steps):
        return np.array([more[numbers[key]] for key in zip(*map(tuple, steps[:3]), strict=True)])

    unseen = Unseen(network, met.copy(), frames, frames, looked)
    _, _, cost = unseen.settled(times).cheapest()
    whole = network.at((network.costs + np.where(met, more, 0.0)) * times)
    assert cost == pytest.approx(whole.cheapest()[2])
    assert np.array_equal(unseen.whole().costs, network.costs + np.where(met, more, 0.0))
