"""Laws of probability in 40-digit arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from mpmath import mp, mpf

mp.dps = 40


def f_survival(f: mpf, df1: int, df2: int) -> mpf:
    return mp.betainc(mpf(df2) / 2, mpf(df1) / 2, 0, df2 / (df2 + df1 * f), regularized=True)


def t_two_sided(t: mpf, df: int) -> mpf:
    return mp.betainc(mpf(df) / 2, mpf(1) / 2, 0, df / (df + t * t), regularized=True)


def t_quantile(two_sided_p: mpf, df: int) -> mpf:
    return mp.findroot(lambda t: mp.log(t_two_sided(t, df) / two_sided_p), (mpf(1), mpf(3)))


def chi2_survival(x: mpf, df: int) -> mpf:
    return mp.gammainc(mpf(df) / 2, x / 2, regularized=True)


def z_two_sided(z: mpf) -> mpf:
    return mp.erfc(abs(z) / mp.sqrt(2))


def ks_survival(d: mpf, n: int) -> mpf:
    """Marsaglia, Tsang and Wang (2003)."""
    k = int(mp.floor(n * d)) + 1
    h, m = k - n * d, 2 * k - 1
    matrix = mp.matrix(m, m)
    for i in range(m):
        for j in range(min(i + 2, m)):
            matrix[i, j] = mpf(1)
    for i in range(m):
        matrix[i, 0] -= h ** (i + 1)
        matrix[m - 1, i] -= h ** (m - i)
    if 2 * h > 1:
        matrix[m - 1, 0] += (2 * h - 1) ** m
    for i in range(m):
        for j in range(min(i + 1, m)):
            matrix[i, j] /= mp.factorial(i - j + 1)
    return 1 - (matrix**n)[k - 1, k - 1] * mp.factorial(n) / mpf(n) ** n


def range_survival(q: mpf, k: int, df: int) -> mpf:
    """Tukey's studentized range, to 15 digits for df from 10: trapezoids, which converge exponentially here."""
    with mp.workdps(20):
        step_z, step_t = mpf("0.25"), 1 / mp.sqrt(2 * df) / 3
        z = [i * step_z for i in range(-36, 37)]
        weights = [k * step_z * mp.npdf(at) for at in z]
        below = [mp.ncdf(at) for at in z]

        def narrower(w: mpf) -> mpf:
            inside = (f * (b - mp.ncdf(at - w)) ** (k - 1) for f, b, at in zip(weights, below, z, strict=True))
            return mp.fsum(inside)

        # SD over sigma = exp(t)
        half = mpf(df) / 2
        scale = step_t * 2 * half**half / mp.gamma(half)
        spread = [(i * step_t, scale * mp.exp(df * i * step_t - half * mp.exp(2 * i * step_t))) for i in range(-42, 28)]
        return 1 - mp.fsum(density * narrower(q * mp.exp(t)) for t, density in spread)


def power_of_rm(n: int, m: int, f: str, rho: str, alpha: str) -> mpf:
    """Power of the repeated-measures F test (G*Power's convention) by the series of the noncentral F law."""
    df1, df2 = m - 1, (n - 1) * (m - 1)
    noncentrality = mpf(f) ** 2 * n * m / (1 - mpf(rho))
    critical = mp.findroot(lambda x: f_survival(x, df1, df2) - mpf(alpha), (mpf(1), mpf(3)), solver="anderson")
    x = df1 * critical / (df1 * critical + df2)

    def term(i: Any) -> mpf:
        weight = mp.exp(-noncentrality / 2) * (noncentrality / 2) ** i / mp.factorial(i)
        return weight * mp.betainc(mpf(df1) / 2 + i, mpf(df2) / 2, 0, x, regularized=True)

    return 1 - mp.fsum(term(i) for i in range(120))


def rank_sum_p(doubled_ranks: list[int], n1: int) -> Callable[[int], mpf]:
    """Two-sided p of a doubled rank sum of n1 of the values, every way to deal them out counted in integers."""
    ways: list[dict[int, int]] = [{0: 1}] + [{} for _ in range(n1)]
    for rank in doubled_ranks:
        for taken in range(n1, 0, -1):
            for total, count in ways[taken - 1].items():
                ways[taken][total + rank] = ways[taken].get(total + rank, 0) + count
    centre = n1 * (len(doubled_ranks) + 1)

    def p(doubled_sum: int) -> mpf:
        far = sum(c for total, c in ways[n1].items() if abs(total - centre) >= abs(doubled_sum - centre))
        return mpf(far) / math.comb(len(doubled_ranks), n1)

    return p
