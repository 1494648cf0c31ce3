"""Steps of recordings, person by person, and the style learned from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ggo_factors.errors import InputError, LogError
from ggo_factors.evaluate.style_learning import learn_style
from ggo_factors.motion.gait import PAPER_MODEL
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import LEAST_STEPS, Style
from ggo_factors.recording.base_gait import import_base_gait
from ggo_factors.recording.each_leg import KINDS
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.recording.report import ImportReport
from ggo_factors.recording.strides.steps import Step
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_progress


def style_of(report: ImportReport) -> Style | None:
    """The style of the steps of one import; None where there are too few, or held-out steps say that it does not help.

    Args:
        report: of the import. Its steps are each compared with the mean of the leg that swings.
    """
    if len(report.steps) < LEAST_STEPS:
        return None
    learned = style_of_steps(report.steps, report.left.legs(), report.activity)
    return learned if learned.helps else None


def style_of_steps(steps: Sequence[Step], model: LegModel, activity: str, people: Sequence[str] | None = None) -> Style:
    """The style of recorded steps of one activity, each compared with the mean of its walker and swinging leg.

    Args:
        steps: in the order in which they were walked.
        model: the legs that their angles were read with.
        activity: as for `import_base_gait`.
        people: who walked each step; one person if None.

    Raises:
        InputError: where they are too few to learn from, see `learn_style`.
    """
    frames, legs = np.stack([step.frames for step in steps]), [step.leg for step in steps]
    return replace(learn_style(frames, model, legs=legs, people=people), ground=KINDS[activity])


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
    progress = as_progress(progress)
    if not logs:
        raise InputError("logs: give one recording or more")
    legs, found = model or PAPER_MODEL, list[tuple[str, Step]]()
    for number, path in enumerate(logs):
        report = import_base_gait(
            path,
            topic=topic,
            joints=joints,
            unit=unit,
            model=model,
            min_strides=1,
            activity=activity,
            progress=None if progress is None else _part(progress, number, len(logs)),
            leg="each",
        )
        found += [(str(number), step) for step in report.steps]
    if not found:
        raise LogError(f"{', '.join(map(str, logs))}: no usable {activity} step found")
    people, steps = zip(*found, strict=True)
    try:
        return style_of_steps(steps, legs, activity, people)
    except InputError as error:
        raise LogError(f"{', '.join(map(str, logs))}: no style can be learned: {error}") from error


def _part(progress: Callable[[float], None], number: int, count: int) -> Callable[[float], None]:
    return lambda share: progress((number + share) / count)
