"""The tests by their textbook sums in 50 digits; a design is a list of groups of exact numbers.

For the stress table, and for the cases of the areas ``tests`` and ``fits``.
"""

from __future__ import annotations

from collections.abc import Sequence
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
    z_two_sided,
)
from benchmarks.stress.case import exactly

Groups = list[list[Any]]


def groups_of(values: np.ndarray) -> Groups:
    """Rows (k, n) in 50 digits, None left out."""
    return [[exactly(value) for value in row] for row in values]


def mean(values: Sequence[Any]) -> Any:
    return mp.fsum(values) / len(values)


def squares(values: Sequence[Any]) -> Any:
    centre = mean(values)
    return mp.fsum((value - centre) ** 2 for value in values)


def variance(values: Sequence[Any]) -> Any:
    return squares(values) / (len(values) - 1)


def t_two_sided(t: Any, df: Any) -> Any:
    return mp.betainc(df / mpf(2), mpf(1) / 2, 0, df / (df + t * t), regularized=True)


def t_below(t: Any, df: Any) -> Any:
    """P(T <= t)."""
    half = t_two_sided(t, df) / 2
    return half if t < 0 else 1 - half


def anova(groups: Groups) -> dict[str, Any]:
    values = [value for group in groups for value in group]
    within = mp.fsum(squares(group) for group in groups)
    total, df1, df2 = squares(values), len(groups) - 1, len(values) - len(groups)
    between = mp.fsum(len(group) * (mean(group) - mean(values)) ** 2 for group in groups)
    f = between / df1 / (within / df2)
    return {"F": f, "p": f_survival(f, df1, df2), "eta2": between / total, "sd": mp.sqrt(within / df2)}


def brown_forsythe(groups: Groups) -> dict[str, Any]:
    found = anova([[abs(value - _median(group)) for value in group] for group in groups])
    return {"F": found["F"], "p": found["p"]}


def lsd(groups: Groups, confidence: float) -> dict[str, Any]:
    """p of all pairs, and the lower end of the first."""
    df = sum(map(len, groups)) - len(groups)
    spread = mp.fsum(squares(group) for group in groups) / df
    p, low = [], None
    for first, second in combinations(groups, 2):
        se = mp.sqrt(spread * (mpf(1) / len(first) + mpf(1) / len(second)))
        difference = mean(first) - mean(second)
        p.append(t_two_sided(difference / se, df))
        if low is None:
            low = difference - t_quantile(1 - mpf(confidence), df) * se
    return {"p": p, "low": low}


def tukey(groups: Groups, pair: int = 0) -> dict[str, Any]:
    """p of one pair."""
    df = sum(map(len, groups)) - len(groups)
    spread = mp.fsum(squares(group) for group in groups) / df
    first, second = list(combinations(groups, 2))[pair]
    se = mp.sqrt(spread * (mpf(1) / len(first) + mpf(1) / len(second)) / 2)
    return {"p": range_survival(abs(mean(first) - mean(second)) / se, len(groups), df)}


def welch(groups: Groups) -> dict[str, Any]:
    k = len(groups)
    weight = [len(group) / variance(group) for group in groups]
    total = mp.fsum(weight)
    grand = mp.fsum(w * mean(group) for w, group in zip(weight, groups, strict=True)) / total
    between = mp.fsum(w * (mean(group) - grand) ** 2 for w, group in zip(weight, groups, strict=True)) / (k - 1)
    lack = mp.fsum((1 - w / total) ** 2 / (len(group) - 1) for w, group in zip(weight, groups, strict=True))
    f, df2 = between / (1 + 2 * (k - 2) * lack / (mpf(k) ** 2 - 1)), (mpf(k) ** 2 - 1) / (3 * lack)
    return {"F": f, "df2": df2, "p": f_survival(f, k - 1, df2)}


def games_howell(groups: Groups) -> dict[str, Any]:
    """Statistic and df of all pairs."""
    q, df = [], []
    for first, second in combinations(groups, 2):
        a, b = variance(first) / len(first), variance(second) / len(second)
        q.append(abs(mean(first) - mean(second)) / mp.sqrt((a + b) / 2))
        df.append((a + b) ** 2 / (a * a / (len(first) - 1) + b * b / (len(second) - 1)))
    return {"q": q, "df": df}


def ranks(values: Sequence[Any]) -> list[Any]:
    """Midranks."""
    return [mpf(2 * sum(v < value for v in values) + sum(v == value for v in values) + 1) / 2 for value in values]


def kruskal(groups: Groups) -> dict[str, Any]:
    """H and p, and p of all pairs: Dunn with Bonferroni."""
    ranked = ranks([value for group in groups for value in group])
    spread, pooled = variance(ranked), mean(ranked)
    own = [[ranked.pop(0) for _ in group] for group in groups]
    h = mp.fsum(len(group) * (mean(group) - pooled) ** 2 for group in own) / spread
    pairs = list(combinations(own, 2))
    z = [(mean(a) - mean(b)) / mp.sqrt(spread * (mpf(1) / len(a) + mpf(1) / len(b))) for a, b in pairs]
    dunn = [min(mpf(1), len(pairs) * z_two_sided(each)) for each in z]
    return {"H": h, "p": chi2_survival(h, len(groups) - 1), "p Dunn": dunn}


def mann_whitney(first: Sequence[Any], second: Sequence[Any]) -> dict[str, Any]:
    """p over every way to deal the ranks out, and Hodges and Lehmann's shift."""
    doubled = [int(2 * rank) for rank in ranks([*first, *second])]
    shift = _median([a - b for a in first for b in second])
    return {"p": rank_sum_p(doubled, len(first))(sum(doubled[: len(first)])), "shift": shift}


def friedman(people: Groups) -> dict[str, Any]:
    n, k = len(people), len(people[0])
    ranked = [ranks(person) for person in people]
    sums = [mp.fsum(person[j] for person in ranked) for j in range(k)]
    between = mp.fsum((total - mean(sums)) ** 2 for total in sums) / n
    spread = mp.fsum((rank - mpf(k + 1) / 2) ** 2 for person in ranked for rank in person) / (n * (k - 1))
    chi2 = between / spread
    return {"chi2": chi2, "p": chi2_survival(chi2, k - 1), "W": chi2 / (n * (k - 1))}


def _two_way(people: Groups) -> tuple[Any, Any, Any, list[list[Any]]]:
    """Sums of squares of columns, rows and residual, and the residuals."""
    columns = [list(column) for column in zip(*people, strict=True)]
    grand = mean([value for row in people for value in row])
    of_columns = len(people) * mp.fsum((mean(column) - grand) ** 2 for column in columns)
    of_rows = len(columns) * mp.fsum((mean(row) - grand) ** 2 for row in people)
    rest = [
        [value - mean(row) - mean(column) + grand for value, column in zip(row, columns, strict=True)] for row in people
    ]
    return of_columns, of_rows, mp.fsum(r * r for row in rest for r in row), rest


def rm_anova(people: Groups) -> dict[str, Any]:
    n, k = len(people), len(people[0])
    treatment, _, error, rest = _two_way(people)
    df1, df2 = k - 1, (n - 1) * (k - 1)
    f = treatment / df1 / (error / df2)
    cross = [[mp.fsum(row[i] * row[j] for row in rest) for j in range(k)] for i in range(k)]
    trace = mp.fsum(cross[i][i] for i in range(k))
    epsilon = trace**2 / (df1 * mp.fsum(value**2 for row in cross for value in row))
    corrected = mp.betainc(df2 * epsilon / 2, df1 * epsilon / 2, 0, df2 / (df2 + df1 * f), regularized=True)
    return {"F": f, "p": f_survival(f, df1, df2), "epsilon": epsilon, "p_gg": corrected}


def icc(subjects: Groups) -> dict[str, Any]:
    """ICC(3,1)."""
    n, k = len(subjects), len(subjects[0])
    _, between, error, _ = _two_way(subjects)
    b, e = between / (n - 1), error / ((n - 1) * (k - 1))
    return {"ICC(3,1)": (b - e) / (b + (k - 1) * e)}


def two_factors(cells: Sequence[Groups]) -> dict[str, Any]:
    """F and p of the first factor of a balanced design, cells[first][second] of values, with interaction."""
    a, b, n = len(cells), len(cells[0]), len(cells[0][0])
    grand = mean([value for row in cells for cell in row for value in cell])
    rows = [mean([value for cell in row for value in cell]) for row in cells]
    of_first = b * n * mp.fsum((row - grand) ** 2 for row in rows) / (a - 1)
    df = a * b * (n - 1)
    f = of_first / (mp.fsum(squares(cell) for row in cells for cell in row) / df)
    return {"F": f, "p": f_survival(f, a - 1, df)}


def balanced_mixed(y: Any) -> dict[str, Any]:
    """Means of specimens, variances and F of participants x specimens x repetitions: REML of a balanced study, from
    mean squares that are pooled where they are out of order."""
    n_p, n_s, n_r = len(y), len(y[0]), len(y[0][0])
    cells = [[mean(cell) for cell in row] for row in y]
    specimens, people, rest, _ = _two_way(cells)
    within = mp.fsum(squares(cell) for row in y for cell in row)
    df = [n_p * n_s * (n_r - 1), (n_p - 1) * (n_s - 1), n_p - 1]
    error, cross, between = _pooled([within, n_r * rest, n_r * people], df)
    f = specimens / (n_s - 1) / (rest / df[1])
    variances = [(between - cross) / (n_s * n_r), (cross - error) / n_r, error]
    return {
        "mean": [mean(list(column)) for column in zip(*cells, strict=True)],
        "variances": variances,
        "SD": [mp.sqrt(each) for each in variances],
        "F": f,
        "p": f_survival(f, n_s - 1, df[1]),
    }


def _pooled(sums: list[Any], df: list[int]) -> list[Any]:
    """Mean squares that do not fall, neighbours pooled where they would."""
    blocks: list[list[int]] = []

    def level(block: list[int]) -> Any:
        return mp.fsum(sums[i] for i in block) / sum(df[i] for i in block)

    for i in range(len(sums)):
        blocks.append([i])
        while len(blocks) > 1 and level(blocks[-2]) > level(blocks[-1]):
            last = blocks.pop()
            blocks[-1] = blocks[-1] + last
    return [level(block) for block in blocks for _ in block]


def tost(first: Sequence[Any], second: Sequence[Any], margin: Any) -> dict[str, Any]:
    centre, df = mean(first) - mean(second), len(first) + len(second) - 2
    se = mp.sqrt((squares(first) + squares(second)) / df * (mpf(1) / len(first) + mpf(1) / len(second)))
    t = (abs(centre) - margin) / se
    return {"t": -t if centre < 0 else t, "p": t_below(t, df)}


def paired(first: Sequence[Any], second: Sequence[Any]) -> dict[str, Any]:
    """Student's paired t, and Wilcoxon's signed ranks over all signs."""
    difference = [a - b for a, b in zip(first, second, strict=True)]
    t = mean(difference) / mp.sqrt(variance(difference) / len(difference))
    told = [value for value in difference if value]
    doubled = [int(2 * rank) for rank in ranks([abs(value) for value in told])]
    ways = {0: 1}
    for rank in doubled:
        grown = dict(ways)
        for total, count in ways.items():
            grown[total + rank] = grown.get(total + rank, 0) + count
        ways = grown
    seen = sum(rank for rank, value in zip(doubled, told, strict=True) if value > 0)
    far = sum(count for total, count in ways.items() if abs(2 * total - sum(doubled)) >= abs(2 * seen - sum(doubled)))
    return {"t": t, "p": t_two_sided(t, len(difference) - 1), "signed ranks": mpf(far) / 2 ** len(told)}


def jzs(groups: Groups, scale: Any) -> dict[str, Any]:
    """log BF01 of k groups of n: the integral over g, inverse chi squared with 1 degree of freedom."""
    k, n = len(groups), len(groups[0])
    values = [value for group in groups for value in group]
    within, total = mp.fsum(squares(group) for group in groups), squares(values)

    def density(log_g: Any) -> Any:
        g = mp.exp(log_g)
        gain = scale**2 * n * g
        left = (within + (total - within) / (1 + gain)) / total
        prior = mp.exp(-1 / (2 * g)) / mp.sqrt(2 * mp.pi * g)
        return prior * (1 + gain) ** (-mpf(k - 1) / 2) * left ** (-mpf(len(values) - 1) / 2)

    with mp.workdps(30):
        return {"log BF01": -mp.log(mp.quad(density, mp.linspace(-8, 120, 33)))}


def trend(blocks: Sequence[Groups]) -> dict[str, Any]:
    """Student's t of the slopes over 0, 1, 2, ... within groups of blocks[block][group]."""
    slopes = []
    for groups in blocks:
        order = [mpf(i) for i in range(len(groups[0]))]
        over = [at - mean(order) for at in order]
        up = mp.fsum(mp.fdot(over, [value - mean(group) for value in group]) for group in groups)
        slopes.append(up / (len(groups) * mp.fdot(over, over)))
    t = mean(slopes) / mp.sqrt(variance(slopes) / len(slopes))
    return {"mean": mean(slopes), "t": t, "p": t_two_sided(t, len(slopes) - 1)}


def _median(values: Sequence[Any]) -> Any:
    ordered = sorted(values)
    n = len(ordered)
    return (ordered[(n - 1) // 2] + ordered[n // 2]) / 2


def ks(values: Sequence[Any]) -> dict[str, Any]:
    """D and p of the standardised Kolmogorov-Smirnov test."""
    ordered, n, centre, sd = sorted(values), len(values), mean(values), mp.sqrt(variance(values))
    cdf = [mp.ncdf((value - centre) / sd) for value in ordered]
    d = max(max(mpf(i + 1) / n - c, c - mpf(i) / n) for i, c in enumerate(cdf))
    return {"D": d, "p": ks_survival(d, n)}


def shapiro(values: Sequence[Any]) -> dict[str, Any]:
    """W and p of Royston's AS R94 for 6 to 11 values."""
    ordered, n = sorted(values), len(values)
    m = [mp.sqrt(2) * mp.erfinv(2 * (i - mpf(3) / 8) / (n + mpf(1) / 4) - 1) for i in range(1, n + 1)]
    total, u = mp.fdot(m, m), 1 / mp.sqrt(n)
    last = m[-1] / mp.sqrt(total) + _poly("0 .221157 -.147981 -2.071190 4.434685 -2.706056", u)
    next_to_last = m[-2] / mp.sqrt(total) + _poly("0 .042981 -.293762 -1.752461 5.682633 -3.582633", u)
    scale = mp.sqrt((total - 2 * m[-1] ** 2 - 2 * m[-2] ** 2) / (1 - 2 * last**2 - 2 * next_to_last**2))
    weights = [-last, -next_to_last, *(value / scale for value in m[2:-2]), next_to_last, last]
    centre = mean(ordered)
    fit = mp.fdot(weights, [value - centre for value in ordered])
    w = fit**2 / squares(ordered) / mp.fdot(weights, weights)
    y = -mp.log(_poly("-2.273 .459", n) - mp.log(1 - w))
    z = (y - _poly(".5440 -.39978 .025054 -.0006714", n)) / mp.exp(_poly("1.3822 -.77857 .062767 -.0020322", n))
    return {"W": w, "p": mp.ncdf(-z)}


def _poly(coefficients: str, x: Any) -> Any:
    return mp.fsum(mpf(c) * mpf(x) ** i for i, c in enumerate(coefficients.split()))
