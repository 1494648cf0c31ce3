"""Style in the graph: spans against the full graph, SciPy on the same cost, Jacobians, and where it is held."""

from __future__ import annotations

import math
from dataclasses import replace

import gtsam
import numpy as np
import pytest
from scipy.optimize import least_squares

import ggo_factors as ggo
from ggo_factors.factors import STYLE_KEY
from ggo_factors.graph.requests import style_request

PAPER = ggo.paper_base_gait()
# Knees bent throughout, so that no knee edge counts.
BENT = replace(PAPER, frames=PAPER.frames + np.radians([10.0, 20.0, 10.0, 20.0]))
FOOTHOLD = (0.42, 0.03)
BOX = ggo.Obstacle(0.20, 0.25, 0.08)


def made_up(size=3, scale=0.03, variance=3e-6, **others):
    """A style of smooth directions, which falls off from number to number."""
    rng, phase = np.random.default_rng(size), np.linspace(0.0, 1.0, 51)
    waves = [np.sin(np.pi * (n + 1) * phase[:, None] + rng.uniform(0.0, 6.0, 4)) / (n + 1) for n in range(size)]
    told = {"steps": 40, "people": 1, "explained": 0.9, "likelihood": (5.0, 4.0), "error_deg": (0.7, 0.8)} | others
    return ggo.Style(directions=scale * np.stack(waves, -1), variance=variance, **told)


TELLING = {"lands": True, "start_variance": 4e-4}
"""A style that landing edges and the first frame tell of too."""


def graph_of(style, smoothness, keyframes="auto", base=BENT):
    graph = ggo.GaitGraph(base, smoothness=smoothness, keyframes=keyframes, style=style)
    graph.anchor(base.frames[0] + np.radians([1.0, 2.0, -2.0, 1.0]))
    graph.end(foothold=FOOTHOLD, gain=1000.0)
    graph.land(FOOTHOLD)
    return graph


@pytest.mark.parametrize("smoothness", [0.0, 3.7, 100.0])
@pytest.mark.parametrize("keyframes", ["auto", [20], [7, 8, 33]])
@pytest.mark.parametrize("told", [{}, TELLING], ids=["chain", "ends"])
def test_spans_are_the_full_graph(smoothness, keyframes, told):
    few, full = (graph_of(made_up(**told), smoothness, each).solve() for each in (keyframes, "all"))
    assert few.converged
    assert len(few.keyframes) < 12 < len(full.keyframes)
    np.testing.assert_allclose(few.gait.frames, full.gait.frames, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(few.style, full.style, rtol=0.0, atol=1e-6)
    for family, cost in full.costs.items():
        assert few.costs[family] == pytest.approx(cost, abs=1e-9), family
    assert np.abs(full.style).max() > 0.05  # it does something


@pytest.mark.parametrize("smoothness", [0.0, 100.0])
@pytest.mark.parametrize("told", [{}, TELLING], ids=["chain", "ends"])
def test_scipy_finds_the_same_minimum_of_the_same_cost(smoothness, told):
    style = made_up(**told)
    solution = graph_of(style, smoothness).solve()
    base, model, last = BENT.frames, BENT.legs(), 50
    posture = ggo.GaitGraph(BENT)
    posture.land(FOOTHOLD)
    target = posture._problem.landing.posture
    prior, start = math.sqrt(style.variance), math.sqrt(style.variance / style.start_variance)
    jacobian = model.endpoint_jacobian(target)
    # Of how the last frame varies only what leaves the swing ankle where it is.
    aside = style.directions[last] - np.linalg.lstsq(jacobian, jacobian @ style.directions[last], rcond=None)[0]

    def errors(values):
        frames = np.concatenate([solution.gait.frames[:1], values[:200].reshape(50, 4)])
        c = values[200:]
        residual = frames - base - style.directions @ c
        landing = style.lands * (style.directions[last] - style.directions[last - 1]) @ c
        return np.concatenate(
            [
                np.diff(residual, axis=0).ravel(),
                math.sqrt(smoothness) * np.diff(residual, 2, axis=0).ravel(),
                prior * c,
                math.sqrt(1000.0) * (model.endpoint(frames[last]) - FOOTHOLD),
                frames[last] - target - style.lands * aside @ c,
                math.sqrt(25.0) * (frames[last] - frames[last - 1] - base[last] + base[last - 1] - landing),
                start * residual[0],
            ]
        )

    found = least_squares(errors, np.concatenate([base[1:].ravel(), np.zeros(3)]), xtol=1e-15, ftol=1e-15, gtol=1e-12)
    np.testing.assert_allclose(solution.gait.frames[1:].ravel(), found.x[:200], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(solution.style, found.x[200:], rtol=0.0, atol=1e-3)
    assert sum(solution.costs.values()) == pytest.approx(found.cost, rel=1e-9)


@pytest.mark.parametrize("lifted", [False, True])
@pytest.mark.parametrize("told", [{}, TELLING], ids=["chain", "ends"])
def test_jacobians_and_the_plain_graph(lifted, told):
    graph = graph_of(made_up(**told), 100.0)
    graph.begin_with(np.radians([0.1, -0.2, 0.1, 0.3]))
    if lifted:
        graph.add_obstacle(BOX)
    solution = graph.solve()
    assert solution.converged
    plain, values = solution.factor_graph, solution.values
    rng = np.random.default_rng(0)
    for key in values.keys():
        values.update(key, values.atVector(key) + rng.uniform(-0.01, 0.01, len(values.atVector(key))))
    on_style = 0
    for k in range(plain.size()):
        assert ggo.check_jacobian(plain.at(k), values) < 1e-6
        on_style += STYLE_KEY in plain.at(k).keys()
    assert on_style > len(solution.keyframes) / 2
    # The optimum of one factor for each edge is that of the few factors that were solved.
    again = gtsam.DoglegOptimizer(plain, solution.graph.values()).optimize()
    for key in again.keys():
        np.testing.assert_allclose(again.atVector(key), solution.graph.values().atVector(key), rtol=0.0, atol=1e-5)
    assert solution.graph.state.style_held == lifted


@pytest.mark.parametrize("frames", [26, 51, 201])
def test_a_step_varies_alike_at_any_rate(frames):
    base = BENT.resampled(frames)
    smoothness = (0.2 * (frames - 1)) ** 2
    found = graph_of(made_up(), smoothness, base=base).solve()
    usual = graph_of(made_up(), 100.0).solve()
    np.testing.assert_allclose(found.style, usual.style, rtol=0.1, atol=0.03)


def test_where_it_would_go_beyond_a_persons_steps_the_prior_is_stiffer():
    style = made_up(variance=1e-9)
    graph = ggo.GaitGraph(BENT, smoothness=100.0, style=style)
    graph.anchor(BENT.frames[0])
    graph.end(pose=BENT.frames[-1] + np.radians([25.0, -10.0, -25.0, 20.0]), gain=1000.0)
    solution = graph.solve()
    assert solution.converged
    assert solution.graph.state.style_gain > 1.0
    assert np.linalg.norm(solution.style) <= 1.1 * (math.sqrt(3.0) + 1.65)


def test_a_start_that_is_not_the_persons_tells_nothing_of_the_style():
    told = made_up(lands=True, start_variance=1e-4)
    for degrees, near in ((1.0, True), (40.0, False)):
        graphs = [
            ggo.GaitGraph(BENT, smoothness=100.0, style=each) for each in (told, replace(told, start_variance=math.inf))
        ]
        for graph in graphs:
            graph.anchor(BENT.frames[0] + np.radians(degrees) * np.array([1.0, -1.0, -1.0, 1.0]))
            graph.end(foothold=FOOTHOLD, gain=1000.0)
        counted, left_out = (graph.solve().style for graph in graphs)
        assert (np.abs(counted - left_out).max() > 1e-3) == near, degrees


def test_without_a_style_there_is_no_variable_for_it():
    solution = graph_of(None, 100.0).solve()
    assert solution.style is None
    assert STYLE_KEY not in solution.values.keys()
    assert "style" not in solution.costs
    zero = graph_of(made_up(scale=1e-12), 100.0).solve()
    np.testing.assert_allclose(zero.gait.frames, solution.gait.frames, rtol=0.0, atol=1e-9)


def test_the_directions_of_what_is_left_are_those_of_the_whole():
    whole = style_request(made_up(), 51)
    rest = style_request(made_up(), 31, 50, 0.4)
    np.testing.assert_allclose(rest.directions, whole.directions[20:], rtol=0.0, atol=1e-9)
    assert rest.unit == whole.unit
    # Frames that are walked already are no first frame of a step.
    starts = [style_request(made_up(**TELLING), *asked).start_gain for asked in ((51,), (31, 50, 0.4))]
    assert starts == [pytest.approx(3e-6 / 4e-4), 0.0]


def test_the_spread_counts_the_style_too():
    steps = [graph_of(style, 100.0).solve() for style in (None, made_up(scale=0.1, variance=1e-6))]
    without, varied = (ggo.joint_spread(step) for step in steps)
    assert not varied[0].any()
    assert (varied[5:-5].mean(axis=0) > without[5:-5].mean(axis=0)).all()
    for keyframes in ([20], "all"):
        full = graph_of(made_up(scale=0.1, variance=1e-6), 100.0, keyframes).solve()
        np.testing.assert_allclose(ggo.joint_spread(full), varied, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("style", [None, made_up()], ids=["plain", "style"])
def test_the_base_gait_itself_takes_one_iteration(style):
    """Its error is rounding, about 1e-30, of which no solver can save a share."""
    graph = ggo.GaitGraph(BENT, style=style, smoothness=100.0)
    graph.anchor(BENT.frames[0])
    graph.end(foothold=BENT.endpoints(BENT.legs())[-1])
    solution = graph.solve()
    assert solution.converged
    assert solution.iterations == 1
    np.testing.assert_allclose(solution.gait.frames, BENT.frames, rtol=0.0, atol=1e-12)
