"""Balanced graphs: beside SciPy on the same cost, at any rate, held to a support or to the base gait."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

import ggo_factors as ggo
from ggo_factors.evaluate.metrics import zmp

SLOW = {count: replace(ggo.paper_base_gait(count), dt=1.0 / (count - 1)) for count in (13, 51, 101)}
BOX = ggo.Obstacle(0.20, 0.25, 0.10)
FOOTHOLD = (0.39, 0.0)


def graph_of(base, gain=None, support=None, smoothness=None):
    graph = ggo.GaitGraph(base, smoothness=(0.2 * (len(base) - 1)) ** 2 if smoothness is None else smoothness)
    graph.anchor(base.frames[0])
    graph.end(FOOTHOLD, gain=20.0 * len(base))
    if gain != 0.0:
        graph.balance(gain, support)
    return graph


def pushes(base, frames):
    """Moment about the supporting ankle and upward force of the ground over the weight, each inner frame."""
    joints = base.legs().joints(frames)
    x, y = np.moveaxis((joints[:, :-1] + joints[:, 1:]) / 2.0, -1, 0)
    ax, ay = (np.diff(each, 2, axis=0) / base.dt**2 for each in (x, y))
    lift = ay + 9.81  # all four masses are alike
    return (lift * x[1:-1] - y[1:-1] * ax).sum(axis=1) / (4 * 9.81), lift.sum(axis=1) / (4 * 9.81)


@pytest.mark.parametrize("support", [None, (-0.12, 0.10)])
def test_scipy_finds_the_same_gait(support):
    base = SLOW[13]
    graph, smoothness, gain = graph_of(base, 3.0, support), (0.2 * 12) ** 2, 3.0
    for n in (6, 7):
        graph.end((0.1, 0.12), frame=n, gain=30.0)
    solution = graph.solve()
    assert solution.converged
    moment, force = pushes(base, base.frames)
    held = moment / force

    def errors(free):
        frames = np.concatenate([base.frames[:1], free.reshape(-1, 4)])
        offset, (moment, force) = frames - base.frames, pushes(base, frames)
        if support is None:
            off = moment - held * force
        else:
            off = np.maximum(moment - support[1] * force, 0.0) + np.minimum(moment - support[0] * force, 0.0)
        ankle = base.legs().endpoint(frames)
        return np.concatenate(
            [
                np.diff(offset, axis=0).ravel(),
                np.sqrt(smoothness) * np.diff(offset, 2, axis=0).ravel(),
                np.sqrt(5.0) * np.minimum(frames[1:, 1::2], 0.0).ravel(),
                np.sqrt(20.0 * 13) * (ankle[-1] - FOOTHOLD),
                np.sqrt(30.0) * (ankle[6:8] - [0.1, 0.12]).ravel(),
                np.sqrt(gain) * off,
            ]
        )

    found = least_squares(errors, base.frames[1:].ravel(), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    assert solution.error_history[-1] == pytest.approx(found.cost, rel=1e-8)
    np.testing.assert_allclose(solution.gait.frames[1:].ravel(), found.x, atol=1e-5)
    assert solution.costs["balance"] > 1e-6
    assert sum(solution.costs.values()) == pytest.approx(found.cost, rel=1e-6)
    assert solution.factor_graph.error(solution.values) == pytest.approx(found.cost, rel=1e-8)


def test_every_frame_is_a_variable():
    base = SLOW[51]
    assert len(graph_of(base, 0.0).solve().keyframes) < 10
    assert graph_of(base).solve().keyframes == tuple(range(51))


@pytest.mark.parametrize("count", [51, 101])
def test_the_zmp_is_held_to_that_of_the_base_gait_at_any_rate(count):
    base, off = SLOW[count], []
    for gain in (0.0, None):
        graph = graph_of(base, gain)
        graph.add_obstacle(BOX)
        solution = graph.solve().require_ok()
        off.append(np.abs(zmp(solution.gait) - zmp(base)).mean())
        off_largest = np.abs(zmp(solution.gait) - zmp(base)).max()
        told = solution.report.zmp_off, solution.report.zmp_off_largest
        assert told == pytest.approx((off[-1], off_largest) if gain is None else (np.nan, np.nan), nan_ok=True)
    free, held = off
    assert free > 0.02
    assert held < 0.005


def test_a_support_is_kept_to_where_the_ends_allow():
    base = SLOW[51]
    support = (-0.25, 0.10)
    assert zmp(base).max() > 0.13
    graph = graph_of(base, 30.0, support)
    frames = np.arange(1, 50)
    solution = graph.solve().require_ok()
    points = zmp(solution.gait)
    inside = points[(frames > 6) & (frames < 44)]
    beyond = np.maximum(support[0] - points, points - support[1]).clip(0.0)
    assert (solution.report.zmp_off, solution.report.zmp_off_largest) == pytest.approx((beyond.mean(), beyond.max()))
    assert inside.max() < support[1] + 0.005


def test_a_gait_that_is_not_balanced_as_asked_is_told():
    graph = graph_of(SLOW[51], 1e-6)
    graph.add_obstacle(ggo.Obstacle(0.20, 0.25, 0.15))
    solution = graph.solve()
    assert solution.converged
    (fault,) = solution.violations
    assert fault.kind == "balance"
    assert fault.value == solution.report.zmp_off > fault.limit == ggo.Tolerances().balance
    assert "mean distance of the ZMP" in str(fault)
    strict = ggo.Tolerances(balance=1e-4)
    graph = graph_of(SLOW[51])
    graph.add_obstacle(BOX)
    near = graph.solve().gait
    assert ggo.verify(near, balance=SLOW[51]).ok
    assert [fault.kind for fault in ggo.verify(near, balance=SLOW[51], tolerances=strict).violations] == ["balance"]
    with pytest.raises(ggo.InputError, match="balance: the base gait has 13 frames, the gait 51"):
        ggo.verify(near, balance=SLOW[13])


def test_balance_and_limits_of_acceleration_stand_side_by_side():
    base, limits = SLOW[51], ggo.JointLimits()
    graph = graph_of(base)
    graph.add_obstacle(BOX)
    graph.limit_joints(limits)
    gait = graph.solve().require_ok().gait
    assert ggo.verify(gait, foothold=FOOTHOLD, obstacles=[BOX], limits=limits).ok


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"gain": 0.0}, "gain: 0 must be above 0"),
        ({"gain": "much"}, "gain: expected a number"),
        ({"support": (0.2, 0.1)}, "support: its back end, 0.2 m, must be behind its front end, 0.1 m"),
        ({"support": (0.2,)}, "support"),
    ],
)
def test_what_cannot_be_asked_is_refused(arguments, words):
    graph = ggo.GaitGraph(SLOW[13])
    with pytest.raises(ggo.InputError, match=words):
        graph.balance(**arguments)
    graph.balance()
    with pytest.raises(ggo.InputError, match="already"):
        graph.balance()
