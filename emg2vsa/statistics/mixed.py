"""Mixed model of a study: specimens fixed, participants and their specimens random, with or without gaps.

y = mean of the specimen + participant + participant by specimen + repetition. With equal numbers of repetitions the
restricted likelihood depends on three mean squares only, whose expectations are ordered,

    lambda1 = s2e <= lambda2 = s2e + R s2ps <= lambda3 = s2e + R s2ps + S R s2p,

and it is largest where the mean squares, pooled until they are in that order (weights: their degrees of freedom), are
the lambdas. This is exact also where a variance is zero, the case in which iterative programs fail.

With gaps the variances are those at which the restricted likelihood is largest (`reml`). Degrees of freedom are then
Satterthwaite's, as lmerTest has them (Kuznetsova, Brockhoff and Christensen 2017); intervals of the ratio of standard
deviations come from the profile of the restricted likelihood (`mixed_variances`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of, unmasked
from emg2vsa.errors import DataError
from emg2vsa.statistics.mixed_variances import SOURCES, ratio_interval
from emg2vsa.statistics.moments import finite_or_nan, without_rounding
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import PairDifferences, pair_numbers, student_pairs
from emg2vsa.statistics.reml import METHOD, TINY_STEP, At, Cells, RemlFit, solve

_SAME_DF = 1e-8


@dataclass(frozen=True, eq=False)
class MixedModel:
    """One study of P participants and S specimens, n values, in the unit of the data.

    mean : (S,) of the specimens. variance : (3,) of participants, participants by specimens, repetitions. icc : share
    of participants in the sum of variances. sd_ratio : SD of participants over that of repetitions; ratio_low,
    ratio_high : its interval; interval_of : whose it is. f, df1, df2, p : no difference between specimens, NaN where
    all values are equal. pairs : contrasts of the specimens, (1, q).
    """

    method: str
    mean: Floats
    variance: Floats
    icc: float
    sd_ratio: float
    ratio_low: float
    ratio_high: float
    interval_of: str
    f: float
    df1: int
    df2: float
    p: float
    pairs: PairDifferences
    n: int
    confidence: float

    def outcome(self) -> Outcome:
        """The test of the specimens, with the ratio of standard deviations and its interval."""
        at_zero = [name for name, s2 in zip(SOURCES, self.variance, strict=True) if s2 == 0]
        notes = (f"variance of {' and of '.join(at_zero)} estimated as 0",) if at_zero else ()
        of_ratio = f"interval of the ratio: {self.interval_of}"
        return Outcome(
            method=self.method,
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
            notes=("undefined: all values are equal",) if np.isnan(self.f) else (*notes, of_ratio),
        )


def balanced_mixed(values: ArrayLike, confidence: float = 0.95) -> MixedModel:
    """Fit ``values`` (P, S, R), no gaps, in closed form; P, S, R >= 2, otherwise DataError.

    F is the mean square of specimens over that of participants by specimens, exact whatever the variances. Interval of
    the participants' variance: Graybill and Wang (1980), cut at 0.
    Why in closed form: decision 12.
    """
    y, unit, origin = _checked(values)
    n_p, n_s, n_r = y.shape
    specimen, (*ms, of_specimens), df = _mean_squares(y, abs(float(np.ldexp(origin, -unit))))
    level = _in_order(np.array(ms), df[:3])
    scale = np.array([n_s * n_r, n_r, 1.0])
    variance = np.maximum([level[2] - level[1], level[1] - level[0], level[0]], 0.0) / scale
    constants = _graybill_wang(n_p - 1, int(df[1]), (1 - confidence) / 2)
    ends = np.array(_difference_interval(ms[2], ms[1], constants)) / scale[0]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        f = float(of_specimens / ms[1])
        ratio, low, high = np.sqrt(np.array([variance[0], *ends]) / variance[2])
        icc, of_data = float(variance[0] / np.sum(variance)), np.ldexp(variance, 2 * unit)
        first, second = pair_numbers(n_s)
        difference = np.ldexp(specimen[first] - specimen[second], unit)[None]
        se = np.full(difference.shape, np.ldexp(np.sqrt(2 * ms[1] / (n_p * n_r)), unit))
    freedom, n = np.full(se.shape, float(df[1])), np.full(se.shape, 2 * n_p * n_r)
    return MixedModel(
        method="linear mixed model, balanced, exact REML",
        mean=origin + np.ldexp(specimen, unit),
        variance=of_data,
        icc=icc,
        sd_ratio=float(ratio),
        ratio_low=float(low),
        ratio_high=float(high),
        interval_of="Graybill and Wang's of the participants' variance, SD of repetitions as fixed",
        f=f,
        df1=n_s - 1,
        df2=float(df[1]),
        p=float(special.fdtrc(n_s - 1, df[1], f)),
        pairs=student_pairs("contrast of the linear mixed model", difference, se, freedom, n, n_s, confidence),
        n=y.size,
        confidence=confidence,
    )


def _mean_squares(y: Floats, origin: float) -> tuple[Floats, Floats, Ints]:
    """Means (S,) of specimens; mean squares (4,) of repetitions, participants by specimens, participants, specimens;
    and their degrees of freedom (4,). y : (P, S, R). origin : size of what was subtracted from the data.
    """
    n_p, n_s, n_r = y.shape
    # a cell is centred on its own first value: equal decimals then do not differ by the rounding of their mean
    inner_mean = (y - y[..., :1]).sum(axis=2) / n_r
    cell = y[..., 0] + inner_mean
    specimen, person = cell.sum(axis=0) / n_p, cell.sum(axis=1) / n_s
    grand = specimen.sum() / n_s
    inner = cell - specimen - person[:, None] + grand
    df = np.array([n_p * n_s * (n_r - 1), (n_p - 1) * (n_s - 1), n_p - 1, n_s - 1])
    squares = np.array(
        [
            ((y - y[..., :1] - inner_mean[..., None]) ** 2).sum(),
            n_r * (inner**2).sum(),
            n_s * n_r * ((person - grand) ** 2).sum(),
            n_p * n_r * ((specimen - grand) ** 2).sum(),
        ]
    )
    largest = max(float(np.max(np.abs(y))), origin)
    return specimen, without_rounding(squares, y.size, largest) / df, df


def _checked(values: ArrayLike) -> tuple[Floats, int, float]:
    """Values (P, S, R) relative to their first, scaled to below 1; the binary exponent and the first value."""
    y = finite_or_nan(np.asarray(unmasked(values), dtype=np.float64))
    if y.ndim != 3 or min(y.shape, default=0) < 2 or not np.all(np.isfinite(y)):
        found = "values missing" if y.ndim == 3 and not np.all(np.isfinite(y)) else f"shape {np.shape(values)}"
        raise DataError(
            "balanced mixed model",
            wanted="two or more participants, specimens and repetitions without a gap",
            found=found,
            do="Use the model for unbalanced studies.",
        )
    unit = int(exponent_of(np.max(np.abs(y), axis=(1, 2)))[0]) + 2
    scaled = np.ldexp(y, -unit)
    return scaled - scaled[0, 0, 0], unit, float(y[0, 0, 0])


def _in_order(ms: Floats, df: Ints) -> Floats:
    """Mean squares (3,) pooled by their df until they do not fall: isotonic regression of three values."""
    a, b, c = ms
    ab = (df[0] * a + df[1] * b) / (df[0] + df[1])
    bc = (df[1] * b + df[2] * c) / (df[1] + df[2])
    abc = (df[0] * a + df[1] * b + df[2] * c) / np.sum(df)
    return np.array([min(a, ab, abc), max(min(b, bc), min(ab, abc)), max(c, bc, abc)])


def _difference_interval(upper: float, lower: float, constants: tuple[float, ...]) -> tuple[float, float]:
    """Graybill and Wang's interval of E(upper) - E(lower), two independent mean squares; cut at 0."""
    g1, h2, g12, h1, g2, h12 = constants
    below = np.sqrt(max((g1 * upper) ** 2 + (h2 * lower) ** 2 + g12 * upper * lower, 0.0))
    above = np.sqrt(max((h1 * upper) ** 2 + (g2 * lower) ** 2 + h12 * upper * lower, 0.0))
    return max(upper - lower - below, 0.0), max(upper - lower + above, 0.0)


def _graybill_wang(df1: int, df2: int, tail: float) -> tuple[float, ...]:
    """Constants of the interval of a difference of mean squares with df1 and df2 degrees of freedom."""
    low1, high1 = (special.chdtri(df1, 1 - p) / df1 for p in (tail, 1 - tail))
    low2, high2 = (special.chdtri(df2, 1 - p) / df2 for p in (tail, 1 - tail))
    at_low, at_high = special.fdtri(df1, df2, tail), special.fdtri(df1, df2, 1 - tail)
    g1, h2, h1, g2 = 1 - 1 / high1, 1 / low2 - 1, 1 / low1 - 1, 1 - 1 / high2
    g12 = ((at_high - 1) ** 2 - g1**2 * at_high**2 - h2**2) / at_high
    h12 = ((1 - at_low) ** 2 - h1**2 * at_low**2 - g2**2) / at_low
    return tuple(float(constant) for constant in (g1, h2, g12, h1, g2, h12))


def unbalanced_mixed(fit: RemlFit, confidence: float = 0.95) -> MixedModel:
    """The model of a study, with or without gaps, from where its restricted likelihood is largest."""
    cells, ratios, at, error, unit = fit.cells, fit.ratios, fit.at, fit.error, fit.unit
    df_of = _satterthwaite(cells, ratios, at, error)
    s = cells.count.shape[1]
    f, df2 = _specimens_differ(_successive(cells.count.sum(axis=0)), at.beta, error * at.inverse, df_of)
    variance = error * np.array([*ratios, 1.0])
    low, high = ratio_interval(cells, ratios, confidence)
    return MixedModel(
        method=METHOD,
        mean=fit.origin + np.ldexp(at.beta, unit),
        variance=np.ldexp(variance, 2 * unit),
        icc=float(variance[0] / variance.sum()),
        sd_ratio=float(np.sqrt(ratios[0])),
        ratio_low=low,
        ratio_high=high,
        interval_of="profile of the restricted likelihood",
        f=f,
        df1=s - 1,
        df2=df2,
        p=float(special.fdtrc(s - 1, df2, f)),
        pairs=_pairs(cells, at.beta, error * at.inverse, df_of, unit, confidence),
        n=cells.n,
        confidence=confidence,
    )


def _satterthwaite(cells: Cells, ratios: Floats, at: At, error: float) -> Callable[[Floats], float]:
    """Degrees of freedom of a contrast of the means: 2 E^2 / Var of its estimated variance, from the curvature of the
    likelihood along the ratios above 0 and the logarithm of the variance of repetitions."""
    above = np.flatnonzero(ratios > 0)
    # the model a tiny imaginary step along each of these ratios
    beside = [solve(cells, *(ratios + 1j * TINY_STEP * along)) for along in np.eye(2)[above]]
    curvature = np.empty((above.size + 1, above.size + 1))
    curvature[-1, -1] = cells.free
    curvature[:-1, -1] = curvature[-1, :-1] = -at.residual_slopes[above] / error
    for column, other in enumerate(beside):
        both = (other.residual_slopes / error + other.log_slopes).imag / TINY_STEP
        curvature[:-1, column] = both[above]
    of_parameters = 2 * np.linalg.inv(curvature)
    # without a variance of participants by specimens all repetitions would count as independent
    people, specimens = cells.count.shape
    interaction = np.count_nonzero(cells.count) - people - specimens + 1
    most = float(interaction) if not ratios[1] > 0 and interaction > 0 else np.inf
    steps = [error * other.inverse.imag / TINY_STEP for other in beside]

    def df_of(contrast: Floats) -> float:
        variance = error * contrast @ at.inverse @ contrast
        slopes = np.array([*(contrast @ step @ contrast for step in steps), variance])
        return min(float(2 * variance**2 / (slopes @ of_parameters @ slopes)), most)

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
