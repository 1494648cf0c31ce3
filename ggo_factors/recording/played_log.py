"""Logs of played gaits: those that this library exported say when each step lands, and joints repeat themselves."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from scipy.interpolate import CubicSpline

from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.strides.signals import Signals
from ggo_factors.recording.strides.steps import LEGS, RISE, SAMPLES, Step
from ggo_factors.support.inputs import Array

LANDINGS_KEY = "landings_s"
"""Key of the metadata record `gait` of an exported log: the times in [s] at which its steps land, from its start on."""
REPEATS_DEG = 0.5
"""Swings that differ by less, RMS in degrees in the median, were not walked but played: people's differ by 2 to 4."""


@dataclass(frozen=True, eq=False)
class Landings:
    """When the steps of an exported log begin and land.

    Attributes:
        times: start of the first step, then each landing, in [s].
        first_swing: the leg that swings in the first step.
    """

    times: Array
    first_swing: str


def told_landings(source: object) -> Landings | None:
    """What an MCAP file says of its steps, if this library exported it; None where it says nothing."""
    if not isinstance(source, str | os.PathLike) or not Path(source).is_file():
        return None
    try:
        with Path(source).open("rb") as file:
            said = next((r.metadata for r in make_reader(file).iter_metadata() if r.name == "gait"), {})
        times = np.array([float(word) for word in said[LANDINGS_KEY].split()])
        first = said["first_swing"]
    except (OSError, McapError, KeyError, ValueError, EOFError):
        return None
    if first not in LEGS or not len(times) or not (np.diff(times, prepend=0.0) > 0.0).all():
        return None
    return Landings(np.append(0.0, times), first)


def steps_between(landings: Landings, signals: Signals, model: LegModel) -> tuple[Step, ...]:
    """The steps of an exported log: its feet are flat, so the ankles are as far apart as the treads when one lands."""
    steps = []
    for stretch in signals.stretches:
        if not np.isfinite(stretch.angles).all():
            continue
        spline = CubicSpline(stretch.times, stretch.angles)
        for number, (start, end) in enumerate(zip(landings.times[:-1], landings.times[1:], strict=True)):
            if start < stretch.times[0] - stretch.dt or end > stretch.times[-1] + stretch.dt:
                continue
            swing = (LEGS.index(landings.first_swing) + number) % 2
            columns = [2, 3, 0, 1] if swing == 0 else [0, 1, 2, 3]
            frames = np.asarray(spline(np.linspace(start, end, SAMPLES + 1)))[:, columns]
            ahead, rise = model.endpoint(frames[-1]).tolist()
            high = abs(rise) > RISE * model.reach
            activity = ("stairs-up" if rise > 0.0 else "stairs-down") if high else "level"
            steps.append(Step(LEGS[swing], float(start), float(end), frames, activity, rise, ahead, ahead))
    return tuple(steps)


def repetition_notes(swings: Sequence[Step]) -> Iterator[str]:
    """Whether stair swings were played and not walked, though it is not known when they land."""
    for apart in (1, 2):  # the other leg's, and the same leg's
        pairs = zip(swings[:-apart], swings[apart:], strict=True)
        off = np.degrees([float(np.sqrt(np.mean((one.frames - other.frames) ** 2))) for one, other in pairs])
        if len(off) > 1 and np.median(off) < REPEATS_DEG:
            yield (
                f"the stair swings repeat within {np.median(off):.2f} degrees: were they played, not walked? riser and "
                f"tread are told from how people walk, whose heels lift; of flat feet they are some cm off"
            )
            return
