"""A walk over a terrain to a goal: footholds chosen, steps made and checked, others chosen where one is refused."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ggo_factors.check.ground import misplaced
from ggo_factors.check.report import STANDARD
from ggo_factors.errors import InputError
from ggo_factors.motion.base_gaits import BaseGaits
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.joint_limits import JointLimits
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import Style
from ggo_factors.motion.surface import WORLD
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.footholds import blocked, free_stretches, may_stand
from ggo_factors.planning.making import Progress, costs_of, feet_of, planned
from ggo_factors.planning.people import PeoplePreference, Prefer, preferred
from ggo_factors.planning.reach import SHORTEST
from ggo_factors.planning.search import Search
from ggo_factors.planning.whynot import Ban, nearest_free, what_is_at
from ggo_factors.procedures.steps import walker_of
from ggo_factors.procedures.walker import Walker
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_bool, as_instance, as_number, as_progress
from ggo_factors.walking.walk import Walk

HEADER = "plan"
"""Key of the header line of a walk file that has the plan."""
START_OFF = 0.02
"""How far off the ground the swinging foot may be at the start in [m]: recorded base gaits are up to 1 cm off."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Footholds over a terrain, and the checked walk over them.

    Attributes:
        terrain: the ground.
        at: x of the supporting ankle at the start in the world frame in [m].
        footholds: x of each landing in the world frame in [m], a closing step included.
        costs: what each step costs in its graph, half the sum of squares in [rad^2].
        expected: what the plan expected of each in [rad^2], by `planning.step_cost`; as long as `costs`.
        considered: x of each foothold that was considered in [m].
        banned: steps that were refused, and why.
        walk: the walk.
        goal: where it arrives in [m].
        to_standing: whether the walker then stands.
        prefer: what was preferred.
    """

    terrain: Terrain
    at: float
    footholds: tuple[float, ...]
    costs: tuple[float, ...]
    expected: tuple[float, ...]
    considered: tuple[float, ...]
    banned: tuple[Ban, ...]
    walk: Walk
    goal: float
    to_standing: bool
    prefer: Prefer = "least_change"

    def __repr__(self) -> str:
        steps = f"{len(self.footholds)} step{'s' if len(self.footholds) != 1 else ''}"
        refused = f", {len(self.banned)} refused before" if self.banned else ""
        return f"Plan({steps} from {self.at:.3f} to {self.goal:.3f} m, cost {self.cost:.4g}{refused})"

    def _repr_html_(self) -> str:
        from ggo_factors.walking.walk_card import places_of, walk_card  # only here: nothing but a notebook needs it

        walk, expected = self.walk, math.fsum(self.expected)
        facts = {
            "ground": repr(self.terrain),
            "way": f"x = {self.at:.3f} to {self.goal:.3f} m{', then standing' if self.to_standing else ''}",
            "footholds": f"{len(self.footholds)} at x = {', '.join(f'{x:.3f}' for x in self.footholds)} m",
            "considered": f"{len(self.considered)} footholds",
            "cost": f"{self.cost:.4g} rad², {expected:.4g} expected",
            "prefers": self.prefer.replace("_", " "),
            "refused": list(map(str, self.banned)),
            "time": f"{sum(gait.duration for gait in walk.gaits):.4g} s",
            "legs": walk.model.lengths(),
        }
        places = places_of(walk.gaits, walk.plan, walk.model, walk.origins(), walk.first_swing)
        return walk_card(f"Plan over {self.terrain.name}", places, facts)

    @property
    def cost(self) -> float:
        """What all steps cost in [rad^2]."""
        return math.fsum(self.costs)

    def to_json(self) -> dict[str, Any]:
        """The plan without its walk, as plain data: lengths in [m], costs in [rad^2], the terrain as TOML."""
        kept = ("at", "goal", "to_standing", "prefer", "footholds", "costs", "expected", "considered")
        return {
            **{name: getattr(self, name) for name in kept},
            "banned": [asdict(ban) for ban in self.banned],
            "terrain": self.terrain.to_toml(),
        }

    def save(self, path: PathLike) -> None:
        """Write the walk as by `Walk.save`, the plan in its header; `load_plan` and `load_walk` read it.

        Raises:
            InputError: where the file cannot be written.
        """
        self.walk.save(path, described={HEADER: json.dumps(self.to_json())})


def furthest_goal(terrain: Terrain, model: LegModel) -> float:
    """The furthest place on a terrain where a foot can stand in [m]."""
    free = free_stretches(blocked(terrain, model.foot), terrain.x_start, terrain.x_end)
    if not free:
        raise InputError(f"terrain: {terrain!r} has no place where a foot can stand")
    return free[-1][1]


def plan_walk(
    base: Gait | BaseGaits,
    terrain: Terrain,
    *,
    goal: float,
    at: float = 0.0,
    to_standing: bool = False,
    prefer: Prefer = "least_change",
    model: LegModel | None = None,
    start: ArrayLike | None = None,
    start_rate: ArrayLike | None = None,
    hard: bool = False,
    limits: JointLimits | None = None,
    pace: float | Literal["auto"] | None = None,
    balance: float | None = None,
    style: Style | None = None,
    first_swing: str = "right",
    progress: Progress | None = None,
) -> Plan:
    """Footholds over a terrain to a goal, and a checked walk over them.

    The footholds are discrete variables of a factor graph (`planning.choice`), scored by what the gait graph of each
    step costs; then they slide where that is less. Each step is made and checked as by `walk`; one that is refused is
    banned, and the plan made again around it.

    Args:
        base: as for `step_over`.
        terrain: the ground.
        goal: x of the last foothold in the world frame in [m], at least `reach.SHORTEST` beyond `at`.
        at: x of the supporting ankle at the start in the world frame in [m].
        to_standing: close with one more step, the feet beside each other at the goal, at rest.
        prefer: ``"least_change"`` of the base gait; or ``"people"``: feet beside boxes, and heights over them, as
            people have them (`planning.people`), which costs three times as much over a box of 0.15 m, more over lower
            ones.
        model: as for `step_over`.
        start: as for `step_over`.
        start_rate: as for `step_over`.
        hard: as for `step_over`.
        limits: as for `step_over`.
        pace: as for `step_over`.
        balance: as for `step_over`.
        style: as for `step_over`.
        first_swing: as for `step_over`.
        progress: called with the share of the way to the goal that is walked, from 0 to 1, as steps are made.

    Raises:
        InputError: where an argument is unusable, or nobody can stand at the start or the goal.
        InfeasibleGaitError: where there is no way, with the place where it ends.
    """
    progress = as_progress(progress)
    walker = walker_of(
        base, model, start, start_rate, None, None, hard, limits, None, pace, None, balance, first_swing, style
    )
    search = _search(walker, terrain, goal, at, to_standing, preferred(prefer))
    found, walk = planned(search, walker.whole, progress)
    return Plan(
        terrain=terrain,
        at=search.feet[1],
        footholds=feet_of(search, found.footholds)[2:],
        costs=costs_of(found.solutions),
        expected=found.footholds.costs,
        considered=found.footholds.considered,
        banned=found.banned,
        walk=walk,
        goal=search.goal,
        to_standing=search.to_standing,
        prefer=prefer,
    )


def _search(walker: Walker, terrain: Terrain, goal: float, at: float, to_standing: bool, prefer: Prefer) -> Search:
    """The search for footholds.

    Raises:
        InputError: where an argument is unusable, or nobody can stand at the start or the goal.
    """
    as_instance(terrain, "terrain", Terrain)
    stands = as_number(at, "at", at_least=-WORLD, at_most=WORLD, unit="m")
    arrives = as_number(goal, "goal", at_least=stands + SHORTEST - 1e-9, at_most=terrain.x_end, unit="m")
    behind = stands + float(walker.model.endpoint(walker.frame)[0])
    preference = PeoplePreference.if_preferred(prefer, terrain)
    standing = as_bool(to_standing, "to_standing")
    search = Search(terrain, walker, (behind, stands), arrives, standing, preference)
    _require_start(search)
    for name, place in (("at", stands), ("goal", arrives)):
        if not may_stand(np.array([place]), search.stretches)[0]:
            what, near = what_is_at(terrain, place), nearest_free(search, place)
            raise InputError(f"{name}: no foot can stand at x = {place:.3f} m ({what}){near}")
    return search


def _require_start(search: Search) -> None:
    """Refuse a swinging foot that stands in the air, in the ground, in a box or in a pit at the start.

    Raises:
        InputError: with how far it is off.
    """
    behind, stands = search.feet
    terrain, model = search.terrain, search.walker.model
    height = terrain.ankle_at(stands, model.foot) + float(model.endpoint(search.walker.frame)[1])
    off = height - terrain.ankle_at(behind, model.foot)
    if abs(off) > START_OFF:
        where = "above" if off > 0.0 else "under"
        raise InputError(
            f"start: the swinging foot is {abs(off):.3f} m {where} the ground at x = {behind:.3f} m (limit "
            f"{START_OFF:g} m); say how the walker stands there, or stand elsewhere (at)"
        )
    y = float(model.endpoint(search.walker.frame)[1])
    boxes = terrain.boxes_from(stands, behind - SHORTEST, behind + SHORTEST, model.foot)
    pits = terrain.pits_from(stands, behind - SHORTEST, behind + SHORTEST, model.foot)
    faults = misplaced(model, (behind - stands, y), (0.0, 0.0), boxes, pits, None, STANDARD)
    feet = [fault for fault in faults if "swinging foot's start" in fault.kind]
    if feet:
        raise InputError("start: " + "; ".join(map(str, feet)))
