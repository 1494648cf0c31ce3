"""From a log to a base gait: what comes out of the recordings, what is refused, and what the report says."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from test_cut_strides import _CYCLE, DOWN, periodic, walk
from test_signals import MAP, NAMES, log_of

from ggo_factors.errors import InputError, LogError
from ggo_factors.motion.gait import PAPER_MODEL, load_gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.base_gait import import_base_gait
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.recording.sources import open_log

LEVEL = {
    "level_csic_s10": 3,
    "level_nonan_middle": 3,
    "level_opensim_rajagopal": 1,
    "level_opensim_subject01": 1,
}


def facts_of(folder, name):
    return json.loads((folder / f"{name}.json").read_text())


def map_of(facts):
    """The joint map that a recording's description states, in either of its two forms."""
    if "joint_map" in facts:
        return JointMap(facts["joint_map"], facts["units"])
    terms = {}
    for joint, name in facts["names"].items():
        side, kind = joint.split("_")
        if isinstance(facts["topic"], dict):
            name = f"{facts['topic'][joint]}:data"
        elif isinstance(name, int):
            name = f"data[{name}]"
        terms[f"{'alpha' if kind == 'hip' else 'beta'}_{side}"] = {name: facts["sign"][joint]}
    return JointMap(terms, facts["unit"])


def import_log(folder, name, **options):
    facts = facts_of(folder, name)
    return import_base_gait(folder / f"{name}.mcap", joints=map_of(facts), **options)


@pytest.fixture
def logged():
    """Import a made log as if it had been read from a file."""

    def run(times, values, joints=MAP, log_unit="rad", **options):
        return import_base_gait(log_of(times, values, log_unit), joints=joints, **options)

    return run


@pytest.mark.parametrize(("name", "min_strides"), LEVEL.items())
def test_level_walks_have_their_strides(recordings, name, min_strides):
    facts = facts_of(recordings, name)
    report = import_log(recordings, name, min_strides=min_strides)
    low, high = facts["strides_per_leg"]
    assert all(low <= count <= high for count in report.strides_used.values()), report.strides_used
    assert report.stride_time[0] == pytest.approx(facts["stride_time_s"], abs=0.02)
    gait = report.gait
    assert len(gait) == 51
    assert gait.model == PAPER_MODEL
    assert any("paper's" in line for line in report.decisions)
    np.testing.assert_allclose(gait.frames[-1], gait.frames[0][[2, 3, 0, 1]], atol=1e-12)
    path = gait.endpoints()
    np.testing.assert_allclose(path[[0, -1], 1], 0.0, atol=1e-9)
    assert path[:, 1].min() > -1e-3
    assert 0.10 < path[:, 1].max() < 0.25
    assert 0.8 < gait.stride() < 1.3
    assert np.degrees(gait.frames[:, 3].max()) > 50.0
    assert report.violations == ()
    assert 0.0 < report.correction_deg < 8.0
    assert 0.5 < report.symmetry["gait_rms_deg"] < 8.0
    assert 2.0 * gait.duration == pytest.approx(report.stride_time[0])


@pytest.mark.parametrize("name", LEVEL)
def test_left_and_right_exchanged_give_the_same_gait(recordings, name):
    joints = map_of(facts_of(recordings, name))
    other = {"right": "left", "left": "right"}
    swapped = replace(
        joints, terms={f"{a.split('_')[0]}_{other[a.split('_')[1]]}": row for a, row in joints.terms.items()}
    )
    one, two = (
        import_base_gait(recordings / f"{name}.mcap", joints=chosen, min_strides=1) for chosen in (joints, swapped)
    )
    np.testing.assert_allclose(one.gait.frames, two.gait.frames, atol=1e-9, rtol=0.0)
    assert one.gait.dt == pytest.approx(two.gait.dt, abs=1e-12)
    assert one.strides_used == {other[leg]: count for leg, count in two.strides_used.items()}
    assert one.symmetry["gait_rms_deg"] == pytest.approx(two.symmetry["gait_rms_deg"])


def test_fewer_strides_than_wanted_name_the_option(recordings):
    with pytest.raises(LogError, match=r"1 right and 1 left.*3 a leg needed.*min_strides=1"):
        import_log(recordings, "level_opensim_subject01")


def test_one_leg_missing_is_refused(recordings):
    with pytest.raises(LogError, match=r"left knee \(knee_angle_l\).*not tracked.*one leg is missing"):
        import_log(recordings, "refuse_one_knee_missing", min_strides=1)


def test_running_is_refused(recordings):
    with pytest.raises(LogError, match="running, not walking"):
        import_log(recordings, "refuse_running", min_strides=1)


def test_stairs(recordings):
    facts = facts_of(recordings, "stairs_wpi_s04_riser173")
    legs = LegModel(facts["thigh_m"], facts["shank_m"])
    for model in (None, legs):
        report = import_log(recordings, "stairs_wpi_s04_riser173", activity="stairs-up", model=model)
        assert [swing.leg for swing in report.used] == ["right", "left", "right"]
        assert report.riser == pytest.approx(facts["riser_m"], abs=0.015)
        assert facts["tread_m"][0] - 0.02 < report.tread < facts["tread_m"][1] + 0.02
        ends = report.gait.endpoints()[[0, -1]]
        np.testing.assert_allclose(ends[:, 1], [-report.riser, report.riser], atol=1e-9)
        np.testing.assert_allclose(ends[:, 0], [-report.tread, report.tread], atol=1e-9)
    with pytest.raises(LogError, match=r"3 swings of activity='stairs-up'"):
        import_log(recordings, "stairs_wpi_s04_riser173")
    with pytest.raises(LogError, match=r"found 0 swings on stairs down.*stairs-up"):
        import_log(recordings, "stairs_wpi_s04_riser173", activity="stairs-down")


def logs_that_expect(folder, *expected):
    for sub in ("formats", "hostile"):
        for path in sorted((folder / sub).glob("*.json")):
            facts = json.loads(path.read_text())
            if facts["expect"] in expected and "mean_cycle_deg" in facts:
                yield f"{sub}/{path.stem}", facts


def rms_after_shift(cycle, truth):
    """RMS of the worse joint after the best circular shift, in degrees; both (100, 2)."""
    fine = np.linspace(0.0, 1.0, 400, endpoint=False)
    spread = [
        np.stack([np.interp(fine, np.arange(len(c) + 1) / len(c), np.append(c[:, k], c[0, k])) for k in (0, 1)], -1)
        for c in (cycle, truth)
    ]
    return min(float(np.sqrt(((np.roll(spread[0], k, 0) - spread[1]) ** 2).mean(0)).max()) for k in range(400))


# The reader's part is tested with the reader: here what is left of its log must make the right cycle.
def test_all_formats_and_damaged_logs(recordings):
    offsets = {}
    count = 0
    for name, facts in logs_that_expect(recordings, "ok", "partial"):
        report = import_log(recordings, name)
        limit = {"hostile/h_duplicate_times": 0.8, "hostile/h_nan_inf": 1.5}.get(name, 0.5)
        for leg in ("right", "left"):
            truth = np.stack([facts["mean_cycle_deg"][f"{leg}_{joint}"][:100] for joint in ("hip", "knee")], -1)
            off = rms_after_shift(np.degrees(report.mean_cycle[leg]), truth)
            assert off < limit, f"{name}, {leg}: {off:.2f} degrees RMS"
        if name == "hostile/h_stamp_drift":
            assert any("1.5" in note for note in report.notes)
            continue
        distance = []
        for leg in ("right", "left"):
            marks = np.array(facts["heel_strikes_s"][leg])
            for time in report.heel_strikes[leg]:
                nearest = time - marks[np.argmin(np.abs(marks - time))]
                distance += [nearest] if abs(nearest) < 0.3 else []
        offsets[name] = float(np.median(distance))
        assert np.median(np.abs(distance - np.median(distance))) < 0.015, name
        count += 1
    assert count > 20
    assert max(offsets.values()) - min(offsets.values()) < 0.010, offsets


def test_what_the_user_must_choose_is_asked_for(recordings):
    def refused(name, **options):
        with pytest.raises(LogError) as error:
            import_base_gait(recordings / f"{name}.mcap", **options)
        assert "\n" not in str(error.value)
        return str(error.value)

    assert "joints='direct'" in refused("formats/ros2_jointstate")
    assert "joints='opensim'" in refused("formats/names_opensim")
    assert "m1, m2, m3, m4" in refused("formats/names_unknown")
    assert "data[0]" in refused("formats/float64multiarray")
    assert "unit='deg'" in refused("formats/degrees", joints="direct")
    assert "unit='rad' or unit='deg'" in refused("formats/json_nested_degrees", joints="direct")
    assert "-knee-negative" in refused("formats/signs_knee_negative", joints="direct")
    assert "/exo/state/joints" in refused("hostile/h_topic_elsewhere", joints="direct", topic="/joint_states")
    assert "beta_right" in refused("hostile/h_missing_joint", joints="direct")
    assert "left_knee_joint has no value" in refused("hostile/h_all_nan_knee", joints="direct")
    assert "it holds no walking" in refused("formats/standing_only", joints="direct")
    assert "min_strides=1" in refused("formats/two_strides", joints="direct")


def test_presets_on_recordings(recordings):
    chosen = {
        "formats/degrees": {"joints": "direct", "unit": "deg"},
        "formats/signs_knee_negative": {"joints": "direct-knee-negative"},
        "formats/names_opensim": {"joints": "opensim"},
        "level_opensim_subject01": {"joints": "opensim-knee-negative", "min_strides": 1},
        "level_nonan_middle": {"joints": "segment-pitch"},
    }
    for name, options in chosen.items():
        by_preset = import_base_gait(recordings / f"{name}.mcap", **options)
        by_map = import_log(recordings, name, min_strides=options.get("min_strides", 3))
        np.testing.assert_allclose(by_preset.gait.frames, by_map.gait.frames, atol=1e-12)


def test_report_as_text_and_json(logged, tmp_path):
    times, values, _ = walk(10)
    values[500, 1] += 2.0
    values[(times > 6.0) & (times < 6.6), 3] = np.nan
    report = logged(times, values)
    text = report.text()
    for word in ("strides", "steps/min", "spikes: knee_r 1", "data missing", "degrees RMS", "6 Hz", "starting"):
        assert word in text
    data = json.loads(report.to_json())
    assert data["format_version"] == 1
    assert data["strides_used"] == report.strides_used
    assert len(data["mean_cycle_deg"]["right"]) == 100
    assert all(re.search(r"\w", item["reason"]) for item in data["refused"])
    assert data["cadence_steps_per_min"] == pytest.approx(120.0 / 1.1, rel=0.02)
    np.testing.assert_allclose(np.radians(data["gait"]["frames_deg"]), report.gait.frames)
    report.gait.save(tmp_path / "base.csv")
    again = load_gait(tmp_path / "base.csv")
    np.testing.assert_allclose(again.frames, report.gait.frames, atol=1e-13)
    assert again.model == PAPER_MODEL
    assert "x.mcap" in again.origin


def test_the_mean_cycle_of_a_made_walk_is_the_one_it_was_made_of(logged):
    report = logged(*walk(12)[:2])
    made = np.degrees(_CYCLE(np.linspace(0.0, 1.0, 100, endpoint=False)))
    for leg in ("right", "left"):
        assert rms_after_shift(np.degrees(report.mean_cycle[leg]), made) < 0.4


def test_frames_and_legs_as_asked_for(logged):
    times, values, _ = walk(8)
    legs = LegModel(0.44, 0.41)
    report = logged(times, values, model=legs, frames=81)
    assert len(report.gait) == 81
    assert report.gait.model == legs
    assert not any("paper's" in line for line in report.decisions)
    coarse = logged(times, values, model=legs, frames=41)
    np.testing.assert_allclose(report.gait.frames[::2], coarse.gait.frames, atol=2e-3)


def test_an_offset_between_the_legs_is_noted_and_halved(logged):
    times, values, _ = walk(10)
    plain = logged(times, values)
    report = logged(times, values + np.radians([0.0, 8.0, 0.0, 0.0]))
    assert report.symmetry["knee_offset_deg"] == pytest.approx(8.0, abs=0.3)
    assert any("right knee is 8.0 degrees more flexed" in note for note in report.notes)
    lifted = np.degrees(report.gait.frames - plain.gait.frames)[:, [1, 3]].mean()
    assert 2.0 < lifted < 6.0


def test_units_of_the_map_and_of_the_call(logged):
    times, values, _ = walk(8)
    report = logged(times, values)
    for options in (
        {"unit": "deg"},
        {"joints": JointMap(MAP.terms, "deg")},
        {"unit": "deg", "log_unit": None},
    ):
        np.testing.assert_allclose(
            logged(times, np.degrees(values), **options).gait.frames, report.gait.frames, atol=1e-9
        )


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"frames": 2}, "frames: 2"),
        ({"frames": 10.5}, "frames"),
        ({"min_strides": 0}, "min_strides"),
        ({"activity": "hopping"}, "stairs-down"),
        ({"unit": "turns"}, "'rad' or 'deg'"),
    ],
)
def test_wrong_arguments(logged, options, word):
    times, values, _ = walk(6)
    with pytest.raises(InputError, match=word):
        logged(times, values, **options)


def test_the_wanted_values_are_named_to_the_reader(monkeypatch):
    times, values, _ = walk(6)
    asked = []

    def read(path, topic=None, names=None, progress=None, **_):
        asked.append((topic, names))
        return log_of(times, values)

    monkeypatch.setattr(open_log, "read_log", read)
    import_base_gait("x.mcap", topic="/joints", joints=MAP)
    assert asked == [("/joints", NAMES)]


def damaged(values, rng):
    """Values with the damage that logs have: NaN, holes, glitches, a sensor that sticks, one absurd number."""
    values = values.copy()
    n = len(values)
    for _ in range(rng.integers(1, 5)):
        start, joint = rng.integers(0, n - 200), rng.integers(0, 4)
        kind = rng.integers(0, 5)
        if kind == 0:
            values[rng.random(values.shape) < 0.03] = np.nan
        elif kind == 1:
            values[start : start + rng.integers(2, 120), joint] = np.nan
        elif kind == 2:
            values[rng.random(n) < 0.01, joint] += rng.choice([-2.5, 0.6, 2.5])
        elif kind == 3:
            values[start : start + rng.integers(60, 200), joint] = values[start, joint]
        else:
            values[start, joint] = rng.choice([7e307, -1e9, np.inf])
    return values


@pytest.mark.parametrize("seed", range(24))
def test_damage_does_not_bend_the_gait(logged, seed):
    times, values, _ = walk(12)
    whole = logged(times, values)
    rng = np.random.default_rng(seed)
    report = logged(times, damaged(values, rng))
    off = np.degrees(report.gait.frames - whole.gait.frames)
    assert np.sqrt((off**2).mean()) < 0.7
    assert report.signal_counts


@pytest.mark.parametrize("seed", range(24))
def test_garbage_is_refused_and_nothing_else_is_raised(logged, seed):
    rng = np.random.default_rng(seed)
    times, values, _ = walk(int(rng.integers(1, 8)), period=rng.uniform(0.2, 4.0), stand=rng.uniform(0.0, 2.0))
    start, end = np.sort(rng.integers(0, len(times), 2))
    joint = rng.integers(0, 4)
    values = values.copy()
    match seed % 8:
        case 0:
            values[:] = rng.normal(0.0, 1.0, values.shape)
        case 1:
            values[:, joint] *= rng.uniform(-3.0, 3.0)
        case 2:
            values[start:end] = np.nan
        case 3:
            values[start:end, joint] = values[start, joint]
        case 4:
            values[:] = 0.1
        case 5:
            values[rng.random(values.shape) < 0.4] = rng.choice([np.nan, np.inf, 50.0])
        case 6:
            values = values[rng.permutation(len(values))]
        case _:
            keep = np.sort(rng.choice(len(times), min(len(times), int(rng.integers(2, 60))), replace=False))
            times, values = times[keep], values[keep]
    try:
        report = logged(times, values, min_strides=1, activity=str(rng.choice(["level", "stairs-up"])))
    except LogError as error:
        lines = str(error).splitlines()
    else:
        lines = ["fine"]
        assert np.isfinite(report.gait.frames).all()
        json.loads(report.to_json())
    assert len(lines) == 1


def test_a_drifting_sensor_is_noted(logged):
    times, values, _ = walk(12)
    plain = logged(times, values)
    assert not any("drifts" in note for note in plain.notes)
    values[:, 2] += np.radians(12.0) * times / times[-1]
    notes = [note for note in logged(times, values).notes if "drifts" in note]
    assert len(notes) == 1
    assert "left thigh drifts by +" in notes[0]


def test_a_way_down_stairs(logged):
    times = np.arange(1500) * 0.01
    report = logged(times, periodic(DOWN, times), activity="stairs-down")
    assert len(report.used) >= 10
    assert report.riser > 0.1
    assert any("upper bound" in note for note in report.notes)
    ends = report.gait.endpoints()[[0, -1]]
    np.testing.assert_allclose(ends[:, 1], [report.riser, -report.riser], atol=1e-9)
    np.testing.assert_allclose(report.gait.frames[-1], report.gait.frames[0][[2, 3, 0, 1]], atol=1e-12)
