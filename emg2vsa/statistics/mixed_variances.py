"""How people, their specimens and their repetitions scatter: standard deviations of the mixed model, and its residuals.

Intervals come from the profile of the restricted likelihood: all values of a standard deviation (or of a ratio) at
which the best choice of the other variances raises -2 log likelihood by less than the quantile of chi squared. They
need no symmetry and end at 0 where the data do not exclude it. (lme4's `confint` takes the profile of the unrestricted
likelihood instead, whose standard deviations are too small by the share of the fixed effects.)
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, special

from emg2vsa.arrays import Floats, unmasked
from emg2vsa.shown import shown
from emg2vsa.statistics.kruskal import midranks
from emg2vsa.statistics.normality import shapiro_wilk
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.reml import LARGEST, Cells, Cost, RemlFit, by_ratios, by_variances, lowest

SOURCES = ("participants", "participants by specimens", "repetitions")
_RTOL = 4 * np.finfo(np.float64).eps


@dataclass(frozen=True, eq=False)
class MixedVariances:
    """Standard deviations of one study, (3,) each in the order of ``SOURCES``, in the unit of the data.

    sd, low, high : REML and its profile interval. ratio, ratio_low, ratio_high : (2,) of the first two to the third.
    """

    sd: Floats
    low: Floats
    high: Floats
    ratio: Floats
    ratio_low: Floats
    ratio_high: Floats
    n: int
    confidence: float

    def outcomes(self) -> tuple[Outcome, ...]:
        """Three standard deviations, two ratios."""
        of = [*SOURCES, *(f"{source} / repetitions" for source in SOURCES[:2])]
        names = ["SD"] * 3 + ["ratio of SD"] * 2
        ends = [np.concatenate(pair) for pair in ((self.low, self.ratio_low), (self.high, self.ratio_high))]
        boundary = "the restricted likelihood is largest at a variance of 0: only the upper limit is informative"
        return tuple(
            Outcome(
                method=f"linear mixed model (REML, profile likelihood), {source}",
                n=self.n,
                estimate_name=name,
                estimate=float(estimate),
                interval=(float(low), float(high)),
                confidence=self.confidence,
                notes=() if estimate > 0 else (boundary,),
            )
            for source, name, estimate, low, high in zip(
                of, names, np.concatenate([self.sd, self.ratio]), *ends, strict=True
            )
        )


@dataclass(frozen=True, eq=False)
class MixedResiduals:
    """What the mixed model leaves, for a drawing; (n,) each, participant by participant, specimen by specimen.

    fitted : mean of the specimen and the predicted effects of the participant (BLUP), in the unit of the data.
    residual : value less fitted, over the SD of repetitions. quantile : of the normal law at the residual's rank
    (Blom 1958). Normal repetitions lie on a straight line, its slope a little below 1: the fit takes a share.
    """

    fitted: Floats
    residual: Floats = field(metadata=shown("Residual / SD of repetitions"))
    quantile: Floats = field(metadata=shown("Normal quantile"))

    def outcomes(self) -> tuple[Outcome, ...]:
        """Is the scatter normal, and is it the same at every level?"""
        normal = shapiro_wilk(self.residual[None]).outcome(0)
        n = self.residual.size
        ranks = [midranks(values) - (n + 1) / 2 for values in (np.abs(self.residual), self.fitted)]
        with np.errstate(divide="ignore", invalid="ignore"):
            rho = float(np.sum(ranks[0] * ranks[1]) / np.sqrt(np.sum(ranks[0] ** 2) * np.sum(ranks[1] ** 2)))
            t = rho * np.sqrt((n - 2) / (1 - rho**2)) if n > 2 else np.nan
        return (
            Outcome(
                method=f"residuals of the mixed model, {normal.method}",
                n=n,
                statistic_name=normal.statistic_name,
                statistic=normal.statistic,
                p=normal.p,
                notes=normal.notes,
            ),
            Outcome(
                method="residuals of the mixed model, Spearman of their size and the fitted level",
                n=n,
                statistic_name="t",
                statistic=float(t),
                df=(n - 2.0,),
                p=float(2 * special.stdtr(n - 2, -abs(t))) if n > 2 else float("nan"),
                effect_name="rank correlation",
                effect_size=rho,
                notes=("a small p: repetitions scatter more, or less, at high levels",),
            ),
        )


def mixed_variances(fit: RemlFit, confidence: float = 0.95) -> MixedVariances:
    """Standard deviations of the study that was fitted, with or without gaps."""
    cells, unit, ratios, error = fit.cells, fit.unit, fit.ratios, fit.error
    variance = np.array([*ratios, 1.0])
    # in SDs of repetitions, so that the variances are of order 1
    cost = by_variances(Cells(cells.count, cells.mean / np.sqrt(error), cells.within / error, cells.n))
    sds = np.sqrt([_ends(cost, variance, i, confidence) for i in range(3)])
    by_ratio = np.sqrt([_ends(by_ratios(cells), ratios, i, confidence) for i in range(2)])
    in_data = np.sqrt(error)
    return MixedVariances(
        sd=np.ldexp(in_data * np.sqrt(variance), unit),
        low=np.ldexp(in_data * sds[:, 0], unit),
        high=np.ldexp(in_data * sds[:, 1], unit),
        ratio=np.sqrt(ratios),
        ratio_low=by_ratio[:, 0],
        ratio_high=by_ratio[:, 1],
        n=cells.n,
        confidence=confidence,
    )


def ratio_interval(cells: Cells, ratios: Floats, confidence: float) -> tuple[float, float]:
    """Interval of the SD of participants to that of repetitions, where the likelihood is largest at ``ratios`` (2,): by
    the profile of the restricted likelihood (Patterson and Thompson 1971)."""
    low, high = np.sqrt(_ends(by_ratios(cells), ratios, 0, confidence))
    return float(low), float(high)


def mixed_residuals(values: ArrayLike, fit: RemlFit) -> MixedResiduals:
    """Residuals of ``values`` (P, S, R), to which the model was fitted."""
    values = np.asarray(unmasked(values), dtype=np.float64)
    t1, t2 = fit.ratios
    person = t1 * np.sum(fit.at.projected, axis=1, keepdims=True)
    there = np.isfinite(values)
    level = np.ldexp(fit.at.beta + person + t2 * fit.at.projected, fit.unit)
    error = np.ldexp(np.sqrt(fit.error), fit.unit)
    residual = ((values - fit.origin - level[..., None]) / error)[there]
    quantile = special.ndtri((midranks(residual) - 0.375) / (residual.size + 0.25))
    fitted = np.broadcast_to(fit.origin + level[..., None], values.shape)[there]
    return MixedResiduals(fitted, residual, quantile)


def _ends(cost: Cost, best: Floats, i: int, confidence: float) -> tuple[float, float]:
    """Ends of the profile interval of parameter ``i`` of ``cost``, which is lowest at ``best``."""
    limit = float(cost(best)[0]) + float(special.chdtri(1, 1 - confidence))
    moving = np.arange(best.size) != i
    near = best

    def excess(value: float) -> float:
        nonlocal near
        near = near.copy()
        near[i] = value
        near = lowest(cost, near, moving)
        return float(cost(near)[0]) - limit

    low, least = best[i], 0.0
    if i == 2:  # the variance of repetitions is not 0
        least = best[i] / 2
        while excess(least) <= 0:
            least /= 2
    if best[i] == 0 or (i != 2 and excess(0.0) <= 0):
        low = 0.0
    else:
        low = optimize.brentq(excess, least, best[i], xtol=1e-300, rtol=_RTOL)
    near, most = best, max(2 * best[i], 1e-3)
    while excess(most) <= 0:
        most *= 4
        if most > LARGEST:
            return low, np.inf
    return low, float(optimize.brentq(excess, best[i], most, xtol=1e-300, rtol=_RTOL))
