"""Mixed model of a study with gaps by restricted maximum likelihood: specimens fixed, participants random.

y = mean of the specimen + participant + participant by specimen + repetition. The values of a cell (participant by
specimen) enter through their number n and mean only, besides the squares within cells. With the variances relative to
that of repetitions, t1 of participants and t2 of participants by specimens, the cell means of one participant have the
covariance diag(1 / n + t2) + t1 1 1', whose inverse and determinant are known (Sherman and Morrison 1950). So the
restricted likelihood (Patterson and Thompson 1971) costs a table of participants by specimens, and not all values.
Its largest value is sought where no variance is negative; a variance may be exactly 0.

Degrees of freedom are Satterthwaite's, as lmerTest has them (Kuznetsova, Brockhoff and Christensen 2017); intervals of
the ratio of standard deviations come from the profile of the restricted likelihood.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from emg2vsa.arrays import Floats, exponent_of
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.post_hoc import PairDifferences, pair_numbers, student_pairs

METHOD = "linear mixed model, REML, Satterthwaite df"
_STEPS = 100
_GRID = (0.0, 1e-3, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0)
"""Ratios at which the search may begin: the likelihood can have two tops."""
_LARGEST = 1e12
_TINY_STEP = 1e-30
"""Of the complex step: derivatives without a difference of numbers (Squire and Trapp 1998)."""
_SETTLED = 1e-14
_SAME_DF = 1e-8
_PROFILE_RTOL = 1e-8


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
            notes=(f"variance of {' and of '.join(at_zero)} estimated as 0",) if at_zero else (),
        )


@dataclass(frozen=True)
class _Cells:
    """count, mean : (P, S), 0 where a cell is empty. within : sum of squares within cells. n : all values."""

    count: Floats
    mean: Floats
    within: float
    n: int

    @property
    def free(self) -> int:
        """Values less fixed effects."""
        return self.n - int(self.count.shape[1])


@dataclass(frozen=True)
class _At:
    """The model at ratios t1, t2, which may be complex: see `_solve`."""

    beta: NDArray[Any]
    inverse: NDArray[Any]
    residual_squares: Any
    logs: Any
    residual_slopes: NDArray[Any]
    log_slopes: NDArray[Any]

    def deviance(self, free: int) -> Any:
        """-2 log restricted likelihood without its constants, the variance of repetitions at its best."""
        return free * np.log(self.residual_squares / free) + self.logs

    def slope(self, free: int) -> NDArray[Any]:
        """Derivatives of `deviance` along t1 and t2."""
        return np.asarray(free * self.residual_slopes / self.residual_squares + self.log_slopes)


def unbalanced_mixed(values: Floats, confidence: float = 0.95) -> UnbalancedMixed | Outcome:
    """Fit ``values`` (P participants, S specimens, R repetitions), NaN where there is none.

    An `Outcome` without numbers, with the reason, where the study cannot bear the model: fewer than two participants
    or specimens, a specimen without values, no cell with two values, or values that do not differ within cells.
    """
    cells, origin, unit, why = _cells_of(np.asarray(values, dtype=np.float64))
    if why:
        return Outcome(method=METHOD, n=cells.n, statistic_name="F", statistic=np.nan, p=np.nan, notes=(why,))
    ratios = _best(cells)
    return _described(cells, ratios, origin, unit, confidence)


def _cells_of(values: Floats) -> tuple[_Cells, float, int, str]:
    """Cells of the values less their first, scaled by 2**-unit to below 1, and why they cannot be fitted, or ""."""
    there = np.isfinite(values)
    count = np.count_nonzero(there, axis=2).astype(np.float64)
    n = int(count.sum())
    origin = float(values[there][0]) if n else 0.0
    shifted = np.where(there, values - origin, 0.0)
    unit = int(exponent_of(np.max(np.abs(shifted)))) if n else 0
    shifted = np.ldexp(shifted, -unit)
    mean = shifted.sum(axis=2) / np.maximum(count, 1)
    within = float(np.sum((shifted - mean[..., None]) ** 2, where=there))
    cells = _Cells(count, mean, within, n)
    if min(count.shape) < 2 or np.count_nonzero(count.sum(axis=1)) < 2:
        return cells, origin, unit, "undefined: fewer than two participants or specimens"
    if np.any(count.sum(axis=0) == 0):
        return cells, origin, unit, "undefined: a specimen has no values"
    if count.max() < 2:
        return cells, origin, unit, "undefined: no participant has two values on one specimen"
    if not within > 0:
        return cells, origin, unit, "undefined: repetitions do not differ at all"
    if np.count_nonzero(count) <= count.shape[1]:
        return cells, origin, unit, "undefined: as many fixed effects as cells"
    return cells, origin, unit, ""


def _solve(cells: _Cells, t1: Any, t2: Any) -> _At:
    """Generalised least squares at the ratios ``t1``, ``t2``, which may be complex, and the slopes along them."""
    weight = cells.count / (1 + cells.count * t2)
    total = weight.sum(axis=1)
    shrink = t1 / (1 + t1 * total)
    information = np.diag(weight.sum(axis=0)) - (weight.T * shrink) @ weight
    right = np.sum(weight * (cells.mean - (shrink * np.sum(weight * cells.mean, axis=1))[:, None]), axis=0)
    inverse = np.linalg.inv(information)
    beta = inverse @ right
    residual = np.where(cells.count > 0, cells.mean - beta, 0.0)
    projected = weight * (residual - (shrink * np.sum(weight * residual, axis=1))[:, None])
    squares = weight**2
    squared = np.sum(squares, axis=1)
    leverage = np.einsum("ps,st,pt->p", weight, inverse, weight, optimize=True)
    crossed = np.einsum("ps,st,pt->p", weight, inverse, squares, optimize=True)
    of_people = np.sum(total / (1 + t1 * total) - leverage / (1 + t1 * total) ** 2)
    of_cells = np.sum(total - shrink * squared + 2 * shrink * crossed - shrink**2 * squared * leverage)
    of_cells -= np.sum(squares, axis=0) @ np.diag(inverse)
    return _At(
        beta=beta,
        inverse=inverse,
        residual_squares=cells.within + np.sum(residual * projected),
        logs=np.sum(np.log(1 + cells.count * t2)) + np.sum(np.log(1 + t1 * total)) + np.linalg.slogdet(information)[1],
        residual_slopes=-np.array([np.sum(projected.sum(axis=1) ** 2), np.sum(projected**2)]),
        log_slopes=np.array([of_people, of_cells]),
    )


def _best(cells: _Cells) -> Floats:
    """Ratios (2,), neither below 0, at which the restricted likelihood is largest."""

    def cost(ratios: Floats) -> tuple[float, Floats]:
        at = _solve(cells, *ratios)
        return float(at.deviance(cells.free)), at.slope(cells.free)

    start = min(((t1, t2) for t1 in _GRID for t2 in _GRID), key=lambda ratios: cost(np.array(ratios))[0])
    bounds = [(0.0, _LARGEST)] * 2
    ratios = np.asarray(optimize.minimize(cost, start, jac=True, bounds=bounds, method="L-BFGS-B").x)
    for _ in range(_STEPS):  # Newton's steps, for the last digits
        slope, curvature = _slope_and_curvature(cells, ratios)
        moves = (ratios > 0) | (slope < 0)
        if not moves.any() or np.linalg.eigvalsh(curvature[np.ix_(moves, moves)])[0] <= 0:
            break
        step = np.zeros(2)
        step[moves] = np.linalg.solve(curvature[np.ix_(moves, moves)], -slope[moves])
        better = np.clip(ratios + step, 0.0, _LARGEST)
        if np.all(np.abs(better - ratios) <= _SETTLED * ratios):
            return better
        ratios = better
    return ratios


def _slope_and_curvature(cells: _Cells, ratios: Floats) -> tuple[Floats, Floats]:
    slope = _solve(cells, *ratios).slope(cells.free)
    columns = [at.slope(cells.free).imag / _TINY_STEP for at in _beside(cells, ratios)]
    return slope, np.stack(columns, axis=1)


def _beside(cells: _Cells, ratios: Floats) -> list[_At]:
    """The model a tiny imaginary step along each ratio."""
    return [_solve(cells, *(ratios + 1j * _TINY_STEP * along)) for along in np.eye(2)]


def _described(cells: _Cells, ratios: Floats, origin: float, unit: int, confidence: float) -> UnbalancedMixed:
    at, free = _solve(cells, *ratios), cells.free
    error = float(at.residual_squares) / free
    df_of = _satterthwaite(cells, ratios, at, error)
    s = cells.count.shape[1]
    others = np.eye(s)[1:] - np.eye(s)[0]
    f, df2 = _specimens_differ(others, at.beta, error * at.inverse, df_of)
    variance = error * np.array([*ratios, 1.0])
    low, high = _ratio_interval(cells, ratios, float(at.deviance(free)), confidence)
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


def _satterthwaite(cells: _Cells, ratios: Floats, at: _At, error: float) -> Callable[[Floats], float]:
    """Degrees of freedom of a contrast of the means: 2 E^2 / Var of its estimated variance, from the curvature of the
    likelihood along the ratios above 0 and the logarithm of the variance of repetitions."""
    above = np.flatnonzero(ratios > 0)
    beside = [at_other for at_other, ratio in zip(_beside(cells, ratios), ratios, strict=True) if ratio > 0]
    curvature = np.empty((above.size + 1, above.size + 1))
    curvature[-1, -1] = cells.free
    curvature[:-1, -1] = curvature[-1, :-1] = -at.residual_slopes[above] / error
    for column, other in enumerate(beside):
        both = (other.residual_slopes / error + other.log_slopes).imag / _TINY_STEP
        curvature[:-1, column] = both[above]
    of_parameters = 2 * np.linalg.inv(curvature)
    steps = [error * other.inverse.imag / _TINY_STEP for other in beside]

    def df_of(contrast: Floats) -> float:
        variance = error * contrast @ at.inverse @ contrast
        slopes = np.array([*(contrast @ step @ contrast for step in steps), variance])
        return float(2 * variance**2 / (slopes @ of_parameters @ slopes))

    return df_of


def _specimens_differ(
    contrasts: Floats, mean: Floats, covariance: Floats, df_of: Callable[[Floats], float]
) -> tuple[float, float]:
    """Wald's F of all ``contrasts`` (q, S) at once and its second df (Fai and Cornelius 1996).

    F is the same whichever contrasts say "no difference", the df in the first four digits only: lmerTest's anova()
    takes others than differences from the first specimen.
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
    cells: _Cells, mean: Floats, covariance: Floats, df_of: Callable[[Floats], float], unit: int, confidence: float
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


def _ratio_interval(cells: _Cells, ratios: Floats, lowest: float, confidence: float) -> tuple[float, float]:
    """Ratios of standard deviations, participants to repetitions, whose profile deviance is not too far above."""
    limit = lowest + float(special.chdtri(1, 1 - confidence))

    def excess(t1: float) -> float:
        return _profile(cells, t1) - limit

    low = 0.0 if ratios[0] == 0 or excess(0.0) <= 0 else optimize.brentq(excess, 0.0, ratios[0], rtol=_PROFILE_RTOL)
    high = max(ratios[0], 1 / cells.count.sum())
    while excess(high) <= 0:
        high *= 4
        if high > _LARGEST:
            return float(np.sqrt(low)), np.inf
    return float(np.sqrt(low)), float(np.sqrt(optimize.brentq(excess, ratios[0], high, rtol=_PROFILE_RTOL)))


def _profile(cells: _Cells, t1: float) -> float:
    """Deviance at ``t1``, the ratio of participants by specimens at its best."""

    def slope(t2: float) -> float:
        return float(_solve(cells, t1, t2).slope(cells.free)[1])

    t2 = 0.0
    if slope(0.0) < 0:
        high = 1.0
        while slope(high) < 0 and high < _LARGEST:
            high *= 8
        t2 = optimize.brentq(slope, 0.0, high, rtol=_PROFILE_RTOL) if high < _LARGEST else high
    return float(_solve(cells, t1, t2).deviance(cells.free))
