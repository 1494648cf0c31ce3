"""Styles from steps: a known style is found, and none where there is none."""

from __future__ import annotations

import numpy as np
import pytest

import ggo_factors as ggo

PAPER = ggo.paper_base_gait()
MODEL = PAPER.legs()
PHASE = np.linspace(0.0, 1.0, 51)[:, None]


def true_style(size=3):
    """Orthonormal smooth directions times standard deviations, shape (51, 4, size)."""
    rng = np.random.default_rng(1)
    waves = [np.sin(np.pi * (n + 1) * PHASE + rng.uniform(0.0, 6.0, 4)).ravel() for n in range(size)]
    across = np.linalg.qr(np.stack(waves, -1))[0]
    return (across * (1.2, 0.6, 0.3)[:size]).reshape(51, 4, size)


def chain(rng, count, spread):
    """Steps' residuals: a smooth random walk of the motions, as the residual edges have it."""
    motions = np.diff(np.eye(50), axis=0)
    root = np.linalg.cholesky(np.eye(50) + 100.0 * motions.T @ motions)
    return np.stack(
        [
            np.concatenate([np.zeros((1, 4)), np.cumsum(np.linalg.solve(root.T, spread * row), axis=0)])
            for row in rng.normal(size=(count, 50, 4))
        ]
    )


def walked(count, size=3, spread=3e-4, seed=0):
    rng = np.random.default_rng(seed)
    style = np.einsum("mjk,nk->nmj", true_style(size), rng.normal(size=(count, size))) if size else 0.0
    return PAPER.frames + style + chain(rng, count, spread)


def test_a_known_style_is_found():
    learned = ggo.learn_style(walked(200), MODEL)
    assert learned.helps
    found, true = learned.directions.reshape(204, -1)[:, :3], true_style().reshape(204, 3)
    for n in range(3):
        size = np.linalg.norm(found[:, n])
        assert size == pytest.approx(np.linalg.norm(true[:, n]), rel=0.2), n
        assert abs(found[:, n] @ true[:, n]) / size / np.linalg.norm(true[:, n]) > 0.95, n
    assert learned.explained > 0.95
    assert learned.likelihood[0] > learned.likelihood[1] + 0.5
    assert learned.error_deg[0] < 0.6 * learned.error_deg[1]
    assert (learned.steps, learned.people) == (200, 1)


def test_it_answers_held_out_steps_better_in_a_graph_too():
    learned, new = ggo.learn_style(walked(60), MODEL), walked(6, seed=9)
    off = []
    for style in (learned, None):
        for step in new:
            graph = ggo.GaitGraph(PAPER, smoothness=100.0, style=style)
            graph.anchor(step[0])
            graph.anchor(step[1], frame=1)
            foothold = tuple(MODEL.endpoint(step[-1]))
            graph.end(foothold=foothold, gain=1000.0)
            off.append(np.square(graph.solve().gait.frames - step).mean())
    assert np.mean(off[:6]) < 0.5 * np.mean(off[6:])


@pytest.mark.parametrize("count", [31, 32, 200])
def test_first_frames_tell_of_the_style_where_their_mean_is_known(count):
    """Here the style says all of first frames: the least deviation that is tried is likeliest."""
    learned = ggo.learn_style(walked(count), MODEL)
    assert (learned.start_variance < np.inf) == (count >= 32)
    if count >= 200:
        assert np.degrees(np.sqrt(learned.start_variance)) == pytest.approx(0.1)


def test_what_the_style_leaves_of_first_frames_is_learned():
    rng, steps = np.random.default_rng(2), walked(200)
    off = np.radians(1.0) * rng.normal(size=(200, 1, 4))
    learned = ggo.learn_style(steps + off * np.linspace(1.0, 0.0, 51)[:, None] ** 8, MODEL)
    assert 0.2 < np.degrees(np.sqrt(learned.start_variance)) < 1.3


def test_landing_edges_vary_with_steps_whose_landings_vary():
    assert ggo.learn_style(walked(60), MODEL).lands


def test_where_nothing_is_common_to_the_steps_it_does_not_help():
    learned = ggo.learn_style(walked(40, size=0, spread=2e-3), MODEL)
    assert not learned.helps
    assert learned.likelihood[0] <= learned.likelihood[1] + 0.05
    # Landing edges that vary by it hold less, and these steps land anyhow.
    assert learned.error_deg[0] >= 0.95 * learned.error_deg[1]


def test_few_steps_do_not_help():
    assert "11 steps" in ggo.learn_style(walked(11), MODEL).why_not
    assert ggo.learn_style(walked(12), MODEL).helps


def test_each_leg_and_person_has_a_mean_of_its_own():
    steps = walked(60)
    shift = np.radians(np.arange(4.0))
    apart = steps.copy()
    apart[::2] += 20.0 * shift
    apart[30:] -= 10.0 * shift
    legs, people = ["left", "right"] * 30, ["a"] * 30 + ["b"] * 30
    learned = ggo.learn_style(apart, MODEL, legs=legs, people=people)
    alike = ggo.learn_style(steps, MODEL, legs=legs, people=people)
    assert learned.people == 2
    np.testing.assert_allclose(np.abs(learned.directions), np.abs(alike.directions), atol=1e-9)
    # One mean for all: their distance is taken for a way to vary.
    together = ggo.learn_style(apart, MODEL)
    assert np.linalg.norm(together.directions[:, :, 0]) > 1.5 * np.linalg.norm(learned.directions[:, :, 0])


def test_of_three_people_whole_people_are_held_out():
    people = [name for name in "abcd" for _ in range(15)]
    learned = ggo.learn_style(walked(60), MODEL, people=people)
    assert learned.helps
    assert learned.people == 4


def test_steps_of_another_number_of_frames_are_resampled():
    steps = walked(30)
    learned, finer = ggo.learn_style(steps, MODEL), ggo.learn_style(np.repeat(steps, 1, axis=1)[:, ::2], MODEL)
    assert finer.directions.shape == learned.directions.shape
    np.testing.assert_allclose(np.abs(finer.directions[:, :, 0]), np.abs(learned.directions[:, :, 0]), atol=2e-3)


@pytest.mark.parametrize(
    ("steps", "others", "words"),
    [
        (np.zeros((3, 51, 4)), {}, "3 steps"),
        (np.zeros((0, 51, 4)), {}, "0 steps"),
        (np.zeros((9, 3, 4)), {}, "3 frames"),
        (np.zeros((9, 51, 3)), {}, "expected shape"),
        (np.full((9, 51, 4), np.nan), {}, "not finite"),
        (np.full((9, 51, 4), 40.0), {}, "2 pi"),
        (np.zeros((4, 51, 4)), {"people": list("abcd")}, "0 steps"),
        (np.zeros((9, 51, 4)), {"legs": ["left"] * 8}, "8 for 9"),
    ],
)
def test_what_no_style_can_be_learned_from_is_refused(steps, others, words):
    with pytest.raises(ggo.InputError, match=words):
        ggo.learn_style(steps, MODEL, **others)


def test_steps_that_are_all_the_same_do_not_help():
    assert not ggo.learn_style(np.repeat(PAPER.frames[None], 20, axis=0), MODEL).helps
