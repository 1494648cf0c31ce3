"""GaitGraph: known optima, an independent solver, spans, users' own factors, and every way to fail."""

import re

import gtsam
import numpy as np
import pytest
from scipy.linalg import lstsq
from scipy.optimize import least_squares

import ggo_factors as ggo
from ggo_factors.factors import checked_factor, frame_key, precision

BASE = ggo.paper_base_gait(frames=50)
MODEL = ggo.LegModel(0.39, 0.39, bones="points")  # the paper's: its obstacle 5 stands in a leg
OBSTACLES = {
    1: (0.20, 0.25, 0.08),
    2: (0.20, 0.25, 0.15),
    3: (0.12, 0.16, 0.08),
    4: (0.12, 0.16, 0.15),
    5: (-0.33, -0.29, 0.175),
}
# Half the sum of squares on which three independent solvers agreed (the paper's settings, m = 50).
OPTIMA = {0: 1.022765e-4, 1: 0.00332829, 2: 0.00896366, 3: 0.00352882, 4: 0.00966653, 5: 0.000795162}


def paper_graph(case, keyframes="auto"):
    """The paper's graph to the letter: case 0 the stride 0.975, else the obstacle of that number."""
    graph = ggo.GaitGraph(BASE, MODEL, keyframes=keyframes)
    graph.anchor(BASE.frames[0])
    if case == 0:
        graph.end(foothold=(0.4875, 0.0), gain=5.0)
        return graph
    box = ggo.Obstacle(*OBSTACLES[case])
    x = BASE.endpoints(MODEL)[:, 0]
    graph.add_obstacle(box, frames=np.flatnonzero((x >= box.x_start) & (x <= box.x_end)), hold=0.0)
    graph.end(foothold=(0.39, 0.0), gain=5.0 * 50)
    return graph


@pytest.mark.parametrize("case", OPTIMA)
def test_known_optimum_with_all_and_with_few_keyframes(case):
    full, few = (paper_graph(case, keyframes).solve() for keyframes in ("all", "auto"))
    for solution in (full, few):
        assert solution.converged, solution.reason
        assert sum(solution.costs.values()) == pytest.approx(OPTIMA[case], rel=1e-5)
        assert solution.iterations > 1
        assert solution.error_history[-1] == pytest.approx(OPTIMA[case], rel=1e-5)
    assert len(full.keyframes) == 50
    assert len(few.keyframes) <= 12
    np.testing.assert_allclose(few.gait.frames, full.gait.frames, atol=1e-4)


@pytest.mark.parametrize("case", [0, 1, 5])
def test_levenberg_marquardt_finds_the_same(case):
    dogleg, lm = (paper_graph(case).solve(optimizer=name) for name in ("dogleg", "lm"))
    np.testing.assert_allclose(lm.gait.frames, dogleg.gait.frames, atol=1e-4)


def test_scipy_finds_the_same_for_the_graph_with_hold():
    box = ggo.Obstacle(0.12, 0.16, 0.15)
    graph = ggo.GaitGraph(BASE, MODEL, keyframes="all")
    graph.anchor(BASE.frames[0])
    held, hold, reference = [25, 26, 27], 0.3, BASE.endpoints(MODEL)[:, 0]
    graph.add_obstacle(box, frames=held, hold=hold)
    graph.end(foothold=(0.40, 0.01), shank_angle=1.7, gain=40.0)
    solution = graph.solve()

    def objective(flat):
        frames = np.vstack([BASE.frames[0], flat.reshape(-1, 4)])
        a1, b1, a2, b2 = frames.T
        x = 0.39 * (np.sin(a2) - np.sin(a1) + np.sin(a2 - b2) - np.sin(a1 - b1))
        y = 0.39 * (np.cos(a1) - np.cos(a2) + np.cos(a1 - b1) - np.cos(a2 - b2))
        low = np.maximum(box.height + 0.02 - y[held], 0.0)
        return np.concatenate(
            [
                np.diff(frames - BASE.frames, axis=0).ravel(),
                np.sqrt(5.0) * np.maximum(-frames[1:, [1, 3]], 0.0).ravel(),
                np.expm1(4.0 * low),
                hold * (x[held] - reference[held]),
                np.sqrt(40.0) * np.array([x[-1] - 0.40, y[-1] - 0.01, np.pi / 2 + a2[-1] - b2[-1] - 1.7]),
            ]
        )

    # Near by, or dense differences of 196 variables take all their time on the way.
    start = solution.gait.frames[1:].ravel() + np.random.default_rng(3).normal(0.0, 0.01, 196)
    found = least_squares(objective, start, xtol=1e-14, ftol=1e-14, gtol=1e-12)
    assert sum(solution.costs.values()) == pytest.approx(found.cost, rel=1e-6)
    np.testing.assert_allclose(solution.gait.frames[1:].ravel(), found.x, atol=1e-4)
    assert solution.costs["hold"] > 0
    assert solution.costs["anchor"] == pytest.approx(0.0, abs=1e-12)


def test_a_list_of_keyframes_changes_nothing_but_the_variables():
    auto, more = paper_graph(1).solve(), paper_graph(1, keyframes=[10, 20, -5]).solve()
    assert {10, 20, 45} <= set(more.keyframes)
    np.testing.assert_allclose(more.gait.frames, auto.gait.frames, atol=1e-4)


def test_a_frame_whose_knee_edge_becomes_active_becomes_a_keyframe():
    # The stride leaves the support knee of some inner frame just negative: it must join, at the full graph's answer.
    solution = paper_graph(0).solve()
    assert solution.rounds > 1
    assert len(solution.keyframes) > 2
    frames = solution.gait.frames
    free = [n for n in range(1, 50) if n not in solution.keyframes]
    assert (frames[free][:, [1, 3]] >= 0.0).all()


def test_frames_over_an_obstacle_are_chosen_and_clear_it():
    graph = ggo.GaitGraph(BASE, MODEL)
    graph.anchor(BASE.frames[0])
    graph.add_obstacle(ggo.Obstacle(*OBSTACLES[2]))
    graph.end(foothold=(0.39, 0.0), gain=250.0)
    solution = graph.solve()
    assert solution.ok, solution.violations
    assert solution.report.clearance > 0.0
    assert solution.require_ok() is solution


def test_the_papers_own_edges_hit_three_of_its_five_obstacles():
    # Frames O on the obstacle's span, no hold: lifted frames swing out of the span and others cross it too low.
    hits = [case for case in OBSTACLES if not paper_graph(case).solve().report.ok]
    assert hits == [1, 2, 4]


def test_plain_gtsam_objects_come_out():
    graph = paper_graph(1)
    before = graph.factor_graph().size()
    values = gtsam.DoglegOptimizer(graph.factor_graph(), graph.initial_values()).optimize()
    assert values.size() == len(graph.solve().keyframes) - 1  # one knee joins in the second round
    assert graph.factor_graph().size() > before
    # After solving, the last round's result is the start: nothing is left to gain.
    assert graph.factor_graph().error(graph.initial_values()) == pytest.approx(OPTIMA[1], rel=1e-5)
    solution = graph.solve()
    assert solution.factor_graph.error(solution.values) == pytest.approx(sum(solution.costs.values()))
    gtsam.Marginals(solution.factor_graph, solution.values).marginalCovariance(frame_key(49))


def test_a_factor_of_ones_own_makes_its_frame_a_keyframe():
    graph = paper_graph(0)
    wanted = BASE.frames[25] + np.array([0.0, 0.0, 0.1, 0.0])
    graph.add_factor(gtsam.PriorFactorVector(gtsam.symbol("g", 25), wanted, precision(4, 1e4)))
    solution = graph.solve()
    assert 25 in solution.keyframes
    np.testing.assert_allclose(solution.gait.frames[25], wanted, atol=1e-3)
    assert solution.costs["user"] > 0
    assert sum(solution.costs.values()) == pytest.approx(solution.error_history[-1])


def test_a_custom_factor_of_ones_own():
    def level_hip(frame, want_jacobian):
        # Keeps both thighs at the same angle.
        return frame[[0]] - frame[[2]], (np.array([[1.0, 0.0, -1.0, 0.0]]),)

    graph = paper_graph(0)
    graph.add_factor(checked_factor("level hip", (30,), 1, level_hip, precision(1, 1e5)))
    frames = graph.solve().gait.frames
    assert frames[30, 0] == pytest.approx(frames[30, 2], abs=1e-4)


@pytest.mark.parametrize("key", [gtsam.symbol("x", 1), gtsam.symbol("g", 50)])
def test_a_factor_off_the_gait_is_refused(key):
    with pytest.raises(ggo.InputError, match="factor"):
        paper_graph(0).add_factor(gtsam.PriorFactorVector(key, np.zeros(4), precision(4, 1.0)))


def test_hard_end_edge_is_met():
    graph = ggo.GaitGraph(BASE, MODEL)
    graph.anchor(BASE.frames[0])
    graph.end(foothold=(0.45, 0.05), shank_angle=np.pi / 2, hard=True)
    solution = graph.solve()
    assert solution.converged, solution.reason
    np.testing.assert_allclose(solution.gait.endpoints()[-1], [0.45, 0.05], atol=1e-6)


def test_two_hard_end_edges_on_different_frames_are_met():
    graph = ggo.GaitGraph(BASE, MODEL)
    graph.anchor(BASE.frames[0])
    graph.end(pose=BASE.frames[20] + 0.1, hard=True, frame=20)
    graph.end(foothold=(0.45, 0.05), hard=True)
    solution = graph.solve()
    assert solution.converged, solution.reason
    np.testing.assert_allclose(solution.gait.frames[20], BASE.frames[20] + 0.1, atol=1e-6)
    np.testing.assert_allclose(solution.gait.endpoints()[-1], [0.45, 0.05], atol=1e-6)


def test_a_constrained_factor_of_ones_own_is_kept():
    graph = paper_graph(0)
    wanted = BASE.frames[25] + 0.05
    graph.add_factor(gtsam.PriorFactorVector(frame_key(25), wanted, gtsam.noiseModel.Constrained.All(4)))
    solution = graph.solve()
    assert solution.converged, solution.reason
    np.testing.assert_allclose(solution.gait.frames[25], wanted, atol=1e-6)


@pytest.mark.parametrize("case", [2, 4])
def test_few_keyframes_find_the_full_graphs_frames_to_the_last_digits(case):
    few, full = (paper_graph(case, keyframes).solve() for keyframes in ("auto", "all"))
    np.testing.assert_allclose(few.gait.frames, full.gait.frames, atol=1e-8)
    assert few.iterations < 25


# -- failures -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("optimizer", ["dogleg", "lm"])
@pytest.mark.parametrize("keyframes", ["auto", "all"])
def test_not_anchored_is_named(optimizer, keyframes):
    graph = ggo.GaitGraph(BASE, MODEL, keyframes=keyframes)
    graph.end(foothold=(0.39, 0.0))
    with pytest.raises(ggo.GraphError, match=r"^frame 0 is not anchored$"):
        graph.solve(optimizer=optimizer)


def test_two_end_edges_anchor_as_well():
    graph = ggo.GaitGraph(BASE, MODEL)
    graph.end(foothold=(-0.39, 0.0), gain=100.0, frame=0)
    graph.end(foothold=(0.39, 0.0), gain=100.0)
    path = graph.solve().gait.endpoints()
    np.testing.assert_allclose(path[[0, -1]], [[-0.39, 0.0], [0.39, 0.0]], atol=1e-4)


def test_not_converged_is_named():
    solution = paper_graph(2, keyframes="all").solve(max_iterations=3)
    assert not solution.converged
    assert solution.reason.startswith("not converged: stopped at the limit of 3 iterations")
    with pytest.raises(ggo.InfeasibleGaitError, match="not converged"):
        solution.require_ok()


def test_a_solver_stopped_by_a_wrong_jacobian_is_not_taken_for_converged():
    graph = paper_graph(0)

    def wrong(frame, want_jacobian):
        return 100.0 * (frame - 0.1), (-100.0 * np.eye(4),)

    graph.add_factor(checked_factor("wrong", (30,), 4, wrong, precision(4, 1.0)))
    solution = graph.solve()
    assert not solution.converged
    assert "not converged" in solution.reason
    told = r"factor 1 of your own \(wrong edge\) has a wrong Jacobian: off by 200 at row (\d), column \1 of g30: "
    assert re.search(told + r"Jacobian -100, finite difference 100; see check_jacobian$", solution.reason)


@pytest.mark.parametrize("frames", [51, 201])
@pytest.mark.parametrize(("sign", "told"), [(-1.0, True), (1.0, False)])
def test_a_refused_step_says_which_factor_has_a_wrong_jacobian_and_accuses_no_other(frames, sign, told):
    def knee_of(sign, angle):
        def knee(frame, want_jacobian):
            return frame[3:] - angle, (np.array([[0.0, 0.0, 0.0, sign]]),)

        return knee

    right = checked_factor("mine", (frames // 2 + 4,), 1, knee_of(1.0, 1.2), precision(1, 5.0))
    # With the right sign it asks for a knee that nobody can bend within the step.
    other = checked_factor("my knee", (frames // 2,), 1, knee_of(sign, 1.2 if told else 4.0), precision(1, 1e5))
    with pytest.raises(ggo.InfeasibleGaitError) as refused:
        ggo.step_over(ggo.paper_base_gait(frames), [], factors=[right, other])
    assert ("factor 2 of your own (my knee" in str(refused.value)) is told
    assert ("see check_jacobian" in str(refused.value)) is told


def test_contradicting_hard_edges_are_named():
    graph = ggo.GaitGraph(BASE, MODEL)
    graph.anchor(BASE.frames[0])
    graph.end(foothold=(0.39, 0.0), hard=True)
    graph.end(foothold=(0.42, 0.0), hard=True)
    solution = graph.solve()
    assert not solution.converged
    assert solution.reason.startswith("contradicting: a hard edge at frame 49 is missed by 0.0")


def test_contradicting_soft_edges_are_seen_by_the_check():
    graph = ggo.GaitGraph(BASE, MODEL)
    graph.anchor(BASE.frames[0])
    graph.end(foothold=(0.39, 0.0), gain=100.0)
    graph.end(foothold=(0.42, 0.0), gain=100.0)
    assert [violation.kind for violation in graph.solve().violations] == ["foothold"]


def test_not_finite_is_named():
    graph = paper_graph(0)
    nan = (np.full(4, np.nan), (np.eye(4),))
    with pytest.raises(ggo.GraphError, match=r"broken edge at frame 7: error .* is not finite"):
        graph.add_factor(checked_factor("broken", (7,), 4, lambda frame, want: nan, precision(4, 1.0)))
    calls = []

    def later(frame, want_jacobian):
        calls.append(1)
        return (nan[0] if len(calls) > 6 else frame * 3.0), (3.0 * np.eye(4),)

    graph.add_factor(checked_factor("later", (7,), 4, later, precision(4, 1.0)))
    with pytest.raises(ggo.GraphError, match=r"later edge at frame 7: error .* is not finite"):
        graph.solve()


def test_an_edge_that_raises_is_named():
    def broken(frame, want_jacobian):
        return frame.nothing, ()

    with pytest.raises(ggo.GraphError, match="mine edge at frame 7: AttributeError"):
        paper_graph(0).add_factor(checked_factor("mine", (7,), 4, broken, precision(4, 1.0)))


@pytest.mark.parametrize(
    "factor",
    [
        gtsam.CustomFactor(None, [frame_key(25)], lambda this, values, jacobians: np.zeros(4)),
        gtsam.PriorFactorVector(frame_key(25), np.zeros(3), precision(3, 1.0)),
        gtsam.PriorFactorPose2(frame_key(25), gtsam.Pose2(), precision(3, 1.0)),
        gtsam.BetweenFactorVector(frame_key(24), frame_key(25), np.zeros(3), precision(3, 1.0)),
    ],
    ids=["no noise", "three rows", "a pose", "a difference of three"],
)
def test_a_factor_that_does_not_fit_is_refused_before_it_can_do_harm(factor):
    with pytest.raises(ggo.InputError, match="factor: "):
        paper_graph(0).add_factor(factor)


def test_rounds_that_do_not_end_are_named(monkeypatch):
    monkeypatch.setattr("ggo_factors.graph.rounds.MOST_ROUNDS", 1)
    solution = paper_graph(0).solve()
    assert not solution.converged
    assert solution.reason == "not converged: frames still join after 1 rounds"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda graph: graph.anchor(BASE.frames[0]), "frame 0 is anchored already"),
        (lambda graph: graph.anchor(np.zeros(3), frame=4), r"frame0: expected shape \(4,\), got \(3,\)"),
        (lambda graph: graph.anchor(np.zeros(4), frame=50), "frame 50 is not in this gait of frames 0 to 49"),
        (lambda graph: graph.add_obstacle(ggo.Obstacle(0.1, 0.2, 0.1), frames=[60]), "frame 60 is not in this gait"),
        (lambda graph: graph.add_obstacle(ggo.Obstacle(0.1, 0.2, 0.1), hold=-1), "hold: -1 1/m must be at least 0"),
        (lambda graph: graph.add_obstacle(ggo.Obstacle(0.1, 0.2, 0.1), gamma=0), "gamma: 0 1/m must be above 0"),
        (lambda graph: graph.end(), "give a foothold, a shank angle or a pose"),
        (lambda graph: graph.end(foothold=(0.3, np.nan)), "foothold: value nan"),
        (lambda graph: graph.end(foothold=(0.3, 0.0), gain=0.0), "gain: 0 must be above 0"),
        (lambda graph: graph.end(shank_angle=90.0), "shank_angle: angle 90 rad .* looks like degrees"),
        (lambda graph: graph.solve(optimizer="adam"), "'adam' is not known; 'dogleg' or 'lm'"),
        (lambda graph: graph.solve(max_iterations=-5), "max_iterations: -5 must be at least 1"),
        (lambda graph: graph.add_factor("edge"), "expected a gtsam factor, got str"),
    ],
)
def test_bad_edges_are_refused(call, message):
    with pytest.raises(ggo.InputError, match=message):
        call(paper_graph(0))


def test_bad_keyframes_are_refused():
    for bad in ("some", [99], [1.5]):
        with pytest.raises(ggo.InputError, match="keyframes"):
            ggo.GaitGraph(BASE, MODEL, keyframes=bad)
    with pytest.raises(
        ggo.UnreachableFootholdError, match=r"2\.000 m from the supporting foot, two legs reach 1\.560 m"
    ):
        paper_graph(0).end(foothold=(2.0, 0.0))


@pytest.mark.parametrize("case", [1, 5])
def test_a_high_sampling_rate_needs_no_more_variables_and_changes_little(case):
    base = ggo.paper_base_gait(frames=301)
    few, full = (ggo.GaitGraph(base, MODEL, keyframes=keyframes) for keyframes in ("auto", "all"))
    for graph in (few, full):
        graph.anchor(base.frames[0])
        graph.add_obstacle(ggo.Obstacle(*OBSTACLES[case]), hold=1.0)
        graph.end(foothold=(0.39, 0.0), gain=5.0 * 301)
    coarse, fine = few.solve(), full.solve()
    assert coarse.ok
    assert fine.ok
    assert len(coarse.keyframes) < 40
    assert coarse.costs["residual"] == pytest.approx(fine.costs["residual"], rel=0.01)


def test_chosen_frames_keep_the_exact_optimum_at_any_rate():
    base = ggo.paper_base_gait(frames=201)
    x = base.endpoints()[:, 0]
    costs = []
    for keyframes in ("auto", "all"):
        graph = ggo.GaitGraph(base, MODEL, keyframes=keyframes)
        graph.anchor(base.frames[0])
        box = ggo.Obstacle(*OBSTACLES[5])
        graph.add_obstacle(box, frames=np.flatnonzero((x >= box.x_start) & (x <= box.x_end)), hold=0.0)
        graph.end(foothold=(0.39, 0.0), gain=5.0 * 201)
        costs.append(sum(graph.solve().costs.values()))
    assert costs[0] == pytest.approx(costs[1], rel=1e-5)


@pytest.mark.parametrize("times", [2, 10])
@pytest.mark.parametrize("count", [26, 101])
def test_a_graph_begins_as_fast_as_the_walker_moves(count, times):
    """As the second-order chain at so many times the rate, whose first motion is given; that one solved densely."""
    base = ggo.Gait(
        ggo.paper_base_gait(count).frames + np.array([0.0, 0.3, 0.0, 0.3]), 0.01, model=ggo.LegModel(0.4, 0.4)
    )
    drift, gain = np.array([0.02, -0.01, 0.03, 0.02]) * 25 / (count - 1), 0.04 * (count - 1) ** 2
    graph = ggo.GaitGraph(base, smoothness=gain)
    graph.anchor(base.frames[0])
    graph.anchor(base.frames[-1], frame=-1)
    graph.begin_with(drift, 1.0 / times)
    offset = graph.solve().gait.frames - base.frames
    motions = times * (count - 1)
    each = np.eye(motions + 1)
    chain = np.vstack([np.diff(each, axis=0), times * gain**0.5 * np.diff(each, n=2, axis=0)])
    # By QR: ten times as quick as by singular values, and of no use to a chain without rank.
    inner = lstsq(chain[:, 2:-1], np.outer(-chain[:, 1], drift / times), lapack_driver="gelsy")[0]
    fine = np.vstack([np.zeros(4), drift / times, inner, np.zeros(4)])
    np.testing.assert_allclose(offset, fine[::times], atol=0.2 / count * np.abs(fine).max())


@pytest.mark.parametrize("anchored", [(0,), (0, 1), (2, 7), (49,), (4, 49), ()])
def test_it_starts_with_the_base_gait_moved_to_the_anchors(anchored):
    graph = ggo.GaitGraph(BASE, MODEL, keyframes="all")
    anchors = {n: BASE.frames[n] + 0.1 * np.arange(4) - 0.01 * n for n in anchored}
    for n, frame in anchors.items():
        graph.anchor(frame, n)
    values = graph.initial_values()
    frames = np.array([values.atVector(frame_key(n)) for n in range(50)])
    offsets = {49: np.zeros(4)} | {n: frame - BASE.frames[n] for n, frame in anchors.items()}
    known = sorted(offsets)
    for column, offset in enumerate((frames - BASE.frames).T):
        wanted = np.interp(range(50), known, [offsets[n][column] for n in known])
        np.testing.assert_allclose(offset, wanted, rtol=0, atol=1e-15)
    for n, frame in anchors.items():
        np.testing.assert_array_equal(frames[n], frame)
