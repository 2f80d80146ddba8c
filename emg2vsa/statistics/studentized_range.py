"""Tukey's studentized range: survival and quantiles, many at once.

P(Q > q) = integral over s of f(s) W(q s), with f the density of the pooled SD over sigma (chi / sqrt(df)) and W(w) the
probability that k standard normal values spread by more than w. Both integrals by Gauss-Legendre; W is written so that
small probabilities keep their digits: with z the largest value,
W(w) = k integral phi(z) (Phi(z)^(k-1) - (Phi(z) - Phi(z - w))^(k-1)) dz.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats

_Z, _Z_WEIGHT = np.polynomial.legendre.leggauss(256)
_S, _S_WEIGHT = np.polynomial.legendre.leggauss(128)
_REACH = 9.0
_WIDTH = 13.0  # standard deviations of s that are integrated over
_CHUNK = 64
_STRETCH, _STRETCHES, _DEGREE = 1.0, 50, 24
_STEPS = 30
_CLOSE = 1e-12


def survival(q: ArrayLike, k: ArrayLike, df: ArrayLike) -> Floats:
    """P(Q > q) for k groups and df degrees of freedom; all broadcast. NaN for q NaN, k < 2 or df < 1."""
    q, k, df = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (q, k, df)))
    p = np.full(q.shape, np.nan)
    good = np.isfinite(q) & (k >= 2) & (df >= 1)
    p[np.isposinf(q) & (k >= 2) & (df >= 1)] = 0.0
    flat = np.stack([q[good], k[good], df[good]])
    answer = [_survival(*flat[:, i : i + _CHUNK]) for i in range(0, flat.shape[1], _CHUNK)]
    p[good] = np.concatenate(answer) if answer else []
    return p


def quantile(probability: float, k: ArrayLike, df: ArrayLike) -> Floats:
    """q with P(Q <= q) = ``probability`` (0 to 1, both excluded), NaN for k < 2 or df < 1."""
    k, df = np.broadcast_arrays(np.asarray(k, dtype=np.float64), np.asarray(df, dtype=np.float64))
    designs, back = np.unique(np.stack([k.ravel(), df.ravel()]), axis=1, return_inverse=True)
    groups, degrees = designs

    def excess(q: Floats) -> Floats:
        return np.asarray(np.log(survival(q, groups, degrees)) - np.log1p(-probability))

    # Bonferroni's t is an upper bound and close; log P is smooth in q, so that the secant needs few steps
    pairs = groups * (groups - 1) / 2
    q = -np.sqrt(2) * special.stdtrit(degrees, (1 - probability) / pairs / 2)
    before, at_before = 0.97 * q, excess(0.97 * q)
    for _ in range(_STEPS):
        at_q = excess(q)
        if np.all((np.abs(at_q) < _CLOSE) | np.isnan(at_q)):
            break
        slope = np.where(q != before, (at_q - at_before) / np.where(q != before, q - before, 1.0), -1.0)
        before, at_before, q = q, at_q, np.maximum(q - at_q / slope, q / 2)
    found = np.where((groups >= 2) & (degrees >= 1), q, np.nan)
    return np.asarray(found[back.ravel()].reshape(k.shape))


def _survival(q: Floats, k: Floats, df: Floats) -> Floats:
    """(j,) of each, all defined."""
    spread = _WIDTH / np.sqrt(2 * df)
    # where W(q s) ~ exp(-(q s)^2 / 4) the product with f is largest at ``peak``, which lies far below 1 for large q
    joint = df + q**2 / 2
    peak = np.sqrt(np.maximum(df - 1, 0.0) / joint)
    low = np.clip(peak - _WIDTH / np.sqrt(2 * joint), 0.0, np.maximum(1 - spread, 0.0))[:, None]
    high = (1 + spread)[:, None]
    # s = low + (high - low) t^3: for low = 0 the density starts like s^(df - 1), which df below 2 makes steep
    t = (_S + 1) / 2
    s = low + (high - low) * t**3
    weight = (high - low) * 3 * t**2 * _S_WEIGHT / 2
    half = df[:, None] / 2
    log_density = half * np.log(half) - special.gammaln(half) + np.log(2.0) + (2 * half - 1) * np.log(s) - half * s**2
    return np.asarray(np.sum(weight * np.exp(log_density) * _spread_survival(q[:, None] * s, k[:, None]), axis=1))


def _spread_survival(w: Floats, k: Floats) -> Floats:
    """Probability that k standard normal values spread by more than w; w (j, s), k (j, 1)."""
    answer = np.empty_like(w)
    for groups in np.unique(k):
        same = k[:, 0] == groups
        answer[same] = _interpolated(w[same], _log_spread(int(groups)))
    return answer


def _interpolated(w: Floats, coefficients: Floats) -> Floats:
    """exp of the Chebyshev series of the stretch that each w lies in (Clenshaw); 0 beyond the last."""
    at = w / _STRETCH
    stretch = np.minimum(at.astype(np.int64), len(coefficients) - 1)
    x = np.minimum(2 * (at - stretch) - 1, 1.0)
    last, before = np.zeros_like(x), np.zeros_like(x)
    for row in coefficients.T[:0:-1]:
        last, before = row[stretch] + 2 * x * last - before, last
    beyond = at >= len(coefficients)
    return np.where(beyond, 0.0, np.exp(np.where(beyond, 0.0, coefficients[stretch, 0] + x * last - before)))


@cache
def _log_spread(k: int) -> Floats:
    """Chebyshev coefficients (stretches, degree) of log W of k groups; log W is smooth: they hold all digits."""
    angle = np.pi * (np.arange(_DEGREE) + 0.5) / _DEGREE
    w = _STRETCH * (np.arange(_STRETCHES)[:, None] + (np.cos(angle) + 1) / 2)
    series = np.cos(np.arange(_DEGREE)[:, None] * angle) * (2 / _DEGREE)
    series[0] /= 2
    return np.asarray(np.log(_spread_quadrature(w, k)) @ series.T)


def _spread_quadrature(w: Floats, k: int) -> Floats:
    """W of any w by quadrature over the largest value."""
    z = w[..., None] / 2 + _REACH * _Z  # the largest of values that spread by a large w is about w / 2
    largest = special.ndtr(z)
    density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi) * _REACH * _Z_WEIGHT
    left_out = special.ndtr(z - w[..., None])
    inside = np.maximum(largest - left_out, 0.0)
    # a^m - b^m = (a - b) (a^(m-1) + ... + b^(m-1)) with a - b = left_out: nothing cancels
    total, power_of_largest = np.zeros_like(left_out), np.ones_like(largest)
    for _ in range(k - 1):
        total = total * inside + power_of_largest
        power_of_largest = power_of_largest * largest
    return np.asarray(k * np.sum(density * left_out * total, axis=-1))
