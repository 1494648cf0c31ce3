"""Steps over a terrain: what each sees from where its supporting foot stands."""

import math

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.motion.world import NOSE
from ggo_factors.walking.on_terrain import AROUND, steps_on

MODEL = ggo.LegModel(0.39, 0.39)
FOOT = ggo.LegModel(0.39, 0.39, foot=ggo.Foot(0.06, 0.05, 0.12))
START = ggo.paper_base_gait().frames[0]
BEHIND = float(MODEL.endpoint(START)[0])
T, BOX = ggo.Terrain, ggo.Obstacle


def steps(terrain, footholds, model=MODEL, **asked):
    return steps_on(terrain, footholds, model=model, start=START, **asked)


def shape(box):
    return (box.x_start, box.x_end, box.height, box.base)


def test_both_feet_meet_a_box_where_it_stands():
    box = BOX(0.5, 0.6, 0.1)
    made = steps(T.level(3.0).with_boxes(box), [0.4, 0.8, 1.2])
    assert [shape(step.obstacles[0]) for step in made] == [
        pytest.approx((0.5, 0.6, 0.1, 0.0)),
        pytest.approx((0.1, 0.2, 0.1, 0.0)),
        pytest.approx((-0.3, -0.2, 0.1, 0.0)),
    ]
    assert [step.foothold for step in made] == [pytest.approx((0.4, 0.0))] * 3


def test_a_step_sees_as_far_as_its_shanks_lean():
    far = [BOX(x, x + 0.01, 0.1) for x in (BEHIND - AROUND - 0.02, BEHIND - AROUND + 0.01, 0.84, 0.86)]
    (step,) = steps(T.level(3.0).with_boxes(*far), [0.4])
    assert [box.x_start for box in step.obstacles] == pytest.approx([far[1].x_start, far[2].x_start])


@pytest.mark.parametrize("rise", [-0.15, 0.1])
def test_a_box_on_other_ground_stands_there(rise):
    terrain = (T.level(0.3) + T.level(3.0, rise=rise)).with_boxes(BOX(0.6, 0.7, 0.05))
    before, on, _ = steps(terrain, [0.4, 0.8, 1.0])
    assert shape(before.obstacles[0]) == pytest.approx((0.6, 0.7, rise + 0.05, min(rise, 0.0)))
    assert shape(on.obstacles[0]) == pytest.approx((0.2, 0.3, 0.05, 0.0))
    assert before.foothold == pytest.approx((0.4, rise))
    assert before.ground.height_at([0.0, 0.35]) == pytest.approx([0.0, rise])
    assert on.ground.height_at([-0.2, 0.0]) == pytest.approx([-rise, 0.0])


def test_a_box_over_a_riser_stands_on_the_higher_side():
    terrain = (T.level(0.5) + T.level(2.0, rise=-0.1)).with_boxes(BOX(0.45, 0.55, 0.05))
    (step,) = steps(terrain, [0.4])
    assert shape(step.obstacles[0]) == pytest.approx((0.45, 0.55, 0.05, 0.0))


def test_pits_and_unknown_ground_beyond_the_end():
    made = steps(T.level(1.24).with_pits(ggo.Gap(0.5, 0.7, 0.01)), [0.4, 0.8, 1.2])
    assert made[0].gaps == (ggo.Gap(0.5, 0.7, 0.01),)
    (pit, beyond) = made[1].gaps
    assert (pit.x_start, pit.x_end, pit.unknown) == pytest.approx((0.1, 0.3, False))
    assert (beyond.x_start, beyond.unknown) == (pytest.approx(0.84), True)
    assert beyond.x_end > 50.0
    (last,) = made[2].gaps[1:]
    assert last.x_start == pytest.approx(0.44)


def test_a_riser_that_is_not_known_is_a_box_too():
    up = T.level(0.6) + T.level(2.0, rise=0.1, edge_std=0.01, height_std=0.005)
    (step,) = steps(up, [0.4])
    (nose,) = step.obstacles
    assert shape(nose) == pytest.approx((0.6, 0.6 + NOSE, 0.1, 0.0))
    assert (nose.edge_std, nose.height_std) == (0.01, 0.005)
    down = T.level(0.6, height_std=0.004) + T.level(2.0, rise=-0.1, edge_std=0.01, height_std=0.005)
    before, after = steps(down, [0.4, 0.8])
    assert shape(before.obstacles[0]) == pytest.approx((0.6 - NOSE, 0.6, 0.0, 0.0))
    assert (before.obstacles[0].edge_std, before.obstacles[0].height_std) == (0.01, 0.004)
    assert after.obstacles[0].x_end == pytest.approx(0.2)
    beyond = steps(down, [0.4, 0.8, 1.0])[2]
    assert shape(beyond.obstacles[0]) == pytest.approx((-0.2 - NOSE, -0.2, 0.1, 0.0))
    assert not steps(T.level(0.6) + T.level(2.0, rise=0.1), [0.4])[0].obstacles


def test_a_box_on_a_ramp_counts_higher_by_what_a_sole_hangs():
    slope = math.radians(10.0)
    terrain = (T.level(0.2) + T.ramp(2.0, slope)).with_boxes(BOX(0.6, 0.7, 0.1))
    top = math.tan(slope) * 0.5 + 0.1
    assert steps(terrain, [0.4])[0].obstacles[0].height == pytest.approx(top)
    assert steps(terrain, [0.4], FOOT)[0].obstacles[0].height == pytest.approx(top + 0.12 * math.sin(slope))


def test_ankles_on_a_ramp_stand_over_their_tilted_soles():
    slope = math.radians(12.0)
    terrain = T.level(0.2) + T.ramp(2.0, slope)
    first, second = steps(terrain, [0.4, 0.9], FOOT)
    lean = 0.06 / math.cos(slope) - 0.06
    assert first.foothold == pytest.approx((0.4, math.tan(slope) * 0.2 + lean))
    assert second.foothold == pytest.approx((0.5, math.tan(slope) * 0.5))
    assert second.ground.slope_at(0.1) == pytest.approx(slope)
    for step in (first, second):
        assert step.ground.ankle_on(FOOT.foot, step.foothold[0]) == pytest.approx(step.foothold[1], abs=1e-12)


def test_elsewhere_at_the_start_and_standing_at_the_end():
    terrain = T.level(3.0).with_boxes(BOX(1.5, 1.6, 0.1))
    there, here = steps(terrain, [1.4, 1.8], at=1.0), steps(T.level(2.0).with_boxes(BOX(0.5, 0.6, 0.1)), [0.4, 0.8])
    assert [shape(step.obstacles[0]) for step in there] == [pytest.approx(shape(step.obstacles[0])) for step in here]
    first, last = steps(terrain, [1.4, 1.4], at=1.0, to_standing=True)
    assert first.end_frame is None
    assert last.foothold is None
    np.testing.assert_array_equal(last.end_frame, ggo.STANDING)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"footholds": []}, "footholds: a walk needs at least one step"),
        ({"footholds": [0.4, math.nan]}, "footholds: value nan"),
        ({"footholds": ["a"]}, "footholds: expected numbers"),
        ({"footholds": 0.4}, "footholds: expected shape"),
        ({"footholds": [0.4, 0.8], "to_standing": True}, "to stand the feet end beside each other, at 0.4 m; got 0.8"),
        ({"footholds": [0.4], "to_standing": 1}, "to_standing: expected True or False"),
        ({"footholds": [0.4], "at": math.inf}, "at: inf m is not finite"),
        ({"footholds": [0.4], "start": [0.0] * 3}, "start: expected shape"),
        ({"footholds": [0.4], "terrain": None}, "terrain: expected a Terrain, got None"),
    ],
)
def test_arguments_are_checked(asked, told):
    given = {"terrain": T.level(3.0), "model": MODEL, "start": START} | asked
    with pytest.raises(ggo.InputError, match=told):
        steps_on(given.pop("terrain"), given.pop("footholds"), **given)
