"""Stairs up and down, foot over foot; each step checked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal

import gtsam
import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.graph.touchdown import touchdown_posture
from ggo_factors.motion.base_gaits import AFTER_FIRST, STAIR, BaseGaits, landing_height, other_leg
from ggo_factors.motion.gait import Gait, swap_roles
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.motion.surface import Surface
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.motion.world import Terrain
from ggo_factors.procedures.steps import MOST_STEPS, walker_of, with_factors
from ggo_factors.procedures.walker import Walker, scaled
from ggo_factors.support.inputs import Array, as_array, as_bool, as_count, as_number
from ggo_factors.walking.step import STANDING, Step, stands_in
from ggo_factors.walking.walk import Walk

UPRIGHT = math.pi / 2.0
"""Angle of an upright shank to the ground in [rad], which the paper's stairs ask for at landing."""
EDGE_HALF_WIDTH = 0.01
"""Half the width in [m] of the box that stands for the edge of a stair (paper, section V-C: [0.28, 0.30] for 0.29)."""


def climb_stairs(
    base: Gait | BaseGaits,
    riser: float | Sequence[float] = 0.10,
    *,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    on_stairs: bool = False,
    to_standing: bool = False,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    gain: float | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
    first_swing: str = "right",
    factors: Sequence[gtsam.NoiseModelFactor] = (),
) -> Walk:
    """Stairs up, foot over foot, the shank upright at landing (paper, section V-C).

    Args:
        base: the base gait; with a gait for stairs beside the level ones (`BaseGaits`) the steps bend that. An imported
            ascent alone begins on the stairs, as it does, unless `start` is given. The first step from level ground
            bends that gait's `Gait.first_step`, the last one to feet together its `Gait.last_step`, where it has them.
        riser: height of the risers in [m], above 0; a number, or one for each step.
        tread: depth of the treads and distance of the footholds in [m].
        first_edge: x of the first riser in the body frame of the first step in [m], between 0 and `tread`.
        steps: number of steps; 2, or as many as there are risers, if None.
        on_stairs: begin in the middle of a flight: the foot behind stands one tread back, the first riser lower.
        to_standing: close with one more step, on the landing, feet together.
        model: as for `step_over`.
        start: as for `step_over`; the first frame of `Gait.first_step` if None, where the stair gait has one.
        start_rate: as for `step_over`.
        gain: as for `step_over`.
        smoothness: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.
        landing: as for `step_over`.
        pace: as for `step_over`.
        deadline: as for `step_over`.
        balance: as for `step_over`.
        style: as for `step_over`.
        first_swing: as for `step_over`.
        factors: as for `step_over`.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where no gait passes the check for a step.
    """
    walker = walker_of(
        base,
        model,
        start,
        start_rate,
        gain,
        smoothness,
        hard,
        limits,
        landing,
        pace,
        deadline,
        balance,
        first_swing,
        style,
    )
    return _walk_flight(walker, 1.0, riser, tread, first_edge, steps, on_stairs, to_standing, factors)


def descend_stairs(
    base: Gait | BaseGaits,
    riser: float | Sequence[float] = 0.10,
    *,
    tread: float = 0.39,
    first_edge: float = 0.29,
    steps: int | None = None,
    on_stairs: bool = False,
    to_standing: bool = False,
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    gain: float | None = None,
    smoothness: float | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
    landing: bool | None = None,
    pace: float | Literal["auto"] | None = None,
    deadline: float | None = None,
    balance: float | None = None,
    style: Style | None = None,
    first_swing: str = "right",
    factors: Sequence[gtsam.NoiseModelFactor] = (),
) -> Walk:
    """Stairs down, foot over foot; arguments and errors as for `climb_stairs`."""
    walker = walker_of(
        base,
        model,
        start,
        start_rate,
        gain,
        smoothness,
        hard,
        limits,
        landing,
        pace,
        deadline,
        balance,
        first_swing,
        style,
    )
    return _walk_flight(walker, -1.0, riser, tread, first_edge, steps, on_stairs, to_standing, factors)


def _walk_flight(
    walker: Walker,
    direction: float,
    riser: float | Sequence[float],
    tread: float,
    first_edge: float,
    steps: int | None,
    on_stairs: bool,
    to_standing: bool,
    factors: Sequence[gtsam.NoiseModelFactor],
) -> Walk:
    """The walk over a flight of stairs, direction 1 up, -1 down."""
    depth = as_number(tread, "tread", above=0.0, unit="m")
    edge = as_number(first_edge, "first_edge", above=0.0, unit="m")
    if not edge < depth:
        raise InputError(f"first_edge: {edge:g} m must be below the tread {depth:g} m, where the first foothold is")
    rises = direction * _risers(riser, steps)
    own = landing_height(walker.bases.gait("up" if direction > 0.0 else "down", walker.swing), walker.model)
    alone = landing_height(walker.base, walker.model)
    if abs(own) > STAIR and own * direction < 0.0:
        ways = "up", "down"
        raise InputError(f"base: {walker.base.name!r} walks stairs {ways[own < 0.0]}, not {ways[direction < 0.0]}")
    behind = as_bool(on_stairs, "on_stairs") or (not walker.placed and abs(alone) > STAIR)
    if behind:
        if walker.placed:
            raise InputError("on_stairs: begins where the base gait does; leave start out")
        walker = _on_a_stair(walker, (depth, float(rises[0])))
    elif not walker.placed:
        walker = _before_the_stairs(walker, float(rises[0]))
    flight = list(_flight(walker, rises, edge, depth, behind))
    if as_bool(to_standing, "to_standing"):
        landing = flight[-1].ground.shifted(depth, float(rises[-1]))
        flight.append(Step(end_frame=tuple(STANDING.tolist()), ground=landing))
    return walker.walk(with_factors(flight, factors))


def _on_a_stair(walker: Walker, stair: tuple[float, float]) -> Walker:
    """The walker at the start of its stair gait, the foot behind where a stair of this tread and rise puts it.

    Raises:
        InputError: where the legs do not reach, or none of the base gaits walks stairs in this direction.
    """
    kind = walker.bases.kind_for(stair[1], walker.model)
    before = walker.bases.gait(kind, other_leg(walker.swing))
    if not landing_height(before, walker.model) * stair[1] > 0.0 or abs(landing_height(before, walker.model)) < STAIR:
        raise InputError("on_stairs: no base gait walks stairs in this direction; give one, or start on level ground")
    posture = touchdown_posture(walker.model, before.frames[-1], stair)
    if posture is None:
        raise InputError(f"on_stairs: the legs do not reach from stair to stair, {stair[0]:g} by {stair[1]:g} m")
    base = walker.bases.gait(kind, walker.swing)
    offset = walker.velocity_offset if walker.moves else np.zeros(4)
    begun = replace(walker, kind=kind, frame=swap_roles(posture), velocity_offset=offset, placed=True)
    return replace(begun, settings=scaled(walker.settings, len(walker.base) - 1, len(base) - 1))


def _before_the_stairs(walker: Walker, rise: float) -> Walker:
    """The walker at the start of its first step up or down, where it has a base gait for that; else as it is."""
    kind = walker.bases.kind_for(rise, walker.model, walker.frame)
    if kind not in AFTER_FIRST:
        return walker
    begun = walker.bending(kind)
    first, second = begun.base.frames[:2]
    at_rest = first - second if stands_in(first) else np.zeros(4)
    offset = begun.velocity_offset if walker.moves else at_rest
    return replace(begun, frame=first, velocity_offset=offset, placed=True)


def _flight(walker: Walker, rises: Array, edge: float, depth: float, behind: bool) -> Iterator[Step]:
    """The steps of a flight of stairs; with a riser behind the first supporting foot where it is one of them."""
    terrain = _terrain(rises, edge, depth, behind)
    for k, rise in enumerate(rises):
        here = terrain.seen_from(depth * k, -math.inf, math.inf)
        ahead = Obstacle(edge - EDGE_HALF_WIDTH, edge + EDGE_HALF_WIDTH, max(float(rise), 0.0))
        # The paper's flat feet want an upright shank at landing; a gait of stairs knows how to land on them.
        bent = walker.bases.gait(walker.bases.kind_for(float(rise), walker.model), walker.swing)
        shank = None if abs(landing_height(bent, walker.model)) > STAIR else UPRIGHT
        yield Step((depth, float(rise)), (ahead,), shank_angle=shank, ground=here)


def _terrain(rises: Array, edge: float, depth: float, behind: bool) -> Terrain:
    """The ground of a flight of stairs, its first supporting foot at the origin of the world frame."""
    before = rises[:1] if behind else rises[:0]
    first = edge - depth * len(before)
    level = Surface(first - 2.0 * depth, first, -float(before.sum()))
    stairs = Terrain.stairs(len(before) + len(rises), riser=[*before, *rises], tread=depth)
    return Terrain((level,), name="stairs") + stairs


def _risers(riser: float | Sequence[float], steps: int | None) -> Array:
    if np.ndim(riser) == 0:
        count = as_count(2 if steps is None else steps, "steps", 1, MOST_STEPS)
        return np.full(count, as_number(riser, "riser", above=0.0, unit="m"))
    rises = as_array(riser, "riser", (None,))
    for rise in rises:
        as_number(rise, "riser", above=0.0, unit="m")
    if len(rises) == 0 or (steps is not None and as_count(steps, "steps", 1) != len(rises)):
        raise InputError(f"riser: {len(rises)} risers for {steps if steps is not None else 'at least 1'} steps")
    return rises
