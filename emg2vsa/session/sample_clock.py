"""When each sample of a stream was measured, on the session's clock, from the times at which blocks of it arrived.

A device samples by its own clock and says no time. A block cannot arrive before its last sample was measured, and
arrives later by buffers, bursts and a busy computer; so the line below all arrivals against the running numbers of the
samples (their lower envelope) is the device's clock. Of all such lines the one with the smallest sum of distances is
taken: it is that edge of the convex hull which lies below the mean (Moon, Skelly and Towsley, INFOCOM 1999).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

BIN_S, MOST_BINS = 0.1, 512
"Of each so long a time the earliest arrival is kept; beyond so many, the time is doubled: an hour keeps 12.8 s."
LEARN_S = 3.0
"Until then the stated rate is believed, and no sample is counted as lost."
CRYSTAL = 1e-4
"Error of a stated rate that needs no telling; a measured rate counts as far as it is known better."
RATE_OFF = 0.005
"A measured rate that differs by so much from the stated one is told."
LATE_S = 0.008
"Arrivals so far above the line are late: a busy computer, or samples that were lost (a Trigno frame is 13.5 ms)."
STEP_S, STEP_BLOCKS = 1.0, 5
"Arrivals that are late for so long, and in so many blocks, are late for ever: samples were lost."
GAP_S = 0.05
"A longer time without an arrival is a gap."


class ClockReport(NamedTuple):
    """The device's clock beside its promise.

    rate_hz, rate_se_hz : measured rate and its standard error; None in the first ``LEARN_S``.
    se_s : how far the earliest arrivals typically lie above the line: the uncertainty of a sample's time beside the
    fixed delay. None in the first ``LEARN_S``.
    missing : samples that the source did not know to be lost, estimated by the time that they took.
    gaps, longest_gap_s : times longer than ``GAP_S`` without an arrival, and the longest time.
    """

    rate_hz: float | None = None
    rate_se_hz: float | None = None
    se_s: float | None = None
    missing: int = 0
    gaps: int = 0
    longest_gap_s: float = 0.0


class SampleClock:
    """Index of a sample to its time; learns with every block, in a memory that does not grow.

    Parameters
    ----------
    fs_hz : stated rate. delay_s : fixed delay from the body to arrival, which is taken off.
    quantum : samples that can be lost at once: 1, or those of a device's frame.

    Times of samples change a little with every block that is added (by less than ``se_s`` once learnt); a file that is
    written at the end has the best of them.
    """

    def __init__(self, fs_hz: float, *, delay_s: float = 0.0, quantum: int = 1) -> None:
        self.fs_hz = fs_hz
        self._delay_s, self._quantum = delay_s, quantum
        self._bin = BIN_S * fs_hz
        self._xs: list[float] = []
        "Place of the earliest arrival of each bin: index of the sample and those missing before it."
        self._ys: list[float] = []
        self._fitted = 3
        "Bins there were when the line was laid."
        self._learnt = False
        self._late: _Late | None = None
        self._steps: list[tuple[int, int]] = []
        "(first sample after a loss, samples missing there), oldest first."
        self._missing = 0
        self._slope = 1 / fs_hz
        self._level_s: float | None = None
        self._slope_se: float | None = None
        self._measured: float | None = None
        self._se_s: float | None = None
        self._arrived_s: float | None = None
        self._gaps, self._longest_s = 0, 0.0

    def add(self, first: int, n: int, arrived_s: float) -> None:
        """A block of ``n`` samples came, the first of them with the running number ``first``. Nothing for n = 0."""
        if n < 1:
            return
        arrived_s = float(arrived_s)
        if self._arrived_s is not None:
            gap_s = arrived_s - self._arrived_s
            self._gaps += gap_s > GAP_S
            self._longest_s = max(self._longest_s, gap_s)
        self._arrived_s = arrived_s
        self._place(first, first + n - 1, arrived_s)

    @overload
    def time_s(self, index: int) -> float: ...
    @overload
    def time_s(self, index: NDArray[np.int64]) -> NDArray[np.float64]: ...
    def time_s(self, index: int | NDArray[np.int64]) -> float | NDArray[np.float64]:
        """When samples were measured, s on the session's clock; NaN before the first block."""
        level_s = math.nan if self._level_s is None else self._level_s - self._delay_s
        if isinstance(index, np.ndarray):
            starts = [start for start, _ in self._steps]
            missing = np.cumsum([0] + [lost for _, lost in self._steps])[np.searchsorted(starts, index, side="right")]
            return np.asarray(level_s + self._slope * (index + missing), dtype=np.float64)
        passed = bisect_right(self._steps, index, key=lambda step: step[0])
        return level_s + self._slope * (index + sum(lost for _, lost in self._steps[:passed]))

    def report(self) -> ClockReport:
        """So far."""
        counts = (self._missing, self._gaps, self._longest_s)
        if self._measured is None or self._slope_se is None:
            return ClockReport(None, None, None, *counts)
        rate_hz = 1 / self._measured
        return ClockReport(rate_hz, rate_hz**2 * self._slope_se, self._se_s, *counts)

    def problems(self) -> tuple[str, ...]:
        """What is wrong, a sentence each: a rate that is not the stated one, samples missing without notice."""
        told = []
        if self._measured is not None and self._slope_se is not None:
            off = 1 / (self._measured * self.fs_hz) - 1
            if abs(off) > max(RATE_OFF, 4 * self._slope_se * self.fs_hz):
                told.append(
                    f"The device states {self.fs_hz:.2f} samples a second and sends {1 / self._measured:.2f} "
                    f"({100 * off:+.1f} %)."
                )
        if self._missing:
            told.append(
                f"About {self._missing} samples ({self._missing / self.fs_hz:.3f} s) never came, and the device did "
                "not say so."
            )
        return tuple(told)

    def _place(self, first: int, last: int, arrived_s: float) -> None:
        place = last + self._missing
        late_s = 0.0 if self._level_s is None else arrived_s - self._level_s - self._slope * place
        if self._learnt and late_s > LATE_S:
            self._wait(first, last, arrived_s, late_s)
            return
        self._late = None
        if self._steps and late_s < -LATE_S:
            self._take_back()
        self._keep(last + self._missing, arrived_s)

    def _wait(self, first: int, last: int, arrived_s: float, late_s: float) -> None:
        """A late block: of a computer that was busy, whose next blocks come in time, or the first after a loss."""
        if self._late is None:
            self._late = _Late(first, arrived_s, late_s, last, arrived_s)
            return
        late = self._late
        late.blocks += 1
        if late_s < late.least_s:
            late.least_s, late.last, late.at_s = late_s, last, arrived_s
        if arrived_s - late.since_s > STEP_S and late.blocks >= STEP_BLOCKS:
            lost = self._quantum * round(late.least_s / self._slope / self._quantum)
            if lost:
                self._steps.append((late.first, lost))
                self._missing += lost
            self._keep(late.last + self._missing, late.at_s)
            self._late = None

    def _take_back(self) -> None:
        """Arrivals are early by the line after a step: it was no loss, the way was longer for a time."""
        start, lost = self._steps.pop()
        place = start + self._missing
        self._missing -= lost
        self._xs = [x - lost if x >= place else x for x in self._xs]

    def _keep(self, place: float, arrived_s: float) -> None:
        if self._xs and self._xs[-1] // self._bin == place // self._bin:
            if arrived_s - self._ys[-1] >= self._slope * (place - self._xs[-1]):
                return
            self._xs[-1], self._ys[-1] = place, arrived_s
        else:
            if len(self._xs) >= MOST_BINS:
                self._thin()
            if len(self._xs) >= 1.02 * self._fitted:
                self._fit()
            self._xs.append(place)
            self._ys.append(arrived_s)
        level_s = arrived_s - self._slope * place
        self._level_s = level_s if self._level_s is None else min(self._level_s, level_s)

    def _thin(self) -> None:
        self._bin *= 2
        kept: list[tuple[float, float]] = []
        for x, y in zip(self._xs, self._ys, strict=True):
            if not kept or kept[-1][0] // self._bin != x // self._bin:
                kept.append((x, y))
            elif y - kept[-1][1] < self._slope * (x - kept[-1][0]):
                kept[-1] = x, y
        self._xs, self._ys = [x for x, _ in kept], [y for _, y in kept]
        self._fitted = 0

    def _fit(self) -> None:
        """Slope and level of the line below the bins."""
        nominal = 1 / self.fs_hz
        x = np.array(self._xs)
        z = np.array(self._ys) - nominal * x
        self._fitted = len(x)
        if (x[-1] - x[0]) * nominal >= LEARN_S:
            slope = _slope_below(x, z)
            if not self._learnt:
                self._learn(nominal if _is_step(x, z, slope, nominal) else nominal + slope)
                return
            above = z - slope * x
            above_s = float(np.median(above - above.min()))
            self._measured, self._se_s = nominal + slope, above_s
            self._slope_se = above_s / (math.sqrt(len(x)) * float(x.std()))
            believed = CRYSTAL * nominal
            if abs(slope) <= 4 * math.hypot(believed, self._slope_se):
                slope *= believed**2 / (believed**2 + self._slope_se**2)
            self._slope = nominal + slope
        self._level_s = float((z - (self._slope - nominal) * x).min())

    def _learn(self, slope: float) -> None:
        """The rate is known well enough to tell late arrivals, which the first seconds may have had as well."""
        self._learnt = True
        arrivals = list(zip(self._xs, self._ys, strict=True))
        self._xs, self._ys, self._fitted = [], [], max(3, len(arrivals) // 2)
        self._slope, self._level_s = slope, None
        for place, arrived_s in arrivals:
            self._place(round(place), round(place), arrived_s)


@dataclass
class _Late:
    """Late blocks in a row: first sample and arrival of the first; last sample and arrival of the least late one."""

    first: int
    since_s: float
    least_s: float
    last: int
    at_s: float
    blocks: int = 1


def _slope_below(x: NDArray[np.float64], z: NDArray[np.float64]) -> float:
    """Slope of that line below all points (x ascending) which has the smallest sum of distances to them."""
    hull: list[int] = []
    for point in range(len(x)):
        while len(hull) > 1:
            a, b = hull[-2:]
            if (z[b] - z[a]) * (x[point] - x[a]) < (z[point] - z[a]) * (x[b] - x[a]):
                break
            hull.pop()
        hull.append(point)
    right = max(1, int(np.searchsorted(x[hull], x.mean())))
    a, b = hull[right - 1], hull[right]
    return float((z[b] - z[a]) / (x[b] - x[a]))


def _is_step(x: NDArray[np.float64], z: NDArray[np.float64], slope: float, nominal: float) -> bool:
    """Does the slope, which is far from the nominal one, come of one place rather than of all?"""
    span = max(1, len(x) // 6)
    everywhere = float(np.median((z[span:] - z[:-span]) / (x[span:] - x[:-span])))
    return abs(slope) > 10 * CRYSTAL * nominal and abs(everywhere) < abs(slope) / 2
