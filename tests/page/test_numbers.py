"""The numbers of a report against code of their own: places, clearances, angles, speeds, checks, origin."""

from __future__ import annotations

import hashlib
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.check.report import STANDARD
from ggo_factors.cli import main
from ggo_factors.cli.loading import comforts_of
from ggo_factors.motion.recorded import Recorded
from ggo_factors.page.checks import CHECKS
from ggo_factors.page.motion import ShownStep
from ggo_factors.page.numbers import Subject, report_numbers

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.20, 0.25, 0.08, 0.005, 0.005)
FOOT = replace(BASE, model=ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.05, 0.13)))


def numbers_of(walk: ggo.Walk | ggo.Gait, tmp_path: Path, *flags: str) -> dict:
    """The JSON that the command prints of a walk."""
    path = tmp_path / "walk.csv"
    walk.save(path)
    page = tmp_path / "numbers.html"
    main(["report", str(path), "-o", str(page), *flags])
    text = page.read_text(encoding="utf-8")
    return json.loads(text.partition('<script type="application/json" id="numbers">')[2].partition("</script>")[0])


@pytest.fixture(scope="module")
def over_a_box() -> ggo.Walk:
    return ggo.walk(BASE, [ggo.Step((0.45, 0.0), obstacles=(BOX,)), ggo.Step((0.39, 0.0))], first_swing="left")


def test_joints_are_where_trigonometry_has_them(over_a_box, tmp_path):
    numbers = numbers_of(over_a_box, tmp_path)
    motion = numbers["motion"]
    ends = [0, *np.flatnonzero(np.diff(motion["step"])).tolist(), len(motion["step"]) - 1]
    stood = np.zeros(2)
    for number, gait in enumerate(over_a_box.gaits):
        thigh, knee, swing, bent = gait.frames[-1]
        hip = stood + 0.39 * np.array([-math.sin(thigh - knee), math.cos(thigh - knee)])
        hip += 0.39 * np.array([-math.sin(thigh), math.cos(thigh)])
        ankle = hip + 0.39 * np.array([math.sin(swing), -math.cos(swing)])
        ankle += 0.39 * np.array([math.sin(swing - bent), -math.cos(swing - bent)])
        places = np.reshape(motion["joints_m"][ends[number + 1]], (5, 2))
        standing, swinging = (4, 0) if number == 0 else (0, 4)  # the left leg swings first
        np.testing.assert_allclose(places[[standing, 2, swinging]], [stood, hip, ankle], atol=1e-5)
        stood = ankle
    assert motion["time_s"][-1] == pytest.approx(sum(gait.duration for gait in over_a_box.gaits), abs=1e-6)
    assert [step["swings"] for step in numbers["steps"]] == ["left", "right"]
    assert numbers["legs"] == {"left": "left", "right": "right"}


def test_every_instant_over_the_box_tells_its_clearance(over_a_box, tmp_path):
    numbers = numbers_of(over_a_box, tmp_path)
    motion = numbers["motion"]
    told = 0
    for step, places, clear in zip(motion["step"], motion["joints_m"], motion["clearance_mm"], strict=True):
        x, y = places[0:2]  # of the left ankle
        over = step == 1 and BOX.x_start + 1e-4 < x < BOX.x_end - 1e-4
        if over:
            told += 1
            assert clear == pytest.approx((y - BOX.height) * 1e3, abs=0.07)
        elif not BOX.x_start - 1e-4 < x < BOX.x_end + 1e-4:
            assert clear is None
    assert told > 2
    least = min(clear for clear in motion["clearance_mm"] if clear is not None)
    assert numbers["steps"][0]["clearance_mm"] - 0.06 <= least <= numbers["steps"][0]["clearance_mm"] + 3.0


def test_a_toe_is_over_the_box_before_the_ankle(tmp_path):
    walk = ggo.walk(FOOT, [ggo.Step((0.6, 0.0), obstacles=(ggo.Obstacle(0.25, 0.30, 0.05),))])
    motion = numbers_of(walk, tmp_path)["motion"]
    over = [places[8] for places, clear in zip(motion["joints_m"], motion["clearance_mm"], strict=True) if clear]
    assert min(over) < 0.25 - 0.08
    assert max(over) > 0.30 + 0.02


def test_the_scene_is_what_the_steps_say(over_a_box, tmp_path):
    scene = numbers_of(over_a_box, tmp_path)["scene"]
    (box,) = scene["boxes"]
    assert (box["x_start"], box["x_end"], box["low"], box["top"]) == (0.20, 0.25, 0.0, 0.08)
    assert box["cautious"]["x_start"] < 0.20 - 0.005
    assert box["cautious"]["top"] > 0.08 + 0.005
    assert scene["footholds"][0] == [0.45, 0.0]
    assert {y for _, y in scene["ground"]} == {0.0}


def test_what_two_steps_see_is_drawn_once(tmp_path):
    walk = ggo.adjust_stride(BASE, 0.975, gaps=[ggo.Gap(0.52, 0.62)])
    assert sum(len(step.gaps) for step in walk.plan) == 2
    (pit,) = numbers_of(walk, tmp_path)["scene"]["pits"]
    assert (pit["x_start"], pit["x_end"], pit["top"], pit["unknown"]) == (0.52, 0.62, 0.0, False)


def test_stairs_are_ground_and_not_boxes(tmp_path):
    walk = ggo.climb_stairs(BASE)
    scene = numbers_of(walk, tmp_path)["scene"]
    assert scene["boxes"] == []
    heights = [y for _, y in scene["ground"]]
    assert heights == sorted(heights)
    risers = np.diff(sorted({round(y, 2) for y in heights}))
    assert len(risers) == len(walk.gaits)
    np.testing.assert_allclose(risers, walk.plan[0].landing(walk.model)[1], atol=0.02)


def test_soles_lie_along_a_ramp_and_turn_on_the_way(tmp_path):
    slope = math.radians(8.0)
    terrain = ggo.Terrain.level(0.9) + ggo.Terrain.ramp(1.2, slope)
    walk = ggo.plan_walk(FOOT, terrain, goal=1.6).walk
    numbers = numbers_of(walk, tmp_path)
    line = np.array(numbers["scene"]["ground"])
    low, high = np.interp([1.0, 1.5], line[:, 0], line[:, 1])
    assert math.atan2(high - low, 0.5) == pytest.approx(slope, abs=1e-3)
    for places, tilt in zip(numbers["motion"]["joints_m"], numbers["motion"]["tilt_rad"], strict=True):
        for (x, y), turned in zip((places[0:2], places[8:10]), tilt, strict=True):
            assert -1e-9 <= turned <= slope + 1e-4
            middle = np.array([x, y]) + 0.06 * np.array([math.sin(turned), -math.cos(turned)])
            for along in (-0.05, 0.13):
                end = middle + along * np.array([math.cos(turned), math.sin(turned)])
                assert end[1] > np.interp(end[0], line[:, 0], line[:, 1]) - 0.003


def test_angles_of_each_leg_stand_beside_the_base_gaits(over_a_box, tmp_path):
    curves = numbers_of(over_a_box, tmp_path, "--base", "paper")["angles"]
    trajectory = over_a_box.joint_trajectory()
    for joint, curve in curves.items():
        own = np.interp(curve["time_s"], trajectory.time, np.degrees(getattr(trajectory, joint.replace(" ", "_"))))
        np.testing.assert_allclose(curve["deg"], own, atol=1e-3)
    # The left leg swings first, then stands.
    cycle = np.concatenate([BASE.frames[:, 2], BASE.frames[:, 0]])
    np.testing.assert_allclose(curves["left hip"]["base_deg"], np.degrees(cycle), atol=1e-3)
    assert "base_sd_deg" not in curves["left hip"]


def test_a_known_spread_goes_with_its_leg():
    spread = np.radians(np.broadcast_to([1.0, 2.0, 3.0, 4.0], (11, 4)))
    base = replace(BASE, recorded=Recorded(7, spread))
    walk = ggo.walk(BASE, [ggo.Step((0.39, 0.0)), ggo.Step((0.39, 0.0))])
    comforts = tuple(comforts_of("walk", walk, (base, base)))
    subject = Subject(walk, walk.verify(), comforts, None, "walk.csv", (base, base), "paper")
    numbers = report_numbers(subject, "1")
    assert numbers["angles"]["right hip"]["base_sd_deg"] == [3.0] * 51 + [1.0] * 51
    assert numbers["angles"]["left knee"]["base_sd_deg"] == [2.0] * 51 + [4.0] * 51
    assert numbers["source"]["base"]["strides"] == {"paper base gait": 7}
    # A band stands beside every step or beside none.
    numbers = report_numbers(replace(subject, bases=(base, BASE)), "1")
    assert "base_sd_deg" not in numbers["angles"]["right hip"]


def test_speeds_are_told_by_joint_against_the_walks_own_limits(tmp_path):
    limits = ggo.JointLimits(hip_speed=math.radians(150.0))
    walk = ggo.walk(BASE, [ggo.Step((0.45, 0.0), obstacles=(BOX,)), ggo.Step((0.39, 0.0))], limits=limits)
    rows = {row["joint"]: row for row in numbers_of(walk, tmp_path, "--base", "paper")["rates"]}
    trajectory = walk.joint_trajectory(rate=5000.0)
    for joint, row in rows.items():
        column = ("left hip", "left knee", "right hip", "right knee").index(joint)
        fastest = math.degrees(np.abs(trajectory.velocities[:, column]).max())
        assert row["speed_deg_s"] == pytest.approx(fastest, rel=2e-3)
        assert row["speed_limit_deg_s"] == pytest.approx(150.0 if "hip" in joint else 500.0)
        assert row["speed_share_percent"] == pytest.approx(
            row["speed_deg_s"] / row["speed_limit_deg_s"] * 1e2, abs=0.01
        )
        assert row["speed_share_percent"] <= 100.1
    own = np.degrees(np.abs(np.diff(BASE.frames, axis=0)).max(axis=0) / BASE.dt)
    assert rows["right knee"]["base_speed_deg_s"] == pytest.approx(own[[1, 3]].max(), abs=0.01)


def test_which_leg_is_the_fastest_follows_the_first_swing(tmp_path):
    steps = [ggo.Step((0.45, 0.0), obstacles=(BOX,))]
    fastest = []
    for leg in ("right", "left"):
        rows = numbers_of(ggo.walk(BASE, steps, first_swing=leg), tmp_path)["rates"]
        assert [row["joint"] for row in rows] == ["left hip", "left knee", "right hip", "right knee"]
        assert rows[0]["speed_limit_deg_s"] is None
        fastest.append(max(rows, key=lambda row: row["speed_deg_s"])["joint"])
    assert fastest == ["right knee", "left knee"]


def test_limits_are_asked_of_a_gait_by_the_flag(tmp_path):
    rows = {row["check"]: row for row in numbers_of(BASE, tmp_path, "--limits")["checks"]}
    assert rows["limits"]["asked"]
    assert rows["limits"]["broken_in_steps"] == []
    assert not {row["check"]: row for row in numbers_of(BASE, tmp_path)["checks"]}["limits"]["asked"]


def test_balance_is_how_far_the_push_is_from_the_base_gaits(tmp_path):
    slow = replace(BASE, dt=0.02)
    slow.save(tmp_path / "slow.csv")
    walk = ggo.walk(slow, [ggo.Step((0.45, 0.0), obstacles=(BOX,))], balance=2.0)
    numbers = numbers_of(walk, tmp_path, "--base", str(tmp_path / "slow.csv"))
    (row,) = numbers["balance"]
    report = ggo.verify(walk.gaits[0], foothold=(0.45, 0.0), obstacles=[BOX], balance=slow)
    assert row["mean_off_base_mm"] == pytest.approx(report.zmp_off * 1e3, abs=1e-3)
    assert row["largest_off_base_mm"] == pytest.approx(report.zmp_off_largest * 1e3, abs=1e-3)
    assert row["back_mm"] < row["front_mm"]
    assert numbers["source"]["base"]["file"] == "slow.csv"


def test_checks_tell_their_tolerances_and_what_was_found(over_a_box, tmp_path):
    numbers = numbers_of(over_a_box, tmp_path)
    rows = {row["check"]: row for row in numbers["checks"]}
    reports = over_a_box.verify()
    assert rows["foothold"]["allowed"] == STANDARD.foothold * 1e3
    assert rows["foothold"]["found"] == pytest.approx(max(r.foothold_error for r in reports) * 1e3, abs=1e-3)
    assert rows["clearance"]["found"] == pytest.approx(reports[0].clearance * 1e3, abs=1e-3)
    assert rows["hit_probability"]["found"] == pytest.approx(reports[0].hit_probability, abs=1e-6)
    assert rows["knee"]["found"] == pytest.approx(math.degrees(min(r.knee for r in reports)), abs=1e-3)
    assert not rows["uneven_ground"]["asked"]
    assert rows["uneven_ground"]["found"] is None
    assert numbers["ok"]
    assert all(row["broken_in_steps"] == [] for row in numbers["checks"])
    assert numbers["instants_checked"] == sum(report.instants for report in reports)


KINDS = {
    "foothold": ("foothold",),
    "clearance": ("obstacle",),
    "hit_probability": ("hit probability",),
    "legs": ("swing shank in obstacle", "support thigh in stairs"),
    "ground": ("ground",),
    "mid_swing": ("foot drags in mid-swing",),
    "standing": (
        *("obstacle in the foothold", "swinging foot's start in a gap", "supporting foot over a void"),
        *("stair in the supporting foot", "foothold off the ground"),
    ),
    "knee": ("knee",),
    "knee_bent": ("knee bent",),
    "thigh_back": ("thigh back",),
    "thigh_forward": ("thigh forward",),
    "hip_drop": ("hip drop",),
    "hip_height": ("hip height",),
    "joint_speed": ("hip turns", "knee turns"),
    "spikes": ("hip spike", "knee spike"),
    "start": ("start",),
    "jumps": ("hip speed jumps", "knee speed jumps"),
    "rest": ("hip not at rest", "knee not at rest"),
    "end_frame": ("end frame",),
    "shank": ("shank",),
    "landing_speed": ("landing speed",),
    "limits": ("hip angle", "knee speed", "hip acceleration"),
    "balance": ("balance",),
}
"""Kinds of violations that `verify` and `Walk.verify` tell, by the check that they belong to."""


def test_every_kind_of_violation_belongs_to_one_check():
    planned = ggo.Step((0.39, 0.0), obstacles=(BOX,), shank_angle=1.0, end_frame=tuple(BASE.frames[-1]))
    shown = ShownStep(BASE, planned, (0.0, 0.0), 0.0, "right")
    for key, kinds in KINDS.items():
        for kind in kinds:
            own = [check.key for check in CHECKS if check.is_own(shown, ggo.Violation(kind, None, 1.0, 0.0, "m"))]
            assert own == [key], kind
    assert {check.key for check in CHECKS} == KINDS.keys() | {"uneven_ground"}
    stairs = replace(shown, step=replace(planned, ground=ggo.stair_ground(0.2, 0.3, [0.1])))
    low = ggo.Violation("ground", 1.0, 0.0, 0.005, "m")
    assert [check.key for check in CHECKS if check.is_own(stairs, low)] == ["uneven_ground"]


def test_a_violation_without_a_row_gets_one():
    report = replace(ggo.verify(BASE), violations=(ggo.Violation("something new", 25.0, 2.0, 1.0, "m", "why"),))
    subject = Subject(BASE, (report,), tuple(comforts_of("gait", BASE, None)), None, "paper")
    numbers = report_numbers(subject, "1")
    assert not numbers["ok"]
    assert numbers["checks"][-1]["broken_in_steps"] == [1]
    assert numbers["checks"][-1]["check"] == "others"
    (told,) = numbers["violations"]
    assert told == {
        **{"step": 1, "kind": "something new", "time_s": 0.25, "value": 2.0, "limit": 1.0, "unit": "m", "note": "why"}
    }


def test_files_are_told_with_their_checksums(over_a_box, tmp_path):
    source = numbers_of(over_a_box, tmp_path, "--base", "paper")["source"]
    path = tmp_path / "walk.csv"
    assert source["file"] == "walk.csv"
    assert source["form"] == path.read_text().partition("\n")[0].removeprefix("# ")
    assert source["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert f"# checksum: {source['checksum']}" in path.read_text().splitlines()
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00", source["written"])
    assert source["base"]["names"] == ["paper base gait"]
    assert source["base"]["file"] is None
    assert source["origins"] == ["generated from paper base gait"]
    assert {(bent["name"], bent["fingerprint"]) for bent in source["bent_from"]} == {(BASE.name, BASE.fingerprint)}
