"""The ends of a flight: from level ground onto the first stair, and from the last one to feet together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ggo_factors.motion.base_gaits import with_flight_step
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.recorded import Recorded
from ggo_factors.recording.each_leg import KINDS
from ggo_factors.recording.report import ImportReport
from ggo_factors.recording.strides.cut_strides import Cycles
from ggo_factors.recording.strides.mean_step import flight_end_with_bent_knees, resampled_step, spread
from ggo_factors.recording.strides.selection import alike
from ggo_factors.recording.strides.signals import Signals
from ggo_factors.recording.strides.steps import LEGS, LONGEST_STEP_S, SAMPLES, SHORTEST_STEP_S, Step

LEVEL_SHARE = 0.5
"""A swing starts from level ground where its feet are apart in height by less than this share of the riser: half way
between level ground and the next stair. A trailing ankle that its heel lifts is 0.02 to 0.05 m off."""
ENDS_DEG = 25.0
"""A first or last step whose ends must change by more degrees to stand on the ground and the stair is none: as much as
other steps on stairs may change."""
STILL_DEG = 15.0
"""A walker whose joints are all slower than this, in [deg/s], ..."""
STILL_S = 0.2
"""... for so long, in [s], or to the end of the log, stands: swinging legs reach 200 deg/s and more, and no joint rests
so long in a swing."""
TOGETHER = 0.1
"""Feet no further apart than this, forward and in height in [m], are together: a person's stand 0 to 0.05 apart."""
SAME_TIME = 1e-6
"""Strikes that differ by no more in [s] are the same."""


def with_flight_ends(
    report: ImportReport, swings: Sequence[Step], cycles: Cycles, signals: Signals, leg: str
) -> ImportReport:
    """An import of stairs whose gaits know first and last step of the flight, where the recording has them.

    Args:
        report: the import.
        swings: all swings of its activity, used or not.
        cycles: all steps of the recording.
        signals: its angles.
        leg: what the gaits are made of, as for `import_base_gait`.
    """
    taken = (leg,) if leg in LEGS else LEGS
    first = [swing for swing in _from_level_ground(swings, report) if swing.leg in taken]
    last = [swing for swing in _closing(swings, cycles, signals, report) if swing.leg in taken]
    whose = f"{leg} swing" if leg in LEGS else "swing"
    report = _with(report, "first", first, whose)
    return _with(report, "last", last, whose)


def _with(report: ImportReport, end: str, swings: Sequence[Step], whose: str) -> ImportReport:
    """The import with the mean of these swings at one end of the flight; `whose` names them where there are none."""
    made = {leg: _mean_gait([swing for swing in swings if swing.leg == leg], report, end, leg) for leg in LEGS}
    known = {leg: gait for leg, gait in made.items() if gait is not None}
    begins = end == "first"
    if not known:
        what, bends = (
            ("starts from level ground", "gait from stair to stair") if begins else ("ends feet together", "level gait")
        )
        none = f"no {whose} on these stairs {what}: the {end} step of a flight bends the {bends}"
        return replace(report, notes=(*report.notes, none))
    one = next(iter(known.values()))
    mean = one if len(known) == 1 else _mean_gait(swings, report, end, "both") or one
    what = "from level ground onto the stairs" if begins else "from the stairs to feet together"
    said = f"{len(swings)} swing{'' if len(swings) == 1 else 's'} {what}: Gait.{end}_step, {mean.duration:.2f} s"
    return replace(
        report,
        mean_gait=with_flight_step(report.mean_gait, f"{end}_step", mean),
        left=with_flight_step(report.left, f"{end}_step", known.get("left", one)),
        right=with_flight_step(report.right, f"{end}_step", known.get("right", one)),
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


def _closing(swings: Sequence[Step], cycles: Cycles, signals: Signals, report: ImportReport) -> list[Step]:
    """The swings after the last stair of each flight that bring the feet together, and are alike.

    Such a swing has no heel strike: it ends where the walker stands still.
    """
    found = []
    for swing in swings:
        after = [step for step in cycles.steps if abs(step.start - swing.end) < SAME_TIME]
        closing = after[0] if after else _until_standing(swing, signals, report)
        if closing is not None and closing.activity == "level":
            apart = np.abs(report.mean_gait.legs().endpoint(closing.frames[-1]))
            found += [closing] if apart.max() < TOGETHER else []
    return [swing for swing in alike(found) if not swing.reason]


def _until_standing(swing: Step, signals: Signals, report: ImportReport) -> Step | None:
    """What the other leg does after a swing until the walker stands; None where the walker does not, or it is lost."""
    for stretch in signals.stretches:
        inside = (stretch.times >= swing.end - SAME_TIME) & (stretch.times <= swing.end + LONGEST_STEP_S)
        angles = stretch.angles[inside] if swing.leg == LEGS[0] else swap_roles(stretch.angles[inside])
        if len(angles) < 3 or stretch.times[0] > swing.end:
            continue
        speeds = np.degrees(np.abs(np.gradient(angles, stretch.dt, axis=0)).max(axis=1))
        apart = np.abs(report.mean_gait.legs().endpoint(angles)).max(axis=1)
        moves, long = ~((speeds < STILL_DEG) & (apart < TOGETHER)), round(STILL_S / stretch.dt)  # so are lost samples
        still = np.flatnonzero([not moves[n : n + long].any() for n in range(len(moves))])
        if not len(still) or not np.isfinite(angles[: still[0] + 1]).all() or still[0] * stretch.dt < SHORTEST_STEP_S:
            return None
        count = int(still[0]) + 1
        frames = resampled_step(angles[:count], SAMPLES + 1)
        leg = LEGS[1 - LEGS.index(swing.leg)]
        end = swing.end + (count - 1) * stretch.dt
        ahead = float(report.mean_gait.legs().endpoint(frames[-1])[0])
        return Step(leg, swing.end, end, frames, "level", 0.0, ahead, 0.0)
    return None


def _mean_gait(swings: Sequence[Step], report: ImportReport, end: str, leg: str) -> Gait | None:
    """The mean of such steps as a gait; each leg counts the same. None without any, or where they stand nowhere."""
    stacks = [np.stack(rows) for one in LEGS if (rows := [swing.frames for swing in swings if swing.leg == one])]
    if not stacks:
        return None
    assert report.riser is not None
    rise = report.riser if report.activity == "stairs-up" else -report.riser
    count, model = len(report.mean_gait), report.mean_gait.legs()
    mean = resampled_step(np.mean([stack.mean(axis=0) for stack in stacks], axis=0), count)
    frames = flight_end_with_bent_knees(mean, model, (0.0, rise) if end == "first" else (-rise, 0.0))
    if np.degrees(np.abs(frames - mean).max()) > ENDS_DEG:
        return None
    deviation = np.sqrt(np.mean([spread(stack) ** 2 for stack in stacks], axis=0))
    kept = Recorded(
        len(swings),
        np.maximum(resampled_step(deviation, count), 0.0),
        f"{end} {KINDS[report.activity]}",
        leg if len(stacks) == 1 else "both",
    )
    duration = float(np.mean([step.duration for step in swings]))
    return Gait(
        frames,
        duration / (count - 1),
        f"{report.mean_gait.name}, {end} step",
        f"{report.mean_gait.origin}, {len(swings)} {'from level ground' if end == 'first' else 'to feet together'}",
        model,
        recorded=kept,
    )
