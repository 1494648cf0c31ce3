"""Chapter (h) of `pgo_analogy.py`: what odometry alone carries on for ever, one absolute fix takes back.

    pose graph                                 gait graph
    ----------------------------------------   --------------------------------------------------------------------
    drift       the odometer's errors add up   the walker starts bent, as after a box, and moves as the base gait moves
    closure     -                              end edge on g(last): fixes two of its four angles, P on the foothold
    fix         GPS and compass on x(last)     landing edges on g(last): posture and motion of the base gait's touchdown

Motion edges know differences only: whatever offset a chain starts with, or picks up, goes on to its end, and from there
into the next chain, which starts where this one ended. In a walk that is the bend of a knee that stepped over a box.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import click
import gtsam
import numpy as np
from chapters import OUT, tell_and_draw
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pgo_analogy import (
    BASE,
    END_GAIN,
    FAMILIES,
    FOOTHOLD,
    TRUE_MOTION,
    Edge,
    Numbers,
    dead_reckoning,
    distances,
    draw_path,
    drifting_odometry,
    finish_map,
    frames_as_values,
    pose_graph,
    pose_key,
    pose_path,
    show,
    solved,
)

from ggo_factors.cli.console import console
from ggo_factors.factors import anchor_factor, foothold_factor, frame_key, landing_factors, residual_factor
from ggo_factors.graph.requests import MOTION_GAIN, POSTURE_GAIN
from ggo_factors.graph.touchdown import touchdown_posture
from ggo_factors.motion.gait import swap_roles
from ggo_factors.plot import BASE_COLOUR
from ggo_factors.support.inputs import Array

FIX_NOISE = gtsam.noiseModel.Isotropic.Sigma(3, 0.01)
BENT = np.radians((20.0, 30.0, 20.0, 30.0))
"""Offset of the start frame from the base gait's: both legs in a crouch, as after a high box."""
OPEN, STEPS = 12, 4
"""Motions of the pose graph, which closes no loop, and steps of the walk."""


def fixed_pose_graph(odometry: list[gtsam.Pose2], place: gtsam.Pose2 | None) -> list[Edge]:
    """The chain of `pose_graph` without its loop closure; on request its last pose is at a known place."""
    edges = [edge for edge in pose_graph(odometry, gtsam.Pose2()) if edge[0] != "closure"]
    if place is not None:
        edges.append(("fix", gtsam.PriorFactorPose2(pose_key(len(odometry)), place, FIX_NOISE)))
    return edges


def touchdown() -> Array:
    """The touchdown posture of the base gait's own foothold, shape (4,) in [rad]."""
    posture = touchdown_posture(BASE.legs(None), BASE.frames[-1], FOOTHOLD)
    assert posture is not None
    return posture


def step_graph(start: Array, landing: bool) -> list[Edge]:
    """One step from a frame, shape (4,) in [rad], to the base gait's own foothold; on request it lands as that does."""
    last, model = len(BASE) - 1, BASE.legs(None)
    edges: list[Edge] = [("anchor", anchor_factor(0, start))]
    edges += [("motion", residual_factor(BASE.frames, first, n)) for first, n in pairwise(range(last + 1))]
    edges.append(("closure", foothold_factor(last, model, FOOTHOLD, gain=END_GAIN * len(BASE))))
    if landing:
        made = landing_factors(BASE.frames, touchdown(), POSTURE_GAIN / last, MOTION_GAIN * last)
        edges += [("fix", factor) for factor in made]
    return edges


def steps_from(start: Array, landing: bool) -> list[Array]:
    """Steps one after the other, roles swapped between them, each (n, 4) in [rad]."""
    gaits = []
    for _ in range(STEPS):
        values = solved(step_graph(start, landing), frames_as_values(BASE))
        gaits.append(np.stack([values.atVector(frame_key(n)) for n in range(len(BASE))]))
        start = swap_roles(gaits[-1][-1])
    return gaits


def off_base(gaits: list[Array]) -> Array:
    """Mean difference of the four angles from the base gait in [deg], of every frame of all steps."""
    return np.concatenate([np.degrees(np.abs(gait - BASE.frames).mean(axis=1)) for gait in gaits])


def h_an_absolute_fix_brings_it_home(pose_ax: Axes, gait_ax: Axes) -> Numbers:
    """(h) Motions alone carry every offset on; one absolute fix at the end of a chain brings it home."""
    odometry = drifting_odometry()[:OPEN]
    true = dead_reckoning([TRUE_MOTION] * OPEN)
    place, start = true.atPose2(pose_key(OPEN)), dead_reckoning(odometry)
    paths = [pose_path(solved(fixed_pose_graph(odometry, fix), start)) for fix in (None, place)]
    alone, fixed = (distances(path, pose_path(true)) for path in paths)
    show(
        ("pose graph: distance from the truth", "mean m", "last pose m"),
        [
            ("odometry alone", f"{alone.mean():.3f}", f"{alone[-1]:.3f}"),
            ("and one fix on the last pose", f"{fixed.mean():.3f}", f"{fixed[-1]:.3f}"),
        ],
        "No loop is closed here: the last pose is known by itself, as by GPS and a compass.",
    )
    draw_path(pose_ax, pose_path(true), "truth", BASE_COLOUR, "--")
    draw_path(pose_ax, paths[0], "odometry alone", "#56B4E9")
    draw_path(pose_ax, paths[1], "one fix on the last pose", FAMILIES["closure"][0])
    finish_map(pose_ax)

    bent, home = (steps_from(BASE.frames[0] + BENT, landing) for landing in (False, True))
    ends = [[float(np.degrees(np.abs(gait[-1] - BASE.frames[-1]).mean())) for gait in gaits] for gaits in (bent, home)]
    begin, motions = float(np.degrees(BENT).mean()), len(BASE) - 1
    near = float(np.degrees(np.abs(touchdown() - BASE.frames[-1]).mean()))
    names = ("anchor, residual edges, end edge", "and landing edges")
    show(
        ("gait graph: off the base gait in deg", "start", *(f"end of step {k}" for k in range(1, STEPS + 1))),
        [(name, f"{begin:.2f}", *(f"{off:.2f}" for off in each)) for name, each in zip(names, ends, strict=True)],
        "Mean of the four angles. The foothold is met every time, but fixes two angles of four; the other two are\n"
        f"what they were. {motions} residual edges in a row are as soft as one of gain 1/{motions}; against them a\n"
        f"single edge of gain {POSTURE_GAIN / motions:g} on the last frame wins within a step, and the next step\n"
        "starts as the base gait does. What stays is how the touchdown posture differs from the base gait's last\n"
        f"frame, {near:.2f}: P ends {-1e3 * BASE.endpoints()[-1, 1]:.1f} mm under the foothold there.",
    )
    at = np.concatenate([np.linspace(k, k + 1, len(BASE)) for k in range(STEPS)])
    gait_ax.plot(at, off_base(bent), color="#56B4E9", lw=2, label="residual edges alone, and the foothold")
    gait_ax.plot(at, off_base(home), color=FAMILIES["closure"][0], lw=2, label="landing edges on each last frame")
    gait_ax.set(xlabel="step", ylabel="mean difference from the base gait [deg]", ylim=(0.0, None))
    gait_ax.legend(fontsize=8, frameon=False)
    missed = max(float(np.hypot(*(BASE.legs(None).endpoint(gait[-1]) - FOOTHOLD))) for gait in bent + home)
    return {
        "mean_alone": float(alone.mean()),
        "mean_fixed": float(fixed.mean()),
        "end_alone": float(alone[-1]),
        "end_fixed": float(fixed[-1]),
        **{f"bent_{k}": off for k, off in enumerate(ends[0], start=1)},
        **{f"home_{k}": off for k, off in enumerate(ends[1], start=1)},
        "posture": near,
        "missed": missed,
    }


def run(figure: Figure) -> Numbers:
    """Print the chapter and draw both graphs side by side."""
    axes = figure.subplots(1, 2)
    console().rule(f"[bold]{(h_an_absolute_fix_brings_it_home.__doc__ or '').strip()}", align="left")
    numbers = h_an_absolute_fix_brings_it_home(*axes)
    axes[0].set_title("(h) pose graph: one fix on the last pose", loc="left", fontsize=10)
    axes[1].set_title(f"(h) gait graph: {STEPS} steps that start in a crouch", loc="left", fontsize=10)
    return numbers


@click.command()
@OUT
def main(out: Path) -> None:
    """Drift, and the fix that takes it back, in both graphs: tables on the screen and one figure, pgo_landing.png."""
    tell_and_draw(__doc__, run, (11.0, 4.8), out / "pgo_landing.png")


if __name__ == "__main__":
    main()
