"""What a user would do without the library: the same gait, check and rounds, solved three other ways.

Each rival minimises the paper's full graph, every frame a variable, to the library's tolerances. The outer loop is
one for all of them: solve without obstacles for the reference path, choose the frames that pass over obstacles, solve,
let frames join that still pass too low, until none does; then the dense check. It is written here a second time, on
every frame, and does not follow what the library may change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

import ggo_factors as ggo
from ggo_factors.check.ground import near_footholds
from ggo_factors.factors.checked import EdgeFunction
from ggo_factors.factors.end import FootholdFunction, pose_edge, shank_function
from ggo_factors.factors.height import HIP, HeightFunction
from ggo_factors.factors.obstacle import ObstacleFunction
from ggo_factors.graph.touchdown import touchdown_posture
from ggo_factors.support.inputs import Array

OBSTACLE_MARGIN, GROUND_MARGIN, GROUND_LEAST, WORTH_RAISING = 0.02, 0.01, 0.006, 0.001
MOST_ROUNDS, MOST_ATTEMPTS, FOOTHOLD_AIM = 15, 5, 0.0005
SWAPPED = [2, 3, 0, 1]

MOST_MOTIONS = 100
SMOOTHING, HIP_GAIN, HIP_SINKS = 0.2, 50.0, 0.1
POSTURE_GAIN, MOTION_GAIN = 50.0, 0.5


@dataclass(frozen=True)
class Gains:
    """The gains of the procedures, and how they stiffen where the check finds a limit broken.

    `share` is what an edge counts that sits on every frame of some stretch: above `MOST_MOTIONS` motions a step the
    procedures count gains per hundredth of a step, so that the gait is the same at any sampling rate.
    """

    end: float
    share: float = 1.0
    knee: float = 5.0
    gamma: float = 4.0
    hold: float = 1.0
    spare: float = 0.0

    def against(self, kinds: set[str]) -> Gains:
        """Stiffer where a limit of one of these kinds was broken."""
        low = bool(kinds & {"obstacle", "ground"})
        return Gains(
            self.end * (10.0 if kinds & {"foothold", "shank"} else 1.0),
            self.share,
            self.knee * (10.0 if "knee" in kinds else 1.0),
            self.gamma * (2.0 if low else 1.0),
            self.hold * (3.0 if "hip drop" in kinds else 1.5 if "ground" in kinds else 1.0),
            self.spare + (0.01 if low else 0.0),
        )


@dataclass(frozen=True)
class Lift:
    """P of a frame over `height`, held at `hold_x`, both in [m]."""

    frame: int
    height: float
    hold_x: float


@dataclass(frozen=True)
class Landing:
    """Touchdown posture, shape (4,) in [rad], the gain of the edge on it, and that of the edge on the last motion."""

    posture: Array
    posture_gain: float
    motion_gain: float


@dataclass(frozen=True)
class Problem:
    """One least-squares problem: the base frames, the first ones of the gait, and what pulls on single frames.

    `given` is the first frame, shape (1, 4), or with second-order residual edges, of gain `smoothness`, the first two,
    which say how fast the walker moves. `rest` are the last frames where they are given, (2, 4), with nothing to land
    on; else shape (0, 4). The hip of the frames in `sunk` is to be higher than `hip`.
    """

    base: Array
    model: ggo.LegModel
    given: Array
    foothold: tuple[float, float]
    shank_angle: float | None
    smoothness: float
    gains: Gains
    hip: float
    landing: Landing | None = None
    rest: Array = field(default_factory=lambda: np.zeros((0, 4)))
    lifts: tuple[Lift, ...] = ()
    sunk: tuple[int, ...] = ()

    @property
    def free(self) -> slice:
        """The frames that are variables."""
        return slice(len(self.given), len(self.base) - len(self.rest))

    def may_move(self, n: int) -> bool:
        """Whether a frame is a variable."""
        return bool(self.free.start <= n < self.free.stop)

    @property
    def last_motion_gain(self) -> float:
        """Of the first-order residual edge of the last motion: that of the landing's motion is the same edge."""
        return 1.0 + (0.0 if self.landing is None else self.landing.motion_gain)

    def points(self) -> Iterator[tuple[int, int, float, EdgeFunction]]:
        """Frame, rows, gain and function of each edge on a single frame but the knee's."""
        gains, last = self.gains, len(self.base) - 1
        for lift in self.lifts:
            yield (
                lift.frame,
                2,
                gains.share,
                ObstacleFunction(self.model, lift.height, gains.gamma, gains.hold, lift.hold_x),
            )
        for n in self.sunk:
            yield n, 1, HIP_GAIN * gains.share, HeightFunction(self.model, HIP, self.hip)
        if len(self.rest):
            return
        yield last, 2, gains.end, FootholdFunction(self.model, self.foothold)
        if self.shank_angle is not None:
            yield last, 1, gains.end, shank_function(self.shank_angle)
        if self.landing is not None:
            yield last, 4, self.landing.posture_gain, pose_edge(last, self.landing.posture, 1.0).function


@dataclass(frozen=True)
class Minimum:
    """Where a minimiser stopped, and how many iterations it took."""

    frames: Array
    iterations: int


def default_smoothness(frames: int) -> float:
    """The procedures' gain of the second-order edges for this many frames a step."""
    return (SMOOTHING * (frames - 1)) ** 2


def first_gains(frames: int, smoothness: float) -> Gains:
    """The procedures' gains of the first attempt for this many frames a step."""
    finer = max(1.0, (frames - 1) / MOST_MOTIONS)
    per_frame = 20.0 if smoothness else 5.0
    return Gains(per_frame * (min(frames - 1, MOST_MOTIONS) + 1) / finer, 1.0 / finer**2)


def landing_of(base: ggo.Gait, step: ggo.Step) -> Landing | None:
    """The procedures' landing edges of a step, whose law for n motions is that of any sampling rate."""
    posture = touchdown_posture(base.legs(), base.frames[-1], step.landing(base.legs()), step.shank_angle)
    motions = len(base) - 1
    return None if posture is None else Landing(posture, POSTURE_GAIN / motions, MOTION_GAIN * motions)


def hip_height(model: ggo.LegModel, frames: Array) -> Array:
    """Of the hip over the supporting ankle, for one frame or many."""
    thigh, knee = frames[..., 0], frames[..., 1]
    return np.asarray(model.thigh * np.cos(thigh) + model.shank * np.cos(thigh - knee))


Minimiser = Callable[[Problem, Array], Minimum]


def least_hip_height(model: ggo.LegModel, start: Array, landing: tuple[float, float]) -> float:
    """How high the hip of a step is to stay."""
    return float(hip_height(model, start)) - max(0.0, -landing[1]) - HIP_SINKS * model.reach


@dataclass(frozen=True)
class Found:
    """The gaits of a task, one for each step, and how they were found."""

    gaits: tuple[Array, ...]
    iterations: int
    rounds: int
    keyframes: int
    clearance: float
    ok: bool


def walk(base: ggo.Gait, steps: Sequence[ggo.Step], smoothness: float, minimise: Minimiser) -> Found:
    """Steps on end, the legs' roles swapped between them, each from where, and as fast as, the one before ended."""
    model, off = base.legs(), np.zeros(2)
    given = base.frames[: 2 if smoothness else 1]
    gaits: list[Array] = []
    iterations, solves, clearance, ok = 0, 0, np.inf, True
    for step in steps:
        seen = step.shifted(*off.tolist())
        minima, report = _checked_step(base, seen, given, smoothness, minimise)
        last = minima[-1].frames
        gaits.append(last)
        iterations, solves = iterations + sum(minimum.iterations for minimum in minima), solves + len(minima)
        clearance = min(clearance, report.clearance)
        ok &= report.ok
        off = model.endpoint(last[-1]) - seen.landing(model)
        drift = np.diff((last - base.frames)[-2:], axis=0)[0]
        given = last[-1:, SWAPPED]
        if smoothness:
            given = np.concatenate([given, given + np.diff(base.frames[:2], axis=0) + drift[SWAPPED]])
    return Found(tuple(gaits), iterations, solves, len(base), clearance, ok)


def _checked_step(
    base: ggo.Gait, step: ggo.Step, given: Array, smoothness: float, minimise: Minimiser
) -> tuple[list[Minimum], ggo.Report]:
    """One step with the first gains, then with stiffer ones until the check is content; the last attempt's rounds."""
    model, gains, landing = base.legs(), first_gains(len(base), smoothness), step.landing(base.legs())
    hip = least_hip_height(model, given[0], landing)
    touchdown, rest = None, np.zeros((0, 4))
    if step.end_frame is not None:
        rest = np.tile(step.end_frame, (2, 1))  # who stands in the end stands still
    elif smoothness:
        touchdown = landing_of(base, step)
    for _ in range(MOST_ATTEMPTS):
        problem = Problem(base.frames, model, given, landing, step.shank_angle, smoothness, gains, hip, touchdown, rest)
        minima = rounds(problem, step, minimise)
        report = ggo.verify(
            ggo.Gait(minima[-1].frames, base.dt, model=model),
            model,
            start=given[0],
            obstacles=step.obstacles,
            foothold=step.foothold,
            shank_angle=step.shank_angle,
            ground=step.ground,
        )
        broken = {violation.kind for violation in report.violations}
        stiffer = gains.against(broken | ({"foothold"} if report.foothold_error > FOOTHOLD_AIM else set()))
        if stiffer == gains:
            break
        gains = stiffer
    return minima, report


def rounds(problem: Problem, step: ggo.Step, minimise: Minimiser, start: Array | None = None) -> list[Minimum]:
    """The minima one after the other, from some frames, or else from the base gait moved to what is given."""
    base, model, count = problem.base, problem.model, len(problem.given)
    if start is None:
        fading = np.linspace(1.0, 0.0, len(base) - count + 1)[1:, None]
        start = base[count:] + fading * (problem.given[-1] - base[count - 1])
    frames = np.concatenate([problem.given, start[-len(base) + count :]])
    frames[problem.free.stop :] = problem.rest
    minima = _until_none_sinks(problem, frames, minimise)
    reference = model.endpoint(minima[-1].frames)
    lifts = _joined({}, reference, reference, step, problem, low_only=False)
    while lifts and len(minima) < MOST_ROUNDS:
        problem = replace(problem, lifts=tuple(lifts.values()), sunk=_sunk(problem, minima[-1].frames))
        minima += _until_none_sinks(problem, minima[-1].frames, minimise)
        grown = _joined(lifts, model.endpoint(minima[-1].frames), reference, step, problem, low_only=True)
        if grown == lifts:
            break
        lifts = grown
    return minima


def _until_none_sinks(problem: Problem, frames: Array, minimise: Minimiser) -> list[Minimum]:
    """Minima with hip edges wherever a minimum before has the hip too low."""
    minima: list[Minimum] = []
    while len(minima) < MOST_ROUNDS:
        minima.append(minimise(problem, frames))
        frames = minima[-1].frames
        sunk = _sunk(problem, frames)
        if sunk == problem.sunk:
            break
        problem = replace(problem, sunk=sunk)
    return minima


def _sunk(problem: Problem, frames: Array) -> tuple[int, ...]:
    """The frames with a hip edge, and those that need one."""
    low = np.flatnonzero(hip_height(problem.model, frames) < problem.hip).tolist()
    return tuple(sorted({*problem.sunk, *filter(problem.may_move, low)}))


def _joined(
    lifts: Mapping[tuple[int, int], Lift],
    path: Array,
    hold_at: Array,
    step: ggo.Step,
    problem: Problem,
    low_only: bool,
) -> dict[tuple[int, int], Lift]:
    """The lifts, and those that the path of P calls for; none leaves, none is lowered."""
    foot, spare = problem.model.foot, problem.gains.spare
    wanted = [(-1, n, height + spare) for n, height in _under_ground(path, hold_at, step.ground.for_ankle(foot))]
    for number, obstacle in enumerate(step.obstacles):
        box = obstacle.for_ankle(foot)
        wanted += [(number, n, box.height + OBSTACLE_MARGIN + spare) for n in _over(path, box, low_only)]
    grown = dict(lifts)
    for source, n, height in wanted:
        known = grown.get((n, source))
        if problem.may_move(n) and (known is None or known.height + WORTH_RAISING < height):
            grown[n, source] = Lift(n, height, float(hold_at[n, 0]))
    return grown


def _over(path: Array, box: ggo.Obstacle, low_only: bool) -> list[int]:
    """Frames with a piece of the path beside them over the box, or only those where it dips under its height."""
    here, there = path[:-1], path[1:]
    run = np.where(there[:, 0] == here[:, 0], np.nan, there[:, 0] - here[:, 0])
    shares = np.stack([(box.x_start - here[:, 0]) / run, (box.x_end - here[:, 0]) / run])
    shares = np.clip(np.nan_to_num(shares, nan=0.0), 0.0, 1.0)
    heights = (here[:, 1] + shares * (there[:, 1] - here[:, 1])).min(axis=0)
    low, high = np.minimum(here[:, 0], there[:, 0]), np.maximum(here[:, 0], there[:, 0])
    pieces = (low <= box.x_end) & (high >= box.x_start) & ((heights < box.height) | (not low_only))
    return np.flatnonzero(np.append(pieces, False) | np.insert(pieces, 0, False)).tolist()


def _under_ground(path: Array, hold_at: Array, ground: ggo.Ground) -> list[tuple[int, float]]:
    """Frames too close to the ground, and how high they are to go where they are held."""
    top = _ground_beside(path, ground)
    near = near_footholds(path[:, 0], top, path[[0, -1]], ground)
    inside = near & np.append(near[1:], True) & np.insert(near[:-1], 0, True)
    least = np.where(inside | (not ground.edges), 0.0, GROUND_LEAST)
    low = np.flatnonzero(path[:-1, 1] < (top + least)[:-1] - 1e-6)  # the last frame has its foothold
    wanted = np.minimum(top, _ground_beside(hold_at, ground)) + least
    return [(int(n), float(wanted[n] + (0.0 if near[n] else GROUND_MARGIN))) for n in low]


def _ground_beside(path: Array, ground: ggo.Ground) -> Array:
    """The highest ground under the pieces of a path beside each frame."""
    pieces = ground.highest_between(path[:-1, 0], path[1:, 0])
    return np.asarray(np.maximum(np.append(pieces, pieces[-1]), np.insert(pieces, 0, pieces[0])))
