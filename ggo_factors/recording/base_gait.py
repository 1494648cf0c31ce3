"""From a recording to a base gait: one step, the same for both legs, that stands on the ground at both ends."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ggo_factors.check.verify import verify
from ggo_factors.errors import InputError, LogError
from ggo_factors.motion.gait import PAPER_MODEL, Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.each_leg import EVERY_LEG, closed_pair, left_share, level_pair, recorded_strides
from ggo_factors.recording.flight_ends import with_flight_ends
from ggo_factors.recording.log.decompress import CHUNK_MIB
from ggo_factors.recording.log.joint_log import JointLog
from ggo_factors.recording.log.joint_map import JointMap
from ggo_factors.recording.log.joint_table import BRIDGE_S
from ggo_factors.recording.plausible import (
    check_angles,
    check_level_gait,
    check_one_gait,
    check_stair_gait,
    check_walking,
)
from ggo_factors.recording.played_log import repetition_notes, steps_between, told_landings
from ggo_factors.recording.report import ImportReport, count_legs, reasons
from ggo_factors.recording.sources.choices import chosen_log
from ggo_factors.recording.sources.open_log import LogLike
from ggo_factors.recording.strides.cut_strides import LONGEST_STRIDE_S, Cycles, Stride, find_cycles
from ggo_factors.recording.strides.mean_step import (
    closed,
    closed_step,
    level_step,
    resampled_step,
    spread,
    stand_with_bent_knees,
    steps_with_bent_knees,
)
from ggo_factors.recording.strides.selection import (
    from_stair_to_stair,
    level_strides,
    stair_swings,
    steps_within,
)
from ggo_factors.recording.strides.signals import CUTOFF_HZ, Signals, clean, unit_of
from ggo_factors.recording.strides.steps import ACTIVITIES, LEGS, Step
from ggo_factors.recording.strides.timing import clock_notes
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_count, as_progress

OFFSET_DEG = 5.0
"""The report notes a mean difference of the legs, or a drift of one angle, of more degrees than this."""
CLIMB = 0.05
"""The report notes a larger rise of the body in a level step, in leg lengths."""
CLIMB_CORRECTION_DEG = 2.0
"""... where the ends had to be corrected by more degrees: a gait that stands on the ground as it is does not climb."""
CORRECTION_DEG = 5.0
"""The report notes a larger correction of the gait's ends, in degrees."""


def import_base_gait(
    log: LogLike,
    topic: str | None = None,
    joints: PathLike | JointMap | None = None,
    unit: str | None = None,
    model: LegModel | None = None,
    frames: int = 51,
    min_strides: int = 3,
    activity: str = "level",
    progress: Callable[[float], None] | None = None,
    largest_chunk: int = CHUNK_MIB,
    leg: str = "mean",
) -> ImportReport:
    """Import the base gait of a recorded walk.

    Args:
        log: a path (an MCAP file, a rosbag2 folder, OpenSim `.mot` or `.sto`, `.csv`, Vicon `.c3d`, a ROS 1 `.bag`), a
            `JointLog`, a mapping of names to arrays (one of them ``t`` or ``time``), or a pandas DataFrame.
        topic: topic of the joints, where there are topics; found by itself where only one can be meant.
        joints: which value is which joint: a TOML file, the name of a preset, or a `JointMap`.
        unit: ``"rad"`` or ``"deg"``, where neither the source, the map nor ROS says it.
        model: the walker's legs; those of the paper if None. Only the ratio of thigh and shank changes the gait.
        frames: number of frames of the gait, both ends included.
        min_strides: fewest good strides of each leg; on stairs, fewest stair swings of all legs that are taken.
        activity: ``"level"``, ``"stairs-up"`` or ``"stairs-down"``: what to take from the recording.
        progress: called with the part of the file that has been read, 0 to 1.
        largest_chunk: the most of the file that is unpacked as one, in [MiB].
        leg: ``"mean"``, one gait for both legs; ``"each"``, a gait for each, however far apart they are
            (`ImportReport.base_gaits`); ``"right"`` or ``"left"``, that leg's strides alone, the other doing the same.

    Raises:
        InputError: where an argument or the joint map is wrong.
        LogError: where the recording cannot be read, needs a choice (joints, unit, topic), or holds no walk that
            could be a base gait: too few strides, one leg missing, legs too far apart for one gait, running,
            kinematics that no leg has.
    """
    progress = as_progress(progress)
    frames = as_count(frames, "frames", 3)
    min_strides = as_count(min_strides, "min_strides", 1)
    if activity not in ACTIVITIES:
        raise InputError(f"activity: expected {', '.join(map(repr, ACTIVITIES))}, got {activity!r:.40}")
    if leg not in EVERY_LEG:
        raise InputError(f"leg: expected {', '.join(map(repr, EVERY_LEG))}, got {leg!r:.40}")
    legs = model or PAPER_MODEL
    read, chosen, unit = chosen_log(log, topic, joints, unit, progress, largest_chunk)
    signals = clean(read, chosen, unit_of(chosen, unit, read))
    check_angles(signals, chosen, read.source)
    cycles = find_cycles(signals, legs)
    check_walking(cycles, legs, read.source)
    told = None if activity == "level" else told_landings(log)
    if told is not None:
        cycles = replace(cycles, steps=steps_between(told, signals, legs))
    cuts: Sequence[Stride | Step]
    cuts = level_strides(cycles) if activity == "level" else stair_swings(cycles, activity)
    used = tuple(cut for cut in cuts if not cut.reason and cut.leg in (leg if leg in LEGS else LEGS))
    refused = tuple(cut for cut in cuts if cut.reason)
    _check_enough(used, refused, cycles, min_strides, activity, read.source, leg)
    averaged = from_stair_to_stair(used, cuts)
    report = _report(read, chosen, signals, cycles, legs, model, activity, frames, used, refused, averaged)
    if told is None:
        swings = [cut for cut in used if isinstance(cut, Step)]
        report = replace(report, notes=(*report.notes, *repetition_notes(swings)))
    else:
        lands = "landings as the log says, which this library exported: feet flat on the treads"
        report = replace(report, decisions=(*report.decisions, lands))
    if activity == "level":
        check_level_gait(report)
    else:
        check_stair_gait(report)
        report = with_flight_ends(report, [cut for cut in cuts if isinstance(cut, Step)], cycles, signals, leg)
    if leg == "mean":
        check_one_gait(report)
    return report


def _check_enough(
    used: Sequence[Stride | Step],
    refused: Sequence[Stride | Step],
    cycles: Cycles,
    min_strides: int,
    activity: str,
    source: str,
    leg: str,
) -> None:
    counts = count_legs(used)
    if activity == "level":
        fewest = counts[leg] if leg in LEGS else min(counts.values())
        what = f"{counts['right']} right and {counts['left']} left strides on level ground, {min_strides} a leg needed"
    else:
        fewest = len(used)
        kind = f"{leg} swing" if leg in LEGS else "swing"
        what = f"{fewest} {kind}{'' if fewest == 1 else 's'} on {activity.replace('-', ' ')}, {min_strides} needed"
    if fewest >= min_strides:
        return
    if not refused and not cycles.steps:
        strikes = sum(len(times) for times in cycles.strikes.values())
        raise LogError(
            f"{source}: it holds no walking: {strikes} times a foot swings forward past the hip and back (standing and "
            f"marching on the spot count none); found {what}"
        )
    swings = {kind: sum(step.activity == kind for step in cycles.steps) for kind in ACTIVITIES[1:] if kind != activity}
    others = [f"{number} swings of activity={kind!r}" for kind, number in swings.items() if number]
    refusals = f" ({reasons(refused)})" if refused else ""
    also = f"; it holds {' and '.join(others)}" if others else ""
    also += "".join(f"; {note}" for note in clock_notes(cycles))
    option = f"; min_strides={fewest} would take them" if fewest else "; min_strides= cannot help"
    raise LogError(f"{source}: found {what}{refusals}{also}{option}")


@dataclass(frozen=True, eq=False)
class _Mean:
    """The mean step or cycle of each leg that has strides or swings.

    Attributes:
        stacks: all strides (k, n + 1, 2) or swings (k, n + 1, 4) of each leg in [rad].
        cycles: their mean, as in `ImportReport.mean_cycle`.
        steps: the step of a walker with this mean on both legs in [rad], shape (count, 4).
        stride_times: of each stride in [s], shape (k,).
        rise: height of a stair in [m], negative on the way down; None on level ground.
        tread: how far the body goes forward from stair to stair in [m]; None on level ground.
    """

    stacks: dict[str, Array]
    cycles: dict[str, Array]
    steps: dict[str, Array]
    stride_times: dict[str, Array]
    rise: float | None = None
    tread: float | None = None


def _mean(used: Sequence[Stride | Step], averaged: Sequence[Stride | Step], activity: str, count: int) -> _Mean:
    """Average the strides or swings of each leg.

    The rise of a stair is the median over all swings that are used, one of which may hold a pause. Its tread is that
    over those from stair to stair: from the ground the body goes another way.
    """
    by_leg = {leg: [cut for cut in averaged if cut.leg == leg] for leg in LEGS}
    present = [leg for leg in LEGS if by_leg[leg]]
    stacks = {
        leg: np.stack([cut.angles if isinstance(cut, Stride) else cut.frames for cut in by_leg[leg]]) for leg in present
    }
    times = {leg: np.array([cut.duration for cut in by_leg[leg]]) for leg in present}
    if activity == "level":
        cycle = {leg: closed(stacks[leg].mean(axis=0)) for leg in present}
        steps = {leg: level_step(cycle[leg], count) for leg in present}
        return _Mean(stacks, {leg: cycle[leg][:-1] for leg in present}, steps, times)
    return _Mean(
        stacks,
        cycles={leg: stacks[leg].mean(axis=0) for leg in present},
        steps={leg: resampled_step(stacks[leg].mean(axis=0), count) for leg in present},
        stride_times={leg: 2.0 * times[leg] for leg in present},
        rise=float(np.median([swing.rise for swing in used if isinstance(swing, Step)])),
        tread=float(np.median([swing.travel for swing in averaged if isinstance(swing, Step)])),
    )


def _report(
    log: JointLog,
    chosen: JointMap,
    signals: Signals,
    cycles: Cycles,
    legs: LegModel,
    model: LegModel | None,
    activity: str,
    count: int,
    used: tuple[Stride | Step, ...],
    refused: tuple[Stride | Step, ...],
    averaged: Sequence[Stride | Step],
) -> ImportReport:
    mean = _mean(used, averaged, activity, count)
    # Each leg counts the same, however many strides it gave: left and right are exchangeable.
    mean_time = sum(float(row.mean()) for row in mean.stride_times.values()) / len(mean.steps)
    frames = np.mean(list(mean.steps.values()), axis=0)
    if activity != "level":
        frames = closed_step(frames)
    stood, raised = stand_with_bent_knees(frames, legs, mean.rise or 0.0, mean.tread)
    correction = float(np.degrees(np.abs(stood - frames).max()))
    symmetry = _symmetry(mean.steps, mean.cycles, cycles, activity)
    shares, pair = _each_leg(mean, cycles, activity, count)
    (left, right), pair_raised = steps_with_bent_knees(pair, legs, mean.rise or 0.0, mean.tread)
    name = os.path.splitext(os.path.basename(log.source))[0]
    origin = f"{os.path.basename(log.source)}, {activity}, {len(used)} {'strides' if activity == 'level' else 'swings'}"
    deviations = {leg: spread(stack)[: len(mean.cycles[leg])] for leg, stack in mean.stacks.items()}
    kept = recorded_strides(
        deviations, activity, shares[0], count, {leg: len(stack) for leg, stack in mean.stacks.items()}
    )
    gait = Gait(stood, mean_time / 2.0 / (count - 1), name, origin.replace("\n", " "), legs, recorded=kept["both"])
    each = [
        replace(gait, frames=own, dt=part * mean_time / (count - 1), name=f"{name}, {leg} swings", recorded=kept[leg])
        for own, part, leg in zip((left, right), shares, ("left", "right"), strict=True)
    ]
    decisions = list(_decisions(chosen, legs, model, raised))
    if mean.rise:
        decisions.append(f"{len(averaged)} of {len(used)} swings start on a stair: the gait is their mean")
    if pair_raised != raised:
        decisions.append(f"in the gaits of each leg the knees are raised by {math.degrees(pair_raised):.2f} degrees")
    return ImportReport(
        mean_gait=gait,
        left=each[0],
        right=each[1],
        source=log.source,
        topic=log.topic,
        encoding=f"{log.encoding} {log.message_type}".strip(),
        time_source=log.time_source,
        unit=signals.unit,
        rate=signals.rate,
        duration=float(log.times[-1] - log.times[0]),
        messages_read=log.messages_read,
        messages_expected=log.messages_expected,
        losses=tuple(str(loss) for loss in log.losses),
        activity=activity,
        decisions=tuple(decisions),
        notes=(
            *log.notes,
            *chosen.notes,
            *_notes(symmetry, cycles, legs, activity, correction, mean_time),
            *_drifts(used),
            *clock_notes(cycles),
        ),
        signal_counts=signals.counts,
        heel_strikes=cycles.strikes,
        used=used,
        refused=refused,
        steps=steps_within(averaged, cycles),
        mean_cycle=mean.cycles,
        spread=deviations,
        stride_time=(mean_time, _deviation(mean.stride_times)),
        step_lengths=_step_lengths(cycles, activity),
        speed=gait.stride() / mean_time,
        symmetry=symmetry,
        correction=stood - frames,
        correction_deg=correction,
        knee_raised_deg=math.degrees(raised),
        riser=None if mean.rise is None else abs(mean.rise),
        tread=mean.tread,
        violations=verify(gait).violations,
    )


def _each_leg(mean: _Mean, cycles: Cycles, activity: str, count: int) -> tuple[tuple[float, float], list[Array]]:
    """The shares of a stride that the left and the right leg's steps take, and the steps as recorded, (count, 4)."""
    share = left_share(cycles, activity) if len(mean.steps) == 2 else 0.5
    if activity == "level":
        made = level_pair(mean.cycles, share, count)
        pair = [made["left"], made["right"]]
    else:
        one = next(iter(mean.steps.values()))
        pair = list(closed_pair(*(mean.steps.get(leg, one) for leg in ("left", "right"))))
    return (share, 1.0 - share), pair


def _deviation(stride_times: dict[str, Array]) -> float:
    """Standard deviation of the stride times in [s], each leg about its own mean; 0 with one stride a leg."""
    pooled = np.concatenate([row - row.mean() for row in stride_times.values()])
    freedom = len(pooled) - len(stride_times)
    return float(math.sqrt((pooled**2).sum() / freedom)) if freedom else 0.0


def _decisions(chosen: JointMap, legs: LegModel, model: LegModel | None, raised: float) -> Iterator[str]:
    """What was decided for the user, a line each; `raised` is the constant on the knee angles in [rad]."""
    if not model:
        yield f"leg lengths not given: the paper's, thigh {legs.thigh} m, shank {legs.shank} m"
    yield (
        f"joints by {chosen.origin}; filtered at {CUTOFF_HZ:g} Hz (zero-phase Butterworth), "
        f"gaps of up to {BRIDGE_S:g} s bridged"
    )
    yield "heel strike: forward extreme of the ankle relative to the hip"
    if raised:
        yield f"both knees raised by {math.degrees(raised):.2f} degrees: they were overstretched"


def _step_lengths(cycles: Cycles, activity: str) -> dict[str, float]:
    steps = {leg: [s.advance for s in cycles.steps if s.leg == leg and s.activity == activity] for leg in LEGS}
    return {leg: float(np.median(row)) for leg, row in steps.items() if row}


def _notes(
    symmetry: dict[str, float], cycles: Cycles, legs: LegModel, activity: str, correction: float, stride_time: float
) -> Iterator[str]:
    """What the user should look at before trusting the gait."""
    for joint in ("hip", "knee"):
        offset = symmetry.get(f"{joint}_offset_deg", 0.0)
        if abs(offset) > OFFSET_DEG:
            yield (
                f"the right {joint} is {abs(offset):.1f} degrees {'more' if offset > 0.0 else 'less'} flexed than the "
                f"left in the mean: a limp, or an offset of a sensor; the gait takes the middle"
            )
    apart = symmetry.get("gait_rms_deg", 0.0)
    if apart > OFFSET_DEG:
        yield f"the base gait from left strides only is {apart:.1f} degrees RMS from that of the right ones"
    climb = float(np.median([step.rise for step in cycles.steps if step.activity == "level"] or [0.0]))
    if activity == "level" and abs(climb) > CLIMB * legs.reach and correction > CLIMB_CORRECTION_DEG:
        yield (
            f"each step on level ground seems to climb {100.0 * climb:+.1f} cm: is the pelvis tilt in the joint map, "
            f"and are the leg lengths right?"
        )
    if activity == "level" and cycles.toe_off < 0.5:
        yield (
            f"toe-off at {100.0 * cycles.toe_off:.0f} % of the stride, so no double support, which nobody does so "
            f"slowly: is the trunk's tilt in the joint map?"
        )
    if activity == "level" and stride_time > LONGEST_STRIDE_S:
        yield f"strides of {stride_time:.1f} s: a very slow walker, or one who stops in every stride"
    if activity == "stairs-down":
        yield "the riser on the way down includes the lift of the trailing heel: it is an upper bound"
    if correction > CORRECTION_DEG:
        yield f"angles were changed by up to {correction:.1f} degrees so that both feet stand on the ground at the ends"


def _drifts(used: Sequence[Stride | Step]) -> Iterator[str]:
    """Sensors whose zero moves: the mean angle of a stride changes steadily over the recording."""
    for leg in LEGS:
        strides = [cut for cut in used if isinstance(cut, Stride) and cut.leg == leg]
        if len(strides) < 6:
            continue
        means = np.degrees([stride.angles.mean(axis=0) for stride in strides])
        times = np.array([stride.start for stride in strides])
        slopes = np.polyfit(times, means, 1)[0] * (times[-1] - times[0])
        for joint, change in zip(("thigh", "knee"), slopes.tolist(), strict=True):
            if abs(change) > OFFSET_DEG:
                yield f"the {leg} {joint} drifts by {change:+.1f} degrees from the first stride to the last"


def _symmetry(raw: dict[str, Array], mean_cycle: dict[str, Array], cycles: Cycles, activity: str) -> dict[str, float]:
    result: dict[str, float] = {}
    if len(raw) == 2:
        result["gait_rms_deg"] = float(np.degrees(np.sqrt(np.mean((raw["right"] - raw["left"]) ** 2))))
    if len(raw) == 2 and activity == "level":
        offset = np.degrees(mean_cycle["right"].mean(axis=0) - mean_cycle["left"].mean(axis=0))
        result |= {"hip_offset_deg": float(offset[0]), "knee_offset_deg": float(offset[1])}
    steps = {leg: [s.duration for s in cycles.steps if s.leg == leg and s.activity == activity] for leg in LEGS}
    if all(steps.values()):
        result["step_time_ratio"] = float(np.median(steps["right"]) / np.median(steps["left"]))
    return result
