"""Mixed model of a balanced study in closed form: specimens fixed, participants and their specimens random.

y = mean of the specimen + participant + participant by specimen + repetition. With equal numbers of repetitions the
restricted likelihood depends on three mean squares only, whose expectations are ordered,

    lambda1 = s2e <= lambda2 = s2e + R s2ps <= lambda3 = s2e + R s2ps + S R s2p,

and it is largest where the mean squares, pooled until they are in that order (weights: their degrees of freedom), are
the lambdas. This is exact also where a variance is zero, the case in which iterative programs fail.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.errors import DataError
from emg2vsa.statistics.moments import unmasked, without_rounding
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import PairDifferences, pair_numbers, student_pairs


@dataclass(frozen=True)
class MixedModel:
    """d studies of P participants, S specimens, R repetitions; (d,) unless said, in the unit of the data.

    mean : (d, S). f, df1, df2, p : no
    difference between specimens, mean square of specimens over that of participants by specimens, exact whatever the
    variances. variance : (d, 3) of participants, participants by specimens, repetitions; low, high : (d, 3) their
    intervals. icc : share of participants in the sum of variances. sd_ratio : (d,) SD of participants over that of
    repetitions, ratio_low, ratio_high its interval. difference : (d, q) of the means of all pairs of specimens,
    se_difference : (d,) their standard error.
    """

    mean: Floats
    f: Floats
    df1: int
    df2: int
    p: Floats
    variance: Floats
    low: Floats
    high: Floats
    icc: Floats
    sd_ratio: Floats
    ratio_low: Floats
    ratio_high: Floats
    difference: Floats
    se_difference: Floats
    n: int
    confidence: float

    def pairs(self) -> PairDifferences:
        """Contrasts of the specimens, with the mean square of participants by specimens as their error, as f has it."""
        shape, k = self.difference.shape, self.mean.shape[1]
        return student_pairs(
            "contrast of the linear mixed model",
            self.difference,
            np.broadcast_to(self.se_difference[:, None], shape),
            np.full(shape, float(self.df2)),
            np.full(shape, 2 * (self.n // k)),
            k,
            self.confidence,
        )

    def outcome(self, i: int = 0) -> Outcome:
        at_zero = [name for name, s2 in zip(_RANDOM, self.variance[i], strict=True) if s2 == 0]
        notes = (f"variance of {' and of '.join(at_zero)} estimated as 0",) if at_zero else ()
        of_ratio = (
            "interval of the ratio: Graybill and Wang's of the participants' variance, SD of repetitions as fixed"
        )
        return Outcome(
            method="linear mixed model, balanced, exact REML",
            n=self.n,
            statistic_name="F",
            statistic=float(self.f[i]),
            df=(float(self.df1), float(self.df2)),
            p=float(self.p[i]),
            estimate_name="SD of participants / SD of repetitions",
            estimate=float(self.sd_ratio[i]),
            interval=(float(self.ratio_low[i]), float(self.ratio_high[i])),
            confidence=self.confidence,
            effect_name="ICC of participants",
            effect_size=float(self.icc[i]),
            notes=("undefined: all values are equal",) if np.isnan(self.f[i]) else (*notes, of_ratio),
        )


_RANDOM = ("participants", "participants by specimens", "repetitions")


def balanced_mixed(values: ArrayLike, confidence: float = 0.95) -> MixedModel:
    """Fit ``values`` (d, P, S, R), or one study (P, S, R), no gaps; P, S, R >= 2, otherwise DataError.

    Intervals of the two upper variances: Graybill and Wang (1980), cut at 0; that of the repetitions is exact.
    """
    y, unit, origin = _checked(values)
    n_p, n_s, n_r = y.shape[1:]
    # a cell is centred on its own first value: equal decimals then do not differ by the rounding of their mean
    inner_mean = (y - y[..., :1]).sum(axis=3) / n_r
    cell = y[..., 0] + inner_mean
    specimen, person = cell.sum(axis=1) / n_p, cell.sum(axis=2) / n_s
    grand = specimen.sum(axis=1) / n_s
    ms_specimen = n_p * n_r * ((specimen - grand[:, None]) ** 2).sum(axis=1) / (n_s - 1)
    inner = cell - specimen[:, None] - person[..., None] + grand[:, None, None]
    df = np.array([n_p * n_s * (n_r - 1), (n_p - 1) * (n_s - 1), n_p - 1])
    squares = np.stack(
        [
            ((y - y[..., :1] - inner_mean[..., None]) ** 2).sum(axis=(1, 2, 3)),
            n_r * (inner**2).sum(axis=(1, 2)),
            n_s * n_r * ((person - grand[:, None]) ** 2).sum(axis=1),
        ],
        axis=1,
    )
    n, largest = n_p * n_s * n_r, np.max(np.abs(y), axis=(1, 2, 3))
    largest = np.fmax(largest, np.abs(np.ldexp(origin, -unit)))
    ms = without_rounding(squares, n, largest[:, None]) / df
    ms_specimen = without_rounding(ms_specimen * (n_s - 1), n, largest) / (n_s - 1)
    level = _in_order(ms, df)
    with np.errstate(divide="ignore", invalid="ignore"):
        f = ms_specimen / ms[:, 1]
    scale = np.array([n_s * n_r, n_r, 1.0])
    steps = np.stack([level[:, 2] - level[:, 1], level[:, 1] - level[:, 0], level[:, 0]], axis=1)
    variance = np.maximum(steps, 0.0) / scale
    low, high = _variance_intervals(ms, df, scale, confidence)
    with np.errstate(divide="ignore", invalid="ignore"):
        total = np.sum(variance, axis=1)
        ratios = [np.sqrt(v / variance[:, 2]) for v in (variance[:, 0], low[:, 0], high[:, 0])]
        icc = variance[:, 0] / total
    with np.errstate(over="ignore"):
        of_data = [np.ldexp(v, 2 * unit[:, None]) for v in (variance, low, high)]
    first, second = pair_numbers(n_s)
    with np.errstate(over="ignore"):
        difference = np.ldexp(specimen[:, first] - specimen[:, second], unit[:, None])
        se_difference = np.ldexp(np.sqrt(2 * ms[:, 1] / (n_p * n_r)), unit)
    return MixedModel(
        mean=origin[:, None] + np.ldexp(specimen, unit[:, None]),
        f=f,
        df1=n_s - 1,
        df2=int(df[1]),
        p=special.fdtrc(n_s - 1, df[1], f),
        variance=of_data[0],
        low=of_data[1],
        high=of_data[2],
        icc=icc,
        sd_ratio=ratios[0],
        ratio_low=ratios[1],
        ratio_high=ratios[2],
        difference=difference,
        se_difference=se_difference,
        n=n,
        confidence=confidence,
    )


def _checked(values: ArrayLike) -> tuple[Floats, np.ndarray, Floats]:
    """Values (d, P, S, R) relative to their first, scaled to below 1; binary exponents and first values (d,)."""
    y = np.asarray(unmasked(values), dtype=np.float64)
    y = y[None] if y.ndim == 3 else y
    if y.ndim != 4 or min(y.shape[1:], default=0) < 2 or not np.all(np.isfinite(y)):
        found = "values missing" if y.ndim == 4 and not np.all(np.isfinite(y)) else f"shape {np.shape(values)}"
        raise DataError(
            "balanced mixed model",
            wanted="two or more participants, specimens and repetitions without a gap",
            found=found,
            do="Use the model for unbalanced studies.",
        )
    origin = y[:, 0, 0, 0]
    unit = exponent_of(np.max(np.abs(y), axis=(2, 3)))[:, 0] + 2
    scaled = np.ldexp(y, -unit[:, None, None, None])
    return scaled - scaled[:, :1, :1, :1], unit, origin


def _in_order(ms: Floats, df: Ints) -> Floats:
    """Mean squares (d, 3) pooled by their df until they do not fall: isotonic regression of three values."""
    a, b, c = ms.T
    ab = (df[0] * a + df[1] * b) / (df[0] + df[1])
    bc = (df[1] * b + df[2] * c) / (df[1] + df[2])
    abc = (df[0] * a + df[1] * b + df[2] * c) / np.sum(df)
    first = np.minimum(np.minimum(a, ab), abc)
    last = np.maximum(np.maximum(c, bc), abc)
    middle = np.maximum(np.minimum(b, bc), np.minimum(ab, abc))
    return np.stack([first, middle, last], axis=1)


def _variance_intervals(ms: Floats, df: Ints, scale: Floats, confidence: float) -> tuple[Floats, Floats]:
    """(d, 3) intervals of the variances of participants, participants by specimens, repetitions."""
    tail = (1 - confidence) / 2
    quantiles = special.chdtri(df[0], [tail, 1 - tail])
    error_low, error_high = df[0] * ms[:, 0] / quantiles[0], df[0] * ms[:, 0] / quantiles[1]
    ends = [
        _difference_interval(ms[:, i], ms[:, i - 1], _graybill_wang(int(df[i]), int(df[i - 1]), tail)) for i in (2, 1)
    ]
    low = np.stack([ends[0][0], ends[1][0], error_low], axis=1) / scale
    high = np.stack([ends[0][1], ends[1][1], error_high], axis=1) / scale
    return low, high


def _difference_interval(upper: Floats, lower: Floats, constants: tuple[float, ...]) -> tuple[Floats, Floats]:
    """Graybill and Wang's interval of E(upper) - E(lower), two independent mean squares; cut at 0."""
    g1, h2, g12, h1, g2, h12 = constants
    below = np.sqrt(np.maximum((g1 * upper) ** 2 + (h2 * lower) ** 2 + g12 * upper * lower, 0.0))
    above = np.sqrt(np.maximum((h1 * upper) ** 2 + (g2 * lower) ** 2 + h12 * upper * lower, 0.0))
    return np.maximum(upper - lower - below, 0.0), np.maximum(upper - lower + above, 0.0)


@cache
def _graybill_wang(df1: int, df2: int, tail: float) -> tuple[float, ...]:
    """Constants of the interval of a difference of mean squares with df1 and df2 degrees of freedom."""
    low1, high1 = (special.chdtri(df1, 1 - p) / df1 for p in (tail, 1 - tail))
    low2, high2 = (special.chdtri(df2, 1 - p) / df2 for p in (tail, 1 - tail))
    at_low, at_high = special.fdtri(df1, df2, tail), special.fdtri(df1, df2, 1 - tail)
    g1, h2, h1, g2 = 1 - 1 / high1, 1 / low2 - 1, 1 / low1 - 1, 1 - 1 / high2
    g12 = ((at_high - 1) ** 2 - g1**2 * at_high**2 - h2**2) / at_high
    h12 = ((1 - at_low) ** 2 - h1**2 * at_low**2 - g2**2) / at_low
    return tuple(float(constant) for constant in (g1, h2, g12, h1, g2, h12))
