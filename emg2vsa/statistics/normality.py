"""Is a sample normal? Kolmogorov-Smirnov with the exact p of a finite sample, and Shapiro-Wilk, many samples at once.

Two tests go by the name of Kolmogorov and Smirnov. ``standardised``: the sample minus its mean over its SD against
N(0, 1); because the parameters come from the sample its p is far too large (at n = 10 the true size of a nominal .05 is
2e-5). ``raw``: the sample itself against N(0, 1), the default of MATLAB's kstest; any all-positive sample has D >= .5.
"""

from __future__ import annotations

from functools import cache
from math import factorial

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, unmasked
from emg2vsa.statistics.moments import row_moments
from emg2vsa.statistics.outcome import Outcomes

_NOTE = {
    True: "mean and SD estimated from the sample: p is too large (Lilliefors' table applies)",
    False: "against N(0, 1) in the unit of the data: tests location and scale as much as shape",
}
_LIMIT_LAW_FROM = 5000
_TAIL = 5.0  # n d^2 beyond which both one-sided events together are rarer than 1e-17
_WIDTHS_TOGETHER = 3  # bits of k: matrices of up to 8 values of k are padded to one size
_PLAIN_UP_TO = 400  # rows of the matrix sum to less than 4: its powers up to here stay below 2^800
_LARGE_EXPONENT = 200  # of two; powers are scaled down beyond, long before their squares overflow
MOST = 5000
"""Values of a sample up to which Royston fitted p."""
# Royston's polynomials, lowest power first
_LAST = (0.0, 0.221157, -0.147981, -2.071190, 4.434685, -2.706056)
_LAST_BUT_ONE = (0.0, 0.042981, -0.293762, -1.752461, 5.682633, -3.582633)
_SMALL_MEAN, _SMALL_LOG_SD = (0.5440, -0.39978, 0.025054, -6.714e-4), (1.3822, -0.77857, 0.062767, -0.0020322)
_LARGE_MEAN, _LARGE_LOG_SD = (-1.5861, -0.31082, -0.083751, 0.0038915), (-0.4803, -0.082676, 0.0030302)
_SMALL_SHIFT = (-2.273, 0.459)
_SMALL = 11


def ks_normal(values: ArrayLike, *, standardise: bool) -> Outcomes:
    """Test each row of ``values`` (k, n), or one row (n,); NaN marks a value that is not there.

    A constant row, or one with a single value, has no standardised test (NaN).
    """
    d, n = largest_gap(values, standardise=standardise)
    undefined = np.isnan(d)
    return Outcomes(
        method="Kolmogorov-Smirnov, " + ("standardised" if standardise else "raw N(0, 1)"),
        statistic_name="D",
        statistic=d,
        p=ks_survival(d, n),
        n=n,
        notes=(
            (_NOTE[standardise], np.ones(n.shape, dtype=np.bool_)),
            ("undefined: all values are equal", undefined & (n > 1)),
            ("undefined: {n} values", undefined & (n <= 1)),
        ),
    )


def largest_gap(values: ArrayLike, *, standardise: bool) -> tuple[Floats, Ints]:
    """D (k,) of ``ks_normal`` alone, and the values (k,) that entered. The statistic of Kolmogorov (1933)."""
    rows = row_moments(values)
    valid, n = rows.valid[:, 0], rows.counts[:, 0]
    if standardise:
        sd = np.sqrt(rows.squares[:, 0] / np.where(rows.squares[:, 0] > 0, n - 1.0, np.nan))
        z = rows.deviation[:, 0] / sd[:, None]
    else:
        z = np.broadcast_to(np.atleast_2d(np.asarray(unmasked(values), dtype=np.float64)), valid.shape)
    cdf = special.ndtr(np.sort(np.where(valid, z, np.inf), axis=1))
    rank = np.arange(valid.shape[1])
    count = np.maximum(n, 1)[:, None]
    gap = np.where(rank < n[:, None], np.maximum((rank + 1) / count - cdf, cdf - rank / count), 0.0)
    d = gap.max(axis=1, initial=0.0)
    d[(n == 0) | np.isnan(z).all(axis=1)] = np.nan
    return d, n


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


def shapiro_wilk(values: ArrayLike) -> Outcomes:
    """Test each row of ``values``, as ``ks_normal`` takes them (Royston 1995, algorithm AS R94).

    A row of fewer than three values, or without spread, has no test (NaN).
    """
    rows = row_moments(values)
    count, squares = rows.counts[:, 0], rows.squares[:, 0]
    deviation = np.sort(np.where(rows.valid, rows.deviation, np.inf)[:, 0], axis=1)
    lack, p = np.full(count.shape, np.nan), np.full(count.shape, np.nan)
    for n in set(count[count >= 3].tolist()):
        same = (count == n) & (squares > 0)
        lack[same] = _lack(deviation[same, :n], n)
        p[same] = _p(lack[same], n)
    repeated = ((deviation[:, 1:] == deviation[:, :-1]) & np.isfinite(deviation[:, 1:])).any(axis=1)
    few, defined = count < 3, np.isfinite(lack)
    return Outcomes(
        method="Shapiro-Wilk",
        statistic_name="W",
        statistic=1 - lack,
        p=p,
        n=count,
        notes=(
            ("undefined: {n} values, needs 3", few),
            ("undefined: all values are equal", ~few & ~defined),
            ("values repeat: rounded data look less normal than they are", defined & repeated),
            (f"p extrapolated: fitted for up to {MOST} values", defined & (count > MOST)),
        ),
    )


@cache
def _weights(n: int) -> Floats:
    """The weights (n,) of the ordered values: antisymmetric, sum 0; squares sum to 1 but for rounding."""
    if n == 3:
        return np.array([-np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    m = special.ndtri((np.arange(1, n + 1) - 0.375) / (n + 0.25))
    squares = np.sum(m**2)
    u = 1 / np.sqrt(n)
    ends = [_polynomial(_LAST, u) + m[-1] / np.sqrt(squares)]
    if n > 5:
        ends.append(_polynomial(_LAST_BUT_ONE, u) + m[-2] / np.sqrt(squares))
    e = len(ends)
    scale = (squares - 2 * np.sum(m[-e:] ** 2)) / (1 - 2 * sum(end**2 for end in ends))
    weights = np.asarray(m / np.sqrt(scale))
    weights[-e:] = ends[::-1]
    weights[:e] = -np.array(ends)
    return np.asarray(weights - np.mean(weights))


def _lack(ordered: Floats, n: int) -> Floats:
    """1 - W of centred, sorted rows (j, n), without the cancellation of taking W from 1."""
    weights = _weights(n)
    size = np.sqrt(np.sum(weights**2) * np.sum(ordered**2, axis=1))
    fit = ordered @ weights
    return np.asarray(np.maximum((size - fit) * (size + fit) / size**2, 0.0))


def _p(lack: Floats, n: int) -> Floats:
    if n == 3:  # exact
        return np.asarray(np.maximum(1 - 6 / np.pi * np.arcsin(np.sqrt(np.minimum(lack, 0.25))), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        y, log_n = np.log(lack), np.log(n)
        if n > _SMALL:
            mean, sd = _polynomial(_LARGE_MEAN, log_n), np.exp(_polynomial(_LARGE_LOG_SD, log_n))
            return np.asarray(special.ndtr((mean - y) / sd))
        bound = _polynomial(_SMALL_SHIFT, n)
        mean, sd = _polynomial(_SMALL_MEAN, n), np.exp(_polynomial(_SMALL_LOG_SD, n))
        z = (-np.log(np.maximum(bound - y, 0.0)) - mean) / sd
        return np.asarray(np.where(y >= bound, 0.0, special.ndtr(-z)))


def _polynomial(coefficients: tuple[float, ...], x: float) -> float:
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value
