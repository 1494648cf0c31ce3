"""A plan in the header of its walk's file: what is written comes back, what is wrong is named."""

import json
from dataclasses import replace

import pytest

import ggo_factors as ggo
from ggo_factors.planning.plan_file import load_plan

TERRAIN = ggo.Terrain.level(3.0).with_boxes(ggo.Obstacle(1.2, 1.3, 0.1))
PLAN = ggo.plan_walk(ggo.paper_base_gait(), TERRAIN, goal=2.0, prefer="people")


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("plans") / "plan.csv"
    PLAN.save(path)
    return path


def test_a_plan_comes_back(saved):
    again = load_plan(saved)
    for name in ("terrain", "at", "goal", "footholds", "costs", "expected", "considered", "banned", "to_standing"):
        assert getattr(again, name) == getattr(PLAN, name), name
    assert again.prefer == "people"


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"at": None}, "at: expected a number, got None"),
        ({"at": float("nan")}, "at: nan m is not finite"),
        ({"goal": "2"}, "goal: expected a number, got '2'"),
        ({"to_standing": 1}, "to_standing: expected True or False, got 1"),
        ({"prefer": "style"}, "prefer: 'style' is neither"),
        ({"prefer": []}, r"prefer: \[\] is neither"),
        ({"footholds": [1.0]}, r"footholds: 1 numbers, the walk has \d steps"),
        ({"costs": []}, r"costs: 0 numbers, the walk has \d steps"),
        ({"expected": [1.0]}, r"expected: 1 numbers, the walk has \d steps"),
        ({"expected": "x"}, "expected: expected numbers"),
        ({"terrain": "x"}, "is no terrain file"),
        ({"terrain": None}, "does not describe a plan"),
        ({"banned": 1}, "does not describe a plan"),
        ({"banned": [{"behind": 0.0}]}, "does not describe a plan"),
        ({"banned": [{"behind": "a", "stands": 0.0, "lands": 0.4, "reason": ""}]}, "banned: behind: expected a number"),
        ({"banned": [{"behind": 0.0, "stands": 0.0, "lands": 0.4, "reason": 5}]}, "banned: reason: expected a str"),
        ({"at": 0.5}, r"footholds: [\d.]+ m, but step 1 of the walk lands at [\d.]+ m"),
        ({"walk": 1}, "does not describe a plan"),
        ({"other": 1}, "does not describe a plan"),
    ],
)
def test_what_is_wrong_in_a_header_is_named(saved, tmp_path, changed, told):
    lines = saved.read_text().splitlines(keepends=True)
    place = next(n for n, line in enumerate(lines) if line.startswith("# plan: "))
    given = json.loads(lines[place].removeprefix("# plan: "))
    lines[place] = f"# plan: {json.dumps(given | changed)}\n"
    path = tmp_path / "changed.csv"
    path.write_text("".join(lines))
    with pytest.raises(ggo.InputError, match=told) as error:
        load_plan(path, edited=True)
    assert str(error.value).startswith(f"{path}: header 'plan'")


def test_a_file_of_before_has_no_expectation_of_the_closing_step(tmp_path):
    plan = ggo.plan_walk(ggo.paper_base_gait(), ggo.Terrain.level(2.0), goal=0.8, to_standing=True)
    older = replace(plan, expected=(*plan.expected[:-2], sum(plan.expected[-2:])))
    older.save(tmp_path / "plan.csv")
    assert load_plan(tmp_path / "plan.csv").expected == (*older.expected, 0.0)
    plan.save(tmp_path / "plan.csv")
    assert load_plan(tmp_path / "plan.csv").expected == plan.expected


def test_a_walk_without_a_plan(tmp_path):
    PLAN.walk.save(tmp_path / "walk.csv")
    with pytest.raises(ggo.InputError, match="is a walk without a plan"):
        load_plan(tmp_path / "walk.csv")
