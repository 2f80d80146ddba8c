"""Power of two treatments: the paired t test that they differ, and two one-sided t tests that they are equal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError
from emg2vsa.statistics.effect_size import noncentral_t
from emg2vsa.statistics.power import fewest_people

_NODE, _WEIGHT = np.polynomial.legendre.leggauss(128)
_WIDTH = 12.0  # standard deviations of the SD that are integrated over
_BISECTIONS = 60


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
    shape = np.broadcast_shapes(*(np.shape(x) for x in (n1, n1 if n2 is None else n2, delta_sd, alpha)))
    return _least(lambda margin: power_tost(margin, n1, n2, delta_sd, alpha), power, shape)


def power_paired(effect_dz: ArrayLike, n: ArrayLike, alpha: ArrayLike = 0.05) -> Floats:
    """Chance that the two-sided paired t test of n people finds a mean difference of ``effect_dz`` SDs of the
    differences; all broadcast. Exact, by the noncentral t. SettingError where a number makes no sense.
    """
    effect, n, level = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (effect_dz, n, alpha)))
    _check_paired(effect, n, level)
    df, shift = n - 1, np.abs(effect) * np.sqrt(n)
    critical = -special.stdtrit(df, level / 2)
    right = 1 - noncentral_t(df, shift, critical)
    wrong_side = noncentral_t(df, -shift, critical)  # P(T' < -critical) at +shift is P(T' > critical) at -shift
    return np.asarray(right + (1 - wrong_side))


def effect_for_power(power: float, n: ArrayLike, alpha: ArrayLike = 0.05) -> Floats:
    """Smallest effect, in SDs of the differences, that the paired t test finds with ``power``."""
    shape = np.broadcast_shapes(np.shape(n), np.shape(alpha))
    return _least(lambda effect: power_paired(effect, n, alpha), power, shape)


def _least(power_of: Callable[[Floats], Floats], power: float, shape: tuple[int, ...]) -> Floats:
    """Smallest argument, 0 or more, at which ``power_of``, which rises in it, reaches ``power``."""
    if not 0 < power < 1:
        raise SettingError("power, target", wanted="a power between 0 and 1", found=str(power), do="Give such a power.")
    high = np.ones(shape)
    while np.any(short := power_of(high) < power):
        high = np.where(short, 2 * high, high)
    low = np.zeros(shape)
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        short = power_of(middle) < power
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
            raise SettingError(
                f"equivalence power, {name}", wanted=wanted, found=str(value), do=f"Give such a value of {name}."
            )


def _check_paired(effect: Floats, n: Floats, alpha: Floats) -> None:
    for name, good, wanted, value in (
        ("effect", np.isfinite(effect), "a finite number", effect),
        ("alpha", (alpha > 0) & (alpha < 1), "a level between 0 and 1", alpha),
        ("n", (n >= 2) & np.isfinite(n), "two people or more", n),
    ):
        if not np.all(good):
            raise SettingError(
                f"paired power, {name}", wanted=wanted, found=str(value), do=f"Give such a value of {name}."
            )


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
        size = 0.5 if effect is None else effect
        power = power_paired(size, people, alpha)
        needed = fewest_people(lambda n: power_paired(size, n, alpha), target)
        return PairPower(float(power), needed, float(effect_for_power(target, people, alpha)), size, 0.0)
    within, size, two = 0.5 if margin is None else margin, effect or 0.0, design == "equal-groups"
    power = power_tost(within, people, people if two else None, size, alpha)
    needed = fewest_people(lambda n: power_tost(within, n, n if two else None, size, alpha), target)
    least = margin_for_power(target, people, people if two else None, size, alpha)
    return PairPower(float(power), needed, float(least), size, within)
