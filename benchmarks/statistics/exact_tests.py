"""The tests in exact rational arithmetic, probabilities in 40 digits."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.statistics.exact_laws import (
    chi2_survival,
    f_survival,
    ks_survival,
    range_survival,
    rank_sum_p,
    t_quantile,
    t_two_sided,
    z_two_sided,
)

Rows = list[list[Fraction]]


def mpq(value: Fraction) -> mpf:
    return mpf(value.numerator) / value.denominator


def fractions(values: Any) -> Rows:
    return [[Fraction(value) for value in row] for row in values]


def mean(values: list[Fraction]) -> Fraction:
    return sum(values, Fraction(0)) / len(values)


def squares(values: list[Fraction]) -> Fraction:
    centre = mean(values)
    return sum(((value - centre) ** 2 for value in values), Fraction(0))


def f_statistic(groups: Rows) -> tuple[Fraction, Fraction, int, int]:
    """F, mean square within, df."""
    values = [value for group in groups for value in group]
    df1, df2 = len(groups) - 1, len(values) - len(groups)
    within = sum((squares(group) for group in groups), Fraction(0))
    return (squares(values) - within) / df1 / (within / df2), within / df2, df1, df2


def exact_anova(design: np.ndarray) -> dict[Any, mpf]:
    """F and p, and of every pair p and the lower end of its LSD interval (95 %)."""
    groups = fractions(design)
    f, within, df1, df2 = f_statistic(groups)
    found = {"F": mpq(f), "p": f_survival(mpq(f), df1, df2)}
    reach = t_quantile(mpf(1) - mpf(0.95), df2)
    for pair, (first, second) in enumerate(combinations(groups, 2)):
        se = mp.sqrt(mpq(within * (Fraction(1, len(first)) + Fraction(1, len(second)))))
        difference = mpq(mean(first) - mean(second))
        found["p LSD", pair] = t_two_sided(difference / se, df2)
        found["low LSD", pair] = difference - reach * se
    return found


def exact_tukey(design: np.ndarray, pair: int) -> mpf:
    """p of one pair."""
    groups = fractions(design)
    _, within, df1, df2 = f_statistic(groups)
    first, second = list(combinations(groups, 2))[pair]
    se = mp.sqrt(mpq(within * (Fraction(1, len(first)) + Fraction(1, len(second))) / 2))
    return range_survival(abs(mpq(mean(first) - mean(second))) / se, df1 + 1, df2)


def midranks(values: list[Fraction]) -> list[Fraction]:
    return [Fraction(sum(v < value for v in values) * 2 + sum(v == value for v in values) + 1, 2) for value in values]


def exact_kruskal(design: np.ndarray) -> dict[Any, mpf]:
    """H and p, and p of every pair: Dunn with Bonferroni."""
    groups = fractions(design)
    ranks = midranks([value for group in groups for value in group])
    variance = squares(ranks) / (len(ranks) - 1)
    own = [[ranks.pop(0) for _ in group] for group in groups]
    pooled = mean([rank for group in own for rank in group])
    h = sum(((mean(group) - pooled) ** 2 * len(group) for group in own), Fraction(0)) / variance
    found = {"H": mpq(h), "p": chi2_survival(mpq(h), len(groups) - 1)}
    pairs = list(combinations(own, 2))
    for pair, (first, second) in enumerate(pairs):
        per_value = Fraction(1, len(first)) + Fraction(1, len(second))
        z = mpq(mean(first) - mean(second)) / mp.sqrt(mpq(variance * per_value))
        found["p Dunn", pair] = min(mpf(1), len(pairs) * z_two_sided(z))
    return found


def exact_mann_whitney(first: np.ndarray, second: np.ndarray) -> mpf:
    ranks = [int(2 * rank) for rank in midranks(fractions([[*first, *second]])[0])]
    return rank_sum_p(ranks, len(first))(sum(ranks[: len(first)]))


def exact_ks(row: np.ndarray) -> dict[str, mpf]:
    """D and p of the standardised Kolmogorov-Smirnov test."""
    values = sorted(Fraction(value) for value in row)
    n, centre = len(values), mean(values)
    sd = mp.sqrt(mpq(squares(values) / (n - 1)))
    cdf = [mp.ncdf(mpq(value - centre) / sd) for value in values]
    d = max(max(mpf(i + 1) / n - c, c - mpf(i) / n) for i, c in enumerate(cdf))
    return {"D": d, "p": ks_survival(d, n)}


def exact_shapiro(row: np.ndarray) -> dict[str, mpf]:
    """W and p of Royston's AS R94 for 6 to 11 values."""
    values = sorted(Fraction(value) for value in row)
    n = len(values)
    m = [mp.sqrt(2) * mp.erfinv(2 * (i - mpf(3) / 8) / (n + mpf(1) / 4) - 1) for i in range(1, n + 1)]
    total, u = mp.fdot(m, m), 1 / mp.sqrt(n)
    last = m[-1] / mp.sqrt(total) + _poly("0 .221157 -.147981 -2.071190 4.434685 -2.706056", u)
    next_to_last = m[-2] / mp.sqrt(total) + _poly("0 .042981 -.293762 -1.752461 5.682633 -3.582633", u)
    scale = mp.sqrt((total - 2 * m[-1] ** 2 - 2 * m[-2] ** 2) / (1 - 2 * last**2 - 2 * next_to_last**2))
    weights = [-last, -next_to_last, *(value / scale for value in m[2:-2]), next_to_last, last]
    centre = mean(values)
    fit = mp.fdot(weights, [mpq(value - centre) for value in values])
    w = fit**2 / mpq(squares(values)) / mp.fdot(weights, weights)
    y = -mp.log(_poly("-2.273 .459", n) - mp.log(1 - w))
    z = (y - _poly(".5440 -.39978 .025054 -.0006714", n)) / mp.exp(_poly("1.3822 -.77857 .062767 -.0020322", n))
    return {"W": w, "p": mp.ncdf(-z)}


def _poly(coefficients: str, x: Any) -> mpf:
    return mp.fsum(mpf(c) * mpf(x) ** i for i, c in enumerate(coefficients.split()))
