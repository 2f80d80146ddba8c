"""Calls on several processes, their results in the order of their ends; a process that dies takes only its own call.

What starts processes is loaded when the first is started: most runs find nothing to do.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from types import TracebackType
from typing import TYPE_CHECKING, Self, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import Future, ProcessPoolExecutor

T = TypeVar("T")
_GRACE_S = 1.0
"""So long a worker that Ctrl-C reached has for the end of its call."""


class WorkerDied(Exception):
    """The process of a call died before the call ended."""

    def __str__(self) -> str:
        return "its process died (out of memory, or killed)"


def available_cores() -> int:
    """Cores this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class ProcessPool:
    """Up to ``jobs`` processes, started when they are first needed and kept until the end of the block.

    What a worker has loaded for one call serves the next. Where an exception ends the block, calls under way have a
    second to end, and are ended then. Workers end with this process, even where it is killed.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._close(at_once=kind is not None)

    def ended(
        self, calls: Sequence[Callable[[], T]], load: Sequence[str] = ()
    ) -> Iterator[tuple[int, Callable[[], T]]]:
        """Place of each call and what gives its result, or raises what it raised, as the calls end.

        `WorkerDied` where its process died, perhaps by another one's doing. A pool of one job makes no process: what
        gives the result is the call. load : modules that the workers have in common; the first use of them counts.
        """
        if self._jobs <= 1:
            yield from enumerate(calls)
            return
        from concurrent.futures import FIRST_COMPLETED, wait
        from concurrent.futures.process import BrokenProcessPool

        waiting = deque(enumerate(calls))
        running: dict[Future[T], int] = {}
        while waiting or running:
            while waiting and len(running) < self._jobs:  # no more: a worker would begin those after Ctrl-C
                self._pool = self._pool or _executor(self._jobs, load)
                try:
                    running[self._pool.submit(_called, waiting[0][1])] = waiting[0][0]
                except BrokenProcessPool:  # a worker died that had nothing to do
                    self._close()
                    break
                waiting.popleft()
            done = wait(running, return_when=FIRST_COMPLETED).done
            if any(isinstance(future.exception(), BrokenProcessPool) for future in done):
                self._close()
                done = set(running)
            for future in done:
                yield running.pop(future), partial(_result, future)

    def _close(self, at_once: bool = False) -> None:
        if self._pool is None:
            return
        pool, self._pool = self._pool, None
        pool.shutdown(wait=not at_once, cancel_futures=True)
        if at_once:
            import multiprocessing

            workers, end = multiprocessing.active_children(), time.monotonic() + _GRACE_S
            try:
                for worker in workers:
                    worker.join(max(0.0, end - time.monotonic()))
            finally:
                for worker in workers:
                    worker.kill()


def _executor(jobs: int, load: Sequence[str]) -> ProcessPoolExecutor:
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    method = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
    context = multiprocessing.get_context(method)
    if method == "forkserver":
        # workers are forked from a server that has done the imports once
        context.set_forkserver_preload(list(load))
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin_worker)


def _result(future: Future[T]) -> T:
    from concurrent.futures.process import BrokenProcessPool

    try:
        return future.result()
    except BrokenProcessPool:
        raise WorkerDied from None


def _called(call: Callable[[], T]) -> T:
    """In a worker: the call, which Ctrl-C reaches."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return call()
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _begin_worker() -> None:
    """In a worker: leave Ctrl-C to its calls, and end with the process that started it, even one that was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_outlive_nobody, daemon=True).start()


def _outlive_nobody() -> None:
    import multiprocessing

    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)
