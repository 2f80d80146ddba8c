"""Analysis of variance of several crossed factors, any number of values a cell, cells without values too.

Every effect is tested over all others that do not contain it (sums of squares of type II, Yates 1934): a main effect
beside the other main effects, an interaction of two factors beside all main effects and the other interactions of two.
Where a cell has no values the model has fewer parameters, and so has every effect that needs the cell; the degrees of
freedom say so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, unmasked
from emg2vsa.errors import DataError
from emg2vsa.shown import shown
from emg2vsa.statistics.effect_size import omega2, share_interval
from emg2vsa.statistics.moments import finite_or_nan, group_moments

_DEPENDENT = 1e-9
"""Singular value, over the largest, below which a column of the model follows from the others."""


@dataclass(frozen=True, eq=False)
class Factorial:
    """One model; e effects, arrays (e,), NaN where an effect has no degree of freedom, or no error is left.

    effects : names, factors of an interaction joined by " × ". df, f, p : of each effect; error_df : within cells.
    eta2 : partial share of the squares (biased upwards). omega2 : of the population, not below 0; low, high : interval
    of that share by the noncentral F (Steiger 2004), lambda / (lambda + n).
    """

    effects: tuple[str, ...]
    df: Ints = field(metadata=shown("df"))
    f: Floats = field(metadata=shown("F", digits=4))
    p: Floats = field(metadata=shown("p"))
    eta2: Floats = field(metadata=shown("Partial η²"))
    omega2: Floats = field(metadata=shown("Partial ω²"))
    low: Floats
    high: Floats
    error_df: int


def factorial(values: ArrayLike, factors: Mapping[str, Sequence[object]], confidence: float = 0.95) -> Factorial:
    """Analyse n ``values`` (NaN is left out), each with a level of every one of the ``factors`` (n of them a factor).

    DataError unless there are one to four factors of n levels each, every one with two or more different levels, and
    fewer than 2000 combinations of levels.
    """
    y = finite_or_nan(np.asarray(unmasked(values), dtype=np.float64)).ravel()
    there = np.isfinite(y)
    codes, sizes = _codes(factors, there)
    cell, where = np.unique(np.ravel_multi_index(tuple(codes), tuple(sizes)), return_inverse=True)
    groups = group_moments(_by_cell(y[there], where, cell.size)[None])
    count, mean = groups.counts[0].astype(np.float64), groups.offset[0]
    levels = np.unravel_index(cell, tuple(sizes))
    coded = [_coding(level, size) for level, size in zip(levels, sizes, strict=True)]
    terms = [term for k in range(1, len(sizes) + 1) for term in combinations(range(len(sizes)), k)]
    columns = {term: _product([coded[factor] for factor in term]) for term in terms}
    squares, df = _type_2(terms, columns, mean, count)
    n, within = int(count.sum()), float(groups.squares.sum())
    error_df = n - cell.size
    defined = (df > 0) & (error_df > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        f = np.where(defined, squares / np.where(defined, df, 1) / (within / max(error_df, 1)), np.nan)
        eta2 = np.where(defined, squares / (squares + within), np.nan)
    low, high = share_interval(f, df, error_df, n, confidence)
    return Factorial(
        effects=tuple(" × ".join(list(factors)[factor] for factor in term) for term in terms),
        df=df,
        f=f,
        p=np.asarray(special.fdtrc(np.maximum(df, 1), max(error_df, 1), f), dtype=np.float64),
        eta2=eta2,
        omega2=omega2(f, df, n),
        low=low,
        high=high,
        error_df=error_df,
    )


def _type_2(
    terms: Sequence[tuple[int, ...]], columns: Mapping[tuple[int, ...], Floats], mean: Floats, count: Floats
) -> tuple[Floats, Ints]:
    """Sum of squares (t,) and degrees of freedom (t,) of each term beside all terms that do not contain it.

    columns : (c, k) contrasts of each term. mean, count : (c,) of the cells.
    """
    root = np.sqrt(count)[:, None]

    def explained(of: Sequence[tuple[int, ...]]) -> tuple[Floats, Floats]:
        """Directions (cells, rank) that the terms span, and the cell means along them."""
        model = root * np.concatenate([np.ones((mean.size, 1)), *(columns[term] for term in of)], axis=1)
        left, singular, _ = np.linalg.svd(model, full_matrices=False)
        basis = left[:, singular > _DEPENDENT * singular[0]]
        return basis, basis.T @ (root[:, 0] * mean)

    squares, df = np.empty(len(terms)), np.empty(len(terms), dtype=np.int64)
    for i, term in enumerate(terms):
        without = [other for other in terms if not set(term) <= set(other)]
        basis, along = explained(without)
        rest = root[:, 0] * mean - basis @ along
        wider, _ = explained([*without, term])
        squares[i] = np.sum((wider.T @ rest) ** 2)
        df[i] = wider.shape[1] - basis.shape[1]
    squares[df == 0] = 0.0
    return squares, df


def _codes(factors: Mapping[str, Sequence[object]], there: np.ndarray) -> tuple[list[Ints], list[int]]:
    """Number of the level (n,) of every value that is there, and how many levels, factor by factor."""
    if not 1 <= len(factors) <= 4:
        raise _refused("one to four factors", f"{len(factors)}")
    codes, sizes = [], []
    for name, levels in factors.items():
        if len(levels) != there.size:
            raise _refused(f"a level of {name} for each of {there.size} values", f"{len(levels)} levels")
        distinct, code = np.unique(np.asarray(levels).astype(np.str_)[there], return_inverse=True)
        if distinct.size < 2:
            raise _refused(f"two levels of {name} or more", f"{distinct.size}")
        codes.append(code.astype(np.int64))
        sizes.append(int(distinct.size))
    if np.prod(sizes) >= 2000:
        raise _refused("fewer than 2000 combinations of levels", str(int(np.prod(sizes))))
    return codes, sizes


def _refused(wanted: str, found: str) -> DataError:
    return DataError("factorial ANOVA", wanted=wanted, found=found, do="Choose other columns as factors.")


def _by_cell(y: Floats, where: Ints, cells: int) -> Floats:
    """Values (cells, r), NaN where a cell has fewer."""
    count = np.bincount(where, minlength=cells)
    order = np.argsort(where, kind="stable")
    place = np.arange(y.size) - np.repeat(np.cumsum(count) - count, count)
    table = np.full((cells, int(count.max())), np.nan)
    table[where[order], place] = y[order]
    return table


def _coding(level: Ints, size: int) -> Floats:
    """Columns (cells, size - 1) that sum to 0 over the levels."""
    return np.asarray((np.eye(size)[:, :-1] - np.eye(size)[:, -1:])[level])


def _product(parts: Sequence[Floats]) -> Floats:
    found = parts[0]
    for part in parts[1:]:
        found = (found[:, :, None] * part[:, None, :]).reshape(len(found), -1)
    return found
