"""Envelopes by one compiled recursion: the engine ``compiled`` of ``[filters]``, more than twice as fast as
products of matrices.

Windows of a record, a few of all channels at a time, stand side by side as lanes: every inner loop runs over lanes, so
that LLVM makes SIMD of it. No operation is reordered or contracted: the bytes are those of any processor, and of the
same loops in Python.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeVar, cast

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import SettingError, install_extra
from emg2vsa.signals.filters import IirFilter

try:
    from numba import njit
except ModuleNotFoundError as error:
    raise SettingError(
        "filters.engine", wanted="the package numba, which compiles this engine", found="no such package",
        do=f"Install it ({install_extra('flow')}), or set engine = \"plain\".",
    ) from error  # fmt: skip

Function = TypeVar("Function", bound=Callable[..., Any])
LANES = 24
"Windows times channels at a time: more leave the processor's cache."
TURNED = 8
"Samples of a lane that are laid at a time."


def kernel(function: Function) -> Function:
    """Compile on first use, and keep the result on disk."""
    return cast(Function, njit(cache=True, nogil=True, error_model="numpy")(function))


def envelopes_inside(
    channels: Sequence[Floats], first: Ints, counts: Ints, step: int, iir: IirFilter, taps: Floats, before: int,
    *, squared: bool,
) -> Floats:  # fmt: skip
    """Envelopes (channels, sum of counts) as ``envelope.envelopes_at`` gives them, of windows whose support and kernel
    lie inside the record; the kernel has taps, of which so many are before the instant of output."""
    support, m = iir.support_samples, len(channels)
    out = np.empty((m, int(counts.sum())))
    # sections run in pairs, the last beside one that changes nothing
    sos = np.concatenate((iir.sos, [[1.0, 0, 0, 1, 0, 0]])) if len(iir.sos) % 2 else iir.sos
    pairs = sos.reshape(-1, 2, 6)
    begins = np.cumsum(counts) - counts
    by_length = np.argsort(counts, kind="stable")
    at_once = max(1, LANES // m)
    for i in range(0, first.size, at_once):
        chosen = by_length[i : i + at_once]
        _lanes(
            tuple(channels),
            first[chosen] - before - support,
            counts[chosen],
            begins[chosen],
            step,
            support,
            pairs,
            iir.zero_phase,
            iir.passes_offset,
            taps,
            squared,
            out,
        )
    return out


@kernel
def _lanes(
    channels: tuple[Floats, ...], starts: Ints, counts: Ints, begins: Ints, step: int, support: int, pairs: Floats,
    both_passes: bool, passes_offset: bool, taps: Floats, squared: bool, out: Floats,
) -> None:  # fmt: skip
    """Some windows, the longest last."""
    n = counts.size
    length = step * (counts[n - 1] - 1) + taps.size
    x = np.empty((support + length + (support if both_passes else 0), len(channels) * n))
    offset, unit = np.empty(x.shape[1]), np.ones(x.shape[1])
    for c in range(len(channels)):
        _cut(channels[c], starts, offset[c * n : (c + 1) * n], x[:, c * n : (c + 1) * n])
    runs = 2 * len(pairs) if both_passes else len(pairs)
    plain = not (passes_offset or squared)  # the last run can leave sizes behind
    for i in range(runs):
        pair, backwards, sizes = pairs[i % len(pairs)], i >= len(pairs), plain and i == runs - 1
        rows = len(x) - support if backwards else len(x)
        if pair[0, 0] == pair[0, 2] and pair[1, 0] == 1.0 and pair[1, 2] == 1.0:
            _filter(x, pair, rows, backwards, sizes, True)
        else:
            _filter(x, pair, rows, backwards, sizes, None)
    inner = x[support : support + length]
    if not plain:
        _rectify(inner, offset, unit, passes_offset, squared)
    _smooth(inner, taps, step, unit, squared, begins, counts, out)


@kernel
def _cut(samples: Floats, starts: Ints, offset: Floats, x: Floats) -> None:
    """Lay samples from each of the starts on, less the first of them, the offset, into the lanes of x.

    A lane that is shorter than others goes on; beyond the end of the record are zeros, which no window sees.
    """
    for k in range(starts.size):
        offset[k] = samples[starts[k]]
    inside = min(x.shape[0], samples.size - starts.max()) // TURNED * TURNED
    for t in range(0, inside, TURNED):
        for k in range(starts.size):
            begin, own = starts[k] + t, offset[k]
            for j in range(TURNED):
                x[t + j, k] = samples[begin + j] - own
    for t in range(inside, x.shape[0]):
        for k in range(starts.size):
            x[t, k] = samples[starts[k] + t] - offset[k] if starts[k] + t < samples.size else 0.0


@kernel
def _filter(x: Floats, pair: Floats, n: int, backwards: bool, sizes: bool, even: Literal[True] | None) -> None:
    """n samples of every lane, from the first or the last on, through two sections in transposed direct form II.

    sizes : what is left is rectified. even : the ends of both numerators are alike, and those of the second are 1, as
    Butterworth's mostly are: three products of ten need not be made. Numba compiles True and None apart.
    """
    b0, b1, b2, a1, a2 = pair[0, 0], pair[0, 1], pair[0, 2], pair[0, 4], pair[0, 5]
    c0, c1, c2, d1, d2 = pair[1, 0], pair[1, 1], pair[1, 2], pair[1, 4], pair[1, 5]
    z = np.zeros((4, x.shape[1]))
    for i in range(n):
        t = x.shape[0] - 1 - i if backwards else i
        for k in range(x.shape[1]):
            v = x[t, k]
            y = b0 * v + z[0, k]
            z[0, k] = b1 * v - a1 * y + z[1, k]
            z[1, k] = (b0 if even is not None else b2) * v - a2 * y
            w = (y if even is not None else c0 * y) + z[2, k]
            z[2, k] = c1 * y - d1 * w + z[3, k]
            z[3, k] = (y if even is not None else c2 * y) - d2 * w
            x[t, k] = abs(w) if sizes else w


@kernel
def _rectify(x: Floats, offset: Floats, unit: Floats, passes_offset: bool, squared: bool) -> None:
    """Sizes, or squares in units of a power of two, which rounds nothing: squares of 1e-160 V are zero, of 1e160
    infinite."""
    for t in range(x.shape[0] if passes_offset else 0):
        for k in range(x.shape[1]):
            x[t, k] += offset[k]
    if squared:
        unit[:] = 0.0
        for t in range(0, x.shape[0], 2):
            other = min(t + 1, x.shape[0] - 1)
            for k in range(x.shape[1]):
                unit[k] = max(unit[k], max(abs(x[t, k]), abs(x[other, k])))
        for k in range(x.shape[1]):
            unit[k] = 2.0 ** max(math.frexp(unit[k])[1], -1021)
    inverse = 1 / unit
    for t in range(x.shape[0]):
        for k in range(x.shape[1]):
            x[t, k] = (x[t, k] * inverse[k]) ** 2 if squared else abs(x[t, k])


@kernel
def _smooth(
    x: Floats, taps: Floats, step: int, unit: Floats, squared: bool, begins: Ints, counts: Ints, out: Floats
) -> None:
    """The taps over every ``step``-th sample on, of each lane as many as its window has."""
    n, level, whole = counts.size, np.empty(x.shape[1]), taps.size - taps.size % 8
    for i in range(counts[n - 1]):
        level[:] = 0.0
        own = x[i * step : i * step + taps.size]
        for j in range(0, whole, 8):  # eight taps in turn, for which a level is read and written once
            t0, t1, t2, t3 = taps[j], taps[j + 1], taps[j + 2], taps[j + 3]
            t4, t5, t6, t7 = taps[j + 4], taps[j + 5], taps[j + 6], taps[j + 7]
            for k in range(level.size):
                half = level[k] + t0 * own[j, k] + t1 * own[j + 1, k] + t2 * own[j + 2, k] + t3 * own[j + 3, k]
                level[k] = half + t4 * own[j + 4, k] + t5 * own[j + 5, k] + t6 * own[j + 6, k] + t7 * own[j + 7, k]
        for j in range(whole, taps.size):
            for k in range(level.size):
                level[k] += taps[j] * own[j, k]
        for c in range(out.shape[0]):
            for k in range(n):
                if i < counts[k]:
                    # a Hamming low-pass has tiny negative side taps; an envelope is never negative
                    positive = max(level[c * n + k], 0.0)
                    out[c, begins[k] + i] = np.sqrt(positive) * unit[c * n + k] if squared else positive
