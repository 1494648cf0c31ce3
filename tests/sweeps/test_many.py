"""Many gaits at once: what a row says, and that it does not depend on who makes it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from many_rows import BASE, told

import ggo_factors as ggo
from ggo_factors.sweeps.tasks import Row, Task, generate_many


def mixed_tasks():
    """Gaits of every procedure, refusals and bad input."""
    return [
        Task("step_over", {"obstacles": [ggo.Obstacle(0.20, 0.25, 0.08)], "foothold": (0.39, 0.0)}),
        Task("adjust_stride", {"stride": 0.6}),
        Task("adjust_stride", {"stride": 9.0}),
        Task("climb_stairs", {"riser": 0.1, "tread": 0.3, "first_edge": 0.4}),
        Task("climb_stairs", {"riser": 0.1, "steps": 1}),
        Task("descend_stairs", {"riser": 0.1, "steps": 1}),
        Task("walk", {"steps": [ggo.Step((0.39, 0.0))], "model": ggo.LegModel(0.41, 0.4)}),
        Task("step_over", {"obstacles": [], "foothold": (0.3, 0.0)}),
    ]


@pytest.fixture(scope="module")
def mixed_rows():
    return generate_many(mixed_tasks(), BASE, workers=1, keep_frames=True)


def test_a_row_is_what_the_procedure_says(mixed_rows):
    row, solution = mixed_rows[0], ggo.step_over(BASE, [ggo.Obstacle(0.20, 0.25, 0.08)], foothold=(0.39, 0.0))
    assert (row.ok, row.error, row.reason, row.violations) == (True, "", "", ())
    assert (row.iterations, row.clearance, row.knee) == (
        solution.iterations,
        solution.report.clearance,
        solution.report.knee,
    )
    assert row.foothold_error == solution.report.foothold_error < 1e-3
    assert row.milliseconds > 0.0
    np.testing.assert_array_equal(row.frames, [solution.gait.frames])
    np.testing.assert_allclose(row.change, np.abs(solution.gait.frames - BASE.frames).mean(axis=0), rtol=0, atol=1e-15)


def test_the_row_of_a_walk_is_the_worst_of_its_steps(mixed_rows):
    row, walk = mixed_rows[1], ggo.adjust_stride(BASE, 0.6)
    assert row.frames.shape == (2, 21, 4)
    assert row.iterations == sum(step.iterations for step in walk.steps)
    assert row.foothold_error == max(step.report.foothold_error for step in walk.steps)
    assert row.knee == min(step.report.knee for step in walk.steps)


def test_what_fails_is_a_row_with_its_reason(mixed_rows):
    with pytest.raises(ggo.UnreachableFootholdError) as refused:
        ggo.adjust_stride(BASE, 9.0)
    row = mixed_rows[2]
    assert (row.ok, row.error, row.reason) == (False, "UnreachableFootholdError", str(refused.value))
    assert row.violations == refused.value.violations
    assert np.isnan([row.foothold_error, row.clearance, row.knee, *row.change]).all()
    assert row.frames is None
    assert (mixed_rows[3].error, mixed_rows[3].violations) == ("InputError", ())
    assert "first_edge" in mixed_rows[3].reason
    assert [row.ok for row in mixed_rows] == [True, True, False, False, True, True, True, True]


def test_rows_survive_json_bit_for_bit(mixed_rows):
    again = [Row.from_json(json.loads(json.dumps(row.to_json()))) for row in mixed_rows]
    assert told(again) == told(mixed_rows)
    assert [row.milliseconds for row in again] == [row.milliseconds for row in mixed_rows]


def test_rows_of_two_processes_equal_the_serial_ones(mixed_rows):
    seen = []
    rows = generate_many(mixed_tasks(), BASE, workers=2, keep_frames=True, progress=seen.append)
    assert told(rows) == told(mixed_rows)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


@pytest.mark.parametrize("workers", [1, 2])
def test_iterators_are_read_once_and_kept(workers):
    task = Task("walk", {"steps": iter([ggo.Step((0.39, 0.0))])})
    rows = generate_many(iter([task, task]), BASE, workers=workers)
    assert [row.ok for row in rows] == [True, True]
    assert told(rows[:1]) == told(rows[1:])


def test_no_tasks_no_rows():
    assert generate_many([], BASE) == []


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Task("jump"), "procedure: 'jump' is not known"),
        (lambda: Task("step_over", {"obstacle": []}), "step_over: "),
        (lambda: Task("step_over", {"base": BASE, "obstacles": []}), "multiple values"),
        (lambda: Task("step_over", 3), "step_over: "),
        (lambda: generate_many([3], BASE), "tasks: expected Tasks"),
        (lambda: generate_many([], None), "base: expected a Gait"),
        (lambda: generate_many(mixed_tasks(), BASE, workers=0), "workers: 0 must be at least 1"),
        (lambda: generate_many([], BASE, client=3), "client: expected a dask.distributed Client"),
        (lambda: generate_many([], BASE, client=3, workers=2), "workers: a cluster has its own"),
    ],
)
def test_bad_tasks_are_one_clear_error(make, message):
    with pytest.raises(ggo.InputError, match=message):
        make()
