"""A walk: consecutive steps, the legs' roles swapped between them, and what each step had to do."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ggo_factors.check.report import STANDARD, Report, Tolerances
from ggo_factors.check.trajectory import trajectory_faults
from ggo_factors.errors import InputError, Violation
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_instance, as_tuple_of, short_text
from ggo_factors.walking.step import Step, stands_in, verify_step
from ggo_factors.walking.trajectory import JointTrajectory, joint_trajectory
from ggo_factors.walking.walk_file import read_walk, write_walk


@dataclass(frozen=True, eq=False)
class Walk:
    """Consecutive steps, each with what was asked of it.

    Attributes:
        gaits: the steps.
        plan: what each step had to do, as long as `gaits`, as seen from where the walker really stood: a step's landing
            error moves the ground of the next step, so that errors do not add up.
        steps: how each step was found, as long as `gaits`; empty for a walk read from a file.
        limits: the joint limits that the steps were made within, if any; the file carries them.
        notes: remarks on the file that the walk was read from, a line each.
    """

    gaits: tuple[Gait, ...]
    plan: tuple[Step, ...]
    steps: tuple[Solution, ...] = ()
    limits: JointLimits | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "gaits", as_tuple_of(self.gaits, "gaits", Gait))
        object.__setattr__(self, "plan", as_tuple_of(self.plan, "plan", Step))
        if not self.gaits or len(self.gaits) != len(self.plan):
            raise InputError(f"walk: {len(self.gaits)} gaits for {len(self.plan)} planned steps; at least one of each")
        for number, gait in enumerate(self.gaits, start=1):
            if (gait.dt, gait.model) != (self.gaits[0].dt, self.gaits[0].model):
                raise InputError(f"gaits: step {number} has another time step or other legs than step 1")
        object.__setattr__(self, "steps", as_tuple_of(self.steps, "steps", Solution))
        if self.steps and len(self.steps) != len(self.gaits):
            raise InputError(f"steps: {len(self.steps)} solutions for {len(self.gaits)} gaits; one each, or none")
        if self.limits is not None:
            as_instance(self.limits, "limits", JointLimits)
        object.__setattr__(self, "notes", as_tuple_of(self.notes, "notes", str))

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
        return joint_trajectory(
            self.gaits,
            first_swing,
            starts_at_rest=stands_in(self.gaits[0].frames[0]),
            ends_at_rest=self.plan[-1].end_frame is not None,
        )

    def origins(self) -> Array:
        """Where the supporting ankle stands in each step, in the body frame of the first, in [m], shape (n, 2)."""
        ends = [gait.endpoints(self.model)[-1] for gait in self.gaits[:-1]]
        return np.concatenate([np.zeros((1, 2)), np.cumsum(np.reshape(ends, (-1, 2)), axis=0)])

    def verify(self, tolerances: Tolerances | None = None, *, limits: JointLimits | None = None) -> tuple[Report, ...]:
        """The dense check of every step, each from where the one before ended, and of the whole trajectory over time.

        Args:
            tolerances: what a good gait may be off by; `STANDARD` if None.
            limits: joint limits, checked at every frame, across changes of legs and where the walker stands; those of
                the walk itself if None.

        Raises:
            InputError: where the gaits state no leg lengths, or an argument is unusable.
        """
        allowed = STANDARD if tolerances is None else as_instance(tolerances, "tolerances", Tolerances)
        held = self.limits if limits is None else as_instance(limits, "limits", JointLimits)
        reports: list[Report] = []
        start: Array | None = None
        for gait, step, found in zip(self.gaits, self.plan, self.trajectory_faults(held, allowed), strict=True):
            report = verify_step(gait, step, self.model, start, allowed)
            reports.append(replace(report, violations=(*report.violations, *found)))
            start = swap_roles(gait.frames[-1])
        return tuple(reports)

    def trajectory_faults(self, limits: JointLimits | None, tolerances: Tolerances = STANDARD) -> list[list[Violation]]:
        """What is wrong with the joint trajectory over time, step by step: the part of `verify` across the steps.

        Args:
            limits: limits of the joints, or None.
            tolerances: what a good gait may be off by.
        """
        found: list[list[Violation]] = []
        before: Array | None = None
        stood = stands_in(self.gaits[0].frames[0])
        for gait, step in zip(self.gaits, self.plan, strict=True):
            stands = step.end_frame is not None
            found.append(trajectory_faults(gait, before, stood, stands, limits, tolerances))
            before, stood = swap_roles(gait.frames), stands
        return found

    def save(self, path: PathLike) -> None:
        """Write the walk as CSV (`# ggo-walk 1`), its ground and limits in the header, whole or not at all.

        Raises:
            InputError: where the file cannot be written.
        """
        write_walk(path, self.gaits, self.plan, self.limits)


def load_walk(path: PathLike, *, edited: bool = False) -> Walk:
    """Read a walk that `Walk.save` wrote; its steps are not checked, see `Walk.verify`.

    Args:
        path: the file.
        edited: take a file whose numbers were changed after it was written.

    Raises:
        InputError: naming the file, the line and the value that is wrong; where numbers were changed.
    """
    gaits, plan, limits, notes = read_walk(path, edited)
    return Walk(gaits, plan, limits=limits, notes=notes)
