"""Stairs from a stair gait: chosen by what a step does, begun from level ground, from standing, on the stairs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from independent import path_of
from made_gaits import ascent, first_step, last_step

import ggo_factors as ggo

PAPER = ggo.paper_base_gait()
# A stair gait takes longer than a level one: its frames are more at one rate.
UP = replace(ascent(), dt=0.014)
DOWN = replace(ggo.descend_stairs(PAPER, 0.16, tread=0.3, first_edge=0.2, steps=4).gaits[3], name="down", dt=0.012)
BOTH = ggo.BaseGaits(PAPER, PAPER, up=UP, down=DOWN)
BEGIN = {"level": {}, "standing": {"start": ggo.STANDING}, "on stairs": {"on_stairs": True}}


@pytest.mark.parametrize("riser", [0.10, 0.15, 0.19])
@pytest.mark.parametrize("begin", BEGIN)
@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
def test_a_flight_from_its_own_gait(procedure, begin, riser):
    walk = procedure(BOTH, riser, tread=0.29, first_edge=0.2, steps=3, to_standing=True, **BEGIN[begin])
    up = procedure is ggo.climb_stairs
    names = [step.task.base.name for step in walk.steps]
    assert names == ["up" if up else "down"] * 3 + ["paper base gait"]
    assert all(report.ok for report in walk.verify())
    for gait in walk.gaits[:3]:
        np.testing.assert_allclose(path_of(gait.frames)[-1], [0.29, riser if up else -riser], atol=2e-3)
    np.testing.assert_array_equal(walk.gaits[-1].frames[-1], ggo.STANDING)
    if begin == "on stairs":
        np.testing.assert_allclose(path_of(walk.gaits[0].frames)[0], [-0.29, -riser if up else riser], atol=1e-9)


FIRST_UP = replace(UP, first_step=replace(first_step(), dt=0.017))
MADE_DOWN = ggo.descend_stairs(PAPER, 0.16, tread=0.3, first_edge=0.2, steps=1)
FIRST_DOWN = replace(DOWN, first_step=replace(MADE_DOWN.gaits[0], name="first"))
WITH_FIRST = ggo.BaseGaits(PAPER, PAPER, up=FIRST_UP, down=FIRST_DOWN)
FROM_LEVEL = {"nowhere said": {}, "standing": {"start": ggo.STANDING}, "level": {"start": PAPER.frames[0]}}


@pytest.mark.parametrize("riser", [0.10, 0.15, 0.19])
@pytest.mark.parametrize("begin", FROM_LEVEL)
@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
def test_a_first_step_from_level_ground_bends_its_own_gait(procedure, begin, riser):
    walk = procedure(WITH_FIRST, riser, tread=0.29, first_edge=0.2, steps=3, to_standing=True, **FROM_LEVEL[begin])
    kind = "up" if procedure is ggo.climb_stairs else "down"
    assert [step.task.base.name for step in walk.steps] == ["first", kind, kind, "paper base gait"]
    assert [step.task.kind for step in walk.steps] == [f"first {kind}", kind, kind, "level"]
    assert all(report.ok for report in walk.verify())
    assert not any(walk.trajectory_faults(None))
    first = WITH_FIRST.gait(f"first {kind}", "right")
    begun = {"nowhere said": first.frames[0], "standing": ggo.STANDING, "level": PAPER.frames[0]}
    np.testing.assert_array_equal(walk.gaits[0].frames[0], begun[begin])


LAST_DOWN = ggo.descend_stairs(PAPER, 0.16, tread=0.3, first_edge=0.2, to_standing=True).gaits[-1]
WITH_ENDS = ggo.BaseGaits(
    PAPER,
    PAPER,
    up=replace(FIRST_UP, last_step=replace(last_step(), dt=0.02)),
    down=replace(FIRST_DOWN, last_step=replace(LAST_DOWN, name="last")),
)


@pytest.mark.parametrize("riser", [0.10, 0.19])
@pytest.mark.parametrize("begin", FROM_LEVEL)
@pytest.mark.parametrize("procedure", [ggo.climb_stairs, ggo.descend_stairs])
def test_a_last_step_to_feet_together_bends_its_own_gait(procedure, begin, riser, tmp_path):
    walk = procedure(WITH_ENDS, riser, tread=0.29, first_edge=0.2, steps=2, to_standing=True, **FROM_LEVEL[begin])
    kind = "up" if procedure is ggo.climb_stairs else "down"
    assert [step.task.kind for step in walk.steps] == [f"first {kind}", kind, f"last {kind}"]
    assert walk.steps[-1].task.base.name == "last"
    assert all(report.ok for report in walk.verify())
    assert not any(walk.trajectory_faults(None))
    np.testing.assert_array_equal(walk.gaits[-1].frames[-1], ggo.STANDING)
    assert len(walk.gaits[-1]) == len(WITH_ENDS.gait(f"last {kind}", "right"))
    if riser < 0.15:  # down higher stairs the knee has no room left for a change in mid-step
        walk.save(tmp_path / "walk.csv")
        again = ggo.replan(ggo.load_walk(tmp_path / "walk.csv"), step=3, at_frame=10, base=WITH_ENDS)
        assert [len(gait) for gait in again.gaits] == [len(gait) for gait in walk.gaits]


def test_a_first_step_is_bent_after_level_steps_and_kept_by_files_and_replans(tmp_path):
    ground = ggo.stair_ground(0.55, 0.3, [0.16])
    steps = [ggo.Step((0.4, 0.0), ground=ground), ggo.Step((0.3, 0.16), ground=ground.shifted(0.4, 0.0))]
    walk = ggo.walk(WITH_FIRST, steps)
    assert [step.task.kind for step in walk.steps] == ["level", "first up"]
    walk.save(tmp_path / "walk.csv")
    read = ggo.load_walk(tmp_path / "walk.csv")
    assert [gait.bent.ground for gait in read.gaits] == ["level", "first up"]
    for known, base in ((walk, None), (read, WITH_FIRST)):
        again = ggo.replan(known, step=2, at_frame=15, foothold=(0.31, 0.16), base=base)
        np.testing.assert_array_equal(again.gaits[1].frames[:16], known.gaits[1].frames[:16])
        assert all(report.ok for report in again.verify())
        assert {step.task.kind for step in again.steps[1:]} <= {"first up"}


def test_an_ascent_alone_knows_its_first_step():
    walk = ggo.climb_stairs(FIRST_UP, 0.16, tread=0.3, first_edge=0.2, steps=3, start=ggo.STANDING)
    assert [step.task.base.name for step in walk.steps] == ["first", "up", "up"]
    on_stairs = ggo.climb_stairs(FIRST_UP, 0.16, tread=0.3, first_edge=0.2)
    assert [step.task.base.name for step in on_stairs.steps] == ["up", "up"]


@pytest.mark.parametrize("bases", [BOTH, WITH_FIRST])
def test_each_steps_joints_move_on_as_they_moved(bases):
    walk = ggo.climb_stairs(bases, 0.17, tread=0.29, first_edge=0.2, steps=3)
    speeds = np.degrees(np.abs(np.diff(walk.joint_trajectory().positions, 2, axis=0)).max(axis=1))
    swaps = np.cumsum([len(gait) - 1 for gait in walk.gaits[:-1]]) - 1
    assert speeds[swaps].max() < np.delete(speeds, swaps).max()


def test_a_steady_step_is_the_stair_gait_itself():
    walk = ggo.climb_stairs(BOTH, 0.17, tread=0.29, first_edge=0.2, steps=4)
    same = walk.gaits[3].resampled(len(UP)).frames
    assert np.degrees(np.sqrt(np.mean((same - UP.frames) ** 2))) < 2.0
    level = ggo.climb_stairs(PAPER, 0.17, tread=0.29, first_edge=0.2, steps=4)
    assert walk.gaits[3].duration == pytest.approx(0.70, abs=0.01)
    assert level.gaits[3].duration == pytest.approx(0.50, abs=0.01)


def test_an_ascent_alone_begins_on_the_stairs_or_from_standing():
    alone, told = (ggo.climb_stairs(UP, 0.16, tread=0.3, first_edge=0.2, **how) for how in ({}, {"on_stairs": True}))
    for mine, theirs in zip(alone.gaits, told.gaits, strict=True):
        np.testing.assert_array_equal(mine.frames, theirs.frames)
    standing = ggo.climb_stairs(UP, 0.16, tread=0.3, first_edge=0.2, start=ggo.STANDING)
    assert all(report.ok for report in standing.verify())


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ggo.descend_stairs(UP, 0.16), "'up' walks stairs up, not down"),
        (lambda: ggo.adjust_stride(UP), r"'up' walks stairs, its feet 0\.170 m apart in height at the start"),
        (lambda: ggo.step_over(UP, [ggo.Obstacle(0.2, 0.25, 0.05)]), "walks stairs"),
        (lambda: ggo.walk(UP, [ggo.Step((0.4, 0.0))]), "walks stairs"),
        (lambda: ggo.climb_stairs(PAPER, on_stairs=True), "no base gait walks stairs in this direction"),
        (lambda: ggo.climb_stairs(UP, on_stairs=True, start=ggo.STANDING), "leave start out"),
    ],
)
def test_what_makes_no_sense_is_refused_with_the_reason(make, said):
    with pytest.raises(ggo.InputError, match=said):
        make()


def test_a_walk_chooses_by_where_each_step_lands():
    ground = ggo.stair_ground(0.55, 0.3, [0.16])
    steps = [ggo.Step((0.4, 0.0), ground=ground), ggo.Step((0.3, 0.16), ground=ground.shifted(0.4, 0.0))]
    walk = ggo.walk(BOTH, steps)
    assert [step.task.base.name for step in walk.steps] == ["paper base gait", "up"]
    again = ggo.replan(walk, step=1, at_frame=20, foothold=(0.38, 0.0))
    assert [step.task.base.name for step in again.steps] == ["paper base gait", "up"]
    assert [len(gait) for gait in again.gaits] == [51, 71]
