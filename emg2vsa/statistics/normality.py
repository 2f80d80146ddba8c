"""One-sample Kolmogorov-Smirnov tests of normality, many samples at once, with the exact p of a finite sample.

Two tests go by that name. ``standardised``: the sample minus its mean over its SD against N(0, 1); because the
parameters come from the sample its p is far too large (at n = 10 the true size of a nominal .05 is 2e-5). ``raw``: the
sample itself against N(0, 1), the default of MATLAB's kstest; any all-positive sample has D >= .5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.statistics.ks_exact import ks_survival
from emg2vsa.statistics.moments import unmasked
from emg2vsa.statistics.outcome import Outcome

_NOTE = {
    True: "mean and SD estimated from the sample: p is too large (Lilliefors' table applies)",
    False: "against N(0, 1) in the unit of the data: tests location and scale as much as shape",
}


@dataclass(frozen=True)
class KsTests:
    """k tests; d, p : (k,), NaN where undefined; n : (k,) values that entered; which of the two it was."""

    d: Floats
    p: Floats
    n: Ints
    standardised: bool

    def outcome(self, i: int = 0) -> Outcome:
        notes: tuple[str, ...] = (_NOTE[self.standardised],)
        if np.isnan(self.d[i]):
            notes += ("undefined: " + ("all values are equal" if self.n[i] > 1 else f"{self.n[i]} values"),)
        return Outcome(
            method="Kolmogorov-Smirnov, " + ("standardised" if self.standardised else "raw N(0, 1)"),
            n=int(self.n[i]),
            statistic_name="D",
            statistic=float(self.d[i]),
            p=float(self.p[i]),
            notes=notes,
        )


def ks_normal(values: ArrayLike, *, standardise: bool) -> KsTests:
    """Test each row of ``values`` (k, n), or one row (n,); NaN marks a value that is not there.

    A constant row, or one with a single value, has no standardised test (NaN).
    """
    d, n = largest_gap(values, standardise=standardise)
    return KsTests(d, ks_survival(d, n), n, standardise)


def largest_gap(values: ArrayLike, *, standardise: bool) -> tuple[Floats, Ints]:
    """D (k,) of ``ks_normal`` alone, and the values (k,) that entered."""
    rows = np.atleast_2d(np.asarray(unmasked(values), dtype=np.float64))
    valid = np.isfinite(rows)
    n = valid.sum(axis=1)
    z = _standardised(rows, valid, n) if standardise else rows
    cdf = special.ndtr(np.sort(np.where(valid, z, np.inf), axis=1))
    rank = np.arange(rows.shape[1])
    count = np.maximum(n, 1)[:, None]
    gap = np.where(rank < n[:, None], np.maximum((rank + 1) / count - cdf, cdf - rank / count), 0.0)
    d = gap.max(axis=1, initial=0.0)
    d[(n == 0) | np.isnan(z).all(axis=1)] = np.nan
    return d, n


def _standardised(rows: Floats, valid: NDArray[np.bool_], n: Ints) -> Floats:
    """(x - mean) / SD, SD with n - 1; NaN in rows that have no spread. Shifted by a value of the row first."""
    filled = np.where(valid, rows, 0.0)
    exponent = exponent_of(filled) + 1
    scaled = np.ldexp(filled, -exponent)
    first = scaled[np.arange(len(rows)), np.argmax(valid, axis=1)] if rows.size else np.zeros(len(rows))
    shifted = scaled - first[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = shifted.sum(axis=1, where=valid) / n
        centred = shifted - mean[:, None]
        sd = np.sqrt(np.vecdot(valid, centred**2) / (n - 1))
        sd[~(valid & (shifted != 0)).any(axis=1)] = np.nan
        return np.asarray(centred / sd[:, None])
