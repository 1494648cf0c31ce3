"""From real recordings to every kind of gait. Needs the folder of recordings."""

import json
from dataclasses import replace

import numpy as np
import pytest
from independent import clearance, densely, least_knee_deg, path_of, stair_clearance, way_over

import ggo_factors as ggo

LEVEL = ["level_csic_s10", "level_nonan_middle", "level_opensim_rajagopal", "level_opensim_subject01"]
OBSTACLES = [(0.20, 0.25, 0.08), (0.20, 0.25, 0.15), (0.12, 0.16, 0.08), (0.12, 0.16, 0.15), (-0.33, -0.29, 0.175)]


def joint_map(truth):
    """The map that stands in a log's truth, as TOML."""
    lines = [f'units = "{truth["units"]}"']
    for angle, terms in truth["joint_map"].items():
        lines += [f"[{angle}]", *(f'"{name}" = {float(factor)}' for name, factor in terms.items())]
    return "\n".join(lines)


@pytest.fixture(scope="module", params=LEVEL)
def imported(request, recordings, tmp_path_factory):
    truth = json.loads((recordings / f"{request.param}.json").read_text())
    path = tmp_path_factory.mktemp("maps") / "map.toml"
    path.write_text(joint_map(truth))
    report = ggo.import_base_gait(recordings / f"{request.param}.mcap", joints=path, min_strides=1)
    return truth, report


def test_strides_are_found_as_stated(imported):
    truth, report = imported
    low, high = truth["strides_per_leg"]
    for leg in ("left", "right"):
        assert low <= sum(stride.leg == leg for stride in report.used) <= high
    assert report.stride_time[0] == pytest.approx(truth["stride_time_s"], abs=0.03)


def test_base_gait_stands_on_the_ground_and_repeats(imported):
    _, report = imported
    gait = report.gait
    assert ggo.verify(gait).ok
    np.testing.assert_allclose(gait.endpoints()[[0, -1], 1], 0.0, atol=1e-6)
    np.testing.assert_allclose(gait.swapped().frames[-1], gait.frames[0], atol=1e-9)


def test_every_kind_of_gait_from_it(imported):
    base = replace(imported[1].gait, model=ggo.LegModel(0.39, 0.39))
    for stride in (0.975, 0.585):
        second = path_of(ggo.adjust_stride(base, stride).gaits[1].frames)
        np.testing.assert_allclose(second[[0, -1], 0], [-stride / 2, stride / 2], atol=1e-3)
    for box in OBSTACLES:
        try:
            frames = ggo.step_over(base, [ggo.Obstacle(*box)], foothold=(0.39, 0.0)).gait.frames
        except ggo.InfeasibleGaitError:
            assert not way_over(base.frames, box, (0.39, 0.0))
            continue
        assert clearance(frames, *box) > 0.0
        assert np.hypot(*(path_of(frames)[-1] - [0.39, 0.0])) < 1e-3
        assert least_knee_deg(frames) > -0.3
        assert path_of(densely(frames))[:, 1].min() > -1e-3
    for sign, procedure in ((1, ggo.climb_stairs), (-1, ggo.descend_stairs)):
        for number, gait in enumerate(procedure(base, 0.10).gaits):
            edges, heights = np.array([0.29, 0.68]) - 0.39 * number, sign * 0.10 * (np.arange(3) - number)
            assert stair_clearance(gait.frames, edges, heights) > 0.005
            np.testing.assert_allclose(path_of(gait.frames)[-1], [0.39, sign * 0.10], atol=1e-3)


def test_the_search_that_backs_a_refusal():
    base = ggo.paper_base_gait()
    for box in OBSTACLES:
        assert way_over(base.frames, box, (0.39, 0.0))
    assert not way_over(base.frames, (0.15, 0.20, 0.9), (0.39, 0.0))
    assert not way_over(base.frames, (0.2, 0.25, 0.1), (1.2, 0.0))
