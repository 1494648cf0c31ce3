"""Run work in batches on processes of this machine or on a cluster; no result is lost when a worker dies.

Nothing here is about gaits: `work` is any picklable function from a list of items to a list with a result for each.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from ggo_factors.errors import GgoError, InputError
from ggo_factors.support.inputs import as_count

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar("Item")
Result = TypeVar("Result")
Batches = Generator[list[tuple[int, Result]], None, None]

MOST_A_BATCH = 10
"""Most items in a batch: sending it costs little beside its work, and the workers finish at about the same time."""
BATCHES_A_WORKER = 2
"""Batches handed out for each worker: one that it works on, and one so that it need not wait for the next."""
ALONE = 2
"""Deaths after which an item is tried with nothing beside it.

A dying process takes all batches of its pool with it. After the first death an item is tried in a batch of its own;
after the second alone, which tells an item that kills its worker from one that only ran beside it.
"""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Environment variables set to 1 in workers: one process a processor leaves nothing for more threads to do."""


@dataclass(frozen=True)
class _Batch:
    numbers: tuple[int, ...]
    deaths: int = 0  # how often a worker died while it was handed out


@dataclass(frozen=True)
class _Crew:
    """A pool of processes or a cluster.

    Attributes:
        start: makes the executor that takes the batches.
        size: how many batches can run at once, now.
        death: what the future of a batch raises when its worker died.
        mortal: whether the death of one worker ends the executor, so that `start` must be called again.
    """

    start: Callable[[], Executor]
    size: Callable[[], int]
    death: type[Exception]
    mortal: bool


def run(
    work: Callable[[list[Item]], list[Result]],
    items: Sequence[Item],
    lost: Callable[[Item], Result],
    workers: int | None = None,
    client: Client | None = None,
) -> Batches[Result]:
    """The result of each item with its number, batch by batch as they are finished.

    Args:
        work: called with each batch; must not raise.
        items: the items, to be cut into batches.
        lost: gives the result of an item that kills every worker that it is given to.
        workers: number of processes on this machine; one for each processor if None; 1 runs all in this process.
        client: a cluster to use instead.

    Raises:
        InputError: where both are given, or one is unusable.
        GgoError: where workers cannot start, or the cluster refuses the work.
    """
    if client is not None:
        if workers is not None:
            raise InputError("workers: a cluster has its own; give workers or client")
        return _Runner(work, items, lost, _cluster(client)).results()
    count = processors() if workers is None else as_count(workers, "workers", 1, 1024)
    count = min(count, len(items))
    if count > 1 and multiprocessing.current_process().daemon:
        raise InputError("workers: a daemonic process may have none of its own; say workers=1")
    return _Runner(work, items, lost, _processes(count)).results() if count > 1 else _here(work, items)


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _here(work: Callable[[list[Item]], list[Result]], items: Sequence[Item]) -> Batches[Result]:
    for number, item in enumerate(items):
        (result,) = work([item])
        yield [(number, result)]


def _processes(count: int) -> _Crew:
    # A fork of this process may hang if it has threads. The fork server has none, imports this library once and stays
    # for the next pool, which starts in 0.2 s (0.3 s more if each worker is a new interpreter); Windows has no fork.
    # A child of `multiprocessing` may have inherited the server of its parent, which it cannot use.
    own = multiprocessing.parent_process() is None
    server = own and "forkserver" in multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("forkserver" if server else "spawn")

    def start() -> Executor:
        context.set_forkserver_preload([__name__])
        return ProcessPoolExecutor(count, mp_context=context, initializer=_settle)

    return _Crew(start, lambda: count, BrokenExecutor, mortal=True)


def _cluster(client: Client) -> _Crew:
    try:
        from distributed import Client as DaskClient
        from distributed import KilledWorker
    except ImportError as error:
        raise InputError("client: needs dask.distributed: pip install 'ggo-factors[cluster]'") from error
    if not isinstance(client, DaskClient) or client.asynchronous:
        kind = type(client).__name__
        raise InputError(f"client: expected a dask.distributed Client that is not asynchronous, got a {kind}")

    untyped: Any = client

    def size() -> int:
        # A cluster may grow: one that has no workers yet gets something to do as well.
        threads: dict[str, int] = untyped.nthreads()
        return max(1, sum(threads.values()))

    return _Crew(lambda: untyped.get_executor(pure=False), size, KilledWorker, mortal=False)


class _Runner(Generic[Item, Result]):
    """Hands out batches, and hands out again those whose worker died."""

    def __init__(
        self,
        work: Callable[[list[Item]], list[Result]],
        items: Sequence[Item],
        lost: Callable[[Item], Result],
        crew: _Crew,
    ) -> None:
        self._work, self._items, self._lost, self._crew = work, items, lost, crew
        self._next = 0  # the first item that nobody has had yet
        self._again: deque[_Batch] = deque()  # to be tried once more, among others
        self._suspects: deque[_Batch] = deque()  # to be tried alone
        self._running: dict[Future[list[Result]], _Batch] = {}
        self._answered = False

    def results(self) -> Batches[Result]:
        """The results with their numbers, as they come; see `run`."""
        executor = self._crew.start()
        try:
            while True:
                self._hand_out(executor)
                if not self._running:
                    return
                if self._crew.mortal:
                    _see_workers(executor)
                done, _ = wait(self._running, return_when=FIRST_COMPLETED)
                broken = self._crew.mortal and any(self._died(future) for future in done)
                if broken:
                    done, _ = wait(self._running)
                for future in done:
                    batch = self._running.pop(future)
                    if not self._died(future):
                        self._answered = True
                        yield list(zip(batch.numbers, self._answer(future), strict=True))
                    elif batch.deaths == ALONE:
                        yield [(number, self._lost(self._items[number])) for number in batch.numbers]
                    else:
                        deaths = batch.deaths + 1
                        queue = self._suspects if deaths == ALONE else self._again
                        queue.extend(_Batch((number,), deaths) for number in batch.numbers)
                if broken:
                    executor.shutdown()
                    executor = self._crew.start()
                    if not self._answered:
                        _require_start(executor)
        finally:
            if self._crew.mortal:
                with _uninterrupted():
                    executor.shutdown(cancel_futures=True)
            else:
                executor.shutdown(wait=False)  # with dask this cancels what is left

    def _hand_out(self, executor: Executor) -> None:
        """Hand out batches as long as there is room."""
        size = self._crew.size()
        while len(self._running) < BATCHES_A_WORKER * size:
            batch = self._take(size)
            if batch is None:
                return
            try:
                with _single_threaded():
                    future = executor.submit(self._work, [self._items[number] for number in batch.numbers])
            except (BrokenExecutor, OSError) as error:
                # The pool is breaking (an OSError if one of its pipes is closed already): this batch dies with it.
                future = Future()
                future.set_exception(BrokenExecutor(str(error)))
                self._running[future] = batch
                return
            self._running[future] = batch

    def _take(self, size: int) -> _Batch | None:
        """The next batch to hand out; None if there is none, or if it must wait until nothing else runs."""
        left = len(self._items) - self._next
        if left:
            # The last batches are small, so that all workers finish at about the same time.
            count = min(max(left // (4 * size), 1), MOST_A_BATCH)
            self._next += count
            return _Batch(tuple(range(self._next - count, self._next)))
        if self._again:
            return self._again.popleft()
        if self._suspects and not self._running:
            return self._suspects.popleft()
        return None

    def _died(self, future: Future[list[Result]]) -> bool:
        return not future.cancelled() and isinstance(future.exception(), self._crew.death)

    def _answer(self, future: Future[list[Result]]) -> list[Result]:
        try:
            return future.result()
        except CancelledError as error:
            raise GgoError("the cluster has dropped the work: its client or scheduler was closed") from error
        except GgoError:
            raise
        except Exception as error:
            # `work` does not raise, so the worker could not run it: it cannot import it, for example.
            raise GgoError(f"a worker cannot do the work: {type(error).__name__}: {error}") from error


def _see_workers(executor: Executor) -> None:
    """Make a process pool watch all its workers.

    A pool starts a worker in `submit` after it has woken the thread that watches them: the death of the last one is not
    seen until something else happens. One more call wakes that thread again.
    """
    with suppress(BrokenExecutor, OSError), _single_threaded():
        executor.submit(os.getpid)


def _require_start(executor: Executor) -> None:
    """Check that a new worker can run anything at all, after workers died before any result came back.

    Raises:
        GgoError: where a worker dies without any work.
    """
    try:
        with _single_threaded():
            executor.submit(os.getpid).result()
    except BrokenExecutor as error:
        raise GgoError(
            "worker processes die as they start: a script must be a file and call this under "
            "`if __name__ == '__main__':` (each worker imports it), or say workers=1"
        ) from error
    except OSError as error:
        raise GgoError(
            f"worker processes cannot start: {type(error).__name__}: {error}; workers=1 needs none"
        ) from error


def _settle() -> None:
    """Make a new worker process ignore Ctrl-C, which its parent handles, and end when its parent is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Ignore Ctrl-C in this block: a shutdown that is interrupted leaves workers that wait for ever."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler if before is None else before)


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Make processes that start in this block use one thread each: libraries read these variables when loaded."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
