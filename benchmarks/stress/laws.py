"""Laws of probability far out in their tails, and what is made of p."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.statistics.exact_laws import ks_survival, power_of_rm, range_survival
from benchmarks.stress.case import Case, Found, exactly
from emg2vsa.statistics import effect_size, normality, studentized_range
from emg2vsa.statistics.multiplicity import adjust
from emg2vsa.statistics.power import power_rm


def cases() -> Iterator[Case]:
    yield from _noncentral()
    for q, k, df, bound, smoke in ((3.5, 3, 12, 12.0, True), (8.0, 5, 45, 10.0, False), (0.01, 3, 12, 12.0, False)):
        yield _of(
            "studentized_range.survival",
            f"q = {q:g}, {k} groups, df {df}",
            lambda q=q, k=k, df=df: studentized_range.survival(q, k, df),
            lambda q=q, k=k, df=df: range_survival(mpf(q), k, df),
            bound,
            smoke,
        )
    for d, n, bound, smoke in ((0.3, 10, 12.0, True), (0.9, 12, 12.0, False), (0.1, 60, 12.0, False)):
        yield _of(
            "normality.ks_survival",
            f"D = {d:g}, n = {n}",
            lambda d=d, n=n: normality.ks_survival([d], [n]),
            lambda d=d, n=n: ks_survival(mpf(d), n),
            bound,
            smoke,
        )
    for n, m, f, rho in ((14, 5, "0.25", "0.5"), (20, 4, "0.25", "0.9"), (60, 6, "0.1", "0")):
        yield _of(
            "power.power_rm",
            f"{n} people, {m} times, f = {f}, rho = {rho}",
            lambda n=n, m=m, f=f, rho=rho: power_rm(n, m, float(f), float(rho)),
            lambda n=n, m=m, f=f, rho=rho: power_of_rm(n, m, f, rho, "0.05"),
            10.0,
            n == 14,
        )
    yield from _hedges()
    yield from _adjusted()


def _of(
    function: str, world: str, ours: Callable[[], Any], truth: Callable[[], Any], bound: float, smoke: bool
) -> Case:
    """A function of fixed numbers; their rounding is not the question."""
    return Case(
        f"stats.{function}",
        world,
        (),
        lambda: Found({"value": ours()}),
        lambda: {"value": truth()},
        bound,
        condition=0.0,
        smoke=smoke,
    )


def _noncentral() -> Iterator[Case]:
    for df, nc, t, bound, smoke in (
        (10, 1.0, 2.0, 12.0, True),
        (10, 30.0, 25.0, 10.0, False),
        (4, 1e3, 1.2e3, 9.0, True),
        (50, 1e6, 1.05e6, 8.0, False),
    ):
        yield _of(
            "effect_size.noncentral_t",
            f"df {df}, noncentrality {nc:g}, t = {t:g}",
            lambda df=df, nc=nc, t=t: effect_size.noncentral_t(np.array([float(df)]), np.array([nc]), np.array([t])),
            lambda df=df, nc=nc, t=t: _exact_noncentral_t(df, nc, t),
            bound,
            smoke,
        )
    for df1, df2, nc, f, bound, smoke in (
        (2, 20, 1.0, 2.0, 12.0, True),
        (4, 40, 100.0, 20.0, 10.0, False),
        (4, 40, 3e3, 700.0, 9.0, False),
    ):
        yield _of(
            "effect_size.noncentral_f",
            f"df {df1} and {df2}, noncentrality {nc:g}, F = {f:g}",
            lambda a=df1, b=df2, nc=nc, f=f: effect_size.noncentral_f(*(np.array([float(v)]) for v in (a, b, nc, f))),
            lambda a=df1, b=df2, nc=nc, f=f: _exact_noncentral_f(a, b, nc, f),
            bound,
            smoke,
        )


def _exact_noncentral_t(df: int, nc: float, t: float) -> Any:
    """P(Z + nc <= t S), S the root of chi squared over df: the normal law averaged over that of S."""
    half = mpf(df) / 2
    scale = 2 * half**half / mp.gamma(half)

    def density(s: Any) -> Any:
        return scale * s ** (df - 1) * mp.exp(-half * s * s) * mp.ncdf(t * s - nc)

    middle = mpf(nc) / mpf(t)  # where the normal law goes from 0 to 1, within a few 1/t
    cuts = [0, *(middle + mpf(c) / t for c in (-12, -6, -3, 0, 3, 6, 12)), middle + 1, middle + 3, middle + 10]
    return mp.quad(density, sorted(max(mpf(0), cut) for cut in cuts))


def _exact_noncentral_f(df1: int, df2: int, nc: float, f: float) -> Any:
    """Poisson's mixture of central laws."""
    half, x = mpf(nc) / 2, df1 * mpf(f) / (df1 * mpf(f) + df2)
    reach = int(half + 14 * mp.sqrt(half) + 60)
    start = max(0, int(half - 14 * mp.sqrt(half) - 60))
    term = mp.exp(-half + start * mp.log(half) - mp.loggamma(start + 1))
    total = mpf(0)
    with mp.workdps(30):
        for i in range(start, reach):
            total += term * mp.betainc(mpf(df1) / 2 + i, mpf(df2) / 2, 0, x, regularized=True)
            term *= half / (i + 1)
    return total


def _hedges() -> Iterator[Case]:
    for t, n, smoke in ((2.0, 5, True), (-3.0, 1_000_000, True)):

        def truth(t: float = t, n: int = n) -> Any:
            df = mpf(2 * n - 2)
            factor = mp.exp(mp.loggamma(df / 2) - mp.loggamma((df - 1) / 2)) / mp.sqrt(df / 2)
            return mpf(t) * mp.sqrt(mpf(2) / n) * factor

        yield _of(
            "effect_size.hedges_g",
            f"t = {t:g}, two groups of {n}",
            lambda t=t, n=n: effect_size.hedges_g([t], [n], [n])[0],
            truth,
            13.0,
            smoke,
        )
    yield _of(
        "effect_size.omega2",
        "F = 1 + 1e-9, df 2, n = 30",
        lambda: effect_size.omega2(1 + 1e-9, 2, 30),
        lambda: 2 * (mpf(1 + 1e-9) - 1) / (2 * (mpf(1 + 1e-9) - 1) + 30),
        13.0,
        False,
    )


def _adjusted() -> Iterator[Case]:
    p = np.array([1e-300, 3e-232, 0.01, 0.2, 0.9])

    def holm(values: np.ndarray) -> list[Any]:
        ordered, largest = sorted(exactly(value) for value in values), mpf(0)
        adjusted = []
        for i, value in enumerate(ordered):
            largest = max(largest, min(mpf(1), (len(ordered) - i) * value))
            adjusted.append(largest)
        return adjusted

    yield Case(
        "stats.multiplicity.adjust, Holm",
        "p from 1e-300",
        (p,),
        lambda x: Found({"p": adjust(x, "holm")}),
        lambda x: {"p": holm(x)},
        15.0,
        smoke=True,
    )
