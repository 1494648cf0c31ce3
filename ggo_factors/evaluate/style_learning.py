"""Styles learned from recorded steps: principal deviations, and what they help with held-out steps.

The model of a step is z + W c + r: z the base gait of that person and leg, W c the style, r a chain of the residual
edges, first and second order, that begins where the step begins. Everything is judged on steps that nothing was learned
from, in blocks of time, or person by person: how likely they are, and how near the model's answer comes to them given
what a step's graph is given, which is start and foothold. The variance of the chain, and so how far c is trusted, is
the one that is nearest: likelihood alone counts 200 differences alike, and trusts c too much. Nearest decides, too,
whether landing edges vary with c. What c leaves of a first frame has the variance that makes held-out ones likeliest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from ggo_factors.errors import InputError
from ggo_factors.factors.checked import FRAME_SIZE
from ggo_factors.graph.requests import MOTION_GAIN, POSTURE_GAIN
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.style import FRAMES, Style
from ggo_factors.procedures.gains import LANDING_END_GAIN
from ggo_factors.procedures.steps import SMOOTHING
from ggo_factors.support.inputs import Array, as_angles, as_instance, as_tuple_of

MOST = 20
"""Most numbers of a step. Fewer (4, 8) give up what many steps tell; more than 20 add nothing."""
FOLDS = 8
"""So many times a part of the steps is held out."""
LEAST = 4
"""Of fewer steps nothing can be held out."""
VARIANCES = np.logspace(-7.0, -3.0, 17)
"""Variances in [rad^2] that are tried, four in a factor of ten."""

LEAST_FOR_STARTS = 32
"""Of fewer steps first frames tell nothing of c: their mean is not known to what the edge of the start would trust, for
people drift; with 12, 18 and 24 steps of a walk that edge misleads in the rest of it, with 36 it helps."""
START_DEVIATIONS = np.radians(np.logspace(-1.0, 0.5, 13))
"""Standard deviations in [rad] that are tried of what c leaves of a first frame, 0.1 to 3.2 degrees."""


def learn_style(
    steps: ArrayLike,
    model: LegModel,
    *,
    legs: Sequence[str] | None = None,
    people: Sequence[str] | None = None,
) -> Style:
    """Learn how steps vary about the base gait, the mean of the steps of the same person and leg.

    Args:
        steps: frames of each step on a common phase, from the other leg's strike to the landing, shape (n, m, 4) in
            [rad], in the order in which they were walked.
        model: the legs.
        legs: the swinging leg of each step; the same if None.
        people: who walked each step; one person if None.

    Returns:
        The style; whether it helps is told by `Style.helps`.

    Raises:
        InputError: where an argument is unusable, or fewer than 4 steps have others of the same person and leg.
    """
    given = as_angles(steps, "steps", (None, None, FRAME_SIZE))
    legs_model, count = as_instance(model, "model", LegModel), len(given)
    if given.shape[1] < 4:
        raise InputError(f"steps: {given.shape[1]} frames are too few, 4 or more")
    persons, sides = _labels(people, "people", count), _labels(legs, "legs", count)
    groups = np.unique(np.stack([persons, sides], -1), axis=0, return_inverse=True)[1].ravel()
    kept = np.bincount(groups, minlength=1)[groups] > 1 if count else np.zeros(0, dtype=bool)
    if kept.sum() < LEAST:
        raise InputError(f"steps: {int(kept.sum())} steps of a person and leg that has more than one, {LEAST} or more")
    phases, wanted = np.linspace(0.0, 1.0, given.shape[1]), np.linspace(0.0, 1.0, FRAMES)
    resampled = given if len(phases) == FRAMES else CubicSpline(phases, given, axis=1)(wanted)
    walked, groups, persons = resampled[kept], groups[kept], persons[kept]
    jacobian = legs_model.endpoint_jacobian(walked[:, -1].mean(axis=0))
    none, means = np.zeros((FRAMES, FRAME_SIZE, 0)), len(np.unique(groups))
    folds = [(principal(learned, means)[0], out) for learned, out in _folds(walked, groups, persons)]
    start = _start_variance(folds) if len(walked) >= LEAST_FOR_STARTS else math.inf
    nearness, likelihoods = [], []
    for directions, held_out in folds:
        answers = [next(_answers(held_out, none, jacobian))]
        for lands in (False, True):
            answers += _answers(held_out, directions, jacobian, lands, start)
        nearness.append(np.stack([np.square(answer - held_out).mean((1, 2)) for answer in answers]))
        likelihoods.append(np.stack([_likelihoods(held_out, each) for each in (directions, none)]))
    mean_square = np.concatenate(nearness, axis=1).mean(axis=1)
    likely = np.concatenate(likelihoods, axis=2).mean(axis=2).max(axis=1)
    best = int(mean_square[1:].argmin())
    directions, explained = principal(_deviations(walked, groups), means)
    rms = np.degrees(np.sqrt(mean_square))
    return Style(
        directions=directions,
        variance=float(VARIANCES[best % len(VARIANCES)]),
        steps=len(walked),
        people=len(np.unique(persons)),
        explained=explained,
        likelihood=(float(likely[0]), float(likely[1])),
        error_deg=(float(rms[1:][best]), float(rms[0])),
        lands=best >= len(VARIANCES),
        start_variance=start,
    )


def principal(deviations: Array, means: int) -> tuple[Array, float]:
    """The principal deviations, (frames, 4, k) in [rad] for a standard deviation, and the share that they explain.

    Args:
        deviations: of steps from their means, shape (n, frames, 4) in [rad].
        means: how many means were taken off.
    """
    count, frames, size = deviations.shape
    free = max(1, count - means)
    _, values, rows = np.linalg.svd(deviations.reshape(count, -1), full_matrices=False)
    most = min(MOST, free, int((values > 1e-9 * max(values[0], 1e-9)).sum()) or 1)
    directions = (rows[:most].T * values[:most] / np.sqrt(free)).reshape(frames, size, most)
    total = float((values**2).sum())
    return directions, float((values[:most] ** 2).sum() / total) if total else 0.0


def _labels(given: Sequence[str] | None, name: str, count: int) -> NDArray[np.int_]:
    """Labels of steps as numbers, shape (count,)."""
    if given is None:
        return np.zeros(count, dtype=int)
    words = as_tuple_of(given, name, str)
    if len(words) != count:
        raise InputError(f"{name}: {len(words)} for {count} steps")
    return np.asarray(np.unique(np.array(words, dtype=str), return_inverse=True)[1])


def _deviations(steps: Array, groups: NDArray[np.int_]) -> Array:
    """Steps less the mean of their group, shape (n, m, 4)."""
    deviations = steps.copy()
    for group in np.unique(groups):
        deviations[groups == group] -= steps[groups == group].mean(axis=0)
    return deviations


def _folds(steps: Array, groups: NDArray[np.int_], persons: NDArray[np.int_]) -> Iterator[tuple[Array, Array]]:
    """Deviations to learn from and held-out ones: of three people or more whole people, else blocks of time."""
    everyone = np.unique(persons)
    apart = len(everyone) > 2
    order = np.searchsorted(everyone, persons) if apart else np.arange(len(steps))
    whole = len(everyone) if apart else len(steps)
    folds = min(FOLDS, whole)
    for fold in range(folds):
        out = order * folds // whole == fold
        learned_from, held_out = _deviations(steps[~out], groups[~out]), _deviations(steps[out], groups[out])
        for group in np.unique(groups[out]):
            known = ~out & (groups == group)
            if known.any():  # the base gait knows no step that is held out
                held_out[groups[out] == group] = steps[out & (groups == group)] - steps[known].mean(axis=0)
        yield learned_from, held_out


@cache
def _chain() -> tuple[Array, Array]:
    """Information of the residual edges of a step of 50 motions, (m, m); its square root on the motions, (m - 1, m)."""
    motions = np.diff(np.eye(FRAMES), axis=0)
    bends = SMOOTHING * (FRAMES - 1) * np.diff(motions, axis=0)
    by_motion = np.diff(np.eye(FRAMES - 1), axis=0)
    smooth = np.eye(FRAMES - 1) + (SMOOTHING * (FRAMES - 1)) ** 2 * by_motion.T @ by_motion
    return motions.T @ motions + bends.T @ bends, np.linalg.cholesky(smooth).T @ motions


def _start_variance(folds: Sequence[tuple[Array, Array]]) -> float:
    """The variance in [rad^2] of what c leaves of first frames that makes held-out ones likeliest.

    Args:
        folds: directions (m, 4, k), and deviations of steps that they were not learned from (n, m, 4).
    """
    likely = np.zeros(len(START_DEVIATIONS))
    for directions, held_out in folds:
        first, style = held_out[:, 0], directions[0]
        for number, deviation in enumerate(START_DEVIATIONS):
            covariance = style @ style.T + deviation**2 * np.eye(FRAME_SIZE)
            squares = float((first * np.linalg.solve(covariance, first.T).T).sum())
            likely[number] -= 0.5 * (len(first) * float(np.linalg.slogdet(covariance)[1]) + squares)
    return float(START_DEVIATIONS[likely.argmax()] ** 2)


def _answers(
    deviations: Array, directions: Array, jacobian: Array, lands: bool = False, start: float = math.inf
) -> Iterator[Array]:
    """What a step's graph, linear at the base gait, answers given two frames and the foothold, shape (n, m, 4).

    One answer for each of `VARIANCES`, the gain of c's prior.

    Args:
        deviations: what the steps really were, shape (n, m, 4).
        directions: W, shape (m, 4, k).
        jacobian: of the swing ankle at the landing, shape (2, 4).
        lands: whether the landing edges vary with c.
        start: variance in [rad^2] of what c leaves of the first frame.
    """
    size, style = FRAMES * FRAME_SIZE, directions.reshape(FRAMES * FRAME_SIZE, -1)
    chain, one = np.kron(_chain()[0], np.eye(FRAME_SIZE)), np.eye(FRAME_SIZE)
    across = -chain @ style
    inner = -style.T @ across
    last, before = slice(size - FRAME_SIZE, size), slice(size - 2 * FRAME_SIZE, size - FRAME_SIZE)
    posture, motion, end = POSTURE_GAIN / (FRAMES - 1), MOTION_GAIN * (FRAMES - 1), LANDING_END_GAIN * FRAMES
    chain[last, last] += (posture + motion) * one + end * jacobian.T @ jacobian
    chain[before, before] += motion * one
    chain[last, before] -= motion * one
    chain[before, last] -= motion * one
    footholds = deviations[:, -1] @ jacobian.T
    pull = np.zeros((len(deviations), size))
    pull[:, last] = posture * footholds @ np.linalg.pinv(jacobian).T + end * footholds @ jacobian
    free = np.eye(FRAME_SIZE) - np.linalg.pinv(jacobian) @ jacobian
    at, moving = free @ directions[-1] * lands, (directions[-1] - directions[-2]) * lands
    # The posture that is aimed at moves the swing ankle, what c varies of it does not: c is not pulled by it.
    across[last] -= posture * at + motion * moving
    across[before] += motion * moving
    inner += posture * at.T @ at + motion * moving.T @ moving
    first = directions[0]
    given = deviations[:, :2].reshape(len(deviations), -1)
    known = given.shape[1]
    # The frames are eliminated once, what is left of c is as small as c.
    right = np.concatenate([(pull[:, known:] - given @ chain[:known, known:]).T, across[known:]], axis=1)
    solved = np.linalg.solve(chain[known:, known:], right)
    frames, by_style = solved[:, : len(given)], solved[:, len(given) :]
    rest = inner - across[known:].T @ by_style
    asked = -(given @ across[:known]).T - across[known:].T @ frames
    for variance in VARIANCES:
        gain = variance / start  # of the edge of the start; that of c's prior is the variance
        prior = variance * np.eye(len(rest)) + gain * first.T @ first
        varied = np.linalg.solve(rest + prior, asked + gain * first.T @ deviations[:, 0].T)
        solved_for = frames - by_style @ varied
        yield np.concatenate([given, solved_for.T], axis=1).reshape(deviations.shape)


def _likelihoods(deviations: Array, directions: Array) -> Array:
    """Logarithm of the likelihood of each step's motions for each of their angles, in nats, shape (variances, n)."""
    root = np.kron(_chain()[1], np.eye(FRAME_SIZE))
    white, style = deviations.reshape(len(deviations), -1) @ root.T, root @ directions.reshape(root.shape[1], -1)
    (size, k), whole, seen, found = style.shape, style.T @ style, white @ style, []
    for variance in VARIANCES:
        inner = variance * np.eye(k) + whole
        spread = (size - k) * np.log(variance) + float(np.linalg.slogdet(inner)[1])
        squares = (white**2).sum(axis=1) - (seen * np.linalg.solve(inner, seen.T).T).sum(axis=1)
        # The root's own determinant is left out: both models have the same.
        found.append(-0.5 * (np.log(2.0 * np.pi) + (spread + squares / variance) / size))
    return np.stack(found)
