"""From a step to be made to its gait graph, or to what speaks against any gait; and from solved frames to a gait."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ggo_factors.check.ground import misplaced
from ggo_factors.check.joint_rates import LEGS, even_faults
from ggo_factors.check.leg_collision import blocks_of, leg_faults, shank_between
from ggo_factors.check.report import STANDARD
from ggo_factors.check.uncertainty import all_cautious
from ggo_factors.errors import Violation
from ggo_factors.graph.problem import Problem, factor_frames
from ggo_factors.graph.requests import (
    MOTION_GAIN,
    POSTURE_GAIN,
    BalanceRequest,
    EndRequest,
    GroundRequest,
    JointLimitRequest,
    LandingRequest,
    LegRequest,
    ObstacleRequest,
    StartRequest,
    StyleRequest,
    balance_gain,
    style_request,
)
from ggo_factors.graph.sampling import Sampling
from ggo_factors.graph.touchdown import posture_on
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.recorded import GENERATED
from ggo_factors.motion.style import Style
from ggo_factors.motion.zero_moment import start_shift
from ggo_factors.procedures.gains import Gains
from ggo_factors.procedures.own import own_factors
from ggo_factors.procedures.task import LEAST_FRAMES_FOR_A_RATE, MOST_MOTIONS, Beginning, StepTask
from ggo_factors.support.inputs import Array

OBSTACLE_MARGIN = 0.02
"""Height to spare over a box in [m]: the paper's delta."""
CAUTIOUS_MARGIN = 0.01
"""The same over a box that was measured with an error: it is made larger already, see `cautious`."""
HARD_MARGIN = 0.005
"""The same where obstacles are constraints, in [m]: they give way only between two frames."""
LEG_MARGIN = 0.01
"""Distance in [m] that thighs and shanks keep from obstacles and stairs."""
GROUND_MARGIN = 0.01
"""Height over the ground in [m], away from the footholds."""
WITHIN = 0.01
"""Share by which the acceleration at an upsampled start stays within its limit."""
STRAIGHT, SAVED = 0.9 * STANDARD.knee, math.radians(0.3)
"""A knee that would go on beyond the first of these in [rad] from one step to the next is slowed, by this at most."""
HIP_SINKS = 0.1
"""Share of the leg by which the hip may sink before an edge pushes it up, half of what the check allows."""


def beginning_of(task: StepTask) -> Beginning:
    """How what is left of a step begins.

    Raises:
        InputError: where a factor of the user's own does not fit the step.
    """
    done, limits, dt = len(task.walked) - 1, task.settings.limits, task.base.dt
    fine, rest, every = _ahead(task.base, done)
    motion = fine.frames[1] - fine.frames[0]
    extrapolated, offset = motion + task.velocity_offset, task.velocity_offset
    if limits is not None:
        slowest, fastest = -limits.speed * dt, limits.speed * dt
        last = task.motion_into()
        if last is not None:
            # Also across the change of legs, where a base gait that does not close to the last digit jumps a little.
            bend = limits.acceleration * dt**2
            slowest, fastest = np.maximum(slowest, last - bend), np.minimum(fastest, last + bend)
        within = (extrapolated >= slowest) & (extrapolated <= fastest)
        offset = np.where(within, offset, np.clip(extrapolated, slowest, np.maximum(slowest, fastest)) - motion)
    carried, stands = None, not extrapolated.any()
    # Without smoothness nothing keeps a speed, but a walker who stands starts from rest all the same.
    if (task.settings.smoothness or stands) and len(rest) >= LEAST_FRAMES_FOR_A_RATE:
        onward = task.walked[-1] + (rest.frames[1] - rest.frames[0]) + every * offset
        if not done and task.last_motion is not None:
            # The step before must not end so that this one cannot begin.
            short = np.where([False, True] * 2, STRAIGHT - onward, 0.0)
            saved = np.where((short > 0.0) & (short < SAVED), short, 0.0)
            offset, onward = offset + saved / every, onward + saved
        carried = task.walked[-1] if stands else onward
    own = own_factors(task, rest, fine) if task.step.factors else ()
    style = task.settings.style
    known = done or stands or task.moves or task.last_motion is not None
    # In the base gait's own first frame the walker moves as the base gait does.
    known = known or np.array_equal(task.walked[-1], task.base.frames[0])
    varies = carried is not None and style is not None and style.helps and not known
    return Beginning(done, fine, rest, every, extrapolated, offset, stands, carried, varies, own)


@lru_cache(maxsize=16)
def _ahead(base: Gait, done: int) -> tuple[Gait, Gait, float]:
    """The base gait from a frame on, the same at the rate that a step is solved at, and the ratio of the two rates."""
    every = max(1.0, (len(base) - 1) / MOST_MOTIONS)
    fine = Gait(base.frames[done:], base.dt, base.name, base.origin, base.model)
    if every == 1.0:
        return fine, fine, every
    rest = fine.resampled(max(LEAST_FRAMES_FOR_A_RATE, round((len(fine) - 1) / every) + 1))
    return fine, rest, (len(fine) - 1) / (len(rest) - 1)


def impossible(task: StepTask, begin: Beginning) -> list[Violation]:
    """What speaks against any gait at all for a step, whatever the graph says.

    Args:
        task: the step.
        begin: how what is left of it begins.
    """
    step, model = task.step, task.model
    from_x, from_y = model.endpoint(task.walked[-1]).tolist()
    under = from_y - float(step.ground.height_at(from_x))
    found = list[Violation]()
    if under < -STANDARD.ground_at_ends:
        note, limit = "under the swinging foot, as it stands now", -STANDARD.ground_at_ends
        found.append(Violation("ground", float(begin.done), under, limit, "m", note))
    start, landing = (from_x, from_y), step.landing(model)
    found += misplaced(model, start, landing, step.obstacles, step.gaps, step.ground, STANDARD, begin.done > 0)
    for obstacle in step.obstacles:
        if obstacle.height > 2.0 * model.reach:
            found.append(Violation("obstacle's height", None, obstacle.height, 2.0 * model.reach, "m", str(obstacle)))
    if begin.carried is not None and begin.carried[1::2].min() < STANDARD.knee:
        knees = np.degrees(begin.carried[1::2])
        leg = f"{LEGS[int(knees.argmin())]}, as it moves now"
        limit = math.degrees(STANDARD.knee)
        found.append(Violation("knee", begin.done + begin.every, float(knees.min()), limit, "deg", leg))
    if task.settings.limits is not None:
        found += _beyond_limits(task, begin, task.settings.limits)
    if model.has_bodies:
        # The frame that the walker is in, and that to which its speed carries it.
        given, now = [task.walked[-1]], [float(begin.done)]
        if begin.carried is not None:
            given.append(begin.carried)
            now.append(begin.done + begin.every)
        here = model.joints(np.array(given))
        found += leg_faults(model, here, np.array(now), step.obstacles, step.ground)[1]
    return found


def _beyond_limits(task: StepTask, begin: Beginning, limits: JointLimits) -> list[Violation]:
    """The joint limits that the walker is beyond now: in angle, or in speed by more than it can slow by in a frame."""
    here, dt = task.walked[-1], task.base.dt
    found = [
        replace(fault, frame=float(begin.done), note=f"{fault.note}, as it stands now")
        for fault in even_faults(np.array([here, here]), dt, limits, STANDARD.limits)
    ]
    if begin.carried is not None:
        speeds = begin.extrapolated / dt
        beyond = np.abs(speeds) - limits.acceleration * dt > limits.speed * (1.0 + STANDARD.limits)
        for n in np.flatnonzero(beyond).tolist():
            kind, note = ("hip speed", "knee speed")[n % 2], f"{LEGS[n // 2]}, as it moves now"
            value = math.degrees(speeds[n])
            most = math.copysign(math.degrees(limits.speed[n]), value)
            found.append(Violation(kind, begin.done + 0.5, value, most, "deg/s", note))
    return found


def problem_of(task: StepTask, begin: Beginning, gains: Gains) -> Problem:
    """The gait graph of what is left of a step.

    Args:
        task: the step.
        begin: how what is left of it begins.
        gains: gains of the attempt.
    """
    step, model, settings, last = task.step, task.model, task.settings, len(begin.rest) - 1
    anchors, start, rests = {0: task.walked[-1]}, None, list[int]()
    if begin.carried is not None:
        # A second frame that follows from the walker's speed joins the steps without a jump in joint speed.
        if begin.varies:
            start = StartRequest(begin.every * begin.velocity_offset, 0.0, varies=True)
        elif begin.every == 1.0 or begin.stands:
            anchors[1] = begin.carried
        else:
            # The first frame of the full rate is not among those of the graph.
            start = StartRequest(begin.every * begin.velocity_offset, 1.0 / begin.every)
    landing, ends, touchdown = step.landing(model), [], None
    if step.end_frame is not None:
        anchors[last] = np.array(step.end_frame)
        # A walker who stands in the end is at rest: the last motion is 0.
        if last > 2:
            anchors[last - 1] = anchors[last]
    else:
        ends.append(EndRequest(last, landing, step.shank_angle, None, np.inf if settings.hard else gains.end))
        if settings.landing:
            posture = _touchdown(task, landing)
            if posture is not None:
                # Counted over the whole step, so that a replan that changes nothing leaves the rest as it was.
                motions = (len(task.base) - 1) / begin.every
                touchdown = LandingRequest(
                    posture, gains.landing * POSTURE_GAIN / motions, gains.landing * MOTION_GAIN * motions
                )
    if begin.every > 1.0:
        rests = [1] * begin.stands + [last - 2] * (step.end_frame is not None)
    boxes, obstacles, margins = step.obstacles, [], []
    for obstacle in step.obstacles:
        margins.append(CAUTIOUS_MARGIN if obstacle.is_uncertain else OBSTACLE_MARGIN)
    if CAUTIOUS_MARGIN in margins:
        boxes = all_cautious(step.obstacles)
    for obstacle, box, margin in zip(step.obstacles, boxes, margins, strict=True):
        lift = 0.0 if obstacle.is_edge else step.lift
        spare = max(lift, HARD_MARGIN if settings.hard else margin) + gains.spare
        obstacles.append(ObstacleRequest(box, None, gains.hold, gains.gamma, spare))
    hip = float(model.hip_height(task.walked[0])) - max(0.0, -float(landing[1])) - HIP_SINKS * model.reach
    joints = []
    if settings.limits is not None:
        joints.append(JointLimitRequest(settings.limits.tightened(gains.inside), gains.limits))
    return Problem(
        base=begin.rest,
        fine=begin.rest if settings.hard else begin.fine,
        model=model,
        knee_gain=gains.knee,
        hard=settings.hard,
        smoothness=settings.smoothness / begin.every**2,
        anchors=anchors,
        start=start,
        rests=tuple(rests),
        obstacles=tuple(obstacles),
        ground=GroundRequest(step.ground, gains.hold, gains.gamma, GROUND_MARGIN + gains.spare),
        ends=tuple(ends),
        landing=touchdown,
        balance=_balance(task, begin) if settings.balance else None,
        style=None if settings.style is None else _style(task, begin, settings.style),
        least_hips=(hip,),
        legs=(LegRequest(boxes, step.ground, LEG_MARGIN + gains.spare, gains.legs),) if model.has_bodies else (),
        joints=tuple(joints),
        own=begin.own,
        own_frames=frozenset().union(*(factor_frames(factor, len(begin.rest)) for factor in begin.own)),
    )


def _balance(task: StepTask, begin: Beginning) -> BalanceRequest:
    """The balance edges of what is left of a step, their gain and shift counted over the whole, as for landing."""
    base = task.base
    gain = balance_gain(task.settings.balance, (len(base) - 1) / begin.every)
    shift = start_shift(task.model, base.frames, base.dt, task.walked[0])
    return BalanceRequest(gain, shift=shift, since=begin.done * base.dt)


def _style(task: StepTask, begin: Beginning, style: Style) -> StyleRequest | None:
    """How the base gait varies over what is left of a step; None where the style does not help."""
    motions = len(task.base) - 1
    return style_request(style, len(begin.rest), motions / begin.every, begin.done / motions) if style.helps else None


def _touchdown(task: StepTask, landing: tuple[float, float]) -> Array | None:
    """The touchdown posture; where a bone lies in a block there, that with the shank as upright as passes beside it."""
    step, model, last = task.step, task.model, tuple(task.base.frames[-1].tolist())
    posture = posture_on(landing, model, last, step.shank_angle)
    if posture is None or model.bones == "points" or step.shank_angle is not None:
        return posture
    leans = float(posture[2] - posture[3])
    least, most = shank_between(blocks_of(model, step.obstacles, step.ground), landing, model.shank)
    if least <= leans <= most or least > most:
        return posture
    return posture_on(landing, model, last, math.pi / 2.0 + min(max(leans, least), most))


def gait_of(task: StepTask, begin: Beginning, bent: Array) -> Gait:
    """The whole step at the full rate: the frames that are walked, then those solved for, (k, 4) in [rad]."""
    origin = f"{GENERATED}{task.base.name}" if task.base.name else task.base.origin
    name = f"step to {task.step.landing(task.model)[0]:.3f} m"
    ahead = bent if begin.every == 1.0 else _upsampled(task, begin, bent)
    frames, dt, walked = np.concatenate([task.walked[:-1], ahead]), task.base.dt, task.walked_times
    paced = None if walked is None else np.append(walked, walked[-1] + dt * np.arange(1, len(ahead)))
    return Gait(frames, dt, name, origin, task.model, paced=paced)


def _upsampled(task: StepTask, begin: Beginning, bent: Array) -> Array:
    """Frames at the full rate: the offset from the base gait, solved for at fewer, is a cubic spline through them."""
    count, rests = len(begin.rest), task.step.end_frame is not None
    # Out of rest and into it the joints move from the second and to the last but one of the frames solved for.
    first, last = int(begin.stands and begin.carried is not None), count - 1 - rests
    slopes = begin.every * np.gradient(begin.fine.frames, axis=0)
    at = np.arange(len(begin.fine)) / begin.every
    leaves = -_between(slopes, at, first) if first else begin.every * begin.velocity_offset
    offsets, curvature = bent - begin.rest.frames, np.zeros((count, 4))
    leads = bool(first or task.settings.smoothness) and not begin.varies
    weights = _curvature_weights(last - first + 1, leads, rests)
    ends = np.vstack([offsets[first : last + 1], leaves, -_between(slopes, at, last)])
    curvature[first : last + 1] = weights @ ends
    limits = task.settings.limits
    if limits is not None and not first and weights[0, -2]:
        # A spline bends most where its slope is given. The slope gives way by the little that the limit asks for.
        bends = curvature[0] + begin.every**2 * np.diff(begin.fine.frames[:3], 2, axis=0)[0]
        most = (1.0 - WITHIN) * limits.acceleration * (begin.every * task.base.dt) ** 2
        ends[-2] -= (bends - np.clip(bends, -most, most)) / weights[0, -2]
        curvature[first : last + 1] = weights @ ends
    sampling = Sampling(begin.rest.frames, begin.fine.frames)
    frames = sampling.frames(bent) + sampling.curved(curvature)
    frames[[0, -1]] = bent[[0, -1]]
    if first:
        frames[at <= first] = bent[0]
    if rests:
        frames[at >= last] = bent[-1]
    return np.asarray(frames)


def _between(values: Array, at: Array, place: float) -> Array:
    """Values (m, 4) at places (m,), linear between them, at another place."""
    return np.array([np.interp(place, at, column) for column in values.T])


@lru_cache(maxsize=8)
def _curvature_weights(count: int, begins: bool, ends: bool) -> Array:
    """Weights of the values at `count` knots, and of the slopes at both ends, in a spline's second derivatives there.

    Shape (count, count + 2). An end whose slope is not given has no curvature.
    """
    from scipy.interpolate import CubicSpline  # here, since it takes longer to import than the whole library

    free: Any = (2, np.zeros(count + 2))
    knots, values, slopes = np.arange(count), np.eye(count, count + 2), np.eye(count + 2)[-2:]
    spline = CubicSpline(knots, values, bc_type=((1, slopes[0]) if begins else free, (1, slopes[1]) if ends else free))
    return np.asarray(spline(knots, 2))
