"""How the rivals of the benchmark find a minimum: GTSAM with a custom factor for every pair of frames, SciPy, Ceres."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise
from typing import Any

import gtsam
import numpy as np
from rivals import HIP_GAIN, Minimiser, Minimum, Problem, hip_height
from scipy.optimize import least_squares
from scipy.sparse import coo_array, csr_array, diags_array, eye_array, kron, vstack

from ggo_factors.factors import anchor_factor, checked_factor, frame_key, precision
from ggo_factors.factors.checked import EdgeFunction
from ggo_factors.graph.judge import optimize
from ggo_factors.graph.optimizer import ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE
from ggo_factors.support.inputs import Array

try:
    import pyceres  # type: ignore[import-not-found]
except ImportError:
    pyceres = None

MOST_ITERATIONS = 100
DENSE_FRAMES = 101
"""More frames than these are not tried with a dense Jacobian, whose cost grows with their cube."""


# -- the textbook graph -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Motion:
    """Everything about the motion into one frame in one edge, as every callback costs.

    Its rows: 4 of the first-order residual edge, 4 of the second-order one, if there is one, which makes it an edge on
    three frames, and the knees' 2.
    """

    frames: tuple[int, ...]
    gains: Array
    function: EdgeFunction


def _motions(problem: Problem) -> Iterator[_Motion]:
    """The motions into the frames that are not given."""
    offset, gain = np.diff(problem.base, axis=0), problem.smoothness
    for last in range(len(problem.given), len(problem.base)):
        bend = offset[last - 1] - offset[last - 2] if gain and last > 1 else None
        motion = problem.last_motion_gain if last == len(offset) else 1.0
        gains = [motion] * 4 + [gain] * (0 if bend is None else 4) + [problem.gains.knee * problem.gains.share] * 2
        first = last - (1 if bend is None else 2)
        function = _motion_function(offset[last - 1], bend)
        yield _Motion(tuple(range(first, last + 1)), np.array(gains), function)


def _motion_function(motion: Array, bend: Array | None) -> EdgeFunction:
    rows = 6 if bend is None else 10
    blocks = [np.zeros((rows, 4), order="F") for _ in range(2 if bend is None else 3)]
    blocks[-2][:4], blocks[-1][:4] = -np.eye(4), np.eye(4)
    if bend is not None:
        for block, weight in zip(blocks, (1.0, -2.0, 1.0), strict=True):
            block[4:8] = weight * np.eye(4)
    knees = ((rows - 2, 1), (rows - 1, 3))

    def evaluate(*arguments: Any) -> tuple[Array, Sequence[Array]]:
        before, last, _ = arguments[-3:]
        error = np.zeros(rows)
        error[:4] = last - before - motion
        if bend is not None:
            error[4:8] = arguments[0] - 2.0 * before + last - bend
        bent = [(row, column) for row, column in knees if last[column] < 0.0]
        if not bent:
            return error, blocks
        mine = blocks[-1].copy(order="F")
        for row, column in bent:
            error[row], mine[row, column] = -last[column], -1.0
        return error, [*blocks[:-1], mine]

    return evaluate


def factors(problem: Problem) -> dict[Hashable, Callable[[], gtsam.CustomFactor]]:
    """What makes each factor of the textbook graph, by what tells it from the others."""
    made: dict[Hashable, Callable[[], gtsam.CustomFactor]] = {}
    for n, frame in [*enumerate(problem.given), *enumerate(problem.rest, problem.free.stop)]:
        made["given", n] = partial(anchor_factor, n, frame)
    for motion in _motions(problem):
        noise = gtsam.noiseModel.Diagonal.Precisions(motion.gains)
        made["motion", motion.frames] = partial(
            checked_factor, "motion", motion.frames, len(motion.gains), motion.function, noise
        )
    for n, rows, gain, function in problem.points():
        made["point", n, function] = partial(checked_factor, "point", (n,), rows, function, precision(rows, gain))
    return made


def textbook(problem: Problem, start: Array) -> Minimum:
    """GTSAM with the library's own edges, a variable and a custom factor for every frame."""
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for make in factors(problem).values():
        graph.add(make())
    for n, frame in enumerate(start):
        values.insert(frame_key(n), frame)
    outcome = optimize(graph, values, max_iterations=MOST_ITERATIONS)
    frames = np.stack([outcome.values.atVector(frame_key(n)) for n in range(len(start))])
    return Minimum(frames, outcome.iterations)


# -- SciPy ------------------------------------------------------------------------------------------------------


class _Vectorised:
    """All rows at once, in numpy; the frames that are given are no variables."""

    def __init__(self, problem: Problem) -> None:
        self._problem, self._given = problem, len(problem.given)
        self._landing = problem.landing
        self._bend = np.sqrt(problem.smoothness)
        self._sunk = np.array(problem.sunk, dtype=int)
        self._lifted = np.array([lift.frame for lift in problem.lifts], dtype=int)
        self._height = np.array([lift.height for lift in problem.lifts])
        self._hold_x = np.array([lift.hold_x for lift in problem.lifts])
        self._gamma, self._hold = problem.gains.gamma, problem.gains.hold
        self._share, self._end = np.sqrt(problem.gains.share), np.sqrt(problem.gains.end)
        self._knee, self._hip = self._share * np.sqrt(problem.gains.knee), self._share * np.sqrt(HIP_GAIN)
        frames, count = len(problem.base), problem.free.stop - self._given
        self._motion = np.ones((frames - self._given, 1))
        self._motion[-1] = np.sqrt(problem.last_motion_gain)
        first: Any = diags_array([-1.0, 1.0], offsets=[0, 1], shape=(frames - 1, frames))
        chains = [first.tocsr()[self._given - 1 :].multiply(self._motion)]
        if self._bend:
            chains.append(self._bend * diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(frames - 2, frames)))
        variables = slice(4 * self._given, 4 * problem.free.stop)
        linear = kron(vstack(chains), eye_array(4)).tocsr()[:, variables].tocoo()
        self._linear = linear.data
        ends = 0 if len(problem.rest) else 2 if problem.shank_angle is None else 3
        postures = 0 if self._landing is None else 4
        sizes = np.cumsum([linear.shape[0], 2 * count, 2 * len(self._lifted), len(self._sunk), ends, postures])
        knees, lifts, hips, end, posture = (np.arange(*each) for each in pairwise(sizes.tolist()))
        places = 4 * (self._lifted - self._given)[:, None] + np.arange(4)
        every = [
            (linear.row, linear.col),
            (knees, (4 * np.arange(count)[:, None] + [1, 3]).ravel()),
            (np.repeat(lifts, 4), np.concatenate([places, places], axis=1).ravel()),
            (np.repeat(hips, 2), (4 * (self._sunk - self._given)[:, None] + [0, 1]).ravel()),
            (np.repeat(end, 4), np.tile(4 * (count - 1) + np.arange(4), ends)),
            (posture, 4 * (count - 1) + np.arange(postures)),
        ]
        at = np.concatenate([r for r, _ in every]), np.concatenate([c for _, c in every])
        self._shape = (int(sizes[-1]), 4 * count)
        # Numbered entries tell, once, where each one goes in the compressed matrix.
        pattern = csr_array(coo_array((np.arange(len(at[0]), dtype=float), at), shape=self._shape))
        self._order = pattern.data.astype(int)
        self._indices, self._indptr = pattern.indices, pattern.indptr

    def frames(self, x: Array) -> Array:
        """The variables with the frames that are given."""
        return np.concatenate([self._problem.given, x.reshape(-1, 4), self._problem.rest])

    def rows(self, x: Array) -> Array:
        """The whitened errors."""
        problem, frames = self._problem, self.frames(x)
        motion = np.diff(frames - problem.base, axis=0)
        knees = self._knee * np.maximum(-frames[problem.free][:, [1, 3]], 0.0)
        p = problem.model.endpoint(frames[self._lifted])
        over = np.exp(self._gamma * np.maximum(self._height - p[:, 1], 0.0)) - 1.0
        lifts = self._share * np.stack([over, self._hold * (p[:, 0] - self._hold_x)], -1)
        parts = [self._motion * motion[self._given - 1 :]]
        if self._bend:
            parts.append(self._bend * np.diff(motion, axis=0))
        hips = self._hip * np.maximum(problem.hip - hip_height(problem.model, frames[self._sunk]), 0.0)
        parts += [knees, lifts, hips]
        if not len(problem.rest):
            parts.append(self._end * (problem.model.endpoint(frames[-1]) - problem.foothold))
        if problem.shank_angle is not None:
            angle = np.pi / 2.0 + frames[-1, 2] - frames[-1, 3]
            parts.append(self._end * np.array([angle - problem.shank_angle]))
        if self._landing is not None:
            parts.append(np.sqrt(self._landing.posture_gain) * (frames[-1] - self._landing.posture))
        return np.concatenate([part.ravel() for part in parts])

    def sparse(self, x: Array) -> csr_array[np.float64]:
        """Their Jacobian."""
        problem, frames = self._problem, self.frames(x)
        p, by = problem.model.endpoint(frames[self._lifted]), problem.model.endpoint_jacobian(frames[self._lifted])
        slope = -self._gamma * np.exp(self._gamma * (self._height - p[:, 1])) * (p[:, 1] < self._height)
        parts = [self._linear, -self._knee * (frames[problem.free][:, [1, 3]] < 0.0)]
        parts.append(self._share * np.stack([slope[:, None] * by[:, 1], self._hold * by[:, 0]], 1))
        parts.append(self._hip * self._hip_slopes(frames[self._sunk]))
        if not len(problem.rest):
            parts.append(self._end * problem.model.endpoint_jacobian(frames[-1]))
        if problem.shank_angle is not None:
            parts.append(self._end * np.array([0.0, 0.0, 1.0, -1.0]))
        if self._landing is not None:
            parts.append(np.full(4, np.sqrt(self._landing.posture_gain)))
        data = np.concatenate([np.asarray(part, dtype=np.float64).ravel() for part in parts])
        return csr_array((data[self._order], self._indices, self._indptr), shape=self._shape)

    def _hip_slopes(self, frames: Array) -> Array:
        model, low = self._problem.model, hip_height(self._problem.model, frames) < self._problem.hip
        shank = model.shank * np.sin(frames[:, 0] - frames[:, 1])
        return np.where(low[:, None], np.stack([model.thigh * np.sin(frames[:, 0]) + shank, -shank], -1), 0.0)

    def dense(self, x: Array) -> Array:
        """The same, every zero written out."""
        return np.asarray(self.sparse(x).toarray(), dtype=np.float64)


def _scipy(problem: Problem, start: Array, options: Mapping[str, Any], dense: bool) -> Minimum:
    rows = _Vectorised(problem)
    result = least_squares(
        rows.rows,
        start[problem.free].ravel(),
        jac=rows.dense if dense else rows.sparse,
        ftol=RELATIVE_TOLERANCE,
        xtol=ABSOLUTE_TOLERANCE,
        gtol=ABSOLUTE_TOLERANCE,
        max_nfev=MOST_ITERATIONS,
        **options,
    )
    return Minimum(rows.frames(result.x), int(result.njev if result.njev is not None else result.nfev))


# -- Ceres ------------------------------------------------------------------------------------------------------


@cache
def _edge_type() -> Any:
    """The cost function, a class that can be made only where pyceres is installed."""

    class Edge(pyceres.CostFunction):  # type: ignore[misc]
        """An edge of the library, the square root of its gain taken in."""

        def __init__(self, blocks: int, root: Array, function: EdgeFunction) -> None:
            pyceres.CostFunction.__init__(self)
            self.set_num_residuals(len(root))
            self.set_parameter_block_sizes([4] * blocks)
            self._root, self._column, self._function = root, root[:, None], function

        def Evaluate(self, at: Sequence[Array], error: Array, blocks: list[Array] | None) -> bool:  # noqa: N802
            value, jacobians = self._function(*at, blocks is not None)
            error[:] = self._root * value
            if blocks is not None:
                for block, jacobian in zip(blocks, jacobians, strict=True):
                    if block is not None:
                        block[:] = (self._column * jacobian).ravel()
            return True

    return Edge


def _ceres(problem: Problem, start: Array, solver: str) -> Minimum:
    edge_type = _edge_type()
    frames = [frame.copy() for frame in start]
    graph, edges = pyceres.Problem(), []  # the edges must outlive the problem
    for motion in _motions(problem):
        edge = edge_type(len(motion.frames), np.sqrt(motion.gains), motion.function)
        edges.append((edge, [frames[n] for n in motion.frames]))
    for n, rows, gain, function in problem.points():
        edges.append((edge_type(1, np.full(rows, np.sqrt(gain)), function), [frames[n]]))
    for edge, blocks in edges:
        graph.add_residual_block(edge, None, blocks)
    for n in (*range(problem.free.start), *range(problem.free.stop, len(frames))):
        graph.set_parameter_block_constant(frames[n])
    options, summary = pyceres.SolverOptions(), pyceres.SolverSummary()
    options.trust_region_strategy_type = pyceres.TrustRegionStrategyType.DOGLEG
    options.linear_solver_type = getattr(pyceres.LinearSolverType, solver)
    options.function_tolerance = RELATIVE_TOLERANCE
    options.gradient_tolerance = options.parameter_tolerance = ABSOLUTE_TOLERANCE
    options.max_num_iterations = MOST_ITERATIONS
    options.minimizer_progress_to_stdout = False
    options.logging_type = pyceres.LoggingType.SILENT
    pyceres.solve(options, graph, summary)
    iterations = summary.num_successful_steps + summary.num_unsuccessful_steps
    return Minimum(np.stack(frames), int(iterations))


# -- who runs ---------------------------------------------------------------------------------------------------


def rivals(frames: int) -> dict[str, dict[str, Minimiser]]:
    """Each rival by name, in the variants of which the fastest counts for this many frames."""
    # With LSMR's own tolerances of 1e-6 the iterations neither end nor reach the minimum.
    accurate = {"atol": 1e-10, "btol": 1e-10, "conlim": 0.0, "maxiter": 100 * frames}
    sparse = {"tr_solver": "lsmr", "tr_options": accurate, "method": "trf"}
    scipy: dict[str, Minimiser] = {"trf, lsmr": lambda p, x: _scipy(p, x, sparse, dense=False)}
    ceres: dict[str, Minimiser] = {"sparse": lambda p, x: _ceres(p, x, "SPARSE_NORMAL_CHOLESKY")}
    if frames <= DENSE_FRAMES:
        exact = {"tr_solver": "exact", "method": "trf"}
        scipy["trf, dense"] = lambda p, x: _scipy(p, x, exact, dense=True)
        scipy["lm, dense"] = lambda p, x: _scipy(p, x, {"method": "lm"}, dense=True)
        ceres["dense"] = lambda p, x: _ceres(p, x, "DENSE_NORMAL_CHOLESKY")
    found: dict[str, dict[str, Minimiser]] = {"textbook": {"": textbook}, "SciPy": scipy}
    return found if pyceres is None else {**found, "pyceres": ceres}
