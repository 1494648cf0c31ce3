"""Gait graph optimization for a reader who knows pose graphs: both built side by side, with the same words.

A *gait frame* is how both legs stand at one instant of a step: four angles, thigh and knee of the leg that supports
and of the leg that swings, and so a vector of four numbers where a pose graph has a pose. From them follows P, the
place of the swinging ankle seen from the supporting one, as the corner of a robot follows from its pose.

    pose graph                                 gait graph
    ----------------------------------------   --------------------------------------------------------------------
    variable    pose x(n)                      gait frame g(n), a vector of 4 angles in [rad]
    anchor      prior on x(0)                  the frame in which the walker stands now
    motion      odometry edge x(n) - x(n+1)    residual edge g(n) - g(n+1): move as in the base gait, a recorded step
    closure     loop closure x(0) - x(last)    end edge on g(last): P lands on this foothold
    obstacle    -                              obstacle edge: P of this frame passes over a box; a closure on the way
    knee        -                              knee edge: no knee bends backwards

A pose graph is given motions that are wrong and a closure that is right, and takes the error out. A gait graph is given
motions that are right and a closure that is "wrong", another foothold than the recorded one, and puts the error in.
The solver does not know the difference: it spreads the error over the motion edges, so evenly that no motion of the
new step feels unlike the recorded one. Read on from (a) to (g) and (i); (h), what brings a chain home that drifts, is
`pgo_landing.py`; (j) and (k), what is discrete in both, are `plan_analogy.py`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Literal

import click
import gtsam
import numpy as np
from chapters import OUT, tell_and_draw
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Rectangle
from matplotlib.ticker import MaxNLocator
from rich.table import Table

import ggo_factors as ggo
from ggo_factors.cli.console import console
from ggo_factors.factors import (
    anchor_factor,
    foothold_factor,
    frame_key,
    knee_factor,
    obstacle_factor,
    residual_factor,
)
from ggo_factors.graph.judge import optimize
from ggo_factors.graph.optimizer import graph_of
from ggo_factors.plot import ANGLE_COLOURS, ANGLE_NAMES, BASE_COLOUR, GROUND_COLOUR, OBSTACLE_COLOUR, PATH_COLOUR
from ggo_factors.support.inputs import Array

Edge = tuple[str, gtsam.NonlinearFactor]
Numbers = dict[str, float]

# Families of edges: colour and name in both graphs.
FAMILIES = {
    "anchor": ("#000000", "anchor: prior | frame that the walker stands in"),
    "motion": ("#0072B2", "motion: odometry edge | residual edge"),
    "closure": ("#D55E00", "closure: loop closure | end edge"),
    "obstacle": (OBSTACLE_COLOUR, "obstacle edge: a closure on the way"),
    "knee": ("#CC79A7", "knee edge"),
}

MOTIONS = 16
TRUE_MOTION = gtsam.Pose2(1.0, 0.0, 2.0 * np.pi / MOTIONS)  # 16 of them close a ring
ODOMETRY_NOISE = gtsam.noiseModel.Diagonal.Sigmas(np.array([0.1, 0.1, 0.02]))
CLOSURE_NOISE = gtsam.noiseModel.Isotropic.Sigma(3, 0.01)
LOOP_CLOSED, LOOP_DISPLACED = gtsam.Pose2(), gtsam.Pose2(1.2, -0.6, 0.0)

BASE = ggo.paper_base_gait()
FOOTHOLD, FOOTHOLD_DISPLACED = (0.39, 0.0), (0.4875, 0.0)  # [m]; the base gait's own, and a quarter further
END_GAIN, KNEE_GAIN = 5.0, 5.0
BOX = ggo.Obstacle(0.20, 0.25, 0.08)
BOX_MARGIN, BOX_HOLD = 0.02, 0.3  # height to spare in [m], pull towards the old place in [1/m]


# -- the two graphs ---------------------------------------------------------------------------------------------------


def pose_key(n: int) -> int:
    """The GTSAM key of a pose, `x<n>`; that of a frame is `g<n>`."""
    return int(gtsam.symbol("x", n))


def pose_graph(odometry: Sequence[gtsam.Pose2], closure: gtsam.Pose2) -> list[Edge]:
    """Anchor the first pose, add each motion, close the loop from the last pose to the first."""
    last = len(odometry)
    edges: list[Edge] = [("anchor", gtsam.PriorFactorPose2(pose_key(0), gtsam.Pose2(), hard(3)))]
    for n, motion in enumerate(odometry):
        edges.append(("motion", gtsam.BetweenFactorPose2(pose_key(n), pose_key(n + 1), motion, ODOMETRY_NOISE)))
    edges.append(("closure", gtsam.BetweenFactorPose2(pose_key(0), pose_key(last), closure, CLOSURE_NOISE)))
    return edges


def gait_graph(
    base: ggo.Gait,
    foothold: tuple[float, float],
    keyframes: Sequence[int] = (),
    lifted: Iterable[int] = (),
    knees: Iterable[int] = (),
) -> list[Edge]:
    """Anchor the first frame, add each motion of the base gait, end on the foothold; on request lift P over the box.

    Frames are variables from 0 to the last, or only the `keyframes`: then a motion spans several frames, as a
    preintegrated odometry edge does, and has a variance as many times as large.
    """
    legs, last, path = base.legs(None), len(base) - 1, base.endpoints()
    edges: list[Edge] = [("anchor", anchor_factor(0, base.frames[0]))]
    for n, following in pairwise(keyframes or range(len(base))):
        edges.append(("motion", residual_factor(base.frames, n, following)))
    for n in lifted:
        height, x = BOX.height + BOX_MARGIN, float(path[n, 0])
        edges.append(("obstacle", obstacle_factor(n, legs, height, hold=BOX_HOLD, hold_x=x)))
    edges += [("knee", knee_factor(n, KNEE_GAIN)) for n in knees]
    edges.append(("closure", foothold_factor(last, legs, foothold, END_GAIN)))
    return edges


def solved(edges: Iterable[Edge], start: gtsam.Values) -> gtsam.Values:
    """The optimum by `gtsam.DoglegOptimizer`; `optimize` adds a verdict, which GTSAM leaves to its caller."""
    outcome = optimize(graph_of(factor for _, factor in edges), start)
    if not outcome.converged:
        raise SystemExit(f"pgo_analogy: {outcome.reason}")
    return outcome.values


def drifting_odometry() -> list[gtsam.Pose2]:
    """The true motions, measured by an odometer that turns 1.5 degrees too little each time, and by noise."""
    noise = np.random.default_rng(3).normal(size=(MOTIONS, 3)) * (0.02, 0.02, np.radians(0.5))
    bias = (0.03, 0.0, np.radians(-1.5))
    return [TRUE_MOTION.compose(gtsam.Pose2(*(bias + error))) for error in noise]


def dead_reckoning(odometry: Iterable[gtsam.Pose2]) -> gtsam.Values:
    """Poses that follow from the motions alone: the start of the pose graph, as the base gait is of the gait graph."""
    values, pose = gtsam.Values(), gtsam.Pose2()
    values.insert(pose_key(0), pose)
    for n, motion in enumerate(odometry):
        pose = pose.compose(motion)
        values.insert(pose_key(n + 1), pose)
    return values


def frames_as_values(base: ggo.Gait) -> gtsam.Values:
    """The base gait as values of the gait graph's variables."""
    values = gtsam.Values()
    for n in range(len(base)):
        values.insert(frame_key(n), base.frames[n])
    return values


def motion_errors(edges: Iterable[Edge], values: gtsam.Values) -> Array:
    """What each motion edge is off by, one row an edge: (x, y, heading) of an odometry edge, else four angles."""
    motions = (factor for family, factor in edges if family == "motion")
    return np.stack([f.unwhitenedError(values) for f in motions if isinstance(f, gtsam.NoiseModelFactor)])


def hard(rows: int) -> gtsam.noiseModel.Base:
    """Noise of an edge that must hold exactly."""
    return gtsam.noiseModel.Constrained.All(rows)


# -- (a) to (g) -------------------------------------------------------------------------------------------------------


def a_closure_removes_drift(ax: Axes) -> Numbers:
    """(a) Pose graph: odometry wrong, loop closure right. The closure takes the drift out."""
    odometry = drifting_odometry()
    start, true = dead_reckoning(odometry), pose_path(dead_reckoning([TRUE_MOTION] * MOTIONS))
    values = solved(pose_graph(odometry, LOOP_CLOSED), start)
    before, after = distances(pose_path(start), true), distances(pose_path(values), true)
    rows = [("odometry alone", before), ("with the loop closure", after)]
    show(
        ("distance from the truth", "mean m", "last pose m"),
        [(name, f"{far.mean():.3f}", f"{far[-1]:.3f}") for name, far in rows],
        "The ring closes. What is left on its far side no edge has seen.",
    )
    draw_path(ax, true, "truth", BASE_COLOUR, "--")
    draw_path(ax, pose_path(start), "odometry alone", "#56B4E9")
    draw_path(ax, pose_path(values), "with the loop closure", FAMILIES["closure"][0])
    finish_map(ax)
    return {"mean_before": before.mean(), "mean_after": after.mean(), "end_before": before[-1], "end_after": after[-1]}


def b_closure_displaced(ax: Axes, errors_ax: Axes) -> Numbers:
    """(b) The same pose graph, its loop closure displaced on purpose: every odometry edge gives way by the same."""
    odometry = drifting_odometry()
    start = dead_reckoning(odometry)
    closed, bent = pose_graph(odometry, LOOP_CLOSED), pose_graph(odometry, LOOP_DISPLACED)
    values, bent_values = solved(closed, start), solved(bent, start)
    errors, bent_errors = motion_errors(closed, values), motion_errors(bent, bent_values)
    shift = np.linalg.norm(bent_errors[:, :2], axis=1)
    turn = np.degrees(np.abs(bent_errors[:, 2]))
    miss = distances(pose_path(bent_values), np.array([LOOP_DISPLACED.translation()]))[-1]
    drift_shift = np.linalg.norm(errors[:, :2], axis=1)
    show(
        ("error of an odometry edge", *SPREAD_HEADINGS),
        [
            ("(a), shift in mm", *spread(1e3 * drift_shift)),
            ("(a), turn in deg", *spread(np.degrees(np.abs(errors[:, 2])))),
            ("(b), shift in mm", *spread(1e3 * shift)),
            ("(b), turn in deg", *spread(turn)),
        ],
        f"The last pose comes within {1e3 * miss:.1f} mm of where the displaced closure wants it, and {MOTIONS} edges "
        "share the way.\nAll give way by the same shift, as the links of a chain bear the same pull. They turn by more "
        "where the pull has a\nlonger lever: a pose graph is even in the shift only. Vectors have no lever, see (c).",
    )
    draw_path(ax, pose_path(values), "closure as measured, (a)", BASE_COLOUR, "--")
    draw_path(ax, pose_path(bent_values), "closure displaced", FAMILIES["closure"][0])
    ax.plot(*LOOP_DISPLACED.translation(), "kx", ms=8, mew=2, ls="none", label="wanted last pose")
    finish_map(ax)
    draw_shares(errors_ax, {"shift": shift, "turn": turn}, "odometry edge")
    return {"ratio": ratio(shift), "ratio_drift": ratio(drift_shift), "ratio_turn": ratio(turn), "miss": miss}


def c_foothold_displaced(ax: Axes, errors_ax: Axes) -> Numbers:
    """(c) Gait graph: base gait right, foothold displaced on purpose. Every residual edge gives way by the same."""
    start, every = frames_as_values(BASE), range(1, len(BASE))
    bare, kneed = gait_graph(BASE, FOOTHOLD_DISPLACED), gait_graph(BASE, FOOTHOLD_DISPLACED, knees=every)
    values, kneed_values = solved(bare, start), solved(kneed, start)
    error = np.degrees(np.linalg.norm(motion_errors(bare, values), axis=1))
    kneed_error = np.degrees(np.linalg.norm(motion_errors(kneed, kneed_values), axis=1))
    path = foot_path(values)
    show(
        ("error of a residual edge in deg a frame", *SPREAD_HEADINGS),
        [
            ("anchor, residual edges, end edge", *spread(error)),
            ("and a knee edge on each frame", *spread(kneed_error)),
            ("the same without the first motion", *spread(kneed_error[1:])),
        ],
        f"The foot lands at {path[-1, 0]:.3f} m instead of {BASE.endpoints()[-1, 0]:.3f} m, {len(error)} edges share "
        "the way, and all give way by the same.\nA knee edge acts on frame 1, where the supporting knee of this base "
        f"gait stands at {np.degrees(BASE.frames[1, 1]):.2f} degrees, bent backwards:\na closure on the way. Between "
        "frames with an active edge of their own the error stays the same.",
    )
    draw_stick_figures(ax, values)
    ax.plot(*BASE.endpoints().T, color=BASE_COLOUR, ls="--", label="P, base gait")
    ax.plot(*path.T, color=PATH_COLOUR, lw=2, label="P, foothold displaced")
    ax.plot(*FOOTHOLD_DISPLACED, "kx", ms=8, mew=2, ls="none", label="wanted foothold")
    ax.plot(0.0, 1.1, alpha=0.0)  # room for the legend
    finish_map(ax, "upper left")
    draw_shares(errors_ax, {"without knee edges": error, "with knee edges": kneed_error}, "residual edge")
    return {
        "ratio": ratio(error),
        "ratio_kneed": ratio(kneed_error),
        "ratio_kneed_later": ratio(kneed_error[1:]),
        "error_deg": float(error.mean()),
        "landing": float(path[-1, 0]),
    }


def d_graphs_drawn(pose_ax: Axes, full_ax: Axes, keyframes_ax: Axes) -> Numbers:
    """(d) The factor graphs before they are solved: a variable is a circle, an edge a square, coloured by family."""
    odometry = drifting_odometry()
    start = dead_reckoning(odometry)
    poses = pose_graph(odometry, LOOP_CLOSED)
    draw_graph(pose_ax, poses, {pose_key(n): place for n, place in enumerate(pose_path(start))})
    drawn = {"pose graph": (start.size(), poses)}

    base = ggo.paper_base_gait(frames=17)
    path = base.endpoints()
    lifted = [n for n, x in enumerate(path[:, 0]) if BOX.x_start - 0.06 <= x <= BOX.x_end + 0.06]
    choices = {"every frame": list(range(len(base))), "keyframes": [0, *lifted, len(base) - 1]}
    for ax, (name, frames) in zip((full_ax, keyframes_ax), choices.items(), strict=True):
        edges = gait_graph(base, FOOTHOLD_DISPLACED, frames, lifted, frames[1:])
        draw_graph(ax, edges, {frame_key(n): path[n] for n in frames}, gait=True)
        drawn[f"gait graph, {name}"] = (len(frames), edges)

    counts = {name: {f: sum(f == g for g, _ in edges) for f in FAMILIES} for name, (_, edges) in drawn.items()}
    show(
        ("graphs as drawn", "variables", *FAMILIES),
        [(name, str(drawn[name][0]), *(str(n) for n in count.values())) for name, count in counts.items()],
        "Alike but for one thing: a loop closure ties the last pose to the first, an end edge ties the last frame to "
        "the ground.\nThe gait has to pass over a box as well; two frames have an obstacle edge that lifts P.",
    )
    return {f"{name}, {family}": n for name, count in counts.items() for family, n in count.items()}


def e_uncertainty(pose_ax: Axes, gait_ax: Axes) -> Numbers:
    """(e) Marginal covariances: small at the anchor and at the closure, largest between."""
    odometry = drifting_odometry()
    poses, frames = pose_graph(odometry, LOOP_CLOSED), gait_graph(BASE, FOOTHOLD_DISPLACED)
    pose_values = solved(poses, dead_reckoning(odometry))
    frame_values = solved(frames, frames_as_values(BASE))
    pose_marginals = gtsam.Marginals(graph_of(f for _, f in poses), pose_values)
    frame_marginals = gtsam.Marginals(graph_of(f for _, f in frames), frame_values)
    legs = BASE.legs(None)
    place, foot, angles = [], [], []
    for n in range(MOTIONS + 1):
        place.append(deviation(pose_marginals.marginalCovariance(pose_key(n))[:2, :2]))
    for n in range(len(BASE)):
        covariance = frame_marginals.marginalCovariance(frame_key(n))
        jacobian = legs.endpoint_jacobian(frame_values.atVector(frame_key(n)))
        foot.append(deviation(jacobian @ covariance @ jacobian.T))
        angles.append(deviation(covariance))
    curves = {"place of the pose": place, "place of P": foot, "all four angles": angles}
    shares = {name: np.array(curve) / max(curve) for name, curve in curves.items()}
    show(
        ("deviation, 1 at its largest", "anchor", "a quarter", "half way", "three quarters", "closure"),
        [(name, *(f"{c[round(k * (len(c) - 1))]:.2f}" for k in QUARTERS)) for name, c in shares.items()],
        "Gains of a gait graph are weights and not measured variances: only the shape of its curves means something.\n"
        "P is sure again at the foothold. The four angles together are not: a foothold is two numbers, and the other\n"
        "two directions stay as free as odometry without a closure. A whole pose as end edge closes them.",
    )
    draw_shares_of_largest(pose_ax, {"place of the pose": shares["place of the pose"]}, "pose")
    draw_shares_of_largest(gait_ax, {k: shares[k] for k in ("place of P", "all four angles")}, "frame")
    return {
        "pose_end": float(shares["place of the pose"][-1]),
        "pose_peak": float(np.argmax(place)) / MOTIONS,
        "foot_end": float(shares["place of P"][-1]),
        "foot_peak": float(np.argmax(foot)) / (len(BASE) - 1),
        "angles_end": float(shares["all four angles"][-1]),
    }


def f_keyframes(ax: Axes) -> Numbers:
    """(f) Preintegrated edges between keyframes against the full graph: the same answer. This time by the library."""
    numbers: Numbers = {}
    rows = []
    for task in ("longer stride", "over a box"):
        found: dict[str, ggo.Solution] = {}
        for keyframes in ("all", "auto"):
            graph = ggo.GaitGraph(BASE, keyframes="all" if keyframes == "all" else "auto")
            graph.anchor(BASE.frames[0])
            if task == "over a box":
                graph.add_obstacle(BOX)
                graph.end(FOOTHOLD, gain=END_GAIN * len(BASE))
            else:
                graph.end(FOOTHOLD_DISPLACED, gain=END_GAIN)
            began = time.perf_counter()
            found[keyframes] = graph.solve()
            spent = 1e3 * (time.perf_counter() - began)
            size, cost = len(found[keyframes].keyframes), sum(found[keyframes].costs.values())
            rows.append((f"{task}, {keyframes}", str(size), f"{spent:.0f}", f"{cost:.12f}", ""))
        apart = float(np.abs(found["auto"].gait.frames - found["all"].gait.frames).max())
        rows[-1] = (*rows[-1][:-1], f"{apart:.1e}")
        numbers |= {f"apart, {task}": apart, f"variables, {task}": len(found["auto"].keyframes)}
    show(
        ("GaitGraph(base, keyframes=...)", "variables", "ms", "objective", "largest difference rad"),
        rows,
        "Frames without an edge of their own need not be variables: their offset from the base gait lies on a straight "
        "line.\nFor vectors that is exact. For poses preintegration is so to first order only, as their motions do not "
        "commute.",
    )
    draw_offsets(ax, found["all"], found["auto"])
    return numbers


def g_without_motion_edges(ax: Axes) -> Numbers:
    """(g) Without odometry or residual edges: a singular graph, and where a solver returns something, no gait."""
    odometry = drifting_odometry()
    start, gait_start = dead_reckoning(odometry), frames_as_values(BASE)
    poses, frames = pose_graph(odometry, LOOP_DISPLACED), gait_graph(BASE, FOOTHOLD_DISPLACED)
    smooth, torn = foot_path(solved(frames, gait_start)), foot_path(without_motion(frames, gait_start))
    torn_poses = pose_path(without_motion(poses, start))
    still = int((distances(torn, BASE.endpoints()) < 1e-9).sum())
    still_poses = int((distances(torn_poses, pose_path(start)) < 1e-9).sum())
    jump, longest = steps(torn)[-1], steps(smooth).max()
    pose_jump, pose_longest = steps(torn_poses)[-1], steps(pose_path(solved(poses, start))).max()
    words = verdict(frames, gait_start)
    show(
        ("without motion edges", "variables left as they were", "last motion m", "longest motion with them m"),
        [
            ("pose graph", f"{still_poses} of {MOTIONS + 1}", f"{pose_jump:.3f}", f"{pose_longest:.3f}"),
            ("gait graph", f"{still} of {len(BASE)}", f"{jump:.3f}", f"{longest:.3f}"),
        ],
        f"Dogleg refuses the gait graph ({words}: two numbers of a foothold for four angles); Levenberg-\nMarquardt "
        "returns the numbers above. Nothing tells the frames before of the foothold, so the last one leaps: "
        f"{1e3 * jump:.0f} mm\nin {1e3 * BASE.dt:.0f} ms, {jump / BASE.dt:.1f} m/s, where the foot of (c) swings at "
        f"{longest / BASE.dt:.1f} m/s at most. GaitGraph always has its residual edges.",
    )
    ax.plot(*smooth.T, color=PATH_COLOUR, marker="o", ms=4, lw=0, label="P of each frame, (c)")
    ax.plot(*torn.T, color=FAMILIES["closure"][0], marker="o", ms=4, lw=0, label="without residual edges")
    draw_jump(ax, torn, f"{1e3 * jump:.0f} mm in {1e3 * BASE.dt:.0f} ms")
    return {
        "refused": float("singular" in words),
        "frames_still": still,
        "poses_still": still_poses,
        "jump": float(jump),
        "longest": float(longest),
    }


def i_style_is_a_calibration() -> Numbers:
    """(i) Calibration: how a person varies steps is estimated together with the frames, as an odometer's bias is."""
    phase = np.linspace(0.0, 1.0, len(BASE))[:, None]
    directions = 0.05 * np.stack(
        [np.sin(np.pi * phase + np.arange(4.0)), np.sin(2.0 * np.pi * phase + np.arange(4.0))], -1
    )
    style = ggo.Style(directions, 1e-6, 60, 1, 0.99, (5.0, 4.0), (0.7, 0.8))
    true = np.array([1.2, -0.8])
    walked = BASE.frames + directions @ true + np.radians([0.0, 15.0, 0.0, 15.0])
    base = ggo.Gait(BASE.frames + np.radians([0.0, 15.0, 0.0, 15.0]), BASE.dt, model=BASE.model)
    off = {}
    for name, known in (("residual edges alone", None), ("with the style variable c", style)):
        graph = ggo.GaitGraph(base, smoothness=100.0, style=known)
        for n in (0, 1, len(base) - 1):
            graph.anchor(walked[n], frame=n)
        solution = graph.solve().require_ok() if known is None else graph.solve()
        off[name] = float(np.degrees(np.abs(solution.gait.frames - walked).mean()))
    found = np.zeros(2) if solution.style is None else solution.style
    show(
        ("a step of which start and end are known", "mean distance from the step in deg"),
        [(name, f"{far:.2f}") for name, far in off.items()],
        f"The person walked c = ({true[0]:.2f}, {true[1]:.2f}); the graph says ({found[0]:.2f}, {found[1]:.2f}). Each "
        "motion edge is off by a linear function of c,\nas each odometry edge is of the odometer's bias: one "
        "variable, a unit prior, all motion edges tied to it.",
    )
    return {
        "without": off["residual edges alone"],
        "with": off["with the style variable c"],
        "c0": found[0],
        "c1": found[1],
    }


def without_motion(edges: Iterable[Edge], start: gtsam.Values) -> gtsam.Values:
    """What Levenberg-Marquardt, whose damping hides that a graph is singular, makes of the other edges."""
    rest = graph_of(factor for family, factor in edges if family != "motion")
    return gtsam.LevenbergMarquardtOptimizer(rest, start).optimize()


def verdict(edges: Iterable[Edge], start: gtsam.Values) -> str:
    """What Dogleg says to the other edges."""
    try:
        optimize(graph_of(factor for family, factor in edges if family != "motion"), start)
    except ggo.GraphError as error:
        return str(error).partition(":")[0].removeprefix("the graph is ")
    return "solved"


# -- numbers ----------------------------------------------------------------------------------------------------------

QUARTERS = (0.0, 0.25, 0.5, 0.75, 1.0)
SPREAD_HEADINGS = ("least", "mean", "most", "most / least")


def pose_path(values: gtsam.Values) -> Array:
    """Places of the poses in [m], shape (n, 2)."""
    return np.stack([values.atPose2(key).translation() for key in values.keys()])


def foot_path(values: gtsam.Values) -> Array:
    """P of the frames in [m], shape (n, 2)."""
    return BASE.legs(None).endpoint(np.stack([values.atVector(key) for key in values.keys()]))


def distances(path: Array, other: Array) -> Array:
    """Distance of each point from its counterpart in [m]."""
    return np.asarray(np.linalg.norm(path - other, axis=1))


def steps(path: Array) -> Array:
    """Distance between each point and the next in [m]."""
    return np.asarray(np.linalg.norm(np.diff(path, axis=0), axis=1))


def deviation(covariance: Array) -> float:
    """Root of the summed variances."""
    return float(np.sqrt(np.trace(covariance)))


def ratio(values: Array) -> float:
    """Largest to least."""
    return float(values.max() / values.min())


def spread(values: Array) -> tuple[str, ...]:
    """Least, mean, most and their ratio, as printed."""
    return (*(f"{v:.4f}" for v in (values.min(), values.mean(), values.max())), f"{ratio(values):.6f}")


def show(headings: Sequence[str], rows: Iterable[Sequence[str]], remark: str) -> None:
    """Print a small table and what it says."""
    screen = console()
    table = Table(box=None, pad_edge=False, header_style="bold")
    for n, heading in enumerate(headings):
        table.add_column(heading, justify="right" if n else "left")
    for row in rows:
        table.add_row(*row)
    screen.print(table)
    screen.print(remark + "\n", markup=False)


# -- pictures ---------------------------------------------------------------------------------------------------------


def draw_path(ax: Axes, path: Array, label: str, colour: str, style: str = "-") -> None:
    """A path of poses, its last one marked."""
    ax.plot(*path.T, color=colour, ls=style, marker=".", ms=5, label=label)
    ax.plot(*path[-1], color=colour, marker="o", ms=7, mfc="w", mew=1.8)


def finish_map(ax: Axes, legend: Literal["center", "upper left"] = "center") -> None:
    """Same scale both ways; the legend where no path is."""
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.legend(fontsize=8, frameon=False, loc=legend)


def draw_stick_figures(ax: Axes, values: gtsam.Values) -> None:
    """The legs at the first frame, half way, and at the last one."""
    joints = BASE.legs(None).joints(np.stack([values.atVector(key) for key in values.keys()]))
    for n in (0, len(joints) // 2, len(joints) - 1):
        ax.plot(*joints[n].T, color="#BBBBBB", lw=1.5, marker="o", ms=2.5, zorder=0)


def draw_shares(ax: Axes, curves: Mapping[str, Array], edge: str) -> None:
    """The error of each edge against the mean of all."""
    for (name, error), colour in zip(curves.items(), (FAMILIES["motion"][0], "#E69F00"), strict=False):
        ax.plot(np.arange(1, len(error) + 1), error / error.mean(), marker=".", color=colour, label=name)
    ax.set_ylim(0.0, 2.4)
    ax.xaxis.set_major_locator(MaxNLocator("auto", integer=True))
    ax.set_xlabel(edge)
    ax.set_ylabel("error of the edge / mean")
    ax.legend(fontsize=8, frameon=False, loc="upper right")


def draw_shares_of_largest(ax: Axes, curves: Mapping[str, Array], variable: str) -> None:
    """Standard deviation of each variable against the largest."""
    for (name, curve), colour in zip(curves.items(), (FAMILIES["motion"][0], "#E69F00"), strict=False):
        ax.plot(curve, marker=".", color=colour, label=name)
    ax.set_ylim(0.0, 1.05)
    ax.xaxis.set_major_locator(MaxNLocator("auto", integer=True))
    ax.set_xlabel(variable)
    ax.set_ylabel("deviation / largest")
    ax.legend(fontsize=8, frameon=False, loc="lower center")


def draw_offsets(ax: Axes, full: ggo.Solution, sparse: ggo.Solution) -> None:
    """Offset of every angle from the base gait: the full graph wide and pale, the keyframes as dots."""
    for c, (name, colour) in enumerate(zip(ANGLE_NAMES, ANGLE_COLOURS, strict=True)):
        ax.plot(np.degrees(full.gait.frames - BASE.frames)[:, c], color=colour, lw=5, alpha=0.3)
        keys = list(sparse.keyframes)
        ax.plot(keys, np.degrees(sparse.gait.frames - BASE.frames)[keys, c], ".-", color=colour, lw=1, label=name)
    ax.set_xlabel("frame")
    ax.set_ylabel("offset from the base gait [deg]")
    ax.legend(fontsize=8, frameon=False, ncols=2)


def draw_jump(ax: Axes, path: Array, words: str) -> None:
    """The end of the step from near, and an arrow from the last place but one to the last."""
    leap = FancyArrowPatch(
        tuple(path[-2]),
        tuple(path[-1]),
        connectionstyle="arc3,rad=-0.5",
        arrowstyle="->",
        mutation_scale=14,
        shrinkA=4.0,
        shrinkB=6.0,
        color=FAMILIES["closure"][0],
    )
    ax.add_patch(leap)
    ax.annotate(words, path[-2:].mean(axis=0), (0, -12), textcoords="offset points", ha="center", fontsize=9)
    ax.plot(*path[-1], "kx", ms=8, mew=2, ls="none", label="wanted foothold")
    ax.set_xlim(path[-1, 0] - 0.25, path[-1, 0] + 0.03)
    ax.set_ylim(-0.02, 0.085)
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.legend(fontsize=8, frameon=False, loc="upper right")


def draw_graph(ax: Axes, edges: Iterable[Edge], places: Mapping[int, Array], gait: bool = False) -> None:
    """A circle for each variable at its place; a square for each edge, at the end of a stalk or between two circles."""
    points = np.stack(list(places.values()))
    stalk = 0.14 * np.ptp(points, axis=0)
    targets: dict[str, Callable[[Array], Array]] = {
        "anchor": lambda place: place - (stalk[0] / 2, 0.0),
        "knee": lambda place: place - (0.0, stalk[1] / 2),
        "obstacle": lambda place: np.array([place[0], BOX.height + BOX_MARGIN]),
        "closure": lambda place: np.array(FOOTHOLD_DISPLACED),
    }
    for family, factor in edges:
        ends = np.stack([places[key] for key in factor.keys()])
        alone = len(ends) == 1
        if alone:
            ends = np.stack([ends[0], targets[family](ends[0])])
        colour = FAMILIES[family][0]
        ax.plot(*ends.T, color=colour, lw=1.6, zorder=1)
        ax.plot(*(ends[1] if alone else ends.mean(axis=0)), color=colour, marker="s", ms=5, zorder=3)
    ax.plot(*points.T, "o", ms=9, mfc="w", mec="k", mew=1.0, zorder=2)
    for key in (min(places), max(places)):
        symbol = gtsam.Symbol(key)
        words = f"{chr(symbol.chr())}{symbol.index()}"
        beside = (-16, -12) if gait and key == max(places) else (14, 6)
        ax.annotate(words, tuple(places[key]), beside, textcoords="offset points", ha="center", fontsize=9)
    if gait:
        width = BOX.x_end - BOX.x_start
        ax.add_patch(Rectangle((BOX.x_start, 0.0), width, BOX.height, color=GROUND_COLOUR, zorder=0))
        ax.set_xlabel("x of P [m]")
        ax.set_ylabel("y of P [m]")
    else:
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_xlabel("x [m]")
        ax.set_ylabel("y [m]")
    ax.margins(0.08)


# -- all of it --------------------------------------------------------------------------------------------------------


def run(figure: Figure) -> dict[str, Numbers]:
    """Print (a) to (g) and (i), draw the former; rows of panels: what moves, how evenly, the graphs."""
    axes = figure.subplots(3, 4)
    parts: list[tuple[Callable[..., Numbers], tuple[Axes, ...]]] = [
        (a_closure_removes_drift, (axes[0, 0],)),
        (b_closure_displaced, (axes[0, 1], axes[1, 0])),
        (c_foothold_displaced, (axes[0, 2], axes[1, 1])),
        (d_graphs_drawn, (axes[2, 0], axes[2, 1], axes[2, 2])),
        (e_uncertainty, (axes[1, 2], axes[1, 3])),
        (f_keyframes, (axes[2, 3],)),
        (g_without_motion_edges, (axes[0, 3],)),
        (i_style_is_a_calibration, ()),
    ]
    numbers = {}
    for part, panels in parts:
        console().rule(f"[bold]{(part.__doc__ or '').splitlines()[0]}", align="left")
        numbers[part.__name__[0]] = part(*panels)
    for ax, title in zip(axes.flat, TITLES, strict=True):
        ax.set_title(title, loc="left", fontsize=10)
    marks = [Line2D([], [], color=c, marker="s", ms=5, lw=1.5, label=name) for c, name in FAMILIES.values()]
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), fontsize=9, frameon=False)
    return numbers


TITLES = (
    "(a) pose graph: the closure removes drift",
    "(b) the same closure, displaced",
    "(c) gait graph: the foothold displaced",
    "(g) without residual edges: no gait",
    "(b) error of each odometry edge",
    "(c) error of each residual edge",
    "(e) uncertainty of the poses",
    "(e) uncertainty of the frames",
    "(d) pose graph, before it is solved",
    "(d) gait graph over a box, every frame",
    "(d) the same graph, keyframes only",
    "(f) full graph (pale), keyframes (dots)",
)


@click.command()
@OUT
def main(out: Path) -> None:
    """A pose graph and a gait graph side by side: tables on the screen and one figure, pgo_analogy.png."""
    tell_and_draw(__doc__, run, (18.0, 12.5), out / "pgo_analogy.png")


if __name__ == "__main__":
    main()
