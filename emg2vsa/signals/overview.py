"""The raw EMG of a record in few numbers, for a picture of it: extremes over time, spectra, and median frequencies."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints, slices

COLUMNS = 400
"A record is drawn in at most so many columns."
SEGMENT_S = 0.25
"Spectra are means over segments of this length (Hann window, half overlapping), 4 Hz fine."
HIGHEST_HZ = 500.0
EMG_FROM_HZ = 10.0
"Below this frequency, baseline and movement would set the median frequency."


@dataclass(frozen=True)
class EmgOverview:
    """One record of m muscles with p presses. Column i covers ``step_s`` from ``start_s + i step_s`` on.

    low_v, high_v : (m, k) extremes of the raw samples in each column. mean_v : (m, k) mean rectified value about the
    column's mean. frequency_hz : (F,). resting, pressing : (m, F) power spectral density in V^2/Hz, NaN where there
    is no rest or press of a quarter of a second. median_hz : (m, p) of each press, above 10 Hz, NaN where too short.
    """

    start_s: float
    step_s: float
    low_v: Floats
    high_v: Floats
    mean_v: Floats
    frequency_hz: Floats
    resting: Floats
    pressing: Floats
    median_hz: Floats


def emg_overview(samples: Sequence[Floats], fs_hz: float, start_s: float, presses: Ints, rests: Ints) -> EmgOverview:
    """Overview of raw samples (n,) of each muscle, V; presses, rests : (p, 2), (r, 2) first and last-plus-one
    samples. Spectra by Welch (1967).
    """
    size = max(1, -(-samples[0].size // COLUMNS))
    low_v, high_v, mean_v = np.moveaxis(np.array([_columns(x, size) for x in samples]), 1, 0)
    length = max(8, round(SEGMENT_S * fs_hz))
    frequency_hz = np.fft.rfftfreq(length, 1 / fs_hz).astype(np.float64)
    kept = frequency_hz <= HIGHEST_HZ
    both = spectra(samples, np.concatenate((presses, rests)), length, fs_hz)
    of_press, of_rest = both[:, : len(presses)], both[:, len(presses) :]
    return EmgOverview(
        start_s=start_s,
        step_s=size / fs_hz,
        low_v=low_v,
        high_v=high_v,
        mean_v=mean_v,
        frequency_hz=frequency_hz[kept],
        resting=mean_known(of_rest)[:, kept],
        pressing=mean_known(of_press)[:, kept],
        median_hz=_median_hz(of_press, frequency_hz),
    )


def _columns(samples: Floats, size: int) -> Floats:
    """Lowest, highest and mean rectified value (3, k) of the columns of samples (n,), some at a time."""
    rows = samples[: samples.size // size * size].reshape(-1, size)
    found = np.empty((3, len(rows)))
    for part in slices(len(rows), size):
        own, (low, high, mean) = rows[part], found[:, part]
        own.min(axis=1, out=low)
        own.max(axis=1, out=high)
        apart = own - own.mean(axis=1, keepdims=True)
        np.abs(apart, out=apart).mean(axis=1, out=mean)
    return found


def spectra(samples: Sequence[Floats], bounds: Ints, length: int, fs_hz: float) -> Floats:
    """Power spectral densities (m, q, F), V^2/Hz, of the pieces [i, j) (q, 2); NaN of those shorter than a segment
    (Welch 1967: Hann windows that overlap by half).

    samples : m of (n,) V at ``fs_hz``, Hz. length : of a segment, samples.
    """
    window = np.hanning(length + 1)[:-1]
    step = length // 2
    counts = np.maximum((bounds[:, 1] - bounds[:, 0] - length) // step + 1, 0)
    piece = np.repeat(np.arange(len(bounds)), counts)
    begins = bounds[piece, 0] + step * (np.arange(piece.size) - np.repeat(np.cumsum(counts) - counts, counts))
    found = np.zeros((len(samples), len(bounds), step + 1))
    for own, x in zip(found, samples, strict=True):
        if x.size < length:
            continue
        sums = np.zeros((len(bounds), 2 * (step + 1)))
        every = np.lib.stride_tricks.as_strided(x, (x.size - length + 1, length), 2 * x.strides)
        for part in slices(piece.size, length):
            segments = every[begins[part]]
            segments -= segments.mean(axis=1, keepdims=True)
            segments *= window
            parts = np.fft.rfft(segments, axis=1).view(np.float64)
            parts *= parts
            own_piece = piece[part]
            at = [0, *(np.flatnonzero(own_piece[1:] != own_piece[:-1]) + 1).tolist(), len(parts)]
            # reduceat is slow along this axis
            for a, b in itertools.pairwise(at):
                sums[own_piece[a]] += np.add.reduce(parts[a:b])
        own[:] = sums[:, ::2] + sums[:, 1::2]
    found *= 2 / (fs_hz * (window @ window))
    with np.errstate(invalid="ignore"):
        return np.asarray(found / counts[:, None])


def mean_known(spectra: Floats) -> Floats:
    """Mean (m, F) over the pieces (m, q, F) that have a spectrum."""
    known = np.isfinite(spectra)
    n = known.sum(axis=1)
    total = np.where(known, spectra, 0.0).sum(axis=1)
    return np.where(n > 0, total / np.maximum(n, 1), np.nan)


def _median_hz(spectra: Floats, frequency_hz: Floats) -> Floats:
    """Frequency (m, p) that halves the power above 10 Hz of each spectrum (m, p, F)."""
    power = np.cumsum(np.where(frequency_hz >= EMG_FROM_HZ, spectra, 0.0), axis=2)
    half = power[:, :, -1:] / 2
    at = np.argmax(power >= half, axis=2)
    before = np.take_along_axis(power, np.maximum(at - 1, 0)[:, :, None], axis=2)[:, :, 0]
    there = np.take_along_axis(power, at[:, :, None], axis=2)[:, :, 0]
    rise = np.where(there > before, there - before, 1.0)
    inner = np.clip((half[:, :, 0] - before) / rise, 0, 1)
    step_hz = float(frequency_hz[1]) if frequency_hz.size > 1 else 0.0
    return np.where(half[:, :, 0] > 0, frequency_hz[at] + (inner - 0.5) * step_hz, np.nan)
