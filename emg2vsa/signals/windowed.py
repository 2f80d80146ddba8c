"""Filtering only the parts of a record that are used, with the result of filtering all of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from casr.counts import count
from emg2vsa.arrays import Floats, Ints, finite
from emg2vsa.errors import SignalError
from emg2vsa.signals.blocks import SIZE, blocks_of, fill_states
from emg2vsa.signals.filters import IirFilter
from emg2vsa.signals.products import times

LONG = 2**19
"A record of more samples is not filtered at once, which takes three times its memory."


def filter_record(samples: Floats, iir: IirFilter) -> Floats:
    """The whole record (n,), as ``sosfiltfilt`` (zero-phase) or one pass that starts in steady state (causal).

    A long one is filtered in windows of ``LONG`` samples or more. SignalError where samples are not finite, or no more
    than those that extend the record at its ends.
    """
    finite(samples, iir.name)
    at_once = max(LONG, 16 * iir.support_samples)
    if samples.size <= at_once:
        (whole,) = filter_windows((samples,), np.zeros(1, np.int64), np.array([samples.size]), iir)
        return np.asarray(whole[0])
    filtered = np.empty(samples.size)
    for begin in range(0, samples.size, at_once):
        end = min(begin + at_once, samples.size)
        (own,) = filter_windows((samples,), np.array([begin]), np.array([end]), iir)
        filtered[begin:end] = own[0]
    return filtered


def filter_windows(channels: Sequence[Floats], starts: Ints, stops: Ints, iir: IirFilter) -> list[Floats]:
    """Every window [start, stop) of every channel (n,), filtered: (m, stop - start) each.

    A window is widened by the filter's support, within which whatever stands before (and after) it dies out, so the
    result equals that of the whole record to better than 1e-10 of the signal, where the filter keeps nine digits; at
    the ends of the record it is the same odd extension as ``sosfiltfilt`` uses. Widened windows that overlap are one
    piece, a whole number of blocks; all pieces are filtered as one signal, end to end.

    channels : finite. SignalError where they have no more samples than extend the record at its ends.
    """
    if channels[0].size <= iir.pad_samples:
        wanted, found = f"more than {iir.pad_samples} samples", f"{channels[0].size}"
        raise SignalError(iir.name, wanted=wanted, found=found, do="Record for longer.")
    windows = list(zip(starts.tolist(), stops.tolist(), strict=True))
    pieces, piece_of = _pieces(windows, channels[0].size, iir)
    filtered = _run(channels, pieces, iir)
    origins = [piece.left + SIZE * piece.first for piece in pieces]
    within = zip(piece_of, windows, strict=True)
    return [filtered[p][:, start - origins[p] : stop - origins[p]] for p, (start, stop) in within]


@dataclass
class _Piece:
    """Samples [left, right) of a record, with its extension; of these [start, stop) are wanted."""

    left: int
    right: int
    start: int
    stop: int

    @property
    def n_blocks(self) -> int:
        return -((self.left - self.right) // SIZE)

    @property
    def first(self) -> int:
        """First block that is wanted."""
        return (self.start - self.left) // SIZE

    @property
    def after(self) -> int:
        """One past the last block that is wanted."""
        return -((self.left - self.stop) // SIZE)


def _pieces(windows: Sequence[tuple[int, int]], n: int, iir: IirFilter) -> tuple[list[_Piece], list[int]]:
    """Pieces of whole blocks, in the order of time, and the piece of each window.

    They stand so far apart that only the first can hold the record's first sample, and only the last its last one.
    """
    pieces: list[_Piece] = []
    piece_of = [0] * len(windows)
    for i in sorted(range(len(windows)), key=windows.__getitem__):
        start, stop = windows[i]
        left = max(start - iir.support_samples, -iir.pad_samples)
        right = min(stop + iir.support_samples, n + iir.pad_samples) if iir.zero_phase else stop
        if pieces and left < pieces[-1].right + SIZE:
            pieces[-1].right, pieces[-1].stop = max(right, pieces[-1].right), max(stop, pieces[-1].stop)
        else:
            pieces.append(_Piece(left, right, start, stop))
        piece_of[i] = len(pieces) - 1
    last = pieces[-1]
    last.left = min(last.left, n + iir.pad_samples - last.n_blocks * SIZE)
    return pieces, piece_of


def _run(channels: Sequence[Floats], pieces: Sequence[_Piece], iir: IirFilter) -> list[Floats]:
    """The wanted blocks of every piece, filtered: (m, samples) each.

    Within the support before the end of the record both passes are not one: the backward pass starts there anew.
    """
    *inner, last = pieces
    ended, support = channels[0].size + iir.pad_samples, SIZE * -(-iir.support_samples // SIZE)
    anew = max(last.left + SIZE * last.first, ended - support)
    if not iir.zero_phase or last.left + SIZE * last.n_blocks < ended or last.stop <= anew:
        return _filtered(channels, pieces, iir, both_passes=iir.zero_phase)
    end = _one_by_one(channels, _Piece(max(last.left, anew - support), ended, anew, last.stop), iir)
    if anew <= last.start:
        return [*(_filtered(channels, inner, iir, both_passes=True) if inner else []), end]
    *found, before = _filtered(channels, [*inner, replace(last, right=ended, stop=anew)], iir, both_passes=True)
    return [*found, np.concatenate((before, end), axis=1)]


def _one_by_one(channels: Sequence[Floats], piece: _Piece, iir: IirFilter) -> Floats:
    """The wanted blocks (m, samples) of a piece that ends with the record, by a forward and then a backward pass."""
    (forward,) = _filtered(channels, [replace(piece, start=piece.left, stop=piece.right)], iir, both_passes=False)
    size, first, after = forward.shape[1], SIZE * piece.first, SIZE * piece.after
    (backward,) = _filtered(list(forward[:, ::-1]), [_Piece(0, size, 0, size - first)], iir, both_passes=False)
    return backward[:, ::-1][:, : after - first]


def _filtered(
    channels: Sequence[Floats], pieces: Sequence[_Piece], iir: IirFilter, *, both_passes: bool
) -> list[Floats]:
    """The wanted blocks of pieces beyond whose ends no sample counts: (m, samples) each."""
    filters, m = blocks_of(iir.sos.tobytes(), both_passes), len(channels)
    count("samples conditioned", m * sum(SIZE * piece.n_blocks for piece in pieces))
    rows = np.empty((m, sum(piece.n_blocks for piece in pieces), len(filters.output)))
    wanted, offsets, begin = [], [], 0
    for piece in pieces:
        own = rows[:, begin : begin + piece.n_blocks]
        targets = zip(channels, own[:, :, :SIZE], strict=True)
        offsets.append([[_lay(samples, piece.left, iir.pad_samples, target)] for samples, target in targets])
        wanted.append(own[:, piece.first : piece.after])
        begin += piece.n_blocks
    fill_states(rows, filters)
    filtered = [times(blocks, filters.output).reshape(m, -1) for blocks in wanted]
    if iir.passes_offset:
        for found, offset in zip(filtered, offsets, strict=True):
            found += offset
    return filtered


def _lay(samples: Floats, left: int, pad: int, target: Floats) -> float:
    """Fill blocks (k, SIZE) with the samples from ``left`` on, less the first of them, which is returned.

    Without it an offset of the record costs no digits. Up to ``pad`` samples before and after the record are its odd
    extension; before them its first value stands for ever.
    """
    right = left + target.size
    if left >= 0 and right <= samples.size:
        inner = np.asarray(samples[left:right], dtype=np.float64).reshape(target.shape)
        np.subtract(inner, inner[0, 0], out=target)
        return float(inner[0, 0])
    first = max(left, -pad)
    cut = _cut(samples, first, right)
    target[...] = np.concatenate((np.zeros(first - left), cut - cut[0])).reshape(target.shape)
    return float(cut[0])


def _cut(samples: Floats, begin: int, end: int) -> Floats:
    """Samples [begin, end) as float64, oddly extended beyond the record: single precision has no room."""
    n = samples.size
    inner = np.asarray(samples[max(begin, 0) : min(end, n)], dtype=np.float64)
    first, last = float(samples[0]), float(samples[-1])
    left = 2 * first - samples[max(-begin, 0) : 0 : -1].astype(np.float64)
    right = 2 * last - samples[n - 1 - max(end - n, 0) : n - 1][::-1].astype(np.float64)
    return np.concatenate((left, inner, right))
