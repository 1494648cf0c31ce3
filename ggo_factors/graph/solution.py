"""A solved gait graph: the gait, how it was found, and what the dense check says of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import gtsam

from ggo_factors.check.report import Report
from ggo_factors.check.verify import verify
from ggo_factors.errors import InfeasibleGaitError, Violation
from ggo_factors.graph.apart import TakenApart
from ggo_factors.graph.assembly import Assembly
from ggo_factors.graph.rounds import Solved
from ggo_factors.motion.gait import Gait
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import Array, short_text

if TYPE_CHECKING:
    from ggo_factors.motion.picture import Place


@dataclass(frozen=True, eq=False)
class Solution(TakenApart):
    """A solved gait graph: the gait, how it was found, and what the dense check says of it.

    Attributes:
        gait: the generated gait.
        graph: the graph of the last round.
        converged: whether the optimizer reached a stationary point that keeps all hard edges.
        reason: why, in words.
        iterations: iterations over all rounds.
        error_history: error at the start and after each iteration, over all rounds.
        rounds: how many times the graph was solved.
        report: what the dense check says of the gait.
        first_frame: the frame of the gait that the graph calls g0: not 0 where a step was replanned.
        frames_apart: frames of the gait from one frame of the graph to the next: above 1 at a high sampling rate.
        whole: from frames of the graph, (m, 4) in [rad], to the gait; None where they are its frames.
    """

    gait: Gait
    graph: Assembly
    converged: bool
    reason: str
    iterations: int
    error_history: Array
    rounds: int
    report: Report
    first_frame: int = 0
    frames_apart: float = 1.0
    whole: Callable[[Array], Gait] | None = None

    def __repr__(self) -> str:
        found = "converged" if self.converged else self.reason.partition(":")[0]
        broken = len(self.violations)
        checked = f"{broken} limit{'s' if broken > 1 else ''} broken" if broken else "checked"
        return (
            f"{type(self).__name__}({short_text(self.gait.name)}, {len(self.gait)} frames, "
            f"{len(self.keyframes)} keyframes, {self.iterations} iterations, {found}, {checked})"
        )

    def _repr_html_(self) -> str:
        from ggo_factors.check.report_card import seen, verdict  # only here: nothing but a notebook needs them
        from ggo_factors.graph.solution_card import place_of, solution_card

        report, problem = self.report, self.graph.problem
        facts = {
            "found": self.reason if not self.converged else f"converged in {self.iterations} iterations",
            "variables": f"{len(self.keyframes)} of {len(self.gait)} frames",
            "time": f"{self.gait.duration:.4g} s",
            "check": [verdict(report.violations), *map(str, report.violations)],
            **seen(report.lengths, report.landing_speed, report.knee),
            "notes": report.notes,
        }
        place = place_of(problem, self.gait)
        return solution_card(f"{type(self).__name__}: {self.gait.name}", self._on(place), problem, facts)

    def _on(self, place: Place) -> Place:
        """Where its picture is drawn, given what its graph was asked to clear."""
        return place

    @property
    def smoothness(self) -> float:
        """Gain of the second-order residual edges."""
        return self.graph.problem.smoothness

    @property
    def keyframes(self) -> tuple[int, ...]:
        """Frames of the gait that were variables in the last round."""
        return tuple(map(self._frame, self.graph.keyframes))

    @property
    def style(self) -> Array | None:
        """How this step varies from the base gait by the style, in standard deviations, (k,); None without a style."""
        asked, found = self.graph.problem.style, self.graph.state.style
        return None if asked is None or found is None else found / asked.unit

    @cached_property
    def costs(self) -> Mapping[str, float]:
        """Half sums of squares by edge family.

        They are anchor, residual, smoothness, knee, limits, obstacle, hold, end, landing and balance, `style` where
        there is one, and `user` where there are factors of a user's own.
        """
        return self.graph.costs()

    @cached_property
    def factor_graph(self) -> gtsam.NonlinearFactorGraph:
        """Graph of the last round, one factor for each edge."""
        return self.graph.plain()

    @cached_property
    def values(self) -> gtsam.Values:
        """Keyframes of the last round, for example for `gtsam.Marginals` with `factor_graph`."""
        return self.graph.values()

    def _assembly(self) -> Assembly:
        return self.graph

    def _frame(self, n: int) -> int:
        return self.first_frame + round(self.frames_apart * n)

    def _gait(self, frames: Array) -> Gait:
        return super()._gait(frames) if self.whole is None else self.whole(frames)

    @property
    def violations(self) -> tuple[Violation, ...]:
        """Every limit that the gait breaks; empty where it is good."""
        return self.report.violations

    @property
    def ok(self) -> bool:
        """Whether the solver converged and the dense check found nothing."""
        return self.converged and self.report.ok

    def save(self, path: PathLike) -> None:
        """Write the gait as `Gait.save` does, whole or not at all; `load_gait` reads it. The graph is not kept.

        Raises:
            InputError: where the file cannot be written.
        """
        self.gait.save(path)

    def require_ok(self) -> Solution:
        """Itself, where the gait is good.

        Raises:
            InfeasibleGaitError: with every violation, where it is not.
        """
        if self.ok:
            return self
        faults = [] if self.converged else [self.reason]
        faults += [str(violation) for violation in self.violations]
        raise InfeasibleGaitError("no safe gait: " + "; ".join(faults), self.violations)


def solution_of(solved: Solved) -> Solution:
    """What a user's graph came to, its gait checked densely against what the graph was asked for."""
    problem, frames = solved.graph.problem, solved.graph.state.frames
    gait = replace(problem.base, frames=frames, model=problem.model, first_step=None, last_step=None)
    landing = problem.model.endpoint(frames[-1])
    ends = [end for end in problem.ends if end.frame == len(frames) - 1]
    feet = [end.foothold for end in ends if end.foothold is not None]
    report = verify(
        gait,
        problem.model,
        start=problem.anchors.get(0),
        obstacles=[request.obstacle for request in problem.obstacles],
        foothold=max(feet, key=lambda foot: math.dist(foot, landing), default=None),
        shank_angle=next((end.shank_angle for end in ends if end.shank_angle is not None), None),
        ground=None if problem.ground is None else problem.ground.ground,
        balance=None if problem.balance is None else problem.balance.support or problem.base,
    )
    return Solution(
        gait=gait,
        graph=solved.graph,
        converged=solved.converged,
        reason=solved.reason,
        iterations=solved.iterations,
        error_history=solved.error_history,
        rounds=solved.rounds,
        report=report,
    )
