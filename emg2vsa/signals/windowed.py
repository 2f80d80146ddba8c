"""Filtering only the parts of a record that are used, with the result of filtering all of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import signal

from emg2vsa.arrays import Floats, Ints
from emg2vsa.signals.filters import IirFilter


@dataclass(frozen=True)
class Pieces:
    """Filtered pieces of a record of ``n_samples``.

    rows : (m, p, length) filtered samples of m channels. piece : (w,) which piece holds window w.
    first : (p,) record index of a piece's first sample; pieces may reach into the extension beyond the record.
    """

    rows: Floats
    piece: Ints
    first: Ints
    n_samples: int


def filter_record(samples: Floats, iir: IirFilter) -> Floats:
    """The whole record (n,), as ``sosfiltfilt`` (zero-phase) or one pass that starts in steady state (causal)."""
    extended = _cut(samples, -iir.pad_samples, samples.size + 2 * iir.pad_samples)
    return _run(extended[None], iir, iir.pad_samples)[0, : samples.size]


def filter_windows(channels: Sequence[Floats], starts: Ints, stops: Ints, iir: IirFilter) -> Pieces:
    """Every window [start, stop) of every channel, filtered in one batch.

    A window is widened by the filter's support, within which the missing past (and future) dies out, so the result
    equals that of the whole record to better than 1e-10 of the signal; at the ends of the record it is the same
    odd extension as ``sosfiltfilt`` uses. Windows that together are longer than the record are one piece, the record.
    """
    n, pad = channels[0].size, iir.pad_samples
    after = iir.support_samples if iir.zero_phase else 0
    length = int(np.max(stops - starts, initial=0)) + iir.support_samples + after
    if length * starts.size >= n + 2 * pad:
        length, piece, first = n + 2 * pad, np.zeros(starts.size, np.int64), np.array([-pad])
    else:
        piece, first = np.arange(starts.size), np.clip(starts - iir.support_samples, -pad, n + pad - length)
    cut = np.empty((len(channels), first.size, length))
    for row, samples in zip(cut, channels, strict=True):
        for target, begin in zip(row, first, strict=True):
            target[:] = _cut(samples, int(begin), length)
    lead = int(np.min(starts - first[piece], initial=length))
    rows = _run(cut.reshape(-1, length), iir, lead)
    return Pieces(rows.reshape(*cut.shape[:2], -1), piece, first + lead, n)


def _cut(samples: Floats, begin: int, length: int) -> Floats:
    end, n = begin + length, samples.size
    inner = samples[max(begin, 0) : min(end, n)]
    if begin >= 0 and end <= n:
        return inner
    left = 2 * samples[0] - samples[max(-begin, 0) : 0 : -1]
    right = 2 * samples[-1] - samples[n - 1 - max(end - n, 0) : n - 1][::-1]
    return np.concatenate((left, inner, right))


def _run(rows: Floats, iir: IirFilter, lead: int) -> Floats:
    """All passes over rows (r, n); the result without its first ``lead`` samples, which nobody needs: (r, n - lead)."""
    filtered = _pass(rows, iir)[:, lead:]
    return _pass(filtered[:, ::-1], iir)[:, ::-1] if iir.zero_phase else filtered


def _pass(rows: Floats, iir: IirFilter) -> Floats:
    steady = iir.state[:, None, :] * rows[None, :, :1]
    filtered, _ = signal.sosfilt(iir.sos, rows, axis=-1, zi=steady)
    return np.asarray(filtered, dtype=np.float64)
