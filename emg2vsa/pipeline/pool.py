"""Tasks on several processes; a process that dies takes only its own task with it.

What starts processes is loaded when the first is started: most runs find nothing to do.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from emg2vsa.pipeline.tasks import Ended, Task

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

OnEnd = Callable[[Ended], None]


def available_cores() -> int:
    """Cores this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Workers:
    """Up to ``jobs`` processes, started when they are first needed and kept until the end.

    What a worker has loaded for one stage serves the next.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._close(at_once=kind is not None)

    def run(self, tasks: Sequence[Task], on_end: OnEnd, *, alone: int = 1, load: Sequence[str] = ()) -> None:
        """Run all tasks, and report each as it ends.

        alone : up to so many run in this process, as starting workers would take longer. load : modules that the
        workers have in common, of all that they will do; only the first use of them counts.
        """
        if self._jobs == 1 or len(tasks) <= alone:
            for task in tasks:
                on_end(task())
            return
        for task in self._side_by_side(tasks, on_end, load):
            # some process died: one at a time, so that the task that kills it is known
            if self._side_by_side([task], on_end, load):
                task.claim.unlink(missing_ok=True)
                died = "its process died (out of memory, or killed). Run again with --jobs 1 if memory is short."
                on_end(Ended(task.step, "failed", died))

    def _side_by_side(self, tasks: Sequence[Task], on_end: OnEnd, load: Sequence[str]) -> list[Task]:
        """The tasks that were not done because a process died."""
        from concurrent.futures import as_completed
        from concurrent.futures.process import BrokenProcessPool

        if self._pool is None:
            self._pool = _executor(self._jobs, load)
        waiting = {self._pool.submit(task): task for task in tasks}
        try:
            for future in as_completed(list(waiting)):
                on_end(future.result())
                del waiting[future]
        except BrokenProcessPool:
            self._close()
            for task in waiting.values():
                task.claim.unlink(missing_ok=True)
            return list(waiting.values())
        return []

    def _close(self, at_once: bool = False) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=not at_once, cancel_futures=True)
            self._pool = None
        if at_once:  # a worker ends its task first, and those it has fetched; so would this process
            import multiprocessing

            for worker in multiprocessing.active_children():
                worker.kill()


def _executor(jobs: int, load: Sequence[str]) -> ProcessPoolExecutor:
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    method = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
    context = multiprocessing.get_context(method)
    if method == "forkserver":
        # workers are forked from a server that has done the imports once
        context.set_forkserver_preload(list(load))
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=end_with_parent)


def end_with_parent() -> None:
    """In a worker: end it with the process that started it, even one that was killed and cannot say so."""
    threading.Thread(target=_outlive_nobody, daemon=True).start()


def _outlive_nobody() -> None:
    import multiprocessing

    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)
