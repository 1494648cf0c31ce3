"""Gait: the paper's base gait, immutability, resampling, and its file."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import CubicSpline

import ggo_factors as ggo

BASE = ggo.paper_base_gait()


def test_paper_base_gait_by_its_equation():
    assert len(BASE) == 51
    assert BASE.dt == pytest.approx(0.01)
    t = 0.89 + 0.2
    swing_knee = 22.70 + 23.69 * math.sin(2 * math.pi * t + 1.02) + 18.54 * math.sin(4 * math.pi * t + 0.41)
    support_hip = 7.52 + 12.94 * math.sin(2 * math.pi * (t + 0.5) - 0.29) + 4.78 * math.sin(4 * math.pi * t - 0.64)
    assert np.degrees(BASE.frames[20, 3]) == pytest.approx(swing_knee)
    assert np.degrees(BASE.frames[20, 0]) == pytest.approx(support_hip)
    # The paper says 0.78 m.
    assert BASE.stride() == pytest.approx(0.78, abs=0.003)


def test_last_frame_is_the_first_with_roles_swapped():
    np.testing.assert_allclose(BASE.swapped().frames[-1], BASE.frames[0], atol=1e-12)


def test_without_endpoint_the_next_step_would_follow():
    gait = ggo.paper_base_gait(frames=50, endpoint=False)
    assert gait.dt == pytest.approx(0.01)
    np.testing.assert_allclose(gait.frames, BASE.frames[:-1], atol=1e-12)


def test_gait_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        BASE.frames[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        BASE.dt = 1.0
    mine = np.zeros((3, 4))
    gait = ggo.Gait(mine, 0.1)
    mine[:] = 1.0
    assert (gait.frames == 0.0).all()


def test_resampling_keeps_ends_and_shape():
    finer = BASE.resampled(201)
    assert finer.duration == pytest.approx(BASE.duration)
    np.testing.assert_allclose(finer.frames[::4], BASE.frames, atol=1e-12)
    np.testing.assert_allclose(finer.frames, ggo.paper_base_gait(201).frames, atol=1e-5)
    assert BASE.resampled(51) is BASE


def over_the_swap(gait):
    """Each joint's largest acceleration in [deg/s^2] by second differences over two steps on end, shape (4,)."""
    frames = np.concatenate([gait.frames, gait.swapped().frames[1:], gait.frames[1:2]])
    return np.degrees(np.abs(np.diff(frames, 2, axis=0)).max(axis=0)) / gait.dt**2


@pytest.mark.parametrize("count", [101, 401])
def test_a_periodic_gait_stays_periodic(count):
    # Closed in its angles, with a corner in its speeds at the change of legs, as recorded gaits have. A spline of one
    # step alone keeps the corner, and the finer the frames the larger the acceleration.
    bend = np.outer(np.sin(np.linspace(0.0, np.pi, 51)), [0.1, -0.2, 0.1, -0.2])
    rough = dataclasses.replace(BASE, frames=BASE.frames + bend)
    finer = rough.resampled(count)
    np.testing.assert_allclose(finer.frames[:: (count - 1) // 50], rough.frames, atol=1e-12)
    np.testing.assert_allclose(finer.swapped().frames[-1], finer.frames[0], atol=1e-12)
    # A spline rounds a corner with sqrt(3) times the second difference of its knots.
    assert (over_the_swap(finer) < 1.76 * over_the_swap(rough)).all()
    alone = dataclasses.replace(finer, frames=CubicSpline(rough.times, rough.frames)(finer.times))
    assert (over_the_swap(alone) > count / 51 * 0.9 * over_the_swap(rough)).any()
    cycle = np.concatenate([rough.frames, rough.swapped().frames[1:-1], rough.frames[:1]])
    same = CubicSpline(np.linspace(0.0, 2.0 * rough.duration, 101), cycle, bc_type="periodic")
    np.testing.assert_allclose(finer.frames, same(finer.times), atol=1e-12)


def test_a_gait_that_is_not_periodic_is_a_spline_of_its_own():
    part = dataclasses.replace(BASE, frames=BASE.frames[:41])
    finer = part.resampled(81)
    np.testing.assert_allclose(finer.frames, CubicSpline(part.times, part.frames)(finer.times), atol=1e-12)


@pytest.mark.parametrize("frames", [2, 3, 4])
def test_few_frames_of_a_periodic_gait(frames):
    coarse = ggo.paper_base_gait(frames)
    finer = coarse.resampled(6 * (frames - 1) + 1)
    np.testing.assert_allclose(finer.frames[::6], coarse.frames, atol=1e-12)


@pytest.mark.parametrize(
    ("frames", "dt"),
    [
        (BASE.frames, 0.002),
        (ggo.paper_base_gait(501).frames, 2e-4),
        (ggo.paper_base_gait(5001).frames, 2e-4),
        (BASE.frames[-3:], 0.01),
        (ggo.paper_base_gait(5001).frames[-9:], 1e-4),
        (BASE.frames, 1.2),
        (np.tile(BASE.frames, (200, 1)), 0.01),
    ],
    ids=["quick", "quick at 501", "5001 of 1 s", "its end", "its end at 5001", "60 s", "200 steps joined"],
)
def test_time_that_a_step_or_a_part_of_it_may_take(frames, dt):
    assert ggo.Gait(frames, dt).duration == pytest.approx((len(frames) - 1) * dt)


@pytest.mark.parametrize(
    ("frames", "dt", "message"),
    [
        (BASE.frames, 1e-4, r"dt: 0\.0001 s makes 51 frames last 0\.005 s, with a joint that turns by 6\d degrees"),
        (BASE.frames, 0.0009, r"a step takes 0\.1 to 60 s"),
        (ggo.paper_base_gait(5001).frames, 5e-6, r"last 0\.025 s"),
        (BASE.frames, 10.0, r"dt: 10 s makes 51 frames last 500 s"),
        (BASE.frames, 1.21, r"last 60\.5 s"),
    ],
)
def test_dt_that_no_step_has_is_refused(frames, dt, message):
    with pytest.raises(ggo.InputError, match=message):
        ggo.Gait(frames, dt)


@pytest.mark.parametrize(
    ("frames", "dt", "message"),
    [
        (np.zeros((3, 3)), 0.01, r"frames: expected shape \(m, 4\), got \(3, 3\)"),
        (np.zeros((1, 4)), 0.01, "at least 2 frames, got 1"),
        (np.full((3, 4), np.nan), 0.01, r"frames: value nan at \[0, 0\] is not finite"),
        (np.full((3, 4), 30.0), 0.01, "looks like degrees"),
        (np.zeros((3, 4)), 0.0, r"dt: 0 s must be above 0"),
        (np.zeros((3, 4)), math.inf, "dt: inf s is not finite"),
        ("walk", 0.01, "frames: expected numbers"),
    ],
)
def test_gait_is_checked_when_made(frames, dt, message):
    with pytest.raises(ggo.InputError, match=message):
        ggo.Gait(frames, dt)


@settings(max_examples=30)
@given(
    frames=arrays(float, st.tuples(st.integers(2, 6), st.just(4)), elements=st.floats(-6.28, 6.28)),
    dt=st.floats(0.1, 1.0),
    name=st.text("ab:# ,1", max_size=8).map(str.strip),
    thigh=st.floats(0.1, 1.0),
)
def test_file_round_trip(tmp_path_factory, frames, dt, name, thigh):
    folder = tmp_path_factory.mktemp("gaits")
    model = ggo.LegModel(thigh, 0.4, foot=ggo.Foot(0.08, 0.05, 0.15))
    ggo.Gait(frames, dt, name, "here", model).save(folder / "a.csv")
    read = ggo.load_gait(folder / "a.csv")
    assert (read.dt, read.name, read.origin, read.model) == (dt, name, "here", model)
    np.testing.assert_allclose(read.frames, frames, atol=1e-13)
    read.save(folder / "b.csv")
    # Exact to the printed digits: a second trip changes nothing.
    assert (folder / "a.csv").read_text() == (folder / "b.csv").read_text()


def test_gait_without_legs_says_so(tmp_path):
    ggo.Gait(BASE.frames, 0.01, "bare").save(tmp_path / "bare.csv")
    with pytest.raises(ggo.InputError, match="'bare' states no leg lengths"):
        ggo.load_gait(tmp_path / "bare.csv").endpoints()


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (1, "# ggo-gait 5", "line 1: expected '# ggo-gait 1' or '# ggo-gait 2' or '# ggo-gait 3' or '# ggo-gait 4'"),
        (1, "# ggo-gait 2", "expected the columns t_s,alpha1_deg"),
        (2, "# dt: fast", "header 'dt' is 'fast', not a finite number"),
        (2, "# dt: 10 ms", "header 'dt' is in 'ms', expected 's'"),
        (2, "# dt: -0.01 s", r"dt: -0\.01 s must be above 0"),
        (3, "# units", "line 3: expected '# key: value', found '# units'"),
        (3, "# units: rad", "header 'units' is 'rad'"),
        (6, "# thigh: 0 m", "header: thigh"),
        (7, "", "line 7: expected the columns"),
        (13, "alpha1_deg,beta1_deg,alpha2_deg", "line 13: expected the columns"),
        (20, "1,2,3", "line 20: expected 4 values, found 3"),
        (20, "1,2,x,4", "line 20: alpha2_deg is 'x', not a finite number"),
        (20, "1,2,nan,4", "line 20: alpha2_deg is 'nan'"),
        (21, "1,400,3,4", "line 21: beta1_deg is 400, not below 360 degrees"),
        (22, "", "line 22: the line is empty"),
    ],
)
def test_damaged_file_names_the_line(tmp_path, line, text, message):
    path = tmp_path / "gait.csv"
    BASE.save(path)
    lines = path.read_text().splitlines()
    lines[line - 1] = text
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(ggo.InputError, match=message) as caught:
        ggo.load_gait(path)
    assert "gait.csv" in str(caught.value)


@pytest.mark.parametrize(("keep", "message"), [(40, "25 frames, its header says 51"), (0.999, "has no end")])
def test_a_cut_file_is_refused(tmp_path, keep, message):
    path = tmp_path / "gait.csv"
    BASE.save(path)
    text = path.read_text()
    path.write_text("".join(text.splitlines(keepends=True)[:keep]) if keep > 1 else text[: int(len(text) * keep)])
    with pytest.raises(ggo.InputError, match=message):
        ggo.load_gait(path)


def test_a_file_made_by_hand_needs_no_count(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("# ggo-gait 1\n# dt: 0.5\nalpha1_deg,beta1_deg,alpha2_deg,beta2_deg\n0,0,0,0\n1,2,3,4")
    assert np.degrees(ggo.load_gait(path).frames[1]) == pytest.approx([1, 2, 3, 4])


def test_nothing_half_written(tmp_path):
    (tmp_path / "folder").mkdir()
    with pytest.raises(ggo.InputError, match="folder"):
        BASE.save(tmp_path / "folder")
    with pytest.raises(ggo.InputError, match="missing"):
        BASE.save(tmp_path / "missing" / "gait.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]
