"""A walk: consecutive steps, the legs' roles swapped between them, and what each step had to do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ggo_factors.check.joint_rates import angle_faults, rate_faults
from ggo_factors.check.report import STANDARD, Report, Tolerances
from ggo_factors.check.trajectory import landing_faults, trajectory_faults
from ggo_factors.check.verify import landing_speed_of
from ggo_factors.errors import InfeasibleGaitError, InputError, Violation
from ggo_factors.graph.solution import Solution
from ggo_factors.motion.base_gaits import as_leg
from ggo_factors.motion.gait import SAME_TIME, Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.recorded import GENERATED
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, as_instance, as_number, as_tuple_of, short_text
from ggo_factors.walking.pace import slowed_times
from ggo_factors.walking.step import Step, stands_in, verify_step
from ggo_factors.walking.trajectory import JointTrajectory, joint_trajectory, times_of
from ggo_factors.walking.walk_file import read_walk, write_walk

if TYPE_CHECKING:
    from ggo_factors.motion.picture import Place
    from ggo_factors.notebook.animation import Animation


@dataclass(frozen=True, eq=False)
class Walk:
    """Consecutive steps, each with what was asked of it.

    Attributes:
        gaits: the steps.
        plan: what each step had to do, as long as `gaits`, as seen from where the walker really stood: a step's landing
            error moves the ground of the next step, so that errors do not add up.
        steps: how each step was found, as long as `gaits`; empty for a walk read from a file.
        limits: the joint limits that the steps were made within, if any; the file carries them.
        landing_speed: how fast a foot may come down at landing in [m/s], if its pace was chosen; the file carries it.
        notes: remarks on the file that the walk was read from, a line each.
        first_swing: the leg that swings in the first step, ``"right"`` or ``"left"``; the file carries it.
    """

    gaits: tuple[Gait, ...]
    plan: tuple[Step, ...]
    steps: tuple[Solution, ...] = ()
    limits: JointLimits | None = None
    notes: tuple[str, ...] = ()
    landing_speed: float | None = None
    first_swing: str = "right"

    if TYPE_CHECKING:
        # For type checkers: what is made a tuple when it is made may be any list.
        def __init__(
            self,
            gaits: Iterable[Gait],
            plan: Iterable[Step],
            steps: Iterable[Solution] = (),
            limits: JointLimits | None = None,
            notes: Iterable[str] = (),
            landing_speed: float | None = None,
            first_swing: str = "right",
        ) -> None: ...

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
        if self.landing_speed is not None:
            object.__setattr__(self, "landing_speed", as_number(self.landing_speed, "landing_speed", above=0.0))
        object.__setattr__(self, "notes", as_tuple_of(self.notes, "notes", str))
        as_leg(self.first_swing, "first_swing")

    def __repr__(self) -> str:
        first, frames = self.gaits[0], sum(map(len, self.gaits))
        seconds = sum(gait.duration for gait in self.gaits)
        legs = "no leg lengths"
        if first.model is not None:
            travel = sum(float(gait.endpoints()[-1, 0]) for gait in self.gaits)
            legs = f"{travel:.4g} m forward, {first.model.lengths()}"
        times = f"{frames} frames, {'slowed' if self._is_slowed else f'{first.dt:.4g} s apart'}, {seconds:.4g} s"
        return f"Walk({short_text(self.name)}, {times}, {legs})"

    def _repr_html_(self) -> str:
        from ggo_factors.walking.walk_card import trajectory_card, walk_card  # only here: for a notebook alone

        first, found = self.gaits[0], [step.report for step in self.steps]
        broken = [f"step {n}: {fault}" for n, report in enumerate(found, start=1) for fault in report.violations]
        facts = {
            "steps": f"{len(self.gaits)}, the {self.first_swing} leg swings first",
            "frames": f"{sum(map(len, self.gaits))}, {'slowed' if self._is_slowed else f'{first.dt:.4g} s apart'}",
            "time": f"{sum(gait.duration for gait in self.gaits):.4g} s",
            "legs": "not known" if first.model is None else first.model.lengths(),
            "limits": "of the joints" if self.limits else "",
            "check": (broken or "every step passed") if found else "not yet: see Walk.verify",
            "notes": [*self.notes, *(note for report in found for note in report.notes)],
        }
        title = self.name[:1].upper() + self.name[1:]
        if first.model is None:
            joints = self.joint_trajectory()
            return trajectory_card(title, joints.time, joints.by_name, facts)
        return walk_card(title, self._places(), facts)

    def _places(self) -> list[Place]:
        """Where each step is in the body frame of the first, for pictures."""
        from ggo_factors.walking.walk_card import places_of

        return places_of(self.gaits, self.plan, self.model, self.origins(), self.first_swing)

    @property
    def name(self) -> str:
        """What it is: how many steps, and which gaits they were made from; each step has a name of its own."""
        made = list(dict.fromkeys(filter(None, map(made_from, self.gaits))))
        more = f" and {len(made) - 1} more" if len(made) > 1 else ""
        count = f"walk of {len(self.gaits)} step{'s' if len(self.gaits) > 1 else ''}"
        return f"{count}, {made[0]}{more}" if made else count

    @property
    def _is_slowed(self) -> bool:
        """Whether its frames are not evenly apart."""
        return any(gait.paced is not None for gait in self.gaits)

    @property
    def model(self) -> LegModel:
        """The legs.

        Raises:
            InputError: where the gaits state none.
        """
        return self.gaits[0].legs()

    @property
    def times(self) -> Array:
        """Time of each frame in [s] from the first, shape (k,); a frame in which the legs change roles occurs once."""
        return times_of(self.gaits)

    def joint_trajectory(self, first_swing: str | None = None, *, rate: float | None = None) -> JointTrajectory:
        """The joint angles of both legs over time, at the frames or at a controller's rate; see `joint_trajectory`.

        The leg that swings first is the walk's own, unless `first_swing` names another.
        """
        return joint_trajectory(
            self.gaits,
            self.first_swing if first_swing is None else first_swing,
            starts_at_rest=stands_in(self.gaits[0].frames[0]),
            ends_at_rest=self.plan[-1].end_frame is not None,
            rate=rate,
        )

    def to_dataframe(self) -> Any:
        """The joints of both legs over time as `JointTrajectory.to_dataframe` has them.

        Raises:
            ImportError: where pandas is not installed.
        """
        return self.joint_trajectory().to_dataframe()

    def animate(self) -> Animation:
        """The legs in motion over their ground at the walk's own speed.

        It plays in a notebook, and is saved as a page, GIF or MP4: ``walk.animate().save("walk.gif")``.

        Raises:
            InputError: where the gaits state no leg lengths.
        """
        from ggo_factors.walking.walk_card import animation  # only here: nothing else needs it

        return animation(self.name, self.gaits, self._places())

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
        fastest = self.landing_speed if allowed.landing_speed is None else allowed.landing_speed
        reports: list[Report] = []
        start: Array | None = None
        for gait, step, found in zip(self.gaits, self.plan, self.trajectory_faults(held, allowed), strict=True):
            report = verify_step(gait, step, self.model, start, allowed)
            slams = landing_faults(report.landing_speed, fastest, len(gait) - 1, allowed.limits)
            reports.append(replace(report, violations=(*report.violations, *slams, *found)))
            start = swap_roles(gait.frames[-1])
        return tuple(reports)

    def trajectory_faults(self, limits: JointLimits | None, tolerances: Tolerances = STANDARD) -> list[list[Violation]]:
        """What is wrong with the joint trajectory over time, step by step: the part of `verify` across the steps.

        Args:
            limits: limits of the joints, or None.
            tolerances: what a good gait may be off by.
        """
        # Where a pace was chosen it is the whole trajectory, as it is played, that keeps the limits.
        by_step = limits if self.landing_speed is None else None
        found: list[list[Violation]] = []
        before: Gait | None = None
        stood = stands_in(self.gaits[0].frames[0])
        for gait, step in zip(self.gaits, self.plan, strict=True):
            stands = step.end_frame is not None
            found.append(trajectory_faults(gait, before, stood, stands, by_step, tolerances))
            before, stood = gait.swapped(), stands
        if limits is not None and self.landing_speed is not None:
            # In the roles of the first step, whichever leg swings in it.
            played, first = self.joint_trajectory("right").played, 0
            for number, (faults, gait) in enumerate(zip(found, self.gaits, strict=True)):
                last = first + len(gait) - 1
                faults += angle_faults(gait.frames, limits, tolerances.limits)
                faults += rate_faults(played, limits, tolerances.limits, first, last, swapped=number % 2 == 1)
                first = last
        return found

    def slowed(self, landing_speed: float, step: int = 0, frame: int = 0, held: bool = False) -> Walk:
        """The same path, walked slower where its joints or a landing foot would be too fast; frames stay to the bit.

        Args:
            landing_speed: how fast a foot may come down in [m/s].
            step: the step that the walker is in, from 0.
            frame: the last frame of it that is walked.
            held: whether the walker moves as fast there as it says, and not slower.

        Raises:
            InfeasibleGaitError: where the joints cannot slow down in time.
        """
        most, ends = [np.ones(1)], np.cumsum([len(gait) - 1 for gait in self.gaits])
        for gait in self.gaits:
            own = np.ones(len(gait) - 1)
            own[-2:] = min(1.0, landing_speed / max(landing_speed_of(gait, self.model), 1e-9))
            most.append(own)
        path, duration = self.joint_trajectory().played, (len(self.gaits[0]) - 1) * self.gaits[0].dt
        first = int(ends[step]) - len(self.gaits[step]) + 1 + frame
        times = slowed_times(path, self.limits, np.concatenate(most), duration, first, held)
        if times is None:
            raise _refused(step, held, [fault for found in self.trajectory_faults(self.limits) for fault in found])
        gaits, steps = list(self.gaits), list(self.steps)
        for number in range(step, len(gaits)):
            start = int(ends[number]) - len(gaits[number]) + 1
            own = times[start : int(ends[number]) + 1]
            gaits[number] = _at_times(gaits[number], own - own[0], frame if number == step else 0)
            if steps and gaits[number] is not self.gaits[number]:
                steps[number] = _told(steps[number], gaits[number])
        made = replace(self, gaits=tuple(gaits), steps=tuple(steps), landing_speed=landing_speed)
        if held:
            # Where a new path bends off suddenly the spline through it rings into the frames that are walked.
            faults = made.trajectory_faults(self.limits)[step]
            rings = [fault for fault in faults if fault.kind.endswith((" speed", " acceleration"))]
            if rings:
                raise _refused(step, held, rings)
        return made

    def save(self, path: PathLike, *, described: Mapping[str, str] | None = None) -> None:
        """Write the walk as CSV, its ground and limits in the header, whole or not at all.

        The form is `# ggo-walk 1`, 2 with a column of times where the frames are not evenly apart, or 3 on ramps.

        Args:
            path: the file.
            described: more lines for the header, by their keys, each value one line.

        Raises:
            InputError: where the file cannot be written.
        """
        names = {"name": self.name, **(described or {})}
        write_walk(path, self.gaits, self.plan, self.limits, self.landing_speed, self.first_swing, names)


def made_from(gait: Gait) -> str:
    """What a gait was made from where it says so, "generated from ...", else its name."""
    return gait.origin if gait.origin.startswith(GENERATED) and gait.name else gait.name


def _refused(step: int, held: bool, faults: list[Violation]) -> InfeasibleGaitError:
    """Why a walk cannot be slowed from a step on, counted from 0."""
    why = "the joints move too fast now to slow down in time" if held else "the joints would be too slow to walk"
    return InfeasibleGaitError(f"step {step + 1}: {why}: " + "; ".join(map(str, faults)), faults, None, step + 1)


def _at_times(gait: Gait, times: Array, walked: int) -> Gait:
    """A gait with its frames at other times in [s], itself where they are the same; those walked keep theirs."""
    now = gait.times
    if np.abs(times - now).max() <= SAME_TIME:
        return gait
    return replace(gait, paced=np.concatenate([now[: walked + 1], times[walked + 1 :]]))


def _told(solution: Solution, gait: Gait) -> Solution:
    """A solution with its gait slowed, and a note that says by how much."""
    said = f"slowed to {gait.duration:.3f} s, {gait.slowdown:.3f} times its time at the base gait's pace"
    report = solution.report
    landed = landing_speed_of(gait, gait.legs())
    return replace(solution, gait=gait, report=replace(report, landing_speed=landed, notes=(*report.notes, said)))


def load_walk(path: PathLike, *, edited: bool = False) -> Walk:
    """Read a walk that `Walk.save` wrote; its steps are not checked, see `Walk.verify`.

    Args:
        path: the file.
        edited: take a file whose numbers were changed after it was written.

    Raises:
        InputError: naming the file, the line and the value that is wrong; where numbers were changed.
    """
    gaits, plan, limits, landing_speed, swing, notes = read_walk(path, edited)
    return Walk(gaits, plan, limits=limits, notes=notes, landing_speed=landing_speed, first_swing=swing)
