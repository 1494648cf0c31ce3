"""Campaign: three hundred random boxes each, bones as lines, judged by kinematics and a search of their own."""

from pathlib import Path
from statistics import median
from time import process_time

import pytest
from bare_bones import axis_in, deepest, joints, pointed, random_boxes, way_past

import ggo_factors as ggo

pytestmark = pytest.mark.campaign

LOG = Path(__file__).parents[2] / "datasets" / "children_walk.mcap"


def base_gait(name):
    if name == "paper":
        return ggo.paper_base_gait()
    return ggo.import_base_gait(LOG, joints=LOG.with_suffix(".toml"), model=ggo.LegModel(0.39, 0.39)).gait


@pytest.mark.parametrize("seed", [7, 8])
@pytest.mark.parametrize("name", ["paper", "sample"])
@pytest.mark.parametrize("hard", [False, True], ids=["any", "hard"])
def test_boxes_before_the_foothold(name, seed, hard):
    base = base_gait(name)
    foothold = (float(base.endpoints()[-1, 0]), 0.0)
    spent, unconfirmed = {"lines": [], "points": []}, []
    ways = {"lines": base, "points": pointed(base)}
    for gait in ways.values():
        ggo.step_over(gait, [ggo.Obstacle(0.1, 0.15, 0.03)], foothold=foothold)
    for box in random_boxes(foothold[0], 300, seed, hard=hard):
        for bones, gait in ways.items():
            began = process_time()
            try:
                made = ggo.step_over(gait, [ggo.Obstacle(*box)], foothold=foothold)
            except ggo.InfeasibleGaitError:
                made = None
            spent[bones].append(process_time() - began)
            if bones == "points":
                continue
            if made is not None:
                assert axis_in(made.gait, box) == 0.0, box
            elif deepest(joints(base.frames[:2]), box) == 0.0 and way_past(base.frames[0], box, foothold):
                unconfirmed.append(box)
    print(f"medians {median(spent['lines']) * 1e3:.1f} and {median(spent['points']) * 1e3:.1f} ms", unconfirmed)
    assert median(spent["lines"]) <= 3.0 * median(spent["points"])
    # Within 20 mm of the foothold a foot must fall in two frames of these base gaits.
    assert len(unconfirmed) <= (60 if hard else 6), unconfirmed
