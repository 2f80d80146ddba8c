"""Where the hand rests, and what the force sensor reads there: the tare of a record, with its slow drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints, runs_of
from emg2vsa.settings import WindowSettings

BLOCK_S = 0.1
"Force is looked at in means over blocks of this length."
MIN_BLOCKS = 4
"Shortest rest, blocks."
ROUNDS = 3
"Rest is looked for around the drift found so far, this many times."


@dataclass(frozen=True)
class Rest:
    """Rests of one record, in samples of the force channel.

    start, stop : (r,) of every rest, its first and last block left out. level_n, centre_s : (r,) median and middle.
    noise_n : standard deviation of the force around its level, all rests together; NaN without any.
    """

    start: Ints
    stop: Ints
    level_n: Floats
    centre_s: Floats
    noise_n: float

    def baseline_at(self, time_s: Floats) -> Floats:
        """Rest force (n,) at times from the first sample: a robust line through the rests plus what is left of them.

        What is left is a running median of three, linear in between, so that slow drift is followed and one rest at
        which the hand leant on the specimen is not.
        """
        if self.level_n.size < 3:
            return np.interp(time_s, self.centre_s, self.level_n)
        slope, level = _theil_sen(self.centre_s, self.level_n)
        left = self.level_n - (level + slope * self.centre_s)
        inner = np.median(np.stack((left[:-2], left[1:-1], left[2:])), axis=0)
        return level + slope * time_s + np.interp(time_s, self.centre_s[1:-1], inner)


def find_rest(force_n: Floats, fs_hz: float, window: WindowSettings) -> Rest:
    """Rests of the filtered force (n,), whatever its offset.

    Rest is the lowest level at which the force stays for 0.4 s or more: it keeps within half the lower force of the
    window, and drifts at less than half the speed of the slowest press that would be accepted. A record that spends
    more than 2 % of its time lower still (by the lower force) never rests: an untared ramp, or a grip held all along.
    """
    lower_n, upper_n = window.force_n
    size = max(1, round(BLOCK_S * fs_hz))
    block_n = force_n[: force_n.size // size * size].reshape(-1, size).mean(axis=1)
    none = Rest(np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0), np.empty(0), np.nan)
    if block_n.size < MIN_BLOCKS:
        return none
    block_s = (np.arange(block_n.size) + 0.5) * size / fs_hz
    speed_limit = (upper_n - lower_n) / window.max_duration_s / 2
    baseline_n = np.full(block_n.size, _lower_mode(block_n))
    rest = none
    for _ in range(ROUNDS):
        rest = _rests_near(baseline_n, block_n, force_n, fs_hz, size, lower_n / 2, speed_limit)
        if rest.level_n.size == 0:
            return none
        baseline_n = rest.baseline_at(block_s)
    return none if np.mean(block_n < baseline_n - lower_n) > 0.02 else rest


def _rests_near(
    baseline_n: Floats, block_n: Floats, force_n: Floats, fs_hz: float, size: int, reach_n: float, speed_limit: float
) -> Rest:
    starts, stops = runs_of(np.abs(block_n - baseline_n) < reach_n)
    found: list[tuple[int, int, float]] = []
    squares, count = 0.0, 0
    for start, stop in zip(starts, stops, strict=True):
        if stop - start < MIN_BLOCKS:
            continue
        # the ends of a rest hold the first touch and the last release; at the ends of the record there is none
        start, stop = start + (start > 0), stop - (stop < block_n.size)
        slope = float(np.polynomial.polynomial.polyfit(np.arange(stop - start), block_n[start:stop], 1)[1])
        if abs(slope) / (size / fs_hz) > speed_limit:
            continue
        piece = force_n[start * size : stop * size]
        level = float(np.median(piece))
        found.append((start * size, stop * size, level))
        squares, count = squares + float(np.sum((piece - level) ** 2)), count + piece.size
    if not found:
        return Rest(np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0), np.empty(0), np.nan)
    start_i, stop_i, level_n = (np.array(column) for column in zip(*found, strict=True))
    return Rest(start_i, stop_i, level_n, (start_i + stop_i) / 2 / fs_hz, (squares / count) ** 0.5)


def _lower_mode(values: Floats) -> float:
    """Middle of the shortest interval that holds a fifth of the values, among those below the middle of the range."""
    low, high = np.quantile(values, (0.02, 0.98))
    ordered = np.sort(values[values <= max((low + high) / 2, values.min())])
    n = min(ordered.size, max(MIN_BLOCKS, values.size // 5))
    begin = int(np.argmin(ordered[n - 1 :] - ordered[: ordered.size - n + 1]))
    return float(np.median(ordered[begin : begin + n]))


def _theil_sen(x: Floats, y: Floats) -> tuple[float, float]:
    i, j = np.triu_indices(x.size, 1)
    slope = float(np.median((y[j] - y[i]) / (x[j] - x[i])))
    return slope, float(np.median(y - slope * x))
