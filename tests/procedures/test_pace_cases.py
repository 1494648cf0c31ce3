"""A seeded sample of the campaign of paces (tests/campaign/test_pace.py): boxes, sampling rates, refusals."""

from __future__ import annotations

import re

import pytest
from bare_bones import pointed, random_boxes
from paces import TIGHT, base_gait, beyond

import ggo_factors as ggo
from ggo_factors.check.report import STANDARD
from ggo_factors.walking.pace import allowed_landing_speed
from ggo_factors.walking.walk import Walk

LIMITS = ggo.JointLimits()


@pytest.mark.parametrize("name", ["paper", "sample"])
def test_boxes_within_limits(name):
    base = base_gait(name)
    foothold, landing = (float(base.endpoints()[-1, 0]), 0.0), allowed_landing_speed(base, base.legs())
    slowed = 0
    for box in random_boxes(foothold[0], 5, seed=14):
        made = ggo.step_over(base, [ggo.Obstacle(*box)], foothold=foothold, limits=LIMITS)
        walk = Walk((made.gait,), (made.task.step,), limits=LIMITS, landing_speed=landing)
        assert beyond(walk, LIMITS) <= 1.0 + STANDARD.limits, box
        assert walk.verify()[0].ok, box
        assert made.report.landing_speed <= landing * (1.0 + STANDARD.limits), box
        assert any("slowed" in note for note in made.report.notes) == (made.gait.slowdown > 1.0), box
        slowed += made.gait.slowdown > 1.0
    assert slowed >= 2


@pytest.mark.parametrize("pace", [1.0, "auto"])
@pytest.mark.parametrize(
    ("limits", "box", "makes"), [(LIMITS, (0.12, 0.16, 0.08), True), (TIGHT, (0.20, 0.25, 0.15), False)]
)
def test_verdicts_at_every_rate(limits, box, makes, pace):
    for frames in (51, 151):
        base = pointed(ggo.paper_base_gait(frames))
        try:
            ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0), limits=limits, pace=pace)
            made = True
        except ggo.InfeasibleGaitError:
            made = False
        assert made == (makes or pace == "auto"), frames


def test_a_refusal_says_at_which_pace_it_works():
    base, said = ggo.paper_base_gait(), 0
    for box in random_boxes(0.39, 4, seed=5, hard=True):
        try:
            ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0), limits=LIMITS, pace=1)
        except ggo.InfeasibleGaitError as error:
            (times,) = re.findall(r"works at ([0-9.]+) times the time", str(error))
            made = ggo.step_over(
                base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0), limits=LIMITS, pace=1.0 / float(times)
            )
            assert made.gait.duration == pytest.approx(0.5 * float(times))
            slowed = ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0), limits=LIMITS)
            # Slow only where it must be.
            assert slowed.gait.duration < made.gait.duration, box
            said += 1
    assert said >= 2
