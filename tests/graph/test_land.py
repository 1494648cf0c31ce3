"""Landing edges of a gait graph: the objective written out for SciPy, spans against the full graph, refusals."""

import math

import gtsam
import numpy as np
import pytest
from independent import path_of
from scipy.optimize import least_squares

import ggo_factors as ggo
from ggo_factors.graph.touchdown import touchdown_posture

FOOTHOLD = (0.45, 0.0)
END_GAIN, KNEE_GAIN = 50.0, 5.0
BOX = ggo.Obstacle(0.20, 0.25, 0.08)


def landing_graph(base, *, keyframes="auto", smoothness=0.0, start=None, shank=None, box=None, **gains):
    """A graph that lands on the foothold."""
    graph = ggo.GaitGraph(base, keyframes=keyframes, smoothness=smoothness, knee_gain=KNEE_GAIN)
    graph.anchor(base.frames[0] if start is None else start)
    graph.end(FOOTHOLD, shank, gain=END_GAIN)
    graph.land(FOOTHOLD, shank, **gains)
    if box is not None:
        graph.add_obstacle(box)
    return graph


def errors(frames, base, smoothness, posture, gains, shank):
    """Errors of every edge of the full graph, each times the root of its gain."""
    offset = np.diff(frames - base.frames, axis=0)
    rows = [
        offset,
        math.sqrt(smoothness) * np.diff(offset, axis=0),
        math.sqrt(KNEE_GAIN) * np.maximum(0.0, -frames[:, [1, 3]]),
        math.sqrt(END_GAIN) * (path_of(frames[-1:])[0] - FOOTHOLD),
        math.sqrt(gains[0]) * (frames[-1] - posture),
        math.sqrt(gains[1]) * offset[-1],
    ]
    if shank is not None:
        rows.append(math.sqrt(END_GAIN) * (math.pi / 2.0 + frames[-1:, 2] - frames[-1:, 3] - shank))
    return np.concatenate([row.ravel() for row in rows])


@pytest.mark.parametrize("smoothness", [0.0, 8.0])
@pytest.mark.parametrize(
    ("given", "gains", "shank"),
    [
        ({}, (50.0 / 14.0, 0.5 * 14.0), None),
        ({}, (50.0 / 14.0, 0.5 * 14.0), math.pi / 2.0),
        ({"posture_gain": 0.3}, (0.3, 0.5 * 14.0), None),
        ({"motion_gain": 90.0}, (50.0 / 14.0, 90.0), None),
    ],
)
def test_scipy_finds_the_same(given, gains, shank, smoothness):
    base = ggo.paper_base_gait(15)
    start = base.frames[0] + np.radians([-4.0, 6.0, 8.0, 12.0])
    posture = touchdown_posture(base.legs(), base.frames[-1], FOOTHOLD, shank)
    solution = landing_graph(base, smoothness=smoothness, start=start, shank=shank, **given).solve()
    assert solution.converged

    def of_free(free):
        return errors(np.vstack([start, free.reshape(-1, 4)]), base, smoothness, posture, gains, shank)

    found = least_squares(of_free, base.frames[1:].ravel(), xtol=1e-14, ftol=1e-14, gtol=1e-12)
    mine = of_free(solution.gait.frames[1:].ravel())
    assert mine @ mine == pytest.approx(2.0 * found.cost, rel=1e-6)
    assert solution.error_history[-1] == pytest.approx(found.cost, rel=1e-6)
    np.testing.assert_allclose(solution.gait.frames[1:].ravel(), found.x, atol=1e-5)


@pytest.mark.parametrize("box", [None, BOX])
@pytest.mark.parametrize("smoothness", [0.0, 100.0])
def test_spans_cost_what_the_full_graph_costs(smoothness, box):
    base = ggo.paper_base_gait()
    start = base.frames[0] + np.radians([-4.0, 6.0, 8.0, 12.0])
    posture = touchdown_posture(base.legs(), base.frames[-1], FOOTHOLD)
    solutions, costs = [], []
    for keyframes in ("auto", "all"):
        graph = landing_graph(base, keyframes=keyframes, smoothness=smoothness, start=start, box=box)
        solutions.append(graph.solve())
        error = errors(solutions[-1].gait.frames, base, smoothness, posture, (1.0, 25.0), None)
        costs.append(0.5 * error @ error)
    few, full = solutions
    assert len(few.keyframes) < 25 < len(full.keyframes) == 51
    assert few.error_history[-1] == pytest.approx(full.error_history[-1], rel=1e-6)
    if box is None:
        assert costs == pytest.approx([full.error_history[-1]] * 2, rel=1e-6)
    np.testing.assert_allclose(few.gait.frames, full.gait.frames, atol=1e-4)


def test_it_draws_the_last_frame_to_the_posture_and_the_last_motion_to_the_base_gaits():
    base = ggo.paper_base_gait()
    posture = touchdown_posture(base.legs(), base.frames[-1], FOOTHOLD)
    start = base.frames[0] + np.radians([-4.0, 6.0, 8.0, 12.0])
    off, moved = [], []
    for gain in (1e-6, 1.0, 1e6):
        frames = landing_graph(base, start=start, posture_gain=gain, motion_gain=1e-6).solve().gait.frames
        off.append(np.abs(frames[-1] - posture).max())
        frames = landing_graph(base, start=start, posture_gain=1.0, motion_gain=gain).solve().gait.frames
        moved.append(np.abs(np.diff(frames - base.frames, axis=0)[-1]).max())
    assert off[0] > 2.0 * off[1] > 1e3 * off[2]
    assert moved[0] > 1.5 * moved[1] > 1e3 * moved[2]
    assert off[2] < 1e-6


def test_hard_graphs_land_softly():
    base = ggo.paper_base_gait()
    graph = ggo.GaitGraph(base, hard=True)
    graph.anchor(base.frames[0] + np.radians([-4.0, 6.0, 8.0, 12.0]))
    graph.end(FOOTHOLD, hard=True)
    graph.land(FOOTHOLD)
    solution = graph.solve()
    assert solution.converged
    last = solution.gait.frames[-1]
    np.testing.assert_allclose(path_of([last])[0], FOOTHOLD, atol=2e-6)
    posture = touchdown_posture(base.legs(), base.frames[-1], FOOTHOLD)
    assert 1e-3 < np.abs(last - posture).max() < 0.2


def test_the_factors_stand_in_the_graph():
    base = ggo.paper_base_gait()
    graph = ggo.GaitGraph(base)
    graph.anchor(base.frames[0])
    graph.end(FOOTHOLD, gain=END_GAIN)
    graph.solve()
    before = graph.factor_graph().size()
    graph.land(FOOTHOLD)  # what was solved is no more its graph
    values = graph.initial_values()
    assert values.exists(gtsam.symbol("g", 49))
    assert graph.factor_graph().size() == before + 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"foothold": (5.0, 0.0)}, r"foothold: no leg has a touchdown posture on \(5, 0\) m"),
        ({"foothold": (1.3, 0.0), "shank_angle": math.pi / 2.0}, "foothold: no leg has a touchdown posture"),
        ({"foothold": (0.4,)}, r"foothold: expected shape \(2,\)"),
        ({"foothold": (0.4, math.nan)}, "foothold"),
        ({"shank_angle": 90.0}, "shank_angle"),
        ({"posture_gain": 0.0}, "posture_gain: 0 must be above 0"),
        ({"posture_gain": math.inf}, "posture_gain"),
        ({"motion_gain": -1.0}, "motion_gain: -1 must be above 0"),
        ({"motion_gain": "stiff"}, "motion_gain"),
    ],
)
def test_what_cannot_be_is_refused(arguments, message):
    graph = ggo.GaitGraph(ggo.paper_base_gait())
    with pytest.raises(ggo.InputError, match=message):
        graph.land(**{"foothold": FOOTHOLD, **arguments})
    graph.land(FOOTHOLD)  # a refused call leaves the graph as it was


def test_a_second_call_is_refused():
    graph = landing_graph(ggo.paper_base_gait())
    with pytest.raises(ggo.InputError, match="land: the graph has landing edges already"):
        graph.land(FOOTHOLD)


def test_gains_are_given_by_name():
    with pytest.raises(TypeError):
        ggo.GaitGraph(ggo.paper_base_gait()).land(FOOTHOLD, None, 1.0)
