"""Work that could kill the interpreter, done in a child process, where it can kill nothing else.

GTSAM trusts what the function of a `gtsam.CustomFactor` writes into its Jacobians. One that is left unset, or has
another number of rows, ends in a segmentation fault or in an error, as the memory happens to lie.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import time
import warnings
from collections.abc import Callable

SECONDS = 5.0
"""So long a child process has in [s]. One that takes longer waits for something that a copied process lacks, such as
another library's threads."""
MOST_BYTES = 4000
"""An answer of more bytes is cut: a pipe takes so many at once on any system."""


def answer_of_child(work: Callable[[], str]) -> str | None:
    """What a function returns in a copy of this process (`os.fork`): its text, that of its error, or how it died.

    None where there is no answer: on a system without fork, for which there is no GTSAM either, and after `SECONDS`.
    """
    if not hasattr(os, "fork"):
        return None
    out, into = os.pipe()
    with warnings.catch_warnings():
        # From Python 3.12 on a fork beside threads warns of locks that the child might wait for: it is given up then.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if not child:
        _work(work, into)
    os.close(into)
    try:
        status = _ended(child)
        if status is None:
            return None
        if status:
            how = signal.Signals(-status).name if status < 0 else f"exit code {status}"
            return f"kills the interpreter ({how})"
        return os.read(out, MOST_BYTES).decode(errors="replace")
    finally:
        os.close(out)


def _work(work: Callable[[], str], into: int) -> None:
    """In the child: do the work without a word, hand over its answer and end, whatever happens."""
    status = 1
    try:
        faulthandler.disable()
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        _no_core_dump()
        try:
            answer = work()
        except BaseException as error:  # SystemExit too: the child must not go on as its parent
            answer = f"{type(error).__name__}: {' '.join(str(error).split())}"
        os.write(into, answer.encode(errors="replace")[:MOST_BYTES])
        status = 0
    finally:
        os._exit(status)


def _no_core_dump() -> None:
    import resource  # not on every system

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _ended(child: int) -> int | None:
    """Exit code of the child process, below 0 where a signal ended it; None where it was given up."""
    until, pause = time.perf_counter() + SECONDS, 1e-4
    while time.perf_counter() < until:
        try:
            done, status = os.waitpid(child, os.WNOHANG)
        except ChildProcessError:  # something else waits for all children, and has the answer
            return None
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(pause)
        pause = min(2.0 * pause, 0.05)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None
