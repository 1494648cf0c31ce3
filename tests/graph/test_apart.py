"""A graph taken apart: edges one by one, edges removed for good, its picture, and gaits from edited values."""

import re
from dataclasses import replace

import gtsam
import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.factors import STYLE_KEY, frame_key, precision

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.15, 0.25, 0.10)
# Knees bent throughout, so that no knee edge counts.
BENT = replace(BASE, frames=BASE.frames + np.radians([10.0, 20.0, 10.0, 20.0]))
OFFSET = np.array([0.02, 0.03, -0.02, 0.04])


def boxed(**how):
    graph = ggo.GaitGraph(BASE, **how)
    graph.anchor(BASE.frames[0])
    graph.end((0.39, 0.0), gain=250.0)
    graph.add_obstacle(BOX)
    return graph


def bent(**how):
    """Held at both ends, the last frame by a pose that is off the base gait by `OFFSET`."""
    graph = ggo.GaitGraph(BENT, **how)
    graph.anchor(BENT.frames[0])
    graph.end(pose=BENT.frames[-1] + OFFSET, gain=1e3)
    return graph


def own_knee(frame=25, gain=50.0):
    block = np.array([[0.0, 0.0, 0.0, 1.0]])
    return ggo.checked_factor("my knee", [frame], 1, lambda g, want: (g[[3]] - 1.0, (block,)), precision(1, gain))


def of_family(graph, family):
    return [edge for edge in graph.edges if edge.family == family]


@pytest.mark.parametrize("how", [{}, {"smoothness": 25.0}, {"keyframes": "all"}, {"hard": True, "smoothness": 25.0}])
def test_the_edges_are_the_graph_one_by_one(how):
    graph = boxed(**how)
    graph.add_factor(own_knee())
    first = graph.edges
    solution = graph.solve()
    edges, factors = graph.edges, solution.factor_graph
    assert len(edges) == factors.size() > len(first) - 1
    for k, edge in enumerate(edges):
        assert list(edge.factor.keys()) == list(factors.at(k).keys()) == list(map(frame_key, edge.frames))
        np.testing.assert_allclose(edge.error, edge.factor.unwhitenedError(solution.values), atol=1e-12)
        if edge.gain < np.inf:
            halves = 0.5 * edge.gain * float(edge.error @ edge.error)
            assert edge.factor.error(solution.values) == pytest.approx(halves, abs=1e-12)
    (mine,) = of_family(graph, "user")
    assert (mine.name, mine.frames, mine.gain) == ("my knee", (25,), pytest.approx(50.0))
    assert [edge.name for edge in of_family(graph, "end")] == ["end"]
    assert {edge.gain for edge in of_family(graph, "anchor")} == {np.inf}
    assert re.fullmatch(r"GraphEdge\(user, 'my knee' on frames \[25\], gain 50, \|error\| 0\.\d+\)", repr(mine))
    assert [e.frames for e in solution.edges] == [e.frames for e in edges]


@pytest.mark.parametrize(
    ("noise", "gain"),
    [
        (gtsam.noiseModel.Isotropic.Sigma(4, 0.1), 100.0),
        (gtsam.noiseModel.Unit.Create(4), 1.0),
        (gtsam.noiseModel.Constrained.All(4), np.inf),
        (gtsam.noiseModel.Diagonal.Sigmas(np.array([1.0, 2.0, 1.0, 1.0])), np.nan),
        (gtsam.noiseModel.Gaussian.Covariance(np.eye(4) + 0.5), np.nan),
        (gtsam.noiseModel.Constrained.MixedSigmas(np.ones(4), np.array([0.0, 1.0, 1.0, 1.0])), np.nan),
        (
            gtsam.noiseModel.Robust.Create(
                gtsam.noiseModel.mEstimator.Huber.Create(1.0), gtsam.noiseModel.Isotropic.Sigma(4, 0.1)
            ),
            100.0,
        ),
    ],
)
def test_gains_of_users_noise_models(noise, gain):
    graph = boxed()
    graph.add_factor(gtsam.PriorFactorVector(frame_key(25), BASE.frames[25], noise))
    (mine,) = of_family(graph, "user")
    assert mine.gain == pytest.approx(gain, nan_ok=True)
    assert mine.name == "PriorFactorVector"


def test_an_end_edge_a_factor_and_an_anchor_removed_are_as_never_added():
    graph, plain = boxed(), boxed()
    graph.end((0.45, 0.0), gain=10.0)
    graph.add_factor(own_knee(20))
    graph.add_factor(own_knee(33))
    for edge in (of_family(graph, "end")[1], *of_family(graph, "user")):
        graph.remove(edge)
    found, wanted = graph.solve(), plain.solve()
    np.testing.assert_allclose(found.gait.frames, wanted.gait.frames, atol=1e-7)
    assert found.keyframes == wanted.keyframes
    assert "user" not in found.costs
    graph.remove(of_family(graph, "anchor")[0])
    with pytest.raises(ggo.GraphError, match="frame 0 is not anchored"):
        graph.solve()


@pytest.mark.parametrize("keyframes", ["all", [20, 21], [20, 21, 33]])
def test_without_its_residual_edge_a_frame_does_not_follow(keyframes):
    """The offset jumps there and is constant elsewhere."""
    graph = bent(keyframes=keyframes)
    (gone,) = (edge for edge in of_family(graph, "residual") if edge.frames == (20, 21))
    graph.remove(gone)
    solution = graph.solve()
    offsets = solution.gait.frames - BENT.frames
    np.testing.assert_allclose(offsets[:21], 0.0, atol=1e-6)
    np.testing.assert_allclose(offsets[21:], np.tile(OFFSET, (30, 1)), atol=1e-6)
    assert sum(solution.costs.values()) == pytest.approx(solution.factor_graph.error(solution.values), abs=1e-9)
    assert sum(solution.costs.values()) < 1e-6


@pytest.mark.parametrize("smoothness", [0.0, 25.0])
def test_a_removed_span_stays_away_though_keyframes_come_into_it(smoothness):
    """Its inner frames are held by nothing but what comes to them; the frames beside it are, as before."""
    graph = bent(keyframes=[8, 9, 40, 41], smoothness=smoothness)
    (gone,) = (e for e in of_family(graph, "residual") if e.frames == ((8, 9, 40, 41) if smoothness else (9, 40)))
    graph.remove(gone)
    wanted = {25: BENT.frames[25] + 0.1, 26: BENT.frames[26] - 0.1}
    for n, frame in wanted.items():
        graph.add_factor(gtsam.PriorFactorVector(frame_key(n), frame, precision(4, 3.0)))
    solution = graph.solve()
    assert {25, 26} <= set(solution.keyframes)
    assert not [e for e in of_family(graph, "residual") if set(e.frames) & {25, 26}]
    assert {e.frames for e in of_family(graph, "residual")} >= {(8, 9), (40, 41)}
    for n, frame in wanted.items():
        np.testing.assert_allclose(solution.gait.frames[n], frame, atol=1e-6)
    offsets = solution.gait.frames - BENT.frames
    np.testing.assert_allclose(offsets[:10], 0.0, atol=1e-5)
    np.testing.assert_allclose(offsets[40:], np.tile(OFFSET, (11, 1)), atol=1e-5)
    costs = solution.factor_graph.error(solution.values)
    assert sum(solution.costs.values()) == pytest.approx(costs, rel=1e-6, abs=1e-9)


def test_a_frame_that_nothing_holds_any_more_is_named():
    graph = boxed(keyframes=[20, 21])
    (gone,) = (edge for edge in of_family(graph, "residual") if edge.frames == (20, 21))
    graph.remove(gone)
    with pytest.raises(ggo.GraphError, match=r"the graph is singular at frame \d+: an edge is missing"):
        graph.solve()


def test_edges_that_rounds_add_stay_out_too():
    graph = boxed()
    graph.solve()
    gone = [edge for edge in graph.edges if edge.family in ("obstacle", "knee")][::2]
    for edge in gone:
        graph.remove(edge)
    left = {(edge.name, edge.frames) for edge in graph.edges}
    assert not left & {(edge.name, edge.frames) for edge in gone}
    assert graph.factor_graph().size() == len(graph.edges)
    graph.solve()
    again = {(edge.name, edge.frames) for edge in graph.edges}
    assert not again & {(edge.name, edge.frames) for edge in gone}
    assert len(again) > len(gone)


def test_of_edges_alike_only_one_is_removed():
    graph = boxed()
    graph.end((0.45, 0.0), gain=250.0)
    first, second = of_family(graph, "end")
    graph.remove(first)
    assert [edge.error.tolist() for edge in of_family(graph, "end")] == [second.error.tolist()]
    graph.remove(second)
    assert not of_family(graph, "end")


def test_edges_that_are_not_there_are_refused():
    graph, other = boxed(), boxed(keyframes="all")
    edge = of_family(graph, "end")[0]
    graph.remove(edge)
    with pytest.raises(ggo.InputError, match=r"edge: GraphEdge\(end, .* is not in this graph"):
        graph.remove(edge)
    with pytest.raises(ggo.InputError, match="is not in this graph"):
        graph.remove(of_family(other, "residual")[3])
    other.add_factor(own_knee())
    with pytest.raises(ggo.InputError, match="is not in this graph"):
        graph.remove(of_family(other, "user")[0])
    with pytest.raises(ggo.InputError, match="edge: expected a GraphEdge"):
        graph.remove(3)


@pytest.mark.parametrize("box", [(), (BOX,)])
def test_a_graph_with_style(box):
    style = ggo.Style(
        directions=np.sin(np.linspace(0.0, np.pi, 51))[:, None, None] * np.array([0.02, 0.05, 0.02, 0.05])[:, None],
        variance=3e-6,
        steps=40,
        people=1,
        explained=0.9,
        likelihood=(5.0, 4.0),
        error_deg=(0.7, 0.8),
    )
    graph = ggo.GaitGraph(BASE, smoothness=25.0, style=style)
    graph.anchor(BASE.frames[0])
    graph.end((0.39, 0.0), gain=250.0)
    for obstacle in box:
        graph.add_obstacle(obstacle)
    solution = graph.solve()
    names = [edge.name for edge in of_family(graph, "style")]
    assert names == (["style anchor", "style prior"] if box else ["style prior"])
    assert len(graph.edges) == solution.factor_graph.size()
    for edge in graph.edges:
        np.testing.assert_allclose(edge.error, edge.factor.unwhitenedError(solution.values), atol=1e-12)
    np.testing.assert_allclose(graph.gait_from(solution.values).frames, solution.gait.frames, atol=1e-12)
    other = gtsam.Values(solution.values)
    other.update(STYLE_KEY, solution.values.atVector(STYLE_KEY) + 0.02)
    assert np.abs(graph.gait_from(other).frames - solution.gait.frames).max() > 1e-3
    assert 'c0 [label="c0\\nstyle"]' in graph.dot()
    with pytest.raises(ggo.InputError, match="belongs to the style"):
        graph.remove(of_family(graph, "style")[0])
    residual = of_family(graph, "residual")[-1]
    graph.remove(residual)
    assert residual.frames not in [edge.frames for edge in of_family(graph, "residual")]


def test_a_picture_names_edges_and_frames():
    graph = boxed(keyframes=[25])
    graph.add_factor(
        ggo.checked_factor('a "quoted" one', [25, 30], 4, lambda g, h, w: (h - g, MOTION), precision(4, 2.0))
    )
    text = graph.dot()
    assert '  g25 [label="g25\\nframe 25"];' in text
    assert 'label="user: a \\"quoted\\" one\\ngain 2"' in text
    assert re.search(r'\[shape=box, label="anchor\\ngain inf"\]', text)
    boxes = re.findall(r"^  (e\d+) \[shape=box", text, re.MULTILINE)
    assert len(boxes) == len(graph.edges)
    circles = set(re.findall(r"^  (g\d+) \[label", text, re.MULTILINE))
    assert circles == {f"g{n}" for n in graph.solve(max_iterations=1).keyframes} & circles
    lines = set(re.findall(r"^  (e\d+) -- (\w+);", text, re.MULTILINE))
    assert lines == {(f"e{k}", f"g{n}") for k, edge in enumerate(boxed_edges(graph, text)) for n in edge}
    assert text.startswith("graph gait_graph {\n")
    assert text.count("{") == text.count("}") == 1


MOTION = (-np.eye(4), np.eye(4))


def boxed_edges(graph, text):
    fresh = ggo.GaitGraph(BASE, keyframes=[25])
    fresh.anchor(BASE.frames[0])
    fresh.end((0.39, 0.0), gain=250.0)
    fresh.add_obstacle(BOX)
    fresh.add_factor(graph.edges[-1].factor)
    assert fresh.dot() == text
    return [edge.frames for edge in fresh.edges]


def edited(values, frame, change):
    new = gtsam.Values(values)
    new.update(frame_key(frame), values.atVector(frame_key(frame)) + change)
    return new


def test_a_gait_from_edited_values():
    graph = boxed(keyframes=[25], smoothness=25.0)
    solution = graph.solve()
    np.testing.assert_allclose(graph.gait_from(solution.values).frames, solution.gait.frames, atol=1e-12)
    assert graph.gait_from(solution.values).model == solution.gait.model
    for frame in (0, 25):  # an anchored one too
        gait = graph.gait_from(edited(solution.values, frame, OFFSET))
        np.testing.assert_allclose(gait.frames[frame], solution.gait.frames[frame] + OFFSET, atol=1e-12)
        np.testing.assert_allclose(solution.gait_from(edited(solution.values, frame, OFFSET)).frames, gait.frames)


@pytest.mark.parametrize("frames", [51, 201])
def test_a_step_from_edited_values(frames):
    base = BASE.resampled(frames)
    solution = ggo.step_over(base, [BOX])
    np.testing.assert_allclose(solution.gait_from(solution.values).frames, solution.gait.frames, atol=1e-12)
    n = solution.graph.keyframes[len(solution.keyframes) // 2]
    place = solution.keyframes[len(solution.keyframes) // 2]
    gait = solution.gait_from(edited(solution.values, n, OFFSET))
    np.testing.assert_allclose(gait.frames[place], solution.gait.frames[place] + OFFSET, atol=1e-9)
    assert f'g{n} [label="g{n}\\nframe {place}"]' in solution.dot()
    again = ggo.replan(solution, frames // 5, obstacles=[ggo.Obstacle(0.17, 0.25, 0.11)])
    np.testing.assert_allclose(again.gait_from(again.values).frames, again.gait.frames, atol=1e-12)
    assert len(solution.edges) == solution.factor_graph.size()


def broken(key, value):
    values = boxed().initial_values()
    if values.exists(key):
        values.erase(key)
    if value is not None:
        values.insert(key, value)
    return values


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (broken(frame_key(0), None), "values: no g0, which is a variable of this graph"),
        (broken(frame_key(0), np.zeros(3)), r"values: g0: expected shape \(4,\), got \(3,\)"),
        (broken(frame_key(0), np.full(4, np.nan)), "values: g0: value nan"),
        (broken(frame_key(0), np.full(4, 90.0)), "values: g0: angle 90 rad .* looks like degrees"),
        (broken(frame_key(0), gtsam.Pose2()), "values: g0 is no vector"),
        (broken(frame_key(7), np.zeros(4)), "values: g7 is no variable of this graph"),
        ({}, "values: expected a Values"),
    ],
)
def test_bad_values_are_refused(values, message):
    with pytest.raises(ggo.InputError, match=message):
        boxed().gait_from(values)
