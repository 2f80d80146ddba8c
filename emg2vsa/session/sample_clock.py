"""When each sample of a stream was measured, on the session's clock, from the times at which blocks of it arrived.

A device samples by its own clock and says no time. A block cannot arrive before its last sample was measured, and
arrives later by buffers, bursts and a busy computer; so the line below all arrivals against the running numbers of the
samples (their lower envelope) is the device's clock. Of all such lines the one with the smallest sum of distances is
taken: it is that edge of the convex hull which lies below the mean (Moon, Skelly and Towsley, INFOCOM 1999).

A stamp of the device itself (LSL) may be early as well as late. For these the line goes through the middle: medians of
0.1 s, and the median of the slopes between them (Theil, 1950; Sen, JASA 1968).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
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
SCATTERS = 4
"Nor is an arrival late that lies so many times nearer to the line than the earliest arrivals of a second usually do."
OFF_S = 0.002
"The same for stamps, and for either side of the line."
STEP_S, STEP_BLOCKS = 1.0, 5
"Arrivals that are late for so long (longer where they scatter), and in so many blocks, tell that samples were lost."
SECONDS = 60
"The scatter is that of the latest so many seconds."
SPANS = 8
"A device whose rate changes leaves the line in whole spans of the stream."
GAP_S = 0.05
"A longer time without an arrival is a gap."


class ClockReport(NamedTuple):
    """The device's clock beside its promise.

    rate_hz, rate_se_hz : measured rate and its standard error; None in the first ``LEARN_S``.
    se_s : how far the earliest arrivals typically lie above the line, and the worst of ``SPANS`` spans of the stream:
    the uncertainty of a sample's time beside the fixed delay. None in the first ``LEARN_S``.
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
    quantum : samples that can be lost at once: 1, or those of a device's frame. stamped : the times are
    the device's own stamps, which scatter to both sides.

    Times of samples change a little with every block that is added (by less than ``se_s`` once learnt); a file that is
    written at the end has the best of them.
    """

    def __init__(self, fs_hz: float, *, delay_s: float = 0.0, quantum: int = 1, stamped: bool = False) -> None:
        self.fs_hz = fs_hz
        self._delay_s, self._quantum, self._stamped = delay_s, quantum, stamped
        self._bin = BIN_S * fs_hz
        self._xs: list[float] = []
        "Place of the earliest arrival of each bin: index of the sample and those missing before it."
        self._ys: list[float] = []
        self._weights: list[int] = []
        "Of stamps a bin holds the mean: of so many."
        self._group: list[tuple[float, float]] = []
        "Stamps of the bin that is not yet full."
        self._seconds: deque[tuple[float, float]] = deque(maxlen=SECONDS)
        "Earliest arrival of each second, by the time less the line's slope; late ones too."
        self._late_s = OFF_S if stamped else LATE_S
        self._before_s = -math.inf
        "Level of the line by the arrivals before the last loss."
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
        last = first + n - 1
        if not self._stamped:
            self._place(first, last, arrived_s)
            return
        if self._level_s is None:
            self._level_s = arrived_s - self._slope * last
        self._group.append((last, arrived_s))
        if last - self._group[0][0] >= BIN_S * self.fs_hz:
            self._place_group()

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

    def timing(self, first: int, stop: int) -> tuple[float, float]:
        """Time of a sample, and the rate from it to sample ``stop``, which is the next to come."""
        last = max(stop - 1, first + 1)
        start_s, stop_s = (float(time) for time in self.time_s(np.array([first, last], dtype=np.int64)))
        return start_s, (last - first) / (stop_s - start_s)

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

    def _place_group(self) -> None:
        """The median of the stamps of a bin, as one."""
        places = np.array(self._group)
        self._group = []
        z = places[:, 1] - places[:, 0] / self.fs_hz
        place = float(np.median(places[:, 0]))
        self._place(int(places[0, 0]), place, float(np.median(z)) + place / self.fs_hz)

    def _place(self, first: int, last: float, arrived_s: float) -> None:
        late_s = 0.0 if self._level_s is None else arrived_s - self._level_s - self._slope * (last + self._missing)
        if self._learnt and not self._stamped:
            self._note_second(last + self._missing, arrived_s)
        if self._steps and self._is_early(last, arrived_s, late_s):
            self._take_back()
            self._place(first, last, arrived_s)
            return
        if self._learnt and (late_s > self._late_s or (self._stamped and late_s < -self._late_s)):
            self._wait(first, last, arrived_s, late_s)
            return
        self._late = None
        self._keep(last + self._missing, arrived_s)

    def _note_second(self, place: float, arrived_s: float) -> None:
        """The earliest arrival of each second, late or not: their scatter says what late is."""
        second = place // self.fs_hz
        if not self._seconds or self._seconds[-1][0] // self.fs_hz != second:
            self._seconds.append((place, arrived_s))
            self._set_late()
        elif arrived_s - self._seconds[-1][1] < self._slope * (place - self._seconds[-1][0]):
            self._seconds[-1] = place, arrived_s

    def _set_late(self) -> None:
        x, y = np.array(self._seconds).T
        above_s = np.sort(y - self._slope * x) - (self._level_s or 0.0)
        # of few seconds most may come after a loss
        typical_s = float(above_s[len(x) // (2 if len(x) > 10 else 4)])
        self._late_s = max(LATE_S, SCATTERS * typical_s)

    def _is_early(self, last: float, arrived_s: float, late_s: float) -> bool:
        """Did a block come sooner than it can have after the last loss? Half a loss is the limit."""
        lost_s = self._slope * self._steps[-1][1]
        if self._stamped:
            return False
        undone_s = arrived_s - self._before_s - self._slope * (last + self._missing - self._steps[-1][1])
        return late_s < -self._late_s or undone_s < lost_s / 2

    def _wait(self, first: int, last: float, arrived_s: float, late_s: float) -> None:
        """A late block: of a computer that was busy, whose next blocks come in time, or the first after a loss."""
        late = self._late
        if late is None or (late.off[0] > 0) != (late_s > 0):
            late = self._late = _Late(first, arrived_s, [], [])
        if not self._stamped and late.off and late_s >= late.off[0]:
            late.blocks += 1
        elif self._stamped:
            late.blocks += 1
            late.off.append(late_s)
            late.at.append((last, arrived_s))
        else:
            late.blocks += 1
            late.off, late.at = [late_s], [(last, arrived_s)]
        wait_s = STEP_S if self._stamped else STEP_S * self._late_s / LATE_S
        if arrived_s - late.since_s <= wait_s or late.blocks < STEP_BLOCKS:
            return
        lost = self._quantum * round(float(np.median(late.off)) / self._slope / self._quantum)
        self._late = None
        if lost > 0:
            gone = late.first + self._missing
            self._seconds = deque(((x + lost if x >= gone else x, y) for x, y in self._seconds), maxlen=SECONDS)
            self._steps.append((late.first, lost))
            self._missing += lost
            self._set_before()
        elif lost < 0 and self._steps:
            self._take_back()
        for place, at_s in late.at:
            self._keep(place + self._missing, at_s)

    def _set_before(self) -> None:
        """Level of the line by the arrivals before the last loss."""
        self._before_s = -math.inf
        if self._steps:
            end = self._steps[-1][0] + self._missing
            levels = [y - self._slope * x for x, y in zip(self._xs, self._ys, strict=True) if x < end]
            self._before_s = min(levels, default=-math.inf)

    def _take_back(self) -> None:
        """Arrivals are early by the line after a step: it was no loss, the way was longer for a time."""
        start, lost = self._steps.pop()
        place = start + self._missing
        self._missing -= lost
        self._xs = [x - lost if x >= place else x for x in self._xs]
        self._seconds = deque(((x - lost if x >= place else x, y) for x, y in self._seconds), maxlen=SECONDS)
        self._late = None
        self._fit()

    def _keep(self, place: float, arrived_s: float) -> None:
        if self._xs and self._xs[-1] // self._bin == place // self._bin:
            if self._stamped:
                self._merge(self._xs, self._ys, self._weights, place, arrived_s, 1)
                return
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
            self._weights.append(1)
        level_s = arrived_s - self._slope * place
        if not self._stamped:
            self._level_s = level_s if self._level_s is None else min(self._level_s, level_s)

    @staticmethod
    def _merge(xs: list[float], ys: list[float], weights: list[int], x: float, y: float, weight: int) -> None:
        """Take a point into the mean of the last bin."""
        weights[-1] += weight
        xs[-1] += (x - xs[-1]) * weight / weights[-1]
        ys[-1] += (y - ys[-1]) * weight / weights[-1]

    def _thin(self) -> None:
        self._bin *= 2
        xs: list[float] = []
        ys: list[float] = []
        weights: list[int] = []
        for x, y, weight in zip(self._xs, self._ys, self._weights, strict=True):
            if not xs or xs[-1] // self._bin != x // self._bin:
                xs.append(x)
                ys.append(y)
                weights.append(weight)
            elif self._stamped:
                self._merge(xs, ys, weights, x, y, weight)
            elif y - ys[-1] < self._slope * (x - xs[-1]):
                xs[-1], ys[-1] = x, y
        self._xs, self._ys, self._weights = xs, ys, weights
        self._fitted = 0

    def _fit(self) -> None:
        """Slope and level of the line below the bins, or through the middle of stamps."""
        nominal = 1 / self.fs_hz
        x = np.array(self._xs)
        z = np.array(self._ys) - nominal * x
        self._fitted = len(x)
        if len(x) > 1 and (x[-1] - x[0]) * nominal >= LEARN_S:
            slope = _slope_amid(x, z) if self._stamped else _slope_below(x, z)
            above = z - slope * x
            above -= np.median(above) if self._stamped else above.min()
            above_s = float(np.median(np.abs(above)))
            slope_se = above_s / (math.sqrt(len(x)) * float(x.std()))
            believed = CRYSTAL * nominal
            likely = slope
            if abs(slope) <= 4 * math.hypot(believed, slope_se):
                likely *= believed**2 / (believed**2 + slope_se**2)
            if not self._learnt:
                self._learn(nominal if _is_step(x, z, slope, nominal) else nominal + likely)
                return
            self._slope, self._measured, self._slope_se = nominal + likely, nominal + slope, slope_se
            spans = [each for each in np.array_split(above, SPANS) if len(each)]
            if self._stamped:
                off_s = max(abs(float(np.median(each))) for each in spans)
                self._se_s = math.hypot(2 * above_s / math.sqrt(len(x)), off_s)
                if self._bin == BIN_S * self.fs_hz:  # longer bins are means, which scatter less than what comes
                    self._late_s = max(OFF_S, 8 * above_s)
            else:
                self._se_s = math.hypot(above_s, max(float(each.min()) for each in spans))
        levels = z - (self._slope - nominal) * x
        self._level_s = float(np.median(levels) if self._stamped else levels.min())
        self._set_before()

    def _learn(self, slope: float) -> None:
        """The rate is known well enough to tell late arrivals, which the first seconds may have had as well."""
        self._learnt = True
        arrivals = list(zip(self._xs, self._ys, strict=True))
        self._xs, self._ys, self._weights, self._fitted = [], [], [], max(3, len(arrivals) // 2)
        self._slope, self._level_s = slope, None
        for place, arrived_s in arrivals:
            self._place(round(place), place, arrived_s)


@dataclass
class _Late:
    """Late blocks in a row: first sample and arrival of the first; how late the least late one is (of stamps:
    each), and its last sample and arrival.
    """

    first: int
    since_s: float
    off: list[float]
    at: list[tuple[float, float]]
    blocks: int = 0


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


def _slope_amid(x: NDArray[np.float64], z: NDArray[np.float64]) -> float:
    """Median of the slopes between points that lie half the stream or more apart: few outliers do not move it."""
    half = len(x) // 2
    return float(np.median((z[half:, None] - z[None, :half]) / (x[half:, None] - x[None, :half])))


def _is_step(x: NDArray[np.float64], z: NDArray[np.float64], slope: float, nominal: float) -> bool:
    """Does the slope, which is far from the nominal one, come of one place rather than of all?"""
    span = max(1, len(x) // 6)
    everywhere = float(np.median((z[span:] - z[:-span]) / (x[span:] - x[:-span])))
    return abs(slope) > 10 * CRYSTAL * nominal and abs(everywhere) < abs(slope) / 2
