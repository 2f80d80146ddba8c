"""Repeated-measures analysis of variance: k treatments on the same people, many designs in one call."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.statistics.moments import shifted_doubles, without_rounding
from emg2vsa.statistics.outcome import Outcome


@dataclass(frozen=True)
class RepeatedAnova:
    """d designs of k treatments; (d,) unless said, NaN where undefined.

    f, df1, df2, p : sphericity assumed. epsilon_gg, epsilon_hf : of Greenhouse and Geisser (1959) and Huynh and Feldt
    (1976), from 1 / (k - 1) to 1; p_gg, p_hf : with both df times epsilon. mauchly_p : sphericity, NaN for k = 2 or
    n < k. eta2_generalised (Olejnik and Algina 2003). n : people without a gap; left_out : the others.
    """

    f: Floats
    df1: int
    df2: Ints
    p: Floats
    epsilon_gg: Floats
    epsilon_hf: Floats
    p_gg: Floats
    p_hf: Floats
    mauchly_p: Floats
    eta2_generalised: Floats
    n: Ints
    left_out: Ints

    def outcome(self, i: int = 0, *, correction: str = "gg") -> Outcome:
        """Design ``i`` alone, df corrected by Greenhouse-Geisser ("gg"), Huynh-Feldt ("hf") or not ("none")."""
        names = {"gg": ", Greenhouse-Geisser", "hf": ", Huynh-Feldt", "none": ", sphericity assumed"}
        epsilon = {"gg": self.epsilon_gg, "hf": self.epsilon_hf, "none": np.ones(self.f.shape)}[correction][i]
        p = {"gg": self.p_gg, "hf": self.p_hf, "none": self.p}[correction][i]
        if np.isinf(self.f[i]):
            epsilon = 1.0  # no scatter to estimate it from
        return Outcome(
            method="repeated-measures ANOVA" + names[correction],
            n=int(self.n[i]),
            statistic_name="F",
            statistic=float(self.f[i]),
            df=(float(self.df1 * epsilon), float(self.df2[i] * epsilon)),
            p=float(p),
            effect_name="generalised eta2",
            effect_size=float(self.eta2_generalised[i]),
            notes=self._notes(i),
        )

    def _notes(self, i: int) -> tuple[str, ...]:
        notes: tuple[str, ...] = (f"{self.left_out[i]} people with a gap left out",) if self.left_out[i] else ()
        if np.isnan(self.f[i]):
            return (*notes, "undefined: needs two people, two treatments and values that differ")
        if np.isinf(self.f[i]):
            return (*notes, "treatments differ by the same amounts in every person: F is infinite")
        return notes


def rm_anova(values: ArrayLike) -> RepeatedAnova:
    """Analysis of ``values`` (d, n people, k treatments), or one design (n, k); people with a NaN are left out.

    An error that rounding alone can make (see `without_rounding`) is 0: F is then infinite, or NaN.
    """
    doubles, _ = shifted_doubles(values)
    complete = np.all(np.isfinite(doubles), axis=2)
    n, k = np.count_nonzero(complete, axis=1), doubles.shape[2]
    y, largest = _scaled(doubles, complete)
    there = complete[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        treatment = np.sum(y, axis=1) / n[:, None]
        person = np.mean(y, axis=2)
        grand = np.mean(treatment, axis=1)
        ss_treatment = n * np.sum((treatment - grand[:, None]) ** 2, axis=1)
        ss_person = k * np.sum((person - grand[:, None]) ** 2, axis=1, where=complete)
        residual = np.where(there, y - treatment[:, None] - person[..., None] + grand[:, None, None], 0.0)
        ss_treatment, ss_person, ss_error = (
            without_rounding(squares, n * k, largest)
            for squares in (ss_treatment, ss_person, np.sum(residual**2, axis=(1, 2)))
        )
        residual = np.where(ss_error[:, None, None] > 0, residual, 0.0)
        df1, df2 = k - 1, (n - 1) * (k - 1)
        f = np.where(df2 > 0, ss_treatment / max(df1, 1) / (ss_error / df2), np.nan)
        gg, hf = _epsilons(residual, n, k)
        w_p = _mauchly(residual, n, k)
        generalised = ss_treatment / (ss_treatment + ss_person + ss_error)

    def p_at(epsilon: Floats | float) -> Floats:
        return np.where(np.isinf(f), 0.0, special.fdtrc(df1 * epsilon, df2 * epsilon, f))

    return RepeatedAnova(f, df1, df2, p_at(1.0), gg, hf, p_at(gg), p_at(hf), w_p, generalised, n, complete.shape[1] - n)


def _scaled(doubles: Floats, complete: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Values relative to the first of their design, scaled to below 1; 0 for people left out. The largest before."""
    filled = np.where(complete[..., None], doubles, 0.0)
    unit = exponent_of(np.max(np.abs(filled), axis=2, initial=0.0))[:, 0] + 1
    filled = np.ldexp(filled, -unit[:, None, None])
    start = np.take_along_axis(filled[..., 0], np.argmax(complete, axis=1)[:, None], axis=1)
    return np.where(complete[..., None], filled - start[..., None], 0.0), np.max(np.abs(filled), axis=(1, 2), initial=0)


def _epsilons(residual: Floats, n: Ints, k: int) -> tuple[Floats, Floats]:
    """From the doubly centred covariance of the treatments: trace^2 over (k - 1) times its sum of squares."""
    covariance = np.swapaxes(residual, 1, 2) @ residual
    trace = np.trace(covariance, axis1=1, axis2=2)
    gg = np.clip(trace**2 / ((k - 1) * np.sum(covariance**2, axis=(1, 2))), 1 / max(k - 1, 1), 1.0)
    hf = (n * (k - 1) * gg - 2) / ((k - 1) * (n - 1 - (k - 1) * gg))
    # with few people the denominator of Huynh and Feldt turns negative: their estimate is then 1
    hf = np.where((n - 1 - (k - 1) * gg) > 0, hf, 1.0)
    return gg, np.where(np.isnan(gg), np.nan, np.clip(hf, gg, 1.0))


def _mauchly(residual: Floats, n: Ints, k: int) -> Floats:
    """p (d,) of Mauchly's (1940) W with the second term of the expansion (Anderson 1958), as R's mauchly.test."""
    if k < 3:
        return np.full(n.shape, np.nan)
    contrasts = np.linalg.qr(np.eye(k) - 1 / k)[0][:, : k - 1]
    free = (n - 1).astype(np.float64)
    projected = residual @ contrasts
    covariance = np.swapaxes(projected, 1, 2) @ projected
    size = np.trace(covariance, axis1=1, axis2=2) / (k - 1)
    enough = (n >= k) & (size > 0)
    w = np.where(enough, np.linalg.det(covariance / np.where(size > 0, size, 1.0)[:, None, None]), np.nan)
    m = k - 1
    rho = 1 - (2 * m**2 + m + 2) / (6 * m * free)
    second = (m + 2) * (m - 1) * (m - 2) * (2 * m**3 + 6 * m**2 + 3 * m + 2) / (288 * (free * m * rho) ** 2)
    df = m * (m + 1) / 2 - 1
    statistic = -free * rho * np.log(w)
    first, later = special.chdtrc(df, statistic), special.chdtrc(df + 4, statistic)
    return np.clip(first + second * (later - first), 0.0, 1.0)
