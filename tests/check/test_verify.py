"""The dense check: it must see each kind of fault, and nothing else."""

import math

import gtsam
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from independent import clearance, densely, path_of, stair_clearance

import ggo_factors as ggo

BASE = ggo.paper_base_gait()
MODEL = ggo.LegModel(0.39, 0.39, bones="points")  # what P alone does, one fault at a time
GOOD = ggo.step_over(BASE, [ggo.Obstacle(0.20, 0.25, 0.08)], foothold=(0.39, 0.0), smoothness=0).gait


def kinds(report):
    return [violation.kind for violation in report.violations]


def test_the_papers_base_gait_passes_though_its_ends_are_off_the_ground():
    report = ggo.verify(BASE)
    assert report.ok, report.violations
    assert math.degrees(report.knee) == pytest.approx(-0.268, abs=1e-3)
    assert report.instants >= 500
    assert BASE.endpoints()[-1, 1] == pytest.approx(-0.0097, abs=1e-4)


def test_a_good_gait_passes_everything():
    report = ggo.verify(
        GOOD,
        MODEL,
        BASE.frames[0],
        [ggo.Obstacle(0.2, 0.25, 0.08)],
        [ggo.Gap(0.2, 0.35)],
        (0.39, 0.0),
        ground=ggo.Ground(),
    )
    assert report.ok
    assert report.clearance == pytest.approx(clearance(GOOD.frames, 0.2, 0.25, 0.08), abs=2e-4)


@pytest.mark.parametrize(
    ("arguments", "kind"),
    [
        ({"start": BASE.frames[0] + 1e-8}, "start"),
        ({"obstacles": [ggo.Obstacle(0.20, 0.25, 0.15)]}, "obstacle"),
        ({"gaps": [ggo.Gap(0.30, 0.45)]}, "foothold in a gap"),
        ({"foothold": (0.395, 0.0)}, "foothold"),
        ({"shank_angle": math.pi / 2}, "shank"),
        ({"ground": ggo.Ground((0.1, 0.3), (0.0, 0.12, 0.0)), "foothold": (0.39, 0.0)}, "ground"),
    ],
)
def test_each_fault_is_named(arguments, kind):
    report = ggo.verify(GOOD, MODEL, **arguments)
    assert kinds(report) == [kind]
    violation = report.violations[0]
    assert violation.value != violation.limit
    assert kind in str(violation)


@pytest.mark.parametrize(
    ("column", "value", "kind"),
    [(1, -1.0, "knee"), (3, 155.0, "knee bent"), (2, -60.0, "thigh back"), (2, 135.0, "thigh forward")],
)
def test_joints_beyond_any_human_range(column, value, kind):
    frames = GOOD.frames.copy()
    frames[20, column] = math.radians(value)
    report = ggo.verify(ggo.Gait(frames, 0.01), MODEL)
    found = next(violation for violation in report.violations if violation.kind == kind)
    assert found.frame == 20
    assert found.value == pytest.approx(value)


def test_a_post_between_two_frames_is_hit():
    # Narrower than the foot moves from one frame to the next, and as high as both frames: only the path between shows.
    path = GOOD.endpoints()
    at = int(np.argmax(np.diff(path[:, 0])))
    middle = path[at : at + 2].mean(axis=0)
    post = ggo.Obstacle(middle[0] - 1e-5, middle[0] + 1e-5, middle[1] + 1e-3)
    assert kinds(ggo.verify(GOOD, MODEL, obstacles=[post])) == ["obstacle"]
    lower = ggo.Obstacle(post.x_start, post.x_end, middle[1] - 3e-3)
    assert ggo.verify(GOOD, MODEL, obstacles=[lower]).ok


def test_under_the_ground():
    frames = BASE.frames.copy()
    frames[38:42, :2] += np.radians([20.0, 40.0])  # the support knee gives way
    report = ggo.verify(ggo.Gait(frames, 0.01), MODEL)
    assert kinds(report) == ["ground", "knee turns"]
    assert report.violations[0].value == pytest.approx(path_of(densely(frames))[100:-100, 1].min(), abs=1e-3)


def test_a_supporting_leg_that_gives_way():
    frames = BASE.frames.copy()
    frames[20:25, :2] += np.radians([45.0, 90.0])
    found = next(v for v in ggo.verify(ggo.Gait(frames, 0.01), MODEL).violations if v.kind == "hip drop")
    hips = MODEL.joints(frames)[:, 2, 1]
    assert found.value == pytest.approx(hips[0] - hips.min() - 0.0097, abs=1e-4)  # less what the landing lies below
    assert found.limit == pytest.approx(0.2 * 0.78)


def test_an_obstacle_in_the_support_foot():
    assert "obstacle in the supporting foot" in kinds(
        ggo.verify(GOOD, MODEL, obstacles=[ggo.Obstacle(-0.01, 0.01, 0.01)])
    )


def test_the_sole_counts():
    foot = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08, 0.05, 0.15))
    pit, box = ggo.Gap(0.50, 0.6), ggo.Obstacle(0.20, 0.25, 0.09)
    assert ggo.verify(GOOD, MODEL, obstacles=[box], gaps=[pit]).ok  # the ankle alone keeps clear of both
    assert kinds(ggo.verify(GOOD, foot, gaps=[pit])) == ["foothold in a gap"]
    assert kinds(ggo.verify(GOOD, foot, obstacles=[box])) == ["obstacle"]


def test_a_toe_that_would_stand_in_the_next_riser_is_told_from_a_foot_off_the_ground():
    foot = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.08, 0.05, 0.15))
    riser = ggo.Ground((0.45,), (0.0, 0.1))
    assert "stair in the foothold" in kinds(ggo.verify(GOOD, foot, foothold=(0.39, 0.0), ground=riser))
    assert "foothold off the ground" in kinds(ggo.verify(GOOD, foot, foothold=(0.39, 0.03), ground=ggo.Ground()))


def test_the_papers_literal_descent_cuts_the_stair():
    """Riser 0.15 as the paper does it: the second step knows of no edge behind, and cuts 94 mm into the stair.

    It starts from a constant (all frames as the last one of step 1), which leads the solver to another minimum than the
    base gait does.
    """
    start, gaits = BASE.frames[0], []
    x = BASE.endpoints()[:, 0]
    for step in range(2):
        graph = ggo.GaitGraph(BASE, MODEL, keyframes="all")
        graph.anchor(start)
        over = np.flatnonzero((x >= 0.28) & (x <= 0.30))
        graph.add_obstacle(ggo.Obstacle(0.28, 0.30, 0.0), frames=over, hold=0.0)
        graph.end(foothold=(0.39, -0.15), shank_angle=math.pi / 2, gain=5.0 * 51)
        values = gtsam.Values()
        for n, frame in enumerate(BASE.frames):
            values.insert(gtsam.symbol("g", n), frame if step == 0 else start)
        params = gtsam.DoglegParams()
        params.setRelativeErrorTol(1e-9)
        solved = gtsam.DoglegOptimizer(graph.factor_graph(), values, params).optimize()
        gaits.append(ggo.Gait([solved.atVector(gtsam.symbol("g", n)) for n in range(51)], 0.01))
        start = gaits[-1].swapped().frames[-1]
    behind = ggo.Ground(edges=(-0.10, 0.29), heights=(0.15, 0.0, -0.15))
    report = ggo.verify(gaits[1], MODEL, foothold=(0.39, -0.15), ground=behind)
    assert kinds(report) == ["ground"]
    assert report.violations[0].value == pytest.approx(-0.094, abs=0.001)
    assert stair_clearance(gaits[1].frames, [-0.10, 0.29], [0.15, 0.0, -0.15]) == pytest.approx(-0.094, abs=1e-3)


@settings(max_examples=60, deadline=None)
@given(start=st.floats(-0.35, 0.30), width=st.floats(0.005, 0.1), height=st.floats(0.0, 0.2))
def test_clearance_against_an_independent_count(start, width, height):
    report = ggo.verify(GOOD, MODEL, obstacles=[ggo.Obstacle(start, start + width, height)])
    other = clearance(GOOD.frames, start, start + width, height)
    if math.isfinite(other):
        assert report.clearance == pytest.approx(other, abs=2e-3)
        assert report.clearance <= other + 1e-9 + 1e-3


def test_tolerances_are_checked():
    with pytest.raises(ggo.InputError, match="knee: nan"):
        ggo.Tolerances(knee=math.nan)
