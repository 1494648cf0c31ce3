"""`ggo see`: a depth camera's point clouds to a terrain file."""

from __future__ import annotations

import json
from dataclasses import asdict

import click

import ggo_factors as ggo
from ggo_factors.cli.flags import JSON, LARGEST_CHUNK, Numbers
from ggo_factors.cli.output import PICTURES, require_ending, save_figure, say_written
from ggo_factors.seeing.terrain_seen import STD


@click.command()
@click.argument("cloud", metavar="CLOUD", type=click.Path())
@click.option("--topic", help="Topic of the clouds; may be left out where one alone has any.")
@click.option("--frame", help="Frame with x forward and z up under the supporting foot, by the log's /tf.")
@click.option("--up", type=Numbers("X,Y,Z"), help="In place of --frame: against gravity, in the camera's frame.")
@click.option("--heading", type=Numbers("X,Y,Z"), help="In place of --frame: where the walk goes.")
@click.option(
    "--at", type=Numbers("X,Y,Z"), help="Ground under the supporting ankle in m; under the camera if left out."
)
@click.option("--frames", type=int, default=1, show_default=True, help="So many clouds, evenly spaced, are fused.")
@click.option(
    "--std", type=float, default=STD, show_default=True, help="What all points of a cloud are off by in common, in m."
)
@click.option("-o", "--output", type=click.Path(), help="Write the terrain as TOML.")
@click.option("--picture", type=click.Path(), help="Draw the terrain over the points.")
@LARGEST_CHUNK
@JSON
def see(
    cloud: str,
    topic: str | None,
    frame: str | None,
    up: tuple[float, float, float] | None,
    heading: tuple[float, float, float] | None,
    at: tuple[float, float, float] | None,
    frames: int,
    std: float,
    output: str | None,
    picture: str | None,
    largest_chunk: int,
    as_json: bool,
) -> None:
    """Make a terrain of what a depth camera saw.

    CLOUD is an MCAP file or a rosbag2 folder with sensor_msgs/PointCloud2 in the camera's own frame. What was not seen
    carries no foot.
    """
    if output is not None:
        require_ending(output, (".toml",))
    if picture is not None:
        require_ending(picture, PICTURES)
    sightings = ggo.read_sightings(
        cloud, topic=topic, frame=frame, up=up, heading=heading, at=at, frames=frames, largest_chunk=largest_chunk
    )
    terrain = ggo.terrain_from_sightings(sightings, std=std)
    if picture is not None:
        from ggo_factors.plot import plot_seen

        save_figure(plot_seen(terrain, sightings), picture)
    if output is not None:
        terrain.save(output)
    if as_json:
        click.echo(json.dumps({"format_version": 1, **asdict(terrain)}, indent=1))
    else:
        for line in (*map(_line, terrain.surfaces), *map(str, terrain.boxes), *map(_line, terrain.pits)):
            click.echo(line)
    say_written(output, as_json)


def _line(shape: ggo.Surface | ggo.Gap) -> str:
    spread = ""
    if isinstance(shape, ggo.Surface):
        edge = f"edge \u00b1 {1e3 * shape.edge_std:.1f} mm, " if shape.edge_std else ""
        spread = f" ({edge}height \u00b1 {1e3 * shape.height_std:.1f} mm)"
    elif not shape.unknown:
        spread = f" (edges \u00b1 {1e3 * shape.edge_std:.1f} mm)"
    return f"{shape}{spread}"
