"""A walk: several steps on end, the legs' roles swapped between them; what it asks for, and its file."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.check.verify import Report, Tolerances, verify
from ggo_factors.errors import InputError
from ggo_factors.graph.optimizer import Solution
from ggo_factors.motion.gait import (
    FRAME_COLUMNS,
    Gait,
    check_angles_deg,
    gait_from_table,
    gait_header,
    swap_roles,
)
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Gap, Ground, Obstacle
from ggo_factors.support.csv_table import Table, read_table, write_table
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_angles, as_array, as_instance, as_number, as_tuple_of, short_text

STANDING: Array = as_array(np.zeros(4), "STANDING", (4,))
"""The frame of a walker who stands straight, feet together."""


@dataclass(frozen=True)
class Step:
    """What one step of a walk must do. All places are in the body frame of this step.

    Attributes:
        foothold: where P must land in [m], shape (2,); may be left out where `end_frame` is given.
        obstacles: boxes to step over.
        gaps: pits with no foothold in them.
        shank_angle: wanted angle of the swinging shank to the ground at landing in [rad], or None.
        ground: height of the ground; level at 0 by default.
        end_frame: frame to end in exactly, shape (4,) in [rad], for example `STANDING`; or None.
        keep_pose: whether to land, as far as the foothold lets it, in the pose in which the step before landed. Without
            it a flight of stairs sinks into a deeper crouch with every step, each bending on from where the last ended.

    Raises:
        InputError: where there is neither foothold nor end frame, or a value is unusable.
    """

    foothold: tuple[float, float] | None = None
    obstacles: tuple[Obstacle, ...] = ()
    gaps: tuple[Gap, ...] = ()
    shank_angle: float | None = None
    ground: Ground = field(default_factory=Ground)
    end_frame: tuple[float, float, float, float] | None = None
    keep_pose: bool = False

    def __post_init__(self) -> None:
        if self.foothold is not None:
            object.__setattr__(self, "foothold", tuple(as_array(self.foothold, "foothold", (2,)).tolist()))
        if self.end_frame is not None:
            object.__setattr__(self, "end_frame", tuple(as_angles(self.end_frame, "end_frame", (4,)).tolist()))
        if self.foothold is None and self.end_frame is None:
            raise InputError("foothold: a step needs a foothold, or an end frame")
        if self.shank_angle is not None:
            object.__setattr__(self, "shank_angle", float(as_angles(self.shank_angle, "shank_angle", ())))
        object.__setattr__(self, "obstacles", as_tuple_of(self.obstacles, "obstacles", Obstacle))
        object.__setattr__(self, "gaps", as_tuple_of(self.gaps, "gaps", Gap))
        as_instance(self.ground, "ground", Ground)

    def landing(self, model: LegModel) -> tuple[float, float]:
        """Where P lands in [m]: the foothold, or where the end frame puts it."""
        if self.foothold is not None:
            return self.foothold
        x, y = model.endpoint(np.array(self.end_frame)).tolist()
        return (x, y)

    def shifted(self, x: float, y: float) -> Step:
        """The step as seen from a body frame that stands `x` further on and `y` higher, both in [m]."""
        foothold = None if self.foothold is None else (self.foothold[0] - x, self.foothold[1] - y)
        return replace(
            self,
            foothold=foothold,
            obstacles=tuple(obstacle.shifted(x, y) for obstacle in self.obstacles),
            gaps=tuple(gap.shifted(x) for gap in self.gaps),
            ground=self.ground.shifted(x, y),
        )


@dataclass(frozen=True, eq=False)
class JointTrajectory:
    """Joint angles of both legs over time: what an exoskeleton replays.

    Attributes:
        time: time in [s], shape (k,).
        left_hip: thigh from the vertical, forward positive, in [rad], shape (k,).
        left_knee: flexion in [rad], shape (k,).
        right_hip: as `left_hip`.
        right_knee: as `left_knee`.
    """

    time: Array
    left_hip: Array
    left_knee: Array
    right_hip: Array
    right_knee: Array


def joint_trajectory(gaits: Sequence[Gait], first_swing: str = "right") -> JointTrajectory:
    """The joint angles of both legs over steps on end; the frame at a role swap occurs once.

    Args:
        gaits: the steps, each starting in the last frame of the one before with the roles swapped.
        first_swing: the leg that swings first, ``"right"`` or ``"left"``.

    Raises:
        InputError: where `first_swing` is neither, the time steps differ, or a step does not start where the one before
            ended (1e-9 rad).
    """
    if first_swing not in ("right", "left"):
        raise InputError(f"first_swing: {first_swing!r} is neither 'right' nor 'left'")
    gaits = as_tuple_of(gaits, "gaits", Gait)
    if not gaits:
        raise InputError("gaits: a trajectory needs at least one step")
    parts: list[Array] = []
    for number, gait in enumerate(gaits, start=1):
        if gait.dt != gaits[0].dt:
            raise InputError(f"step {number}: dt is {gait.dt:g} s, in step 1 {gaits[0].dt:g} s")
        swinging_left = (first_swing == "left") == (number % 2 == 1)
        # Columns: left hip, left knee, right hip, right knee.
        frames = swap_roles(gait.frames) if swinging_left else gait.frames
        if parts:
            jump = float(np.abs(frames[0] - parts[-1][-1]).max())
            if jump > Tolerances().start:
                raise InputError(f"step {number}: starts {jump:.3g} rad away from the end of step {number - 1}")
        parts.append(frames[1:] if parts else frames)
    joined = np.concatenate(parts)
    columns = [as_array(column, "trajectory", (None,)) for column in joined.T]
    return JointTrajectory(as_array(np.arange(len(joined)) * gaits[0].dt, "time", (None,)), *columns)


@dataclass(frozen=True, eq=False)
class Walk:
    """Steps on end, each with what was asked of it.

    Attributes:
        gaits: the steps.
        plan: what each step had to do, as long as `gaits`, as seen from where the walker really stood: a step's landing
            error moves the ground of the next step, so that errors do not add up.
        steps: how each step was found, as long as `gaits`; empty for a walk read from a file.
    """

    gaits: tuple[Gait, ...]
    plan: tuple[Step, ...]
    steps: tuple[Solution, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "gaits", as_tuple_of(self.gaits, "gaits", Gait))
        object.__setattr__(self, "plan", as_tuple_of(self.plan, "plan", Step))
        if not self.gaits or len(self.gaits) != len(self.plan):
            raise InputError(f"walk: {len(self.gaits)} gaits for {len(self.plan)} planned steps; at least one of each")
        for number, gait in enumerate(self.gaits, start=1):
            if (gait.dt, gait.model) != (self.gaits[0].dt, self.gaits[0].model):
                raise InputError(f"gaits: step {number} has another time step or other legs than step 1")

    def __repr__(self) -> str:
        first, frames = self.gaits[0], sum(map(len, self.gaits))
        seconds = sum(gait.duration for gait in self.gaits)
        legs = "no leg lengths"
        if first.model is not None:
            travel = sum(float(gait.endpoints()[-1, 0]) for gait in self.gaits)
            legs = f"{travel:.4g} m forward, {first.model.lengths()}"
        steps = f"{len(self.gaits)} step{'s' if len(self.gaits) > 1 else ''}"
        times = f"{frames} frames, {first.dt:.4g} s apart, {seconds:.4g} s"
        return f"Walk({short_text(first.name)}, {steps}, {times}, {legs})"

    @property
    def model(self) -> LegModel:
        """The legs.

        Raises:
            InputError: where the gaits state none.
        """
        return self.gaits[0].legs()

    def joint_trajectory(self, first_swing: str = "right") -> JointTrajectory:
        """The joint angles of both legs over time, see `joint_trajectory`."""
        return joint_trajectory(self.gaits, first_swing)

    def origins(self) -> Array:
        """Where the supporting ankle stands in each step, in the body frame of the first, in [m], shape (n, 2)."""
        ends = [gait.endpoints(self.model)[-1] for gait in self.gaits[:-1]]
        return np.concatenate([np.zeros((1, 2)), np.cumsum(np.reshape(ends, (-1, 2)), axis=0)])

    def verify(self, tolerances: Tolerances | None = None) -> tuple[Report, ...]:
        """The dense check of every step, each from where the one before ended.

        Raises:
            InputError: where the gaits state no leg lengths.
        """
        starts: list[ArrayLike | None] = [None, *(swap_roles(gait.frames[-1]) for gait in self.gaits[:-1])]
        return tuple(
            verify_step(gait, step, self.model, start, tolerances)
            for gait, step, start in zip(self.gaits, self.plan, starts, strict=True)
        )

    def save(self, path: PathLike) -> None:
        """Write the walk as CSV (`# ggo-walk 1`), its ground in the header, whole or not at all.

        Raises:
            InputError: where the file cannot be written.
        """
        header = gait_header(self.gaits[0])
        for number, step in enumerate(self.plan, start=1):
            header[f"step {number}"] = json.dumps(_step_to_json(step))
        rows = [
            np.column_stack([np.full(len(gait), number), np.degrees(gait.frames)])
            for number, gait in enumerate(self.gaits, start=1)
        ]
        write_table(path, "ggo-walk", header, ("step", *FRAME_COLUMNS), np.concatenate(rows), counts=1)


def load_walk(path: PathLike) -> Walk:
    """Read a walk that `Walk.save` wrote; its steps are not checked, see `Walk.verify`.

    Raises:
        InputError: naming the file, the line and the value that is wrong.
    """
    table = read_table(path, "ggo-walk", ("step", *FRAME_COLUMNS))
    numbers, degrees = table.values[:, 0], table.values[:, 1:]
    check_angles_deg(table, degrees, FRAME_COLUMNS)
    count = sum(key.startswith("step ") for key in table.header)
    plan = tuple(_step_from_json(table, f"step {number}") for number in range(1, count + 1))
    jumps = np.diff(numbers, prepend=1.0)
    for row in np.flatnonzero(((jumps != 0.0) & (jumps != 1.0)) | (numbers > count))[:1]:
        line = table.first_line + row
        raise InputError(f"{path}, line {line}: step {numbers[row]:g} does not follow the header's steps")
    gaits = []
    for number in range(1, count + 1):
        rows = degrees[numbers == number]
        if len(rows) < 2:
            raise InputError(f"{path}: step {number} has {len(rows)} frames, expected at least 2")
        gaits.append(gait_from_table(table, np.radians(rows)))
    if not gaits:
        raise InputError(f"{path}: the header has no line '# step 1: ...'")
    return Walk(tuple(gaits), plan)


def verify_step(
    gait: Gait,
    step: Step,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    tolerances: Tolerances | None = None,
    limits: JointLimits | None = None,
) -> Report:
    """The dense check of one step against what was asked of it; see `verify`."""
    legs = gait.legs(model)
    return verify(
        gait,
        legs,
        start=start,
        obstacles=step.obstacles,
        gaps=step.gaps,
        foothold=step.landing(legs),
        shank_angle=step.shank_angle,
        tolerances=tolerances,
        ground=step.ground,
        end_frame=step.end_frame,
        limits=limits,
    )


def across(
    plan: Sequence[Step], model: LegModel, obstacles: Sequence[Obstacle], gaps: Sequence[Gap]
) -> tuple[Step, ...]:
    """Steps on level ground, each with all obstacles and gaps, as seen from its own supporting foot.

    Args:
        plan: the steps.
        model: the legs.
        obstacles: boxes in the body frame of the first step.
        gaps: pits in the body frame of the first step.
    """
    placed, stands = [], 0.0
    for step in plan:
        boxes = [box.shifted(stands) for box in obstacles]
        pits = [gap.shifted(stands) for gap in gaps]
        placed.append(replace(step, obstacles=(*step.obstacles, *boxes), gaps=(*step.gaps, *pits)))
        stands += step.landing(model)[0]
    return tuple(placed)


def _step_to_json(step: Step) -> dict[str, object]:
    return {
        "foothold_m": step.foothold,
        "obstacles_m": [_obstacle_to_json(obstacle) for obstacle in step.obstacles],
        "gaps_m": [[g.x_start, g.x_end] for g in step.gaps],
        "shank_angle_deg": None if step.shank_angle is None else math.degrees(step.shank_angle),
        "ground_edges_m": step.ground.edges,
        "ground_heights_m": step.ground.heights,
        "end_frame_deg": None if step.end_frame is None else [math.degrees(angle) for angle in step.end_frame],
        "keep_pose": step.keep_pose,
    }


def _obstacle_to_json(obstacle: Obstacle) -> list[float]:
    numbers = list(astuple(obstacle))
    return numbers if obstacle.is_uncertain else numbers[:3]


def _step_from_json(table: Table, key: str) -> Step:
    text = table.text(key)
    try:
        given = json.loads(text)
        angle, frame = given["shank_angle_deg"], given["end_frame_deg"]
        return Step(
            foothold=given["foothold_m"],
            obstacles=tuple(Obstacle(*numbers) for numbers in given["obstacles_m"]),
            gaps=tuple(Gap(*numbers) for numbers in given["gaps_m"]),
            shank_angle=None if angle is None else math.radians(as_number(angle, "shank_angle_deg")),
            ground=Ground(tuple(given["ground_edges_m"]), tuple(given["ground_heights_m"])),
            end_frame=None if frame is None else tuple(np.radians(as_array(frame, "end_frame_deg", (4,))).tolist()),
            keep_pose=bool(given["keep_pose"]),
        )
    except (InputError, KeyError) as error:
        problem = f"{key!r} lacks {error}" if isinstance(error, KeyError) else f"{key!r}: {error}"
        raise InputError(f"{table.path}: header {problem}") from error
    except (ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{table.path}: header {key!r} does not describe a step: {text:.60}") from error
