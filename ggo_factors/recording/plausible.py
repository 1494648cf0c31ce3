"""Refuse angles that no walking leg has, and say which fault it is."""

from __future__ import annotations

import math

import numpy as np

from ggo_factors.check.verify import DRAGS
from ggo_factors.errors import LogError
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.recording.log.joint_map import ANGLES, JointMap
from ggo_factors.recording.report import ImportReport
from ggo_factors.recording.strides.cut_strides import Cycles
from ggo_factors.recording.strides.signals import Signals
from ggo_factors.recording.strides.steps import ankle_path
from ggo_factors.support.inputs import Array

# In degrees; wide enough for slow, fast, old and stair gait, and for sensors that are some degrees off.
KNEE_STILL, HIP_STILL = 12.0, 8.0
"""A knee or thigh that moves less, while the other leg's moves three times as much, was not tracked."""
KNEE_LOWEST, KNEE_HIGHEST = -30.0, 165.0
"""Range of a knee's flexion in degrees, of its 1st and 99th percentile."""
THIGH_LOWEST, THIGH_HIGHEST = -70.0, 120.0
"""Range of a thigh's angle from the vertical in degrees, of its 1st and 99th percentile."""
THIGH_MIDDLE = 70.0
"""Largest median of a thigh's angle in degrees, either way: beyond it, it is not measured from the vertical."""

EARLIEST_MIDSTANCE, MIDSTANCE_KNEE_DEG = 0.215, 20.0
"""A walker is over the foot at 20 to 33 % of the stride, the knee bent by 2 to 20 degrees; a runner, who stands for 30
to 40 % of it only, at 15 to 20 %, the knee bent by 20 to 55 (seen on the logs at hand). Both together tell a run."""
FROUDE_SLOWEST_RUN = 0.25
"""Nobody runs more slowly, speed^2 / (g leg): 1.5 m/s with legs of 0.9 m; a crouched walk may look like a run else."""
EARLIEST_TOE_OFF, CARRIED = 0.4, 0.35
"""A slow step without double support is still a walk, by a rough model of the trunk, from this toe-off on where the
support foot goes back under the body by this share in the later half of the step: 0.4 to 0.6 in walks, 0 to 0.3 in
marching on the spot."""
SHORTEST_STRIDE = 0.2
"""Least stride of a base gait, in leg lengths."""
DEEPEST_DIP = 0.025
"""How far the swing ankle may go below the ground in a base gait, in [m]."""
MOST_CORRECTION_DEG = 15.0
"""Largest correction of a gait's ends in degrees: errors of a sensor's zero or of a leg's length need less."""
MOST_CORRECTION_DOWN_DEG = 25.0
"""The same on the way down, where the foot has further to go after the ankle's forward extreme at which steps are cut:
24 degrees with the mean curves of healthy people."""
TREAD_OFF = 0.15
"""How far a stair's tread by the body's speed may be from where the foot lands, in [m]: people are 0.06 to 0.08 off."""
HIGHEST_RISER = 0.30
"""Nobody walks stairs with higher risers foot over foot, in [m]."""
HYPEREXTENDED_DEG = 5.0
"""A knee bent back by more in the mean stride is what the feet cannot stand on the ground with, where they cannot."""
LEAST_KNEE_BEND_DEG = 20.0
"""Healthy knees bend by 50 to 70 degrees in a stride on level ground."""

_FASTEST_HZ = 1e4
"""No joint is measured so often."""

GRAVITY = 9.81
"""Acceleration of gravity in [m/s^2]."""
FROUDE_RUN = 0.5
"""People change from walking to running at about this Froude number, speed^2 / (g leg) (Alexander 1989)."""


def check_angles(signals: Signals, joints: JointMap, source: str) -> None:
    """Refuse angles that cannot be the thigh and knee of a walker.

    Raises:
        LogError: naming the angle, its values, and what is probably wrong with it.
    """
    if not signals.stretches:
        fast = (
            ""
            if signals.rate < _FASTEST_HZ
            else (
                f"; by its times the samples follow each other at {signals.rate:.3g} Hz: written at once, "
                "or counted in another unit than nanoseconds?"
            )
        )
        raise LogError(f"{source}: too short: no stretch of half a second with samples{fast}")
    everything = np.concatenate([stretch.angles for stretch in signals.stretches])
    low, middle, high = np.full((3, 4), np.nan)
    for column, angle in enumerate(ANGLES):
        values = np.degrees(everything[:, column])
        values = values[np.isfinite(values)]
        if not len(values):
            raise LogError(f"{source}: {_words(angle, joints)} has no stretch of valid samples long enough to use")
        low[column], middle[column], high[column] = np.percentile(values, [1.0, 50.0, 99.0])
    for column, other in ((1, 3), (0, 2), (3, 1), (2, 0)):
        still = KNEE_STILL if column % 2 else HIP_STILL
        moves, others = high[column] - low[column], high[other] - low[other]
        if moves < still and others > 3.0 * max(moves, 0.5 * still):
            raise LogError(
                f"{source}: {_words(ANGLES[column], joints)} moves by only {moves:.1f} degrees, that of the other "
                f"leg by {others:.1f}: it was not tracked, so one leg is missing"
            )
    for column in (1, 3):
        words = _words(ANGLES[column], joints)
        if low[column] < -25.0 and high[column] < 15.0:
            raise LogError(
                f"{source}: {words} runs from {low[column]:.0f} to {high[column]:.0f} degrees: the log counts knee "
                f"flexion negative; give it the factor -1 in the joint map, or a preset that ends in -knee-negative"
            )
        if low[column] < KNEE_LOWEST or high[column] > KNEE_HIGHEST:
            raise LogError(
                f"{source}: {words} runs from {low[column]:.0f} to {high[column]:.0f} degrees: no knee does; "
                f"look at the joint map (factor, unit, offset) or at the sensor"
            )
    for column in (0, 2):
        words = _words(ANGLES[column], joints)
        if abs(middle[column]) > THIGH_MIDDLE or low[column] < THIGH_LOWEST or high[column] > THIGH_HIGHEST:
            raise LogError(
                f"{source}: {words} runs from {low[column]:.0f} to {high[column]:.0f} degrees: not a thigh's angle "
                f"from the vertical; look at the joint map (pelvis tilt, factor, unit) or at the sensor"
            )
    _check_direction(signals, joints, source)


def _check_direction(signals: Signals, joints: JointMap, source: str) -> None:
    """A knee bends while its thigh swings forward: if both bend while it goes back, a sign or a leg is wrong."""
    together = []
    for thigh in (0, 2):
        forward, bend = [], []
        for stretch in signals.stretches:
            speed = np.gradient(stretch.angles[:, thigh])
            known = np.isfinite(speed) & np.isfinite(stretch.angles[:, thigh + 1])
            forward.append(speed[known] / stretch.dt)
            bend.append(stretch.angles[known, thigh + 1])
        together.append(_correlation(np.concatenate(forward), np.concatenate(bend)))
    if max(together) < -0.1:
        raise LogError(
            f"{source}: both knees bend while their thighs swing back (correlation {together[0]:.2f}, "
            f"{together[1]:.2f}): the thighs ({', '.join(joints.terms['alpha_right'])}) count forward negative, or the "
            f"knees belong to the other legs"
        )
    for angle, found in zip(("beta_right", "beta_left"), together, strict=True):
        if found < -0.1:
            raise LogError(
                f"{source}: {_words(angle, joints)} bends while its own thigh swings back (correlation {found:.2f}), "
                f"that of the other leg does not: it is another joint's value, or of another time"
            )


def _correlation(a: Array, b: Array) -> float:
    if len(a) < 10 or a.std() < 1e-6 or b.std() < 1e-6:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def check_walking(cycles: Cycles, model: LegModel, source: str) -> None:
    """Refuse running.

    Walking has double support: a toe leaves the ground after the other heel struck, past half of the stride. The
    ankle's backward extreme follows the toe-off of a runner by a little, so near one half the speed decides. Whatever
    the legs look like, nobody runs slowly.

    Raises:
        LogError: with the phase of the toe-off and the Froude number.
    """
    if not cycles.steps or not math.isfinite(cycles.toe_off):
        return
    speed = _fastest(cycles, model)
    froude = speed**2 / (GRAVITY * model.reach)
    if froude < FROUDE_SLOWEST_RUN and cycles.toe_off > EARLIEST_TOE_OFF and _carried(cycles, model) > CARRIED:
        return
    if cycles.toe_off < 0.5 or (cycles.toe_off < 0.55 and froude > FROUDE_RUN):
        what = "running" if froude > FROUDE_SLOWEST_RUN else "marching on the spot or a wrong joint map"
        raise LogError(
            f"{source}: {what}, not walking: toe-off at {100.0 * cycles.toe_off:.0f} % of the stride, so no double "
            f"support, at {speed:.2f} m/s (Froude number {froude:.2f}); a base gait needs walking"
        )


def _carried(cycles: Cycles, model: LegModel) -> float:
    """How much of its way back under the body the support foot makes in the later half of a step, in the median.

    Half of it in walking of any speed; little in marching, where the foot is back before the other lifts.
    """
    shares = []
    for step in cycles.steps:
        x = ankle_path(step.frames[:, :2], model)[:, 0]
        if x[0] > x[-1]:
            shares.append(float((x[len(x) // 2] - x[-1]) / (x[0] - x[-1])))
    return float(np.median(shares or [0.0]))


def _fastest(cycles: Cycles, model: LegModel) -> float:
    """The greater of two speeds in [m/s]: over the flat foot, true of runners; and over the whole time on the ground.

    The first is far too low, even negative, where a bent support leg straightens while the feet pass each other.
    """
    passing = float(np.median([step.travel / step.duration for step in cycles.steps]))
    on_ground = [
        float(np.ptp(ankle_path(stride.angles, model)[:, 0])) / (stride.toe_off * stride.duration)
        for stride in cycles.strides
        if not stride.reason and stride.toe_off > 0.0
    ]
    return max([passing, *([float(np.median(on_ground))] if on_ground else [])])


def check_level_gait(report: ImportReport) -> None:
    """Refuse a base gait that nobody walks with: the joint map, a sign or a unit is wrong.

    A swing ankle that goes a little below the ground is accepted, and the report says so: leg lengths that are not the
    walker's cause it, and every gait generated from the base gait is lifted over the ground and checked.

    Raises:
        LogError: with the numbers that no walker has.
    """
    stride, reach = report.mean_gait.stride(), report.mean_gait.legs().reach
    middles = [_middle_of_stance(cycle, report.mean_gait.legs()) for cycle in report.mean_cycle.values()]
    under, bent = np.mean(middles, axis=0).tolist()
    froude = report.speed**2 / (GRAVITY * reach)
    if under < EARLIEST_MIDSTANCE and bent > MIDSTANCE_KNEE_DEG and froude > FROUDE_SLOWEST_RUN:
        raise LogError(
            f"{report.source}: running, not walking: the ankle passes under the hip at {100.0 * under:.0f} % of the "
            f"stride, with the knee bent by {bent:.0f} degrees, at {report.speed:.2f} m/s (Froude number "
            f"{froude:.2f}); a base gait needs walking"
        )
    faults = [
        str(violation)
        for violation in report.violations
        if violation.kind not in ("ground", DRAGS) or violation.value < -DEEPEST_DIP
    ]
    if stride < SHORTEST_STRIDE * reach:
        faults.append(f"the stride is {stride:.3f} m")
    if report.correction_deg > MOST_CORRECTION_DEG:
        faults.append(f"angles must change by {report.correction_deg:.1f} degrees for both feet to stand on the ground")
    for leg, cycle in report.mean_cycle.items():
        bend = math.degrees(float(np.ptp(cycle[:, 1])))
        if bend < LEAST_KNEE_BEND_DEG:
            faults.append(f"the {leg} knee bends by only {bend:.1f} degrees in a stride")
    lowest = {leg: -math.degrees(float(cycle[:, 1].min())) for leg, cycle in report.mean_cycle.items()}
    if faults and max(lowest.values()) > HYPEREXTENDED_DEG:
        knees = " and ".join(f"the {leg} one by {low:.0f}" for leg, low in lowest.items() if low > 0.0)
        raise LogError(
            f"{report.source}: no base gait: a knee is hyperextended in the mean stride ({knees} degrees): an offset "
            "of the sensor, or a wrong sign?"
        )
    if faults:
        hints = [note for note in report.notes if "pelvis" in note]
        raise LogError(
            f"{report.source}: no base gait: {'; '.join(faults)}; look at the joint map (pelvis tilt, signs, unit)"
            + (f" ({'; '.join(hints)})" if hints else "")
        )


def check_one_gait(report: ImportReport) -> None:
    """Refuse one gait for legs that are too far apart.

    Raises:
        LogError: with the distance, and what to do.
    """
    _ = report.gait


def check_stair_gait(report: ImportReport) -> None:
    """Refuse a stair gait that nobody walks with, or whose riser or tread the angles contradict.

    Raises:
        LogError: with the numbers.
    """
    assert report.riser is not None  # a stair gait's report has both
    assert report.tread is not None
    faults = []
    least = SHORTEST_STRIDE * report.mean_gait.legs().reach / 2.0
    ahead = float(np.median([swing.advance for swing in report.steps]))
    if report.tread < least:
        faults.append(
            f"the body goes {report.tread:+.2f} m forward from stair to stair, at least {least:.2f} m expected"
        )
    elif abs(ahead - report.tread) > TREAD_OFF:
        faults.append(
            f"the body goes {report.tread:.2f} m forward from stair to stair, the foot lands {ahead:.2f} m ahead"
        )
    if report.riser > HIGHEST_RISER:
        faults.append(f"the riser would be {report.riser:.2f} m")
    most = MOST_CORRECTION_DEG if report.activity == "stairs-up" else MOST_CORRECTION_DOWN_DEG
    if report.correction_deg > most:
        faults.append(f"angles must change by {report.correction_deg:.1f} degrees for both feet to stand on the stairs")
    for leg, cycle in report.mean_cycle.items():
        bend = math.degrees(float(np.ptp(cycle[:, 3])))
        if bend < LEAST_KNEE_BEND_DEG:
            faults.append(f"the {leg} knee bends by only {bend:.1f} degrees in a swing")
    if faults:
        raise LogError(
            f"{report.source}: no stair gait: {'; '.join(faults)}; look at the joint map (pelvis tilt, signs, unit) "
            f"and at what the walker did (a pause, another gait than a person's)"
        )


def _middle_of_stance(cycle: Array, model: LegModel) -> tuple[float, float]:
    """Phase of a mean cycle (n, 2), from heel strike, with the ankle under the hip; the knee there in [deg]."""
    ahead = model.thigh * np.sin(cycle[:, 0]) + model.shank * np.sin(cycle[:, 0] - cycle[:, 1])
    after = int(np.argmax(ahead < 0.0))
    if after == 0:
        return math.nan, math.nan
    phase = (after - float(ahead[after] / (ahead[after] - ahead[after - 1]))) / len(cycle)
    return phase, math.degrees(float(cycle[after, 1]))


def _words(angle: str, joints: JointMap) -> str:
    joint, _, leg = angle.partition("_")
    name = {"alpha": "thigh", "beta": "knee"}[joint]
    return f"the {leg} {name} ({', '.join(joints.terms[angle])})"
