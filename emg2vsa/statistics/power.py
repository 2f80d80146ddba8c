"""Power of the repeated-measures F test within one group of people, which is the computation behind n = 14, and of two
treatments: the paired t test that they differ (statsmodels), and two one-sided t tests that they are equal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, special

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
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(128)
_WIDTH = 12.0  # standard deviations of the SD that are integrated over


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

    df1 = (m - 1) epsilon, df2 = (n - 1)(m - 1) epsilon. f : Cohen's effect size (1988). rho : correlation between
        measurements. epsilon : sphericity, 1 / (m - 1) to 1. alpha : level of the test.
    gpower : lambda = f^2 n m epsilon / (1 - rho), G*Power's default ("as in G*Power 3.0"; Faul et al. 2007).
    spss : f is already the partial one, lambda = f^2 (n - 1)(m - 1) epsilon; rho does not enter.
    SettingError outside n, m >= 2, f >= 0, 0 <= rho < 1, 1 / (m - 1) <= epsilon <= 1, 0 < alpha < 1.
    """
    n, m, f, rho, epsilon, alpha = (np.asarray(x, dtype=np.float64) for x in (n, m, f, rho, epsilon, alpha))
    lowest = 1 / (np.maximum(m, 2) - 1)
    _check(
        "power",
        ("n", n >= 2, "at least 2 people", n),
        ("m", m >= 2, "at least 2 measurements", m),
        ("f", (f >= 0) & np.isfinite(f), "an effect size of 0 or more", f),
        ("rho", (rho >= 0) & (rho < 1), "a correlation from 0 to below 1", rho),
        ("epsilon", (epsilon >= lowest - 1e-12) & (epsilon <= 1), "1 / (m - 1) to 1", epsilon),
        ("alpha", (alpha > 0) & (alpha < 1), "a level between 0 and 1", alpha),
    )
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


def fewest_people(power_of: Callable[[int], Any], target: float) -> int:
    """Fewest people, two or more, for whom ``power_of`` reaches ``target``, or 0 where a million do not. SettingError :
    a target that is no power."""
    _check_target(target)

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


def power_paired(effect_dz: float, n: int, alpha: float = 0.05) -> float:
    """Chance that the two-sided paired t test of n people finds a mean difference of ``effect_dz`` SDs of the
    differences. SettingError where a number makes no sense.
    """
    from statsmodels.stats.power import TTestPower  # noqa: PLC0415  (0.4 s that one command alone needs)

    _check(
        "paired power",
        ("effect", np.isfinite(effect_dz), "a finite number", effect_dz),
        ("alpha", 0 < alpha < 1, "a level between 0 and 1", alpha),
        ("n", 2 <= n < np.inf, "two people or more", n),
    )
    # one tail at a time: that of the wrong sign is NaN where it is less than 1e-13
    tails = [TTestPower().power(side, n, alpha / 2, alternative="larger") for side in (abs(effect_dz), -abs(effect_dz))]
    return float(np.nansum(tails))


def power_tost(margin_sd: float, n1: int, n2: int | None = None, delta_sd: float = 0.0, alpha: float = 0.05) -> float:
    """Chance that equivalence within ``margin_sd`` is found where the true difference is ``delta_sd``.

    Both in true SDs: of each group for two samples of n1 and n2 (pooled variance), of the differences or the values for
    n2 None (paired, one sample). Exact: both tests reject where |difference| < margin - t(1 - alpha) SE, normal given
    the SD, and that is integrated over the chi law of the SD. SettingError where a number makes no sense.
    """
    df = n1 - 1 if n2 is None else n1 + n2 - 2
    _check(
        "equivalence power",
        ("margin", 0 <= margin_sd < np.inf, "a margin of 0 or more", margin_sd),
        ("difference", np.isfinite(delta_sd), "a finite number", delta_sd),
        ("alpha", 0 < alpha < 0.5, "a level between 0 and 1/2", alpha),
        ("n", n1 >= 1 and (n2 is None or n2 >= 1) and df >= 1, "one degree of freedom or more", df),
    )
    se, t = np.sqrt(1 / n1 + (0.0 if n2 is None else 1 / n2)), float(special.stdtrit(df, 1 - alpha))
    # s, the estimated over the true SD, from 0 or far below 1 to where no difference is inside or far above 1
    half = _WIDTH / np.sqrt(2 * df)
    low = max(1 - half, 0.0)
    high = max(min(1 + half, margin_sd / (se * t)), low)
    # s = low + (high - low) u^3: for low = 0 the density starts like s^(df - 1), steep for df below 2
    u = (_NODE + 1) / 2
    s = low + (high - low) * u**3
    reach = margin_sd / se - t * s
    inside = special.ndtr(reach - delta_sd / se) - special.ndtr(-reach - delta_sd / se)
    weight = (high - low) * 3 * u**2 * _WEIGHT / 2
    return float(np.sum(weight * _chi_density(s, df) * np.maximum(inside, 0.0)))


def _chi_density(s: Floats, df: float) -> Floats:
    """Density of chi / sqrt(df) at s > 0."""
    half = df / 2
    with np.errstate(divide="ignore"):
        log_s = np.log(s)
    return np.asarray(2 * np.exp(half * np.log(half) - special.gammaln(half) + (df - 1) * log_s - half * s**2))


def least_for_power(power_of: Callable[[float], float], target: float) -> float:
    """Smallest argument, 0 or more, at which ``power_of``, which rises in it, reaches ``target``. SettingError : a
    target that is no power."""
    _check_target(target)
    if power_of(0.0) >= target:
        return 0.0
    high = 1.0
    while power_of(high) < target:
        high *= 2
    return float(optimize.brentq(lambda at: power_of(at) - target, 0.0, high, xtol=1e-300, rtol=1e-15))


@dataclass(frozen=True)
class PairPower:
    """power : of the test with ``people`` (of each group for "equal-groups"). needed : people for the wanted power, 0
    where it is more than a million. least : smallest effect, or smallest margin, that is found with the wanted power.
    effect, margin : in SDs, as taken."""

    power: float
    needed: int
    least: float
    effect: float
    margin: float


def pair_power(
    design: str, people: int, *, effect: float | None, margin: float | None, alpha: float, target: float
) -> PairPower:
    """Power of a ``design``: "paired" (effect 0.5 unless given), "equal-paired" or "equal-groups" (margin 0.5 and
    effect 0 unless given). SettingError where a number makes no sense."""
    if design == "paired":
        size, within = 0.5 if effect is None else effect, 0.0
        power = power_paired(size, people, alpha)
        needed = fewest_people(lambda n: power_paired(size, n, alpha), target)
        return PairPower(power, needed, least_for_power(lambda x: power_paired(x, people, alpha), target), size, within)
    within, size, two = 0.5 if margin is None else margin, effect or 0.0, design == "equal-groups"

    def equal(margin_sd: float, n: int) -> float:
        return power_tost(margin_sd, n, n if two else None, size, alpha)

    power, needed = equal(within, people), fewest_people(lambda n: equal(within, n), target)
    return PairPower(power, needed, least_for_power(lambda x: equal(x, people), target), size, within)


def _check_target(target: float) -> None:
    if not 0 < target < 1:
        do = "Give such a power."
        raise SettingError("power, target", wanted="a power between 0 and 1", found=str(target), do=do)


def _check(what: str, *asked: tuple[str, Any, str, Any]) -> None:
    """SettingError for the first name whose value is not good: name, whether it is, what is wanted, value."""
    for name, good, wanted, value in asked:
        if not np.all(good):
            raise SettingError(f"{what}, {name}", wanted=wanted, found=str(value), do=f"Give such a value of {name}.")
