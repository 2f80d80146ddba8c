"""Scores by mounting: the one form in which specimens, angles and conditions are compared.

Presses of one mounting share its errors, so a press is no replicate of a specimen: the mounting is. Of each cell (a
design and a specimen) the mean of ln score of every mounting counts once. An estimate is a weighted sum of cells'
means; its error comes from the scatter between mountings, pooled over all cells of the designs involved, and is never
below that which the cells of the sum show themselves. The pooled degrees of freedom count unless a cell of the sum
scatters more than the rest of the pool (F test at 1 %, corrected for the cells), or cells differ in their number of
mountings, or a mounting has less than half the presses of another: then those of Welch and Satterthwaite count, or
those that cells of equal scatter would have if these are fewer. With three mountings and one cell that scatters six
times as much as the others, intervals of 95 % then miss in 9 % (13 % by the larger variance alone, 20 % by the pooled
one), those of 99.7 % in 3 % (tests/discrimination/test_mountings.py).

Where no cell of the pool was mounted twice, presses tell their own scatter, and the SD between mountings is assumed.

Drift (``emg2vsa.statistics.drift``) is taken out where the order of mountings tells it, with its error. Where it tells
nothing or little ("same"), drift may be as large as the trend of presses within mountings allows, over as many places
as the cells lie apart; where nobody knows the order, over the whole experiment.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.statistics.drift import Drift, Slope, drift

Cell = tuple[int, int]
"Design and specimen."
_ROUNDING = 1e-24
_DIGITS = 9
_LEAST_DF = 3
"Degrees of freedom from which on the order of mountings tells drift."
_UNEQUAL = 0.01
"Level of the test by which a cell scatters more than the others."


@dataclass(frozen=True)
class CellSum:
    """A weighted sum of cells' means of ln score; NaN where a cell has no press, or nothing tells its error.

    error : standard error, of ``df`` degrees of freedom. known_sd : SD that was assumed of what mountings add.
    drift : what may be drift, in either direction; None for nothing.
    """

    estimate: float
    error: float
    df: float
    known_sd: float = 0.0
    drift: Slope | None = None

    def ends(self, confidence: float) -> tuple[float, float]:
        """Low and high; NaN without an error. Scatter and drift share what is left of the confidence (Bonferroni)."""
        if not (self.error > 0 or self.known_sd > 0):
            return np.nan, np.nan
        confidence = 0.5 + 0.5 * confidence if self.drift else confidence
        quantile = 0.5 + 0.5 * confidence
        reach = np.hypot(special.stdtrit(self.df, quantile) * self.error, special.ndtri(quantile) * self.known_sd)
        reach += self.drift.most(confidence) if self.drift else 0.0
        return float(self.estimate - reach), float(self.estimate + reach)

    @property
    def p(self) -> float:
        """p of no difference; NaN where part of the error was assumed, or may be drift."""
        if self.known_sd or self.drift or not self.error > 0:
            return np.nan
        return 2 * float(special.stdtr(self.df, -abs(self.estimate) / self.error))


UNKNOWN = CellSum(np.nan, np.nan, np.nan)


@dataclass(frozen=True, eq=False)
class Ratios:
    """(q,) ratios and their intervals."""

    estimate: Floats
    low: Floats
    high: Floats


def ratios(of: Sequence[CellSum], confidence: float) -> Ratios:
    """What differences of mean ln score are as ratios."""
    return Ratios(*np.exp(columns([(each.estimate, *each.ends(confidence)) for each in of])))


def columns(rows: Sequence[Sequence[float]], count: int = 3) -> Floats:
    """(count, q) of q rows."""
    return np.array(rows, dtype=np.float64).reshape(-1, count).T


@dataclass(frozen=True, eq=False)
class Mountings:
    """D designs of S specimens, mounted up to M times and pressed up to R times.

    logs : (D, S, R) ln scores. mounting : (D, S, R) its number, from 1. place : (D, S, R) in which all mountings were
    pressed, None where nobody knows. assumed_sd : of ln score from mounting to mounting, where mounted once.
    """

    logs: Floats
    mounting: Ints
    place: Floats | None
    assumed_sd: float

    @classmethod
    def of(cls, scores: Floats, mounting: Ints, assumed_sd: float, place: Floats | None = None) -> Mountings:
        """Mountings from scores and numbers of mountings (from 1; 0: no press), both (D, S, R).

        Scores that are not above 0 have no logarithm and are left out. ValueError where shapes differ, or where a
        score has no mounting.
        """
        shapes = {scores.shape, mounting.shape, scores.shape if place is None else place.shape}
        if scores.ndim != 3 or len(shapes) > 1:
            raise ValueError(f"scores (D, S, R), their mountings and places, got shapes {', '.join(map(str, shapes))}")
        if np.any(np.isfinite(scores) & (mounting < 1)):
            raise ValueError("a number of its mounting, from 1, for every press with a score, got a score without one")
        with np.errstate(invalid="ignore", divide="ignore"):
            return cls(np.log(np.where(scores > 0, scores, np.nan)), mounting, place, assumed_sd)

    @classmethod
    def of_table(cls, table: RunTable, scores: Floats, assumed_sd: float) -> Mountings:
        """``scores`` (D, S, R) of the runs in ``table``."""
        return cls.of(scores, table.mounting, assumed_sd, table.position)

    def _each(self, values: Floats) -> Floats:
        """(D, S, M, R), NaN where a press is of another mounting."""
        numbers = np.arange(1, int(self.mounting.max(initial=1)) + 1)
        return np.where(self.mounting[:, :, None] == numbers[:, None], values[:, :, None], np.nan)

    @cached_property
    def _by_mounting(self) -> Floats:
        return self._each(self.logs)

    @cached_property
    def own(self) -> Floats:
        """(D, S, M) mean of each mounting; NaN without a press."""
        return mean_of(self._by_mounting)

    @cached_property
    def presses(self) -> Ints:
        """(D, S, M) with a score."""
        return np.asarray(np.isfinite(self._by_mounting).sum(axis=3))

    @cached_property
    def squares(self) -> Floats:
        """(D, S) of presses about the mean of their mounting."""
        return _without_rounding(np.nansum((self._by_mounting - self.own[..., None]) ** 2, axis=(2, 3)))

    @cached_property
    def mean(self) -> Floats:
        """(D, S) of the means of mountings."""
        return mean_of(self.own)

    @cached_property
    def count(self) -> Ints:
        """(D, S) mountings with a score."""
        return np.asarray(np.isfinite(self.own).sum(axis=2))

    @cached_property
    def scatter(self) -> Floats:
        """(D, S) squares of the means of mountings about that of their cell."""
        return _without_rounding(np.nansum((self.own - self.mean[..., None]) ** 2, axis=2))

    @cached_property
    def drift(self) -> Drift:
        """Drift of ln score by place: told by mountings of the same cell; where there are none, by designs and
        specimens.

        Mountings of the same number are a round, and only places within rounds tell: drift may start anew in each, and
        rounds in the same order tell nothing of it.
        """
        there = np.isfinite(self._by_mounting)
        design, specimen, number, _ = np.nonzero(there)
        repetition = np.cumsum(there, axis=3)[there].astype(np.float64)
        cell = np.char.mod("%d", design * self.logs.shape[1] + specimen)
        place = np.full(cell.shape, np.nan) if self.place is None else self._each(self.place)[there]
        logs, several = self._by_mounting[there], bool((self.count > 1).any())
        block, group = (np.zeros_like(cell), cell) if several else (np.char.mod("%d", design), specimen.astype(np.str_))
        found = drift(block, group, place, repetition, logs, cell)
        if several and found.order == "differs":
            place, logs = (each - (np.bincount(number, each) / np.bincount(number))[number] for each in (place, logs))
            by = drift(block, group, place.round(_DIGITS), repetition, logs, cell)
            found = replace(found, order=by.order, by_order=by.by_order)
        told = found.order != "differs" or found.by_order.df >= _LEAST_DF
        return replace(found, order=found.order if told else "same", places=int(self.count.sum()))

    @cached_property
    def places(self) -> Floats:
        """(D, S) mean place of the mountings with a score; NaN where nobody knows."""
        place = np.full(self.logs.shape, np.nan) if self.place is None else self.place
        return mean_of(np.where(np.isfinite(self.own), mean_of(self._each(place)), np.nan))

    def sum(self, weights: Mapping[Cell, float], pool: Iterable[int] = ()) -> CellSum:
        """The weighted sum of cells' means. pool : designs that tell the scatter besides those of the cells."""
        at = tuple(np.array(list(weights)).T)
        weight = np.array(list(weights.values()))
        scattered = self._scattered(at, weight, pool)
        return scattered if np.isnan(scattered.estimate) else self._free_of_drift(scattered, at, weight)

    def _free_of_drift(self, of: CellSum, at: tuple[Ints, ...], weight: Floats) -> CellSum:
        by = self.drift
        if by.order == "unknown":
            return replace(of, drift=by.within.times(by.places - 1.0))
        apart = float(weight @ self.places[at])
        if by.order == "same":
            return replace(of, drift=by.within.times(apart)) if apart else of
        moved = by.by_order.times(apart)
        error = float(np.hypot(of.error, moved.error))
        df = error**4 / (of.error**4 / of.df + moved.error**4 / moved.df) if error > 0 else of.df
        return replace(of, estimate=of.estimate - moved.value, error=error, df=df)

    def _scattered(self, at: tuple[Ints, ...], weight: Floats, pool: Iterable[int]) -> CellSum:
        """With the error of what was drawn at random, drift apart."""
        count, estimate = self.count, float(weight @ self.mean[at])
        if not np.isfinite(estimate):
            return UNKNOWN
        designs = np.zeros(count.shape, dtype=np.bool_)
        designs[[*at[0].tolist(), *pool]] = True
        several = designs & (count > 1)
        if not several.any():
            presses = self.presses.sum(axis=2)
            known = self.assumed_sd * float(np.sqrt(np.sum(weight**2 / count[at])))
            return CellSum(estimate, *_error(self.squares, presses - count, presses, weight, at, designs), known)
        if not several[at].all():  # a cell that was mounted once scatters as the others do
            df = float(np.sum(count[several] - 1))
            error = np.sqrt(self.scatter[several].sum() / df * np.sum(weight**2 / count[at]))
            return CellSum(estimate, float(error), df)
        most, least = self.presses.max(axis=2), np.where(self.presses > 0, self.presses, np.inf).min(axis=2)
        even = (2 * least >= most[at].max()) & (2 * least[at].min() >= most)
        alike = even[at].all() and np.ptp(count[at]) == 0
        return CellSum(estimate, *_error(self.scatter, count - 1, count, weight, at, several & even if alike else None))

    def press_sd(self, designs: Iterable[int]) -> tuple[float, float]:
        """SD of a press within its mounting, pooled over the cells of ``designs``, and its degrees of freedom."""
        rows = list(designs)
        df = float(np.sum(self.presses[rows] - np.isfinite(self.own[rows])))
        return (float(np.sqrt(self.squares[rows].sum() / df)) if df else np.nan), df


def _without_rounding(squares: Floats) -> Floats:
    """0 where logarithms differ by no more than their last digits."""
    return np.where(squares < _ROUNDING, 0.0, squares)


def checked(given: Mountings) -> Mountings:
    """TypeError for presses without their mountings."""
    if not isinstance(given, Mountings):
        raise TypeError(
            f"expected Mountings (Mountings.of(scores, mounting, assumed_sd)), got {type(given).__name__}: presses of "
            "one mounting are no replicates of a specimen, so specimens, angles and conditions are compared by mounting"
        )
    return given


def _error(
    squares: Floats, df: Ints, units: Ints, weight: Floats, at: tuple[Ints, ...], pool: NDArray[np.bool_] | None
) -> tuple[float, float]:
    """Standard error of the sum, and its degrees of freedom; NaN where a cell has no scatter.

    squares, df, units : (D, S) of what is drawn at random, about the mean of its cell. pool : (D, S) cells of equal
    scatter; None where those of the sum have none.
    """
    if not (df[at] > 0).all():
        return np.nan, np.nan
    of_cell, share = squares[at] / df[at], weight**2 / units[at]
    own, welch = float(share @ of_cell), _welch_df(share, of_cell, df[at])
    if pool is None:
        return float(np.sqrt(own)), welch
    total, total_df = float(squares[pool].sum()), float(df[pool].sum())
    rest_df = total_df - df[at]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = of_cell / ((total - squares[at]) / rest_df)
    limit = special.fdtri(df[at], np.maximum(rest_df, 1), 1 - _UNEQUAL / weight.size)
    unequal = bool(np.any((ratio > limit) & (rest_df > 0)))
    variance = max(total / total_df * float(share.sum()), own)
    return float(np.sqrt(variance)), welch if unequal else total_df


def _welch_df(share: Floats, of_cell: Floats, df: Ints) -> float:
    """Degrees of freedom of a sum of means with variances of their own, ``share`` times that of the cell.

    The estimated degrees of freedom (Welch 1947, Satterthwaite 1946) are too many where a cell of few mountings happens
    to scatter little: those of equal scatter bound them.
    """
    equal = float(share.sum() ** 2 / np.sum(share**2 / df))
    terms = share * of_cell
    return min(equal, float(terms.sum() ** 2 / np.sum(terms**2 / df))) if terms.any() else equal
