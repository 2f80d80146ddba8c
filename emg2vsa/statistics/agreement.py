"""Intraclass correlations: how well repeated ratings, or repetitions, of the same subjects agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.moments import group_moments, shifted_doubles, without_rounding
from emg2vsa.statistics.outcome import Outcome

KINDS = ("ICC(1,1)", "ICC(2,1)", "ICC(3,1)", "ICC(1,k)", "ICC(2,k)", "ICC(3,k)")
"""1: every subject has raters of its own. 2: the same raters, drawn from many, absolute agreement. 3: the same raters,
these alone, consistency. (., 1) of a single rating, (., k) of the mean of all k."""


@dataclass(frozen=True)
class IntraclassCorrelations:
    """Of d designs, in the order of KINDS: value, low, high at ``confidence``, f, df1, df2, p : (d, 6), NaN: undefined.

    f, p : of the hypothesis that the correlation is 0. n : (d,) subjects without a gap; left_out : (d,) the others.
    """

    value: Floats
    low: Floats
    high: Floats
    f: Floats
    df1: Floats
    df2: Floats
    p: Floats
    n: Ints
    left_out: Ints
    k: int
    confidence: float

    def outcome(self, i: int = 0, kind: str = "ICC(2,1)") -> Outcome:
        """One coefficient of design ``i`` alone; n counts ratings."""
        at = (i, KINDS.index(kind))
        notes: tuple[str, ...] = (f"subjects with a gap, left out: {self.left_out[i]}",) if self.left_out[i] else ()
        if np.isnan(self.value[at]):
            notes += ("undefined: needs two subjects, two ratings each, and ratings that differ",)
        elif self.value[at] < 0:
            notes += ("negative: subjects differ less than the ratings of one subject do",)
        return Outcome(
            method=f"intraclass correlation {kind}",
            n=int(self.n[i]) * self.k,
            statistic_name="F",
            statistic=float(self.f[at]),
            df=(float(self.df1[at]), float(self.df2[at])),
            p=float(self.p[at]),
            estimate_name=kind,
            estimate=float(self.value[at]),
            interval=(float(self.low[at]), float(self.high[at])),
            confidence=self.confidence,
            notes=notes,
        )


@dataclass(frozen=True)
class _MeanSquares:
    """(d,) each: between subjects, within them, between raters, residual; n subjects, k raters."""

    subjects: Floats
    within: Floats
    raters: Floats
    error: Floats
    n: Floats
    k: int


def icc(values: ArrayLike, confidence: float = 0.95) -> IntraclassCorrelations:
    """The six coefficients of Shrout and Fleiss (1979) of ``values`` (d, n subjects, k ratings each), or one (n, k).

    Subjects with a NaN are left out. Intervals are theirs, for ICC(2, .) with the df of McGraw and Wong (1996). Ratings
    that agree wholly give 1, ratings all equal are undefined. DataError for another shape.
    """
    doubles, _ = shifted_doubles(values)
    complete = np.all(np.isfinite(doubles), axis=2)
    n = np.count_nonzero(complete, axis=1)
    k = doubles.shape[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        ms = _mean_squares(np.where(complete[..., None], doubles, np.nan), n, k)
        f, df2 = _tests(ms)
        value, low, high = _coefficients(ms, f, df2, confidence)
    df1 = np.broadcast_to(ms.n[:, None] - 1, f.shape)
    p = np.asarray(special.fdtrc(df1, df2, f), dtype=np.float64)
    return IntraclassCorrelations(value, low, high, f, df1, df2, p, n, complete.shape[1] - n, k, confidence)


def _mean_squares(values: Floats, n: Ints, k: int) -> _MeanSquares:
    """Two-way, in a unit of the design's own; n NaN where nothing can be estimated."""
    groups = group_moments(values)
    subjects = np.where((n > 1) & (k > 1), n, np.nan)
    there = groups.count > 0
    mean = np.sum(groups.offset, axis=1) / subjects
    between = k * np.sum((groups.offset - mean[:, None]) ** 2, axis=1, where=there)
    rater = np.sum(groups.deviation, axis=1) / subjects[:, None]
    residual = groups.deviation - rater[:, None]
    largest = np.ldexp(np.nanmax(np.abs(values), axis=(1, 2), initial=0.0), -groups.unit)
    between, error, within, raters = (
        without_rounding(squares, n * k, largest)
        for squares in (
            between,
            np.sum(residual**2, axis=(1, 2), where=groups.valid),
            np.sum(groups.squares, axis=1),
            subjects * np.sum(rater**2, axis=1),
        )
    )
    return _MeanSquares(
        subjects=between / (subjects - 1),
        within=within / (subjects * (k - 1)),
        raters=raters / (k - 1),
        error=error / ((subjects - 1) * (k - 1)),
        n=subjects,
        k=k,
    )


def _tests(ms: _MeanSquares) -> tuple[Floats, Floats]:
    """F and its second df, (d, 6), in the order of KINDS."""
    one_way, two_way = ms.subjects / ms.within, ms.subjects / ms.error
    df_one_way, df_two_way = ms.n * (ms.k - 1), (ms.n - 1) * (ms.k - 1)
    f = np.stack([one_way, two_way, two_way] * 2, axis=1)
    return f, np.stack([df_one_way, df_two_way, df_two_way] * 2, axis=1)


def _coefficients(ms: _MeanSquares, f: Floats, df2: Floats, confidence: float) -> tuple[Floats, Floats, Floats]:
    """Value, low and high (d, 6); those of a mean follow from those of a single rating (Spearman and Brown)."""
    k, tail = ms.k, (1 - confidence) / 2
    df1 = (ms.n - 1)[:, None]
    at_low = f[:, :3] / special.fdtri(df1, df2[:, :3], 1 - tail)
    at_high = f[:, :3] * special.fdtri(df2[:, :3], df1, 1 - tail)
    single, low, high = (_of_f(x, k) for x in (f[:, :3], at_low, at_high))
    single[:, 1] = _absolute(ms.subjects, ms.raters, ms.error, ms.n, k)
    low[:, 1], high[:, 1] = _absolute_interval(ms, single[:, 1], tail)
    value, low, high = (np.concatenate([x, _of_mean(x, k)], axis=1) for x in (single, low, high))
    return value, low, high


def _of_f(f: Floats, k: int) -> Floats:
    return np.asarray(np.where(np.isinf(f), 1.0, (f - 1) / (f + k - 1)))


def _of_mean(single: Floats, k: int) -> Floats:
    shared = 1 + (k - 1) * single
    return np.asarray(np.where(shared <= 0, -np.inf, k * single / shared))


def _absolute(subjects: Floats, raters: Floats, error: Floats, n: Floats, k: int) -> Floats:
    return np.asarray((subjects - error) / (subjects + (k - 1) * error + k * (raters - error) / n))


def _absolute_interval(ms: _MeanSquares, value: Floats, tail: float) -> tuple[Floats, Floats]:
    """Satterthwaite's df for the mixture of raters and error in the denominator of ICC(2, 1)."""
    n, k = ms.n, ms.k
    lack = n * (1 - value)
    a, b = k * value / lack, 1 + k * value * (n - 1) / lack
    mixed = a * ms.raters + b * ms.error
    df = mixed**2 / ((a * ms.raters) ** 2 / (k - 1) + (b * ms.error) ** 2 / ((n - 1) * (k - 1)))
    upper, lower = special.fdtri(n - 1, df, 1 - tail), special.fdtri(df, n - 1, 1 - tail)
    noise = k * ms.raters + (k * n - k - n) * ms.error
    low = n * (ms.subjects - upper * ms.error) / (upper * noise + n * ms.subjects)
    high = n * (lower * ms.subjects - ms.error) / (noise + n * lower * ms.subjects)
    whole = value == 1
    return np.where(whole, 1.0, low), np.where(whole, 1.0, high)
