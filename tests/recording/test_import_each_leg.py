"""Imports that know each leg and each kind of ground: stairs of recordings and of the library itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_cut_strides import DOWN, UP, periodic, walk
from test_import_base_gait import import_log, logged  # noqa: F401  (a fixture)

import ggo_factors as ggo
from ggo_factors.errors import InputError, LogError
from ggo_factors.motion.gait import swap_roles
from ggo_factors.recording.each_leg import closed_pair, level_pair
from ggo_factors.recording.strides.mean_step import level_step, stand_with_bent_knees, steps_with_bent_knees

STAIRS = {"stairs_wpi_s04_riser173": 0.173, "stairs_wpi_s04_riser192": 0.192}
PAPER = ggo.paper_base_gait()


def limping(degrees=0.0, shift=0.5):
    """A log of a steady walk, the left knee bent by more, landing at `shift` of the right leg's stride."""
    times, values, _ = walk(12, shift=shift)
    return times, values + np.radians([0.0, 0.0, 0.0, degrees])


def test_each_leg_has_its_own_step(logged):  # noqa: F811
    times, values = limping(6.0)
    report = logged(times, values)
    assert np.degrees(report.left.frames[:, 3] - report.right.frames[:, 3]).mean() == pytest.approx(6.0, abs=1.0)
    assert np.degrees(report.left.frames[:, 1] - report.right.frames[:, 1]).mean() == pytest.approx(-6.0, abs=1.0)
    for one, other in ((report.left, report.right), (report.right, report.left)):
        np.testing.assert_allclose(swap_roles(one.frames[-1]), other.frames[0], atol=1e-12)
        np.testing.assert_allclose(one.endpoints()[[0, -1], 1], 0.0, atol=1e-9)
        assert one.frames[:, 1::2].min() > np.radians(-0.3) - 1e-9


def test_a_leg_that_lands_late_takes_longer(logged):  # noqa: F811
    report = logged(*limping(shift=0.45))
    # The left leg is at 0.45 of its stride when the right one strikes: it lands 0.55 of a stride later.
    assert report.left.duration == pytest.approx(0.55 * 1.1, abs=0.01)
    assert report.right.duration == pytest.approx(0.45 * 1.1, abs=0.01)
    both = report.base_gaits
    assert both.left.dt == both.right.dt
    assert len(both.left) - len(both.right) == pytest.approx(10, abs=1)


def test_legs_too_far_apart_are_no_one_gait(logged):  # noqa: F811
    times, values = limping(18.0)
    with pytest.raises(LogError, match=r"the legs are 1[0-9] degrees apart.*leg='each'.*leg='right' or leg='left'"):
        logged(times, values)
    each = logged(times, values, leg="each")
    with pytest.raises(LogError, match="the legs are"):
        _ = each.gait
    assert each.base_gaits.left is not each.base_gaits.right
    right = logged(times, values, leg="right")
    np.testing.assert_allclose(right.left.frames, right.right.frames, atol=1e-12)
    np.testing.assert_allclose(right.gait.frames, right.right.frames, atol=1e-9)
    assert right.strides_used["left"] == 0
    with pytest.raises(InputError, match="leg: expected 'mean', 'each'"):
        logged(times, values, leg="both")


def test_the_covariance_is_that_of_the_strides(logged):  # noqa: F811
    times, values = limping()
    rng = np.random.default_rng(1)
    sizes = np.repeat(1.0 + 0.05 * rng.normal(size=len(times) // 110 + 1), 110)[: len(times), None]
    report = logged(times, values * sizes)
    for leg, found in report.covariance.items():
        strides = np.array([s.angles[:-1].ravel() for s in report.used if s.leg == leg])
        wanted = np.cov(strides, rowvar=False)
        np.testing.assert_allclose(found.reshape(wanted.shape), wanted, atol=1e-12)
        np.testing.assert_allclose(np.sqrt(np.einsum("ajaj->aj", found)), report.spread[leg], atol=1e-12)
    assert max(report.spread_deg.values()) > 0.5


@pytest.mark.parametrize("leg", ["mean", "each", "right"])
def test_base_gaits_know_their_strides_and_how_they_spread(logged, leg, tmp_path):  # noqa: F811
    times, values = limping()
    rng = np.random.default_rng(2)
    sizes = np.repeat(1.0 + 0.1 * rng.normal(size=len(times) // 110 + 1), 110)[: len(times), None]
    report = logged(times, values * sizes, leg=leg)
    counts = report.strides_used
    assert report.right.recorded.strides == counts["right"]
    assert report.mean_gait.recorded.strides == counts["right"] + counts["left"]
    # Half a cycle from heel strike to heel strike is support, and half is swing.
    sd = np.array([s.angles for s in report.used if s.leg == "right"]).std(axis=0, ddof=1)
    phase = np.linspace(0.0, 1.0, len(sd))
    late = np.array([np.interp(np.linspace(0.5, 1.0, 51), phase, column) for column in sd.T]).T
    np.testing.assert_allclose(report.right.recorded.spread[5:-5, 2:], late[5:-5], rtol=0.05)
    if leg == "right":
        assert report.left.recorded.strides == counts["right"]
        np.testing.assert_allclose(report.mean_gait.recorded.spread, report.right.recorded.spread, rtol=1e-3)
    kept = report.base_gaits if leg == "each" else report.gait
    kept.save(tmp_path / "base.csv")
    read = ggo.load_base_gaits(tmp_path / "base.csv").right if leg == "each" else ggo.load_gait(tmp_path / "base.csv")
    mine = report.right if leg == "each" else report.mean_gait
    assert read.recorded.swing == ("right" if leg == "each" else "both")
    np.testing.assert_allclose(read.recorded.spread, mine.recorded.spread_at(len(read)), atol=1e-12)


def test_a_pair_of_like_legs_is_the_one_step():
    cycle = np.vstack([PAPER.frames[:, :2], PAPER.frames[1:-1, 2:]])
    made = level_pair({"right": cycle, "left": cycle}, 0.5, 51)
    one = level_step(np.vstack([cycle, cycle[:1]]), 51)
    for frames in made.values():
        np.testing.assert_allclose(frames, one, atol=1e-12)
    (left, right), _ = steps_with_bent_knees([one, one], PAPER.legs(), 0.1, 0.3)
    np.testing.assert_allclose(left, right, atol=1e-12)
    np.testing.assert_allclose(left, stand_with_bent_knees(one, PAPER.legs(), 0.1, 0.3)[0], atol=1e-12)


def test_a_pair_is_changed_by_the_least_that_stands_on_the_ground():
    from scipy.optimize import minimize

    rng = np.random.default_rng(3)
    first, second = closed_pair(*(PAPER.frames + np.radians(rng.normal(0.0, 4.0, (1, 4))) for _ in range(2)))
    first, second = (frames + np.radians([0.0, 8.0, 0.0, 8.0]) for frames in (first, second))
    (left, right), raised = steps_with_bent_knees([first, second], PAPER.legs())
    assert raised == 0.0
    share = np.linspace(0.0, 1.0, len(first))[:, None]

    def changed(numbers):
        own, other = numbers.reshape(2, 4)
        return [(1 - share) * a + share * swap_roles(b) for a, b in ((own, other), (other, own))]

    ground = [
        {"type": "eq", "fun": lambda d, f=f, k=k: PAPER.legs().endpoint(f[0] + d.reshape(2, 4)[k])[1]}
        for k, f in enumerate((first, second))
    ]
    cost = lambda d: 1e3 * sum(float((part**2).sum()) for part in changed(d))  # noqa: E731
    found = minimize(cost, np.zeros(8), constraints=ground, method="SLSQP", options={"ftol": 1e-14, "maxiter": 500})
    assert found.success
    best = changed(found.x)
    np.testing.assert_allclose(left, first + best[0], atol=2e-4)
    np.testing.assert_allclose(right, second + best[1], atol=2e-4)


@pytest.mark.parametrize("name", STAIRS)
@pytest.mark.parametrize("legs", [None, ggo.LegModel(0.383, 0.383)])
def test_recorded_stairs_have_their_riser_and_tread(recordings, name, legs):
    report = import_log(recordings, name, activity="stairs-up", model=legs)
    assert report.riser == pytest.approx(STAIRS[name], abs=0.010)
    assert 0.26 < report.tread < 0.32
    assert report.riser == pytest.approx(np.median([swing.rise for swing in report.used]))
    assert max(report.corrections_deg) == report.correction_deg < 15.0
    assert "support hip" in report.text()
    for gait in (report.left, report.right):
        np.testing.assert_allclose(gait.endpoints()[-1], [report.tread, report.riser], atol=1e-9)


def test_legs_of_a_recording_that_are_far_apart(recordings):
    with pytest.raises(LogError, match="the legs are 17 degrees apart"):
        import_log(recordings, "refuse_legs_apart", min_strides=1)
    assert import_log(recordings, "refuse_legs_apart", min_strides=1, leg="right").strides_used == {
        "right": 2,
        "left": 0,
    }


@pytest.mark.parametrize("pair", [("stairs_wpi_s04_riser173", "stairs_wpi_s04_riser192"), tuple(reversed(STAIRS))])
def test_a_persons_stairs_are_like_those_made_from_another_of_theirs(recordings, pair):
    base, walked = (import_log(recordings, name, activity="stairs-up") for name in pair)
    both = ggo.BaseGaits(PAPER, PAPER, up=base.gait)
    for how in ({}, {"start": ggo.STANDING}, {"on_stairs": True}):
        made = ggo.climb_stairs(both, STAIRS[pair[1]], tread=0.29, first_edge=0.2, steps=4, **how)
        for step in made.gaits[1:]:
            for swing in walked.used[1:]:
                off = step.resampled(len(swing.frames)).frames - swing.frames
                assert np.degrees(np.sqrt(np.mean(off**2))) < 10.0


@pytest.mark.parametrize("first_swing", ["right", "left"])
@pytest.mark.parametrize(("riser", "tread"), [(0.10, 0.35), (0.18, 0.25)])
@pytest.mark.parametrize(("procedure", "kind"), [(ggo.climb_stairs, "up"), (ggo.descend_stairs, "down")])
def test_exported_stairs_are_read_as_they_were(tmp_path, procedure, kind, riser, tread, first_swing):
    made = procedure(PAPER, riser, tread=tread, first_edge=0.2, steps=5, first_swing=first_swing)
    made.slowed(0.8).save(tmp_path / "slow.csv")
    for number, played in enumerate((made, ggo.load_walk(tmp_path / "slow.csv"))):
        ggo.export_mcap(played, tmp_path / f"{number}.mcap")
        report = ggo.import_base_gait(tmp_path / f"{number}.mcap", joints="direct", activity=f"stairs-{kind}")
        assert report.riser == pytest.approx(riser, abs=0.010)
        assert report.tread == pytest.approx(tread, abs=0.010)
        assert report.used[-1].leg == first_swing
        off = report.gait.frames - made.gaits[-1].frames
        # Slowed towards the landing, the same frames are at other times of the step.
        assert number == 1 or np.degrees(np.sqrt(np.mean(off**2))) < 1.0


def test_a_pause_in_one_swing_does_not_raise_the_stairs(logged):  # noqa: F811
    times = np.arange(1200) * 0.01
    plain = logged(times, periodic(UP, times), activity="stairs-up")
    swing = plain.used[0]
    inside = (swing.start + swing.end) / 2.0
    paused = np.where(times < inside, times, np.maximum(inside, times - 0.4))
    report = logged(times, periodic(UP, paused), activity="stairs-up")
    assert report.riser == pytest.approx(plain.riser, abs=0.01)


def test_swings_that_repeat_are_told(logged):  # noqa: F811
    times = np.arange(1200) * 0.01
    report = logged(times, periodic(UP, times), activity="stairs-up")
    assert any("were they played" in note for note in report.notes)


def test_stairs_that_lead_backwards_are_refused(logged):  # noqa: F811
    made = ggo.climb_stairs(PAPER, 0.14, tread=0.3, first_edge=0.2, steps=8).joint_trajectory()
    values = made.positions[:, [2, 3, 0, 1]]
    with pytest.raises(LogError, match=r"no stair gait: the body goes -0\.1. m forward from stair to stair"):
        logged(made.time, values, activity="stairs-up")


def test_a_way_down_needs_no_more_than_its_limit(logged):  # noqa: F811
    times = np.arange(1500) * 0.01
    tilted = periodic(DOWN, times) + np.radians([12.0, 0.0, 12.0, 0.0])
    with pytest.raises(LogError, match=r"no stair gait: .*angles must change by"):
        logged(times, tilted, activity="stairs-down")


def test_a_walk_knows_its_first_leg_when_exported(tmp_path):
    step = replace(PAPER, name="left first")
    walk_left = ggo.walk(step, [ggo.Step((0.4, 0.0))] * 2, first_swing="left")
    ggo.export_mcap(walk_left, tmp_path / "left.mcap")
    read = ggo.import_base_gait
    with pytest.raises(LogError, match=r"found 0 swings on stairs up"):
        read(tmp_path / "left.mcap", joints="direct", activity="stairs-up")
    played = walk_left.joint_trajectory()
    np.testing.assert_array_equal(played.left_knee[: len(PAPER)], walk_left.gaits[0].frames[:, 3])
