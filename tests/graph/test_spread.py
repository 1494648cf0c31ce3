"""The spread of the joints: closed forms, GTSAM's marginals, the full graph, draws, and its picture."""

from __future__ import annotations

import math
from dataclasses import replace

import gtsam
import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")

from matplotlib import pyplot as plt

import ggo_factors as ggo
from ggo_factors.graph.spread import STEP_STD, joint_spread
from ggo_factors.plot import plot_spread

PAPER = ggo.paper_base_gait()
# Knees bent throughout, so that no knee edge counts.
BENT = replace(PAPER, frames=PAPER.frames + np.radians([10.0, 20.0, 10.0, 20.0]))
BOX = ggo.Obstacle(0.20, 0.25, 0.08)


def solved(smoothness=0.0, keyframes="auto", own=None):
    graph = ggo.GaitGraph(PAPER, smoothness=smoothness, keyframes=keyframes)
    graph.anchor(PAPER.frames[0])
    graph.add_obstacle(BOX)
    graph.end(foothold=(0.39, 0.0), gain=255.0)
    if own is not None:
        graph.add_factor(own)
    return graph.solve().require_ok()


def marginals(solution):
    """What GTSAM says of the keyframes."""
    found = gtsam.Marginals(solution.factor_graph, solution.values)
    blocks = [found.marginalCovariance(gtsam.symbol("g", n)) for n in solution.keyframes]
    return np.sqrt([np.diag(block) for block in blocks]) * STEP_STD / math.sqrt(50.0)


def test_free_at_its_end_it_grows_to_the_step_std():
    graph = ggo.GaitGraph(BENT)
    graph.anchor(BENT.frames[0])
    expected = 0.05 * np.sqrt(np.arange(51) / 50.0)
    np.testing.assert_allclose(joint_spread(graph.solve(), 0.05), np.tile(expected[:, None], 4), atol=1e-12)


def test_held_at_both_ends_it_is_a_bridge():
    graph = ggo.GaitGraph(BENT, keyframes=[20])
    graph.anchor(BENT.frames[0])
    graph.anchor(BENT.frames[-1], frame=-1)
    share = np.arange(51) / 50.0
    expected = 0.05 * np.sqrt(share * (1.0 - share))
    np.testing.assert_allclose(joint_spread(graph.solve(), 0.05), np.tile(expected[:, None], 4), atol=1e-12)


@pytest.mark.parametrize("smoothness", [0.0, 3.7, 100.0])
def test_keyframes_are_as_gtsam_has_them_and_the_others_as_in_the_full_graph(smoothness):
    few, full = solved(smoothness), solved(smoothness, "all")
    assert len(few.keyframes) < 15 < len(full.keyframes) == 51
    found = joint_spread(few)
    np.testing.assert_allclose(found[list(few.keyframes)], marginals(few), atol=1e-10)
    np.testing.assert_allclose(found, marginals(full), atol=1e-8)
    np.testing.assert_allclose(joint_spread(full), marginals(full), atol=1e-10)


def test_a_constraint_of_a_users_own_leaves_nothing_open():
    def knee_of_frame_20(frame, want_jacobian):
        return frame[[1]] - 0.4, [np.asfortranarray([[0.0, 1.0, 0.0, 0.0]])]

    hard, stiff = gtsam.noiseModel.Constrained.All(1), gtsam.noiseModel.Isotropic.Precision(1, 1e8)
    found, reference = (
        solved(own=ggo.checked_factor("knee of frame 20", [20], 1, knee_of_frame_20, noise)) for noise in (hard, stiff)
    )
    spread = joint_spread(found)
    assert spread[20, 1] < 1e-9
    # GTSAM's own marginals of a frame that a constraint leaves partly free are 0 in all four joints.
    np.testing.assert_allclose(spread[list(found.keyframes)], marginals(reference), atol=1e-6)


def test_against_20_000_draws_of_the_second_order_chain():
    """Gaits drawn around the base gait, without the graph: by differences of first and second order and a foothold."""
    smoothness, draws, step = 50.0, 20_000, 0.03
    graph = ggo.GaitGraph(BENT, smoothness=smoothness)
    graph.anchor(BENT.frames[0])
    foothold = BENT.endpoints()[-1]
    graph.end(foothold=tuple(foothold), gain=255.0)
    solution = graph.solve()
    np.testing.assert_allclose(solution.gait.frames, BENT.frames, atol=1e-9)  # nothing bends it
    motions = np.diff(np.eye(51), axis=0)
    chain = np.concatenate([motions, math.sqrt(smoothness) * np.diff(motions, axis=0)])
    rows = np.kron(chain, np.eye(4))
    nudged = BENT.frames[-1] + 1e-6 * np.concatenate([np.eye(4), -np.eye(4)])
    ends = BENT.model.endpoint(nudged)
    landing = np.zeros((2, 204))
    landing[:, -4:] = math.sqrt(255.0) * (ends[:4] - ends[4:]).T / 2e-6
    rows = np.concatenate([rows, landing])[:, 4:]  # frame 0 is anchored
    noise = np.random.default_rng(0).standard_normal((len(rows), draws)) * step / math.sqrt(50.0)
    drawn = (np.linalg.pinv(rows) @ noise).std(axis=1).reshape(50, 4)
    np.testing.assert_allclose(joint_spread(solution, step)[1:], drawn, rtol=0.03)
    assert not joint_spread(solution, step)[0].any()


def test_the_sampling_rate_makes_no_difference():
    found = []
    for frames in (51, 201):
        base = BENT.resampled(frames)
        graph = ggo.GaitGraph(base, smoothness=(0.2 * (frames - 1)) ** 2)
        graph.anchor(base.frames[0])
        graph.end(foothold=(0.39, 0.0), gain=5.0 * (frames - 1))
        found.append(joint_spread(graph.solve()))
    np.testing.assert_allclose(found[1][::4][1:], found[0][1:], rtol=0.03)


def test_it_is_proportional_and_checked():
    solution = solved()
    np.testing.assert_allclose(joint_spread(solution, 0.1), 2.0 * joint_spread(solution, 0.05))
    for wrong in (0.0, -1.0, math.nan):
        with pytest.raises(ggo.InputError, match="step_std: "):
            joint_spread(solution, wrong)
    with pytest.raises(ggo.InputError, match="solution: "):
        joint_spread(PAPER)


@pytest.mark.parametrize("shared", [False, True])
def test_the_picture_shows_two_standard_deviations(shared):
    solution = solved(100.0)
    panels = plot_spread(solution, PAPER, step_std=0.05, axes=plt.subplots()[1] if shared else None)
    assert len(panels) == (1 if shared else 4)
    bands = [band for ax in panels for band in ax.collections if band.get_gid() == "spread"]
    frames, spread = np.degrees(solution.gait.frames), np.degrees(joint_spread(solution, 0.05))
    for number, band in enumerate(bands):
        heights = band.get_paths()[0].vertices[:, 1]
        low, high = (frames + side * spread for side in (-2.0, 2.0))
        assert heights.min() == pytest.approx(low[:, number].min())
        assert heights.max() == pytest.approx(high[:, number].max())
    assert len(bands) == 4
    legend = panels[0].get_legend() if shared else panels[0].get_figure().legends[0]
    assert legend.get_texts()[-1].get_text() == "\u00b1 2 standard deviations"
    plt.close("all")
