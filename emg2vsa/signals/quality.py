"""How good the raw signals of a trial are: clipped, flat, held or hummed over; and how much force fell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, runs_of
from emg2vsa.signals.products import times

MAINS_HZ = (50.0, 60.0)
MAINS_HARMONICS = 3
MAINS_BLOCK_S = 1.0
"Mains is looked for in blocks of this length, so that its wander of +-0.1 Hz does not matter."

SILENT_DB = 1.0
"A muscle that differs from its rest by less shows nothing of the press: estimates of a dead channel stay within it."

REPEATING = 0.3
"A channel that holds values for this share of its samples was sampled more slowly than its file says."


PEAK_SAMPLES = 4
"So many samples at the extremes are the two peaks of a coarse converter, not a saturated amplifier."


@dataclass(frozen=True)
class RawQuality:
    """One channel within one window.

    clip_share : share of samples in runs at the largest or the smallest value, longer than runs elsewhere usually are.
    repeat_share : share of samples equal to the one before. held_samples : longest run of one value.
    mains_ratio : share of power at 50 or 60 Hz (the larger) and two harmonics. missing : samples that were no numbers.
    """

    clip_share: float
    repeat_share: float
    held_samples: int
    flat: bool
    mains_ratio: float
    missing: int


def raw_qualities(windows: Sequence[Floats], missing: Sequence[NDArray[np.bool_]], fs_hz: float) -> list[RawQuality]:
    """Quality of the unfiltered samples (n,), n >= 2, of every window; missing : (n,) where they were interpolated."""
    return [_quality(*window) for window in zip(windows, missing, mains_ratios(windows, fs_hz).tolist(), strict=True)]


def _quality(samples: Floats, missing: NDArray[np.bool_], mains: float) -> RawQuality:
    n_missing = int(np.count_nonzero(missing))
    samples = samples[~missing] if n_missing else samples
    if samples.size < 2:
        return RawQuality(0.0, 0.0, 1, False, 0.0, n_missing)
    repeats = samples[1:] == samples[:-1]
    n_repeats = int(np.count_nonzero(repeats))
    if n_repeats == repeats.size:
        return RawQuality(0.0, 1.0, samples.size, True, 0.0, n_missing)
    if n_repeats == 0:
        return RawQuality(0.0, 0.0, 1, False, mains, n_missing)
    first, last = runs_of(repeats)
    length = last - first + 1
    value = samples[first]
    at_extreme = (value == samples.max()) | (value == samples.min())
    n_clipped = 0
    if at_extreme.any():
        elsewhere = length[~at_extreme]
        # a channel that repeats its samples everywhere also repeats its single largest one
        usual = int(elsewhere.max()) if elsewhere.sum() > REPEATING * samples.size else 1
        n_clipped = int(np.sum(length[at_extreme & (length > usual)]))
    clipped = n_clipped / samples.size if n_clipped > PEAK_SAMPLES else 0.0
    return RawQuality(clipped, n_repeats / repeats.size, int(length.max()), False, mains, n_missing)


def mains_ratios(windows: Sequence[Floats], fs_hz: float) -> Floats:
    """Share (w,) of the power of each window (n,) at 50 or 60 Hz, the larger, and its harmonics; 0 when n is small."""
    sizes = [min(window.size, round(MAINS_BLOCK_S * fs_hz)) for window in windows]
    ratios = np.zeros(len(windows))
    for size in set(sizes):
        if size < 4 * fs_hz / MAINS_HZ[0]:
            continue
        alike = [i for i, own in enumerate(sizes) if own == size]
        pieces = [windows[i][: windows[i].size // size * size].reshape(-1, size) for i in alike]
        begin = np.cumsum([0, *map(len, pieces[:-1])])
        blocks = np.concatenate(pieces)
        blocks -= blocks.mean(axis=1, keepdims=True)
        total = np.add.reduceat(np.vecdot(blocks, blocks), begin)
        power = np.add.reduceat(times(blocks[None], _mains_waves(size, fs_hz))[0] ** 2, begin)
        larger = power.reshape(len(alike), len(MAINS_HZ), -1).sum(axis=2).max(axis=1)
        ratios[alike] = np.divide(larger, total, out=np.zeros(len(alike)), where=total > 0)
    return np.minimum(ratios, 1.0)


@lru_cache(maxsize=16)
def _mains_waves(size: int, fs_hz: float) -> Floats:
    """(size, 2 x mains x harmonics) sines and cosines of unit norm; a harmonic at or above half the rate is zero."""
    frequency = np.repeat(np.outer(MAINS_HZ, np.arange(1, MAINS_HARMONICS + 1)).ravel(), 2)
    phase = np.tile((0.0, np.pi / 2), frequency.size // 2)
    waves = np.sin(2 * np.pi / fs_hz * np.outer(np.arange(size), frequency) + phase)
    waves[:, frequency >= fs_hz / 2] = 0.0
    norm = np.linalg.norm(waves, axis=0)
    return np.asarray(waves / np.where(norm > 0, norm, 1.0), dtype=np.float64)


def falling_share(force_n: Floats, tolerance_n: float) -> float:
    """Share of the path of ``force_n`` (n,) that falls; reversals up to ``tolerance_n`` are noise, not counted. Both in
    N."""
    rising = force_n[1:] > force_n[:-1]
    if force_n.size < 2 or rising.all():
        return 0.0
    turns = np.flatnonzero(rising[1:] != rising[:-1]) + 1
    rise, fall = _paths((*force_n[[0, *turns, -1]].tolist(),), tolerance_n)
    return fall / (rise + fall) if rise + fall > 0 else 0.0


def _paths(turns: Sequence[float], tolerance: float) -> tuple[float, float]:
    """Length of all rises and of all falls between turning points, reversals within the tolerance left out."""
    path = {1: 0.0, -1: 0.0}
    pivot = extreme = turns[0]
    direction = 1
    for value in turns[1:]:
        if direction * (value - extreme) > 0:
            extreme = value
        elif direction * (extreme - value) > tolerance:
            path[direction] += abs(extreme - pivot)
            pivot, extreme, direction = extreme, value, -direction
    path[direction] += abs(extreme - pivot)
    return path[1], path[-1]


def ratio_db(level: Floats, reference: Floats) -> Floats:
    """20 log10 of two amplitudes, (n,) dB; NaN where the reference is unknown, infinite where it is zero."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(20 * np.log10(level / reference))


def window_means(values: Floats, offsets: Ints) -> Floats:
    """Means (m, w) of the ragged rows of ``values`` (m, n) between successive ``offsets`` (w + 1,); NaN where empty."""
    total = np.zeros((len(values), values.shape[1] + 1))
    np.cumsum(values, axis=1, out=total[:, 1:])
    edges = total[:, offsets]
    with np.errstate(invalid="ignore"):
        return np.asarray((edges[:, 1:] - edges[:, :-1]) / (offsets[1:] - offsets[:-1]))
