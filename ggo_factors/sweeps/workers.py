"""Work in batches on processes of this machine or on a cluster; a worker that dies loses nothing.

It knows no gaits. `work` is a picklable function of a list of items that returns a result for each.
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

# Large enough that sending a batch costs nothing beside its work, small enough that the last ones end together.
MOST_A_BATCH = 10
BATCHES_A_WORKER = 2  # handed out at once, so that no worker waits for the next
# An item in a batch whose worker died is tried again: first among others, then with nothing beside it, which tells the
# item that kills its worker from those that were only near it.
ALONE = 2
# More threads than one a process only get in each other's way.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
PIECE = 1 << 16  # small enough to stay in a cache between reading and writing
ANONYMOUS = "00:00"  # the device of memory that no file stands behind


@dataclass(frozen=True)
class _Batch:
    numbers: tuple[int, ...]
    deaths: int = 0  # workers that died over it


@dataclass(frozen=True)
class _Crew:
    """Who does the work.

    Attributes:
        start: makes what takes the batches.
        size: how many batches can be worked on at once, now.
        death: what a batch raises whose worker died.
        mortal: whether a worker's death ends all the others, so that `start` must be called again.
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
    """The result of each item with its number, batch by batch as they are done.

    Args:
        work: what to do with a batch; must not raise.
        items: what to do it with.
        lost: the result of an item that kills every worker it is given to.
        workers: processes of this machine; one a processor if None, and none but this one if 1.
        client: a cluster to do it on instead.

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
    # Not forked from here: a fork in a process with threads may hang. A server that has none, has imported this library
    # and stays for the next pool forks them in no time; Windows has no fork.
    # A child of `multiprocessing` may have inherited its parent's server, which it cannot use.
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
    """Hands out batches, and hands out again what was lost with a worker."""

    def __init__(
        self,
        work: Callable[[list[Item]], list[Result]],
        items: Sequence[Item],
        lost: Callable[[Item], Result],
        crew: _Crew,
    ) -> None:
        self._work, self._items, self._lost, self._crew = work, items, lost, crew
        self._next = 0  # the first item that nobody has had yet
        self._again: deque[_Batch] = deque()
        self._running: dict[Future[list[Result]], _Batch] = {}
        self._answered = False

    def results(self) -> Batches[Result]:
        """The results with their numbers, as they come; see `run`."""
        executor = self._crew.start()
        try:
            while self._hand_out(executor) or self._running:
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
                        self._again.extend(_Batch((number,), batch.deaths + 1) for number in batch.numbers)
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
                executor.shutdown(wait=False)  # dask's way to cancel what is left

    def _hand_out(self, executor: Executor) -> bool:
        """Hand out batches as long as there is room; whether there was one."""
        handed = False
        size = self._crew.size()
        while len(self._running) < BATCHES_A_WORKER * size:
            batch = self._take(size)
            if batch is None:
                break
            try:
                with _single_threaded():
                    future = executor.submit(self._work, [self._items[number] for number in batch.numbers])
                self._running[future] = batch
            except (BrokenExecutor, OSError) as error:
                # A pool that is just breaking: a handle of it may be closed already, which is an OSError.
                future = Future()
                future.set_exception(BrokenExecutor(str(error)))
                self._running[future] = batch
                return True
            handed = True
        return handed

    def _take(self, size: int) -> _Batch | None:
        if any(batch.deaths == ALONE for batch in self._running.values()):
            return None
        left = len(self._items) - self._next
        if left:
            # The last batches are small, so that all workers end together.
            count = min(max(left // (4 * size), 1), MOST_A_BATCH)
            self._next += count
            return _Batch(tuple(range(self._next - count, self._next)))
        if not self._again or (self._again[0].deaths == ALONE and self._running):
            return None
        return self._again.popleft()

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
            # The work itself raises nothing: this is a worker that cannot do it at all.
            raise GgoError(f"a worker cannot do the work: {type(error).__name__}: {error}") from error


def _require_start(executor: Executor) -> None:
    """Tell work that kills its worker from workers that never come to life.

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
    """Make a new worker process leave Ctrl-C to its parent, end where its parent is killed, and own its code."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _own_code()
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def _own_code() -> None:
    """Give this process its own copy of the machine code that it shares with the other workers, about 70 MB.

    Processors that ration the last-level cache, as machines of a cloud do, are slow at memory that several cores read
    (seen: 512 KiB at 50 ns a line where two cores read the same pages, 10 where each reads its own), and workers read
    the same libraries: two of them took 1.4 times as long for a gait as one. To write back what stands there changes
    nothing, but makes the kernel copy the page (copy on write). Where the system has no such files or forbids it, the
    pages stay shared, which costs that speed and nothing else.
    """
    with suppress(OSError), open("/proc/self/maps") as maps, open("/proc/self/mem", "r+b", buffering=0) as memory:
        for span, flags, _, device, *_ in map(str.split, maps.readlines()):
            if flags == "r-xp" and device != ANONYMOUS:
                begin, end = (int(address, 16) for address in span.split("-"))
                for at in range(begin, end, PIECE):
                    memory.seek(at)
                    code = memory.read(min(PIECE, end - at))
                    memory.seek(at)
                    memory.write(code)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Let Ctrl-C wait for the end of this block: workers that are only half told to stop would wait for ever."""
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
    """Let processes that start in this block use one thread each; a library reads this as it is loaded."""
    before: dict[str, Any] = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
