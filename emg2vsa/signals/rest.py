"""Where the hand rests, and what the force sensor reads there: the tare of a record, with its slow drift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, median, runs_of
from emg2vsa.settings import WindowSettings

BLOCK_S = 0.1
"Force is looked at in means over blocks of this length."
MIN_BLOCKS = 4
"Shortest rest, blocks."
ROUNDS = 4
"Rest is looked for around the drift found so far, at most this many times."
LOWER_STILL = 0.02
"Share of the record that may lie below its rest by the lower force of the window."


@dataclass(frozen=True)
class Baseline:
    """Rest force over time: a robust line through the rests plus what is left of them.

    What is left is a running median of three, linear in between (knots_s, knots_n), so that slow drift is followed and
    one rest at which the hand leant on the specimen is not.
    """

    slope: float
    level_n: float
    knots_s: Floats
    knots_n: Floats

    def at(self, time_s: Floats) -> Floats:
        """Rest force (n,) at times from the first sample."""
        return np.asarray(self.level_n + self.slope * time_s + np.interp(time_s, self.knots_s, self.knots_n))


@dataclass(frozen=True)
class Rest:
    """Rests of one record; none at all where ``level_n`` is empty.

    start, stop : (r,) samples of every rest, without the block at which it begins and the one at which it ends.
    level_n : (r,) median force. noise_n : standard deviation around it, all rests together; NaN without any.
    """

    start: Ints
    stop: Ints
    level_n: Floats
    baseline: Baseline
    noise_n: float


def find_rest(force_n: Floats, fs_hz: float, window: WindowSettings) -> Rest:
    """Rests of the filtered force (n,), whatever its offset.

    Rest is the lowest level at which the force stays for 0.4 s or more: it keeps within half the lower force of the
    window, and drifts at less than half the speed of the slowest press that would be accepted. A record that spends
    more than 2 % of its time lower still (by the lower force) never rests: an untared ramp, or a grip held all along.
    """
    lower_n, upper_n = window.force_n
    size = max(1, round(BLOCK_S * fs_hz))
    block_n = force_n[: force_n.size // size * size].reshape(-1, size).mean(axis=1)
    block_s = (np.arange(block_n.size) + 0.5) * size / fs_hz
    largest_step_n = (upper_n - lower_n) / window.max_duration_s / 2 * size / fs_hz
    if block_n.size < MIN_BLOCKS:
        return _rest(np.empty((0, 2), np.int64), np.empty(0), force_n, fs_hz)
    baseline_n = np.full(block_n.size, _lower_mode(block_n))
    runs, levels_n = np.empty((0, 2), np.int64), np.empty(0)
    near = np.zeros(block_n.size, dtype=np.bool_)
    for _ in range(ROUNDS):
        before, near = near, np.abs(block_n - baseline_n) < lower_n / 2
        if np.array_equal(before, near):
            break
        runs, levels_n = _rests_among(near, block_n, largest_step_n)
        if levels_n.size == 0:
            break
        baseline_n = _baseline(runs.mean(axis=1) * size / fs_hz, levels_n).at(block_s)
    if levels_n.size and np.mean(block_n < baseline_n - lower_n) > LOWER_STILL:
        runs, levels_n = runs[:0], levels_n[:0]
    return _rest(runs * size, levels_n, force_n, fs_hz)


def _rests_among(near: NDArray[np.bool_], block_n: Floats, largest_step_n: float) -> tuple[Ints, Floats]:
    """First and last-plus-one block (r, 2) and level (r,) of the rests among the blocks ``near`` the baseline."""
    starts, stops = runs_of(near)
    runs, levels_n = [], []
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        if stop - start < MIN_BLOCKS:
            continue
        # the ends of a rest hold the first touch and the last release; at the ends of the record there is none
        inner = start + (start > 0), stop - (stop < block_n.size)
        piece = block_n[slice(*inner)]
        lever = np.arange(piece.size) - (piece.size - 1) / 2
        if abs(float(lever @ piece)) <= largest_step_n * float(lever @ lever):
            runs.append(inner)
            levels_n.append(median(piece))
    return np.array(runs, dtype=np.int64).reshape(-1, 2), np.array(levels_n, dtype=np.float64)


def _rest(runs: Ints, levels_n: Floats, force_n: Floats, fs_hz: float) -> Rest:
    around = [force_n[start:stop] - force_n[start:stop].mean() for start, stop in runs.tolist()]
    noise_n = float(np.std(np.concatenate(around))) if around else np.nan
    return Rest(runs[:, 0], runs[:, 1], levels_n, _baseline(runs.mean(axis=1) / fs_hz, levels_n), noise_n)


def _baseline(centre_s: Floats, level_n: Floats) -> Baseline:
    if level_n.size == 0:
        return Baseline(0.0, 0.0, np.zeros(1), np.zeros(1))
    if level_n.size < 3:
        return Baseline(0.0, 0.0, centre_s, level_n)
    i, j = np.nonzero(centre_s[:, None] < centre_s)
    slope = median((level_n[j] - level_n[i]) / (centre_s[j] - centre_s[i]))
    left = level_n - slope * centre_s
    level = median(left)
    smooth = np.sort((left[:-2], left[1:-1], left[2:]), axis=0)[1]
    return Baseline(slope, level, centre_s[1:-1], smooth - level)


def _lower_mode(values: Floats) -> float:
    """Middle of the shortest interval that holds a fifth of the values, among those below the middle of the range."""
    ordered = np.sort(values)
    low, high = ordered[[round(0.02 * (values.size - 1)), round(0.98 * (values.size - 1))]]
    lower = ordered[: np.searchsorted(ordered, (low + high) / 2, side="right")]
    n = min(lower.size, max(MIN_BLOCKS, values.size // 5))
    begin = int(np.argmin(lower[n - 1 :] - lower[: lower.size - n + 1]))
    return median(lower[begin : begin + n])
