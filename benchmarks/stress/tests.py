"""Every test of ``emg2vsa.statistics`` where values lie on an offset, spread unequally, or are of extreme scale."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.statistics.exact_tests import exact_ks, exact_shapiro
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
Exact = Callable[[np.ndarray], Mapping[str, Any]]
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
    """``ours`` gives numbers, and under "said" what its outcome tells where they are NaN."""

    def run(x: np.ndarray) -> Found:
        found = dict(ours(x))
        said = found.pop("said", "")
        undefined = any(np.any(np.isnan(np.asarray(value, dtype=np.float64))) for value in found.values())
        return Found(found, said if undefined else "")

    return Case(f"stats.{function}", world, (values,), run, truth, bound, smoke=smoke)


def _means(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    values = worlds(name)

    def add(function: str, ours: Ours, truth: Exact, least: float = bound, short: bool = smoke) -> Case:
        return case(function, name, values, ours, truth, least, short)

    def of_anova(x: np.ndarray) -> Mapping[str, Any]:
        found = one_way(x)
        return {"F": found.f, "p": found.p, "eta2": found.eta2, "sd": found.sd, "said": notes(found.outcome())}

    yield add("anova.one_way", of_anova, lambda x: exact.anova(exact.groups_of(x)))
    yield add(
        "post_hoc.lsd",
        lambda x: {"p": lsd(one_way(x)).p, "low": lsd(one_way(x)).low[0, 0]},
        lambda x: exact.lsd(exact.groups_of(x), 0.95),
    )
    if not name.startswith("two"):
        yield add(
            "anova.brown_forsythe",
            lambda x: {"F": brown_forsythe(x).statistic, "p": brown_forsythe(x).p},
            lambda x: exact.brown_forsythe(exact.groups_of(x)),
            bound,
            smoke and "far" not in name,
        )
    if name in ("as measured", "offset 1e6", "x 1e300"):
        yield add(
            "post_hoc.tukey",
            lambda x: {"p": tukey(one_way(x)).p[0, 0]},
            lambda x: exact.tukey(exact.groups_of(x)),
            bound - 1,
            False,
        )
    yield add(
        "anova.welch",
        lambda x: {"F": welch(x).statistic, "df2": welch(x).df[1], "p": welch(x).p, "said": notes(welch(x).outcome())},
        lambda x: exact.welch(exact.groups_of(x)),
    )
    yield add(
        "post_hoc.games_howell",
        lambda x: {"q": games_howell(x).statistic, "df": games_howell(x).df},
        lambda x: exact.games_howell(exact.groups_of(x)),
    )
    scale = float(name.split()[1]) if name.startswith("x ") else 1.0
    margin = 3 * scale

    def of_tost(x: np.ndarray) -> Mapping[str, Any]:
        found = tost(x, margin)
        return {"t": found.t[0, 2], "p": found.p[0, 2], "said": notes(found.outcome(pair=2))}

    def true_tost(x: np.ndarray) -> Mapping[str, Any]:
        groups = exact.groups_of(x)
        return exact.tost(groups[1], groups[2], mpf(margin))

    yield add("equivalence.tost", of_tost, true_tost)
    yield add(
        "bayes.jzs_anova",
        lambda x: {"log BF01": jzs_anova(x).log_bf01},
        lambda x: exact.jzs(exact.groups_of(x), mpf(SCALE)),
        bound - 1,
        name == "offset 1e13",
    )


def _ranks(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    values = worlds(name)

    def dunn_and(x: np.ndarray) -> Mapping[str, Any]:
        found = kruskal(x)
        return {"H": found.h, "p": found.p, "said": "" if dunn(found).p.size else "no pairs"}

    yield case("kruskal.kruskal", name, values, dunn_and, lambda x: exact.kruskal(exact.groups_of(x)), bound, smoke)
    yield case(
        "mann_whitney.mann_whitney",
        name,
        values,
        lambda x: {"p": mann_whitney(x).p[0, 0], "shift": mann_whitney(x).shift[0, 0]},
        lambda x: exact.mann_whitney(*exact.groups_of(x)[:2]),
        bound,
        smoke,
    )
    yield case(
        "repeated.friedman",
        name,
        values.T,
        lambda x: {"chi2": friedman(x).statistic, "p": friedman(x).p, "W": friedman(x).effect},
        lambda x: exact.friedman(exact.groups_of(x)),
        bound,
        smoke,
    )
    yield case(
        "repeated.paired_tests, signed ranks",
        name,
        values[:2].T,
        lambda x: {"signed ranks": paired_tests(x).signed_rank_p},
        lambda x: {"signed ranks": exact.paired(*exact.groups_of(x.T))["signed ranks"]},
        bound,
        smoke,
    )
    if name == "as measured":
        far = np.arange(600.0).reshape(4, 150)
        yield case(
            "kruskal.kruskal",
            "four groups of 150 apart: p below 1e-100",
            far,
            dunn_and,
            lambda x: exact.kruskal(exact.groups_of(x)),
            11.0,
        )


def _people(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    values = worlds(name, 9).T

    def repeated(x: np.ndarray) -> Mapping[str, Any]:
        found = rm_anova(x)
        return {
            "F": found.f,
            "p": found.p,
            "epsilon": found.epsilon_gg,
            "p_gg": found.p_gg,
            "said": notes(found.outcome()),
        }

    yield case("repeated.rm_anova", name, values, repeated, lambda x: exact.rm_anova(exact.groups_of(x)), bound, smoke)
    yield case(
        "repeated.rm_anova, agreement",
        name,
        values,
        lambda x: {"ICC(3,1)": rm_anova(x).consistency().estimate},
        lambda x: {"ICC(3,1)": exact.icc(exact.groups_of(x))["ICC(3,1)"]},
        bound - 1,
    )
    yield case(
        "repeated.paired_tests, t",
        name,
        values[:, :2],
        lambda x: {"t": paired_tests(x).t.statistic, "p": paired_tests(x).t.p},
        lambda x: {key: exact.paired(*exact.groups_of(x.T))[key] for key in ("t", "p")},
        bound,
    )
    cells = worlds(name, 24).reshape(3, 4, 6)
    levels = {"specimen": np.repeat(np.arange(3), 24), "angle": np.tile(np.repeat(np.arange(4), 6), 3)}
    yield case(
        "factorial.factorial",
        name,
        cells,
        lambda x: {"F": factorial(x.ravel(), levels).f[0], "p": factorial(x.ravel(), levels).p[0]},
        lambda x: exact.two_factors([exact.groups_of(row) for row in x]),
        bound - 1,
    )
    study = _study(name)
    squared = not name.startswith("x ")  # variances of such values are no doubles

    def truth(x: np.ndarray) -> dict[str, Any]:
        found = exact.balanced_mixed([exact.groups_of(row) for row in x])
        sd = [mp.sqrt(each) for each in found["variances"]]
        return {"SD": sd, **{key: found[key] for key in (("variances", "F", "p") if squared else ("F", "p"))}}

    def without(names: tuple[str, ...]) -> Exact:
        return lambda x: {key: value for key, value in truth(x).items() if key not in names}

    yield case(
        "mixed.balanced_mixed",
        name,
        study,
        lambda x: {"variances": balanced_mixed(x).variance, "F": balanced_mixed(x).f, "p": balanced_mixed(x).p},
        without(("SD",)),
        bound - 1,
        smoke,
    )
    yield case("mixed.unbalanced_mixed", name, study, _unbalanced, without(("SD", "p")), 12.0)
    yield case("mixed_variances.mixed_variances", name, study, _variances, without(("variances", "F", "p")), 12.0)
    yield case(
        "trend.trend",
        name,
        study,
        _trend,
        lambda x: exact.trend([exact.groups_of(row) for row in x]),
        bound - 1,
        name == "x 1e300",
    )


def _study(name: str) -> np.ndarray:
    """4 people x 3 specimens x 5 repetitions with variance between people and between their specimens."""
    rng = np.random.default_rng(8)
    z = rng.standard_normal((4, 3, 5)) + 3 * rng.standard_normal((4, 3, 1)) + 9 * rng.standard_normal((4, 1, 1))
    if name.startswith("offset"):
        return z + float(name.split()[1])
    if name.startswith("x "):
        return z * float(name.split()[1]) * 1e-2
    return z.astype(np.float32) if name == "single precision" else z


def _unbalanced(x: np.ndarray) -> Mapping[str, Any]:
    fit = fit_reml(x)
    if isinstance(fit, Outcome):
        return {"variances": np.nan, "said": notes(fit)}
    found = unbalanced_mixed(fit)
    return {"variances": found.variance, "F": found.f}


def _variances(x: np.ndarray) -> Mapping[str, Any]:
    fit = fit_reml(x)
    return {"SD": np.nan, "said": notes(fit)} if isinstance(fit, Outcome) else {"SD": mixed_variances(fit).sd}


def _trend(x: np.ndarray) -> Mapping[str, Any]:
    block, group, order = (index.ravel() for index in np.indices(x.shape))
    found = trend(block.astype(str), group.astype(str), order.astype(float), x.ravel())
    return {"mean": found.mean, "t": found.t, "p": found.p}


def _samples(name: str, bound: float, smoke: bool) -> Iterator[Case]:
    row = worlds(name, 10)[0]

    def ks(x: np.ndarray) -> Mapping[str, Any]:
        found = ks_normal(x, standardise=True)
        return {"D": found.statistic, "p": found.p, "said": notes(found.outcome())}

    yield case("normality.ks_normal", name, row, ks, lambda x: exact_ks(list(x)), bound - 1, smoke)
    yield case(
        "lilliefors.lilliefors, D",
        name,
        row,
        lambda x: {"D": lilliefors(x).statistic},
        lambda x: {"D": exact_ks(list(x))["D"]},
        bound - 1,
    )
    yield case(
        "normality.shapiro_wilk",
        name,
        row,
        lambda x: {"W": shapiro_wilk(x).statistic, "p": shapiro_wilk(x).p},
        lambda x: exact_shapiro(list(x)),
        bound - 1,
        smoke,
    )


def notes(outcome: Outcome) -> str:
    """What the outcome warns of."""
    return "; ".join(outcome.notes)
