"""What a step costs, nearly as its graph has it, without GTSAM: for hundreds of steps at once, around footholds chosen.

The residual edges, the start's rate and the landing edges make one Gaussian chain of all frames, the same for each
joint, whose mean and covariance are known for any start and touchdown. What is hard holds a few rows of it: the
foothold, the instant at which the swing ankle is lowest over what is in its way, a knee that would bend backwards. A
few Newton steps on those rows give the least cost that keeps them, and the path, within some per cent of the graph's.
`step_cost` takes the landing for hard and what must be lifted for small: nearer the truth it is quicker than right.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ggo_factors.check.ground import FOOTHOLD_ZONE
from ggo_factors.graph.requests import MOTION_GAIN, POSTURE_GAIN
from ggo_factors.planning.step_cost import FARTHEST_LIFT, LEAST_VARIANCE, StepCosts
from ggo_factors.support.inputs import Array

INSTANTS = 25
"""The path of the swing ankle is looked at at about so many instants."""
LOOKS = 2
"""So many times the instant at which the swing ankle is lowest is found and held up."""
NEWTON = 2
"""Newton steps after each."""
SLACK = 0.01
"""Share of its variance that a row but the foothold's may be missed by, so that two at one instant do not fight."""
BELOW = 1e-3
"""A swing ankle that is so much too low in [m] is held up."""
BACKWARDS = 1e-4
"""A knee that bends backwards by so much in [rad] is held."""


@dataclass(frozen=True, eq=False)
class Chain:
    """The offsets of a step's frames from the base gait: a Gaussian chain with a given start.

    Attributes:
        covariance: of the offsets, shape (m, m); 0 for the first frame.
        weights: their mean, of the offset of the first frame, of the change of the offset in the first motion, and of
            the touchdown posture's offset, shape (m, 3).
        quadratic: twice what the mean costs as a quadratic form in those three, shape (3, 3).
    """

    covariance: Array
    weights: Array
    quadratic: Array


@lru_cache(maxsize=16)
def chain_of(motions: int, smoothness: float) -> Chain:
    """The chain of a step's edges that are linear: residual, rate, landing.

    Args:
        motions: from frame to frame.
        smoothness: gain of the second-order edges.
    """
    count = motions + 1
    first, last, end = np.zeros(count), np.zeros(count), np.zeros(count)
    first[:2], last[-2:], end[-1] = [-1.0, 1.0], [-1.0, 1.0], 1.0
    steps, bends = np.diff(np.eye(count), axis=0), np.diff(np.eye(count), n=2, axis=0)
    rate, posture = 2.0 * smoothness, POSTURE_GAIN / motions
    information = steps.T @ steps + smoothness * bends.T @ bends + rate * np.outer(first, first)
    information += MOTION_GAIN * motions * np.outer(last, last) + posture * np.outer(end, end)
    covariance = np.zeros((count, count))
    covariance[1:, 1:] = np.linalg.inv(information[1:, 1:])
    pulls = np.stack([np.zeros(count), rate * first, posture * end], -1)
    weights = covariance @ np.stack([-information[:, 0], rate * first, posture * end], -1)
    weights[0] = [1.0, 0.0, 0.0]
    quadratic = weights.T @ information @ weights - pulls.T @ weights - weights.T @ pulls
    quadratic += np.diag([0.0, rate, posture])
    return Chain(covariance, weights, quadratic)


@dataclass(eq=False)
class Held:
    """Paths of steps with some rows of them held.

    Attributes:
        mean: frames at the instants with nothing held, shape (n, k, 4) in [rad].
        covariance: of an angle's offset over the instants, shape (k, k).
        at: the instant of each row, shape (n, rows).
        jacobian: of each row by its frame, shape (n, rows, 4).
        short: what each row is short of at the mean, shape (n, rows).
        on: which rows are held, shape (n, rows).
        pull: multiplier of each row, shape (n, rows).
    """

    mean: Array
    covariance: Array
    at: NDArray[np.intp]
    jacobian: Array
    short: Array
    on: NDArray[np.bool_]
    pull: Array

    @classmethod
    def nothing(cls, mean: Array, covariance: Array, rows: int) -> Held:
        """Paths on which nothing is held yet, of at most so many rows."""
        shape = len(mean), rows
        none = np.zeros(shape)
        last = np.full(shape, len(covariance) - 1, dtype=np.intp)
        return cls(mean, covariance, last, np.zeros((*shape, 4)), none, np.zeros(shape, dtype=bool), none.copy())

    def solve(self) -> Array:
        """What it costs to hold the rows, shape (n,); finds their multipliers."""
        rows = self.at.shape[1]
        gram = self.covariance[self.at[:, :, None], self.at[:, None, :]]
        gram = gram * (self.jacobian @ self.jacobian.transpose(0, 2, 1))
        gram *= self.on[:, :, None] & self.on[:, None, :]
        slack = np.where(np.arange(rows) < 2, 0.0, SLACK)
        diagonal = gram[:, range(rows), range(rows)] * (1.0 + slack) + 1e-12
        gram[:, range(rows), range(rows)] = np.where(self.on, diagonal, 1.0)
        short = np.where(self.on, self.short, 0.0)
        self.pull = np.asarray(np.linalg.solve(gram, short[..., None])[..., 0])
        return np.asarray(0.5 * (self.pull * short).sum(axis=1))

    def frames(self, rows: slice) -> Array:
        """Frames at the instants of some rows, shape (n, rows, 4) in [rad]."""
        at = self.at[:, rows]
        shares = self.covariance[at[:, :, None], self.at[:, None, :]] * self.pull[:, None, :]
        return np.asarray(self.mean[np.arange(len(at))[:, None], at] + shares @ self.jacobian)

    def path(self) -> Array:
        """Frames at all instants, shape (n, k, 4) in [rad]."""
        shares = self.covariance[self.at].transpose(0, 2, 1) * self.pull[:, None, :]
        return np.asarray(self.mean + shares @ self.jacobian)


@dataclass(frozen=True, eq=False)
class NearCosts:
    """Near costs of steps of one walker.

    Attributes:
        rough: the walker, the ground, and what steps cost roughly.
    """

    rough: StepCosts

    def of(self, starts: Array, ends: Array, stands: Array, leaves: Array, met: NDArray[np.bool_]) -> Array:
        """Cost of the path of each step over what is in its way, shape (n,) in [rad^2].

        Args:
            starts: frame that the step begins in, shape (n, 4) in [rad].
            ends: its touchdown posture, shape (n, 4) in [rad].
            stands: x of the supporting ankle in the world frame, shape (n,) in [m].
            leaves: change of the offset from the base gait in the first motion, shape (n, 4) in [rad].
            met: whether anything may be in its way, shape (n,).

        Returns:
            Infinite where the ankle would have to be lifted further than `FARTHEST_LIFT`.
        """
        costs = np.empty(len(starts))
        for which, looks in ((~met, 0), (met, LOOKS)):
            (some,) = np.nonzero(which)
            if len(some):
                costs[some] = self._of(starts[some], ends[some], stands[some], leaves[some], looks)
        return costs

    def _of(self, starts: Array, ends: Array, stands: Array, leaves: Array, looks: int) -> Array:
        base, model = self.rough.base.frames, self.rough.model
        motions, every = len(base) - 1, max(1, (len(base) - 1) // INSTANTS)
        chain = chain_of(motions, self.rough.smoothness)
        instants = np.append(np.arange(every, motions, every), motions)
        given = np.stack([starts - base[0], leaves, ends - base[-1]], axis=1)
        free = 0.5 * (given * (chain.quadratic @ given)).sum(axis=(1, 2))
        mean = base[instants] + chain.weights[instants] @ given
        # The rows: x and y of the swing ankle at the landing and at its lowest instants, then the knees.
        feet = 2 + 2 * looks
        held = Held.nothing(mean, chain.covariance[np.ix_(instants, instants)], feet + 2)
        held.on[:, :2] = True
        held.jacobian[:, feet, 1] = held.jacobian[:, feet + 1, 3] = 1.0
        goals = np.zeros((len(starts), feet // 2, 2))
        goals[:, 0] = model.endpoint(ends)
        cost = self._newton(held, goals, np.repeat(ends[:, None], feet // 2, axis=1))
        least = np.minimum(0.0, np.minimum(starts[:, 1::2].min(axis=1), ends[:, 1::2].min(axis=1)))
        wall = np.zeros(len(starts), dtype=bool)
        for look in range(max(1, looks)):
            path = held.path()
            if looks:
                wall |= self._hold_up(held, goals, 1 + look, path, stands, model.endpoint(starts))
            if self._hold_knees(held, path, least, feet) or looks:
                cost = self._newton(held, goals, held.frames(slice(0, feet, 2)))
                wrong = held.on & (held.pull < 0.0)
                wrong[:, :2] = wrong[:, 2:feet:2] = False
                if wrong.any():  # what pulls down is not in the way
                    held.on &= ~wrong
                    held.on[:, 2:feet:2] &= held.on[:, 3:feet:2]
                    cost = self._newton(held, goals, held.frames(slice(0, feet, 2)))
        return np.where(wall | np.isnan(cost), np.inf, free + cost)

    def _newton(self, held: Held, goals: Array, frames: Array) -> Array:
        """What it costs to hold the swing ankle on its goals, shape (n,), from frames of shape (n, k, 4) in [rad]."""
        count, goals_each = goals.shape[:2]
        feet = slice(0, 2 * goals_each, 2)
        mean = held.mean[np.arange(count)[:, None], held.at[:, feet]]
        cost = np.zeros(count)
        for _ in range(NEWTON):
            points, jacobian = self.rough.model.endpoint_and_jacobian(frames.reshape(-1, 4))
            jacobian = jacobian.reshape(count, goals_each, 2, 4)
            off = goals - points.reshape(count, goals_each, 2) + (jacobian @ (frames - mean)[..., None])[..., 0]
            held.jacobian[:, : 2 * goals_each] = jacobian.reshape(count, -1, 4)
            held.short[:, : 2 * goals_each] = off.reshape(count, -1)
            cost = held.solve()
            frames = held.frames(feet)
        return cost

    def _hold_up(
        self, held: Held, goals: Array, slot: int, path: Array, stands: Array, begins: Array
    ) -> NDArray[np.bool_]:
        """Hold the swing ankle up where it is, at the instant at which that costs most; whether it must go too high."""
        count, instants = path.shape[:2]
        points, jacobian = self.rough.model.endpoint_and_jacobian(path.reshape(-1, 4))
        x, y = points.reshape(count, instants, 2).transpose(2, 0, 1)
        ahead, up = jacobian.reshape(count, instants, 2, 4).transpose(2, 0, 1, 3)
        over = self.rough.least_height(x, stands, begins[:, :1], goals[:, 0, :1])
        over -= self.rough.roof.ground_at(stands)[:, None]
        for foot in (begins, goals[:, 0]):  # beside its footholds the ground is that under it
            over = np.where(np.abs(x - foot[:, :1]) <= FOOTHOLD_ZONE, np.minimum(over, foot[:, 1:]), over)
        need = np.clip(over - y, 0.0, 2.0 * FARTHEST_LIFT)
        need[:, -1] = 0.0
        squares = (up**2).sum(axis=-1) - (up * ahead).sum(axis=-1) ** 2 / (ahead**2).sum(axis=-1)
        variances = np.diag(held.covariance)
        loose = np.maximum(variances, LEAST_VARIANCE * variances.max())
        worst = (need**2 / (squares * loose)).argmax(axis=1)
        each = np.arange(count)
        low = need[each, worst] > BELOW
        held.at[:, 2 * slot : 2 * slot + 2] = np.where(low, worst, instants - 1)[:, None]
        held.on[:, 2 * slot : 2 * slot + 2] = low[:, None]
        goals[:, slot] = np.stack([x[each, worst], (y + need)[each, worst]], -1)
        return np.asarray(need.max(axis=1) > FARTHEST_LIFT)

    def _hold_knees(self, held: Held, path: Array, least: Array, feet: int) -> bool:
        """Hold knees where they bend backwards most, at `least` of shape (n,) in [rad]; whether any does."""
        knees = path[:, :-1, 1::2]
        if not knees.size:
            return False  # a base gait of one motion has no frame on the way
        lowest = knees.argmin(axis=1)
        back = knees.min(axis=1) < least[:, None] - BACKWARDS
        rows = slice(feet, feet + 2)
        held.at[:, rows] = np.where(back, lowest, held.at[:, rows])
        held.on[:, rows] |= back
        means = np.take_along_axis(held.mean[:, :, 1::2], held.at[:, None, rows], axis=1)[:, 0]
        held.short[:, rows] = least[:, None] - means
        return bool(back.any())
