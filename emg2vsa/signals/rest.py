"""Where the hand rests, and what the force sensor reads there: the tare of a record, with its slow drift."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, median, runs_of
from emg2vsa.settings import WindowSettings

BLOCK_S = 0.1
"Force is looked at in means over blocks of this length."
MIN_BLOCKS = 4
"Shortest rest, blocks."
LULL_RISE = 0.2
"From a rest, force rises by this share of the window before it falls by the window's lower force."
LOWER_STILL = 0.02
"Share of the record that may lie below its rest by the lower force of the window."
LEANING = 4.0, 0.03
"A rest above the line of its neighbours by so many times what is usual elsewhere, and so many newtons, is no rest."


@dataclass(frozen=True)
class Baseline:
    """Rest force over time: straight lines between the rests (knots_s, knots_n), the first and last level beyond."""

    knots_s: Floats
    knots_n: Floats

    def at(self, time_s: Floats) -> Floats:
        """Rest force (n,), N, at ascending times (n,), s from the first sample."""
        edges = np.searchsorted(time_s, self.knots_s).tolist()
        force_n = np.empty(time_s.size)
        force_n[: edges[0]], force_n[edges[-1] :] = self.knots_n[0], self.knots_n[-1]
        slopes = (self.knots_n[1:] - self.knots_n[:-1]) / (self.knots_s[1:] - self.knots_s[:-1])
        for knot, slope in enumerate(slopes.tolist()):
            between = slice(edges[knot], edges[knot + 1])
            own = np.subtract(time_s[between], self.knots_s[knot], out=force_n[between])
            own *= slope
            own += self.knots_n[knot]
        return force_n


@dataclass(frozen=True)
class Rest:
    """Rests of one record; none at all where ``level_n`` is empty.

    start, stop : (r,) samples of every rest, without the block at which it begins and the one at which it ends.
    level_n : (r,) median force. slope : (r,) N/s within it. noise_n : standard deviation around it, all rests together;
    NaN without any.
    """

    start: Ints
    stop: Ints
    level_n: Floats
    slope: Floats
    baseline: Baseline
    noise_n: float


def find_rest(force_n: Floats, fs_hz: float, window: WindowSettings) -> Rest:
    """Rests of the filtered force (n,), whatever its offset and however its zero drifts: a running tare.

    A rest is a lull: force stays for 0.4 s or more, drifts at less than half the speed of the slowest press that would
    be accepted, and on either side rises before it falls. So every press has the lull before it, while a hold or a
    plateau is none. A record that spends more than 2 % of its time lower still (by the lower force) never rests: an
    untared ramp, or a grip held all along.
    """
    lower_n, upper_n = window.force_n
    size = max(1, round(BLOCK_S * fs_hz))
    block_n = force_n[: force_n.size // size * size].reshape(-1, size).mean(axis=1)
    largest_step_n = (upper_n - lower_n) / window.max_duration_s / 2 * size / fs_hz
    runs = _lulls(block_n, largest_step_n, LULL_RISE * (upper_n - lower_n), lower_n)
    rest = _rest(runs * size, block_n, runs, force_n, fs_hz)
    if rest.level_n.size:
        baseline_n = rest.baseline.at((np.arange(block_n.size) + 0.5) * size / fs_hz)
        if np.mean(block_n < baseline_n - lower_n) > LOWER_STILL:
            return _rest(runs[:0], block_n, runs[:0], force_n, fs_hz)
    return rest


def _lulls(block_n: Floats, largest_step_n: float, rise_n: float, fall_n: float) -> Ints:
    """First and last-plus-one block (r, 2) of every lull."""
    if block_n.size < MIN_BLOCKS:
        return np.empty((0, 2), np.int64)
    lever = np.arange(MIN_BLOCKS) - (MIN_BLOCKS - 1) / 2
    steps_n = np.convolve(block_n, lever[::-1], mode="valid") / float(lever @ lever)
    shifted = [block_n[i : i + steps_n.size] for i in range(MIN_BLOCKS)]
    range_n = np.maximum.reduce(shifted) - np.minimum.reduce(shifted)
    level = (np.abs(steps_n) <= largest_step_n) & (range_n < fall_n / 2)
    still = np.zeros(block_n.size, dtype=np.bool_)
    for shift in range(MIN_BLOCKS):
        still[shift : shift + level.size] |= level
    starts, stops = runs_of(still)
    blocks_n, lulls, levels_n = block_n.tolist(), list[tuple[int, int]](), list[float]()
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        # the ends of a rest hold the first touch and the last release; at the ends of the record there is none
        inner = start + (start > 0), stop - (stop < block_n.size)
        at_n = median(block_n[slice(*inner)])
        sides = range(stop, block_n.size), range(start - 1, -1, -1)
        if all(_rises((blocks_n[i] - at_n for i in side), rise_n, fall_n) for side in sides):
            if lulls and max(blocks_n[lulls[-1][1] : start]) < max(at_n, levels_n[-1]) + rise_n:
                # the same lull, at two levels: at the higher one the hand leans on the specimen
                if at_n < levels_n[-1]:
                    lulls[-1], levels_n[-1] = inner, at_n
                continue
            lulls.append(inner)
            levels_n.append(at_n)
    return np.array(lulls, dtype=np.int64).reshape(-1, 2)


def _rises(above_n: Iterable[float], rise_n: float, fall_n: float) -> bool:
    """Whether the blocks, from a rest on, do not fall by ``fall_n`` before they rise by ``rise_n``."""
    for block_n in above_n:
        if block_n > rise_n or block_n < -fall_n:
            return block_n > rise_n
    return True


def _rest(samples: Ints, block_n: Floats, runs: Ints, force_n: Floats, fs_hz: float) -> Rest:
    """The rests at ``samples`` (r, 2), which are the blocks ``runs`` (r, 2), without those at which the hand leans."""
    pieces = [block_n[start:stop] for start, stop in runs.tolist()]
    levels_n = np.array([median(piece) for piece in pieces], dtype=np.float64)
    kept = ~_leaning(samples.mean(axis=1) / fs_hz, levels_n)
    samples, levels_n = samples[kept], levels_n[kept]
    centre_s = samples.mean(axis=1) / fs_hz
    block_s = max(1, round(BLOCK_S * fs_hz)) / fs_hz
    slope = np.array(
        [_slope(piece) / block_s for piece, own in zip(pieces, kept, strict=True) if own], dtype=np.float64
    )
    within = 0.0
    for start, stop in samples.tolist():
        around = force_n[start:stop] - force_n[start:stop].mean()
        within += float(np.einsum("i,i->", around, around))
    noise_n = float(np.sqrt(within / np.sum(samples[:, 1] - samples[:, 0]))) if len(samples) else np.nan
    baseline = Baseline(centre_s, levels_n) if levels_n.size else Baseline(np.zeros(1), np.zeros(1))
    return Rest(samples[:, 0], samples[:, 1], levels_n, slope, baseline, noise_n)


def _slope(piece: Floats) -> float:
    """Newtons per block."""
    lever = np.arange(piece.size) - (piece.size - 1) / 2
    return float(lever @ piece) / max(float(lever @ lever), 1e-300)


def _leaning(centre_s: Floats, level_n: Floats) -> NDArray[np.bool_]:
    """Which rests (r,) stand above the line of their neighbours while the others do not: the hand leans there."""
    leans = np.zeros(level_n.size, dtype=np.bool_)
    if level_n.size < 5:
        return leans
    line = level_n[:-2] + (level_n[2:] - level_n[:-2]) * (centre_s[1:-1] - centre_s[:-2]) / (
        centre_s[2:] - centre_s[:-2]
    )
    above = level_n[1:-1] - line
    times, least_n = LEANING
    for i in np.flatnonzero(above > least_n).tolist():
        elsewhere = np.abs(np.delete(above, slice(max(0, i - 1), i + 2)))
        leans[i + 1] = elsewhere.size > 0 and above[i] > times * median(elsewhere)
    return leans
