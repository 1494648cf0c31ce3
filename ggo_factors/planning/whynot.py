"""The place where there is no way, in words and numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from ggo_factors.errors import InfeasibleGaitError
from ggo_factors.motion.gait import swap_roles
from ggo_factors.motion.terrain import Gap, Obstacle
from ggo_factors.motion.world import Terrain
from ggo_factors.planning.footholds import free_stretches
from ggo_factors.planning.postures import postures
from ggo_factors.planning.reach import LENGTH
from ggo_factors.planning.search import Search

NEAR = 0.3
"""What lies within this distance in [m] of a place is named with it."""
MOST_NAMED = 4
"""So many of them, the others are counted."""


@dataclass(frozen=True)
class Ban:
    """A step that was refused, and why.

    Attributes:
        behind: x of the swing ankle at the start in the world frame in [m].
        stands: x of the supporting ankle.
        lands: x at which the swing ankle was to land.
        reason: why no gait was found.
    """

    behind: float
    stands: float
    lands: float
    reason: str

    def __str__(self) -> str:
        return f"from {self.behind:.3f} over {self.stands:.3f} to {self.lands:.3f} m: {self.reason}"


def no_way(search: Search, banned: Sequence[Ban]) -> InfeasibleGaitError:
    """Why there is no way over a terrain: where it ends, what is there, and the steps that were refused."""
    terrain = search.terrain
    free = replace(search, banned=[])
    at, onward = _ends(free)
    if onward is None:
        at, onward = _ends(search)
        if onward is None and banned:
            # Refused so often that no more were tried: beyond where the last ones stand.
            at, onward = max((ban.stands, ban.lands) for ban in banned)
        where = "" if onward is None else f" between x = {at:.2f} and {onward:.2f} m"
        if at >= search.goal:
            where = f" to stand at x = {at:.2f} m"
        # What a foot cannot be taken over lies between where it comes from and where it was to land.
        low = min([ban.behind for ban in banned if ban.stands >= at - 1e-6], default=at)
        last = f"; the last of {len(banned)} refused: {banned[-1]}" if banned else ""
        what = _what(terrain, min(low, at), onward)
        return InfeasibleGaitError(f"no way{where}: every step tried there was refused{what}{last}")
    if at >= search.goal:
        return InfeasibleGaitError(f"no step ends standing at x = {at:.2f} m{_what(terrain, at, onward)}")
    message = f"no foothold between x = {at:.2f} and {onward:.2f} m"
    longest = _longest_from(free, at, onward)
    step = f"the longest step here is {longest:.2f} m" if 0.0 < longest < onward - at else "no step goes on there"
    return InfeasibleGaitError(f"{message}{_what(terrain, at, onward)}; {step}")


def _ends(search: Search) -> tuple[float, float | None]:
    """The last foothold that can be reached in [m], and the next one that cannot; None if the goal can be reached."""
    network = search.network()
    least, _ = network.reached()
    if np.isfinite(least + network.closing).any():
        return search.goal, None
    reached = network.pairs[np.isfinite(least), 1]
    last = float(network.places[reached].max())
    free = free_stretches(search.stretches, last + 1e-6, search.goal)
    beyond = [begins for begins, _ in free if begins > last + 2e-6]
    return last, min([*beyond, search.goal])


def _longest_from(search: Search, at: float, onward: float) -> float:
    """The longest step from the last foothold that ends as high as the next one, by its postures, in [m]; 0 if none."""
    walker, network, costs = search.walker, search.network(), search.step_costs
    landing, limits = costs.base.frames[-1], walker.settings.limits
    reached = network.pairs[np.isfinite(network.reached()[0])]
    behind = network.places[reached[network.places[reached[:, 1]] == at, 0]]
    height, *below, beyond = (search.terrain.ankle_at(x, walker.model.foot) for x in (at, *behind, onward))
    begins = walker.frame[None]
    if at > search.feet[1]:
        apart = np.stack([at - behind, height - np.array(below)], -1)
        begins = swap_roles(postures(walker.model, landing, apart, limits))
    rise = beyond - height
    lengths = np.arange(LENGTH, float(search.reach.over(np.array(rise))) + 1e-9, LENGTH)
    ends = postures(walker.model, landing, np.stack([lengths, np.full(len(lengths), rise)], -1), limits)
    each = costs.postures(np.repeat(begins, len(ends), axis=0), np.tile(ends, (len(begins), 1)))
    return float(np.tile(lengths, len(begins))[np.isfinite(each)].max(initial=0.0))


def _what(terrain: Terrain, low: float, high: float | None) -> str:
    """What lies between two places in [m] or near them, the nearest first."""
    high = low if high is None else high
    shapes: list[Obstacle | Gap] = [*terrain.pits, *terrain.boxes]
    spans = [(shape.x_start, shape.x_end, str(shape)) for shape in shapes]
    for _, surface, rise in terrain.seams:
        if rise:
            spans.append((surface.x_start, surface.x_start, f"riser of {rise:g} m at {surface.x_start:g} m"))
    apart = [(max(begins - high, low - ends, 0.0), text) for begins, ends, text in spans]
    found = [text for off, text in sorted(apart, key=itemgetter(0)) if off < NEAR]
    more = f" and {len(found) - MOST_NAMED} more" if len(found) > MOST_NAMED else ""
    return f": {', '.join(found[:MOST_NAMED])}{more}" if found else ""


def nearest_free(search: Search, place: float) -> str:
    """Where a foot may stand near a place in [m], as a hint; empty where nowhere near."""
    ends = [end for stretch in free_stretches(search.stretches, place - 1.0, place + 1.0) for end in stretch]
    if not ends:
        return ""
    return f"; the nearest place is x = {min(ends, key=lambda end: abs(end - place)):.3f} m"


def what_is_at(terrain: Terrain, place: float) -> str:
    """What lies around a place in [m], in words."""
    return _what(terrain, place, place).removeprefix(": ") or f"the terrain ends at {terrain.x_end:g} m"
