"""What the timer calls, not how long it takes."""

from __future__ import annotations

import math

import cv2

from benchmarks.tactile.timing import best_times, one_thread, peak_memory_mb


def test_every_run_is_called_and_timed_above_nothing() -> None:
    calls = {"a": 0, "b": 0}

    def call(name: str) -> None:
        calls[name] += 1
        sum(range(2000))

    times = best_times({name: lambda name=name: call(name) for name in calls}, n_repeats=3)  # type: ignore[misc]
    assert min(calls.values()) >= 3
    assert all(0 < time < math.inf for time in times.values())


def test_a_run_beyond_its_budget_is_not_repeated() -> None:
    calls = []
    best_times({"a": lambda: calls.append(sum(range(10000)))}, n_repeats=5, budget_s=1e-9)
    assert len(calls) == 1


def test_opencv_gets_its_threads_back() -> None:
    before = cv2.getNumThreads()
    with one_thread():
        assert cv2.getNumThreads() == 1
    assert cv2.getNumThreads() == before


def test_memory_is_that_of_a_python_process() -> None:
    assert math.isnan(peak_memory_mb()) or 10 < peak_memory_mb() < 1e5
