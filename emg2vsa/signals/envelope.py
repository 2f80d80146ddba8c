"""The envelope of the rectified signal, evaluated only at the instants that are asked for."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy import signal

from casr.by_name import module_named
from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.errors import SettingError
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.filters import IirFilter
from emg2vsa.signals.products import times
from emg2vsa.signals.windowed import LONG, filter_windows

FEWEST_OUT = 16
"Outputs of a block: narrower matrices multiply more slowly."
SMALLEST_EXPONENT = -1021
"Smallest exponent of a power of two whose inverse is finite."


@dataclass(frozen=True)
class Smoother:
    """A symmetric kernel over the rectified signal.

    taps : (t,) of unit sum. squared : over the square, then the root (RMS); else over the absolute value.
    before, after : samples used before and after the instant of output. delay_s : of the output; 0 when centred.
    """

    name: str
    taps: Floats
    squared: bool
    before: int
    after: int
    delay_s: float
    notes: tuple[str, ...]


def smoother(filters: FilterSettings, fs_hz: float, step: int) -> Smoother:
    """The envelope kernel of ``filters`` at ``fs_hz``, Hz; ``step`` is the decimation, for the warning on aliasing.

    SettingError : an odd order of the FIR, or a cut-off from half the rate on.
    """
    centred = filters.phase == "zero-phase"
    if filters.envelope == "rms":
        window = max(3, round(filters.rms_window_s * fs_hz) // 2 * 2 + 1)
        return _smoother("EMG envelope RMS", window, None, centred, fs_hz, step)
    if filters.fir_order % 2:
        do = f"Use {filters.fir_order + 1}."
        raise SettingError("filters.fir_order", wanted="an even order", found=str(filters.fir_order), do=do)
    if filters.fir_cutoff_hz >= fs_hz / 2:
        wanted, found = f"less than half the EMG rate, {fs_hz / 2:g} Hz", f"{filters.fir_cutoff_hz:g} Hz"
        raise SettingError("filters.fir_cutoff_hz", wanted=wanted, found=found, do="Lower the cut-off.")
    return _smoother("EMG envelope FIR", filters.fir_order + 1, filters.fir_cutoff_hz, centred, fs_hz, step)


@lru_cache(maxsize=64)
def _smoother(name: str, n_taps: int, cutoff_hz: float | None, centred: bool, fs_hz: float, step: int) -> Smoother:
    if cutoff_hz is None:
        taps = np.full(n_taps, 1 / n_taps)
    else:
        taps = np.asarray(signal.firwin(n_taps, cutoff_hz, window="hamming", fs=fs_hz), dtype=np.float64)
    half = n_taps // 2
    before, after, delay_s = (half, half, 0.0) if centred else (n_taps - 1, 0, half / fs_hz)
    edge_hz = _edge_hz(taps, fs_hz)
    delay = "centred, no delay" if centred else f"delay {1e3 * delay_s:.3g} ms"
    design = "moving window" if cutoff_hz is None else f"Hamming, {cutoff_hz:g} Hz"
    notes = [f"{name}: {design}, {n_taps} taps; true -3 dB at {edge_hz:.4g} Hz; {delay}"]
    leak = 20 * math.log10(max(_gain(taps, fs_hz / step / 2, fs_hz), 1e-12))
    if step > 1 and leak > -20:
        notes.append(
            f"{name}: only {-leak:.0f} dB down at half the output rate ({fs_hz / step / 2:.3g} Hz); "
            "a longer kernel or a higher output_fs_hz avoids aliasing"
        )
    return Smoother(name, taps, cutoff_hz is None, before, after, delay_s, tuple(notes))


def _gain(taps: Floats, frequency_hz: float, fs_hz: float) -> float:
    return float(abs(np.exp(-2j * np.pi * frequency_hz / fs_hz * np.arange(taps.size)) @ taps))


def _edge_hz(taps: Floats, fs_hz: float) -> float:
    grid = np.linspace(0, fs_hz / 2, 4096)
    response = np.abs(np.exp(-2j * np.pi / fs_hz * np.outer(grid, np.arange(taps.size))) @ taps)
    below = np.flatnonzero(response < math.sqrt(0.5))
    if below.size == 0:
        return math.nan
    last = int(below[0])
    return float(np.interp(math.sqrt(0.5), response[[last, last - 1]], grid[[last, last - 1]]))


def envelopes_at(
    channels: Sequence[Floats], first: Ints, counts: Ints, step: int, iir: IirFilter, kernel: Smoother
) -> Floats:
    """Envelopes of all windows, one after the other: (channels, sum of counts), in the unit of the channels.

    Window w is evaluated at the samples ``first[w] + step * arange(counts[w])``, all inside the record. Within the
    kernel's reach of an end of the record, the taps that remain are rescaled to unit sum, but never more than doubled:
    a causal envelope rises from zero at the start of its record. Windows of more than ``LONG`` samples in all are
    filtered some at a time.
    Band-pass, rectification and low-pass are those of paper IV.B.
    """
    if not np.any(counts):
        return np.empty((len(channels), 0))
    if np.min(counts) == 0:
        first, counts = first[counts > 0], counts[counts > 0]
    if iir.engine == "compiled":
        return _compiled(channels, first, counts, step, iir, kernel)
    return _by_products(channels, first, counts, step, iir, kernel)


def _compiled(
    channels: Sequence[Floats], first: Ints, counts: Ints, step: int, iir: IirFilter, kernel: Smoother
) -> Floats:
    """``envelopes_at`` by the compiled engine, but for windows that the ends of the record reach into."""
    # loaded when chosen: numba is an extra
    envelopes_inside = module_named("emg2vsa.signals.compiled").envelopes_inside
    starts, stops = first - kernel.before - iir.support_samples, first + step * (counts - 1) + kernel.after
    ends, size = stops + (iir.support_samples if iir.zero_phase else 0), channels[0].size
    if starts.min() >= 0 and ends.max() < size and step * counts.max() < LONG:
        levels: Floats = envelopes_inside(
            channels, first, counts, step, iir, kernel.taps, kernel.before, squared=kernel.squared
        )
        return levels
    inside = (starts >= 0) & (ends < size) & (step * counts < LONG)
    levels, of = np.empty((len(channels), int(counts.sum()))), np.repeat(inside, counts)
    levels[:, of] = _compiled(channels, first[inside], counts[inside], step, iir, kernel) if np.any(of) else 0.0
    levels[:, ~of] = _by_products(channels, first[~inside], counts[~inside], step, iir, kernel)
    return levels


def _by_products(
    channels: Sequence[Floats], first: Ints, counts: Ints, step: int, iir: IirFilter, kernel: Smoother
) -> Floats:
    """``envelopes_at`` by products of matrices, ``LONG`` samples at a time."""
    reach = kernel.taps.size + 2 * iir.support_samples
    at = np.cumsum(step * counts + reach) // LONG
    cuts = [0, *(np.flatnonzero(np.diff(at)) + 1).tolist(), first.size]
    parts = [
        _envelopes(channels, first[i:j], counts[i:j], step, iir, kernel) for i, j in itertools.pairwise(cuts)
    ]  # fmt: skip
    return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=1)


def _envelopes(
    channels: Sequence[Floats], first: Ints, counts: Ints, step: int, iir: IirFilter, kernel: Smoother
) -> Floats:
    """``envelopes_at`` of windows that are filtered together."""
    n = channels[0].size
    starts, stops = first - kernel.before, first + step * (counts - 1) + kernel.after + 1
    filtered = filter_windows(channels, np.maximum(starts, 0), np.minimum(stops, n), iir)
    n_out = max(FEWEST_OUT, -(-kernel.taps.size // step) - 1)
    n_blocks = -(-counts // n_out) + 1
    begins = np.cumsum(n_blocks) - n_blocks
    rectified = np.zeros((len(channels), int(n_blocks.sum()), n_out * step))
    flat = rectified.reshape(len(channels), -1)
    for source, begin in zip(filtered, (begins * n_out * step + np.maximum(-starts, 0)).tolist(), strict=True):
        np.abs(source, out=flat[:, begin : begin + source.shape[1]])
    unit = np.ones((len(channels), 1))
    if kernel.squared:  # squares of 1e-160 V are zero, of 1e160 infinite; powers of two round nothing
        unit = np.ldexp(unit, np.maximum(exponent_of(flat), SMALLEST_EXPONENT))
        flat /= unit
        np.square(flat, out=flat)
    smoothed = _smooth(rectified, step, kernel)
    cuts = zip((begins * n_out).tolist(), counts.tolist(), strict=True)
    levels = np.concatenate([smoothed[:, begin : begin + count] for begin, count in cuts], axis=1)
    if starts.min() < 0 or stops.max() > n:
        windows = zip(first.tolist(), counts.tolist(), strict=True)
        levels /= _tap_sum(kernel, np.concatenate([begin + step * np.arange(count) for begin, count in windows]), n)
    # a Hamming low-pass has tiny negative side taps; an envelope is never negative
    np.maximum(levels, 0, out=levels)
    return np.sqrt(levels) * unit if kernel.squared else levels


def _smooth(rectified: Floats, step: int, kernel: Smoother) -> Floats:
    """Smoothed outputs (m, N), ``step`` samples apart, of rectified samples (m, blocks, n); of the last block none.

    The outputs of a block need it and the start of the next only, so that two small matrices of taps make all of them.
    """
    own, following = _tap_matrices(kernel.taps.tobytes(), step, rectified.shape[-1] // step)
    smoothed = times(rectified[:, :-1], own)
    smoothed += times(rectified[:, 1:, : len(following)], following)
    return smoothed.reshape(len(rectified), -1)


@lru_cache(maxsize=16)
def _tap_matrices(taps: bytes, step: int, n_out: int) -> tuple[Floats, Floats]:
    """What the samples of a block, and the first of the next, add to its outputs: (n_out * step, n_out), (r, n_out)."""
    kernel, size = np.frombuffer(taps), n_out * step
    both = np.zeros((size + max(kernel.size - step, 0), n_out))
    for k in range(n_out):
        both[k * step : k * step + kernel.size, k] = kernel
    return both[:size].copy(), both[size:].copy()


def _tap_sum(kernel: Smoother, at: Ints, n_samples: int) -> Floats:
    cumulative = np.concatenate(([0.0], np.cumsum(kernel.taps)))
    missing_before = np.maximum(kernel.before - at, 0)
    missing_after = np.maximum(at + kernel.after - (n_samples - 1), 0)
    remaining = cumulative[kernel.taps.size - missing_after] - cumulative[missing_before]
    return np.asarray(np.maximum(remaining, 0.5 * cumulative[-1]), dtype=np.float64)


def decimation(fs_hz: float, output_fs_hz: float | Literal["native"]) -> int:
    """Whole number of samples between outputs, nearest to the rate that is asked for."""
    return 1 if output_fs_hz == "native" else max(1, round(fs_hz / output_fs_hz))
