"""Tasks on several processes; a process that dies takes only its own task with it."""

from __future__ import annotations

import contextlib
import importlib
import multiprocessing
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass

from emg2vsa.pipeline.tasks import Ended, Task


def available_cores() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class Modules:
    """What to import where, so that imports are done once and side by side: in the workers, and here meanwhile."""

    workers: tuple[str, ...] = ()
    here: tuple[str, ...] = ()


NOTHING = Modules()


def run_tasks(
    tasks: Sequence[Task],
    jobs: int,
    on_end: Callable[[Ended], None],
    *,
    alone: int = 1,
    modules: Modules = NOTHING,
) -> None:
    """Run all tasks and report each step as it ends.

    Up to ``alone`` of them run in this process: starting workers would take longer.
    """
    if jobs == 1 or len(tasks) <= alone:
        for task in tasks:
            _report(task(), on_end)
        return
    left = _run_in_pool(tasks, jobs, on_end, modules)
    for task in left:  # some process died: one at a time, so that the task that kills it is known
        if _run_in_pool([task], 1, on_end, NOTHING):
            died = "its process died (out of memory, or killed). Run again with --jobs 1 if memory is short."
            _report([Ended(step, "failed", died) for step in task.steps], on_end)


def _run_in_pool(tasks: Sequence[Task], jobs: int, on_end: Callable[[Ended], None], modules: Modules) -> list[Task]:
    with _executor(min(jobs, len(tasks)), modules.workers) as pool:
        waiting = {pool.submit(task): task for task in tasks}
        try:
            for name in modules.here:
                with contextlib.suppress(ImportError):  # the step that needs it will say so
                    importlib.import_module(name)
            for future in as_completed(list(waiting)):
                _report(future.result(), on_end)
                del waiting[future]
        except BrokenProcessPool:
            return list(waiting.values())
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return []


def _executor(jobs: int, preload: Sequence[str]) -> ProcessPoolExecutor:
    method = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
    context = multiprocessing.get_context(method)
    if method == "forkserver":
        # workers are forked from a server that has done the imports once
        context.set_forkserver_preload(list(preload))
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=end_with_parent)


def end_with_parent() -> None:
    """In a worker: end it with the process that started it, even one that was killed and cannot say so."""
    threading.Thread(target=_outlive_nobody, daemon=True).start()


def _outlive_nobody() -> None:
    if parent := multiprocessing.parent_process():
        parent.join()
        os._exit(1)


def _report(ended: Sequence[Ended], on_end: Callable[[Ended], None]) -> None:
    for end in ended:
        on_end(end)
