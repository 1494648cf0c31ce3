"""Steps of many recordings, person by person, and the style learned from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ggo_factors.errors import InputError, LogError
from ggo_factors.evaluate.style_learning import learn_style
from ggo_factors.motion.gait import PAPER_MODEL
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.recording.base_gait import _read
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.recording.plausible import check_angles, check_walking
from ggo_factors.recording.strides.cut_strides import Cycles, find_cycles
from ggo_factors.recording.strides.selection import level_strides, stair_swings
from ggo_factors.recording.strides.signals import clean, unit_of
from ggo_factors.recording.strides.steps import ACTIVITIES, Step
from ggo_factors.support.files import PathLike

WITHIN = 1e-6
"""A step that ends so much in [s] after a stride ends with it."""


def usable_steps(cycles: Cycles, activity: str) -> list[Step]:
    """The steps that a base gait is made of, in the order in which they were walked.

    Args:
        cycles: what was found in a recording.
        activity: one of `ACTIVITIES`.
    """
    if activity != "level":
        return [swing for swing in stair_swings(cycles, activity) if not swing.reason]
    spans = [(stride.start - WITHIN, stride.end + WITHIN) for stride in level_strides(cycles) if not stride.reason]
    return [step for step in cycles.steps if any(a <= step.start and step.end <= b for a, b in spans)]


def learn_from_logs(
    logs: Sequence[PathLike],
    *,
    topic: str | None = None,
    joints: PathLike | JointMap | None = None,
    unit: str | None = None,
    model: LegModel | None = None,
    activity: str = "level",
    progress: Callable[[float], None] | None = None,
) -> Style:
    """Learn a style from recordings, each of another person.

    Args:
        logs: MCAP files or rosbag2 folders.
        topic: as for `import_base_gait`, the same for all, as what follows.
        joints: as for `import_base_gait`.
        unit: as for `import_base_gait`.
        model: as for `import_base_gait`.
        activity: as for `import_base_gait`.
        progress: called with the part that has been read, 0 to 1.

    Raises:
        InputError: where an argument is wrong.
        LogError: where a recording cannot be read, or all together hold too few steps.
    """
    if activity not in ACTIVITIES:
        raise InputError(f"activity: expected {', '.join(map(repr, ACTIVITIES))}, got {activity!r:.40}")
    if not logs:
        raise InputError("logs: give one recording or more")
    legs, found = model or PAPER_MODEL, list[tuple[str, Step]]()
    for number, path in enumerate(logs):
        share = None if progress is None else _part(progress, number, len(logs))
        log, chosen = _read(path, topic, joints, share)
        signals = clean(log, chosen, unit_of(chosen, unit, log))
        check_angles(signals, chosen, log.source)
        cycles = find_cycles(signals, legs)
        check_walking(cycles, legs, log.source)
        found += [(str(number), step) for step in usable_steps(cycles, activity)]
    if not found:
        raise LogError(f"{', '.join(map(str, logs))}: no usable {activity} step found")
    people, steps = zip(*found, strict=True)
    try:
        return learn_style(
            np.stack([step.frames for step in steps]), legs, legs=[step.leg for step in steps], people=people
        )
    except InputError as error:
        raise LogError(f"{', '.join(map(str, logs))}: no style can be learned: {error}") from error


def _part(progress: Callable[[float], None], number: int, count: int) -> Callable[[float], None]:
    return lambda share: progress((number + share) / count)
