"""Gaits beside a person's steps: steps with a known answer."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from ggo_factors.evaluate.likeness import LIBRARY, METHODS, PARTS, ComparedStep, Comparison, compare_step
from ggo_factors.evaluate.rivals import RIVALS
from ggo_factors.evaluate.summary import JOINTS
from ggo_factors.motion.leg_model import Foot
from ggo_factors.motion.paper_gait import paper_base_gait
from ggo_factors.procedures.steps import adjust_stride

BASE = adjust_stride(paper_base_gait(), steps=1).gaits[0]
MODEL = BASE.legs()


def compared(*steps, base=BASE):
    made = []
    for number, frames in enumerate(steps):
        foothold = tuple(MODEL.endpoint(frames[-1]).tolist())
        made.append(ComparedStep("right", number, number + 0.5, foothold, frames, *compare_step(base, frames)))
    return Comparison("base", "someone", "level", tuple(made), 0, 0, 0.0, MODEL)


def longer():
    """A step of 4 degrees more of each thigh at its end."""
    return BASE.frames + np.linspace(0.0, 1.0, len(BASE))[:, None] ** 2 * np.radians([-4.0, 0.0, 4.0, 0.0])


def test_who_walks_as_the_base_gait_does_is_met():
    made = compared(BASE.frames)
    assert len(made.counted) == 1
    for method in METHODS:
        assert made.rmse_deg(method) < (1.0 if method == "via_points" else 0.1), method
        assert made.foothold_off(method) < 1e-3


def test_a_constant_is_no_change_and_a_longer_step_is_followed():
    assert compared(BASE.frames + np.radians([1.0, 2.0, 1.0, 2.0])).rmse_deg("no_change") == pytest.approx(
        0.0, abs=1e-9
    )
    made = compared(longer())
    by_hand = np.degrees(np.sqrt(np.mean((longer() - BASE.frames) ** 2)))
    assert made.rmse_deg("no_change") == pytest.approx(by_hand)
    assert made.ratio("ggo") < 0.7
    assert made.foothold_off("ggo") < 1e-3
    away = np.linalg.norm(MODEL.endpoint(BASE.frames[-1]) - MODEL.endpoint(longer()[-1]))
    assert made.foothold_off("no_change") == pytest.approx(away)


def test_joints_and_parts_are_what_they_say():
    made = compared(longer(), BASE.frames)
    off = np.degrees(made.errors("no_change"))
    assert off.shape == (2, len(BASE), 4)
    both = made.by_joint_and_part_deg("no_change")
    assert both.shape == (len(JOINTS), len(PARTS))
    np.testing.assert_allclose(both[2, 1], np.sqrt(np.mean(off[:, 17:34, 2] ** 2)))
    np.testing.assert_allclose(made.by_joint_deg("no_change")[2], np.sqrt(np.mean(off[..., 2] ** 2)))
    np.testing.assert_allclose(made.by_part_deg("no_change")[2], np.sqrt(np.mean(off[:, 34:] ** 2)))
    np.testing.assert_allclose(made.by_frame_deg("no_change")[-1], [np.sqrt(8.0), 0.0, np.sqrt(8.0), 0.0], atol=1e-9)
    one, other = (step.rmse_deg("no_change") for step in made.steps)
    assert made.rmse_deg("no_change") == pytest.approx(np.hypot(one, other) / np.sqrt(2.0))


def test_steps_that_no_gait_makes_are_told_and_left_out():
    overstretched = BASE.frames + np.radians([0.0, -40.0, 0.0, -40.0])
    made = compared(BASE.frames, overstretched)
    assert (len(made.steps), len(made.counted)) == (2, 1)
    assert made.rmse_deg("ggo") < 0.1
    ((reason, count),) = made.refusals("ggo").items()
    assert "knee" in reason
    assert count == 1
    assert np.isnan(made.steps[1].rmse_deg("ggo"))
    # What knows no check has a gait all the same.
    assert made.refusals("no_change") == {}
    assert made.steps[1].rmse_deg("no_change") == pytest.approx(0.0, abs=1e-9)


def test_a_step_back_is_refused_by_the_library_alone():
    made, refused = compare_step(BASE, BASE.frames[::-1])
    assert set(refused) == set(LIBRARY)
    assert "on the supporting one or behind it" in refused["ggo"]
    assert set(made) == set(RIVALS)


def test_soles_and_thickness_of_legs_make_no_difference():
    legs = replace(MODEL, foot=Foot(0.08, 0.05, 0.15), thigh_radius=0.05, shank_radius=0.05)
    made, refused = compare_step(replace(BASE, model=legs), longer())
    assert not refused
    np.testing.assert_array_equal(made["ggo"], compare_step(BASE, longer())[0]["ggo"])


def test_at_a_prompt_it_is_one_line():
    made = compared(longer(), BASE.frames + np.radians([0.0, -40.0, 0.0, -40.0]))
    assert re.fullmatch(
        r"Comparison\('base', 1 of 2 steps of 'someone', \d\.\d\d degrees off, no change \d\.\d\d\)", repr(made)
    )
    assert len(repr(made.steps[0])) < 150


def test_json_holds_the_numbers_and_no_nan():
    made = compared(longer(), BASE.frames)
    kept = json.loads(json.dumps(made.to_json(), allow_nan=False))
    assert (kept["compared"], kept["counted"]) == (2, 2)
    assert list(kept["methods"]) == list(METHODS)
    numbers = kept["methods"]["ggo"]
    assert numbers["rmse_deg"] == made.rmse_deg("ggo")
    assert numbers["by_joint_and_part_deg"]["beta2"]["last_third"] == made.by_joint_and_part_deg("ggo")[3, 2]
    assert kept["steps"][0]["rmse_deg"]["dmp"] == made.steps[0].rmse_deg("dmp")
    none = compared(BASE.frames + np.radians([0.0, -40.0, 0.0, -40.0])).to_json()
    assert json.loads(json.dumps(none, allow_nan=False))["methods"]["faded"]["rmse_deg"] is None


def test_where_no_leg_lands_rivals_have_no_posture_to_aim_at():
    split = BASE.frames + np.linspace(0.0, 1.0, len(BASE))[:, None] * (
        np.radians([-90.0, 0.0, 90.0, 0.0]) - BASE.frames[-1]
    )
    made, refused = compare_step(BASE, split)
    assert made == {}
    assert set(refused) == set(METHODS)
    assert all(refused[rival] == "no touchdown posture" for rival in RIVALS)
