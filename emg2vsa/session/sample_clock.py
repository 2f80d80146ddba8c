"""When each sample of a stream was measured, on the session's clock, from the times at which blocks of it arrived.

A device samples by its own clock and says no time. A block cannot arrive before its last sample was measured, and
arrives later by buffers, bursts and a busy computer; so the line below all arrivals against the running numbers of the
samples (their lower envelope) is the device's clock (``clock_line``).

A radio loses frames, and a crystal errs by 100 ppm. So the stated rate is held: arrivals that are late and stay late
are a step, one or several frames that never came. A stated rate that is wrong shows no steps: all arrivals lie on one
line of another slope. No arrival is early: samples that come sooner than the stated rate allows were sent at another
rate, or came twice, and the line follows them.

A stamp of the device itself (LSL) may be early as well as late: for these the line goes through the middle.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections import deque
from typing import Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from emg2vsa.session.clock_line import LATE_S, SPANS, LineFitter

BIN_S, MOST_BINS = 0.1, 512
"""Time of a bin, of which the earliest arrival is kept, and most bins. With more bins their time is doubled: after
an hour it is 12.8 s.
"""
LEARN_S = 3.0
"Time until which the stated rate is believed and no sample is counted as lost."
FREE = 3e-4
"No crystal errs by more: samples that come sooner were sent at another rate, or came twice."
RATE_OFF = 2e-3
"A measured rate that differs by so much from the stated one is told."
SCATTERS = 4
"Nor is an arrival late that lies so many times nearer to the line than the earliest arrivals of a second usually do."
OFF_S = 0.002
"The same for stamps, and for either side of the line."
STEP_S, STEP_BLOCKS = 1.0, 5
"Arrivals that are late for so long (longer where they scatter), and in so many blocks, tell that samples were lost."
SECONDS = 60
"The scatter is that of the latest so many seconds."
GAP_S = 0.05
"A longer time without an arrival is a gap."
UNEVEN = "The device sends more samples than it states, and not evenly: some come twice"


class Timing(NamedTuple):
    """When the samples of a stream were measured, from number ``first`` on.

    start_s : time of the first on the session's clock. fs_hz : rate by that clock. lost : (number of a sample, samples
    that never came before it) in order; the samples and those that never came follow one another at this rate.
    """

    first: int
    start_s: float
    fs_hz: float
    lost: tuple[tuple[int, int], ...] = ()


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
        self._fitter = LineFitter(fs_hz, quantum, stamped)
        self._bin = BIN_S * fs_hz
        self._xs: list[float] = []
        "Number of the sample that arrived earliest in each bin."
        self._ys: list[float] = []
        self._weights: list[int] = []
        "Number of stamps whose mean each bin holds."
        self._group: list[tuple[float, float]] = []
        "Stamps of the bin that is not yet full."
        self._seconds: deque[tuple[float, float]] = deque(maxlen=SECONDS)
        "Sample and arrival of the earliest of each second, by the time less the line's slope; late ones too."
        self._late_s = OFF_S if stamped else LATE_S
        self._before_s = -math.inf
        "Level of the line by the arrivals before the last loss."
        self._fitted = 3
        "Bins there were when the line was laid."
        self._learnt = False
        self._late: list[_Late] = []
        "Late blocks in a row: of a computer that was busy, whose next blocks come in time, or the first after a loss."
        self._starts: list[int] = []
        "First sample after each loss, oldest first, ..."
        self._gone = [0]
        "... and the samples missing before the first loss, the second, and so on."
        self._slope = 1 / fs_hz
        self._level_s: float | None = None
        self._slope_se: float | None = None
        self._measured: float | None = None
        self.uneven = False
        "More samples come than the stated rate has, and at no steady rate: frames come twice."
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
            self._note_second(last, arrived_s)
            self._place(_Late(first, last, arrived_s))
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
        """When samples were measured, s on the session's clock; NaN before the first block.

        index : number of a sample, or (n,) numbers; the answer has its shape.
        """
        level_s = math.nan if self._level_s is None else self._level_s - self._delay_s
        return level_s + self._slope * self._place_of(index)

    def first_after(self, time_s: float, stop: int) -> int:
        """Number of the first sample not before a time, s; ``stop`` where it is not among those before."""
        return bisect_left(range(stop), time_s, key=self.time_s)

    def timing(self, first: int, stop: int) -> Timing:
        """Timing of the samples from ``first`` to the one before ``stop``."""
        lost = zip(self._starts, np.diff(self._gone).tolist(), strict=True)
        inside = tuple((start, n) for start, n in lost if first < start < stop)
        return Timing(first, self.time_s(first), 1 / self._slope, inside)

    def report(self) -> ClockReport:
        """So far."""
        counts = (self._gone[-1], self._gaps, self._longest_s)
        if self._measured is None or self._slope_se is None:
            return ClockReport(None, None, None, *counts)
        rate_hz = 1 / self._measured
        return ClockReport(rate_hz, rate_hz**2 * self._slope_se, self._se_s, *counts)

    def problems(self) -> tuple[str, ...]:
        """What is wrong, a sentence each: a rate that is not the stated one, samples missing without notice."""
        told = []
        if self._measured is not None and self._slope_se is not None:
            off = 1 / (self._measured * self.fs_hz) - 1
            if self.uneven:
                told.append(f"{UNEVEN} ({100 * off:+.2g} %).")
            elif abs(off) > max(RATE_OFF, 4 * self._slope_se * self.fs_hz):
                told.append(
                    f"The device states {self.fs_hz:.2f} samples a second and sends {1 / self._measured:.2f} "
                    f"({100 * off:+.1f} %)."
                )
        if missing := self._gone[-1]:
            told.append(
                f"About {missing} samples ({missing / self.fs_hz:.3f} s) never came, and the device did not say so: "
                "shorten the distance to its radio."
            )
        return tuple(told)

    def _place_group(self) -> None:
        """The median of the stamps of a bin, as one."""
        places = np.array(self._group)
        self._group = []
        z = places[:, 1] - places[:, 0] / self.fs_hz
        place = float(np.median(places[:, 0]))
        self._place(_Late(int(places[0, 0]), place, float(np.median(z)) + place / self.fs_hz))

    @overload
    def _place_of(self, index: float) -> float: ...
    @overload
    def _place_of(self, index: NDArray[np.int64] | NDArray[np.float64]) -> NDArray[np.float64]: ...
    def _place_of(self, index: float | NDArray[Any]) -> float | NDArray[np.float64]:
        """Number of a sample, those that never came before it counted."""
        if isinstance(index, np.ndarray):
            passed = np.searchsorted(self._starts, index, side="right")
            return np.asarray(index + np.array(self._gone)[passed], dtype=np.float64)
        return index + self._gone[bisect_right(self._starts, index)]

    def _late_s_of(self, last: float, arrived_s: float) -> float:
        return 0.0 if self._level_s is None else arrived_s - self._level_s - self._slope * self._place_of(last)

    def _place(self, block: _Late) -> None:
        _, last, arrived_s = block
        late_s = self._late_s_of(last, arrived_s)
        if self._starts and self._is_early(last, arrived_s, late_s):
            self._take_back()
            self._place(block)
        elif self._learnt and (late_s > self._late_s or (self._stamped and late_s < -self._late_s)):
            self._wait(block, late_s)
        else:
            self._late = []
            self._keep(last, arrived_s)

    def _note_second(self, last: float, arrived_s: float) -> None:
        """The earliest arrival of each second, late or not: their scatter says what late is."""
        if not self._learnt:
            return
        second = last // self.fs_hz
        if not self._seconds or self._seconds[-1][0] // self.fs_hz != second:
            self._seconds.append((last, arrived_s))
            self._set_late()
        elif self._late_s_of(last, arrived_s) < self._late_s_of(*self._seconds[-1]):
            self._seconds[-1] = last, arrived_s

    def _set_late(self) -> None:
        known_s = self._late[0].arrived_s if self._late else math.inf
        "What is late since may come after a loss."
        if not (known := [each for each in self._seconds if each[1] < known_s]):
            return
        x, y = np.array(known).T
        above_s = np.sort(y - self._slope * self._place_of(x)) - (self._level_s or 0.0)
        # of few seconds most may come after a loss
        typical_s = float(above_s[len(x) // (2 if len(x) > 10 else 4)])
        self._late_s = max(LATE_S, SCATTERS * typical_s)

    def _is_early(self, last: float, arrived_s: float, late_s: float) -> bool:
        """Did a block come sooner than it can have after the last loss? Half a loss is the limit."""
        if self._stamped:
            return False
        lost = self._gone[-1] - self._gone[-2]
        undone_s = arrived_s - self._before_s - self._slope * (self._place_of(last) - lost)
        return late_s < -self._late_s or undone_s < self._slope * lost / 2

    def _wait(self, block: _Late, late_s: float) -> None:
        """A late block: when all have been late for long enough, so much was lost before the first of them."""
        if self._stamped and self._late and (self._late_s_of(*self._late[-1][1:]) > 0) != (late_s > 0):
            self._late = []
        self._late.append(block)
        wait_s = STEP_S if self._stamped else STEP_S * self._late_s / LATE_S
        if block.arrived_s - self._late[0].arrived_s <= wait_s or len(self._late) < STEP_BLOCKS:
            return
        waited, self._late = self._late, []
        off_s = [self._late_s_of(*each[1:]) for each in waited]
        least_s = float(np.median(off_s)) if self._stamped else min(off_s)
        if not self._stamped:
            least_s -= self._before(waited[0].arrived_s)
        lost = self._quantum * round(least_s / self._slope / self._quantum)
        if lost > 0:
            self._starts.append(waited[0].first)
            self._gone.append(self._gone[-1] + lost)
            self._set_before()
        elif lost < 0 and self._starts:
            self._take_back()
        else:
            for each in waited if self._stamped else [waited[int(np.argmin(off_s))]]:
                self._keep(*each[1:])
            if not self._stamped:
                self._fit()
            return
        early = np.array(off_s) < self._slope * lost
        many = np.count_nonzero(early) >= STEP_BLOCKS  # few blocks between two losses do not lower the line
        for each, own in zip(waited, early.tolist(), strict=True):
            if many or not own:
                self._place(each)

    def _before(self, time_s: float) -> float:
        """How late the earliest arrivals were in the seconds before: a crystal's slope, or a wrong rate, is no step."""
        earlier = [self._late_s_of(*each) for each in self._seconds if each[1] < time_s]
        return max(0.0, min(earlier[-5:], default=0.0))

    def _set_before(self) -> None:
        """Level of the line by the arrivals before the last loss."""
        self._before_s = -math.inf
        if self._starts:
            kept = zip(self._xs, self._ys, strict=True)
            levels = [y - self._slope * self._place_of(x) for x, y in kept if x < self._starts[-1]]
            self._before_s = min(levels, default=-math.inf)

    def _take_back(self) -> None:
        """Arrivals are early by the line after a step: it was no loss, the way was longer for a time."""
        self._starts.pop()
        self._gone.pop()
        self._late = []
        self._fit()

    def _keep(self, last: float, arrived_s: float) -> None:
        if self._xs and self._xs[-1] // self._bin == last // self._bin:
            if self._stamped:
                self._merge(self._xs, self._ys, self._weights, last, arrived_s, 1)
            elif self._late_s_of(last, arrived_s) < self._late_s_of(self._xs[-1], self._ys[-1]):
                self._xs[-1], self._ys[-1] = last, arrived_s
        else:
            if len(self._xs) >= MOST_BINS:
                self._thin()
            if len(self._xs) >= 1.02 * self._fitted:
                self._fit()
            self._xs.append(last)
            self._ys.append(arrived_s)
            self._weights.append(1)
        if not self._stamped and (self._slope_se is None or not self._starts):
            level_s = arrived_s - self._slope * self._place_of(last)
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
            elif self._late_s_of(x, y) < self._late_s_of(xs[-1], ys[-1]):
                xs[-1], ys[-1] = x, y
        self._xs, self._ys, self._weights = xs, ys, weights
        self._fitted = 0

    def _fit(self) -> None:
        """Slope and level of the line below the bins, or through the middle of stamps."""
        nominal = 1 / self.fs_hz
        self._fitted = len(self._xs)
        numbers, y = self._points()
        if len(numbers) > 1 and (numbers[-1] - numbers[0]) * nominal >= LEARN_S:
            line = self._fitter.through(self._place_of(numbers), y, amid=self._stamped or bool(self._starts))
            if self._starts:
                without = self._fitter.through(np.array(self._xs), np.array(self._ys), amid=self._stamped)
                if without.is_steady and not without.is_stated:  # what was counted as losses is a wrong rate
                    line, self._starts, self._gone = without, [], [0]
            fast = not self._stamped and not line.is_stated and self._is_fast(numbers, y)
            self.uneven = fast and not line.is_even
            held = not (line.is_steady or line.is_stated or fast)
            last = max(self._slope, nominal * (1 - FREE)) if not self._stamped else self._slope
            slope = last if held else nominal + line.likely
            if not self._learnt:
                self._learn(slope)
                return
            self._slope, self._slope_se, self._se_s = slope, line.slope_se, line.se_s
            self._measured = slope if held else nominal + line.slope
            if self._stamped and self._bin == BIN_S * self.fs_hz:  # longer bins are means, which scatter less
                self._late_s = max(OFF_S, 8 * line.above_s)
        self._level_s = self._fitter.level(y - self._slope * self._place_of(numbers), amid=bool(self._starts))
        self._set_before()

    def _is_fast(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> bool:
        """Do both halves of the stream come sooner than the stated rate allows? A start that was late shows in one."""
        halves = zip(np.array_split(self._place_of(x), 2), np.array_split(y, 2), strict=True)
        lines = [self._fitter.through(*half, amid=False) for half in halves]
        return all(line.slope < -(FREE / self.fs_hz + 4 * line.slope_se) for line in lines)

    def _points(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Samples and arrivals that make the line: those of the bins; where samples were lost, of whole seconds."""
        x, y = np.array(self._xs), np.array(self._ys)
        seconds = not self._stamped and bool(self._starts)
        size = max(1, min(round(self.fs_hz / self._bin), len(x) // SPANS)) if seconds else 1
        above = y - self._slope * self._place_of(x)
        starts = range(0, len(x), size)
        rows = [start + int(np.argmin(above[start : start + size])) for start in starts]
        return x[rows], y[rows]

    def _learn(self, slope: float) -> None:
        """The rate is known well enough to tell late arrivals, which the first seconds may have had as well."""
        self._learnt = True
        arrivals = list(zip(self._xs, self._ys, strict=True))
        self._xs, self._ys, self._weights, self._fitted = [], [], [], max(3, len(arrivals) // 2)
        self._slope, self._level_s = slope, None
        for last, arrived_s in arrivals:
            if not self._stamped:
                self._note_second(last, arrived_s)
            self._place(_Late(round(last), last, arrived_s))


class _Late(NamedTuple):
    """A block: its first and its last sample, and when that arrived."""

    first: int
    last: float
    arrived_s: float
