"""Time as an argument: the same code runs against the wall and against a clock that jumps."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Seconds since some start, never going back."""

    def now_s(self) -> float:
        """Time since the clock's start, s."""

    def sleep_until(self, time_s: float) -> None:
        """Return at ``time_s``, or at once when that has passed."""


class WallClock:
    """Real time."""

    def __init__(self) -> None:
        self._start_s = time.perf_counter()

    def now_s(self) -> float:
        return time.perf_counter() - self._start_s

    def sleep_until(self, time_s: float) -> None:
        # sleeping is good to about 0.1 ms; the rest is spent waiting, so that a 200 Hz loop keeps its period
        while (left_s := time_s - self.now_s()) > 0:
            if left_s > _WAIT_S:
                time.sleep(left_s - _WAIT_S)


class VirtualClock:
    """Time that passes only when somebody sleeps: ten minutes in seconds."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now_s(self) -> float:
        return self._now_s

    def sleep_until(self, time_s: float) -> None:
        self._now_s = max(self._now_s, time_s)


_WAIT_S = 2e-4
