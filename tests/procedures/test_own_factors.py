"""Users' own GTSAM factors in the procedures: met, at any rate and from any frame on, beside everything else."""

import math
from functools import cache

import gtsam
import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.factors import Place, frame_key, placed_factor

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.15, 0.25, 0.10)
STIFF = gtsam.noiseModel.Isotropic.Precision(1, 1e4)
HARD = gtsam.noiseModel.Constrained.All(1)
KNEE = np.array([[0.0, 0.0, 0.0, 1.0]])
LESS = math.radians(6.0)


def knee_at(frame, angle, noise=STIFF):
    """The swinging knee bent by an angle in a frame."""
    return ggo.checked_factor("knee angle", [frame], 1, lambda g, want: (g[[3]] - angle, (KNEE,)), noise)


def raw_knee_at(frame, angle, noise=STIFF):
    key = frame_key(frame)

    def function(this, values, blocks):
        if blocks is not None:
            blocks[0] = np.asfortranarray(KNEE)
        return values.atVector(key)[[3]] - angle

    return gtsam.CustomFactor(noise, [key], function)


def hip_height_at(frame, height, model):
    """The hip at a height over the supporting ankle in a frame, its Jacobian by differences."""

    def error(g):
        return np.array([model.hip_height(g) - height])

    def function(g, want):
        slopes = [(error(g + step) - error(g - step)) / 2e-6 for step in 1e-6 * np.eye(4)]
        return error(g), (np.stack(slopes, -1),)

    return ggo.checked_factor("hip height", [frame], 1, function, STIFF)


@cache
def plain_knee(frames, frame, **how):
    """The swinging knee in a frame of the step over the box without such factors."""
    return ggo.step_over(BASE.resampled(frames), [BOX], **how).gait.frames[frame, 3]


@pytest.mark.parametrize("how", [{}, {"hard": True}, {"limits": ggo.JointLimits()}, {"smoothness": 0.0}])
@pytest.mark.parametrize(
    ("frames", "frame", "tolerance", "make"),
    [(51, 25, 1e-5, knee_at), (51, 25, 1e-5, raw_knee_at), (201, 100, 1e-5, knee_at), (201, 101, 1e-4, knee_at)],
)
def test_a_factor_of_ones_own_is_met_in_a_step_over_a_box(how, frames, frame, tolerance, make):
    base = BASE.resampled(frames)
    angle = plain_knee(frames, frame, **how) - LESS
    made = ggo.step_over(base, [BOX], factors=[make(frame, angle)], **how)
    if "smoothness" in how:
        tolerance *= 10.0  # the offset has a kink there
    assert made.gait.frames[frame, 3] == pytest.approx(angle, abs=tolerance)
    assert made.require_ok().report.clearance > 0.0
    assert made.gait.endpoints(made.gait.legs())[-1, 0] == pytest.approx(base.endpoints(base.legs())[-1, 0], abs=2e-3)
    assert made.costs["user"] > 0.0


@pytest.mark.parametrize(("frames", "frame", "tolerance"), [(51, 25, 1e-6), (201, 101, 1e-4)])
def test_a_constraint_of_ones_own_is_met(frames, frame, tolerance):
    base = BASE.resampled(frames)
    angle = ggo.step_over(base, [BOX]).gait.frames[frame, 3] - LESS
    made = ggo.step_over(base, [BOX], factors=[knee_at(frame, angle, HARD)])
    assert made.gait.frames[frame, 3] == pytest.approx(angle, abs=tolerance)


def test_the_hip_at_a_height_and_a_motion_of_two_frames():
    model, plain = BASE.legs(), ggo.step_over(BASE, [BOX]).gait
    wanted = float(model.hip_height(plain.frames[25])) - 0.01
    motion = np.array([0.0, 0.0, 0.0, 0.02])
    between = gtsam.BetweenFactorVector(
        frame_key(30), frame_key(32), motion, gtsam.noiseModel.Diagonal.Precisions(np.array([0.01, 0.01, 0.01, 1e4]))
    )
    made = ggo.step_over(BASE, [BOX], factors=[hip_height_at(25, wanted, model), between]).require_ok().gait
    assert model.hip_height(made.frames[25]) == pytest.approx(wanted, abs=2e-4)
    assert made.frames[32, 3] - made.frames[30, 3] == pytest.approx(0.02, abs=2e-4)


def test_none_changes_nothing():
    plain, none = ggo.step_over(BASE, [BOX]), ggo.step_over(BASE, [BOX], factors=())
    np.testing.assert_array_equal(plain.gait.frames, none.gait.frames)
    assert "user" not in none.costs


def test_each_step_of_a_walk_has_its_own():
    steps = [ggo.Step((0.39, 0.0)), ggo.Step((0.39, 0.0), (BOX,)), ggo.Step((0.39, 0.0))]
    plain = ggo.walk(BASE, steps)
    angle = plain.gaits[1].frames[25, 3] - LESS
    steps[1] = ggo.Step((0.39, 0.0), (BOX,), factors=[knee_at(25, angle)])
    made = ggo.walk(BASE, steps)
    np.testing.assert_array_equal(made.gaits[0].frames, plain.gaits[0].frames)
    assert made.gaits[1].frames[25, 3] == pytest.approx(angle, abs=1e-4)
    assert made.plan[1].factors == steps[1].factors
    assert all(report.ok for report in made.verify())


@pytest.mark.parametrize(
    "make",
    [
        lambda **how: ggo.walk(BASE, [ggo.Step((0.39, 0.0)), ggo.Step((0.36, 0.0))], **how),
        lambda **how: ggo.adjust_stride(BASE, 0.7, **how),
        lambda **how: ggo.climb_stairs(BASE, 0.10, tread=0.29, first_edge=0.15, **how),
        lambda **how: ggo.descend_stairs(BASE, 0.10, tread=0.29, first_edge=0.15, **how),
    ],
)
def test_every_procedure_gives_them_to_each_step(make):
    for gait in make(factors=[knee_at(30, 0.9)]).gaits:
        assert gait.frames[30, 3] == pytest.approx(0.9, abs=1e-3)


@pytest.mark.parametrize(("frames", "at", "frame"), [(51, 10, 30), (201, 41, 120), (201, 41, 121)])
def test_a_replan_keeps_them_and_takes_others(frames, at, frame):
    base = BASE.resampled(frames)
    angle = ggo.step_over(base, [BOX]).gait.frames[frame, 3] - LESS
    # One factor is on frames that are walked by then, one on such a frame and one ahead.
    gone = knee_at(at // 2, float(base.frames[at // 2, 3]), gtsam.noiseModel.Isotropic.Precision(1, 1.0))
    first = ggo.step_over(base, [BOX], factors=[gone, knee_at(frame, angle)])
    again = ggo.replan(first, at, obstacles=[ggo.Obstacle(0.17, 0.25, 0.11)])
    assert again.gait.frames[frame, 3] == pytest.approx(angle, abs=1e-3)
    bend = float(first.gait.frames[at - 1, 3]) + 0.5

    def beyond(g, h, want):
        return h[[3]] - g[[3]] - 0.5, (-KNEE, KNEE)

    other = ggo.checked_factor("beyond", [at - 1, frame], 1, beyond, STIFF)
    assert bend == pytest.approx(ggo.replan(first, at, factors=[other]).gait.frames[frame, 3], abs=1e-3)
    assert "user" not in ggo.replan(first, at, factors=[]).costs


@pytest.mark.parametrize(
    "noise",
    [
        gtsam.noiseModel.Gaussian.Covariance(np.array([[2.0, 0.5], [0.5, 1.0]])),
        gtsam.noiseModel.Constrained.All(2),
        gtsam.noiseModel.Robust.Create(
            gtsam.noiseModel.mEstimator.Huber.Create(0.1), gtsam.noiseModel.Isotropic.Sigma(2, 0.5)
        ),
        gtsam.noiseModel.Robust.Create(
            gtsam.noiseModel.mEstimator.Tukey.Create(0.1), gtsam.noiseModel.Isotropic.Sigma(2, 0.5)
        ),
    ],
)
def test_at_a_higher_rate_a_factor_is_the_same_for_any_noise_model(noise):
    frame, base = 100, BASE.resampled(201)

    def knees(g, want):
        return np.array([g[1] ** 2 - 0.1, g[3] * g[1]]), (np.array([[0, 2 * g[1], 0, 0], [0, g[3], 0, g[1]]]),)

    mine = ggo.checked_factor("knees", [frame], 2, knees, noise)
    shares = {3: 0.25, 4: 0.75}
    placed = placed_factor(mine, {frame: Place(np.full(4, 0.1), shares)}, "mine")
    values, whole = gtsam.Values(), gtsam.Values()
    at = {n: base.frames[n + 90] for n in shares}
    for n, g in at.items():
        values.insert(frame_key(n), g)
    whole.insert(frame_key(frame), 0.1 + sum(shares[n] * g for n, g in at.items()))
    assert placed.error(values) == pytest.approx(mine.error(whole))
    wanted, found = mine.linearize(whole), placed.linearize(values)
    np.testing.assert_allclose(np.array(found.getb()), np.array(wanted.getb()), atol=1e-12)
    np.testing.assert_allclose(
        np.array(found.getA()), np.hstack([part * np.array(wanted.getA()) for part in shares.values()]), atol=1e-12
    )


@pytest.mark.parametrize(
    ("factor", "message"),
    [
        ("factor", r"factors: expected a list of NoiseModelFactors"),
        ([3], "factors: expected NoiseModelFactors, got 3"),
        (
            lambda: [gtsam.PriorFactorVector(gtsam.symbol("x", 1), np.zeros(4), gtsam.noiseModel.Unit.Create(4))],
            r"factors\[0\]: key x1 is not",
        ),
        (lambda: [knee_at(10, 0.5), knee_at(51, 0.5)], r"step 1: factors\[1\]: frame 51 is not in this gait of frames"),
        (
            lambda: [gtsam.PriorFactorVector(frame_key(9), np.zeros(3), gtsam.noiseModel.Unit.Create(3))],
            r"step 1: factors\[0\]: does not fit",
        ),
        (lambda: [knee_at(9, np.nan)], "knee angle edge at frame 9: error .* is not finite"),
        (lambda: [raw_knee_at(9, np.nan)], r"step 1: factors\[0\]: its error or Jacobian is not finite"),
    ],
)
def test_bad_factors_are_refused_by_name(factor, message):
    factors = factor() if callable(factor) else factor
    with pytest.raises((ggo.InputError, ggo.GraphError), match=message):
        ggo.step_over(BASE.resampled(51), [BOX], factors=factors)


@pytest.mark.parametrize(
    ("frames", "make", "said"),
    [
        (51, ggo.checked_factor, "mine edge at frame 30"),
        (201, ggo.checked_factor, "mine edge at frame 30"),
        (51, None, "CustomFactor edge at frame 30"),
        (201, None, r"CustomFactor \(of the step's frames \[30\]\) edge at frame 15"),
    ],
)
def test_what_a_factor_raises_in_a_solve_is_told_with_its_frame(frames, make, said):
    calls = []

    def function(g, want):
        calls.append(1)
        if len(calls) > 12:
            raise ValueError("my trouble")
        return g[[3]] - 0.9, (KNEE,)

    def raw(this, values, blocks):
        if blocks is not None:
            blocks[0] = np.asfortranarray(KNEE)
        return function(values.atVector(frame_key(30)), False)[0]

    factor = make("mine", [30], 1, function, STIFF) if make else gtsam.CustomFactor(STIFF, [frame_key(30)], raw)
    with pytest.raises(ggo.InfeasibleGaitError, match=f"no gait found: {said}: ValueError: my trouble"):
        ggo.step_over(BASE.resampled(frames), [BOX], factors=[factor])


def test_a_factor_of_a_later_step_is_refused_with_its_number():
    steps = [ggo.Step((0.39, 0.0)), ggo.Step((0.39, 0.0), factors=[knee_at(77, 0.5)])]
    with pytest.raises(ggo.InputError, match=r"step 2: factors\[0\]: frame 77 is not in this gait"):
        ggo.walk(BASE, steps)


def test_factors_that_contradict_the_step_are_refused_with_numbers():
    with pytest.raises(ggo.InfeasibleGaitError, match="contradicting: a hard edge at frame 25 is missed by"):
        ggo.step_over(BASE, [BOX], factors=[knee_at(25, 0.9, HARD), knee_at(25, 1.0, HARD)])
    with pytest.raises(ggo.InfeasibleGaitError, match="obstacle"):
        ggo.step_over(BASE, [BOX], factors=[knee_at(n, 0.2, HARD) for n in range(20, 35)])


def test_a_step_with_factors_prints_in_a_line():
    step = ggo.Step((0.39, 0.0), factors=[knee_at(25, 0.9)])
    assert "\n" not in repr(step)
    assert step.shifted(0.01, 0.0).factors == step.factors
