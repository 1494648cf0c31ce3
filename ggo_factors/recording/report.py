"""What an import found, decided and left out: as text to read and as JSON to keep."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ggo_factors.errors import LogError, Violation
from ggo_factors.motion.base_gaits import BaseGaits
from ggo_factors.motion.flight_rows import FLIGHT_STEPS
from ggo_factors.motion.gait import Gait
from ggo_factors.recording.each_leg import MOST_APART_DEG
from ggo_factors.recording.strides.cut_strides import Stride
from ggo_factors.recording.strides.steps import LEGS, Step
from ggo_factors.support.data_frame import pandas
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, short_text
from ggo_factors.support.plain import to_plain, write_plain

KIND = "ggo-import 1"
"""Kind and version of a saved report; the number grows when a key changes its meaning or goes."""
FORMAT_VERSION = 1
"""Version of the report's JSON; raised when a key changes its meaning or goes."""


@dataclass(frozen=True, eq=False)
class ImportReport:
    """A base gait from a recording, with what one needs to know to trust it.

    Attributes:
        mean_gait: the mean of both legs' steps, whether or not they are alike; see `gait`.
        left: the step in which the left leg swings, and `right` the other one; each ends where the other begins.
        right: as `left`. Where one leg alone was taken, both are its step.
        source: the recording.
        topic: topic, or topics separated by commas.
        encoding: encoding and type of the messages.
        time_source: where the times come from.
        unit: unit in which the logged values were read.
        rate: median rate of the values in [Hz].
        duration: time from the first sample to the last in [s].
        messages_read: messages read.
        messages_expected: messages by the file's own statistics, or None.
        losses: what was lost, a line each.
        activity: ``"level"``, ``"stairs-up"`` or ``"stairs-down"``.
        decisions: what was decided, a line each.
        notes: what the user should look at, a line each.
        signal_counts: what was wrong with the values, by kind and logged value.
        heel_strikes: times of all heel strikes in [s] of each leg (the ankle's forward extreme).
        used: the strides (level) or stair swings that went into the gait.
        refused: those that did not, each with its reason.
        steps: the single steps that the gait is made of as they were recorded, in the order of time: those within the
            strides, or the swings that were averaged.
        mean_cycle: thigh and knee of each leg in [rad] at the phases 0, 1/n, ..., (n-1)/n of its own cycle, from heel
            strike to heel strike, shape (n, 2); on stairs ``[alpha1, beta1, alpha2, beta2]`` of its swing, (n, 4).
        spread: standard deviation over the strides in [rad], same shapes; 0 where there is only one.
        stride_time: mean and standard deviation in [s].
        step_lengths: how far ahead of the support foot each leg lands in the mean, in [m].
        speed: the gait's stride by the stride time in [m/s], for these leg lengths.
        symmetry: how the legs differ: ``gait_rms_deg`` (base gait from left strides only against right only),
            ``hip_offset_deg``, ``knee_offset_deg`` (mean angle, right less left), ``step_time_ratio`` (time of a right
            step over that of a left one).
        correction: what was added to the mean step, so that both feet stand on the ground in its first and last frame
            and no knee is overstretched, in [rad], shape (m, 4).
        correction_deg: largest such change of an angle, in degrees.
        knee_raised_deg: the part of it that is a constant on all knee angles.
        riser: height of a stair in [m], from the kinematics; None on level ground.
        tread: how far the body goes forward from stair to stair in [m]; None on level ground.
        violations: limits that the base gait breaks by itself on level ground.
    """

    mean_gait: Gait
    left: Gait
    right: Gait
    source: str
    topic: str
    encoding: str
    time_source: str
    unit: str
    rate: float
    duration: float
    messages_read: int
    messages_expected: int | None
    losses: tuple[str, ...]
    activity: str
    decisions: tuple[str, ...]
    notes: tuple[str, ...]
    signal_counts: Mapping[str, Mapping[str, float]]
    heel_strikes: Mapping[str, Array]
    used: tuple[Stride | Step, ...]
    refused: tuple[Stride | Step, ...]
    steps: tuple[Step, ...]
    mean_cycle: Mapping[str, Array]
    spread: Mapping[str, Array]
    stride_time: tuple[float, float]
    step_lengths: Mapping[str, float]
    speed: float
    symmetry: Mapping[str, float]
    correction: Array
    correction_deg: float
    knee_raised_deg: float
    riser: float | None
    tread: float | None
    violations: tuple[Violation, ...]

    def _repr_html_(self) -> str:
        from ggo_factors.recording.import_card import import_card  # only here: nothing but a notebook needs it

        (mean, sd), what = self.stride_time, "strides" if self.activity == "level" else "stair swings"
        facts = {
            "source": f"{self.source}, topic {self.topic}",
            "time": f"{self.duration:.1f} s at {self.rate:.0f} Hz",
            what: ", ".join(f"{leg} {count}" for leg, count in self.strides_used.items()),
            "refused": f"{len(self.refused)}: {reasons(self.refused)}" if self.refused else "none",
            "stride time": f"{mean:.3f} s, sd {sd:.3f} s; {self.speed:.2f} m/s",
            "base gait": f"{len(self.mean_gait)} frames, stride {self.mean_gait.stride():.3f} m",
            "legs": _symmetry_words(self.symmetry),
            "lost": self.losses,
            "decided": self.decisions,
            "notes": self.notes,
            "limits broken": list(map(str, self.violations)),
        }
        return import_card(f"Import: {self.activity}", self.mean_cycle, self.spread, facts)

    @property
    def gait(self) -> Gait:
        """The base gait, one step for both legs: the mean of theirs.

        Raises:
            LogError: where they are too far apart for one gait, with what to do.
        """
        apart = self.symmetry.get("gait_rms_deg", 0.0)
        if apart > MOST_APART_DEG:
            raise LogError(
                f"{self.source}: the legs are {apart:.0f} degrees apart, and their mean would be nobody's gait (RMS "
                f"over the step, at most {MOST_APART_DEG:g}): take a gait for each leg (leg='each'), or the one "
                f"that was measured well (leg='right' or leg='left')"
            )
        return self.mean_gait

    @property
    def base_gaits(self) -> BaseGaits:
        """A gait for each leg, as the procedures take them; on stairs to be put beside the level ones."""
        return BaseGaits(self.left, self.right)

    @property
    def corrections_deg(self) -> tuple[float, ...]:
        """Largest change of each angle in degrees: support hip and knee, swing hip and knee; see `correction`."""
        return tuple(np.degrees(np.abs(self.correction).max(axis=0)).tolist())

    @property
    def covariance(self) -> dict[str, Array]:
        """How the strides, or the swings that went into the gait, vary about their leg's mean, over time.

        For each leg the covariance of angle j at phase a with angle k at phase b in [rad^2], shape (n, J, n, J), at the
        phases and of the angles of `mean_cycle`; 0 where there is only one stride.
        """
        result = {}
        cuts: Sequence[Stride | Step] = self.used if self.activity == "level" else self.steps
        for leg, cycle in self.mean_cycle.items():
            rows = [cut.angles if isinstance(cut, Stride) else cut.frames for cut in cuts if cut.leg == leg]
            flat = np.array([row[: len(cycle)].ravel() for row in rows])
            off = flat - flat.mean(axis=0)
            result[leg] = (off.T @ off / max(1, len(flat) - 1)).reshape(*cycle.shape, *cycle.shape)
        return result

    @property
    def cadence(self) -> float:
        """Steps a minute."""
        return 120.0 / self.stride_time[0]

    @property
    def strides_used(self) -> dict[str, int]:
        """How many strides (level) or stair swings of each leg went into the gait."""
        return count_legs(self.used)

    @property
    def spread_deg(self) -> dict[str, float]:
        """Standard deviation over the strides, RMS over the cycle, of each leg in degrees."""
        return {leg: float(np.degrees(np.sqrt(np.mean(row**2)))) for leg, row in self.spread.items()}

    def __repr__(self) -> str:
        used, refused = len(self.used), len(self.refused)
        strides = f"{used} stride{'' if used == 1 else 's'} used, {refused} refused"
        return f"ImportReport({short_text(str(self.source))}, {self.activity}, {strides}, {self.duration:.4g} s)"

    def text(self) -> str:
        """The report for reading, several lines."""
        expected = "" if self.messages_expected is None else f" of {self.messages_expected}"
        what = "strides" if self.activity == "level" else "stair swings"
        used = self.strides_used
        spread = self.spread_deg
        mean, sd = self.stride_time
        lines = [
            f"{self.source}: {self.activity}",
            f"  topic        {self.topic} ({self.encoding}), {self.messages_read}{expected} messages, "
            f"{self.duration:.1f} s at {self.rate:.0f} Hz, time: {self.time_source}, unit: {self.unit}",
            f"  {what:<12} " + ", ".join(f"{leg} {used[leg]}" for leg in LEGS) + f" used; {len(self.refused)} refused",
            f"  stride time  {mean:.3f} s, sd {sd:.3f} s; {self.cadence:.1f} steps/min, {self.speed:.2f} m/s",
            "  spread       " + ", ".join(f"{leg} {spread[leg]:.1f}" for leg in spread) + " degrees",
            "  legs         " + _symmetry_words(self.symmetry),
            f"  gait         {len(self.mean_gait)} frames, {self.mean_gait.duration:.3f} s, stride "
            f"{self.mean_gait.stride():.3f} m; left swings {self.left.duration:.3f}, right {self.right.duration:.3f} s",
            f"  corrected    {_corrections(self.corrections_deg)}, to set both feet on the ground",
        ]
        if self.riser is not None and self.tread is not None:
            lines.append(f"  stairs       riser {self.riser:.3f} m, tread {self.tread:.3f} m (from the kinematics)")
        for reason, number in Counter(_kind(item.reason) for item in self.refused).most_common():
            lines.append(f"  refused      {number} x {reason}")
        for kind, row in self.signal_counts.items():
            lines.append(f"  signals      {kind}: " + ", ".join(f"{name} {number:g}" for name, number in row.items()))
        lines += [f"  lost         {line}" for line in self.losses]
        lines += [f"  decided      {line}" for line in self.decisions]
        lines += [f"  note         {line}" for line in self.notes]
        lines += [f"  limit        {violation}" for violation in self.violations]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """The report as plain numbers, words, lists and dictionaries; angles in degrees."""
        return {
            "format_version": FORMAT_VERSION,
            "source": self.source,
            "topic": self.topic,
            "encoding": self.encoding,
            "time_source": self.time_source,
            "unit": self.unit,
            "rate_hz": self.rate,
            "duration_s": self.duration,
            "messages_read": self.messages_read,
            "messages_expected": self.messages_expected,
            "losses": list(self.losses),
            "activity": self.activity,
            "decisions": list(self.decisions),
            "notes": list(self.notes),
            "signals": {kind: dict(row) for kind, row in self.signal_counts.items()},
            "heel_strikes_s": {leg: times.tolist() for leg, times in self.heel_strikes.items()},
            "strides_used": self.strides_used,
            "used": [_item(item) for item in self.used],
            "refused": [_item(item) for item in self.refused],
            "stride_time_s": {"mean": self.stride_time[0], "sd": self.stride_time[1]},
            "cadence_steps_per_min": self.cadence,
            "step_length_m": dict(self.step_lengths),
            "speed_m_s": self.speed,
            "symmetry": dict(self.symmetry),
            "spread_deg": self.spread_deg,
            "mean_cycle_deg": {leg: np.degrees(row).tolist() for leg, row in self.mean_cycle.items()},
            "cycle_sd_deg": {leg: np.degrees(row).tolist() for leg, row in self.spread.items()},
            "correction_deg": self.correction_deg,
            "corrections_deg": list(self.corrections_deg),
            "knee_raised_deg": self.knee_raised_deg,
            "riser_m": self.riser,
            "tread_m": self.tread,
            "violations": [str(violation) for violation in self.violations],
            "gait": _gait(self.mean_gait),
            "left": _gait(self.left),
            "right": _gait(self.right),
        }

    def to_json(self) -> str:
        """The report as JSON with a `format_version`."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False)

    def save(self, path: PathLike) -> None:
        """Write all of it as JSON, strides and gaits too, whole or not at all; `load_import_report` reads it.

        Every number is exact and in [rad], [m] and [s]; `to_json` is for reading, in degrees and without the strides.

        Raises:
            InputError: where the file cannot be written.
        """
        write_plain(path, KIND, to_plain(self))

    def to_dataframe(self) -> Any:
        """A `pandas.DataFrame` with a row for each stride or stair swing, used ones and refused ones by their start.

        Columns: leg, start and end in [s], used, reason; on stairs also activity, rise and travel in [m].

        Raises:
            ImportError: where pandas is not installed.
        """
        items = sorted((*self.used, *self.refused), key=lambda item: item.start)
        used = {id(item) for item in self.used}
        rows = [
            {"leg": item.leg, "start": item.start, "end": item.end, "used": id(item) in used, "reason": item.reason}
            | ({"activity": item.activity, "rise": item.rise, "travel": item.travel} if isinstance(item, Step) else {})
            for item in items
        ]
        return pandas().DataFrame(rows)


def _corrections(degrees: Sequence[float]) -> str:
    """By how many degrees each joint's angles were changed at most."""
    names = ("support hip", "support knee", "swing hip", "swing knee")
    return ", ".join(f"{name} {value:.1f}" for name, value in zip(names, degrees, strict=True)) + " degrees at most"


def count_legs(items: Sequence[Stride | Step]) -> dict[str, int]:
    """How many of `items` each leg has."""
    return {leg: sum(item.leg == leg for item in items) for leg in LEGS}


def reasons(items: Sequence[Stride | Step]) -> str:
    """Why strides were refused, in one line."""
    kinds = Counter(_kind(item.reason) for item in items)
    return "; ".join(f"{number} x {kind}" for kind, number in kinds.most_common()) or "none refused"


def _kind(reason: str) -> str:
    """A reason without its numbers, so that alike ones can be counted."""
    return reason.partition(" (")[0]


def _gait(gait: Gait) -> dict[str, Any]:
    return {
        "name": gait.name,
        "origin": gait.origin,
        "dt_s": gait.dt,
        "stride_m": gait.stride(),
        "frames_deg": np.degrees(gait.frames).tolist(),
    } | {key: _gait(own) for key in FLIGHT_STEPS if (own := getattr(gait, key)) is not None}


def _item(item: Stride | Step) -> dict[str, Any]:
    row: dict[str, Any] = {"leg": item.leg, "start_s": item.start, "end_s": item.end}
    if isinstance(item, Step):
        row |= {"activity": item.activity, "rise_m": item.rise, "travel_m": item.travel}
    return row | ({"reason": item.reason} if item.reason else {})


def _symmetry_words(symmetry: Mapping[str, float]) -> str:
    words = []
    if "gait_rms_deg" in symmetry:
        words.append(f"base gait from left strides only against right only {symmetry['gait_rms_deg']:.1f} degrees RMS")
    if "hip_offset_deg" in symmetry:
        words.append(
            f"offset right less left hip {symmetry['hip_offset_deg']:+.1f}, knee {symmetry['knee_offset_deg']:+.1f}"
        )
    if "step_time_ratio" in symmetry:
        words.append(f"step time right/left {symmetry['step_time_ratio']:.2f}")
    return "; ".join(words) or "one leg only"
