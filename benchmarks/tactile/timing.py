"""Processor time on one thread, the best of interleaved repeats, so that a busy machine disturbs all runs alike."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import cv2

Run = Callable[[], Any]
CALLS_AT_ONCE_S = 2e-3
"Shorter runs are called several times between two readings of the clock."


@contextmanager
def one_thread() -> Iterator[None]:
    """OpenCV on one thread, as the other methods are; processor time would add the threads up."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def best_times(runs: Mapping[str, Run], *, n_repeats: int = 9, budget_s: float = 1.5) -> dict[str, float]:
    """Smallest processor time of each run, s. Called after every run was warmed up once.

    n_repeats : most repeats of a run; one that has used ``budget_s`` is not repeated again.
    """
    best, used, calls = dict.fromkeys(runs, float("inf")), dict.fromkeys(runs, 0.0), dict.fromkeys(runs, 1)
    for _ in range(n_repeats):
        for name, run in runs.items():
            if used[name] >= budget_s:
                continue
            elapsed = processor_time(run, calls[name])
            used[name] += elapsed
            best[name] = min(best[name], elapsed / calls[name])
            calls[name] = max(1, int(CALLS_AT_ONCE_S / max(best[name], 1e-7)))
    return best


def processor_time(run: Run, n_calls: int = 1) -> float:
    """Processor time of so many calls, s."""
    start = time.process_time()
    for _ in range(n_calls):
        run()
    return time.process_time() - start


def peak_memory_mb() -> float:
    """Most memory this process ever held, MB; NaN on systems that do not say."""
    try:
        resource = import_module("resource")
    except ImportError:
        return float("nan")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # macOS counts bytes, Linux KiB
    return float(peak / 1e6 if sys.platform == "darwin" else peak * 1024 / 1e6)
