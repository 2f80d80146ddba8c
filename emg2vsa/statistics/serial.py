"""Presses that follow each other may be alike: their correlation is tested, and says how many presses they count as.

The statistic is the first serial correlation about the mean of a specimen, r = sum e_t e_(t+1) / sum e_t^2, pooled over
specimens. Independent normal presses have E r = -1/n and a variance that follows from traces (Durbin and Watson 1950,
Biometrika 37, 409; Moran 1948, Biometrika 35, 255). The test is one-sided: only a positive correlation makes intervals
too short. Where p is below .25, the level for a test on which an estimate depends (Bancroft and Han 1977, International
Statistical Review 45, 117), presses are taken as an autoregression of first order with the correlation rho whose
expected r (Sawa 1978) is the pooled one. In it the mean of n presses has the variance

    sigma^2 gamma / n,  gamma = 1 + 2 sum_k (1 - k/n) rho^k,

and the sample variance s^2 expects sigma^2 (n - gamma) / (n - 1), so that s^2 / n has to be divided by n_eff in place
of n. Degrees of freedom are fewer by (1 - rho^2) / (1 + rho^2) (Bayley and Hammersley 1946, Supplement to the Journal
of the Royal Statistical Society 8, 184). A drift from press to press shows as such a correlation too.

Four specimens of ten presses: 95 % intervals cover 96, 94, 93 and 93 % at rho = 0, .2, .4 and .6, and 95, 90, 80 and
66 % if the presses are taken as independent.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, mean_of
from emg2vsa.statistics.moments import finite_or_nan

_LEAST_PRESSES = 4
_INCLUDED_P = 0.25
_ROUNDING = 1e-9
"""Share of the mean: presses that differ by no more are equal."""
_RHO = np.linspace(0.0, 0.95, 39)


@dataclass(frozen=True)
class SerialCorrelation:
    """Serial correlation in d calibrations. rho : (d,) correlation of successive presses, 0 where the test does not
    reject. p : (d,) of independent presses, NaN where too few repeat. effective_n : (d, S) independent presses that
    those of each specimen count as.
    """

    rho: Floats
    p: Floats
    effective_n: Floats

    @property
    def share_of_freedom(self) -> Floats:
        """(d,) by which the degrees of freedom of variances shrink."""
        return np.asarray((1 - self.rho**2) / (1 + self.rho**2))


def serial_correlation(scores: Floats, most: float = 1.0) -> SerialCorrelation:
    """Serial correlation of presses (d, S, R) in the order they were made, NaN where there is none; its neighbours
    then count as successive. Specimens weigh by their presses, and those with fewer than four do not count. most :
    of ``rho``.

    The test is that of Durbin and Watson (1950) and Moran (1948); the expected r that of Sawa (1978).
    """
    there = np.isfinite(finite_or_nan(scores))
    n = np.count_nonzero(there, axis=-1)
    order = np.argsort(~there, axis=-1, kind="stable")
    e = np.take_along_axis(np.where(there, scores - mean_of(scores)[..., None], 0.0), order, axis=-1)
    largest = np.max(np.abs(e), axis=-1, keepdims=True, initial=0.0)
    rounding = (
        _ROUNDING * np.abs(np.nan_to_num(mean_of(scores)))[..., None]
    )  # equal presses differ from their mean by it
    e = np.where(largest > rounding, e / np.where(largest > 0, largest, 1.0), 0.0)  # in any unit squares do not vanish
    squares = np.sum(e**2, axis=-1)
    used = (n >= _LEAST_PRESSES) & (squares > 0)
    weight = np.where(used, n, 0)
    count = np.where(used, n, _LEAST_PRESSES)
    total = np.sum(weight, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        r = np.sum(e[..., :-1] * e[..., 1:], axis=-1) / np.where(used, squares, 1.0)
        pooled = np.sum(weight * r, axis=-1) / total
        expected, variance = (np.array([_independent(k)[i] for k in range(count.max(initial=0) + 1)]) for i in (0, 1))
        away = np.sum(weight * (r - expected[count]), axis=-1)
        p = special.ndtr(-away / np.sqrt(np.sum(weight**2 * variance[count], axis=-1)))
    rho = np.zeros(len(scores))
    for i in np.flatnonzero(p < _INCLUDED_P):
        curve = sum(w * _expected_r(k) for w, k in zip(weight[i].tolist(), count[i].tolist(), strict=True)) / total[i]
        rho[i] = min(float(np.interp(pooled[i], curve, _RHO)), most)
    return SerialCorrelation(rho, p, _effective(n, rho))


def independent(groups: Floats) -> SerialCorrelation:
    """Correlation 0 of presses (d, S, M, R) that are taken as independent."""
    n = np.count_nonzero(np.isfinite(groups), axis=(-2, -1)).astype(np.float64)
    return SerialCorrelation(np.zeros(len(groups)), np.full(len(groups), np.nan), n)


def serial_of_mountings(groups: Floats) -> SerialCorrelation:
    """The same of presses (d, S, M, R) by mounting: successive ones are those of one mounting. effective_n : (d, S).
    Sources as there (Sawa 1978)."""
    d, s, m, r = groups.shape
    found = serial_correlation(groups.reshape(d, s * m, r))
    return dataclasses.replace(found, effective_n=found.effective_n.reshape(d, s, m).sum(axis=-1))


def _effective(n: Floats, rho: Floats) -> Floats:
    """(d, S) presses in place of n (d, S)."""
    lag = np.arange(1, max(int(n.max(initial=1)), 2))
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.clip(1 - lag / np.maximum(n, 1)[..., None], 0, None)
        gamma = 1 + 2 * np.sum(share * rho[:, None, None] ** lag, axis=-1)
        return np.where(n > 1, n * (n - gamma) / ((n - 1) * gamma), n)


def _centred(n: int) -> tuple[Floats, Floats]:
    """Centring matrix, and that of the products of neighbours, each (n, n)."""
    return np.eye(n) - 1 / n, (np.eye(n, k=1) + np.eye(n, k=-1)) / 2


@lru_cache(maxsize=256)
def _independent(n: int) -> tuple[float, float]:
    """Mean and variance of r of n independent normal presses."""
    if n < _LEAST_PRESSES:
        return 0.0, 0.0
    centre, neighbours = _centred(n)
    form = centre @ neighbours @ centre
    trace, square = float(np.trace(form)), float(np.trace(form @ form))
    return trace / (n - 1), 2 * ((n - 1) * square - trace**2) / ((n - 1) ** 2 * (n + 1))


@lru_cache(maxsize=256)
def _expected_r(n: int) -> Floats:
    """Expected r of n presses at each of ``_RHO``: the integral of Sawa (1978, Journal of Econometrics 8, 295)."""
    centre, neighbours = _centred(n)
    lags = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    root = np.linalg.cholesky(_RHO[:, None, None] ** lags)
    size, axes = np.linalg.eigh(np.swapaxes(root, 1, 2) @ centre @ root)
    turned = centre @ root @ axes
    products = np.einsum("rij,ik,rkj->rj", turned, neighbours, turned)
    u, weight = np.polynomial.legendre.leggauss(80)
    u = (1 + u) / 2
    t, weight = u / (1 - u) / n, weight / 2 / (1 - u) ** 2 / n
    grown = 1 + 2 * t[:, None, None] * np.clip(size, 0, None)
    inside = np.exp(-0.5 * np.sum(np.log(grown), axis=-1)) * np.sum(products / grown, axis=-1)
    return np.asarray(weight @ inside)
