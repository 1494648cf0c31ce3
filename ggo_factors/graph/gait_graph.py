"""The gait graph: a base gait, edges in the paper's words, and GTSAM underneath."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import gtsam
import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.factors import require_fit
from ggo_factors.graph.apart import GraphEdge, TakenApart, without
from ggo_factors.graph.assembly import Assembly, first_assembly, require_anchored
from ggo_factors.graph.optimizer import require_solver
from ggo_factors.graph.problem import Problem, factor_frames, frame_number, keyframe_numbers
from ggo_factors.graph.requests import (
    LEG_GAIN,
    LIMIT_GAIN,
    MOTION_GAIN,
    POSTURE_GAIN,
    EndRequest,
    GroundRequest,
    JointLimitRequest,
    LandingRequest,
    LegRequest,
    ObstacleRequest,
    StartRequest,
    balance_request,
    style_request,
)
from ggo_factors.graph.rounds import Solver, solve_in_rounds
from ggo_factors.graph.solution import Solution, solution_of
from ggo_factors.graph.touchdown import touchdown_posture
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.motion.terrain import Ground, Obstacle
from ggo_factors.support.inputs import as_angles, as_array, as_bool, as_instance, as_number, as_tuple_of, short_text


class GaitGraph(TakenApart):
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
        smoothness: gain of the second-order residual edges, of error d(n+1) - 2 d(n) + d(n-1) for the offset d from the
            base gait; 0 is the paper's graph. The same smoothness in time asks for a gain that grows with the square
            of the sampling rate.
        hard: whether knees, obstacles and joint limits are constraints, met to 1e-6 in [rad], [m] or shares of the
            limit, instead of edges that give way.
        fine: the base gait at a higher sampling rate, where obstacles and the ground are looked at: their edges sit at
            its frames, between those of the graph; the base gait itself if None.
        style: how the base gait varies from step to step, see `learn_style`, or None. A step has a variable for it,
            ``gtsam.symbol("c", 0)``. It is used whether it helps or not, see `Style.helps`.

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
        smoothness: float = 0.0,
        hard: bool = False,
        fine: Gait | None = None,
        style: Style | None = None,
    ) -> None:
        base = as_instance(base, "base", Gait).evenly()
        sampled = base if fine is None else as_instance(fine, "fine", Gait)
        if len(sampled) < len(base):
            raise InputError(f"fine: has {len(sampled)} frames, the base gait {len(base)}")
        if np.abs(sampled.frames[[0, -1]] - base.frames[[0, -1]]).max() > 1e-6:
            raise InputError("fine: does not begin and end as the base gait does")
        self._problem = Problem(
            base=base,
            fine=sampled,
            model=base.legs(model),
            knee_gain=as_number(knee_gain, "knee_gain", above=0.0),
            hard=as_bool(hard, "hard"),
            smoothness=as_number(smoothness, "smoothness", at_least=0.0),
            always=keyframe_numbers(keyframes, len(base)),
            full=isinstance(keyframes, str) and keyframes == "all",
            style=None if style is None else style_request(as_instance(style, "style", Style), len(base)),
        )
        self._last: Assembly | None = None

    @property
    def base(self) -> Gait:
        """The base gait."""
        return self._problem.base

    @property
    def model(self) -> LegModel:
        """The legs."""
        return self._problem.model

    def _change(self, **changes: Any) -> None:
        """Replace parts of the description; a graph that was solved before is no longer its graph."""
        self._problem, self._last = replace(self._problem, **changes), None

    def __repr__(self) -> str:
        asked = self._problem
        kinds = {"anchors": asked.anchors, "obstacles": asked.obstacles, "ends": asked.ends}
        kinds |= {"factors of your own": asked.own}
        counts = ", ".join(f"{len(items)} {kind}" for kind, items in kinds.items())
        return f"GaitGraph({short_text(self.base.name)}, {len(self.base)} frames, {counts}, {self.model.lengths()})"

    def _repr_html_(self) -> str:
        from ggo_factors.graph.solution_card import graph_card  # only here: nothing but a notebook needs it

        costs = {} if self._last is None else self._last.costs()
        return graph_card(f"Gait graph: {self.base.name}", self._problem, self._assembly().keyframes, costs)

    # -- edges, in the paper's words ----------------------------------------------------------------------------

    def anchor(self, frame0: ArrayLike, frame: int = 0) -> None:
        """Fix a frame, by default the first: the one that the walker stands in now.

        Args:
            frame0: the frame in [rad], shape (4,).
            frame: its number.

        Raises:
            InputError: where the frame is unusable or anchored already.
        """
        number = frame_number(frame, "frame", len(self.base))
        if number in self._problem.anchors:
            raise InputError(f"frame {number} is anchored already")
        self._change(anchors={**self._problem.anchors, number: as_angles(frame0, "frame0", (4,))})

    def begin_with(self, drift: ArrayLike, given: float = 0.0) -> None:
        """Add the second-order residual edge of the start, for a walker who is in motion already.

        Args:
            drift: velocity offset: change of the offset from the base gait from one frame to the next there, shape
                (4,) in [rad].
            given: share of the motion from frame 0 to 1 that is given by that speed, from 0 to below 1: at a higher
                sampling rate its first motion.

        Raises:
            InputError: where it is unusable, or the graph has no second-order edges.
        """
        if not self._problem.smoothness:
            raise InputError("drift: the graph has no second-order edges; give it a smoothness")
        share = as_number(given, "given", at_least=0.0)
        if not share < 1.0:
            raise InputError(f"given: {share:g} must be below 1; anchor frame 1 instead")
        self._change(start=StartRequest(as_angles(drift, "drift", (4,)), share))

    def add_obstacle(
        self,
        obstacle: Obstacle,
        frames: Sequence[int] | None = None,
        hold: float = 0.3,
        gamma: float = 4.0,
        margin: float = 0.02,
    ) -> None:
        """Add obstacle edges that lift the swing ankle over a box (paper, Eq. obs_1).

        Args:
            obstacle: the box, in the body frame of this step.
            frames: frames that get the edge, the paper's O; if None `solve` chooses them in rounds, until none
                crosses too low.
            hold: pull in [1/m] of each such frame towards the place it would have without the obstacle; 0 is
                the paper's edge.
            gamma: steepness in [1/m].
            margin: height to spare, the paper's delta, in [m].

        Raises:
            InputError: where an argument is unusable.
        """
        as_instance(obstacle, "obstacle", Obstacle)
        listed = None if frames is None else as_tuple_of(frames, "frames", object)
        if listed is not None and self._problem.fine is not self.base:
            raise InputError("frames: with a gait at a higher sampling rate only `solve` chooses them")
        numbers = None if listed is None else tuple(frame_number(n, "frames", len(self.base)) for n in listed)
        request = ObstacleRequest(
            obstacle,
            numbers,
            as_number(hold, "hold", at_least=0.0, unit="1/m"),
            as_number(gamma, "gamma", above=0.0, unit="1/m"),
            as_number(margin, "margin", at_least=0.0, unit="m"),
        )
        self._change(obstacles=(*self._problem.obstacles, request))

    def add_ground(self, ground: Ground, hold: float = 0.3, gamma: float = 4.0, margin: float = 0.01) -> None:
        """Keep the swing ankle above the ground: `solve` gives frames that pass too low obstacle edges, in rounds.

        Args:
            ground: level ground or stairs, in the body frame of this step.
            hold: as for `add_obstacle`.
            gamma: steepness in [1/m].
            margin: height to spare, away from both footholds, in [m].

        Raises:
            InputError: where an argument is unusable, or the ground is given already.
        """
        if self._problem.ground is not None:
            raise InputError("ground: it is given already")
        request = GroundRequest(
            as_instance(ground, "ground", Ground),
            as_number(hold, "hold", at_least=0.0, unit="1/m"),
            as_number(gamma, "gamma", above=0.0, unit="1/m"),
            as_number(margin, "margin", at_least=0.0, unit="m"),
        )
        self._change(ground=request)

    def end(
        self,
        foothold: ArrayLike | None = None,
        shank_angle: float | None = None,
        gain: float = 5.0,
        hard: bool = False,
        frame: int | None = None,
        pose: ArrayLike | None = None,
    ) -> None:
        """Add end edges: swing ankle to its foothold, shank to its angle (paper, Eq. end_3), all joints to a pose.

        Args:
            foothold: target of the swing ankle in [m], shape (2,).
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
            self.model.require_reach(x, y)
            point = (x, y)
        angle = None if shank_angle is None else float(as_angles(shank_angle, "shank_angle", ()))
        weight = math.inf if as_bool(hard, "hard") else as_number(gain, "gain", above=0.0)
        number = len(self.base) - 1 if frame is None else frame_number(frame, "frame", len(self.base))
        whole = None if pose is None else as_angles(pose, "pose", (4,))
        self._change(ends=(*self._problem.ends, EndRequest(number, point, angle, whole, weight)))

    def land(
        self,
        foothold: ArrayLike,
        shank_angle: float | None = None,
        *,
        posture_gain: float | None = None,
        motion_gain: float | None = None,
    ) -> None:
        """Add landing edges: the last frame near the base gait's touchdown posture, its last motion as there.

        They are soft, and used beside an end edge: an absolute fix at the end of a step, which takes out the offset
        that residual edges, like odometry, carry on for ever.

        Args:
            foothold: target of the swing ankle in the touchdown posture in [m], shape (2,).
            shank_angle: target of the swinging shank's angle to the ground in [rad], or None.
            posture_gain: gain of the posture; 50 / n for n frame-to-frame motions if None.
            motion_gain: gain of the last motion; 0.5 n if None.

        Raises:
            InputError: where an argument is unusable, the graph has landing edges already, or no human leg has a
                posture on that foothold.
        """
        if self._problem.landing is not None:
            raise InputError("land: the graph has landing edges already")
        x, y = as_array(foothold, "foothold", (2,)).tolist()
        angle = None if shank_angle is None else float(as_angles(shank_angle, "shank_angle", ()))
        posture = touchdown_posture(self.model, self.base.frames[-1], (x, y), angle)
        if posture is None:
            raise InputError(f"foothold: no leg has a touchdown posture on ({x:g}, {y:g}) m")
        motions = len(self.base) - 1
        near = POSTURE_GAIN / motions if posture_gain is None else as_number(posture_gain, "posture_gain", above=0.0)
        alike = MOTION_GAIN * motions if motion_gain is None else as_number(motion_gain, "motion_gain", above=0.0)
        self._change(landing=LandingRequest(posture, near, alike))

    def balance(self, gain: float | None = None, support: ArrayLike | None = None) -> None:
        """Add balance edges, which hold the ground's push (ZMP) to where it acts in the base gait, frame by frame.

        Every frame is a keyframe then: the ZMP does not interpolate.

        Args:
            gain: gain of each edge in [1/m^2]; 2 (50 / n)^2 for n frame-to-frame motions if None.
            support: x of the back and front end of a support in [m], from the supporting ankle, that the push is kept
                within instead, shape (2,).

        Raises:
            InputError: where an argument is unusable, or the graph has balance edges already.
        """
        if self._problem.balance is not None:
            raise InputError("balance: the graph has balance edges already")
        self._change(balance=balance_request(len(self.base) - 1, gain, support))

    def keep_hip_above(self, height: float) -> None:
        """Add hip edges, which keep the supporting leg from giving way, on frames whose hip sinks under a height.

        Args:
            height: least height of the hip over the supporting ankle in [m].

        Raises:
            InputError: where the height is not below the length of the leg.
        """
        least = as_number(height, "height", at_most=self.model.reach, unit="m")
        self._change(least_hips=(*self._problem.least_hips, least))

    def keep_legs_clear(
        self,
        obstacles: Sequence[Obstacle] = (),
        ground: Ground | None = None,
        margin: float = 0.01,
        gain: float = LEG_GAIN,
    ) -> None:
        """Add leg edges, which keep thighs and shanks, bones or bodies, clear on frames where they would hit.

        Args:
            obstacles: boxes in the body frame of this step.
            ground: stairs in the body frame of this step.
            margin: distance to spare in [m].
            gain: gain of the edges in [1/m^2].

        Raises:
            InputError: where an argument is unusable.
        """
        boxes = as_tuple_of(obstacles, "obstacles", Obstacle)
        stairs = None if ground is None else as_instance(ground, "ground", Ground)
        spare = as_number(margin, "margin", at_least=0.0, unit="m")
        request = LegRequest(boxes, stairs, spare, as_number(gain, "gain", above=0.0))
        self._change(legs=(*self._problem.legs, request))

    def limit_joints(self, limits: JointLimits, gain: float = LIMIT_GAIN) -> None:
        """Add limit edges on angles, speeds and accelerations of the joints, on frames that go beyond their limits.

        Args:
            limits: the limits.
            gain: gain of the edges, whose error is a share of the limit.

        Raises:
            InputError: where an argument is unusable.
        """
        asked, weight = as_instance(limits, "limits", JointLimits), as_number(gain, "gain", above=0.0)
        self._change(joints=(*self._problem.joints, JointLimitRequest(asked, weight)))

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
        numbers = factor_frames(factor, len(self.base))
        require_fit(factor, self.base.frames)
        self._change(own=(*self._problem.own, factor), own_frames=self._problem.own_frames | numbers)

    def remove(self, edge: GraphEdge) -> None:
        """Take out an edge, one of `edges`, for good: the rounds of `solve` do not put it in again.

        Args:
            edge: the edge. A residual edge over several frames goes with all that it stands for.

        Raises:
            InputError: where it is not an edge of this graph.
        """
        self._last = without(self._assembly(), edge)
        self._problem = self._last.problem

    def factor_graph(self) -> gtsam.NonlinearFactorGraph:
        """The graph of the last round, or of the first one before `solve`: one factor for each edge."""
        return self._assembly().plain()

    def initial_values(self) -> gtsam.Values:
        """Values for `factor_graph`: the keyframes that the last round ended with, or the first one starts with."""
        return self._assembly().values()

    def solve(self, optimizer: str = "dogleg", max_iterations: int = 100, initial: ArrayLike | None = None) -> Solution:
        """Solve the graph and check the gait; never raises for an unsafe gait, see `Solution.require_ok`.

        Args:
            optimizer: ``"dogleg"`` or ``"lm"``.
            max_iterations: limit of iterations in each round.
            initial: frames to start from, shape (m, 4) in [rad]: a warm start; the base gait moved to the anchors if
                None.

        Raises:
            InputError: where an argument is unusable.
            GraphError: where frame 0 is not anchored, or an edge is singular or not finite.
        """
        require_solver(optimizer, max_iterations)
        begin = None if initial is None else as_angles(initial, "initial", self.base.frames.shape)
        require_anchored(first_assembly(self._problem))
        solved = solve_in_rounds(self._problem, begin, Solver(optimizer, max_iterations))
        self._last = solved.graph
        return solution_of(solved)

    def _assembly(self) -> Assembly:
        return self._last or first_assembly(self._problem)
