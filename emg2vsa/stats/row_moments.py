"""Mean and spread of single samples: rows of a table, each on its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import DataError
from emg2vsa.stats.group_moments import group_moments


@dataclass(frozen=True)
class RowMoments:
    """k samples of up to n values. count, mean (unit of the data) : (k,), mean NaN where there is no value.

    deviation (k, n) from the mean, 0 where there is no value, and squares (k,), the sum of their squares, are in a unit
    of the sample's own, 2^unit of the data, unit : (k,). valid : (k, n).
    """

    count: Ints
    mean: Floats
    deviation: Floats
    squares: Floats
    valid: NDArray[np.bool_]
    unit: NDArray[np.int32]


def row_moments(values: ArrayLike) -> RowMoments:
    """Moments of the rows of ``values`` (k, n), or of one row (n,); NaN: no value there. DataError for other shapes."""
    rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
    if rows.ndim != 2:
        do = "Give one sample a row, shorter ones padded with NaN."
        raise DataError("samples", wanted="numbers of shape (samples, values)", found=f"shape {rows.shape}", do=do)
    groups = group_moments(rows[:, None, :] if rows.shape[1] else np.full((len(rows), 1, 1), np.nan))
    return RowMoments(
        count=groups.count[:, 0],
        mean=groups.mean[:, 0],
        deviation=groups.deviation[:, 0],
        squares=groups.squares[:, 0],
        valid=groups.valid[:, 0],
        unit=groups.unit,
    )
