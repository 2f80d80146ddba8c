"""Groups of unequal variance, people measured again and again, and equivalence."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from mpmath import mpf
from scipy import stats

from benchmarks.bench.case import Case, Size, Way, peer
from benchmarks.nist import Exact, Numbers, looped, worst_error
from benchmarks.statistics.group_peers import tables
from benchmarks.stress import exact_tests
from emg2vsa.statistics.anova import welch
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.post_hoc import games_howell
from emg2vsa.statistics.repeated import friedman, rm_anova

statsmodels_api, pingouin = peer("statsmodels.api"), peer("pingouin")
MPMATH = "50-digit arithmetic"


def design_cases(size: Size) -> Iterator[Case]:
    """Fourteen designs of each kind."""
    rng = np.random.default_rng(7)
    n = size.pick(2, 14)
    spread = np.array([1.0, 2.0, 0.5, 1.5, 3.0])[:, None]
    yield _welch(rng.standard_normal((n, 5, 10)) * spread + 0.4 * np.arange(5)[:, None])
    people = rng.standard_normal((n, 14, 5)) + rng.standard_normal((n, 14, 1)) + 0.3 * np.arange(5)
    yield _repeated(people)
    yield _friedman(people)
    yield _tost(rng.standard_normal((n, 2, 10)))


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
    return Case(
        name, len(b), "designs", tuple(ways), worst_error(lambda: _each(exact_tests.welch, b)), "relative", MPMATH
    )


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
    exact = worst_error(lambda: _each(exact_tests.rm_anova, people))
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
    name = f"Friedman, 14 people x 5, {len(people)} designs"
    exact = worst_error(lambda: _each(exact_tests.friedman, people))
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
    exact = worst_error(lambda: _each(lambda pair: exact_tests.tost(*pair, mpf(margin)), pairs))
    name = f"two one-sided t tests of 10 and 10, {len(pairs)} pairs"
    return Case(name, len(pairs), "pairs", tuple(ways), exact, "relative", MPMATH)


def _each(exact: Any, designs: np.ndarray) -> Exact:
    found = [exact(exact_tests.groups_of(design)) for design in designs[:8]]
    return {name: {i: numbers[name] for i, numbers in enumerate(found)} for name in found[0]}


def _long(people: np.ndarray) -> pd.DataFrame:
    person, treatment = (index.ravel() for index in np.indices(people.shape))
    return pd.DataFrame({"y": people.ravel(), "person": person, "treatment": treatment})
