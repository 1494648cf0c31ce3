"""Exports in a robot's own joints: read back through the same map they give the same gait, by whichever reader."""

from __future__ import annotations

import json
import math

import numpy as np
import pandas as pd
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import ggo_factors as ggo
from ggo_factors.cli.ggo import main
from ggo_factors.recording.log.joint_map import load_joint_map
from ggo_factors.recording.sources.open_log import open_log

# Maps in degrees are told, see `test_degrees_for_ros_are_written_with_a_warning`.
pytestmark = pytest.mark.filterwarnings("ignore:positions are in degrees")

MAPS = {
    "signs and order": """
order = ["kl", "hl", "kr", "hr"]
[alpha_right]
hr = -1.0
[beta_right]
kr = -1.0
[alpha_left]
hl = 1.0
[beta_left]
kl = 2.0
""",
    "degrees, offsets, a pelvis and ankles": """
units = "deg"
[alpha_right]
"right/hip" = 1.0
pelvis = -1.0
[beta_right]
"right/knee" = -1.0
[alpha_left]
"left/hip" = 1.0
pelvis = -1.0
[beta_left]
"left/knee" = 1.0
[offsets]
"right/hip" = 12.5
"left/knee" = -3.0
pelvis = 1.0
[fixed]
pelvis = 6.0
right_ankle = 2.0
left_ankle = 2.0
""",
    "knees as segments": """
[alpha_right]
thigh_r = 1.0
[beta_right]
thigh_r = 1.0
shank_r = -1.0
[alpha_left]
thigh_l = 1.0
[beta_left]
thigh_l = 1.0
shank_l = -1.0
""",
}


@pytest.fixture(scope="module")
def walk():
    return ggo.climb_stairs(ggo.paper_base_gait(), riser=[0.1, 0.1])


@pytest.fixture(params=list(MAPS))
def mapped(request, tmp_path):
    path = tmp_path / "map.toml"
    path.write_text(MAPS[request.param])
    return path


def angles(names, values, chosen, unit):
    """Left hip, left knee, right hip, right knee in [rad] by a joint map, written out anew."""
    scale = math.pi / 180.0 if unit == "deg" else 1.0
    columns = {name: np.asarray(values)[:, list(names).index(name)] * scale for name in names}
    made = []
    for angle in ("alpha_left", "beta_left", "alpha_right", "beta_right"):
        terms = chosen.terms[angle]
        made.append(sum(factor * (columns[name] - chosen.offsets.get(name, 0.0)) for name, factor in terms.items()))
    return np.stack(made, -1)


def decoded(path, topic):
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [message for _, _, _, message in reader.iter_decoded_messages(topics=[topic])]


@pytest.mark.parametrize("rate", [None, 130.0])
def test_a_log_read_back_through_its_map_holds_the_gait(walk, mapped, rate, tmp_path):
    chosen, out = load_joint_map(mapped), tmp_path / "out.mcap"
    ggo.export_mcap(walk, out, joints=mapped, rate=rate)
    want = walk.joint_trajectory(rate=rate)
    (message,) = decoded(out, "/gait/trajectory")
    assert tuple(message.joint_names) == chosen.order
    unit = chosen.units or "rad"
    np.testing.assert_allclose(
        angles(chosen.order, [p.positions for p in message.points], chosen, unit), want.positions, rtol=0, atol=1e-12
    )
    still = load_joint_map(mapped)
    object.__setattr__(still, "offsets", {})
    for got, rates in (("velocities", want.velocities), ("accelerations", want.accelerations)):
        values = [getattr(point, got) for point in message.points]
        np.testing.assert_allclose(angles(chosen.order, values, still, unit), rates, rtol=0, atol=1e-9)
    states = decoded(out, "/joint_states")
    assert [list(s.position) for s in states] == [list(p.positions) for p in message.points]
    fixed = [chosen.order.index(name) for name in chosen.fixed]
    assert not np.asarray([s.velocity for s in states])[:, fixed].any()
    read = open_log(out, "/joint_states", chosen.names)
    np.testing.assert_allclose(angles(read.names, read.values, chosen, unit), want.positions, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read.times, want.time, rtol=0, atol=1e-9)


def test_rosbags_reads_the_whole_of_it(walk, mapped, tmp_path):
    highlevel = pytest.importorskip("rosbags.highlevel")
    ggo.export_mcap(walk, tmp_path / "out.mcap", joints=mapped, rate=100.0)
    with highlevel.AnyReader([tmp_path / "out.mcap"]) as reader:
        read = [(c.topic, reader.deserialize(data, c.msgtype)) for c, _, data in reader.messages()]
    states = [message for topic, message in read if topic == "/joint_states"]
    (trajectory,) = [message for topic, message in read if topic == "/gait/trajectory"]
    assert len(states) == len(trajectory.points) == len(walk.joint_trajectory(rate=100.0).time)
    assert {len(point.accelerations) for point in trajectory.points} == {len(trajectory.joint_names)}


def test_an_import_through_the_map_gives_the_gait_of_the_plain_export(mapped, tmp_path):
    base = ggo.paper_base_gait()
    walk = ggo.walk(base, [ggo.Step((0.4, 0.0))] * 12)
    plain = {f"{a}_{s}": {f"{s}_{j}": 1.0} for s in ("right", "left") for a, j in (("alpha", "hip"), ("beta", "knee"))}
    made = []
    for name, joints in (("plain", None), ("mapped", mapped)):
        ggo.export_mcap(walk, tmp_path / f"{name}.mcap", joints=joints)
        read = ggo.import_base_gait(
            tmp_path / f"{name}.mcap", joints=joints or ggo.JointMap(plain), topic="/joint_states"
        )
        made.append(read.gait.frames)
    np.testing.assert_allclose(made[1], made[0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("ending", [".csv", ".mot"])
def test_tables_are_read_back(walk, mapped, ending, tmp_path):
    chosen, out = load_joint_map(mapped), tmp_path / f"out{ending}"
    ggo.export_trajectory(walk, out, joints=mapped)
    read, want = open_log(out, None, chosen.names), walk.joint_trajectory()
    unit = chosen.units or "rad"
    if ending == ".mot":
        assert set(read.units.values()) == {unit}
    np.testing.assert_allclose(angles(read.names, read.values, chosen, unit), want.positions, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read.times, want.time, rtol=0, atol=1e-9)


def test_a_mot_has_the_names_of_opensim(walk, tmp_path):
    ggo.export_trajectory(walk, tmp_path / "out.mot", pelvis_tilt=0.1)
    read, want = open_log(tmp_path / "out.mot"), walk.joint_trajectory()
    columns = dict(zip(read.names, np.radians(read.values).T, strict=True))
    np.testing.assert_allclose(columns["pelvis_tilt"], 0.1, atol=1e-12)
    np.testing.assert_allclose(columns["hip_flexion_l"] + 0.1, want.left_hip, atol=1e-12)
    np.testing.assert_allclose(columns["knee_angle_r"], want.right_knee, atol=1e-12)


@pytest.mark.parametrize("ending", [".yaml", ".json"])
def test_a_goal_is_read_by_any_yaml_reader(walk, mapped, ending, tmp_path):
    chosen, out = load_joint_map(mapped), tmp_path / f"goal{ending}"
    ggo.export_trajectory(walk, out, joints=mapped, rate=50.0, ends_moving=True)
    goal = yaml.safe_load(out.read_text())
    if ending == ".json":
        assert json.loads(out.read_text()) == goal
    want, points = walk.joint_trajectory(rate=50.0), goal["trajectory"]["points"]
    assert goal["trajectory"]["joint_names"] == list(chosen.order)
    assert {type(x) for p in points for k in ("positions", "velocities", "accelerations") for x in p[k]} == {float}
    positions = [point["positions"] for point in points]
    made = angles(chosen.order, positions, chosen, chosen.units or "rad")
    np.testing.assert_allclose(made, want.positions, rtol=0, atol=1e-12)
    times = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in points]
    np.testing.assert_allclose(times, want.time, rtol=0, atol=1e-9)


def test_a_goal_that_ends_in_motion_is_refused(walk, tmp_path):
    with pytest.raises(ggo.InputError, match=r"ends_moving: .* moves at .* rad/s at the end"):
        ggo.export_trajectory(walk, tmp_path / "goal.yaml")
    assert list(tmp_path.iterdir()) == []
    standing = ggo.Step(end_frame=tuple(ggo.STANDING.tolist()))
    whole = ggo.walk(ggo.paper_base_gait(), [ggo.Step((0.4, 0.0)), standing], start=ggo.STANDING)
    ggo.export_trajectory(whole, tmp_path / "goal.yaml")
    last = yaml.safe_load((tmp_path / "goal.yaml").read_text())["trajectory"]["points"][-1]
    assert last["velocities"] == [0.0] * 4


def test_a_walk_beyond_its_limits_is_refused(walk, tmp_path):
    from dataclasses import replace

    stiff = replace(walk, limits=ggo.JointLimits(knee_bent=math.radians(40.0)))
    with pytest.raises(ggo.InfeasibleGaitError, match=r"joint limits: .*angle"):
        ggo.export_mcap(stiff, tmp_path / "x.mcap")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (MAPS["signs and order"].replace('"kl", ', ""), "order: expected each of"),
        (
            MAPS["knees as segments"].replace("thigh_r = 1.0", "thigh_r = 1.0\npelvis = 1.0", 1),
            r"put those .* under \[fixed\]",
        ),
        ('units = "rad"' + MAPS["signs and order"] + "[offsets]\nankle = 1.0\n", r"\[offsets\] ankle: no value"),
        ('units = "rad"' + MAPS["signs and order"] + "[fixed]\nhr = 1.0\n", "too few stay free"),
        (MAPS["signs and order"] + "[offsets]\nhr = 12.5\n", r"units: say 'rad' or 'deg', which \[offsets\]"),
        (MAPS["knees as segments"].replace("thigh_r = 1.0\nshank_r = -1.0", "thigh_r = 1.0"), "too few stay free"),
    ],
)
def test_a_map_that_cannot_be_inverted_is_refused(walk, text, words, tmp_path):
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(ggo.InputError, match=words):
        ggo.export_mcap(walk, tmp_path / "x.mcap", joints=tmp_path / "map.toml")


def test_a_preset_is_no_robot(walk, tmp_path):
    with pytest.raises(ggo.InputError, match=r"joints: opensim is a preset .*MAP\.toml"):
        ggo.export_trajectory(walk, tmp_path / "x.csv", joints="opensim")


def test_frames_of_pandas(walk):
    frame, want = walk.to_dataframe(), walk.joint_trajectory()
    assert isinstance(frame, pd.DataFrame)
    assert list(frame.columns) == ["left_hip", "left_knee", "right_hip", "right_knee"]
    np.testing.assert_array_equal(frame.to_numpy(), want.positions)
    read = open_log(frame)
    np.testing.assert_array_equal(read.values, want.positions)
    np.testing.assert_allclose(read.times, want.time, rtol=0, atol=1e-9)
    gait = walk.gaits[0].to_dataframe()
    np.testing.assert_array_equal(gait["alpha2"], walk.gaits[0].frames[:, 2])
    np.testing.assert_array_equal(gait.index, walk.gaits[0].times)


@pytest.mark.filterwarnings("default:positions are in degrees")
@pytest.mark.parametrize("unit", ["rad", "deg"])
@pytest.mark.parametrize(("ending", "ros"), [(".yaml", 1), (".json", 1), (".mcap", 1), (".csv", 0), (".mot", 0)])
def test_degrees_for_ros_are_written_with_a_warning(walk, unit, ending, ros, tmp_path, capsys, recwarn):
    joints, out = tmp_path / "map.toml", tmp_path / f"out{ending}"
    joints.write_text(f'units = "{unit}"\n{MAPS["signs and order"]}')
    if ending == ".mcap":
        ggo.export_mcap(walk, out, joints=joints)
    else:
        ggo.export_trajectory(walk, out, joints=joints, ends_moving=True)
    expected = int(unit == "deg" and ros)
    assert [str(told.message)[:24] for told in recwarn] == ["positions are in degrees"] * expected
    assert all(told.filename == __file__ for told in recwarn)
    walk.save(tmp_path / "walk.csv")
    assert main(["export", str(tmp_path / "walk.csv"), "--joints", str(joints), "--ends-moving", "-o", str(out)]) == 0
    said = capsys.readouterr().err
    assert said.count("ggo: positions are in degrees, as the joint map has them, but ROS 2 expects radians") == expected
    assert "Warning" not in said


def test_the_command_line_writes_each(walk, mapped, tmp_path):
    walk.save(tmp_path / "walk.csv")
    for ending in (".mcap", ".yaml", ".csv", ".mot"):
        out = tmp_path / f"out{ending}"
        command = ["export", str(tmp_path / "walk.csv"), "--joints", str(mapped), "--rate", "100", "-o", str(out)]
        assert main([*command, "--ends-moving"]) == 0
        assert out.stat().st_size > 1000
