"""How the rivals of the benchmark find a minimum: GTSAM with a custom factor for every pair of frames, SciPy, Ceres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import gtsam
import numpy as np
from rivals import Minimiser, Minimum, Problem
from scipy.optimize import least_squares
from scipy.sparse import coo_array, csr_array

from ggo_factors.arrays import Array
from ggo_factors.factors import anchor_factor, checked_factor, foothold_factor, frame_key, obstacle_factor, shank_factor
from ggo_factors.factors.checked import EdgeFunction
from ggo_factors.solve import ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE, optimize

try:
    import pyceres  # type: ignore[import-not-found]
except ImportError:
    pyceres = None

MOST_ITERATIONS = 100
DENSE_FRAMES = 101
"""More frames than these are not tried with a dense Jacobian, whose cost grows with their cube."""


# -- the textbook graph -----------------------------------------------------------------------------------------


def _pair_function(motion: Array) -> EdgeFunction:
    """Residual and knee edge of two frames in one: 4 + 2 rows, the knee's of the second frame."""
    minus, plus = np.zeros((6, 4), order="F"), np.zeros((6, 4), order="F")
    minus[:4], plus[:4] = -np.eye(4), np.eye(4)

    def evaluate(first: Array, last: Array, want_jacobian: bool) -> tuple[Array, tuple[Array, ...]]:
        error = np.zeros(6)
        error[:4] = last - first - motion
        block = plus
        for row, column in ((4, 1), (5, 3)):
            if last[column] < 0.0:
                error[row] = -last[column]
                if want_jacobian:
                    block = plus.copy(order="F") if block is plus else block
                    block[row, column] = -1.0
        return error, (minus, block)

    return evaluate


def textbook(problem: Problem, start: Array) -> Minimum:
    """GTSAM with the library's own edges, a variable and a custom factor for every frame."""
    gains, graph, values = problem.gains, gtsam.NonlinearFactorGraph(), gtsam.Values()
    graph.add(anchor_factor(0, problem.start))
    noise = gtsam.noiseModel.Diagonal.Precisions(np.array([1.0] * 4 + [gains.knee] * 2))
    for n, motion in enumerate(np.diff(problem.base, axis=0)):
        graph.add(checked_factor("pair", (n, n + 1), 6, _pair_function(motion), noise))
    for lift in problem.lifts:
        graph.add(
            obstacle_factor(
                lift.frame, problem.model, lift.height, gamma=gains.gamma, hold=gains.hold, hold_x=lift.hold_x
            )
        )
    last = len(problem.base) - 1
    graph.add(foothold_factor(last, problem.model, problem.foothold, problem.gains.end))
    if problem.shank_angle is not None:
        graph.add(shank_factor(last, problem.shank_angle, problem.gains.end))
    for n, frame in enumerate(start):
        values.insert(frame_key(n), frame)
    outcome = optimize(graph, values, max_iterations=MOST_ITERATIONS)
    frames = np.stack([outcome.values.atVector(frame_key(n)) for n in range(len(start))])
    return Minimum(frames, outcome.iterations, outcome.error_history[-1])


# -- SciPy ------------------------------------------------------------------------------------------------------


class _Vectorised:
    """All rows at once, in numpy; the first frame is no variable."""

    def __init__(self, problem: Problem) -> None:
        self._problem, self._motion = problem, np.diff(problem.base, axis=0)
        self._lifted = np.array([lift.frame for lift in problem.lifts], dtype=int)
        self._height = np.array([lift.height for lift in problem.lifts])
        self._hold_x = np.array([lift.hold_x for lift in problem.lifts])
        self._gamma, self._hold = problem.gains.gamma, problem.gains.hold
        self._knee, self._end = np.sqrt(problem.gains.knee), np.sqrt(problem.gains.end)
        count = len(problem.base) - 1
        rows = np.arange(4 * count)
        knees = 4 * count + np.arange(2 * count)
        lifts = 6 * count + np.arange(2 * len(self._lifted))
        ends = lifts[-1:].max(initial=6 * count - 1) + 1 + np.arange(2 if problem.shank_angle is None else 3)
        places = 4 * (self._lifted - 1)[:, None] + np.arange(4)
        final = 4 * (count - 1) + np.arange(4)
        every = [
            (rows, rows),
            (rows[4:], rows[:-4]),
            (knees, np.stack([rows[1::4], rows[3::4]], -1).ravel()),
            (np.repeat(lifts, 4), np.concatenate([places, places], axis=1).ravel()),
            (np.repeat(ends, 4), np.tile(final, len(ends))),
        ]
        at = np.concatenate([r for r, _ in every]), np.concatenate([c for _, c in every])
        self._shape = (int(ends[-1]) + 1, 4 * count)
        # Numbered entries tell, once, where each one goes in the compressed matrix.
        pattern = csr_array(coo_array((np.arange(len(at[0]), dtype=float), at), shape=self._shape))
        self._order = pattern.data.astype(int)
        self._indices, self._indptr = pattern.indices, pattern.indptr

    def _frames(self, x: Array) -> Array:
        return np.concatenate([self._problem.start[None], x.reshape(-1, 4)])

    def rows(self, x: Array) -> Array:
        """The whitened errors."""
        problem, frames = self._problem, self._frames(x)
        knees = self._knee * np.maximum(-frames[1:, [1, 3]], 0.0)
        p = problem.model.endpoint(frames[self._lifted])
        over = np.exp(self._gamma * np.maximum(self._height - p[:, 1], 0.0)) - 1.0
        lifts = np.stack([over, self._hold * (p[:, 0] - self._hold_x)], -1)
        parts = [np.diff(frames, axis=0) - self._motion, knees, lifts]
        parts.append(self._end * (problem.model.endpoint(frames[-1]) - problem.foothold))
        if problem.shank_angle is not None:
            angle = np.pi / 2.0 + frames[-1, 2] - frames[-1, 3]
            parts.append(self._end * np.array([angle - problem.shank_angle]))
        return np.concatenate([part.ravel() for part in parts])

    def sparse(self, x: Array) -> csr_array[np.float64]:
        """Their Jacobian."""
        problem, frames = self._problem, self._frames(x)
        count = len(frames) - 1
        p, by = problem.model.endpoint(frames[self._lifted]), problem.model.endpoint_jacobian(frames[self._lifted])
        slope = -self._gamma * np.exp(self._gamma * (self._height - p[:, 1])) * (p[:, 1] < self._height)
        parts = [np.ones(4 * count), -np.ones(4 * count - 4)]
        parts.append(-self._knee * (frames[1:, [1, 3]] < 0.0))
        parts.append(np.stack([slope[:, None] * by[:, 1], self._hold * by[:, 0]], 1))
        parts.append(self._end * problem.model.endpoint_jacobian(frames[-1]))
        if problem.shank_angle is not None:
            parts.append(self._end * np.array([0.0, 0.0, 1.0, -1.0]))
        data = np.concatenate([np.asarray(part, dtype=np.float64).ravel() for part in parts])
        return csr_array((data[self._order], self._indices, self._indptr), shape=self._shape)

    def dense(self, x: Array) -> Array:
        """The same, every zero written out."""
        return np.asarray(self.sparse(x).toarray(), dtype=np.float64)


def _scipy(problem: Problem, start: Array, options: Mapping[str, Any], dense: bool) -> Minimum:
    rows = _Vectorised(problem)
    result = least_squares(
        rows.rows,
        start[1:].ravel(),
        jac=rows.dense if dense else rows.sparse,
        ftol=RELATIVE_TOLERANCE,
        xtol=ABSOLUTE_TOLERANCE,
        gtol=ABSOLUTE_TOLERANCE,
        max_nfev=MOST_ITERATIONS,
        **options,
    )
    frames = np.concatenate([problem.start[None], result.x.reshape(-1, 4)])
    return Minimum(frames, int(result.njev if result.njev is not None else result.nfev), float(result.cost))


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
    pair = np.sqrt(np.array([1.0] * 4 + [problem.gains.knee] * 2))
    for n, motion in enumerate(np.diff(problem.base, axis=0)):
        edges.append((edge_type(2, pair, _pair_function(motion)), [frames[n], frames[n + 1]]))
    for n, rows, gain, function in problem.points():
        edges.append((edge_type(1, np.full(rows, np.sqrt(gain)), function), [frames[n]]))
    for edge, blocks in edges:
        graph.add_residual_block(edge, None, blocks)
    graph.set_parameter_block_constant(frames[0])
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
    return Minimum(np.stack(frames), int(iterations), float(summary.final_cost))


# -- who runs ---------------------------------------------------------------------------------------------------


def rivals(frames: int) -> dict[str, dict[str, Minimiser]]:
    """Each rival by name, in the variants of which the fastest counts for this many frames."""
    sparse = {"tr_solver": "lsmr", "method": "trf"}
    scipy: dict[str, Minimiser] = {"trf, lsmr": lambda p, x: _scipy(p, x, sparse, dense=False)}
    ceres: dict[str, Minimiser] = {"sparse": lambda p, x: _ceres(p, x, "SPARSE_NORMAL_CHOLESKY")}
    if frames <= DENSE_FRAMES:
        exact = {"tr_solver": "exact", "method": "trf"}
        scipy["trf, dense"] = lambda p, x: _scipy(p, x, exact, dense=True)
        scipy["lm, dense"] = lambda p, x: _scipy(p, x, {"method": "lm"}, dense=True)
        ceres["dense"] = lambda p, x: _ceres(p, x, "DENSE_NORMAL_CHOLESKY")
    found: dict[str, dict[str, Minimiser]] = {"textbook": {"": textbook}, "SciPy": scipy}
    return found if pyceres is None else {**found, "pyceres": ceres}
