"""Processes and a cluster: nothing is lost with a worker that dies, and none stays behind."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from functools import partial

import pytest
from many_rows import BASE, GRID, grid_rows, told

from ggo_factors.sweeps.netcdf import sweep
from ggo_factors.sweeps.tasks import Task, generate_many
from ggo_factors.sweeps.workers import run


class Deadly:
    """Becomes a list of no obstacles in the process that reads it, which may kill that process.

    Once where there is a marker, which that leaves; or every time, when a marker of another is there.
    """

    def __init__(self, marker=None, after=None):
        self.marker, self.after = marker, after

    def __reduce__(self):
        return _die, (os.getpid(), self.marker, self.after)


def _die(parent, marker, after):
    if os.getpid() != parent and after is not None:
        wait_until(after.exists)
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
    # Row 9 dies first: had row 20 taken it along twice before, its own death would come when it is tried alone.
    tasks[20] = Task("step_over", {"obstacles": Deadly(after=once), "foothold": (0.32, 0.0)})
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


class Watched(list):
    """A list that notes which of its items are taken from it."""

    def __init__(self, items):
        super().__init__(items)
        self.log = []

    def __getitem__(self, number):
        item = super().__getitem__(number)
        self.log.append(item)
        return item


def test_an_item_that_kills_its_worker_is_tried_alone(tmp_path):
    items, found = Watched(["killer", "bystander"]), {}
    for batch in run(partial(_killer_and_bystander, tmp_path), items, "{} lost".format, workers=2):
        items.log.append("back")
        found.update(batch)
    assert found == {0: "killer lost", 1: "bystander made"}
    assert {path.name: path.stat().st_size for path in tmp_path.iterdir()} == {"killer": 3, "bystander": 3}
    # Twice they are handed out together; then the second waits until the first is back. A lost item is taken once more.
    killer, bystander = ["killer", "killer", "back"], ["bystander", "back"]
    assert items.log[4:] in (killer + bystander, bystander + killer)


def _killer_and_bystander(folder, items):
    """Twice the killer dies when the bystander has begun, and takes it along; the third time it dies at once."""
    (name,) = items
    with (folder / name).open("ab") as tries:
        tries.write(b".")
        tries.flush()
        number = tries.tell()
    if name == "killer":
        if number < 3:
            other = folder / "bystander"
            wait_until(lambda: other.exists() and other.stat().st_size >= number)
        os.kill(os.getpid(), signal.SIGKILL)
    if number < 3:
        wait_until(lambda: False)  # the pool ends this process when the killer dies
    return [f"{name} made"]


def wait_until(event):
    """Wait for something that another process does, and give up after a minute."""
    end = time.monotonic() + 60.0
    while not event():
        assert time.monotonic() < end
        time.sleep(0.002)


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
        def interrupt(number, frame):
            print("interrupted", flush=True)
            raise KeyboardInterrupt

        signal.signal(signal.SIGINT, interrupt)
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
    os.killpg(process.pid, signal.SIGINT)
    assert b"interrupted\n" in iter(process.stdout.readline, b"")
    os.killpg(process.pid, signal.SIGINT)
    # The workers hold the other end of this pipe: it closes when the last of them is gone.
    process.communicate(timeout=120)
    assert process.returncode != 0


def test_a_cluster_whose_worker_is_killed_loses_nothing(tmp_path):
    from distributed import Client, LocalCluster

    killed = []
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", local_directory=tmp_path) as cluster,
        Client(cluster) as client,
    ):
        client.wait_for_workers(2, timeout=120)
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
