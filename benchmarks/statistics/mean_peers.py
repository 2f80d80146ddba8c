"""Other ways to an analysis of variance with all pairs of groups."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchmarks.bench.case import Way
from benchmarks.nist import Numbers, looped
from benchmarks.statistics.peers import pingouin, scikit_posthocs, statsmodels_api, statsmodels_formula

UPPER = np.triu_indices(5, 1)


def tables(designs: np.ndarray) -> list[pd.DataFrame]:
    """One tidy table a design: y, g."""
    _, k, n = designs.shape
    return [pd.DataFrame({"y": d.ravel(), "g": np.repeat([f"S{i}" for i in range(k)], n)}) for d in designs]


def f_oneway(design: np.ndarray) -> dict[str, Any]:
    found = stats.f_oneway(*design)
    return {"F": found.statistic, "p": found.pvalue}


def anova_and_lsd(b: np.ndarray) -> Iterator[Way]:
    frames = tables(b)

    def axis_aware() -> Numbers:
        found = stats.f_oneway(*np.moveaxis(b, 1, 0), axis=1)
        return {"F": found.statistic, "p": found.pvalue}

    yield Way("scipy", "f_oneway, axis-aware", axis_aware, "as used", "no pairs")
    yield Way("scipy", "f_oneway and LSD by hand, loop", looped(lambda d: f_oneway(d) | _hand_lsd(d), b), "equal")
    if scikit_posthocs is not None:
        yield Way("scikit-posthocs", "posthoc_lsd, loop", looped(_posthoc_lsd, frames), "as used", "no F, no intervals")
        both_tests = looped(lambda t: _posthoc_ttest(t) | _posthoc_lsd(t), frames)
        yield Way("scikit-posthocs", "posthoc_lsd and posthoc_ttest, loop", both_tests, "as used", "no F, no intervals")
    if statsmodels_api is not None:
        yield Way("statsmodels", "anova_lm and t_test_pairwise, loop", looped(_statsmodels, frames), "equal")
    if pingouin is not None:
        yield Way(
            "pingouin", "anova and pairwise_tests, loop", looped(_pingouin, frames), "as used", "pairs by their own SDs"
        )


def _hand_lsd(design: np.ndarray) -> dict[str, Any]:
    n, df = design.shape[1], design.size - len(design)
    sd = np.sqrt(np.mean(design.var(axis=1, ddof=1)))
    reach = stats.t.ppf(0.975, df) * sd * np.sqrt(2 / n)
    differences = [x.mean() - y.mean() for x, y in combinations(design, 2)]
    p = [2 * stats.t.sf(abs(d) / (sd * np.sqrt(2 / n)), df) for d in differences]
    return {"p LSD": p, "low LSD": np.array(differences) - reach}


def _tukey_hsd(design: np.ndarray) -> dict[str, Any]:
    found = stats.tukey_hsd(*design)
    return {"p Tukey": found.pvalue[UPPER], "low Tukey": found.confidence_interval().low[UPPER]}


def _posthoc_lsd(table: pd.DataFrame) -> dict[str, Any]:
    return {"p LSD": scikit_posthocs.posthoc_lsd(table, val_col="y", group_col="g").to_numpy()[UPPER]}


def _posthoc_ttest(table: pd.DataFrame) -> dict[str, Any]:
    return {"p LSD": scikit_posthocs.posthoc_ttest(table, val_col="y", group_col="g", pool_sd=True).to_numpy()[UPPER]}


def _statsmodels(table: pd.DataFrame) -> dict[str, Any]:
    fit = statsmodels_formula.ols("y ~ C(g)", table).fit()
    anova = statsmodels_api.stats.anova_lm(fit)
    pairs = fit.t_test_pairwise("C(g)").result_frame
    return {"F": anova["F"].iloc[0], "p": anova["PR(>F)"].iloc[0], "p LSD": pairs["P>|t|"].to_numpy()}


def _pingouin(table: pd.DataFrame) -> dict[str, Any]:
    anova = pingouin.anova(table, dv="y", between="g")
    pingouin.pairwise_tests(table, dv="y", between="g")
    return {"F": anova["F"].iloc[0], "p": anova["p_unc"].iloc[0]}


def anova_and_tukey(b: np.ndarray) -> Iterator[Way]:
    frames = tables(b)
    yield Way("scipy", "f_oneway and tukey_hsd, loop", looped(lambda d: f_oneway(d) | _tukey_hsd(d), b), "equal")
    if statsmodels_api is not None:
        yield Way("statsmodels", "pairwise_tukeyhsd, loop", looped(_tukeyhsd, frames), "equal")
    if pingouin is not None:
        yield Way("pingouin", "pairwise_tukey, loop", looped(_pairwise_tukey, frames), "as used", "no intervals")


def _tukeyhsd(table: pd.DataFrame) -> dict[str, Any]:
    return {"p Tukey": statsmodels_api.stats.multicomp.pairwise_tukeyhsd(table["y"], table["g"]).pvalues}


def _pairwise_tukey(table: pd.DataFrame) -> dict[str, Any]:
    return {"p Tukey": pingouin.pairwise_tukey(table, dv="y", between="g")["p_tukey"].to_numpy()}
