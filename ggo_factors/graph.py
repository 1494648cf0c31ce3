"""The gait graph: a base gait, edges in the paper's words, and GTSAM underneath."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Literal

import gtsam
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ggo_factors.arrays import Array, as_angles, as_array, as_instance, as_number, as_tuple_of
from ggo_factors.crossing import Lifts, thinned, wishes
from ggo_factors.edges import EndEdge, GroundEdges, ObstacleEdges
from ggo_factors.errors import GraphError, InputError, UnreachableFootholdError
from ggo_factors.factors import (
    Edge,
    anchor_edge,
    fill_spans,
    frame_key,
    frame_of_key,
    knee_edge,
    require_fit,
    residual_edge,
    stacked_factor,
)
from ggo_factors.gait import Gait
from ggo_factors.model import LegModel
from ggo_factors.solve import (
    HARD_TOLERANCE,
    Outcome,
    Solution,
    common_offset_is_free,
    costs_of,
    descend,
    graph_of,
    judged,
)
from ggo_factors.terrain import Ground, Obstacle
from ggo_factors.verify import verify

MOST_ROUNDS = 15
STACKED = 12
"""How many neighbouring keyframes share one factor where the graph is solved."""
FINEST = 100
"""Above this many frame-to-frame motions the edges that `solve` chooses stand for several frames each."""


@dataclass(frozen=True)
class _Round:
    """What one solve of the graph consists of beside the edges that the user gave."""

    frames: Array
    lifts: Lifts = field(default_factory=Lifts)
    knees: dict[int, float] = field(default_factory=dict)  # frames with how many each stands for
    bent: NDArray[np.bool_] | None = None  # frames that the knees stand for
    shifts: dict[str, Array] = field(default_factory=dict)  # of the constraints, by name


class GaitGraph:
    """A base gait bent by edges: the paper's gait graph as a GTSAM factor graph.

    Each keyframe n is a 4-vector variable ``gtsam.symbol("g", n)``; residual edges keep the motion of the base gait
    between keyframes, the other edges pull on single frames. Frames between keyframes follow exactly (see
    `factors.residual`).

    Args:
        base: the base gait.
        model: the legs; the base gait's own if None.
        keyframes: ``"auto"`` (only frames that have an edge of their own), ``"all"`` (the paper's full graph), or a
            list of frames to have besides the automatic ones.
        knee_gain: gain of the knee edges, the paper's lambda.

    Raises:
        InputError: where an argument is unusable.
    """

    def __init__(
        self,
        base: Gait,
        model: LegModel | None = None,
        *,
        keyframes: Literal["auto", "all"] | Sequence[int] = "auto",
        knee_gain: float = 5.0,
    ) -> None:
        self.base = as_instance(base, "base", Gait)
        self.model = base.legs(model)
        self._knee_gain = as_number(knee_gain, "knee_gain", above=0.0)
        if isinstance(keyframes, str):
            if keyframes not in ("auto", "all"):
                raise InputError(f"keyframes: {keyframes!r} is not known; 'auto', 'all' or a list of frames")
            self._always = frozenset(range(len(base)) if keyframes == "all" else ())
        else:
            listed = as_tuple_of(keyframes, "keyframes", object)
            self._always = frozenset(self._frame(n, "keyframes") for n in listed)
        self._full = isinstance(keyframes, str) and keyframes == "all"
        self._anchors: dict[int, Array] = {}
        self._obstacles: list[ObstacleEdges] = []
        self._ground: GroundEdges | None = None
        self._ends: list[EndEdge] = []
        self._own: list[gtsam.NonlinearFactor] = []
        self._own_frames: set[int] = set()
        self._round: _Round | None = None

    # -- edges, in the paper's words ----------------------------------------------------------------------------

    def anchor(self, frame0: ArrayLike, frame: int = 0) -> None:
        """Fix a frame, by default the first: the one that the walker stands in now.

        Args:
            frame0: the frame in [rad], shape (4,).
            frame: its number.

        Raises:
            InputError: where the frame is unusable or anchored already.
        """
        number = self._frame(frame, "frame")
        if number in self._anchors:
            raise InputError(f"frame {number} is anchored already")
        self._anchors[number] = as_angles(frame0, "frame0", (4,))
        self._round = None

    def add_obstacle(
        self,
        obstacle: Obstacle,
        frames: Sequence[int] | None = None,
        hold: float = 0.3,
        gamma: float = 4.0,
        margin: float = 0.02,
    ) -> None:
        """Add obstacle edges that lift P over a box (paper, Eq. obs_1).

        Args:
            obstacle: the box, in the body frame of this step.
            frames: frames that get the edge, the paper's O; None: chosen by `solve`, in rounds, until none crosses
                too low.
            hold: pull in [1/m] of each such frame towards the place it would have without the obstacle; 0 is
                the paper's edge.
            gamma: steepness in [1/m].
            margin: height to spare, the paper's delta, in [m].

        Raises:
            InputError: where an argument is unusable.
        """
        as_instance(obstacle, "obstacle", Obstacle)
        listed = None if frames is None else as_tuple_of(frames, "frames", object)
        numbers = None if listed is None else tuple(self._frame(n, "frames") for n in listed)
        self._obstacles.append(
            ObstacleEdges(
                obstacle,
                numbers,
                as_number(hold, "hold", at_least=0.0, unit="1/m"),
                as_number(gamma, "gamma", above=0.0, unit="1/m"),
                as_number(margin, "margin", at_least=0.0, unit="m"),
            )
        )
        self._round = None

    def add_ground(self, ground: Ground, hold: float = 0.3, gamma: float = 4.0, margin: float = 0.01) -> None:
        """Keep P above the ground: frames that would pass too low get obstacle edges, chosen by `solve` in rounds.

        Args:
            ground: level ground or stairs, in the body frame of this step.
            hold: as for `add_obstacle`.
            gamma: steepness in [1/m].
            margin: height to spare, away from both footholds, in [m].

        Raises:
            InputError: where an argument is unusable, or the ground is given already.
        """
        if self._ground is not None:
            raise InputError("ground: it is given already")
        self._ground = GroundEdges(
            as_instance(ground, "ground", Ground),
            as_number(hold, "hold", at_least=0.0, unit="1/m"),
            as_number(gamma, "gamma", above=0.0, unit="1/m"),
            as_number(margin, "margin", at_least=0.0, unit="m"),
        )
        self._round = None

    def end(
        self,
        foothold: tuple[float, float] | None = None,
        shank_angle: float | None = None,
        gain: float = 5.0,
        hard: bool = False,
        frame: int | None = None,
        pose: ArrayLike | None = None,
    ) -> None:
        """Add end edges: P onto its foothold, the shank to its angle (paper, Eq. end_3), all joints to a pose.

        Args:
            foothold: target of P in [m], shape (2,).
            shank_angle: target of the swinging shank's angle to the ground in [rad]; pi/2 is upright.
            gain: the paper's omega.
            hard: whether the edges are constraints instead, met to 1e-6.
            frame: the frame; the last one if None.
            pose: target of the whole frame, shape (4,) in [rad].

        Raises:
            InputError: where an argument is unusable, or there is no foothold, shank angle or pose.
            UnreachableFootholdError: where the foothold is further from the supporting foot than two legs reach.
        """
        if foothold is None and shank_angle is None and pose is None:
            raise InputError("end: give a foothold, a shank angle or a pose")
        point = None
        if foothold is not None:
            x, y = as_array(foothold, "foothold", (2,)).tolist()
            distance, reach = math.hypot(x, y), 2.0 * self.model.reach
            if distance > reach:
                raise UnreachableFootholdError(
                    f"foothold ({x:g}, {y:g}) is {distance:.3f} m from the supporting foot, "
                    f"two legs reach {reach:.3f} m",
                    distance,
                    reach,
                )
            point = (x, y)
        angle = None if shank_angle is None else float(as_angles(shank_angle, "shank_angle", ()))
        weight = math.inf if hard else as_number(gain, "gain", above=0.0)
        number = len(self.base) - 1 if frame is None else self._frame(frame, "frame")
        whole = None if pose is None else as_angles(pose, "pose", (4,))
        self._ends.append(EndEdge(number, point, angle, whole, weight))
        self._round = None

    def add_factor(self, factor: gtsam.NonlinearFactor) -> None:
        """Add a GTSAM factor of your own on ``gtsam.symbol("g", n)``; each such n becomes a keyframe.

        Custom factors are best built by `factors.checked_factor`, which keeps a wrong Jacobian from killing the
        interpreter.

        Raises:
            InputError: where it is no GTSAM factor, a key is not a frame of this gait, or it does not fit frames of
                four angles.
        """
        if not isinstance(factor, gtsam.NonlinearFactor):
            raise InputError(f"factor: expected a gtsam factor, got {type(factor).__name__}")
        numbers = []
        for key in factor.keys():
            number = frame_of_key(key)
            if number is None:
                raise InputError(f"factor: key {gtsam.DefaultKeyFormatter(key)} is not gtsam.symbol('g', frame)")
            numbers.append(self._frame(number, "factor"))
        require_fit(factor, self.base.frames)
        self._own.append(factor)
        self._own_frames.update(numbers)
        self._round = None

    # -- plain GTSAM objects ------------------------------------------------------------------------------------

    def factor_graph(self) -> gtsam.NonlinearFactorGraph:
        """The graph of the last round, or of the first one before `solve`: one factor for each edge."""
        return self._plain_graph(self._current())

    def initial_values(self) -> gtsam.Values:
        """A start for `factor_graph`: the keyframes of the last round's result, or of the first one's start."""
        return self._values(self._current())

    # -- solving ------------------------------------------------------------------------------------------------

    def solve(self, optimizer: str = "dogleg", max_iterations: int = 100) -> Solution:
        """Solve the graph and check the gait; never raises for an unsafe gait, see `Solution.require_ok`.

        Args:
            optimizer: ``"dogleg"`` or ``"lm"``.
            max_iterations: limit of iterations in each round.

        Raises:
            InputError: where the optimizer is unknown.
            GraphError: where frame 0 is not anchored, or an edge is singular or not finite.
        """
        self._require_anchored()
        state = self._first_round()
        outcomes: list[Outcome] = []
        if any(edges.frames is None for edges in self._obstacles) or self._ground is not None:
            # Where the foot would pass without obstacles decides which frames pass over them, and where to hold.
            state, free = self._rounds(state, None, optimizer, max_iterations)
            outcomes += free
            reference = self.model.endpoint(state.frames)
            lifted = self._lifted(state, reference, reference, low_only=False)
            if lifted.lifts.edges == state.lifts.edges:
                self._round = state
                return self._solution(state, outcomes, max_iterations)
            state = lifted
        else:
            reference = self.model.endpoint(self.base.frames)
        state, bent = self._rounds(state, reference, optimizer, max_iterations)
        self._round = state
        return self._solution(state, outcomes + bent, max_iterations)

    def _rounds(
        self, state: _Round, reference: Array | None, optimizer: str, max_iterations: int
    ) -> tuple[_Round, list[Outcome]]:
        """Solve until no frame joins any more."""
        outcomes: list[Outcome] = []
        while True:
            state, grown, outcome = self._solve_once(state, reference, optimizer, max_iterations)
            outcomes.append(outcome)
            if grown is None:
                return state, outcomes
            if len(outcomes) == MOST_ROUNDS:
                reason = f"not converged: frames still join after {MOST_ROUNDS} rounds"
                outcomes[-1] = replace(outcome, converged=False, reason=reason)
                return state, outcomes
            state = grown

    def _solve_once(
        self, state: _Round, reference: Array | None, optimizer: str, max_iterations: int
    ) -> tuple[_Round, _Round | None, Outcome]:
        """Solve one round: its result, and the next round with the frames that join, or None where none does."""
        keys = self._keyframes(state)
        solved, outcome = self._descended(state, keys, optimizer, max_iterations)
        frames = solved.frames
        bent = np.asarray((frames[:, [1, 3]] < 0.0).any(axis=1))
        bent[list(self._anchors)] = False
        known = np.zeros(len(bent), dtype=bool) if state.bent is None else state.bent
        knees = state.knees | thinned(bent & ~known, self._spacing())
        grown = replace(solved, knees=knees, bent=bent | known)
        if reference is not None:
            grown = self._lifted(grown, self.model.endpoint(frames), reference, low_only=True)
        reweighed = self._spacing() > 1 and grown.knees != state.knees
        changed = reweighed or grown.knees.keys() - set(keys) or grown.lifts.edges != state.lifts.edges
        return solved, grown if changed else None, outcome

    def _descended(self, state: _Round, keys: list[int], optimizer: str, max_iterations: int) -> tuple[_Round, Outcome]:
        """The graph minimised, its constraints met by an augmented Lagrangian.

        The edge of a constraint is shifted by what it misses its target by, which is the constraint's multiplier over
        the gain, until nothing is missed.
        """
        fixed, missed = self._fixed(), math.inf
        history: list[float] = []
        while True:
            graph, edges = self._solved_graph(state)
            curved = None if any(math.isinf(edge.gain) for edge in edges) else [e for e in edges if e.curvature]
            outcome = descend(graph, self._values(state, fixed), optimizer, max_iterations, curved)
            at = [fixed[n] if n in fixed else outcome.values.atVector(frame_key(n)) for n in keys]
            state = replace(state, frames=fill_spans(self.base.frames, keys, np.stack(at)))
            history += outcome.error_history[bool(history) :]
            hard = {edge.constraint: edge for edge in edges if edge.constraint}
            if not hard:
                return state, outcome
            outcome = replace(outcome, error_history=tuple(history), iterations=len(history) - 1)
            shifts = {name: edge.errors(state.frames) for name, edge in hard.items()}
            misses = {name: np.abs(shift - state.shifts.get(name, 0.0)).max() for name, shift in shifts.items()}
            worst = max(misses, key=misses.__getitem__)
            before, missed = missed, float(misses[worst])
            if missed <= HARD_TOLERANCE / 10.0:
                return state, outcome
            if missed > before / 2.0:  # shifting no longer helps
                reason = (
                    f"contradicting: a hard edge at frame {hard[worst].frames[0]} is missed by {missed:.3g} ({worst})"
                )
                return state, outcome if missed <= HARD_TOLERANCE else replace(outcome, reason=reason)
            state = replace(state, shifts=shifts)

    def _lifted(self, state: _Round, path: Array, hold_at: Array, low_only: bool) -> _Round:
        """The round with the lifts that its path calls for."""
        lifts = state.lifts
        for wish in wishes(path, self._obstacles, self._ground, self.model.foot, low_only):
            lifts = lifts.granting(wish, hold_at, self._anchors, self._spacing())
        return replace(state, lifts=lifts)

    def _spacing(self) -> int:
        """How many frames one edge that `solve` chooses may stand for; 1 where the user chose the frames."""
        chosen = [edges.frames is None for edges in self._obstacles] + [True] * (self._ground is not None)
        return -(-(len(self.base) - 1) // FINEST) if chosen and all(chosen) and not self._full else 1

    # -- building -----------------------------------------------------------------------------------------------

    def _current(self) -> _Round:
        return self._round or self._first_round()

    def _first_round(self) -> _Round:
        """The base gait, moved to the anchors; the offset fades out where the end is free."""
        base = self.base.frames
        offsets = {n: frame - base[n] for n, frame in self._anchors.items()}
        offsets.setdefault(len(base) - 1, np.zeros(4))
        known = sorted(offsets)
        every = np.arange(len(base))
        shift = np.stack([np.interp(every, known, [offsets[n][c] for n in known]) for c in range(4)], -1)
        frames = base + shift
        for n, frame in self._anchors.items():
            frames[n] = frame
        path = self.model.endpoint(base)
        return _Round(frames, Lifts().with_given(self._obstacles, self.model.foot, path, self._anchors))

    def _keyframes(self, state: _Round) -> list[int]:
        keys = {0, len(self.base) - 1} | self._always | self._own_frames | state.knees.keys() | self._anchors.keys()
        keys |= {frame for frame, _ in state.lifts.edges} | {end.frame for end in self._ends}
        return sorted(keys)

    def _edges(self, state: _Round) -> list[tuple[str, Edge]]:
        """Every edge with the family that its cost counts to."""
        keys = self._keyframes(state)
        made = [("anchor", anchor_edge(n, frame)) for n, frame in self._anchors.items()]
        made += [("residual", residual_edge(self.base.frames, first, last)) for first, last in pairwise(keys)]
        made += [
            ("knee", knee_edge(n, self._knee_gain * state.knees.get(n, 1.0))) for n in keys if n not in self._anchors
        ]
        made += [("obstacle", lift.edge(self.model)) for lift in state.lifts.edges.values()]
        for number, end in enumerate(self._ends):
            made += [("end", edge) for edge in end.edges(self.model, number, state.shifts)]
        return made

    def _plain_graph(self, state: _Round) -> gtsam.NonlinearFactorGraph:
        """A factor for each edge."""
        return graph_of([*(edge.factor() for _, edge in self._edges(state)), *self._own])

    def _fixed(self) -> dict[int, Array]:
        """The anchored frames that are no variable where the graph is solved: those that no factor of a user's has."""
        return {n: frame for n, frame in self._anchors.items() if n not in self._own_frames}

    def _solved_graph(self, state: _Round) -> tuple[gtsam.NonlinearFactorGraph, list[Edge]]:
        """The same sum of squares in few factors: the soft edges of neighbouring keyframes are one; and the edges."""
        fixed = self._fixed()
        edges = [edge for _, edge in self._edges(state) if edge.name != "anchor" or edge.frames[0] not in fixed]
        stacks: dict[int, list[Edge]] = {}
        place = {n: k // STACKED for k, n in enumerate(self._keyframes(state))}
        for edge in edges:
            if not math.isinf(edge.gain) and not fixed.keys() >= set(edge.frames):
                stacks.setdefault(place[edge.frames[-1]], []).append(edge)
        hard = [edge.factor() for edge in edges if math.isinf(edge.gain)]
        soft = [stacked_factor(stack, fixed) for stack in stacks.values()]
        return graph_of([*hard, *soft, *self._own]), edges

    def _values(self, state: _Round, without: Collection[int] = ()) -> gtsam.Values:
        values = gtsam.Values()
        for n in self._keyframes(state):
            if n not in without:
                values.insert(frame_key(n), state.frames[n])
        return values

    def _require_anchored(self) -> None:
        """Refuse a graph that all frames could slide through together."""
        if self._anchors:
            return
        state = self._first_round()
        holding = [*(edge.factor() for family, edge in self._edges(state) if family == "end"), *self._own]
        if common_offset_is_free(holding, self._values(state)):
            raise GraphError("frame 0 is not anchored")

    # -- results ------------------------------------------------------------------------------------------------

    def _solution(self, state: _Round, outcomes: list[Outcome], max_iterations: int) -> Solution:
        last = outcomes[-1]
        if not last.reason:
            last = judged(self._solved_graph(state)[0], last, max_iterations)
        gait = replace(self.base, frames=state.frames, model=self.model)
        ends = [end for end in self._ends if end.frame == len(self.base) - 1]
        landing = gait.endpoints()[-1]
        feet = [end.foothold for end in ends if end.foothold is not None]
        check = partial(
            verify,
            gait,
            self.model,
            start=self._anchors.get(0),
            obstacles=[edges.obstacle for edges in self._obstacles],
            foothold=max(feet, key=lambda foot: math.dist(foot, landing), default=None),
            shank_angle=next((end.shank_angle for end in ends if end.shank_angle is not None), None),
            ground=None if self._ground is None else self._ground.ground,
        )
        history = np.concatenate([outcome.error_history for outcome in outcomes])
        history.setflags(write=False)
        costs = costs_of(self._edges(state), state.frames)
        if self._own:
            costs["user"] = float(graph_of(self._own).error(last.values))
        return Solution(
            gait=gait,
            converged=last.converged,
            reason=last.reason,
            iterations=sum(outcome.iterations for outcome in outcomes),
            error_history=history,
            costs=costs,
            rounds=len(outcomes),
            keyframes=tuple(self._keyframes(state)),
            values=self._values(state),
            build=partial(self._plain_graph, state),
            check=check,
        )

    def _frame(self, number: object, name: str) -> int:
        """A frame number of this gait; negative ones count from the end, as in Python."""
        count = len(self.base)
        if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or not -count <= number < count:
            raise InputError(f"{name}: frame {number!r:.40} is not in this gait of frames 0 to {count - 1}")
        return int(number) % count
