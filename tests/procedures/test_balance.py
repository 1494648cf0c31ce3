"""Balanced steps: near the base gait's ZMP for no more change, in every procedure; told where it cannot be had."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from independent import clearance, path_of

import ggo_factors as ggo
from ggo_factors.evaluate.metrics import zmp

FOOTHOLD = (0.39, 0.0)
FIVE = [(0.20, 0.25, 0.08), (0.20, 0.25, 0.15), (0.12, 0.16, 0.08), (0.12, 0.16, 0.15), (-0.33, -0.29, 0.175)]


def slow(count):
    """The paper's base gait and model, in which bones are points: a box stands in the leg."""
    base = ggo.paper_base_gait(count)
    return replace(base, dt=1.0 / (count - 1), model=replace(base.legs(), bones="points"))


BASE = slow(51)
LEVEL = ggo.Step(FOOTHOLD)


def boxes(count, seed):
    """Boxes that do not come within 0.03 m of the supporting foot."""
    rng = np.random.default_rng(seed)
    while count:
        start, width, height = rng.uniform(-0.30, 0.25), rng.uniform(0.02, 0.08), rng.uniform(0.02, 0.18)
        if start > 0.03 or start + width < -0.03:
            count -= 1
            yield start, start + width, height


def numbers(base, box, balance):
    """Mean distance of the ZMP from the base gait's, mean change and peak acceleration of a step over a box."""
    gait = ggo.step_over(base, [ggo.Obstacle(*box)], foothold=FOOTHOLD, balance=balance).gait
    assert clearance(gait.frames, *box) > 0.0
    assert np.hypot(*(path_of(gait.frames)[-1] - FOOTHOLD)) < 1e-3
    bend = np.abs(np.diff(gait.frames, 2, axis=0)).max() / base.dt**2
    return np.abs(zmp(gait) - zmp(base)).mean(), np.abs(gait.frames - base.frames).mean(), bend


def judge(base, cases):
    free, held = (np.array([numbers(base, box, balance) for box in cases]) for balance in (None, 2.0))
    assert free[:, 0].mean() > 0.02
    assert held[:, 0].mean() <= 0.005
    assert held[:, 0].max() <= 0.015
    more = held.mean(axis=0) / free.mean(axis=0)
    assert more[1] <= 1.02
    assert more[2] <= 1.05


def test_the_papers_boxes_and_a_sample_of_others():
    judge(BASE, [*FIVE, *boxes(8, 3)])


@pytest.mark.parametrize("count", [31, 101, 201])
def test_alike_at_any_sampling_rate(count):
    judge(slow(count), FIVE)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", [1, 2, 5])
def test_a_hundred_boxes(seed):
    judge(BASE, [*FIVE, *boxes(100, seed)])


PROCEDURES = {
    "step_over": lambda how: [ggo.step_over(BASE, [ggo.Obstacle(*FIVE[0])], **how)],
    "walk": lambda how: ggo.walk(BASE, [ggo.Step(FOOTHOLD, (ggo.Obstacle(*FIVE[0]),)), LEVEL], **how).steps,
    "adjust_stride": lambda how: ggo.adjust_stride(BASE, 0.9, **how).steps,
    "climb_stairs": lambda how: ggo.climb_stairs(BASE, 0.15, tread=0.29, first_edge=0.2, **how).steps,
    "descend_stairs": lambda how: ggo.descend_stairs(BASE, 0.1, tread=0.29, first_edge=0.2, **how).steps,
    "from standing": lambda how: ggo.walk(BASE, [LEVEL], start=ggo.STANDING, **how).steps,
    "hard": lambda how: [ggo.step_over(BASE, [ggo.Obstacle(*FIVE[0])], hard=True, **how)],
    "limits": lambda how: [ggo.step_over(BASE, [ggo.Obstacle(*FIVE[0])], limits=ggo.JointLimits(), **how)],
}


@pytest.mark.parametrize("name", PROCEDURES)
def test_every_procedure_balances_and_tells(name):
    free, none, held = (PROCEDURES[name]({"balance": gain}) for gain in (None, 0.0, 2.0))
    for each, other, balanced in zip(free, none, held, strict=True):
        np.testing.assert_array_equal(each.gait.frames, other.gait.frames)
        assert np.isnan(each.report.zmp_off)
        off = ggo.verify(each.gait, balance=BASE).zmp_off
        assert balanced.ok
        assert balanced.report.zmp_off < balanced.report.zmp_off_largest
        told = any("not balanced" in note for note in balanced.report.notes)
        assert told == (balanced.report.zmp_off > ggo.Tolerances().balance)
        if told:
            assert balanced.report.zmp_off > 0.1
            np.testing.assert_allclose(balanced.gait.frames, each.gait.frames, atol=0.1)
        else:
            assert balanced.report.zmp_off < off
    # Down stairs the second start is too far from the base gait's.
    assert told == (name == "descend_stairs")


def test_a_replan_stays_balanced():
    solution = ggo.step_over(BASE, [ggo.Obstacle(*FIVE[0])], foothold=FOOTHOLD, balance=2.0)
    same = ggo.replan(solution, 12)
    np.testing.assert_allclose(same.gait.frames, solution.gait.frames, atol=np.radians(1.5))
    assert same.report.zmp_off < 0.005
    moved = ggo.replan(solution, 12, foothold=(0.42, 0.0))
    assert moved.report.zmp_off < 0.005
    walk = ggo.replan(ggo.walk(BASE, [LEVEL, LEVEL], balance=2.0), step=1, at_frame=12, foothold=(0.42, 0.0))
    assert all(step.report.zmp_off < 0.01 for step in walk.steps)


@pytest.mark.parametrize("balance", [-1.0, "yes", float("nan"), True])
def test_what_is_no_gain_is_refused(balance):
    with pytest.raises(ggo.InputError, match="balance"):
        ggo.step_over(BASE, [], balance=balance)
