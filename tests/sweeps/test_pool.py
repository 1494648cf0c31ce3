"""Processes and a cluster: nothing is lost with a worker that dies, and none stays behind."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from many_rows import BASE, GRID, grid_rows, told

from ggo_factors.sweeps.netcdf import sweep
from ggo_factors.sweeps.tasks import Task, generate_many
from ggo_factors.sweeps.workers import run


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


def test_a_cluster_whose_worker_is_killed_loses_nothing(tmp_path):
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
    assert told(rows) == told(grid_rows())
    assert found.iterations.values.ravel().tolist() == [row.iterations for row in grid_rows()]
