"""The numbers of a report: one JSON object, which the page shows and holds."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np

from ggo_factors.check.balance import off_balance
from ggo_factors.check.report import STANDARD, Report
from ggo_factors.evaluate.comfort import Comfort
from ggo_factors.evaluate.summary import summarize
from ggo_factors.motion.base_gaits import as_leg, other_leg
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.zero_moment import zero_moment_points
from ggo_factors.page.checks import Seen, check_rows, violation_rows
from ggo_factors.page.motion import ShownStep, motion_numbers, scene_numbers
from ggo_factors.support.files import read_text
from ggo_factors.support.inputs import Array
from ggo_factors.walking.walk import Walk

FORMAT, FORMAT_VERSION = "ggo-report", 1
"""What the JSON says that it is."""
LEGS = {"left": "left", "right": "right"}
"""What the legs of a walk are called."""
ROLES = {"left": "supporting", "right": "swinging"}
"""What those of a single gait are called: which leg swings nobody said; it is drawn as the right one."""
JOINTS = ("left hip", "left knee", "right hip", "right knee")
"""The joints of a walk in the order of `ShownStep.by_leg`."""


@dataclass(frozen=True, eq=False)
class Subject:
    """What a report is about.

    Attributes:
        loaded: the gait or walk.
        reports: what the dense check saw of each step.
        comforts: speeds and accelerations of its joints, then those of the base gait if there is one.
        limits: joint limits that it was held to, if any.
        file: where it was read from.
        bases: the base gait that each step is put beside, in as many frames; empty without one.
        base_file: where they were read from, if there are any.
    """

    loaded: Gait | Walk
    reports: tuple[Report, ...]
    comforts: tuple[Comfort, ...]
    limits: JointLimits | None
    file: str
    bases: tuple[Gait, ...] = ()
    base_file: str | None = None

    @property
    def gaits(self) -> tuple[Gait, ...]:
        """The steps."""
        return self.loaded.gaits if isinstance(self.loaded, Walk) else (self.loaded,)

    @property
    def name(self) -> str:
        """What to call it: a walk by its file; a gait by its own name."""
        return "" if isinstance(self.loaded, Walk) else self.gaits[0].name

    def steps(self) -> tuple[ShownStep, ...]:
        """The steps with their places and times."""
        walk = self.loaded if isinstance(self.loaded, Walk) else None
        origins = [[0.0, 0.0]] if walk is None else walk.origins().tolist()
        begins = accumulate((gait.duration for gait in self.gaits), initial=0.0)
        swings, shown = "right" if walk is None else walk.first_swing, list[ShownStep]()
        for number, (gait, (x, y), time) in enumerate(zip(self.gaits, origins, begins, strict=False)):
            shown.append(ShownStep(gait, None if walk is None else walk.plan[number], (x, y), time, swings))
            swings = other_leg(as_leg(swings, "first_swing"))
        return tuple(shown)


def report_numbers(subject: Subject, version: str) -> dict[str, Any]:
    """All that a report says, as one object for JSON: units are in the names of the numbers.

    Args:
        subject: what it is about.
        version: of the library.

    Raises:
        InputError: where the gait states no leg lengths.
    """
    steps, model = subject.steps(), subject.gaits[0].legs()
    walk = subject.loaded if isinstance(subject.loaded, Walk) else None
    seen = Seen(steps, subject.reports, subject.limits, None if walk is None else walk.landing_speed)
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "library": f"ggo-factors {version}",
        "name": subject.name or Path(subject.file).name,
        "kind": "gait" if walk is None else "walk",
        "legs": ROLES if walk is None else LEGS,
        "ok": all(report.ok for report in subject.reports),
        "violations": violation_rows(seen),
        "instants_checked": sum(report.instants for report in subject.reports),
        "checks": check_rows(seen),
        "steps": _step_rows(subject, steps),
        "rates": _rate_rows(subject),
        "balance": _balance_rows(subject, steps),
        "angles": _angle_curves(subject, steps),
        "scene": scene_numbers(steps, model),
        "motion": motion_numbers(steps, model),
        "source": _source(subject),
    }


def _step_rows(subject: Subject, steps: Sequence[ShownStep]) -> list[dict[str, Any]]:
    """What `ggo verify --json` says of each step, with when it begins, which leg swings, and where it lands."""
    rows, model = [], subject.gaits[0].legs()
    bases = subject.bases or (None,) * len(steps)
    for number, (shown, report, base) in enumerate(zip(steps, subject.reports, bases, strict=True), start=1):
        landed = model.endpoint(shown.gait.frames[-1]).tolist()
        rows.append(
            {
                **summarize(f"step {number}", shown.gait, report, base).to_json(),
                "begins_s": round(shown.begins, 6),
                "swings": shown.swings,
                "lands_m": [round(value, 5) for value in landed],
                "origin": shown.gait.origin,
            }
        )
    return rows


def _rate_rows(subject: Subject) -> list[dict[str, Any]]:
    """Peak speed and acceleration of each joint, the limits, and the base gait's own peaks, in degrees and seconds.

    A walk whose pace was chosen is looked at as it is played, at every instant, as the check does; any other by
    differences between its frames.
    """
    walk = subject.loaded if isinstance(subject.loaded, Walk) else None
    speeds, bends = subject.comforts[0].peaks[:2]
    if walk is not None and walk.landing_speed is not None:
        played = walk.joint_trajectory("right").played
        speeds, bends = (np.abs(rates).max(axis=0) for rates in (played.fastest, played.accelerations))
    numbers: dict[str, Array | None] = {
        "speed_deg_s": speeds,
        "speed_limit_deg_s": None if subject.limits is None else subject.limits.speed,
        "base_speed_deg_s": subject.comforts[1].peaks[0] if len(subject.comforts) > 1 else None,
        "acceleration_deg_s2": bends,
        "acceleration_limit_deg_s2": None if subject.limits is None else subject.limits.acceleration,
        "base_acceleration_deg_s2": subject.comforts[1].peaks[1] if len(subject.comforts) > 1 else None,
    }
    # Columns are in the roles of the first step: the supporting leg, then the swinging one.
    roles = JOINTS if walk is None or walk.first_swing == "right" else (*JOINTS[2:], *JOINTS[:2])
    rows: list[dict[str, Any]] = [
        {
            "joint": joint,
            **{
                name: None if values is None else round(math.degrees(values[column]), 3)
                for name, values in numbers.items()
            },
        }
        for column, joint in enumerate(roles)
    ]
    for row in rows:
        for rate, unit in (("speed", "deg_s"), ("acceleration", "deg_s2")):
            most = row[f"{rate}_limit_{unit}"]
            row[f"{rate}_share_percent"] = None if most is None else round(row[f"{rate}_{unit}"] / most * 100.0, 2)
    return sorted(rows, key=lambda row: JOINTS.index(str(row["joint"])))


def _balance_rows(subject: Subject, steps: Sequence[ShownStep]) -> list[dict[str, Any]]:
    """Where the ground's push acts in each step (ZMP), and how far that is from where it acts in the base gait."""
    rows, model = [], subject.gaits[0].legs()
    bases = subject.bases or (None,) * len(steps)
    for number, (shown, base) in enumerate(zip(steps, bases, strict=True), start=1):
        gait = shown.gait.evenly()
        points = zero_moment_points(model, gait.frames, gait.dt)
        known = points[~np.isnan(points)]
        off = np.zeros(0) if base is None else off_balance(shown.gait, model, base)
        rows.append(
            {
                "step": number,
                "back_mm": _extreme(known, -1.0),
                "front_mm": _extreme(known, 1.0),
                "mean_off_base_mm": round(float(off.mean()) * 1e3, 3) if len(off) else None,
                "largest_off_base_mm": _extreme(off, 1.0),
                "allowed_mean_off_base_mm": STANDARD.balance * 1e3,
            }
        )
    return rows


def _extreme(values: Array, sign: float) -> float | None:
    """The largest value, or with sign -1 the smallest, of values in [m], in [mm]; None where there is none."""
    return round(sign * float((sign * values).max()) * 1e3, 3) if len(values) else None


def _angle_curves(subject: Subject, steps: Sequence[ShownStep]) -> dict[str, dict[str, Any]]:
    """Each joint over time in [deg], with the base gait's in place of each step and its spread (standard deviation)."""
    own = {"deg": [shown.by_leg for shown in steps]}
    if subject.bases:
        pairs = list(zip(subject.bases, steps, strict=True))
        own["base_deg"] = [_as_swung(base.frames, shown) for base, shown in pairs]
        spreads = [base.recorded.spread_at(len(base)) for base, _ in pairs if base.recorded is not None]
        if len(spreads) == len(steps):
            own["base_sd_deg"] = [_as_swung(sd, shown) for sd, shown in zip(spreads, steps, strict=True)]
    times = np.concatenate([shown.begins + shown.gait.times for shown in steps])
    curves: dict[str, dict[str, Any]] = {}
    for column, joint in enumerate(JOINTS):
        curves[joint] = {"time_s": np.round(times, 6).tolist()}
        for name, parts in own.items():
            curves[joint][name] = np.round(np.degrees(np.concatenate(parts)[:, column]), 4).tolist()
    return curves


def _as_swung(frames: Array, shown: ShownStep) -> Array:
    """Frames of a gait for either leg in the order of `ShownStep.by_leg`."""
    return frames if shown.swings == "right" else swap_roles(frames)


def _source(subject: Subject) -> dict[str, Any]:
    """Where the numbers come from: files with their dates and checksums, and what was noticed about them."""
    walk = subject.loaded if isinstance(subject.loaded, Walk) else None
    notes = subject.gaits[0].notes if walk is None else walk.notes
    base = None
    if subject.bases and subject.base_file is not None:
        names = list(dict.fromkeys(each.name for each in subject.bases))
        base = {"names": names, **_file(subject.base_file), "notes": list(subject.bases[0].notes)}
        counts = {each.name: each.recorded.strides for each in subject.bases if each.recorded is not None}
        base["strides"] = counts or None
    model = subject.gaits[0].legs()
    foot = {"ankle_m": model.foot.ankle_height, "heel_m": model.foot.heel, "toe_m": model.foot.toe}
    lengths = {"thigh_m": model.thigh, "shank_m": model.shank, **foot}
    origins = list(dict.fromkeys(gait.origin for gait in subject.gaits if gait.origin))
    bent = [gait.bent.to_json() for gait in subject.gaits if gait.bent is not None]
    for each in bent:
        each.pop("numbers", None)  # of the style, different in each step
    told = list({json.dumps(each): each for each in bent}.values())
    return {
        **_file(subject.file),
        "origins": origins,
        "bent_from": told,
        "notes": list(notes),
        "base": base,
        "model": lengths,
    }


def _file(file: str) -> dict[str, Any]:
    """What a file says of itself, its date and its SHA-256; the word `paper` stands for no file."""
    path = Path(file)
    if not path.exists():
        return {"file": None, "form": None, "checksum": None, "sha256": None, "written": None}
    text = read_text(path)
    stated = re.search(r"^# *checksum: *(\S+)", text, re.MULTILINE)
    written = datetime.fromtimestamp(path.stat().st_mtime, UTC)
    return {
        "file": path.name,
        "form": text.partition("\n")[0].lstrip("# ").strip(),
        "checksum": None if stated is None else stated[1],
        "sha256": sha256(path.read_bytes()).hexdigest(),
        "written": written.isoformat(timespec="seconds"),
    }
