"""Normality of 70 samples of ten: Kolmogorov-Smirnov with its exact p, Lilliefors, Shapiro-Wilk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from mpmath import mpf
from scipy import special, stats

from benchmarks.statistics.exact_tests import exact_ks, exact_shapiro
from benchmarks.statistics.peers import pingouin, statsmodels_api
from benchmarks.statistics.task import Exact, Numbers, Peer, Task
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.normality import ks_normal
from emg2vsa.statistics.shapiro import shapiro_wilk

SIMULATED = 2_000_000


def sample_tasks(n_samples: int = 70, n: int = 10, simulated: int = SIMULATED) -> Iterator[Task]:
    rows = np.random.default_rng(2).standard_normal((n_samples, n))
    rows[::3] = np.exp(rows[::3])
    yield Task(
        f"{n_samples} Kolmogorov-Smirnov tests of {n} values, standardised, exact p",
        lambda: _ours(ks_normal(rows, standardise=True), "D"),
        tuple(_ks_peers(rows)),
        lambda: _exact_rows(exact_ks, rows, ("D", "p")),
        0.30,
    )
    yield Task(
        f"{n_samples} Lilliefors tests of {n} values",
        lambda: _ours(lilliefors(rows), "D"),
        tuple(_lilliefors_peers(rows)),
        lambda: _exact_rows(exact_ks, rows, ("D",)) | _simulated_p(rows, simulated),
        note=f"p against {simulated} simulated samples, to 3 digits at most. Wanted: as the notes have it beside KS.",
    )
    yield Task(
        f"{n_samples} Shapiro-Wilk tests of {n} values",
        lambda: _ours(shapiro_wilk(rows), "W"),
        tuple(_shapiro_peers(rows)),
        lambda: _exact_rows(exact_shapiro, rows, ("W", "p")),
        note="Wanted: what the notes have beside KS.",
    )


def _ours(found: Any, statistic: str) -> Numbers:
    return {statistic: getattr(found, statistic.lower()), "p": found.p}


def _exact_rows(
    exact: Callable[[np.ndarray], Mapping[str, mpf]], rows: np.ndarray, names: tuple[str, ...]
) -> dict[str, dict[int, mpf]]:
    found = {i: exact(rows[i]) for i in range(0, len(rows), max(1, len(rows) // 20))}
    return {name: {i: numbers[name] for i, numbers in found.items()} for name in names}


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


def _ks_peers(rows: np.ndarray) -> Iterator[Peer]:
    def axis_aware() -> Numbers:
        found = stats.ks_1samp(_standardised(rows), stats.norm.cdf, axis=1)
        return {"D": found.statistic, "p": found.pvalue}

    yield Peer("scipy ks_1samp, axis-aware", axis_aware, (39, 11.7))
    looped = partial(_each, lambda z: stats.kstest(z, "norm"), "D")
    yield Peer("scipy kstest, loop", lambda: looped(_standardised(rows)), (240, 72))


def _lilliefors_peers(rows: np.ndarray) -> Iterator[Peer]:
    if statsmodels_api is not None:
        looped = partial(_each, statsmodels_api.stats.lilliefors, "D", rows)
        yield Peer("statsmodels lilliefors, loop", looped, (253, 76))


def _shapiro_peers(rows: np.ndarray) -> Iterator[Peer]:
    def axis_aware() -> Numbers:
        found = stats.shapiro(rows, axis=1)
        return {"W": found.statistic, "p": found.pvalue}

    yield Peer("scipy shapiro, axis given", axis_aware)
    yield Peer("scipy shapiro, loop", partial(_each, stats.shapiro, "W", rows), (77, 23))
    if pingouin is not None:
        table = pd.DataFrame({"y": rows.ravel(), "row": np.repeat(np.arange(len(rows)), rows.shape[1])})

        def normality() -> Numbers:
            found = pingouin.normality(table, dv="y", group="row")
            return {"W": found["W"].to_numpy(), "p": found["pval"].to_numpy()}

        yield Peer("pingouin normality", normality, (220, 66))
