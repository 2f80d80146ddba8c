"""Groups of unequal variance, people measured again and again, equivalence, and the bootstrap."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pandas as pd
from mpmath import mp, mpf
from scipy import stats

from benchmarks.bench.case import Case, Size, Way
from benchmarks.nist import Exact, Numbers, looped, worst_error
from benchmarks.statistics.exact_laws import chi2_survival, f_survival
from benchmarks.statistics.exact_tests import fractions, mean, midranks, mpq, squares
from benchmarks.statistics.mean_peers import tables
from benchmarks.statistics.peers import pingouin, statsmodels_api
from emg2vsa.statistics.anova import welch
from emg2vsa.statistics.bootstrap import bca
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.post_hoc import games_howell
from emg2vsa.statistics.repeated import friedman, rm_anova

MPMATH = "rational and 40-digit arithmetic"
RESAMPLES = 2000
LOW, HIGH = 0.025, 0.975


def design_cases(size: Size) -> Iterator[Case]:
    """Fourteen designs of each kind, eight samples for the bootstrap."""
    rng = np.random.default_rng(7)
    n = size.pick(2, 14)
    spread = np.array([1.0, 2.0, 0.5, 1.5, 3.0])[:, None]
    yield _welch(rng.standard_normal((n, 5, 10)) * spread + 0.4 * np.arange(5)[:, None])
    people = rng.standard_normal((n, 14, 5)) + rng.standard_normal((n, 14, 1)) + 0.3 * np.arange(5)
    yield _repeated(people)
    yield _friedman(people)
    yield _tost(rng.standard_normal((n, 2, 10)))
    yield _bootstrap(rng.standard_normal((size.pick(2, 8), 8)))


def _welch(b: np.ndarray) -> Case:
    frames = tables(b)

    def ours() -> Numbers:
        found = welch(b)
        games_howell(b)
        return {"F": found.statistic, "p": found.p}

    def scipy_each(design: np.ndarray) -> dict[str, Any]:
        found = stats.f_oneway(*design, equal_var=False)
        return {"F": found.statistic, "p": found.pvalue}

    ways = [
        Way("emg2vsa", "welch and games_howell, all in one call", ours, "equal"),
        Way("scipy", "f_oneway, equal_var=False, loop", looped(scipy_each, b), "as used", "no pairs"),
    ]
    if statsmodels_api is not None:

        def statsmodels_each(design: np.ndarray) -> dict[str, Any]:
            found = statsmodels_api.stats.anova_oneway(list(design), use_var="unequal")
            return {"F": found.statistic, "p": found.pvalue}

        ways.append(Way("statsmodels", "anova_oneway, loop", looped(statsmodels_each, b), "as used", "no pairs"))
    if pingouin is not None:

        def pingouin_each(table: pd.DataFrame) -> dict[str, Any]:
            found = pingouin.welch_anova(table, dv="y", between="g")
            pingouin.pairwise_gameshowell(table, dv="y", between="g")
            return {"F": found["F"].iloc[0], "p": found["p_unc"].iloc[0]}

        name = "welch_anova and pairwise_gameshowell, loop"
        ways.append(Way("pingouin", name, looped(pingouin_each, frames), "as used", "no intervals"))
    name = f"Welch's ANOVA of 5 x 10 with the pairs of Games and Howell, {len(b)} designs"
    return Case(name, len(b), "designs", tuple(ways), worst_error(lambda: _each(_exact_welch, b)), "relative", MPMATH)


def _repeated(people: np.ndarray) -> Case:
    frames = [_long(design) for design in people]

    def ours() -> Numbers:
        found = rm_anova(people)
        return {"F": found.f, "p": found.p}

    ways = [Way("emg2vsa", "rm_anova, all in one call", ours, "equal", "with both epsilons and Mauchly's test")]
    if statsmodels_api is not None:

        def statsmodels_each(table: pd.DataFrame) -> dict[str, Any]:
            found = statsmodels_api.stats.AnovaRM(table, "y", "person", within=["treatment"]).fit().anova_table
            return {"F": found["F Value"].iloc[0], "p": found["Pr > F"].iloc[0]}

        ways.append(Way("statsmodels", "AnovaRM, loop", looped(statsmodels_each, frames), "as used", "no epsilon"))
    if pingouin is not None:

        def pingouin_each(table: pd.DataFrame) -> dict[str, Any]:
            found = pingouin.rm_anova(table, dv="y", within="treatment", subject="person", correction=True)
            return {"F": found["F"].iloc[0], "p": found["p_unc"].iloc[0]}

        ways.append(Way("pingouin", "rm_anova, loop", looped(pingouin_each, frames), "equal"))
    name = f"repeated-measures ANOVA, 14 people x 5, {len(people)} designs"
    exact = worst_error(lambda: _each(_exact_repeated, people))
    return Case(name, len(people), "designs", tuple(ways), exact, "relative", MPMATH)


def _friedman(people: np.ndarray) -> Case:
    def ours() -> Numbers:
        found = friedman(people)
        return {"chi2": found.statistic, "p": found.p}

    def scipy_each(design: np.ndarray) -> dict[str, Any]:
        found = stats.friedmanchisquare(*design.T)
        return {"chi2": found.statistic, "p": found.pvalue}

    ways = [
        Way("emg2vsa", "friedman, all in one call", ours, "equal"),
        Way("scipy", "friedmanchisquare, loop", looped(scipy_each, people), "equal"),
    ]
    if pingouin is not None:

        def pingouin_each(table: pd.DataFrame) -> dict[str, Any]:
            found = pingouin.friedman(table, dv="y", within="treatment", subject="person")
            return {"chi2": found["Q"].iloc[0], "p": found["p_unc"].iloc[0]}

        frames = [_long(design) for design in people]
        ways.append(Way("pingouin", "friedman, loop", looped(pingouin_each, frames), "equal"))
    name = f"Friedman, 14 people x 5, {len(people)} designs"
    exact = worst_error(lambda: _each(_exact_friedman, people))
    return Case(name, len(people), "designs", tuple(ways), exact, "relative", MPMATH)


def _tost(pairs: np.ndarray, margin: float = 1.0) -> Case:
    def scipy_each(pair: np.ndarray) -> dict[str, Any]:
        x, y = pair
        above = stats.ttest_ind(x + margin, y, alternative="greater")
        below = stats.ttest_ind(x - margin, y, alternative="less")
        return {"p": max(above.pvalue, below.pvalue)}

    ways = [
        Way("emg2vsa", "tost, all in one call", lambda: {"p": tost(pairs, margin).p[:, 0]}, "equal", "with interval"),
        Way("scipy", "two ttest_ind, loop", looped(scipy_each, pairs), "equal"),
    ]
    if statsmodels_api is not None:

        def statsmodels_each(pair: np.ndarray) -> dict[str, Any]:
            return {"p": statsmodels_api.stats.ttost_ind(*pair, -margin, margin)[0]}

        ways.append(Way("statsmodels", "ttost_ind, loop", looped(statsmodels_each, pairs), "equal"))
    if pingouin is not None:

        def pingouin_each(pair: np.ndarray) -> dict[str, Any]:
            return {"p": pingouin.tost(*pair, bound=margin)["pval"].iloc[0]}

        ways.append(Way("pingouin", "tost, loop", looped(pingouin_each, pairs), "equal"))
    exact = worst_error(lambda: _each(lambda pair: _exact_tost(pair, margin), pairs))
    name = f"two one-sided t tests of 10 and 10, {len(pairs)} pairs"
    return Case(name, len(pairs), "pairs", tuple(ways), exact, "relative", MPMATH)


def _bootstrap(rows: np.ndarray) -> Case:
    def ours() -> np.ndarray:
        found = bca(rows[:, None], lambda values: np.nanmean(values, axis=-1)[..., 0], RESAMPLES)
        return np.array([found.low, found.high])

    def by_scipy() -> np.ndarray:
        interval = stats.bootstrap(
            (rows,), np.mean, axis=-1, n_resamples=RESAMPLES, method="BCa", rng=np.random.default_rng(0)
        ).confidence_interval
        return np.array([interval.low, interval.high])

    def error(found: np.ndarray) -> float:
        return float(np.sqrt(np.mean(((found - _exact_bca(rows)) / (rows.std(axis=1, ddof=1) / np.sqrt(8))) ** 2)))

    ways = (
        Way("emg2vsa", "bca, all in one call", ours, "equal"),
        Way("scipy", "bootstrap BCa, axis given", by_scipy, "equal"),
    )
    return Case(
        f"BCa bootstrap of the mean of 8 values, {RESAMPLES} resamples, {len(rows)} samples",
        len(rows),
        "samples",
        ways,
        error,
        "RMS of both ends, standard errors",
        "all 6435 resamples, weighted by how often each is drawn",
    )


def _each(exact: Any, designs: np.ndarray) -> Exact:
    found = [exact(design) for design in designs[:8]]
    return {name: {i: numbers[name] for i, numbers in enumerate(found)} for name in found[0]}


def _exact_welch(design: np.ndarray) -> dict[str, mpf]:
    groups = fractions(design)
    k = len(groups)
    weights = [len(group) * (len(group) - 1) / squares(group) for group in groups]
    total = sum(weights, Fraction(0))
    grand = sum((w * mean(group) for w, group in zip(weights, groups, strict=True)), Fraction(0)) / total
    between = sum((w * (mean(group) - grand) ** 2 for w, group in zip(weights, groups, strict=True)), Fraction(0))
    lack = sum(((1 - w / total) ** 2 / (len(g) - 1) for w, g in zip(weights, groups, strict=True)), Fraction(0))
    f = between / (k - 1) / (1 + 2 * (k - 2) * lack / (k**2 - 1))
    return {"F": mpq(f), "p": f_survival(mpq(f), k - 1, mpq((k**2 - 1) / (3 * lack)))}


def _exact_repeated(people: np.ndarray) -> dict[str, mpf]:
    rows = fractions(people)
    n, k = people.shape
    of_people = k * squares([mean(row) for row in rows])
    of_treatments = n * squares([mean(list(column)) for column in zip(*rows, strict=True)])
    left = squares([value for row in rows for value in row]) - of_people - of_treatments
    df1, df2 = k - 1, (n - 1) * (k - 1)
    f = mpq(of_treatments / df1 / (left / df2))
    return {"F": f, "p": f_survival(f, df1, df2)}


def _exact_friedman(people: np.ndarray) -> dict[str, mpf]:
    n, k = people.shape
    ranks = [midranks(row) for row in fractions(people)]
    spread = sum((squares(row) for row in ranks), Fraction(0)) / (n * (k - 1))
    chi2 = mpq(n * squares([mean(list(column)) for column in zip(*ranks, strict=True)]) / spread)
    return {"chi2": chi2, "p": chi2_survival(chi2, k - 1)}


def _exact_tost(pair: np.ndarray, margin: float) -> dict[str, mpf]:
    x, y = fractions(pair)
    df = len(x) + len(y) - 2
    per_mean = (squares(x) + squares(y)) / df * (Fraction(1, len(x)) + Fraction(1, len(y)))
    t = mpq(Fraction(margin) - abs(mean(x) - mean(y))) / mp.sqrt(mpq(per_mean))
    tail = mp.betainc(mpf(df) / 2, mpf(1) / 2, 0, df / (df + t * t), regularized=True) / 2
    return {"p": tail if t > 0 else 1 - tail}


def _exact_bca(rows: np.ndarray) -> np.ndarray:
    """Both ends (2, samples) of the BCa interval of the mean, from every resample and its probability."""
    n = rows.shape[1]
    drawn = np.array(list(combinations_with_replacement(range(n), n)))
    counts = np.array([np.bincount(draw, minlength=n) for draw in drawn])
    chance = np.array([1.0 / np.prod([float(mp.factorial(c)) for c in row]) for row in counts])
    chance /= chance.sum()
    ends = []
    for row in rows:
        means = np.sort(row[drawn].mean(axis=1))
        order = np.argsort(row[drawn].mean(axis=1))
        below = np.cumsum(chance[order])
        # the mean itself is drawn with the identical sample, counted half as both programs count ties
        z0 = stats.norm.ppf(np.interp(row.mean(), means, below - chance[order] / 2))
        left = (row.sum() - row) / (n - 1)
        away = left.mean() - left
        acceleration = np.sum(away**3) / (6 * np.sum(away**2) ** 1.5)
        z = z0 + stats.norm.ppf([LOW, HIGH])
        at = stats.norm.cdf(z0 + z / (1 - acceleration * z))
        ends.append(np.interp(at, below - chance[order] / 2, means))
    return np.array(ends).T


def _long(people: np.ndarray) -> pd.DataFrame:
    person, treatment = (index.ravel() for index in np.indices(people.shape))
    return pd.DataFrame({"y": people.ravel(), "person": person, "treatment": treatment})
