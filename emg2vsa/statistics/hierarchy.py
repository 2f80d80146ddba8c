"""b of a person is not b of a press: means of recordings, and values of people drawn towards those of the study.

The interval of a recording's mean needs the scatter of its presses, and few presses hardly show it. Recordings of a
study scatter alike, as shares of their level, but not equally. Their variances are taken as draws from one scaled
inverse chi-squared law, whose centre and degrees of freedom the study shows; a recording's own variance is averaged
with that centre, each by its degrees of freedom (Smyth 2004, Statistical Applications in Genetics and Molecular Biology
3, 3). Successive presses may be alike; their correlation is that of all recordings (``serial``).

Shrunken values are the predictions of the study's mixed model (``reml``): mean of the specimen, what the person differs
by, and what the person's recording differs by (Henderson 1975, Biometrics 31, 423).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.statistics.moments import finite_or_nan
from emg2vsa.statistics.serial import serial_correlation

if TYPE_CHECKING:
    from emg2vsa.statistics.reml import RemlFit

_LEAST_SHARE = 1e-5
"Share of the median variance. Recordings that scatter by less are taken as scattering by so much."
_MOST_DF, _STEPS = 1e6, 20
MOST_ALIKE = 0.6
"Largest correlation of successive presses; a level that wanders over 10 s gives .4, and few presses often seem to."
ENOUGH = 5
"Presses from which on a recording alone tells whether successive ones are alike."


@dataclass(frozen=True, eq=False)
class RecordingMeans:
    """Means of c recordings. mean, half (c,) : in the unit of the data, and half of the interval; count (c,) presses.

    sd : of a press, as a share of the level of its recording, typical of all; NaN where none has two presses.
    df : degrees of freedom behind ``sd`` that each recording borrows; infinite where recordings scatter equally, 0 of
    one recording. rho : correlation of successive presses, 0 where it is not shown.
    """

    mean: Floats
    half: Floats
    count: Ints
    sd: float
    df: float
    rho: float


def recording_means(values: Floats, level: Floats, error: Floats, confidence: float = 0.95) -> RecordingMeans:
    """Means of presses (c, R) in the order they were made, NaN where there is none.

    level : (c,) that the scatter is proportional to; a recording where it is not above 0 has no interval. error : (c,)
    standard error that the presses of a recording have in common. Half is NaN where no recording has two presses.
    Variances of recordings are drawn to each other after Smyth (2004).
    Why a recording and not a press: decision 48.
    """
    level = np.where(level > 0, level, np.nan)
    mean = mean_of(finite_or_nan(values))
    away = (values - mean[:, None]) / level[:, None]
    n = np.count_nonzero(np.isfinite(away), axis=1)
    own_df = np.maximum(n - 1, 0)
    squares = np.sum(away**2, axis=1, where=np.isfinite(away)) / np.maximum(own_df, 1)
    centre, prior_df = _law_of_variances(squares[own_df > 0], own_df[own_df > 0])
    serial = serial_correlation(away[None], MOST_ALIKE)
    df = np.minimum(prior_df + own_df, own_df.sum())
    share = np.full(n.size, centre)
    if np.isfinite(prior_df):
        share = (prior_df * centre + own_df * squares) / np.maximum(prior_df + own_df, 1)
    variance = share * level**2 / np.maximum(serial.effective_n[0], np.finfo(np.float64).tiny)
    df = np.maximum(df * float(serial.share_of_freedom[0]), 1.0)
    half = special.stdtrit(df, 0.5 + confidence / 2) * np.sqrt(variance + np.nan_to_num(error) ** 2)
    known = (n > 0) & (prior_df + own_df > 0)
    count = np.count_nonzero(np.isfinite(values), axis=1)
    return RecordingMeans(
        mean, np.where(known, half, np.nan), count, float(np.sqrt(centre)), prior_df, float(serial.rho[0])
    )


def _law_of_variances(variance: Floats, df: Ints) -> tuple[float, float]:
    """Centre and degrees of freedom of the law that variances (c,) with ``df`` (c,) come from, by Smyth's moments."""
    if not variance.size:
        return np.nan, 0.0
    typical = float(np.sum(variance * df) / df.sum())
    least = _LEAST_SHARE * float(np.median(variance))
    if variance.size < 2 or not least > 0:
        return typical, 0.0 if variance.size < 2 else np.inf
    logs = np.log(np.maximum(variance, least)) - special.digamma(df / 2) + np.log(df / 2)
    centre = float(np.mean(logs))
    beyond = float(np.var(logs, ddof=1) - np.mean(special.polygamma(1, df / 2)))
    if beyond <= float(special.polygamma(1, _MOST_DF / 2)):
        return typical, np.inf
    half = 0.5 + 1 / beyond
    for _ in range(_STEPS):  # Newton's, on the reciprocal of the trigamma function, which is nearly straight
        trigamma = special.polygamma(1, half)
        half += trigamma * (1 - trigamma / beyond) / special.polygamma(2, half)
    return float(np.exp(centre + special.digamma(half) - np.log(half))), 2 * float(half)


@dataclass(frozen=True, eq=False)
class ShrunkenValues:
    """Predictions of the mixed model for P participants, in the unit of the data.

    person, person_low, person_high (P,) : mean over the specimens. cell, cell_low, cell_high (P, S) : on each specimen,
    also one the participant has not pressed. Of each, an interval of the value that many presses would have.
    """

    person: Floats
    person_low: Floats
    person_high: Floats
    cell: Floats
    cell_low: Floats
    cell_high: Floats


def shrunken(fit: RemlFit, confidence: float = 0.95) -> ShrunkenValues:
    """Best linear unbiased predictions at the variances of ``fit``, with Student's t on the participants.

    The error holds that of the specimens' means; that of the variances enters by the degrees of freedom alone.
    """
    count, (t1, t2) = fit.cells.count, fit.ratios
    p, s = count.shape
    between = t1 + t2 * np.eye(s)  # of a participant's true values, in variances of repetitions
    target = np.vstack([np.eye(s), np.full((1, s), 1 / s)])
    prior = np.einsum("ij,jk,ik->i", target, between, target)
    value, error = np.empty((p, s + 1)), np.empty((p, s + 1))
    rows, of = np.unique(count, axis=0, return_inverse=True)
    for number, row in enumerate(rows):  # participants are independent; those with equal counts share their gains
        own, there = of.ravel() == number, np.flatnonzero(row)
        covariance = between[np.ix_(there, there)] + np.diag(1 / row[there])
        gain = np.linalg.solve(covariance, between[there] @ target.T).T
        beyond = fit.cells.mean[np.ix_(own, there)] - fit.at.beta[there]
        value[own] = target @ fit.at.beta + beyond @ gain.T
        apart = target.copy()
        apart[:, there] -= gain
        known = np.einsum("ij,ij->i", gain, target @ between[:, there])
        error[own] = prior - known + np.einsum("ij,jk,ik->i", apart, fit.at.inverse, apart)
    factor = special.stdtrit(np.count_nonzero(count.any(axis=1)) - 1, 0.5 + confidence / 2)
    half = factor * np.sqrt(np.maximum(error, 0.0) * fit.error)
    ends = [fit.origin + np.ldexp(each, fit.unit) for each in (value, value - half, value + half)]
    cells, people = [each[:, :s] for each in ends], [each[:, s] for each in ends]
    return ShrunkenValues(*people, *cells)
