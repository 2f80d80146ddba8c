"""Trials of different length: rows cut from one long array by offsets, and their padding."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Ints

Number = TypeVar("Number", np.float64, np.int64)


def row_of_each(offsets: Ints) -> Ints:
    """Row number of every element (N,) for ``offsets`` (k + 1,), which start at 0 and end at N."""
    return np.repeat(np.arange(offsets.size - 1), np.diff(offsets))


def pad_rows(values: NDArray[Number], offsets: Ints, filler: float = np.nan) -> NDArray[Number]:
    """Rows ``values[offsets[i]:offsets[i + 1]]`` as (k, longest), ``filler`` beyond the end of each."""
    lengths = np.diff(offsets)
    inside = np.arange(np.max(lengths, initial=0)) < lengths[:, None]
    padded = np.full(inside.shape, filler, dtype=values.dtype)
    padded[inside] = values
    return padded
