"""p-values of a family of tests, adjusted for its size; many families at once."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError

Adjustment = Literal["none", "bonferroni", "holm", "fdr_bh", "fdr_by"]
NAMES = {
    "none": "not corrected",
    "bonferroni": "Bonferroni",
    "holm": "Holm",
    "fdr_bh": "false discovery rate, Benjamini-Hochberg",
    "fdr_by": "false discovery rate, Benjamini-Yekutieli",
}


def adjust(p: ArrayLike, method: Adjustment) -> Floats:
    """Adjusted p (f, m) of f families of m tests, or (m,) of one; NaN is no test: it stays NaN and does not count.

    bonferroni, holm (1979): family-wise error under any dependence. fdr_bh (1995): false discovery rate, independent or
    positively dependent tests; fdr_by (2001): under any dependence. SettingError for another name.
    """
    if method not in get_args(Adjustment):
        raise SettingError(
            "adjustment of p", wanted=", ".join(get_args(Adjustment)), found=repr(method), do="Use one of these names."
        )
    values = np.asarray(p, dtype=np.float64)
    if method == "none":
        return values.copy()
    families = np.atleast_2d(values)
    m = np.count_nonzero(~np.isnan(families), axis=1)[:, None]
    if method == "bonferroni":
        return np.asarray(np.minimum(families * m, 1.0).reshape(values.shape))
    order = np.argsort(families, axis=1)  # NaN last
    rank = np.arange(1, families.shape[1] + 1)
    ordered = np.take_along_axis(families, order, axis=1)
    adjusted = np.empty_like(families)
    np.put_along_axis(adjusted, order, _stepwise(ordered, m, rank, method), axis=1)
    return np.minimum(adjusted, 1.0).reshape(values.shape)


def _stepwise(ordered: Floats, m: np.ndarray, rank: np.ndarray, method: Adjustment) -> Floats:
    """``ordered`` p (f, m), ascending with NaN last: the running maximum (Holm) or minimum from above (FDR)."""
    if method == "holm":
        scaled = ordered * (m - rank + 1)
        return np.where(np.isnan(ordered), np.nan, np.fmax.accumulate(scaled, axis=1))
    harmonic = np.concatenate([[0.0], np.cumsum(1 / rank)])[m] if method == "fdr_by" else 1.0
    scaled = ordered * (m * harmonic / rank)
    lowest = np.fmin.accumulate(scaled[:, ::-1], axis=1)[:, ::-1]
    return np.where(np.isnan(ordered), np.nan, lowest)
