"""How late the machine itself is: tests of real time are skipped with this figure where it is above their limit.

Measured before a test, in a process of its own while the test goes on, and again after one that failed.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from types import TracebackType
from typing import Self

LIMIT_MS = float(os.environ.get("EMG2VSA_LATEST_MS", 15.0))
"""An idle machine of two cores is late by 1 to 5 ms; one with twice the load of its cores by 50 ms and more."""
_WORK_MS, _SLEEPS, _SLEEP_MS = 60.0, 50, 2.0
_WATCH = f"""\
import sys, threading, time
ended = threading.Thread(target=sys.stdin.read)
ended.start()
latest_s = 0.0
while ended.is_alive():
    begun_s = time.perf_counter()
    time.sleep({_SLEEP_MS / 1e3})
    latest_s = max(latest_s, time.perf_counter() - begun_s - {_SLEEP_MS / 1e3})
print(1e3 * latest_s)
"""


def lateness_ms() -> float:
    """The larger of: how late 60 ms of work end, and the latest of 50 sleeps of 2 ms."""
    begun_s, worked_s = time.perf_counter(), time.thread_time()
    while time.thread_time() - worked_s < _WORK_MS / 1e3:
        pass
    latest_ms = 1e3 * (time.perf_counter() - begun_s) - _WORK_MS
    for _ in range(_SLEEPS):
        begun_s = time.perf_counter()
        time.sleep(_SLEEP_MS / 1e3)
        latest_ms = max(latest_ms, 1e3 * (time.perf_counter() - begun_s) - _SLEEP_MS)
    return latest_ms


class Watched:
    """The latest sleep of another process within a with statement; ``latest_ms`` is there after it."""

    latest_ms = 0.0

    def __enter__(self) -> Self:
        command = [sys.executable, "-S", "-E", "-c", _WATCH]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        told, _ = self._process.communicate()
        self.latest_ms = float(told or 0.0)
