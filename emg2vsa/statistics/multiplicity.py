"""Several tests at once: p corrected for a family of pairs."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats

Adjustment = Literal["bonferroni", "holm", "fdr_bh"]


def adjust(p: ArrayLike, method: Adjustment) -> Floats:
    """Adjusted p (f, m) of f families of m tests, or (m,) of one; NaN is no test: it stays NaN and does not count.

    bonferroni, holm (1979): family-wise error under any dependence. fdr_bh (1995): false discovery rate, independent or
    positively dependent tests.
    """
    values = np.asarray(p, dtype=np.float64)
    missing, m = np.isnan(values), values.shape[-1]
    if np.count_nonzero(missing):
        m = m - np.count_nonzero(missing, axis=-1, keepdims=True)
    if method == "bonferroni":
        return np.asarray(np.minimum(values * m, 1.0))
    order = np.argsort(values, axis=-1)  # NaN last
    ordered, rank = np.take_along_axis(values, order, axis=-1), np.arange(1, values.shape[-1] + 1)
    if method == "holm":
        stepped = np.fmax.accumulate(ordered * (m - rank + 1), axis=-1)
    else:
        stepped = np.fmin.accumulate((ordered * (m / rank))[..., ::-1], axis=-1)[..., ::-1]
    adjusted = np.empty_like(values)
    np.put_along_axis(adjusted, order, np.where(np.isnan(ordered), np.nan, np.minimum(stepped, 1.0)), axis=-1)
    return adjusted
