"""Normality of 70 samples of ten: Kolmogorov-Smirnov with its exact p, Lilliefors, Shapiro-Wilk."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from mpmath import mpf
from scipy import special, stats

from benchmarks.bench.case import Case, Size, Way
from benchmarks.statistics.exact_tests import exact_ks, exact_shapiro
from benchmarks.statistics.numbers import Exact, Numbers, exact_rows, worst_error
from benchmarks.statistics.peers import pingouin, statsmodels_api
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.normality import ks_normal, shapiro_wilk

MPMATH = "40-digit arithmetic"


def sample_cases(size: Size) -> Iterator[Case]:
    """Normality of samples of ten."""
    rows = np.random.default_rng(2).standard_normal((size.pick(6, 70), 10))
    rows[::3] = np.exp(rows[::3])
    simulated = size.pick(20_000, 2_000_000)
    for title, ours, peers, exact, truth in (
        (
            "Kolmogorov-Smirnov, standardised, exact p",
            lambda: _ours(ks_normal(rows, standardise=True), "D"),
            _ks_peers,
            lambda: exact_rows(exact_ks, ("D", "p"), rows),
            MPMATH,
        ),
        (
            "Lilliefors",
            lambda: _ours(lilliefors(rows), "D"),
            _lilliefors_peers,
            lambda: _simulated_p(rows, simulated),
            f"p of {simulated:.0e} simulated samples, to 2 or 3 digits",
        ),
        (
            "Shapiro-Wilk",
            lambda: _ours(shapiro_wilk(rows), "W"),
            _shapiro_peers,
            lambda: exact_rows(exact_shapiro, ("W", "p"), rows),
            MPMATH + ", Royston's AS R94",
        ),
    ):
        yield Case(
            f"{title}, {len(rows)} samples of 10",
            len(rows),
            "samples",
            (Way("emg2vsa", "all samples in one call", ours, "equal"), *peers(rows)),
            worst_error(exact),
            "relative",
            truth,
        )


def _ours(found: Any, statistic: str) -> Numbers:
    return {statistic: found.statistic, "p": found.p}


def _simulated_p(rows: np.ndarray, simulated: int) -> Exact:
    """p of the first rows' D among those of normal samples, mean and SD estimated."""
    rng, n = np.random.default_rng(4), rows.shape[1]
    found = _largest_gap(rows[:6])
    reached = np.zeros(len(found))
    for _ in range(0, simulated, 100_000):
        d = _largest_gap(rng.standard_normal((min(simulated, 100_000), n)))
        reached += np.count_nonzero(d[:, None] >= found, axis=0)
    drawn = min(simulated, 100_000) * len(range(0, simulated, 100_000))
    return {"p": {i: mpf(int(count)) / drawn for i, count in enumerate(reached)}}


def _largest_gap(rows: np.ndarray) -> np.ndarray:
    n = rows.shape[1]
    cdf = special.ndtr(np.sort(_standardised(rows), axis=1))
    return np.max(np.maximum(np.arange(1, n + 1) / n - cdf, cdf - np.arange(n) / n), axis=1)


def _standardised(rows: np.ndarray) -> np.ndarray:
    return np.asarray((rows - rows.mean(axis=1, keepdims=True)) / rows.std(axis=1, ddof=1, keepdims=True))


def _each(test: Callable[[np.ndarray], Any], statistic: str, rows: np.ndarray) -> Numbers:
    """A test that returns its statistic and p, row by row."""
    return dict(zip((statistic, "p"), np.array([test(row) for row in rows]).T, strict=True))


def _ks_peers(rows: np.ndarray) -> Iterator[Way]:
    def axis_aware() -> Numbers:
        found = stats.ks_1samp(_standardised(rows), stats.norm.cdf, axis=1)
        return {"D": found.statistic, "p": found.pvalue}

    yield Way("scipy", "ks_1samp, axis-aware", axis_aware, "equal")
    looped = partial(_each, lambda z: stats.kstest(z, "norm"), "D")
    yield Way("scipy", "kstest, loop", lambda: looped(_standardised(rows)), "equal")


def _lilliefors_peers(rows: np.ndarray) -> Iterator[Way]:
    if statsmodels_api is not None:
        looped = partial(_each, statsmodels_api.stats.lilliefors, "D", rows)
        yield Way("statsmodels", "lilliefors, loop", looped, "equal")


def _shapiro_peers(rows: np.ndarray) -> Iterator[Way]:
    def axis_aware() -> Numbers:
        found = stats.shapiro(rows, axis=1)
        return {"W": found.statistic, "p": found.pvalue}

    yield Way("scipy", "shapiro, axis given", axis_aware, "equal")
    yield Way("scipy", "shapiro, loop", partial(_each, stats.shapiro, "W", rows), "equal")
    if pingouin is not None:
        table = pd.DataFrame({"y": rows.ravel(), "row": np.repeat(np.arange(len(rows)), rows.shape[1])})

        def normality() -> Numbers:
            found = pingouin.normality(table, dv="y", group="row")
            return {"W": found["W"].to_numpy(), "p": found["pval"].to_numpy()}

        yield Way("pingouin", "normality", normality, "equal")
