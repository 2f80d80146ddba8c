"""Mixed model of a study with gaps: means of the specimens, their differences, and the variances between people.

The variances are those at which the restricted likelihood is largest (`reml`). Degrees of freedom are Satterthwaite's,
as lmerTest has them (Kuznetsova, Brockhoff and Christensen 2017); intervals of the ratio of standard deviations come
from the profile of the restricted likelihood (`mixed_variances`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.statistics.mixed_variances import ratio_interval
from emg2vsa.statistics.moments import unmasked
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import PairDifferences, pair_numbers, student_pairs
from emg2vsa.statistics.reml import LARGEST, TINY_STEP, At, Cells, best_ratios, cells_of, solve

METHOD = "linear mixed model, REML, Satterthwaite df"
_SAME_DF = 1e-8


@dataclass(frozen=True, eq=False)
class UnbalancedMixed:
    """One study of P participants and S specimens, n values, in the unit of the data.

    mean : (S,) of the specimens. covariance : (S, S) of those means. variance : (3,) of participants, participants by
    specimens, repetitions. sd_ratio : SD of participants over that of repetitions, ratio_low, ratio_high its interval.
    icc : share of participants in the sum of variances. f, df1, df2, p : no difference between specimens.
    pairs : differences of specimens. minus_2_reml : -2 log of the restricted likelihood of the data.
    """

    mean: Floats
    covariance: Floats
    variance: Floats
    sd_ratio: float
    ratio_low: float
    ratio_high: float
    icc: float
    f: float
    df1: int
    df2: float
    p: float
    pairs: PairDifferences
    minus_2_reml: float
    n: int
    confidence: float

    def outcome(self) -> Outcome:
        """The test of the specimens, with the ratio of standard deviations and its interval."""
        names = ("participants", "participants by specimens")
        at_zero = [name for name, s2 in zip(names, self.variance, strict=False) if s2 == 0]
        return Outcome(
            method=METHOD,
            n=self.n,
            statistic_name="F",
            statistic=self.f,
            df=(float(self.df1), self.df2),
            p=self.p,
            estimate_name="SD of participants / SD of repetitions",
            estimate=self.sd_ratio,
            interval=(self.ratio_low, self.ratio_high),
            confidence=self.confidence,
            effect_name="ICC of participants",
            effect_size=self.icc,
            notes=(
                *((f"variance of {' and of '.join(at_zero)} estimated as 0",) if at_zero else ()),
                "interval of the ratio: profile of the restricted likelihood",
            ),
        )


def unbalanced_mixed(values: Floats, confidence: float = 0.95) -> UnbalancedMixed | Outcome:
    """Fit ``values`` (P participants, S specimens, R repetitions), NaN where there is none.

    An `Outcome` without numbers, with the reason, where the study cannot bear the model: fewer than two participants
    or specimens, a specimen without values, no cell with two values, or values that do not differ within cells, or
    next to nothing beside what people differ.
    """
    cells, origin, unit, why = cells_of(np.asarray(unmasked(values), dtype=np.float64))
    ratios = np.zeros(2) if why else best_ratios(cells)
    if ratios.max() >= LARGEST:
        why = "undefined: repetitions differ more than a million times less than participants"
    if why:
        return Outcome(method=METHOD, n=cells.n, statistic_name="F", statistic=np.nan, p=np.nan, notes=(why,))
    return _described(cells, ratios, origin, unit, confidence)


def _beside(cells: Cells, ratios: Floats) -> list[At]:
    """The model a tiny imaginary step along each ratio."""
    return [solve(cells, *(ratios + 1j * TINY_STEP * along)) for along in np.eye(2)]


def _described(cells: Cells, ratios: Floats, origin: float, unit: int, confidence: float) -> UnbalancedMixed:
    at, free = solve(cells, *ratios), cells.free
    error = float(at.residual_squares) / free
    df_of = _satterthwaite(cells, ratios, at, error)
    s = cells.count.shape[1]
    others = _successive(cells.count.sum(axis=0))
    f, df2 = _specimens_differ(others, at.beta, error * at.inverse, df_of)
    variance = error * np.array([*ratios, 1.0])
    low, high = ratio_interval(cells, ratios, confidence)
    return UnbalancedMixed(
        mean=origin + np.ldexp(at.beta, unit),
        covariance=np.ldexp(error * at.inverse, 2 * unit),
        variance=np.ldexp(variance, 2 * unit),
        sd_ratio=float(np.sqrt(ratios[0])),
        ratio_low=low,
        ratio_high=high,
        icc=float(variance[0] / variance.sum()),
        f=f,
        df1=s - 1,
        df2=df2,
        p=float(special.fdtrc(s - 1, df2, f)),
        pairs=_pairs(cells, at.beta, error * at.inverse, df_of, unit, confidence),
        minus_2_reml=float(at.deviance(free)) + free * (1 + np.log(2 * np.pi) + 2 * unit * np.log(2)),
        n=cells.n,
        confidence=confidence,
    )


def _satterthwaite(cells: Cells, ratios: Floats, at: At, error: float) -> Callable[[Floats], float]:
    """Degrees of freedom of a contrast of the means: 2 E^2 / Var of its estimated variance, from the curvature of the
    likelihood along the ratios above 0 and the logarithm of the variance of repetitions."""
    above = np.flatnonzero(ratios > 0)
    beside = [at_other for at_other, ratio in zip(_beside(cells, ratios), ratios, strict=True) if ratio > 0]
    curvature = np.empty((above.size + 1, above.size + 1))
    curvature[-1, -1] = cells.free
    curvature[:-1, -1] = curvature[-1, :-1] = -at.residual_slopes[above] / error
    for column, other in enumerate(beside):
        both = (other.residual_slopes / error + other.log_slopes).imag / TINY_STEP
        curvature[:-1, column] = both[above]
    of_parameters = 2 * np.linalg.inv(curvature)
    steps = [error * other.inverse.imag / TINY_STEP for other in beside]

    def df_of(contrast: Floats) -> float:
        variance = error * contrast @ at.inverse @ contrast
        slopes = np.array([*(contrast @ step @ contrast for step in steps), variance])
        return float(2 * variance**2 / (slopes @ of_parameters @ slopes))

    return df_of


def _successive(count: Floats) -> Floats:
    """The contrasts (S - 1, S) that lmerTest's anova() takes of specimens with ``count`` (S,) values.

    They are those of type I: the rows below the intercept of the unit triangle of X'X (Goodnight 1978), X with the
    first specimen as its reference.
    """
    from_first = np.eye(count.size)[1:] - np.eye(count.size)[0]
    crossed = np.diag(np.concatenate([[count.sum()], count[1:]]))
    crossed[0, 1:] = crossed[1:, 0] = count[1:]
    lower = np.linalg.cholesky(crossed)
    return np.asarray((lower / np.diag(lower)).T[1:, 1:] @ from_first)


def _specimens_differ(
    contrasts: Floats, mean: Floats, covariance: Floats, df_of: Callable[[Floats], float]
) -> tuple[float, float]:
    """Wald's F of all ``contrasts`` (q, S) at once and its second df (Fai and Cornelius 1996).

    F is the same whichever contrasts say "no difference". The df is not: see `_successive`.
    """
    values, vectors = np.linalg.eigh(contrasts @ covariance @ contrasts.T)
    independent = vectors.T @ contrasts
    f = float(np.mean((independent @ mean) ** 2 / values))
    df = np.array([df_of(contrast) for contrast in independent])
    if np.ptp(df) < _SAME_DF:
        return f, float(np.mean(df))
    if np.any(df <= 2):
        return f, 2.0
    expected = float(np.sum(df / (df - 2)))
    return f, 2 * expected / (expected - df.size)


def _pairs(
    cells: Cells, mean: Floats, covariance: Floats, df_of: Callable[[Floats], float], unit: int, confidence: float
) -> PairDifferences:
    first, second = pair_numbers(mean.size)
    contrasts = np.eye(mean.size)[first] - np.eye(mean.size)[second]
    se = np.sqrt(np.einsum("qs,st,qt->q", contrasts, covariance, contrasts))
    per_specimen = cells.count.sum(axis=0).astype(np.int64)
    return student_pairs(
        "contrast of the linear mixed model, Satterthwaite df",
        np.ldexp(contrasts @ mean, unit)[None],
        np.ldexp(se, unit)[None],
        np.array([[df_of(contrast) for contrast in contrasts]]),
        (per_specimen[first] + per_specimen[second])[None],
        mean.size,
        confidence,
    )
