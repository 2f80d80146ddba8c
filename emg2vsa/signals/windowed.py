"""Filtering only the parts of a record that are used, with the result of filtering all of it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy import fft, signal

from casr.counts import count
from emg2vsa.arrays import Floats, Ints
from emg2vsa.signals.filters import IirFilter

LENGTHS = 256
"Spectra are of a multiple of so many samples: few lengths occur, and the gains of each are computed once."
AT_ONCE = 2**18
"Samples that are transformed in one call: more need more memory, and gain nothing."


def filter_record(samples: Floats, iir: IirFilter) -> Floats:
    """The whole record (n,), as ``sosfiltfilt`` (zero-phase) or one pass that starts in steady state (causal)."""
    extended = _cut(samples, -iir.pad_samples, samples.size + 2 * iir.pad_samples)
    return _run(extended[None], iir, iir.pad_samples)[0, : samples.size]


def filter_windows(channels: Sequence[Floats], starts: Ints, stops: Ints, iir: IirFilter) -> list[Floats]:
    """Every window [start, stop) of every channel (n,), filtered: (m, stop - start) each.

    A window is widened by the filter's support, within which whatever stands before (and after) it dies out, so the
    result equals that of the whole record to better than 1e-10 of the signal; at the ends of the record it is the same
    odd extension as ``sosfiltfilt`` uses. Widened windows that overlap are one piece.
    """
    n, pad = channels[0].size, iir.pad_samples
    begins = np.maximum(starts - iir.support_samples, -pad)
    ends = np.minimum(stops + iir.support_samples, n + pad) if iir.zero_phase else stops
    order = np.argsort(begins)
    ordered, reached = begins[order], np.maximum.accumulate(ends[order])
    apart = ordered[1:] > reached[:-1]
    first, last = ordered[np.append(True, apart)].tolist(), reached[np.append(apart, True)].tolist()
    pieces = list(zip(first, last, strict=True))
    inner = [(begin, end) for begin, end in pieces if iir.zero_phase and begin >= 0 and end <= n]
    filtered = _by_spectrum(channels, inner, iir)
    for begin, end in set(pieces) - set(inner):
        rows = np.stack([_cut(samples, begin, end - begin) for samples in channels])
        filtered[begin, end] = _run(rows, iir, 0)
    windows = zip(np.searchsorted(first, begins, side="right").tolist(), starts.tolist(), stops.tolist(), strict=True)
    return [filtered[pieces[p - 1]][:, a - first[p - 1] : b - first[p - 1]] for p, a, b in windows]


def _cut(samples: Floats, begin: int, length: int) -> Floats:
    """Samples [begin, begin + length) as float64, oddly extended beyond the record: single precision has no room."""
    end, n = begin + length, samples.size
    inner = np.asarray(samples[max(begin, 0) : min(end, n)], dtype=np.float64)
    if begin >= 0 and end <= n:
        return inner
    first, last = float(samples[0]), float(samples[-1])
    left = 2 * first - samples[max(-begin, 0) : 0 : -1].astype(np.float64)
    right = 2 * last - samples[n - 1 - max(end - n, 0) : n - 1][::-1].astype(np.float64)
    return np.concatenate((left, inner, right))


def _by_spectrum(
    channels: Sequence[Floats], pieces: Sequence[tuple[int, int]], iir: IirFilter
) -> dict[tuple[int, int], Floats]:
    """Pieces [begin, end) of all channels (m, n), filtered in both passes at once by the power gain at each frequency.

    Right but within the support of either end of a piece, where its ends see each other. The line through its ends is
    taken out, so that they meet; a symmetric filter leaves a line as it is or, without gain at 0 Hz, nothing of it.
    """
    alike: dict[int, list[tuple[int, int]]] = {}
    for begin, end in pieces:
        size = LENGTHS * fft.next_fast_len(-(-(end - begin) // LENGTHS), real=True)
        alike.setdefault(size, []).append((begin, end))
    filtered = {}
    for size, own in alike.items():
        gains, rising = _power_gains(iir.sos.tobytes(), size), np.arange(size, dtype=np.float64)
        at_once = max(1, AT_ONCE // (size * len(channels)))
        for some in (own[i : i + at_once] for i in range(0, len(own), at_once)):
            rows = np.empty((len(some), len(channels), size))
            for of_piece, (begin, end) in zip(rows, some, strict=True):
                of_piece[:, end - begin :] = 0.0
                for row, samples in zip(of_piece, channels, strict=True):
                    np.subtract(samples[begin:end], samples[begin], out=row[: end - begin])
                    row[: end - begin] -= row[end - 1 - begin] / (end - 1 - begin) * rising[: end - begin]
            spectra = np.fft.rfft(rows)
            parts = spectra.view(np.float64)
            parts *= gains
            np.fft.irfft(spectra, size, out=rows)
            for of_piece, (begin, end) in zip(rows, some, strict=True):
                if iir.passes_offset:
                    for row, samples in zip(of_piece, channels, strict=True):
                        row[: end - begin] += np.linspace(samples[begin], samples[end - 1], end - begin)
                filtered[begin, end] = of_piece
    return filtered


@lru_cache(maxsize=64)
def _power_gains(sos: bytes, size: int) -> Floats:
    """Squared magnitude of the response, for the real and the imaginary parts (2 (size // 2 + 1),) of a spectrum.

    In powers of 1/z - 1, whose coefficients are small where the response is steep: those of 1/z would cancel there.
    """
    half_turns = np.pi * np.arange(size // 2 + 1) / size
    u = -2j * np.sin(half_turns) * np.exp(-1j * half_turns)
    gains = np.ones(u.size)
    for section in np.frombuffer(sos).reshape(-1, 6):
        above, below = ((a + c + b) + ((b + 2 * c) + c * u) * u for a, b, c in (section[:3], section[3:]))
        ratio = above / below
        gains *= ratio.real**2 + ratio.imag**2
    gains = np.repeat(gains, 2)
    gains.flags.writeable = False
    return gains


def _run(rows: Floats, iir: IirFilter, lead: int) -> Floats:
    """All passes over rows (r, n); the result without its first ``lead`` samples, which nobody needs: (r, n - lead)."""
    count("samples conditioned", rows.size)
    filtered = _pass(rows, iir)[:, lead:]
    return _pass(filtered[:, ::-1], iir)[:, ::-1] if iir.zero_phase else filtered


def _pass(rows: Floats, iir: IirFilter) -> Floats:
    """One pass over rows (r, n) that starts in the steady state of each row's first sample.

    The first sample is taken out, which is exact, and comes back with the filter's gain at 0 Hz, which is known: so an
    offset of the record costs no digits.
    """
    first = rows[:, :1]
    filtered = np.asarray(signal.sosfilt(iir.sos, rows - first, axis=-1), dtype=np.float64)
    if iir.passes_offset:
        filtered += first
    return filtered
