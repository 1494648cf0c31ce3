"""Steps with a style: all checks hold, what it costs in motion, fallbacks that are told, and likeness to people."""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from independent import clearance, densely, least_knee_deg, path_of
from paper_gaits import FOOTHOLD, OBSTACLES, STRIDES

import ggo_factors as ggo
from ggo_factors.factors import styled_edges
from ggo_factors.graph import varied
from ggo_factors.recording.learning import learn_from_logs, style_of
from ggo_factors.recording.strides.mean_step import resampled_step

BASE = ggo.paper_base_gait()
POINTS = replace(BASE, model=replace(BASE.legs(), bones="points"))
FOLDER = Path(os.environ.get("GGO_RECORDINGS", "no such folder"))
needs_recordings = pytest.mark.skipif(not FOLDER.is_dir(), reason="GGO_RECORDINGS names no folder")


@pytest.fixture(
    scope="module", params=[(1.0, False, math.inf), (1.5, True, math.radians(0.2) ** 2)], ids=["few", "many"]
)
def style(request):
    """Smooth ways to vary a step, as large as those of a person, as learned from few steps or many (smoother)."""
    falls, *tells = request.param
    rng, phase = np.random.default_rng(5), np.linspace(0.0, 1.0, 51)[:, None]
    waves = [np.sin(np.pi * (n + 1) * phase + rng.uniform(0.0, 6.0, 4)) / (n + 1) ** falls for n in range(12)]
    numbers = 0.03 * np.stack(waves, -1), 3e-6, 60, 1, 0.99, (5.0, 4.0), (0.7, 0.8)
    return ggo.Style(*numbers, "", *tells)


def bend(gait, base=BASE):
    """Largest second difference beside the base gait's."""
    return float(np.abs(np.diff(gait.frames, 2, axis=0)).max() / np.abs(np.diff(base.frames, 2, axis=0)).max())


@pytest.mark.parametrize("box", OBSTACLES, ids=str)
def test_five_obstacles(box, style):
    step = ggo.step_over(POINTS, [box], foothold=FOOTHOLD, style=style)
    frames = step.gait.frames
    assert clearance(frames, box.x_start, box.x_end, box.height) > 0.0
    assert np.hypot(*(path_of(frames)[-1] - FOOTHOLD)) < 1e-3
    assert least_knee_deg(frames) > -0.3
    assert path_of(densely(frames))[:, 1].min() > -1e-3
    assert bend(step.gait) < 1.5 * bend(ggo.step_over(POINTS, [box], foothold=FOOTHOLD).gait)
    assert step.style is not None


@pytest.mark.parametrize("asked", [{"stride": 0.4}, {"stride": 0.6, "start": ggo.STANDING}], ids=["short", "standing"])
def test_where_limits_break_only_the_residual_edges_bend_on(style, asked):
    """The variable is found on few keyframes, with its limit, and held where more of them join: no round is lost."""
    for number, styled in enumerate(ggo.adjust_stride(BASE, **asked, style=style).steps):
        assert styled.graph.state.joined
        assert styled.graph.state.style_held
        assert styled.rounds <= 4, number
        assert np.linalg.norm(styled.style) > 0.1
        assert least_knee_deg(styled.gait.frames) > -0.3


def test_random_boxes_are_made_as_without(style):
    rng, made, iterations = np.random.default_rng(3), np.zeros(2, dtype=int), np.zeros(2)
    for _ in range(25):
        x, width, height = rng.uniform(0.05, 0.25), rng.uniform(0.02, 0.08), rng.uniform(0.02, 0.2)
        for k, each in enumerate((None, style)):
            try:
                step = ggo.step_over(POINTS, [ggo.Obstacle(x, x + width, height)], foothold=FOOTHOLD, style=each)
            except ggo.InfeasibleGaitError:
                continue
            made[k] += 1
            iterations[k] += step.iterations
            assert clearance(step.gait.frames, x, x + width, height) > 0.0
    assert made[1] >= made[0] >= 24
    assert iterations[1] <= 1.2 * iterations[0]


def test_what_all_first_rounds_share_is_made_once(style, monkeypatch):
    """The residual edges of the style, which take longer to make than to solve, are the same in each step of a walk."""
    made = []
    monkeypatch.setattr(varied, "styled_edges", lambda *given: made.append(given) or styled_edges(*given))
    walk = ggo.adjust_stride(BASE.resampled(47), 0.5, steps=5, style=style)
    assert len(walk.steps) == 5
    assert len(made) == 1


@pytest.mark.parametrize("stride", STRIDES)
def test_strides(stride, style):
    walk = ggo.adjust_stride(BASE, stride, steps=4, style=style)
    assert all(report.ok for report in walk.verify())
    assert max(map(bend, walk.gaits)) < 1.5


@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
@pytest.mark.parametrize("riser", [0.05, 0.10, 0.15, 0.18])
def test_stairs(procedure, riser, style):
    walk = procedure(BASE, riser, tread=0.29, first_edge=0.2, steps=3, style=style)
    assert all(report.ok for report in walk.verify())
    # The made-up ways to vary a step bend more than a person's: with those of the recordings it is 1.4 at most.
    assert max(map(bend, walk.gaits)) < 2.5


@pytest.mark.parametrize("how", [{"hard": True}, {"balance": 2.0}, {"limits": ggo.JointLimits()}, {"smoothness": 0.0}])
def test_beside_everything_else(how, style):
    step = ggo.step_over(BASE, OBSTACLES[:1], foothold=FOOTHOLD, style=style, **how)
    assert step.ok
    assert not any("style" in note for note in step.report.notes)


@pytest.mark.parametrize("frames", [51, 301])
def test_a_step_is_replanned_with_its_style(frames, style):
    start = BASE.frames[0] + np.radians([2.0, 1.0, -2.0, 1.0])
    step = ggo.step_over(BASE.resampled(frames), [], foothold=(0.42, 0.0), start=start, style=style)
    at = (frames - 1) // 3
    again = ggo.replan(step, at)
    np.testing.assert_array_equal(again.gait.frames[: at + 1], step.gait.frames[: at + 1])
    assert again.style is not None
    assert np.degrees(np.abs(again.gait.frames - step.gait.frames).max()) < 2.0


def test_from_a_start_whose_speed_is_not_known_the_first_motion_varies_with_the_style(style):
    asked = {"foothold": (0.42, 0.0), "style": style}
    start = BASE.frames[0] + np.radians([1.0, 0.5, -1.0, 0.5])
    offsets = [
        np.diff(ggo.step_over(BASE, [], **asked, **where).gait.frames[:2] - BASE.frames[:2], axis=0)
        for where in (
            {"start": start},
            {},
            {"start": start, "start_rate": np.diff(BASE.frames[:2], axis=0)[0] / BASE.dt},
        )
    ]
    assert np.abs(offsets[0]).max() > 1e-4
    # In its own first frame, or with its own speed given, the walker moves as the base gait does.
    assert np.abs(offsets[1:]).max() < 1e-9
    fine = ggo.step_over(BASE.resampled(301), [], start=start, **asked).gait
    coarse = ggo.step_over(BASE, [], start=start, **asked).gait
    assert np.degrees(np.abs(fine.resampled(51).frames - coarse.frames).max()) < 1.0


def test_a_style_that_does_not_help_is_left_out_and_told(style):
    few = replace(style, steps=6)
    step, plain = (ggo.step_over(BASE, OBSTACLES[:1], foothold=FOOTHOLD, style=each) for each in (few, None))
    np.testing.assert_array_equal(step.gait.frames, plain.gait.frames)
    assert any("6 steps" in note for note in step.report.notes)
    assert step.style is None


def test_no_style_is_refused_by_name():
    with pytest.raises(ggo.InputError, match="style"):
        ggo.step_over(BASE, [], style="style.npz")
    with pytest.raises(ggo.InputError, match="style"):
        ggo.GaitGraph(BASE, style="style.npz")


@needs_recordings
@pytest.mark.parametrize("moving", [True, False], ids=["start and speed", "start"])
@pytest.mark.parametrize(("name", "most", "every"), [("level_nonan_middle", 56, 3), ("level_csic_s10", 14, 1)])
def test_nearer_to_what_people_did(name, most, every, moving):
    for count in (6, 12, 24, most):  # every third of 56 steps takes both legs in turn
        if count > most:
            continue
        off = off_people(name, count, 1 if count == most else every, most, moving)
        assert off["style"] <= off["without"] + 1e-9, count
    assert off["style"] <= 0.75 * off["no change"]
    assert off["style"] <= 0.90 * off["without"]


@cache
def imported(name):
    """The import of a recording, a gait for each leg."""
    told = json.loads((FOLDER / f"{name}.json").read_text())
    joints = ggo.JointMap(told["joint_map"], told["units"])
    return ggo.import_base_gait(FOLDER / f"{name}.mcap", joints=joints, min_strides=1, leg="each")


def off_people(name, count, every, tested, moving):
    """RMSE in [rad] of every so manyth step from the number `tested` on, learned from the first `count`."""
    report = imported(name)
    steps, legs = np.array([resampled_step(step.frames, 51) for step in report.steps]), [s.leg for s in report.steps]
    # What the check refuses, knees bent backwards, is raised by a constant alike in all.
    steps[:, :, 1::2] += max(0.0, np.radians(0.5) - steps[:, :, 1::2].min())
    style = ggo.learn_style(steps[:count], report.gait.legs(), legs=legs[:count])
    known = np.array(legs[:count])
    bases = {leg: replace(report.gait, frames=steps[:count][known == leg].mean(axis=0)) for leg in set(legs)}
    squares = {"no change": [], "without": [], "style": []}
    for frames, leg in zip(steps[tested::every], legs[tested::every], strict=True):
        base = bases[leg]
        squares["no change"].append(base.frames + frames[0] - base.frames[0] - frames)
        squares["without"].append(bent_to(base, frames, moving) - frames)
        squares["style"].append(bent_to(base, frames, moving, style) - frames)
    return {way: float(np.sqrt(np.mean(np.square(errors)))) for way, errors in squares.items()}


def bent_to(base, frames, moving, style=None):
    """The base gait bent to a person's start, where `moving` its joint speeds, and foothold, shape (51, 4)."""
    x, y = base.legs().endpoint(frames[-1]).tolist()
    step = ggo.Step((x, y), ground=ggo.Ground((-0.02, 0.02, x - 0.02), (-0.5, 0.0, -0.5, y)))
    rate = (frames[1] - frames[0]) / base.dt if moving else None
    return ggo.walk(base, [step], start=frames[0], start_rate=rate, style=style).gaits[0].frames


@needs_recordings
def test_learned_from_logs():
    log = FOLDER / "level_nonan_middle.mcap"
    style = learn_from_logs([log], joints="segment-pitch")
    assert style.helps
    assert style.steps == 112
    assert style.directions.shape == (51, 4, 20)
    own = style_of(ggo.import_base_gait(log, joints="segment-pitch"))
    np.testing.assert_allclose(np.abs(own.directions), np.abs(style.directions), atol=1e-9)
