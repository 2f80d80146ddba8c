"""Every test of ``emg2vsa.statistics`` where values lie on an offset, spread unequally, or are of extreme scale."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from mpmath import mpf

from benchmarks.stress import exact_tests as exact
from benchmarks.stress.case import Case, Found
from emg2vsa.statistics.anova import brown_forsythe, one_way, welch
from emg2vsa.statistics.bayes import SCALE, jzs_anova
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.factorial import factorial
from emg2vsa.statistics.kruskal import dunn, kruskal
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.mixed import balanced_mixed, unbalanced_mixed
from emg2vsa.statistics.mixed_variances import mixed_variances
from emg2vsa.statistics.normality import ks_normal, shapiro_wilk
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import games_howell, lsd, tukey
from emg2vsa.statistics.reml import fit_reml
from emg2vsa.statistics.repeated import friedman, paired_tests, rm_anova
from emg2vsa.statistics.trend import trend

Ours = Callable[[np.ndarray], Mapping[str, Any]]
Exact = Callable[[Any], Mapping[str, Any]]
MEANS: tuple[tuple[str, float, bool], ...] = (
    ("as measured", 13.0, False),
    ("offset 1e6", 13.0, True),
    ("offset 1e9", 13.0, False),
    ("offset 1e13", 13.0, True),
    ("x 1e-200", 13.0, False),
    ("x 1e300", 13.0, False),
    ("single precision", 13.0, False),
    ("two values each", 12.0, False),
    ("far apart: p near 1e-230", 11.0, True),
    ("variances 1e-12 : 1 : 100", 12.0, True),
)
"""World, least digits promised, in the short table. An offset costs nothing: differences of doubles are taken exactly.
A p near 1e-230 is a power of a number next to 1, which costs two digits."""
RANKS = (("as measured", 13.0, True), ("offset 1e13", 13.0, False), ("x 1e300", 13.0, False), ("ties", 13.0, True))


def worlds(name: str, n: int = 8) -> np.ndarray:
    """Three groups of ``n`` values."""
    z = np.random.default_rng(6).standard_normal((3, 2 if name == "two values each" else n))
    if name.startswith("far apart"):
        return np.random.default_rng(6).standard_normal((3, 120)) + 5.2 * np.arange(3)[:, None]
    if name.startswith("variances"):
        return z * np.array([[1e-6], [1.0], [10.0]]) + np.array([[0.0], [1.0], [4.0]])
    if name == "ties":
        return np.round(2 * (z + np.arange(3)[:, None]))
    values = z + 0.8 * np.arange(3)[:, None]
    if name.startswith("offset"):
        return values + float(name.split()[1])
    if name.startswith("x "):
        return values * float(name.split()[1])
    return values.astype(np.float32) if name == "single precision" else values


def cases() -> Iterator[Case]:
    for name, bound, smoke in MEANS:
        yield from _means(name, bound, smoke)
    for name, bound, smoke in RANKS:
        yield from _ranks(name, bound, smoke)
    for name, bound, smoke in MEANS[:7]:
        yield from _people(name, bound, smoke)
        yield from _samples(name, bound, smoke)


def case(
    function: str, world: str, values: np.ndarray, ours: Ours, truth: Exact, bound: float, smoke: bool = False
) -> Case:
    """``ours`` gives numbers, and under "said" what its outcome tells where they are NaN; ``truth`` gives these and
    perhaps more of the rows of the values in 50 digits."""
    names: list[str] = []

    def run(x: np.ndarray) -> Found:
        found = dict(ours(x))
        said = found.pop("said", "")
        names[:] = found
        undefined = any(np.any(np.isnan(np.asarray(value, dtype=np.float64))) for value in found.values())
        return Found(found, said if undefined else "")

    def true(x: np.ndarray) -> Mapping[str, Any]:
        groups = [exact.groups_of(row) for row in x] if x.ndim == 3 else exact.groups_of(np.atleast_2d(x))
        found = truth(groups)
        return {name: found[name] for name in names}

    return Case(f"stats.{function}", world, (values,), run, true, bound, smoke=smoke)


def numbers(test: Callable[[np.ndarray], Any], **names: str) -> Ours:
    """Attributes of what a test returns, by the names of the numbers, and what it warns of."""

    def ours(x: np.ndarray) -> Mapping[str, Any]:
        found = test(x)
        said = notes(found.outcome()) if hasattr(found, "outcome") else ""
        return {name: getattr(found, attribute) for name, attribute in names.items()} | {"said": said}

    return ours


def _means(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    values = worlds(name)
    of_anova = numbers(one_way, F="f", p="p", eta2="eta2", sd="sd")
    yield case("anova.one_way", name, values, of_anova, exact.anova, bound, smoke)

    def of_lsd(x: np.ndarray) -> Mapping[str, Any]:
        found = lsd(one_way(x))
        return {"p": found.p, "low": found.low[0, 0]}

    yield case("post_hoc.lsd", name, values, of_lsd, lambda groups: exact.lsd(groups, 0.95), bound, smoke)
    if not name.startswith("two"):
        short = smoke and "far" not in name
        of_medians = numbers(brown_forsythe, F="statistic", p="p")
        yield case("anova.brown_forsythe", name, values, of_medians, exact.brown_forsythe, bound, short)
    if name in ("as measured", "offset 1e6", "x 1e300"):
        yield case(
            "post_hoc.tukey", name, values, lambda x: {"p": tukey(one_way(x)).p[0, 0]}, exact.tukey, bound - 1
        )  # fmt: skip

    def of_welch(x: np.ndarray) -> Mapping[str, Any]:
        found = welch(x)
        return {"F": found.statistic, "df2": found.df[1], "p": found.p, "said": notes(found.outcome())}

    yield case("anova.welch", name, values, of_welch, exact.welch, bound, smoke)
    of_pairs = numbers(games_howell, q="statistic", df="df")
    yield case("post_hoc.games_howell", name, values, of_pairs, exact.games_howell, bound, smoke)
    margin = 3 * (float(name.split()[1]) if name.startswith("x ") else 1.0)

    def of_tost(x: np.ndarray) -> Mapping[str, Any]:
        found = tost(x, margin)
        return {"t": found.t[0, 2], "p": found.p[0, 2], "said": notes(found.outcome(pair=2))}

    yield case(
        "equivalence.tost", name, values, of_tost, lambda groups: exact.tost(*groups[1:3], mpf(margin)), bound, smoke
    )
    of_bayes = numbers(jzs_anova, **{"log BF01": "log_bf01"})
    true_bayes = partial(exact.jzs, scale=mpf(SCALE))
    yield case("bayes.jzs_anova", name, values, of_bayes, true_bayes, bound - 1, name == "offset 1e13")


def _ranks(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    values = worlds(name)

    def dunn_and(x: np.ndarray) -> Mapping[str, Any]:
        found = kruskal(x)
        return {"H": found.h, "p": found.p, "said": "" if dunn(found).p.size else "no pairs"}

    yield case("kruskal.kruskal", name, values, dunn_and, exact.kruskal, bound, smoke)

    def of_pair(x: np.ndarray) -> Mapping[str, Any]:
        found = mann_whitney(x)
        return {"p": found.p[0, 0], "shift": found.shift[0, 0]}

    true_pair = lambda groups: exact.mann_whitney(*groups[:2])  # noqa: E731
    yield case("mann_whitney.mann_whitney", name, values, of_pair, true_pair, bound, smoke)
    of_people = numbers(friedman, chi2="statistic", p="p", W="effect")
    yield case("repeated.friedman", name, values.T, of_people, exact.friedman, bound, smoke)
    of_signs = numbers(paired_tests, **{"signed ranks": "signed_rank_p"})
    yield case("repeated.paired_tests, signed ranks", name, values[:2].T, of_signs, _paired, bound, smoke)
    if name == "as measured":
        far = np.arange(600.0).reshape(4, 150)
        yield case(
            "kruskal.kruskal", "four groups of 150 apart: p below 1e-100", far, dunn_and, exact.kruskal, 11.0
        )  # fmt: skip


def _paired(people: exact.Groups) -> Mapping[str, Any]:
    return exact.paired(*(list(column) for column in zip(*people, strict=True)))


def _people(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    values = worlds(name, 9).T
    repeated = numbers(rm_anova, F="f", p="p", epsilon="epsilon_gg", p_gg="p_gg")
    yield case("repeated.rm_anova", name, values, repeated, exact.rm_anova, bound, smoke)

    def agreement(x: np.ndarray) -> Mapping[str, Any]:
        return {"ICC(3,1)": rm_anova(x).consistency().estimate}

    yield case("repeated.rm_anova, agreement", name, values, agreement, exact.icc, bound - 1)
    of_t = numbers(lambda x: paired_tests(x).t, t="statistic", p="p")
    yield case("repeated.paired_tests, t", name, values[:, :2], of_t, _paired, bound)
    cells = worlds(name, 24).reshape(3, 4, 6)
    levels = {"specimen": np.repeat(np.arange(3), 24), "angle": np.tile(np.repeat(np.arange(4), 6), 3)}

    def first_factor(x: np.ndarray) -> Mapping[str, Any]:
        found = factorial(x.ravel(), levels)
        return {"F": found.f[0], "p": found.p[0]}

    yield case("factorial.factorial", name, cells, first_factor, exact.two_factors, bound - 1)
    study = _study(name)
    # variances of values of such a scale are no doubles
    squared = {} if name.startswith("x ") else {"variances": "variance"}
    balanced = numbers(balanced_mixed, **squared, F="f", p="p")
    yield case("mixed.balanced_mixed", name, study, balanced, exact.balanced_mixed, bound - 1, smoke)
    unbalanced = _of_reml(unbalanced_mixed, **squared, F="f")
    yield case("mixed.unbalanced_mixed", name, study, unbalanced, exact.balanced_mixed, 12.0)
    yield case(
        "mixed_variances.mixed_variances", name, study, _of_reml(mixed_variances, SD="sd"), exact.balanced_mixed, 12.0
    )
    yield case("trend.trend", name, study, _trend, exact.trend, bound - 1, name == "x 1e300")


def _study(name: str) -> np.ndarray:
    """4 people x 3 specimens x 5 repetitions with variance between people and between their specimens."""
    rng = np.random.default_rng(8)
    z = rng.standard_normal((4, 3, 5)) + 3 * rng.standard_normal((4, 3, 1)) + 9 * rng.standard_normal((4, 1, 1))
    if name.startswith("offset"):
        return z + float(name.split()[1])
    if name.startswith("x "):
        return z * float(name.split()[1]) * 1e-2
    return z.astype(np.float32) if name == "single precision" else z


def _of_reml(test: Callable[[Any], Any], **names: str) -> Ours:
    """Numbers of a test of the REML fit, NaN with its reason where there is no fit."""

    def ours(x: np.ndarray) -> Mapping[str, Any]:
        fit = fit_reml(x)
        if isinstance(fit, Outcome):
            return dict.fromkeys(names, np.nan) | {"said": notes(fit)}
        found = test(fit)
        return {name: getattr(found, attribute) for name, attribute in names.items()}

    return ours


def _trend(x: np.ndarray) -> Mapping[str, Any]:
    block, group, order = (index.ravel() for index in np.indices(x.shape))
    found = trend(block.astype(str), group.astype(str), order.astype(float), x.ravel())
    return {"mean": found.mean, "t": found.t, "p": found.p}


def _samples(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    row = worlds(name, 10)[0]
    ks = numbers(partial(ks_normal, standardise=True), D="statistic", p="p")
    yield case("normality.ks_normal", name, row, ks, lambda rows: exact.ks(rows[0]), bound - 1, smoke)

    def d(x: np.ndarray) -> Mapping[str, Any]:
        return {"D": lilliefors(x).statistic}

    yield case("lilliefors.lilliefors, D", name, row, d, lambda rows: exact.ks(rows[0]), bound - 1)

    def w(x: np.ndarray) -> Mapping[str, Any]:
        found = shapiro_wilk(x)
        return {"W": found.statistic, "p": found.p}

    yield case("normality.shapiro_wilk", name, row, w, lambda rows: exact.shapiro(rows[0]), bound - 1, smoke)


def notes(outcome: Outcome) -> str:
    """What the outcome warns of."""
    return "; ".join(outcome.notes)
