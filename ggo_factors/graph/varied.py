"""The edges of a base gait that varies by style: where the style is a variable, and where it is held."""

from __future__ import annotations

from functools import lru_cache
from itertools import repeat

from ggo_factors.factors import (
    Edge,
    landing_edges,
    motion_edges,
    rate_edge,
    style_prior,
    style_start,
    styled_edges,
    styled_landing,
    styled_rate_edge,
    with_style_held,
)
from ggo_factors.graph.problem import Problem
from ggo_factors.graph.requests import LandingRequest, StartRequest, StyleRequest, starts_likely
from ggo_factors.motion.gait import Gait
from ggo_factors.support.inputs import Array


def first_rate_edge(problem: Problem, start: StartRequest) -> Edge:
    """The edge that begins with the walker's motion."""
    return rate_edge(problem.base.frames, start.velocity_offset, problem.smoothness, start.given)


def varied_edges(
    problem: Problem, style: StyleRequest, keyframes: list[int], gain: float, held: Array | None
) -> list[tuple[str, Edge]]:
    """The residual edges, the edge of the start, and what holds the style variable itself, with their families.

    Args:
        problem: the description.
        style: its style.
        keyframes: the frames that are variables, ascending.
        gain: of the variable's prior.
        held: the variable, shape (k,), where it is held; then nothing holds it besides.
    """
    directions, rates = style.directions, list[Edge]()
    if problem.start is not None:
        rates.append(styled_rate_edge(first_rate_edge(problem, problem.start), directions, problem.start.varies))
    if held is not None:
        motions = motion_edges(problem.base.frames + directions @ held, keyframes, problem.smoothness)
        rates = [with_style_held(edge, held) for edge in rates]
        return [*zip(repeat("residual"), motions), *zip(repeat("smoothness"), rates)]
    own = [style_prior(directions.shape[2], gain), *start_edges(problem, style)]
    varying = _styled_motions(problem.base, tuple(keyframes), problem.smoothness, style)
    return [
        *zip(repeat("residual"), varying),
        *zip(repeat("smoothness"), rates),
        *zip(repeat("style"), own),
    ]


@lru_cache(maxsize=16)
def _styled_motions(base: Gait, keyframes: tuple[int, ...], smoothness: float, style: StyleRequest) -> tuple[Edge, ...]:
    """The residual edges of a base gait varied by style: the same in all first rounds of a walk, with few keyframes."""
    return tuple(styled_edges(motion_edges(base.frames, keyframes, smoothness), style.directions))


def start_edges(problem: Problem, style: StyleRequest) -> list[Edge]:
    """The edge by which the anchored first frame tells of the style, where that is asked for."""
    base, start = problem.base.frames[0], problem.anchors.get(0)
    if not style.start_gain or start is None or not starts_likely(style, start - base):
        return []
    return [style_start(base, style.directions[0], style.start_gain)]


def varied_landing(problem: Problem, asked: LandingRequest, held: Array | None) -> tuple[Edge, Edge]:
    """The landing edges, varying by the style where it has them vary; `held` as for `varied_edges`."""
    at, moving = landing_edges(problem.base.frames, asked.posture, asked.posture_gain, asked.motion_gain)
    if problem.style is not None and problem.style.lands:
        jacobian = problem.model.endpoint_jacobian(asked.posture)
        at, moving = styled_landing((at, moving), problem.style.directions[-2:], jacobian)
    return (at, moving) if held is None else (with_style_held(at, held), with_style_held(moving, held))
