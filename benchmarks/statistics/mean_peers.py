"""Other ways to an analysis of variance with all pairs of groups."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchmarks.statistics.peers import pingouin, scikit_posthocs, statsmodels_api, statsmodels_formula
from benchmarks.statistics.task import Numbers, Peer

UPPER = np.triu_indices(5, 1)


def tables(designs: np.ndarray) -> list[pd.DataFrame]:
    """One tidy table a design: y, g."""
    _, k, n = designs.shape
    return [pd.DataFrame({"y": d.ravel(), "g": np.repeat([f"S{i}" for i in range(k)], n)}) for d in designs]


def collected(rows: list[dict[str, Any]]) -> Numbers:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def looped(each: Callable[[Any], dict[str, Any]], designs: Any) -> Callable[[], Numbers]:
    return lambda: collected([each(design) for design in designs])


def f_oneway(design: np.ndarray) -> dict[str, Any]:
    found = stats.f_oneway(*design)
    return {"F": found.statistic, "p": found.pvalue}


def anova_and_lsd(b: np.ndarray) -> Iterator[Peer]:
    frames = tables(b)

    def axis_aware() -> Numbers:
        found = stats.f_oneway(*np.moveaxis(b, 1, 0), axis=1)
        return {"F": found.statistic, "p": found.pvalue}

    yield Peer("scipy f_oneway, axis-aware, no pairs", axis_aware, (6.5, 1.4))
    yield Peer("scipy f_oneway and LSD by hand, loop", looped(lambda d: f_oneway(d) | _hand_lsd(d), b), (163, 35.5))
    yield Peer("scipy f_oneway and tukey_hsd, loop", looped(lambda d: f_oneway(d) | _tukey_hsd(d), b), (11067, 2418))
    if scikit_posthocs is not None:
        yield Peer("scikit-posthocs posthoc_lsd alone, loop", looped(_posthoc_lsd, frames), (213, 46.5))
        both_tests = looped(lambda t: _posthoc_ttest(t) | _posthoc_lsd(t), frames)
        yield Peer("scikit-posthocs posthoc_lsd and _ttest", both_tests, (437, 95))
    if statsmodels_api is not None:
        yield Peer("statsmodels anova_lm and t_test_pairwise", looped(_statsmodels, frames), (998, 218))
    if pingouin is not None:
        yield Peer("pingouin anova and pairwise_tests (own SDs)", looped(_pingouin, frames), (3574, 781))


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


def anova_and_tukey(b: np.ndarray) -> Iterator[Peer]:
    frames = tables(b)
    yield Peer("scipy f_oneway and tukey_hsd, loop", looped(lambda d: f_oneway(d) | _tukey_hsd(d), b))
    if statsmodels_api is not None:
        yield Peer("statsmodels pairwise_tukeyhsd, loop", looped(_tukeyhsd, frames))
    if pingouin is not None:
        yield Peer("pingouin pairwise_tukey, loop (no intervals)", looped(_pairwise_tukey, frames))


def _tukeyhsd(table: pd.DataFrame) -> dict[str, Any]:
    return {"p Tukey": statsmodels_api.stats.multicomp.pairwise_tukeyhsd(table["y"], table["g"]).pvalues}


def _pairwise_tukey(table: pd.DataFrame) -> dict[str, Any]:
    return {"p Tukey": pingouin.pairwise_tukey(table, dv="y", between="g")["p_tukey"].to_numpy()}
