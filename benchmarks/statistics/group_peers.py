"""Other ways to an analysis of variance with all pairs of groups, and to tests on ranks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchmarks.bench.case import Way, peer
from benchmarks.experts import ranks, two_samples
from benchmarks.nist import looped

statsmodels_api, statsmodels_formula = peer("statsmodels.api"), peer("statsmodels.formula.api")
scikit_posthocs = peer("scikit_posthocs")
UPPER = np.triu_indices(5, 1)
P_ALONE = "p alone; ours gives the shift with its interval too"


def tables(designs: np.ndarray) -> list[pd.DataFrame]:
    """One tidy table a design: y, g."""
    _, k, n = designs.shape
    return [pd.DataFrame({"y": d.ravel(), "g": np.repeat([f"S{i}" for i in range(k)], n)}) for d in designs]


def f_oneway(design: np.ndarray) -> dict[str, Any]:
    found = stats.f_oneway(*design)
    return {"F": found.statistic, "p": found.pvalue}


def anova_and_lsd(b: np.ndarray) -> Iterator[Way]:
    frames = tables(b)

    yield Way("numpy", "expert: all in one call", lambda: ranks.anova_and_lsd(b), "equal")
    yield Way("scipy", "f_oneway and LSD by hand, loop", looped(lambda d: f_oneway(d) | _hand_lsd(d), b), "equal")
    if statsmodels_api is not None:
        yield Way("statsmodels", "anova_lm and t_test_pairwise, loop", looped(_anova_of_statsmodels, frames), "equal")


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


def _anova_of_statsmodels(table: pd.DataFrame) -> dict[str, Any]:
    fit = statsmodels_formula.ols("y ~ C(g)", table).fit()
    anova = statsmodels_api.stats.anova_lm(fit)
    pairs = fit.t_test_pairwise("C(g)").result_frame
    return {"F": anova["F"].iloc[0], "p": anova["PR(>F)"].iloc[0], "p LSD": pairs["P>|t|"].to_numpy()}


def anova_and_tukey(b: np.ndarray) -> Iterator[Way]:
    frames = tables(b)
    yield Way("scipy", "f_oneway and tukey_hsd, loop", looped(lambda d: f_oneway(d) | _tukey_hsd(d), b), "equal")
    if statsmodels_api is not None:
        yield Way("statsmodels", "pairwise_tukeyhsd, loop", looped(_tukeyhsd, frames), "equal")


def _tukeyhsd(table: pd.DataFrame) -> dict[str, Any]:
    return {"p Tukey": statsmodels_api.stats.multicomp.pairwise_tukeyhsd(table["y"], table["g"]).pvalues}


def kruskal_and_pairs(scores: np.ndarray) -> Iterator[Way]:
    yield Way("numpy", "expert: all in one call", lambda: ranks.kruskal_and_dunn(scores), "equal")
    frames = tables(scores)
    both = list(zip(scores, frames, strict=True))
    if scikit_posthocs is not None:
        yield Way("scikit-posthocs", "posthoc_dunn, with scipy kruskal, loop", looped(_kruskal_and_dunn, both), "equal")


def _kruskal(design: np.ndarray) -> dict[str, Any]:
    found = stats.kruskal(*design)
    return {"H": found.statistic, "p": found.pvalue}


def _kruskal_and_dunn(both: tuple[np.ndarray, pd.DataFrame]) -> dict[str, Any]:
    design, table = both
    pairs = scikit_posthocs.posthoc_dunn(table, val_col="y", group_col="g", p_adjust="bonferroni")
    return _kruskal(design) | {"p Dunn": pairs.to_numpy()[np.triu_indices(3, 1)]}


def mann_whitney_untied(scores: np.ndarray) -> Iterator[Way]:
    first, second = scores[:, [0, 0, 1]], scores[:, [1, 2, 2]]
    yield Way("numpy", "expert: all pairs", lambda: _rows(two_samples.exact_of_pairs(first, second)), "equal")
    yield Way("scipy", "mannwhitneyu exact, loop", looped(_exact, scores), "as used", P_ALONE)


def _rows(found: dict[str, Any]) -> dict[str, Any]:
    return {"p": found["p"], "shift": found["shift"]}


def mann_whitney_tied(scores: np.ndarray) -> Iterator[Way]:
    yield Way("scipy", "mannwhitneyu exact, loop", looped(_exact, scores), "as used", f"{P_ALONE}; knows no ties")
    yield Way("scipy", "mannwhitneyu, all permutations", looped(_permutations, scores), "as used", P_ALONE)


def _exact(design: np.ndarray) -> dict[str, Any]:
    return {"p": [stats.mannwhitneyu(x, y, method="exact").pvalue for x, y in combinations(design, 2)]}


def _permutations(design: np.ndarray) -> dict[str, Any]:
    every = stats.PermutationMethod(n_resamples=np.inf, batch=20_000)
    return {"p": [stats.mannwhitneyu(x, y, method=every).pvalue for x, y in combinations(design, 2)]}
