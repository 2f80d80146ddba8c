"""Preconditions of arrays: what every stage asks of samples before it computes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.errors import SignalError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

AT_ONCE = 2**17
"Samples of a long record that are worked on at a time: what they are copied to stays in the processor's cache."


def slices(n: int, width: int = 1) -> Iterator[slice]:
    """Parts of n rows of ``width`` samples, one after the other."""
    rows = max(1, AT_ONCE // width)
    for begin in range(0, n, rows):
        yield slice(begin, min(begin + rows, n))


def sums_of(blocks: Floats) -> Floats:
    """Sums (k,) of blocks (k, size); numpy's own take five times as long where blocks are short."""
    return np.asarray(np.einsum("ij->i", blocks))


def uniform(shape: int | tuple[int, ...], number: float) -> NDArray[Any]:
    """An array of one integer or one float; ``np.full`` takes twice as long where it is small."""
    array = np.empty(shape, dtype=type(number))
    array.fill(number)
    return array


def aligned(rows: int, columns: int) -> Floats:
    """An empty table that begins with a line of the processor's cache; arithmetic on numpy's own, which begin within
    one, takes up to twice as long."""
    room = np.empty(rows * columns + 7)
    first = -(room.ctypes.data // room.itemsize) % 8
    return room[first : first + rows * columns].reshape(rows, columns)


def samples_1d(values: ArrayLike, where: str, *, at_least: int = 1) -> Floats:
    """``values`` as a contiguous float64 vector (n,), n >= ``at_least``; SignalError where it is not."""
    samples = np.ascontiguousarray(values, dtype=np.float64)
    if samples.ndim != 1 or samples.size < at_least:
        found = f"{samples.size} samples" if samples.ndim == 1 else f"an array of shape {samples.shape}"
        raise SignalError(where, wanted=f"one row of at least {at_least} samples", found=found, do="Record for longer.")
    return samples


def unmasked(values: ArrayLike) -> ArrayLike:
    """``values`` with the masked ones as NaN (None among objects): a plain array would bring them back."""
    if not isinstance(values, np.ma.MaskedArray):
        return values
    missing = None if values.dtype == object else np.nan
    plain = np.array(values.data, dtype=object if missing is None else np.float64)
    plain[np.ma.getmaskarray(values)] = missing
    return plain


def finite(samples: Floats, where: str, *, at_least: int = 0) -> Floats:
    """The same samples (n,). SignalError where one is not finite, or n < ``at_least``."""
    if samples.size < at_least:
        found, do = f"{samples.size}", "Record for longer."
        raise SignalError(where, wanted=f"{at_least} samples or more", found=found, do=do)
    if not np.isfinite(samples).all():
        count = samples.size - int(np.count_nonzero(np.isfinite(samples)))
        do = "Fill gaps first, and correct what is infinite."
        raise SignalError(where, wanted="finite samples", found=f"{count} of {samples.size} that are not", do=do)
    return samples


def bridge_gaps(samples: Floats, where: str) -> tuple[Floats, NDArray[np.bool_]]:
    """Samples with every non-finite one replaced by linear interpolation, and the mask (n,) of those replaced; it is
    not to be written to.

    SignalError where none is a number.
    """
    missing = ~np.isfinite(samples)
    n_missing = int(np.count_nonzero(missing))
    if n_missing == 0:
        return samples, np.broadcast_to(np.False_, samples.shape)  # one byte, whatever n
    if n_missing == samples.size:
        raise SignalError(where, wanted="finite numbers", found="none", do="Check the export of this channel.")
    index = np.arange(samples.size)
    filled = samples.copy()
    filled[missing] = np.interp(index[missing], index[~missing], samples[~missing])
    return filled, missing


def runs_of(mask: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """First index and one past the last index of every run of True in ``mask`` (n,)."""
    ends = np.zeros(mask.size + 1, dtype=np.bool_)
    np.not_equal(mask[1:], mask[:-1], out=ends[1:-1])
    if mask.size:
        ends[0], ends[-1] = mask[0], mask[-1]
    edges = np.flatnonzero(ends)
    return edges[0::2], edges[1::2]


def mean_of(values: Floats) -> Floats:
    """Mean along the last axis of the values (..., n) that are there; NaN where there is none."""
    there = np.isfinite(values)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sum(values, axis=-1, where=there) / np.count_nonzero(there, axis=-1))


SORTED_BELOW = 1000
"So few values are sorted sooner than parted."


def median(values: Floats) -> float:
    """Median of finite values (n,), n >= 1; numpy's costs more in its preparations than in a few values."""
    middle = values.size // 2
    if values.size < SORTED_BELOW:
        ordered = values.copy()
        ordered.sort()
        return float(ordered[(values.size - 1) // 2] + ordered[middle]) / 2
    parted = np.partition(values, middle)
    below = parted[middle] if values.size % 2 else parted[:middle].max()
    return float(below + parted[middle]) / 2


def quantiles(ordered: Floats, *shares: float) -> list[float]:
    """Quantiles of values (n,), n >= 1, in ascending order: numpy's default, linear between neighbours."""
    found = []
    for share in shares:
        at = share * (ordered.size - 1)
        low = min(int(at), max(ordered.size - 2, 0))
        high = min(low + 1, ordered.size - 1)
        found.append(float(ordered[low] + (at - low) * (ordered[high] - ordered[low])))
    return found


def exponent_of(values: Floats) -> NDArray[np.int32]:
    """Binary exponent e of the largest |value| along the last axis (kept), for finite values; 0 where all are zero.

    |value| <= 2^e: rows scaled by 2^-e can be squared and summed without overflow or underflow, and without rounding.
    """
    return np.asarray(np.frexp(np.max(np.abs(values), axis=-1, keepdims=True, initial=0.0))[1], dtype=np.int32)
