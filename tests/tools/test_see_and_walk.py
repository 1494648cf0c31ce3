"""The tool of the whole loop: a simulated camera's log, a terrain, a plan, a checked walk, one scene."""

import itertools
import json

import numpy as np
import pytest
import see_and_walk
from click.testing import CliRunner
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import ggo_factors as ggo


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("loop")
    result = CliRunner().invoke(see_and_walk.main, ["--out", str(folder)], catch_exceptions=False)
    assert result.exit_code == 0
    return folder, result.output


def messages(path, topic):
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [message for _, _, _, message in reader.iter_decoded_messages(topics=[topic])]


def test_what_was_seen_is_what_is_there(made):
    seen = ggo.load_terrain(made[0] / "terrain.toml")
    true = see_and_walk.COURSE
    assert [s.x_start for s in seen.surfaces[1:]] == pytest.approx([s.x_start for s in true.surfaces[1:3]], abs=0.02)
    assert seen.rises[0] == pytest.approx(0.06, abs=0.005)
    assert [(box.x_start, box.x_end, box.height) for box in seen.boxes] == [
        pytest.approx((1.30, 1.35, 0.08), abs=0.012)
    ]
    assert [(pit.x_start, pit.x_end) for pit in seen.pits if not pit.unknown] == [pytest.approx((2.06, 2.31), abs=0.01)]


def test_the_walk_keeps_off_what_is_there_and_what_nobody_saw(made):
    seen, walk = ggo.load_terrain(made[0] / "terrain.toml"), ggo.load_walk(made[0] / "walk.csv")
    assert all(report.ok for report in walk.verify())
    x, landings = 0.0, []
    for gait in walk.gaits:
        frames = gait.frames
        dense = np.concatenate([np.linspace(one, other, 20) for one, other in itertools.pairwise(frames)])
        place = [x, sum(float(rise) for _, rise in landings)]
        ankle = np.add([walk.model.endpoint(frame) for frame in dense], place)
        over = (ankle[:, 0] > 1.30) & (ankle[:, 0] < 1.35)
        assert (ankle[over, 1] > 0.06 + 0.08).all()
        landings.append(walk.model.endpoint(frames[-1]))
        x += float(landings[-1][0])
        true_pits = see_and_walk.COURSE.pits
        assert not any(pit.x_start <= x <= pit.x_end for pit in (*seen.pits, *true_pits))
    assert x == pytest.approx(see_and_walk.GOAL, abs=0.01)


def test_cloud_ground_and_legs_are_in_one_scene(made):
    (cloud,) = messages(made[0] / "walk.mcap", "/seen/points")
    points = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 3)
    assert (cloud.header.frame_id, cloud.width) == ("map", len(points))
    x, y, z = points.T
    strip = (np.abs(y) < 0.2) & (x > 0.2) & (x < 0.55)
    assert strip.sum() > 1000
    assert np.median(z[strip]) == pytest.approx(0.0, abs=0.006)
    kerb = (np.abs(y) < 0.2) & (x > 1.55) & (x < 2.0)
    assert np.median(z[kerb]) == pytest.approx(0.06, abs=0.006)
    (scene,) = messages(made[0] / "walk.mcap", "/gait/scene")
    # The edges of a kerb that was measured are boxes too.
    box = min(scene.markers, key=lambda marker: abs(marker.pose.position.x - 1.325) + (marker.ns != "boxes"))
    assert (box.ns, box.header.frame_id) == ("boxes", "map")
    assert box.pose.position.x == pytest.approx(1.325, abs=0.01)
    assert len(messages(made[0] / "walk.mcap", "/gait/stick")) > 100


def test_its_log_is_read_by_others_and_by_the_command(made, capsys):
    clouds = messages(made[0] / "cloud.mcap", see_and_walk.CLOUD_TOPIC)
    assert [cloud.height for cloud in clouds] == [424] * 4
    from ggo_factors.cli import main

    assert main(["see", str(made[0] / "cloud.mcap"), "--frame", "odom", "--frames", "4", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["surfaces"][1]["height"] == pytest.approx(0.06, abs=0.01)
    assert (made[0] / "see_and_walk.png").stat().st_size > 50_000
    assert "probability of a hit at most" in made[1]
