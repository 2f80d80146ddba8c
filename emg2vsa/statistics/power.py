"""Power of the repeated-measures F test within one group of people: the computation behind n = 14."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import SettingError

Convention = Literal["gpower", "spss"]

MEANING = (
    "n = 14 follows from ten measurements a person, f = .25, correlation .5 and sphericity: power .819 to find that b "
    "differs between the ten repetitions. To find that it differs between five specimens with the same assumptions, "
    "14 people have power .604 and 21 are needed; neither says anything on equality between people."
)
"""What the paper's sample size means."""
_MOST_PEOPLE = 1_000_000
_NO_EFFECT = 1e-13


@dataclass(frozen=True)
class PowerTable:
    """Power (R, E) for correlations rho (R,) by epsilons (E,), and people needed (R, E), 0 where none suffice."""

    rho: Floats
    epsilon: Floats
    power: Floats
    people: Ints


def power_rm(
    n: ArrayLike,
    m: ArrayLike,
    f: ArrayLike = 0.25,
    rho: ArrayLike = 0.5,
    epsilon: ArrayLike = 1.0,
    alpha: ArrayLike = 0.05,
    convention: Convention = "gpower",
) -> Floats:
    """Power P[F'(df1, df2, lambda) > F(1 - alpha)] of n people measured m times each; all arguments broadcast.

    df1 = (m - 1) epsilon, df2 = (n - 1)(m - 1) epsilon. f : Cohen's effect size. rho : correlation between
    measurements. epsilon : sphericity, 1 / (m - 1) to 1. alpha : level of the test.
    gpower : lambda = f^2 n m epsilon / (1 - rho), G*Power's default ("as in G*Power 3.0").
    spss : f is already the partial one, lambda = f^2 (n - 1)(m - 1) epsilon; rho does not enter.
    SettingError outside n, m >= 2, f >= 0, 0 <= rho < 1, 1 / (m - 1) <= epsilon <= 1, 0 < alpha < 1.
    """
    n, m, f, rho, epsilon, alpha = (np.asarray(x, dtype=np.float64) for x in (n, m, f, rho, epsilon, alpha))
    _check(n, m, f, rho, epsilon, alpha)
    df1 = (m - 1) * epsilon
    df2 = (n - 1) * df1
    noncentrality = f**2 * n * m * epsilon / (1 - rho) if convention == "gpower" else f**2 * df2
    # below this the noncentral law is the central one to 12 digits, and ncfdtr may answer 1
    noncentrality = np.where(noncentrality < _NO_EFFECT, 0.0, noncentrality)
    critical = special.fdtri(df1, df2, 1 - alpha)
    return np.asarray(1 - special.ncfdtr(df1, df2, noncentrality, critical))


def power_anova(groups: int, total: int, f: float, alpha: float) -> float:
    """Power of the one-way ANOVA of ``total`` values in ``groups`` equal groups at Cohen's f; NaN for too few."""
    df1, df2 = groups - 1, total - groups
    if df1 < 1 or df2 < 1:
        return float("nan")
    return float(1 - special.ncfdtr(df1, df2, f**2 * total, float(special.fdtri(df1, df2, 1 - alpha))))


def n_for_power(
    m: int,
    f: float = 0.25,
    rho: float = 0.5,
    epsilon: float = 1.0,
    alpha: float = 0.05,
    power: float = 0.8,
    convention: Convention = "gpower",
) -> int:
    """Fewest people that reach ``power``, or 0 where a million do not."""
    return fewest_people(lambda n: power_rm(n, m, f, rho, epsilon, alpha, convention), power)


def fewest_people(power_of: Callable[[int], Floats], target: float) -> int:
    """Fewest people, two or more, for whom ``power_of`` reaches ``target``, or 0 where a million do not."""
    if not 0 < target < 1:
        raise SettingError(
            "power, target", wanted="a power between 0 and 1", found=str(target), do="Give such a power."
        )

    def enough(n: int) -> bool:
        return bool(power_of(n) >= target)

    high = 2
    while not enough(high):
        high *= 2
        if high > _MOST_PEOPLE:
            return 0
    low = high // 2  # too few, or 1, which no test accepts
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return high


def power_table(
    n: int,
    m: int,
    f: float = 0.25,
    rho: ArrayLike = (0.0, 0.3, 0.5, 0.7),
    epsilon: ArrayLike = (0.5, 0.75, 1.0),
    alpha: float = 0.05,
    power: float = 0.8,
    convention: Convention = "gpower",
) -> PowerTable:
    """How much the answer hangs on the two assumptions nobody knows beforehand.

    An epsilon below its smallest value, 1 / (m - 1), counts as that value.
    """
    rhos = np.atleast_1d(np.asarray(rho, dtype=np.float64))
    epsilons = np.unique(np.maximum(np.asarray(epsilon, dtype=np.float64), 1 / (max(m, 2) - 1)))
    table = power_rm(n, m, f, rhos[:, None], epsilons[None, :], alpha, convention)
    people = [[n_for_power(m, f, r, e, alpha, power, convention) for e in epsilons] for r in rhos]
    return PowerTable(rhos, epsilons, table, np.array(people, dtype=np.int64))


def _check(n: Floats, m: Floats, f: Floats, rho: Floats, epsilon: Floats, alpha: Floats) -> None:
    lowest = 1 / (np.maximum(m, 2) - 1)
    for name, good, wanted, value in (
        ("n", n >= 2, "at least 2 people", n),
        ("m", m >= 2, "at least 2 measurements", m),
        ("f", (f >= 0) & np.isfinite(f), "an effect size of 0 or more", f),
        ("rho", (rho >= 0) & (rho < 1), "a correlation from 0 to below 1", rho),
        ("epsilon", (epsilon >= lowest - 1e-12) & (epsilon <= 1), "1 / (m - 1) to 1", epsilon),
        ("alpha", (alpha > 0) & (alpha < 1), "a level between 0 and 1", alpha),
    ):
        if not np.all(good):
            raise SettingError(f"power, {name}", wanted=wanted, found=str(value), do=f"Give such a value of {name}.")
