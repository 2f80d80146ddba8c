"""Analyses of variance with all pairs, and their counterparts on ranks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from mpmath import mpf

from benchmarks.statistics import mean_peers, rank_peers
from benchmarks.statistics.exact_tests import exact_anova, exact_kruskal, exact_mann_whitney, exact_tukey
from benchmarks.statistics.task import Exact, Numbers, Task
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.kruskal import dunn, kruskal
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.post_hoc import lsd, tukey

TUKEY_NOTE = "The notes have no ratio for equal work; theirs is tukey_hsd beside our LSD, in the table above."
TIED_NOTE = "scipy's exact method does not know of ties; its permutations do."


def group_tasks(n_people: int = 14, n_angles: int = 8, n: int = 10) -> Iterator[Task]:
    """Designs of five specimens (means) and of three (ranks), n values each."""
    rng = np.random.default_rng(3)
    b = rng.standard_normal((n_people, 5, n)) + 0.4 * np.arange(5)[:, None]
    yield Task(
        f"{n_people} analyses of variance of 5 x {n}, 10 LSD pairs each with intervals",
        lambda: _anova(b),
        tuple(mean_peers.anova_and_lsd(b)),
        lambda: _exact_designs(exact_anova, b[:5]),
        0.22,
    )
    yield Task(
        f"{n_people} analyses of variance of 5 x {n}, 10 Tukey pairs each with intervals",
        lambda: _tukey(b),
        tuple(mean_peers.anova_and_tukey(b)),
        lambda: {"p Tukey": {(0, pair): exact_tukey(b[0], pair) for pair in (0, 3, 7)}},
        note=TUKEY_NOTE,
    )
    scores = rng.standard_normal((n_angles, 3, n)) + np.arange(3)[:, None]
    yield Task(
        f"{n_angles} Kruskal-Wallis tests of 3 x {n}, Dunn with Bonferroni",
        lambda: _kruskal(scores),
        tuple(rank_peers.kruskal_and_pairs(scores)),
        lambda: _exact_designs(exact_kruskal, scores),
        0.19,
    )
    for title, values, peers in (
        ("without ties", scores, rank_peers.mann_whitney_untied),
        ("with ties", np.round(2 * scores[:1]), rank_peers.mann_whitney_tied),
    ):
        yield Task(
            f"{len(values)} x 3 exact Mann-Whitney tests of {n} and {n}, {title}",
            lambda values=values: {"p": mann_whitney(values).p},
            tuple(peers(values)),
            lambda values=values: _exact_mann_whitney(values),
            note=TIED_NOTE if title == "with ties" else "",
        )


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
