"""Many gaits at once: the rows do not depend on who makes them, and nothing is lost with a process that dies."""

from __future__ import annotations

import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import ggo_factors as ggo
from ggo_factors.grid import Grid
from ggo_factors.many import Row, Task, generate_many
from ggo_factors.pool import run
from ggo_factors.sweep_file import outcome, sweep

BASE = ggo.paper_base_gait(frames=21)
GRID = Grid(obstacle_x=(0.15, 0.20), obstacle_height=(0.04, 0.08, 0.12), thigh=(0.39, 0.41))


def told(rows):
    """All that rows say but how long they took, bit for bit."""
    return [json.dumps({**row.to_json(), "milliseconds": 0.0}) for row in rows]


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


@pytest.fixture(scope="module")
def grid_rows():
    return generate_many(GRID.tasks(BASE), BASE, workers=1)


def load(path):
    import xarray  # not above: every worker process that reads this file would load it

    return xarray.load_dataset(path)


# -- rows ------------------------------------------------------------------------------------------------------------


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


# -- processes that die ------------------------------------------------------------------------------------------------


class Deadly:
    """Becomes a list of no obstacles in the process that reads it, which may kill that process."""

    def __init__(self, marker=None):
        self.marker = marker

    def __reduce__(self):
        return _die, (os.getpid(), self.marker)


def _die(parent, marker):
    if os.getpid() != parent and (marker is None or not marker.exists()):
        if marker is not None:
            marker.write_text(os.environ["OPENBLAS_NUM_THREADS"])
        os.kill(os.getpid(), signal.SIGKILL)
    return []


def harmless_tasks(count):
    return [Task("step_over", {"obstacles": [], "foothold": (0.3 + 0.001 * k, 0.0)}) for k in range(count)]


def test_processes_that_die_lose_nothing_but_a_row_that_kills_them_all(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    tasks, once = harmless_tasks(30), tmp_path / "died"
    tasks[9] = Task("step_over", {"obstacles": Deadly(once), "foothold": (0.309, 0.0)})
    tasks[20] = Task("step_over", {"obstacles": Deadly(), "foothold": (0.32, 0.0)})
    seen = []
    rows = generate_many(tasks, BASE, workers=2, progress=seen.append)
    assert (seen[-1], sorted(set(seen))) == (1.0, seen)  # no row was made twice
    lost = rows.pop(20)
    expected = generate_many(harmless_tasks(30), BASE, workers=1)
    assert told(rows) == told(expected[:20] + expected[21:])
    assert (lost.ok, lost.error, "died" in lost.reason) == (False, "WorkerDied", True)
    assert once.read_text() == "1"  # each worker uses one thread, and this process what it did before
    assert os.environ["OPENBLAS_NUM_THREADS"] == "7"
    assert multiprocessing.active_children() == []


def test_processes_that_cannot_start_are_told_from_rows_that_kill_them(tmp_path):
    script = tmp_path / "unguarded.py"
    script.write_text(
        "from ggo_factors import Task, generate_many, paper_base_gait\n"
        "task = Task('step_over', {'obstacles': [], 'foothold': (0.3, 0.0)})\n"
        "generate_many([task, task], paper_base_gait(), workers=2)\n"
    )
    made = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=120, check=False)
    assert re.search(r"GgoError: worker processes die as they start: .*__main__", made.stderr)


CALLS = """
import multiprocessing, signal, sys
from ggo_factors import GgoError, Obstacle, Task, generate_many, paper_base_gait

TASKS = [Task("step_over", {"obstacles": [Obstacle(0.2, 0.25, 0.05)]})] * int(sys.argv[2])

def call(progress=None):
    try:
        print([row.ok for row in generate_many(TASKS, paper_base_gait(21), workers=2, progress=progress)], flush=True)
    except GgoError as error:
        print(error, flush=True)

if __name__ == "__main__":
    if sys.argv[1] == "interrupted":
        signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background may ignore it
        call(lambda part: print("working", flush=True))
    else:
        call()
        context = multiprocessing.get_context("fork")
        child = context.Process(target=call, daemon=sys.argv[1] == "daemonic")
        child.start()
        child.join()
"""


@pytest.mark.parametrize(
    ("how", "told"),
    [("nested", "[True, True]"), ("daemonic", "workers: a daemonic process may have none of its own; say workers=1")],
)
def test_a_child_that_was_forked_after_a_call(tmp_path, how, told):
    script = tmp_path / "calls.py"
    script.write_text(CALLS)
    made = subprocess.run([sys.executable, script, how, "2"], capture_output=True, text=True, timeout=120, check=False)
    assert made.stdout.splitlines() == ["[True, True]", told], made.stderr


def test_two_interrupts_end_all_processes(tmp_path):
    script = tmp_path / "calls.py"
    script.write_text(CALLS)
    process = subprocess.Popen(
        [sys.executable, script, "interrupted", "2000"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    assert process.stdout.readline() == b"working\n"
    for _ in range(2):
        os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.1)
    process.communicate(timeout=60)
    assert process.returncode != 0


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux tells which pages a process shares")
def test_each_process_runs_code_of_its_own():
    ((_, (shared, private)),) = next(run(_gtsam_kib, [0, 1], lambda item: None, workers=2))
    assert private > 1000
    assert shared == 0


def _gtsam_kib(items):
    """The machine code of GTSAM in this process, in KiB: shared with other processes, and its own."""
    counts = {}
    code = False
    for line in Path("/proc/self/smaps").read_text().splitlines():
        name, *rest = line.split()
        if not name.endswith(":"):
            code = rest[0] == "r-xp" and "libgtsam" in line
        elif code and name.startswith(("Shared", "Private")):
            owner = name.split("_")[0]
            counts[owner] = counts.get(owner, 0) + int(rest[0])
    return [(counts["Shared"], counts["Private"])] * len(items)


# -- a cluster ---------------------------------------------------------------------------------------------------------


def test_a_cluster_whose_worker_is_killed_loses_nothing(tmp_path, grid_rows):
    from distributed import Client, LocalCluster

    killed = []
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", local_directory=tmp_path) as cluster,
        Client(cluster) as client,
    ):
        workers = client.run(os.getpid)
        assert len(workers) == 2

        def kill_one(part):
            if not killed:
                killed.append(part)
                os.kill(next(iter(workers.values())), signal.SIGKILL)

        rows = generate_many(GRID.tasks(BASE), BASE, client=client, progress=kill_one)
        found = sweep(GRID, BASE, tmp_path / "out.nc", client=client)
    assert 0.0 < killed[0] < 1.0
    assert told(rows) == told(grid_rows)
    assert found.iterations.values.ravel().tolist() == [row.iterations for row in grid_rows]


# -- grids -------------------------------------------------------------------------------------------------------------


def test_a_grid_has_every_combination_in_order():
    grid = Grid(obstacle_x=[0.1, 0.2], obstacle_height=0.05, stride=np.array([0.7, 0.8]), thigh=(0.4, 0.41, 0.42))
    assert grid.axes == {
        "obstacle_x": (0.1, 0.2),
        "obstacle_height": (0.05,),
        "stride": (0.7, 0.8),
        "thigh": (0.4, 0.41, 0.42),
    }
    assert (grid.shape, grid.size, grid.steps_a_row) == ((2, 1, 2, 3), 12, 1)
    for task, (x, stride, thigh) in zip(
        grid.tasks(BASE), product((0.1, 0.2), (0.7, 0.8), (0.4, 0.41, 0.42)), strict=True
    ):
        assert task.procedure == "step_over"
        assert task.arguments["obstacles"] == (ggo.Obstacle(x, x + 0.05, 0.05),)
        assert task.arguments["foothold"] == (stride / 2.0, 0.0)
        assert task.arguments["model"] == ggo.LegModel(thigh, 0.39)


def test_risers_go_up_and_down():
    up, down = Grid(riser=(0.1, -0.12), tread=0.35, steps=3).tasks(BASE)
    assert (up.procedure, up.arguments["riser"]) == ("climb_stairs", 0.1)
    assert (down.procedure, down.arguments["riser"]) == ("descend_stairs", 0.12)
    assert down.arguments["tread"] == 0.35
    assert down.arguments["steps"] == 3
    assert [task.arguments["stride"] for task in Grid(stride=(0.6, 0.7)).tasks(BASE)] == [0.6, 0.7]


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ({}, "grid: give at least one of"),
        ({"stride": []}, "stride: an axis needs at least one value"),
        ({"stride": [0.6, 0.7, 0.6]}, "stride: 0.6 m stands twice"),
        ({"stride": [0.6, np.nan]}, "stride: value nan"),
        ({"stride": "wide"}, "stride: expected numbers"),
        ({"stride": -0.6}, "stride: -0.6 m must be above 0 m"),
        ({"thigh": 39.0}, "thigh: 39 m must be at most 2 m"),
        ({"riser": [0.1, 0.0]}, "riser: 0 m is neither up nor down"),
        ({"riser": 0.1, "stride": 0.6}, "stride: does not go with riser"),
        ({"tread": 0.3}, "tread: stairs need a riser"),
        ({"obstacle_x": 0.1}, "obstacle_x: an obstacle needs"),
        ({"obstacle_x": 0.1, "obstacle_height": -0.1}, "obstacle_height: -0.1 m must be at least 0 m"),
        ({"obstacle_x": 0.1, "obstacle_height": 0.1, "steps": 2}, "steps: a step over an obstacle is one"),
        ({"stride": 0.6, "steps": 0}, "steps: 0 must be at least 1"),
        ({"stride": np.linspace(0.1, 1, 1001), "thigh": np.linspace(0.1, 1, 1000)}, "grid: 1001000 rows"),
    ],
)
def test_bad_grids_are_one_clear_error(axes, message):
    with pytest.raises(ggo.InputError, match=message):
        Grid(**axes)


# -- files -------------------------------------------------------------------------------------------------------------


class StoppedError(Exception):
    pass


def stop_at(part):
    def progress(now):
        if now >= part:
            raise StoppedError

    return progress


def test_results_in_one_file_with_named_axes(tmp_path, grid_rows):
    path = tmp_path / "out.nc"
    grid = Grid(obstacle_x=0.2, obstacle_height=(0.08, 0.6))
    found = sweep(grid, BASE, path, workers=1, keep_frames=True)
    assert [file.name for file in tmp_path.iterdir()] == ["out.nc"]
    assert load(path).identical(found)
    assert found.sizes == {"obstacle_x": 1, "obstacle_height": 2, "joint": 4, "step": 1, "frame": 21}
    good, bad = (found.sel(obstacle_x=0.2, obstacle_height=height) for height in (0.08, 0.6))
    solution = ggo.step_over(BASE, [ggo.Obstacle(0.2, 0.25, 0.08)])
    assert good.ok
    assert (good.iterations, good.clearance_mm) == (solution.iterations, solution.report.clearance * 1e3)
    np.testing.assert_array_equal(good.frames_deg[0], np.degrees(solution.gait.frames))
    assert not bad.ok
    assert (bad.error, "no gait found" in str(bad.reason.values)) == ("InfeasibleGaitError", True)
    assert np.isnan([bad.iterations, bad.knee_deg, *bad.frames_deg.values.ravel()]).all()
    counts = outcome(found)
    assert (counts["rows"], counts["ok"], counts["errors"]) == (2, 1, {"InfeasibleGaitError": 1})
    assert sum(counts["violations"].values()) >= 1


def test_a_stopped_sweep_does_only_the_rest(tmp_path, grid_rows):
    path, partial = tmp_path / "out.nc", tmp_path / "out.nc.partial"
    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=stop_at(0.5))
    assert [file.name for file in tmp_path.iterdir()] == ["out.nc.partial"]
    lines = partial.read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + GRID.size // 2
    partial.write_bytes(b"".join(lines[:-1]) + lines[-1][:-20])  # and its last row was cut short
    seen = []
    found = sweep(GRID, BASE, path, workers=1, progress=seen.append)
    assert len(seen) == 1 + GRID.size - (len(lines) - 2)
    spent = found.milliseconds.values.ravel()
    assert [json.loads(line)["milliseconds"] for line in lines[1:-1]] == spent[: len(lines) - 2].tolist()
    assert found.clearance_mm.values.ravel().tolist() == [row.clearance * 1e3 for row in grid_rows]
    assert [file.name for file in tmp_path.iterdir()] == ["out.nc"]


def test_a_killed_sweep_goes_on_and_leaves_no_process_behind(tmp_path, grid_rows):
    path, partial = tmp_path / "out.nc", tmp_path / "out.nc.partial"
    script = tmp_path / "script.py"
    script.write_text(
        "import ggo_factors as ggo\nfrom ggo_factors.sweep_file import Grid, sweep\n"
        "if __name__ == '__main__':\n"
        f"    sweep({GRID!r}, ggo.paper_base_gait({len(BASE)}), {str(path)!r}, workers=2)\n"
    )
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE) as process:
        while process.poll() is None and (not partial.exists() or partial.read_bytes().count(b"\n") < 2):
            time.sleep(0.002)
        process.kill()
        # The workers hold the other end of this pipe: it closes when the last of them is gone.
        process.stdout.read()
    assert partial.exists()
    assert not path.exists()
    found = sweep(GRID, BASE, path, workers=1)
    assert found.clearance_mm.values.ravel().tolist() == [row.clearance * 1e3 for row in grid_rows]


@pytest.mark.parametrize(
    ("other", "message"),
    [
        ({"grid": Grid(obstacle_x=(0.15, 0.20), obstacle_height=(0.04, 0.09))}, "obstacle_height, thigh differ"),
        ({"base": ggo.paper_base_gait(frames=22)}, "base gait, dt differ"),
        ({"model": ggo.LegModel(0.39, 0.4)}, "legs differs"),
        ({"keep_frames": True}, "keep_frames differs"),
    ],
)
def test_the_partial_file_of_another_sweep_is_refused(tmp_path, other, message):
    path = tmp_path / "out.nc"
    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=stop_at(0.0))
    before = (tmp_path / "out.nc.partial").read_bytes()
    with pytest.raises(ggo.InputError, match=f"is of another sweep, {message}"):
        sweep(**{"grid": GRID, "base": BASE, "path": path, "workers": 1, **other})
    assert (tmp_path / "out.nc.partial").read_bytes() == before


def test_bad_files_are_one_clear_error(tmp_path):
    path, partial = tmp_path / "out.nc", tmp_path / "out.nc.partial"
    for name, message in (("out.csv", "end in .nc"), ("no/out.nc", "cannot be written"), ("", "end in .nc")):
        with pytest.raises(ggo.InputError, match=message):
            sweep(GRID, BASE, tmp_path / name, workers=1)
    for content in (b"my notes", b"my notes\n", b"[1]\n"):
        partial.write_bytes(content)
        with pytest.raises(ggo.InputError, match="is no partial file of a sweep"):
            sweep(GRID, BASE, path, workers=1)
        assert partial.read_bytes() == content
    partial.unlink()
    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=stop_at(0.0))
    start = partial.read_bytes()
    for line in (b"{}\n", b'{"row": 99}\n', b"[]\n", b"\xff\n", b'{"row": 1, "ok": true}\n'):
        partial.write_bytes(start + line)
        with pytest.raises(ggo.InputError, match="line 2: is no row of this sweep"):
            sweep(GRID, BASE, path, workers=1)
    with pytest.raises(ggo.InputError, match=r"keep_frames: .* GB of frames"):
        sweep(
            Grid(stride=np.linspace(0.1, 1, 1000), thigh=np.linspace(0.3, 0.5, 1000), steps=4),
            BASE,
            path,
            keep_frames=True,
        )


def test_two_sweeps_do_not_write_one_file(tmp_path):
    path = tmp_path / "out.nc"

    def progress(part):
        with pytest.raises(ggo.InputError, match="another sweep is writing it"):
            sweep(GRID, BASE, path, workers=1)
        raise StoppedError

    with pytest.raises(StoppedError):
        sweep(GRID, BASE, path, workers=1, progress=progress)


# -- the command -------------------------------------------------------------------------------------------------------


def invoke(arguments):
    from click.testing import CliRunner

    from ggo_factors.commands.sweeping import sweep as command

    return CliRunner().invoke(command, arguments)


def test_the_command_sweeps_and_says_what_became_of_the_rows(tmp_path):
    path = tmp_path / "out.nc"
    arguments = [
        "paper",
        "--frames",
        "21",
        "--stride",
        "0.6:0.7:3,9",
        "--steps",
        "1",
        "--workers",
        "1",
        "-o",
        str(path),
    ]
    done = invoke(arguments)
    assert (done.exit_code, done.stderr) == (0, "")
    assert (
        done.stdout == f"4 rows, 3 gaits\nrefused: UnreachableFootholdError 1\nlimits broken: reach 1\nwrote {path}\n"
    )
    assert load(path).stride.values.tolist() == [0.6, 0.65, 0.7, 9.0]
    done = invoke([*arguments, "--json"])
    assert json.loads(done.stdout) == {
        "format_version": 1,
        "rows": 4,
        "ok": 3,
        "errors": {"UnreachableFootholdError": 1},
        "violations": {"reach": 1},
        "output": str(path),
    }


@pytest.mark.parametrize("values", ["wide", "0.1:0.2", "0.1:0.2:0", "0.1:0.2:2.5", "0.1,,0.2", ""])
def test_values_that_are_none_are_bad_input(tmp_path, values):
    done = invoke(["paper", "--stride", values, "-o", str(tmp_path / "out.nc")])
    assert done.exit_code == 2
    assert "is neither a number nor START:STOP:COUNT" in done.stderr


def test_importing_it_takes_no_xarray_and_no_dask_with_it():
    code = (
        "import sys, ggo_factors, ggo_factors.many, ggo_factors.sweep_file, ggo_factors.commands.sweeping; "
        "print([m for m in ('xarray', 'pandas', 'dask', 'distributed') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
