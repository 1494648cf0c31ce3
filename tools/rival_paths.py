"""Rivals of the gait graph: a path for the swing ankle, then inverse kinematics for the swinging leg.

The supporting leg follows the base gait, so both have the base gait's balance and timing to start from, and only the
swinging leg is theirs. Neither checks its gait: give it to `verify`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ggo_factors.errors import InfeasibleGaitError, InputError
from ggo_factors.motion.gait import Gait
from ggo_factors.motion.leg_model import LegModel
from ggo_factors.motion.terrain import Obstacle
from ggo_factors.support.inputs import Array, as_array, as_instance, as_number, as_tuple_of

PATH_STEP = 0.004
MOST_PATH_STEPS = 2000
QUINTIC = 6
SPARE = 0.02
"""How high over an obstacle's corners the minimum-jerk path passes in [m]: the paper's delta."""


@dataclass(frozen=True)
class PotentialField:
    """Gains of the artificial potential field; the attraction to the foothold has force 1.

    The defaults come from two random searches over all gains at once, 5000 fields in all, for the least sum of mean
    peak joint acceleration and mean |ZMP|, each as a share of the gait graph's, over the paper's five obstacles at 51
    frames, among fields that clear each obstacle by 9 mm or more (the gait graph's own least) and pass `verify`; the
    best one, rounded. It repels from afar and rounds much: the ankle passes high. The pace is the base gait's, as
    minimum-jerk timing put the ankle out of the leg's reach wherever it was tried.

    Attributes:
        repulsion: gain of an obstacle's repulsion (1/d - 1/reach) / d^2 in [m^3].
        reach: distance in [m] within which an obstacle repels.
        tangential: share of the repulsion that acts along the obstacle's surface as well, up its near side and forward
            over its top; without it the ankle stops in front of a box.
        ground_repulsion: gain of the ground's repulsion in [m^3], of the same form.
        ground_reach: height in [m] under which the ground repels.
        fade: distance from the foothold in [m] within which repulsion and inertia fade, so that the ankle can land.
        inertia: share of the last direction kept at each step of 4 mm, 0 to below 1.
        smoothing: standard deviation in [m] along the path of the Gaussian that rounds it, ends kept.

    Raises:
        InputError: where a number is unusable.
    """

    repulsion: float = 5.2e-3
    reach: float = 2.2
    tangential: float = 2.9
    ground_repulsion: float = 2.1e-5
    ground_reach: float = 4.0
    fade: float = 0.062
    inertia: float = 0.21
    smoothing: float = 0.255

    def __post_init__(self) -> None:
        for field in fields(self):
            number = as_number(getattr(self, field.name), field.name, at_least=0.0, at_most=100.0)
            object.__setattr__(self, field.name, number)
        for name in ("reach", "ground_reach", "fade"):
            as_number(getattr(self, name), name, above=0.0, unit="m")
        as_number(self.inertia, "inertia", at_most=0.999)


def potential_field(
    base: Gait,
    obstacles: Sequence[Obstacle] = (),
    foothold: tuple[float, float] | None = None,
    field: PotentialField | None = None,
) -> Gait:
    """One step whose swing ankle goes down an artificial potential field (Khatib 1986; Lee 2003).

    The ankle moves in the direction of the field's force from where the base gait lifts it to the foothold; the path is
    rounded and passed at the pace of the base gait's own (the same share of its length at each frame). The leg follows
    by inverse kinematics.

    Args:
        base: the base gait, whose supporting leg and pace are taken over.
        obstacles: boxes to step over, in the body frame of this step.
        foothold: where the swing ankle must land in [m], shape (2,); where the base gait lands, on the ground, if None.
        field: gains; tuned ones if None.

    Raises:
        InputError: where an argument is unusable.
        InfeasibleGaitError: where the swing ankle stops before the foothold.
        UnreachableFootholdError: where the path leaves the reach of the swinging leg.
    """
    legs, boxes, goal = _task(base, obstacles, foothold)
    gains = PotentialField() if field is None else as_instance(field, "field", PotentialField)
    start = base.endpoints(legs)[0]
    path = _rounded(_down_the_field(start, goal, boxes, gains), gains.smoothing)
    pace = _lengths(base.endpoints(legs))
    lengths = _lengths(path)
    at = pace / pace[-1] * lengths[-1]
    points = np.stack([np.interp(at, lengths, column) for column in path.T], -1)
    return _followed(base, legs, points, "artificial potential field")


def minimum_jerk(
    base: Gait,
    obstacles: Sequence[Obstacle] = (),
    foothold: tuple[float, float] | None = None,
) -> Gait:
    """One step whose swing ankle has the least jerk (Flash and Hogan 1985), then inverse kinematics.

    Of all paths that start and land with the base gait's velocity and acceleration of the ankle and pass `SPARE` over
    both upper corners of every obstacle, at times that are free, the one with the least integral of squared jerk: a
    quintic between corners. Nothing is tuned. Starting and landing at rest, the classical form, puts the ankle out of
    the leg's reach on all five obstacles of the paper; the base gait's velocity without its acceleration costs a third
    more joint acceleration in the mean.

    Args:
        base: the base gait, whose supporting leg and boundary motion are taken over.
        obstacles: boxes to step over, in the body frame of this step.
        foothold: where the swing ankle must land in [m], shape (2,); where the base gait lands, on the ground, if None.

    Raises:
        InputError: where an argument is unusable, or the base gait has fewer than 4 frames.
        UnreachableFootholdError: where the path leaves the reach of the swinging leg.
    """
    legs, boxes, goal = _task(base, obstacles, foothold)
    if len(base) < 4:
        raise InputError(f"base: {len(base)} frames, its motion at both ends needs at least 4")
    path = base.endpoints(legs)
    # In shares of the step, 0 to 1: position, velocity and acceleration at both ends, by one-sided differences.
    dt = 1.0 / (len(base) - 1)
    starts, ends = _motion_at_start(path, dt), _motion_at_start(path[::-1], -dt)
    ends[0] = goal
    in_order = sorted(boxes, key=lambda box: box.x_start)
    corners = np.array([[x, box.height + SPARE] for box in in_order for x in (box.x_start, box.x_end)]).reshape(-1, 2)
    times = _passing_times(starts, ends, corners)
    pieces = _quintics(times, starts, ends, corners)[0]
    knots = np.append(0.0, times[:-1])
    at = np.linspace(0.0, 1.0, len(base))
    which = np.searchsorted(knots, at, "right") - 1
    powers = (at - knots[which])[:, None] ** np.arange(QUINTIC)
    return _followed(base, legs, np.einsum("nk,nkc->nc", powers, pieces[which]), "minimum-jerk endpoint")


def _task(
    base: Gait, obstacles: Sequence[Obstacle], foothold: tuple[float, float] | None
) -> tuple[LegModel, tuple[Obstacle, ...], Array]:
    """The legs, the boxes as the ankle must clear them, and the foothold."""
    legs = as_instance(base, "base", Gait).legs()
    boxes = tuple(box.for_ankle(legs.foot) for box in as_tuple_of(obstacles, "obstacles", Obstacle))
    landing = (float(base.endpoints(legs)[-1, 0]), 0.0) if foothold is None else foothold
    return legs, boxes, as_array(landing, "foothold", (2,))


def _followed(base: Gait, legs: LegModel, points: Array, name: str) -> Gait:
    """The base gait with the swing ankle on the path, shape (m, 2) in [m]."""
    support = base.frames[:, :2]
    frames = np.concatenate([support, legs.inverse_kinematics(points, support)], axis=1)
    return replace(base, frames=frames, name=name, origin=f"{name}, supporting leg of {base.name}", model=legs)


# -- potential field --------------------------------------------------------------------------------------------


def _down_the_field(start: Array, goal: Array, boxes: Sequence[Obstacle], gains: PotentialField) -> Array:
    """The path of the swing ankle from start to goal, shape (k, 2) in [m]."""
    (x, y), (goal_x, goal_y) = start.tolist(), goal.tolist()
    heading_x = heading_y = 0.0
    points = [(x, y)]
    for _ in range(MOST_PATH_STEPS):
        distance = math.hypot(goal_x - x, goal_y - y)
        if distance < PATH_STEP:
            return np.array([*points, (goal_x, goal_y)])
        force_x, force_y = (goal_x - x) / distance, (goal_y - y) / distance
        fade = min(1.0, distance / gains.fade)
        for push_x, push_y in _pushes(x, y, boxes, gains):
            force_x, force_y = force_x + fade**3 * push_x, force_y + fade**3 * push_y
        size = math.hypot(force_x, force_y) or 1.0
        kept = gains.inertia * fade  # or the ankle would circle around the foothold
        heading_x = kept * heading_x + (1.0 - kept) * force_x / size
        heading_y = kept * heading_y + (1.0 - kept) * force_y / size
        size = math.hypot(heading_x, heading_y) or 1.0
        x, y = x + PATH_STEP * heading_x / size, y + PATH_STEP * heading_y / size
        points.append((x, y))
    raise InfeasibleGaitError(f"potential field: the swing ankle stops at ({x:.3f}, {y:.3f}) m, before its foothold")


def _pushes(x: float, y: float, boxes: Sequence[Obstacle], gains: PotentialField) -> Iterator[tuple[float, float]]:
    """The forces of obstacles and ground on the swing ankle."""
    for box in boxes:
        off_x, off_y = x - min(max(x, box.x_start), box.x_end), y - min(y, box.height)
        distance = max(math.hypot(off_x, off_y), 1e-3)
        if distance < gains.reach:
            size = _repulsion(gains.repulsion, distance, gains.reach)
            away_x, away_y = off_x / distance, off_y / distance
            # The tangent is the outward normal turned clockwise: up the near side, forward over the top.
            yield size * (away_x + gains.tangential * away_y), size * (away_y - gains.tangential * away_x)
    if y < gains.ground_reach:
        yield 0.0, _repulsion(gains.ground_repulsion, max(y, 1e-3), gains.ground_reach)


def _repulsion(gain: float, distance: float, reach: float) -> float:
    return gain * (1.0 / distance - 1.0 / reach) / distance**2


def _rounded(path: Array, spread: float) -> Array:
    """The path under a Gaussian along its length; mirrored in its ends, so that they stay."""
    lengths = _lengths(path)
    count = 400
    at = np.linspace(0.0, lengths[-1], count)
    even = np.stack([np.interp(at, lengths, column) for column in path.T], -1)
    if spread < at[1]:
        return even
    mirrored = np.concatenate([2.0 * even[0] - even[:0:-1], even, 2.0 * even[-1] - even[-2::-1]])
    offsets = np.arange(-count + 1, count)
    weights = np.exp(-0.5 * (offsets * at[1] / spread) ** 2)
    weights /= weights.sum()
    return np.stack([np.convolve(column, weights, "same")[count - 1 : 2 * count - 1] for column in mirrored.T], -1)


def _lengths(path: Array) -> Array:
    """Length of the path up to each of its points in [m]."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])


# -- minimum jerk -----------------------------------------------------------------------------------------------


def _motion_at_start(path: Array, dt: float) -> Array:
    """Position, velocity and acceleration of the first point of a path, shape (3, 2)."""
    velocity = (-3.0 * path[0] + 4.0 * path[1] - path[2]) / (2.0 * dt)
    acceleration = (2.0 * path[0] - 5.0 * path[1] + 4.0 * path[2] - path[3]) / dt**2
    return np.stack([path[0], velocity, acceleration])


def _passing_times(starts: Array, ends: Array, corners: Array) -> Array:
    """When to pass each corner so that the whole path has the least jerk, as shares of the step; then 1."""
    if len(corners) == 0:
        return np.ones(1)
    from scipy.optimize import minimize  # here, since it takes longer to import than all the rest

    def times_of(logits: Array) -> Array:
        shares = np.exp(np.append(logits, 0.0))  # of the spans, beside that of the last one
        return np.append(np.cumsum(shares[:-1]) / shares.sum(), 1.0)

    def cost(logits: Array) -> float:
        return math.log(_quintics(times_of(logits), starts, ends, corners)[1])

    found = []
    # The cost has several valleys: passing early, in the middle and late.
    for middle in (0.15, 0.3, 0.5, 0.7):
        shares = np.full(len(corners), 0.1 / max(len(corners) - 1, 1))
        shares[0] = middle - 0.05
        first = np.log(shares / (0.95 - middle))
        found.append(minimize(cost, first, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-8}))
    return times_of(min(found, key=lambda result: float(result.fun)).x)


def _quintics(times: Array, starts: Array, ends: Array, corners: Array) -> tuple[Array, float]:
    """Coefficients (pieces, 6, 2) of the least-jerk path through the corners at these times, and its squared jerk.

    Position is given at the corners, all derivatives up to the fourth are continuous there: the conditions for a
    minimum of the integral of squared jerk.
    """
    spans = np.diff(times, prepend=0.0)
    count = len(spans)
    matrix, right = np.zeros((QUINTIC * count, QUINTIC * count)), np.zeros((QUINTIC * count, 2))
    matrix[:3, :QUINTIC], right[:3] = _derivatives(0.0)[:3], starts
    matrix[3:6, -QUINTIC:], right[3:6] = _derivatives(spans[-1])[:3], ends
    at_start = _derivatives(0.0)
    for n, corner in enumerate(corners):
        rows, here = slice(QUINTIC * (n + 1), QUINTIC * (n + 2)), QUINTIC * n
        block = matrix[rows]
        at_end = _derivatives(spans[n])
        block[0, here : here + QUINTIC], block[1, here + QUINTIC : here + 2 * QUINTIC] = at_end[0], at_start[0]
        block[2:, here : here + QUINTIC], block[2:, here + QUINTIC : here + 2 * QUINTIC] = at_end[1:5], -at_start[1:5]
        right[rows][:2] = corner
    pieces = np.linalg.solve(matrix, right).reshape(count, QUINTIC, 2)
    # Jerk a + b t + c t^2 over a span h, squared and integrated.
    h = spans[:, None]
    a, b, c = 6.0 * pieces[:, 3], 24.0 * pieces[:, 4], 60.0 * pieces[:, 5]
    squares = a * a * h + a * b * h**2 + (b * b + 2.0 * a * c) * h**3 / 3.0 + b * c * h**4 / 2.0 + c * c * h**5 / 5.0
    return np.asarray(pieces, dtype=np.float64), float(squares.sum())


def _derivatives(t: float) -> Array:
    """Row k: what the k-th derivative of a quintic at t is of its coefficients, shape (5, 6)."""
    rows = np.zeros((QUINTIC - 1, QUINTIC))
    for order in range(QUINTIC - 1):
        for power in range(order, QUINTIC):
            rows[order, power] = math.perm(power, order) * t ** (power - order)
    return rows
