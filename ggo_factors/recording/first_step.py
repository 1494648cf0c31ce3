"""The first step of a flight: from level ground onto the first stair, the mean of a recording's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ggo_factors.motion.gait import Gait
from ggo_factors.motion.recorded import Recorded
from ggo_factors.recording.each_leg import KINDS
from ggo_factors.recording.report import ImportReport
from ggo_factors.recording.strides.mean_step import first_step_with_bent_knees, resampled_step, spread
from ggo_factors.recording.strides.selection import alike
from ggo_factors.recording.strides.steps import LEGS, Step

LEVEL_SHARE = 0.5
"""A swing starts from level ground where its feet are apart in height by less than this share of the riser: half way
between level ground and the next stair. A trailing ankle that its heel lifts is 0.02 to 0.05 m off."""
ENDS_DEG = 25.0
"""A first step whose ends must change by more degrees to stand on the ground and the stair is none: as much as other
steps on stairs may change."""


def with_first_step(report: ImportReport, swings: Sequence[Step]) -> ImportReport:
    """An import of stairs whose gaits know the first step of the flight, where the recording has one.

    Args:
        report: the import.
        swings: all swings of its activity, used or not, of the legs that it is made of.
    """
    found = _from_level_ground(swings, report)
    made = {leg: _first_gait([swing for swing in found if swing.leg == leg], report, leg) for leg in LEGS}
    known = {leg: gait for leg, gait in made.items() if gait is not None}
    if not known:
        none = "no swing starts from level ground: a first step onto the stairs bends the gait from stair to stair"
        return replace(report, notes=(*report.notes, none))
    one = next(iter(known.values()))
    mean = one if len(known) == 1 else _first_gait(found, report, "both")
    said = (
        f"{len(found)} swing{' starts' if len(found) == 1 else 's start'} from level ground: the first step onto the "
        f"stairs (Gait.first_step), {one.duration if mean is None else mean.duration:.2f} s"
    )
    return replace(
        report,
        mean_gait=replace(report.mean_gait, first_step=mean),
        left=replace(report.left, first_step=known.get("left", one)),
        right=replace(report.right, first_step=known.get("right", one)),
        decisions=(*report.decisions, said),
    )


def _from_level_ground(swings: Sequence[Step], report: ImportReport) -> list[Step]:
    """The swings that start with both feet on level ground and are alike."""
    assert report.riser is not None  # a stair gait's report has it
    legs, ends = report.mean_gait.legs(), {swing.end for swing in swings}
    first = [
        replace(swing, reason="")
        for swing in swings
        if swing.start not in ends and abs(float(legs.endpoint(swing.frames[0])[1])) < LEVEL_SHARE * report.riser
    ]
    return [swing for swing in alike(first) if not swing.reason]


def _first_gait(swings: Sequence[Step], report: ImportReport, leg: str) -> Gait | None:
    """The mean of first steps as a gait; each leg counts the same. None without any, or where they stand nowhere."""
    stacks = [np.stack(rows) for one in LEGS if (rows := [swing.frames for swing in swings if swing.leg == one])]
    if not stacks:
        return None
    assert report.riser is not None
    rise = report.riser if report.activity == "stairs-up" else -report.riser
    count, model = len(report.mean_gait), report.mean_gait.legs()
    mean = resampled_step(np.mean([stack.mean(axis=0) for stack in stacks], axis=0), count)
    frames = first_step_with_bent_knees(mean, model, rise)
    if np.degrees(np.abs(frames - mean).max()) > ENDS_DEG:
        return None
    deviation = np.sqrt(np.mean([spread(stack) ** 2 for stack in stacks], axis=0))
    swing = leg if len(stacks) == 1 else "both"
    kept = Recorded(
        len(swings), np.maximum(resampled_step(deviation, count), 0.0), f"first {KINDS[report.activity]}", swing
    )
    duration = float(np.mean([step.duration for step in swings]))
    return Gait(
        frames,
        duration / (count - 1),
        f"{report.mean_gait.name}, first step",
        f"{report.mean_gait.origin}, {len(swings)} from level ground",
        model,
        recorded=kept,
    )
