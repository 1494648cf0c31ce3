"""The scene beside an exported walk: a URDF that moves as the model does, boxes where they stand, other readers."""

from __future__ import annotations

import base64
import io
import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.paper_gait import paper_base_gait
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.procedures.stairs import climb_stairs
from ggo_factors.procedures.steps import walk
from ggo_factors.recording.export.export_mcap import export_mcap
from ggo_factors.recording.export.urdf import legs_urdf
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.walking.step import Step, across

TILT = 0.1
LATCHED = ("/robot_description", "/gait/scene", "/gait/trajectory")


@pytest.fixture(scope="module")
def stepped():
    base, box = paper_base_gait(), Obstacle(0.2, 0.25, 0.08)
    return walk(base, across([Step(foothold=(0.39, 0.0))] * 2, base.legs(), [box], []))


@pytest.fixture(scope="module")
def exported(stepped, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("scene") / "walk.mcap"
    export_mcap(stepped, path, pelvis_tilt=TILT)
    return path


def read(path: Path) -> dict[str, list]:
    found: dict[str, list] = {}
    with path.open("rb") as stream:
        for _, channel, _, decoded in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            found.setdefault(channel.topic, []).append(decoded)
    return found


MAPS = {
    "own names": None,
    "signs, zeros and a fixed pelvis": JointMap(
        {
            "alpha_right": {"hr": -1.0, "pelvis": 1.0},
            "beta_right": {"kr & <b>": -1.0},
            "alpha_left": {"hl": 1.0, "pelvis": 1.0},
            "beta_left": {"kl": 1.0},
        },
        "rad",
        offsets={"hr": 0.3, "kl": -0.2},
        fixed={"pelvis": 0.15, "right_ankle": 0.1},
        order=("kl", "right_ankle", "hr", "hl", "kr & <b>", "pelvis"),
    ),
}


@pytest.mark.parametrize("joints", MAPS.values(), ids=MAPS)
@pytest.mark.parametrize("rate", [None, 130.0])
def test_the_urdf_moved_by_the_exported_joints_puts_the_ankles_where_the_model_does(stepped, joints, rate, tmp_path):
    yourdfpy = pytest.importorskip("yourdfpy")
    export_mcap(stepped, tmp_path / "walk.mcap", pelvis_tilt=TILT, joints=joints, rate=rate)
    messages = read(tmp_path / "walk.mcap")
    text = messages["/robot_description"][0].data
    robot = yourdfpy.URDF.load(io.BytesIO(text.encode()), load_meshes=False)
    assert robot.base_link == "pelvis"
    lean = np.array([[np.cos(TILT), 0, -np.sin(TILT)], [0, 1, 0], [np.sin(TILT), 0, np.cos(TILT)]])
    played = stepped.joint_trajectory(rate=rate)
    first = played.time <= stepped.gaits[0].duration + 1e-9
    want = stepped.model.endpoint(played.positions)  # the left leg stands in the first step
    assert np.ptp(want[first, 1]) > 0.05
    assert len(messages["/joint_states"]) == len(want)
    for state, (x, z) in zip(messages["/joint_states"], want, strict=True):
        told = dict(zip(state.name, state.position, strict=True))
        robot.update_cfg({name: told[name] for name in robot.actuated_joint_names})
        ankles = [robot.get_transform(f"{side}_ankle", "pelvis")[:3, 3] for side in ("left", "right")]
        np.testing.assert_allclose(lean @ (ankles[1] - ankles[0]), [x, 0.0, z], rtol=0, atol=1e-9)


@pytest.mark.parametrize("change", [{"units": "deg"}, {"terms": 2.0}])
def test_joints_that_a_urdf_cannot_turn_leave_it_its_own(change):
    joints = MAPS["signs, zeros and a fixed pelvis"]
    assert joints is not None
    if "terms" in change:
        change = {"terms": {**joints.terms, "beta_left": {"kl": 2.0}}}
    assert legs_urdf(LegModel(0.4, 0.35), replace(joints, **change)) == legs_urdf(LegModel(0.4, 0.35))


def test_the_transforms_put_the_ankles_where_the_stick_figure_has_them(exported):
    messages = read(exported)
    assert len(messages["/tf"]) == len(messages["/gait/stick"]) > 50
    for moved, stick in zip(messages["/tf"], messages["/gait/stick"], strict=True):
        chain = {t.child_frame_id: t for t in moved.transforms}
        for figure in stick.markers:
            place, link = np.zeros(3), f"{figure.text}_ankle"
            while link != "map":
                step = chain[link]
                turn, shift = step.transform.rotation, step.transform.translation
                half = np.arctan2(turn.y, turn.w)
                c, s = np.cos(2.0 * half), np.sin(2.0 * half)
                place = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ place + [shift.x, shift.y, shift.z]
                link = step.header.frame_id
            ankle = figure.points[0]
            np.testing.assert_allclose(place, [ankle.x, 0.0, ankle.z], rtol=0, atol=1e-9)


def test_a_box_seen_by_two_steps_is_drawn_once_where_it_stands(exported):
    (scene,) = read(exported)["/gait/scene"]
    (box,) = [m for m in scene.markers if m.ns == "boxes"]
    assert box.pose.position.x == pytest.approx(0.225)
    assert box.scale.x == pytest.approx(0.05)
    assert box.pose.position.z == pytest.approx(0.04)
    assert box.scale.z == pytest.approx(0.08)
    balls = [m.pose.position.x for m in scene.markers if m.ns == "footholds"]
    assert balls == pytest.approx([0.39, 0.78], abs=2e-3)


def test_stairs_are_drawn_with_each_tread_at_its_height(tmp_path):
    export_mcap(climb_stairs(paper_base_gait(), [0.10, 0.14]), tmp_path / "stairs.mcap")
    (scene,) = read(tmp_path / "stairs.mcap")["/gait/scene"]
    tops = {round(m.pose.position.z + m.scale.z / 2.0, 6) for m in scene.markers if m.ns == "ground"}
    assert tops == {0.0, 0.1, 0.24}


def test_masses_and_lengths_of_the_urdf_are_the_models():
    tree = ElementTree.fromstring(legs_urdf(LegModel(0.4, 0.35, thigh_mass=8.0, shank_mass=3.0)))
    links = tree.findall("link[inertial]")
    masses = {link.get("name"): float(link.find("inertial/mass").get("value")) for link in links}
    assert masses == {"left_thigh": 8.0, "left_shank": 3.0, "right_thigh": 8.0, "right_shank": 3.0}
    assert tree.find("joint[@name='left_knee']/origin").get("xyz") == "0 0 -0.4"


def test_what_is_told_once_is_latched(exported):
    with exported.open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
    durable = {c.topic for c in channels if "durability: 1" in c.metadata["offered_qos_profiles"]}
    assert durable == set(LATCHED)


def test_the_foxglove_layout_shows_what_is_exported(exported):
    layout = json.loads((Path(__file__).parents[2] / "tools/ros2/foxglove_layout.json").read_text())
    panels, messages = layout["configById"], read(exported)
    assert set(panels["3D!legs"]["topics"]) <= set(messages)
    assert {layout["layout"]["first"], layout["layout"]["second"]} == set(panels)
    names = messages["/joint_states"][0].name
    for path in panels["Plot!angles"]["paths"]:
        topic, column = path["value"].removesuffix("]").split(".position[")
        assert (topic, names[int(column)]) == ("/joint_states", path["label"])


SCRIPT = """
const {parse} = require('@foxglove/rosmsg'); const {MessageReader} = require('@foxglove/rosmsg2-serialization');
const {schemas, messages} = JSON.parse(require('fs').readFileSync(0));
const reader = (text) => new MessageReader(parse(text, {ros2: true}));
const readers = Object.fromEntries(Object.entries(schemas).map(([k, text]) => [k, reader(text)]));
const plain = (k, v) => ArrayBuffer.isView(v) ? Array.from(v) : v;
console.log(JSON.stringify(messages.map(([k, data]) => readers[k].readMessage(Buffer.from(data, 'base64'))), plain));
"""
"""Reads all messages of a log as Foxglove does and writes them as JSON."""


def plain(message):
    """A message of mcap-ros2-support as JSON has it; of stamps the first field is called sec by both."""
    if hasattr(message, "__slots__"):
        return {name: plain(getattr(message, name)) for name in message.__slots__}
    if isinstance(message, bytes):
        return list(message)
    return [plain(item) for item in message] if isinstance(message, list | tuple) else message


@pytest.mark.parametrize("joints", MAPS.values(), ids=MAPS)
def test_foxglove_reads_every_message(stepped, joints, tmp_path):
    node = shutil.which("node")
    wanted = "require.resolve('@foxglove/rosmsg'); require.resolve('@foxglove/rosmsg2-serialization')"
    if node is None or subprocess.run([node, "-e", wanted], capture_output=True, check=False).returncode:
        pytest.skip("node with @foxglove/rosmsg and @foxglove/rosmsg2-serialization (NODE_PATH) is not there")
    export_mcap(stepped, tmp_path / "walk.mcap", joints=joints)
    schemas, raw, ours = dict[str, str](), [], []
    with (tmp_path / "walk.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for schema, _, message, decoded in reader.iter_decoded_messages():
            schemas[schema.name] = schema.data.decode()
            raw.append((schema.name, base64.b64encode(message.data).decode()))
            ours.append(plain(decoded))
    told = json.dumps({"schemas": schemas, "messages": raw})
    done = subprocess.run([node, "-e", SCRIPT], input=told, capture_output=True, text=True, check=True)
    theirs = json.loads(done.stdout.replace('"nsec"', '"nanosec"'))
    assert len(theirs) == len(ours) > 300
    assert theirs == ours
