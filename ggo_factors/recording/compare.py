"""`compare`: a base gait bent to the starts and footholds of a recording's own steps, beside what the person did."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.evaluate.likeness import LEAST_FRAMES, ComparedStep, Comparison, compare_step
from ggo_factors.motion.base_gaits import LEGS, BaseGaits, both
from ggo_factors.motion.gait import PAPER_MODEL, Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import LEAST_STEPS, Style
from ggo_factors.recording.base_gait import import_base_gait
from ggo_factors.recording.each_leg import KINDS, closed_pair
from ggo_factors.recording.learning import style_of_steps
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.recording.report import ImportReport
from ggo_factors.recording.sources.open_log import LogLike
from ggo_factors.recording.strides.mean_step import closed_step, resampled_step, steps_with_bent_knees
from ggo_factors.recording.strides.steps import Step
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_count, as_instance, as_progress

KNEES = np.array([0.0, 1.0, 0.0, 1.0])
"""The knees of a frame."""
KNEE_SPARE = math.radians(0.5)
"""Least knee angle in [rad] that steps are raised to where they bend backwards: the check refuses -0.3 degrees, also
where a knee moves on to from the start."""
FRAMES = 51
"""Frames of every step that is compared, as an import has. The motion at the start is given by the first two: with as
many as the base gait has, the time that they see would depend on its rate, and errors on that by up to 0.2 degrees."""
GIVEN = 3
"""Frames at the start of a step that are given, or follow from what is given."""
LEAST_OF_LEG = 3
"""Fewest steps of each leg on level ground, or of both on stairs, that an own base gait is made of."""
READING = 0.2
"""The part of `compare`'s progress that is the reading."""


def compare(
    base: Gait | BaseGaits | None,
    log: LogLike,
    *,
    topic: str | None = None,
    joints: PathLike | JointMap | None = None,
    unit: str | None = None,
    model: LegModel | None = None,
    activity: str = "level",
    skip: int = 0,
    progress: Callable[[float], None] | None = None,
    largest_chunk: int = CHUNK_MIB,
    style: Style | None = None,
) -> Comparison:
    """Compare gaits with what a person did: each step of a recording, given its start frame, motion and foothold.

    The steps are those that `import_base_gait` would make a base gait of (on stairs those from stair to stair, where
    there are any), at equal shares of their time: the pace is not compared. Of several base gaits each step is compared
    with that of its swinging leg, on stairs with that for stairs where there is one. As an import changes the mean step
    so that both feet stand on the ground, every step is changed by the same, that of its leg where each has its own
    base gait, else the errors would tell of the import. For numbers that hold for steps nobody has seen, the base gait
    must not be made of the steps that are compared: `skip`.

    With a style that helps, the library's gaits are made with it too (`ggo_style`); where it does not help,
    `Comparison.why_no_style` says why.

    Args:
        base: the base gait that is bent, or several, with their legs; None for own ones, made of the steps that are
            skipped: one for each leg on level ground, one for both on stairs.
        log: the recording, as for `import_base_gait`.
        topic: as for `import_base_gait`.
        joints: as for `import_base_gait`.
        unit: as for `import_base_gait`.
        model: the walker's legs; those of the base gait if None, without one the paper's.
        activity: as for `import_base_gait`: which steps.
        skip: how many steps at the beginning are not compared.
        progress: called with the share that is done, 0 to 1.
        largest_chunk: as for `import_base_gait`.
        style: how the person varies steps, see `learn_style` and `load_style`. If None and the base gaits are own ones,
            it is learned from the steps that are skipped, where those are 12 or more; else there is none.

    Raises:
        InputError: where an argument or the joint map is wrong, or no step is left.
        LogError: where the recording cannot be read or holds no such steps, see `import_base_gait`.
    """
    skip, progress = as_count(skip, "skip", 0), as_progress(progress)
    if style is not None:
        as_instance(style, "style", Style)
    if base is not None:
        model = both(base).legs(model)
        base = both(base).changed(lambda gait: replace(gait, model=model))
        least = min(map(len, _pair(base, activity)))
        if least < LEAST_FRAMES:
            raise InputError(f"base: {least} frames, a comparison needs at least {LEAST_FRAMES}")
    report = import_base_gait(
        log,
        topic=topic,
        joints=joints,
        unit=unit,
        model=model or PAPER_MODEL,
        min_strides=1,
        activity=activity,
        progress=None if progress is None else lambda part: progress(READING * part),
        largest_chunk=largest_chunk,
        frames=FRAMES,
        leg="each",
    )
    if skip >= len(report.steps):
        raise InputError(f"skip: {skip} steps, {report.source} has {len(report.steps)} ({activity})")
    why_not = ""
    if base is None:
        base, correction = _own(report, skip)
        if style is None:
            style, why_not = _own_style(report, skip)
    elif _one_for_both(base, activity):
        correction = dict.fromkeys(LEGS, report.correction)
    else:
        _, correction = _stood(report, report.steps, True)
    if style is not None and not style.helps:
        why_not = style.why_not
        style = None
    return replace(_compared(base, style, report, correction, skip, progress), why_no_style=why_not)


def _pair(base: BaseGaits, activity: str) -> tuple[Gait, Gait]:
    """The base gaits of the left and the right leg for an activity."""
    left, right = (base.gait(KINDS.get(activity, "level"), leg) for leg in LEGS)
    return left, right


def _one_for_both(base: BaseGaits, activity: str) -> bool:
    left, right = _pair(base, activity)
    return left is right


def _own(report: ImportReport, count: int) -> tuple[BaseGaits, Mapping[str, Array]]:
    """Base gaits of the first steps of a recording as an import makes them, and what was added to the means by leg.

    Raises:
        InputError: where they are too few.
    """
    used = report.steps[:count]
    level = report.activity == "level"
    by_leg = {leg: [step for step in used if step.leg == leg] for leg in LEGS}
    fewest = min(map(len, by_leg.values())) if level else len(used)
    if fewest < LEAST_OF_LEG:
        what = "steps of each leg" if level else "steps"
        raise InputError(f"skip: {fewest} {what} are skipped, a base gait of them needs {LEAST_OF_LEG}")
    stood, correction = _stood(report, used, level)
    name, origin = f"first {count} steps of {report.mean_gait.name}", report.source.replace("\n", " ")
    gaits = {}
    for leg in LEGS:
        frames, timed = stood[leg], by_leg[leg] if level else used
        duration = float(np.mean([step.duration for step in timed]))
        gaits[leg] = Gait(frames, duration / (len(frames) - 1), name, origin, report.mean_gait.legs())
    return (BaseGaits(gaits["left"], gaits["right"]) if level else both(gaits["left"])), correction


def _own_style(report: ImportReport, count: int) -> tuple[Style | None, str]:
    """The style of the first steps of a recording; where they are too few to learn from none, and that they are."""
    if count < LEAST_STEPS:
        return None, f"{count} steps are skipped, fewer than {LEAST_STEPS} to learn a style from"
    return style_of_steps(report.steps[:count], report.mean_gait.legs(), report.activity), ""


def _stood(report: ImportReport, steps: Sequence[Step], each: bool) -> tuple[Mapping[str, Array], Mapping[str, Array]]:
    """The mean step of each leg on the ground, or that of both, and what was added to it, by leg, (m, 4) in [rad]."""
    level, count = report.activity == "level", len(report.mean_gait)
    stacks = {leg: [step.frames for step in steps if step.leg == leg] for leg in LEGS}
    means = {leg: resampled_step(np.mean(stack, axis=0), count) for leg, stack in stacks.items() if stack}
    one = np.mean(list(means.values()), axis=0)
    left, right = (np.asarray(means.get(leg, one)) for leg in LEGS)
    made = closed_pair(left, right) if each else (closed_step(one),)
    rise = 0.0 if level else float(np.mean([step.rise for step in steps]))
    travel = None if level else float(np.mean([step.travel for step in steps]))
    stood, _ = steps_with_bent_knees(made, report.mean_gait.legs(), rise, travel)
    added = [after - before for after, before in zip(stood, made, strict=True)]
    # One step serves both legs: the first is also the last.
    return {"left": stood[0], "right": stood[-1]}, {"left": added[0], "right": added[-1]}


def _compared(
    base: BaseGaits,
    style: Style | None,
    report: ImportReport,
    correction: Mapping[str, Array],
    skip: int,
    progress: Callable[[float], None] | None,
) -> Comparison:
    """All steps but the first ones, one after the other."""
    steps = report.steps[skip:]
    walked = [resampled_step(step.frames, len(report.mean_gait)) + correction[step.leg] for step in steps]
    raised = _raise_of(walked)
    compared = []
    for number, (step, frames) in enumerate(zip(steps, walked, strict=True), start=1):
        compared.append(_compare_one(base, style, step, frames + raised * KNEES, raised))
        if progress is not None:
            progress(1.0 - (1.0 - READING) * (1.0 - number / len(steps)))
    return Comparison(
        base=" and ".join(dict.fromkeys(gait.name for gait in _pair(base, report.activity))),
        source=report.source,
        activity=report.activity,
        steps=tuple(compared),
        skipped=skip,
        from_ground=0 if report.activity == "level" else len(report.used) - len(report.steps),
        knees_raised=raised,
        model=base.legs(),
        style=style,
    )


def _raise_of(steps: Sequence[Array]) -> float:
    """The constant in [rad] that straightens no knee of any step's given frames beyond what can be walked."""
    least = min(float(frames[:GIVEN, 1::2].min()) for frames in steps)
    return KNEE_SPARE - least if least < 0.0 else 0.0


def _compare_one(base: BaseGaits, style: Style | None, step: Step, frames: Array, raised: float) -> ComparedStep:
    bent = base_of(base, step).resampled(len(frames))
    # A constant between the person's knees and the base gait's would be a difference: both are raised alike.
    bent = replace(bent, frames=bent.frames + raised * KNEES)
    made, refused = compare_step(bent, frames, style)
    x, y = bent.legs().endpoint(frames[-1]).tolist()
    return ComparedStep(step.leg, step.start, step.end, (x, y), frames, made, refused)


def base_of(base: BaseGaits, step: Step) -> Gait:
    """The base gait that a step of a recording is bent from: that of the leg that swings, on its kind of ground."""
    left, right = _pair(base, step.activity)
    return left if step.leg == "left" else right
