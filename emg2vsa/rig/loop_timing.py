"""The beat of the control loop, and how well it was kept."""

from __future__ import annotations

from array import array
from dataclasses import dataclass

import numpy as np

from emg2vsa.rig.clock import Clock


@dataclass(frozen=True)
class LoopTiming:
    """Period errors are distances of the true period between two turns from the wanted one, s; 0 with fewer turns."""

    turns: int
    median_s: float
    p99_s: float
    p999_s: float
    largest_s: float
    overruns: int
    "Beats that passed while a turn was still going on."


class Beat:
    """Due times a period apart, on the clock and not after one another, so that lateness never adds up."""

    def __init__(self, clock: Clock, period_s: float) -> None:
        self._clock, self._period_s = clock, period_s
        self._errors_s = array("d")
        self._turns = self._overruns = 0
        self.restart()

    def restart(self) -> None:
        """Begin anew at the present time; the gap is no period."""
        self._start_s, self._beat = self._clock.now_s(), 0
        self._last_s: float | None = None

    def wait(self) -> tuple[float, float]:
        """Sleep until the next due time; the time then, and how late that is, s. Beats already over are left out."""
        due_s = self._start_s + self._beat * self._period_s
        self._clock.sleep_until(due_s)
        now_s = self._clock.now_s()
        if self._last_s is not None:
            self._errors_s.append(abs(now_s - self._last_s - self._period_s))
        over = int((now_s - due_s) / self._period_s)
        self._last_s, self._beat = now_s, self._beat + 1 + over
        self._turns += 1
        self._overruns += over
        return now_s, now_s - due_s

    def timing(self) -> LoopTiming:
        """So far."""
        errors_s = np.array(self._errors_s) if self._errors_s else np.zeros(1)
        median, p99, p999, largest = np.quantile(errors_s, (0.5, 0.99, 0.999, 1)).tolist()
        return LoopTiming(self._turns, median, p99, p999, largest, self._overruns)
