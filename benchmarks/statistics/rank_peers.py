"""Other ways to tests on ranks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchmarks.bench.case import Way
from benchmarks.nist import Numbers, looped
from benchmarks.statistics.mean_peers import tables
from benchmarks.statistics.peers import pingouin, scikit_posthocs

UPPER = np.triu_indices(3, 1)
P_ALONE = "p alone; ours gives the shift with its interval too"


def kruskal_and_pairs(scores: np.ndarray) -> Iterator[Way]:
    groups = np.moveaxis(scores, 1, 0)

    def axis_aware() -> Numbers:
        found = stats.kruskal(*groups, axis=1)
        for first, second in combinations(groups, 2):
            stats.mannwhitneyu(first, second, axis=1)
        return {"H": found.statistic, "p": found.pvalue}

    yield Way("scipy", "kruskal, 3 mannwhitneyu, axis-aware", axis_aware, "as used", "Mann-Whitney pairs for Dunn's")
    yield Way(
        "scipy",
        "kruskal, 3 mannwhitneyu, loop",
        looped(_kruskal_and_mwu, scores),
        "as used",
        "Mann-Whitney pairs for Dunn's",
    )
    frames = tables(scores)
    both = list(zip(scores, frames, strict=True))
    if scikit_posthocs is not None:
        yield Way("scikit-posthocs", "posthoc_dunn, with scipy kruskal, loop", looped(_kruskal_and_dunn, both), "equal")
    if pingouin is not None:
        yield Way(
            "pingouin",
            "kruskal and pairwise_tests, loop",
            looped(_pingouin, frames),
            "as used",
            "Mann-Whitney pairs for Dunn's",
        )


def _kruskal(design: np.ndarray) -> dict[str, Any]:
    found = stats.kruskal(*design)
    return {"H": found.statistic, "p": found.pvalue}


def _kruskal_and_mwu(design: np.ndarray) -> dict[str, Any]:
    for first, second in combinations(design, 2):
        stats.mannwhitneyu(first, second)
    return _kruskal(design)


def _kruskal_and_dunn(both: tuple[np.ndarray, pd.DataFrame]) -> dict[str, Any]:
    design, table = both
    pairs = scikit_posthocs.posthoc_dunn(table, val_col="y", group_col="g", p_adjust="bonferroni")
    return _kruskal(design) | {"p Dunn": pairs.to_numpy()[UPPER]}


def _pingouin(table: pd.DataFrame) -> dict[str, Any]:
    found = pingouin.kruskal(table, dv="y", between="g")
    pingouin.pairwise_tests(table, dv="y", between="g", parametric=False, padjust="bonf")
    return {"H": found["H"].iloc[0], "p": found["p_unc"].iloc[0]}


def mann_whitney_untied(scores: np.ndarray) -> Iterator[Way]:
    yield Way("scipy", "mannwhitneyu exact, loop", looped(_exact, scores), "as used", P_ALONE)
    yield Way("scipy", "mannwhitneyu exact, axis-aware", lambda: _axis_aware(scores), "as used", P_ALONE)


def mann_whitney_tied(scores: np.ndarray) -> Iterator[Way]:
    yield Way("scipy", "mannwhitneyu exact, loop", looped(_exact, scores), "as used", f"{P_ALONE}; knows no ties")
    yield Way("scipy", "mannwhitneyu, all permutations", looped(_permutations, scores), "as used", P_ALONE)


def _exact(design: np.ndarray) -> dict[str, Any]:
    return {"p": [stats.mannwhitneyu(x, y, method="exact").pvalue for x, y in combinations(design, 2)]}


def _axis_aware(scores: np.ndarray) -> Numbers:
    groups = np.moveaxis(scores, 1, 0)
    p = [stats.mannwhitneyu(x, y, axis=1, method="exact").pvalue for x, y in combinations(groups, 2)]
    return {"p": np.stack(p, axis=1)}


def _permutations(design: np.ndarray) -> dict[str, Any]:
    every = stats.PermutationMethod(n_resamples=np.inf, batch=20_000)
    return {"p": [stats.mannwhitneyu(x, y, method=every).pvalue for x, y in combinations(design, 2)]}
