"""Time as an argument, the beat of a control loop on it, and a process that keeps it.

The same code runs against the wall and against a clock that jumps.
"""

from __future__ import annotations

import gc
import os
import sys
import time
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol, TypeVar

T = TypeVar("T")
_WAIT_S = 2e-4
LEAST_PRIORITY = 1
"""The lowest of the real-time priorities is above every ordinary program."""
LATE_PERIODS = 0.5
"""A turn that begins so much of a period after its due time is late."""
_SWITCH_S = 2e-4
"""A thread that fetches frames, or watches the log, hands the interpreter over after this time instead of 5 ms."""


class Clock(Protocol):
    """Seconds since some start, never going back."""

    def now_s(self) -> float:
        """Time since the clock's start, s."""

    def sleep_until(self, time_s: float) -> None:
        """Return at ``time_s``, s on this clock, or at once when that has passed."""


class WallClock:
    """Real time."""

    def __init__(self) -> None:
        self._start_s = time.perf_counter()

    def now_s(self) -> float:
        """Time, s, since this clock was made."""
        return time.perf_counter() - self._start_s

    def sleep_until(self, time_s: float) -> None:
        """Return at ``time_s``, s: asleep until shortly before, then waiting."""
        # sleeping is good to about 0.1 ms; the rest is spent waiting, so that a 200 Hz loop keeps its period
        while (left_s := time_s - self.now_s()) > 0:
            if left_s > _WAIT_S:
                time.sleep(left_s - _WAIT_S)


class FastClock:
    """Wall time that runs ``factor`` times as fast."""

    def __init__(self, factor: float) -> None:
        self._wall, self.factor = WallClock(), factor

    def now_s(self) -> float:
        """Time, s: ``factor`` times that of the wall."""
        return self._wall.now_s() * self.factor

    def sleep_until(self, time_s: float) -> None:
        """Return at ``time_s``, s on this clock."""
        self._wall.sleep_until(time_s / self.factor)


class VirtualClock:
    """Time that passes only when somebody sleeps: ten minutes in seconds."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now_s(self) -> float:
        """Time, s, up to which somebody has slept."""
        return self._now_s

    def sleep_until(self, time_s: float) -> None:
        """Return at once; the time is ``time_s``, s, then, or stays where it was later."""
        self._now_s = max(self._now_s, time_s)


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
    late: int = 0
    "Turns that began half a period or more after their due time."
    latest_s: float = 0.0
    "Largest delay of a turn after its due time."


class Beat:
    """Due times a period apart, on the clock and not after one another, so that lateness never adds up."""

    def __init__(self, clock: Clock, period_s: float) -> None:
        self._clock, self._period_s = clock, period_s
        self._errors_s = array("d")
        self._turns = self._overruns = self._late = 0
        self._latest_s = 0.0
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
        self._last_s, late_s = now_s, now_s - due_s
        self._beat += 1
        self._turns += 1
        if late_s > 0:
            over = int(late_s / self._period_s)
            self._beat += over
            self._overruns += over
            self._late += late_s >= LATE_PERIODS * self._period_s
            self._latest_s = max(self._latest_s, late_s)
        return now_s, late_s

    def timing(self) -> LoopTiming:
        """So far."""
        errors_s = sorted(self._errors_s) or [0.0]
        median, p99, p999, largest = (_quantile(errors_s, share) for share in (0.5, 0.99, 0.999, 1.0))
        return LoopTiming(self._turns, median, p99, p999, largest, self._overruns, self._late, self._latest_s)


def awaited(clock: Clock, within_s: float, every_s: float, look: Callable[[], T]) -> T | None:
    """What ``look`` gives once that is something, asked again every ``every_s``; None where it gives nothing for
    ``within_s``. Both in s."""
    end_s = clock.now_s() + within_s
    while not (found := look()):
        if clock.now_s() >= end_s:
            return None
        clock.sleep_until(clock.now_s() + every_s)
    return found


def _quantile(ordered: list[float], share: float) -> float:
    """Linear between neighbours, as NumPy's, which folders of runs are known without."""
    place = share * (len(ordered) - 1)
    below = int(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (place - below) * (ordered[above] - ordered[below])


@contextmanager
def undisturbed() -> Iterator[bool]:
    """What a control loop asks of the operating system and of Python (decision 0015).

    For the time of a run: scheduled in real time where the system permits it, True then; threads that give way soon;
    short collections of garbage.

    To be entered before the devices are opened: threads started within are scheduled alike, so that none holds the
    interpreter while an ordinary program has its processor. What is in memory already is left out of the collections
    of garbage; a search of all of it was measured to take 35 ms.
    """
    gc.collect()
    gc.freeze()
    usual_s = sys.getswitchinterval()
    sys.setswitchinterval(_SWITCH_S)
    permitted = _scheduled(LEAST_PRIORITY)
    try:
        yield permitted
    finally:
        if permitted:
            _scheduled(0)
        sys.setswitchinterval(usual_s)
        gc.unfreeze()


@contextmanager
def ahead() -> Iterator[None]:
    """The calling thread goes before those that it has started, where `undisturbed` was permitted.

    A frame that a thread makes grey takes a millisecond or two, which is a large part of a turn.
    """
    real_time = sys.platform == "linux" and os.sched_getscheduler(0) == os.SCHED_FIFO
    if real_time:
        _scheduled(LEAST_PRIORITY + 1)
    try:
        yield
    finally:
        if real_time:
            _scheduled(LEAST_PRIORITY)


def _scheduled(priority: int) -> bool:
    """Whether the system gives the calling thread this priority in real time; 0 : that of an ordinary program."""
    if sys.platform == "win32" or not hasattr(os, "sched_setscheduler"):
        return False
    policy = os.SCHED_FIFO if priority else os.SCHED_OTHER
    try:
        os.sched_setscheduler(0, policy, os.sched_param(priority))
    except OSError:
        return False
    return True
