"""Steps over a terrain: what each must do, from where its feet stand in the world frame."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ggo_factors.errors import InputError
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.world import Terrain
from ggo_factors.support.inputs import Array, as_array, as_bool, as_instance, as_number
from ggo_factors.walking.step import STANDING, Step

AROUND = 0.45
"""How far before and beyond its feet in [m] a step looks for boxes, edges and pits: further than a shank leans."""


def step_on(
    terrain: Terrain, model: LegModel, behind: float, stands: float, lands: float, to_standing: bool = False
) -> Step:
    """One step over a terrain, in the body frame of its supporting foot.

    Args:
        terrain: the ground.
        model: the legs.
        behind: x of the swing ankle at the start in the world frame in [m].
        stands: x of the supporting ankle.
        lands: x at which the swing ankle lands.
        to_standing: whether the walker then stands, both feet beside each other.
    """
    low, high = min(behind, stands, lands) - AROUND, max(behind, stands, lands) + AROUND
    foot = model.foot
    rise = terrain.ankle_at(lands, foot) - terrain.ankle_at(stands, foot)
    end = tuple(STANDING.tolist()) if to_standing else None
    return Step(
        foothold=None if to_standing else (lands - stands, rise),
        obstacles=terrain.boxes_from(stands, low, high, foot),
        gaps=terrain.pits_from(stands, low, high, foot),
        ground=terrain.seen_from(stands, low, high),
        end_frame=end,
    )


def steps_on(
    terrain: Terrain,
    footholds: ArrayLike,
    *,
    model: LegModel,
    start: ArrayLike,
    at: float = 0.0,
    to_standing: bool = False,
) -> tuple[Step, ...]:
    """The steps of a walk over a terrain, each with all that its feet and legs meet on the way.

    Both feet meet every box: the one that steps over it, and the trailing one in the step after.

    Args:
        terrain: the ground.
        footholds: x of each landing in the world frame in [m], shape (n,).
        model: the legs.
        start: the frame that the walker is in, shape (4,) in [rad].
        at: x of the supporting ankle at the start in the world frame in [m].
        to_standing: whether the last step ends with the feet beside each other: the last foothold is then that of the
            last but one, or lands there.

    Raises:
        InputError: where a value is unusable, or the last foothold is not that of the other foot where it must be.
    """
    as_instance(terrain, "terrain", Terrain)
    places: Array = as_array(footholds, "footholds", (None,))
    if not len(places):
        raise InputError("footholds: a walk needs at least one step")
    stands = as_number(at, "at", unit="m")
    behind = stands + float(model.endpoint(as_array(start, "start", (4,)))[0])
    feet = [behind, stands, *places.tolist()]
    if as_bool(to_standing, "to_standing") and abs(feet[-1] - feet[-2]) > 1e-9:
        raise InputError(f"footholds: to stand the feet end beside each other, at {feet[-2]:g} m; got {feet[-1]:g} m")
    last = len(feet) - 1
    return tuple(
        step_on(terrain, model, feet[n - 2], feet[n - 1], feet[n], to_standing and n == last)
        for n in range(2, last + 1)
    )
