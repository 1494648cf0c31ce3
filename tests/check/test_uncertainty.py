"""Obstacles measured with an error: the cautious box, the probability of a hit, and what the check says of it."""

import json
import math
from statistics import NormalDist

import numpy as np
import pytest
from bare_bones import pointed
from hypothesis import given
from hypothesis import strategies as st
from independent import densely, hit_share, path_of

import ggo_factors as ggo
from ggo_factors.check.uncertainty import HIT_PROBABILITY
from ggo_factors.cli import main

BASE = ggo.paper_base_gait()
BOX = ggo.Obstacle(0.20, 0.25, 0.06)
below = NormalDist().cdf


def uncertain(box, edge_std=0.0, height_std=0.0):
    return ggo.Obstacle(box.x_start, box.x_end, box.height, edge_std, height_std)


@pytest.fixture(scope="module")
def over():
    """A gait made as if the box were known to the millimetre."""
    return ggo.step_over(pointed(BASE), [BOX], foothold=(0.39, 0.0)).gait


# -- the obstacle ---------------------------------------------------------------------------------------------------


def test_an_obstacle_keeps_its_errors():
    box = uncertain(BOX, 0.01, 0.02)
    for other in (box.shifted(0.1, 0.02), box.for_ankle(ggo.Foot(0.08, 0.05, 0.15))):
        assert (other.edge_std, other.height_std) == (0.01, 0.02)
    assert str(box) == "box from 0.2 to 0.25 m, 0.06 m high (edges ± 0.01, height ± 0.02 m)"
    assert str(BOX) == "box from 0.2 to 0.25 m, 0.06 m high"


@pytest.mark.parametrize(
    ("stds", "message"),
    [
        ((-0.01, 0.0), "edge_std: -0.01 m must be at least 0 m"),
        ((0.0, math.nan), "height_std: nan m is not finite"),
        ((5.0, 0.0), "edge_std: 5 m must be at most 0.1 m"),  # millimetres
    ],
)
def test_errors_are_checked(stds, message):
    with pytest.raises(ggo.InputError, match=message):
        uncertain(BOX, *stds)


def test_a_walk_file_keeps_the_errors_and_has_none_where_there_are_none(tmp_path):
    step = ggo.Step((0.39, 0.0), (BOX, uncertain(BOX, 0.01), uncertain(BOX, 0.0, 0.02)))
    ggo.Walk((BASE,), (step,)).save(tmp_path / "walk.csv")
    assert ggo.load_walk(tmp_path / "walk.csv").plan[0].obstacles == step.obstacles
    (line,) = [line for line in (tmp_path / "walk.csv").read_text().splitlines() if line.startswith("# step 1: ")]
    written = json.loads(line.removeprefix("# step 1: "))["obstacles_m"]
    assert written == [[0.2, 0.25, 0.06], [0.2, 0.25, 0.06, 0.01, 0.0], [0.2, 0.25, 0.06, 0.0, 0.02]]


# -- the cautious box -----------------------------------------------------------------------------------------------


def test_a_box_on_lower_ground_stays_there():
    box = ggo.Obstacle(0.2, 0.25, -0.1, edge_std=0.01, height_std=0.01, base=-0.2)
    larger = ggo.cautious(box)
    assert larger.base == box.base
    assert larger.height > box.height


def test_a_known_box_is_its_own_cautious_box():
    assert ggo.cautious(BOX) is BOX
    assert ggo.all_cautious([BOX, BOX], 1e-9) == (BOX, BOX)


@pytest.mark.parametrize("stds", [(0.02, 0.0), (0.0, 0.02), (0.01, 0.02)])
@pytest.mark.parametrize("probability", [0.3, 0.02])
def test_the_true_box_sticks_out_of_the_cautious_one_as_often_as_allowed(stds, probability):
    box, draws = ggo.Obstacle(0.2, 0.5, 0.1, *stds), 1_000_000
    held = ggo.cautious(box, probability)
    assert not held.is_uncertain
    errors = np.random.default_rng(3).standard_normal((3, draws))
    near, far = np.array([[0.2], [0.5]]) + stds[0] * errors[:2]
    out = (near < held.x_start) | (far > held.x_end) | (0.1 + stds[1] * errors[2] > held.height)
    # As wide a box needs no share for an edge that passes the other end: half of the edges' shares is not used up.
    used = probability if stds[0] == 0.0 else 0.5 * probability if stds[1] == 0.0 else 2.0 / 3.0 * probability
    assert out.mean() <= probability
    assert out.mean() == pytest.approx(used, rel=0.15)


def test_a_box_on_lower_ground_is_cautious_there_too():
    low = ggo.Obstacle(0.20, 0.25, -0.10, 0.01, 0.01, base=-0.16)
    wide = ggo.cautious(low)
    assert wide.base == -0.16
    assert -0.10 < wide.height < -0.05


def test_a_post_thinner_than_its_error_lies_in_its_cautious_box():
    post = ggo.Obstacle(0.200, 0.201, 0.1, 0.02)
    held = ggo.cautious(post, 0.02)
    errors = 0.02 * np.random.default_rng(4).standard_normal((2, 1_000_000))
    edges = np.array([[0.200], [0.201]]) + errors
    out = ((edges < held.x_start) | (edges > held.x_end)).any(axis=0).mean()
    assert 0.015 < out <= 0.02


def test_several_boxes_share_the_probability():
    box = uncertain(BOX, 0.01, 0.01)
    assert ggo.all_cautious([box, BOX, box], 1e-3) == (ggo.cautious(box, 5e-4), BOX, ggo.cautious(box, 5e-4))


@pytest.mark.parametrize("probability", [0.0, -0.1, 1.1, math.nan])
def test_probability_is_checked(probability):
    with pytest.raises(ggo.InputError, match="probability: "):
        ggo.cautious(BOX, probability)


# -- the probability of a hit -----------------------------------------------------------------------------------------

LEVEL = [(-1.0, 0.1), (1.0, 0.1)]
WALL = [(-1.0, 0.0), (0.1, 0.0), (0.1, 1.0), (1.0, 1.0)]


def test_a_level_path_is_hit_by_what_is_higher():
    for height, std in ((0.08, 0.01), (0.1, 0.02), (0.05, 0.01)):
        box = ggo.Obstacle(0.2, 0.3, height, 0.0, std)
        assert ggo.hit_probability(box, LEVEL) == pytest.approx(1.0 - below((0.1 - height) / std), rel=1e-6, abs=1e-15)
    # Where it lies makes no difference to a path that is level all along.
    assert ggo.hit_probability(ggo.Obstacle(0.2, 0.201, 0.08, 0.05, 0.01), LEVEL) == pytest.approx(1.0 - below(2.0))


def test_a_wall_is_hit_by_either_edge_before_it():
    box = ggo.Obstacle(0.12, 0.14, 0.2, 0.01, 0.0)
    free = below(2.0) * below(4.0)
    assert ggo.hit_probability(box, WALL) == pytest.approx(1.0 - free, rel=1e-6)
    # A height that may be under the low part, and never over the high one.
    low = ggo.Obstacle(0.12, 0.14, 0.02, 0.01, 0.02)
    assert ggo.hit_probability(low, WALL) == pytest.approx(below(1.0) * (1.0 - free), rel=1e-6)


def test_beside_the_path_there_is_no_hit():
    assert ggo.hit_probability(ggo.Obstacle(1.2, 1.3, 5.0, 0.01, 0.01), LEVEL) < 1e-15
    assert ggo.hit_probability(ggo.Obstacle(1.02, 1.3, 5.0, 0.01, 0.0), LEVEL) == pytest.approx(1.0 - below(2.0))


def test_what_is_known_is_hit_or_not():
    assert ggo.hit_probability(ggo.Obstacle(0.2, 0.3, 0.09), LEVEL) == 0.0
    assert ggo.hit_probability(ggo.Obstacle(0.2, 0.3, 0.11), LEVEL) == 1.0
    assert ggo.hit_probability(ggo.Obstacle(0.2, 0.3, 0.10), LEVEL) == 0.0  # touched


def test_a_path_that_turns_back_counts_where_it_is_lowest():
    loop = [(0.0, 0.0), (-0.1, 0.05), (-0.1, 0.2), (0.3, 0.05), (0.2, 0.02), (0.2, 0.0)]
    box = ggo.Obstacle(0.25, 0.4, 0.04, 0.0, 0.01)
    fine = np.stack([np.interp(np.linspace(0, 5, 5001), np.arange(6), column) for column in np.array(loop).T], -1)
    # Lowest over the box: at its near edge on the way back, half way from (0.3, 0.05) to (0.2, 0.02).
    assert ggo.hit_probability(box, fine) == pytest.approx(1.0 - below(-0.5), abs=1e-3)


@pytest.mark.parametrize("path", [[(0.0, 0.0)], [0.0, 1.0], [(0.0, math.inf), (1.0, 0.0)]])
def test_a_path_is_checked(path):
    with pytest.raises(ggo.InputError, match="path: "):
        ggo.hit_probability(BOX, path)


@pytest.mark.parametrize(
    ("box", "stds"),
    [
        ((0.20, 0.25, 0.06), (0.02, 0.02)),
        ((0.20, 0.25, 0.09), (0.0, 0.01)),
        ((0.20, 0.25, 0.09), (0.001, 0.02)),
        ((0.200, 0.205, 0.09), (0.02, 0.0)),
        ((0.30, 0.34, 0.02), (0.02, 0.02)),  # near the landing
        ((-0.42, -0.36, 0.02), (0.02, 0.02)),  # where the foot is lifted, drawn back at first
        ((0.20, 0.25, 0.06), (0.01, 0.005)),
    ],
)
def test_against_100_000_draws(over, box, stds):
    path = path_of(densely(over.frames, 4000))
    expected = hit_share(path, box, *stds)
    found = ggo.hit_probability(ggo.Obstacle(*box, *stds), path[::8])
    assert found == pytest.approx(expected, abs=4.0 * math.sqrt(expected / 100_000) + 5e-4)


@given(
    start=st.floats(-0.5, 0.5),
    width=st.floats(0.001, 0.2),
    height=st.floats(0.0, 0.2),
    edge_std=st.sampled_from([0.0, 1e-6, 0.001, 0.02, 0.1]),
    height_std=st.sampled_from([0.0, 1e-6, 0.001, 0.02, 0.1]),
)
def test_a_larger_box_is_never_hit_less(over, start, width, height, edge_std, height_std):
    path = path_of(densely(over.frames, 500))
    box = ggo.Obstacle(start, start + width, height, edge_std, height_std)
    larger = ggo.Obstacle(start - 0.01, start + width + 0.01, height + 0.01, edge_std, height_std)
    found = ggo.hit_probability(box, path)
    assert 0.0 <= found <= ggo.hit_probability(larger, path) + 1e-4 <= 1.0 + 1e-4


# -- generated gaits and the check ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("box", "stds"),
    [
        ((0.20, 0.25, 0.06), (0.005, 0.005)),
        ((0.20, 0.25, 0.08), (0.02, 0.02)),
        ((0.12, 0.16, 0.08), (0.01, 0.02)),
        ((0.15, 0.155, 0.10), (0.02, 0.0)),
        ((0.20, 0.25, 0.08), (0.0, 0.02)),
    ],
)
@pytest.mark.parametrize("hard", [False, True])
def test_a_gait_over_an_uncertain_box_hits_at_most_as_often_as_allowed(box, stds, hard):
    asked = ggo.Obstacle(*box, *stds)
    solution = ggo.step_over(BASE, [asked], foothold=(0.39, 0.0), hard=hard)
    report = ggo.verify(solution.gait, obstacles=[asked], foothold=(0.39, 0.0))
    assert report.ok, report.violations
    drawn = hit_share(path_of(densely(solution.gait.frames, 1000)), box, *stds)
    assert drawn <= HIT_PROBABILITY
    assert drawn == pytest.approx(report.hit_probability, abs=1e-4)


@pytest.mark.parametrize("probability", [0.1, 0.01, 1e-3])
def test_the_box_for_another_probability_is_hit_no_more_often_than_that(probability):
    box, stds = (0.20, 0.25, 0.06), (0.02, 0.02)
    held = ggo.cautious(ggo.Obstacle(*box, *stds), probability)
    # So close that little but the probability is left: no margin.
    graph = ggo.GaitGraph(BASE)
    graph.anchor(BASE.frames[0])
    graph.add_obstacle(held, margin=0.0)
    graph.end(foothold=(0.39, 0.0), gain=250.0)
    drawn = hit_share(path_of(densely(graph.solve().gait.frames, 1000)), box, *stds)
    assert 0.0 < drawn <= probability


def test_two_uncertain_boxes_are_hit_at_most_as_often_together():
    boxes, stds = [(-0.25, -0.20, 0.08), (0.20, 0.25, 0.06)], (0.01, 0.02)
    solution = ggo.step_over(BASE, [ggo.Obstacle(*box, *stds) for box in boxes], foothold=(0.39, 0.0))
    path = path_of(densely(solution.gait.frames, 1000))
    drawn = sum(hit_share(path, box, *stds, seed=number) for number, box in enumerate(boxes))
    assert drawn <= HIT_PROBABILITY
    assert drawn == pytest.approx(solution.report.hit_probability, abs=1e-4)


def test_a_gait_over_the_measured_box_hits_more_often(over):
    asked = uncertain(BOX, 0.02, 0.02)
    report = ggo.verify(over, obstacles=[asked])
    (violation,) = report.violations
    assert (violation.kind, violation.limit, violation.note) == ("hit probability", 1e-3, str(asked))
    assert violation.value == report.hit_probability > 0.01
    assert ggo.verify(over, obstacles=[asked], tolerances=ggo.Tolerances(hit_probability=0.9)).ok


def test_several_obstacles_add_up(over):
    near, far = uncertain(BOX, 0.01, 0.02), ggo.Obstacle(0.28, 0.30, 0.02, 0.01, 0.01)
    alone = [ggo.verify(over, obstacles=[box]).hit_probability for box in (near, far)]
    both = ggo.verify(over, obstacles=[near, far]).hit_probability
    assert both == pytest.approx(sum(alone))
    assert min(alone) > 0.0
    assert ggo.verify(over, obstacles=[uncertain(BOX, 0.1, 0.1)] * 9).hit_probability == 1.0


def test_known_obstacles_are_checked_as_ever(over):
    report = ggo.verify(over, obstacles=[BOX], foothold=(0.39, 0.0))
    assert report.ok
    assert report.hit_probability == 0.0


def test_the_heel_may_hit_too(over):
    box = ggo.Obstacle(0.30, 0.32, 0.05, 0.005, 0.005)
    foot = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08, heel=0.03, toe=0.0))
    wider = hit_share(path_of(densely(over.frames, 4000)), (0.30, 0.35, 0.05), 0.005, 0.005)
    assert ggo.verify(over, foot, obstacles=[box]).hit_probability == pytest.approx(wider, abs=0.01)
    assert ggo.verify(over, obstacles=[box]).hit_probability < wider / 2.0


def test_shanks_stay_clear_of_the_cautious_box(over):
    legs = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08), shank_radius=0.04)
    post = ggo.Obstacle(0.08, 0.10, 0.10)
    measured, known = uncertain(post, 0.01, 0.01), ggo.verify(over, legs, obstacles=[post])
    report = ggo.verify(over, legs, obstacles=[measured])
    beside = ggo.verify(over, legs, obstacles=[ggo.cautious(measured)])
    assert known.leg_clearance > 0.0 > report.leg_clearance == beside.leg_clearance
    assert "support shank in obstacle" in [violation.kind for violation in report.violations]


@pytest.mark.parametrize("number", [0.0, 1.5, -1.0])
def test_the_limit_is_checked(number):
    with pytest.raises(ggo.InputError, match="hit_probability: "):
        ggo.Tolerances(hit_probability=number)


# -- the command line -------------------------------------------------------------------------------------------------


def test_verify_tells_the_probability(over, tmp_path, capsys):
    over.save(tmp_path / "over.csv")
    flags = ["verify", str(tmp_path / "over.csv"), "--obstacle"]
    assert main([*flags, "0.2,0.25,0.06,0.001,0.002", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["steps"][0]["hit_probability"]
    expected = ggo.verify(over, obstacles=[uncertain(BOX, 0.001, 0.002)]).hit_probability
    assert told == pytest.approx(expected)
    assert told > 0.0
    assert main([*flags, "0.2,0.25,0.06,0.02,0.02"]) == 3
    captured = capsys.readouterr()
    assert "hit probability (box from 0.2 to 0.25 m, 0.06 m high (edges ± 0.02, height ± 0.02 m)): 0." in captured.err
    assert " hit " in captured.out
    assert main([*flags, "0.2,0.25,0.06"]) == 0
    assert " hit " not in capsys.readouterr().out


def test_errors_of_an_obstacle_come_in_pairs(capsys):
    assert main(["step-over", "paper", "--obstacle", "0.2,0.25,0.06,0.01"]) == 2
    assert "has 4 numbers, expected XS,XE,H[,SE,SH]" in capsys.readouterr().err
