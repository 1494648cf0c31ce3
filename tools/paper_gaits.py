"""The gaits of the paper's experiments: to the letter, as the library makes them, and the rivals'."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import gtsam
import numpy as np
from rival_paths import minimum_jerk, potential_field

import ggo_factors as ggo
from ggo_factors.graph.judge import optimize
from ggo_factors.graph.optimizer import Outcome, graph_of
from ggo_factors.motion.gait import PAPER_MODEL, swap_roles
from ggo_factors.support.inputs import Array

OBSTACLES = (
    ggo.Obstacle(0.20, 0.25, 0.08),
    ggo.Obstacle(0.20, 0.25, 0.15),
    ggo.Obstacle(0.12, 0.16, 0.08),
    ggo.Obstacle(0.12, 0.16, 0.15),
    ggo.Obstacle(-0.33, -0.29, 0.175),
)
FOOTHOLD = (0.39, 0.0)
STRIDES = (0.585, 0.975)
SWITCHED_STRIDES = (0.975, 0.975, 0.78, 0.78, 0.585, 0.585)
RISER, TREAD, EDGE = 0.10, 0.39, 0.29
STAIR_BOX = ggo.Obstacle(EDGE - 0.01, EDGE + 0.01, RISER)  # O of the paper's stairs, [0.28, 0.30], and its h
UPRIGHT = math.pi / 2.0
OBSTACLE_GAMMA, OBSTACLE_DELTA, KNEE_LAMBDA = 4.0, 0.02, 5.0

# The paper's legs hit nothing but with P: its obstacle 5 stands in the shank of the start frame.
POINTS = replace(PAPER_MODEL, bones="points")
# The robot with feet, ours: the paper gives neither L_a nor L_f, nor where its stair stands.
ROBOT = replace(POINTS, foot=ggo.Foot(ankle_height=0.08, heel=0.05, toe=0.12))
COLLECTED_RISER, COLLECTED_TREAD, NEW_FOOTHOLD = 0.12, 0.25, (0.27, 0.06)
# The paper gives no step time for its ZMP: this one is fitted to its column "Base gait", see `reproduce_paper`.
ZMP_STEP_TIME = 1.18
BALANCE = 2.0  # the gain that the library recommends
ROBOT_EDGE = 0.18
ROBOT_FRAMES = 40


def paper_base(frames: int = 51, endpoint: bool = True) -> ggo.Gait:
    """The paper's base gait on the paper's legs, whose bones are points."""
    return replace(ggo.paper_base_gait(frames, endpoint=endpoint), model=POINTS)


@dataclass(frozen=True)
class Variant:
    """One reading of the paper: its name, its sampling, and which frames O holds."""

    name: str
    frames: int
    endpoint: bool
    around_start: float | None  # O = x_s -+ this in [m]; None: the obstacle's span

    @cached_property
    def base(self) -> ggo.Gait:
        """The paper's base gait, sampled so."""
        return paper_base(self.frames, self.endpoint)

    def over(self, box: ggo.Obstacle) -> list[int]:
        """O of a box: frames of the base gait."""
        x = self.base.endpoints()[:, 0]
        low, high = box.x_start, box.x_end
        if self.around_start is not None:
            low, high = box.x_start - self.around_start, box.x_start + self.around_start
        return [int(n) for n in np.flatnonzero((low <= x) & (x <= high))]


LITERAL = (Variant("literal_span", 50, False, None), Variant("literal_paper", 80, False, 0.02))


@dataclass(frozen=True)
class Made:
    """A gait, how long it took, and its solution where a graph made it."""

    gait: ggo.Gait
    milliseconds: float
    solution: ggo.Solution | None = None


@dataclass(frozen=True)
class Results:
    """All gaits, for the tables and the figures."""

    base: ggo.Gait
    strides: dict[tuple[str, float], tuple[Made, ...]]
    switched: ggo.Walk
    obstacles: dict[str, tuple[Made, ...]]
    stairs: dict[tuple[str, str], tuple[Made, ...]]
    stair_plan: dict[str, tuple[ggo.Step, ...]]
    collected: ggo.Walk
    robot: ggo.Walk


# -- the experiments --------------------------------------------------------------------------------------------


def literal_graph(
    base: ggo.Gait,
    start: Array,
    foothold: tuple[float, float],
    gain: float,
    obstacle: ggo.Obstacle | None = None,
    over: Sequence[int] = (),
    shank_angle: float | None = None,
    full: bool = True,
) -> ggo.GaitGraph:
    """One step by the paper's own edges and gains, anchored: no hold, no rounds, nothing made stiffer."""
    graph = ggo.GaitGraph(base, keyframes="all" if full else "auto", knee_gain=KNEE_LAMBDA)
    graph.anchor(start)
    if obstacle is not None:
        graph.add_obstacle(obstacle, frames=over, hold=0.0, gamma=OBSTACLE_GAMMA, margin=OBSTACLE_DELTA)
    graph.end(foothold, shank_angle, gain=gain)
    return graph


def run(full: bool) -> Results:
    """Every experiment; `full` solves the literal rows on the paper's full graph and not on its keyframes."""
    base = paper_base()
    strides: dict[tuple[str, float], tuple[Made, ...]] = {}
    obstacles: dict[str, tuple[Made, ...]] = {}
    stairs: dict[tuple[str, str], tuple[Made, ...]] = {}

    for variant in LITERAL:
        z = variant.base
        for stride in STRIDES:
            strides[variant.name, stride] = _two_literal(variant, (stride / 2.0, 0.0), full=full)
        obstacles[variant.name] = tuple(
            _timed(literal_graph(z, z.frames[0], FOOTHOLD, 5.0 * len(z), box, variant.over(box), full=full).solve)
            for box in OBSTACLES
        )
        for way, rise in (("up", RISER), ("down", -RISER)):
            # The paper names O for its stairs itself, [0.28, 0.30], and keeps the obstacle on the way down.
            frames = replace(variant, around_start=None).over(STAIR_BOX)
            stairs[variant.name, way] = _two_literal(variant, (TREAD, rise), STAIR_BOX, frames, UPRIGHT, full)
    for stride in STRIDES:
        strides["verified", stride] = _timed_walk(partial(ggo.adjust_stride, base, stride))
    minimum_jerk(base, OBSTACLES[:1], FOOTHOLD)  # or its first time would be that of an import
    for name, make in (
        ("verified", ggo.step_over),
        ("potential field", potential_field),
        ("minimum jerk", minimum_jerk),
    ):
        obstacles[name] = tuple(_timed(partial(make, base, [box], foothold=FOOTHOLD)) for box in OBSTACLES)
    slow = replace(base, dt=ZMP_STEP_TIME / (len(base) - 1))
    obstacles["balanced"] = tuple(
        _timed(partial(ggo.step_over, slow, [box], foothold=FOOTHOLD, balance=BALANCE)) for box in OBSTACLES
    )
    plans = {}
    for way, climb in (("up", ggo.climb_stairs), ("down", ggo.descend_stairs)):
        plans[way] = climb(base, RISER, tread=TREAD, first_edge=EDGE).plan
        stairs["verified", way] = _timed_walk(partial(climb, base, RISER, tread=TREAD, first_edge=EDGE))
    switched = ggo.walk(base, [ggo.Step((stride / 2.0, 0.0)) for stride in SWITCHED_STRIDES])
    start = paper_base(ROBOT_FRAMES, endpoint=False)
    collected = _standing_climb((start, start), COLLECTED_RISER, COLLECTED_TREAD)
    robot = _standing_climb(collected.gaits, NEW_FOOTHOLD[1], NEW_FOOTHOLD[0])
    return Results(base, strides, switched, obstacles, stairs, plans, collected, robot)


def _two_literal(
    variant: Variant,
    foothold: tuple[float, float],
    obstacle: ggo.Obstacle | None = None,
    over: Sequence[int] = (),
    shank_angle: float | None = None,
    full: bool = True,
) -> tuple[Made, ...]:
    """Two steps with omega 5, the second from where the first ended."""
    made: list[Made] = []
    for _ in range(2):
        start = swap_roles(made[-1].gait.frames[-1]) if made else variant.base.frames[0]
        made.append(_timed(literal_graph(variant.base, start, foothold, 5.0, obstacle, over, shank_angle, full).solve))
    return tuple(made)


def _standing_climb(bases: Sequence[ggo.Gait], riser: float, foothold: float) -> ggo.Walk:
    """Onto one stair and together: from standing straight to standing straight, for the robot with feet."""
    ground = ggo.stair_ground(ROBOT_EDGE, 1.0, [riser])
    steps = (
        ggo.Step((foothold, riser), shank_angle=UPRIGHT, ground=ground),
        ggo.Step(end_frame=(0.0, 0.0, 0.0, 0.0), ground=ground.shifted(foothold, riser)),
    )
    first = ggo.walk(bases[0], steps[:1], model=ROBOT, start=ggo.STANDING)
    landed = swap_roles(first.gaits[0].frames[-1])
    off = first.gaits[0].endpoints(ROBOT)[-1] - steps[0].landing(ROBOT)
    second = ggo.walk(bases[1], [steps[1].shifted(*off.tolist())], model=ROBOT, start=landed)
    return ggo.Walk(first.gaits + second.gaits, first.plan + second.plan, first.steps + second.steps)


def _timed(make: Callable[[], ggo.Solution | ggo.Gait]) -> Made:
    began = time.perf_counter()
    result = make()
    spent = (time.perf_counter() - began) * 1e3
    return Made(result, spent) if isinstance(result, ggo.Gait) else Made(result.gait, spent, result)


def _timed_walk(make: Callable[[], ggo.Walk]) -> tuple[Made, ...]:
    began = time.perf_counter()
    walk = make()
    each = (time.perf_counter() - began) * 1e3 / len(walk.steps)
    return tuple(Made(step.gait, each, step) for step in walk.steps)


# -- what the paper leaves out or open --------------------------------------------------------------------------


@dataclass(frozen=True)
class Ablation:
    """The first obstacle's graph without its residual edges.

    Attributes:
        dogleg: what Dogleg says, or how it ends.
        moved: frames that Levenberg-Marquardt moves at all.
        frames: number of frames.
        largest_jump_deg: largest step of a joint from one frame to the next in the result.
        base_jump_deg: the same in the base gait.
        gait: the result of Levenberg-Marquardt.
    """

    dogleg: str
    moved: int
    frames: int
    largest_jump_deg: float
    base_jump_deg: float
    gait: ggo.Gait


def without_residual_edges() -> Ablation:
    """Solve the graph of obstacle 1, `literal_paper`, with its residual edges taken out."""
    variant, box = LITERAL[1], OBSTACLES[0]
    graph = literal_graph(variant.base, variant.base.frames[0], FOOTHOLD, 5.0 * variant.frames, box, variant.over(box))
    factors = graph.factor_graph()
    kept = graph_of(factors.at(n) for n in range(factors.size()) if len(factors.at(n).keys()) == 1)
    try:
        said = optimize(kept, graph.initial_values()).reason
    except ggo.GraphError as error:
        said = str(error)
    # GTSAM itself, as `optimize` refuses what is singular; the damping of Levenberg-Marquardt hides it.
    values = gtsam.LevenbergMarquardtOptimizer(
        kept, graph.initial_values(), gtsam.LevenbergMarquardtParams()
    ).optimize()
    frames = np.stack([values.atVector(gtsam.symbol("g", n)) for n in range(variant.frames)])
    base = variant.base.frames
    jumps = [float(np.degrees(np.abs(np.diff(each, axis=0)).max())) for each in (frames, base)]
    moved = int((np.abs(frames - base).max(axis=1) > 1e-6).sum())
    return Ablation(said, moved, variant.frames, jumps[0], jumps[1], replace(variant.base, frames=frames))


def from_a_constant(results: Results) -> list[tuple[str, Outcome, Outcome]]:
    """Second steps started as the paper starts them, all frames as the last of step 1, and from the base gait."""
    variant = LITERAL[0]
    found = []
    tasks: list[tuple[str, ggo.Gait, tuple[float, float], ggo.Obstacle | None, float | None]] = [
        (f"stride {stride:g} m", results.strides[variant.name, stride][0].gait, (stride / 2.0, 0.0), None, None)
        for stride in STRIDES
    ]
    for way, rise in (("up", RISER), ("down", -RISER)):
        tasks.append((f"stairs {way}", results.stairs[variant.name, way][0].gait, (TREAD, rise), STAIR_BOX, UPRIGHT))
    for name, first, foothold, box, angle in tasks:
        start = swap_roles(first.frames[-1])
        over = [] if box is None else variant.over(box)
        graph = literal_graph(variant.base, start, foothold, 5.0, box, over, angle)
        constant = gtsam.Values()
        for n in range(variant.frames):
            constant.insert(gtsam.symbol("g", n), start)
        factors = graph.factor_graph()
        found.append((name, optimize(factors, constant), optimize(factors, graph.initial_values())))
    return found
