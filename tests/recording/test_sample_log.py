"""The sample log: that it is what its tool makes, and that it looks like walking."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import make_sample_log as tool
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from ggo_factors.errors import InputError
from ggo_factors.motion.gait import load_gait
from ggo_factors.motion.paper_gait import paper_base_gait

ROOT = Path(__file__).parents[2]
LOG = ROOT / "datasets" / "children_walk.mcap"


def messages(path: Path) -> list[tuple[int, bytes]]:
    with path.open("rb") as stream:
        return [(m.log_time, m.data) for _, _, m in make_reader(stream, validate_crcs=True).iter_messages()]


@pytest.fixture(scope="module")
def angles() -> dict[str, np.ndarray]:
    """Each logged joint in [rad], and `time` in [s]."""
    with LOG.open("rb") as stream:
        states = [
            d for *_, d in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages([tool.TOPIC])
        ]
    columns = np.array([state.position for state in states]).T
    time = np.array([state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec for state in states])
    assert all(state.name == list(tool.JOINTS) for state in states)
    return {"time": time, **dict(zip(tool.JOINTS, columns, strict=True))}


def test_shipped_log_is_what_the_tool_makes(tmp_path, capsys):
    pytest.importorskip("fdatools")
    for name in ("a.mcap", "b.mcap"):
        assert tool.main(["--out", str(tmp_path / name)]) == 0
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    # Message by message: another release of the compressor may pack the same messages otherwise.
    assert messages(tmp_path / "a.mcap") == messages(LOG)
    said = capsys.readouterr().out
    assert "24 strides a leg" in said
    assert "pelvis tilt -18.12 deg" in said


def test_log_is_small_and_says_where_it_comes_from():
    assert LOG.stat().st_size < 300_000
    with LOG.open("rb") as stream:
        (source,) = make_reader(stream).iter_metadata()
    assert "Olshen" in source.metadata["data"]
    assert "not one person's walk" in source.metadata["note"]
    readme = (ROOT / "datasets" / "README.md").read_text()
    for path in (ROOT / "datasets").iterdir():
        assert path.name == "README.md" or path.name in readme
    assert "Copyright (c) 2026, Hamed Davodi" in readme


def test_rate_is_steady(angles):
    np.testing.assert_allclose(np.diff(angles["time"]), 0.01, atol=1e-6)
    assert len(angles["time"]) > 2000


def test_joints_are_smooth(angles):
    for joint in tool.JOINTS:
        speed = np.degrees(np.diff(angles[joint])) * tool.RATE_HZ
        acceleration = np.diff(speed) * tool.RATE_HZ
        assert np.abs(speed).max() < 800.0
        # A jump of one degree changes the acceleration by 20 000 deg/s^2 from one sample to the next.
        assert np.abs(np.diff(acceleration)).max() < 10_000.0


def test_seams_are_smooth():
    """Between two children whose cycles differ: value, slope and curvature join from either side."""
    generator = np.random.default_rng(1)
    phase = (np.arange(20) + 0.5) / 20
    wave = np.stack([np.sin(2.0 * np.pi * phase), np.cos(2.0 * np.pi * phase)], -1)
    samples = np.radians(wave[:, None] * generator.uniform(10.0, 30.0, (1, 3, 2)) + generator.uniform(0, 9, (1, 3, 2)))
    spline = tool.CubicSpline(np.append(phase, phase[0] + 1.0), np.concatenate([samples, samples[:1]]), axis=0,
                              bc_type="periodic")  # fmt: skip
    cycles = tool.Cycles(spline, np.zeros(3))
    step = 1e-4
    fine = tool.stitched(cycles, [0, 1, 2], np.arange(-0.5, 3.5, step))
    assert np.abs(np.diff(fine, axis=0)).max() / step < 6.0
    assert np.abs(np.diff(fine, 2, axis=0)).max() / step**2 < 100.0
    assert np.abs(np.diff(fine, 3, axis=0)).max() / step**3 < 1e4


def test_legs_walk_alike_half_a_cycle_apart(angles):
    for joint in ("hip_flexion", "knee_flexion"):
        left, right = angles[f"left_{joint}"], angles[f"right_{joint}"]
        lags = np.arange(20, 80)
        match = [np.corrcoef(left[lag:], right[: len(right) - lag])[0, 1] for lag in lags]
        assert abs(lags[np.argmax(match)] - 100.0 * tool.STRIDE_S / 2.0) <= 1.0
        assert max(match) > 0.98


def test_both_feet_stand_on_the_ground_at_the_ends_of_the_mean_step(angles):
    hip = {side: angles[f"{side}_hip_flexion"] + angles["pelvis_tilt"] for side in ("left", "right")}
    knee = {side: angles[f"{side}_knee_flexion"] for side in ("left", "right")}
    # Ankle from hip in parts of a segment's length: forward, and up.
    ahead = {side: np.sin(hip[side]) + np.sin(hip[side] - knee[side]) for side in hip}
    up = {side: -np.cos(hip[side]) - np.cos(hip[side] - knee[side]) for side in hip}
    strikes = {side: heel_strikes(ahead[side]) for side in hip}
    assert all(len(strikes[side]) >= 24 for side in hip)
    for front, back in (("left", "right"), ("right", "left")):
        rows = strikes[front]
        difference = 0.39 * (up[front][rows] - up[back][rows])
        assert abs(difference.mean()) < 0.01
    alpha = np.degrees(np.concatenate([hip["left"], hip["right"]]))
    assert -25.0 < alpha.min() < -16.0
    assert 31.0 < alpha.max() < 43.0
    assert min(knee["left"].min(), knee["right"].min()) > np.radians(-0.3)


def heel_strikes(ahead: np.ndarray) -> np.ndarray:
    """Rows in which the ankle is furthest ahead within 0.3 s on either side."""
    return np.array([k for k in range(30, len(ahead) - 30) if ahead[k] == ahead[k - 30 : k + 31].max()])


def test_joint_map_names_what_is_logged():
    given = tomllib.loads((ROOT / "datasets" / "children_walk.toml").read_text())
    assert given.pop("units") == "rad"
    assert sorted(given) == ["alpha_left", "alpha_right", "beta_left", "beta_right"]
    assert {joint for terms in given.values() for joint in terms} == set(tool.JOINTS)


def test_without_fdatools_the_tool_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "fdatools.datasets", None)
    assert tool.main(["--out", str(tmp_path / "x.mcap")]) == 2
    assert "pip install fdatools" in capsys.readouterr().err
    with pytest.raises(InputError):
        tool.measured_cycles()
    assert list(tmp_path.iterdir()) == []


def test_an_unwritable_place_is_one_line(tmp_path, capsys):
    pytest.importorskip("fdatools")
    assert tool.main(["--out", str(tmp_path / "no" / "x.mcap")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "cannot be written" in said


def test_shipped_base_gait_is_the_papers():
    shipped, paper = load_gait(ROOT / "datasets" / "paper_base_gait.csv"), paper_base_gait()
    np.testing.assert_allclose(shipped.frames, paper.frames, atol=1e-13)
    assert (shipped.dt, shipped.name, shipped.origin, shipped.model) == (
        paper.dt,
        paper.name,
        paper.origin,
        paper.model,
    )
