"""The whole loop in one run: a depth camera's clouds in, the ground with its uncertainty, a plan, a checked walk out.

The camera is simulated (`depth_camera.py`): it is carried towards a course, and its clouds and its places are written
as a log, which is then read like any other. What comes out: `cloud.mcap`, `terrain.toml`, `walk.csv`, `walk.mcap`
with the cloud, the ground and the legs in one scene, and a picture. See `--help`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
from depth_camera import KINECT_2, Camera, look
from scipy.spatial.transform import Rotation

import ggo_factors as ggo
from ggo_factors import plot
from ggo_factors.cli.console import console
from ggo_factors.recording.export.cloud import cloud_message
from ggo_factors.recording.export.ros2_log import NANOSECONDS, header, ros2_log
from ggo_factors.support.files import replacing

COURSE = ggo.load_terrain(ggo.datasets.course())
"""The course of the demo; its kerb, its box and its pit are walked over, the stairs behind them come into view."""
PIT_DEPTHS = (0.5,)
GOAL = 2.6
"""Where the walk is to end, in [m] from its first supporting ankle."""
PLACES = (-0.9, -0.6, -0.3, 0.0)
"""Where the walker is when each cloud is taken, in [m] from where the walk begins, so that ground near it is seen."""
OFF = 0.003
"""Standard deviation of the error of the place that the log tells of the camera, forward and up, in [m]."""
REP_103 = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From x forward, y up, z right to x forward, y left, z up."""
ODOM, LENS, CLOUD_TOPIC = "odom", "camera_depth_optical_frame", "/camera/depth/points"
"""The frame in which the walk begins, that of the camera, and the topic of its clouds."""


@click.command()
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("out"), show_default=True, help="Folder to write to."
)
@click.option("--seed", type=int, default=1, show_default=True, help="Of the camera's noise.")
def main(out: Path, seed: int) -> None:
    """See a course with a simulated depth camera, plan a walk over what was seen, and make it."""
    screen = console()
    out.mkdir(parents=True, exist_ok=True)
    write_clouds(out / "cloud.mcap", seed)
    sightings = ggo.read_sightings(out / "cloud.mcap", frame=ODOM, frames=len(PLACES))
    terrain = ggo.terrain_from_sightings(sightings, std=OFF, name="course, seen")
    terrain.save(out / "terrain.toml")
    screen.print(f"{len(sightings)} clouds of {len(np.asarray(sightings[0].points))} points: {terrain!r}", markup=False)
    for shape in (*terrain.surfaces, *terrain.boxes, *terrain.pits):
        screen.print(f"  {shape}", markup=False)
    plan = ggo.plan_walk(ggo.paper_base_gait(), terrain, goal=GOAL)
    plan.walk.save(out / "walk.csv")
    ggo.export_mcap(plan.walk, out / "walk.mcap", sightings=sightings)
    draw(terrain, sightings, plan, out / "see_and_walk.png")
    worst = max(step.report.hit_probability or 0.0 for step in plan.walk.steps)
    screen.print(f"{plan!r}; probability of a hit at most {worst:.1e} a step", markup=False)
    for off in errors(terrain):
        screen.print(f"  {off}", markup=False)
    screen.print(f"wrote cloud.mcap, terrain.toml, walk.csv, walk.mcap and see_and_walk.png to {out}", markup=False)


def write_clouds(path: Path, seed: int) -> None:
    """A log of what the camera sees from each place: clouds in its own frame, and where it is by the walker's word."""
    rng = np.random.default_rng(seed)
    with ros2_log(path) as log:
        log.add_topic(CLOUD_TOPIC, "sensor_msgs/PointCloud2")
        log.add_topic("/tf", "tf2_msgs/TFMessage")
        for number, x in enumerate(PLACES):
            time = number * NANOSECONDS
            camera = replace(KINECT_2, at=(x + 0.1, 1.1, 0.0), pitch=math.radians(38.0))
            points = look(COURSE, camera, rng, PIT_DEPTHS)
            log.write("/tf", time, {"transforms": [pose(camera, rng.normal(0.0, OFF, 2).tolist(), time)]})
            log.write(CLOUD_TOPIC, time, cloud_message(points, time, LENS))


def pose(camera: Camera, off: Sequence[float], time_ns: int) -> dict[str, object]:
    """Where the camera is in the frame of the walk's start, told with an error forward and up in [m]."""
    place = REP_103 @ np.add(camera.at, [off[0], off[1], 0.0])
    turn = Rotation.from_matrix(REP_103 @ camera.axes.T).as_quat()
    return {
        "header": header(time_ns, ODOM),
        "child_frame_id": LENS,
        "transform": {
            "translation": dict(zip("xyz", map(float, place), strict=True)),
            "rotation": dict(zip("xyzw", map(float, turn), strict=True)),
        },
    }


def errors(terrain: ggo.Terrain) -> list[str]:
    """What was seen beside what is there."""
    pairs = [
        *(
            ("edge", a.x_start, b.x_start, a.edge_std)
            for a, b in zip(terrain.surfaces[1:], COURSE.surfaces[1:], strict=False)
        ),
        *(
            ("box, near edge", a.x_start, b.x_start, a.edge_std)
            for a, b in zip(terrain.boxes, COURSE.boxes, strict=False)
        ),
        *(("box, far edge", a.x_end, b.x_end, a.edge_std) for a, b in zip(terrain.boxes, COURSE.boxes, strict=False)),
        *(("box, height", a.height, b.height, a.height_std) for a, b in zip(terrain.boxes, COURSE.boxes, strict=False)),
    ]
    return [f"{what}: {1e3 * (one - other):+.1f} mm off, stated {1e3 * std:.1f} mm" for what, one, other, std in pairs]


def draw(terrain: ggo.Terrain, sightings: Sequence[ggo.Sighting], plan: ggo.Plan, path: Path) -> None:
    """The points, the ground that was made of them, and the legs on their way over it."""
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(
        2, 1, figsize=(12.0, 7.5), layout="constrained", gridspec_kw={"height_ratios": (1.0, 2.4)}
    )
    plot.plot_seen(terrain, sightings, ax=above)
    plot.plot_stick_figure(plan.walk, frames=5, ax=below)
    above.set_xlim(below.get_xlim())
    above.set_ylim(-0.25, 0.3)
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=150, bbox_inches="tight")
    pyplot.close(figure)


if __name__ == "__main__":
    main()
