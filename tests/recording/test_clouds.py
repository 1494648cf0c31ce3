"""Point clouds in MCAP as drivers of depth cameras write them."""

import math

import numpy as np
import pytest
from cloud_files import CLOUD_TEXT, CLOUD_TYPE, camera_pose, cloud_message, tf_message, write_clouds
from depth_camera import KINECT_2
from log_files import START_NS, write_messages
from mcap.writer import CompressionType
from seen_scenes import Scene

import ggo_factors as ggo
from ggo_factors import InputError, LogError, Terrain, read_sightings, terrain_from_points, terrain_from_sightings
from ggo_factors.recording.clouds import read_clouds
from ggo_factors.recording.transforms import Transforms

SCENE = Scene(Terrain.level(1.0) + Terrain.level(5, rise=0.1), (), (), KINECT_2, 1)
POINTS = SCENE.points()
FEW = np.array([[0.1, -0.2, 1.5], [np.nan, np.nan, np.nan], [1e-3, 7.0, 3.25]], np.float32)
AHEAD = {"up": [0.0, -1.0, 0.0], "heading": [0.0, 0.0, 1.0]}


def log_of(path, *messages, **options):
    return write_clouds(
        path / "clouds.mcap", [(START_NS + n * 10**8, data) for n, data in enumerate(messages)], **options
    )


@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("colour", [False, True])
def test_points_are_read_to_the_bit(tmp_path, kind, big, colour):
    log = log_of(tmp_path, cloud_message(FEW, kind=kind, big=big, colour=colour))
    (cloud,) = read_clouds(log).clouds
    assert cloud.points.dtype == kind
    assert np.array_equal(cloud.points, FEW.astype(kind), equal_nan=True)
    assert (cloud.frame, cloud.time_ns) == ("camera", START_NS)


def test_an_organised_cloud_keeps_its_rows_and_padding_is_no_point(tmp_path):
    organised = np.arange(4 * 5 * 3, dtype=np.float32).reshape(4, 5, 3)
    (cloud,) = read_clouds(log_of(tmp_path, cloud_message(organised, pad=20))).clouds
    assert np.array_equal(cloud.points, organised)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD])
def test_a_whole_frame_gives_the_terrain_of_its_points(tmp_path, compression):
    log = log_of(tmp_path, cloud_message(POINTS), compression=compression)
    (sighting,) = read_sightings(log, **SCENE.told())
    assert terrain_from_sightings([sighting]) == terrain_from_points(POINTS, **SCENE.told())


def test_where_the_camera_is_comes_from_the_transforms(tmp_path):
    place, turn = camera_pose(SCENE.camera)
    half = math.sqrt(0.5)
    # Through a mount that is turned, below a base that moves in the frame of the start.
    moves = [
        (START_NS, tf_message([("odom", "base", place - [0.0, 0.0, 0.5], [0.0, 0.0, 0.0, 1.0])])),
        (START_NS, tf_message([("/base", "mount", [0.0, 0.0, 0.5], [half, 0.0, 0.0, half])])),
        (START_NS, tf_message([("mount", "camera", [0.0, 0.0, 0.0], after(half, turn))])),
        (
            START_NS + 10**9,
            tf_message([("odom", "base", np.add(place, [9.0, 0.0, 0.0]), [0.0, 0.0, 0.0, 1.0])], START_NS + 10**9),
        ),
    ]
    log = log_of(tmp_path, cloud_message(POINTS), transforms=moves)
    (sighting,) = read_sightings(log, frame="odom")
    for name, value in SCENE.told().items():
        assert getattr(sighting, name) == pytest.approx(value, abs=1e-9), name


def after(half, turn):
    """The rotation that, after a quarter turn about x, gives `turn`."""
    from scipy.spatial.transform import Rotation

    return (Rotation.from_quat([half, 0.0, 0.0, half]).inv() * Rotation.from_quat(turn)).as_quat()


def test_clouds_are_taken_evenly_over_the_log(tmp_path):
    clouds = [cloud_message(FEW + n, ns=START_NS + n) for n in (3, 0, 1, 4, 2)]
    log = log_of(tmp_path, *clouds)
    told = [read_sightings(log, frames=n, **AHEAD) for n in (1, 3, 9)]
    firsts = [[float(one.points[0, 0]) for one in sightings] for sightings in told]
    assert firsts == [pytest.approx([0.1]), pytest.approx([0.1, 2.1, 4.1]), pytest.approx([0.1, 1.1, 2.1, 3.1, 4.1])]


@pytest.mark.parametrize(
    ("message", "says"),
    [
        (cloud_message(FEW, names=("x", "y", "depth")), "has no field z; its fields are x, y, depth, rgb"),
        (cloud_message(np.ones((3, 3)), kind="i2"), r"field x of type 3; FLOAT32 \(7\) and FLOAT64 \(8\) are read"),
        (cloud_message(FEW)[:-40], "claims 96 elements of data at byte"),
        (b"\x00\x01\x00\x00", "ends at byte 4"),
    ],
)
def test_a_log_whose_clouds_cannot_be_read_says_why(tmp_path, message, says):
    with pytest.raises(LogError, match=says):
        read_clouds(log_of(tmp_path, message))


def test_one_damaged_cloud_does_not_hide_the_others(tmp_path):
    log = log_of(tmp_path, cloud_message(FEW)[:-40], cloud_message(FEW))
    assert len(read_clouds(log).clouds) == 1


def test_a_cloud_that_says_it_is_larger_than_it_is(tmp_path):
    data = bytearray(cloud_message(FEW))
    at = data.index((3).to_bytes(4, "little"), 20)
    data[at : at + 4] = (4000).to_bytes(4, "little")
    with pytest.raises(LogError, match="says it has 1 rows of 4000 points of 32 bytes, and holds 96 bytes"):
        read_clouds(log_of(tmp_path, bytes(data)))


def test_an_empty_cloud_is_no_points(tmp_path):
    log = log_of(tmp_path, cloud_message(np.empty((0, 3), np.float32)))
    with pytest.raises(InputError, match="points: there are none"):
        read_sightings(log, **AHEAD)


def test_what_must_be_told_is_asked_for(tmp_path):
    bare = log_of(tmp_path, cloud_message(FEW))
    with pytest.raises(InputError, match=r"give the frame of the foot, or up= and heading="):
        read_sightings(bare)
    with pytest.raises(LogError, match=r"frame 'odom' is not joined .* has no transforms"):
        read_sightings(bare, frame="odom")
    with pytest.raises(InputError, match="give it, or them"):
        read_sightings(bare, frame="odom", **AHEAD)
    moved = write_clouds(
        tmp_path / "moved.mcap",
        [(START_NS, cloud_message(FEW))],
        [(START_NS, tf_message([("odom", "camera", [0, 0, 1], [0, 0, 0, 1])]))],
    )
    with pytest.raises(InputError, match=r"the log has odom, camera"):
        read_sightings(moved)
    with pytest.raises(LogError, match="the log's frames are odom, camera"):
        read_sightings(moved, frame="map")


def test_two_topics_need_a_choice_and_other_logs_have_no_clouds(tmp_path):
    channels = dict.fromkeys(("/left", "/right"), (CLOUD_TYPE, CLOUD_TEXT, "ros2msg", "cdr"))
    data = [(name, START_NS, START_NS, cloud_message(FEW + n)) for n, name in enumerate(channels)]
    log = write_messages(tmp_path / "two.mcap", channels, data)
    with pytest.raises(LogError, match=r"choose one with topic= \(/left, /right\)"):
        read_clouds(log)
    assert read_clouds(log, topic="/right").clouds[0].points[0, 0] == pytest.approx(1.1)
    with pytest.raises(LogError, match="holds no sensor_msgs/PointCloud2 on topic '/up'"):
        read_clouds(log, topic="/up")
    other = write_messages(
        tmp_path / "json.mcap", {"/c": (CLOUD_TYPE, "", "jsonschema", "json")}, [("/c", 0, 0, b"{}")]
    )
    with pytest.raises(LogError, match="encoding 'json', and clouds are read from 'cdr' alone"):
        read_clouds(other)


def test_an_export_wants_to_know_where_the_points_are(tmp_path):
    walk = ggo.walk(ggo.paper_base_gait(), [ggo.Step((0.39, 0.0))])
    with pytest.raises(InputError, match="sightings: each needs its at"):
        ggo.export_mcap(walk, tmp_path / "walk.mcap", sightings=[ggo.Sighting(FEW, **AHEAD)])
    assert not list(tmp_path.iterdir())


def test_frames_in_a_circle_are_refused():
    transforms = Transforms()
    for parent, child in (("a", "b"), ("b", "a")):
        transforms.add(0, parent, child, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))
    with pytest.raises(LogError, match="go round in a circle"):
        transforms.between("a", "b", 0)


def test_a_pose_is_the_last_one_before_the_time_and_nonsense_is_none():
    transforms = Transforms()
    for time, x in ((20, 2.0), (10, 1.0), (30, np.nan)):
        transforms.add(time, "odom", "camera", np.array([x, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 2.0]))
    transforms.add(40, "odom", "camera", np.ones(3), np.zeros(4))
    places = [transforms.between("camera", "odom", time)[0, 3] for time in (0, 10, 19, 20, 50)]
    assert places == [1.0, 1.0, 1.0, 2.0, 2.0]
    assert transforms.between("odom", "camera", 50)[0, 3] == -2.0
