"""Processor time of the ways of one case, in turn, so that a busy machine disturbs all of them alike."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from casr.decoder_process import child_pid
from emg2vsa.arrays import Floats

SHORTEST_S = 2e-3
"A way is called several times between two readings of the clock until these seconds have passed."


def processor_s() -> float:
    """Processor time so far of this process, of its children that have ended, and of the child that decodes files (the
    last on Linux alone)."""
    spent = time.process_time() + _ended_children_s()
    pid = child_pid()
    if pid is None or sys.platform != "linux":
        return spent
    return spent + time.clock_gettime(~pid << 3 | 2)  # clock_getcpuclockid(3)


def _ended_children_s() -> float:
    """0 on Windows, which does not tell."""
    if sys.platform == "win32":
        return 0.0
    else:
        from resource import RUSAGE_CHILDREN, getrusage  # os.times counts in hundredths

        used = getrusage(RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime


@dataclass(frozen=True)
class Spread:
    """Of a ratio: median, 5 % and 95 % quantile over the rounds."""

    median: float
    low: float
    high: float


@dataclass(frozen=True)
class Timed:
    """Processor seconds of one call. first_s : of the first call, which counts nowhere else. rounds_s : mean of each
    round, NaN for rounds after the way's budget was spent."""

    first_s: float
    rounds_s: tuple[float, ...]

    @property
    def known_s(self) -> Floats:
        return np.array([seconds for seconds in self.rounds_s if np.isfinite(seconds)])

    @property
    def least_s(self) -> float:
        return float(np.min(self.known_s))

    @property
    def median_s(self) -> float:
        return float(np.median(self.known_s))

    @property
    def iqr_s(self) -> float:
        low, high = np.quantile(self.known_s, (0.25, 0.75))
        return float(high - low)

    def ratio_to(self, other: Timed) -> Spread:
        """Times slower than the other, taken within each round that both have."""
        ratios = np.array(self.rounds_s) / np.array(other.rounds_s)
        low, median, high = np.quantile(ratios[np.isfinite(ratios)], (0.05, 0.5, 0.95))
        return Spread(float(median), float(low), float(high))


def first_call(run: Callable[[], Any], clock: Callable[[], float] = processor_s) -> tuple[float, Any]:
    """Seconds and output of the first call, in which libraries load, compile and fill caches."""
    start = clock()
    output = run()
    return clock() - start, output


def timed(
    runs: Sequence[Callable[[], Any]],
    first_s: Sequence[float],
    *,
    rounds: int,
    budget_s: float,
    clock: Callable[[], float] = processor_s,
) -> list[Timed]:
    """Times of runs that were each called once already, which took ``first_s``.

    rounds : in each, every run has one turn, in an order that is drawn: what a run leaves in the processor's caches
    must not always meet the same other one. A run that has used ``budget_s`` has no further turn, but each has one.
    """
    calls = []
    for run, first in zip(runs, first_s, strict=True) if rounds else ():
        again = _mean(run, 1, clock) if first < 0.2 else first
        calls.append(max(1, min(10_000, round(SHORTEST_S / max(again, 1e-7)))))
    times = np.full((len(runs), rounds), np.nan)
    spent = np.zeros(len(runs))
    order = np.random.default_rng(len(runs))
    for turn in range(rounds):
        for way in order.permutation(len(runs)).tolist():
            if turn and spent[way] >= budget_s:
                continue
            times[way, turn] = _mean(runs[way], calls[way], clock)
            spent[way] += times[way, turn] * calls[way]
    return [Timed(first, tuple(map(float, row))) for first, row in zip(first_s, times, strict=True)]


def _mean(run: Callable[[], Any], n_calls: int, clock: Callable[[], float]) -> float:
    start = clock()
    for _ in range(n_calls):
        run()
    return (clock() - start) / n_calls
