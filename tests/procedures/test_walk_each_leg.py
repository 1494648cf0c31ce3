"""Walks from a base gait for each leg: which is bent for which step, what a file says, replans, exports."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_gaits import pair

import ggo_factors as ggo
from ggo_factors.motion.base_gaits import LEGS
from ggo_factors.procedures.steps import walker_of
from ggo_factors.procedures.walker import scaled
from ggo_factors.recording.strides.mean_step import steps_with_bent_knees

MADE, _ = pair()
# On the ground at both ends, as an import leaves them.
STOOD, _ = steps_with_bent_knees([gait.frames for gait in MADE], MADE[0].legs())
BOTH = ggo.BaseGaits(
    *(replace(gait, frames=frames, name=f"limps {leg}") for gait, frames, leg in zip(MADE, STOOD, LEGS, strict=True))
)
PAPER = ggo.paper_base_gait()


def own_steps(first, count):
    """Steps where the base gaits themselves land."""
    legs = [first, "left" if first == "right" else "right"] * count
    return [ggo.Step((float(BOTH.gait("level", leg).endpoints()[-1, 0]), 0.0)) for leg in legs[:count]]


@pytest.mark.parametrize("first", ["right", "left"])
def test_each_step_bends_the_gait_of_the_leg_that_swings(first):
    steps = [replace(step, foothold=(step.foothold[0] + 0.03, 0.0)) for step in own_steps(first, 4)]
    walk = ggo.walk(BOTH, steps, first_swing=first)
    legs = ["left" if (first == "left") == (number % 2 == 0) else "right" for number in range(4)]
    assert [step.task.base.name for step in walk.steps] == [f"limps {leg}" for leg in legs]
    assert [len(gait) for gait in walk.gaits] == [len(BOTH.gait("level", leg)) for leg in legs]
    assert all(report.ok for report in walk.verify())
    # In the joints of the left leg its own swing, of whichever number it is.
    number = legs.index("left")
    ends = np.cumsum([0] + [len(gait) - 1 for gait in walk.gaits])
    played = walk.joint_trajectory()
    swing = walk.gaits[number].frames[:, 3]
    np.testing.assert_array_equal(played.left_knee[ends[number] : ends[number + 1] + 1], swing)


def test_its_own_footholds_leave_the_base_gaits_as_they_are():
    walk = ggo.walk(BOTH, own_steps("left", 4), first_swing="left")
    for step in walk.steps:
        assert np.degrees(np.abs(step.gait.frames - step.task.base.frames).max()) < 0.5


def test_one_gait_for_both_legs_is_one_gait():
    steps = [ggo.Step((0.42, 0.0), (ggo.Obstacle(0.2, 0.25, 0.08),)), ggo.Step((0.4, 0.0))]
    one, two = (ggo.walk(base, steps) for base in (PAPER, ggo.BaseGaits(PAPER, PAPER)))
    for mine, theirs in zip(one.gaits, two.gaits, strict=True):
        np.testing.assert_array_equal(mine.frames, theirs.frames)


def test_a_file_says_what_each_step_was_bent_from(tmp_path):
    walk = ggo.walk(BOTH, own_steps("left", 3), first_swing="left")
    walk.save(tmp_path / "walk.csv")
    read = ggo.load_walk(tmp_path / "walk.csv")
    assert read.first_swing == "left"
    assert [gait.origin for gait in read.gaits] == [f"generated from limps {leg}" for leg in ("left", "right", "left")]
    np.testing.assert_allclose(read.joint_trajectory().positions, walk.joint_trajectory().positions, atol=1e-12)
    # A file from before says neither.
    text = (tmp_path / "walk.csv").read_text()
    lines = [line for line in text.splitlines() if not line.startswith("# first_swing")]
    old = "\n".join(line.split(', "origin"')[0] + "}" if line.startswith("# step") else line for line in lines)
    (tmp_path / "old.csv").write_text(old + "\n")
    older = ggo.load_walk(tmp_path / "old.csv")
    assert older.first_swing == "right"
    assert {gait.origin for gait in older.gaits} == {"generated from limps left"}


def test_a_replan_goes_on_with_the_gait_of_each_leg(tmp_path):
    walk = ggo.walk(BOTH, own_steps("left", 4), first_swing="left")
    foothold = (walk.plan[1].foothold[0] + 0.03, 0.0)
    again = ggo.replan(walk, step=2, at_frame=10, foothold=foothold)
    assert again.first_swing == "left"
    assert [step.task.base.name for step in again.steps] == [step.task.base.name for step in walk.steps]
    np.testing.assert_array_equal(again.gaits[0].frames, walk.gaits[0].frames)
    np.testing.assert_array_equal(again.gaits[1].frames[:11], walk.gaits[1].frames[:11])
    assert all(report.ok for report in again.verify())
    walk.save(tmp_path / "walk.csv")
    read = ggo.replan(ggo.load_walk(tmp_path / "walk.csv"), step=2, at_frame=10, foothold=foothold, base=BOTH)
    for mine, theirs in zip(read.gaits, again.gaits, strict=True):
        assert np.degrees(np.abs(mine.frames - theirs.frames).max()) < 1.0
    swapped, saved = ggo.BaseGaits(BOTH.right, BOTH.left), ggo.load_walk(tmp_path / "walk.csv")
    with pytest.raises(ggo.InputError, match=r"has \d+ frames at this rate, step 2"):
        ggo.replan(saved, step=2, at_frame=10, foothold=foothold, base=swapped)


def test_a_file_of_a_slow_walk_is_replanned_with_the_gaits_of_each_leg(tmp_path):
    """It was refused: the base gaits at the file's time step have fewer frames than steps at half their pace."""
    walk = ggo.walk(BOTH, own_steps("left", 3), first_swing="left", pace=0.5)
    walk.save(tmp_path / "walk.csv")
    saved, foothold = ggo.load_walk(tmp_path / "walk.csv"), (walk.plan[1].foothold[0] + 0.03, 0.0)
    again = ggo.replan(walk, step=2, at_frame=10, foothold=foothold)
    for base in (BOTH, BOTH.changed(lambda gait: replace(gait, dt=1.2 * gait.dt))):
        read = ggo.replan(saved, step=2, at_frame=10, foothold=foothold, base=base)
        for mine, theirs in zip(read.gaits, again.gaits, strict=True):
            assert np.degrees(np.abs(mine.frames - theirs.frames).max()) < 1.0
    for other in (ggo.BaseGaits(BOTH.right, BOTH.left), BOTH.changed(lambda gait: replace(gait, dt=3.0 * gait.dt))):
        with pytest.raises(ggo.InputError, match=r"has \d+ frames at this rate, step 2"):
            ggo.replan(saved, step=2, at_frame=10, foothold=foothold, base=other)


@pytest.mark.parametrize(
    "options", [{}, {"gain": 700.0}, {"smoothness": 30.0}, {"balance": 2.0}, {"landing": False}, {"smoothness": 0.0}]
)
@pytest.mark.parametrize(("motions", "others"), [(50, 73), (73, 50), (40, 250), (250, 120)])
def test_settings_of_another_length_are_those_of_a_walker_of_it(options, motions, others):
    plain = {"gain": None, "smoothness": None, "landing": None, **options}

    def settings(count):
        rest = {"model": None, "start": None, "start_rate": None, "hard": False, "limits": None}
        return walker_of(ggo.paper_base_gait(count + 1), **rest, **plain).settings

    found, wanted = scaled(settings(motions), motions, others), settings(others)
    assert found.gains.end == pytest.approx(wanted.gains.end)
    assert (found.gains.hold, found.gains.inside) == (wanted.gains.hold, wanted.gains.inside)
    assert found.smoothness == pytest.approx(wanted.smoothness)


def test_many_walks_from_gaits_of_each_leg():
    task = ggo.Task("walk", {"steps": own_steps("right", 3)})
    (row,) = ggo.generate_many([task], BOTH, workers=1, keep_frames=True)
    assert row.ok, row.reason
    assert max(np.degrees(row.change)) < 0.5
    assert row.frames.shape == (3, len(BOTH.left), 4)


def test_a_leg_that_is_none_is_refused():
    with pytest.raises(ggo.InputError, match="first_swing: 'both' is neither"):
        ggo.walk(BOTH, own_steps("left", 1), first_swing="both")
