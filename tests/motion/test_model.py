"""LegModel: kinematics against hand-worked poses, finite differences and their own inverse."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import ggo_factors as ggo

MODEL = ggo.LegModel(thigh=0.45, shank=0.40)
ANGLE = st.floats(-1.2, 1.2)


def test_endpoint_by_hand():
    assert MODEL.endpoint(np.zeros(4)) == pytest.approx([0.0, 0.0])
    # Swing thigh level forward, shank hanging: P is a thigh forward and a thigh up.
    assert MODEL.endpoint([0.0, 0.0, math.pi / 2, math.pi / 2]) == pytest.approx([0.45, 0.45])
    # Support leg tilted back by 30 degrees, the other hanging: hip forward of the ankle.
    hip = np.array([0.85 * math.sin(math.radians(30)), 0.85 * math.cos(math.radians(30))])
    assert MODEL.endpoint([math.radians(-30), 0.0, 0.0, 0.0]) == pytest.approx(hip - [0.0, 0.85])


def test_endpoint_is_the_papers_equation():
    frames = np.random.default_rng(0).uniform(-1, 1, (20, 4))
    a1, b1, a2, b2 = frames.T
    x = 0.45 * (-np.sin(a1) + np.sin(a2)) + 0.40 * (-np.sin(a1 - b1) + np.sin(a2 - b2))
    y = 0.45 * (np.cos(a1) - np.cos(a2)) + 0.40 * (np.cos(a1 - b1) - np.cos(a2 - b2))
    np.testing.assert_allclose(MODEL.endpoint(frames), np.stack([x, y], -1), atol=1e-15)


def test_joints_are_linked_by_the_segments():
    joints = MODEL.joints(np.random.default_rng(1).uniform(-1, 1, (7, 4)))
    assert joints.shape == (7, 5, 2)
    lengths = np.linalg.norm(np.diff(joints, axis=1), axis=-1)
    np.testing.assert_allclose(lengths, np.tile([0.40, 0.45, 0.45, 0.40], (7, 1)))
    np.testing.assert_array_equal(joints[:, 0], 0.0)


def test_the_hip_is_as_high_as_its_joint():
    frames = np.random.default_rng(1).uniform(-1, 1, (5, 7, 4))
    np.testing.assert_allclose(MODEL.hip_height(frames), MODEL.joints(frames)[..., 2, 1], rtol=0, atol=1e-15)
    assert MODEL.hip_height([0.0, 0.0, 1.0, 1.0]) == MODEL.reach


def test_swapped_roles_mirror_the_endpoint():
    frames = np.random.default_rng(2).uniform(-1, 1, (9, 4))
    np.testing.assert_allclose(MODEL.endpoint(frames[:, [2, 3, 0, 1]]), -MODEL.endpoint(frames), atol=1e-15)


def test_jacobian_against_differences():
    frames, step = np.random.default_rng(3).uniform(-1.5, 1.5, (20, 4)), 1e-6
    numeric = np.stack(
        [(MODEL.endpoint(frames + d) - MODEL.endpoint(frames - d)) / (2 * step) for d in np.eye(4) * step], -1
    )
    np.testing.assert_allclose(MODEL.endpoint_jacobian(frames), numeric, atol=1e-8)


def test_rows_for_one_frame_equal_the_vectorised_forms():
    for frame in np.random.default_rng(4).uniform(-1.5, 1.5, (20, 4)):
        x, y, row_x, row_y = MODEL.endpoint_rows(frame)
        np.testing.assert_allclose([x, y], MODEL.endpoint(frame), atol=1e-15)
        np.testing.assert_allclose([row_x, row_y], MODEL.endpoint_jacobian(frame), atol=1e-15)


@given(ANGLE, st.floats(0.0, 2.0), ANGLE, st.floats(0.001, 2.5))
def test_inverse_kinematics_undoes_the_forward(a1, b1, a2, b2):
    found = MODEL.inverse_kinematics(MODEL.endpoint([a1, b1, a2, b2]), [a1, b1])
    # The knee's angle is found through a cosine, flat where the leg is straight.
    np.testing.assert_allclose(found, [a2, b2], atol=1e-6)


def test_inverse_kinematics_bends_the_human_way_and_takes_many():
    targets = np.array([[0.1, 0.05], [0.2, 0.1], [-0.3, 0.2]])
    support = np.tile([0.1, 0.2], (3, 1))
    angles = MODEL.inverse_kinematics(targets, support)
    assert (angles[:, 1] > 0).all()
    np.testing.assert_allclose(MODEL.endpoint(np.hstack([support, angles])), targets, atol=1e-12)


def test_out_of_reach_says_the_distance_and_the_reach():
    with pytest.raises(ggo.UnreachableFootholdError, match=r"1\.7\d* m from the hip, the leg reaches 0\.85") as caught:
        MODEL.inverse_kinematics([1.5, 0.0], [0.0, 0.0])
    assert caught.value.distance == pytest.approx(math.hypot(1.5, 0.85))
    assert caught.value.reach == MODEL.reach == pytest.approx(0.85)
    with pytest.raises(ggo.UnreachableFootholdError, match=r"no nearer than 0\.05"):
        MODEL.inverse_kinematics([0.0, 0.84], [0.0, 0.0])
    with pytest.raises(ggo.InputError, match=r"support: shape \(2, 2\), target has \(3, 2\)"):
        MODEL.inverse_kinematics([[0.1, 0.0]] * 3, [[0.0, 0.0]] * 2)


def test_model_is_checked_when_made():
    for bad in ({"thigh": 0.0, "shank": 0.4}, {"thigh": 0.4, "shank": -1}, {"thigh": float("nan"), "shank": 0.4}):
        with pytest.raises(ggo.InputError, match=r"thigh|shank"):
            ggo.LegModel(**bad)
    with pytest.raises(ggo.InputError, match=r"toe: -0\.1 m must be at least 0"):
        ggo.Foot(toe=-0.1)
    assert ggo.LegModel(0.39, 0.39).thigh_mass == ggo.LegModel(0.39, 0.39).shank_mass == 7.0
