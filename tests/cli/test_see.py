"""`ggo see`, and the picture of what was seen."""

import json

import numpy as np
import pytest
from cloud_files import camera_pose, cloud_message, tf_message, write_clouds
from depth_camera import KINECT_2
from log_files import START_NS
from matplotlib import pyplot
from matplotlib.patches import Rectangle
from seen_scenes import Scene

from ggo_factors import Gap, InputError, Obstacle, Sighting, Surface, Terrain, load_terrain, terrain_from_points
from ggo_factors.cli import main
from ggo_factors.plot import plot_seen

GROUND = Terrain.level(1.0) + Terrain.level(5, rise=0.1)
SCENE = Scene(GROUND.with_boxes(Obstacle(1.6, 1.7, 0.12)), (), (), KINECT_2, 1)
POINTS = SCENE.points()


@pytest.fixture
def log(tmp_path):
    pose = tf_message([("odom", "camera", *camera_pose(SCENE.camera))])
    path = tmp_path / "cloud.mcap"
    return str(write_clouds(path, [(START_NS, cloud_message(POINTS))], [(START_NS, pose)]))


def test_a_log_becomes_a_terrain_and_a_picture(log, tmp_path, capsys):
    toml, picture = tmp_path / "seen.toml", tmp_path / "seen.png"
    assert main(["see", log, "--frame", "odom", "-o", str(toml), "--picture", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "level from 0 to " in said
    assert "unknown ground" in said
    assert f"wrote {toml}" in said
    told = terrain_from_points(POINTS, **SCENE.told())
    written = load_terrain(toml)
    assert len(written.boxes) == 1
    for one, other in zip(told.surfaces, written.surfaces, strict=True):
        assert (one.x_start, one.height) == pytest.approx((other.x_start, other.height), abs=1e-6)
    assert picture.stat().st_size > 10_000


def test_directions_in_place_of_a_frame_and_json(log, capsys):
    numbers = {name: ",".join(map(repr, map(float, value))) for name, value in SCENE.told().items()}
    flags = [f"--{name}={value}" for name, value in numbers.items()]
    assert main(["see", log, *flags, "--std", "0.01", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["format_version"] == 1
    assert told["surfaces"][1]["height_std"] >= 0.01
    assert [pit["unknown"] for pit in told["pits"]] == [True] * len(told["pits"])


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        ([], "give the frame of the foot (the log has odom, camera), or --up and --heading"),
        (["--frame", "map"], "frame 'map' is not joined to 'camera'"),
        (["--frame", "odom", "--topic", "/up"], "on topic '/up'"),
        (["--frame", "odom", "--frames", "0"], "--frames: 0 must be at least 1"),
        (["--frame", "odom", "-o", "seen.csv"], "must end in .toml"),
        (["--frame", "odom", "--picture", "seen.bmp"], "must end in .png"),
        (["--up", "0,0"], "expected X,Y,Z"),
    ],
)
def test_one_line_says_what_is_wrong(log, flags, says, capsys):
    assert main(["see", log, *flags]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert len(error.splitlines()) == 1


def test_the_picture_shows_each_part_where_it_is():
    terrain = Terrain(
        (Surface(0, 1, 0.0), Surface(1, 3, 0.1, 0.0, 0.004, 0.003)),
        (Obstacle(1.4, 1.5, 0.2, 0.005, 0.003),),
        (Gap(2.0, 2.3, 0.004), Gap(2.6, 2.8, unknown=True)),
    )
    ax = plot_seen(terrain, [Sighting(POINTS, **SCENE.told())])
    shapes = [patch.get_bbox().extents for patch in ax.patches if isinstance(patch, Rectangle)]
    assert [pytest.approx(list(shape)) for shape in shapes] == [
        [2.0, 0.02, 2.3, 0.1],
        [2.6, 0.02, 2.8, 0.1],
        [1.4, 0.1, 1.5, 0.3],
    ]
    lines = [line.get_xydata().tolist() for line in ax.lines if line.get_gid() is None]
    assert [[0, 0], [1, 0]] in lines
    assert [[1, 0], [1, 0.1]] in lines
    (dots,) = [line for line in ax.lines if line.get_gid() == "points"]
    assert len(dots.get_xdata()) > 5000
    legend = [text.get_text() for text in ax.get_legend().get_texts()]
    assert legend == ["ground", "points seen", "box", "pit", "nobody saw it", "95 % interval"]
    assert np.ptp(ax.get_xlim()) == pytest.approx(3.1)
    pyplot.close(ax.figure)
    with pytest.raises(InputError, match="terrain: expected a Terrain"):
        plot_seen(GROUND.surfaces)
