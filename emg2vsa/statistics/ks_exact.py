"""Exact distribution of the two-sided Kolmogorov-Smirnov statistic, many statistics at once."""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints

_LIMIT_LAW_FROM = 5000
_TAIL = 5.0  # n d^2 beyond which both one-sided events together are rarer than 1e-17
_WIDTHS_TOGETHER = 3  # bits of k: matrices of up to 8 values of k are padded to one size
_PLAIN_UP_TO = 400  # rows of the matrix sum to less than 4: its powers up to here stay below 2^800
_LARGE_EXPONENT = 200  # of two; powers are scaled down beyond, long before their squares overflow


def ks_survival(d: ArrayLike, n: ArrayLike) -> Floats:
    """P(D_n >= d) for samples of n from a continuous law; d, n : (k,). NaN for d NaN.

    Marsaglia, Tsang and Wang (2003), batched; for d >= 1/2 or far in the tail twice the one-sided probability (exact,
    and below 1e-17 off), which keeps its digits where p is tiny. Above n = 5000 the limit law (p off by < .005).
    """
    d, n = np.broadcast_arrays(np.asarray(d, dtype=np.float64), np.asarray(n, dtype=np.int64))
    p = np.full(d.shape, np.nan)
    reach = n * d
    p[reach <= 0.5] = 1.0
    left = reach > 0.5
    tail = left & ((d >= 0.5) | (reach * d > _TAIL))
    p[tail] = np.minimum(1.0, 2 * special.smirnov(n[tail], d[tail]))
    large = left & ~tail & (n > _LIMIT_LAW_FROM)
    p[large] = special.kolmogorov(np.sqrt(n[large]) * d[large])
    body = left & ~tail & ~large
    k = np.floor(np.where(body, reach, 0.0)).astype(np.int64) + 1
    width = k >> _WIDTHS_TOGETHER
    for size, alike in set(zip(n[body].tolist(), width[body].tolist(), strict=True)):
        same = body & (n == size) & (width == alike)
        p[same] = 1 - _cdf(d[same], size, k[same])
    return p


def _cdf(d: Floats, n: int, k: Ints) -> Floats:
    """P(D_n < d) = n!/n^n (H^n)[k-1, k-1], with k = floor(n d) + 1; d, k : (j,)."""
    power, exponent = _power(_matrix(k - n * d, k), n)
    numerator, denominator = factorial(n), n**n
    shift = denominator.bit_length() - numerator.bit_length()
    factor = (numerator << shift) / denominator  # correctly rounded, and within 1/2 to 2
    middle = power[np.arange(k.size), k - 1, k - 1]
    return np.asarray(np.clip(np.ldexp(middle * factor, exponent - shift), 0.0, 1.0))


def _matrix(h: Floats, k: Ints) -> Floats:
    """The band matrices H of the paper, m by m with m = 2 k - 1, one per h = k - n d.

    Smaller ones sit in the upper left with zeros to their right: what is below does not enter their powers.
    """
    m = 2 * k - 1
    order = np.arange(1, np.max(m) + 1)
    inverse = 1 / special.gamma(order + 1.0)  # of order!, underflows to the 0 that it is
    # 1 / (i - j + 1)!, zero above the first diagonal over the main one
    by_distance = np.concatenate([np.zeros(order.size), [1.0], inverse])
    matrix = np.empty((m.size, order.size, order.size))
    matrix[:] = by_distance[order.size + 1 + order[:, None] - order]
    row, last = np.arange(m.size), m - 1
    powers = h[:, None] ** order
    edge = (1 - powers) * inverse
    matrix[:, :, 0] = edge
    matrix[row, last] = np.where(order <= m[:, None], edge[row[:, None], m[:, None] - order], 0.0)
    matrix[row, last, 0] = (1 - 2 * powers[row, last] + np.maximum(2 * h - 1, 0.0) ** m) * inverse[last]
    return matrix


def _power(matrix: Floats, n: int) -> tuple[Floats, int]:
    """``matrix`` (j, m, m) to the power n, n >= 1, as (mantissa, binary exponent), free of overflow."""
    if n <= _PLAIN_UP_TO:
        return np.linalg.matrix_power(matrix, n), 0
    result, result_exponent, exponent = None, 0, 0
    while True:
        if n & 1:
            product = matrix if result is None else result @ matrix
            result, result_exponent = _reduced(product, result_exponent + exponent)
        n >>= 1
        if result is not None and n == 0:
            return result, result_exponent
        matrix, exponent = _reduced(matrix @ matrix, 2 * exponent)


def _reduced(matrix: Floats, exponent: int) -> tuple[Floats, int]:
    largest = int(np.frexp(np.max(matrix))[1])
    return (matrix, exponent) if largest < _LARGE_EXPONENT else (np.ldexp(matrix, -largest), exponent + largest)
