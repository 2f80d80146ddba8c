"""Analyses of variance with all pairs, and their counterparts on ranks.

The mixed model of a balanced study, with and without variance between participants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from benchmarks.bench.case import Case, Size, Way, peer
from benchmarks.experts import two_samples
from benchmarks.nist import Exact, Numbers, Run, worst_error
from benchmarks.statistics import group_peers
from benchmarks.stress import exact_tests
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.kruskal import dunn, kruskal
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.post_hoc import lsd, tukey

VOLTS = 1e-5
statsmodels_formula = peer("statsmodels.formula.api")


def mixed_cases(size: Size) -> Iterator[Case]:
    """Fourteen people, five specimens, ten repetitions, in volts."""
    rng = np.random.default_rng(5)
    shape = size.pick((5, 3, 4), (14, 5, 10))
    noise = rng.standard_normal(shape) + 0.5 * np.arange(shape[1])[:, None]
    people = rng.standard_normal((shape[0], 1, 1))
    cells = 0.5 * rng.standard_normal((shape[0], shape[1], 1))
    level = noise - noise.mean(axis=(1, 2), keepdims=True)  # no variance between people at all
    for title, y in (
        ("participants and their specimens differ", noise + people + cells),
        ("no variance between participants (boundary)", level + cells - cells.mean(axis=1, keepdims=True)),
    ):
        ours = Way("emg2vsa", "balanced_mixed", lambda y=VOLTS * y: _ours(y), "equal", "with intervals and checks")
        yield Case(
            f"mixed model in volts, {title}",
            y.size,
            "rows",
            (ours, *_statsmodels(VOLTS * y)),
            worst_error(lambda y=VOLTS * y: _exact(y)),
            "relative",
            "REML of a balanced study in 50-digit arithmetic",
        )


def _ours(y: np.ndarray) -> Numbers:
    found = balanced_mixed(y)
    return {
        "mean": found.mean,
        "var people": found.variance[:1],
        "var cells": found.variance[1:2],
        "var rep": found.variance[2:],
        "F": [found.f],
    }


def _statsmodels(y: np.ndarray) -> Iterator[Way]:
    if statsmodels_formula is None:
        return
    person, specimen, _ = (index.ravel() for index in np.indices(y.shape))
    table = pd.DataFrame({"y": y.ravel(), "person": person, "specimen": specimen})

    def fit(**random: Any) -> Any:
        return statsmodels_formula.mixedlm("y ~ C(specimen)", table, groups="person", **random).fit(reml=True)

    def simple() -> Numbers:
        try:
            return {"mean": _means(fit())}
        except np.linalg.LinAlgError:
            return {"mean": np.full(y.shape[1], np.nan)}

    def nested() -> Numbers:
        try:
            found = fit(re_formula="1", vc_formula={"cell": "0 + C(specimen)"})
        except np.linalg.LinAlgError:
            return {"mean": np.full(y.shape[1], np.nan)}
        numbers = {"var people": found.cov_re.to_numpy()[0], "var cells": found.vcomp, "var rep": [found.scale]}
        return {"mean": _means(found), **numbers}

    yield Way(
        "statsmodels", "MixedLM (1 | person)", simple, "as used", "no variance of cells; a fit that fails has no digits"
    )
    yield Way("statsmodels", "MixedLM, specimens within", nested, "equal", "a fit that fails has no digits")


def _means(fit: Any) -> np.ndarray:
    effects = fit.fe_params.to_numpy()
    return np.concatenate([effects[:1], effects[0] + effects[1:]])


def _exact(y: np.ndarray) -> Exact:
    found = exact_tests.balanced_mixed([exact_tests.groups_of(row) for row in y])
    variances = dict(zip(("var people", "var cells", "var rep"), found["variances"], strict=True))
    return {"mean": dict(enumerate(found["mean"])), **{k: {0: v} for k, v in variances.items()}, "F": {0: found["F"]}}


MPMATH = "50-digit arithmetic"


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
            group_peers.anova_and_lsd(b),
            lambda b=b: _exact_designs(_exact_anova, b[:5]),
            family,
        )
    b = rng.standard_normal((size.pick(2, 4), 5, n)) + 0.4 * np.arange(5)[:, None]
    yield _case(
        f"ANOVA of 5 x 10 with Tukey's pairs and intervals, {len(b)} designs",
        len(b),
        lambda: _tukey(b),
        group_peers.anova_and_tukey(b),
        lambda: {
            "p Tukey": {(0, pair): exact_tests.tukey(exact_tests.groups_of(b[0]), pair)["p"] for pair in (0, 3, 7)}
        },
    )
    for n_designs in size.pick((2,), (1, 8, 64)):
        scores = rng.standard_normal((n_designs, 3, n)) + np.arange(3)[:, None]
        family = "Kruskal-Wallis of 3 x 10 with Dunn's pairs"
        yield _case(
            f"{family}, {n_designs} designs",
            n_designs,
            lambda x=scores: _kruskal(x),
            group_peers.kruskal_and_pairs(scores),
            lambda x=scores: _exact_designs(exact_tests.kruskal, x[:8]),
            family,
        )
    for title, values, peers in (
        ("without ties", scores[: size.pick(1, 8)], group_peers.mann_whitney_untied),
        ("with ties", np.round(2 * scores[:1]), size.pick(_no_peers, group_peers.mann_whitney_tied)),
    ):
        yield _case(
            f"exact Mann-Whitney of 10 and 10, {title}, {len(values)} x 3 pairs",
            len(values),
            lambda x=values: _mann_whitney(x),
            peers(values),
            lambda x=values: _exact_designs(_exact_mann_whitney, x[:3]),
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
                Way("emg2vsa", "mann_whitney", lambda x=pair: _ours_of_two(x), "equal", "shift and interval too"),
                Way("numpy", "expert: sorted, and secants", lambda x=pair: two_samples.of_large(*x), "equal"),
                Way("scipy", "mannwhitneyu", lambda x=pair: _u_and_p(x), "as used", "U and p alone"),
            ),
            lambda found, x=pair: _off(found, *x),
            "places",
            "pairs counted in integers: how far U is off, and the shift from the middle of all differences",
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


def _ours_of_two(pair: np.ndarray) -> dict[str, float]:
    found = mann_whitney(pair)
    return {name: float(getattr(found, name)[0, 0]) for name in ("u", "p", "shift", "low", "high")}


def _u_and_p(pair: np.ndarray) -> dict[str, float]:
    found = stats.mannwhitneyu(*pair)
    return {"u": float(found.statistic), "p": float(found.pvalue)}


def _off(found: dict[str, float], x: np.ndarray, y: np.ndarray) -> float:
    """Pairs that U is off, or places that the shift lies from the middle of all differences."""
    off, middle = abs(found["u"] - _pairs_won(x, y)), x.size * y.size / 2
    if "shift" in found:
        ordered = np.sort(y)
        before, upto = (
            np.sum(y.size - np.searchsorted(ordered, x - found["shift"], side=side)) for side in ("right", "left")
        )
        off = max(off, float(before) - middle, middle - float(upto))
    return off


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


def _mann_whitney(values: np.ndarray) -> Numbers:
    found = mann_whitney(values)
    return {"p": found.p, "shift": found.shift}


def _exact_designs(exact: Callable[[exact_tests.Groups], Mapping[str, Any]], designs: np.ndarray) -> Exact:
    """A number of each design, or one of each of its pairs."""
    found: dict[str, dict[Any, Any]] = {}
    for i, design in enumerate(designs):
        for name, value in exact(exact_tests.groups_of(design)).items():
            of_pairs = {(i, pair): each for pair, each in enumerate(value)} if isinstance(value, list) else {i: value}
            found.setdefault(name, {}).update(of_pairs)
    return found


def _exact_anova(groups: exact_tests.Groups) -> Mapping[str, Any]:
    anova, pairs = exact_tests.anova(groups), exact_tests.lsd(groups, 0.95)
    return {"F": anova["F"], "p": anova["p"], "p LSD": pairs["p"], "low LSD": [pairs["low"]]}


def _exact_mann_whitney(groups: exact_tests.Groups) -> Mapping[str, Any]:
    found = [exact_tests.mann_whitney(*pair) for pair in combinations(groups, 2)]
    return {name: [each[name] for each in found] for name in ("p", "shift")}


def _exact_tukey(design: np.ndarray, pair: int) -> Any:
    return exact_tests.tukey(exact_tests.groups_of(design), pair)["p"]
