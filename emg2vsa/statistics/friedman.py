"""Friedman's test: k treatments on the same people, by ranks within each person; many designs in one call."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.kruskal import midranks
from emg2vsa.statistics.moments import shifted_doubles
from emg2vsa.statistics.outcome import Outcome


@dataclass(frozen=True)
class Friedman:
    """chi2 corrected for ties, p, Kendall's w, n people without a gap : (d,); df : k - 1."""

    chi2: Floats
    df: int
    p: Floats
    w: Floats
    n: Ints
    left_out: Ints

    def outcome(self, i: int = 0) -> Outcome:
        notes: tuple[str, ...] = (f"{self.left_out[i]} people with a gap left out",) if self.left_out[i] else ()
        if np.isnan(self.chi2[i]):
            notes += ("undefined: needs two people, two treatments, and ranks that differ",)
        return Outcome(
            method="Friedman, corrected for ties",
            n=int(self.n[i]),
            statistic_name="chi2",
            statistic=float(self.chi2[i]),
            df=(float(self.df),),
            p=float(self.p[i]),
            effect_name="Kendall's W",
            effect_size=float(self.w[i]),
            notes=notes,
        )


def friedman(values: ArrayLike) -> Friedman:
    """Friedman (1937) on ``values`` (d, n people, k treatments), or one (n, k); a person with a NaN is left out."""
    doubles, _ = shifted_doubles(values)
    k = doubles.shape[2]
    complete = np.all(np.isfinite(doubles), axis=2)
    ranks = midranks(np.where(complete[..., None], doubles, np.nan))
    n = np.count_nonzero(complete, axis=1)
    there = complete[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean_rank = np.sum(ranks, axis=1, where=there) / n[:, None]
        spread = np.sum((ranks - (k + 1) / 2) ** 2, axis=(1, 2), where=there)
        between = n**2 * np.sum((mean_rank - (k + 1) / 2) ** 2, axis=1)
        chi2 = np.where((n > 1) & (k > 1), (k - 1) * between / spread, np.nan)
        w = chi2 / (n * (k - 1)) if k > 1 else np.full(n.shape, np.nan)
    return Friedman(chi2, k - 1, special.chdtrc(max(k - 1, 1), chi2), w, n, complete.shape[1] - n)
