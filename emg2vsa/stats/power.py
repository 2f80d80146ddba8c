"""Power: what a design can find before it is run.

Of the repeated-measures F test within one group of people (the computation behind n = 14), and of two one-sided t tests
of equality.
"""

from __future__ import annotations

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
"""What the paper's sample size means (statistics notes 2)."""
_MOST_PEOPLE = 1_000_000
_NO_EFFECT = 1e-13
_NODE, _WEIGHT = np.polynomial.legendre.leggauss(128)
_WIDTH = 12.0  # standard deviations of the SD that are integrated over
_BISECTIONS = 60


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

    if not 0 < power < 1:
        raise SettingError("power, target", wanted="a power between 0 and 1", found=str(power), do="Change it.")

    def enough(n: int) -> bool:
        return bool(power_rm(n, m, f, rho, epsilon, alpha, convention) >= power)

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
        ("f", f >= 0, "an effect size of 0 or more", f),
        ("rho", (rho >= 0) & (rho < 1), "a correlation from 0 to below 1", rho),
        ("epsilon", (epsilon >= lowest - 1e-12) & (epsilon <= 1), "1 / (m - 1) to 1", epsilon),
        ("alpha", (alpha > 0) & (alpha < 1), "a level between 0 and 1", alpha),
    ):
        if not np.all(good):
            raise SettingError(f"power, {name}", wanted=wanted, found=str(value), do="Change it.")


def power_tost(
    margin_sd: ArrayLike, n1: ArrayLike, n2: ArrayLike | None = None, delta_sd: ArrayLike = 0.0, alpha: ArrayLike = 0.05
) -> Floats:
    """Chance that equivalence within ``margin_sd`` is found where the true difference is ``delta_sd``; all broadcast.

    Both in true SDs: of each group for two samples of n1 and n2 (pooled variance), of the differences or the values for
    n2 None (paired, one sample). Exact: both tests reject where |difference| < margin - t(1 - alpha) SE, normal given
    the SD, and that is integrated over the chi law of the SD. SettingError where a number makes no sense.
    """
    margin, delta, level = (np.asarray(x, dtype=np.float64) for x in (margin_sd, delta_sd, alpha))
    a, b = np.asarray(n1, dtype=np.float64), np.asarray(np.inf if n2 is None else n2, dtype=np.float64)
    df = a - 1 if n2 is None else a + b - 2
    _check_tost(margin, delta, level, a, b, df)
    se = np.sqrt(1 / a + 1 / b)
    margin, delta, level, df, se = (x[..., None] for x in np.broadcast_arrays(margin, delta, level, df, se))
    t = special.stdtrit(df, 1 - level)
    # s, the estimated over the true SD, from 0 or far below 1 to where no difference is inside or far above 1
    half = _WIDTH / np.sqrt(2 * df)
    low = np.maximum(1 - half, 0.0)
    high = np.maximum(np.minimum(1 + half, margin / (se * t)), low)
    # s = low + (high - low) u^3: for low = 0 the density starts like s^(df - 1), steep for df below 2
    u = (_NODE + 1) / 2
    s = low + (high - low) * u**3
    reach = margin / se - t * s
    inside = special.ndtr(reach - delta / se) - special.ndtr(-reach - delta / se)
    weight = (high - low) * 3 * u**2 * _WEIGHT / 2
    return np.asarray(np.sum(weight * _chi_density(s, df) * np.maximum(inside, 0.0), axis=-1))


def margin_for_power(
    power: float, n1: ArrayLike, n2: ArrayLike | None = None, delta_sd: ArrayLike = 0.0, alpha: ArrayLike = 0.05
) -> Floats:
    """Smallest margin, in SDs, within which a design finds equivalence with ``power``; arguments as ``power_tost``."""
    if not 0 < power < 1:
        raise SettingError("equivalence, power", wanted="a power between 0 and 1", found=str(power), do="Change it.")
    shape = np.broadcast_shapes(*(np.shape(x) for x in (n1, n1 if n2 is None else n2, delta_sd, alpha)))
    high = np.ones(shape)
    while np.any(short := power_tost(high, n1, n2, delta_sd, alpha) < power):
        high = np.where(short, 2 * high, high)
    low = np.zeros(shape)
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        short = power_tost(middle, n1, n2, delta_sd, alpha) < power
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return np.asarray(high)


def _chi_density(s: Floats, df: Floats) -> Floats:
    """Density of chi / sqrt(df) at s > 0."""
    half = df / 2
    with np.errstate(divide="ignore"):
        log_s = np.log(s)
    return np.asarray(2 * np.exp(half * np.log(half) - special.gammaln(half) + (df - 1) * log_s - half * s**2))


def _check_tost(margin: Floats, delta: Floats, alpha: Floats, n1: Floats, n2: Floats, df: Floats) -> None:
    for name, good, wanted, value in (
        ("margin", (margin >= 0) & np.isfinite(margin), "a margin of 0 or more", margin),
        ("difference", np.isfinite(delta), "a finite number", delta),
        ("alpha", (alpha > 0) & (alpha < 0.5), "a level between 0 and 1/2", alpha),
        ("n", (n1 >= 1) & (n2 >= 1) & (df >= 1), "one degree of freedom or more", df),
    ):
        if not np.all(good):
            raise SettingError(f"equivalence power, {name}", wanted=wanted, found=str(value), do="Change it.")
