"""Jeffreys-Zellner-Siow Bayes factors of one-way designs, many at once; of two groups that is the t test's.

Effects, in SDs, have a Cauchy prior of scale r; mean and variance have Jeffreys' prior. Given the variance g r^2 of the
effects the Bayes factor is a formula, and g, inverse chi squared with 1 df, is integrated out numerically.
Rouder, Speckman, Sun, Morey and Iverson (2009); Rouder, Morey, Speckman and Province (2012).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.moments import GroupMoments, group_moments
from emg2vsa.statistics.outcome import Outcome

SCALE = 0.5
"""r, the usual medium one of fixed effects; of the difference of two groups it is sqrt(1/2)."""
# Trapezoid rule in log g. Below the range the prior is under e^-700, above it even effects of 1e16 SDs have decayed.
# The rule converges geometrically on an integrand as smooth as this one: at this step it is at rounding.
_STEP = 0.25
_LOG_G = np.arange(-7.3, 110.0, _STEP)
_LOG_PRIOR = np.log(_STEP) - np.log(2 * np.pi) / 2 - _LOG_G / 2 - np.exp(-_LOG_G) / 2
_CHUNK = 256
_NO_DIRECTION = 1e-9


@dataclass(frozen=True)
class BayesFactors:
    """log_bf01, n : (d,) natural log of how much likelier the data are without an effect, NaN where
    undefined, and values that entered.
    """

    log_bf01: Floats
    n: Ints

    @property
    def bf01(self) -> Floats:
        """(d,) how much likelier the data are without an effect."""
        return np.asarray(np.exp(self.log_bf01))

    def outcome(self, i: int = 0) -> Outcome:
        """Design ``i`` alone."""
        factor = float(self.bf01[i])
        notes: tuple[str, ...] = (f"Cauchy prior of scale r = {SCALE:.4g} on effects in SDs",)
        if np.isnan(factor):
            notes += ("undefined: too few values, or no spread",)
        method = "JZS Bayes factor, one-way fixed effects"
        return Outcome(method=method, n=int(self.n[i]), statistic_name="BF01", statistic=factor, notes=notes)


def jzs_anova(values: ArrayLike) -> BayesFactors:
    """One-way fixed effects of ``values`` (d, k groups, n), or of one design (k, n); NaN: no value there.

    NaN where fewer than two groups have values, none has two, or all values are equal; values equal within groups that
    differ give BF01 = 0. DataError for another shape.
    """
    groups = group_moments(values)
    total = np.sum(groups.counts, axis=1)
    along = _directions(groups, total)
    within = np.sum(groups.squares, axis=1)
    k = np.count_nonzero(groups.counts, axis=1)
    squares = np.where((k > 1) & (total > k), within + np.sum(along.squares, axis=1), np.nan)
    squares[squares == 0] = np.nan
    return BayesFactors(_log_bf01(within / squares, along.squares / squares[:, None], along, total - 1.0), total)


@dataclass(frozen=True)
class _Directions:
    """Principal directions of d designs (d, j): information on an effect along each, how many are alike, and the sum of
    squares along all these."""

    information: Floats
    times: Floats
    squares: Floats


def _directions(groups: GroupMoments, total: Ints) -> _Directions:
    """Effects sum to zero over the groups that have values: k' groups have k' - 1 directions.

    Directions among groups of equally many values are alike, with this number as their information, and stand at right
    angles to all others: so only sums over such groups are left to take apart, of which there are few.
    """
    sizes = np.unique(groups.counts[groups.counts > 0])
    member = (groups.counts[:, :, None] == sizes).astype(np.float64)
    alike = np.sum(member, axis=1)
    k, n = np.maximum(np.sum(alike, axis=1), 1.0)[:, None, None], np.maximum(total, 1)[:, None, None]
    grand = np.sum(groups.counts * groups.offset, axis=1)[:, None] / n[:, 0]
    deviation = np.where(groups.counts > 0, groups.offset - grand, 0.0)
    mean = _row_times(deviation, member) / np.maximum(alike, 1.0)
    among = sizes * _row_times((deviation - _times_column(member, mean)) ** 2, member)

    root, eye = np.sqrt(alike), np.eye(sizes.size)
    there, counted = np.where(alike > 0, 1.0, 0.0), sizes * root
    centre = there[:, :, None] * eye - root[:, :, None] * root[:, None, :] / k
    design = (sizes * there)[:, :, None] * eye - counted[:, :, None] * counted[:, None, :] / n
    information, axes = np.linalg.eigh(centre @ design @ centre)
    score = _row_times(_times_column(centre, counted * mean), axes)
    real = information > _NO_DIRECTION * np.max(information, axis=1, keepdims=True, initial=0.0)
    between = np.where(real, score**2 / np.where(real, information, 1.0), 0.0)
    return _Directions(
        np.concatenate((np.broadcast_to(sizes, alike.shape), np.where(real, information, 0.0)), axis=1),
        np.concatenate((np.maximum(alike - 1, 0.0), np.ones_like(alike)), axis=1),
        np.concatenate((among, between), axis=1),
    )


def _row_times(row: Floats, matrix: Floats) -> Floats:
    """One row (d, i) by one matrix (d, i, j) of each design; NumPy has it as ``vecmat`` since 2.2."""
    return (row[:, None, :] @ matrix)[:, 0]


def _times_column(matrix: Floats, column: Floats) -> Floats:
    """One matrix (d, i, j) by one column (d, j) of each design; ``matvec`` since NumPy 2.2."""
    return (matrix @ column[:, :, None])[:, :, 0]


def _log_bf01(unexplained: Floats, explained: Floats, along: _Directions, power: Floats) -> Floats:
    """Shares of the sum of squares left (d,) and along directions (d, j)."""
    answer = np.full(unexplained.shape, np.nan)
    answer[unexplained == 0] = -np.inf
    places = np.flatnonzero(unexplained > 0)
    for start in range(0, places.size, _CHUNK):
        at = places[start : start + _CHUNK]
        gain = SCALE * SCALE * along.information[at, None, :] * np.exp(_LOG_G)[:, None]
        taken = np.sum(explained[at, None, :] * gain / (1 + gain), axis=2)
        left = unexplained[at, None] + np.sum(explained[at, None, :] / (1 + gain), axis=2)
        # powers are large: neither next to 1 nor next to 0 may the logarithm lose digits
        log_left = np.where(taken < 0.5, np.log1p(-np.minimum(taken, 0.5)), np.log(left))
        log = (
            _LOG_PRIOR - np.sum(along.times[at, None, :] * np.log1p(gain), axis=2) / 2 - power[at, None] / 2 * log_left
        )
        most = np.max(log, axis=1)
        answer[at] = -most - np.log(np.sum(np.exp(log - most[:, None]), axis=1))
    return answer
