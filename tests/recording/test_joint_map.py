"""Joint maps: TOML, presets, and what is said when a log and a map do not fit."""

from __future__ import annotations

import pytest

from ggo_factors.errors import InputError, LogError
from ggo_factors.recording.log.joint_map import ANGLES, JointMap, joint_map, load_joint_map, suggestion
from ggo_factors.recording.log.presets import PRESETS

EXAMPLE = """units = "rad"
[alpha_right]
right_hip = 1.0
[beta_right]
right_knee = 1.0
[alpha_left]
left_hip = 1.0
[beta_left]
left_knee = 1.0"""

DIRECT = ("left_hip_joint", "left_knee_joint", "right_hip_joint", "right_knee_joint")


def written(tmp_path, text):
    path = tmp_path / "map.toml"
    path.write_text(text)
    return path


def test_toml_map(tmp_path):
    text = """units = "deg"
[alpha_right]
hip_r = 1.0
tilt = 1
[beta_right]
"/right/knee:data" = -1.0
[alpha_left]
left.hip = 1.0
[beta_left]
"data[3]" = 0.5
"""
    joints = load_joint_map(written(tmp_path, text))
    assert joints.units == "deg"
    assert dict(joints.terms["alpha_right"]) == {"hip_r": 1.0, "tilt": 1.0}
    assert dict(joints.terms["alpha_left"]) == {"left.hip": 1.0}
    assert joints.names == ("hip_r", "tilt", "/right/knee:data", "left.hip", "data[3]")


def test_the_plainest_map(tmp_path):
    assert load_joint_map(written(tmp_path, EXAMPLE)).names == ("right_hip", "right_knee", "left_hip", "left_knee")


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (("[beta_left]", "[gamma_left]"), "gamma_left"),
        (("[beta_left]\nleft_knee = 1.0", ""), "beta_left"),
        (("left_knee = 1.0", ""), "beta_left"),
        (("left_knee = 1.0", 'left_knee = "one"'), "expected a number"),
        (("left_knee = 1.0", "left_knee = true"), "expected a number"),
        (("left_knee = 1.0", "left_knee = nan"), "not finite"),
        (("left_knee = 1.0", "left_knee = 0.0"), "factor of 0"),
        (("left_knee = 1.0", "left_knee = "), "TOML"),
        (('units = "rad"', 'units = "grad"'), "units"),
        (('units = "rad"', "units = 3"), "units"),
        (("[alpha_right]\nright_hip = 1.0", "alpha_right = 1.0"), "alpha_right"),
    ],
)
def test_wrong_maps_are_refused_by_name(tmp_path, change, word):
    path = written(tmp_path, EXAMPLE.replace(*change))
    with pytest.raises(InputError, match=word) as error:
        load_joint_map(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_map_file_names_the_presets():
    with pytest.raises(InputError, match=r"No such file.*opensim-knee-negative"):
        joint_map("nosuchpreset", DIRECT, "x.mcap")


@pytest.mark.parametrize(
    ("preset", "names", "row"),
    [
        ("direct", DIRECT, {"alpha_left": {"left_hip_joint": 1.0}, "beta_right": {"right_knee_joint": 1.0}}),
        ("direct", ("left.hip", "left.knee", "right.hip", "right.knee"), {"beta_left": {"left.knee": 1.0}}),
        ("direct", ("LHip", "LKnee", "RHip", "RKnee"), {"alpha_right": {"RHip": 1.0}}),
        (
            "direct-knee-negative",
            DIRECT,
            {"beta_left": {"left_knee_joint": -1.0}, "alpha_left": {"left_hip_joint": 1.0}},
        ),
        (
            "opensim",
            ("pelvis_tilt", "hip_flexion_r", "knee_angle_r", "hip_flexion_l", "knee_angle_l", "ankle_angle_r"),
            {"alpha_right": {"hip_flexion_r": 1.0, "pelvis_tilt": 1.0}, "beta_left": {"knee_angle_l": 1.0}},
        ),
        (
            "opensim-knee-negative",
            ("pelvis_tilt", "hip_flexion_r", "knee_angle_r", "hip_flexion_l", "knee_angle_l"),
            {"beta_right": {"knee_angle_r": -1.0}},
        ),
        (
            "plug-in-gait",
            ("LHipAngles.x", "LHipAngles.y", "LKneeAngles.x", "RHipAngles.x", "RKneeAngles.x", "LPelvisAngles.x"),
            {
                "alpha_left": {"LHipAngles.x": 1.0, "LPelvisAngles.x": -1.0},
                "alpha_right": {"RHipAngles.x": 1.0, "LPelvisAngles.x": -1.0},
            },
        ),
        (
            "segment-pitch",
            ("thigh_pitch_r", "shank_pitch_r", "thigh_pitch_l", "shank_pitch_l"),
            {"beta_left": {"thigh_pitch_l": 1.0, "shank_pitch_l": -1.0}, "alpha_left": {"thigh_pitch_l": 1.0}},
        ),
    ],
)
def test_presets(preset, names, row):
    joints = joint_map(preset, names, "x.mcap")
    for angle, terms in row.items():
        assert dict(joints.terms[angle]) == terms
    assert joints.units is None
    assert preset in suggestion(names)


def test_opensim_without_pelvis_tilt_says_so():
    joints = joint_map("opensim", ("hip_flexion_r", "knee_angle_r", "hip_flexion_l", "knee_angle_l"), "x.mcap")
    assert len(joints.notes) == 2
    assert all("pelvis tilt" in note for note in joints.notes)


def test_without_a_map_the_user_is_asked_with_a_suggestion():
    with pytest.raises(LogError, match=r"joints=.*left_hip_joint.*fit joints='direct' or"):
        joint_map(None, DIRECT, "x.mcap")
    with pytest.raises(LogError, match=r"m1, m2.*MAP\.toml.*preset"):
        joint_map(None, ("m1", "m2", "m3", "m4"), "x.mcap")


def test_a_value_that_is_not_there():
    with pytest.raises(LogError, match=r"no beta_right;.*right_ankle_joint"):
        joint_map("direct", (*DIRECT[:3], "right_ankle_joint"), "x.mcap")
    wrong = JointMap({angle: {"right_hip_join": 1.0} for angle in ANGLES})
    with pytest.raises(LogError, match=r"no value named 'right_hip_join'.*did you mean 'right_hip_joint'"):
        joint_map(wrong, DIRECT, "x.mcap")


def test_two_values_for_one_joint_are_not_guessed_between():
    with pytest.raises(LogError, match="left_hip and left_hip_joint fit"):
        joint_map("direct", ("left_hip", *DIRECT), "x.mcap")


def test_every_preset_has_all_angles():
    assert all(set(rows) == set(ANGLES) for rows in PRESETS.values())


@pytest.mark.parametrize(
    "names",
    [
        ("hüfte_rechts", "knie_rechts", "hüfte_links", "knie_links"),
        ("右髋", "右膝", "左髋", "左膝"),
        ("legs.right.hip", "legs.right.knee", "legs.left.hip", "legs.left.knee"),
    ],
)
def test_names_of_any_language_and_depth(tmp_path, names):
    text = "".join(f'[{angle}]\n"{name}" = 1.0\n' for angle, name in zip(ANGLES, names, strict=True))
    chosen = joint_map(written(tmp_path, text), names, "x.mcap")
    assert chosen.names == names
    with pytest.raises(LogError) as error:
        joint_map(None, names, "x.mcap")
    assert ", ".join(names) in str(error.value)
    if not names[0].isascii():
        with pytest.raises(InputError, match=r"names with other characters than A-Z.* need quotes"):
            load_joint_map(written(tmp_path, text.replace('"', "")))
