"""Mid-ranks of many samples at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints


def midranks(values: ArrayLike) -> Floats:
    """Ranks 1, 2, ... along the last axis of ``values`` (..., n); ties share a mean rank, NaN stays NaN, uncounted."""
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape[-1] == 0:
        return rows.copy()
    order = np.argsort(rows, axis=-1)  # NaN last
    ordered = np.sort(rows, axis=-1)
    first, last = _runs(ordered)
    ranks = np.empty_like(rows)
    np.put_along_axis(ranks, order, np.where(np.isnan(ordered), np.nan, (first + last) / 2 + 1), axis=-1)
    return ranks


def _runs(ordered: Floats) -> tuple[Ints, Ints]:
    """First and last index of the run of equal values that each value of sorted rows (..., n) belongs to."""
    index = np.broadcast_to(np.arange(ordered.shape[-1]), ordered.shape)
    starts = np.ones(ordered.shape, dtype=np.bool_)
    np.not_equal(ordered[..., 1:], ordered[..., :-1], out=starts[..., 1:])
    ends = np.ones(ordered.shape, dtype=np.bool_)
    ends[..., :-1] = starts[..., 1:]
    first = np.maximum.accumulate(np.where(starts, index, 0), axis=-1)
    last = np.minimum.accumulate(np.where(ends, index, ordered.shape[-1])[..., ::-1], axis=-1)[..., ::-1]
    return first, last
