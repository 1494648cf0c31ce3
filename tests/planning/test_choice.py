"""Footholds as discrete variables of a factor graph, against all choices there are."""

import itertools
import math

import gtsam
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ggo_factors.planning.choice import LEAST_WEIGHT, chosen, cost_of, foothold_graph, key


def tables_of(seed, steps, options, decades, none, offset=0.0):
    """Random costs of so many steps over some decades, a share of them infinite, but for one choice."""
    random = np.random.default_rng(seed)
    counts = [int(n) for n in random.integers(1, options + 1, steps)]
    known = [int(random.integers(0, n)) for n in counts]
    tables = []
    for n in range(steps):
        shape = tuple(counts[max(0, n - 2) : n + 1])
        table = offset + 10.0 ** random.uniform(-decades, 0.0, shape)
        missing = random.uniform(size=shape) < none
        missing[tuple(known[max(0, n - 2) : n + 1])] = False
        tables.append(np.where(missing, np.inf, table))
    return tables, counts, known


def least_of(tables, counts):
    return min(cost_of(tables, choice) for choice in itertools.product(*map(range, counts)))


@given(st.integers(0, 10**6), st.integers(1, 5), st.integers(1, 4), st.floats(0.0, 6.0), st.floats(0.0, 0.7))
def test_what_is_chosen_is_the_cheapest_of_all(seed, steps, options, decades, none):
    tables, counts, known = tables_of(seed, steps, options, decades, none)
    choice = chosen(tables, counts, known)
    least, most = least_of(tables, counts), cost_of(tables, known)
    spare = most - sum(float(table.min()) for table in tables)
    # The graph tells weights apart that differ by more than 1e-9, of LEAST_WEIGHT or more.
    assert least <= cost_of(tables, choice) <= least + 2e-3 * spare + 1e-9


@pytest.mark.parametrize(("scale", "offset"), [(1e-9, 0.0), (1e9, 0.0), (1.0, 1e6), (1e-6, 1.0)])
def test_neither_scale_nor_offset_of_costs_matters(scale, offset):
    tables, counts, known = tables_of(3, 6, 4, 1.0, 0.2)
    others = [scale * table + offset for table in tables]
    assert chosen(others, counts, known) == chosen(tables, counts, known) != known


def test_costs_that_differ_by_many_decades_leave_the_small_ones_right():
    dear, cheap = np.array([1e6, 1e-3, 2e-3]), np.array([[5.0, np.inf], [1e-4, 1e-5], [1e-5, 1e8]])
    assert chosen([dear, cheap], [3, 2], [0, 0]) == [1, 1]


def test_what_all_ways_cost_does_not_hide_what_they_differ_by():
    """As of a closing step beside a box, which costs 520 rad^2 whatever the one before does; GTSAM raised an error."""
    first, last = np.array([6.3134e-5, 3.218e-5, 1.6887e-5]), np.array([[np.inf], [520.5907117781173], [520.592758]])
    assert chosen([first, last], [3, 1], [1, 0]) == [1, 0]


def test_many_steps_do_not_run_out_of_weight():
    tables, counts, known = tables_of(5, 120, 3, 0.5, 0.3)
    choice = chosen(tables, counts, known)
    assert cost_of(tables, choice) < 0.9 * cost_of(tables, known)


def test_where_the_known_choice_is_none_nothing_is_chosen():
    assert chosen([np.array([np.inf, 1.0])], [2], [0]) == [0]


def test_the_product_of_the_factors_is_the_weight_of_a_choice():
    tables, counts, known = tables_of(11, 4, 3, 2.0, 0.3)
    most = cost_of(tables, known)
    graph = foothold_graph(tables, counts, most)
    sums = sum(float(table.min()) for table in tables)
    rate = -math.log(LEAST_WEIGHT) / (most - sums)
    seen = 0
    for choice in itertools.product(*map(range, counts)):
        values = gtsam.DiscreteValues()
        for step, option in enumerate(choice):
            values[key(step)] = option
        cost = cost_of(tables, choice)
        if cost <= most:
            seen += 1
            # Each factor holds its weights to 1e-9.
            assert graph(values) == pytest.approx(math.exp(-rate * (cost - sums)), rel=1e-2, abs=1e-8)
        else:
            assert graph(values) <= LEAST_WEIGHT * (1.0 + 1e-2)
    assert seen > 3
