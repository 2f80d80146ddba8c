"""Filtering only the parts of a record that are used, with the result of filtering all of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import signal

from emg2vsa.arrays import Floats, Ints
from emg2vsa.signals.filters import IirFilter


def filter_record(samples: Floats, iir: IirFilter) -> Floats:
    """The whole record (n,), as ``sosfiltfilt`` (zero-phase) or one pass that starts in steady state (causal)."""
    extended = _cut(samples, -iir.pad_samples, samples.size + 2 * iir.pad_samples)
    return _run(extended[None], iir, iir.pad_samples)[0, : samples.size]


def filter_windows(channels: Sequence[Floats], starts: Ints, stops: Ints, iir: IirFilter) -> tuple[Floats, Ints]:
    """Every window [start, stop) of every channel, filtered in one batch; one window at least.

    Returns rows (m, N) of filtered samples and the column (w,) at which each window begins. A window is widened by the
    filter's support, within which whatever stands before (and after) it dies out, so the result equals that of the
    whole record to better than 1e-10 of the signal; at the ends of the record it is the same odd extension as
    ``sosfiltfilt`` uses. Widened windows that overlap are one piece, and a row is all pieces, one after the other.
    """
    n, pad = channels[0].size, iir.pad_samples
    begins = np.maximum(starts - iir.support_samples, -pad)
    ends = np.minimum(stops + iir.support_samples, n + pad) if iir.zero_phase else stops
    order = np.argsort(begins)
    ordered, reached = begins[order], np.maximum.accumulate(ends[order])
    apart = ordered[1:] > reached[:-1]
    first, last = ordered[np.append(True, apart)], reached[np.append(apart, True)]
    columns = np.cumsum(last - first) - last
    piece = np.searchsorted(first, begins, side="right") - 1
    pieces = list(zip(first.tolist(), (last - first).tolist(), strict=True))
    rows = np.array([np.concatenate([_cut(samples, *piece) for piece in pieces]) for samples in channels])
    return _run(rows, iir, 0), columns[piece] + starts


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


def _run(rows: Floats, iir: IirFilter, lead: int) -> Floats:
    """All passes over rows (r, n); the result without its first ``lead`` samples, which nobody needs: (r, n - lead)."""
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
