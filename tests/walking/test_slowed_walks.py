"""Walks made slower where joints or a landing foot would be too fast: limits at every instant, the path as it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paces import STANDING, TIGHT, beyond, paces, random_limits, random_plan
from scipy.optimize import minimize

import ggo_factors as ggo
from ggo_factors.check.report import STANDARD
from ggo_factors.motion.gait import swap_roles
from ggo_factors.motion.played import Played
from ggo_factors.walking.pace import BENDS_OVER, slowed_times

BASE = ggo.paper_base_gait()
LIMITS = ggo.JointLimits()
BOX = ggo.Obstacle(0.20, 0.25, 0.15)
LEVEL_STEP = ggo.Step((0.39, 0.0))
OVER = ggo.Step((0.39, 0.0), (BOX,))


@pytest.fixture(scope="module")
def walk():
    """Four steps, the first over a high box, from standing to standing, within tight limits."""
    return ggo.walk(BASE, [OVER, LEVEL_STEP, LEVEL_STEP, STANDING], start=ggo.STANDING, limits=TIGHT)


def unpaced(walk):
    """The same frames at the base gait's pace."""
    return replace(walk, gaits=tuple(replace(gait, paced=None) for gait in walk.gaits), steps=(), landing_speed=None)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=8)  # tests/campaign/test_pace.py makes 240
def test_random_walks_keep_random_limits(seed):
    rng = np.random.default_rng(seed)
    (steps, start), limits = random_plan(rng, most=4), random_limits(rng)
    walk = ggo.walk(BASE, steps, start=start, limits=limits)
    assert beyond(walk, limits) <= 1.0
    assert paces(walk).max() <= 1.0 + 1e-9
    trajectory = walk.joint_trajectory(rate=1000.0)
    for stands, end in ((start is not None, 0), (steps[-1] is STANDING, -1)):
        assert not stands or not trajectory.velocities[end].any()
    assert all(report.ok for report in walk.verify())


def test_the_path_stays_to_the_bit(walk):
    # Slowing on its own, so that nothing but times may change.
    free = unpaced(walk)
    slowed = free.slowed(1.0)
    assert slowed.times[-1] > 1.1 * free.times[-1]
    for before, after in zip(free.gaits, slowed.gaits, strict=True):
        np.testing.assert_array_equal(after.frames, before.frames)
        assert after.dt == before.dt
    assert slowed.plan == free.plan


def test_a_walk_that_is_slow_enough_keeps_its_times():
    wide = ggo.JointLimits(hip_speed=40.0, knee_speed=40.0, hip_acceleration=900.0, knee_acceleration=900.0)
    walk = ggo.walk(BASE, [LEVEL_STEP] * 3, limits=wide)
    np.testing.assert_allclose(walk.times, np.arange(151) * BASE.dt, atol=1e-9, rtol=0.0)
    assert all(gait.paced is None for gait in walk.gaits)
    assert not any("slowed" in note for step in walk.steps for note in step.report.notes)
    assert walk.joint_trajectory().time.tolist() == (np.arange(151) * BASE.dt).tolist()


def test_the_slowdown_is_told(walk):
    for step, gait in zip(walk.steps, walk.gaits, strict=True):
        said = [note for note in step.report.notes if note.startswith("slowed to")]
        assert len(said) == (gait.paced is not None)
        if said:
            assert f"{gait.duration:.3f} s, {gait.slowdown:.3f} times" in said[0]
        assert step.gait is gait
    assert walk.gaits[0].slowdown > 1.05
    assert "slowed" in repr(walk)


def test_the_pace_changes_slowly_also_where_the_legs_change_roles(walk):
    times, squares = walk.times, paces(walk) ** 2
    # Half a frame is lost at each end of the two motions that are compared.
    assert np.abs(np.diff(squares)).max() <= 2.2 * BASE.dt / (BENDS_OVER * 0.5)
    played = walk.joint_trajectory().played
    for end in np.cumsum([len(gait) - 1 for gait in walk.gaits])[:-1]:
        (_, before, _), (_, after, _) = (played.at(np.array([times[end] + off])) for off in (-1e-9, 1e-9))
        np.testing.assert_allclose(before, after, atol=1e-5)


@pytest.mark.parametrize("x_end", [0.33, 0.37, 0.385])
def test_a_foot_lands_no_faster_than_it_may(x_end):
    box = ggo.Obstacle(x_end - 0.04, x_end, 0.10)
    fast = ggo.step_over(BASE, [box], foothold=(0.39, 0.0))
    slow = ggo.step_over(BASE, [box], foothold=(0.39, 0.0), pace="auto")
    assert fast.report.landing_speed > 1.5
    assert slow.report.landing_speed <= 1.0 * (1.0 + STANDARD.limits)
    # Its own two last frames, and the path between them as it is played.
    gait = slow.gait
    height = gait.endpoints()[-2:, 1]
    assert (height[0] - height[1]) / (gait.times[-1] - gait.times[-2]) == pytest.approx(slow.report.landing_speed)
    np.testing.assert_array_equal(gait.frames, fast.gait.frames)


@pytest.mark.parametrize("riser", [0.10, 0.15])
def test_descents_land_softly(riser):
    walk = ggo.descend_stairs(BASE, riser, tread=0.29, first_edge=0.19, steps=3, limits=LIMITS)
    reports = walk.verify()
    assert max(report.landing_speed for report in reports) <= walk.landing_speed * (1.0 + STANDARD.limits)
    assert walk.landing_speed == pytest.approx(1.0, abs=0.05)
    assert all(report.ok for report in reports)
    assert beyond(walk, LIMITS) <= 1.0


# -- the linear program beside other solvers ---------------------------------------------------------------------


def quickest(path, limits, bends):
    """The least time along a path of evenly spaced frames by SLSQP, which knows the time itself and no program."""
    ds, q1, q2 = path.times[1], path.velocities, path.accelerations
    middle, half = (q1[1:] + q1[:-1]) / 2.0, q2[1:] - q2[:-1]
    count = len(path.times)

    def accelerations(b):
        slope = (np.diff(b) / ds)[:, None]
        starts, ends = q2[:-1] * b[:-1, None] + q1[:-1] * slope / 2.0, q2[1:] * b[1:, None] + q1[1:] * slope / 2.0
        between = (q2[:-1] + half / 2.0) * ((b[1:] + b[:-1]) / 2.0)[:, None] + (middle - half * ds / 8.0) * slope / 2.0
        return np.concatenate([starts, between, ends]) / limits.acceleration

    def slack(b):
        speeds = np.abs(q1) * np.sqrt(b)[:, None] / limits.speed
        slopes = np.diff(b) / ds * bends / 2.0
        curved = np.diff(b, 2) / ds**2 * bends**2 / 4.0
        return 1.0 - np.concatenate([np.abs(part).ravel() for part in (accelerations(b), speeds, slopes, curved)])

    def duration(b):
        roots = np.sqrt(b)
        return float((2.0 * ds / (roots[:-1] + roots[1:])).sum())

    found = minimize(
        duration,
        np.full(count, 0.02),
        method="SLSQP",
        bounds=[(1e-3, 1.0)] * count,
        constraints={"type": "ineq", "fun": slack},
        options={"maxiter": 400, "ftol": 1e-9},
    )
    assert found.success
    assert slack(found.x).min() > -1e-6
    return found.fun


@pytest.mark.parametrize("scale", [0.4, 0.7])
def test_as_quick_as_another_solver_finds(scale):
    gait = ggo.step_over(ggo.paper_base_gait(41), [ggo.Obstacle(0.20, 0.25, 0.10)], foothold=(0.39, 0.0)).gait
    limits = replace(LIMITS, **{name: getattr(LIMITS, name) * scale for name in ("hip_speed", "knee_acceleration")})
    path = gait.played
    times = slowed_times(path, limits, np.ones(len(gait)), gait.duration, 0, held=False)
    least = quickest(path, limits, BENDS_OVER * gait.duration)
    assert least > 1.05 * gait.duration
    # What the program sums is pace squared, not time, and it draws limits in by what the spline swings beyond them.
    assert 0.99 * least < times[-1] < 1.06 * least


@given(seed=st.integers(0, 10**6))
@settings(max_examples=20)
def test_no_slower_than_one_pace_for_all(seed):
    rng = np.random.default_rng(seed)
    walk, limits = unpaced(ggo.walk(BASE, [LEVEL_STEP] * 2)), random_limits(rng)
    slowed = replace(walk, limits=limits).slowed(2.0)
    path = walk.joint_trajectory().played
    times = max(
        1.0,
        float((np.abs(path.fastest) / limits.speed).max()),
        float(np.sqrt((np.abs(path.accelerations) / limits.acceleration).max())),
    )
    assert slowed.times[-1] <= 1.005 * times * walk.times[-1]


def test_a_walker_who_moves_keeps_the_speed_that_it_has():
    gait = ggo.step_over(BASE, [BOX], foothold=(0.39, 0.0)).gait
    times = slowed_times(gait.played, LIMITS, np.ones(51), 0.5, 8, held=True)
    np.testing.assert_array_equal(times[:9], gait.times[:9])
    assert times[9] - times[8] == pytest.approx(BASE.dt, rel=0.05)
    assert times[-1] > gait.duration
    again = Played(times, gait.frames)
    assert np.abs(again.velocities[8] - gait.played.velocities[8]).max() < 0.01 * np.abs(gait.played.velocities).max()


def test_a_walker_who_moves_too_fast_to_slow_down_is_told():
    walk = ggo.Walk((BASE,), (LEVEL_STEP,), limits=replace(LIMITS, hip_speed=0.2))
    with pytest.raises(ggo.InfeasibleGaitError, match="step 1: the joints move too fast now to slow down in time: hip"):
        walk.slowed(1.0, held=True)
    assert walk.slowed(1.0).times[-1] > 4.0 * BASE.duration


# -- files -------------------------------------------------------------------------------------------------------


def test_walk_file_round_trip(walk, tmp_path):
    path = tmp_path / "walk.csv"
    walk.save(path)
    text = path.read_text()
    assert text.startswith("# ggo-walk 2\n")
    assert "\nstep,t_s," in text
    read = ggo.load_walk(path)
    assert read.landing_speed == walk.landing_speed
    np.testing.assert_allclose(read.times, walk.times, atol=1e-12, rtol=0.0)
    for before, after in zip(walk.gaits, read.gaits, strict=True):
        np.testing.assert_allclose(after.frames, before.frames, atol=1e-12, rtol=0.0)
        assert after.dt == before.dt
    assert all(report.ok for report in read.verify())
    read.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == text


def test_a_walk_with_evenly_spaced_frames_is_written_as_before(tmp_path):
    path = tmp_path / "walk.csv"
    ggo.walk(BASE, [LEVEL_STEP]).save(path)
    text = path.read_text()
    assert text.startswith("# ggo-walk 1\n")
    assert "t_s" not in text
    assert "landing_speed" not in text
    read = ggo.load_walk(path)
    assert (read.gaits[0].paced, read.landing_speed) == (None, None)


def test_gait_file_round_trip(walk, tmp_path):
    path, gait = tmp_path / "gait.csv", walk.gaits[0]
    gait.save(path)
    text = path.read_text()
    assert text.startswith("# ggo-gait 2\n")
    read = ggo.load_gait(path)
    np.testing.assert_allclose(read.times, gait.times, atol=1e-12, rtol=0.0)
    np.testing.assert_allclose(read.frames, gait.frames, atol=1e-12, rtol=0.0)
    read.save(tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == text


def rows_of(text):
    """Numbers of the lines with frames."""
    lines = text.splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith(("step,", "t_s,"))) + 1
    return lines, first


def with_time(text, row, change):
    """The file with another time in a row, its column found by its name."""
    lines, first = rows_of(text)
    column = lines[first - 1].split(",").index("t_s")
    cells = lines[first + row].split(",")
    cells[column] = change(cells[column])
    lines[first + row] = ",".join(cells)
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("kind", ["gait", "walk"])
@pytest.mark.parametrize(
    ("row", "change", "message"),
    [
        (7, lambda cell: "0.0", "times|t_s is 0, expected more"),
        (7, lambda cell: "-1", "times|t_s is -1, expected more"),
        (7, lambda cell: "nan", "line"),
        (7, lambda cell: "soon", "line"),
        (0, lambda cell: "0.25", "t_s is 0.25|times"),
    ],
)
def test_damaged_times(walk, tmp_path, kind, row, change, message):
    path = tmp_path / "file.csv"
    (walk.gaits[0] if kind == "gait" else walk).save(path)
    path.write_text(with_time(path.read_text(), row, change))
    for edited in (False, True):
        with pytest.raises(ggo.InputError, match=rf"file\.csv.*({message})"):
            (ggo.load_gait if kind == "gait" else ggo.load_walk)(path, edited=edited)


@pytest.mark.parametrize("kind", ["gait", "walk"])
def test_a_time_that_was_changed_is_told(walk, tmp_path, kind):
    path = tmp_path / "file.csv"
    (walk.gaits[0] if kind == "gait" else walk).save(path)
    path.write_text(with_time(path.read_text(), 7, lambda cell: f"{float(cell) + 1e-3:.6f}"))
    load = ggo.load_gait if kind == "gait" else ggo.load_walk
    with pytest.raises(ggo.InputError, match=r"file\.csv"):
        load(path)
    assert load(path, edited=True)


def test_a_step_that_does_not_begin_where_the_one_before_ended(walk, tmp_path):
    path = tmp_path / "walk.csv"
    walk.save(path)
    path.write_text(with_time(path.read_text(), len(walk.gaits[0]), lambda cell: f"{float(cell) + 0.01:.6f}"))
    _, first = rows_of(path.read_text())
    with pytest.raises(ggo.InputError, match=rf"walk\.csv, line {first + len(walk.gaits[0]) + 1}: t_s is"):
        ggo.load_walk(path, edited=True)


@pytest.mark.parametrize(
    "paced", [np.arange(51) * 0.01 + 0.1, np.arange(51) * -0.01, np.zeros(51), np.arange(50) * 0.01]
)
def test_times_are_checked_when_made(paced):
    with pytest.raises(ggo.InputError, match="paced"):
        replace(BASE, paced=paced)


# -- what a controller plays -------------------------------------------------------------------------------------


@pytest.mark.parametrize("rate", [100.0, 333.0, 1000.0])
def test_at_a_controllers_rate(walk, rate):
    whole, played = walk.joint_trajectory(rate=rate), walk.joint_trajectory()
    np.testing.assert_allclose(np.diff(whole.time)[:-1], 1.0 / rate, rtol=1e-9)
    assert whole.time[-1] == played.time[-1] == pytest.approx(walk.times[-1])
    assert (np.abs(whole.velocities).max(axis=0) <= TIGHT.speed[[0, 1, 0, 1]]).all()
    assert (np.abs(whole.accelerations).max(axis=0) <= TIGHT.acceleration[[0, 1, 0, 1]]).all()
    assert not whole.velocities[[0, -1]].any()
    if rate == 1000.0:
        # Velocities are those of the positions: their central differences miss them by a third derivative at most.
        central = (whole.positions[2:-1] - whole.positions[:-3]) * rate / 2.0
        np.testing.assert_allclose(whole.velocities[1:-2], central, atol=2e-3 * np.abs(central).max())


def test_the_trajectory_at_the_frames_has_their_times(walk):
    trajectory = walk.joint_trajectory()
    np.testing.assert_allclose(trajectory.time, walk.times, atol=1e-12, rtol=0.0)
    second = walk.gaits[1].frames
    first = len(walk.gaits[0]) - 1
    np.testing.assert_array_equal(trajectory.positions[first : first + len(second)], swap_roles(second))


# -- verify ------------------------------------------------------------------------------------------------------


def test_a_walk_that_is_played_too_fast_is_found(walk):
    assert all(report.ok for report in walk.verify())
    fast = replace(walk, gaits=tuple(replace(gait, paced=None) for gait in walk.gaits), steps=())
    kinds = {violation.kind for report in fast.verify() for violation in report.violations}
    assert any(kind.endswith(("speed", "acceleration")) for kind in kinds - {"landing speed"})
    # By a tenth over all: every speed grows by a tenth, every acceleration by a fifth.
    gaits = tuple(replace(g, paced=g.times / 1.1) for g in walk.gaits)
    kinds = {
        violation.kind for report in replace(walk, gaits=gaits, steps=()).verify() for violation in report.violations
    }
    assert any(kind.endswith(("speed", "acceleration")) for kind in kinds)


def test_a_landing_that_is_too_fast_is_found():
    walk = ggo.descend_stairs(BASE, 0.15, tread=0.29, first_edge=0.19, steps=2, pace="auto")
    assert all(report.ok for report in walk.verify())
    times = walk.gaits[1].times.copy()
    times[-1] -= 0.3 * (times[-1] - times[-2])
    edited = replace(walk, gaits=(walk.gaits[0], replace(walk.gaits[1], paced=times)), steps=())
    first, second = edited.verify()
    assert first.ok
    (fault,) = [fault for fault in second.violations if fault.kind == "landing speed"]
    assert (fault.unit, fault.limit) == ("m/s", walk.landing_speed)
    assert fault.value == pytest.approx(second.landing_speed)
    assert "landing speed" in {v.kind for v in walk.verify(replace(STANDARD, landing_speed=0.5))[1].violations}
    assert not edited.verify(replace(STANDARD, landing_speed=9.0))[1].violations


# -- replans -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def long_walk():
    """Ten steps with two boxes, paced."""
    boxes = {1: BOX, 5: ggo.Obstacle(0.15, 0.20, 0.12)}
    plan = [ggo.Step((0.39, 0.0), (boxes[n],) if n in boxes else ()) for n in range(10)]
    return ggo.walk(BASE, plan, limits=LIMITS)


@pytest.mark.parametrize(
    ("step", "frame", "pace"),
    [
        *((step, frame, pace) for step, frame in ((5, 30), (10, 20)) for pace in (None, "auto")),
        (1, 12, None),
        (6, 5, "auto"),
        # Over the high box nobody comes at the base gait's pace.
        (2, 10, "auto"),
        (2, 25, "auto"),
    ],
)
def test_replans_of_paced_walks(long_walk, step, frame, pace):
    again = ggo.replan(long_walk, step=step, at_frame=frame, foothold=(0.41, 0.0), pace=pace, deadline=5.0)
    for before, after in zip(long_walk.gaits[: step - 1], again.gaits, strict=False):
        np.testing.assert_array_equal(after.frames, before.frames)
        np.testing.assert_array_equal(after.times, before.times)
    before, after = long_walk.gaits[step - 1], again.gaits[step - 1]
    np.testing.assert_array_equal(after.frames[: frame + 1], before.frames[: frame + 1])
    np.testing.assert_array_equal(after.times[: frame + 1], before.times[: frame + 1])
    assert all(report.ok for report in again.verify())
    assert beyond(again, LIMITS) <= 1.0 + STANDARD.limits
    # The speed is what it was, at the frame that the walker is in.
    number = sum(len(gait) - 1 for gait in long_walk.gaits[: step - 1]) + frame
    was, goes = (each.joint_trajectory().played.velocities for each in (long_walk, again))
    assert np.abs(goes[number] - was[number]).max() < 0.01 * np.abs(was).max()


def test_a_paced_walk_is_replanned_by_time(long_walk):
    instant = float(long_walk.gaits[0].duration + long_walk.gaits[1].times[20]) + 1e-4
    again = ggo.replan(long_walk, time=instant, foothold=(0.40, 0.0), pace="auto")
    by_frame = ggo.replan(long_walk, step=2, at_frame=20, foothold=(0.40, 0.0), pace="auto")
    for one, other in zip(again.gaits, by_frame.gaits, strict=True):
        np.testing.assert_array_equal(one.frames, other.frames)


@pytest.mark.parametrize("first_swing", ["right", "left"])
def test_the_leg_that_breaks_a_limit_is_told_whichever_swings_first(first_swing):
    walk = ggo.walk(BASE, [LEVEL_STEP] * 3, limits=LIMITS, first_swing=first_swing)
    tight = ggo.JointLimits(knee_speed=float(np.radians(200.0)))
    kinds = [{(fault.kind, fault.note) for fault in report.violations} for report in walk.verify(limits=tight)]
    assert kinds == [{("knee speed", "swing leg")}] * 3
