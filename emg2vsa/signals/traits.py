"""What one recording is like, in few numbers: by these it is compared with the other recordings of its study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from emg2vsa.arrays import Floats, Ints, median
from emg2vsa.signals.overview import EMG_FROM_HZ, EmgOverview, mean_known, spectra

POINTS = 32
"A press is compared with others by so many points of its force and envelope."
CUBIC = np.linalg.qr(np.vander(np.linspace(-1, 1, POINTS), 4))[0]
"Orthonormal columns of cubics over the points."
NOISE_FROM = 0.7
"Share of the frequencies below which muscles are."
SHARES = (0.05, 0.5, 0.95)
"The edges of a band leave out these shares of its power; the middle one is the median frequency."
LINE_SEGMENT_S = 1.0
LINE_HZ = (20.0, 130.0)
LINE_OVER = 12.0
"A narrow line stands out so many times over the median of the spectrum 8 Hz to either side."


@dataclass(frozen=True)
class Traits:
    """One recording of m muscles with p presses; NaN where something is not known.

    press_v : (m,) median over the presses of their mean envelope less the power at rest, volts.
    press_band_hz : (m, 3) frequencies below which 5, 50 and 95 % of the power of pressing, less that at rest, lie, of
    10 to 500 Hz. rest_density : (m, F) power spectral density at rest without its narrow lines, V^2/Hz. noise_v : (m,)
    square root of its median over the frequencies above ``NOISE_FROM`` of them, where there is no muscle. spectrum :
    (F,) power spectral density while pressing, sum of the muscles over its own sum, on ``frequency_hz`` (F,). line_hz :
    strongest narrow line at rest, 20 to 130 Hz. duration_s, peak_n : medians of the presses. lag_s : of force behind
    EMG. fingerprints : (p, 2, 32) force and summed envelope of each press without its cubic trend, of unit norm.
    """

    muscles: tuple[str, ...]
    press_v: Floats
    press_band_hz: Floats
    rest_density: Floats
    noise_v: Floats
    frequency_hz: Floats
    spectrum: Floats
    line_hz: float
    duration_s: float
    peak_n: float
    lag_s: float
    fingerprints: Floats

    @staticmethod
    def joined(parts: Sequence[Traits]) -> Traits:
        """Several recordings as one: all fingerprints, of the rest the medians, the spectrum of the first."""
        first = parts[0]

        def middle(name: str) -> Floats:
            values = np.array([getattr(part, name) for part in parts])
            return np.array([_median_known(row) for row in values.reshape(len(parts), -1).T]).reshape(values.shape[1:])

        arrays = {name: middle(name) for name in ("press_v", "press_band_hz", "rest_density", "noise_v")}
        numbers = {name: float(middle(name)) for name in ("line_hz", "duration_s", "peak_n", "lag_s")}
        changed: dict[str, Any] = {**arrays, **numbers}
        return replace(first, **changed, fingerprints=np.concatenate([part.fingerprints for part in parts]))


def traits_of(
    muscles: tuple[str, ...],
    samples: Sequence[Floats],
    fs_hz: float,
    rests: Ints,
    overview: EmgOverview,
    rest_v: Floats,
    levels_v: Floats,
    duration_s: Floats,
    peak_n: Floats,
    lag_s: float,
    force_n: Floats,
    envelopes_v: Floats,
    offsets: Ints,
) -> Traits:
    """Traits of raw ``samples`` (n,) by muscle, rests (r, 2) in them, the mean envelopes ``levels_v`` (m, p) of the
    presses, and force (N,) and envelopes (m, N), press i at ``[offsets[i]:offsets[i + 1]]``.
    """
    resting, pressing = overview.resting, overview.pressing
    resting = np.nan_to_num(resting)
    smooth = median_filter(resting, size=(1, 11))
    own = np.array([_across(*each, overview.frequency_hz) for each in zip(pressing, resting, smooth, strict=True)])
    level_v = np.sqrt(np.maximum(levels_v**2 - np.nan_to_num(rest_v)[:, None] ** 2, 0.0))
    total = own.sum(axis=0)
    return Traits(
        muscles=muscles,
        press_v=np.array([_median_known(row) for row in level_v]),
        press_band_hz=_band_hz(own, overview.frequency_hz),
        rest_density=smooth,
        noise_v=np.sqrt([median(row) for row in smooth[:, round(NOISE_FROM * smooth.shape[1]) :]]),
        frequency_hz=overview.frequency_hz,
        spectrum=total / total.sum() if total.sum() > 0 else np.full(total.size, np.nan),
        line_hz=_line_hz(samples, fs_hz, rests),
        duration_s=_median_known(duration_s),
        peak_n=_median_known(peak_n),
        lag_s=lag_s,
        fingerprints=_fingerprints(np.stack((force_n, envelopes_v.sum(axis=0))), offsets),
    )


def _median_known(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return median(known) if known.size else np.nan


def _across(pressing: Floats, resting: Floats, smooth: Floats, frequency_hz: Floats) -> Floats:
    """Power (F,) that pressing adds; where a line at rest hides it, as its neighbours have it."""
    added, line = np.maximum(pressing - resting, 0.0), resting > 4 * smooth
    if line.all() or not line.any():
        return added
    return np.where(line, np.interp(frequency_hz, frequency_hz[~line], added[~line]), added)


def _band_hz(power: Floats, frequency_hz: Floats) -> Floats:
    """Frequencies (m, 3) below which the ``SHARES`` of the power (m, F) from 10 Hz on lie."""
    found = np.full((len(power), len(SHARES)), np.nan)
    sums = np.cumsum(np.where(frequency_hz >= EMG_FROM_HZ, np.nan_to_num(power), 0.0), axis=1)
    for row, run in zip(found, sums, strict=True):
        if run[-1] > 0:
            row[:] = np.interp(np.array(SHARES) * run[-1], run, frequency_hz)
    return found


def _line_hz(samples: Sequence[Floats], fs_hz: float, rests: Ints) -> float:
    """The strongest line that is one second's resolution narrow; between bins by the centre of its power."""
    length = round(LINE_SEGMENT_S * fs_hz)
    power = np.nansum(mean_known(spectra(samples, rests, length, fs_hz)), axis=0)
    hz = np.fft.rfftfreq(length, 1 / fs_hz)
    inner = np.flatnonzero((hz >= LINE_HZ[0]) & (hz <= LINE_HZ[1]))
    if inner.size < 20 or not power.any():
        return np.nan
    near = slice(max(int(inner[0]) - 8, 0), int(inner[-1]) + 9)
    around = median_filter(power[near], size=17)[inner - near.start]
    over = power[inner] / np.maximum(around, 1e-300)
    top = int(inner[np.argmax(over)])
    if over.max() < LINE_OVER:
        return np.nan
    near = slice(top - 1, top + 2)
    return float(power[near] @ hz[near] / power[near].sum())


def _fingerprints(rows: Floats, offsets: Ints) -> Floats:
    """(p, k, 32) of rows (k, N); NaN of presses of fewer samples."""
    found = np.full((offsets.size - 1, len(rows), POINTS), np.nan)
    long = np.flatnonzero(np.diff(offsets) >= POINTS)
    counts = np.diff(offsets)[long]
    # the running sum of each press, from 0 on, one after the other
    begins = np.cumsum(counts + 1) - counts - 1
    runs = np.zeros((len(rows), int((counts + 1).sum())))
    for press, begin, count in zip(long.tolist(), begins.tolist(), counts.tolist(), strict=True):
        own = rows[:, offsets[press] : offsets[press] + count]
        np.cumsum(own, axis=1, out=runs[:, begin + 1 : begin + 1 + count])
    edges = np.multiply.outer(counts, np.arange(POINTS + 1) / POINTS)
    before = np.minimum(edges.astype(np.int64), counts[:, None] - 1)
    low, high = runs[:, begins[:, None] + before], runs[:, begins[:, None] + before + 1]
    sums = np.moveaxis(np.diff(low + (edges - before) * (high - low)), 0, 1)
    left = sums - (sums @ CUBIC) @ CUBIC.T
    norm = np.linalg.norm(left, axis=2, keepdims=True)
    found[long] = np.divide(left, norm, out=np.full_like(left, np.nan), where=norm > 0)
    return found
