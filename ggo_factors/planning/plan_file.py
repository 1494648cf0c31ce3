"""A plan in the header of its walk's file."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.people import preferred
from ggo_factors.planning.plan import HEADER, Plan
from ggo_factors.planning.whynot import Ban
from ggo_factors.support.files import PathLike
from ggo_factors.support.inputs import as_array, as_bool, as_instance, as_number
from ggo_factors.walking.walk import Walk, load_walk
from ggo_factors.walking.walk_file import described

SAME_LANDING = 0.01
"""Footholds and landings no further apart than this in [m] are the same: each lands within 1 mm, and they add up."""


def load_plan(path: PathLike, *, edited: bool = False) -> Plan:
    """Read a plan that `Plan.save` wrote, its walk with it; its steps are not checked, see `Walk.verify`.

    Args:
        path: the file.
        edited: take a file whose numbers were changed after it was written.

    Raises:
        InputError: naming the file and what is wrong; where it is a walk that was not planned.
    """
    walk, text = load_walk(path, edited=edited), described(path, HEADER)
    if text is None:
        raise InputError(f"{path}: is a walk without a plan: the header has no line '# {HEADER}: ...'")
    try:
        given = json.loads(text)
        terrain = Terrain.from_toml(given.pop("terrain"))
        banned = tuple(map(_ban, given.pop("banned")))
        numbers = ("footholds", "costs", "expected", "considered")
        lists: dict[str, Any] = {name: tuple(as_array(given.pop(name), name, (None,)).tolist()) for name in numbers}
        standing, prefer = as_bool(given.pop("to_standing"), "to_standing"), preferred(given.pop("prefer"))
        if standing and len(lists["expected"]) == len(walk.gaits) - 1:
            lists["expected"] += (0.0,)  # a file of before, in which the closing step is in the last one
        for name in ("footholds", "costs", "expected"):
            if len(lists[name]) != len(walk.gaits):
                raise InputError(f"{name}: {len(lists[name])} numbers, the walk has {len(walk.gaits)} steps")
        places: dict[str, Any] = {name: as_number(given.pop(name), name, unit="m") for name in ("at", "goal")}
        _require_landings(walk, places["at"], lists["footholds"])
        return Plan(terrain, banned=banned, walk=walk, to_standing=standing, prefer=prefer, **lists, **places, **given)
    except InputError as error:
        raise InputError(f"{path}: header {HEADER!r}: {error}") from error
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: header {HEADER!r} does not describe a plan: {text:.60}") from error


def _ban(given: dict[str, Any]) -> Ban:
    """A refused step as a file has it."""
    ban = Ban(**given)
    for name in ("behind", "stands", "lands"):
        as_number(getattr(ban, name), f"banned: {name}", unit="m")
    as_instance(ban.reason, "banned: reason", str)
    return ban


def _require_landings(walk: Walk, at: float, footholds: tuple[float, ...]) -> None:
    """Refuse footholds that are not where the walk lands.

    Raises:
        InputError: with the first of them.
    """
    landings = at + np.cumsum([walk.model.endpoint(gait.frames[-1])[0] for gait in walk.gaits])
    for number in np.flatnonzero(np.abs(landings - footholds) > SAME_LANDING)[:1]:
        raise InputError(
            f"footholds: {footholds[number]:.3f} m, but step {number + 1} of the walk lands at {landings[number]:.3f} m"
        )
