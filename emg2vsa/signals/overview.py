"""The raw EMG of a record in few numbers, for a picture of it: extremes over time, spectra, and median frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints

COLUMNS = 400
"A record is drawn in at most so many columns."
SEGMENT_S = 0.25
"Spectra are means over segments of this length (Hann window, half overlapping), 4 Hz fine."
HIGHEST_HZ = 500.0
EMG_FROM_HZ = 10.0
"Below, baseline and movement would set the median frequency."


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
    """Of raw samples (n,) of each muscle; presses, rests : (p, 2), (r, 2) first and last-plus-one samples."""
    size = max(1, -(-samples[0].size // COLUMNS))
    rows = [x[: x.size // size * size].reshape(-1, size) for x in samples]
    length = max(8, round(SEGMENT_S * fs_hz))
    frequency_hz = np.fft.rfftfreq(length, 1 / fs_hz).astype(np.float64)
    kept = frequency_hz <= HIGHEST_HZ
    of_press, of_rest = (spectra(samples, bounds, length, fs_hz) for bounds in (presses, rests))
    return EmgOverview(
        start_s=start_s,
        step_s=size / fs_hz,
        low_v=np.array([row.min(axis=1) for row in rows]),
        high_v=np.array([row.max(axis=1) for row in rows]),
        mean_v=np.array([np.abs(row - row.mean(axis=1, keepdims=True)).mean(axis=1) for row in rows]),
        frequency_hz=frequency_hz[kept],
        resting=mean_known(of_rest)[:, kept],
        pressing=mean_known(of_press)[:, kept],
        median_hz=_median_hz(of_press, frequency_hz),
    )


def spectra(samples: Sequence[Floats], bounds: Ints, length: int, fs_hz: float) -> Floats:
    """Power spectral densities (m, q, F) of the pieces [i, j) (q, 2); NaN of those shorter than a segment."""
    window = np.hanning(length + 1)[:-1]
    spectra = np.full((len(samples), len(bounds), length // 2 + 1), np.nan)
    for own, x in zip(spectra, samples, strict=True):
        for row, (i, j) in zip(own, bounds.tolist(), strict=True):
            if j - i < length:
                continue
            segments = np.lib.stride_tricks.sliding_window_view(x[i:j], length)[:: length // 2]
            found = np.fft.rfft((segments - segments.mean(axis=1, keepdims=True)) * window, axis=1)
            (found.real**2 + found.imag**2).mean(axis=0, out=row)
    spectra *= 2 / (fs_hz * (window @ window))
    return spectra


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
