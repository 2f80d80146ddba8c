"""Analyses of variance with all pairs, and their counterparts on ranks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from mpmath import mpf
from scipy import stats

from benchmarks.bench.case import Case, Size, Way
from benchmarks.statistics import mean_peers, rank_peers
from benchmarks.statistics.exact_tests import exact_anova, exact_kruskal, exact_mann_whitney, exact_tukey
from benchmarks.statistics.numbers import Exact, Numbers, Run, worst_error
from emg2vsa.stats.anova import one_way
from emg2vsa.stats.kruskal import dunn, kruskal
from emg2vsa.stats.mann_whitney import mann_whitney
from emg2vsa.stats.post_hoc import lsd, tukey

MPMATH = "rational and 40-digit arithmetic"


def group_cases(size: Size) -> Iterator[Case]:
    """Designs of five specimens (means) and of three (ranks), ten values each."""
    rng = np.random.default_rng(3)
    n = 10
    for n_designs in size.pick((3,), (1, 8, 64)):
        b = rng.standard_normal((n_designs, 5, n)) + 0.4 * np.arange(5)[:, None]
        family = "one-way ANOVA of 5 x 10 with LSD pairs"
        yield _case(
            f"{family}, {n_designs} designs",
            n_designs,
            lambda b=b: _anova(b),
            mean_peers.anova_and_lsd(b),
            lambda b=b: _exact_designs(exact_anova, b[:5]),
            family,
        )
    b = rng.standard_normal((size.pick(2, 4), 5, n)) + 0.4 * np.arange(5)[:, None]
    yield _case(
        f"ANOVA of 5 x 10 with Tukey's pairs and intervals, {len(b)} designs",
        len(b),
        lambda: _tukey(b),
        mean_peers.anova_and_tukey(b),
        lambda: {"p Tukey": {(0, pair): exact_tukey(b[0], pair) for pair in (0, 3, 7)}},
    )
    for n_designs in size.pick((2,), (1, 8, 64)):
        scores = rng.standard_normal((n_designs, 3, n)) + np.arange(3)[:, None]
        family = "Kruskal-Wallis of 3 x 10 with Dunn's pairs"
        yield _case(
            f"{family}, {n_designs} designs",
            n_designs,
            lambda x=scores: _kruskal(x),
            rank_peers.kruskal_and_pairs(scores),
            lambda x=scores: _exact_designs(exact_kruskal, x[:8]),
            family,
        )
    for title, values, peers in (
        ("without ties", scores[: size.pick(1, 8)], rank_peers.mann_whitney_untied),
        ("with ties", np.round(2 * scores[:1]), size.pick(_no_peers, rank_peers.mann_whitney_tied)),
    ):
        yield _case(
            f"exact Mann-Whitney of 10 and 10, {title}, {len(values)} x 3 pairs",
            len(values),
            lambda x=values: {"p": mann_whitney(x).p},
            peers(values),
            lambda x=values: _exact_mann_whitney(x),
        )


def many_values(size: Size) -> Iterator[Case]:
    """Mann-Whitney of two large samples, and all pairs of many groups."""
    rng = np.random.default_rng(9)
    for n in size.pick((300, 3_000), (3_000, 30_000, 300_000)):
        pair = rng.standard_normal((2, n))
        family = "Mann-Whitney of two large samples"
        yield Case(
            f"{family}, {n} values each",
            n,
            "values",
            (
                Way(
                    "emg2vsa", "mann_whitney", lambda x=pair: mann_whitney(x).u[0, 0], "equal", "shift and interval too"
                ),
                Way(
                    "scipy", "mannwhitneyu", lambda x=pair: stats.mannwhitneyu(*x).statistic, "as used", "U and p alone"
                ),
            ),
            lambda u, x=pair: abs(float(u) - _pairs_won(*x)),
            "pairs of U",
            "pairs counted in integers",
            family,
        )
    for k in size.pick((4, 8), (10, 40, 160)):
        groups = rng.standard_normal((k, 10))
        first, second = np.triu_indices(k, 1)
        family = "Mann-Whitney of all pairs of groups of 10"
        yield Case(
            f"{family}, {k} groups",
            k,
            "groups",
            (
                Way(
                    "emg2vsa", "mann_whitney", lambda x=groups: mann_whitney(x).u[0], "equal", "shift and interval too"
                ),
                Way(
                    "scipy",
                    "mannwhitneyu, axis-aware",
                    lambda x=groups, i=first, j=second: (
                        stats.mannwhitneyu(x[i], x[j], axis=1, method="exact").statistic
                    ),
                    "as used",
                    "U and p alone",
                ),
            ),
            lambda u, x=groups, i=first, j=second: float(
                np.max(np.abs(np.asarray(u) - [_pairs_won(x[a], x[b]) for a, b in zip(i, j, strict=True)]))
            ),
            "pairs of U",
            "pairs counted in integers",
            family,
        )


def _pairs_won(x: np.ndarray, y: np.ndarray) -> float:
    """Pairs whose first value is the larger; values without ties."""
    return float(np.sum(np.searchsorted(np.sort(y), x)))


def _case(name: str, n: int, ours: Run, peers: Iterator[Way], exact: Callable[[], Exact], family: str = "") -> Case:
    ways = (Way("emg2vsa", "all designs in one call", ours, "equal"), *peers)
    return Case(name, n, "designs", ways, worst_error(exact), "relative", MPMATH, family)


def _no_peers(_: np.ndarray) -> Iterator[Way]:
    """All permutations take seconds."""
    return iter(())


def _anova(b: np.ndarray) -> Numbers:
    anova = one_way(b)
    pairs = lsd(anova)
    return {"F": anova.f, "p": anova.p, "p LSD": pairs.p, "low LSD": pairs.low}


def _tukey(b: np.ndarray) -> Numbers:
    return {"p Tukey": tukey(one_way(b)).p}


def _kruskal(scores: np.ndarray) -> Numbers:
    found = kruskal(scores)
    return {"H": found.h, "p": found.p, "p Dunn": dunn(found).p}


def _exact_designs(exact: Callable[[np.ndarray], Mapping[Any, mpf]], designs: np.ndarray) -> Exact:
    """Keys of ``exact`` are names, or names with a pair."""
    found: dict[str, dict[Any, mpf]] = {}
    for i, design in enumerate(designs):
        for key, value in exact(design).items():
            name, index = (key, i) if isinstance(key, str) else (key[0], (i, key[1]))
            found.setdefault(name, {})[index] = value
    return found


def _exact_mann_whitney(scores: np.ndarray) -> Exact:
    return {
        "p": {
            (i, pair): exact_mann_whitney(design[first], design[second])
            for i, design in enumerate(scores[:3])
            for pair, (first, second) in enumerate(((0, 1), (0, 2), (1, 2)))
        }
    }
