"""How far a bent gait is from what people did: every step of a recording, given its first frame and its foothold.

Three answers to "how does this person step there?" are compared by their RMSE over all frames and the four angles: the
base gait moved to the person's first frame, its offset constant ("no change"); the base gait bent by `walk` from that
frame and its joint speeds onto the person's own foothold; the same without landing edges.

The base gait is the mean of all strides, changed by the import so that it stands on the ground. The same change is
applied to every step, else the difference would tell of the import. Where a person's knee dips below straight, which
the check refuses, all knees of the recording and of its base gait are raised by one constant.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np
from rich.table import Table

import ggo_factors as ggo
from ggo_factors.cli.console import console
from ggo_factors.recording.log.joint_map import joint_map
from ggo_factors.recording.log.read_log import read_log
from ggo_factors.recording.strides.cut_strides import find_cycles
from ggo_factors.recording.strides.mean_step import closed_step, level_step, resampled_step, stand_with_bent_knees
from ggo_factors.recording.strides.selection import from_stair_to_stair
from ggo_factors.recording.strides.signals import clean, unit_of
from ggo_factors.recording.strides.steps import Step
from ggo_factors.support.inputs import Array

LEVEL = ("level_csic_s10", "level_nonan_middle", "level_opensim_rajagopal", "level_opensim_subject01")
STAIRS = ("stairs_wpi_s04_riser173", "stairs_wpi_s04_riser192")
LEVEL_GOAL, STAIR_GOAL = 0.85, 0.95
"""The bent gait is to be at most so many times as far from people as no change, on level ground and on stairs."""
STAIR_TO_STAIR = "from stair to stair"
"""Those stair swings alone that start on a stair, as the base gait does; of three the first starts from the ground."""
KNEE_SPARE = np.radians(0.5)
"""Least knee angle in [rad] that steps are raised to: the check refuses -0.3 degrees, also where a knee moves on to."""
EARLY = 3
"""Frames at the start of a step that are given, or follow from what is given."""
FOOT, PIT = 0.02, -0.5
"""Half the length of the ground under the supporting foot, and the height of the ground around it, both in [m]."""
KNEES = np.array([0.0, 1.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording as the comparison needs it.

    Attributes:
        name: name of the log.
        which: which of its steps.
        base: its base gait.
        steps: the person's steps, each as many frames as the base gait, shape (m, 4) in [rad].
        raised: the constant that all knees of base gait and steps are raised by in [rad].
        legs: the swinging leg of each step.
    """

    name: str
    which: str
    base: ggo.Gait
    steps: tuple[Array, ...]
    raised: float
    legs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Row:
    """What was found for the steps of one recording and the base gait of one, RMSE in [deg]."""

    log: str
    which: str
    base: str
    steps: int
    refused: int
    no_change_deg: float
    without_landing_deg: float
    bent_deg: float
    knees_raised_deg: float
    refusals: tuple[str, ...]

    @property
    def ratio(self) -> float:
        """How many times as far from the person the bent gait is as no change."""
        return self.bent_deg / self.no_change_deg


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path), envvar="GGO_RECORDINGS")
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as JSON instead of a table.")
def main(folder: Path, as_json: bool) -> None:
    """Compare bent gaits with what people did in the recordings in FOLDER, or in the one that GGO_RECORDINGS names."""
    level = [compare(recording, recording) for recording in (recorded(folder, name, "level") for name in LEVEL)]
    stairs, on_stairs = (_from_one_to_the_other(folder, which) for which in ("stairs-up", STAIR_TO_STAIR))
    means = {"level": _mean_ratio(level), "stairs": _mean_ratio(stairs), STAIR_TO_STAIR: _mean_ratio(on_stairs)}
    goals = {"level": LEVEL_GOAL, "stairs": STAIR_GOAL, STAIR_TO_STAIR: STAIR_GOAL}
    rows = [*level, *stairs, *on_stairs]
    if as_json:
        numbers = [vars(row) | {"ratio": row.ratio} for row in rows]
        click.echo(json.dumps({"format_version": 1, "logs": numbers, "mean_ratio": means, "goals": goals}, indent=1))
        return
    screen = console()
    screen.print(_table(rows))
    for kind, ratio in means.items():
        screen.print(f"{kind}: in the mean over the logs {ratio:.3f} times as far as no change; goal {goals[kind]}")
    for row in rows:
        for reason in row.refusals:
            screen.print(f"{row.log}: {reason}")


def recorded(folder: Path, name: str, which: str) -> Recording:
    """A log read: its base gait, and its steps as the import changes them.

    Args:
        folder: where the log lies, with a JSON file beside it that says which value is which joint.
        name: name of the log.
        which: ``"level"``, ``"stairs-up"`` or `STAIR_TO_STAIR`.
    """
    level = which == "level"
    truth = json.loads((folder / f"{name}.json").read_text())
    joints = ggo.JointMap(truth["joint_map"], truth["units"])
    path = folder / f"{name}.mcap"
    report = ggo.import_base_gait(path, joints=joints, min_strides=1, activity="level" if level else "stairs-up")
    count, base = len(report.gait), report.gait
    if level:
        steps = _steps_within(path, joints, report)
        mean = [level_step(np.vstack([cycle, cycle[:1]]), count) for cycle in report.mean_cycle.values()]
        uncorrected = np.mean(mean, axis=0)
    else:
        cuts = from_stair_to_stair(report.used) if which == STAIR_TO_STAIR else report.used
        steps = [cut for cut in cuts if isinstance(cut, Step)]
        mean = [resampled_step(frames, count) for frames in report.mean_cycle.values()]
        uncorrected = closed_step(np.mean(mean, axis=0))
    change = base.frames - uncorrected
    walked = [resampled_step(step.frames, count) + change for step in steps]
    least = min(float(frames[:EARLY, 1::2].min()) for frames in walked)
    raised = KNEE_SPARE - least if least < 0.0 else 0.0
    return with_knees_raised(Recording(name, which, base, tuple(walked), 0.0, tuple(s.leg for s in steps)), raised)


def with_knees_raised(recording: Recording, raised: float) -> Recording:
    """The recording with all knees raised by a constant in [rad] and the base gait on the ground again."""
    base = recording.base
    rise = float(base.endpoints()[-1, 1])
    stood, _ = stand_with_bent_knees(base.frames + raised * KNEES, base.legs(), rise)
    change = stood - base.frames
    steps = tuple(frames + change for frames in recording.steps)
    return replace(recording, base=replace(base, frames=stood), steps=steps, raised=recording.raised + raised)


def _steps_within(path: Path, joints: ggo.JointMap, report: ggo.ImportReport) -> list[Step]:
    """The level steps of a log that lie in a stride that its base gait is made of."""
    log = read_log(path, names=joints.names)
    chosen = joint_map(joints, log.names, log.source)
    cycles = find_cycles(clean(log, chosen, unit_of(chosen, None, log)), report.gait.legs())
    spans = [(stride.start - 1e-6, stride.end + 1e-6) for stride in report.used]
    return [step for step in cycles.steps if any(a <= step.start and step.end <= b for a, b in spans)]


def compare(source: Recording, person: Recording) -> Row:
    """Bend the base gait of one recording to every step of one, the same or another.

    Args:
        source: whose base gait.
        person: whose steps.
    """
    raised = max(source.raised, person.raised)  # alike for both: a constant between them would be a difference
    base = with_knees_raised(source, raised - source.raised).base
    steps = with_knees_raised(person, raised - person.raised).steps
    errors: list[tuple[Array, Array, Array]] = []
    refusals: Counter[str] = Counter()
    for frames in steps:
        try:
            bent, without = (bent_to(base, frames, landing) for landing in (None, False))
        except ggo.InfeasibleGaitError as error:
            refusals[str(error).split(";")[0]] += 1
            continue
        moved = base.frames + (frames[0] - base.frames[0])
        errors.append((moved - frames, without - frames, bent - frames))
    moved_off, without_off, bent_off = (_rms_deg(each[k] for each in errors) for k in range(3))
    return Row(
        log=person.name,
        which=person.which,
        base=source.name,
        steps=len(steps),
        refused=sum(refusals.values()),
        no_change_deg=moved_off,
        without_landing_deg=without_off,
        bent_deg=bent_off,
        knees_raised_deg=float(np.degrees(raised)),
        refusals=tuple(f"{count} refused: {reason}" for reason, count in refusals.most_common()),
    )


def bent_to(base: ggo.Gait, frames: Array, landing: bool | None, style: ggo.Style | None = None) -> Array:
    """The base gait bent to a person's first frame, its joint speeds, and the person's foothold, (m, 4) in [rad].

    Args:
        base: the base gait.
        frames: the person's step, shape (m, 4) in [rad].
        landing: as for `walk`.
        style: as for `walk`.
    """
    x, y = base.legs().endpoint(frames[-1]).tolist()
    # Where an ankle is at a strike, heels lifted, says nothing of the ground: it is under both feet only.
    ground = ggo.Ground((-FOOT, FOOT, x - FOOT), (PIT, 0.0, PIT, y))
    rate = (frames[1] - frames[0]) / base.dt
    step, begins = ggo.Step((x, y), ground=ground), {"start": frames[0], "start_rate": rate}
    walk = ggo.walk(base, [step], **begins, landing=landing, style=style)
    return walk.gaits[0].frames


def _from_one_to_the_other(folder: Path, which: str) -> list[Row]:
    """The base gait from one stair ascent and the steps of the other, and the reverse."""
    first, second = (recorded(folder, name, which) for name in STAIRS)
    return [compare(first, second), compare(second, first)]


def _rms_deg(errors: Iterable[Array]) -> float:
    """Root mean square of all angles in [deg]; NaN where every step was refused."""
    angles = list(errors)
    return float(np.degrees(np.sqrt(np.mean(np.square(angles))))) if angles else float("nan")


def _mean_ratio(rows: Sequence[Row]) -> float:
    """Mean RMSE of the bent gaits by that of no change; every log counts the same, however many steps it has."""
    return sum(row.bent_deg for row in rows) / sum(row.no_change_deg for row in rows)


def _table(rows: Sequence[Row]) -> Table:
    title = "Distance from what people did, RMSE over frames and joints in degrees"
    table = Table(title=title, title_justify="left")
    names = ("steps of", "which", "base gait of")
    headings = (*names, "steps", "refused", "no change", "without landing", "bent", "ratio", "knees +")
    for heading in headings:
        table.add_column(heading, justify="left" if heading in names else "right")
    for row in rows:
        base = "the same" if row.base == row.log else row.base
        numbers = (row.no_change_deg, row.without_landing_deg, row.bent_deg)
        cells = (f"{number:.2f}" for number in numbers)
        counts = (str(row.steps), str(row.refused))
        table.add_row(row.log, row.which, base, *counts, *cells, f"{row.ratio:.3f}", f"{row.knees_raised_deg:.1f}")
    return table


if __name__ == "__main__":
    main()
