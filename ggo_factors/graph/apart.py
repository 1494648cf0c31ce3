"""A graph taken apart: its edges one by one, a picture of it, and a gait from values that were edited."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import gtsam
import numpy as np

from ggo_factors.errors import InputError
from ggo_factors.factors import frame_of_key
from ggo_factors.factors.checked import CheckedFactor
from ggo_factors.graph.assembly import Assembly
from ggo_factors.graph.problem import EdgeKey
from ggo_factors.motion.gait import Gait
from ggo_factors.support.inputs import Array, as_angles, as_array, as_instance

USER = "user"
"""Family of the factors of a user's own."""


@dataclass(frozen=True, eq=False)
class GraphEdge:
    """An edge of a gait graph as it stands in its last round.

    Attributes:
        family: what its cost counts to: anchor, residual, smoothness, knee, limits, obstacle, end, landing, balance,
            style or user.
        name: what it is called in errors.
        frames: numbers n of the variables ``gtsam.symbol("g", n)`` that it connects.
        gain: it adds `gain * |error|^2 / 2` to the graph's error; infinite for a hard constraint of GTSAM's, large for
            one whose target is shifted until it is met, NaN for a factor of a user's own whose rows count differently.
        error: its error at the graph's present values, shape (rows,).
        factor: the same as a GTSAM factor.
    """

    family: str
    name: str
    frames: tuple[int, ...]
    gain: float
    error: Array
    factor: gtsam.NonlinearFactor
    _key: EdgeKey = field(repr=False)

    def __repr__(self) -> str:
        where = ", ".join(map(str, self.frames))
        away = float(np.linalg.norm(self.error))
        return f"GraphEdge({self.family}, {self.name!r} on frames [{where}], gain {self.gain:.4g}, |error| {away:.3g})"


class TakenApart:
    """What can be read off an assembled graph."""

    def _assembly(self) -> Assembly:
        raise NotImplementedError

    def _frame(self, n: int) -> int:
        """The frame of the gait that is frame n of the graph."""
        return n

    def _gait(self, frames: Array) -> Gait:
        """The gait of all frames of the graph, shape (m, 4) in [rad]."""
        problem = self._assembly().problem
        return replace(problem.base, frames=frames, model=problem.model, first_step=None, last_step=None)

    @property
    def edges(self) -> tuple[GraphEdge, ...]:
        """Every edge of the graph of the last round, or of the first one before it is solved, as in `factor_graph`."""
        return edges_of(self._assembly())

    def dot(self) -> str:
        """The graph of the last round in Graphviz' language: a circle a variable, a box an edge, with their names."""
        return dot_of(self._assembly(), self._frame)

    def gait_from(self, values: gtsam.Values) -> Gait:
        """The gait of values for the graph's variables, for example edited ones, at the base gait's pace.

        It is not checked, see `verify` and `verify_step`.

        Args:
            values: a value for each variable of the graph of the last round, as `GaitGraph.initial_values` and
                `Solution.values` have them; the frames between follow.

        Raises:
            InputError: where a variable is missing, unknown, or unusable.
        """
        return self._gait(frames_from(self._assembly(), values))


def edges_of(assembly: Assembly) -> tuple[GraphEdge, ...]:
    """Views of all edges of a graph."""
    frames, style, values = assembly.state.frames, assembly.state.style, assembly.values()
    views = []
    for key, edge in assembly.keyed_edges:
        error = edge.errors(frames, style)
        views.append(GraphEdge(key.family, edge.name, edge.frames, edge.gain, error, edge.factor(), key))
    for number, factor in enumerate(assembly.problem.own):
        name = factor.edge if isinstance(factor, CheckedFactor) else type(factor).__name__
        numbers = tuple(n for n in map(frame_of_key, factor.keys()) if n is not None)
        error, gain = np.full(0, math.nan), math.nan
        if isinstance(factor, gtsam.NoiseModelFactor):
            error, gain = factor.unwhitenedError(values), _gain(factor.noiseModel())
        views.append(GraphEdge(USER, name, numbers, gain, error, factor, EdgeKey(USER, name, numbers, number)))
    return tuple(views)


def _gain(noise: gtsam.noiseModel.Base) -> float:
    """The gain of a noise model; NaN where its rows count differently."""
    if isinstance(noise, gtsam.noiseModel.Robust):
        noise = noise.noise()
    root = np.stack([noise.whiten(row) for row in np.eye(noise.dim())], -1)
    if noise.isConstrained():
        return math.inf if not np.any(noise.sigmas()) else math.nan
    same = np.allclose(root, root[0, 0] * np.eye(len(root)), rtol=1e-9, atol=0.0)
    return float(root[0, 0] ** 2) if same else math.nan


def without(assembly: Assembly, edge: GraphEdge) -> Assembly:
    """The graph without an edge, all else as it is.

    Raises:
        InputError: where the edge is not one of the graph, or one that holds its style.
    """
    gone, problem = as_instance(edge, "edge", GraphEdge), assembly.problem
    if gone.family == USER:
        own = tuple(factor for factor in problem.own if factor is not gone.factor)
        if len(own) == len(problem.own):
            raise InputError(f"edge: {gone!r} is not in this graph")
        frames = frozenset(n for factor in own for n in map(frame_of_key, factor.keys()) if n is not None)
        return replace(assembly, problem=replace(problem, own=own, own_frames=frames))
    if gone.family == "style":
        raise InputError(f"edge: {gone.name!r} belongs to the style; make the graph without style=")
    if all(key != gone._key for key, _ in assembly.keyed_edges):
        raise InputError(f"edge: {gone!r} is not in this graph")
    if gone.family == "anchor":
        anchors = {n: frame for n, frame in problem.anchors.items() if n not in gone.frames}
        fixed = {n: frame for n, frame in assembly.fixed.items() if n in anchors}
        return replace(assembly, problem=replace(problem, anchors=anchors), fixed=fixed)
    # Where a span ends a keyframe stays, so that the motion that is let go does not grow.
    always = problem.always.union(gone.frames) if gone.family == "residual" else problem.always
    return replace(assembly, problem=replace(problem, always=always, removed=problem.removed | {gone._key}))


def frames_from(assembly: Assembly, values: gtsam.Values) -> Array:
    """All frames of a gait, shape (m, 4) in [rad], from values of the graph's variables.

    Raises:
        InputError: where a variable is missing, unknown, or unusable.
    """
    given, wanted = as_instance(values, "values", gtsam.Values), assembly.values()
    for key in wanted.keys():
        name = gtsam.DefaultKeyFormatter(key)
        if not given.exists(key):
            raise InputError(f"values: no {name}, which is a variable of this graph")
        try:
            at = given.atVector(key)
        except (RuntimeError, ValueError) as error:
            raise InputError(f"values: {name} is no vector") from error
        if frame_of_key(key) is None:
            as_array(at, f"values: {name}", wanted.atVector(key).shape)
        else:
            as_angles(at, f"values: {name}", (4,))
    unknown = [gtsam.DefaultKeyFormatter(key) for key in given.keys() if not wanted.exists(key)]
    if unknown:
        raise InputError(f"values: {', '.join(unknown)} is no variable of this graph, whose frames between follow")
    free = replace(assembly, fixed={}, state=replace(assembly.state, style_held=False))
    return free.filled(given).frames


def dot_of(assembly: Assembly, frame: Callable[[int], int]) -> str:
    """A graph in Graphviz' language.

    Args:
        assembly: the graph.
        frame: the frame of the gait that is a frame of the graph.
    """
    lines = ["graph gait_graph {", "  node [fontsize=10];"]
    for n in assembly.keyframes:
        lines.append(f'  g{n} [label="g{n}\\nframe {frame(n)}"];')
    if assembly.state.style is not None:
        lines.append('  c0 [label="c0\\nstyle"];')
    for k, edge in enumerate(edges_of(assembly)):
        name = edge.name.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ")
        label = name if edge.family == edge.name else f"{edge.family}: {name}"
        lines.append(f'  e{k} [shape=box, label="{label}\\ngain {edge.gain:.4g}"];')
        for key in dict.fromkeys(edge.factor.keys()):
            lines.append(f"  e{k} -- {gtsam.DefaultKeyFormatter(key)};")
    return "\n".join([*lines, "}", ""])
