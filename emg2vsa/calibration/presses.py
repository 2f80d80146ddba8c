"""Scores of repeated presses: their mean, and presses drawn again; NaN where there is no press."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats


def mean_of(scores: Floats) -> Floats:
    """Mean along the last axis of the scores that are there; NaN where there is none."""
    there = np.isfinite(scores)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sum(scores, axis=-1, where=there) / np.count_nonzero(there, axis=-1))


def redrawn(scores: Floats, resamples: int, rng: np.random.Generator) -> Floats:
    """One press fewer than there are, drawn with replacement from each group: (d, B, ..., R) from scores (d, ..., R).

    Means of one fewer have the variance s^2 / n of the mean that is judged; means of as many have (n - 1) / n of it,
    and intervals from ten presses would cover 1.5 % less (Hesterberg 2015). A single press is drawn as it is. The draws
    are the same for all d, so that the answer for one does not depend on its company.
    """
    first = np.sort(scores, axis=-1)[:, None]  # NaN last
    count = np.count_nonzero(np.isfinite(first), axis=-1, keepdims=True)
    index = (rng.random((resamples, *scores.shape[1:])) * count).astype(np.int64)
    return np.where(
        np.arange(scores.shape[-1]) < np.maximum(count - 1, 1), np.take_along_axis(first, index, axis=-1), np.nan
    )
