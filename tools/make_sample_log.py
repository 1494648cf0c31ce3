"""Make the sample walking log, `datasets/children_walk.mcap`, from measured gait cycles of children.

The cycles are the `gait` data of the R package fda (Olshen et al. 1989): hip and knee angle of 39 boys, one cycle
each, 20 samples a cycle. No child's walk of many strides is published there, so this log is assembled: each stride
is another child's, both legs alike, half a cycle apart.

    pip install fdatools
    python tools/make_sample_log.py --out datasets/children_walk.mcap
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from ggo_factors.errors import GgoError, InputError
from ggo_factors.recording.export.ros2_log import NANOSECONDS, header, ros2_log
from ggo_factors.support.files import PathLike

Array = NDArray[np.float64]

TOPIC = "/joint_states"
JOINTS = (
    "left_hip_flexion",
    "left_knee_flexion",
    "pelvis_tilt",
    "right_hip_flexion",
    "right_knee_flexion",
)
CHILDREN = 24
RATE_HZ = 100
# The data hold no times: an ordinary cadence for a child, about 140 steps a minute, and steps that vary by up to 3 %.
STRIDE_S = 0.85
VARIATION = 0.03
SEED = 39
# One child passes into the next while the leg stands: around this phase, and so much of a cycle on either side.
# There the joints move least and the same way in all of them; the swing and both heel strikes stay as measured.
BLEND_AT, BLEND = 0.3, 0.15
# A clock that has run for a while, as a robot's has.
START_S = 10.0
# Angles are rounded to this, 6e-5 degrees, so that no library's last bit shows in the file.
STEP_RAD = 1e-6


@dataclass(frozen=True)
class Cycles:
    """Gait cycles from heel strike to heel strike, one a child.

    Attributes:
        spline: periodic, from the phase (0 to 1) to hip and knee in [rad], shape (children, 2).
        heel_strike: phase of each child's heel strike, shape (children,).
    """

    spline: CubicSpline[np.float64]
    heel_strike: Array

    def at(self, phase: float | Array, child: int) -> Array:
        """Hip and knee in [rad], shape (..., 2), of one child, the phase counted from its heel strike."""
        return np.asarray(self.spline((phase + self.heel_strike[child]) % 1.0)[..., child, :])

    def mean(self, phase: float, children: list[int]) -> Array:
        """Mean hip and knee of some children in [rad], shape (2,)."""
        return np.asarray(np.mean([self.at(phase, child) for child in children], axis=0))


def measured_cycles() -> tuple[Array, Array]:
    """Phase of the samples, shape (20,), and hip and knee in [rad], shape (20, 39, 2), from fdatools.

    Raises:
        InputError: where fdatools is not installed.
    """
    try:
        from fdatools.datasets import load_gait
    except ImportError as error:
        raise InputError("the measured cycles come with the package fdatools: pip install fdatools") from error
    gait = load_gait()
    return np.asarray(gait.t), np.radians(gait.value)


def make_cycles(phase: Array, angles: Array) -> tuple[Cycles, list[int], float]:
    """Cycles that begin at heel strike, the children to take in their order, and the pelvis tilt in [rad].

    The heel strike is where the ankle is furthest ahead of the hip. That depends a little on the tilt, and the
    tilt on it, so the two are found in turns.
    """
    spline = CubicSpline(
        np.append(phase, phase[0] + 1.0), np.concatenate([angles, angles[:1]]), axis=0, bc_type="periodic"
    )
    fine = np.arange(1000) / 1000.0
    hip, knee = np.moveaxis(spline(fine), -1, 0)
    everyone = list(range(angles.shape[1]))
    tilt = 0.0
    for _ in range(10):
        ankle = np.sin(hip + tilt) + np.sin(hip + tilt - knee)
        cycles = Cycles(spline, fine[np.argmax(ankle, axis=0)])
        tilt = level_tilt(cycles, everyone)
    # The hip is measured from each child's pelvis, whose own tilt nobody noted: taken with one tilt for all, the
    # children at the ends of the range seem to climb. The two dozen in the middle walk level.
    own = [abs(level_tilt(cycles, [child]) - tilt) for child in everyone]
    chosen = sorted(sorted(everyone, key=lambda child: own[child])[:CHILDREN])
    # Up the range of hip angles and down again, so that each child walks much like the ones before and after it.
    ranked = sorted(chosen, key=lambda child: float(np.mean(angles[:, child, 0])))
    return cycles, ranked[::2] + ranked[1::2][::-1], level_tilt(cycles, chosen)


def level_tilt(cycles: Cycles, children: list[int]) -> float:
    """The pelvis tilt in [rad] with which both ankles are equally high at the ends of the children's mean step.

    Thigh and shank count as equally long. Both ends are the same pose with the legs exchanged.
    """
    leading, trailing = cycles.mean(0.0, children), cycles.mean(0.5, children)

    def difference(tilt: float) -> float:
        front, back = (np.cos(hip + tilt) + np.cos(hip + tilt - knee) for hip, knee in (leading, trailing))
        return float(front - back)

    return float(brentq(difference, -math.radians(60.0), math.radians(60.0), xtol=1e-15))


def make_walk(cycles: Cycles, order: list[int], tilt: float) -> tuple[NDArray[np.int64], Array]:
    """Times in [ns], shape (n,), and the angles of `JOINTS` in [rad], shape (n, 5).

    A whole stride of each child and leg, and a quarter of a cycle before the first and after the last.
    """
    draw = random.Random(SEED)
    steps = 2 * len(order) + 3
    durations = [STRIDE_S / 2.0 * (1.0 + VARIATION * (2.0 * draw.random() - 1.0)) for _ in range(steps)]
    # The phase counts cycles of the right leg; its heel strikes are whole numbers, the left leg's lie between them.
    strikes = np.cumsum([0.0, *durations])
    phase_at = CubicSpline(strikes, (np.arange(steps + 1) - 1.0) / 2.0)
    first, last = np.interp([-0.25, len(order) + 0.75], phase_at(strikes), strikes)
    time = np.arange(math.ceil(first * RATE_HZ), math.floor(last * RATE_HZ) + 1) / RATE_HZ
    phase = phase_at(time)
    right, left = stitched(cycles, order, phase), stitched(cycles, order, phase - 0.5)
    pelvis = np.full(len(time), tilt)
    angles = np.stack([left[:, 0], left[:, 1], pelvis, right[:, 0], right[:, 1]], -1)
    ticks = np.arange(len(time)) * (NANOSECONDS // RATE_HZ) + round(START_S * NANOSECONDS)
    return ticks, np.rint(angles / STEP_RAD) * STEP_RAD


def stitched(cycles: Cycles, order: list[int], phase: Array) -> Array:
    """Hip and knee of a leg in [rad], shape (n, 2): from stance to stance one child's, then the next one's."""
    angles = np.empty((len(phase), 2))
    nearest = np.rint(phase - BLEND_AT).astype(int)
    for stance in np.unique(nearest):
        rows = nearest == stance
        x = np.clip((phase[rows] - BLEND_AT - stance) / (2.0 * BLEND) + 0.5, 0.0, 1.0)
        weight = (x**3 * (10.0 - 15.0 * x + 6.0 * x**2))[:, None]
        before, after = order[stance % len(order)], order[(stance + 1) % len(order)]
        angles[rows] = (1.0 - weight) * cycles.at(phase[rows], before) + weight * cycles.at(phase[rows], after)
    return angles


def write_log(path: PathLike, times_ns: NDArray[np.int64], angles: Array) -> None:
    """Write the walk as sensor_msgs/JointState with positions only, as many recorders do.

    Raises:
        InputError: where the file cannot be written.
    """
    with ros2_log(path) as log:
        log.add_topic(TOPIC, "sensor_msgs/JointState")
        log.add_metadata(
            "source",
            {
                "made_by": "tools/make_sample_log.py of ggo_factors",
                "data": "gait of the R package fda (Olshen et al. 1989), as in the Python package fdatools",
                "licence": "BSD-3-Clause, Copyright (c) 2026, Hamed Davodi",
                "note": "assembled from single cycles of different children: not one person's walk",
            },
        )
        for time, position in zip(times_ns.tolist(), angles.tolist(), strict=True):
            state = {"name": JOINTS, "position": position, "velocity": [], "effort": []}
            log.write(TOPIC, time, {"header": header(time), **state})


def main(arguments: list[str] | None = None) -> int:
    """Make the log and say what is in it; 0 where it was written, 2 on bad input."""
    parser = argparse.ArgumentParser(
        description=__doc__.partition("\n")[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("--out", default="datasets/children_walk.mcap", help="the log to write")
    path = parser.parse_args(arguments).out
    try:
        cycles, order, tilt = make_cycles(*measured_cycles())
        times_ns, angles = make_walk(cycles, order, tilt)
        write_log(path, times_ns, angles)
    except GgoError as error:
        print(f"make_sample_log: {error}", file=sys.stderr)
        return 2
    thigh = np.degrees(angles[:, [0, 3]] + tilt)
    seconds = (times_ns[-1] - times_ns[0]) / NANOSECONDS
    print(f"{path}: {len(times_ns)} messages, {seconds:.2f} s, {len(order)} strides a leg")
    print(f"pelvis tilt {math.degrees(tilt):.2f} deg: both feet on the ground at the ends of the mean step")
    print(f"thighs from the vertical {thigh.min():.1f} to {thigh.max():.1f} deg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
